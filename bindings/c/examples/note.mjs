// node note.mjs erard_c.wasm: a note, read at the header's offsets; says its digest, sizes and times. What a page does,
// without the page.
import { readFile } from "node:fs/promises";
import { gzipSync } from "node:zlib";

const bytes = await readFile(process.argv[2]);
const { instance } = await WebAssembly.instantiate(bytes, {});
const erard = instance.exports;
if (erard.erard_abi() !== 1) throw new Error("another version of the interface");

const text = (address) => {
  const all = new Uint8Array(erard.memory.buffer);
  return new TextDecoder().decode(all.subarray(address, all.indexOf(0, address)));
};
const given = (string) => {
  const utf8 = new TextEncoder().encode(string);
  const address = erard.erard_memory_new(utf8.length);
  new Uint8Array(erard.memory.buffer, address, utf8.length).set(utf8);
  return [address, utf8.length];
};
// A text of the library, given back.
const taken = (address) => {
  if (address === 0) throw new Error(text(erard.erard_last_error()));
  const own = text(address);
  erard.erard_text_free(address);
  return own;
};

// ErardReading: its size and a reserved number, ten doubles, two counts, and two doubles of a hand.
const READING_BYTES = 112;
const reading = erard.erard_memory_new(READING_BYTES);
const read = () => new DataView(erard.memory.buffer, reading, READING_BYTES);
read().setUint32(0, READING_BYTES, true);
const action = erard.erard_action_new(0, 0, 50e-6, 0);
if (action === 0) throw new Error(text(erard.erard_last_error()));
const note = () => {
  for (let n = 0; n < 10000; n++) erard.erard_action_step_force(action, n < 5000 ? 5 : 0, reading);
};
note();
const bodies = erard.erard_action_body_count(action);
const angles = erard.erard_memory_new(8 * bodies);
erard.erard_action_angles(action, angles, bodies);
let digest = 0xcbf29ce484222325n;
for (const byte of new Uint8Array(erard.memory.buffer, angles, 8 * bodies)) {
  digest = BigInt.asUintN(64, (digest ^ BigInt(byte)) * 0x100000001b3n);
}
const best = (work, times) => {
  let least = Infinity;
  for (let n = 0; n < times; n++) {
    const began = performance.now();
    work();
    least = Math.min(least, performance.now() - began);
  }
  return least;
};
const step_us = (best(note, 10) / 10000) * 1000;

// Loaded, checked, drawn.
const [wrong, length] = given('format = "erard-instrument/1"\nname = 3\n');
const found = JSON.parse(taken(erard.erard_file_check(wrong, length, 0, 0)));
if (found.sound || found.errors[0].line !== 2) throw new Error(JSON.stringify(found));
const instrument = erard.erard_instrument_new(0, 0, 0);
const svg = taken(erard.erard_instrument_draw(instrument, angles, bodies, 900, 1, 0, 0));
if (!svg.startsWith("<svg") || !svg.includes("data-body")) throw new Error("no picture");
const draw_ms = best(() => erard.erard_text_free(erard.erard_instrument_draw(instrument, angles, bodies, 900, 0, 0, 0)), 3);

console.log(`digest ${digest.toString(16).padStart(16, "0")} after ${read().getUint32(88, true) > 0 ? "an impact" : "no impact"}`);
console.log(`${bytes.length} bytes, ${gzipSync(bytes, { level: 9 }).length} gzipped; ${step_us.toFixed(2)} us a step; a picture ${draw_ms.toFixed(1)} ms`);
