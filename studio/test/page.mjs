// The page as a page: size, first picture, links, no network, faults, pictures to look at.
import { readFile, readdir } from "node:fs/promises";
import { gzipSync } from "node:zlib";
import { assert, goal, struck, until } from "./help.mjs";
import { LOOKS, READ, STATES } from "./states.mjs";

/** Budgets of each of the three pages, bytes as they travel. What the first picture needs takes a tenth of a second at
 * 1 MB/s; all that playing needs, the engine included, a second and a half; what is loaded when it is asked for
 * (the reader of Parquet, the words of another language, sound) counts apart. */
const FIRST = 100_000, PLAYING = 1_495_000, LATER = { parquet: 40_000, "/de-": 10_000, "/fr-": 10_000, "/sound": 6000, "/hear-": 1000 };
const isLater = (name) => Object.keys(LATER).some((part) => name.includes(part));

export const size = async () => {
  const site = new URL("../site/", import.meta.url);
  const text = (name) => readFile(new URL(name, site), "utf8");
  const packed = async (name) => {
    const bytes = await readFile(new URL(name, site));
    // The engine is packed already.
    return name === "engine.bin" ? bytes.length : gzipSync(bytes, { level: 9 }).length;
  };
  const all = (await readdir(new URL("assets/", site))).map((name) => `assets/${name}`);
  const kb = (bytes) => `${(bytes / 1e3).toFixed(0)} kB`;
  const told = [];
  for (const [part, most] of Object.entries(LATER)) {
    let later = 0;
    for (const name of all.filter((one) => one.includes(part))) later += await packed(name);
    assert(later > 0 && later <= most, `${part}, loaded when asked for, takes ${later} bytes; there may be ${most}`);
    told.push(`${part.replace(/\W/g, "")} when asked for ${kb(later)}`);
  }
  for (const page of ["index.html", "tools.html", "action.html"]) {
    // Everything that the page names, what that names, and so on: scripts, styles, workers.
    const needs = new Set([page, "engine.bin"]);
    for (const name of needs) {
      if (!/\.(html|js)$/.test(name)) continue;
      const own = await text(name);
      for (const other of all) if (!isLater(other) && own.includes(other.slice("assets/".length))) needs.add(other);
    }
    let first = 0, playing = 0;
    for (const name of needs) {
      playing += await packed(name);
      if (/\.(html|css)$/.test(name)) first += await packed(name);
    }
    assert([...needs].some((one) => one.includes("player.worker")), `${page} needs no player: ${[...needs]}`);
    assert(first <= FIRST, `${page}: the first picture takes ${first} bytes; there may be ${FIRST}`);
    assert(playing <= PLAYING, `${page}: playing takes ${playing} bytes; there may be ${PLAYING}`);
    told.push(`${page}: first picture ${kb(first)}, all that playing needs ${kb(playing)}`);
  }
  return told.join("; ");
};

/** From nothing to the first impact in the story, and to the first turned screw at the workbench, on a line of 1
 * MB/s. */
export const stranger = async ({ browser, address }) => {
  const context = await browser.newContext({ viewport: { width: 1440, height: 900 }, serviceWorkers: "block" });
  const page = await context.newPage();
  const devtools = await context.newCDPSession(page);
  await devtools.send("Network.enable");
  await devtools.send("Network.emulateNetworkConditions", { offline: false, latency: 20, downloadThroughput: 1_000_000, uploadThroughput: 1_000_000 });
  const began = performance.now();
  const since = () => (performance.now() - began) / 1000;
  await page.goto(address, { waitUntil: "commit" });
  await page.waitForSelector("svg.first");
  const painted = await page.evaluate(() => new Promise((resolve) => {
    const look = () => {
      const [first] = performance.getEntriesByName("first-contentful-paint");
      if (first) resolve(first.startTime / 1000);
      else requestAnimationFrame(look);
    };
    look();
  }));
  goal(painted < 1, `the first picture is there after ${painted} s`);
  await page.waitForSelector("html[data-ready=true]");
  const ready = since();
  // The drawn key itself is a thing to drag, beside the drawn finger.
  const { x, y } = await page.evaluate(() => {
    const [key] = [...document.querySelectorAll("[data-scene=lever] svg .key")].map((part) => part.getBoundingClientRect()).sort((a, b) => b.width - a.width);
    return { x: key.left + 0.12 * key.width, y: key.top + key.height / 2 };
  });
  await page.mouse.move(x, y);
  await page.mouse.down();
  for (let n = 1; n <= 6; n++) await page.mouse.move(x, y + 5 * n);
  await until(page, () => story.figures.lever.now?.press.impacts > 0);
  const played = since();
  await page.mouse.up();
  await page.click(".bar .bench");
  await page.waitForSelector("html[data-ready=true] #tab-screws");
  await page.click("#tab-screws");
  await page.locator("[data-dial=let_off]").press("ArrowLeft");
  await until(page, () => "let_off" in studio.loaded[0].setting.turns);
  // Nothing waits: the page is never busy for long, neither while it begins nor when an action is drawn anew.
  const busy = await page.evaluate(() => new Promise((resolve) => {
    const observer = new PerformanceObserver((list) => resolve(Math.max(...list.getEntries().map(({ duration }) => duration))));
    observer.observe({ type: "longtask", buffered: true });
    setTimeout(() => resolve(0), 500);
  }));
  goal(busy < 1000, `the page was busy for ${busy} ms`);
  return `first picture ${painted.toFixed(2)} s, ready ${ready.toFixed(1)} s; first impact: one drag, ${played.toFixed(1)} s; first turned screw: three clicks more, ${since().toFixed(1)} s; never busy for more than ${busy.toFixed(0)} ms`;
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
  const other = await visit(long.slice(long.indexOf("#")));
  await until(other, () => studio.scenes[0].name === "In the link");
  assert.equal(await other.evaluate(() => studio.loaded[0].text), mine);
  // What no link can mean is said, and the page begins.
  const odd = await visit("#a=file:%%%&tab=nowhere&firm=-3");
  await until(odd, () => !document.getElementById("notice").hidden && studio.scenes.length === 1);
  const unknown = await visit("#a=harpsichord");
  await until(unknown, () => studio.scenes.length === 1);
  return `${href.length - address.length} and ${long.length - address.length} characters`;
};

export const offline = async ({ read }) => {
  const page = await read();
  await page.evaluate(() => navigator.serviceWorker.ready);
  await until(page, () => navigator.serviceWorker.controller !== null);
  await page.context().setOffline(true);
  await page.reload();
  await page.waitForSelector("html[data-ready=true]");
  await page.click("[data-scene=lever] .show");
  await until(page, () => story.figures.lever.now?.pose.key_m > 4e-3);
  await page.click(".bar .bench");
  await page.waitForSelector("html[data-ready=true] #tab-keyboard");
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
    const before = await page.evaluate(() => studio.events[0]?.hammer_contact_s ?? 0);
    await page.evaluate(() => studio.push(0));
    await until(page, () => studio.poses[0].key_m < 1e-3);
    await page.evaluate(() => studio.push(6));
    await until(page, (before) => studio.events[0].hammer_contact_s > 0 && studio.events[0].hammer_contact_s !== before, before);
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

/** Pictures of all of it, to be looked at. */
export const screenshots = async ({ visit, read }, folder) => {
  const LATE = { wide: { viewport: { width: 1920, height: 1080 } } };
  let count = 0;
  for (const [look, options] of Object.entries({ ...LOOKS, ...LATE })) {
    const shot = async (page, name) => {
      await page.waitForTimeout(350);
      await page.screenshot({ path: `${folder}/${look}-${name.replaceAll(" ", "-")}.png` });
      await page.context().close();
      count++;
    };
    for (const [name, { act }] of Object.entries(READ)) {
      const page = await read("", { viewport: { width: 1400, height: 900 }, ...options });
      await act(page);
      await shot(page, name);
    }
    for (const [name, { hash, act }] of Object.entries(look === "wide" ? { play: STATES.play } : STATES)) {
      const page = await visit(hash, options);
      if (name === "screws") await until(page, () => document.querySelectorAll("#panel-screws .sheet .waiting").length === 0, undefined, 120_000);
      if (name === "keyboard") {
        await until(page, () => !document.getElementById("keys-said").textContent.includes("ready"), undefined, 120_000);
        await page.click("#ten");
        await page.waitForTimeout(250);
      } else if (name !== "a fault") {
        await page.evaluate(() => studio.stroke({ nuance: "mf", struck: false }));
        await until(page, () => studio.hammerSpeedOf(0) > 0);
        await page.waitForTimeout(700);
        await page.evaluate(() => studio.seek(studio.events[0].hammer_contact_s - 0.012));
      }
      await act?.(page);
      await shot(page, name);
    }
  }
  return `${count} pictures in ${folder}`;
};
