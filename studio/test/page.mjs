// The page as a page: size, first picture, links, no network, faults, screen readers, phones, pictures to look at.
import { readFile, readdir } from "node:fs/promises";
import { createRequire } from "node:module";
import { gzipSync } from "node:zlib";
import { assert, onKey, struck, until } from "./help.mjs";

const TABS = ["play", "screws", "file", "compare", "keyboard", "learn"];
/** Budgets, bytes as they travel. What the first picture needs takes a tenth of a second at 1 MB/s; all of it, engine included, less than one and a half. */
const FIRST = 100_000, ALL = 1_350_000;

export const size = async () => {
  const dist = new URL("../dist/", import.meta.url);
  const names = (await readdir(dist, { recursive: true, withFileTypes: true })).filter((one) => one.isFile());
  let first = 0, all = 0;
  for (const { name, parentPath } of names) {
    const bytes = await readFile(`${parentPath}/${name}`);
    // The engine is packed already.
    const packed = name === "engine.bin" ? bytes.length : gzipSync(bytes, { level: 9 }).length;
    all += packed;
    if (name === "index.html" || name.endsWith(".css")) first += packed;
  }
  assert(first <= FIRST, `the first picture takes ${first} bytes; there may be ${FIRST}`);
  assert(all <= ALL, `all of it takes ${all} bytes; there may be ${ALL}`);
  return `first picture ${(first / 1e3).toFixed(0)} kB, all ${(all / 1e3).toFixed(0)} kB`;
};

/** From nothing to the first blow, and to the first turned screw, on a line of 1 MB/s. */
export const stranger = async ({ browser, address }) => {
  const context = await browser.newContext({ viewport: { width: 1440, height: 900 }, serviceWorkers: "block" });
  const page = await context.newPage();
  const devtools = await context.newCDPSession(page);
  await devtools.send("Network.enable");
  await devtools.send("Network.emulateNetworkConditions", { offline: false, latency: 20, downloadThroughput: 1_000_000, uploadThroughput: 1_000_000 });
  const began = performance.now();
  const since = () => (performance.now() - began) / 1000;
  await page.goto(address, { waitUntil: "commit" });
  await page.waitForSelector("#pictures svg");
  const painted = await page.evaluate(() => new Promise((resolve) => {
    const look = () => {
      const [first] = performance.getEntriesByName("first-contentful-paint");
      if (first) resolve(first.startTime / 1000);
      else requestAnimationFrame(look);
    };
    look();
  }));
  assert(painted < 1, `the first picture is there after ${painted} s`);
  await page.waitForSelector("html[data-ready=true]");
  const ready = since();
  const { x, y } = await onKey(page);
  await page.mouse.move(x, y);
  await page.mouse.down();
  for (let n = 1; n <= 6; n++) await page.mouse.move(x, y + 12 * n);
  await struck(page);
  const blown = since();
  await page.mouse.up();
  await page.click("#tab-screws");
  await page.locator("[data-dial=let_off]").press("ArrowLeft");
  await until(page, () => "let_off" in studio.loaded[0].setting.turns);
  return `first picture ${painted.toFixed(2)} s, ready ${ready.toFixed(1)} s; first blow: one drag, ${blown.toFixed(1)} s; first turned screw: two clicks more, ${since().toFixed(1)} s`;
};

export const link = async ({ visit, address }) => {
  const page = await visit("#tab=screws&a=steinway-o;hammer:9.5;let_off:-0.4&b=key:28&firm=2&force=8&beside=1");
  const state = await page.evaluate(() => studio.state);
  assert.equal(state.a.turns.hammer, 9.5);
  assert.equal(state.b.base.key, 28);
  await page.click("#link");
  const href = page.url();
  await page.reload();
  await page.waitForSelector("html[data-ready=true]");
  assert.deepEqual(await page.evaluate(() => studio.state), state);
  // A file that nobody has but this page travels in the link.
  await page.click("#tab-file");
  const mine = (await page.inputValue("#file-text")).replace(/name = "[^"]*"/, 'name = "In the link"');
  await page.fill("#file-text", mine);
  await until(page, () => studio.scenes[0].name === "In the link");
  await page.evaluate(() => document.activeElement.blur());
  await page.click("#link");
  const long = page.url();
  const other = await visit(long.slice(address.length));
  await until(other, () => studio.scenes[0].name === "In the link");
  assert.equal(await other.evaluate(() => studio.loaded[0].text), mine);
  // What no link can mean is said, and the page begins.
  const odd = await visit("#a=file:%%%&tab=nowhere&firm=-3");
  await until(odd, () => !document.getElementById("notice").hidden && studio.scenes.length === 1);
  const unknown = await visit("#a=harpsichord");
  await until(unknown, () => studio.scenes.length === 1);
  return `${href.length - address.length} and ${long.length - address.length} characters`;
};

export const offline = async ({ visit }) => {
  const page = await visit();
  await page.evaluate(() => navigator.serviceWorker.ready);
  await until(page, () => navigator.serviceWorker.controller !== null);
  await page.context().setOffline(true);
  await page.reload();
  await page.waitForSelector("html[data-ready=true]");
  await page.keyboard.down(" ");
  await struck(page);
  await page.keyboard.up(" ");
  await page.click("#tab-keyboard");
  await until(page, () => !document.getElementById("keys-said").textContent.includes("ready"), undefined, 120_000);
  await page.context().setOffline(false);
};

/** A trap, numbers that are none, and an engine that does not answer: a message each, and a button that goes back. */
export const faults = async ({ visit, faults }) => {
  const page = await visit("#a=concert-grand;hammer:9.5");
  const engine = () => page.workers().find((one) => one.url().includes("player"));
  const broken = async (how, what) => {
    await page.evaluate(() => studio.push(0));
    await how();
    await page.evaluate(() => studio.push(4));
    await page.waitForSelector("#fault:not([hidden]) button");
    assert.match(await page.textContent("#fault"), what);
    await page.click("#fault button");
    await page.waitForSelector("#fault", { state: "hidden" });
    assert.equal(await page.evaluate(() => studio.loaded[0].setting.turns.hammer), 9.5);
    const before = await page.evaluate(() => studio.events[0]?.blow_s ?? 0);
    await page.evaluate(() => studio.push(0));
    await until(page, () => studio.poses[0].key_m < 1e-3);
    await page.evaluate(() => studio.push(6));
    await until(page, (before) => studio.events[0].blow_s > 0 && studio.events[0].blow_s !== before, before);
    await page.evaluate(() => studio.push(0));
    await until(page, () => document.getElementById("clock").textContent === "at rest");
  };
  // An address that is no action: the library reaches beyond its memory.
  await broken(() => engine().evaluate(() => { globalThis.player.actions[0].action = 0x7fffff00; }), /stopped/);
  await broken(() => engine().evaluate(() => {
    const { actions } = globalThis.player, step = actions[0].step.bind(actions[0]);
    actions[0].step = () => step({ kind: "force", force_n: NaN });
  }), /not finite/);
  // One that never answers again is replaced.
  await broken(() => engine().evaluate(() => { globalThis.player.advance = () => { for (;;); }; }), /does not answer/);
  assert.deepEqual(faults, []);
};

export const axe = async ({ visit }) => {
  const source = await readFile(createRequire(import.meta.url).resolve("axe-core/axe.min.js"), "utf8");
  let checked = 0;
  for (const colorScheme of ["light", "dark"]) {
    for (const tab of TABS) {
      const page = await visit(`#tab=${tab}${tab === "compare" ? "&b=heavy-touch" : ""}`, { colorScheme, bypassCSP: true });
      await page.waitForTimeout(300);
      await page.evaluate(source);
      const found = await page.evaluate(() => axe.run(document, { resultTypes: ["violations"] }).then(({ violations }) => violations.map(({ id, nodes }) => `${id}: ${nodes.slice(0, 4).map(({ html }) => html.slice(0, 140)).join(" | ")}`)));
      assert.deepEqual(found, [], `${tab}, ${colorScheme}`);
      checked++;
      await page.context().close();
    }
  }
  return `${checked} pages without findings`;
};

const PHONE = { viewport: { width: 390, height: 844 }, hasTouch: true, isMobile: true, deviceScaleFactor: 2 };

export const phone = async ({ visit }) => {
  for (const tab of TABS) {
    const page = await visit(`#tab=${tab}${tab === "compare" ? "&b=heavy-touch" : ""}`, PHONE);
    const wide = await page.evaluate(() => document.documentElement.scrollWidth);
    assert(wide <= 390, `${tab} is ${wide} px wide`);
    await page.context().close();
  }
};

export const screenshots = async ({ visit }, folder) => {
  const looks = [["light", {}], ["dark", { colorScheme: "dark" }], ["phone", PHONE], ["wide", { viewport: { width: 1920, height: 1080 } }]];
  let count = 0;
  for (const [look, options] of looks) {
    const pages = look === "wide" ? ["play"] : [...TABS, ...[1, 2, 3, 4, 5, 6].map((scene) => `learn&scene=${scene}`)];
    for (const tab of pages) {
      if (tab === "learn") continue;
      const page = await visit(`#tab=${tab}${tab === "compare" ? "&b=heavy-touch" : ""}`, options);
      if (tab === "screws") await until(page, () => document.querySelectorAll("#panel-screws .sheet .waiting").length === 0, undefined, 120_000);
      if (tab === "keyboard") {
        await until(page, () => !document.getElementById("keys-said").textContent.includes("ready"), undefined, 120_000);
        await page.click("#ten");
        await page.waitForTimeout(250);
      } else if (tab.startsWith("learn")) {
        await page.waitForTimeout(400);
        await page.click(".tries button");
        await page.waitForTimeout(2800);
      } else {
        await page.evaluate(() => studio.stroke({ nuance: "mf", struck: false }));
        await until(page, () => studio.blowOf(0) > 0);
        await page.waitForTimeout(700);
        await page.evaluate(() => studio.seek(studio.events[0].blow_s - 0.012));
      }
      await page.waitForTimeout(350);
      await page.screenshot({ path: `${folder}/${look}-${tab.replace("&scene=", "-")}.png` });
      await page.context().close();
      count++;
    }
  }
  return `${count} pictures in ${folder}`;
};
