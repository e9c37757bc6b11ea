// A run's own Parquet file, dropped onto the page, is played as `press` plays it.
import { execFileSync } from "node:child_process";
import { mkdtempSync, readFileSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { assert, atRest, hammerSpeed, struck, until } from "./help.mjs";

const drop = (page, name, bytes) => page.evaluate(async ([name, base64]) => {
  const data = new DataTransfer();
  data.items.add(new File([Uint8Array.from(atob(base64), (c) => c.charCodeAt(0))], name));
  document.body.dispatchEvent(new DragEvent("drop", { dataTransfer: data, bubbles: true, cancelable: true }));
}, [name, Buffer.from(bytes).toString("base64")]);

export const parquet = async ({ visit }) => {
  const work = mkdtempSync(join(tmpdir(), "erard-parquet-"));
  try {
    const press = (...options) => execFileSync(process.env.ERARD, ["press", ...options, "--force", "--quiet"], { stdio: "ignore" });
    press("--stroke", "f", "--out", join(work, "played"));
    press(join(work, "played", "run.parquet"), "--out", join(work, "again"));
    const expected = Number(readFileSync(join(work, "again", "summary.json"), "utf8").match(/"hammer_speed_m_per_s": ([-+.e\d]+)/)[1]);
    const page = await visit();
    // Nothing of the reader is there before it is needed.
    const loaded = () => page.evaluate(() => performance.getEntriesByType("resource").some(({ name }) => name.includes("parquet")));
    const file = readFileSync(join(work, "played", "run.parquet"));
    const before = await loaded();
    await drop(page, "run.parquet", file);
    await struck(page);
    const speed = await hammerSpeed(page);
    assert.equal(speed, expected, "the same bits as the command's");
    await atRest(page);
    assert.equal(before, false, "the reader is loaded with the first file");
    assert((await page.textContent("#recorded")).includes("run.parquet"));
    // What it cannot be said plainly: half of a file, no recording, another's compression.
    await drop(page, "half.parquet", file.subarray(0, file.length / 2));
    await until(page, () => /half\.parquet: cannot be read as Parquet/.test(document.getElementById("notice").textContent));
    const renamed = Buffer.from(file);
    for (let at = renamed.indexOf("force_N"); at >= 0; at = renamed.indexOf("force_N", at + 1)) renamed.write("f0rce_N", at);
    for (let at = renamed.indexOf("key_m"); at >= 0; at = renamed.indexOf("key_m", at + 1)) renamed.write("k3y_m", at);
    await drop(page, "other.parquet", renamed);
    await until(page, () => /other\.parquet: .*neither a force nor a position/.test(document.getElementById("notice").textContent));
    assert.equal(await hammerSpeed(page), speed, "what was played is still there");
    return `${speed.toFixed(4)} m/s, as press`;
  } finally {
    rmSync(work, { recursive: true, force: true });
  }
};
