// node test/run.mjs [--seconds N] [--shots FOLDER] [--only WORD] [--lanes N] [--timed] [--every]: the pages in a real
// browser, N tests at a time, each lane in a browser of its own; tests of time run alone at the end. What did not hold
// is tried once more then; exit code 1 where it fails again. Missed goals of time are listed; with --timed, for a
// machine that does nothing else, they fail, too. --every lets axe see every state on a desk, in light and dark, beside
// a phone. ERARD names the command whose bits the page is compared with; CHROMIUM the browser.
import { mkdirSync } from "node:fs";
import { parseArgs } from "node:util";
import { open } from "./browser.mjs";
import { missed } from "./help.mjs";
import { axe } from "./axe.mjs";
import { bits } from "./bits.mjs";
import { parquet } from "./parquet.mjs";
import { wild } from "./wild.mjs";
import * as play from "./play.mjs";
import * as grasp from "./grasp.mjs";
import * as bench from "./bench.mjs";
import * as page from "./page.mjs";
import { diagnose } from "./diagnose.mjs";
import { edges } from "./edges.mjs";
import { gallery } from "./gallery.mjs";
import { terms } from "./terms.mjs";
import { typed } from "./typed.mjs";
import * as reader from "./reader.mjs";
import * as sound from "./sound.mjs";
import * as story from "./story.mjs";
import * as claims from "./claims.mjs";

const { values: asked } = parseArgs({ options: { seconds: { type: "string", default: "20" }, shots: { type: "string" }, only: { type: "string" }, lanes: { type: "string", default: "2" }, timed: { type: "boolean", default: false }, every: { type: "boolean", default: false } } });
/** The longest begins, so that no lane waits for it at the end. */
const LONG = "axe";
const tests = {
  size: page.size,
  "numbers of the story, rewritten": claims.writer,
  ...(process.env.ERARD ? { bits, parquet } : {}),
  "first picture": reader.first,
  "the story, step by step": story.tasks,
  "the story by the keyboard alone": reader.keys,
  "the story by touch": reader.touch,
  "the story read": reader.reader,
  "a stranger's path": page.stranger,
  "press by mouse": play.mouse,
  "press by touch": play.touch,
  "press by key": play.key,
  "an imposed motion": play.imposed,
  "every part can be grasped": grasp.grasp,
  "the keyboard alone": grasp.keys_only,
  "the pedal": grasp.pedal,
  "look back": play.replay,
  "a recording": play.recording,
  screws: bench.screws,
  "what is typed": typed,
  "what cannot work": bench.refused,
  regulate: bench.regulate,
  "a broken file": bench.file,
  compare: bench.compare,
  keyboard: bench.keyboard,
  "strings of a chord": bench.strung,
  ...(process.env.ERARD ? { diagnose, "a note is heard": sound.note, "the audio thread": sound.offline } : {}),
  "the story is heard": sound.told,
  "keys are heard": sound.live,
  "blocks of sound": sound.blocks,
  "the gallery": gallery,
  "terms in three languages": terms,
  "rough edges": edges,
  link: page.link,
  offline: page.offline,
  faults: page.faults,
  [LONG]: (browser) => axe(browser, asked.every),
  ...(asked.shots ? { screenshots: (browser) => page.screenshots(browser, asked.shots) } : {}),
  "random playing": (browser) => wild(browser, Number(asked.seconds)),
};

/** Tests of time, and hands that move in milliseconds, have the machine for themselves. */
const ALONE = new Set(["the story, step by step", "first picture", "a stranger's path", "the pedal", "keyboard", "strings of a chord", "keys are heard", "blocks of sound", "rough edges", "screenshots", "random playing"]);
if (asked.shots) mkdirSync(asked.shots, { recursive: true });
if (!process.env.ERARD) console.log("not run: bits, parquet and diagnose, for ERARD names no command");
const names = Object.keys(tests).filter((name) => !asked.only || name.includes(asked.only));
const together = names.filter((name) => !ALONE.has(name)).sort((a, b) => (b === LONG) - (a === LONG));
const failed = [];
/** Runs tests one after the other in a browser of its own, until none is left; `fail` is given the name of each that
 * does not hold, and returns the word that is printed for it. */
const lane = async (left, fail) => {
  if (!left.length) return;
  const browser = await open();
  for (let name; (name = left.shift()) !== undefined;) {
    const began = performance.now();
    browser.faults.length = 0;
    let said = "";
    try {
      said = (await tests[name](browser)) ?? "";
      if (browser.faults.length) throw new Error(browser.faults.join("\n  "));
    } catch (error) {
      said = `${fail(name)}: ${error.message}`;
    }
    for (const context of browser.browser.contexts()) await context.close();
    console.log(`${name} (${((performance.now() - began) / 1000).toFixed(1)} s) ${said}`);
  }
  await browser.close();
};
// A machine that stalls moves a hand by fits and starts: what fails the first time is tried once more by itself.
const again = [];
const later = (name) => (again.push(name), "to be tried again");
await Promise.all(Array.from({ length: Number(asked.lanes) }, () => lane(together, later)));
await lane(names.filter((name) => ALONE.has(name)), later);
await lane(again, (name) => (failed.push(name), "FAILED"));
for (const text of missed) console.log(`${asked.timed ? "FAILED" : "goal of time missed"}: ${text}`);
if (asked.timed) failed.push(...missed);
console.log(failed.length ? `${failed.length} failed` : "all hold");
process.exit(failed.length ? 1 : 0);
