// The processor that owns a keyboard whose strings sound, and moves it on with blocks of samples: what is heard is the
// pressure at two places before the soundboard, at a fixed gain; where none moves, the force of all strings on the
// bridge, less that at rest.
import { Keys } from "./keys";
import { Library } from "./library";
import { type FromKeys, FULL_SCALE, type ToKeys, type Unit } from "./protocol";

declare const sampleRate: number;
declare const currentTime: number;
declare class AudioWorkletProcessor {
  readonly port: MessagePort;
}
declare const registerProcessor: (name: string, processor: new (node: { processorOptions: Options }) => AudioWorkletProcessor) => void;

/** `turns`: a passage that begins at once (for tests, which cannot send messages in time). `exact`: as the command
 * computes it, however long a block takes. */
export interface Options {
  module: WebAssembly.Module;
  name: string;
  turns: [number, number, number][];
  exact: boolean;
}

/** Two samples are a step: the usual length where strings sound, at 48 kHz. */
const SAMPLES = 2;
/** Samples between the steps are interpolated from so many steps on either side; the steps themselves stay as they are,
 * so many steps late. */
const SIDE = 8;
/** A pointer is heard of as often as this, s. */
const FRAME_S = 1 / 60;
/** The last forces that are kept for the page, s. */
const KEPT_S = 0.1;
/** Sound that is later than the clock by this much more than before has broken off, s; browsers hand over blocks by the
 * dozen. And how fast the two clocks may drift, as a share of their distance a block. */
const BROKEN_S = 0.05, DRIFT = 1e-3;

/** Weights of the steps on one side of a sample between two: a sinc under a Hann window, of sum 1/2. */
const weights = (): number[] => {
  const all = Array.from({ length: SIDE }, (_, n) => {
    const x = Math.PI * (n + 0.5);
    return (Math.sin(x) / x) * (0.5 + 0.5 * Math.cos(x / SIDE));
  });
  const sum = 2 * all.reduce((a, b) => a + b);
  return all.map((one) => one / sum);
};

class Sound extends AudioWorkletProcessor {
  private readonly keys: Keys;
  private readonly step_s = SAMPLES / sampleRate;
  private readonly unit: Unit;
  /** What is there at rest, which is not heard, N or Pa. */
  private readonly rest: number;
  private readonly weights = weights();
  /** What was heard after the last steps, left and right: twice the side, the oldest first. */
  private readonly past = [new Float64Array(2 * SIDE), new Float64Array(2 * SIDE)];
  private places = [new Float64Array(), new Float64Array()];
  private block = new Float64Array();
  private kept: number[] = [];
  private finger: { now_m: number; to_m: number; left_s: number } | null = null;
  private steps = 0;
  private spent_ms = 0;
  private peak = 0;
  private clipped = 0;
  private dropouts = 0;
  private lost_s = 0;
  private behind_s: number | null = null;
  private failed = false;

  constructor({ processorOptions: { module, name, turns, exact } }: { processorOptions: Options }) {
    super();
    const began = Date.now();
    this.keys = new Keys(new Library(new WebAssembly.Instance(module, {})), name, this.step_s, exact);
    this.unit = this.keys.radiates ? "Pa" : "N";
    this.rest = this.keys.radiates ? 0 : this.keys.bridge_n();
    if (turns.length) this.keys.begin(turns);
    this.port.onmessage = ({ data }: MessageEvent<ToKeys>) => this.guarded(() => this.take(data));
    this.say({ kind: "ready", keys: this.keys.count, step_s: this.step_s, took_ms: Date.now() - began });
  }

  private say(message: FromKeys): void {
    this.port.postMessage(message);
  }

  /** What fails is said once, and is silent from then on. */
  private guarded(work: () => void): void {
    if (this.failed) return;
    try {
      work();
    } catch (error) {
      this.failed = true;
      this.say({ kind: "fault", message: error instanceof Error ? error.message : String(error) });
    }
  }

  private take(data: ToKeys): void {
    if (data.kind === "show") this.say({ kind: "shown", key: data.key, scene: this.keys.show(data.key) });
    else if (data.kind === "pedal") this.keys.pedal(data.lift_m);
    else if (data.kind === "passage") this.keys.begin(data.turns);
    else if (data.kind === "frame") {
      for (const [key, force] of data.forces) this.keys.press(key, force);
      const to_m = data.finger_m;
      this.finger = to_m === null ? null : { now_m: this.finger?.now_m ?? to_m, to_m, left_s: FRAME_S };
      const bridge_n = Float32Array.from(this.kept), { steps, spent_ms, unit, peak, clipped, dropouts, lost_s } = this;
      this.kept = [];
      this.steps = this.spent_ms = this.peak = this.clipped = 0;
      this.say({ kind: "frame", wall_ms: data.wall_ms, ...this.keys.stand(), steps, cost_ms: spent_ms, late_s: lost_s, bridge_n, sound: { unit, peak, clipped, dropouts, lost_s } });
    }
  }

  /** Whether the sound has fallen behind the clock since the block before. */
  private listen(): void {
    const behind_s = Date.now() / 1e3 - currentTime;
    const before_s = Math.min(this.behind_s ?? behind_s, behind_s);
    if (behind_s > before_s + BROKEN_S) {
      this.dropouts += 1;
      this.lost_s += behind_s - before_s;
      this.behind_s = behind_s;
    } else this.behind_s = before_s + DRIFT * (behind_s - before_s);
  }

  process(_: Float32Array[][], [channels]: [Float32Array[]]): boolean {
    this.listen();
    this.guarded(() => this.fill(channels));
    return !this.failed;
  }

  private fill(channels: Float32Array[]): void {
    const { keys, past, weights, finger, step_s } = this;
    const began = Date.now(), steps = channels[0]!.length / SAMPLES;
    if (this.block.length !== steps) [this.block, this.places] = [new Float64Array(steps), [new Float64Array(steps), new Float64Array(steps)]];
    if (finger) {
      finger.now_m += (finger.to_m - finger.now_m) * Math.min((steps * step_s) / Math.max(finger.left_s, 1e-9), 1);
      finger.left_s -= steps * step_s;
    }
    keys.walk(steps, finger ? finger.now_m : null, this.block, this.places);
    this.kept.push(...this.block);
    for (const [channel, out] of channels.entries()) {
      const own = past[channel]!, heard = this.places[channel]!;
      for (let step = 0; step < steps; step++) {
        own.copyWithin(0, 1);
        own[2 * SIDE - 1] = heard[step]! - this.rest;
        let between = 0;
        for (let n = 0; n < SIDE; n++) between += weights[n]! * (own[SIDE - 1 - n]! + own[SIDE + n]!);
        for (const [at, n] of [[2 * step, own[SIDE - 1]!], [2 * step + 1, between]] as const) {
          const sample = n / FULL_SCALE[this.unit], loud = Math.abs(sample);
          this.peak = Math.max(this.peak, loud);
          if (loud > 1) this.clipped += 1;
          out[at] = Math.min(Math.max(sample, -1), 1);
        }
      }
    }
    const most = Math.round(KEPT_S / step_s);
    if (this.kept.length > most) this.kept.splice(0, this.kept.length - most);
    this.steps += steps;
    this.spent_ms += Date.now() - began;
  }
}
registerProcessor("erard-keys", Sound);
