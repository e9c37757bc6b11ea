// What things are called: in English as the page and the engine have it, in German and French by terms/de.json and
// terms/fr.json, which name the source of every word of the trade. Labels follow the chosen language while they are on
// the page; sentences stay English.
import english from "../../terms/en.json";

export const LANGUAGES = { en: "English", de: "Deutsch", fr: "Fran\u00e7ais" } as const;
export type Language = keyof typeof LANGUAGES;
/** A label of the page's own. The engine's labels (`quantity.`, `cause.`, `screw.`, `part.`, `zone.`) come with their
 * English. */
export type Label = keyof typeof english;
/** A text, and its language where that is not the page's. */
export interface Called {
  text: string;
  lang: Language | null;
}

/** Where the choice is remembered. */
const KEPT = "erard-language";
const FILES = { de: () => import("../../terms/de.json"), fr: () => import("../../terms/fr.json") };

let language: Language = "en", wanted: Language = "en";
let labels: Record<string, string[]> = {};
/** For tests: labels that the chosen language does not have. */
export const missing = new Set<string>();
/** Told when another language is chosen: for what is drawn or composed. */
export const onlanguage: (() => void)[] = [];

/** What something is called now. A screw that only the reader's file has keeps the name that it has there. */
export function called(key: Label): Called;
export function called(key: string, inEnglish: string): Called;
export function called(key: string, inEnglish = (english as Record<string, string>)[key] ?? key): Called {
  if (language === "en") return { text: inEnglish, lang: null };
  const text = labels[key]?.[0];
  if (text !== undefined) return { text, lang: language };
  missing.add(key);
  return { text: inEnglish, lang: null };
}

/** `lang` of an element is that of its text. */
export const speaks = (element: Element, lang: Language | null): void => {
  if (lang) element.setAttribute("lang", lang);
  else element.removeAttribute("lang");
};

/** What is done again to an element when the language changes: once for its text, once for its spoken name. */
const names = new WeakMap<Element, Map<string, () => void>>();
const follow = <E extends Element>(element: E, what: string, key: string, put: () => void): E => {
  const own = names.get(element) ?? new Map<string, () => void>();
  own.set(what, put);
  names.set(element, own);
  element.setAttribute("data-term", key);
  put();
  return element;
};

/** Gives an element its text, and keeps it in the chosen language. */
export function named<E extends Element>(element: E, key: Label): E;
export function named<E extends Element>(element: E, key: string, inEnglish: string): E;
export function named<E extends Element>(element: E, key: string, inEnglish?: string): E {
  return follow(element, "text", key, () => {
    const { text, lang } = called(key, inEnglish!);
    if (element.textContent !== text) element.textContent = text;
    speaks(element, lang);
  });
}

/** Gives an element the name that a screen reader says, and keeps it in the chosen language. */
export const spoken = <E extends Element>(element: E, key: string, inEnglish: string, whole: (called: Called) => string = ({ text }) => text): E =>
  follow(element, "name", key, () => {
    const now = called(key, inEnglish);
    element.setAttribute("aria-label", whole(now));
    speaks(element, now.lang);
  });

/** Changes the language of all labels, and remembers it. */
export const speak = async (next: Language): Promise<void> => {
  wanted = next;
  const found = next === "en" ? {} : (await FILES[next]()).default.labels;
  // Another one was chosen meanwhile.
  if (wanted !== next) return;
  [language, labels] = [next, found];
  try {
    localStorage.setItem(KEPT, next);
  } catch {
    // A browser that keeps nothing forgets the choice with the page.
  }
  for (const element of document.querySelectorAll("[data-term]")) names.get(element)?.forEach((put) => put());
  onlanguage.forEach((told) => told());
};

/** The language that was chosen the last time. */
const kept = (): Language => {
  try {
    const found = localStorage.getItem(KEPT);
    return found !== null && found in LANGUAGES ? (found as Language) : "en";
  } catch {
    return "en";
  }
};

/** Names what the page's own text has, and lets `select` choose the language. */
export const languages = async (select: HTMLSelectElement): Promise<void> => {
  for (const element of document.querySelectorAll("[data-term]")) named(element, element.getAttribute("data-term") as Label);
  for (const [tag, name] of Object.entries(LANGUAGES)) {
    const option = new Option(name, tag);
    if (tag !== "en") option.lang = tag;
    select.add(option);
  }
  select.addEventListener("change", () => void speak(select.value as Language));
  const first = kept();
  select.value = first;
  if (first !== "en") await speak(first).catch(() => (select.value = "en"));
};
