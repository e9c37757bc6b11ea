// The words of the trade in German and French: complete, each with a source or the mark "unchecked", the same as the
// book's; and the page's switch of language.
import { readFile } from "node:fs/promises";
import { EXAMPLES } from "../src/page/examples.js";
import { assert, until } from "./help.mjs";

const ROOT = new URL("../../", import.meta.url);
const text = (path) => readFile(new URL(path, ROOT), "utf8");
const json = async (name) => JSON.parse(await text(`studio/terms/${name}.json`));
const TAGS = ["de", "fr"];
/** What the engine names in words of everyday language. */
const PLAIN = new Set(["quantity.assist_g", "quantity.measured_at_mm", "part.finger"]);
const sorted = (names) => [...new Set(names)].sort();

/** Files of terms against each other, against the page's own text and against the book's table. */
const files = async () => {
  const english = await json("en"), terms = Object.fromEntries(await Promise.all(TAGS.map(async (tag) => [tag, await json(tag)])));
  const counts = [];
  for (const tag of TAGS) {
    const { sources, words, labels } = terms[tag];
    for (const [word, [said, source, ...rest]] of Object.entries(words)) {
      assert(said && rest.length === 0, `${tag}: ${word}`);
      assert(source === "unchecked" || source in sources, `${tag}: ${word} names a source that is not in the list: ${source}`);
    }
    assert.deepEqual(sorted(Object.values(words).map(([, source]) => source).filter((source) => source !== "unchecked")), sorted(Object.keys(sources)), `${tag}: sources that no word names`);
    // A source is found by its author, its title, its year and its address.
    for (const [name, source] of Object.entries(sources)) assert.match(source, /^.+, .+, (\d{4}|no year), https?:\/\/\S+$/, `${tag}: ${name}`);
    for (const [key, [said, ...of]] of Object.entries(labels)) {
      assert(said, `${tag}: ${key}`);
      // What the engine names is a term, and says its source by the words that it is made of.
      if (/^(quantity|cause|screw|zone|part)\.(?!numbers)/.test(key)) assert(of.length > 0 || PLAIN.has(key), `${tag}: ${key} names no word of the list`);
      // A label uses the words of the trade as they stand in the list, whatever its grammar does to them.
      for (const word of of) {
        assert(word in words, `${tag}: ${key} names a word that is not in the list: ${word}`);
        for (const part of words[word][0].toLowerCase().split(" ")) assert(said.toLowerCase().includes(part), `${tag}: "${said}" (${key}) does not say "${words[word][0]}"`);
      }
    }
    const checked = Object.values(words).filter(([, source]) => source !== "unchecked").length;
    counts.push(`${tag}: ${checked} words with a source, ${Object.keys(words).length - checked} unchecked, ${Object.keys(labels).length} labels`);
  }
  assert.deepEqual(sorted(Object.keys(terms.de.words)), sorted(Object.keys(terms.fr.words)), "words of one language only");
  assert.deepEqual(sorted(Object.keys(terms.de.labels)), sorted(Object.keys(terms.fr.labels)), "labels of one language only");
  for (const key of Object.keys(terms.de.labels)) assert.deepEqual(key in english, !/^(quantity|cause|screw|zone)\.|^part\.(?!numbers)|^example\.(?!next|all)/.test(key), `${key} is a label of the page or one of the engine, and not both`);
  // The page's own text is the English of its labels.
  for (const [, key, said] of (await text("studio/tools.html")).matchAll(/data-term="([^"]*)"[^>]*>([^<]*)</g)) assert.equal(said, english[key], key);
  // The book has the same words, the unchecked ones marked.
  const table = (await text("book/src/glossary.md")).split("\n## ")[1].split("\n").filter((line) => /^\| (?!English)/.test(line));
  const book = { de: {}, fr: {} };
  for (const line of table) {
    const [names, ...said] = line.split("|").slice(1, 4).map((cell) => cell.replace(/\([^)]*\)/, "").trim().split(", "));
    TAGS.forEach((tag, column) => names.forEach((name, n) => (book[tag][name] = said[column][n])));
  }
  for (const tag of TAGS) assert.deepEqual(book[tag], Object.fromEntries(Object.entries(terms[tag].words).map(([word, [said, source]]) => [word, source === "unchecked" ? `${said}\u00b0` : said])), `book/src/glossary.md, ${tag}`);
  return { english, terms, counts };
};

/** What the engine can ask the page to name: its quantities, screws and contacts, and the causes of its table. */
const asked = async (page) => {
  const causes = [...(await text("crates/erard-workshop/src/diagnose/causes.toml")).split("\n[[look]]")[0].matchAll(/^key = "(\w+)"/gm)].map(([, key]) => `cause.${key}`);
  const engine = await page.evaluate(async () => {
    const names = new Set();
    for (const { name } of await studio.bench.ask({ kind: "diagnosable", key: 40 })) names.add(`quantity.${name}`);
    document.querySelectorAll("#panel-screws .sheet tr[data-line]").forEach(({ dataset }) => names.add(`quantity.${dataset.line}`));
    for (const builtin of studio.builtin) {
      await studio.setBase(0, { builtin });
      for (const { name } of studio.loaded[0].dials) names.add(`screw.${name}`);
      for (const { name } of studio.scenes[0].zones) names.add(`zone.${name}`);
      for (const { value } of document.getElementById("parts").options) if (value) names.add(`part.${value}`);
    }
    return [...names];
  });
  return [...causes, ...engine, ...EXAMPLES.map(({ id }) => `example.${id}`)];
};

export const terms = async ({ visit, faults }) => {
  const { english, terms, counts } = await files();
  const page = await visit("#tab=screws");
  await until(page, () => document.querySelectorAll("#panel-screws .sheet tr[data-line]").length > 10);
  const engine = await asked(page);
  for (const tag of TAGS) assert.deepEqual(sorted(Object.keys(terms[tag].labels)), sorted([...Object.keys(english), ...engine]), `${tag}: labels that are missing, or that nothing asks for`);
  // English first; then each language by the page's own switch, in every panel.
  assert.equal(await page.inputValue("#language"), "en");
  assert.equal(await page.locator("[data-term][lang]").count(), 0);
  const first = await page.evaluate(() => [...document.querySelectorAll("[data-term]:not(input)")].map((one) => [one.dataset.term, one.textContent]));
  for (const tag of TAGS) {
    await page.focus("#language");
    await page.selectOption("#language", tag);
    await until(page, (tag) => document.getElementById("tab-screws").lang === tag, tag);
    const { labels } = terms[tag];
    for (const tab of ["play", "screws", "file", "compare", "keyboard", "diagnose"]) {
      await page.click(`#tab-${tab}`);
      if (tab === "compare") await page.selectOption("#other", "heavy-touch");
      if (tab === "diagnose") {
        for (const [name, said] of Object.entries({ key: "C4", down_weight_g: "58", up_weight_g: "18", let_off_mm: "3.5", drop_mm: "0", blow_mm: "47" })) await page.fill(`[data-field=${name}] input`, said);
        await page.click("#diagnose");
        await page.waitForSelector("#diagnosis .causes");
      }
      // Every label is that of the file, whole, and says in which language it is.
      const said = await page.evaluate(() => [...document.querySelectorAll("[data-term]")].map((one) => ({ key: one.dataset.term, said: one.matches("input") ? one.getAttribute("aria-label").split(", ")[0] : one.textContent, lang: one.lang })));
      for (const { key, said: shown, lang } of said) {
        assert(key in labels, `${tag}, ${tab}: ${key}`);
        assert(shown === labels[key][0] || labels[key][0].startsWith(`${shown}, `), `${tag}, ${tab}: ${key} is "${shown}" and not "${labels[key][0]}"`);
        assert.equal(lang, tag, key);
      }
    }
    assert.deepEqual(await page.evaluate(() => [...terms.missing]), [], tag);
    // What is drawn and composed follows, too.
    await page.click("#tab-play");
    await page.check("#naming");
    await until(page, (word) => [...document.querySelectorAll("#pictures .names text")].some((one) => one.textContent === word), labels["part.jack"][0]);
    await page.selectOption("#parts", "let-off button");
    await until(page, (word) => document.querySelector("#part h2").textContent.startsWith(word), labels["part.let-off button"][0]);
    await page.click("#part button[aria-label=Close]");
    await page.evaluate(() => studio.push(5));
    await until(page, (word) => document.querySelector("#curves .u-title")?.textContent === word, labels["curve.travel"][0]);
    await page.evaluate(() => studio.push(0));
  }
  // The choice is remembered; the page itself is English, and its sentences are.
  await page.reload();
  await page.waitForSelector("html[data-ready=true]");
  assert.equal(await page.inputValue("#language"), "fr");
  assert.equal(await page.textContent("#tab-screws"), terms.fr.labels["tab.screws"][0]);
  assert.equal(await page.getAttribute("html", "lang"), "en");
  await page.selectOption("#language", "en");
  await until(page, () => document.querySelectorAll("[data-term][lang]").length === 0);
  const again = new Set(await page.evaluate(() => [...document.querySelectorAll("[data-term]:not(input)")].map((one) => `${one.dataset.term}: ${one.textContent}`)));
  for (const [key, said] of first) if (!key.startsWith("tool.")) assert(again.has(`${key}: ${said}`), `${key} was "${said}"`);
  assert.deepEqual(faults, []);
  return counts.join("; ");
};
