// The screws: sliders with units, the sheet that follows, what does not work and why, and regulation in one click with
// a log of the turns.
import type { Dial, Regulated } from "../engine/protocol";
import type { App } from "./app";
import { Dropped } from "./bench";
import { fixed, h, later, say } from "./dom";
import { Sheet } from "./sheet";
import { type Label, named, spoken } from "./terms";

const GROUPS: Record<string, Label> = { screws: "screws.screws", places: "screws.places", weights: "screws.weights", felts: "screws.felts", friction: "screws.friction" };

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
      if (document.activeElement !== number && !number.hasAttribute("aria-invalid")) number.value = text(dial, value);
      if (document.activeElement !== input || Math.abs(Number(input.value) - value) > 1e-9) input.value = String(value);
      input.setAttribute("aria-valuetext", `${fixed(shown(dial, value), dial.decimals)} ${said(dial.unit)}`);
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
      const section = h("details", { open: group !== "friction" && group !== "felts" }, named(h("summary"), heading));
      for (const dial of own) section.append(this.row(dial));
      this.into.append(section);
    }
  }

  private row(dial: Dial): HTMLElement {
    const step = 10 ** -dial.decimals;
    const term = `screw.${dial.name}`, input = spoken(h("input", { type: "range", min: dial.from, max: dial.to, step: step / 10, [this.some ? "data-turn" : "data-dial"]: dial.name }), term, dial.label);
    const id = `typed-${++fields}`;
    const number = h("input", { type: "text", autocomplete: "off", spellcheck: "false", "aria-describedby": id, class: "exact", title: HINT });
    spoken(number, term, dial.label, ({ text, lang }) => `${text}, ${lang && dial.unit === "x" ? "\u00d7" : said(dial.unit)}`);
    const wrong = h("p", { class: "bad", id, hidden: true });
    const back = h("button", { type: "button", class: "back", title: `Back to ${fixed(shown(dial, dial.value), dial.decimals)} ${said(dial.unit)}, as the file has it`, "aria-label": `${dial.label}: back to the file's` }, "\u21ba");
    const turn = (value: number) => this.app.turn(this.which, dial.name, Math.abs(value - dial.value) < 1e-9 ? null : value);
    const point = (message: string | null) => {
      wrong.textContent = message ?? "";
      wrong.hidden = message === null;
      if (message === null) number.removeAttribute("aria-invalid");
      else number.setAttribute("aria-invalid", "true");
    };
    // Undo takes back one thing: a drag of the slider, one typed value, one way back.
    input.addEventListener("pointerdown", () => this.app.apart());
    const turnApart = (value: number | null) => {
      this.app.apart();
      const turned = value === null ? this.app.turn(this.which, dial.name, null) : turn(value);
      this.app.apart();
      return turned;
    };
    input.addEventListener("input", () => {
      point(null);
      const value = Number(Number(input.value).toFixed(dial.decimals + 1));
      number.value = text(dial, value);
      void turn(Math.abs(value - dial.value) < step / 20 ? dial.value : value);
    });
    // What is typed is read by the engine, as the command reads it.
    number.addEventListener("change", async () => {
      const typed = number.value, file = this.app.loaded[this.which]?.baseText;
      if (file === undefined) return;
      try {
        const value = await this.app.bench.ask<number>({ kind: "dial-typed", text: file, dial: dial.name, typed });
        if (number.value !== typed) return;
        point(null);
        number.value = text(dial, value);
        await turnApart(value);
      } catch (error) {
        if (error instanceof Dropped || number.value !== typed) return;
        point((error as Error).message);
        say((error as Error).message);
      }
    });
    back.addEventListener("click", () => {
      point(null);
      void turnApart(null);
    });
    this.rows.set(dial.name, { input, number, back, dial });
    return h("div", { class: "dial", title: dial.note }, named(h("span", { class: "name" }), term, dial.label), input, h("span", { class: "value" }, number, h("span", { class: "unit" }, dial.unit === "x" ? "\u00d7" : dial.unit)), back, wrong);
  }
}

/** How many fields there are: each has a name for its error. */
let fields = 0;

/** What may be typed into the fields of this panel. */
const HINT = "A value (0.3, 1/64in), a change from the file with its sign (+0.5, \u22120.2 mm), or a factor (x1.05). Without a unit: the unit shown.";

/** What a dial shows of a value: a screw is turned from where the file has it, so that it starts at 0; a mass or a
 * place
 * is itself. */
const shown = (dial: Dial, value: number): number => (dial.group === "screws" ? value - dial.value : value);

/** The text of a dial's field: a change from the file has a sign, as it would be typed. */
const text = (dial: Dial, value: number): string => {
  const digits = shown(dial, value).toFixed(dial.decimals);
  return dial.group !== "screws" || (digits.startsWith("-") && Number(digits) !== 0) ? digits : `+${digits.replace("-", "")}`;
};

const said = (unit: string): string => (unit === "x" ? "times the file's" : unit);

export const screwsPanel = (app: App, into: HTMLElement): void => {
  const sliders = h("div", { class: "dials" });
  const dials = new Dials(app, 0, sliders);
  const sheet = new Sheet(app, 0);
  const why = h("div", { class: "notice", id: "why", role: "status", hidden: true });
  const log = h("div", { class: "log", id: "log", role: "status" });
  const reset = h("button", { type: "button", id: "reset", onclick: () => void app.change({ a: { ...app.state.a, turns: {} } }) });
  named(reset, "screws.reset");
  const regulate = named(h("button", { type: "button", id: "regulate" }), "screws.regulate");
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
      say(done.goals.length === 0 ? "Nothing is turned: every distance is in its usual range." : done.all_met ? "Regulated: every goal is met." : "Regulated as far as the screws allow.");
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
    h("div", { class: "columns" }, h("div", {}, h("p", { class: "soft" }, HINT), sliders, byName(app)), h("div", { class: "sheet-place" }, sheet.table)),
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

/** Any number of the file, changed by the name that command, Python and C have for it. */
const byName = (app: App): HTMLElement => {
  const field = (id: string, label: string, example: string) =>
    h("input", { id, type: "text", "aria-label": label, placeholder: example, autocomplete: "off", autocapitalize: "off", spellcheck: "false", "aria-describedby": "changed-wrong" });
  const path = field("changed-name", "name of a number", "body.hammer.mass"), change = field("changed-by", "its change", "+0.8 g");
  const wrong = h("p", { class: "bad", id: "changed-wrong", hidden: true });
  const form = h("form", { id: "changed", novalidate: true }, h("div", { class: "row" }, path, change, named(h("button", { type: "submit" }), "screws.change")), wrong,
    h("p", { class: "soft" }, "Typed as above. Without a unit: mm, g, degrees or N mm, else SI; the unit at the end of a path (body.hammer.mass_g)."));
  form.addEventListener("submit", async (event) => {
    event.preventDefault();
    const before = app.loaded[0];
    if (!before) return;
    form.classList.add("waiting");
    let message = "";
    try {
      const text = await app.bench.ask<string>({ kind: "vary", text: before.text, called: path.value, change: change.value });
      if (app.loaded[0] !== before) message = "The action was changed meanwhile: nothing is changed.";
      else if (!(await app.setBase(0, { text }))) message = app.refused?.message ?? "";
    } catch (error) {
      message = error instanceof Dropped ? "" : (error as Error).message;
    }
    wrong.textContent = message;
    wrong.hidden = !message;
    for (const input of [path, change]) message ? input.setAttribute("aria-invalid", "true") : input.removeAttribute("aria-invalid");
    if (message) say(message);
    form.classList.remove("waiting");
  });
  return h("details", { id: "any" }, named(h("summary"), "screws.any"), form);
};

/** The log of a regulation. */
const told = (done: Regulated, dials: Dial[]): HTMLElement[] => {
  const turns = done.screws.map(({ screw, unit, from, to, turned_by, turns_text, way }) => {
    const dial = dials.find(({ name }) => name === screw);
    // As the panel beside it shows the screw: from where the file has it.
    const place = (value: number) => (dial ? text(dial, value) : fixed(value, 2)).replace("-", "\u2212");
    const by = turns_text === null ? "" : `, ${turns_text}`;
    return h("li", {}, `${dial?.label ?? screw.replaceAll("_", " ")}: ${place(from)} to ${place(to)} ${unit}, ${way} by ${fixed(Math.abs(turned_by), 2)} ${unit}${by}`);
  });
  const missed = done.goals.filter(({ met }) => !met).map(({ goal, asked, after, unit, why_not }) => h("li", { class: "bad" }, `${goal}: asked ${fixed(asked, 2)} ${unit}, there is ${fixed(after, 2)} ${unit}${why_not ? `: ${why_not}` : ""}`));
  return [
    h("p", {}, done.goals.length === 0 ? "Every distance with a screw is in its usual range: nothing is turned. What is red has no screw; \u201cDiagnose\u201d finds its cause." : done.all_met ? "What was out of its usual range is at the trade\u2019s norm, all else as it was. What was turned:" : "Regulated as far as the screws allow. What was turned:"),
    ...(turns.length ? [h("ol", {}, ...turns)] : []),
    ...(missed.length ? [h("p", {}, "What was missed:"), h("ul", {}, ...missed)] : []),
  ];
};
