// What is heard: notes that the workshop renders, beside the command's; a keyboard in the audio thread, rendered
// offline, beside the command's; the same keyboard by its own button; what blocks of samples cost.
import { execFileSync } from "node:child_process";
import { mkdtempSync, readFileSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { assert, goal, percentile, until } from "./help.mjs";

/** Full scale of the command's sounds, N, in its source: the page's is compared with it, sample by sample. */
const FULL_SCALE_N = Number(/FULL_SCALE_N: f64 = ([0-9.]+);/.exec(readFileSync(new URL("../../crates/erard-cli/src/wav.rs", import.meta.url), "utf8"))[1]);
/** Steps by which the processor's samples are late. */
const LATE = 8;
/** The force on the bridge of a run of the command less that at rest, N, row by row. */
const bridge = (...args) => {
  const work = mkdtempSync(join(tmpdir(), "erard-sound-"));
  try {
    execFileSync(process.env.ERARD, ["press", ...args, "--out", work, "--force", "--quiet", "--record-every", "1"]);
    const [head, ...lines] = readFileSync(join(work, "run.csv"), "utf8").trim().split("\n");
    const column = head.split(",").indexOf("bridge_N");
    const forces = lines.map((line) => Number(line.split(",")[column]));
    return forces.map((n) => n - forces[0]);
  } finally {
    rmSync(work, { recursive: true, force: true });
  }
};
const heard = async (page, button, said) => {
  await page.click(button);
  await until(page, (said) => /^(Heard|No sound)/.test(document.querySelector(said).textContent), said, 120_000);
  const text = await page.textContent(said);
  assert.match(text, /^Heard/, text);
  return { text, notes: await page.evaluate(() => studio.sounds.map((note) => Array.from(note))) };
};
const peak = (note) => Math.max(...note.map(Math.abs));

/** The note's button: the samples are those of `press`, and what is turned is heard. */
export const note = async ({ visit }) => {
  const page = await visit("#a=concert-grand-strings");
  await page.click("button[aria-label='f, pressed']");
  const own = await heard(page, "#hear", "#hear-said");
  const theirs = bridge("--instrument", "concert-grand-strings", "--stroke", "f");
  assert(theirs.length > 5000 && peak(theirs) > 10, `${theirs.length} rows`);
  const compared = Math.min(theirs.length - 1, own.notes[0].length);
  // In steps that are halved near the strings, `press` asks the hand at each part, an action that is stepped once:
  // 1e-7.
  const most = 1e-6 * peak(theirs);
  for (let n = 0; n < compared; n++) {
    assert(Math.abs(own.notes[0][n] - theirs[n + 1]) < most, `sample ${n} of ${compared}: ${own.notes[0][n]} and ${theirs[n + 1]} N`);
  }
  // The built-in grand, whose string is rigid, is heard on the one with strings, with its own screws.
  const other = await visit("#tab=compare&a=concert-grand&b=concert-grand;hammer:11");
  await until(other, () => studio.loaded.length === 2);
  const two = await heard(other, "#hear-both", "#hear-both-said");
  assert.match(two.text, /A: mf, pressed on concert-grand-strings.*B: mf, pressed/);
  assert.equal(two.notes.length, 2);
  assert(Math.abs(peak(two.notes[0]) / peak(two.notes[1]) - 1) > 0.02, "a heavier hammer sounds the same");
  // What has no strings says so.
  const silent = await visit("#a=heavy-touch");
  await silent.click("#hear");
  await until(silent, () => document.getElementById("hear-said").textContent.startsWith("No sound: the string of heavy-touch is rigid"));
  return `${compared} samples of f, pressed, the same; ${peak(two.notes[0]).toFixed(1)} and ${peak(two.notes[1]).toFixed(1)} N with a heavier hammer`;
};

/** The audio thread, rendered offline, beside `press`. */
export const offline = async ({ visit }) => {
  const page = await visit("#tab=keyboard&keys=concert-grand-strings");
  const samples = await page.evaluate(async () => Array.from(await studio.rendered([[0, 40, 8]], 0.5)));
  const theirs = bridge("--instrument", "concert-grand-strings:key=40", "--force-step", "8N", "--duration", "0.5");
  let compared = 0, worst = 0;
  for (let row = 1; row < theirs.length && 2 * (row - 1 + LATE) < samples.length; row++) {
    worst = Math.max(worst, Math.abs(FULL_SCALE_N * samples[2 * (row - 1 + LATE)] - theirs[row]));
    compared += 1;
  }
  assert(compared > 5000 && peak(theirs) > 5, `${compared} rows, ${peak(theirs)} N`);
  assert(worst < 1e-5, `the worst of ${compared} samples is off by ${worst} N`);
  // Between the steps lies what the steps say of a band below 12 kHz: left out, a step is found again from the samples
  // between its neighbours, as each of those is from the steps.
  const odd = samples.filter((_, n) => n % 2), even = samples.filter((_, n) => n % 2 === 0);
  const weights = Array.from({ length: 8 }, (_, n) => { const x = Math.PI * (n + 0.5); return (Math.sin(x) / x) * (0.5 + 0.5 * Math.cos(x / 8)); });
  const sum = 2 * weights.reduce((a, b) => a + b);
  let square = 0, all = 0;
  for (let n = 3000; n < 11_000; n++) {
    const again = weights.reduce((total, one, k) => total + (one / sum) * (odd[n - 1 - k] + odd[n + k]), 0);
    square += (again - even[n]) ** 2;
    all += even[n] ** 2;
  }
  const left = 10 * Math.log10(square / all);
  assert(left < -25, `what lies between the steps is ${left.toFixed(1)} dB of the sound away from them`);
  return `${compared} samples, off by ${worst.toExponential(1)} N at most, of ${peak(theirs).toFixed(1)} N; between the steps ${left.toFixed(0)} dB`;
};

/** By its own button: heard, measured, and silent again. */
export const live = async ({ visit }) => {
  const page = await visit("#tab=keyboard&keys=concert-grand-strings");
  const ready = () => until(page, () => /real time|nothing is computed/.test(document.getElementById("keys-said").textContent), undefined, 120_000);
  await ready();
  await page.click("#sound");
  await until(page, () => document.getElementById("sound").getAttribute("aria-pressed") === "true" && document.getElementById("sound-said").textContent.startsWith("Heard"), undefined, 120_000);
  await page.focus("#keys");
  await page.keyboard.down("q");
  await until(page, () => document.getElementById("sound-level").value > 0.02, undefined, 60_000);
  await until(page, () => document.querySelectorAll("#impacts li").length > 0);
  await page.keyboard.up("q");
  await until(page, () => document.getElementById("sound-level").value < 0.01, undefined, 60_000);
  const said = await page.textContent("#sound-said");
  assert.match(said, /not what the soundboard radiates; (no drop-outs|\d+ drop-outs?, \d+\.\d s)/);
  await page.click("#sound");
  await ready();
  assert.equal(await page.getAttribute("#sound", "aria-pressed"), "false");
  // Where the browser has no audio thread the page says so, and plays on without.
  await page.evaluate(() => Object.defineProperty(AudioContext.prototype, "audioWorklet", { get: () => undefined }));
  await page.click("#sound");
  await until(page, () => document.getElementById("sound-said").textContent.startsWith("No sound: browsers give pages the audio thread"));
  await ready();
  return said;
};

/** Blocks of 128 samples of so many fingers that play fortissimo, beside their time. */
export const blocks = async ({ visit }) => {
  const page = await visit("#tab=keyboard&keys=concert-grand-strings");
  await until(page, () => /real time|nothing is computed/.test(document.getElementById("keys-said").textContent), undefined, 120_000);
  const cost = (fingers) => page.evaluate(async (fingers) => {
    const url = performance.getEntriesByType("resource").map(({ name }) => name).find((name) => name.includes("keys.worker"));
    const worker = new Worker(url, { type: "module" });
    const answer = (message) => new Promise((resolve) => {
      worker.onmessage = ({ data }) => resolve(data);
      worker.postMessage(message);
    });
    await answer({ kind: "open", module: studio.engine, name: "concert-grand-strings", step_s: 1 / 24e3 });
    const block_ms = 128 / 48, costs = [];
    for (let n = 0, keys = Array.from({ length: fingers }, (_, n) => 28 + 3 * n); n < 750; n++) {
      const forces = n % 125 === 0 ? keys.map((key) => [key, (n / 125) % 2 ? 0 : 12]) : [];
      costs.push((await answer({ kind: "frame", wall_ms: n * block_ms, forces, finger_m: null })).cost_ms / block_ms);
    }
    worker.terminate();
    return costs;
  }, fingers);
  let most = 0, said = [];
  for (const fingers of [1, 2, 3, 5, 10]) {
    const share = percentile(await cost(fingers), 0.99);
    said.push(`${fingers}: ${(100 * share).toFixed(0)} %`);
    if (share > 0.6) break;
    most = fingers;
  }
  goal(most >= 1, `a single key with strings takes more than 60 % of real time`);
  return `at the 99th of a hundred, of real time, by fingers: ${said.join(", ")}`;
};
