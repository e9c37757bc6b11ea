// Every state of the pages by the rules of axe, on a phone and with `--every` on a desk, in light and dark; none is
// wider than its screen.
import { readFile } from "node:fs/promises";
import { createRequire } from "node:module";
import { assert } from "./help.mjs";
import { LOOKS, READ, STATES } from "./states.mjs";

/** The rules that look at colours: in the dark nothing else of a page differs. */
const OF_COLOURS = ["color-contrast", "link-in-text-block"];

const findings = (page, places, rules) => page.evaluate(async ([places, rules]) => {
  const { violations } = await axe.run(places ? { include: places } : document, { resultTypes: ["violations"], ...(rules ? { runOnly: rules } : {}) });
  return violations.map(({ id, nodes }) => `${id}: ${nodes.slice(0, 4).map(({ html }) => html.slice(0, 140)).join(" | ")}`);
}, [places, rules]);

/** Checks what is on a page now: by all rules, then in the dark where it is to be by those of colours. */
const check = async (page, name, { colorScheme }, places = null) => {
  assert.deepEqual(await findings(page, places), [], name);
  const { width } = page.viewportSize();
  const wide = await page.evaluate(() => document.documentElement.scrollWidth);
  assert(wide <= width, `${name}: ${wide} px wide`);
  if (colorScheme !== "dark") return 1;
  await page.emulateMedia({ colorScheme });
  // Inks fade from one to the other.
  await page.waitForTimeout(300);
  assert.deepEqual(await findings(page, places, OF_COLOURS), [], `${name}, dark`);
  await page.emulateMedia({ colorScheme: "light" });
  return 2;
};

export const axe = async ({ visit, read }, every) => {
  const source = await readFile(createRequire(import.meta.url).resolve("axe-core/axe.min.js"), "utf8");
  const of = async (look) => {
    const options = { ...LOOKS[look], colorScheme: "light", bypassCSP: true };
    let checked = 0;
    // One page for all steps of the story: the whole of it once, then each step with the bar that names it.
    const page = await read("", options);
    await page.evaluate(source);
    for (const [name, { act, step }] of Object.entries(READ)) {
      await act(page);
      checked += await check(page, `${name}, ${look}`, LOOKS[look], step ? [[`#${step}`], [".bar"]] : null);
    }
    await page.context().close();
    for (const [name, { hash, act }] of Object.entries(STATES)) {
      const page = await visit(hash, options);
      await page.waitForTimeout(200);
      await act?.(page);
      await page.evaluate(source);
      checked += await check(page, `${name}, ${look}`, LOOKS[look]);
      await page.context().close();
    }
    return checked;
  };
  const checked = await Promise.all((every ? ["dark", "phone"] : ["phone"]).map(of));
  return `${checked.reduce((sum, one) => sum + one)} states without findings, none wider than its screen`;
};
