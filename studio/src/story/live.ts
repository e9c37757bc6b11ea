// The engine under one figure at a time: what is asked of the player's worker, frame by frame. Knows nothing of
// figures.
import { type FromPlayer, HEARD, NOTE_S, type Note, type Scene, type Slow, type ToPlayer, type Touch } from "../engine/protocol";
import { Bench } from "../page/bench";

export type Frame = Extract<FromPlayer, { kind: "frame" }>;

/** An action: a built-in file, dials that are turned from where it has them, and the sustain pedal. */
export interface Setup {
  base: string;
  turns?: Record<string, number>;
  /** Changes the file's text beyond what dials can. */
  edit?: (text: string) => string;
  pedal_mm?: number;
  /** Whether its strings sound. */
  sounds?: boolean;
}

/** How firm the fingertip is, N/m: the key follows the finger, and bone is felt at the key's bottom. */
const FIRM_N_PER_M = 3000;
/** How many points a curve has. */
const POINTS = 320;
/** How a stroke that the step plays by itself is called. */
const OWN = "the step\u2019s own stroke";
/** Without an answer for so many frames the worker is taken to hang. */
const PATIENCE = 600;

export class Live {
  private worker!: Worker;
  private readonly bench: Bench;
  private readonly texts = new Map<string, Promise<string>>();
  private loadId = 0;
  private resolve: ((scene: Scene) => void) | null = null;
  private reject: ((error: Error) => void) | null = null;
  private touch: Touch = { kind: "finger", position_m: null, firmness_n_m: FIRM_N_PER_M };
  private needed = false;
  private asked = false;
  private waited = 0;
  private loaded = false;
  slow: Slow[] = [];
  /** What was heard last; for tests. */
  note: Note | null = null;
  /** From when on curves are wanted, s, and for how long at most; null: none are. */
  since: { from_s: number; most_s: number } | null = null;
  private now_s = 0;
  onframe: (frame: Frame) => void = () => {};
  onfault: (message: string) => void = () => {};

  constructor(private readonly module: WebAssembly.Module) {
    this.bench = new Bench(module);
    this.open();
    requestAnimationFrame(this.tick);
  }

  private open(): void {
    this.worker?.terminate();
    this.worker = new Worker(new URL("../engine/player.worker.ts", import.meta.url), { type: "module" });
    this.worker.onmessage = ({ data }: MessageEvent<FromPlayer>) => this.hear(data);
    this.worker.onerror = (event) => this.fail(event.message || "its worker failed");
    this.tell({ kind: "open", module: this.module });
    this.asked = this.loaded = false;
  }

  private tell(message: ToPlayer): void {
    this.worker.postMessage(message);
  }

  private fail(message: string): void {
    this.loaded = false;
    this.reject?.(new Error(message));
    this.onfault(message);
  }

  /** A new worker, with nothing loaded. */
  restart(): void {
    this.open();
  }

  private hear(message: FromPlayer): void {
    if (message.kind === "loaded" && message.id === this.loadId) {
      this.loaded = true;
      this.resolve?.(message.scenes[0]!);
      this.wake();
    } else if (message.kind === "refused" && message.id === this.loadId) this.reject?.(new Error(message.message));
    else if (message.kind === "fault" || message.kind === "no-stroke") this.fail(message.message);
    else if (message.kind === "frame") {
      this.asked = false;
      if (!this.loaded) return;
      this.now_s = message.span[1];
      this.onframe(message);
      if (message.resting && !this.woken) this.needed = false;
    }
  }

  private textOf({ base, turns = {}, edit }: Setup): Promise<string> {
    const key = JSON.stringify([base, turns, edit?.toString()]);
    let text = this.texts.get(key);
    if (!text) {
      text = (async () => {
        const plain = await this.bench.ask<string>({ kind: "base", of: { builtin: base } });
        const turned = Object.keys(turns).length ? await this.bench.ask<string>({ kind: "turned", text: plain, turns }) : plain;
        return edit ? edit(turned) : turned;
      })();
      text.catch(() => this.texts.delete(key));
      this.texts.set(key, text);
    }
    return text;
  }

  /** An action at rest, nobody's finger on it. Rejects where it cannot be loaded; what another call has overtaken never
   * resolves. */
  async load(setup: Setup): Promise<Scene> {
    const id = ++this.loadId;
    this.since = null;
    this.touch = { kind: "finger", position_m: null, firmness_n_m: FIRM_N_PER_M };
    const text = await this.textOf(setup);
    if (id !== this.loadId) return new Promise(() => {});
    this.loaded = false;
    return new Promise((resolve, reject) => {
      [this.resolve, this.reject] = [resolve, reject];
      this.tell({ kind: "pedal", lift_m: 1e-3 * (setup.pedal_mm ?? 0) });
      this.tell({ kind: "load", id, texts: [text], keep: true });
    });
  }

  /** A finger so far below the key's rest, m; null lifts it. */
  press(position_m: number | null): void {
    this.touch = { kind: "finger", position_m, firmness_n_m: FIRM_N_PER_M };
    this.wake();
  }

  /** A finger that presses with so much, N; 0 lets go. */
  push(force_n: number): void {
    this.touch = { kind: "force", force_n };
    this.wake();
  }

  /** Plays a table of times and places of the key. */
  play(csv: string): void {
    this.touch = { kind: "finger", position_m: null, firmness_n_m: FIRM_N_PER_M };
    this.tell({ kind: "stroke", stroke: { csv, name: OWN } });
    this.wake();
  }

  /** Lets a table of forces or places be heard, as it sounds from rest. @returns once it begins, what is heard; a
   * sentence. */
  async listen(setup: Setup, csv: string): Promise<string> {
    const [{ play }, text] = await Promise.all([import("../page/sound"), this.textOf(setup)]);
    const task = { kind: "sound", text, stroke: { csv, name: OWN }, pedal_m: 1e-3 * (setup.pedal_mm ?? 0), seconds: NOTE_S } as const;
    const note = (this.note = await this.bench.ask<Note>(task, "sound"));
    await play([note]);
    return `Heard: ${HEARD[note.unit]}.`;
  }

  stop(): void {
    this.tell({ kind: "stop" });
    this.press(null);
  }

  private woken = false;

  private wake(): void {
    // A clock that stood still does not owe the time since then.
    if (!this.needed) this.tell({ kind: "rest" });
    this.needed = this.woken = true;
  }

  private readonly tick = (now: number): void => {
    requestAnimationFrame(this.tick);
    if (!this.loaded || !this.needed) return;
    if (this.asked) {
      this.waited += 1;
      if (this.waited > PATIENCE) this.fail("it does not answer");
      return;
    }
    this.asked = true;
    this.waited = 0;
    this.woken = false;
    const { since } = this, to = since && Math.min(this.now_s, since.from_s + since.most_s);
    const curves = since && to! > since.from_s ? { from: since.from_s, to: to!, points: POINTS } : null;
    this.tell({ kind: "frame", wall_ms: now, touch: this.touch, at_s: null, curves, pace: 1, slow: this.slow });
  };

  /** What a sheet's lines are for an action; for tests, which hold the text against it. */
  async measure(setup: Setup, lines: string): Promise<Record<string, number>> {
    return this.bench.ask({ kind: "measure", text: await this.textOf(setup), lines });
  }
}
