// The curves: panels on a canvas, a cursor on another above it.
const canvas = $("curves"), cursor = $("cursor");
const LEFT = 46, RIGHT = 18, TOP = 6, FOOT = 30, GAP = 20, LINE = 15;
let shownTime = [...data.windows[data.windows.length - 1]];
let layout = [], high = 0, wide = 0;

const colour = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();
// On a dark page curves are a third lighter, and black ones as the text.
const dark = matchMedia("(prefers-color-scheme: dark)");
const lighter = (hex) => `#${[1, 3, 5].map((k) => Math.round(parseInt(hex.slice(k, k + 2), 16) * 0.67 + 84).toString(16)).join("")}`;
const curveColour = (curve) =>
  curve.colour === "#000000" ? colour("--ink") : dark.matches ? lighter(curve.colour) : curve.colour;
const xOf = (t) => LEFT + ((t - shownTime[0]) / (shownTime[1] - shownTime[0])) * (wide - LEFT - RIGHT);
const tOf = (x) => shownTime[0] + ((x - LEFT) / (wide - LEFT - RIGHT)) * (shownTime[1] - shownTime[0]);

// Round numbers 1, 2, 5 times a power of ten.
const ticks = (low, top, most) => {
  const raw = (top - low) / most;
  if (!(raw > 0)) return [];
  const power = 10 ** Math.floor(Math.log10(raw));
  const step = [1, 2, 5, 10].map((round) => round * power).find((s) => s >= raw * 0.999999);
  const digits = Math.max(0, -Math.floor(Math.log10(step) + 1e-9));
  const out = [];
  for (let k = Math.ceil(low / step - 1e-9); k * step <= top + 1e-9 * (top - low); k++) out.push([k * step, (k * step).toFixed(digits)]);
  return out;
};

// First, lowest, highest and last sample of every column of pixels: spikes survive.
const thin = (y, each) => {
  const first = Math.max(frameAt(shownTime[0]), 0), last = Math.min(frameAt(shownTime[1]) + 1, frames - 1);
  let column = NaN, kept = [];
  const flush = () => {
    kept.sort((a, b) => a - b).forEach((i, n) => { if (!n || i !== kept[n - 1]) each(xOf(time[i]), y[i]); });
  };
  for (let i = first; i <= last; i++) {
    const now = Math.floor(xOf(time[i]));
    if (now !== column) {
      flush();
      column = now;
      kept = [i, i, i, i];
    }
    if (y[i] < y[kept[1]]) kept[1] = i;
    if (y[i] > y[kept[2]]) kept[2] = i;
    kept[3] = i;
    kept = [kept[0], kept[1], kept[2], i];
  }
  flush();
};

// Where a panel's title and the names of its curves stand: places across, and the line, from 0; as many lines as they
// need.
const HEADING = "12px system-ui, sans-serif";
const titleOf = (panel) => `${panel.quantity} (${panel.unit}${panel.lanes ? `, logarithmic, ${panel.lanes.map((v) => +v.toPrecision(2)).join(" to ")}` : ""})`;
const headingOf = (panel) => {
  if (panel.lanes) return { names: [], lines: 1 };
  const g = canvas.getContext("2d");
  g.font = HEADING;
  const begin = LEFT + g.measureText(titleOf(panel)).width + 14;
  let x = begin, line = 0;
  const names = panel.curves.map((curve) => {
    const long = 34 + g.measureText(curve.label).width;
    if (x > begin && x + long - 12 > wide - RIGHT) [x, line] = [LEFT, line + 1];
    const place = { curve, x, line };
    x += long;
    return place;
  });
  return { names, lines: line + 1 };
};

// The height of a lane's label, which stands above the lane and never over its curve; two lanes of one contact share
// it.
const LABEL = 13;
const labelsOf = (panel) => panel.curves.filter((curve) => !curve.joins).length;

const arrange = () => {
  wide = canvas.parentElement.clientWidth;
  const headings = data.panels.map(headingOf);
  const words = headings.reduce((sum, { lines }) => sum + LINE * (lines - 1), 0);
  let y = TOP;
  const least = (panel) => (panel.lanes ? LABEL * labelsOf(panel) + 17 * panel.curves.length : 88);
  // a tall window is filled
  const room = window.innerHeight - 130 - FOOT - TOP - GAP * data.panels.length - words;
  const stretch = Math.min(Math.max(room / data.panels.reduce((sum, panel) => sum + least(panel), 1), 1), 2.2);
  layout = data.panels.map((panel, index) => {
    const tall = stretch * least(panel), heading = headings[index], above = GAP + LINE * (heading.lines - 1);
    const place = { panel, heading, top: y + above - 6, tall };
    y += tall + above;
    return place;
  });
  high = y + FOOT;
  for (const sheet of [canvas, cursor]) {
    const scale = window.devicePixelRatio || 1;
    sheet.width = Math.round(wide * scale);
    sheet.height = Math.round(high * scale);
    sheet.style.height = `${high}px`;
    sheet.getContext("2d").setTransform(scale, 0, 0, scale, 0, 0);
  }
};

const range = (panel) => {
  let low = Infinity, top = -Infinity;
  for (const curve of panel.curves) for (const v of curve.y) { if (v < low) low = v; if (v > top) top = v; }
  if (!(top > low)) return [(low || 0) - 1, (low || 0) + 1];
  return [low - 0.06 * (top - low), top + 0.06 * (top - low)];
};
for (const panel of data.panels) panel.range ??= range(panel);

const rule = (g, style, x1, y1, x2, y2) => {
  g.strokeStyle = style;
  g.beginPath();
  g.moveTo(x1, y1);
  g.lineTo(x2, y2);
  g.stroke();
};

const drawTogether = (g, panel, top, tall) => {
  const [low, peak] = panel.range;
  const yOf = (v) => top + tall - ((v - low) / (peak - low)) * tall;
  g.textAlign = "right";
  for (const [tick, label] of ticks(low, peak, 4)) {
    rule(g, colour("--grid"), LEFT, yOf(tick), wide - RIGHT, yOf(tick));
    g.fillStyle = colour("--soft");
    g.fillText(label, LEFT - 5, yOf(tick) + 4);
  }
  g.save();
  g.beginPath();
  g.rect(LEFT, top, wide - LEFT - RIGHT, tall);
  g.clip();
  g.lineWidth = 1.5;
  for (const curve of panel.curves) {
    g.strokeStyle = curveColour(curve);
    g.setLineDash(curve.dash);
    g.beginPath();
    thin(curve.y, (x, v) => g.lineTo(x, yOf(v)));
    g.stroke();
  }
  g.restore();
};

const drawLanes = (g, panel, top, tall) => {
  const [floor, ceiling] = panel.lanes;
  const lane = (tall - LABEL * labelsOf(panel)) / panel.curves.length;
  let base = top;
  panel.curves.forEach((curve) => {
    base += lane + (curve.joins ? 0 : LABEL);
    const yOf = (v) => base - (v > floor ? Math.min(Math.log10(v / floor) / Math.log10(ceiling / floor), 1) * (lane - 3) : 0);
    g.save();
    g.beginPath();
    g.rect(LEFT, top, wide - LEFT - RIGHT, tall);
    g.clip();
    g.strokeStyle = g.fillStyle = curveColour(curve);
    g.beginPath();
    let last = LEFT, begun = false;
    thin(curve.y, (x, v) => {
      if (!begun) g.moveTo(x, base);
      begun = true;
      g.lineTo((last = x), yOf(v));
    });
    g.lineTo(last, base);
    g.globalAlpha = 0.35;
    g.fill();
    g.globalAlpha = 1;
    g.lineWidth = 1;
    g.stroke();
    g.restore();
    g.lineWidth = 0.7;
    rule(g, colour("--rule"), LEFT, base, wide - RIGHT, base);
    if (curve.joins) return;
    g.textAlign = "left";
    g.font = "10.5px system-ui, sans-serif";
    // the lines of events end beside it
    g.lineWidth = 3;
    g.strokeStyle = colour("--page");
    g.strokeText(curve.label, LEFT + 5, base - lane - 3);
    g.fillStyle = colour("--ink");
    g.fillText(curve.label, LEFT + 5, base - lane - 3);
  });
};

const drawCurves = () => {
  const g = canvas.getContext("2d");
  g.clearRect(0, 0, wide, high);
  g.font = "11px system-ui, sans-serif";
  const foot = high - FOOT;
  for (const { panel, heading, top, tall } of layout) {
    g.font = "11px system-ui, sans-serif";
    g.lineWidth = 0.7;
    for (const [tick] of ticks(1e3 * shownTime[0], 1e3 * shownTime[1], Math.max(2, Math.floor(wide / 80)))) {
      rule(g, colour("--grid"), xOf(tick / 1e3), top, xOf(tick / 1e3), top + tall);
    }
    g.setLineDash([3, 2.5]);
    for (const [, t] of data.events) {
      if (t >= shownTime[0] && t <= shownTime[1]) rule(g, colour("--soft"), xOf(t), top, xOf(t), top + tall);
    }
    g.setLineDash([]);
    (panel.lanes ? drawLanes : drawTogether)(g, panel, top, tall);
    g.lineWidth = 0.8;
    g.strokeStyle = colour("--rule");
    g.strokeRect(LEFT, top, wide - LEFT - RIGHT, tall);
    drawHeading(g, panel, heading, top - 5 - LINE * (heading.lines - 1));
  }
  g.font = "11px system-ui, sans-serif";
  g.fillStyle = colour("--soft");
  g.textAlign = "center";
  for (const [tick, label] of ticks(1e3 * shownTime[0], 1e3 * shownTime[1], Math.max(2, Math.floor(wide / 80)))) {
    g.fillText(label, xOf(tick / 1e3), foot + 12);
  }
  g.fillText("time (ms)", (LEFT + wide - RIGHT) / 2, foot + 26);
};

// The panel's quantity and unit, and which curve is which.
const drawHeading = (g, panel, { names }, y) => {
  g.font = HEADING;
  g.textAlign = "left";
  g.fillStyle = colour("--ink");
  g.fillText(titleOf(panel), LEFT, y);
  for (const { curve, x, line } of names) {
    const at = y + LINE * line;
    g.setLineDash(curve.dash);
    g.lineWidth = 2;
    rule(g, curveColour(curve), x, at - 4, x + 18, at - 4);
    g.setLineDash([]);
    g.fillStyle = colour("--soft");
    g.fillText(curve.label, x + 22, at, wide - RIGHT - x - 22);
  }
};

const drawCursor = (t) => {
  const g = cursor.getContext("2d");
  g.clearRect(0, 0, wide, high);
  if (t < shownTime[0] || t > shownTime[1]) return;
  const where = between(t);
  g.lineWidth = 1.4;
  rule(g, colour("--accent"), xOf(t), TOP, xOf(t), high - FOOT);
  for (const { panel, top, tall } of layout) {
    if (panel.lanes) continue;
    for (const curve of panel.curves) {
      const y = top + tall - ((mix(curve.y, where) - panel.range[0]) / (panel.range[1] - panel.range[0])) * tall;
      g.fillStyle = curveColour(curve);
      g.beginPath();
      g.arc(xOf(t), y, 3.2, 0, 7);
      g.fill();
    }
  }
};
