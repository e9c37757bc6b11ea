// The action: turning the outlines, drawing the forces, moving the view.
const picture = $("action");
const SVG = "http://www.w3.org/2000/svg";

// What moves: an element turns with its body, or follows a point of it without turning (`data-point`, from
// `data-drawn`), a guided one up and down only. `placed` is where its frame is now.
data.actions.forEach((action, index) => {
  action.group = picture.querySelector(`[data-action="${index}"]`);
  action.pieces = [...action.group.querySelectorAll(".parts > path")];
  action.layers = { forces: element("g", {}, $("forces")), numbers: element("g", {}, $("numbers")) };
  action.moving = movingIn(action.group);
  action.outlines = outlinesIn(action.group, action.moving);
  action.dents = new Map();
});

// Where a zone is pressed, for the felt that is dented there: the place of the nearer of two frames.
const pressedAt = (zone, where) => {
  const first = where.share < 0.5 ? where.i : where.j, frame = zone.at[first] >= 0 ? first : where.i + where.j - first;
  const entry = zone.at[frame];
  if (zone.unseen || entry < 0) return null;
  const turn = zone.values[entry + 3];
  return { sides: zone, at: [zone.values[entry + 1], zone.values[entry + 2]], normal: [zone.sign * Math.cos(turn), zone.sign * Math.sin(turn)] };
};

// A modal string swings across the straight one, exaggerated as its label says.
for (const action of data.actions) {
  const { string, group } = action;
  if (!string) continue;
  string.line = element("polyline", { class: "swinging" }, group);
  const label = element("text", { class: "newton swinging", x: string.x[0].toFixed(2), y: (-string.y - 13).toFixed(2) }, group);
  label.textContent = string.times === 1 ? "middle string" : `middle string, swing × ${string.times}`;
}
const swing = ({ x, y, shape, times, line }, { i, j, share }) => {
  const count = x.length;
  const points = x.map((at, k) => {
    const from = shape[i * count + k], to = shape[j * count + k];
    return `${at.toFixed(2)},${(-y - times * (from + share * (to - from))).toFixed(3)}`;
  });
  line.setAttribute("points", points.join(" "));
};

const pose = (where) => {
  for (const action of data.actions) {
    action.placed = placeBodies(action.bodies, (body) => mix(action.bodies[body].angle, where));
    move(action.moving, action.placed, action.string?.pedal ? mix(action.string.pedal, where) : 0);
    if (!action.group.hasAttribute("hidden")) dent(action.outlines, action.zones.map((zone) => pressedAt(zone, where)), action.dents);
    if (action.string) swing(action.string, where);
  }
};

// Arrows and their numbers are made once and reused: the finger's and one per zone, and whatever else a later kind of
// force brings (its class is its kind, and `at` says where it acts, which way and how much, or nothing).
const arrows = [];
const arrow = (action, kind, at) => {
  const { forces, numbers } = data.actions[action].layers, tint = data.actions.length > 1 ? ` a${action}` : "";
  const path = element("path", { class: `arrow ${kind}${tint}` }, forces);
  const text = element("text", { class: `newton ${kind}${tint}`, "text-anchor": "middle" }, numbers);
  arrows.push({ action: data.actions[action], path, text, at });
};
data.actions.forEach((action, index) => {
  if (action.press) {
    arrow(index, "touch", (where) => {
      const [x, y] = carry(action.placed[action.press.body], action.press.point);
      return { x, y, ux: 0, uy: 1, force: mix(action.force, where) };
    });
  }
  action.zones.forEach((zone) => {
    if (zone.unseen) return;
    arrow(index, "contact", (where) => {
      // at the edge of a contact only one of the two frames knows the place
      const entry = zone.at[where.i] >= 0 ? zone.at[where.i] : zone.at[where.j];
      if (entry < 0) return null;
      const next = zone.at[where.i] >= 0 && zone.at[where.j] >= 0 ? zone.at[where.j] : entry;
      const at = (k) => zone.values[entry + k] + where.share * (zone.values[next + k] - zone.values[entry + k]);
      const turn = zone.values[entry + 3];
      return { x: at(1), y: at(2), ux: Math.cos(turn), uy: -Math.sin(turn), force: mix(zone.force, where) };
    });
  });
});

// What a pin does to the body that turns about it.
const pinForces = $("pin-forces");
data.actions.forEach((action, index) => {
  for (const { body, x, y } of action.pins) {
    arrow(index, "pin", (where) => {
      const along = mix(x, where), up = mix(y, where), force = Math.hypot(along, up);
      if (!pinForces.checked || !(force > 0)) return null;
      const on = action.placed[body];
      return { x: on.x, y: on.y, ux: along / force, uy: -up / force, force };
    });
  }
});
pinForces?.addEventListener("change", () => show());

const push = (where) => {
  const law = data.arrow, on = $("arrows").checked;
  const shown = [];
  // Side by side, an action's numbers keep clear of its own arrows only.
  const together = isBeside() ? data.actions.map(() => ({ shafts: [], taken: [] })) : [{ shafts: [], taken: [] }];
  const of = (action) => together[Math.min(data.actions.indexOf(action), together.length - 1)];
  for (const { action, path, text, at } of arrows) {
    const force = on && !action.group.hasAttribute("hidden") ? at(where) : null;
    const visible = force !== null && force.force >= law.drawn;
    path.style.display = visible ? "" : "none";
    text.style.display = "none";
    if (!visible) continue;
    const { path: outline, shaft } = arrowOf(law, force);
    path.setAttribute("d", outline);
    of(action).shafts.push(shaft);
    shown.push({ action, text, force: force.force, shaft });
  }
  for (const { action, text, force, shaft } of shown) {
    const { shafts, taken } = of(action);
    if (force < law.labelled) continue;
    const label = newtons(force);
    const place = freePlace(shaft, 7.6 * label.length * pixel, 13 * pixel, shafts, taken, pixel);
    if (!place) continue;
    taken.push(place);
    text.style.display = "";
    text.textContent = label;
    text.setAttribute("x", ((place[0] + place[2]) / 2).toFixed(2));
    text.setAttribute("y", (place[3] - 2.6 * pixel).toFixed(2));
  }
};

// Which of two actions are seen.
data.actions.forEach((action, index) => {
  const box = $(`see-${index}`);
  if (!box) return;
  box.addEventListener("change", () => {
    action.group.toggleAttribute("hidden", !box.checked);
    show();
  });
});

// The view: [left, top, width, height] in millimetres of the picture. Two actions side by side are seen in the same
// view each, in halves of the picture: the second, with all that belongs to it, is moved aside or below, as the picture
// has room, and both are cut at its edges.
const box = (view) => [view[0], view[1], view[2] - view[0], view[3] - view[1]];
let view = box(data.views.whole);
const sideBySide = $("beside");
const isBeside = () => sideBySide !== null && sideBySide.checked;
const cut = element("rect", {}, element("clipPath", { id: "half" }, picture.querySelector("defs")));
const titles = sideBySide ? data.actions.map(({ name }, index) => {
  const title = element("text", { class: `whose newton a${index}` }, picture);
  title.textContent = name;
  return title;
}) : [];
let apart = [0, 0];
const halve = () => {
  const [left, top, wide, tall] = view, beside = isBeside(), frame = picture.getBoundingClientRect();
  const across = Math.min(frame.width / (2 * wide), frame.height / tall), down = Math.min(frame.width / wide, frame.height / (2 * tall));
  apart = !beside ? [0, 0] : across >= down ? [1.03 * wide, 0] : [0, 1.03 * tall];
  picture.setAttribute("viewBox", [left, top, wide + apart[0], tall + apart[1]].map((v) => v.toFixed(3)).join(" "));
  picture.classList.toggle("beside", beside);
  const edges = { x: left, y: top, width: wide, height: tall };
  for (const [name, value] of Object.entries(edges)) cut.setAttribute(name, value.toFixed(3));
  data.actions.forEach(({ group, layers }, index) => {
    for (const layer of [group, layers.forces, layers.numbers]) {
      if (index > 0) layer.setAttribute("transform", `translate(${apart[0].toFixed(3)} ${apart[1].toFixed(3)})`);
      if (beside) layer.setAttribute("clip-path", "url(#half)");
      else layer.removeAttribute("clip-path");
    }
  });
  // A clip-path that cuts at the first action's edges cuts its names, too.
  if (beside) $("names").setAttribute("clip-path", "url(#half)");
  else $("names").removeAttribute("clip-path");
  measure();
  titles.forEach((title, index) => {
    title.style.display = beside ? "" : "none";
    title.setAttribute("x", (left + index * apart[0] + 4 * pixel).toFixed(2));
    title.setAttribute("y", (top + index * apart[1] + 15 * pixel).toFixed(2));
  });
};
sideBySide?.addEventListener("change", () => look(view));
const look = (to) => {
  const widest = 3 * box(data.views.whole)[2];
  if (!(to[2] > 5 && to[2] < widest)) return;
  view = to;
  halve();
  measure();
  show();
  remember();
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
// Where the mouse or a finger is, in the view of the half that it is in, or was put down in.
const halfOf = ([x, y]) => (isBeside() && (apart[0] ? x > view[0] + 1.015 * view[2] : y > view[1] + 1.015 * view[3]) ? 1 : 0);
const inPicture = (event, half) => {
  const matrix = picture.getScreenCTM().inverse();
  const at = [matrix.a * event.clientX + matrix.e, matrix.d * event.clientY + matrix.f];
  half ??= halfOf(at);
  return [at[0] - half * apart[0], at[1] - half * apart[1], half];
};
picture.addEventListener("wheel", (event) => {
  event.preventDefault();
  zoom(Math.exp(event.deltaY * (event.deltaMode ? 0.05 : 0.0015)), ...inPicture(event).slice(0, 2));
}, { passive: false });
// One finger or the mouse moves the picture, two fingers zoom it: the points under them stay under them.
const fingers = new Map();
picture.addEventListener("pointerdown", (event) => {
  picture.setPointerCapture(event.pointerId);
  fingers.set(event.pointerId, inPicture(event));
  picture.classList.add("grabbed");
});
picture.addEventListener("pointermove", (event) => {
  const from = fingers.get(event.pointerId);
  if (!from) return;
  const to = inPicture(event, from[2]);
  const [other] = [...fingers].filter(([id]) => id !== event.pointerId).map(([, at]) => at);
  if (other) {
    const spread = (at) => Math.hypot(at[0] - other[0], at[1] - other[1]);
    zoom(Math.min(Math.max(spread(from) / Math.max(spread(to), 1e-3), 0.5), 2), ...other.slice(0, 2));
    fingers.set(event.pointerId, inPicture(event, from[2]));
  } else look([view[0] + from[0] - to[0], view[1] + from[1] - to[1], view[2], view[3]]);
});
for (const over of ["pointerup", "pointercancel"]) {
  picture.addEventListener(over, (event) => {
    fingers.delete(event.pointerId);
    if (!fingers.size) picture.classList.remove("grabbed");
  });
}
const wholeView = () => look(box(data.views.whole));
picture.addEventListener("dblclick", wholeView);
$("whole").addEventListener("click", wholeView);
$("zoom-in").addEventListener("click", () => zoomMiddle(0.8));
$("zoom-out").addEventListener("click", () => zoomMiddle(1.25));
$("close-up").hidden = data.views.close === null;
const closeUp = () => data.views.close && look(box(data.views.close));
$("close-up").addEventListener("click", closeUp);
