// Everything that can be on the pages: to be checked, and to be looked at.
import { struck, until } from "./help.mjs";

const TABS = ["play", "screws", "file", "compare", "keyboard", "diagnose"];
const STEPS = ["lever", "flight", "escapement", "check", "damper", "again", "erard", "touch"];
const PHONE = { viewport: { width: 390, height: 844 }, hasTouch: true, isMobile: true, deviceScaleFactor: 2 };

/** What can be on the page: every panel, and what opens in it. */
export const STATES = {
  ...Object.fromEntries(TABS.map((tab) => [tab, { hash: `#tab=${tab}${tab === "compare" ? "&b=heavy-touch" : ""}` }])),
  "side by side": { hash: "#tab=compare&b=heavy-touch&beside=1&names=1" },
  "a keyboard with strings": { hash: "#tab=keyboard&keys=concert-grand-strings", act: (page) => page.waitForSelector("#heard canvas", { timeout: 120_000 }) },
  "with a pedal": { hash: "#a=concert-grand-strings" },
  "an example": { hash: "#example=double-strike&tab=compare&b=concert-grand;front_punching:1.8&beside=1", act: (page) => until(page, () => studio.events[1]?.impact_count === 2) },
  "lost notes": { hash: "#example=lost-notes&tab=keyboard&keys=heavy-touch", act: (page) => until(page, () => document.getElementById("passage-said").textContent !== "", undefined, 120_000) },
  "in German": { hash: "#tab=screws", act: (page) => page.selectOption("#language", "de") },
  "a part": { hash: "", act: (page) => page.selectOption("#parts", "let-off button") },
  "a diagnosis": { hash: "#tab=diagnose&readings=key:C4;down_weight_g:58;up_weight_g:18;let_off_mm:3.5;drop_mm:0;blow_mm:47", act: (page) => page.waitForSelector("#diagnosis .causes") },
  "impossible readings": { hash: "#tab=diagnose&readings=down_weight_g:18;up_weight_g:58", act: (page) => page.waitForSelector("[data-field=up_weight_g] .bad:not([hidden])") },
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
    hash: "",
    act: async (page) => {
      await page.evaluate(() => studio.stroke({ nuance: "mf", struck: false }));
      await struck(page);
      await page.click("#replay");
    },
  },
};
/** Lets a scene show its stroke until the key is seen to go down: a machine that stalls can miss a whole one. */
const shown = async (page, id, tries = 3) => {
  await page.click(`[data-scene=${id}] .show`);
  const went = until(page, (id) => story.figures[id].now?.pose.key_m > 1e-3, id, tries > 1 ? 10_000 : 30_000);
  await (tries > 1 ? went.catch(() => shown(page, id, tries - 1)) : went);
};
/** The story: its beginning, and every step in the middle of its own stroke. */
export const READ = {
  "the story": { act: async () => {} },
  ...Object.fromEntries(STEPS.map((id) => [id, {
    step: id,
    act: async (page) => {
      await page.evaluate((id) => {
        const { top, height } = document.querySelector(`[data-scene=${id}]`).getBoundingClientRect();
        scrollTo({ top: scrollY + top + height / 2 - innerHeight / 2, behavior: "instant" });
      }, id);
      await until(page, (id) => story.active === id && document.querySelector(`[data-scene=${id}]`).dataset.live === "true", id);
      await shown(page, id);
      await page.waitForTimeout(1500);
    },
  }])),
};
export const LOOKS = { light: {}, dark: { colorScheme: "dark" }, phone: PHONE };
