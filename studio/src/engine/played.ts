// One action that is played: stepped, watched, and its last second kept.
import { type Library, LibraryError } from "./library";
import { Ring } from "./ring";
import type { Events, Pose, Scene, Stroke } from "./protocol";

/** Length of a step, s: `erard press` takes the same. */
export const STEP_S = 50e-6;
/** What is kept, s: the last second, and enough before it that a press which swings out for long is still there from
 * its beginning. */
const KEPT_S = 3;
/** Bytes of ErardReading and ErardEvents: a size, a reserved number, then the doubles. */
export const READING_BYTES = 112;
const EVENTS_BYTES = 80;
const NUMBERS_AT = 8;
const EVENTS = [
  "key_start_s", "toe_contact_s", "let_off_s", "hammer_contact_s", "hammer_speed_m_per_s", "key_bottom_s", "check_s", "free_flight_s", "key_bottom_after_impact_s",
] as const;

/** What drives a key in a step. */
export type Drive =
  | { kind: "free" }
  | { kind: "force"; force_n: number }
  | { kind: "finger"; position_m: number; velocity_m_per_s: number; firmness_n_m: number }
  | { kind: "imposed"; position_m: number; velocity_m_per_s: number }
  | { kind: "stroke" };

/** A fingertip's damping over its stiffness, s: as in the built-in files. */
const TIP_S = 1e-3;
/** How far back a string's swing is looked at, rows: 20 ms, five periods of middle C. */
const SWING_ROWS = 400;
/** Numbers at the head of a row of the ring: then the angles, then five of every zone, then the string's shape. */
const HEAD = 5;

export class Played {
  readonly scene: Scene;
  readonly ring: Ring;
  private readonly instrument: number;
  private readonly action: number;
  private readonly detector: number;
  private readonly reading: number;
  private readonly events: number;
  private readonly numbers: number;
  private readonly bodies: number;
  private readonly zones: number;
  private readonly places: number;
  private readonly shape: number;
  private stroke = 0;
  strokeLeft_s = 0;
  private impactsBefore = 0;
  /** Steps that reached an iteration limit. */
  limited = 0;

  /** @param spare rings that nobody uses any more: twenty megabytes each, which a slider that is dragged would else ask
   * for many times a second. */
  constructor(private readonly library: Library, text: string, spare: Ring[]) {
    const { raw } = library;
    this.instrument = library.made(library.given(text, (at, length) => raw.erard_instrument_new(at, length, 0)));
    this.reading = library.struct(READING_BYTES);
    this.events = library.struct(EVENTS_BYTES);
    try {
      this.scene = library.json<Scene>(raw.erard_instrument_drawing_json(this.instrument, 0, 0));
      this.action = library.made(raw.erard_action_of_instrument(this.instrument, STEP_S, 0));
    } catch (error) {
      raw.erard_instrument_free(this.instrument);
      throw error;
    }
    this.detector = library.made(raw.erard_event_detector_new(this.instrument, 0));
    library.done(raw.erard_action_record_contacts(this.action));
    this.bodies = raw.erard_action_body_count(this.action);
    this.zones = raw.erard_action_zone_count(this.action);
    this.numbers = raw.erard_memory_new(8 * (this.bodies + 5 * this.zones));
    this.places = raw.erard_action_string_places(this.action, 0, 0);
    this.shape = raw.erard_memory_new(8 * Math.max(this.places, 1));
    raw.erard_action_string_places(this.action, this.shape, this.places);
    this.scene.places_m = [...library.f64(this.shape, this.places)];
    const width = HEAD + this.bodies + 5 * this.zones + this.places, fits = spare.findIndex((ring) => ring.width === width);
    this.ring = fits >= 0 ? spare.splice(fits, 1)[0]! : new Ring(width, Math.round(KEPT_S / STEP_S));
    this.ring.clear();
    library.done(raw.erard_action_read(this.action, this.reading));
    this.keep();
  }

  free(): void {
    const { raw } = this.library;
    this.endStroke();
    raw.erard_event_detector_free(this.detector);
    raw.erard_action_free(this.action);
    raw.erard_instrument_free(this.instrument);
    raw.erard_memory_free(this.reading, READING_BYTES);
    raw.erard_memory_free(this.events, EVENTS_BYTES);
    raw.erard_memory_free(this.numbers, 8 * (this.bodies + 5 * this.zones));
    raw.erard_memory_free(this.shape, 8 * Math.max(this.places, 1));
  }

  /** A press begins: its instants are looked for. */
  begin(): void {
    this.impactsBefore = this.impact_count;
    this.library.done(this.library.raw.erard_event_detector_reset(this.detector));
    this.library.done(this.library.raw.erard_event_detector_observe(this.detector, this.action));
  }

  /** A stroke begins, from rest, as `erard press` plays it: what still moved is at rest, and the clock at 0. The hand
   * of a level is the one that reaches it on `reference`, so that two actions that are compared are played by one hand.
   * @returns what was done to a recording to make it ready, a line each. */
  beginStroke(stroke: Stroke, reference: Played): string[] {
    const { raw } = this.library;
    this.endStroke();
    this.stroke = this.library.stroke(this.instrument, stroke, reference.instrument);
    this.strokeLeft_s = raw.erard_stroke_duration(this.stroke);
    this.library.done(raw.erard_action_reset(this.action));
    raw.erard_action_read(this.action, this.reading);
    this.ring.clear();
    this.keep();
    this.begin();
    return this.library.taken(raw.erard_stroke_remarks(this.stroke, 0, 0)).split("\n").filter((line) => line);
  }

  /** Sends the rail that the sustain pedal lifts to a lift, m. */
  pedal(lift_m: number): void {
    this.library.done(this.library.raw.erard_action_set_pedal(this.action, lift_m));
  }

  endStroke(): void {
    if (this.stroke) this.library.raw.erard_stroke_free(this.stroke);
    this.stroke = 0;
    this.strokeLeft_s = 0;
  }

  /** One step, kept and watched. */
  step(drive: Drive): void {
    const { raw } = this.library;
    let status: number;
    if (drive.kind === "finger") status = raw.erard_action_step_fingertip(this.action, drive.position_m, drive.velocity_m_per_s, drive.firmness_n_m, TIP_S * drive.firmness_n_m, this.reading);
    else if (drive.kind === "imposed") status = raw.erard_action_step_rigid(this.action, drive.position_m, drive.velocity_m_per_s, this.reading);
    else if (drive.kind === "force") status = raw.erard_action_step_force(this.action, drive.force_n, this.reading);
    else if (drive.kind === "stroke" && this.stroke) {
      status = raw.erard_action_step_stroke(this.action, this.stroke, this.reading);
      this.strokeLeft_s -= STEP_S;
      if (this.strokeLeft_s <= 0) this.endStroke();
    } else status = raw.erard_action_step_free(this.action, this.reading);
    if (status < 0) throw new LibraryError(this.library.statusText(status));
    this.limited += status > 0 ? 1 : 0;
    raw.erard_event_detector_observe(this.detector, this.action);
    this.keep();
  }

  private keep(): void {
    const { library, bodies, zones, numbers } = this;
    library.raw.erard_action_angles(this.action, numbers, bodies);
    library.raw.erard_action_contacts(this.action, numbers + 8 * bodies, 5 * zones);
    const [time, key, , finger, , hammer, speed, string] = this.readings(10) as unknown as number[];
    const row = this.ring.push(time!);
    row[0] = key!;
    row[1] = hammer!;
    row[2] = finger!;
    row[3] = string!;
    row[4] = speed!;
    row.set(library.f64(numbers, bodies + 5 * zones), HEAD);
    if (!this.places) return;
    library.raw.erard_action_string_shape(this.action, this.shape, this.places);
    row.set(library.f32(this.shape, this.places), HEAD + bodies + 5 * zones);
  }

  get rests(): boolean {
    return this.library.raw.erard_action_is_asleep(this.action) === 1;
  }

  /** The first doubles of the reading. */
  private readings(count: number): Float64Array {
    return this.library.f64(this.reading + NUMBERS_AT, count);
  }

  get time_s(): number {
    return this.readings(1)[0]!;
  }

  get impact_count(): number {
    return this.library.u32(this.reading + NUMBERS_AT + 80, 1)[0]!;
  }

  get hammer_speed_m_per_s(): number {
    return this.readings(10)[9]!;
  }

  /** Speed of the key's front, m/s, down. */
  get key_m_per_s(): number {
    return this.readings(3)[2]!;
  }

  get hammer_rise_m(): number {
    return this.readings(6)[5]!;
  }

  /** Speed of the hammer's strike point now, m/s, up. */
  get hammer_rise_m_per_s(): number {
    return this.readings(7)[6]!;
  }

  get key_m(): number {
    return this.readings(2)[1]!;
  }

  get peakFinger_n(): number {
    return this.readings(4)[3]!;
  }

  seen(): Events {
    this.library.done(this.library.raw.erard_event_detector_read(this.detector, this.events));
    const values = this.library.f64(this.events + NUMBERS_AT, EVENTS.length);
    const impact_count = this.impact_count - this.impactsBefore;
    return { ...(Object.fromEntries(EVENTS.map((name, index) => [name, values[index]!])) as unknown as Events), impact_count };
  }

  /** How it stood at a time, straight between rows; now where none is given. */
  pose(time: number | null): Pose {
    const { ring, bodies, zones } = this, last = HEAD + bodies + 5 * zones;
    const index = time === null ? ring.length - 1 : ring.find(time);
    const row = ring.row(index), next = ring.row(Math.min(index + 1, ring.length - 1));
    const from = ring.timeOf(index), to = ring.timeOf(Math.min(index + 1, ring.length - 1));
    const share = time === null || to <= from ? 0 : Math.min(Math.max((time - from) / (to - from), 0), 1);
    const mixed = Float32Array.from(row, (value, k) => value + share * (next[k]! - value));
    // A contact that is in one of the two rows only keeps its place and direction.
    for (let k = HEAD + bodies; k < last; k += 5) {
      const known = row[k]! > 0 ? row : next;
      if (!(row[k]! > 0 && next[k]! > 0)) for (let j = 1; j < 5; j++) mixed[k + j] = known[k + j]!;
    }
    return {
      time_s: time === null ? from : from + share * (to - from),
      key_m: mixed[0]!, hammer_rise_m: mixed[1]!, finger_force_n: mixed[2]!, string_n: mixed[3]!, hammer_rise_m_per_s: mixed[4]!,
      angles: mixed.slice(HEAD, HEAD + bodies),
      contacts: mixed.slice(HEAD + bodies, last),
      string: mixed.slice(last),
      swing_m: this.swing(index),
    };
  }

  /** How much the string swings about its mean over the last rows before one, m. */
  private swing(index: number): number {
    const { ring, places } = this, first = ring.width - places, from = Math.max(index + 1 - SWING_ROWS, 0);
    if (!places || index - from < SWING_ROWS / 4) return 0;
    let squares = 0;
    for (let place = first; place < ring.width; place++) {
      let sum = 0, square = 0;
      for (let k = from; k <= index; k++) {
        const value = ring.at(k, place);
        sum += value;
        square += value * value;
      }
      squares += square - (sum * sum) / (index + 1 - from);
    }
    return Math.sqrt(Math.max(squares, 0) / (places * (index + 1 - from)));
  }

  /** Key (mm), hammer (mm), finger (N) and string (N) at so many instants; of forces the largest since the instant
   * before, so that no impact is lost. */
  curves(times: Float64Array): Float64Array[] {
    const out = [0, 1, 2, 3].map(() => new Float64Array(times.length).fill(NaN));
    const [first, last] = this.ring.span;
    let before = -1;
    times.forEach((time, n) => {
      if (time < first - 1e-9 || time > last + 1e-9) return;
      const index = this.ring.find(time);
      out[0]![n] = 1e3 * this.ring.at(index, 0);
      out[1]![n] = 1e3 * this.ring.at(index, 1);
      let finger = this.ring.at(index, 2), string = this.ring.at(index, 3);
      for (let k = before + 1; before >= 0 && k < index; k++) {
        finger = Math.max(finger, this.ring.at(k, 2));
        string = Math.max(string, this.ring.at(k, 3));
      }
      out[2]![n] = finger;
      out[3]![n] = string;
      before = index;
    });
    return out;
  }

  save(): Uint8Array<ArrayBuffer> {
    const { raw } = this.library;
    const size = raw.erard_memory_new(8);
    raw.erard_action_save(this.action, 0, size);
    const bytes = this.library.u32(size, 1)[0]!;
    const at = raw.erard_memory_new(bytes);
    const status = raw.erard_action_save(this.action, at, size);
    const saved = this.library.bytes(at, bytes).slice();
    raw.erard_memory_free(at, bytes);
    raw.erard_memory_free(size, 8);
    this.library.done(status);
    return saved as Uint8Array<ArrayBuffer>;
  }

  restore(saved: Uint8Array): void {
    const { raw } = this.library;
    const at = raw.erard_memory_new(saved.length);
    this.library.bytes(at, saved.length).set(saved);
    const status = raw.erard_action_restore(this.action, at, saved.length);
    raw.erard_memory_free(at, saved.length);
    this.library.done(status);
    raw.erard_action_read(this.action, this.reading);
    this.ring.clear();
    this.keep();
  }
}
