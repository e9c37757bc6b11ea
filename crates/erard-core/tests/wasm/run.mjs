// node run.mjs FILE.wasm: exit code 1 where a digest is another than the tests'.
import { readFile } from "node:fs/promises";

const { instance } = await WebAssembly.instantiate(await readFile(process.argv[2]), {});
const hex = (digest) => "0x" + BigInt.asUintN(64, digest).toString(16).padStart(16, "0");
let same = true;
for (const name of ["loaded", "long_run", "long_bending_run", "long_hand_run", "long_level_run"]) {
  const began = performance.now();
  const [found, expected] = [instance.exports[name](), instance.exports[name + "_expected"]()];
  const seconds = ((performance.now() - began) / 1000).toFixed(1);
  console.log(`${name} ${hex(found)} ${found === expected ? "the same" : "NOT " + hex(expected)} (${seconds} s)`);
  same &&= found === expected;
}
process.exit(same ? 0 : 1);
