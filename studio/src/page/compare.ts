// Compare: a second action under the same finger, overlaid or side by side, and what differs between their curves.
import type { App } from "./app";
import { fixed, h } from "./dom";
import { Dials } from "./screws";
import { Sheet } from "./sheet";
import { type Label, named } from "./terms";

export const comparePanel = (app: App, into: HTMLElement): void => {
  const select = h("select", { "aria-label": "Action B", id: "other" });
  const difference = h("input", { type: "checkbox", id: "difference" });
  difference.addEventListener("change", () => void app.change({ difference: difference.checked }));
  const swap = h("button", { type: "button", id: "swap", onclick: () => app.state.b && void app.change({ a: app.state.b, b: app.state.a }) });
  named(swap, "compare.swap");
  const copy = h("button", { type: "button", id: "copy", onclick: () => void app.change({ b: structuredClone(app.state.a) }) });
  named(copy, "compare.copy");
  const listen = named(h("button", { type: "button", id: "hear-both" }), "compare.hear"), said = h("p", { class: "soft", id: "hear-both-said", role: "status" });
  app.hears(listen, said, 0, 1);
  const numbers = h("table", { class: "sheet", id: "differences" });
  const sliders = h("div", { class: "dials" });
  const dials = new Dials(app, 1, sliders);
  const sheets = [new Sheet(app, 0, "compare-a", "A"), new Sheet(app, 1, "compare-b", "B")];
  const two = h("div", { class: "columns" }, ...sheets.map(({ table }) => h("div", { class: "sheet-place" }, table)));
  const more = h("div", {}, h("div", { class: "row" }, swap, h("label", {}, difference, " ", named(h("span"), "compare.difference")), listen), said, numbers, named(h("h2"), "compare.sheets"), two, named(h("h2"), "compare.turn"), sliders);
  select.addEventListener("change", () => {
    if (select.value === "") void app.change({ b: null, beside: false });
    else if (select.value !== "own") void app.setBase(1, { builtin: select.value });
  });
  into.append(
    h("p", {}, "Two actions under one finger: what you press moves both."),
    h("div", { class: "row" }, h("label", { class: "field" }, named(h("span"), "compare.other"), " ", select), copy),
    more,
  );
  app.onchange.push(() => {
    const { b } = app.state;
    const own = b && !("builtin" in b.base);
    select.replaceChildren(named(new Option("", ""), "compare.nothing"), ...app.builtin.map((name) => new Option(name, name)), ...(own ? [new Option("key" in b.base ? `key ${b.base.key}` : "a file", "own")] : []));
    select.value = !b ? "" : "builtin" in b.base ? b.base.builtin : "own";
    more.hidden = !b;
    difference.checked = app.state.difference;
    dials.follow();
    const seen = app.state.tab === "compare" && b !== null && app.loaded.length > 1;
    sheets.forEach((sheet) => sheet.look(seen));
  });
  const lines: [Label, string, number, (which: number) => number | undefined][] = [
    ["number.hammer-speed", "m/s", 2, (which) => app.hammerSpeedOf(which)],
    ["number.last-push", "ms", 1, (which) => 1e3 * (app.events[which]!.let_off_s - app.events[which]!.key_start_s)],
    ["number.free-flight", "ms", 1, (which) => 1e3 * app.events[which]!.free_flight_s],
    ["number.key-bottom", "ms", 1, (which) => 1e3 * app.events[which]!.key_bottom_after_impact_s],
  ];
  const cells = lines.map(([name, unit]) => {
    const row = numbers.insertRow();
    row.append(h("th", { scope: "row" }, named(h("span"), name), `, ${unit}`));
    return [row.insertCell(), row.insertCell(), row.insertCell()];
  });
  numbers.prepend(named(h("caption"), "compare.impact"));
  numbers.createTHead().append(h("tr", {}, ...["", "A", "B", "B \u2212 A"].map((head) => (head ? h("th", { scope: "col" }, head) : h("td")))));
  app.onframe.push(({ poses }) => {
    if (app.state.tab !== "compare" || poses.length < 2) return;
    lines.forEach(([, , decimals, of], index) => {
      const [a, b] = [of(0), of(1)];
      const texts = [fixed(a, decimals), fixed(b, decimals), fixed(a === undefined || b === undefined ? NaN : b - a, decimals)];
      texts.forEach((text, n) => (cells[index]![n]!.textContent = text));
    });
  });
};
