// The engine for Node and browsers: liberard in WebAssembly behind a few classes. Types and documentation are in
// index.d.ts; the functions behind it in the C interface's header, erard.h.

/** Doubles of ErardReading, in its order, after its size and a reserved number. */
export const READING = [
  "time_s", "key_m", "key_m_per_s", "finger_force_n", "finger_force_mean_n", "hammer_rise_m", "hammer_rise_m_per_s", "string_n", "impact_time_s",
  "hammer_speed_m_per_s",
];
/** What follows: two whole numbers, two doubles of a hand. */
const COUNTS = ["impact_count", "new_impact_count"], HAND = ["hand_m", "hand_m_per_s"];
const READING_BYTES = 8 + 8 * READING.length + 4 * COUNTS.length + 8 * HAND.length;
const ABI = 1;
/** Length of a step, s: as `erard press` takes. */
export const STEP_S = 50e-6;

export class ErardError extends Error {
  name = "ErardError";
}

const compiled = async (source) => {
  if (source instanceof WebAssembly.Module) return source;
  if (source instanceof ArrayBuffer || ArrayBuffer.isView(source)) return WebAssembly.compile(source);
  if (source !== undefined && typeof source !== "string" && !(source instanceof URL)) {
    throw new TypeError(`erard: the engine is ${String(source)}; expected bytes, a WebAssembly.Module, or an address`);
  }
  const address = new URL(source ?? "./erard.wasm", import.meta.url);
  if (address.protocol === "file:") {
    const { readFile } = await import("node:fs/promises");
    return WebAssembly.compile(await readFile(address));
  }
  const answer = await fetch(address);
  if (!answer.ok) throw new ErardError(`the engine is not at ${address}: ${answer.status}`);
  return WebAssembly.compile(await answer.arrayBuffer());
};

export const open = async (source) => {
  const { exports } = await WebAssembly.instantiate(await compiled(source), {});
  if (exports.erard_abi?.() !== ABI) throw new ErardError("the engine has another interface than this package");
  return new Engine(exports);
};

export class Engine {
  constructor(raw) {
    this.raw = raw;
  }

  get version() {
    return this.textAt(this.raw.erard_version());
  }

  names() {
    return JSON.parse(this.taken(this.raw.erard_builtin_names(0, 0)));
  }

  instrument(name = "concert-grand", key) {
    const made = this.given(name, (at) => (key === undefined ? this.raw.erard_instrument_builtin(at, 0) : this.raw.erard_instrument_of_keyboard(at, whole(key, "key", 1, 88), 0)));
    return new Instrument(this, this.made(made));
  }

  read(text) {
    return new Instrument(this, this.made(this.given(text, (at, length) => this.raw.erard_instrument_new(at, length, 0))));
  }

  check(text) {
    return JSON.parse(this.taken(this.given(text, (at, length) => this.raw.erard_file_check(at, length, 0, 0))));
  }

  // What the classes share: memory moves when it grows, so that every look at it is a new one.

  /** A text that stays the library's. */
  textAt(address) {
    const all = new Uint8Array(this.raw.memory.buffer);
    return new TextDecoder().decode(all.subarray(address, all.indexOf(0, address)));
  }

  /** A text of the library, given back to it. */
  taken(address) {
    const text = this.textAt(this.made(address));
    this.raw.erard_text_free(address);
    return text;
  }

  made(address) {
    if (address === 0) throw new ErardError(this.textAt(this.raw.erard_last_error()));
    return address;
  }

  done(status) {
    if (status < 0) throw new ErardError(this.textAt(this.raw.erard_status_text(status)));
    return status;
  }

  /** Memory for a call, freed after it. */
  lent(bytes, call) {
    const address = this.raw.erard_memory_new(bytes);
    if (address === 0) throw new ErardError("there is no memory left");
    try {
      return call(address);
    } finally {
      this.raw.erard_memory_free(address, bytes);
    }
  }

  /** A text, ended by a zero, for a call. */
  given(text, call) {
    if (typeof text !== "string") throw new TypeError(`erard: ${String(text)} is no text`);
    const utf8 = new TextEncoder().encode(text);
    return this.lent(utf8.length + 1, (address) => {
      const room = new Uint8Array(this.raw.memory.buffer, address, utf8.length + 1);
      room.set(utf8);
      room[utf8.length] = 0;
      return call(address, utf8.length);
    });
  }
}

const whole = (value, called, least, most) => {
  if (!Number.isInteger(value) || value < least || value > most) throw new RangeError(`erard: ${called} is ${String(value)}; expected a whole number from ${least} to ${most}`);
  return value;
};
/** WebAssembly would make a number of anything: null would be 0. */
const number = (value, called) => {
  if (typeof value !== "number") throw new TypeError(`erard: ${called} is ${String(value)}; expected a number`);
  return value;
};

/** An object of the library, which is freed once. */
class Owned {
  #address;
  #free;

  constructor(engine, address, free) {
    this.engine = engine;
    this.#address = address;
    this.#free = free;
  }

  get address() {
    if (this.#address === 0) throw new ErardError("this object has been freed");
    return this.#address;
  }

  free() {
    if (this.#address !== 0) this.#free(this.#address);
    this.#address = 0;
  }
}

export class Instrument extends Owned {
  constructor(engine, address) {
    super(engine, address, engine.raw.erard_instrument_free);
  }

  get text() {
    return this.engine.taken(this.engine.raw.erard_instrument_text(this.address, 0, 0));
  }

  vary(changes) {
    const changed = this.engine.read(this.text);
    try {
      for (const [called, change] of Object.entries(changes)) {
        const status = this.engine.given(called, (at) => this.engine.given(change, (to) => this.engine.raw.erard_instrument_vary(changed.address, at, to)));
        if (status < 0) throw new ErardError(this.engine.textAt(this.engine.raw.erard_last_error()));
      }
    } catch (error) {
      changed.free();
      throw error;
    }
    return changed;
  }

  measure(lines, key = 0) {
    const { raw } = this.engine;
    const answer = (wanted) => JSON.parse(this.engine.taken(raw.erard_instrument_measure(this.address, whole(key, "key", 0, 88), wanted, 0, 0, 0, 0)));
    return lines === undefined ? answer(0) : this.engine.given(lines.join(","), answer);
  }

  draw(size_px = 900) {
    return this.engine.taken(this.engine.raw.erard_instrument_draw(this.address, 0, 0, number(size_px, "size_px"), 1, 0, 0));
  }

  press(stroke = "mf", { struck = false, step_s = STEP_S } = {}) {
    const { engine } = this, { raw } = engine;
    const made = engine.made(
      typeof stroke === "string"
        ? engine.given(stroke, (at) => raw.erard_stroke_builtin(this.address, at, struck ? 1 : 0, 0))
        : engine.given(stroke.csv, (at, length) => raw.erard_stroke_new(this.address, at, length, 0)),
    );
    try {
      return {
        csv: engine.taken(raw.erard_stroke_run_csv(this.address, made, number(step_s, "step_s"), 0, 0)),
        remarks: engine.taken(raw.erard_stroke_remarks(made, 0, 0)).split("\n").filter((line) => line),
      };
    } finally {
      raw.erard_stroke_free(made);
    }
  }

  action(step_s = STEP_S) {
    return new Action(this.engine, this.engine.made(this.engine.raw.erard_action_of_instrument(this.address, number(step_s, "step_s"), 0)));
  }
}

export class Action extends Owned {
  #reading;

  constructor(engine, address) {
    super(engine, address, engine.raw.erard_action_free);
    this.#reading = engine.raw.erard_memory_new(READING_BYTES);
    if (this.#reading === 0) throw new ErardError("there is no memory left");
    new DataView(engine.raw.memory.buffer).setUint32(this.#reading, READING_BYTES, true);
  }

  free() {
    super.free();
    if (this.#reading !== 0) this.engine.raw.erard_memory_free(this.#reading, READING_BYTES);
    this.#reading = 0;
  }

  stepForce(force_n) {
    return this.engine.done(this.engine.raw.erard_action_step_force(this.address, number(force_n, "force_n"), this.#reading)) === 0;
  }

  stepMotion(position_m, velocity_m_per_s) {
    const { raw } = this.engine;
    return this.engine.done(raw.erard_action_step_motion(this.address, number(position_m, "position_m"), number(velocity_m_per_s, "velocity_m_per_s"), this.#reading)) === 0;
  }

  stepFree() {
    return this.engine.done(this.engine.raw.erard_action_step_free(this.address, this.#reading)) === 0;
  }

  get reading() {
    this.engine.done(this.engine.raw.erard_action_read(this.address, this.#reading));
    const view = new DataView(this.engine.raw.memory.buffer, this.#reading, READING_BYTES), all = {};
    let at = 8;
    for (const name of READING) (all[name] = view.getFloat64(at, true)), (at += 8);
    for (const name of COUNTS) (all[name] = view.getUint32(at, true)), (at += 4);
    for (const name of HAND) (all[name] = view.getFloat64(at, true)), (at += 8);
    return all;
  }

  angles() {
    const { raw } = this.engine, count = raw.erard_action_body_count(this.address);
    return this.engine.lent(8 * count, (at) => {
      this.engine.done(raw.erard_action_angles(this.address, at, count));
      return new Float64Array(raw.memory.buffer.slice(at, at + 8 * count));
    });
  }

  get rests() {
    return this.engine.raw.erard_action_is_asleep(this.address) === 1;
  }

  reset() {
    this.engine.done(this.engine.raw.erard_action_reset(this.address));
  }

  save() {
    const { raw } = this.engine;
    return this.engine.lent(8, (size) => {
      const words = () => new DataView(raw.memory.buffer);
      words().setUint32(size, 0, true);
      raw.erard_action_save(this.address, 0, size);
      const bytes = words().getUint32(size, true);
      return this.engine.lent(bytes, (at) => {
        this.engine.done(raw.erard_action_save(this.address, at, size));
        return new Uint8Array(raw.memory.buffer.slice(at, at + bytes));
      });
    });
  }

  restore(bytes) {
    if (!(bytes instanceof Uint8Array)) throw new TypeError("erard: a saved state is a Uint8Array");
    this.engine.lent(Math.max(bytes.length, 1), (at) => {
      new Uint8Array(this.engine.raw.memory.buffer, at, bytes.length).set(bytes);
      this.engine.done(this.engine.raw.erard_action_restore(this.address, at, bytes.length));
    });
  }
}
