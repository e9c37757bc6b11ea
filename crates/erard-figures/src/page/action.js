// The action: turning the outlines, drawing the forces, moving the view.
const picture = $("action");
const carried = [...picture.querySelectorAll("[data-body]")].map((element) => [element, +element.dataset.body]);
const forces = $("forces");
const SVG = "http://www.w3.org/2000/svg";

const pose = (where) => {
  const placed = [];
  for (const body of data.bodies) {
    const angle = mix(body.angle, where);
    let [x, y] = body.pivot;
    if (body.parent !== null) {
      const on = placed[body.parent];
      [x, y] = [on.x + on.cos * x - on.sin * y, on.y + on.sin * x + on.cos * y];
    }
    placed.push({ x, y, angle, cos: Math.cos(angle), sin: Math.sin(angle) });
  }
  for (const [element, index] of carried) {
    const { x, y, angle } = placed[index];
    const degrees = (-angle * 180) / Math.PI;
    element.setAttribute("transform", `translate(${x.toFixed(3)} ${(-y).toFixed(3)}) rotate(${degrees.toFixed(4)})`);
  }
};

// Arrows and their numbers are made once per zone and reused.
const arrows = data.zones.map(() => {
  const path = document.createElementNS(SVG, "path");
  const text = document.createElementNS(SVG, "text");
  path.setAttribute("class", "arrow");
  text.setAttribute("class", "newton");
  forces.append(path, text);
  return { path, text };
});

const push = (where) => {
  const law = data.arrow;
  const taken = [];
  data.zones.forEach((zone, index) => {
    const { path, text } = arrows[index];
    const force = mix(zone.force, where);
    // at the edge of a contact only one of the two frames knows the place
    const entry = zone.at[where.i] >= 0 ? zone.at[where.i] : zone.at[where.j];
    const shown = force >= law.drawn && entry >= 0 && $("arrows").checked;
    path.style.display = shown ? "" : "none";
    text.style.display = shown && force >= law.labelled ? "" : "none";
    if (!shown) return;
    const next = zone.at[where.i] >= 0 && zone.at[where.j] >= 0 ? zone.at[where.j] : entry;
    const at = (k) => zone.values[entry + k] + where.share * (zone.values[next + k] - zone.values[entry + k]);
    const x = at(1), y = -at(2), turn = zone.values[entry + 3];
    const ux = Math.cos(turn), uy = -Math.sin(turn);
    const length = law.base + law.decade * Math.log10(1 + force / law.knee);
    const neck = length - 4, half = 1.9;
    const point = (along, across) => `${(x + ux * along - uy * across).toFixed(2)} ${(y + uy * along + ux * across).toFixed(2)}`;
    path.setAttribute("d", `M${point(0, 0)}L${point(neck, 0)}M${point(length, 0)}L${point(neck, half)}L${point(neck, -half)}Z`);
    text.textContent = newtons(force);
    const upright = Math.abs(ux) < 0.4;
    const tx = x + ux * (length + 6 * pixel) + (upright ? 0 : Math.sign(ux) * 2 * pixel);
    let ty = y + uy * (length + 8 * pixel) + 4.5 * pixel;
    // numbers of neighbouring arrows step aside along the picture's height
    const step = (uy <= 0 ? -14 : 14) * pixel;
    const meets = ([a, b]) => Math.abs(a - tx) < 46 * pixel && Math.abs(b - ty) < 13 * pixel;
    for (let tries = 0; tries < 6 && taken.some(meets); tries++) ty += step;
    taken.push([tx, ty]);
    text.setAttribute("x", tx.toFixed(2));
    text.setAttribute("y", ty.toFixed(2));
    text.setAttribute("text-anchor", upright ? "middle" : ux > 0 ? "start" : "end");
  });
};

// The view: [left, top, width, height] in millimetres of the picture.
const box = (view) => [view[0], view[1], view[2] - view[0], view[3] - view[1]];
let view = box(data.views.whole);
const look = (to) => {
  const widest = 3 * box(data.views.whole)[2];
  if (!(to[2] > 5 && to[2] < widest)) return;
  view = to;
  picture.setAttribute("viewBox", view.map((v) => v.toFixed(3)).join(" "));
  measure();
};
// Numbers at the arrows keep their size on the screen whatever the zoom: millimetres of the picture per pixel.
let pixel = 0.4;
const measure = () => {
  const matrix = picture.getScreenCTM();
  if (!matrix) return;
  pixel = 1 / matrix.a;
  picture.style.setProperty("--px", pixel);
};
const zoom = (factor, x, y) =>
  look([x + (view[0] - x) * factor, y + (view[1] - y) * factor, view[2] * factor, view[3] * factor]);
const zoomMiddle = (factor) => zoom(factor, view[0] + view[2] / 2, view[1] + view[3] / 2);
const inPicture = (event) => {
  const matrix = picture.getScreenCTM().inverse();
  return [matrix.a * event.clientX + matrix.e, matrix.d * event.clientY + matrix.f];
};
picture.addEventListener("wheel", (event) => {
  event.preventDefault();
  zoom(Math.exp(event.deltaY * (event.deltaMode ? 0.05 : 0.0015)), ...inPicture(event));
}, { passive: false });
picture.addEventListener("pointerdown", (event) => {
  const from = inPicture(event);
  picture.setPointerCapture(event.pointerId);
  picture.classList.add("grabbed");
  const move = (moved) => {
    const to = inPicture(moved);
    look([view[0] + from[0] - to[0], view[1] + from[1] - to[1], view[2], view[3]]);
  };
  const stop = () => {
    picture.classList.remove("grabbed");
    picture.removeEventListener("pointermove", move);
  };
  picture.addEventListener("pointermove", move);
  picture.addEventListener("pointerup", stop, { once: true });
  picture.addEventListener("pointercancel", stop, { once: true });
});
const wholeView = () => look(box(data.views.whole));
picture.addEventListener("dblclick", wholeView);
$("whole").addEventListener("click", wholeView);
$("zoom-in").addEventListener("click", () => zoomMiddle(0.8));
$("zoom-out").addEventListener("click", () => zoomMiddle(1.25));
$("close-up").hidden = data.views.close === null;
const closeUp = () => data.views.close && look(box(data.views.close));
$("close-up").addEventListener("click", closeUp);
