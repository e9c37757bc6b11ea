// The page as a page: size, first picture, links, no network, faults, screen readers, phones, pictures to look at.
import { readFile, readdir } from "node:fs/promises";
import { createRequire } from "node:module";
import { gzipSync } from "node:zlib";
import { assert, onKey, struck, until } from "./help.mjs";

const TABS = ["play", "screws", "file", "compare", "keyboard", "learn"];
/** Budgets, bytes as they travel. What the first picture needs takes a tenth of a second at 1 MB/s; all that playing
 * needs, the engine included, less than one and a half; what is loaded when it is asked for (the reader of Parquet)
 * counts apart. */
const FIRST = 100_000, PLAYING = 1_450_000, LATER = 40_000;

export const size = async () => {
  const dist = new URL("../dist/", import.meta.url);
  const names = (await readdir(dist, { recursive: true, withFileTypes: true })).filter((one) => one.isFile());
  let first = 0, all = 0, later = 0;
  for (const { name, parentPath } of names) {
    const bytes = await readFile(`${parentPath}/${name}`);
    // The engine is packed already.
    const packed = name === "engine.bin" ? bytes.length : gzipSync(bytes, { level: 9 }).length;
    if (name.startsWith("parquet")) later += packed;
    else all += packed;
    if (name === "index.html" || name.endsWith(".css")) first += packed;
  }
  assert(first <= FIRST, `the first picture takes ${first} bytes; there may be ${FIRST}`);
  assert(all <= PLAYING, `playing takes ${all} bytes; there may be ${PLAYING}`);
  assert(later > 0 && later <= LATER, `what is loaded later takes ${later} bytes; there may be ${LATER}`);
  const kb = (bytes) => `${(bytes / 1e3).toFixed(0)} kB`;
  return `first picture ${kb(first)}, all that playing needs ${kb(all)}, loaded when asked for ${kb(later)}`;
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
  // Nothing waits: the page is never busy for long, neither while it begins nor when an action is drawn anew.
  const busy = await page.evaluate(() => new Promise((resolve) => {
    const observer = new PerformanceObserver((list) => resolve(Math.max(...list.getEntries().map(({ duration }) => duration))));
    observer.observe({ type: "longtask", buffered: true });
    setTimeout(() => resolve(0), 500);
  }));
  assert(busy < 1000, `the page was busy for ${busy} ms`);
  return `first picture ${painted.toFixed(2)} s, ready ${ready.toFixed(1)} s; first blow: one drag, ${blown.toFixed(1)} s; first turned screw: two clicks more, ${since().toFixed(1)} s; never busy for more than ${busy.toFixed(0)} ms`;
};

export const link = async ({ visit, address }) => {
  const page = await visit("#tab=screws&a=steinway-o;hammer:9.5;let_off:-0.4&b=key:28&firm=2&force=8&beside=1&pedal=3.5&slower=200&forces=0&names=1&difference=1&view=150.0,-150.0,120.0,80.0");
  const state = await page.evaluate(() => studio.state);
  assert.equal(state.a.turns.hammer, 9.5);
  assert.equal(state.b.base.key, 28);
  assert.deepEqual([state.pedal, state.speed, state.forces, state.names, state.difference, state.view], [3.5, 1 / 200, false, true, true, [150, -150, 120, 80]]);
  const seen = () => page.evaluate(() => [document.getElementById("speed").value, document.getElementById("arrows").checked, document.getElementById("naming").checked, ...[...document.querySelectorAll("#pictures svg")].map((svg) => svg.getAttribute("viewBox"))].join("; "));
  assert.equal(await seen(), "0.005; false; true; 150.000 -150.000 120.000 80.000; 150.000 -150.000 120.000 80.000");
  await page.click("#link");
  const href = page.url();
  await page.reload();
  await page.waitForSelector("html[data-ready=true]");
  assert.deepEqual(await page.evaluate(() => studio.state), state);
  assert.equal(await seen(), "0.005; false; true; 150.000 -150.000 120.000 80.000; 150.000 -150.000 120.000 80.000");
  // A file that nobody has but this page travels in the link.
  await page.click("#tab-file");
  const mine = (await page.inputValue("#file-text")).replace(/name = "[^"]*"/, 'name = "In the link"');
  await page.evaluate((mine) => {
    const area = document.getElementById("file-text");
    area.value = mine;
    area.dispatchEvent(new Event("input", { bubbles: true }));
  }, mine);
  await until(page, () => studio.scenes[0].name === "In the link");
  await page.evaluate(() => document.activeElement.blur());
  await page.click("#link");
  // The file is compressed first.
  await until(page, () => location.hash.includes("file:"));
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

const PHONE = { viewport: { width: 390, height: 844 }, hasTouch: true, isMobile: true, deviceScaleFactor: 2 };

/** What can be on the page: every panel, and what opens in it. */
const STATES = {
  ...Object.fromEntries(TABS.map((tab) => [tab, { hash: `#tab=${tab}${tab === "compare" ? "&b=heavy-touch" : ""}` }])),
  "side by side": { hash: "#tab=compare&b=heavy-touch&beside=1&names=1" },
  "with a pedal": { hash: "#a=concert-grand-strings" },
  "a part": { hash: "", act: (page) => page.selectOption("#parts", "let-off button") },
  "a wrong file": {
    hash: "#tab=file",
    act: async (page) => {
      await page.fill("#file-text", (await page.inputValue("#file-text")).replace(/mass_g = [^\n]*/, "mass_g = -1"));
      await until(page, () => document.getElementById("file-said").textContent.startsWith("Line"));
    },
  },
  "what cannot work": {
    hash: "#tab=screws",
    act: async (page) => {
      await page.evaluate(() => studio.turn(0, "let_off", 40));
      await until(page, () => !document.getElementById("why").hidden);
    },
  },
  "a regulation": {
    hash: "#tab=screws&a=concert-grand;let_off:-1",
    act: async (page) => {
      await page.click("#regulate");
      await until(page, () => document.querySelector("#log ol") !== null, undefined, 120_000);
    },
  },
  "a wrong recording": {
    hash: "",
    act: async (page) => {
      await page.evaluate(() => studio.stroke({ csv: "time_s\n1", name: "wrong.csv" }));
      await until(page, () => !document.getElementById("notice").hidden);
    },
  },
  "a fault": {
    hash: "",
    act: async (page) => {
      await page.workers().find((one) => one.url().includes("player")).evaluate(() => { globalThis.player.actions[0].action = 0x7fffff00; });
      await page.evaluate(() => studio.push(4));
      await page.waitForSelector("#fault:not([hidden]) button");
    },
  },
  "looking back": {
    hash: "#tab=learn&scene=5",
    act: async (page) => {
      await page.click(".tries button");
      await until(page, () => document.getElementById("replay").textContent === "Pause");
    },
  },
};
const LOOKS = { light: {}, dark: { colorScheme: "dark" }, phone: PHONE };

export const axe = async ({ visit }) => {
  const source = await readFile(createRequire(import.meta.url).resolve("axe-core/axe.min.js"), "utf8");
  let checked = 0;
  for (const [look, options] of Object.entries(LOOKS)) {
    for (const [name, { hash, act }] of Object.entries(STATES)) {
      const page = await visit(hash, { ...options, bypassCSP: true });
      await page.waitForTimeout(200);
      await act?.(page);
      await page.evaluate(source);
      const found = await page.evaluate(() => axe.run(document, { resultTypes: ["violations"] }).then(({ violations }) => violations.map(({ id, nodes }) => `${id}: ${nodes.slice(0, 4).map(({ html }) => html.slice(0, 140)).join(" | ")}`)));
      assert.deepEqual(found, [], `${name}, ${look}`);
      const { width } = page.viewportSize();
      const wide = await page.evaluate(() => document.documentElement.scrollWidth);
      assert(wide <= width, `${name}, ${look}: ${wide} px wide`);
      checked++;
      await page.context().close();
    }
  }
  return `${checked} states without findings, none wider than its screen`;
};

/** Pictures of all of it, to be looked at. */
export const screenshots = async ({ visit }, folder) => {
  const LATE = { wide: { viewport: { width: 1920, height: 1080 } } };
  const scenes = Object.fromEntries([1, 2, 3, 4, 5, 6].map((scene) => [`learn-${scene}`, { hash: `#tab=learn&scene=${scene}`, scene }]));
  let count = 0;
  for (const [look, options] of Object.entries({ ...LOOKS, ...LATE })) {
    const wanted = look === "wide" ? { play: STATES.play } : { ...STATES, ...scenes };
    for (const [name, { hash, act, scene }] of Object.entries(wanted)) {
      const page = await visit(hash, options);
      if (name === "screws") await until(page, () => document.querySelectorAll("#panel-screws .sheet .waiting").length === 0, undefined, 120_000);
      if (name === "keyboard") {
        await until(page, () => !document.getElementById("keys-said").textContent.includes("ready"), undefined, 120_000);
        await page.click("#ten");
        await page.waitForTimeout(250);
      } else if (scene) {
        await page.waitForTimeout(400);
        await page.click(".tries button");
        await until(page, () => document.getElementById("replay").textContent === "Pause" || document.getElementById("clock").textContent === "at rest");
        await page.waitForTimeout(1200);
      } else if (name !== "a fault") {
        await page.evaluate(() => studio.stroke({ nuance: "mf", struck: false }));
        await until(page, () => studio.blowOf(0) > 0);
        await page.waitForTimeout(700);
        await page.evaluate(() => studio.seek(studio.events[0].blow_s - 0.012));
      }
      await act?.(page);
      await page.waitForTimeout(350);
      await page.screenshot({ path: `${folder}/${look}-${name.replaceAll(" ", "-")}.png` });
      await page.context().close();
      count++;
    }
  }
  return `${count} pictures in ${folder}`;
};
