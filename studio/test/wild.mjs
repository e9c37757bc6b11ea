// Random playing: pointers, keys, sliders, tabs, strokes. Nothing fails, nothing is kept, frames and steps stay in
// time.
import { assert, goal, onKey, percentile, until } from "./help.mjs";

/** The same every time: a linear congruence. */
const random = (seed) => () => (seed = (Math.imul(seed, 1664525) + 1013904223) >>> 0) / 2 ** 32;

/** What is kept, bytes: of the page after a collection, and the most that any engine has. */
const kept = async (page) => {
  await page.evaluate(() => globalThis.gc?.());
  await page.waitForTimeout(100);
  await page.evaluate(() => globalThis.gc?.());
  const heap = await page.evaluate(() => performance.memory.usedJSHeapSize);
  const player = page.workers().find((one) => one.url().includes("player"));
  const engine = await player.evaluate(() => { globalThis.gc?.(); return { memory: globalThis.player.library.memoryBytes, heap: performance.memory?.usedJSHeapSize ?? 0 }; });
  return { heap, engine: engine.memory, worker: engine.heap };
};

export const wild = async ({ visit }, seconds) => {
  const page = await visit();
  const chance = random(20261122);
  const pick = (list) => list[Math.floor(chance() * list.length)];
  const dials = ["let_off", "drop", "capstan_height", "back_check", "hammer", "capstan", "knuckle", "leads", "front_punching"];
  const acts = [
    async () => {
      if (!(await page.isVisible("#pictures svg"))) await page.click("#tab-play");
      const { x, y } = await onKey(page);
      await page.mouse.move(x, y);
      await page.mouse.down();
      for (let n = 0; n < 12; n++) await page.mouse.move(x, y + 90 * chance());
      await page.mouse.up();
    },
    async () => {
      for (let n = 0; n < 6; n++) {
        await page.evaluate((force) => studio.push(force), 30 * chance());
        await page.waitForTimeout(120 * chance());
        await page.evaluate(() => studio.push(0));
        await page.waitForTimeout(90 * chance());
      }
    },
    async () => page.evaluate(([nuance, struck]) => studio.stroke({ nuance, struck }), [pick(["pp", "p", "mf", "f", "ff"]), chance() < 0.5]),
    async () => page.evaluate(async ([name, share]) => {
      const dial = studio.loaded[0].dials.find((one) => one.name === name);
      if (dial) await studio.turn(0, name, dial.from + share * (dial.to - dial.from));
    }, [pick(dials), chance()]),
    async () => page.evaluate(() => studio.undo()),
    async () => page.evaluate(() => studio.redo()),
    async () => page.evaluate(() => studio.change({ a: { ...studio.state.a, turns: {} } })),
    async () => page.click(`#tab-${pick(["play", "screws", "compare", "file", "keyboard", "diagnose"])}`),
    async () => page.evaluate((b) => studio.change({ b: b && { base: { builtin: b }, turns: {} } }), pick([null, null, "heavy-touch", "steinway-o", "concert-grand-strings"])),
    async () => page.evaluate((on) => studio.change({ beside: on }), chance() < 0.5),
    async () => page.evaluate(() => studio.replay()),
    async () => page.evaluate(() => studio.goLive()),
    async () => page.evaluate((share) => studio.pictures[0].zoom(0.5 + share), chance()),
    async () => page.evaluate(() => studio.pictures[0].lookWhole()),
    async () => page.evaluate(([part, action]) => studio.onchoose(part ? { action, part } : null), [pick([null, "jack", "let-off button", "string", "hammer felt"]), 0]),
    async () => page.evaluate((pedal) => studio.change({ pedal }), 10 * chance()),
    async () => {
      // A hand anywhere in the picture: on a part with a screw, on another, on none.
      if (!(await page.isVisible("#pictures svg"))) return;
      const { x, y, width, height } = await page.locator("#pictures").boundingBox();
      await page.mouse.move(x + width * (0.5 + 0.45 * chance()), y + height * (0.2 + 0.6 * chance()));
      await page.mouse.down();
      for (let n = 0; n < 6; n++) await page.mouse.move(x + width * (0.5 + 0.45 * chance()), y + height * (0.2 + 0.6 * chance()));
      await page.mouse.up();
    },
  ];
  /** Everything as at first, so that what is kept can be compared. */
  const home = async () => {
    await page.evaluate(() => { studio.push(0); studio.goLive(); studio.pictures[0].lookWhole(); });
    await page.click("#tab-play");
    await page.evaluate(() => studio.change({ a: { base: { builtin: "concert-grand" }, turns: {} }, b: null, beside: false, pedal: 0 }));
    await page.evaluate(() => studio.onchoose(null));
    await until(page, () => studio.scenes.length === 1 && document.getElementById("clock").textContent === "at rest");
    return kept(page);
  };
  const samples = [];
  let acted = 0;
  const rounds = 6;
  for (let round = 0; round < rounds; round++) {
    const end = performance.now() + (1000 * seconds) / rounds;
    while (performance.now() < end) {
      await pick(acts)();
      await page.waitForTimeout(60 * chance());
      acted++;
    }
    assert(await page.evaluate(() => document.getElementById("fault").hidden), await page.textContent("#fault"));
    samples.push(await home());
  }
  // The first round fills caches; after it nothing grows but by what one undo step and one sheet keep.
  const mb = (bytes) => (bytes / 1e6).toFixed(1);
  const [, first, ...later] = samples;
  const last = later.at(-1);
  const grown = last.heap - first.heap;
  assert(grown < 4e6 + 0.15 * first.heap, `the page kept ${mb(first.heap)} MB, then ${mb(last.heap)} MB`);
  assert(last.engine <= first.engine + 4e6, `the engine has ${mb(first.engine)} MB, then ${mb(last.engine)} MB`);
  // Frames and steps while one plays, and nothing else is asked for.
  await page.evaluate(() => { for (const list of Object.values(studio.timing)) list.length = 0; });
  for (let n = 0; n < 12; n++) {
    await acts[0]();
    await page.waitForTimeout(150);
  }
  const timing = await page.evaluate(() => studio.timing);
  const frames = timing.frames, steps = timing.costs.map((cost, n) => [cost, timing.steps[n]]).filter(([, count]) => count > 50).map(([cost, count]) => (1e3 * cost) / count);
  // Sixty frames a second, of which a busy machine loses some, and steps in real time.
  goal(percentile(frames, 0.5) < 20, `a frame takes ${percentile(frames, 0.5).toFixed(1)} ms`);
  goal(percentile(frames, 0.95) < 67, `a frame in twenty takes ${percentile(frames, 0.95).toFixed(1)} ms`);
  goal(percentile(steps, 0.95) < 50, `a step in twenty takes ${percentile(steps, 0.95).toFixed(1)} us; there are 50`);
  return `${acted} acts in ${seconds} s; heap ${samples.map(({ heap }) => mb(heap)).join(", ")} MB, engine ${mb(last.engine)} MB; ` +
    `frames ${percentile(frames, 0.5).toFixed(1)} ms, 95th percentile ${percentile(frames, 0.95).toFixed(1)} ms; a step ${percentile(steps, 0.5).toFixed(1)} us, 95th percentile ${percentile(steps, 0.95).toFixed(1)} us`;
};
