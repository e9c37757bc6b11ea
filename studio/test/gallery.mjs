// The gallery: each example by one click from the front page, by what its sentence says there is to see.
import { readFile } from "node:fs/promises";
import { addressOf, EXAMPLES } from "../src/page/examples.js";
import { assert, until } from "./help.mjs";

const book = (name) => readFile(new URL(`../../book/src/${name}.md`, import.meta.url), "utf8");
/** Waits until an example's stroke is over and its instant is looked at. */
const shown = (page) => until(page, () => document.getElementById("live").getAttribute("aria-pressed") === "false" && studio.events.length > 0, undefined, 60_000);
/** The same, and what both actions did. */
const events = async (page) => {
  await shown(page);
  return page.evaluate(() => studio.events);
};
const weights = async (page) => {
  await until(page, () => document.querySelectorAll("#panel-compare tr[data-line=down_weight_g]:not(.waiting)").length === 2, undefined, 120_000);
  return page.evaluate(() => [...document.querySelectorAll("#panel-compare tr[data-line=down_weight_g]")].map((row) => Number.parseFloat(row.cells[1].textContent)));
};
const passage = (page, text) => until(page, (text) => document.getElementById("passage-said").textContent.startsWith(text), text, 120_000);

/** What must hold of each once it is played. */
const HOLDS = {
  "worn-regulation": async (page) => {
    const [a, b] = await events(page);
    assert.deepEqual([a.impact_count, b.impact_count], [1, 0]);
  },
  "double-strike": async (page) => {
    const [a, b] = await events(page);
    assert.deepEqual([a.impact_count, b.impact_count], [1, 2]);
  },
  "capstan-moved": async (page) => {
    const [a, b] = await events(page);
    assert(b.hammer_speed_m_per_s < a.hammer_speed_m_per_s - 0.03);
    const [first, second] = await weights(page);
    assert(second > first + 8, `${first} and ${second} g`);
  },
  "struck-beside-pressed": async (page) => {
    const [a, b] = await events(page);
    assert(Math.abs(a.hammer_speed_m_per_s - b.hammer_speed_m_per_s) < 0.02);
    // From the stroke's beginning, as the picture is seen.
    const share = b.hammer_contact_s / a.hammer_contact_s;
    assert(share > 0.4 && share < 0.6, `${share} of the time`);
  },
  "lost-repetition": async (page) => {
    const [a, b] = await events(page);
    assert.deepEqual([a.impact_count, b.impact_count], [2, 1]);
  },
  "heavy-touch": async (page) => {
    const [a, b] = await events(page);
    assert(b.hammer_speed_m_per_s < a.hammer_speed_m_per_s - 0.1 && b.hammer_contact_s > a.hammer_contact_s + 2e-3);
    const [first, second] = await weights(page);
    assert(second > first + 5, `${first} and ${second} g`);
  },
  pedal: async (page) => {
    await until(page, () => studio.hammerSpeedOf(0) > 1 && studio.poses[0].time_s > 0.9 && studio.poses[0].key_m < 1e-3, undefined, 60_000);
    const before = await page.evaluate(() => studio.poses[0].swing_m);
    // Of half a millimetre; the soundboard has taken the rest.
    assert(before > 1e-5, `the string swings by ${before} m`);
    await page.evaluate(() => document.activeElement.blur());
    await page.keyboard.press("p");
    await until(page, (before) => studio.poses[0].swing_m < 0.2 * before, before);
  },
  "lost-notes": async (page) => {
    await passage(page, "4 of 12 notes sounded; 8 were lost");
    assert.equal(await page.locator("#passage-notes .sounded").count(), 4);
    await page.selectOption("#which-keyboard", "concert-grand");
    await page.click("#passage");
    await passage(page, "12 of 12 notes sounded");
  },
};

/** The book has a command for each: its options are those of the reference. */
const commands = async () => {
  const [studio, cli] = await Promise.all([book("studio"), book("cli")]);
  for (const { id, title } of EXAMPLES) {
    const [, said] = studio.match(new RegExp(`\\n# ${title}\\n((?:erard [^\\n]*\\n)+)`)) ?? [];
    assert(said, `book/src/studio.md has no commands under "# ${title}" (${id})`);
    for (const command of said.trim().split("\n")) {
      const [, name, ...words] = command.split("#")[0].trim().split(/\s+/);
      const section = cli.split(`## erard ${name}\n`)[1]?.split("\n## ")[0];
      assert(section, `${command}: there is no such command`);
      for (const option of words.filter((word) => word.startsWith("--"))) assert(section.includes(`\`${option.split("=")[0]} `) || section.includes(`\`${option.split("=")[0]}\``), `${command}: ${option} is not in the reference`);
    }
  }
};

export const gallery = async ({ read, visit, faults }) => {
  await commands();
  assert.deepEqual(Object.keys(HOLDS), EXAMPLES.map(({ id }) => id));
  const front = await read();
  const cards = await front.evaluate(() => [...document.querySelectorAll("#examples a")].map((card) => {
    const { width, height } = card.getBoundingClientRect(), picture = card.querySelector("svg").getBoundingClientRect();
    return { to: card.getAttribute("href"), said: card.querySelector("span").textContent, width, height, picture: picture.width, drawn: card.querySelectorAll("svg > *").length };
  }));
  assert.deepEqual(cards.map(({ to, said }) => [to, said]), EXAMPLES.map((example) => [`./tools.html#${addressOf(example)}`, example.title]));
  for (const { said, width, height, picture, drawn } of cards) assert(width >= 24 && height >= 24 && picture > 60 && drawn > 1, said);
  await front.context().close();
  for (const [n, example] of EXAMPLES.entries()) {
    const page = await read();
    const card = page.locator("#examples a").nth(n);
    // By mouse or by keyboard: each opens it.
    if (n % 2) await card.click();
    else {
      await card.focus();
      await page.keyboard.press("Enter");
    }
    await page.waitForSelector("html[data-ready=true] #example:not([hidden])");
    const said = await page.textContent("#example p");
    assert.equal(said, `${example.title}. ${example.see}`);
    await HOLDS[example.id](page);
    await page.context().close();
  }
  // On a phone everything of the strip can be hit, and nothing is wider than the screen.
  const phone = await visit(`#${addressOf(EXAMPLES[1])}`, { viewport: { width: 390, height: 844 }, hasTouch: true, isMobile: true });
  const targets = await phone.evaluate(() => [...document.querySelectorAll("#example a, #example button, header select, header button, .tabs button")].map((one) => [one.id || one.textContent, one.getBoundingClientRect()]).map(([name, { width, height }]) => [name, Math.round(width), Math.round(height)]));
  for (const [name, width, height] of targets) assert(width >= 24 && height >= 24, `${name} is ${width} by ${height} px`);
  assert(await phone.evaluate(() => document.documentElement.scrollWidth <= innerWidth));
  await phone.context().close();
  // From one to the next by the link; the same again; a reloaded address shows it anew; closed, it is gone.
  const page = await visit(`#${addressOf(EXAMPLES[0])}`);
  for (const { id, title } of [...EXAMPLES.slice(1), EXAMPLES[0]]) {
    await page.focus("#example-next");
    await page.keyboard.press("Enter");
    await until(page, ([id, title]) => studio.state.example === id && document.querySelector("#example b").textContent === `${title}.`, [id, title]);
  }
  await shown(page);
  await page.click("#example-again");
  await until(page, () => document.getElementById("live").getAttribute("aria-pressed") === "true");
  await shown(page);
  await page.reload();
  await page.waitForSelector("html[data-ready=true] #example:not([hidden])");
  await shown(page);
  await page.click("#example button[aria-label='Close the example']");
  await page.waitForSelector("#example", { state: "hidden" });
  await until(page, () => !location.hash.includes("example="));
  assert.deepEqual(faults, []);
  return `${EXAMPLES.length} examples, each by one click`;
};
