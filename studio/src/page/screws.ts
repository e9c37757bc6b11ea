// The screws: sliders with units, the sheet that follows, what does not work and why, and regulation in one click with
// a log of the turns.
import type { Dial, Regulated } from "../engine/protocol";
import type { App } from "./app";
import { Dropped } from "./bench";
import { fixed, h, later, say } from "./dom";
import { Sheet } from "./sheet";

const GROUPS: Record<string, string> = { screws: "Screws, from where they are", places: "Where parts stand", weights: "Weights", felts: "Felts, springs, what bends", friction: "Friction" };

/** Sliders of an action's dials. */
export class Dials {
  private rows = new Map<string, { input: HTMLInputElement; number: HTMLInputElement; back: HTMLButtonElement; dial: Dial }>();
  private made = "";

  /** @param some only these dials, by name, without headings: those of a part. */
  constructor(private readonly app: App, private readonly which: number, private readonly into: HTMLElement, private readonly some?: { of(): string[] }) {}

  /** Made again, whatever they were. */
  anew(): void {
    this.made = "";
    this.follow();
  }

  follow(): void {
    const loaded = this.app.loaded[this.which];
    if (!loaded) return this.into.replaceChildren();
    const made = JSON.stringify(loaded.dials);
    if (made !== this.made) {
      this.made = made;
      this.make(loaded.dials);
    }
    const { turns } = (this.which ? this.app.state.b : this.app.state.a) ?? loaded.setting;
    for (const [name, { input, number, back, dial }] of this.rows) {
      const value = turns[name] ?? dial.value;
      if (document.activeElement !== number) number.value = shown(dial, value).toFixed(dial.decimals);
      if (document.activeElement !== input || Math.abs(Number(input.value) - value) > 1e-9) input.value = String(value);
      input.setAttribute("aria-valuetext", `${fixed(shown(dial, value), dial.decimals)} ${spoken(dial.unit)}`);
      back.classList.toggle("idle", !(name in turns));
      back.disabled = !(name in turns);
    }
  }

  private make(dials: Dial[]): void {
    this.rows.clear();
    this.into.replaceChildren();
    if (this.some) {
      const wanted = this.some.of();
      this.into.append(...dials.filter(({ name }) => wanted.includes(name)).map((dial) => this.row(dial)));
      return;
    }
    for (const [group, heading] of Object.entries(GROUPS)) {
      const own = dials.filter((dial) => dial.group === group);
      if (!own.length) continue;
      const section = h("details", { open: group !== "friction" && group !== "felts" }, h("summary", {}, heading));
      for (const dial of own) section.append(this.row(dial));
      this.into.append(section);
    }
  }

  private row(dial: Dial): HTMLElement {
    const step = 10 ** -dial.decimals;
    const input = h("input", { type: "range", min: dial.from, max: dial.to, step: step / 10, "aria-label": dial.label, [this.some ? "data-turn" : "data-dial"]: dial.name });
    const number = h("input", { type: "number", min: shown(dial, dial.from), max: shown(dial, dial.to), step, "aria-label": `${dial.label}, ${spoken(dial.unit)}`, class: "exact" });
    const back = h("button", { type: "button", class: "back", title: `Back to ${fixed(shown(dial, dial.value), dial.decimals)} ${spoken(dial.unit)}, as the file has it`, "aria-label": `${dial.label}: back to the file's` }, "\u21ba");
    const turn = (text: string) => {
      const value = Number(text);
      if (text === "" || !Number.isFinite(value)) return;
      const rounded = Math.min(Math.max(Number(value.toFixed(dial.decimals + 1)), dial.from), dial.to);
      void this.app.turn(this.which, dial.name, Math.abs(rounded - dial.value) < step / 20 ? null : rounded);
    };
    input.addEventListener("input", () => {
      number.value = shown(dial, Number(input.value)).toFixed(dial.decimals);
      turn(input.value);
    });
    number.addEventListener("change", () => number.value === "" || turn(String(Number(number.value) + dial.value - shown(dial, dial.value))));
    back.addEventListener("click", () => void this.app.turn(this.which, dial.name, null));
    this.rows.set(dial.name, { input, number, back, dial });
    return h("div", { class: "dial", title: dial.note }, h("span", { class: "name" }, dial.label), input, h("span", { class: "value" }, number, h("span", { class: "unit" }, dial.unit === "x" ? "\u00d7" : dial.unit)), back);
  }
}

/** What a dial shows of a value: a screw is turned from where the file has it, so that it starts at 0; a mass or a
 * place
 * is itself. */
const shown = (dial: Dial, value: number): number => (dial.group === "screws" ? value - dial.value : value);

const spoken = (unit: string): string => (unit === "x" ? "times the file's" : unit);

export const screwsPanel = (app: App, into: HTMLElement): void => {
  const sliders = h("div", { class: "dials" });
  const dials = new Dials(app, 0, sliders);
  const sheet = new Sheet(app, 0);
  const why = h("div", { class: "notice", id: "why", role: "status", hidden: true });
  const log = h("div", { class: "log", id: "log", role: "status" });
  const reset = h("button", { type: "button", id: "reset", onclick: () => void app.change({ a: { ...app.state.a, turns: {} } }) }, "Reset");
  const regulate = h("button", { type: "button", id: "regulate" }, "Regulate");
  regulate.addEventListener("click", async () => {
    const before = app.loaded[0];
    if (!before) return;
    regulate.disabled = true;
    log.replaceChildren(h("p", {}, "Turns the screws, one after the other, and measures \u2026"));
    try {
      const done = await app.bench.ask<Regulated>({ kind: "regulate", text: before.text }, "regulate");
      if (app.loaded[0] !== before) {
        log.replaceChildren(h("p", {}, "The action was changed meanwhile: nothing is turned."));
        return;
      }
      const turns = { ...app.state.a.turns };
      for (const { screw, to } of done.screws) turns[screw] = to;
      await app.change({ a: { ...app.state.a, turns } });
      log.replaceChildren(...told(done, before.dials));
      say(done.all_met ? "Regulated: every goal is met." : "Regulated as far as the screws allow.");
    } catch (error) {
      if (!(error instanceof Dropped)) log.replaceChildren(h("p", { class: "bad" }, `It cannot be regulated: ${(error as Error).message}`));
    } finally {
      regulate.disabled = false;
    }
  });

  // What cannot work says why: the reader's words, or those of a press that went wrong.
  const tried = later(150, async () => {
    const text = app.loaded[0]?.text;
    if (!text || app.refused) return;
    try {
      const { hammer_speed_m_per_s, warnings } = await app.bench.ask<{ hammer_speed_m_per_s: number | null; warnings: string[] }>({ kind: "try", text });
      if (text !== app.loaded[0]?.text || app.refused) return;
      const said = [...(hammer_speed_m_per_s === null ? ["A mezzo forte does not bring the hammer to the string"] : []), ...warnings];
      why.replaceChildren(...said.map((one) => h("p", {}, `${one}.`)));
      why.hidden = !said.length;
    } catch (error) {
      if (error instanceof Dropped) return;
      why.replaceChildren(h("p", {}, (error as Error).message));
      why.hidden = false;
    }
  });

  into.append(
    h("div", { class: "row" }, regulate, reset),
    why,
    log,
    h("div", { class: "columns" }, sliders, h("div", { class: "sheet-place" }, sheet.table)),
    h("p", { class: "soft" }, "Norms are those of the key, of middle C where the file does not say which it is. Every line is measured as on a piano, in a simulation of its own: weights take some seconds."),
  );
  const follow = () => {
    const seen = app.state.tab === "screws";
    dials.follow();
    reset.disabled = !Object.keys(app.state.a.turns).length;
    sheet.look(seen);
    if (app.refused?.which === 0) {
      why.replaceChildren(h("p", {}, `This does not work: ${app.refused.message}. The action in the picture is the last one that does.`));
      why.hidden = false;
    } else if (seen) tried();
  };
  app.onchange.push(follow);
};

/** The log of a regulation. */
const told = (done: Regulated, dials: Dial[]): HTMLElement[] => {
  const label = (screw: string) => dials.find(({ name }) => name === screw)?.label ?? screw.replaceAll("_", " ");
  const turns = done.screws.map(({ screw, unit, from, to, turned_by, turns: threads, way }) => {
    const by = threads === null ? "" : `, about ${fixed(Math.abs(threads), 2)} turns`;
    return h("li", {}, `${label(screw)}: ${fixed(from, 2)} to ${fixed(to, 2)} ${unit}, ${way} by ${fixed(Math.abs(turned_by), 2)} ${unit}${by}`);
  });
  const missed = done.goals.filter(({ met }) => !met).map(({ goal, asked, after, unit, why_not }) => h("li", { class: "bad" }, `${goal}: asked ${fixed(asked, 2)} ${unit}, there is ${fixed(after, 2)} ${unit}${why_not ? `: ${why_not}` : ""}`));
  return [
    h("p", {}, done.all_met ? "Every goal is met. What was turned:" : "Regulated as far as the screws allow. What was turned:"),
    h("ol", {}, ...(turns.length ? turns : [h("li", {}, "nothing: it was regulated")])),
    ...(missed.length ? [h("p", {}, "What was missed:"), h("ul", {}, ...missed)] : []),
  ];
};
