// The workbench's edges: what is labelled is what happens, nothing moves away under the pointer, and silence is
// explained.
import { assert, atRest, struck, until } from "./help.mjs";

export const edges = async ({ visit }) => {
  const page = await visit();
  // A button that was clicked leaves the space bar to the key.
  await page.click("#close-up");
  await page.keyboard.down(" ");
  await struck(page);
  await page.keyboard.up(" ");
  await until(page, () => studio.poses[0].key_m < 2e-4);
  await page.check("#naming");
  const first = await page.evaluate(() => studio.events[0].hammer_contact_s);
  await page.keyboard.down(" ");
  await until(page, (first) => studio.events[0].hammer_contact_s > first, first);
  await page.keyboard.up(" ");
  await atRest(page);
  // Too soft to sound: all the way down within two seconds. The page says so, until the next press.
  const slow = ["time_s,position_m", ...Array.from({ length: 101 }, (_, n) => `${(n / 50).toFixed(3)},${(n * 9.8e-5).toFixed(7)}`)].join("\n");
  await page.evaluate((csv) => studio.stroke({ csv, name: "slow.csv" }), slow);
  await until(page, () => !document.getElementById("soft").hidden);
  assert.match(await page.textContent("#soft"), /Too soft to sound/);
  assert.equal(await page.evaluate(() => studio.events[0].impact_count), 0);
  await atRest(page);
  await page.evaluate(() => studio.push(6));
  await struck(page);
  assert.equal(await page.isHidden("#soft"), true);
  await page.evaluate(() => studio.push(0));
  await until(page, () => studio.poses[0].key_m < 2e-4);
  // What happens now is slow, too, if that is wanted.
  await page.selectOption("#speed", String(1 / 20));
  await page.check("#slow");
  assert.match(await page.evaluate(() => studio.link()), /slow=1/);
  const before = await page.evaluate(() => [performance.now() / 1000, studio.poses[0].time_s]);
  await page.evaluate(() => studio.push(6));
  await page.waitForTimeout(700);
  const after = await page.evaluate(() => [performance.now() / 1000, studio.poses[0].time_s]);
  const pace = (after[1] - before[1]) / (after[0] - before[0]);
  assert(pace > 1 / 60 && pace < 1 / 15, `${pace} s of the action in a second, live at 1/20`);
  await page.uncheck("#slow");
  await page.evaluate(() => studio.push(0));
  // Screws start at 0, wherever the file has them; what they do is counted from there.
  await page.click("#tab-screws");
  const shown = (dial) => page.evaluate((dial) => Number(document.querySelector(`[data-dial="${dial}"]`).parentElement.querySelector(".exact").value), dial);
  const dials = await page.evaluate(() => studio.loaded[0].dials.map(({ name, group, value }) => ({ name, group, value })));
  for (const { name, group, value } of dials) {
    if (group === "screws") assert.equal(Math.abs(await shown(name)), 0, `${name} starts at ${await shown(name)}`);
    else assert(Math.abs((await shown(name)) - value) < 0.01 * Math.abs(value) + 0.01, `${name} shows ${await shown(name)} for ${value}`);
  }
  const file = dials.find(({ name }) => name === "let_off").value;
  await page.evaluate(() => {
    const number = document.querySelector('[data-dial="let_off"]').parentElement.querySelector(".exact");
    number.value = "-0.5";
    number.dispatchEvent(new Event("change", { bubbles: true }));
  });
  await until(page, () => "let_off" in studio.state.a.turns);
  const turned = await page.evaluate(() => studio.state.a.turns.let_off);
  assert(Math.abs(turned - (file - 0.5)) < 1e-3, `turned down by half a millimetre, ${file} became ${turned}`);
  // Tabs stay where they are, whichever is chosen.
  const places = [];
  for (const tab of ["play", "screws", "file", "compare", "keyboard"]) {
    await page.click(`#tab-${tab}`);
    await page.waitForTimeout(60);
    places.push(await page.evaluate(() => [...document.querySelectorAll("[role=tab]")].map((one) => Math.round(one.getBoundingClientRect().left + 10_000 * one.getBoundingClientRect().top)).join()));
  }
  assert.equal(new Set(places).size, 1, places.join(" | "));
  // Z is the C below middle C, Q is middle C; a key that is held and still is not called one that rests.
  await until(page, () => !document.getElementById("keys-said").textContent.includes("ready"), undefined, 120_000);
  await page.focus("#keys");
  for (const [key, name] of [["z", "C3"], ["q", "C4"]]) {
    await page.keyboard.down(key);
    await until(page, (name) => document.querySelector("#impacts li")?.textContent.startsWith(name), name);
    if (key === "q") await until(page, () => document.getElementById("keys-said").textContent.startsWith("1 key is held, and still"));
    await page.keyboard.up(key);
  }
  await until(page, () => document.getElementById("keys-said").textContent.startsWith("All keys rest"));
  assert.match(await page.textContent("#panel-keyboard"), /play from C3 on.*from middle C, C4, on/);
  return `live at 1/20: 1/${Math.round(1 / pace)}`;
};
