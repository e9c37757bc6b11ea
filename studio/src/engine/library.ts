// liberard in WebAssembly: texts, memory and errors across its C interface (bindings/c/include/erard.h). Knows nothing
// of pages or workers.
import type { Stroke } from "./protocol";

/** The functions of erard.h that a page calls. Addresses and sizes are numbers; a text's length may be asked for or
 * not. */
export interface Exports {
  memory: WebAssembly.Memory;
  erard_abi(): number;
  erard_version(): number;
  erard_last_error(): number;
  erard_status_text(status: number): number;
  erard_text_free(text: number): void;
  erard_memory_new(bytes: number): number;
  erard_memory_free(memory: number, bytes: number): void;
  erard_instrument_new(text: number, length: number, status: number): number;
  erard_instrument_builtin(name: number, status: number): number;
  erard_instrument_of_keyboard(name: number, key: number, status: number): number;
  erard_instrument_free(instrument: number): void;
  erard_instrument_text(instrument: number, length: number, status: number): number;
  erard_instrument_json(instrument: number, length: number, status: number): number;
  erard_instrument_vary_field(instrument: number, called: number, change: number): number;
  erard_instrument_dial_typed(instrument: number, dial: number, typed: number, value: number): number;
  erard_instrument_with_dials(instrument: number, turns: number, status: number): number;
  erard_instrument_dials(instrument: number, length: number, status: number): number;
  erard_instrument_drawing_json(instrument: number, length: number, status: number): number;
  erard_sheet_lines(key: number, length: number, status: number): number;
  erard_diagnose_quantities(key: number, length: number, status: number): number;
  erard_diagnose(readings: number, length: number, status: number): number;
  erard_diagnose_check(readings: number, length: number, status: number): number;
  erard_instrument_test_press(instrument: number, length: number, status: number): number;
  erard_file_check(text: number, length: number, jsonLength: number, status: number): number;
  erard_builtin_names(length: number, status: number): number;
  erard_instrument_measure(instrument: number, key: number, wanted: number, progress: number, user: number, length: number, status: number): number;
  erard_instrument_regulate(instrument: number, goals: number, progress: number, user: number, length: number, status: number): number;
  erard_action_of_instrument(instrument: number, step: number, status: number): number;
  erard_action_free(action: number): void;
  erard_action_step_force(action: number, force: number, reading: number): number;
  erard_action_step_fingertip(action: number, position: number, velocity: number, stiffness: number, damping: number, reading: number): number;
  erard_action_step_rigid(action: number, position: number, velocity: number, reading: number): number;
  erard_action_step_free(action: number, reading: number): number;
  erard_action_read(action: number, reading: number): number;
  erard_action_reset(action: number): number;
  erard_action_string_places(action: number, places: number, count: number): number;
  erard_action_string_shape(action: number, shape: number, count: number): number;
  erard_action_set_pedal(action: number, lift: number): number;
  erard_action_bridge_force(action: number, force: number): number;
  erard_action_pressure(action: number, pressure: number): number;
  erard_action_save(action: number, bytes: number, size: number): number;
  erard_action_restore(action: number, bytes: number, size: number): number;
  erard_action_is_asleep(action: number): number;
  erard_action_body_count(action: number): number;
  erard_action_zone_count(action: number): number;
  erard_action_angles(action: number, angles: number, count: number): number;
  erard_action_record_contacts(action: number): number;
  erard_action_contacts(action: number, numbers: number, count: number): number;
  erard_event_detector_new(instrument: number, status: number): number;
  erard_event_detector_free(detector: number): void;
  erard_event_detector_reset(detector: number): number;
  erard_event_detector_observe(detector: number, action: number): number;
  erard_event_detector_read(detector: number, events: number): number;
  erard_stroke_builtin(instrument: number, nuance: number, struck: number, status: number): number;
  erard_stroke_new(instrument: number, text: number, length: number, status: number): number;
  erard_stroke_run_csv(instrument: number, stroke: number, step: number, length: number, status: number): number;
  erard_stroke_remarks(stroke: number, length: number, status: number): number;
  erard_recording_columns(titles: number, length: number, status: number): number;
  erard_stroke_free(stroke: number): void;
  erard_stroke_duration(stroke: number): number;
  erard_stroke_rewind(stroke: number): number;
  erard_action_step_stroke(action: number, stroke: number, reading: number): number;
  erard_keyboard_builtin(name: number, step: number, status: number): number;
  erard_keyboard_free(keyboard: number): void;
  erard_keyboard_key_count(keyboard: number): number;
  erard_keyboard_awake_count(keyboard: number): number;
  erard_keyboard_drive(keyboard: number, key: number, input: number): number;
  erard_keyboard_step(keyboard: number, steps: number, impacts: number, capacity: number, count: number): number;
  erard_keyboard_read(keyboard: number, key: number, reading: number): number;
  erard_keyboard_set_pedal(keyboard: number, lift: number): number;
  erard_keyboard_total_bridge_force(keyboard: number, force: number): number;
  erard_keyboard_pressure(keyboard: number, pressure: number): number;
  erard_keyboard_set_halving(keyboard: number, kind: number): number;
  erard_keyboard_angles(keyboard: number, key: number, angles: number, count: number): number;
}

/** The version of the C interface that this page was written for. */
const ABI = 1;

/** UTF-8, also where there are no coders for it: in an AudioWorklet. */
const text = (utf8: Uint8Array): string =>
  typeof TextDecoder === "function" ? new TextDecoder().decode(utf8) : decodeURIComponent(Array.from(utf8, (byte) => `%${byte.toString(16).padStart(2, "0")}`).join(""));
const utf8 = (text: string): Uint8Array =>
  typeof TextEncoder === "function" ? new TextEncoder().encode(text) : Uint8Array.from(encodeURIComponent(text).match(/%..|./gs) ?? [], (one) => (one.length > 1 ? Number.parseInt(one.slice(1), 16) : one.charCodeAt(0)));

/** What the library says went wrong: a line for people. */
export class LibraryError extends Error {
  override name = "LibraryError";
}

export class Library {
  private buffer: ArrayBuffer | null = null;
  private all = new Uint8Array();
  private doubles = new Float64Array();
  private words = new Uint32Array();
  private singles = new Float32Array();

  readonly raw: Exports;

  /** A library of its own: nothing is shared with another one of the same module. */
  static async open(module: WebAssembly.Module): Promise<Library> {
    return new Library(await WebAssembly.instantiate(module, {}));
  }

  constructor({ exports }: WebAssembly.Instance) {
    this.raw = exports as unknown as Exports;
    if (this.raw.erard_abi() !== ABI) throw new LibraryError("the library is of another version than the page");
  }

  /** Its memory as bytes, doubles and words. It moves when it grows: ask anew after every call that may allocate. */
  private look(): void {
    if (this.buffer === this.raw.memory.buffer) return;
    this.buffer = this.raw.memory.buffer;
    this.all = new Uint8Array(this.buffer);
    this.doubles = new Float64Array(this.buffer);
    this.words = new Uint32Array(this.buffer);
    this.singles = new Float32Array(this.buffer);
  }

  bytes(address: number, count: number): Uint8Array {
    this.look();
    return this.all.subarray(address, address + count);
  }

  f64(address: number, count: number): Float64Array {
    this.look();
    return this.doubles.subarray(address >> 3, (address >> 3) + count);
  }

  f32(address: number, count: number): Float32Array {
    this.look();
    return this.singles.subarray(address >> 2, (address >> 2) + count);
  }

  u32(address: number, count: number): Uint32Array {
    this.look();
    return this.words.subarray(address >> 2, (address >> 2) + count);
  }

  get memoryBytes(): number {
    return this.raw.memory.buffer.byteLength;
  }

  version(): string {
    return this.textAt(this.raw.erard_version());
  }

  lastError(): string {
    return this.textAt(this.raw.erard_last_error());
  }

  statusText(status: number): string {
    return this.textAt(this.raw.erard_status_text(status));
  }

  /** Memory for a struct of the interface, whose first field is its size. */
  struct(bytes: number, count = 1): number {
    const address = this.raw.erard_memory_new(bytes * count);
    if (address === 0) throw new LibraryError("there is no memory left");
    this.u32(address, 1)[0] = bytes;
    return address;
  }

  /** A text that stays the library's. */
  textAt(address: number): string {
    this.look();
    return text(this.all.slice(address, this.all.indexOf(0, address)));
  }

  /** A text of the library, given back to it; its error where there is none. */
  taken(address: number): string {
    if (address === 0) throw new LibraryError(this.lastError());
    const text = this.textAt(address);
    this.raw.erard_text_free(address);
    return text;
  }

  json<T>(address: number): T {
    return JSON.parse(this.taken(address)) as T;
  }

  /** An object of the library; its error where there is none. */
  made(address: number): number {
    if (address === 0) throw new LibraryError(this.lastError());
    return address;
  }

  /** What a call that says how it ended has to say. */
  done(status: number): void {
    if (status < 0) throw new LibraryError(this.lastError() || this.statusText(status));
  }

  /** Passes a text, ended by a zero, to a call. */
  given<T>(text: string, call: (address: number, length: number) => T): T {
    const bytes = utf8(text);
    const address = this.raw.erard_memory_new(bytes.length + 1);
    if (address === 0) throw new LibraryError("there is no memory left");
    try {
      this.bytes(address, bytes.length).set(bytes);
      return call(address, bytes.length);
    } finally {
      this.raw.erard_memory_free(address, bytes.length + 1);
    }
  }

  /** A stroke for an instrument, to be freed. The hand of a level is the one that reaches it on `reference`. */
  stroke(instrument: number, stroke: Stroke, reference = instrument): number {
    const { raw } = this;
    return this.made(
      "csv" in stroke
        ? this.given(stroke.csv, (at, length) => raw.erard_stroke_new(instrument, at, length, 0))
        : this.given(stroke.nuance, (at) => raw.erard_stroke_builtin(reference, at, stroke.struck ? 1 : 0, 0)),
    );
  }

  /** The instrument of a text, for a call; freed after it. */
  withInstrument<T>(text: string, call: (instrument: number) => T): T {
    const instrument = this.made(this.given(text, (at, length) => this.raw.erard_instrument_new(at, length, 0)));
    try {
      return call(instrument);
    } finally {
      this.raw.erard_instrument_free(instrument);
    }
  }
}
