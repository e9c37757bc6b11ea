// The worker that owns a keyboard and moves it on with the page's frames.
import { Keys } from "./keys";
import { Library } from "./library";
import type { FromKeys, ToKeys } from "./protocol";

/** Never more than this at once, s; and a page that asks for nothing for so long was not looked at. */
const MAX_ADVANCE_S = 0.1, AWAY_S = 0.5;
let keys: Keys;
let step_s = 0;
let last_ms: number | null = null;
let owed_s = 0;
/** Time that was not computed, for it would not have been in time, s. */
let late_s = 0;
const say = (message: FromKeys, transfer: Transferable[] = []) => postMessage(message, { transfer });

const open = async (module: WebAssembly.Module, name: string, length_s: number): Promise<void> => {
  const began = performance.now();
  step_s = length_s;
  keys = new Keys(await Library.open(module), name, step_s, false);
  say({ kind: "ready", keys: keys.count, step_s, took_ms: performance.now() - began });
};

const frame = (wall_ms: number, forces: [number, number][], to_m: number | null): void => {
  const began = performance.now();
  for (const [key, force] of forces) keys.press(key, force);
  const passed_s = last_ms === null ? 0 : Math.max(wall_ms - last_ms, 0) / 1e3;
  owed_s += passed_s;
  // A page that was away is not late.
  if (passed_s < AWAY_S) late_s += Math.max(owed_s - MAX_ADVANCE_S, 0);
  owed_s = Math.min(owed_s, MAX_ADVANCE_S);
  last_ms = wall_ms;
  const steps = Math.floor(owed_s / step_s + 1e-6);
  owed_s = Math.max(owed_s - steps * step_s, 0);
  const bridge_n = new Float32Array(keys.sounds ? steps : 0);
  keys.walk(steps, to_m, keys.sounds ? bridge_n : null);
  const stand = keys.stand();
  say({ kind: "frame", wall_ms, ...stand, steps, cost_ms: performance.now() - began, late_s, bridge_n, sound: null }, [stand.key_m.buffer, stand.hammer_rise_m.buffer, stand.finger_force_n.buffer, bridge_n.buffer]);
};

let queue = Promise.resolve();
addEventListener("message", ({ data }: MessageEvent<ToKeys>) => {
  queue = queue
    .then(() => {
      if (data.kind === "open") return open(data.module, data.name, data.step_s);
      if (data.kind === "show") return say({ kind: "shown", key: data.key, scene: keys.show(data.key) });
      if (data.kind === "pedal") return keys.pedal(data.lift_m);
      if (data.kind === "passage") return keys.begin(data.turns);
      frame(data.wall_ms, data.forces, data.finger_m);
    })
    .catch((error: unknown) => say({ kind: "fault", message: error instanceof Error ? error.message : String(error) }));
});
