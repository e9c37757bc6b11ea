// The player: one or two actions under one finger, on a clock that whoever owns the player moves on. A worker moves it
// with the page's frames. No messages, no page and no timer here.
import type { Library } from "./library";
import { LibraryError } from "./library";
import { type Drive, Played, STEP_S } from "./played";
import type { Impact, Scene, Slow, Stroke, Touch } from "./protocol";
import type { Ring } from "./ring";

/** A page that was away wakes up late: never more than this at once, s. */
const MAX_ADVANCE_S = 0.1;
/** A force grows and fades over this time, s: what a finger that is already on the key takes. */
const RAMP_S = 0.012;
/** How much a fingertip may move at most, m/s: pointers jump. */
const FASTEST_M_PER_S = 2;
/** A hand in slow motion keeps its speed, but is never slower than this, m/s: a mezzo forte. */
const SLOWED_M_PER_S = 0.15;
/** What is left of the hand's speed from one frame to the next where the pointer stands still: pointers move in
 * jumps. */
const HAND = 0.8;

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
  /** How fast the finger moved in real time, m/s. */
  private hand_m_per_s = 0;
  /** The last impact on the first action, s. */
  private impact_s = -Infinity;
  /** Seconds of the action in a second of the page. */
  pace = 1;
  private pressed = false;
  private owed_s = 0;
  private pedal_m = 0;
  /** Whether the pedal was moved since the last steps. */
  private pedalled = false;
  private fresh: Impact[] = [];
  /** Steps since the last time it was asked, and whether anything moved. */
  steps = 0;
  resting = false;
  /** What was last sound: texts, and states. */
  private good: { texts: string[]; saved: Uint8Array[] } | null = null;

  constructor(private library: Library) {}

  /** Replaces the instruments, at rest. If one of them cannot be made, the old ones stay. */
  load(texts: string[]): Scene[] {
    const loaded: Played[] = [];
    texts.forEach((text, which) => {
      try {
        loaded.push(new Played(this.library, text, this.spare));
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
    this.hand_m_per_s = 0;
    this.impact_s = -Infinity;
    this.pace = 1;
    this.resting = false;
    this.pedalled = this.pedal_m !== 0;
    this.actions.forEach((one) => one.pedal(this.pedal_m));
    this.good = { texts, saved: loaded.map((one) => one.save()) };
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
    const scenes = this.load(good.texts);
    this.actions.forEach((one, which) => one.restore(good.saved[which]!));
    return scenes;
  }

  /** A stroke begins on all actions, on others than the first `other`, if there is one. @returns what was done to a
   * recording to make it ready, a line each. */
  begin(stroke: Stroke, other: Stroke | null = null): string[] {
    this.owed_s = this.force_n = 0;
    this.finger_m = null;
    this.impact_s = -Infinity;
    this.fresh = [];
    this.resting = false;
    const told = this.actions.map((one, which) => one.beginStroke(which ? (other ?? stroke) : stroke, this.actions[0]!))[0] ?? [];
    this.actions.forEach((one) => one.pedal(this.pedal_m));
    return told;
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

  /** Moves the clock on by so many seconds of the page under a touch, which has got from where it was to where it is at
   * an even pace. Seconds of the action are `pace` times those, or fewer while one of `slow` holds. In slow motion the
   * hand is slow, too: it keeps the speed that it had in real time. */
  advance(seconds: number, touch: Touch, pace = 1, slow: readonly Slow[] = []): void {
    this.pace = this.paceNow(pace, slow);
    this.owed_s = Math.min(this.owed_s + Math.max(seconds, 0), MAX_ADVANCE_S);
    const to = touch.kind === "finger" ? touch.position_m : null;
    const presses = to !== null || (touch.kind === "force" && touch.force_n > 0);
    // A finger ends a stroke that is still played, and begins a press of its own.
    if (presses && !this.pressed) {
      this.stop();
      this.actions.forEach((one) => one.begin());
    }
    const same = touch.kind === "force" ? this.force_n === touch.force_n : to === this.finger_m && this.force_n === 0;
    this.pressed = presses;
    let moved = false;
    for (;;) {
      const length_s = STEP_S / this.pace;
      const steps = Math.floor(this.owed_s / length_s + 1e-6);
      if (steps === 0) break;
      if (!moved) {
        // What rests under what has not changed rests on: its clock stands still, and the last second stays what it
        // was.
        this.resting = same && !this.pedalled && !this.striking && this.actions.every((one) => one.rests);
        if (this.resting) {
          this.owed_s = Math.max(this.owed_s - steps * length_s, 0);
          return;
        }
        this.pedalled = false;
        moved = true;
      }
      const done = this.walk(steps, to, touch, pace, slow);
      this.owed_s = Math.max(this.owed_s - done * length_s, 0);
    }
    if (!moved) this.resting = false;
    else if (this.good) this.good.saved = this.actions.map((one) => one.save());
  }

  /** So many steps towards where the finger is wanted, or fewer where the pace of time changes on the way. @returns how
   * many. */
  private walk(steps: number, to: number | null, touch: Touch, wanted_pace: number, slow: readonly Slow[]): number {
    const target_n = touch.kind === "force" ? touch.force_n : 0, imposed = touch.kind === "finger" && touch.imposed === true;
    // A fingertip lands where the pointer is; a key front goes on from where it is.
    const from = this.finger_m ?? (imposed && to !== null ? (this.actions[0]?.key_m ?? to) : to);
    const wanted = to === null || from === null ? 0 : (to - from) / (steps * STEP_S);
    const most = this.pace < 1 ? Math.max(this.hand_m_per_s, SLOWED_M_PER_S) : FASTEST_M_PER_S;
    const velocity = Math.min(Math.max(wanted, -most), most);
    if (this.pace === 1) this.hand_m_per_s = Math.max(Math.abs(velocity), HAND * this.hand_m_per_s);
    const rate = (Math.max(target_n, this.force_n, 1) * STEP_S) / RAMP_S;
    let n = 0;
    for (let pace = this.pace; n < steps && pace === this.pace; ) {
      this.force_n += Math.min(Math.max(target_n - this.force_n, -rate), rate);
      let drive: Drive = { kind: "free" };
      if (to !== null && from !== null) {
        // A step takes a finger's place in its middle, a key front's at its end.
        const place_m = (share: number) => from + velocity * (n + share) * STEP_S;
        drive = imposed ? { kind: "imposed", position_m: place_m(1), velocity_m_per_s: velocity } : { kind: "finger", position_m: place_m(0.5), velocity_m_per_s: velocity, firmness_n_m: touch.kind === "finger" ? touch.firmness_n_m : 0 };
      } else if (this.force_n > 0) drive = { kind: "force", force_n: this.force_n };
      this.actions.forEach((one, action) => {
        const before = one.impact_count;
        one.step(one.strokeLeft_s > 0 ? { kind: "stroke" } : drive);
        if (one.impact_count === before) return;
        this.fresh.push({ action, time_s: one.time_s, hammer_speed_m_per_s: one.hammer_speed_m_per_s });
        if (action === 0) this.impact_s = one.time_s;
      });
      n += 1;
      if (slow.length) pace = this.paceNow(wanted_pace, slow);
    }
    this.steps += n;
    this.finger_m = to === null || from === null ? null : from + velocity * n * STEP_S;
    if (slow.length) this.pace = this.paceNow(wanted_pace, slow);
    return n;
  }

  /** How slowly time runs now. */
  private paceNow(pace: number, slow: readonly Slow[]): number {
    const one = this.actions[0];
    if (!one) return pace;
    for (const rule of slow) {
      if (rule.pace >= pace) continue;
      if (rule.of === "impact") {
        if (one.time_s - this.impact_s < rule.for_s) pace = rule.pace;
        continue;
      }
      const key = rule.of === "key", at = key ? one.key_m : one.hammer_rise_m, speed = key ? one.key_m_per_s : one.hammer_rise_m_per_s;
      const fast = rule.going ? rule.going * speed : Math.abs(speed);
      if (at >= rule.from_m && at <= rule.to_m && fast >= rule.least_m_per_s) pace = rule.pace;
    }
    return pace;
  }

  /** What was seen since the last time. */
  takeImpacts(): Impact[] {
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
