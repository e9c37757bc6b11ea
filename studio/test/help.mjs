// What several tests ask of the page.
import assert from "node:assert/strict";

export { assert };
/** Goals of time that were missed. What else the machine does decides them, too, so they fail with `--timed` only. */
export const missed = [];
export const goal = (holds, text) => { if (!holds) missed.push(text); };
/** Waits until something holds in the page. What is not there yet (a figure before its first picture) is waited for,
 * too. */
export const until = async (page, holds, given, timeout = 30_000) => {
  const end = performance.now() + timeout;
  for (;;) {
    try {
      await page.waitForFunction(holds, given, { timeout: Math.max(end - performance.now(), 1), polling: 50 });
      return;
    } catch (error) {
      if (/TypeError/.test(error.message) && performance.now() < end) {
        await page.waitForTimeout(50);
        continue;
      }
      throw new Error(`waited in vain for ${holds.toString().replace(/\s+/g, " ").slice(0, 200)}: ${error.message.split("\n")[0]}`);
    }
  }
};
/** Hammer speed at the last impact of action A, m/s; undefined before the first. */
export const hammerSpeed = (page) => page.evaluate(() => studio.hammerSpeedOf(0));
export const struck = (page) => until(page, () => studio.hammerSpeedOf(0) > 0);
/** The key's travel now, mm. */
export const key = (page) => page.evaluate(() => 1e3 * studio.poses[0].key_m);
export const atRest = (page) => until(page, () => document.getElementById("clock").textContent === "at rest");
/** Where the finger may be put on the key, px. */
export const onKey = async (page) => {
  const box = await page.evaluate(() => {
    const all = [...document.querySelectorAll("#pictures svg .key")].map((part) => part.getBoundingClientRect()).filter((one) => one.width > 100);
    const { left, top, height } = all.sort((a, b) => b.width - a.width)[0];
    return { x: left + 0.12 * all[0].width, y: top + height / 2 };
  });
  return box;
};
export const percentile = (values, share) => [...values].sort((a, b) => a - b)[Math.min(Math.floor(values.length * share), values.length - 1)];
