// The numbers in the story's text: `<data data-claim=NAME value=NUMBER>`. `.ci/regenerate story` rewrites them.
import { mkdirSync, readFileSync, writeFileSync } from "node:fs";
import { assert } from "./help.mjs";

const PAGE = new URL("../index.html", import.meta.url);
/** Folder below which the page is written with the engine's numbers instead of failing where they differ. */
const folder = process.env.ERARD_REGENERATE;
export const rewriting = folder !== undefined;

/** A page in which a claim has another value, to as many digits as before, and the text the same number. `words` is the
 * text where it says the number in words: a person rewrites those. */
export const withClaim = (page, name, found) => {
  const match = new RegExp(`(<data data-claim="${name}" value=")([^"]*)(">)([^<]*)(?=</data>)`).exec(page);
  assert(match, `no claim ${name} is on the page`);
  const [whole, begin, value, between, text] = match;
  const number = found.toFixed(value.split(".")[1]?.length ?? 0).replace(/^-(0(\.0*)?)$/, "$1");
  const inText = new RegExp(`(?<![\\d.])${value.replace(".", "\\.")}(?![\\d.])`);
  const written = inText.test(text);
  const replaced = `${begin}${number}${between}${written ? text.replace(inText, number) : text}`;
  return { page: page.slice(0, match.index) + replaced + page.slice(match.index + whole.length), value: Number(number), words: written ? undefined : text };
};

/** Writes the page with these claims, and returns what remains to be rewritten by hand. */
export const rewrite = (claims) => {
  let page = readFileSync(PAGE, "utf8");
  const left = [];
  for (const [name, found] of claims) {
    const changed = withClaim(page, name, found);
    page = changed.page;
    if (changed.words !== undefined) left.push(`${name}: the engine gives ${changed.value}, the text says "${changed.words}"`);
  }
  mkdirSync(`${folder}/studio`, { recursive: true });
  writeFileSync(`${folder}/studio/index.html`, page);
  return left;
};

/** Values keep their digits, texts follow them, words are handed back, and nothing else changes. */
export const writer = async () => {
  const page = 'a <data data-claim="check" value="13">13&nbsp;mm</data> b <data data-claim="dip" value="10">a\ncentimetre</data> c <data data-claim="way-up" value="7.5">7.5&nbsp;mm</data>';
  assert.deepEqual(withClaim(page, "check", 13.62), { page: page.replace('"13">13&', '"14">14&'), value: 14, words: undefined });
  assert.deepEqual(withClaim(page, "dip", 11.2), { page: page.replace('"10"', '"11"'), value: 11, words: "a\ncentimetre" });
  assert.deepEqual(withClaim(page, "way-up", 6.96), { page: page.replaceAll("7.5", "7.0"), value: 7, words: undefined });
  assert.equal(withClaim(page, "check", -0.2).value, 0);
  assert.throws(() => withClaim(page, "blow", 1), /no claim blow/);
  const story = readFileSync(PAGE, "utf8");
  for (const [, name, value] of story.matchAll(/<data data-claim="([^"]*)" value="([^"]*)">/g)) {
    assert.equal(withClaim(story, name, Number(value)).page, story, `${name} is written as it is read`);
  }
};
