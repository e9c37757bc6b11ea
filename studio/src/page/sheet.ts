// The protocol sheet beside the screws: measured anew after every turn, line by line as they come, with the usual
// range.
import type { SheetGroup } from "../engine/protocol";
import type { App } from "./app";
import { Dropped } from "./bench";
import { fixed, h, later } from "./dom";
import { named } from "./terms";

/** Lines that are measured together, the cheap ones first: each costs what the others of its group have paid
 * already. */
const PARTS = [
  ["dip_mm", "blow_mm", "let_off_mm", "drop_mm", "aftertouch_mm", "check_mm"],
  ["repetition_rate_hz"],
  ["effective_inertia_kg"],
  ["down_weight_g", "up_weight_g", "balance_weight_g", "friction_weight_g", "strike_weight_ratio_weights", "strike_weight_g", "front_weight_g"],
];
/** In the order of the page. */
const SHOWN = [
  "down_weight_g", "up_weight_g", "balance_weight_g", "friction_weight_g", "strike_weight_ratio_weights", "effective_inertia_kg", "strike_weight_g", "front_weight_g",
  "dip_mm", "blow_mm", "let_off_mm", "drop_mm", "aftertouch_mm", "check_mm", "repetition_rate_hz",
];

const MIDDLE_C = 40;

type Values = Record<string, number | null>;

export class Sheet {
  readonly table: HTMLTableElement;
  /** The key whose norms hold: middle C where nobody says which it is. */
  private key = MIDDLE_C;
  private lines = new Map<string, SheetGroup["lines"][number]>();
  private rows = new Map<string, { row: HTMLTableRowElement; now: HTMLTableCellElement; norm: HTMLElement; mark: HTMLElement }>();
  private values: Values = {};
  private text = "";
  private readonly cache = new Map<string, Values>();
  /** Whether it is looked at: what nobody sees is not measured. */
  private seen = false;

  constructor(private readonly app: App, private readonly which: number, private readonly group = `sheet-${which}`, caption: string | null = null) {
    this.table = h("table", { class: "sheet" }, caption === null ? named(h("caption"), "sheet.caption") : h("caption", {}, caption));
    this.table.append(h("thead", {}, h("tr", {}, ...(["sheet.measure", "sheet.now", "sheet.usual"] as const).map((key) => named(h("th", { scope: "col" }), key)))));
    void this.build();
  }

  private async build(): Promise<void> {
    const key = this.key;
    const groups = await this.app.bench.ask<SheetGroup[]>({ kind: "sheet", key });
    if (key !== this.key) return;
    this.table.tBodies[0]?.remove();
    this.rows.clear();
    for (const line of groups.flatMap(({ lines }) => lines)) this.lines.set(line.key, line);
    const body = h("tbody");
    for (const key of SHOWN) {
      const line = this.lines.get(key);
      if (!line) continue;
      const [low, high] = line.usual;
      const number = (value: number) => fixed(value, line.decimals);
      const usual = low !== null && high !== null ? `${number(low)}\u2013${number(high)}` : low !== null ? `\u2265 ${number(low)}` : high !== null ? `\u2264 ${number(high)}` : "";
      const mark = h("span", { class: "mark" });
      const norm = h("span", { class: "norm", "aria-hidden": "true", hidden: low === null || high === null }, h("span", { class: "range" }), mark);
      const now = h("td");
      const row = h("tr", { title: line.source ?? "", "data-line": key }, named(h("th", { scope: "row" }), `quantity.${key}`, line.label), now, h("td", {}, h("span", {}, usual), norm));
      body.append(row);
      this.rows.set(key, { row, now, norm, mark });
    }
    this.table.append(body);
    this.show();
  }

  look(seen: boolean): void {
    this.seen = seen;
    if (seen) this.follow();
    else this.app.bench.drop(this.group);
  }

  /** The text of the action that it belongs to may have changed. */
  follow(): void {
    const loaded = this.app.loaded[this.which];
    const text = loaded?.text;
    if (!text || !this.seen) return;
    const { base } = loaded.setting, key = "key" in base ? base.key : MIDDLE_C;
    if (key !== this.key) {
      this.key = key;
      void this.build();
    }
    if (text === this.text && PARTS.flat().every((key) => key in this.values)) return;
    if (text !== this.text) {
      this.text = text;
      this.values = { ...(this.cache.get(text) ?? {}) };
      this.show();
    }
    this.measure();
  }

  private readonly measure = later(120, () => {
    const { app, group, text } = this;
    app.bench.drop(group);
    for (const part of PARTS) {
      if (part.every((key) => key in this.values)) continue;
      app.bench.ask<Values>({ kind: "measure", text, lines: part.join(",") }, group).then((values) => {
        if (text !== this.text) return;
        Object.assign(this.values, values);
        if (this.cache.size > 60) this.cache.clear();
        this.cache.set(text, { ...this.values });
        this.show();
      }).catch((error: Error) => {
        if (error instanceof Dropped || text !== this.text) return;
        for (const key of part) this.values[key] = null;
        this.why = error.message;
        this.show();
      });
    }
  });

  /** Why something could not be measured. */
  why = "";
  onmeasured: () => void = () => {};

  private show(): void {
    for (const [key, { row, now, norm, mark }] of this.rows) {
      const line = this.lines.get(key)!, known = key in this.values, value = this.values[key];
      row.classList.toggle("waiting", !known);
      now.textContent = known ? `${fixed(value, line.decimals)} ${line.unit}`.trim() : "\u2026";
      const [low, high] = line.usual;
      // Values and ends are compared as they are read, as in the command: digits that nobody sees raise no flag.
      const read = (x: number) => Number(x.toFixed(line.decimals));
      const isLow = typeof value === "number" && low !== null && read(value) < read(low), isHigh = typeof value === "number" && high !== null && read(value) > read(high);
      const isMissing = known && value === null && (low !== null || high !== null);
      const flag = isMissing ? "sheet.none" : isLow ? "sheet.low" : isHigh ? "sheet.high" : null;
      now.classList.toggle("out", flag !== null);
      if (flag) now.append(" ", named(h("span", { class: "flag" }), flag));
      if (low !== null && high !== null && value !== null && value !== undefined) {
        const share = Math.min(Math.max((value - low) / (high - low), -0.5), 1.5);
        mark.style.insetInlineStart = `${25 + 50 * share}%`;
        norm.classList.add("known");
      } else norm.classList.remove("known");
    }
    if (PARTS.flat().every((key) => key in this.values)) this.onmeasured();
  }

  get complete(): boolean {
    return PARTS.flat().every((key) => key in this.values);
  }
}
