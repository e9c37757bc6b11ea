// Every part can be grasped: pointed at, tapped, dragged by its screw; by the keyboard alone; and the pedal of an
// action with strings.
import { assert, atRest, goal, struck, until } from "./help.mjs";

/** A place where a part of action A is uncovered, px. */
const on = async (page, part) => {
  const found = await page.evaluate((part) => {
    for (const path of document.querySelectorAll(`#pictures svg [data-part="${part}"]`)) {
      const { left, top, width, height } = path.getBoundingClientRect();
      for (let x = 0.1; x < 1; x += 0.1) for (let y = 0.1; y < 1; y += 0.1) {
        const at = { x: left + x * width, y: top + y * height };
        if (document.elementFromPoint(at.x, at.y)?.dataset.part === part) return at;
      }
    }
    return null;
  }, part);
  assert(found, `${part} cannot be reached by a pointer`);
  return found;
};

export const grasp = async ({ visit }) => {
  const page = await visit();
  // Every part that has a name can be reached by a pointer, and something is said of it; every dial belongs to a part.
  const parts = await page.evaluate(() => [...document.getElementById("parts").options].map(({ value }) => value).filter((value) => value));
  assert(parts.length > 20, parts.join());
  const dials = await page.evaluate(() => studio.loaded[0].dials.map(({ name }) => name));
  const turned = new Set();
  for (const part of parts) {
    await page.selectOption("#parts", part);
    await until(page, (part) => document.querySelector("#part h2").textContent === part, part);
    const card = await page.evaluate(() => ({ does: document.querySelector("#part p").textContent, turns: [...document.querySelectorAll("#part [data-turn]")].map(({ dataset }) => dataset.turn) }));
    assert(card.does.length > 20, `nothing is said of the ${part}`);
    card.turns.forEach((dial) => turned.add(dial));
  }
  assert.deepEqual(dials.filter((dial) => !turned.has(dial)), [], "dials of no part");
  await page.click("#part button[aria-label=Close]");
  await until(page, () => document.getElementById("part").hidden);
  await page.click("#close-up");
  await page.waitForTimeout(200);
  const close = await page.evaluate(() => studio.state.view !== null);
  assert(close, "what is seen is part of the state");
  // Pointed at: its name and its numbers; tapped: what it is for, and its screws.
  const button = await on(page, "let-off button");
  await page.mouse.move(button.x, button.y);
  await until(page, () => !document.getElementById("pointed").hidden && document.getElementById("pointed").textContent.includes("let-off button"));
  assert.match(await page.textContent("#pointed"), /drag: let-off/);
  await page.mouse.down();
  await page.mouse.up();
  await until(page, () => !document.getElementById("part").hidden && document.querySelector("#part h2").textContent === "let-off button");
  await page.click("#part button[aria-label=Close]");
  // Dragged: it follows the hand, millimetre by millimetre, and the file with it; one step to undo.
  const was = await page.evaluate(() => studio.loaded[0].dials.find(({ name }) => name === "let_off").value);
  const scale = await page.evaluate(() => document.querySelector("#pictures svg").getScreenCTM().a);
  await page.mouse.move(button.x, button.y);
  await page.mouse.down();
  for (let n = 1; n <= 10; n++) await page.mouse.move(button.x, button.y + (n / 10) * scale);
  await page.mouse.move(button.x, button.y + Math.max(scale, 5));
  await until(page, () => studio.state.a.turns.let_off !== undefined && studio.loaded[0].setting.turns.let_off === studio.state.a.turns.let_off);
  await page.mouse.up();
  const now = await page.evaluate(() => studio.state.a.turns.let_off);
  assert(Math.abs(now - (was - Math.max(scale, 5) / scale)) < 0.02, `dragged from ${was} to ${now} mm`);
  const moved = await on(page, "let-off button");
  assert(moved.y > button.y - 1, "the button follows the hand");
  await page.click("#undo");
  await until(page, () => Object.keys(studio.state.a.turns).length === 0);
  // Numbers follow what is played.
  await page.selectOption("#parts", "hammer moulding");
  await page.evaluate(() => studio.push(6));
  await struck(page);
  await atRest(page);
  const told = await page.innerText("#part dl");
  assert.match(told, /weight of the hammer\s+\d+\.\d g/);
  const rise = await page.evaluate(() => (1e3 * studio.poses[0].hammer_rise_m).toFixed(2));
  assert(told.includes(`${rise} mm`), told);
  assert.match(told, /hammer tail – back check\s+\d+\.\d\d N/);
  return `${parts.length} parts, ${dials.length} dials`;
};

/** From the address bar to the first impact and the first turned screw, without a pointer; the story's test does the
 * same
 * there. */
export const keys_only = async ({ visit }) => {
  const page = await visit();
  let tabs = 0;
  const focused = () => page.evaluate(() => {
    const one = document.activeElement, style = getComputedStyle(one);
    return { id: one.id, name: one.getAttribute("aria-label") ?? one.textContent.trim().slice(0, 40), shown: one === document.body || one.matches(":focus-visible") && (style.outlineStyle !== "none" || one.classList.contains("skip")) };
  });
  const to = async (wanted) => {
    for (let n = 0; n < 80; n++) {
      const now = await focused();
      assert(now.shown, `no focus is seen on ${now.id || now.name}`);
      if (wanted(now)) return;
      await page.keyboard.press("Tab");
      tabs++;
    }
    assert.fail("it is not reached by the keyboard");
  };
  await page.keyboard.down(" ");
  await struck(page);
  await page.keyboard.up(" ");
  await to(({ id }) => id === "tab-play");
  await page.keyboard.press("ArrowRight");
  await until(page, () => studio.state.tab === "screws");
  await to(({ id }) => id === "parts");
  await page.keyboard.press("l");
  await until(page, () => !document.getElementById("part").hidden);
  await to(({ name }) => name === "let-off");
  await page.keyboard.press("ArrowLeft");
  await until(page, () => "let_off" in studio.loaded[0].setting.turns);
  await page.keyboard.press("Control+z");
  await until(page, () => Object.keys(studio.state.a.turns).length === 0);
  await page.focus("#tab-screws");
  await page.keyboard.press("End");
  await until(page, () => studio.state.tab === "diagnose");
  await page.keyboard.press("ArrowLeft");
  await until(page, () => studio.state.tab === "keyboard");
  return `${tabs} times Tab`;
};

/** A pedal that lifts the dampers: the picture shows it, and the string rings on. */
export const pedal = async ({ visit }) => {
  const page = await visit();
  assert.equal(await page.locator("#pedal").isVisible(), false, "an action without strings has no pedal");
  await page.selectOption("#instrument", "concert-grand-strings");
  await until(page, () => studio.scenes[0].pedal === true);
  await page.waitForSelector("#pedal", { state: "visible" });
  await page.click("button[aria-label='mf, pressed']");
  await struck(page);
  // The string is seen to swing, and the picture says by how much that is exaggerated.
  await page.evaluate(() => studio.seek(studio.events[0].hammer_contact_s + 0.001));
  await until(page, () => Math.max(...studio.poses[0].string) > 2e-4);
  assert.match(await page.textContent("#pictures .swing"), /middle string, swing \u00d7 (2|5|10)$/);
  const [strike, height] = await page.evaluate(() => studio.scenes[0].string);
  const drawn = await page.evaluate(() => document.querySelector("#pictures .swinging").getAttribute("points").split(" ").map((pair) => pair.split(",").map(Number)));
  const [, up] = drawn.reduce((best, point) => (Math.abs(point[0] - strike) < Math.abs(best[0] - strike) ? point : best));
  assert(-up - height > 0.2, `where it is struck it is ${-up - height} mm above its rest in the picture`);
  await page.evaluate(() => studio.goLive());
  const damper = () => page.evaluate(() => studio.poses[0].angles[studio.scenes[0].bodies.findIndex(({ name }) => name === "damper")]);
  await page.evaluate(() => studio.push(0));
  await until(page, () => studio.poses[0].key_m < 2e-4);
  await page.waitForTimeout(600);
  const lying = await damper();
  await page.evaluate(() => document.activeElement.blur());
  await page.keyboard.press("p");
  await until(page, (lying) => Math.abs(studio.poses[0].angles[studio.scenes[0].bodies.findIndex(({ name }) => name === "damper")] - lying) > 0.02, lying);
  assert.equal(await page.evaluate(() => studio.state.pedal), 7);
  const hash = await page.evaluate(() => studio.link());
  assert.match(hash, /pedal=7/);
  await page.evaluate(() => studio.stroke({ nuance: "f", struck: false }));
  await until(page, () => studio.hammerSpeedOf(0) > 1);
  await page.keyboard.press("p");
  await until(page, (lying) => Math.abs(studio.poses[0].angles[studio.scenes[0].bodies.findIndex(({ name }) => name === "damper")] - lying) < 0.01, lying);
  const steps = await page.evaluate(() => studio.timing.costs.map((cost, n) => [cost, studio.timing.steps[n]]).filter(([, count]) => count > 50).map(([cost, count]) => (1e3 * cost) / count).sort((a, b) => a - b));
  const middle = steps[steps.length >> 1];
  goal(middle < 50, `a step with strings takes ${middle} us`);
  return `a step with strings ${middle.toFixed(1)} us, 95th percentile ${steps[Math.floor(0.95 * steps.length)].toFixed(1)} us`;
};
