// The studio: what the panels share. It owns the state, the workers and the clock of frames, and knows nothing of the
// panels' insides.
import type { Dial, Events, FromPlayer, Impact, Note, Pose, Scene, Stroke, ToPlayer, Touch } from "../engine/protocol";
import { Bench, Dropped } from "./bench";
import { CurvePanel } from "./curves";
import { byId, fixed, later, say } from "./dom";
import type { Chosen } from "./part";
import { PARTS } from "./parts";
import { exampleOf, LENGTH_S, strokeOf } from "./examples";
import { Picture, type View } from "./picture";
import { type Base, DEEPEST_M, FIRST, fromHash, same, type Setting, type State, toHash } from "./state";
import { called, named, onlanguage, speaks } from "./terms";

/** What is known of an action that is played. */
export interface Loaded {
  setting: Setting;
  /** The file before any dial is turned, and as it is. */
  baseText: string;
  text: string;
  dials: Dial[];
}

type Frame = Extract<FromPlayer, { kind: "frame" }>;

/** How much of the past the curves and the slider show, s. */
const SHOWN_S = 1;
/** What is shown before a key starts, s. */
const BEFORE_S = 0.03;
/** The curves show no less than this, s. */
const LEAST_SHOWN_S = 0.1;
/** How many points a curve has. */
const POINTS = 600;
/** How often curves are drawn, ms. */
const CURVES_MS = 60;
/** Without an answer for so many frames the worker is taken to hang: seconds, and none while the page is not seen or
 * the machine sleeps. */
const PATIENCE = 300;

/** No finger on the key; how firm it is comes with every frame. */
const LIFTED: Extract<Touch, { kind: "finger" }> = { kind: "finger", position_m: null, firmness_n_m: 0 };

export class App {
  state: State = structuredClone(FIRST);
  loaded: Loaded[] = [];
  scenes: Scene[] = [];
  builtin: string[] = [];
  keyboards: string[] = [];
  readonly pictures: Picture[] = [];
  private readonly curves = new CurvePanel(byId("curves"));
  private player!: Worker;
  readonly bench: Bench;
  private past: State[] = [];
  private future: State[] = [];
  private loadId = 0;
  private waitingFor: ((refused: { which: number; message: string } | null) => void) | null = null;
  private touch: Touch = LIFTED;
  /** The instant that is looked at; null is now. */
  private at_s: number | null = null;
  private playing = false;
  private span: [number, number] = [0, 0];
  private asked_ms: number | null = null;
  private waited = 0;
  private drawn_ms = 0;
  private curves_ms = 0;
  private needed = true;
  /** Whether what was loaded has not been seen yet, and how often something was. */
  private loading = false;
  loads = 0;
  private broken = false;
  private latest: Frame | null = null;
  /** For tests: how long frames and steps took. */
  readonly timing = { frames: [] as number[], costs: [] as number[], steps: [] as number[] };

  /** Told when the state or what is loaded has changed; when a frame is there; when the action came to rest. */
  readonly onchange: (() => void)[] = [];
  readonly onframe: ((frame: Frame) => void)[] = [];
  readonly onfault: ((message: string) => void)[] = [];
  readonly onrefused: ((which: number, message: string) => void)[] = [];
  /** Told what was done to a recording that is played. */
  readonly onstroke: ((told: string[]) => void)[] = [];
  /** Told which part is tapped, and which is pointed at. */
  onchoose: (chosen: Chosen | null) => void = () => {};
  onpoint: (pointed: Chosen | null) => void = () => {};

  /** For tests: what frames of the keyboard cost, ms, their steps, and how many keys were awake; and the time that was
   * left out, s. */
  readonly keysTiming: [number, number, number][] = [];
  keysLate = 0;
  /** For tests: the notes that were heard last, N at the bridge in steps of SOUND_STEP_S. */
  sounds: Note[] = [];
  readonly rendered = async (turns: [number, number, number][], seconds: number, exact: boolean) => (await import("./sound")).rendered(this.engine, this.state.keyboard, turns, seconds, exact);

  constructor(readonly engine: WebAssembly.Module) {
    this.bench = new Bench(engine);
    this.startPlayer();
    // Names in the picture and in the curves are drawn.
    onlanguage.push(() => this.scenes.length && this.show(this.scenes));
  }

  // -------------------------------------------------------------------------------------------------------- the player

  private startPlayer(): void {
    this.player?.terminate();
    // It has nothing to show until something is loaded into it.
    this.scenes = [];
    this.player = new Worker(new URL("../engine/player.worker.ts", import.meta.url), { type: "module" });
    this.player.onmessage = ({ data }: MessageEvent<FromPlayer>) => this.hear(data);
    this.player.onerror = (event) => this.fail(event.message || "the engine's worker failed");
    this.tell({ kind: "open", module: this.engine });
    this.asked_ms = null;
  }

  private tell(message: ToPlayer): void {
    this.player.postMessage(message);
  }

  private hear(message: FromPlayer): void {
    switch (message.kind) {
      case "ready":
        return;
      case "loaded":
        if (message.id !== this.loadId) return;
        this.at_s = null;
        this.playing = false;
        this.loading = true;
        this.show(message.scenes);
        this.waitingFor?.(null);
        return;
      case "refused":
        if (message.id === this.loadId) this.waitingFor?.(message);
        return;
      case "no-stroke":
        say(message.message);
        this.notice(message.message);
        return;
      case "stroke-begun":
        [this.shows, this.waits, this.heard] = [this.waits, null, []];
        return this.onstroke.forEach((told) => told(message.told));
      case "restored":
        this.broken = false;
        byId("fault").hidden = true;
        this.show(message.scenes);
        this.wake();
        say("Restored.");
        return;
      case "fault":
        return this.fail(message.message);
      case "frame":
        this.asked_ms = null;
        this.take(message);
    }
  }

  /** Says what went wrong in the engine, with a button that goes back to what was good. */
  private fail(message: string): void {
    this.broken = true;
    this.asked_ms = null;
    const place = byId("fault");
    const again = document.createElement("button");
    again.type = "button";
    again.textContent = "Restore the last good state";
    again.addEventListener("click", () => this.recover());
    place.replaceChildren(`The engine has stopped: ${message}. `, again);
    place.hidden = false;
    this.onfault.forEach((told) => told(message));
  }

  private recover(): void {
    // A worker that still answers restores itself; one that hangs is replaced, and begins at rest.
    this.tell({ kind: "restore" });
    const hung = setTimeout(() => {
      this.startPlayer();
      this.broken = false;
      byId("fault").hidden = true;
      void this.reload();
    }, 3000);
    const heard = ({ data }: MessageEvent<FromPlayer>) => {
      if (data.kind === "restored") clearTimeout(hung);
    };
    this.player.addEventListener("message", heard);
  }

  notice(message: string | null): void {
    const place = byId("notice");
    place.textContent = message ?? "";
    place.hidden = !message;
  }

  // ---------------------------------------------------------------------------------------------------------- pictures

  private show(scenes: Scene[]): void {
    const another = scenes.length !== this.scenes.length || this.state.beside !== this.pictures.length > 1;
    this.scenes = scenes;
    const beside = this.state.beside && scenes.length > 1;
    const wanted = beside ? 2 : 1;
    const place = byId("pictures");
    byId("pictures").querySelector(".first")?.remove();
    while (this.pictures.length > wanted) this.pictures.pop()!.svg.remove();
    while (this.pictures.length < wanted) {
      const picture = new Picture(place, this.pictures.length ? "Action B" : "The action", {
        press: (down_m) => this.press(down_m),
        point: (at) => this.onpoint(at),
        choose: (at) => this.onchoose(at),
        way: (action, part) => this.movable(part, action)?.way ?? null,
        take: (action, part) => this.hold(part, action),
      });
      picture.onview = (view) => {
        this.pictures.forEach((other) => other !== picture && other.look(view, true));
        this.state = { ...this.state, view: picture.isWhole ? null : [...view] };
        this.remember();
      };
      this.pictures.push(picture);
    }
    const all = scenes.map((scene, index) => ({ scene, index }));
    this.pictures.forEach((picture, index) => {
      picture.arrows = this.state.forces;
      picture.naming = this.state.names;
      picture.show(beside ? [all[index]!] : all, scenes.length > 1 && !beside, !another);
    });
    // What the address asks for is seen first; then each picture is where it was, and a new one shows all.
    if (this.first) this.pictures.forEach((picture) => this.state.view && picture.look(this.state.view as View, true));
    else if (another && this.state.view) this.state = { ...this.state, view: null };
    this.first = false;
    place.classList.toggle("beside", beside);
    for (const two of document.querySelectorAll<HTMLElement>(".two")) two.hidden = scenes.length < 2;
    byId<HTMLInputElement>("beside").checked = beside;
    byId("name-a").textContent = `A: ${this.title(0)}`;
    byId("name-b").textContent = `B: ${this.title(1)}`;
    this.wake();
  }

  private first = true;

  /** The dial that dragging a part turns, what that does, and which way it goes on the screen. */
  movable(part: string, action: number): { dial: Dial; label: string; way: "ns" | "ew" } | null {
    const drag = PARTS[part]?.drag;
    const dial = drag && this.loaded[action]?.dials.find(({ name }) => name === drag.dial);
    return dial ? { dial, label: dial.label, way: drag!.along[1] ? "ns" : "ew" } : null;
  }

  /** A part is taken by hand: it follows by its dial, as far as that goes. */
  private hold(part: string, action: number): ((x_mm: number, y_mm: number) => void) | null {
    const found = this.movable(part, action);
    if (!found) return null;
    const { dial } = found, { along } = PARTS[part]!.drag!;
    const setting = action ? this.state.b : this.state.a;
    const began = setting?.turns[dial.name] ?? dial.value;
    let last = began;
    this.apart();
    return (x_mm, y_mm) => {
      if (last === began) this.onchoose({ action, part });
      const value = Math.min(Math.max(began + along[0] * x_mm + along[1] * y_mm, dial.from), dial.to);
      const rounded = Number(value.toFixed(dial.decimals));
      if (rounded === last) return;
      last = rounded;
      void this.turn(action, dial.name, rounded);
    };
  }

  /** What tells an action from the other. */
  title(which: number): string {
    const one = this.loaded[which];
    if (!one) return "";
    const { base, turns } = one.setting;
    const of = "builtin" in base ? base.builtin : "key" in base ? `key ${base.key}` : (this.scenes[which]?.name ?? "a file");
    const turned = Object.keys(turns).length;
    return turned ? `${of}, ${turned} turned` : of;
  }

  get names(): string[] {
    return this.scenes.length > 1 ? ["A", "B"] : ["A"];
  }

  // ------------------------------------------------------------------------------------------------------------ frames

  /** A frame is wanted: something may move. */
  wake(): void {
    this.needed = true;
    this.woken = true;
  }
  /** Since the last frame that was asked for: what that one says of rest is out of date. */
  private woken = false;

  private take(frame: Frame): void {
    this.latest = frame;
    if (this.loading) this.loads += 1;
    this.loading = false;
    const [, end] = frame.span;
    const start = frame.events[0]?.key_start_s ?? NaN;
    const wanted = Number.isFinite(start) ? Math.min(end - SHOWN_S, start - BEFORE_S) : end - SHOWN_S;
    this.span = [Math.max(frame.span[0], wanted), end];
    for (const picture of this.pictures) picture.draw(frame.poses);
    this.timing.costs.push(frame.cost_ms);
    this.timing.steps.push(frame.steps);
    if (frame.curves) this.curves.draw(frame.curves, this.names, this.state.difference, this.at_s);
    this.onframe.forEach((told) => told(frame));
    this.transport(frame);
    this.look(frame.impacts, end);
    // While nothing happens nothing is asked for.
    if (frame.resting && frame.curves && !this.woken && !this.playing && this.at_s === null) this.needed = false;
  }

  private readonly tick = (now: number): void => {
    requestAnimationFrame(this.tick);
    if (this.drawn_ms) this.timing.frames.push(now - this.drawn_ms);
    if (this.timing.frames.length > 20_000) for (const list of Object.values(this.timing)) list.splice(0, 10_000);
    const passed_s = this.drawn_ms ? Math.min((now - this.drawn_ms) / 1e3, 0.1) : 0;
    this.drawn_ms = now;
    if (this.broken || !this.scenes.length) return;
    if (this.asked_ms !== null) {
      this.waited += 1;
      if (this.waited > PATIENCE) this.fail("it does not answer");
      return;
    }
    if (!this.needed) {
      // The clock of what rests stands still: the next frame begins anew.
      return;
    }
    if (this.playing && this.at_s !== null) {
      const next = this.at_s + passed_s * this.state.speed;
      this.at_s = next > this.span[1] ? this.span[0] : next;
    }
    const [from, to] = this.span;
    // Curves follow more slowly than the picture, and are drawn once more where everything has come to rest.
    const draws = now - this.curves_ms > CURVES_MS || this.latest?.resting === true;
    if (draws) this.curves_ms = now;
    const curves = draws ? { from: Math.min(from, to - LEAST_SHOWN_S), to, points: POINTS } : null;
    this.asked_ms = now;
    this.waited = 0;
    this.woken = false;
    const touch = this.touch.kind === "finger" ? { ...this.touch, firmness_n_m: 1e3 * this.state.firmness } : this.touch;
    this.tell({ kind: "frame", wall_ms: now, touch, at_s: this.at_s, curves, pace: this.state.slow ? this.state.speed : 1, slow: [] });
  };

  /** Goes to the impact that an example is about, when its stroke is over. */
  private look(impacts: Impact[], end_s: number): void {
    if (!this.shows) return;
    this.heard.push(...impacts);
    if (end_s < LENGTH_S) return;
    const [which, nth] = this.shows, at = this.heard.filter(({ action }) => action === which)[nth - 1];
    this.shows = null;
    if (at) this.seek(at.time_s);
  }

  /** Whether the button of the replay says that it pauses. */
  private pausable = false;

  private transport(frame: Frame): void {
    const slider = byId<HTMLInputElement>("time"), clock = byId("clock");
    const [from, to] = this.span;
    slider.min = String(from);
    slider.max = String(Math.max(to, from + 1e-6));
    slider.value = String(this.at_s ?? to);
    const at = this.at_s ?? to;
    const start = frame.events[0]?.key_start_s;
    const since = start !== undefined && Number.isFinite(start) ? start : to;
    const now = called(frame.resting ? "tool.at-rest" : "tool.now");
    const text = this.at_s === null ? now.text : `${fixed(1e3 * (at - since), 2)} ms`;
    clock.textContent = text;
    speaks(clock, this.at_s === null ? now.lang : null);
    slider.setAttribute("aria-valuetext", this.at_s === null ? text : `${text} from the key's start`);
    byId("live").setAttribute("aria-pressed", String(this.at_s === null));
    byId("replay").setAttribute("aria-pressed", String(this.playing));
    if (this.playing !== this.pausable) named(byId("replay").firstElementChild!, (this.pausable = this.playing) ? "tool.pause" : "tool.replay");
  }

  get events(): Events[] {
    return this.latest?.events ?? [];
  }

  get poses(): Pose[] {
    return this.latest?.poses ?? [];
  }

  /** Hammer speed at the first impact of the last press, m/s. */
  hammerSpeedOf(which: number): number | undefined {
    const speed = this.events[which]?.hammer_speed_m_per_s;
    return Number.isFinite(speed) ? speed : undefined;
  }

  // ---------------------------------------------------------------------------------------------------------- pressing

  /** The finger, so far below where it touched the key, m; null lifts it. */
  press(down_m: number | null): void {
    this.goLive();
    const { imposed } = this.state, [least_m, most_m] = imposed ? [0, DEEPEST_M] : [-0.005, 0.095];
    this.touch = { ...LIFTED, position_m: down_m === null ? null : Math.min(Math.max(down_m, least_m), most_m), imposed };
    if (down_m !== null && down_m > 1e-3) document.getElementById("hint")?.remove();
    this.begin();
  }

  /** A finger that presses with so much, N; 0 lifts it. */
  push(force_n: number): void {
    this.goLive();
    this.touch = { kind: "force", force_n };
    document.getElementById("hint")?.remove();
    this.begin();
  }

  /** The impact of an example that is looked at once its stroke is over, which action's and which; before the stroke
   * has begun it waits. And the impacts so far. */
  private waits: [number, number] | null = null;
  private shows: [number, number] | null = null;
  private heard: Impact[] = [];
  /** Told to play the keyboard's passage. */
  onpassage: () => void = () => {};

  /** Plays the example that is shown, and then looks at its instant. */
  perform(): void {
    const example = exampleOf(this.state.example);
    if (!example) return;
    say(example.see);
    if (example.passage) return this.onpassage();
    const stroke = strokeOf(example);
    if (!stroke) return;
    this.stroke(stroke, example.other ?? null);
    this.waits = example.at ?? null;
  }

  /** The stroke that was played last. */
  lastStroke: Stroke | null = null;

  /** A stroke is played from rest, as `erard press` plays it. */
  stroke(stroke: Stroke, other: Stroke | null = null): void {
    this.goLive();
    this.waits = this.shows = null;
    this.notice(null);
    this.touch = LIFTED;
    this.lastStroke = stroke;
    this.tell({ kind: "stroke", stroke, other });
    document.getElementById("hint")?.remove();
    this.begin();
  }

  private sendPedal(): void {
    this.tell({ kind: "pedal", lift_m: 1e-3 * this.state.pedal });
    this.begin();
  }

  private begin(): void {
    this.shows = null;
    if (!this.needed) this.tell({ kind: "rest" });
    this.wake();
  }

  goLive(): void {
    if (this.at_s === null) return;
    this.at_s = null;
    this.playing = false;
    this.tell({ kind: "rest" });
    this.wake();
  }

  /** Plays the last second again, from its beginning or from where one is. */
  replay(on = !this.playing, from: number | null = null): void {
    this.playing = on;
    if (on) {
      const start = this.events[0]?.key_start_s;
      const first = start !== undefined && start > this.span[0] ? Math.max(start - 0.005, this.span[0]) : this.span[0];
      this.at_s = from ?? (this.at_s === null || this.at_s >= this.span[1] ? first : this.at_s);
    }
    this.wake();
  }

  seek(time: number): void {
    this.playing = false;
    this.at_s = Math.min(Math.max(time, this.span[0]), this.span[1]);
    this.wake();
  }

  setSpeed(speed: number): void {
    void this.change({ speed });
  }

  // ------------------------------------------------------------------------------------------------------------- state

  /** Begins with what the address asks for. */
  async start(): Promise<void> {
    const { instruments, keyboards } = await this.bench.ask<{ instruments: string[]; keyboards: string[] }>({ kind: "builtin" });
    this.builtin = instruments;
    this.keyboards = keyboards;
    const { state, fault } = await fromHash(location.hash);
    this.state = state;
    let said = fault;
    if (!(await this.reload())) {
      said ??= `The address asks for something that does not exist: ${this.refused?.message}`;
      this.state = structuredClone(FIRST);
      await this.reload();
    }
    this.notice(said);
    if (!said) this.perform();
    addEventListener("hashchange", () => void this.follow());
    requestAnimationFrame(this.tick);
  }

  private async follow(): Promise<void> {
    if (location.hash.replace(/^#/, "") === this.written) return;
    const { state, fault } = await fromHash(location.hash);
    await this.change(state);
    this.pictures.forEach((picture) => (state.view ? picture.look(state.view as View, true) : picture.lookWhole()));
    if (fault) this.notice(fault);
    else this.perform();
  }

  private written = "";
  private readonly remember = later(250, async () => {
    this.written = await toHash(this.state);
    history.replaceState(null, "", this.written ? `#${this.written}` : location.pathname + location.search);
  });

  async link(): Promise<string> {
    return `${location.href.split("#")[0]}#${await toHash(this.state)}`;
  }

  get canUndo(): boolean {
    return this.past.length > 0;
  }

  get canRedo(): boolean {
    return this.future.length > 0;
  }

  /** Goes to another state. Changes of the same `gesture` that follow each other are undone as one. */
  async change(change: Partial<State>, gesture: string | null = null): Promise<boolean> {
    const before = this.state;
    const next = { ...this.state, ...change };
    if (same(before, next)) return true;
    const instruments = !same([before.a, before.b], [next.a, next.b]);
    this.state = next;
    if (instruments) {
      const goes = gesture !== null && gesture === this.gesture;
      if (!goes) this.past.push(before);
      if (this.past.length > 200) this.past.shift();
      this.future = [];
      this.gesture = gesture;
    } else if (before.beside !== next.beside) this.show(this.scenes);
    if (before.pedal !== next.pedal) this.sendPedal();
    if (before.forces !== next.forces || before.names !== next.names) {
      for (const picture of this.pictures) {
        [picture.arrows, picture.naming] = [next.forces, next.names];
        picture.draw(this.poses);
      }
    }
    if (before.difference !== next.difference) this.wake();
    this.remember();
    if (instruments) return this.reload();
    this.onchange.forEach((told) => told());
    return true;
  }
  private gesture: string | null = null;

  /** Ends a gesture: what follows is undone by itself. */
  apart(): void {
    this.gesture = null;
  }

  async undo(): Promise<void> {
    const to = this.past.pop();
    if (!to) return;
    this.future.push(this.state);
    await this.goTo(to);
  }

  async redo(): Promise<void> {
    const to = this.future.pop();
    if (!to) return;
    this.past.push(this.state);
    await this.goTo(to);
  }

  private async goTo({ a, b }: State): Promise<void> {
    this.apart();
    this.state = { ...this.state, a, b };
    this.remember();
    await this.reload();
  }

  /** Turns a dial of an action; where it has it already, takes the turn back. */
  turn(which: number, name: string, value: number | null): Promise<boolean> {
    const setting = which ? this.state.b! : this.state.a;
    const turns = { ...setting.turns };
    if (value === null) delete turns[name];
    else turns[name] = value;
    const changed: Setting = { ...setting, turns };
    return this.change(which ? { b: changed } : { a: changed }, `${which}:${name}`);
  }

  setBase(which: number, base: Base): Promise<boolean> {
    const setting: Setting = { base, turns: {} };
    return this.change(which ? { b: setting } : { a: setting, example: "" });
  }

  private reloading: Promise<boolean> | null = null;
  private stale = false;

  /** Loads what the state says into the player: the last one asked for, where several are. */
  private reload(): Promise<boolean> {
    this.stale = true;
    this.reloading ??= (async () => {
      let sound = true;
      while (this.stale) {
        this.stale = false;
        sound = await this.load();
      }
      this.reloading = null;
      return sound;
    })();
    return this.reloading;
  }

  private readonly bases = new Map<string, Promise<{ text: string; dials: Dial[] }>>();

  /** A file without turns, and its dials. */
  private base(base: Base): Promise<{ text: string; dials: Dial[] }> {
    const key = JSON.stringify(base);
    let known = this.bases.get(key);
    if (!known) {
      known = (async () => {
        const text = await this.bench.ask<string>({ kind: "base", of: base });
        return { text, dials: await this.bench.ask<Dial[]>({ kind: "dials", text }) };
      })();
      if (this.bases.size > 40) this.bases.clear();
      this.bases.set(key, known);
      known.catch(() => this.bases.delete(key));
    }
    return known;
  }

  /** Lets a button play the last stroke on some actions, one after the other, and says how it went. */
  hears(button: HTMLButtonElement, said: HTMLElement, ...actions: number[]): void {
    button.addEventListener("click", async () => {
      button.disabled = true;
      said.textContent = "The note is computed \u2026";
      const { hear } = await import("./hear");
      said.textContent = await hear(this, actions).catch((error: Error) => `No sound: ${error.message}.`);
      button.disabled = false;
    });
  }

  /** The file of an action whose strings sound: its own, or the built-in grand with strings and the same turns, whose
   * name comes with it. Throws where there is none. */
  async strung(which: number): Promise<{ text: string; instead: string | null }> {
    const own = this.loaded[which];
    if (!own) throw new Error("nothing is loaded");
    if (this.scenes[which]?.string) return { text: own.text, instead: null };
    const { base, turns } = own.setting, instead = `${FIRST.keyboard}-strings`;
    const other: Base | null = "builtin" in base && base.builtin === FIRST.keyboard ? { builtin: instead } : "key" in base && base.keyboard === FIRST.keyboard ? { key: base.key, keyboard: instead } : null;
    if (!other) throw new Error(`the string of ${this.title(which)} is rigid, and does not sound; those of ${instead} do`);
    const { text } = await this.base(other);
    return { text: Object.keys(turns).length ? await this.bench.ask<string>({ kind: "turned", text, turns }) : text, instead };
  }

  private async load(): Promise<boolean> {
    const { a, b } = this.state;
    const settings = b ? [a, b] : [a];
    const loaded: Loaded[] = [];
    for (const [which, setting] of settings.entries()) {
      try {
        const { text: baseText, dials } = await this.base(setting.base);
        const turned = Object.keys(setting.turns).length > 0;
        const text = turned ? await this.bench.ask<string>({ kind: "turned", text: baseText, turns: setting.turns }) : baseText;
        loaded.push({ setting, baseText, text, dials });
      } catch (error) {
        if (error instanceof Dropped) return false;
        return this.refuse(which, (error as Error).message);
      }
    }
    const id = ++this.loadId;
    const was = this.loaded;
    this.loaded = loaded;
    const refused = await new Promise<{ which: number; message: string } | null>((resolve) => {
      this.waitingFor = resolve;
      this.tell({ kind: "pedal", lift_m: 1e-3 * this.state.pedal });
      this.tell({ kind: "load", id, texts: loaded.map(({ text }) => text), keep: true });
    });
    if (refused) {
      this.loaded = was;
      return this.refuse(refused.which, refused.message);
    }
    this.notice(null);
    this.refused = null;
    this.onchange.forEach((told) => told());
    return true;
  }

  /** Why what is asked for does not work; what was there before goes on. */
  refused: { which: number; message: string } | null = null;

  private refuse(which: number, message: string): boolean {
    this.refused = { which, message };
    this.onrefused.forEach((told) => told(which, message));
    this.onchange.forEach((told) => told());
    return false;
  }
}
