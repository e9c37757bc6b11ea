// Playing: by mouse, by touch, by key; looking back; recordings.
import { assert, atRest, hammerSpeed, key, onKey, struck, until } from "./help.mjs";

export const mouse = async ({ visit }) => {
  const page = await visit();
  const { x, y } = await onKey(page);
  await page.mouse.move(x, y);
  await page.mouse.down();
  for (let n = 1; n <= 8; n++) await page.mouse.move(x, y + 9 * n);
  await struck(page);
  const speed = await hammerSpeed(page);
  await until(page, () => studio.poses[0].key_m > 0.008);
  // A held note is still: the clock stops, the finger still presses.
  await atRest(page);
  assert((await page.evaluate(() => studio.poses[0].finger_force_n)) > 1, "the finger presses on");
  await page.mouse.up();
  await until(page, () => studio.poses[0].key_m < 2e-4);
  const text = await page.textContent("#numbers");
  assert(text.includes(`${speed.toFixed(2)} m/s`), text);
  // Elsewhere the pointer moves the picture, and the key stays up.
  const view = () => page.getAttribute("#pictures svg", "viewBox");
  const before = await view();
  await page.mouse.move(x + 200, 150);
  await page.mouse.down();
  await page.mouse.move(x + 260, 190);
  await page.mouse.up();
  assert.notEqual(await view(), before, "the picture has moved");
  assert.equal(await hammerSpeed(page), speed);
  return `${speed.toFixed(2)} m/s`;
};

export const touch = async ({ visit }) => {
  const page = await visit("", { viewport: { width: 390, height: 844 }, hasTouch: true, isMobile: true, deviceScaleFactor: 2 });
  const { x, y } = await onKey(page);
  const devtools = await page.context().newCDPSession(page);
  const send = (type, down) => devtools.send("Input.dispatchTouchEvent", { type, touchPoints: down === null ? [] : [{ x, y: y + down, id: 1 }] });
  await send("touchStart", 0);
  for (let n = 1; n <= 8; n++) await send("touchMove", 6 * n);
  await struck(page);
  await send("touchEnd", null);
  await until(page, () => studio.poses[0].key_m < 2e-4);
  assert.equal(await page.evaluate(() => scrollY), 0, "the page does not scroll while the key is held");
  // The button takes a finger, too.
  const first = await page.evaluate(() => studio.events[0].hammer_contact_s);
  const { x: bx, y: by, width, height } = await page.locator("#press").boundingBox();
  await devtools.send("Input.dispatchTouchEvent", { type: "touchStart", touchPoints: [{ x: bx + width / 2, y: by + height / 2, id: 2 }] });
  await until(page, (first) => studio.events[0].hammer_contact_s > first, first);
  await devtools.send("Input.dispatchTouchEvent", { type: "touchEnd", touchPoints: [] });
};

export const key_ = async ({ visit }) => {
  const page = await visit();
  await page.keyboard.down(" ");
  await struck(page);
  await atRest(page);
  assert((await key(page)) > 8, "the key is held");
  await page.keyboard.up(" ");
  await until(page, () => studio.poses[0].key_m < 2e-4);
  // A switch or a reader of the screen clicks without a pointer: the key is pressed for a while, and let go.
  const before = await page.evaluate(() => studio.events[0].hammer_contact_s);
  await page.evaluate(() => document.getElementById("press").click());
  await until(page, (before) => studio.events[0].hammer_contact_s > before, before);
  await until(page, () => studio.poses[0].key_m < 2e-4);
  // The strokes that are built in, and what the sheet of a press says of them.
  await page.click("button[aria-label='ff, struck']");
  await until(page, () => studio.hammerSpeedOf(0) > 4);
  // Away from the page nothing stays pressed.
  await page.keyboard.down(" ");
  await until(page, () => studio.poses[0].key_m > 0.008);
  await page.evaluate(() => dispatchEvent(new Event("blur")));
  await until(page, () => studio.poses[0].key_m < 2e-4);
};
export { key_ as key };

/** The key front's own motion: it is where the pointer is, and its force is what that takes. */
export const imposed = async ({ visit }) => {
  const page = await visit("");
  await page.check("#imposed");
  await until(page, () => location.hash.includes("imposed=1"));
  for (const down of [0.004, 0.0075]) {
    await page.evaluate((down) => studio.press(down), down);
    await until(page, (down) => Math.abs(studio.poses[0].key_m - down) < 2e-6, down);
  }
  assert((await page.evaluate(() => studio.poses[0].finger_force_n)) > 0.1, "the force that holds the key");
  await page.evaluate(() => studio.press(null));
  await until(page, () => studio.poses[0].key_m < 2e-4);
  // From where the key is, not from where the last motion ended; no deeper than a finger goes.
  await page.evaluate(() => studio.press(0.03));
  await until(page, () => Math.abs(studio.poses[0].key_m - 0.0102) < 2e-6);
  return `${(await page.evaluate(() => studio.poses[0].finger_force_n)).toFixed(1)} N at the bottom`;
};

export const replay = async ({ visit }) => {
  const page = await visit();
  await page.click("button[aria-label='mf, pressed']");
  await struck(page);
  await atRest(page);
  const seconds = await page.evaluate(() => Number(document.getElementById("time").max) - Number(document.getElementById("time").min));
  assert(seconds >= 1, `${seconds} s are kept`);
  // At the impact the hammer is at the string, and presses on it.
  await page.evaluate(() => studio.seek(studio.events[0].hammer_contact_s + 3e-4));
  await until(page, () => studio.poses[0].string_n > 5);
  const there = await page.evaluate(() => studio.poses[0].hammer_rise_m);
  assert(there > 0.045, `the hammer has risen by ${there} m`);
  // A thousand times slower: a millisecond a second.
  await page.selectOption("#speed", "0.001");
  const at = () => page.evaluate(() => studio.poses[0].time_s);
  await page.click("#replay");
  const from = await at();
  await page.waitForTimeout(600);
  const to = await at();
  assert(to > from && to - from < 2e-3, `${to - from} s in 0.6 s`);
  await page.click("#live");
  await until(page, () => studio.poses[0].string_n === 0);
  assert.equal(await page.getAttribute("#live", "aria-pressed"), "true");
  // The slider and the keys of the keyboard reach it, too.
  await page.focus("#time");
  await page.keyboard.press("Home");
  await until(page, () => document.getElementById("live").getAttribute("aria-pressed") === "false");
};

export const recording = async ({ visit }) => {
  const page = await visit();
  const csv = "time_s,force_N\n0,0\n0.01,6\n0.15,6\n0.16,0\n";
  await page.setInputFiles("#recording", { name: "hand.csv", mimeType: "text/csv", buffer: Buffer.from(csv) });
  await struck(page);
  const speed = await hammerSpeed(page);
  await atRest(page);
  await page.setInputFiles("#recording", { name: "wrong.csv", mimeType: "text/csv", buffer: Buffer.from("time_s,force_N\n0,0\n0.01,much\n") });
  await until(page, () => document.getElementById("notice").textContent.includes(":3:"));
  // Dropped onto the page, it plays as if it had been opened.
  await page.evaluate(async (text) => {
    const data = new DataTransfer();
    data.items.add(new File([text], "dropped.csv", { type: "text/csv" }));
    document.body.dispatchEvent(new DragEvent("drop", { dataTransfer: data, bubbles: true, cancelable: true }));
  }, csv);
  await until(page, () => document.getElementById("recorded").textContent.includes("dropped.csv") && document.getElementById("notice").hidden);
  await until(page, () => document.getElementById("clock").textContent !== "at rest");
  await struck(page);
  // The same stroke, from the same rest.
  assert.equal(await hammerSpeed(page), speed);
};
