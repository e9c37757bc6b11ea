// The package as it is installed, without anything else: `node --test`. ERARD=COMMAND compares with the command.
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { existsSync, mkdtempSync, readFileSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { test } from "node:test";

const erard = await import(process.env.ERARD_PACKAGE ?? "../index.js");
const engine = await erard.open();

test("a press of 5 N strikes once, and a state that is restored continues with the same bits", () => {
  const action = engine.instrument().action();
  const play = (from, to) => {
    for (let n = from; n < to; n++) assert.ok(action.stepForce(n < 5000 ? 5 : 0));
  };
  play(0, 2000);
  const saved = action.save();
  play(2000, 10000);
  const { reading } = action, angles = action.angles();
  assert.equal(reading.impact_count, 1);
  assert.ok(Math.abs(reading.time_s - 0.5) < 1e-9);
  // A player's mezzo-forte: 1 to 4 m/s (Askenfelt and Jansson, 1991).
  assert.ok(reading.hammer_speed_m_per_s > 1 && reading.hammer_speed_m_per_s < 4, `${reading.hammer_speed_m_per_s}`);
  action.restore(saved);
  play(2000, 10000);
  assert.deepEqual(action.reading, reading);
  assert.deepEqual(action.angles(), angles);
  action.free();
  action.free();
  assert.throws(() => action.stepFree(), /freed/);
});

test("levels are the command's to the byte", { skip: process.env.ERARD ? false : "ERARD names no command" }, () => {
  const folder = mkdtempSync(join(tmpdir(), "erard-js-"));
  try {
    for (const [stroke, struck] of [["mf", false], ["ff", true]]) {
      const asked = ["press", "--stroke", stroke, ...(struck ? ["--touch", "struck"] : [])];
      execFileSync(process.env.ERARD, [...asked, "--out", join(folder, stroke), "--quiet"]);
      assert.equal(engine.instrument().press(stroke, { struck }).csv, readFileSync(join(folder, stroke, "run.csv"), "utf8"));
    }
  } finally {
    rmSync(folder, { recursive: true });
  }
});

test("a change by name moves what it names, and leaves its instrument alone", () => {
  const grand = engine.instrument(), before = grand.text;
  const changed = grand.vary({ "body.hammer.mass": "+0.8 g" });
  assert.equal(grand.text, before);
  const [was, is] = [grand, changed].map((one) => one.measure(["down_weight_g"]).down_weight_g);
  // Some five grams at the key for a gram at the hammer.
  assert.ok(is - was > 0.8 * 3 && is - was < 0.8 * 8, `${was} ${is}`);
  assert.throws(() => grand.vary({ "body.hamer.mass": "+1 g" }), (error) => error instanceof erard.ErardError && /hamer/.test(error.message));
});

test("a wrong file is named with its line, a wrong argument with its name", () => {
  const { sound, errors } = engine.check('format = "erard-instrument/1"\nname = 3\n');
  assert.equal(sound, false);
  assert.equal(errors[0].line, 2);
  assert.throws(() => engine.read("name = 3"), erard.ErardError);
  assert.throws(() => engine.instrument("concert-grant"), /concert-grant/);
  assert.throws(() => engine.instrument("concert-grand", 89), /key is 89/);
  const action = engine.instrument("concert-grand", 40).action();
  for (const wrong of [undefined, null, "5"]) assert.throws(() => action.stepForce(wrong), TypeError);
  for (const wrong of [NaN, Infinity, 1e5]) assert.throws(() => action.stepForce(wrong), erard.ErardError);
  assert.throws(() => action.restore(new Uint8Array(10)), erard.ErardError);
  assert.equal(action.reading.time_s, 0);
});

test("memory does not grow with objects that are freed", () => {
  const once = () => {
    const grand = engine.instrument(), action = grand.action();
    action.stepForce(5);
    action.save();
    action.free();
    grand.free();
  };
  for (let n = 0; n < 5; n++) once();
  const before = engine.raw.memory.buffer.byteLength;
  for (let n = 0; n < 50; n++) once();
  assert.equal(engine.raw.memory.buffer.byteLength, before);
});

// In a clone only: the header is not in the package.
const header = new URL("../../c/include/erard.h", import.meta.url);
test("a reading's numbers are the header's, in its order", { skip: existsSync(header) ? false : "no header here" }, () => {
  const [, struct] = readFileSync(header, "utf8").match(/typedef struct ErardReading \{([^}]*)\}/);
  const fields = [...struct.matchAll(/^ +(\w+) (\w+);$/gm)].map(([, type, name]) => `${type} ${name}`);
  const expected = [...erard.READING.map((name) => `double ${name}`), "uint32_t impact_count", "uint32_t new_impact_count", "double hand_m", "double hand_m_per_s"];
  assert.deepEqual(fields.slice(2), expected);
  const { reading } = engine.instrument().action();
  assert.deepEqual(Object.keys(reading), expected.map((one) => one.split(" ")[1]));
});
