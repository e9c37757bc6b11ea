// What is typed into the studio is read as the other fronts read it: the tables that command, C and Python are held
// against. Every row of the first is typed into the field for any number by its name; those of the second, generated
// from the register, go through the page's own call of the engine; then dials and readings.
import { readFileSync } from "node:fs";
import { assert, until } from "./help.mjs";

const table = (name) => readFileSync(new URL(`../../crates/erard-core/tests/${name}`, import.meta.url), "utf8").trimEnd().split("\n").slice(1).map((row) => row.split("\t"));

/** The number at a path of an instrument's file, in the file's unit. */
const numberAt = (text, path) => {
  const [list, name, ...keys] = path.split(".");
  const wanted = keys.length > 1 ? `[${[list, ...keys.slice(0, -1)].join(".")}]` : `[[${list}]]`;
  let header = "", own = keys.length ? "" : null;
  for (const line of text.split("\n")) {
    if (/^\[/.test(line)) {
      header = line.trim();
      if (header === `[[${list}]]`) own = "";
      continue;
    }
    const [, key, value] = /^(\w+)\s*=\s*(.*)$/.exec(line) ?? [];
    if (key === "name" && header === `[[${list}]]`) own = JSON.parse(value.replace(/\s*#.*$/, ""));
    // A number of a table of its own, as in finger.stiffness_N_per_m, or of the file.
    const here = keys.length ? own === name && header === wanted && key === keys.at(-1) : name ? header === `[${list}]` && key === name : header === "" && key === list;
    if (here) return Number.parseFloat(/^\{[^}]*?value\s*=\s*([^,}]+)/.exec(value)?.[1] ?? value);
  }
  return Number.NaN;
};

/** Whether a value is what a row expects of the present one. */
const holds = (expected, now, found) => {
  const [kind, by] = expected.split(" ");
  const wanted = kind === "set" ? Number(by) : kind === "add" ? now + Number(by) : now * Number(by);
  return Math.abs(found - wanted) <= 1e-8 * Math.abs(wanted) + 1e-15;
};

/** Where the first table's names are in the file, and the SI value of the file's unit. */
const PLACES = {
  let_off: ["screw.let_off.setting_mm", 1e-3], set_off: ["screw.let_off.setting_mm", 1e-3], back_check_angle: ["screw.back_check_angle.setting_deg", Math.PI / 180],
  "body.hammer.mass": ["body.hammer.mass_g", 1e-3], "body.wippen.mass": ["body.whippen.mass_g", 1e-3], "body.whippen.friction": ["body.whippen.friction_torque_N_m", 1],
  "zone.check.friction": ["zone.check.friction_coefficient", 1],
};

export const typed = async ({ visit }) => {
  const page = await visit("#tab=screws");
  const own = await page.evaluate(() => studio.loaded[0].text);
  // As a person types: a name, a change, Enter; and back.
  await page.click("#any summary");
  let rows = 0;
  for (const [name, text, command, other] of table("typed.tsv")) {
    // A list is the command's only: a decimal comma is read where one value is asked.
    const expected = command.startsWith("no type `") && !other.startsWith("no") ? other : text === "1,500" ? other : command;
    await page.fill("#changed-name", name);
    await page.fill("#changed-by", text);
    await page.press("#changed-by", "Enter");
    await until(page, (own) => !document.querySelector("#changed.waiting") && (!document.getElementById("changed-wrong").hidden || JSON.stringify(studio.loaded[0].setting.base).length > 100), own);
    const said = await page.evaluate(() => (document.getElementById("changed-wrong").hidden ? null : document.getElementById("changed-wrong").textContent));
    const row = `${name} ${text}: ${said ?? "read"}; expected ${expected}`;
    if (expected.startsWith("no ")) {
      assert(said?.includes(expected.slice(3)), row);
      assert.equal(await page.getAttribute("#changed-by", "aria-invalid"), "true");
    } else {
      assert.equal(said, null, row);
      const [path, si] = PLACES[name];
      const [now, found] = [own, await page.evaluate(() => studio.loaded[0].text)].map((file) => si * numberAt(file, path));
      assert(holds(expected, now, found), `${row}, found ${now} and then ${found}`);
      await page.click("#undo");
      await until(page, () => "builtin" in studio.loaded[0].setting.base);
    }
    rows++;
  }
  // The generated table, through the page's own call.
  const generated = table("typed-register.tsv");
  for (const instrument of new Set(generated.map(([of]) => of))) {
    const some = generated.filter(([of]) => of === instrument);
    const answers = await page.evaluate(async ([builtin, some]) => {
      const text = await studio.bench.ask({ kind: "base", of: { builtin } });
      const answers = [];
      for (const [, called, change] of some) answers.push(await studio.bench.ask({ kind: "vary", text, called, change }).catch((error) => ({ error: error.message })));
      return { text, answers };
    }, [instrument, some]);
    some.forEach(([, name, text, command, other, path, si], n) => {
      const expected = command === "-" || (command.startsWith("no type `") && !other.startsWith("no")) ? other : command;
      const answer = answers.answers[n];
      if (expected.startsWith("no ")) return assert(answer.error?.includes(expected.slice(3)), `${name} ${text}: ${answer.error ?? "read"}; expected ${expected}`);
      assert.equal(answer.error, undefined, `${name} ${text}: expected ${expected}`);
      // Of some numbers the file holds a part.
      if (!path) return;
      const [now, found] = [answers.text, answer].map((file) => Number(si) * numberAt(file, path));
      assert(holds(expected, now, found), `${name} ${text}: found ${now} and then ${found}; expected ${expected}`);
    });
  }
  // A dial's field: values, changes from the file, factors, any unit; what cannot be is said below it.
  const field = page.locator(".dial:has([data-dial=let_off])");
  const file = await page.evaluate(() => studio.loaded[0].dials.find(({ name }) => name === "let_off").value);
  for (const [text, value] of [["+0.5", file + 0.5], ["\u22120,2 mm", file - 0.2], ["0.3", 0.3], ["1/64in", 25.4 / 64], ["x2", 2 * file], ["0.004 inch", 0.1016], ["= -0.1mm", -0.1]]) {
    await field.locator(".exact").fill(text);
    await field.locator(".exact").press("Enter");
    await until(page, (value) => Math.abs((studio.loaded[0].setting.turns.let_off ?? Infinity) - value) < 1e-9, value);
    assert.match(await field.locator(".exact").inputValue(), /^[+-]\d\.\d\d$/);
  }
  for (const [text, told] of [["1,500", "may be 1.500 or 1500"], ["1 g", "`g` is not one of its units"], ["1 1/2", "`1 1/2in`"], ["50", "expected a number from"], ["ten", "expected a length"]]) {
    await field.locator(".exact").fill(text);
    await field.locator(".exact").press("Enter");
    await until(page, (told) => document.querySelector(".dial:has([data-dial=let_off]) .bad").textContent.includes(told), told);
    assert.equal(await field.locator(".exact").getAttribute("aria-invalid"), "true");
  }
  await field.locator(".back").click();
  await until(page, () => !("let_off" in studio.loaded[0].setting.turns));
  assert.equal(await field.locator(".bad").isVisible(), false);
  // Readings of one's own piano.
  await page.click("#tab-diagnose");
  await page.waitForSelector("[data-field=dip_mm] input");
  for (const [name, text, told] of [["dip_mm", "0.4in", "10.2 mm"], ["blow_mm", "1 7/8\u2033", "47.6 mm"], ["down_weight_g", "2oz", "56.7 g"], ["front_weight_g", "\u22128,6", "-8.6 g"], ["dip_mm", "1,500", null], ["dip_mm", "10g", null], ["dip_mm", "1/2", null]]) {
    await page.click("#clear");
    await page.fill(`[data-field=${name}] input`, text);
    await page.click("#diagnose");
    if (told) {
      await until(page, ([name, told]) => document.querySelector(`#diagnosis:not(.waiting) tr[data-reading=${name}] td`)?.textContent.replace("\u2212", "-") === told, [name, told]);
    } else await until(page, (name) => !document.querySelector(`[data-field=${name}] .bad`).hidden, name);
  }
  // Balance weight and friction weight instead of down-weight and up-weight; one of them alone is refused.
  await page.click("text=More readings");
  await page.click("#clear");
  await page.fill("[data-field=balance_weight_g] input", "38");
  await page.click("#diagnose");
  await until(page, () => document.querySelector("[data-field=balance_weight_g] .bad").textContent.includes("BW of 38 g alone"));
  await page.fill("[data-field=friction_weight_g] input", "0.02 kg");
  await page.click("#diagnose");
  await until(page, () => ["down_weight_g", "up_weight_g"].map((name) => document.querySelector(`#diagnosis:not(.waiting) tr[data-reading=${name}] td`)?.textContent).join() === "58.0 g,18.0 g");
  return `${rows} rows typed, ${generated.length} generated`;
};
