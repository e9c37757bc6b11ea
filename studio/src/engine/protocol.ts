// What page and workers say to each other. Lengths in m, forces in N, times in s, unless a name says otherwise.
import type { ArrowLaw, Hinge } from "../../../crates/erard-figures/src/page/moving.js";

/** What erard_instrument_drawing_json reports about an instrument. */
export interface Scene {
  name: string;
  shapes: string;
  gradients: string;
  bodies: (Hinge & { name: string; angle: number; mass_g: number })[];
  zones: { name: string; label: string; sign: number; unseen: boolean; disc: number | null; curve: number | null }[];
  press: { body: number; point: number[] } | null;
  pedal: boolean;
  /** Where a modal string is struck and how high it lies; null where it is rigid. */
  string: number[] | null;
  /** The places at which it is looked at, m from there: not erard_instrument_drawing_json's, but the action's. */
  places_m?: number[];
  labels: { text: string; piece: number; at: number[] }[];
  arrow: ArrowLaw;
  views: { whole: number[]; close: number[] | null };
}

/** The instants of a press; NaN for what has not happened. */
export interface Events {
  key_start_s: number;
  toe_contact_s: number;
  let_off_s: number;
  hammer_contact_s: number;
  hammer_speed_m_per_s: number;
  key_bottom_s: number;
  check_s: number;
  free_flight_s: number;
  key_bottom_after_impact_s: number;
  /** Number of impacts since the press began. */
  impact_count: number;
}

/** An action at an instant: angles of its bodies, rad; of every zone force, point and normal. */
export interface Pose {
  time_s: number;
  key_m: number;
  hammer_rise_m: number;
  finger_force_n: number;
  string_n: number;
  hammer_rise_m_per_s: number;
  angles: Float32Array;
  contacts: Float32Array;
  /** How far the string is from its rest at its places, m; none where it is rigid. */
  string: Float32Array;
  /** How much the string swings about its mean, m: the root mean square over its places and the last 20 ms; 0 where it
   * is rigid. */
  swing_m: number;
}

/** An impact since the last frame. */
export interface Impact {
  action: number;
  time_s: number;
  hammer_speed_m_per_s: number;
}

/** What presses the key: a fingertip somewhere (null: lifted), so firm, the key front's own motion where it is imposed,
 * or
 * a force that grows and fades within milliseconds. The instrument's own fingertip belongs to strokes. */
export type Touch = { kind: "finger"; position_m: number | null; firmness_n_m: number; imposed?: boolean } | { kind: "force"; force_n: number };

/** A stroke that is built in, or a recording: a table's text, and the name of its file, with `rows` where lines of the
 * text are no lines of the file. */
export type Stroke = { nuance: string; struck: boolean } | { csv: string; name: string; rows?: boolean };

/** When time slows down by itself: while the key or the hammer is between two places and moves at least so fast
 * (`going`
 * 1: the key down, the hammer up; -1: back; 0: either way), or for so long after an impact. The slowest rule that holds
 * decides. */
export type Slow =
  | { of: "key" | "hammer"; from_m: number; to_m: number; going: -1 | 0 | 1; least_m_per_s: number; pace: number }
  | { of: "impact"; for_s: number; pace: number };

export type ToPlayer =
  | { kind: "open"; module: WebAssembly.Module }
  | { kind: "load"; id: number; texts: string[]; keep: boolean }
  | { kind: "stroke"; stroke: Stroke; other?: Stroke | null }
  | { kind: "stop" }
  | { kind: "pedal"; lift_m: number }
  | { kind: "rest" }
  | {
      kind: "frame"; wall_ms: number; touch: Touch; at_s: number | null; curves: { from: number; to: number; points: number } | null;
      /** Seconds of the action in a second of the page, at most 1, and what slows it further. */
      pace: number; slow: Slow[];
    }
  | { kind: "restore" };

export type FromPlayer =
  | { kind: "ready"; version: string }
  | { kind: "loaded"; id: number; scenes: Scene[] }
  | { kind: "refused"; id: number; which: number; message: string }
  | { kind: "no-stroke"; message: string }
  | { kind: "stroke-begun"; told: string[] }
  | {
      kind: "frame"; wall_ms: number; poses: Pose[]; events: Events[]; span: [number, number]; impacts: Impact[]; resting: boolean;
      limited: number; cost_ms: number; steps: number; pace: number; curves: { times: Float64Array; series: Float64Array[][] } | null;
    }
  | { kind: "fault"; message: string }
  | { kind: "restored"; scenes: Scene[] };

/** A slider of erard_instrument_dials. */
export interface Dial {
  name: string;
  label: string;
  note: string;
  group: string;
  unit: string;
  decimals: number;
  value: number;
  from: number;
  to: number;
}

export interface SheetGroup {
  heading: string;
  lines: { key: string; label: string; unit: string; decimals: number; usual: [number | null, number | null]; source: string | null }[];
}

export interface Check {
  kind: string;
  sound: boolean;
  name: string | null;
  errors: { line: number; column: number; key: string; message: string; found: string; expected: string; begin: number; end: number; text: string }[];
}

export interface Regulated {
  all_met: boolean;
  goals: { goal: string; unit: string; asked: number; before: number | null; after: number | null; met: boolean; why_not: string | null }[];
  screws: { screw: string; unit: string; from: number; to: number; turned_by: number; turns: number | null; turns_text: string | null; way: string }[];
  file: string;
}

/** What can be measured of a key of one's own piano, as erard_diagnose_quantities has it. */
export interface Measurable {
  name: string;
  label: string;
  unit: string;
  decimals: number;
  limits: [number, number];
  precision: number;
  usual: [number | null, number | null];
  how: string;
}

/** A reading that cannot be: `name` is that of its field, empty where it belongs to none. */
export interface ReadingFault {
  name: string;
  found: string;
  expected: string;
}

/** A key in erard_diagnose's answer, which is the command's diagnosis.json. */
export interface Diagnosed {
  key: number;
  note: string;
  readings: {
    name: string; label: string; value: number | null; unit: string; decimals: number; usual_low: number | null; usual_high: number | null;
    standing: "inside" | "doubtful" | "out" | "no_range" | "not_judged"; likely_reason: string | null;
  }[];
  is_work: boolean;
  verdict: string;
  causes: {
    cause: string; name: string; probability: number; case: number; test: string; cure: string; odds_assumed: number;
    explains: { name: string; label: string; by: number; unit: string; decimals: number }[];
  }[];
  undecided: { cause: string; name: string; test: string }[];
  open_question: string | null;
  something_else: number;
  to_do: string[];
  measure_next: {
    name: string; label: string; unit: string; decimals: number; how: string; bits: number;
    would_read: { value: number; causes: string[]; names: string }[];
  } | null;
  leverage: { low: number; high: number } | null;
  front_weight_g: { low: number; high: number } | null;
  inertia_kg: { low: number; high: number } | null;
  notes: string[];
}

export interface Diagnosis {
  readings_from: string | null;
  is_key_assumed: boolean;
  rests_on: string;
  keys: Diagnosed[];
}

export type Task =
  | { kind: "builtin" }
  | { kind: "base"; of: { builtin: string } | { key: number; keyboard: string } | { text: string } }
  | { kind: "turned"; text: string; turns: Record<string, number> }
  | { kind: "dials"; text: string }
  | { kind: "dial-typed"; text: string; dial: string; typed: string }
  | { kind: "vary"; text: string; called: string; change: string }
  | { kind: "sheet"; key: number }
  | { kind: "check"; text: string }
  | { kind: "columns"; titles: string[] }
  | { kind: "run"; text: string; stroke: Stroke }
  | { kind: "sound"; text: string; stroke: Stroke; pedal_m: number; seconds: number }
  | { kind: "try"; text: string }
  | { kind: "measure"; text: string; lines: string }
  | { kind: "regulate"; text: string }
  | { kind: "diagnosable"; key: number }
  | { kind: "diagnose"; readings: Record<string, string> };

export type ToWorkshop = { kind: "open"; module: WebAssembly.Module } | { kind: "task"; id: number; task: Task };
export type FromWorkshop =
  | { kind: "ready" }
  | { kind: "done"; id: number; answer: unknown }
  | { kind: "failed"; id: number; message: string; fault: boolean };

/** An impact of a key's hammer; where a passage is played, when, s from its beginning. */
export interface KeyImpact {
  key: number;
  hammer_speed_m_per_s: number;
  at_s: number | null;
}

/** How the keyboard stands, and the impacts since it was last asked. */
export interface Stand {
  key_m: Float32Array<ArrayBuffer>;
  hammer_rise_m: Float32Array<ArrayBuffer>;
  finger_force_n: Float32Array<ArrayBuffer>;
  impacts: KeyImpact[];
  /** How far the passage is, s from its beginning; null where there was none. */
  passage_s: number | null;
  awake: number;
  shown: { key: number; angles: Float32Array<ArrayBuffer> } | null;
}

/** What is a full scale of sound, the same for all keys, as the command has it: pressure before a soundboard, Pa, or
 * force on a bridge that stands still, N. Three keys struck as loud as can be reach it together. */
export const FULL_SCALE = { Pa: 10, N: 150 };
export type Unit = keyof typeof FULL_SCALE;
/** What is heard, as the page says it. */
export const HEARD: Record<Unit, string> = {
  Pa: "the pressure 1 m before the soundboard, without a room; an estimate",
  N: "the strings\u2019 force on the bridge, for no soundboard moves",
};
/** A note: after each step what is heard on the left and on the right, and the force on the bridge less that at rest,
 * N. */
export interface Note {
  unit: Unit;
  channels: [Float32Array<ArrayBuffer>, Float32Array<ArrayBuffer>];
  bridge_n: Float32Array<ArrayBuffer>;
}
/** How much of a note is heard, s. */
export const NOTE_S = 2;
/** Length of a step where strings are heard, s. */
export const SOUND_STEP_S = 1 / 24e3;

/** How keys of a built-in keyboard are pressed: key, from 1, and force, N, 0 lets go; and of the key that is shown,
 * where the far end of a fingertip on it is, m (null: lifted). The pedal: lift of its rail, m. */
export type ToKeys =
  | { kind: "open"; module: WebAssembly.Module; name: string; step_s: number }
  | { kind: "show"; key: number }
  | { kind: "pedal"; lift_m: number }
  /** Forces on keys, in the order of time: when, s from now, which key, and the force, N; 0 lets it go. */
  | { kind: "passage"; turns: [number, number, number][] }
  | { kind: "frame"; wall_ms: number; forces: [number, number][]; finger_m: number | null };
/** What was sent to the loudspeaker since the frame before. */
export interface Heard {
  unit: Unit;
  /** Largest sample, of a full scale of 1, and samples that were beyond it. */
  peak: number;
  clipped: number;
  /** Since the beginning: how often the sound broke off, and for how long in all, s. */
  dropouts: number;
  lost_s: number;
}
export type FromKeys =
  /** `step_s`: length of a step, s. */
  | { kind: "ready"; keys: number; step_s: number; took_ms: number }
  | { kind: "shown"; key: number; scene: Scene }
  | (Stand & {
      kind: "frame"; wall_ms: number; steps: number; cost_ms: number; late_s: number;
      /** Force of all strings on the bridge after each step of the frame, N; none where no strings sound. */
      bridge_n: Float32Array;
      /** Null where it is not heard. */
      sound: Heard | null;
    })
  | { kind: "fault"; message: string };
