// The player: one or two actions under one finger, on a clock that whoever owns the player moves on. A worker moves it
// with the page's frames; an AudioWorklet would move it with blocks of samples. No messages, no page and no timer here.
import type { Library } from "./library";
import { LibraryError } from "./library";
import { type Drive, Played, STEP_S } from "./played";
import type { Blow, Scene, Stroke, Touch } from "./protocol";
import type { Ring } from "./ring";

/** A page that was away wakes up late: never more than this at once, s. */
const LONGEST_S = 0.1;
/** A force grows and fades over this time, s: what a finger that is already on the key takes. */
const RAMP_S = 0.012;
/** How much a fingertip may move at most, m/s: pointers jump. */
const FASTEST_M_PER_S = 2;

/** Which of the instruments could not be loaded, and why. */
export class LoadError extends Error {
  constructor(readonly which: number, message: string) {
    super(message);
  }
}

export class Player {
  private actions: Played[] = [];
  private spare: Ring[] = [];
  private force_n = 0;
  private finger_m: number | null = null;
  private pressed = false;
  private owed_s = 0;
  private pedal_m = 0;
  /** Whether the pedal was moved since the last steps. */
  private pedalled = false;
  private fresh: Blow[] = [];
  /** Steps since the last time it was asked, and whether anything moved. */
  steps = 0;
  resting = false;
  /** What was last sound: texts, how firm, and states. */
  private good: { texts: string[]; firmness_n_m: number; saved: Uint8Array[] } | null = null;

  constructor(private library: Library) {}

  /** Other instruments, at rest; those that were stay where one of them cannot be had. */
  load(texts: string[], firmness_n_m: number): Scene[] {
    const loaded: Played[] = [];
    texts.forEach((text, which) => {
      try {
        loaded.push(new Played(this.library, text, firmness_n_m, this.spare));
      } catch (error) {
        loaded.forEach((one) => one.free());
        if (error instanceof LibraryError) throw new LoadError(which, error.message);
        throw error;
      }
    });
    this.actions.forEach((one) => one.free());
    this.spare = this.actions.map(({ ring }) => ring);
    this.actions = loaded;
    this.force_n = 0;
    this.finger_m = null;
    this.pressed = false;
    this.owed_s = 0;
    this.fresh = [];
    this.resting = false;
    this.pedalled = this.pedal_m !== 0;
    this.actions.forEach((one) => one.pedal(this.pedal_m));
    this.good = { texts, firmness_n_m, saved: loaded.map((one) => one.save()) };
    return this.scenes;
  }

  get scenes(): Scene[] {
    return this.actions.map((one) => one.scene);
  }

  /** The last good state once more, in a library that has not failed. */
  restore(library: Library): Scene[] {
    const good = this.good;
    this.library = library;
    this.actions = [];
    if (!good) return [];
    const scenes = this.load(good.texts, good.firmness_n_m);
    this.actions.forEach((one, which) => one.restore(good.saved[which]!));
    return scenes;
  }

  /** A stroke begins on all actions. @returns what was done to a recording to make it ready, a line each. */
  begin(stroke: Stroke): string[] {
    this.owed_s = 0;
    this.resting = false;
    return this.actions.map((one) => one.beginStroke("csv" in stroke ? { csv: stroke.csv } : stroke, this.actions[0]!))[0] ?? [];
  }

  /** Sends the sustain pedal's rail to a lift, m. */
  pedal(lift_m: number): void {
    this.pedalled = this.pedalled || lift_m !== this.pedal_m;
    this.pedal_m = lift_m;
    this.actions.forEach((one) => one.pedal(lift_m));
  }

  stop(): void {
    for (const one of this.actions) one.endStroke();
  }

  get striking(): boolean {
    return this.actions.some((one) => one.strokeLeft_s > 0);
  }

  /** Moves the clock on by so much under a touch, which has got from where it was to where it is at an even pace. */
  advance(seconds: number, touch: Touch): void {
    this.owed_s = Math.min(this.owed_s + Math.max(seconds, 0), LONGEST_S);
    const steps = Math.floor(this.owed_s / STEP_S + 1e-6);
    this.owed_s = Math.max(this.owed_s - steps * STEP_S, 0);
    const to = touch.kind === "finger" ? touch.position_m : null;
    const presses = to !== null || (touch.kind === "force" && touch.force_n > 0);
    // A finger ends a stroke that is still played, and begins a press of its own.
    if (presses && !this.pressed) {
      this.stop();
      this.actions.forEach((one) => one.begin());
    }
    const same = touch.kind === "force" ? this.force_n === touch.force_n : to === this.finger_m && this.force_n === 0;
    this.pressed = presses;
    // What rests under what has not changed rests on: its clock stands still, and the last second stays what it was.
    this.resting = steps > 0 && same && !this.pedalled && !this.striking && this.actions.every((one) => one.rests);
    if (this.resting || steps === 0) return;
    this.pedalled = false;
    const from = this.finger_m ?? to;
    const wanted = to === null || from === null ? 0 : (to - from) / (steps * STEP_S);
    const velocity = Math.min(Math.max(wanted, -FASTEST_M_PER_S), FASTEST_M_PER_S);
    const target_n = touch.kind === "force" ? touch.force_n : 0;
    const rate = (Math.max(target_n, this.force_n, 1) * STEP_S) / RAMP_S;
    let force = this.force_n;
    for (let n = 0; n < steps; n++) {
      force += Math.min(Math.max(target_n - force, -rate), rate);
      let drive: Drive = { kind: "free" };
      if (to !== null && from !== null) {
        drive = { kind: "finger", position_m: from + velocity * (n + 0.5) * STEP_S, velocity_m_per_s: velocity };
      } else if (force > 0) drive = { kind: "force", force_n: force };
      this.actions.forEach((one, action) => {
        const before = one.blows;
        one.step(one.strokeLeft_s > 0 ? { kind: "stroke" } : drive);
        if (one.blows !== before) this.fresh.push({ action, time_s: one.time_s, speed_m_per_s: one.hammer_speed_m_per_s });
      });
    }
    this.steps += steps;
    this.force_n = force;
    this.finger_m = to === null || from === null ? null : from + velocity * steps * STEP_S;
    if (this.good) this.good.saved = this.actions.map((one) => one.save());
  }

  /** What was seen since the last time. */
  takeBlows(): Blow[] {
    return this.fresh.splice(0);
  }

  poses(at_s: number | null) {
    return this.actions.map((one) => one.pose(at_s));
  }

  events() {
    return this.actions.map((one) => one.seen());
  }

  get limited(): number {
    return this.actions.reduce((sum, one) => sum + one.limited, 0);
  }

  /** The time that is kept, s. */
  get span(): [number, number] {
    return this.actions[0]?.ring.span ?? [0, 0];
  }

  curves(from: number, to: number, points: number) {
    const times = Float64Array.from({ length: points }, (_, n) => from + ((to - from) * n) / (points - 1));
    return { times, series: this.actions.map((one) => one.curves(times)) };
  }
}
