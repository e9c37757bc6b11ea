// The file itself beside the action: edited with the reader's own errors at line and key, opened and saved.
import type { Check } from "../engine/protocol";
import type { App } from "./app";
import { h, later, save as download, say } from "./dom";
import { named } from "./terms";

export const filePanel = (app: App, into: HTMLElement): void => {
  const gutter = h("pre", { class: "gutter", "aria-hidden": "true" });
  const area = h("textarea", { spellcheck: "false", autocomplete: "off", wrap: "off", "aria-label": "Instrument file", "aria-describedby": "file-said", id: "file-text" });
  const said = h("p", { id: "file-said", role: "status" });
  const go = named(h("button", { type: "button", hidden: true }), "file.line");
  let shown = "";
  let wrong: Check["errors"][number] | null = null;

  const lines = () => {
    const count = area.value.split("\n").length;
    gutter.replaceChildren(...Array.from({ length: count }, (_, n) => h("span", { class: wrong?.line === n + 1 ? "wrong" : "" }, `${n + 1}\n`)));
  };
  const show = (text: string) => {
    shown = text;
    area.value = text;
    wrong = null;
    lines();
  };
  const tell = (error: Check["errors"][number] | null) => {
    wrong = error;
    area.setAttribute("aria-invalid", String(error !== null));
    said.className = error ? "bad" : "";
    said.textContent = error
      ? `Line ${error.line}${error.key ? `, ${error.key}` : ""}: ${error.message}${error.found ? `; found ${error.found}` : ""}${error.expected ? `; expected ${error.expected}` : ""}. The action is still the last sound one.`
      : "The file has no errors.";
    go.hidden = !error;
    lines();
  };
  go.addEventListener("click", () => {
    if (!wrong) return;
    area.focus();
    area.setSelectionRange(wrong.begin, wrong.end);
    area.scrollTop = Math.max((wrong.line - 5) * parseFloat(getComputedStyle(area).lineHeight), 0);
  });

  const take = async (text: string) => {
    const check = await app.bench.ask<Check>({ kind: "check", text });
    if (text !== area.value) return;
    if (!check.sound) return tell(check.errors[0] ?? null);
    if (check.kind !== "instrument") {
      said.className = "bad";
      said.textContent = "This is a keyboard file: the studio opens instruments, and the built-in keyboard's keys.";
      return;
    }
    shown = text;
    if (await app.setBase(0, { text })) tell(null);
    else {
      said.className = "bad";
      said.textContent = `${app.refused?.message ?? "It cannot be played"}. The action is still the last one that works.`;
    }
  };
  const edited = later(350, () => void take(area.value));
  area.addEventListener("input", () => {
    lines();
    edited();
  });
  area.addEventListener("scroll", () => (gutter.scrollTop = area.scrollTop));

  const opened = (text: string) => {
    show(text);
    void app.change({ tab: "file" });
    void take(text);
  };
  const choose = h("input", { type: "file", accept: ".toml,text/plain", class: "unseen", id: "instrument-file", "aria-label": "Open an instrument file" });
  choose.addEventListener("change", async () => {
    const file = choose.files?.[0];
    choose.value = "";
    if (!file) return;
    if (file.size > 4_000_000) return tell({ line: 0, column: 0, key: "", message: `${file.name} is larger than 4 MB`, found: "", expected: "", begin: 0, end: 0, text: "" });
    opened(await file.text());
  });
  document.addEventListener("instrument", (event) => opened((event as CustomEvent<string>).detail));
  const save = () => {
    download(area.value, `${app.title(0).replace(/[^\w.-]+/g, "-") || "instrument"}.toml`);
    say("The file is saved.");
  };

  into.append(
    h("div", { class: "row" }, named(h("button", { type: "button", id: "open", onclick: () => choose.click() }), "file.open"), named(h("button", { type: "button", id: "save", onclick: save }), "file.save"), choose, go),
    said,
    h("div", { class: "editor" }, gutter, area),
    h("p", { class: "soft" }, "Millimetres, grams, degrees. What you write here is read as the command reads it; a file can also be dropped onto the page."),
  );
  app.onchange.push(() => {
    const text = app.loaded[0]?.text;
    if (text === undefined || text === shown || app.refused || document.activeElement === area) return;
    show(text);
    said.textContent = "";
    go.hidden = true;
  });
};
