// One figure of the story: the picture, the finger, what is to be done and what came of it.
import type { Scene } from "../engine/protocol";
import { fixed, h, say } from "../page/dom";
import { Picture } from "../page/picture";
import type { Frame, Live } from "./live";
import { Plot, Strip, STRIP_S } from "./plot";
import type { Now, Step } from "./scenes";
import { Press } from "./strokes";

/** How far the finger goes, mm below the key's rest: the last of it presses on the felt under the key. */
const DEEPEST_MM = 11;
/** A step of the arrow keys, mm. */
const STEP_MM = 0.5;
/** Below this the key is at rest, m. */
const REST_M = 2.5e-4;
/** What a strip shows before the key leaves its rest, s. */
const BEFORE_S = 0.03;
/** A lighter finger than this has left the key, N. */
const FELT_N = 0.02;
/** How long a click that nobody holds presses, ms. */
const CLICK_MS = 1200;
const narrow = matchMedia("(max-width: 900px)");

export class Figure {
  readonly id: string;
  private picture: Picture | null = null;
  private live: Live | null = null;
  private scene: Scene | null = null;
  private readonly frame: HTMLElement;
  private readonly grip: HTMLElement;
  private readonly track = h("div", { class: "track" });
  private readonly thumb = h("div", { class: "thumb" });
  private readonly pace = h("p", { class: "pace" }, "loading the model");
  private readonly facts = h("dl", { class: "facts", "aria-hidden": "true" });
  private readonly result = h("p", { class: "outcome" });
  private readonly heard = h("p", { class: "heard", role: "status" });
  private readonly pressButton: HTMLElement;
  private plot: Plot | null = null;
  private strip: Strip | null = null;
  private option = 0;
  private last: (Press | null)[];
  /** Where the finger is held, mm; null lifts it. */
  private held_mm: number | null = null;
  private readonly pressing = new Set<string>();
  private press = new Press();
  private rested = true;
  private said = "";
  /** The last frame's numbers; for tests, too. */
  now: Now | null = null;
  done = false;
  /** The slowest that time has run, seconds of the action in one of the page; for tests. */
  slowest = 1;

  constructor(readonly element: HTMLElement, private readonly step: Step, still: SVGSVGElement) {
    this.id = element.dataset.scene!;
    this.last = step.setups.map(() => null);
    this.frame = element.querySelector<HTMLElement>(".frame")!;
    if (!this.frame.contains(still)) this.frame.append(still.cloneNode(true));
    this.look();
    narrow.addEventListener("change", () => this.look());
    const goal = step.mark_mm === undefined ? null : h("div", { class: "goal" });
    this.grip = h("div", {
      class: "grip", role: "slider", tabindex: 0, "aria-orientation": "vertical", "aria-label": "Finger on the key", "aria-valuemin": 0, "aria-valuemax": 10,
      "aria-valuenow": 0, "aria-valuetext": "up", title: "Drag the finger down, or use the arrow keys; hold the space bar to press",
    }, this.track, goal, this.thumb, h("span", { class: "word", "aria-hidden": "true" }, "drag"));
    this.pressButton = h("button", { type: "button", class: "press" }, "Press and hold");
    const show = h("button", { type: "button", class: "show", onclick: () => this.show() }, "Show me");
    const listen = h("button", { type: "button", class: "listen" }, "Hear it");
    listen.addEventListener("click", () => void this.listen_to(listen));
    const acts = h("div", { class: "acts" }, this.switch(), this.pressButton, show, step.setups.some(({ sounds }) => sounds) ? listen : null);
    this.frame.prepend(this.grip);
    if (step.plot) this.plot = new Plot(this.frame);
    this.frame.append(this.facts, this.pace);
    const caption = element.querySelector("figcaption")!;
    caption.append(this.result);
    if (!element.classList.contains("wide")) this.strip = new Strip(caption);
    caption.append(acts, this.heard);
    this.listen();
    this.place(0);
    if (goal) new ResizeObserver(() => this.mark(goal)).observe(this.frame);
  }

  /** What it waits for, before it is live. */
  wait(words: string): void {
    this.pace.textContent = words;
  }

  private look(): void {
    const view = narrow.matches ? this.step.narrow : this.step.wide;
    this.frame.querySelector("svg.first")?.setAttribute("viewBox", view.join(" "));
    this.picture?.look(view, true);
  }

  private mark(goal: HTMLElement): void {
    goal.style.top = `${this.track.offsetTop + (this.step.mark_mm! / DEEPEST_MM) * this.track.offsetHeight}px`;
  }

  /** The positions of the step's switch, where it has one. */
  private switch(): HTMLElement | null {
    if (this.step.setups.length < 2) return null;
    return h("fieldset", { class: "switch" }, h("legend", { class: "unseen" }, "Action"), ...this.step.setups.map(({ label }, which) =>
      h("label", {}, h("input", { type: "radio", name: `${this.id}-setup`, value: which, checked: which === 0, onchange: () => void this.choose(which) }), label!)));
  }

  // -------------------------------------------------------------------------------------------------------- the engine

  /** The engine plays this figure from now on. */
  async begin(live: Live): Promise<void> {
    this.live = live;
    live.slow = this.step.slow;
    live.onframe = (frame) => this.take(frame);
    this.wait("at rest");
    const scene = await live.load(this.step.setups[this.option]!);
    if (this.live !== live) return;
    this.scene = scene;
    if (!this.picture) {
      this.frame.querySelector("svg.first")?.remove();
      this.picture = new Picture(this.frame, this.element.querySelector(".task")?.textContent ?? "The action", {
        press: (down_m) => this.hold(down_m === null ? null : 1e3 * down_m),
        point: () => {}, choose: () => {}, way: () => null, take: () => null, fixed: true,
      });
      this.picture.arrows = false;
      if (this.plot) this.picture.svg.setAttribute("preserveAspectRatio", "xMidYMax meet");
    }
    this.picture.show([{ index: 0, scene }], false, true);
    this.look();
    this.element.dataset.live = "true";
  }

  /** Another figure has the engine. */
  end(): void {
    if (!this.live) return;
    this.live.stop();
    this.live = null;
    this.held_mm = null;
    this.pressing.clear();
    this.pressButton.classList.remove("down");
    this.element.dataset.live = "false";
  }

  /** Whether a hand is on it. */
  get busy(): boolean {
    return this.held_mm !== null || this.pressing.size > 0;
  }

  async choose(which: number): Promise<void> {
    this.option = which;
    for (const input of this.element.querySelectorAll<HTMLInputElement>(".switch input")) input.checked = Number(input.value) === which;
    this.press = new Press();
    this.rested = true;
    const { live } = this;
    if (!live) return;
    live.stop();
    await this.begin(live);
  }

  /** Plays the step's own stroke. */
  show(): void {
    this.element.classList.add("touched");
    this.held_mm = null;
    this.rested = true;
    this.live?.stop();
    this.live?.play(this.step.show);
  }

  /** Lets the step's own stroke be heard. */
  private async listen_to(button: HTMLButtonElement): Promise<void> {
    const { live } = this;
    if (!live) return;
    button.disabled = true;
    this.heard.textContent = "The note is computed \u2026";
    this.heard.textContent = await live.listen(this.step.setups[this.option]!, this.step.show).catch((error: Error) => `No sound: ${error.message}.`);
    button.disabled = false;
  }

  // -------------------------------------------------------------------------------------------------------- the finger

  private hold(down_mm: number | null): void {
    this.held_mm = down_mm === null ? null : Math.min(Math.max(down_mm, -0.5), DEEPEST_MM);
    this.element.classList.add("touched");
    this.live?.press(this.held_mm === null ? null : 1e-3 * this.held_mm);
    if (this.held_mm !== null) this.place(this.held_mm);
  }

  /** A press by the button, or by a key of the keyboard on one of the two: as long as one of them holds. */
  private push(by: "pointer" | "grip" | "button", holds: boolean): void {
    const before = this.pressing.size > 0;
    if (holds) this.pressing.add(by);
    else this.pressing.delete(by);
    const on = this.pressing.size > 0;
    if (on === before) return;
    this.pressButton.classList.toggle("down", on);
    this.element.classList.add("touched");
    this.held_mm = null;
    this.live?.push(on ? this.step.press_n : 0);
  }

  /** The drawn finger at a depth, mm. */
  private place(down_mm: number): void {
    this.thumb.style.transform = "";
    this.thumb.style.top = `${this.track.offsetTop + (Math.max(down_mm, 0) / DEEPEST_MM) * this.track.offsetHeight}px`;
  }

  private listen(): void {
    const { grip, pressButton } = this;
    let from: { y: number; mm: number; pointer: number } | null = null;
    grip.addEventListener("pointerdown", (event) => {
      if (event.button !== 0) return;
      grip.setPointerCapture(event.pointerId);
      from = { y: event.clientY, mm: this.held_mm ?? 0, pointer: event.pointerId };
      this.hold(from.mm);
    });
    grip.addEventListener("pointermove", (event) => {
      if (from?.pointer === event.pointerId) this.hold(from.mm + ((event.clientY - from.y) / this.track.offsetHeight) * DEEPEST_MM);
    });
    for (const over of ["pointerup", "pointercancel"] as const) grip.addEventListener(over, (event) => {
      if (from?.pointer !== event.pointerId) return;
      from = null;
      this.hold(null);
    });
    grip.addEventListener("keydown", (event) => {
      const at = this.held_mm ?? 0;
      const to: Record<string, number | null> = {
        ArrowDown: at + STEP_MM, ArrowRight: at + STEP_MM, ArrowUp: at - STEP_MM, ArrowLeft: at - STEP_MM, PageDown: at + 4 * STEP_MM, PageUp: at - 4 * STEP_MM,
        End: 10, Home: null, Escape: null,
      };
      if (event.key === " " || event.key === "Enter") this.push("grip", true);
      else if (event.key in to) this.hold(to[event.key]! !== null && to[event.key]! > 0 ? to[event.key]! : null);
      else return;
      event.preventDefault();
    });
    for (const [of, by] of [[grip, "grip"], [pressButton, "button"]] as const) {
      of.addEventListener("keyup", (event) => {
        if (event.key === " " || event.key === "Enter") this.push(by, false);
      });
      of.addEventListener("blur", () => this.push(by, false));
    }
    grip.addEventListener("blur", () => this.held_mm !== null && !from && this.hold(null));
    pressButton.addEventListener("pointerdown", (event) => {
      if (event.button !== 0) return;
      pressButton.setPointerCapture(event.pointerId);
      this.push("pointer", true);
    });
    for (const over of ["pointerup", "pointercancel"] as const) pressButton.addEventListener(over, () => this.push("pointer", false));
    pressButton.addEventListener("contextmenu", (event) => event.preventDefault());
    pressButton.addEventListener("keydown", (event) => {
      if (event.key !== " " && event.key !== "Enter") return;
      event.preventDefault();
      this.push("button", true);
    });
    // A click without a pointer and without a key, as assistive technology makes one.
    let pressed = false;
    pressButton.addEventListener("pointerdown", () => (pressed = true));
    pressButton.addEventListener("click", () => {
      if (!pressed) {
        this.push("button", true);
        setTimeout(() => this.push("button", false), CLICK_MS);
      }
      pressed = false;
    });
    addEventListener("blur", () => {
      for (const by of ["pointer", "grip", "button"] as const) this.push(by, false);
      if (this.held_mm !== null) this.hold(null);
    });
  }

  // ------------------------------------------------------------------------------------------------------ what is seen

  private take(frame: Frame): void {
    const pose = frame.poses[0], events = frame.events[0];
    if (!pose || !events || !this.scene) return;
    this.picture?.draw(frame.poses);
    const lifted = !this.busy;
    if (pose.key_m < REST_M) this.rested ||= lifted && frame.resting;
    else if (this.rested) {
      this.rested = false;
      this.press = this.last[this.option] = new Press();
      this.plot?.begin();
      this.strip?.begin();
      if (this.strip && this.live) this.live.since = { from_s: pose.time_s - BEFORE_S, most_s: STRIP_S };
    }
    const key_mm = 1e3 * pose.key_m, hammer_mm = 1e3 * pose.hammer_rise_m;
    this.press.see({ time_s: pose.time_s, key_mm, hammer_mm, finger_force_n: pose.finger_force_n, swing_m: pose.swing_m, impacts: frame.impacts });
    if (pose.finger_force_n > FELT_N) this.plot?.add(key_mm, pose.finger_force_n * 101.97);
    const { curves } = frame, since = this.live?.since;
    if (curves && since) this.strip?.draw(since.from_s, curves.times, curves.series[0]![0]!, curves.series[0]![1]!, frame.impacts.map(({ time_s }) => time_s));
    this.now = { press: this.press, pose, events, resting: frame.resting, option: this.option, last: this.last };
    const [text, done] = this.step.outcome(this.now);
    if (text && this.result.textContent !== text) this.result.textContent = text;
    if (done && !this.done) {
      this.done = true;
      this.element.classList.add("done");
    }
    this.tell(this.step.facts(this.now));
    if (this.held_mm === null) this.place(key_mm);
    this.slowest = Math.min(this.slowest, frame.pace);
    const slower = Math.round(1 / frame.pace), pace = frame.resting ? "at rest" : slower > 1 ? `slow motion, 1/${slower}` : "real time";
    if (this.pace.textContent !== pace) this.pace.textContent = pace;
    this.pace.classList.toggle("slow", slower > 1 && !frame.resting);
    this.grip.setAttribute("aria-valuenow", fixed(Math.min(Math.max(key_mm, 0), 10), 1));
    this.grip.setAttribute("aria-valuetext", key_mm < 0.3 ? "up" : `${fixed(key_mm, 1)} mm down; hammer ${fixed(hammer_mm, 0)} mm up`);
    // Screen readers hear what came of it once it stands still.
    if (frame.resting && text && text !== this.said) {
      this.said = text;
      say(text);
    }
  }

  private tell(facts: [string, string][]): void {
    if (this.facts.children.length !== facts.length) this.facts.replaceChildren(...facts.map(([name]) => h("div", {}, h("dt", {}, name), h("dd"))));
    facts.forEach(([, value], k) => {
      const cell = this.facts.children[k]!.lastElementChild!;
      if (cell.textContent !== value) cell.textContent = value;
    });
  }
}
