// The picture of one or two actions: moved, pushed at by arrows, named, zoomed, and grasped by the key.
import {
  arrowOf, carry, dent, element, freePlace, layNames, move, movingIn, newtons, outlinesIn, placeBodies, STILL,
} from "../../../crates/erard-figures/src/page/moving.js";
import type { Dent, Frame, Moving, Name, Outline } from "../../../crates/erard-figures/src/page/moving.js";
import type { Pose, Scene } from "../engine/protocol";
import { mainPart } from "./parts";
import { called, speaks } from "./terms";

interface Shown {
  scene: Scene;
  /** Which it is of all that are played: its tint. */
  index: number;
  group: SVGElement;
  moving: Moving[];
  outlines: Outline[];
  dents: Map<number, Dent | null>;
  placed: Frame[];
  finger: { path: SVGElement; text: SVGElement };
  zones: ({ path: SVGElement; text: SVGElement } | null)[];
  /** A modal string: its line, how it is exaggerated, and the label that says so. */
  swing: { line: SVGElement; label: SVGElement; times: number; most_mm: number } | null;
  pose: Pose | null;
}

interface Label extends Name {
  moving: Moving | undefined;
  at: number[];
  leader: SVGElement;
  end: SVGElement;
  label: SVGElement;
}

/** [left, top, width, height], mm of the picture. */
export type View = [number, number, number, number];
const boxOf = (view: number[]): View => [view[0]!, view[1]!, view[2]! - view[0]!, view[3]! - view[1]!];

export interface Grasp {
  /** A finger is put on the key, moves it down by so much from where it was put down, m, or leaves it. */
  press(down_m: number | null): void;
  /** A part of an action is pointed at; null: none is. */
  point(at: { action: number; part: string } | null): void;
  /** A part was tapped; null: none was, but the picture. */
  choose(at: { action: number; part: string } | null): void;
  /** Which way a part is turned by dragging it, of the screen; null where it is not. */
  way(action: number, part: string): "ns" | "ew" | null;
  /** A part that can be turned by hand is taken: the function that receives where the hand is, mm to the right and up
   * from there. */
  take(action: number, part: string): ((x_mm: number, y_mm: number) => void) | null;
  /** The view is not moved by hand: wheel and pan are the page's. */
  fixed?: boolean;
}

/** Times by which a string's swing is exaggerated, and how far it then goes at most, mm of the picture. */
const TIMES = [10, 5, 2, 1], SWING_MM = 12;
/** How far a pointer moves and still taps, px. */
const TAP = 4;

interface Finger {
  from: number[];
  key: boolean;
  at: { action: number; part: string } | null;
  drag: ((x_mm: number, y_mm: number) => void) | null;
  /** Where it was put down, px, and whether it has left that place. */
  down: number[];
  moved: boolean;
}

/** How far apart the wanted and the shown view may be, as a share of the view. */
const CLOSE = 1e-3;

let made = 0;

export class Picture {
  private readonly mine = `p${++made}-`;
  readonly svg: SVGSVGElement;
  private shown: Shown[] = [];
  private labels: Label[] = [];
  private forces!: SVGElement;
  private numbers!: SVGElement;
  private names!: SVGElement;
  private parts!: SVGElement;
  private view: View = [0, 0, 1, 1];
  private whole: View = [0, 0, 1, 1];
  private close: View | null = null;
  private pixel = 0.4;
  private layout = "";
  private fingers = new Map<number, Finger>();
  private marked = "";
  arrows = true;
  naming = false;
  onview: (view: View) => void = () => {};

  constructor(into: Element, private readonly title: string, private readonly grasp: Grasp) {
    this.svg = document.createElementNS("http://www.w3.org/2000/svg", "svg");
    this.svg.setAttribute("class", "action");
    this.svg.setAttribute("role", "img");
    this.svg.setAttribute("aria-label", title);
    this.svg.setAttribute("preserveAspectRatio", "xMidYMid meet");
    into.append(this.svg);
    this.listen();
    new ResizeObserver(() => this.redraw()).observe(this.svg);
  }

  /** Shows other actions: numbers of those that are played, and their scenes. */
  show(actions: { index: number; scene: Scene }[], tinted: boolean, keepView: boolean): void {
    this.svg.replaceChildren();
    this.svg.setAttribute("aria-label", `${this.title}: ${actions.map(({ scene }) => scene.name).join(" and ")}`);
    const defs = element("defs", {}, this.svg);
    // Each picture has gradients of its own: those of one that is not shown paint nothing.
    defs.innerHTML = (actions[0]?.scene.gradients ?? "").replaceAll('id="', `id="${this.mine}`).replaceAll('href="#', `href="#${this.mine}`);
    this.parts = element("g", {}, this.svg);
    this.names = element("g", { class: "names" }, this.svg);
    this.forces = element("g", { class: "forces" }, this.svg);
    this.numbers = element("g", { class: "numbers" }, this.svg);
    this.shown = actions.map(({ index, scene }) => {
      const tint = tinted ? ` a${index}` : "";
      const group = element("g", { class: `one${tint}` }, this.parts);
      group.innerHTML = scene.shapes;
      const arrow = (kind: string) => ({
        path: element("path", { class: `arrow ${kind}${tint}` }, this.forces),
        text: element("text", { class: `newton ${kind}${tint}`, "text-anchor": "middle" }, this.numbers),
      });
      const key = scene.press?.body;
      const pressed = new Set(key === undefined ? [] : [key, scene.bodies[key]?.parent ?? key]);
      for (const part of group.querySelectorAll<SVGElement>("[data-body]")) {
        if (pressed.has(Number(part.dataset.body))) part.classList.add("key");
      }
      // Names are shown beside the picture; a browser's own would cover it.
      for (const part of group.querySelectorAll<SVGElement>(".parts > path")) {
        const title = part.querySelector("title");
        part.dataset.part = mainPart(title?.textContent ?? "");
        part.dataset.detail = title?.textContent ?? "";
        title?.remove();
        const way = this.grasp.way(index, part.dataset.part);
        if (way) part.classList.add(`turns-${way}`);
      }
      const moving = movingIn(group), outlines = outlinesIn(group, moving);
      for (const part of group.querySelectorAll("[fill^='url(#']")) part.setAttribute("fill", part.getAttribute("fill")!.replace("url(#", `url(#${this.mine}`));
      return {
        scene, index, group, moving, outlines, dents: new Map(), placed: [], pose: null, swing: this.swinging(scene, group), finger: arrow("touch"),
        zones: scene.zones.map((zone) => (zone.unseen ? null : arrow("contact"))),
      };
    });
    const first = this.shown[0];
    const pieces = first ? [...first.group.querySelectorAll(".parts > path")] : [];
    this.labels = (first?.scene.labels ?? []).map(({ text: part, piece, at }) => {
      const { text, lang } = called(`part.${mainPart(part)}`, part);
      const leader = element("path", { class: "leader" }, this.names), end = element("circle", { class: "leader-end" }, this.names);
      const label = element("text", { class: "label", "text-anchor": "middle" }, this.names);
      label.textContent = text;
      speaks(label, lang);
      const moving = first!.moving.find((one) => one.element === pieces[piece]);
      return { text, at, moving, leader, end, label, anchor: [0, 0], wide: 0, row: 0, x: 0, y: 0, from: 0, placed: false };
    });
    this.layout = this.marked = "";
    const boxes = actions.map(({ scene }) => scene.views);
    const around = (views: number[][]): View =>
      boxOf([Math.min(...views.map((v) => v[0]!)), Math.min(...views.map((v) => v[1]!)), Math.max(...views.map((v) => v[2]!)), Math.max(...views.map((v) => v[3]!))]);
    if (boxes.length) {
      this.whole = around(boxes.map(({ whole }) => whole));
      const near = boxes.map(({ close }) => close).filter((close) => close !== null);
      this.close = near.length ? around(near) : null;
    }
    if (!keepView || this.view[2] === 1) this.view = this.whole;
    this.look(this.view, true);
  }

  /** A string that yields swings across the straight one, exaggerated as its label says. */
  private swinging(scene: Scene, group: SVGElement): Shown["swing"] {
    const { string, places_m } = scene;
    if (!string || !places_m?.length) return null;
    const line = element("polyline", { class: "swinging" }, group);
    const label = element("text", { class: "newton swing", "text-anchor": "end", x: (string[0]! - 4).toFixed(2), y: (-string[1]! - SWING_MM - 1).toFixed(2) }, group);
    return { line, label, times: 0, most_mm: 0 };
  }

  private swingBy({ swing, scene }: Shown, shape_m: Float32Array): void {
    if (!swing || !scene.string) return;
    const [strike, height] = scene.string;
    swing.most_mm = Math.max(swing.most_mm, ...shape_m.map((m) => 1e3 * Math.abs(m)));
    const times = TIMES.find((times) => times * swing.most_mm <= SWING_MM) ?? 1;
    if (times !== swing.times) {
      swing.times = times;
      swing.label.textContent = times === 1 ? "middle string" : `middle string, swing \u00d7 ${times}`;
    }
    swing.line.setAttribute("points", scene.places_m!.map((place, k) => `${(strike! + 1e3 * place).toFixed(2)},${(-height! - times * 1e3 * shape_m[k]!).toFixed(3)}`).join(" "));
  }

  /** The body that carries a part; null: none does; undefined: there is no such part of this action here. */
  bodyOf(action: number, part: string): number | null | undefined {
    const path = this.shown.find(({ index }) => index === action)?.group.querySelector<SVGElement>(`[data-part="${CSS.escape(part)}"]`);
    return path ? (path.dataset.body === undefined ? null : Number(path.dataset.body)) : undefined;
  }

  /** Shows which part is meant. */
  mark(what: { action: number; part: string } | null): void {
    const marked = what ? `${what.action} ${what.part}` : "";
    if (marked === this.marked) return;
    this.marked = marked;
    for (const one of this.shown) {
      for (const part of one.group.querySelectorAll<SVGElement>("[data-part]")) part.classList.toggle("held", one.index === what?.action && part.dataset.part === what.part);
    }
  }

  /** The part that an event met. */
  private partOf(target: EventTarget | null): { action: number; part: string } | null {
    const path = (target as Element | null)?.closest<SVGElement>("[data-part]");
    const one = path && this.shown.find(({ group }) => group.contains(path));
    return one && path.dataset.part ? { action: one.index, part: path.dataset.part } : null;
  }

  /** Moves everything to where it is. */
  draw(poses: Pose[]): void {
    for (const one of this.shown) {
      const pose = poses[one.index];
      if (!pose || pose.angles.length !== one.scene.bodies.length) continue;
      one.pose = pose;
      this.swingBy(one, pose.string);
      one.placed = placeBodies(one.scene.bodies, (body) => pose.angles[body]!);
      move(one.moving, one.placed);
      dent(one.outlines, one.scene.zones.map((zone, k) => {
        const [force, x, y, nx, ny] = pose.contacts.subarray(5 * k, 5 * k + 5);
        return zone.unseen || !(force! > 0) ? null : { sides: zone, at: [1e3 * x!, 1e3 * y!], normal: [nx!, ny!] };
      }), one.dents);
    }
    this.push();
    this.name();
  }

  private redraw(): void {
    this.measure();
    if (!this.shown.length) return;
    this.push();
    this.name();
  }

  private measure(): void {
    const matrix = this.svg.getScreenCTM();
    if (!matrix || !(matrix.a > 0)) return;
    this.pixel = 1 / matrix.a;
    this.svg.style.setProperty("--px", String(this.pixel));
  }

  private push(): void {
    const shafts: number[][][] = [], seen = this.seen();
    // Numbers stay within what is seen.
    const far = 1e6, taken: number[][] = [[-far, -far, seen[0]!, far], [seen[2]!, -far, far, far], [-far, -far, far, seen[1]!], [-far, seen[3]!, far, far]];
    const numbered: { text: SVGElement; force: number; shaft: number[][]; law: Scene["arrow"] }[] = [];
    const draw = (one: Shown, arrow: { path: SVGElement; text: SVGElement }, force: { x: number; y: number; ux: number; uy: number; force: number }) => {
      const law = one.scene.arrow;
      const visible = this.arrows && force.force >= law.drawn;
      arrow.path.style.display = visible ? "" : "none";
      arrow.text.style.display = "none";
      if (!visible) return;
      const { path, shaft } = arrowOf(law, force);
      arrow.path.setAttribute("d", path);
      shafts.push(shaft);
      numbered.push({ text: arrow.text, force: force.force, shaft, law });
    };
    for (const one of this.shown) {
      const { pose, scene, placed } = one;
      if (!pose) continue;
      if (scene.press) {
        const [x, y] = carry(placed[scene.press.body]!, scene.press.point);
        draw(one, one.finger, { x: x!, y: y!, ux: 0, uy: 1, force: pose.finger_force_n });
      }
      one.zones.forEach((arrow, zone) => {
        if (!arrow) return;
        const [force, x, y, nx, ny] = pose.contacts.subarray(5 * zone, 5 * zone + 5);
        const sign = scene.zones[zone]!.sign;
        draw(one, arrow, { x: 1e3 * x!, y: 1e3 * y!, ux: sign * nx!, uy: -sign * ny!, force: force! });
      });
    }
    for (const { text, force, shaft, law } of numbered) {
      const [x, y] = shaft[1]!;
      if (force < law.labelled || x! < seen[0]! || x! > seen[2]! || y! < seen[1]! || y! > seen[3]!) continue;
      const label = newtons(force);
      const place = freePlace(shaft, 7.6 * label.length * this.pixel, 13 * this.pixel, shafts, taken, this.pixel);
      if (!place) continue;
      taken.push(place);
      text.style.display = "";
      text.textContent = label;
      text.setAttribute("x", ((place[0]! + place[2]!) / 2).toFixed(2));
      text.setAttribute("y", (place[3]! - 2.6 * this.pixel).toFixed(2));
    }
  }

  /** What the element shows, mm of the picture: more than the view box where their shapes differ. */
  private seen(): number[] {
    const matrix = this.svg.getScreenCTM(), frame = this.svg.getBoundingClientRect();
    if (!matrix || !(matrix.a > 0)) return [this.view[0], this.view[1], this.view[0] + this.view[2], this.view[1] + this.view[3]];
    return [(frame.left - matrix.e) / matrix.a, (frame.top - matrix.f) / matrix.d, (frame.right - matrix.e) / matrix.a, (frame.bottom - matrix.f) / matrix.d];
  }

  private name(): void {
    this.names.style.display = this.naming ? "" : "none";
    if (!this.naming) return;
    const [left, top, wide, tall] = this.view;
    const inside = this.labels.filter((label) => {
      const [x, y] = carry(label.moving?.frame ?? STILL, label.at);
      label.anchor = [x!, -y!];
      return x! > left && x! < left + wide && -y! > top && -y! < top + tall;
    });
    const layout = `${this.view} ${this.pixel} ${inside.map(({ text }) => text)}`;
    if (layout !== this.layout) {
      this.layout = layout;
      for (const label of this.labels) label.placed = false;
      layNames(inside, this.seen(), this.pixel);
    }
    for (const label of this.labels) {
      const shown = label.placed && inside.includes(label);
      for (const part of [label.leader, label.end, label.label]) part.style.display = shown ? "" : "none";
      if (!shown) continue;
      const [x, y] = label.anchor;
      label.leader.setAttribute("d", `M${label.x.toFixed(2)} ${label.from.toFixed(2)}L${x!.toFixed(2)} ${y!.toFixed(2)}`);
      label.leader.setAttribute("stroke-width", this.pixel.toFixed(3));
      label.end.setAttribute("cx", x!.toFixed(2));
      label.end.setAttribute("cy", y!.toFixed(2));
      label.end.setAttribute("r", (2 * this.pixel).toFixed(3));
      label.label.setAttribute("x", label.x.toFixed(2));
      label.label.setAttribute("y", label.y.toFixed(2));
    }
  }

  /** Shows this view; one that is out of all proportion is not taken. */
  look(to: View, quietly = false): void {
    if (!to.every(Number.isFinite) || to[2] < 4 || to[2] > 4 * this.whole[2]) return;
    const moved = to.some((value, k) => Math.abs(value - this.view[k]!) > CLOSE * this.view[2]);
    this.view = to;
    this.svg.setAttribute("viewBox", to.map((value) => value.toFixed(3)).join(" "));
    this.redraw();
    if (moved && !quietly) this.onview(to);
  }

  lookWhole(): void {
    this.look(this.whole);
  }

  lookClose(): void {
    this.look(this.close ?? this.whole);
  }

  get isWhole(): boolean {
    return this.view.every((value, k) => Math.abs(value - this.whole[k]!) < CLOSE * this.whole[2]);
  }

  zoom(factor: number, x = this.view[0] + this.view[2] / 2, y = this.view[1] + this.view[3] / 2): void {
    const [left, top, wide, tall] = this.view;
    this.look([x + (left - x) * factor, y + (top - y) * factor, wide * factor, tall * factor]);
  }

  private at(event: { clientX: number; clientY: number }): number[] {
    const matrix = this.svg.getScreenCTM()!;
    return [(event.clientX - matrix.e) / matrix.a, (event.clientY - matrix.f) / matrix.d];
  }

  /** One finger on the key presses it, elsewhere it moves the picture; two zoom it. */
  private listen(): void {
    const { svg, fingers } = this;
    if (!this.grasp.fixed) svg.addEventListener("wheel", (event) => {
      event.preventDefault();
      const [x, y] = this.at(event);
      this.zoom(Math.exp(event.deltaY * (event.deltaMode ? 0.05 : 0.0015)), x, y);
    }, { passive: false });
    svg.addEventListener("pointerdown", (event) => {
      if (event.button !== 0 || (this.grasp.fixed && !(event.target as Element).closest(".key"))) return;
      svg.setPointerCapture(event.pointerId);
      const key = (event.target as Element).closest(".key") !== null && ![...fingers.values()].some((other) => other.key);
      const at = this.partOf(event.target);
      const drag = at && !key && !fingers.size ? this.grasp.take(at.action, at.part) : null;
      fingers.set(event.pointerId, { from: this.at(event), key, at, drag, down: [event.clientX, event.clientY], moved: false });
      svg.classList.toggle("grabbed", !key && !drag);
      svg.classList.toggle("pressing", key);
      if (key) this.grasp.press(0);
    });
    svg.addEventListener("pointermove", (event) => {
      const finger = fingers.get(event.pointerId);
      if (!finger) {
        if (event.pointerType === "mouse") this.grasp.point(this.partOf(event.target));
        return;
      }
      const to = this.at(event), from = finger.from;
      finger.moved ||= Math.hypot(event.clientX - finger.down[0]!, event.clientY - finger.down[1]!) > TAP;
      if (finger.key) return this.grasp.press(1e-3 * (to[1]! - from[1]!));
      if (finger.drag) {
        if (finger.moved) finger.drag(to[0]! - from[0]!, from[1]! - to[1]!);
        return;
      }
      const [other] = [...fingers].filter(([id, one]) => id !== event.pointerId && !one.key && !one.drag).map(([, one]) => one.from);
      if (other) {
        const spread = (at: number[]) => Math.hypot(at[0]! - other[0]!, at[1]! - other[1]!);
        this.zoom(Math.min(Math.max(spread(from) / Math.max(spread(to), 1e-3), 0.5), 2), other[0], other[1]);
        finger.from = this.at(event);
      } else if (finger.moved) this.look([this.view[0] + from[0]! - to[0]!, this.view[1] + from[1]! - to[1]!, this.view[2], this.view[3]]);
    });
    const over = (event: PointerEvent) => {
      const finger = fingers.get(event.pointerId);
      fingers.delete(event.pointerId);
      if (finger?.key) this.grasp.press(null);
      if (finger && !finger.moved && event.type === "pointerup") this.grasp.choose(finger.at);
      if (!fingers.size) svg.classList.remove("grabbed", "pressing");
    };
    svg.addEventListener("pointerup", over);
    svg.addEventListener("pointercancel", over);
    svg.addEventListener("pointerleave", () => this.grasp.point(null));
    if (!this.grasp.fixed) svg.addEventListener("dblclick", () => this.lookWhole());
  }

}
