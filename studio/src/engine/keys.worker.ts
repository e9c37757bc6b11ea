// The worker that owns a whole keyboard: 88 actions, those at rest free of cost.
import { Library, LibraryError } from "./library";
import { READING_BYTES, STEP_S } from "./played";
import type { FromKeys, KeyImpact, Scene, ToKeys } from "./protocol";

/** Never more than this at once, s; and a page that asks for nothing for so long was not looked at. */
const MAX_ADVANCE_S = 0.1, AWAY_S = 0.5;
const MAX_IMPACTS = 256;
const IMPACT_BYTES = 24;
/** Bytes of ErardInput: its size, its kind and six doubles. */
const INPUT_BYTES = 72;
const FREE = 0, FORCE = 1, MOTION = 2;
/** A fingertip's way within a frame is taken in so many steps at a time: a millisecond. */
const STRIDE = 20;
const FASTEST_M_PER_S = 2;
let library: Library;
let keyboard = 0, keys = 0, input = 0, impacts = 0, count = 0, reading = 0, bridge = 0;
let name = "";
/** Whether strings sound: every step is heard at the bridge. */
let sounds = false;
let last_ms: number | null = null;
let owed_s = 0;
/** Time that was not computed, for it would not have been in time, s. */
let late_s = 0;
/** What a passage has still to do, in the order of its time: after how many steps which key is pressed by how much; and
 * the steps since it began. */
let score: { step: number; key: number; force_n: number }[] = [];
let walked: number | null = null;
let shown: { key: number; bodies: number; angles: number } | null = null;
let finger_m: number | null = null;
const say = (message: FromKeys, transfer: Transferable[] = []) => postMessage(message, { transfer });

const open = async (module: WebAssembly.Module, called: string): Promise<void> => {
  const began = performance.now();
  library = await Library.open(module);
  const { raw } = library;
  name = called;
  keyboard = library.made(library.given(name, (at) => raw.erard_keyboard_builtin(at, STEP_S, 0)));
  keys = raw.erard_keyboard_key_count(keyboard);
  input = library.struct(INPUT_BYTES);
  impacts = library.struct(IMPACT_BYTES, MAX_IMPACTS);
  count = raw.erard_memory_new(8);
  reading = library.struct(READING_BYTES);
  bridge = raw.erard_memory_new(8);
  say({ kind: "ready", keys, took_ms: performance.now() - began });
};

const drive = (key: number, kind: number, force: number, position: number, velocity: number): void => {
  library.u32(input + 4, 1)[0] = kind;
  library.f64(input + 8, 6).set([force, position, velocity, 0, 0, 0]);
  check(library.raw.erard_keyboard_drive(keyboard, key, input));
};

/** The key whose action is looked at. */
const show = (key: number): void => {
  const { raw } = library;
  if (shown) {
    if (finger_m !== null) drive(shown.key, FREE, 0, 0, 0);
    raw.erard_memory_free(shown.angles, 8 * shown.bodies);
  }
  finger_m = null;
  const instrument = library.made(library.given(name, (at) => raw.erard_instrument_of_keyboard(at, key, 0)));
  try {
    const scene = library.json<Scene>(raw.erard_instrument_drawing_json(instrument, 0, 0));
    sounds = scene.string !== null;
    shown = { key, bodies: scene.bodies.length, angles: raw.erard_memory_new(8 * scene.bodies.length) };
    say({ kind: "shown", key, scene });
  } finally {
    raw.erard_instrument_free(instrument);
  }
};

/** A passage begins. */
const begin = (turns: [number, number, number][]): void => {
  walked = 0;
  score = turns.map(([time_s, key, force_n]) => ({ step: Math.round(time_s / STEP_S), key, force_n }));
};

const frame = (wall_ms: number, forces: [number, number][], to_m: number | null): void => {
  const { raw } = library;
  const began = performance.now();
  for (const [key, force] of forces) drive(key, force > 0 ? FORCE : FREE, force, 0, 0);
  const passed_s = last_ms === null ? 0 : Math.max(wall_ms - last_ms, 0) / 1e3;
  owed_s += passed_s;
  // A page that was away is not late.
  if (passed_s < AWAY_S) late_s += Math.max(owed_s - MAX_ADVANCE_S, 0);
  owed_s = Math.min(owed_s, MAX_ADVANCE_S);
  last_ms = wall_ms;
  const steps = Math.floor(owed_s / STEP_S + 1e-6);
  owed_s = Math.max(owed_s - steps * STEP_S, 0);
  const bridge_n = new Float32Array(sounds ? steps : 0);
  const struck: KeyImpact[] = [];
  const from_m = finger_m ?? to_m;
  const wanted = to_m === null || from_m === null || !steps ? 0 : (to_m - from_m) / (steps * STEP_S);
  const velocity = Math.min(Math.max(wanted, -FASTEST_M_PER_S), FASTEST_M_PER_S);
  if (shown && to_m === null && finger_m !== null) drive(shown.key, FREE, 0, 0, 0);
  for (let done = 0; done < steps; ) {
    for (; walked !== null && score[0] && score[0].step <= walked; score.shift()) drive(score[0].key, score[0].force_n > 0 ? FORCE : FREE, score[0].force_n, 0, 0);
    const free = Math.min(steps - done, walked !== null && score[0] ? score[0].step - walked : steps);
    const some = sounds ? 1 : to_m === null ? free : Math.min(STRIDE, free);
    if (shown && to_m !== null && from_m !== null) drive(shown.key, MOTION, 0, from_m + velocity * (done + 0.5 * some) * STEP_S, velocity);
    check(raw.erard_keyboard_step(keyboard, some, impacts, MAX_IMPACTS, count));
    const many = Math.min(library.u32(count, 1)[0]!, MAX_IMPACTS);
    for (let n = 0; n < many; n++) {
      const at = impacts + IMPACT_BYTES * n;
      struck.push({ key: library.u32(at + 4, 1)[0]!, hammer_speed_m_per_s: library.f64(at + 16, 1)[0]!, at_s: walked === null ? null : walked * STEP_S });
    }
    if (sounds) {
      check(raw.erard_keyboard_total_bridge_force(keyboard, bridge));
      bridge_n[done] = library.f64(bridge, 1)[0]!;
    }
    done += some;
    if (walked !== null) walked += some;
  }
  finger_m = to_m === null || from_m === null ? null : from_m + velocity * steps * STEP_S;
  const [key_m, hammer_rise_m, finger_force_n] = [new Float32Array(keys), new Float32Array(keys), new Float32Array(keys)];
  for (let key = 1; key <= keys; key++) {
    raw.erard_keyboard_read(keyboard, key, reading);
    const read = library.f64(reading + 8, 6);
    key_m[key - 1] = read[1]!;
    finger_force_n[key - 1] = read[3]!;
    hammer_rise_m[key - 1] = read[5]!;
  }
  let pose: { key: number; angles: Float32Array } | null = null;
  if (shown) {
    check(raw.erard_keyboard_angles(keyboard, shown.key, shown.angles, shown.bodies));
    pose = { key: shown.key, angles: Float32Array.from(library.f64(shown.angles, shown.bodies)) };
  }
  const awake = raw.erard_keyboard_awake_count(keyboard);
  say({ kind: "frame", wall_ms, key_m, hammer_rise_m, finger_force_n, impacts: struck, passage_s: walked === null ? null : walked * STEP_S, awake, steps, cost_ms: performance.now() - began, late_s, shown: pose, bridge_n }, [key_m.buffer, hammer_rise_m.buffer, finger_force_n.buffer, bridge_n.buffer]);
};

const check = (status: number): void => {
  if (status < 0) throw new LibraryError(library.statusText(status));
};

let queue = Promise.resolve();
addEventListener("message", ({ data }: MessageEvent<ToKeys>) => {
  queue = queue
    .then(() => {
      if (data.kind === "open") return open(data.module, data.name);
      if (data.kind === "show") return show(data.key);
      if (data.kind === "pedal") return check(library.raw.erard_keyboard_set_pedal(keyboard, data.lift_m));
      if (data.kind === "passage") return begin(data.turns);
      frame(data.wall_ms, data.forces, data.finger_m);
    })
    .catch((error: unknown) => say({ kind: "fault", message: error instanceof Error ? error.message : String(error) }));
});
