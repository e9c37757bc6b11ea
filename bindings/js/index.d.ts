/** The grand piano action, simulated. SI units, as each name says; key and finger positive downward, the hammer upward.
 * The same source as the command `erard`, and the same bits. */

/** What a call refuses, with the library's own words: names what was found and what is expected. */
export class ErardError extends Error {}

/** Length of a step, s, that `erard press` takes: 50 us. */
export const STEP_S: number;

/** Names of a reading's numbers that the C interface's `ErardReading` has as its first doubles, in order. */
export const READING: readonly (keyof Reading)[];

export interface Reading {
  /** The present instant, s from the action's creation or its last reset. */
  time_s: number;
  /** Travel of the key front, m, down positive. */
  key_m: number;
  /** Velocity of the key front, m/s, down positive. */
  key_m_per_s: number;
  /** Force of the finger on the key in the last step, N, down positive. */
  finger_force_n: number;
  /** Mean of that force over the steps of the last call, N; each call here takes one. */
  finger_force_mean_n: number;
  /** Rise of the hammer's strike point, m, up positive. */
  hammer_rise_m: number;
  /** Velocity of that point, m/s, up positive. */
  hammer_rise_m_per_s: number;
  /** Force between hammer and string, N, never negative. */
  string_n: number;
  /** Instant of the last impact on the string, s; 0 before the first. */
  impact_time_s: number;
  /** Speed of the strike point at that impact, m/s; 0 before the first. */
  hammer_speed_m_per_s: number;
  /** Impacts since the action was made or reset. */
  impact_count: number;
  /** Impacts in the last step. */
  new_impact_count: number;
  /** Position of a hand, m below the key front's rest. */
  hand_m: number;
  /** Velocity of a hand, m/s, down positive. */
  hand_m_per_s: number;
}

/** What `Engine.check` says of a file; lines and columns begin at 1. */
export interface Checked {
  kind: string | null;
  sound: boolean;
  name: string | null;
  errors: { line: number; column: number; key: string | null; message: string; found: string | null; expected: string | null; text: string }[];
}

/** Compiles the engine and opens it. In Node and with bundlers that know `import.meta.url` it lies beside this module;
 * `source` is another address, the bytes of `erard.wasm`, or a compiled module. Every engine has memory of its own: one
 * for each worker. */
export function open(source?: string | URL | BufferSource | WebAssembly.Module): Promise<Engine>;

export class Engine {
  /** The library's version, "0.1.0". */
  readonly version: string;
  /** Every function of the C interface, for what these classes leave out. Addresses and sizes are numbers. */
  readonly raw: WebAssembly.Exports & { memory: WebAssembly.Memory };
  /** The names of the built-in instruments and keyboards. */
  names(): { instruments: string[]; keyboards: string[] };
  /** A built-in instrument; with `key` (1 to 88), that key of a built-in keyboard. */
  instrument(name?: string, key?: number): Instrument;
  /** The instrument of a file's text. */
  read(text: string): Instrument;
  /** Checks the text of an instrument or keyboard file. */
  check(text: string): Checked;
}

export class Instrument {
  /** The text of its file, as it is now. */
  readonly text: string;
  /** A copy with changes, each as `--vary` takes it: `{ let_off: "-1 mm", "body.hammer.mass": "+0.8 g" }`. */
  vary(changes: Record<string, string>): Instrument;
  /** The technician's sheet, measured: all of it, or the values of the lines that are named ("down_weight_g"). `key` (1
   * to 88) is the piano key whose usual ranges hold; 0 is the instrument's own. Takes tenths of a second to seconds. */
  measure(): Record<string, unknown>;
  measure(lines: undefined, key: number): Record<string, unknown>;
  measure(lines: string[], key?: number): Record<string, number | null>;
  /** A drawing at rest: SVG, `size_px` wide. */
  draw(size_px?: number): string;
  /** A press from rest: a level ("pp", "p", "mf", "f", "ff"; `struck` from above the key), or a recording, the text of
   * a CSV file with a column for the time and one for force or position. `csv` is the run.csv of `erard press`;
   * `remarks` say what was done to a recording. */
  press(
    stroke?: "pp" | "p" | "mf" | "f" | "ff" | { csv: string },
    options?: { struck?: boolean; step_s?: number },
  ): { csv: string; remarks: string[] };
  /** An action to step, at rest. It does not change when the instrument is freed. */
  action(step_s?: number): Action;
  /** Gives its memory back. A page that lives long frees what it no longer needs; there is no collector behind it. */
  free(): void;
}

export class Action {
  /** One step under a force on the key front, N, down positive. False if the step ended at its limit of iterations. */
  stepForce(force_n: number): boolean;
  /** One step under a device `position_m` below the key's rest that moves at `velocity_m_per_s`, both in the middle of
   * the step: its force is the reading's `finger_force_n`. */
  stepMotion(position_m: number, velocity_m_per_s: number): boolean;
  /** One step without a finger. */
  stepFree(): boolean;
  /** What the last step left. */
  readonly reading: Reading;
  /** Angles of the bodies, rad, absolute, counter-clockwise with the player to the left. */
  angles(): Float64Array;
  /** Whether it rests, so that steps would change nothing. */
  readonly rests: boolean;
  /** At rest, at 0 s. */
  reset(): void;
  /** The whole state; a restored action continues with the same bits, on every machine. */
  save(): Uint8Array;
  restore(bytes: Uint8Array): void;
  free(): void;
}
