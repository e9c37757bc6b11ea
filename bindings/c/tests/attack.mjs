// node attack.mjs erard_c.wasm [FIRST] [LAST]: what a page could pass to the library by mistake, drawn by chance from
// the declarations of erard.h, so that a function that was added today is attacked today: numbers that are none, no
// object, texts that end outside of the memory, memory outside of it.
//
// The module may import nothing. A call is answered, refused in words, or, only where an address or a length lies
// outside of the memory, stopped by WebAssembly's own checks (bounds, and the functions of an object that is none);
// the library never ends itself (`unreachable`), and takes no number that is none. Prints how many calls ended how,
// and ends with 1 where one was wrong.
import { readFile } from "node:fs/promises";

const [path, from = "1", to = "800"] = process.argv.slice(2);
const module = new WebAssembly.Module(await readFile(path));
const imports = WebAssembly.Module.imports(module);
if (imports.length > 0) throw new Error(`imports ${JSON.stringify(imports)}; expected none`);

const header = await readFile(new URL("../include/erard.h", import.meta.url), "utf8");
const flat = header
  .replace(/\/\*[\s\S]*?\*\//g, "").replace(/\(\*(\w+)\)\[\d+\]/g, "*$1").replace(/^#.*$/gm, "").replace(/\s+/g, " ");
/** Functions of the header: name and arguments, each with type and name. */
const functions = flat.split(";").flatMap((one) => {
  const found = one.match(/([\w ]+[ *]+)(erard_\w+)\(([^()]*)\)\s*$/);
  if (!found) return [];
  const given = found[3].split(",").map((argument) => argument.trim()).filter((argument) => argument !== "void" && argument !== "");
  const split = (argument) => {
    const [, type, name] = argument.match(/^(.*[ *])(\w+)$/);
    return { type: type.replace(/\bconst\b|\bstruct\b/g, "").replace(/\s+/g, ""), name };
  };
  return [{ name: found[2], returns: found[1].replace(/.*[{}]/, "").replace(/\bconst\b|\bstruct\b/g, "").replace(/\s+/g, ""), given: given.map(split) }];
});
const exported = WebAssembly.Module.exports(module).filter((one) => one.kind === "function").map((one) => one.name);
const unknown = exported.filter((name) => name.startsWith("erard_") && !functions.some((one) => one.name === name));
if (unknown.length > 0 || functions.length < 50) throw new Error(`not read from the header: ${unknown}`);
const attacked = functions.filter((one) => exported.includes(one.name));

/** The same every time: xorshift. */
const random = (seed) => {
  let state = (Math.imul(seed, 0x9e3779b9) | 1) >>> 0;
  return (n) => {
    for (let k = 0; k < 3; k++) {
      state ^= state << 13;
      state ^= state >>> 17;
      state ^= state << 5;
    }
    return (state >>> 0) % n;
  };
};

const NUMBERS = [NaN, Infinity, -Infinity, 1e300, -1e300, 1e9, 0, -0, -1, 5e-324, 1e-12, 0.001, 50e-6, 5];
const WHOLE = [0, 1, 2, 40, 88, 89, 1000, -1, 0x7fffffff];
const TEXTS = ["", " ", "x", "concert-grand-rigid", "let_off", "body.hammer.mass_g", "x".repeat(100000), '{"let_off": 1e999}', "let_off=1 mm,drop=nan"];
/** Bytes of a buffer that is given with a count of this many of its items. */
const ROOM = 1 << 16;

/** A library of its own with one object of each kind. */
const begin = () => {
  const erard = new WebAssembly.Instance(module, {}).exports;
  const text = (string) => {
    const utf8 = new TextEncoder().encode(string);
    const at = erard.erard_memory_new(utf8.length + 1);
    new Uint8Array(erard.memory.buffer, at, utf8.length).set(utf8);
    return [at, utf8.length];
  };
  const [grand] = text("concert-grand-rigid");
  const [keyboard] = text("concert-grand");
  const [mf] = text("mf");
  const instrument = erard.erard_instrument_builtin(grand, 0);
  const objects = {
    "ErardInstrument*": instrument,
    "ErardAction*": erard.erard_action_of_instrument(instrument, 50e-6, 0),
    "ErardKeyboard*": erard.erard_keyboard_builtin(keyboard, 50e-6, 0),
    "ErardStroke*": erard.erard_stroke_builtin(instrument, mf, 0, 0),
    "ErardEventDetector*": erard.erard_event_detector_new(instrument, 0),
  };
  for (const [kind, at] of Object.entries(objects)) if (at === 0) throw new Error(`no ${kind}`);
  return { erard, text, objects, room: erard.erard_memory_new(2 * ROOM) };
};

const ends = { done: 0, refused: 0, stopped: 0 };
const faults = [];
let world = begin();
for (let seed = Number(from); seed < Number(to); seed++) {
  const pick = random(seed);
  const one = (list) => list[pick(list.length)];
  // One after the other: none is left out by chance.
  const { name, given, returns } = attacked[seed % attacked.length];
  const { erard, text, objects, room } = world;
  const end = erard.memory.buffer.byteLength;
  // Seldom, an address outside of the memory.
  const outside = () => (pick(12) === 0 ? one([end - 4, end, 0xfffffff0 | 0, -1]) : undefined);
  let isOutside = false;
  let isNone = false;
  let length;
  const frees = name.endsWith("_free");
  const values = given.map(({ type, name: own }, place) => {
    if (type === "double" || type === "float") {
      const number = one(NUMBERS);
      isNone ||= !Number.isFinite(number);
      return number;
    }
    if (type.endsWith("*") || type === "ErardProgress") {
      if (frees || type === "void*" || type === "ErardProgress") return 0;
      const far = outside();
      if (far !== undefined) {
        isOutside = true;
        length = one([1, 16, 4096]);
        return far;
      }
      if (type in objects) return one([objects[type], objects[type], objects[type], 0]);
      if (type === "char*") {
        const [at, bytes] = text(one(TEXTS));
        length = bytes;
        // A name ends with a zero; a text has a length.
        if (given[place + 1]?.type === "size_t" && pick(6) === 0) {
          length = one([end - at + 1, 0x7ffffff0, -1]);
          isOutside = true;
        }
        return at;
      }
      if (type === "ErardInput*" || type === "ErardReading*" || type === "ErardImpact*" || type === "ErardEvents*") {
        // Its size first, as the header has it, or another.
        const view = new DataView(erard.memory.buffer, room, ROOM);
        view.setUint32(0, one([56, 64, 112, 0, 4, 0xffffffff]), true);
        view.setUint32(4, one([0, 1, 2, 3, 4, 5, 0xffffffff]), true);
        for (let k = 8; k < 120; k += 8) view.setFloat64(k, one([0, 0.001, 5, NaN, 1e9]), true);
        length = one([0, 1, 5, 64]);
        return room;
      }
      length = one([0, 1, 5, 64, 4096]);
      return one([room, room, room, 0]);
    }
    if (type === "size_t") return length ?? one([0, 1, 7, 1000, -1]);
    return one(WHOLE);
  });
  const call = `${name}(${values.join(", ")})`;
  const wrong = (why) => faults.push(`seed ${seed}: ${call}: ${why}`);
  if (frees) continue;
  try {
    const found = erard[name](...values);
    const isRefused = returns === "ErardStatus" ? found < 0 : returns.endsWith("*") && found === 0;
    ends[isRefused ? "refused" : "done"] += 1;
    if (returns === "ErardStatus" && (found < -13 || found > 1)) wrong(`the code ${found} is not in the table`);
    if (returns === "ErardStatus" && isNone && !isRefused && name !== "erard_status_text") wrong("a number that is none was taken");
    if (returns.endsWith("*") && found !== 0) {
      const object = given.length > 0 && returns.startsWith("Erard") && `erard_${returns.slice(5, -1).replace(/(?!^)[A-Z]/g, "_$&").toLowerCase()}_free`;
      if (object && erard[object]) erard[object](found);
      else if (returns === "char*" && !flat.includes(`const char *${name}(`)) erard.erard_text_free(found);
    }
  } catch (error) {
    if (!(error instanceof WebAssembly.RuntimeError)) throw error;
    // A text as long as no memory is cannot be copied: the library ends where its memory does.
    const isTooLong = /unreachable/.test(error.message) && values.some((value) => value === 0x7ffffff0);
    if (isOutside && (isTooLong || /out of bounds|null function|signature mismatch/.test(error.message))) ends.stopped += 1;
    else wrong(error.message);
    // What was cut off half-way is not called again.
    world = begin();
  }
}
for (const fault of faults.slice(0, 40)) console.log(`wrong: ${fault}`);
console.log(`${Object.values(ends).reduce((a, b) => a + b, 0)} calls of ${attacked.length} functions:`, ends, `${faults.length} wrong`);
process.exit(faults.length > 0 ? 1 : 0);
