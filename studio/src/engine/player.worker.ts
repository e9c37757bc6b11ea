// The worker that owns the player. The page's frames are its clock: it asks for a frame, and gets what became of the
// time since the last one.
import { Library } from "./library";
import { LoadError, Player } from "./player";
import type { FromPlayer, Stroke, ToPlayer } from "./protocol";

/** What is wrong with a recording, with its own name in it; a line of a table that is no text is a row below its
 * titles. */
const inFile = (message: string, stroke: Stroke): string =>
  "csv" in stroke ? message.replace(/^recording(:(\d+))?/, (_, line, number) => stroke.name + (!line ? "" : stroke.rows ? `, row ${Number(number) - 1}` : line)) : message;

let module: WebAssembly.Module;
let player: Player | null = null;
let last_ms: number | null = null;
let faulty = false;
const say = (message: FromPlayer, transfer: Transferable[] = []) => postMessage(message, { transfer });

const act = async (message: ToPlayer): Promise<void> => {
  if (message.kind === "open") {
    module = message.module;
    const library = await Library.open(module);
    player = new Player(library);
    // For tests, which break it on purpose.
    Object.assign(self, { player });
    return say({ kind: "ready", version: library.version() });
  }
  if (!player) return;
  if (message.kind === "restore") {
    const scenes = player.restore(await Library.open(module));
    faulty = false;
    last_ms = null;
    return say({ kind: "restored", scenes });
  }
  if (faulty) return;
  switch (message.kind) {
    case "load":
      try {
        say({ kind: "loaded", id: message.id, scenes: player.load(message.texts) });
      } catch (error) {
        if (!(error instanceof LoadError)) throw error;
        say({ kind: "refused", id: message.id, which: error.which, message: error.message });
      }
      return;
    case "stroke":
      try {
        say({ kind: "stroke-begun", told: player.begin(message.stroke, message.other) });
      } catch (error) {
        if (error instanceof WebAssembly.RuntimeError) throw error;
        player.stop();
        say({ kind: "no-stroke", message: inFile((error as Error).message, message.stroke) });
      }
      return;
    case "stop":
      return player.stop();
    case "pedal":
      return player.pedal(message.lift_m);
    case "rest":
      last_ms = null;
      return;
    case "frame": {
      const began = performance.now();
      // Who looks back stops the clock: what is looked at must not be overwritten.
      const passed_s = last_ms === null || message.at_s !== null ? 0 : (message.wall_ms - last_ms) / 1e3;
      last_ms = message.wall_ms;
      const before = player.steps;
      player.advance(passed_s, message.touch, message.pace, message.slow);
      const asked = message.curves;
      const curves = asked && asked.to > asked.from ? player.curves(asked.from, asked.to, asked.points) : null;
      say({
        kind: "frame", wall_ms: message.wall_ms, poses: player.poses(message.at_s), events: player.events(), span: player.span, impacts: player.takeImpacts(),
        resting: player.resting, limited: player.limited, curves, steps: player.steps - before, pace: player.pace, cost_ms: performance.now() - began,
      });
      return;
    }
  }
};

let queue = Promise.resolve();
addEventListener("message", ({ data }: MessageEvent<ToPlayer>) => {
  queue = queue.then(() => act(data)).catch((error: unknown) => {
    faulty = true;
    say({ kind: "fault", message: error instanceof Error ? error.message : String(error) });
  });
});
