// node built.mjs ENGINE.wasm: the engine packed into built/engine.bin, the built-in concert grand at rest as
// built/picture.svg, and the pictures of the gallery as built/pictures.json.
import { readFile, writeFile } from "node:fs/promises";
import { gzipAsync } from "@gfx/zopfli";
import { pictures } from "./pictures.mjs";

const bytes = await readFile(process.argv[2]);
const { instance } = await WebAssembly.instantiate(bytes, {});
const erard = instance.exports;
const address = erard.erard_instrument_drawing_json(erard.erard_instrument_new(0, 0, 0), 0, 0);
const all = new Uint8Array(erard.memory.buffer);
const scene = JSON.parse(new TextDecoder().decode(all.subarray(address, all.indexOf(0, address))));
const [left, top, right, bottom] = scene.views.whole;
const picture = `<svg class="action first" role="img" aria-label="A concert grand's action at rest" viewBox="${left} ${top} ${right - left} ${bottom - top}" preserveAspectRatio="xMidYMid meet"><defs>${scene.gradients}</defs>${scene.shapes}</svg>`;
// A twentieth smaller than the best of zlib, for seconds of building.
await writeFile(new URL("built/engine.bin", import.meta.url), await gzipAsync(bytes, { numiterations: 3 }));
await writeFile(new URL("built/picture.svg", import.meta.url), picture + "\n");
await writeFile(new URL("built/pictures.json", import.meta.url), JSON.stringify(pictures(erard)) + "\n");
