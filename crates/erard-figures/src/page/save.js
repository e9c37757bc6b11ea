// Saving: the picture and the curves as PNG, the tables as CSV.
const download = (name, blob) => {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(blob);
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
};
const csv = (rows) => {
  const cell = (value) => (/[",\n]/.test(value) ? `"${value.replaceAll('"', '""')}"` : value);
  return new Blob([rows.map((row) => row.map((value) => cell(String(value))).join(",")).join("\n") + "\n"], { type: "text/csv" });
};

$("save-summary").addEventListener("click", () => {
  const rows = [...$("summary").rows].map((row) => [...row.cells].map((cell) => cell.textContent));
  download("summary.csv", csv(rows));
});

$("save-curves").addEventListener("click", () => {
  const curves = data.panels.flatMap((panel) => panel.curves.map((curve) => ({ name: `${curve.label} (${panel.unit || "1"})`, y: curve.y })));
  const rows = [["time (ms)", ...curves.map(({ name }) => name)]];
  for (let i = 0; i < frames; i++) {
    if (time[i] < shownTime[0] || time[i] > shownTime[1]) continue;
    rows.push([(1e3 * time[i]).toFixed(4), ...curves.map(({ y }) => +y[i].toPrecision(6))]);
  }
  download("curves.csv", csv(rows));
});

// What the page's style does to the picture is written into the copy: an image has no page around it.
const STYLED = ["fill", "fill-opacity", "stroke", "stroke-width", "font-size", "font-family", "paint-order", "display", "visibility"];
$("save-png").addEventListener("click", async () => {
  const frame = picture.getBoundingClientRect(), scale = 2;
  const copy = picture.cloneNode(true);
  copy.setAttribute("xmlns", SVG);
  copy.setAttribute("width", scale * frame.width);
  copy.setAttribute("height", scale * frame.height);
  const originals = picture.querySelectorAll("*"), copies = copy.querySelectorAll("*");
  originals.forEach((original, index) => {
    const style = getComputedStyle(original);
    for (const name of STYLED) copies[index].style.setProperty(name, style.getPropertyValue(name));
  });
  const image = new Image();
  image.src = `data:image/svg+xml;charset=utf-8,${encodeURIComponent(new XMLSerializer().serializeToString(copy))}`;
  await image.decode();
  const plot = canvas.getBoundingClientRect();
  const wide = Math.round(scale * Math.max(frame.width, plot.width));
  const sheet = document.createElement("canvas");
  const top = 34 * scale;
  sheet.width = wide;
  sheet.height = Math.round(top + scale * (frame.height + plot.height + 12));
  const g = sheet.getContext("2d");
  g.fillStyle = colour("--page");
  g.fillRect(0, 0, sheet.width, sheet.height);
  g.fillStyle = colour("--ink");
  g.font = `${15 * scale}px system-ui, sans-serif`;
  g.fillText(`${document.title} - ${milliseconds(now)}`, 8 * scale, 23 * scale);
  g.fillStyle = colour("--paper");
  g.fillRect(0, top, scale * frame.width, scale * frame.height);
  g.drawImage(image, 0, top);
  for (const layer of [canvas, cursor]) g.drawImage(layer, 0, top + scale * (frame.height + 12), scale * plot.width, scale * plot.height);
  sheet.toBlob((blob) => download("action.png", blob), "image/png");
});

// A link to this page as it stands: the time, the stretch of time shown, the view, the names.
const permalink = () => {
  const round = (value, digits) => +value.toFixed(digits);
  const parts = [`t=${round(now, 7)}`, `shown=${shownTime.map((t) => round(t, 7))}`, `view=${view.map((v) => round(v, 2))}`];
  if ($("naming").checked) parts.push("names=1");
  if (sideBySide && !isBeside()) parts.push("beside=0");
  if (pinForces && !pinForces.checked) parts.push("pins=0");
  return `#${parts.join("&")}`;
};
let remembering = 0;
const remember = () => {
  clearTimeout(remembering);
  remembering = setTimeout(() => {
    if (!playing) history.replaceState(null, "", permalink());
  }, 250);
};
$("link").addEventListener("click", async () => {
  history.replaceState(null, "", permalink());
  try {
    await navigator.clipboard.writeText(location.href);
    $("said").textContent = "Link copied.";
  } catch {
    $("said").textContent = "The address bar holds the link.";
  }
  setTimeout(() => ($("said").textContent = ""), 4000);
});
