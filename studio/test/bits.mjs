// The page is the engine: each stroke's button plays what `press` plays, whatever was done before it, and the run that
// the page saves is that of the command, byte for byte.
import { execFileSync } from "node:child_process";
import { mkdtempSync, readFileSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { assert, onKey, until } from "./help.mjs";

const NUANCES = ["pp", "p", "mf", "f", "ff"];
/** Key, hammer, force of the finger and the angles of a run's rows, as the page keeps them: in single precision. */
const rowsOf = (text) => {
  const [head, ...lines] = text.trim().split("\n");
  const titles = head.split(",");
  const angles = titles.map((title, column) => [title, column]).filter(([title]) => title.endsWith("_rad")).map(([, column]) => column);
  const columns = [titles.indexOf("key_m"), titles.indexOf("hammer_rise_m"), ...angles];
  return lines.map((line) => {
    const cells = line.split(",");
    return columns.map((column) => Math.fround(Number(cells[column])));
  });
};
/** What the page has kept of its last stroke: so many rows from its first. */
const kept = (page, rows) => page.workers().find((one) => one.url().includes("player")).evaluate((rows) => {
  const [played] = globalThis.player.actions, { ring, bodies } = played;
  const first = ring.find(0);
  if (ring.timeOf(first) !== 0) throw new Error(`the page keeps nothing of the stroke's beginning, but ${ring.timeOf(first)} s`);
  return Array.from({ length: rows }, (_, n) => {
    const row = ring.row(first + n);
    return [row[0], row[1], ...row.subarray(5, 5 + bodies)];
  });
}, rows);
const ended = async (page) => {
  const worker = page.workers().find((one) => one.url().includes("player"));
  for (;;) {
    if (await worker.evaluate(() => !globalThis.player.striking)) return;
    await page.waitForTimeout(100);
  }
};
const exported = async (page) => {
  const [download] = await Promise.all([page.waitForEvent("download"), page.click("#save-run")]);
  assert.equal(download.suggestedFilename(), "run.csv");
  return readFileSync(await download.path(), "utf8");
};

/** What a visitor may have done before a stroke's button. */
const BEFORE = {
  "a slider moved": (page) => page.evaluate(() => {
    const slider = document.querySelector("[aria-label='firmness of the fingertip']");
    slider.value = "1";
    slider.dispatchEvent(new Event("input", { bubbles: true }));
  }),
  "a key pressed by mouse": async (page) => {
    const { x, y } = await onKey(page);
    await page.mouse.move(x, y);
    await page.mouse.down();
    for (let n = 1; n <= 6; n++) await page.mouse.move(x, y + 8 * n);
    await page.mouse.up();
  },
  "another stroke 0.2 s ago": async (page) => {
    await page.click("button[aria-label='pp, pressed']");
    await page.waitForTimeout(200);
  },
};

export const bits = async ({ visit }) => {
  const work = mkdtempSync(join(tmpdir(), "erard-bits-"));
  let compared = 0;
  const native = new Map();
  const press = (nuance, touch) => {
    const name = `${nuance}-${touch}`;
    if (!native.has(name)) {
      execFileSync(process.env.ERARD, ["press", "--stroke", nuance, "--touch", touch, "--out", join(work, name), "--force", "--quiet"]);
      native.set(name, readFileSync(join(work, name, "run.csv"), "utf8"));
    }
    return native.get(name);
  };
  const compare = async (page, nuance, touch, before) => {
    const theirs = rowsOf(press(nuance, touch));
    await page.click(`button[aria-label='${nuance}, ${touch}']`);
    await until(page, () => document.getElementById("clock").textContent !== "at rest");
    await ended(page);
    const ours = await kept(page, theirs.length);
    theirs.forEach((row, n) => row.forEach((value, column) => {
      if (!Object.is(value + 0, ours[n][column] + 0)) assert.fail(`${nuance} ${touch} after ${before}: row ${n}, number ${column}: ${ours[n][column]} and not ${value}`);
    }));
    compared += theirs.length;
    const last_push = await page.evaluate(() => studio.events[0].key_bottom_s - studio.events[0].key_start_s);
    assert(!(last_push < 0), `${nuance} ${touch} after ${before}: the key is down ${last_push} s after its start`);
  };
  try {
    // A small picture: the strokes are played in real time, as fast as it is drawn.
    const page = await visit("", { viewport: { width: 620, height: 480 } });
    for (const touch of ["pressed", "struck"]) for (const nuance of NUANCES) await compare(page, nuance, touch, "another stroke");
    for (const [before, act] of Object.entries(BEFORE)) {
      await act(page);
      await compare(page, "f", "struck", before);
    }
    // The saved run, whole: of the first and of the last stroke that was played.
    assert.equal(await exported(page), press("f", "struck"), "the saved run is not that of the command");
    await compare(page, "mf", "pressed", "a saved run");
    assert.equal(await exported(page), press("mf", "pressed"), "the saved run is not that of the command");
  } finally {
    rmSync(work, { recursive: true, force: true });
  }
  return `${compared} rows of ${2 * NUANCES.length + Object.keys(BEFORE).length + 1} strokes by their buttons, the same bits; two saved runs, the same bytes`;
};
