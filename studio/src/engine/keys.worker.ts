// The worker that owns a whole keyboard: 88 actions, those at rest free of cost.
import { Library, LibraryError } from "./library";
import { STEP_S } from "./played";
import type { FromKeys, ToKeys } from "./protocol";

const LONGEST_S = 0.1;
const MOST_BLOWS = 256;
const BLOW_BYTES = 24;
const FREE = 0, FORCE = 1;
let library: Library;
let keyboard = 0, keys = 0, input = 0, blows = 0, count = 0, reading = 0;
let last_ms: number | null = null;
let owed_s = 0;
const say = (message: FromKeys, transfer: Transferable[] = []) => postMessage(message, { transfer });

const open = async (module: WebAssembly.Module): Promise<void> => {
  const began = performance.now();
  library = await Library.open(module);
  const { raw } = library;
  keyboard = library.made(raw.erard_keyboard_new(0, 0, STEP_S, 0));
  keys = raw.erard_keyboard_keys(keyboard);
  input = raw.erard_memory_new(32);
  blows = raw.erard_memory_new(BLOW_BYTES * MOST_BLOWS);
  count = raw.erard_memory_new(8);
  reading = raw.erard_memory_new(88);
  say({ kind: "ready", keys, took_ms: performance.now() - began });
};

const frame = (wall_ms: number, forces: [number, number][]): void => {
  const { raw } = library;
  const began = performance.now();
  for (const [key, force] of forces) {
    library.u32(input, 2).set([force > 0 ? FORCE : FREE, 0]);
    library.f64(input + 8, 3).set([force, 0, 0]);
    check(raw.erard_keyboard_drive(keyboard, key, input));
  }
  owed_s = Math.min(owed_s + (last_ms === null ? 0 : Math.max(wall_ms - last_ms, 0) / 1e3), LONGEST_S);
  last_ms = wall_ms;
  const steps = Math.floor(owed_s / STEP_S + 1e-6);
  owed_s = Math.max(owed_s - steps * STEP_S, 0);
  const struck: { key: number; speed_m_s: number }[] = [];
  if (steps > 0) {
    check(raw.erard_keyboard_step(keyboard, steps, blows, MOST_BLOWS, count));
    const many = Math.min(library.u32(count, 1)[0]!, MOST_BLOWS);
    for (let n = 0; n < many; n++) {
      const at = blows + BLOW_BYTES * n;
      struck.push({ key: library.u32(at, 1)[0]!, speed_m_s: library.f64(at + 16, 1)[0]! });
    }
  }
  const [key_m, hammer_m, finger_n] = [new Float32Array(keys), new Float32Array(keys), new Float32Array(keys)];
  for (let key = 1; key <= keys; key++) {
    raw.erard_keyboard_read(keyboard, key, reading);
    const read = library.f64(reading, 6);
    key_m[key - 1] = read[1]!;
    finger_n[key - 1] = read[3]!;
    hammer_m[key - 1] = read[5]!;
  }
  const awake = raw.erard_keyboard_awake(keyboard);
  say({ kind: "frame", wall_ms, key_m, hammer_m, finger_n, blows: struck, awake, steps, cost_ms: performance.now() - began }, [key_m.buffer, hammer_m.buffer, finger_n.buffer]);
};

const check = (status: number): void => {
  if (status < 0) throw new LibraryError(library.statusText(status));
};

let queue = Promise.resolve();
addEventListener("message", ({ data }: MessageEvent<ToKeys>) => {
  queue = queue
    .then(() => (data.kind === "open" ? open(data.module) : frame(data.wall_ms, data.forces)))
    .catch((error: unknown) => say({ kind: "fault", message: error instanceof Error ? error.message : String(error) }));
});
