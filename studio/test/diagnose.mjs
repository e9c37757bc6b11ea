// One's own measurements: the form gives the command's answer for the same numbers, points at what cannot be, and makes
// a sheet that can be printed.
import { execFileSync } from "node:child_process";
import { mkdtempSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { assert, until } from "./help.mjs";

const answered = (page) => until(page, () => document.querySelector("#diagnosis:not(.waiting) .verdict") !== null);
/** Types readings as a person does, and asks. */
const type = async (page, readings) => {
  await page.click("#clear");
  for (const [name, text] of Object.entries(readings)) {
    const input = page.locator(`[data-field=${name}] input`);
    if (!await input.isVisible()) await page.click("text=More readings");
    await input.fill(text);
  }
  await page.click("#diagnose");
};
const wrong = (page) => page.evaluate(() => Object.fromEntries([...document.querySelectorAll(".reading")].map((one) => [one.dataset.field, one.querySelector(".bad")]).filter(([, bad]) => bad && !bad.hidden).map(([name, bad]) => [name, bad.textContent])));

/** The sets that are compared with the command: any subset, decimal commas, words, names of notes, leads. */
const SETS = [
  { readings: { key: "C4", down_weight_g: "58", up_weight_g: "18" } },
  { readings: { key: "40", let_off_mm: "3,5", drop_mm: "0" } },
  { readings: { down_weight_g: "58 g", up_weight_g: "18", let_off_mm: "3.5", drop_mm: "0", dip_mm: "10.1", blow_mm: "46.5", aftertouch_mm: "1.2", strike_weight_g: "9.4", leads: "14@165, 14@147", key_ratio: "0.51" } },
  { readings: { key: "c#4", dip_mm: "9", front_weight_g: "24", strike_weight_g: "9", down_weight_g: "50", up_weight_g: "26" }, of: "a sharp" },
  { readings: { key: "A0", down_weight_g: "52", up_weight_g: "27" }, of: "a sound key" },
  { readings: { key: "C4", down_weight_g: "58", up_weight_g: "18", let_off_mm: "3.5", drop_mm: "0", blow_mm: "47", tapped: "no" }, of: "a cause named, others open, and a question answered" },
];

export const diagnose = async ({ visit }) => {
  const page = await visit("#tab=diagnose");
  await page.waitForSelector("[data-field=down_weight_g] input");
  assert.equal(await page.locator(".stage").isVisible(), false, "the picture is of another piano");
  let compared = 0;
  for (const { readings } of SETS) {
    const options = Object.entries(readings).map(([name, text]) => `--${name.replace(/_(g|mm)$/, "").replaceAll("_", "-")}=${name === "leads" ? text.replaceAll(" ", "") : text}`);
    const work = mkdtempSync(join(tmpdir(), "erard-diagnose-"));
    const theirs = JSON.parse(execFileSync(process.env.ERARD, ["diagnose", "--json", ...options], { cwd: work }));
    rmSync(work, { recursive: true });
    const ours = await page.evaluate((readings) => studio.bench.ask({ kind: "diagnose", readings }), readings);
    assert(ours.answer, JSON.stringify(ours.faults));
    for (const [name, value] of Object.entries(ours.answer)) assert.deepEqual(value, theirs[name], `${name} of ${JSON.stringify(readings)}`);
    // What the page shows of it: every reading, every cause in its rank, what to do and what to measure next.
    await type(page, readings);
    await answered(page);
    const [key] = theirs.keys;
    const text = (await page.textContent("#diagnosis")).replaceAll("\u00a0", " ").replaceAll("\u2212", "-");
    assert(text.includes(`${key.note} (key ${key.key})`), text.slice(0, 80));
    assert.equal(text.includes("No key was named"), theirs.is_key_assumed);
    assert.deepEqual(await page.evaluate(() => [...document.querySelectorAll("#diagnosis [data-cause]")].map(({ dataset }) => dataset.cause)), key.causes.map(({ cause }) => cause));
    assert.deepEqual(await page.evaluate(() => [...document.querySelectorAll("#diagnosis [data-open]")].map(({ dataset }) => dataset.open)), key.undecided.map(({ cause }) => cause));
    assert.deepEqual(await page.evaluate(() => [...document.querySelectorAll("#diagnosis tr:has(.out)")].map(({ dataset }) => dataset.reading)), key.readings.filter(({ standing }) => standing === "out").map(({ name }) => name));
    for (const { value, decimals, label } of key.readings) assert(value === null || text.includes(value.toFixed(decimals)), `${label} ${value}`);
    for (const line of [...key.to_do, key.verdict, ...key.causes.flatMap(({ test, cure }) => [test, cure]), ...key.undecided.map(({ test }) => test), ...(key.open_question ? [key.open_question] : []), ...key.notes, ...(key.measure_next ? [`Measure next: ${key.measure_next.label}`] : [])]) assert(text.includes(line), line);
    compared++;
  }
  // D 58, U 18: balance 38 g and friction 20 g, and friction before all else; no lead is asked for.
  await type(page, { key: "C4", down_weight_g: "58", up_weight_g: "18", let_off_mm: "3.5", drop_mm: "0" });
  await answered(page);
  const cell = (name) => page.textContent(`#diagnosis tr[data-reading=${name}] td`);
  assert.deepEqual([await cell("balance_weight_g"), await cell("friction_weight_g"), await cell("drop_mm")], ["38.0 g", "20.0 g", "0.0 mm"]);
  assert.equal(await page.locator("#diagnosis [data-cause^=leads]").count(), 0);
  // The link keeps the numbers, and the printed sheet has them, with nothing else of the page.
  const link = await page.evaluate(() => studio.link());
  const other = await visit(link.slice(link.indexOf("#")));
  await answered(other);
  assert.equal(await other.textContent("#diagnosis"), await page.textContent("#diagnosis"));
  await other.click("text=Head of the printed sheet");
  await other.fill("#head-piano", "Model S 7");
  await other.press("#head-piano", "Enter");
  await until(other, () => document.querySelector("#diagnosis .head")?.textContent.includes("Model S 7"));
  await other.emulateMedia({ media: "print" });
  assert.deepEqual(await other.evaluate(() => ["header", "nav", ".stage", ".readings", "#diagnosis"].map((one) => document.querySelector(one).checkVisibility())), [false, false, false, false, true]);
  await other.emulateMedia({ media: "screen" });
  // What cannot be is pointed at beside its field, all of it at once, and no answer stays that is not of these numbers.
  await type(page, { down_weight_g: "18", up_weight_g: "58", drop_mm: "much", key: "H9", leads: "14" });
  // Every field that is left is answered; the leads' is the last.
  await until(page, () => document.querySelector("[data-field=leads] .bad:not([hidden])"));
  const told = await wrong(page);
  assert.deepEqual(Object.keys(told).sort(), ["drop_mm", "key", "leads", "up_weight_g"]);
  assert.match(told.up_weight_g, /are they swapped\?/);
  assert.match(told.drop_mm, /a number from 0 to 40 mm/);
  assert.equal(await page.getAttribute("[data-field=up_weight_g] input", "aria-invalid"), "true");
  assert.equal(await page.locator("#diagnosis > *").count(), 0);
  assert.equal(await page.isDisabled("#print"), true);
  // In a folded part it unfolds; mended, the faults are gone.
  await type(page, { repetition_spring_m_per_s: "soft" });
  await page.click("text=More readings");
  await page.click("#diagnose");
  await until(page, () => document.querySelector("[data-field=repetition_spring_m_per_s] .bad").checkVisibility());
  await page.fill("[data-field=repetition_spring_m_per_s] input", "weak");
  await page.press("[data-field=repetition_spring_m_per_s] input", "Enter");
  await answered(page);
  assert.deepEqual(await wrong(page), {});
  // An empty form says what it needs.
  await page.click("#clear");
  await page.click("#diagnose");
  await until(page, () => !document.getElementById("wrong-all").hidden);
  assert.match(await page.textContent("#wrong-all"), /No reading was given; expected one at least/);
  return `${compared} sets of readings, the command's own answers`;
};
