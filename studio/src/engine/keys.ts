// A whole keyboard: 88 actions, those at rest free of cost. Whoever owns it moves its clock on: a worker with the
// page's frames, an AudioWorklet with blocks of samples. No messages, no page and no timer here.
import { type Library, LibraryError } from "./library";
import { READING_BYTES } from "./played";
import type { KeyImpact, Scene, Stand } from "./protocol";

const MAX_IMPACTS = 256;
const IMPACT_BYTES = 24;
/** Bytes of ErardInput: its size, its kind and six doubles. */
const INPUT_BYTES = 72;
const FREE = 0, FORCE = 1, MOTION = 2;
/** ERARD_HALVING_FEWER: a step near the strings takes a third of the time; the error is in `docs/notes/speed.md`. */
const FEWER = 2;
/** A fingertip's way is taken in so many seconds at a time. */
const STRIDE_S = 1e-3;
const FASTEST_M_PER_S = 2;

export class Keys {
  readonly count: number;
  private readonly keyboard: number;
  private readonly input: number;
  private readonly impacts: number;
  private readonly many: number;
  private readonly reading: number;
  private readonly bridge: number;
  private readonly pressure: number;
  /** Whether the keys have modal strings, and whether these move a soundboard. */
  readonly sounds: boolean;
  readonly radiates: boolean;
  /** What a passage has still to do, in the order of its time: after how many steps which key is pressed by how much;
   * and the steps since it began. */
  private score: { step: number; key: number; force_n: number }[] = [];
  private walked: number | null = null;
  private shown: { key: number; bodies: number; angles: number } | null = null;
  private finger_m: number | null = null;
  private struck: KeyImpact[] = [];

  /** @param name a built-in keyboard. @param step_s length of a step, s. @param exact whether blows are computed as
   * exactly as the command does; else so that none is late. */
  constructor(private readonly library: Library, private readonly name: string, private readonly step_s: number, exact: boolean) {
    const { raw } = library;
    this.keyboard = library.made(library.given(name, (at) => raw.erard_keyboard_builtin(at, step_s, 0)));
    this.count = raw.erard_keyboard_key_count(this.keyboard);
    this.input = library.struct(INPUT_BYTES);
    this.impacts = library.struct(IMPACT_BYTES, MAX_IMPACTS);
    this.many = raw.erard_memory_new(8);
    this.reading = library.struct(READING_BYTES);
    this.bridge = raw.erard_memory_new(8);
    this.pressure = raw.erard_memory_new(16);
    // Dampers at rest press on modal strings.
    this.sounds = this.bridge_n() !== 0;
    this.radiates = raw.erard_keyboard_pressure(this.keyboard, this.pressure) === 0;
    if (this.sounds && !exact) this.check(raw.erard_keyboard_set_halving(this.keyboard, FEWER));
  }

  private check(status: number): void {
    if (status < 0) throw new LibraryError(this.library.statusText(status));
  }

  private drive(key: number, kind: number, force: number, position: number, velocity: number): void {
    this.library.u32(this.input + 4, 1)[0] = kind;
    this.library.f64(this.input + 8, 6).set([force, position, velocity, 0, 0, 0]);
    this.check(this.library.raw.erard_keyboard_drive(this.keyboard, key, this.input));
  }

  /** Presses a key with so much, N; 0 lets it go. */
  press(key: number, force_n: number): void {
    this.drive(key, force_n > 0 ? FORCE : FREE, force_n, 0, 0);
  }

  pedal(lift_m: number): void {
    this.check(this.library.raw.erard_keyboard_set_pedal(this.keyboard, lift_m));
  }

  /** The key whose action is looked at. @returns how it is drawn. */
  show(key: number): Scene {
    const { library } = this, { raw } = library;
    if (this.shown) {
      if (this.finger_m !== null) this.press(this.shown.key, 0);
      raw.erard_memory_free(this.shown.angles, 8 * this.shown.bodies);
    }
    this.finger_m = null;
    const instrument = library.made(library.given(this.name, (at) => raw.erard_instrument_of_keyboard(at, key, 0)));
    try {
      const scene = library.json<Scene>(raw.erard_instrument_drawing_json(instrument, 0, 0));
      this.shown = { key, bodies: scene.bodies.length, angles: raw.erard_memory_new(8 * scene.bodies.length) };
      return scene;
    } finally {
      raw.erard_instrument_free(instrument);
    }
  }

  /** A passage begins: when, s from now, which key, and the force, N. */
  begin(turns: [number, number, number][]): void {
    this.walked = 0;
    this.score = turns.map(([time_s, key, force_n]) => ({ step: Math.round(time_s / this.step_s), key, force_n }));
  }

  /** The present force of all strings on the bridge, N. */
  bridge_n(): number {
    this.check(this.library.raw.erard_keyboard_total_bridge_force(this.keyboard, this.bridge));
    return this.library.f64(this.bridge, 1)[0]!;
  }

  /** So many steps, in which a fingertip on the key that is shown gets evenly to where it is wanted, m (null: lifted).
   * Where strings sound, `bridge` receives their force on the bridge after each step, N, and `places` the pressure at
   * two places before the soundboard, Pa (the force, where none moves). */
  walk(steps: number, to_m: number | null, bridge: { [step: number]: number } | null, places: readonly { [step: number]: number }[] = []): void {
    const { library, step_s, shown } = this, { raw } = library;
    const from_m = this.finger_m ?? to_m, stride = Math.max(Math.round(STRIDE_S / step_s), 1);
    const wanted = to_m === null || from_m === null || !steps ? 0 : (to_m - from_m) / (steps * step_s);
    const velocity = Math.min(Math.max(wanted, -FASTEST_M_PER_S), FASTEST_M_PER_S);
    const each = this.sounds && bridge !== null;
    if (shown && to_m === null && this.finger_m !== null) this.press(shown.key, 0);
    for (let done = 0; done < steps; ) {
      for (; this.walked !== null && this.score[0] && this.score[0].step <= this.walked; this.score.shift()) this.press(this.score[0].key, this.score[0].force_n);
      const free = Math.min(steps - done, this.walked !== null && this.score[0] ? this.score[0].step - this.walked : steps);
      const some = each ? 1 : to_m === null ? free : Math.min(stride, free);
      if (shown && to_m !== null && from_m !== null) this.drive(shown.key, MOTION, 0, from_m + velocity * (done + 0.5 * some) * step_s, velocity);
      this.check(raw.erard_keyboard_step(this.keyboard, some, this.impacts, MAX_IMPACTS, this.many));
      const many = Math.min(library.u32(this.many, 1)[0]!, MAX_IMPACTS);
      for (let n = 0; n < many; n++) {
        const at = this.impacts + IMPACT_BYTES * n;
        this.struck.push({ key: library.u32(at + 4, 1)[0]!, hammer_speed_m_per_s: library.f64(at + 16, 1)[0]!, at_s: this.walked === null ? null : this.walked * step_s });
      }
      if (each) {
        const force_n = (bridge[done] = this.bridge_n());
        if (this.radiates && places.length) this.check(raw.erard_keyboard_pressure(this.keyboard, this.pressure));
        for (const [place, numbers] of places.entries()) numbers[done] = this.radiates ? library.f64(this.pressure, 2)[place]! : force_n;
      }
      done += some;
      if (this.walked !== null) this.walked += some;
    }
    this.finger_m = to_m === null || from_m === null ? null : from_m + velocity * steps * step_s;
  }

  stand(): Stand {
    const { library, count, reading, shown } = this, { raw } = library;
    const [key_m, hammer_rise_m, finger_force_n] = [new Float32Array(count), new Float32Array(count), new Float32Array(count)];
    for (let key = 1; key <= count; key++) {
      raw.erard_keyboard_read(this.keyboard, key, reading);
      const read = library.f64(reading + 8, 6);
      key_m[key - 1] = read[1]!;
      finger_force_n[key - 1] = read[3]!;
      hammer_rise_m[key - 1] = read[5]!;
    }
    let pose: Stand["shown"] = null;
    if (shown) {
      this.check(raw.erard_keyboard_angles(this.keyboard, shown.key, shown.angles, shown.bodies));
      pose = { key: shown.key, angles: Float32Array.from(library.f64(shown.angles, shown.bodies)) };
    }
    const impacts = this.struck;
    this.struck = [];
    return { key_m, hammer_rise_m, finger_force_n, impacts, passage_s: this.walked === null ? null : this.walked * this.step_s, awake: raw.erard_keyboard_awake_count(this.keyboard), shown: pose };
  }
}
