// What is drawn beside a figure as the key is pressed: the finger's force against the key's depth, and hammer and key
// against time.
import { element } from "../../../crates/erard-figures/src/page/moving.js";

const WIDE = 420, TALL = 150, DEEP_MM = 10, GRAMS = 200;

export class Plot {
  private readonly svg: SVGSVGElement;
  private readonly trace: SVGElement;
  private readonly before: SVGElement;
  private readonly dot: SVGElement;
  private points: [number, number][] = [];

  constructor(into: Element) {
    this.svg = document.createElementNS("http://www.w3.org/2000/svg", "svg");
    this.svg.setAttribute("class", "plot");
    this.svg.setAttribute("viewBox", `0 0 ${WIDE} ${TALL}`);
    this.svg.setAttribute("preserveAspectRatio", "xMinYMin meet");
    this.svg.setAttribute("aria-hidden", "true");
    const { svg } = this;
    element("path", { class: "axis", d: `M34 4V${TALL - 24}H${WIDE - 6}` }, svg);
    const text = (x: number, y: number, words: string, anchor: string) => (element("text", { x, y, "text-anchor": anchor }, svg).textContent = words);
    for (const grams of [0, 50, 100, 150, 200]) {
      const y = this.y(grams);
      if (grams) element("path", { class: "axis", d: `M30 ${y}H34` }, svg);
      text(27, y + 4, String(grams), "end");
    }
    for (const depth of [0, 2, 4, 6, 8, 10]) text(this.x(depth), TALL - 9, String(depth), "middle");
    text(40, 12, "finger, grams", "start");
    text(WIDE - 6, TALL - 30, "key down, mm", "end");
    this.before = element("path", { class: "before", d: "" }, svg);
    this.trace = element("path", { class: "trace", d: "" }, svg);
    this.dot = element("circle", { class: "dot", r: 4, cx: -99, cy: 0 }, svg);
    into.append(svg);
  }

  private x(depth_mm: number): number {
    return 34 + (Math.min(Math.max(depth_mm, 0), DEEP_MM) / DEEP_MM) * (WIDE - 46);
  }

  private y(grams: number): number {
    return TALL - 24 - (Math.min(grams, GRAMS) / GRAMS) * (TALL - 34);
  }

  /** Another press: the last one stays, thin. */
  begin(): void {
    if (this.points.length > 20) this.before.setAttribute("d", this.trace.getAttribute("d") ?? "");
    this.points = [];
  }

  /** Where the key is, mm, and what the finger carries, g. */
  add(depth_mm: number, grams: number): void {
    if (depth_mm > 0.05) this.points.push([depth_mm, grams]);
    if (this.points.length > 4000) this.points.splice(0, 2000);
    const [x, y] = [this.x(depth_mm), this.y(grams)];
    this.dot.setAttribute("cx", x.toFixed(1));
    this.dot.setAttribute("cy", y.toFixed(1));
    this.trace.setAttribute("d", this.points.map(([depth, force], k) => `${k ? "L" : "M"}${this.x(depth).toFixed(1)} ${this.y(force).toFixed(1)}`).join(""));
  }
}

/** Hammer and key since the key left its rest, and a dot for every impact. */
export class Strip {
  private readonly hammer: SVGElement;
  private readonly key: SVGElement;
  private readonly dots: SVGElement;
  private readonly ticks: SVGElement;
  private impacts: number[] = [];
  private shown_s = 0;

  constructor(into: Element) {
    const svg = document.createElementNS("http://www.w3.org/2000/svg", "svg");
    svg.setAttribute("class", "strip");
    svg.setAttribute("viewBox", `0 0 ${STRIP.wide} ${STRIP.tall}`);
    svg.setAttribute("aria-hidden", "true");
    element("path", { class: "string", d: `M0 ${STRIP.string}H${STRIP.wide}` }, svg);
    element("path", { class: "line", d: `M0 ${STRIP.rest}H${STRIP.wide}M0 ${STRIP.floor}H${STRIP.wide}` }, svg);
    const text = (y: number, words: string, of: string) => {
      const made = element("text", { x: STRIP.wide, y, "text-anchor": "end", class: of }, svg);
      made.textContent = words;
    };
    text(STRIP.string - 5, "string", "of-string");
    text(STRIP.rest - 5, "hammer", "of-hammer");
    text(STRIP.floor - 5, "key", "of-key");
    this.ticks = element("g", {}, svg);
    this.hammer = element("path", { class: "hammer", d: "" }, svg);
    this.key = element("path", { class: "key", d: "" }, svg);
    this.dots = element("g", {}, svg);
    into.append(svg);
    this.scale(STRIP.least_s);
  }

  begin(): void {
    this.impacts = [];
    this.dots.replaceChildren();
    this.scale(STRIP.least_s);
  }

  private scale(shown_s: number): void {
    this.shown_s = shown_s;
    const step = shown_s > 1.2 ? 0.5 : shown_s > 0.5 ? 0.2 : 0.1;
    this.ticks.replaceChildren();
    for (let n = 0; n * step <= shown_s + 1e-9; n++) {
      const label = element("text", { x: this.x(n * step), y: STRIP.tall - 2, "text-anchor": n ? "middle" : "start" }, this.ticks);
      label.textContent = n ? String(Number((n * step).toFixed(1))) : "0 s";
    }
  }

  private x(s: number): number {
    return (s / this.shown_s) * (STRIP.wide - 52);
  }

  /** Key and hammer, mm, at times from the start on, and the impacts that are new. */
  draw(start_s: number, times: Float64Array, key_mm: Float64Array, hammer_mm: Float64Array, impacts: number[]): void {
    this.impacts.push(...impacts);
    const long_s = times.at(-1)! - start_s;
    const wanted = STRIP.scales_s.find((one) => one >= long_s) ?? STRIP.most_s;
    if (wanted > this.shown_s) this.scale(wanted);
    const line = (of: Float64Array, y: (mm: number) => number) => {
      const points: string[] = [];
      times.forEach((time, k) => Number.isNaN(of[k]!) || points.push(`${this.x(time - start_s).toFixed(1)} ${y(of[k]!).toFixed(1)}`));
      return points.length > 1 ? `M${points.join("L")}` : "";
    };
    this.hammer.setAttribute("d", line(hammer_mm, (mm) => STRIP.rest - (mm / 47.5) * (STRIP.rest - STRIP.string)));
    this.key.setAttribute("d", line(key_mm, (mm) => STRIP.rest + 8 + (mm / 10) * (STRIP.floor - STRIP.rest - 12)));
    while (this.dots.children.length < this.impacts.length) element("circle", { class: "impact", r: 3.2, cy: STRIP.string }, this.dots);
    this.impacts.forEach((at, k) => this.dots.children[k]!.setAttribute("cx", this.x(Math.min(at - start_s, this.shown_s * 1.15)).toFixed(1)));
  }
}

/** Sizes of a strip, px of its own, and how long it shows, s. */
const STRIP = { wide: 330, tall: 176, string: 22, rest: 112, floor: 156, least_s: 0.4, scales_s: [0.4, 0.8, 1.2, 2], most_s: 2.6 };
/** How long a strip shows, s. */
export const STRIP_S = STRIP.most_s;
