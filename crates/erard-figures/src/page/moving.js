// Moving a picture of the action: what a page of a run and a page that plays live share. Nothing here knows of a page.
// In the page of a run these lines stand among its others; where scripts are modules it is one.

/** A body's frame: where its pivot is, mm of the picture with y up, and how it is turned.
 * @typedef {{ x: number, y: number, cos: number, sin: number, angle: number }} Frame */
/** What a body is hinged on (null: the ground), and where, mm.
 * @typedef {{ parent: number | null, pivot: number[] }} Hinge */
/** An element that turns with its body, or follows a point of it without turning, a guided one up and down only, or is
 * lifted by the sustain pedal (`rail`); `frame` is where it is now.
 * @typedef {{ element: SVGElement, body: number, point?: number[], drawn?: number[], guided: boolean, rail: boolean, frame: Frame }} Moving */
/** How long arrows are, mm, for forces in N.
 * @typedef {{ base: number, decade: number, knee: number, drawn: number, labelled: number }} ArrowLaw */
/** A force: where it acts, mm with y up, which way its arrow points in the picture (y down), and how much, N.
 * @typedef {{ x: number, y: number, ux: number, uy: number, force: number }} Force */
/** A name of a part, its place in the picture, and what it is laid out with.
 * @typedef {{ text: string, anchor: number[], wide: number, row: number, x: number, y: number, from: number, placed: boolean }} Name */

/** @type {(name: string, attributes: Record<string, string | number>, into: Element) => SVGElement} */
export const element = (name, attributes, into) => {
  const made = document.createElementNS("http://www.w3.org/2000/svg", name);
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, String(value));
  into.append(made);
  return made;
};

/** @type {Frame} */
export const STILL = { x: 0, y: 0, cos: 1, sin: 0, angle: 0 };
/** A point of a frame in the picture. @type {(on: Frame, point: number[]) => number[]} */
export const carry = (on, [x, y]) => [on.x + on.cos * x - on.sin * y, on.y + on.sin * x + on.cos * y];

/** A point of the picture in a frame. @type {(on: Frame, at: number[]) => number[]} */
export const home = (on, [x, y]) => [on.cos * (x - on.x) + on.sin * (y - on.y), on.cos * (y - on.y) - on.sin * (x - on.x)];

/** The frames of all bodies, whose absolute angles `angle` tells. @type {(bodies: Hinge[], angle: (body: number) => number) => Frame[]} */
export const placeBodies = (bodies, angle) => {
  /** @type {Frame[]} */
  const placed = [];
  bodies.forEach((body, index) => {
    const turned = angle(index);
    const [x, y] = body.parent === null ? body.pivot : carry(placed[body.parent], body.pivot);
    placed.push({ x, y, angle: turned, cos: Math.cos(turned), sin: Math.sin(turned) });
  });
  return placed;
};

/** What moves in a group of shapes. @type {(group: Element) => Moving[]} */
export const movingIn = (group) => {
  const pair = (/** @type {string} */ text) => text.split(" ").map(Number);
  return [.../** @type {NodeListOf<SVGElement>} */ (group.querySelectorAll("[data-body], [data-rail]"))].map((element) => {
    const { body, point, drawn, guided, rail } = element.dataset;
    return {
      element, body: Number(body), point: point ? pair(point) : undefined, drawn: drawn ? pair(drawn) : undefined,
      guided: guided !== undefined, rail: rail !== undefined, frame: STILL,
    };
  });
};

/** Moves them to where the bodies are, and the pedal's rail to its lift, mm. @type {(all: Moving[], placed: Frame[], lift?: number) => void} */
export const move = (all, placed, lift = 0) => {
  for (const moving of all) {
    const on = moving.rail ? { ...STILL, y: lift } : placed[moving.body];
    let frame = on;
    if (moving.point && moving.drawn) {
      const [x, y] = carry(on, moving.point);
      frame = { ...STILL, x: moving.guided ? 0 : x - moving.drawn[0], y: y - moving.drawn[1] };
    }
    moving.frame = frame;
    const degrees = (-frame.angle * 180) / Math.PI;
    moving.element.setAttribute("transform", `translate(${frame.x.toFixed(3)} ${(-frame.y).toFixed(3)}) rotate(${degrees.toFixed(4)})`);
  }
};

/** @type {(f: number) => string} */
export const newtons = (f) => `${f.toFixed(f >= 99.95 ? 0 : f >= 9.995 ? 1 : 2)} N`;

/** An arrow's outline, and the line along it. @type {(law: ArrowLaw, force: Force) => { path: string, shaft: number[][] }} */
export const arrowOf = (law, { x, y: up, ux, uy, force }) => {
  const y = -up;
  const length = law.base + law.decade * Math.log10(1 + force / law.knee);
  const neck = length - 4, half = 1.9;
  const point = (/** @type {number} */ along, /** @type {number} */ across) =>
    `${(x + ux * along - uy * across).toFixed(2)} ${(y + uy * along + ux * across).toFixed(2)}`;
  const path = `M${point(0, 0)}L${point(neck, 0)}M${point(length, 0)}L${point(neck, half)}L${point(neck, -half)}Z`;
  return { path, shaft: [[x, y], [x + ux * length, y + uy * length]] };
};

/** Whether a line, with some room, crosses a box [left, top, right, bottom]: Liang and Barsky's clipping.
 * @type {(line: number[][], box: number[], room: number) => boolean} */
export const crosses = ([from, to], box, room) => {
  let enter = 0, leave = 1;
  for (const axis of [0, 1]) {
    const low = box[axis] - room, high = box[axis + 2] + room, way = to[axis] - from[axis];
    if (Math.abs(way) < 1e-12) {
      if (from[axis] < low || from[axis] > high) return false;
      continue;
    }
    const a = (low - from[axis]) / way, b = (high - from[axis]) / way;
    enter = Math.max(enter, Math.min(a, b));
    leave = Math.min(leave, Math.max(a, b));
  }
  return enter <= leave;
};
/** @type {(a: number[], b: number[]) => boolean} */
export const overlap = (a, b) => a[0] < b[2] && b[0] < a[2] && a[1] < b[3] && b[1] < a[3];
const TURNS = [0, 0.5, -0.5, 1, -1, 1.5, -1.5, 2, -2, 2.5, -2.5, 3.1];

/** The nearest place for a number about its arrow's tip that no arrow and no other number crosses; `pixel`: mm of the
 * picture per pixel.
 * @type {(line: number[][], wide: number, tall: number, shafts: number[][][], taken: number[][], pixel: number) => number[] | null} */
export const freePlace = ([from, tip], wide, tall, shafts, taken, pixel) => {
  const heading = Math.atan2(tip[1] - from[1], tip[0] - from[0]);
  for (let ring = 0; ring < 40; ring++) {
    for (const turn of TURNS) {
      const cos = Math.cos(heading + turn), sin = Math.sin(heading + turn);
      const away = (2 + 4 * ring) * pixel + 0.5 * (wide * Math.abs(cos) + tall * Math.abs(sin));
      const x = tip[0] + away * cos, y = tip[1] + away * sin;
      const place = [x - wide / 2, y - tall / 2, x + wide / 2, y + tall / 2];
      if (!taken.some((other) => overlap(other, place)) && !shafts.some((shaft) => crosses(shaft, place, 2.2))) return place;
    }
  }
  return null;
};

/** Puts the names of one side into two rows, in the order of what they name, pushed apart until none covers another.
 * @type {(side: Name[], left: number, right: number, pixel: number) => void} */
const spread = (side, left, right, pixel) => {
  side.sort((a, b) => a.anchor[0] - b.anchor[0]);
  side.forEach((label, index) => {
    label.row = index % 2;
    label.x = label.anchor[0];
  });
  const apart = (/** @type {Name} */ a, /** @type {Name} */ b, /** @type {number} */ room) => {
    const lack = room - (b.x - a.x);
    if (lack > 0) {
      a.x -= lack / 2;
      b.x += lack / 2;
    }
  };
  for (let round = 0; round < 600; round++) {
    for (let i = 1; i < side.length; i++) {
      apart(side[i - 1], side[i], (side[i].row ? side[i - 1] : side[i]).wide / 2 + 6 * pixel);
      if (i > 1) apart(side[i - 2], side[i], (side[i - 2].wide + side[i].wide) / 2 + 8 * pixel);
    }
    for (const label of side) label.x = Math.max(Math.min(label.x, right - label.wide / 2), left + label.wide / 2);
  }
};

/** Lays names out around a box [left, top, right, bottom] of the picture: two rows above and two below.
 * @type {(inside: Name[], box: number[], pixel: number) => void} */
export const layNames = (inside, [left, top, right, bottom], pixel) => {
  const heights = inside.map(({ anchor }) => anchor[1]).sort((p, q) => p - q);
  const middle = heights[heights.length >> 1];
  for (const above of [true, false]) {
    let side = inside.filter(({ anchor }) => anchor[1] < middle === above);
    for (const label of side) label.wide = 7.4 * label.text.length * pixel;
    // a narrow view has no room for all: the longest chains of neighbours lose every other name
    while (side.length > 1 && side.reduce((sum, { wide }) => sum + wide + 8 * pixel, 0) > 1.8 * (right - left)) side = side.filter((_, i) => i % 2 === 0);
    spread(side, left + 3 * pixel, right - 3 * pixel, pixel);
    for (const label of side) {
      label.placed = true;
      label.y = above ? top + (14 + 16 * (1 - label.row)) * pixel : bottom - (6 + 16 * (1 - label.row)) * pixel;
      label.from = above ? label.y + 3 * pixel : label.y - 12 * pixel;
    }
  }
};

/** An outline of the picture: what it is made of (how soft: 0 is the softest, -1 is hard), its path as drawn, its
 * points once they are asked for (mm of its frame, y up; `corners` are those that a straight line does not pass), and
 * the body that carries it (null: the ground).
 * @typedef {{ element: SVGGeometryElement, moving: Moving | undefined, body: number | null, soft: number, drawn: string, points: number[][] | null, corners: number[][], dented: boolean }} Outline */
/** The bodies on the two sides of a contact (null: the ground).
 * @typedef {{ disc: number | null, curve: number | null }} Sides */
/** A pressed contact: its point (mm, y up) and the normal toward the disc's side.
 * @typedef {{ sides: Sides, at: number[], normal: number[] }} Pressed */
/** Which outline is dented in a contact, by which, and whether it is the disc's; where on that part it was pressed
 * last, and the way into the felt there, in
 * the part's frame. @typedef {{ felt: Outline, into: Outline, ofDisc: boolean, at: number[], inward: number[] }} Dent */

const SOFT = ["felt", "cloth", "leather"];
/** mm: between points of an outline; how little a point may be beside the line of its neighbours to be none of its
 * corners; how far an outline may be from a contact that it shows; how far about the contact, and how deep, a felt is
 * dented. */
const FINE = 0.25, STRAIGHT = 1e-4, NEAR = 1.5, ABOUT = 15, DEEPEST = 4;

/** The outlines in a group of shapes. @type {(group: Element, moving: Moving[]) => Outline[]} */
export const outlinesIn = (group, moving) => [.../** @type {NodeListOf<SVGGeometryElement>} */ (group.querySelectorAll(".parts > path"))].map((element) => ({
  element, moving: moving.find((one) => one.element === element), body: "body" in element.dataset ? Number(element.dataset.body) : null,
  soft: SOFT.findIndex((finish) => element.getAttribute("fill") === `url(#${finish})`), drawn: element.getAttribute("d") ?? "", points: null, corners: [], dented: false,
}));

/** Points of a path of lines and quadratic curves, no farther apart than FINE, y up. What the browser says of a path
 * (getPointAtLength) takes seconds for a whole action.
 * @type {(drawn: string) => number[][]} */
const pointsAlong = (drawn) => {
  const words = drawn.match(/[A-Z]|-?[0-9.]+(?:e-?[0-9]+)?/g) ?? [];
  /** @type {number[][]} */
  const points = [];
  let at = 0, here = [0, 0];
  const next = () => [Number(words[at++]), -Number(words[at++])];
  const put = (/** @type {number[]} */ p) => {
    const last = points[points.length - 1];
    if (!last || p[0] !== last[0] || p[1] !== last[1]) points.push(p);
  };
  const far = (/** @type {number[]} */ a, /** @type {number[]} */ b) => Math.hypot(b[0] - a[0], b[1] - a[1]);
  const along = (/** @type {number[]} */ over, /** @type {number[]} */ to) => {
    const from = here, count = Math.max(1, Math.ceil((far(from, over) + far(over, to)) / FINE));
    for (let k = 1; k <= count; k++) {
      const t = k / count, u = 1 - t;
      put([0, 1].map((axis) => u * u * from[axis] + 2 * u * t * over[axis] + t * t * to[axis]));
    }
    here = to;
  };
  const straight = (/** @type {number[]} */ to) => along([(here[0] + to[0]) / 2, (here[1] + to[1]) / 2], to);
  while (at < words.length) {
    const command = words[at++];
    if (command === "M") put(here = next());
    else if (command === "L") straight(next());
    else if (command === "Q") along(next(), next());
    else if (points.length) straight(points[0]);
  }
  // It is closed: its end is its beginning.
  if (points.length > 1 && far(points[0], points[points.length - 1]) < 1e-9) points.pop();
  return points;
};

/** An outline's points, in its frame. @type {(outline: Outline) => number[][]} */
const pointsOf = (outline) => {
  if (!outline.points) {
    const points = outline.points = pointsAlong(outline.drawn), count = points.length;
    outline.corners = points.filter(([x, y], k) => {
      const [a, b] = points[(k + count - 1) % count], [c, d] = points[(k + 1) % count];
      return Math.abs((c - a) * (y - b) - (d - b) * (x - a)) > STRAIGHT * Math.hypot(c - a, d - b);
    });
  }
  return outline.points;
};
/** @type {(outline: Outline) => Frame} */
const frameOf = (outline) => outline.moving?.frame ?? STILL;
/** How far an outline passes from a point. @type {(outline: Outline, at: number[]) => number} */
const farFrom = (outline, at) => {
  const frame = frameOf(outline);
  return Math.min(...pointsOf(outline).map((p) => carry(frame, p)).map(([x, y]) => Math.hypot(x - at[0], y - at[1])));
};

/** Which two outlines show a contact: the softest of both sides, and the nearest of the other's. Nothing if the picture
 * does not show it.
 * @type {(outlines: Outline[], pressed: Pressed) => Dent | null} */
const dentOf = (outlines, { sides, at }) => {
  const near = (/** @type {number | null} */ body) => outlines.filter((outline) => outline.body === body)
    .map((outline) => ({ outline, far: farFrom(outline, at) })).filter(({ far }) => far < NEAR).sort((a, b) => a.far - b.far);
  const disc = near(sides.disc), curve = near(sides.curve);
  const felts = [...disc, ...curve].filter(({ outline }) => outline.soft >= 0).sort((a, b) => a.outline.soft - b.outline.soft || a.far - b.far);
  const felt = felts[0]?.outline;
  if (!felt) return null;
  const ofDisc = disc.some(({ outline }) => outline === felt);
  const into = (ofDisc ? curve : disc).sort((a, b) => +(a.outline.soft >= 0) - +(b.outline.soft >= 0) || a.far - b.far)[0]?.outline;
  return into ? { felt, into, ofDisc, at: [0, 0], inward: [0, 0] } : null;
};

/** Where a point of a felt goes that lies within the part that presses it, or beyond its surface: out of it, the way
 * `inward` into the felt.
 * @type {(p: number[], beyond: boolean, inward: number[], part: number[][]) => number[]} */
const pushedOut = (p, beyond, [dx, dy], part) => {
  let crossings = 0, way = 0;
  part.forEach((from, k) => {
    const to = part[(k + 1) % part.length];
    const a = (from[0] - p[0]) * dy - (from[1] - p[1]) * dx, b = (to[0] - p[0]) * dy - (to[1] - p[1]) * dx;
    if (a > 0 === b > 0) return;
    const share = a / (a - b);
    const along = (from[0] + share * (to[0] - from[0]) - p[0]) * dx + (from[1] + share * (to[1] - from[1]) - p[1]) * dy;
    if (along < 0) return;
    crossings++;
    if (along <= DEEPEST) way = Math.max(way, along);
  });
  return beyond || crossings % 2 === 1 ? [p[0] + way * dx, p[1] + way * dy] : p;
};

/** Felts are dented where something presses them, and are as drawn elsewhere. The outlines are where `move` has put
 * them; `found` keeps which outlines show
 * which contact. @type {(outlines: Outline[], pressed: (Pressed | null)[], found: Map<number, Dent | null>) => void} */
export const dent = (outlines, pressed, found) => {
  /** @type {Map<Outline, number[][]>} */
  const dented = new Map();
  pressed.forEach((contact, zone) => {
    let shown = found.get(zone);
    if (contact && shown === undefined) found.set(zone, shown = dentOf(outlines, contact));
    if (!shown) return;
    const { felt, into, ofDisc } = shown, own = frameOf(felt), other = frameOf(into);
    // A felt that lags behind what leaves it pushes no more, and is dented still.
    if (contact) {
      shown.at = home(other, contact.at);
      shown.inward = home({ ...other, x: 0, y: 0 }, ofDisc ? contact.normal : contact.normal.map((n) => -n));
    }
    const { at, inward } = shown;
    let moves = dented.has(felt);
    const after = (dented.get(felt) ?? pointsOf(felt)).map((point) => {
      const p = home(other, carry(own, point)), away = [p[0] - at[0], p[1] - at[1]];
      const deep = away[0] * inward[0] + away[1] * inward[1];
      if (Math.abs(deep) > DEEPEST || Math.hypot(...away) > ABOUT) return point;
      const moved = pushedOut(p, contact !== null && ofDisc && deep < 0, inward, into.corners);
      if (moved === p) return point;
      moves = true;
      return home(own, carry(other, moved));
    });
    if (moves) dented.set(felt, after);
  });
  for (const outline of outlines) {
    const points = dented.get(outline);
    if (points) outline.element.setAttribute("d", `M${points.map(([x, y]) => `${x.toFixed(3)} ${(-y).toFixed(3)}`).join("L")}Z`);
    else if (outline.dented) outline.element.setAttribute("d", outline.drawn);
    outline.dented = points !== undefined;
  }
};
