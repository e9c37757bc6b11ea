// The few things that every panel needs to make elements.

type Child = Node | string | null | false | undefined;
type Attributes = Record<string, string | number | boolean | null | undefined | ((event: never) => void)>;

/** An element: attributes by name (true: there, false or null: not), listeners as `onclick` and so on. */
export const h = <K extends keyof HTMLElementTagNameMap>(tag: K, attributes: Attributes = {}, ...children: Child[]): HTMLElementTagNameMap[K] => {
  const made = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (typeof value === "function") made.addEventListener(name.slice(2), value as EventListener);
    else if (value === true) made.setAttribute(name, "");
    else if (value !== false && value !== null && value !== undefined) made.setAttribute(name, String(value));
  }
  for (const child of children) if (child) made.append(child);
  return made;
};

export const byId = <T extends Element = HTMLElement>(id: string): T => {
  const found = document.getElementById(id);
  if (!found) throw new Error(`the page has no #${id}`);
  return found as Element as T;
};

/** Saves a text as a file of the reader's. */
export const save = (text: string, name: string, type = "text/plain"): void => {
  const link = h("a", { href: URL.createObjectURL(new Blob([text], { type })), download: name });
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
};

/** Says something to screen readers, too. */
export const say = (text: string): void => {
  byId("said").textContent = text;
};

export const fixed = (value: number | null | undefined, decimals: number): string =>
  value === null || value === undefined || !Number.isFinite(value) ? "\u2013" : (value + 0).toFixed(decimals).replace(/^-(0(\.0*)?)$/, "$1").replace("-", "\u2212");

/** Runs a piece of work when nothing has asked for it again for so long, ms. */
export const later = <A extends unknown[]>(wait_ms: number, work: (...given: A) => void): ((...given: A) => void) => {
  let timer: ReturnType<typeof setTimeout> | undefined;
  return (...given) => {
    clearTimeout(timer);
    timer = setTimeout(() => work(...given), wait_ms);
  };
};
