// Screws, files, two actions, the keyboard.
import { assert, atRest, hammerSpeed, goal, percentile, struck, until } from "./help.mjs";

const line = (page, name) => page.evaluate((name) => {
  const row = [...document.querySelectorAll("#panel-screws .sheet tbody tr")].find((one) => one.cells[0].textContent === name);
  return row && !row.classList.contains("waiting") ? Number.parseFloat(row.cells[1].textContent.replace("\u2212", "-")) : null;
}, name);
const measured = (page, name) => until(page, (name) => {
  const row = [...document.querySelectorAll("#panel-screws .sheet tbody tr")].find((one) => one.cells[0].textContent === name);
  return row && !row.classList.contains("waiting");
}, name, 120_000);
/** Waits until a line is measured and says something else. */
const changed = (page, name, before) => until(page, ([name, before]) => {
  const row = [...document.querySelectorAll("#panel-screws .sheet tbody tr")].find((one) => one.cells[0].textContent === name);
  return row && !row.classList.contains("waiting") && Number.parseFloat(row.cells[1].textContent.replace("\u2212", "-")) !== before;
}, [name, before], 120_000);
const turn = (page, dial, value) => page.evaluate(([dial, value]) => {
  const slider = document.querySelector(`[data-dial="${dial}"]`);
  slider.value = value;
  slider.dispatchEvent(new Event("input", { bubbles: true }));
}, [dial, value]);

export const screws = async ({ visit }) => {
  const page = await visit();
  await page.click("#tab-screws");
  await measured(page, "let-off");
  const before = await line(page, "let-off");
  const drawn = await page.innerHTML("#pictures svg g.one");
  await turn(page, "let_off", -1);
  await until(page, () => "let_off" in studio.state.a.turns && studio.loaded[0].text.includes("setting_mm = { value = -1"));
  await changed(page, "let-off", before);
  const after = await line(page, "let-off");
  assert(after > before + 0.5, `let-off was ${before} mm and is ${after} mm with the button 1 mm lower`);
  await until(page, (drawn) => document.querySelector("#pictures svg g.one").innerHTML !== drawn, drawn);
  // Undone and redone, in one step each however long the slider was dragged.
  for (const value of [-0.9, -0.8, -0.7]) await turn(page, "let_off", value);
  await until(page, () => studio.state.a.turns.let_off === -0.7);
  await page.click("#undo");
  await until(page, () => Object.keys(studio.state.a.turns).length === 0);
  await changed(page, "let-off", after);
  assert.equal(await line(page, "let-off"), before);
  await page.keyboard.press("Control+Shift+Z");
  await until(page, () => studio.state.a.turns.let_off === -0.7);
  await page.click("#reset");
  await until(page, () => Object.keys(studio.state.a.turns).length === 0);
  // Undo takes back one thing: of two typed values the last one, and the way back alone.
  const row = page.locator(".dial:has([data-dial=let_off])");
  const file = await page.evaluate(() => studio.loaded[0].dials.find(({ name }) => name === "let_off").value);
  const is = (change) => until(page, (value) => Math.abs((studio.state.a.turns.let_off ?? Infinity) - value) < 1e-9, file + change);
  for (const change of [0.5, -0.25]) {
    await row.locator(".exact").fill(`${change < 0 ? "" : "+"}${change}`);
    await row.locator(".exact").press("Enter");
    await is(change);
  }
  await row.locator(".back").click();
  await until(page, () => Object.keys(studio.state.a.turns).length === 0);
  for (const change of [-0.25, 0.5]) {
    await page.click("#undo");
    await is(change);
  }
  await page.click("#undo");
  await until(page, () => Object.keys(studio.state.a.turns).length === 0);
  // A value beyond the end of its range by digits that nobody sees is in it; by a digit that is read it is not.
  for (const [beyond, digits, flag] of [[0.4, 0, ""], [0.6, 1, " high"]]) {
    const said = await page.evaluate(async ([beyond, digits]) => {
      studio.measured ??= studio.bench.ask.bind(studio.bench);
      const lines = (await studio.measured({ kind: "sheet", key: 40 })).flatMap(({ lines }) => lines);
      const { usual: [, high], decimals } = lines.find(({ key }) => key === "check_mm");
      studio.bench.ask = async (question, group) => {
        const values = await studio.measured(question, group);
        return question.kind === "measure" && "check_mm" in values ? { ...values, check_mm: high + beyond * 10 ** -decimals } : values;
      };
      return `${(high + digits * 10 ** -decimals).toFixed(decimals)} mm`;
    }, [beyond, digits]);
    await turn(page, "let_off", file - beyond);
    await until(page, (said) => document.querySelector("tr[data-line=check_mm] td").textContent === said, said + flag, 120_000);
  }
  await page.evaluate(() => { studio.bench.ask = studio.measured; });
  await page.click("#reset");
  await until(page, () => Object.keys(studio.state.a.turns).length === 0);
  // A heavier hammer is a heavier touch, and the last lines come, too.
  await measured(page, "down-weight D");
  const down = await line(page, "down-weight D");
  await turn(page, "hammer", 10);
  await until(page, () => studio.loaded[0].setting.turns.hammer === 10);
  await changed(page, "down-weight D", down);
  const heavy = await line(page, "down-weight D");
  assert(heavy > down + 4, `${down} g, and ${heavy} g with a hammer that is 1.3 g heavier`);
  return `let-off ${before} to ${after} mm; down-weight ${down} to ${heavy} g`;
};

export const refused = async ({ visit }) => {
  const page = await visit("#tab=screws&a=concert-grand;let_off:4");
  // A button four millimetres too high: the hammer is never let off, and the page says what is wrong.
  await until(page, () => document.querySelector("#panel-screws .sheet .out") !== null, undefined, 120_000);
  const flagged = await page.textContent("#panel-screws .sheet .out");
  // What no file may be is refused, and what was there goes on.
  await page.evaluate(() => studio.turn(0, "let_off", 40));
  await until(page, () => document.getElementById("why").textContent.includes("let_off"));
  assert.match(await page.textContent("#why"), /expected a number from/);
  await page.click("#undo");
  await until(page, () => studio.refused === null);
  await page.keyboard.press("Escape");
  await page.evaluate(() => studio.push(5));
  await until(page, () => studio.poses[0].key_m > 0.005);
  return flagged.trim().slice(0, 60);
};

export const regulate = async ({ visit }) => {
  // What is in its range is left alone.
  const untouched = await visit("#tab=screws");
  await untouched.click("#regulate");
  await until(untouched, () => document.querySelector("#log")?.textContent.includes("nothing is turned"), undefined, 120_000);
  assert.deepEqual(await untouched.evaluate(() => studio.state.a.turns), {});
  const page = await visit("#tab=screws&a=concert-grand;let_off:-1.5;drop:1");
  await page.click("#regulate");
  await until(page, () => document.querySelector("#log ol") !== null, undefined, 120_000);
  const log = await page.textContent("#log");
  assert.match(log, /What was out of its usual range is at the trade.s norm/);
  assert.match(log, /let-off: .* mm, up by .* mm, (\d+ )?(\d\/\d )?turns?/);
  await until(page, () => studio.state.a.turns.let_off !== -1.5 && studio.loaded[0].setting.turns.let_off !== -1.5);
  await page.waitForTimeout(300);
  await measured(page, "let-off");
  const after = await line(page, "let-off");
  assert(Math.abs(after - 1.5) < 0.15, `${after} mm`);
  // The log counts a screw as the panel beside it does: from where the file has it.
  const field = await page.inputValue(".dial:has([data-dial=let_off]) .exact");
  const [, from, to] = log.match(/let-off: (\S+) to (\S+) mm/);
  const setting = await page.evaluate(() => studio.loaded[0].dials.find(({ name }) => name === "let_off").value);
  assert.deepEqual([from, to].map((said) => said.replace("\u2212", "-")), [(-1.5 - setting).toFixed(2), field]);
  await page.click("#undo");
  await until(page, () => studio.state.a.turns.let_off === -1.5);
  return `let-off ${after} mm`;
};

export const file = async ({ visit }) => {
  const page = await visit("#tab=file");
  const text = await page.inputValue("#file-text");
  const wrong = text.split("\n").findIndex((one) => one.startsWith("mass_g")) + 1;
  const lines = text.split("\n");
  lines[wrong - 1] = "mass_g = -1";
  await page.fill("#file-text", lines.join("\n"));
  await until(page, (wrong) => document.getElementById("file-said").textContent.includes(`Line ${wrong}, `), wrong);
  assert.match(await page.textContent("#file-said"), /mass_g/);
  assert.equal(await page.getAttribute("#file-text", "aria-invalid"), "true");
  await page.click("text=Go to the line");
  assert.equal(await page.evaluate(() => { const area = document.getElementById("file-text"); return area.value.slice(area.selectionStart, area.selectionEnd); }), "-1");
  // The last sound action plays on.
  await page.evaluate(() => studio.push(5));
  await struck(page);
  await page.evaluate(() => studio.push(0));
  await page.fill("#file-text", text.replace(/name = "[^"]*"/, 'name = "Mine"'));
  await until(page, () => document.getElementById("file-said").textContent === "The file has no errors." && studio.scenes[0].name === "Mine");
  // Saved, and opened again: the same bytes. What is no file at all is said, too.
  const [download] = await Promise.all([page.waitForEvent("download"), page.click("#save")]);
  const saved = await (await import("node:fs/promises")).readFile(await download.path(), "utf8");
  assert.equal(saved, await page.inputValue("#file-text"));
  await page.setInputFiles("#instrument-file", { name: "broken.toml", mimeType: "text/plain", buffer: Buffer.from('format = "erard-instrument/1"\nname = 3\n') });
  await until(page, () => document.getElementById("file-said").textContent.startsWith("Line 2, name"));
  await page.setInputFiles("#instrument-file", { name: "again.toml", mimeType: "text/plain", buffer: Buffer.from(saved) });
  await until(page, () => document.getElementById("file-said").textContent === "The file has no errors.");
};

export const compare = async ({ visit }) => {
  const page = await visit("#tab=compare");
  await page.selectOption("#other", "heavy-touch");
  await until(page, () => studio.scenes.length === 2);
  await page.evaluate(() => studio.stroke({ nuance: "mf", struck: false }));
  await until(page, () => studio.hammerSpeedOf(0) > 0 && studio.hammerSpeedOf(1) > 0);
  await atRest(page);
  const [a, b] = await page.evaluate(() => [studio.hammerSpeedOf(0), studio.hammerSpeedOf(1)]);
  assert(Math.abs(a - b) > 0.01, "two actions, two impacts");
  const row = await page.evaluate(() => [...document.querySelectorAll("#differences tbody tr")][0].innerText);
  assert(row.includes(a.toFixed(2)) && row.includes(b.toFixed(2)), row);
  assert.equal(await page.locator("#pictures svg").count(), 1);
  await page.check("#beside");
  await until(page, () => document.querySelectorAll("#pictures svg.action").length === 2);
  await page.check("#difference");
  await until(page, () => document.getElementById("curves").textContent.includes("B \u2212 A"));
  // One finger on both: grasped in the second picture, too.
  const second = await page.evaluate(() => {
    const box = [...document.querySelectorAll("#pictures svg.action")[1].querySelectorAll(".key")].map((part) => part.getBoundingClientRect()).sort((p, q) => q.width - p.width)[0];
    return { x: box.left + 0.15 * box.width, y: box.top + box.height / 2 };
  });
  await page.mouse.move(second.x, second.y);
  await page.mouse.down();
  for (let n = 1; n <= 6; n++) await page.mouse.move(second.x, second.y + 10 * n);
  await until(page, () => studio.poses.every(({ key_m }) => key_m > 0.006));
  await page.mouse.up();
  await page.click("#swap");
  await until(page, () => studio.loaded[0]?.setting.base.builtin === "heavy-touch" && studio.loaded[1]?.setting.base.builtin === "concert-grand");
  return `${a.toFixed(2)} and ${b.toFixed(2)} m/s`;
};

/** A keyboard whose strings sound, by its name: a chord is heard at the bridge, longer with the pedal down. */
export const strung = async ({ visit }) => {
  const page = await visit("#tab=keyboard");
  await page.waitForFunction(() => document.querySelectorAll("#which-keyboard option").length === 3);
  const ready = () => until(page, () => /real time|nothing is computed/.test(document.getElementById("keys-said").textContent), undefined, 120_000);
  await ready();
  assert(await page.isHidden("#heard") && (await page.isHidden("#bridge-level")), "rigid strings are not heard");
  await page.selectOption("#which-keyboard", "concert-grand-strings");
  await until(page, () => location.hash.includes("keys=concert-grand-strings"));
  await ready();
  await page.waitForSelector("#heard canvas");
  const loudest = () => page.evaluate(() => Math.max(...document.getElementById("bridge-level").textContent.match(/\d+\.\d/g).map(Number)));
  const resting = await loudest();
  await page.click("#ten");
  await until(page, () => document.querySelectorAll("#impacts li").length >= 8);
  await until(page, (resting) => Math.max(...document.getElementById("bridge-level").textContent.match(/\d+\.\d/g).map(Number)) > resting + 20, resting);
  // Once the dampers lie on the strings again they are as still as at first.
  await until(page, (resting) => Math.max(...document.getElementById("bridge-level").textContent.match(/\d+\.\d/g).map(Number)) < resting + 5, resting, 60_000);
  // With the pedal down the strings go on when the keys are up again.
  await page.check("#keys-pedal");
  await page.waitForTimeout(500);
  await page.click("#ten");
  await page.waitForTimeout(3000);
  const spread = () => page.evaluate(() => { const [low, high] = document.getElementById("bridge-level").textContent.match(/\u2212?\d+\.\d/g).map((text) => Number(text.replace("\u2212", "-"))); return high - low; });
  assert((await spread()) > 2, `${await spread()} N between the least and the greatest`);
  const timing = await page.evaluate(() => studio.keysTiming);
  const busy = timing.filter(([, , awake]) => awake >= 10).map(([cost, steps]) => cost / (steps * 0.05));
  await page.click("#open-key");
  await until(page, () => studio.loaded[0].setting.base.keyboard === "concert-grand-strings" && location.hash.includes(":concert-grand-strings"));
  return `${resting} N at rest; ten keys and more take ${(100 * percentile(busy, 0.5)).toFixed(0)} % of real time in the middle`;
};

export const keyboard = async ({ visit }) => {
  const page = await visit("#tab=keyboard");
  await until(page, () => !document.getElementById("keys-said").textContent.includes("ready"), undefined, 120_000);
  // Ten keys at once stay in real time: the steps of a frame cost less than the frame.
  await page.click("#ten");
  await until(page, () => document.querySelectorAll("#impacts li").length >= 8);
  await page.waitForTimeout(1800);
  await page.click("#ten");
  await page.waitForTimeout(1500);
  const timing = await page.evaluate(() => studio.keysTiming);
  const busy = timing.filter(([, , awake]) => awake >= 10).map(([cost, steps]) => cost / (steps * 0.05));
  assert(busy.length > 0, "ten keys were awake");
  const share = percentile(busy, 0.5);
  goal(share < 1, `ten keys take ${(100 * share).toFixed(0)} % of real time`);
  // Not only in the middle: nothing of the time in which they were played was left out.
  const asked = timing.reduce((sum, [, steps]) => sum + steps, 0);
  const late = await page.evaluate(() => studio.keysLate);
  goal(late < 0.05 * asked * 50e-6, `${late} s of ${asked * 50e-6} s were left out`);
  // Ten fingers on the glass, at once.
  const box = await page.locator("#keys").boundingBox();
  const devtools = await page.context().newCDPSession(page);
  const fingers = Array.from({ length: 10 }, (_, n) => ({ x: box.x + box.width * (0.08 + 0.09 * n), y: box.y + 0.9 * box.height, id: n + 1 }));
  await page.evaluate(() => document.getElementById("impacts").replaceChildren());
  await devtools.send("Input.dispatchTouchEvent", { type: "touchStart", touchPoints: fingers });
  await until(page, () => new Set([...document.querySelectorAll("#impacts li")].map((row) => row.textContent.split(" ")[0])).size >= 10);
  await devtools.send("Input.dispatchTouchEvent", { type: "touchEnd", touchPoints: [] });
  // A key that is pressed again before its hammer has come back does not strike, here as on a piano.
  await until(page, () => document.getElementById("keys-said").textContent.startsWith("All keys rest"));
  // The action of the key that was pressed last is in the picture, and its key can be dragged.
  await until(page, () => document.querySelector(".inside svg .key") !== null);
  const dragged = await page.evaluate(() => {
    const parts = [...document.querySelectorAll(".inside svg .key")].map((part) => part.getBoundingClientRect()).sort((a, b) => b.width - a.width);
    return { x: parts[0].left + 0.12 * parts[0].width, y: parts[0].top + parts[0].height / 2 };
  });
  await page.evaluate(() => document.getElementById("impacts").replaceChildren());
  await page.mouse.move(dragged.x, dragged.y);
  await page.mouse.down();
  for (let n = 1; n <= 10; n++) await page.mouse.move(dragged.x, dragged.y + 8 * n);
  await until(page, () => document.querySelector("#impacts li") !== null);
  await page.mouse.up();
  // A key is chosen and looked into.
  await page.focus("#keys");
  const before = Number((await page.textContent("#chosen")).match(/key (\d+)/)[1]);
  await page.keyboard.press("ArrowDown");
  assert.equal(Number((await page.textContent("#chosen")).match(/key (\d+)/)[1]), before - 12);
  const said = await page.evaluate(() => document.querySelector("#impacts li").textContent);
  await page.keyboard.down("q");
  await until(page, (said) => document.querySelector("#impacts li").textContent !== said || document.querySelector("#impacts li").textContent.startsWith("C4"), said);
  await page.keyboard.up("q");
  await page.mouse.move(box.x + 0.02 * box.width, box.y + 0.95 * box.height);
  await page.mouse.down();
  await until(page, () => document.querySelector("#impacts li").textContent.startsWith("B0") || document.querySelector("#impacts li").textContent.startsWith("A0"));
  await page.mouse.up();
  await page.click("#open-key");
  await until(page, () => studio.state.tab === "play" && studio.loaded[0].setting.base.key > 0);
  await page.evaluate(() => studio.push(8));
  await struck(page);
  return `ten keys take ${(100 * share).toFixed(0)} % of real time in the middle, ${(100 * percentile(busy, 0.95)).toFixed(0)} % at the 95th percentile`;
};
