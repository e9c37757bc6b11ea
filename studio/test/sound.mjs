// What is heard: notes that the workshop renders, beside the command's; a keyboard in the audio thread, rendered
// offline, beside the command's; the same keyboard by its own button; what blocks of samples cost.
import { execFileSync } from "node:child_process";
import { mkdtempSync, readFileSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { assert, goal, percentile, until } from "./help.mjs";
import { to } from "./story.mjs";

/** Full scale of the command's sounds, Pa, in its source: the page's is compared with it, sample by sample. */
const FULL_SCALE_PA = Number(/FULL_SCALE_PA: f64 = ([0-9.]+);/.exec(readFileSync(new URL("../../crates/erard-cli/src/wav.rs", import.meta.url), "utf8"))[1]);
/** Steps by which the processor's samples are late. */
const LATE = 8;
/** A press of the command: the force on the bridge less that at rest, N, row by row; and its sound left and right, Pa,
 * of which every other sample is taken, so that they lie at the ends of the page's steps. */
const pressed = (...args) => {
  const work = mkdtempSync(join(tmpdir(), "erard-sound-"));
  try {
    execFileSync(process.env.ERARD, ["press", ...args, "--out", work, "--force", "--quiet", "--record-every", "1", "--wav"]);
    const [head, ...lines] = readFileSync(join(work, "run.csv"), "utf8").trim().split("\n");
    const column = head.split(",").indexOf("bridge_N");
    const forces = lines.map((line) => Number(line.split(",")[column]));
    const file = readFileSync(join(work, "note.wav")), from = file.indexOf("data") + 8;
    const samples = new Int16Array(file.buffer.slice(file.byteOffset + from, file.byteOffset + file.length));
    const channels = [0, 1].map((channel) => Array.from({ length: Math.floor(samples.length / 4) }, (_, n) => (FULL_SCALE_PA / 32767) * samples[4 * n + 2 + channel]));
    return { bridge_n: forces.map((n) => n - forces[0]), channels };
  } finally {
    rmSync(work, { recursive: true, force: true });
  }
};
/** How far samples are from the command's, which takes steps a quarter as long: what is left, and the difference of
 * their levels, dB. */
const beside = (own, theirs) => {
  const count = Math.min(own.length, theirs.length);
  const power = (of) => { let sum = 0; for (let n = 0; n < count; n++) sum += of(n) ** 2; return sum; };
  const all = power((n) => theirs[n]);
  return { left_db: 10 * Math.log10(power((n) => own[n] - theirs[n]) / all), louder_db: 10 * Math.log10(power((n) => own[n]) / all), count };
};
/** Holds what is heard beside the command's sound, and says how far it is. */
const sounds_alike = (own, theirs, most) => {
  const found = own.map((samples, channel) => beside(samples, theirs[channel]));
  const said = found.map(({ left_db, louder_db }) => `${left_db.toFixed(0)} dB (${louder_db.toFixed(2)} dB louder)`).join(" and ");
  assert(theirs.every((samples) => peak(samples) > 0.1) && found.every(({ count }) => count > 5000), `${found[0].count} samples`);
  assert(found.every(({ left_db, louder_db }) => left_db < most.left_db && Math.abs(louder_db) < most.louder_db), said);
  return said;
};
const heard = async (page, button, said) => {
  await page.click(button);
  await until(page, (said) => /^(Heard|No sound)/.test(document.querySelector(said).textContent), said, 120_000);
  const text = await page.textContent(said);
  assert.match(text, /^Heard/, text);
  return { text, notes: await page.evaluate(() => studio.sounds.map(({ unit, channels, bridge_n }) => ({ unit, channels: channels.map((one) => Array.from(one)), bridge_n: Array.from(bridge_n) }))) };
};
const peak = (note) => Math.max(...note.map(Math.abs));

/** The note's button: the samples are those of `press`, and what is turned is heard. */
export const note = async ({ visit }) => {
  const page = await visit("#a=concert-grand-strings");
  await page.click("button[aria-label='f, pressed']");
  const own = await heard(page, "#hear", "#hear-said");
  const run = pressed("--instrument", "concert-grand-strings", "--stroke", "f"), theirs = run.bridge_n;
  assert(theirs.length > 5000 && peak(theirs) > 10, `${theirs.length} rows`);
  const { bridge_n } = own.notes[0], compared = Math.min(theirs.length - 1, bridge_n.length);
  // In steps that are halved near the strings, `press` asks the hand at each part, an action that is stepped once:
  // 1e-7.
  const most = 1e-6 * peak(theirs);
  for (let n = 0; n < compared; n++) {
    assert(Math.abs(bridge_n[n] - theirs[n + 1]) < most, `sample ${n} of ${compared}: ${bridge_n[n]} and ${theirs[n + 1]} N`);
  }
  assert.equal(own.notes[0].unit, "Pa");
  const alike = sounds_alike(own.notes[0].channels, run.channels, { left_db: -20, louder_db: 0.3 });
  // The built-in grand, whose string is rigid, is heard on the one with strings, with its own screws.
  const other = await visit("#tab=compare&a=concert-grand&b=concert-grand;hammer:11");
  await until(other, () => studio.loaded.length === 2);
  const two = await heard(other, "#hear-both", "#hear-both-said");
  assert.match(two.text, /A: mf, pressed on concert-grand-strings.*B: mf, pressed/);
  assert.equal(two.notes.length, 2);
  const peaks = two.notes.map((note) => peak(note.bridge_n));
  assert(Math.abs(peaks[0] / peaks[1] - 1) > 0.02, "a heavier hammer sounds the same");
  const heavier = [0, 1].map((channel) => beside(two.notes[1].channels[channel], two.notes[0].channels[channel]).louder_db);
  assert(heavier.every((louder_db) => Math.abs(louder_db) > 0.05), `a heavier hammer is louder by ${heavier} dB`);
  // What has no strings says so.
  const silent = await visit("#a=heavy-touch");
  await silent.click("#hear");
  await until(silent, () => document.getElementById("hear-said").textContent.startsWith("No sound: the string of heavy-touch is rigid"));
  return `${compared} samples of f, pressed, the same force; the sound beside the command's: ${alike}; with a heavier hammer ${peaks[1].toFixed(1)} N for ${peaks[0].toFixed(1)}, ${heavier.map((louder_db) => louder_db.toFixed(2)).join(" and ")} dB louder`;
};

/** The audio thread, rendered offline, beside `press`; and as it is played, with fewer parts of a blow. */
export const offline = async ({ visit }) => {
  const page = await visit("#tab=keyboard&keys=concert-grand-strings");
  const render = (exact) => page.evaluate(async (exact) => (await studio.rendered([[0, 40, 8]], 0.5, exact)).map((one) => Array.from(one)), exact);
  const [exact, played] = [await render(true), await render(false)];
  const { channels } = pressed("--instrument", "concert-grand-strings:key=40", "--force-step", "8N", "--duration", "0.5");
  const steps = (channel) => Array.from({ length: Math.floor(channel.length / 2) - LATE }, (_, n) => FULL_SCALE_PA * channel[2 * (n + LATE)]);
  const alike = sounds_alike(exact.map(steps), channels, { left_db: -20, louder_db: 0.3 });
  const fewer = sounds_alike(played.map(steps), exact.map(steps), { left_db: -30, louder_db: 0.1 });
  const samples = exact[0];
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
  return `beside the command's sound: ${alike}; with fewer parts of a blow: ${fewer}; between the steps ${left.toFixed(0)} dB`;
};

/** The story's buttons: a hammer that is pushed to the string chokes its note, one that is set free lets it ring; the
 * damper ends it, unless the pedal is down. */
export const told = async ({ read }) => {
  const page = await read();
  /** How loud what a step plays still is so many seconds after the stroke began, dB below its loudest twentieth of a
   * second. */
  const faded_db = async (id, option, at_s) => {
    await to(page, id);
    if (option) await page.locator(`[data-scene=${id}] .switch label`).nth(option).click();
    await page.evaluate(() => (story.live.note = null));
    await page.click(`[data-scene=${id}] .listen`);
    await until(page, (id) => document.querySelector(`[data-scene=${id}] .heard`).textContent.startsWith("Heard: the pressure 1 m before the soundboard"), id, 120_000);
    const samples = await page.evaluate(() => Array.from(story.live.note.channels[0]));
    assert(samples.length === 48_000 && peak(samples) > 0.1, `${id}: ${samples.length} samples`);
    const level = (from) => samples.slice(from, from + 1200).reduce((sum, n) => sum + n * n, 0);
    const loudest = Math.max(...Array.from({ length: 39 }, (_, n) => level(1200 * n)));
    return 10 * Math.log10(loudest / level(Math.round(24e3 * at_s)));
  };
  const choked = await faded_db("flight", 0, 0.6), free = await faded_db("escapement", 0, 0.6);
  assert(choked > free + 5, `choked ${choked} dB, free ${free} dB`);
  const damped = await faded_db("damper", 0, 1.2), held = await faded_db("damper", 1, 1.2);
  assert(damped > held + 20, `damped ${damped} dB, with the pedal ${held} dB`);
  return `after 0.6 s a choked note is ${choked.toFixed(0)} dB down, a free one ${free.toFixed(0)} dB; let go ${damped.toFixed(0)} dB, with the pedal ${held.toFixed(0)} dB`;
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
  assert.match(said, /^Heard: the pressure 1 m before the soundboard, without a room; an estimate; (no drop-outs|\d+ drop-outs?, \d+\.\d s)/);
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
