// Time: slider, playing, stepping, events, keys.
let now = begin, playing = false, drawnAt = 0;

const show = () => {
  if (!frames) return;
  const where = between(now);
  pose(where);
  push(where);
  nameParts();
  readOut(where);
  drawCursor(now);
  $("time").value = now;
  $("time").setAttribute("aria-valuetext", milliseconds(now));
  $("clock").textContent = milliseconds(now);
};
const go = (t) => {
  now = Math.min(Math.max(t, begin), end);
  show();
  remember();
};

const speeds = [1, 2, 5, 10, 20, 50, 100, 200, 500, 1000];
for (const slower of speeds) $("speed").add(new Option(slower === 1 ? "1 (real time)" : `1/${slower}`, 1 / slower));
$("speed").value = 1 / 10;
// The first time the page plays by itself, and stops where what it shows ends.
let once = false;

const tick = (at) => {
  if (!playing) return;
  // a page in the background wakes up late: never jump by more than a tenth of a second
  const passed = Math.min((at - drawnAt) / 1e3, 0.1) * +$("speed").value;
  drawnAt = at;
  // what is looped, and where playing ends, is the time shown in the curves
  const inside = now >= shownTime[0] && now <= shownTime[1];
  const [from, to] = inside ? [Math.max(shownTime[0], begin), Math.min(shownTime[1], end)] : [begin, end];
  let next = now + passed;
  if (next > to) {
    if ($("loop").checked && !once) next = from;
    else {
      next = to;
      play(false);
    }
  }
  go(next);
  requestAnimationFrame(tick);
};
const play = (on) => {
  if (on === playing) return;
  playing = on;
  $("play").textContent = on ? "Pause" : "Play";
  $("play").setAttribute("aria-label", on ? "Pause" : "Play");
  if (!on) {
    once = false;
    return;
  }
  if (now >= Math.min(shownTime[1], end) - 1e-9) now = Math.max(shownTime[0], begin);
  drawnAt = performance.now();
  requestAnimationFrame(tick);
};
const step = (count) => {
  play(false);
  const i = frameAt(now + 1e-9);
  go(time[Math.min(Math.max(i + count, 0), frames - 1)] ?? begin);
};
const nextEvent = (direction) => {
  const times = data.events.map(([, t]) => t).sort((a, b) => a - b);
  const found = direction > 0 ? times.find((t) => t > now + 1e-6) : times.findLast((t) => t < now - 1e-6);
  if (found !== undefined) {
    visit(found);
  }
};

const slider = $("time");
slider.addEventListener("input", () => {
  play(false);
  go(+slider.value);
});
$("play").addEventListener("click", () => play(!playing));
$("back").addEventListener("click", () => step(-1));
$("on").addEventListener("click", () => step(1));
$("first").addEventListener("click", () => go(begin));
$("arrows").addEventListener("change", show);
// Goes to an instant, and takes the curves along where they do not show it.
const visit = (t) => {
  play(false);
  if (t < shownTime[0] || t > shownTime[1]) {
    const half = (shownTime[1] - shownTime[0]) / 2;
    showTime(t - half, t + half);
  }
  go(t);
};
// The first impact's events as buttons; of later impacts a few as well, many as a list.
const isLater = ([name]) => name.startsWith("impact ");
const later = data.events.filter(isLater);
const listed = later.length > 6;
for (const [name, t, action] of data.events.filter((event) => !(listed && isLater(event)))) {
  const button = document.createElement("button");
  button.type = "button";
  button.textContent = name;
  button.title = milliseconds(t);
  if (data.actions.length > 1) {
    const whose = document.createElement("span");
    whose.className = `swatch a${action}`;
    button.prepend(whose);
    button.title += `, ${data.actions[action].name}`;
    button.setAttribute("aria-label", `${name}, ${data.actions[action].name}`);
  }
  button.addEventListener("click", () => visit(t));
  // each action has its own row
  if (action > 0 && $("events").lastElementChild?.dataset.action !== String(action)) {
    const end = document.createElement("span");
    end.className = "end";
    $("events").append(end);
  }
  button.dataset.action = action;
  $("events").append(button);
}
if (listed) {
  const list = document.createElement("select");
  list.setAttribute("aria-label", "Go to a later impact");
  list.add(new Option("later impacts", ""));
  for (const [name, t] of later) list.add(new Option(`${name}: ${milliseconds(t)}`, t));
  list.addEventListener("change", () => list.value !== "" && visit(+list.value));
  $("events").append(list);
}

// Which stretch of time the curves show.
const showTime = (from, to) => {
  const least = 20e-6, all = end - begin;
  const span = Math.min(Math.max(to - from, least), all);
  const start = Math.min(Math.max(from, begin), end - span);
  shownTime = [start, start + span];
  // the slider spans what the curves show, and the time stays within it
  [slider.min, slider.max] = shownTime;
  if (now < shownTime[0] || now > shownTime[1]) go(Math.min(Math.max(now, shownTime[0]), shownTime[1]));
  for (const button of $("windows").children) {
    const [a, b] = button.window;
    button.setAttribute("aria-pressed", Math.abs(a - shownTime[0]) + Math.abs(b - shownTime[1]) < 1e-6);
  }
  drawCurves();
  drawCursor(now);
  slider.value = now;
  remember();
};
const windowNames = data.windows.length > 1 ? ["whole run", "around the impact"] : ["whole run"];
data.windows.forEach((window, index) => {
  const button = document.createElement("button");
  button.type = "button";
  button.textContent = windowNames[index];
  button.window = window;
  button.addEventListener("click", () => showTime(...window));
  $("windows").append(button);
});
const seek = (event) => {
  play(false);
  go(tOf(event.clientX - cursor.getBoundingClientRect().left));
};
// One finger or the mouse seeks, two fingers zoom the time.
const touching = new Map();
const placeOf = (event) => event.clientX - cursor.getBoundingClientRect().left;
cursor.addEventListener("pointerdown", (event) => {
  cursor.setPointerCapture(event.pointerId);
  touching.set(event.pointerId, tOf(placeOf(event)));
  if (touching.size === 1) seek(event);
});
cursor.addEventListener("pointermove", (event) => {
  if (!touching.has(event.pointerId)) return;
  const [other] = [...touching].filter(([id]) => id !== event.pointerId).map(([, t]) => t);
  if (other === undefined) return seek(event);
  const was = touching.get(event.pointerId), is = tOf(placeOf(event));
  const factor = Math.min(Math.max(Math.abs(was - other) / Math.max(Math.abs(is - other), 1e-7), 0.5), 2);
  showTime(other + (shownTime[0] - other) * factor, other + (shownTime[1] - other) * factor);
  touching.set(event.pointerId, tOf(placeOf(event)));
});
for (const over of ["pointerup", "pointercancel"]) cursor.addEventListener(over, (event) => touching.delete(event.pointerId));
cursor.addEventListener("wheel", (event) => {
  event.preventDefault();
  const t = tOf(event.clientX - cursor.getBoundingClientRect().left);
  const factor = Math.exp(event.deltaY * (event.deltaMode ? 0.05 : 0.0015));
  showTime(t + (shownTime[0] - t) * factor, t + (shownTime[1] - t) * factor);
}, { passive: false });
cursor.addEventListener("dblclick", () => showTime(begin, end));

document.addEventListener("keydown", (event) => {
  if (event.ctrlKey || event.altKey || event.metaKey || event.target.matches("select")) return;
  const many = event.shiftKey ? 10 : 1;
  const keys = {
    ArrowLeft: () => step(-many),
    ArrowRight: () => step(many),
    Home: () => go(begin),
    End: () => go(end),
    "[": () => nextEvent(-1),
    "]": () => nextEvent(1),
    "+": () => zoomMiddle(0.8),
    "-": () => zoomMiddle(1.25),
    0: wholeView,
    9: closeUp,
  };
  // a focused button or box takes the space bar itself
  if (!event.target.matches("button, input[type=checkbox]")) keys[" "] = () => play(!playing);
  const act = keys[event.key];
  if (!act) return;
  event.preventDefault();
  act();
});

const redraw = () => {
  arrange();
  halve();
  showTime(...shownTime);
  show();
};
addEventListener("resize", redraw);
dark.addEventListener("change", redraw);

// #t=0.123 opens the page at that time (s); shown=from,to at that stretch of the curves; view=whole, or
// left,top,width,height in millimetres of the picture, at that view; names=1 with the parts' names; beside=0 with two
// actions over each other; pins=0 without the forces of the pins.
const open = () => {
  const hash = new URLSearchParams(location.hash.slice(1));
  const numbers = (key, count) => {
    const found = (hash.get(key) ?? "").split(",").map(Number);
    return found.length === count && found.every(Number.isFinite) ? found : null;
  };
  if (sideBySide && hash.has("beside")) sideBySide.checked = hash.get("beside") === "1";
  if (pinForces && hash.has("pins")) pinForces.checked = hash.get("pins") === "1";
  const asked = numbers("view", 4);
  if (asked) look(asked);
  else wholeView();
  const stretch = numbers("shown", 2);
  if (stretch && stretch[1] > stretch[0]) showTime(...stretch);
  if (hash.has("names")) $("naming").checked = hash.get("names") === "1";
  const t = hash.has("t") ? +hash.get("t") || 0 : shownTime[0];
  if (t < shownTime[0] || t > shownTime[1]) showTime(...data.windows[0]);
  go(t);
};
redraw();
open();
// Who follows no link sees the touch first: the whole action, once, ten times slower than it is.
if (!location.hash && frames > 1 && !matchMedia("(prefers-reduced-motion: reduce)").matches) {
  play(true);
  once = true;
}
addEventListener("hashchange", open);
$("what").textContent = `${data.actions.length > 1 ? "Two simulated runs" : "A simulated run"} of ${milliseconds(end - begin)}, ${frames} frames${
  frames < data.rows ? ` of ${data.rows} rows` : ""}.`;
