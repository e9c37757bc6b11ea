// One's own piano: whatever was measured of a key is typed in; out come balance and friction, what is out of range, the
// likely causes with their tests, and what to measure next. The answer is erard_diagnose's, the command's own.
import type { Diagnosed, Diagnosis, Measurable, ReadingFault } from "../engine/protocol";
import type { App } from "./app";
import { Dropped } from "./bench";
import { fixed, h, say } from "./dom";
import { same } from "./state";
import { type Label, named } from "./terms";

/** What most people can measure, in the order of work; the rest is folded. */
const FIRST = ["down_weight_g", "up_weight_g", "let_off_mm", "drop_mm", "dip_mm", "blow_mm", "aftertouch_mm", "strike_weight_g", "front_weight_g", "leads", "key_ratio"];
const MIDDLE_C = 40;
/** In place of a unit: the entry is a condition, answered in words. */
const YES_OR_NO = "yes|no";
/** Fields that are no entries of the table. */
const KEY = { name: "key", label: "key", term: "diagnose.key", unit: "", usual: [null, null], how: "by number (1 to 88) or note (A0 to C8): usual ranges differ along the keyboard" };
const LEADS = { name: "leads", label: "leads", term: "diagnose.leads", unit: "g@mm", usual: [null, null], how: "grams at millimetres in front of the balance pin, as in 14@165, 14@147; behind it negative" };
/** What stands at the head of the printed sheet, and is no reading. */
const HEAD = ["piano", "date", "note"] as const;

type Field = Pick<Measurable, "name" | "label" | "unit" | "usual" | "how"> & { term?: string };
type Answer = { faults: ReadingFault[] } | { answer: Diagnosis };

const range = (low: number | null, high: number | null, decimals: number): string =>
  low !== null && high !== null ? `${fixed(low, decimals)}\u2013${fixed(high, decimals)}` : low !== null ? `\u2265 ${fixed(low, decimals)}` : high !== null ? `\u2264 ${fixed(high, decimals)}` : "";
const signed = (value: number, decimals: number): string => (value < 0 ? fixed(value, decimals) : `+${fixed(value, decimals)}`);
const percent = (share: number): string => {
  const whole = Math.round(100 * share);
  return whole < 1 ? "under 1\u00a0%" : whole > 99 ? "over 99\u00a0%" : `${whole}\u00a0%`;
};
/** What is put beside a reading: a sign, and a label. */
const MARKS: Record<string, [string, Label | null]> = { out: ["!", null], doubtful: ["? ", "diagnose.doubtful"], not_judged: ["", "diagnose.not-judged"] };
/** A label within a line. */
const term = (key: Label) => named(h("span"), key);
/** A reading, a cause: the engine's English, or the chosen language's term. */
const quantity = (name: string, label: string) => named(h("span"), `quantity.${name}`, label);
const cause = (key: string, name: string) => named(h("b"), `cause.${key}`, name);
/** Nodes with a text between them. */
const joined = (nodes: Node[][], between: string): (Node | string)[] => nodes.flatMap((some, n) => (n ? [between, ...some] : some));

/** The sheet of a key: what can be printed and taken to the piano. */
const sheetOf = (key: Diagnosed, { is_key_assumed, rests_on }: Diagnosis, head: [Label, string][], how: (name: string) => string): HTMLElement[] => {
  const readings = h("table", { class: "sheet" }, named(h("caption"), "diagnose.readings"));
  readings.append(
    h("thead", {}, h("tr", {}, ...(["diagnose.reading", "diagnose.here", "sheet.usual"] as const).map((key) => named(h("th", { scope: "col" }), key)), h("td"))),
    h("tbody", {}, ...key.readings.map((line) => {
      const value = line.value === null ? term("sheet.none") : `${fixed(line.value, line.decimals)} ${line.unit}`.trim();
      const [sign, mark] = MARKS[line.standing] ?? ["", null];
      return h("tr", { "data-reading": line.name }, named(h("th", { scope: "row" }), `quantity.${line.name}`, line.label), h("td", { class: line.standing === "out" ? "out" : null }, value), h("td", {}, range(line.usual_low, line.usual_high, line.decimals)), h("td", { class: `mark-text${line.standing === "out" ? " out" : ""}` }, sign, mark && term(mark)));
    })),
  );
  const causes = key.causes.map((one) =>
    h("li", { "data-cause": one.cause },
      cause(one.cause, one.name), `, ${percent(one.probability)}`,
      h("dl", { class: "facts" },
        ...(one.explains.length ? [named(h("dt"), "diagnose.explains"), h("dd", {}, ...joined(one.explains.map(({ name, label, by, unit, decimals }) => [quantity(name, label), new Text(` ${signed(by, decimals)} ${unit}`.trimEnd())]), ", "))] : []),
        named(h("dt"), "diagnose.test"), h("dd", {}, one.test),
        named(h("dt"), "diagnose.then"), h("dd", {}, one.cure),
      ),
    ));
  const next = key.measure_next;
  const why = key.readings.find(({ standing }) => standing === "not_judged")?.likely_reason;
  const band = (of: { low: number; high: number } | null, decimals: number, unit: string) => (of ? `${fixed(of.low, decimals)}\u2013${fixed(of.high, decimals)}${unit}` : term("diagnose.left-out"));
  return [
    h("h2", {}, `${key.note} (key ${key.key}): diagnosis of your readings`),
    ...(head.length ? [h("dl", { class: "head" }, ...head.flatMap(([name, text]) => [named(h("dt"), name), h("dd", {}, text)]))] : []),
    ...(is_key_assumed ? [h("p", { class: "assumed" }, `No key was named: usual ranges are those of ${key.note} (key ${key.key}).`)] : []),
    readings,
    ...(why ? [h("p", { class: "soft" }, `Not judged: ${why}.`)] : []),
    ...(key.to_do.length ? [named(h("h3"), "diagnose.to-do"), h("ol", { class: "to-do" }, ...key.to_do.map((line) => h("li", {}, line)))] : []),
    h(key.is_work ? "h3" : "p", { class: "verdict" }, key.verdict),
    ...(causes.length ? [h("ol", { class: "causes" }, ...causes)] : []),
    ...(key.open_question && key.open_question !== key.verdict ? [h("p", { class: "verdict" }, key.open_question)] : []),
    ...(key.undecided.length ? [h("ul", { class: "open" }, ...key.undecided.map((one) => h("li", { "data-open": one.cause }, cause(one.cause, one.name), `: ${one.test}`)))] : []),
    ...(key.something_else > 0.05 ? [h("p", { class: "soft" }, `Something that is not in this list: ${percent(key.something_else)}.`)] : []),
    ...(next ? [
      // Down-weight and up-weight are taken together.
      h("h3", {}, term("diagnose.next"), ": ", next.label.startsWith("down-weight and up-weight") ? term("diagnose.weights") : quantity(next.name, next.label)),
      h("p", {}, `How: ${next.how}.`),
      h("ul", { class: "next" }, ...next.would_read.map(({ value, causes, names }) => {
        const each = names.split(" + ");
        const all = causes.length ? joined(causes.map((one, n) => [named(h("span"), `cause.${one}`, each[n]!)]), " + ") : [term("diagnose.none-of-these")];
        return h("li", {}, term("diagnose.about"), ` ${fixed(value, next.decimals)} ${next.unit}`.trimEnd(), ": ", ...all);
      })),
    ] : []),
    named(h("h3"), "diagnose.follows"),
    h("p", { class: "soft" }, quantity("strike_weight_ratio", "leverage"), ": ", band(key.leverage, 2, "")),
    h("p", { class: "soft" }, term("diagnose.inertia"), ": ", band(key.inertia_kg, 2, " kg")),
    ...key.notes.map((line) => h("p", { class: "soft" }, line)),
    ...key.readings.filter(({ name }) => name === "down_weight_g" || name === "up_weight_g").map(({ name, label }) => h("p", { class: "soft" }, `${label}, ${how(name)}.`)),
    ...(key.is_work ? [h("p", { class: "soft" }, rests_on)] : []),
  ];
};

export const diagnosePanel = (app: App, into: HTMLElement): void => {
  const form = h("form", { class: "readings", novalidate: true, "aria-label": "Readings" });
  const sheet = h("div", { class: "diagnosis", id: "diagnosis" });
  const wrongAll = h("p", { class: "bad", id: "wrong-all", role: "alert", hidden: true });
  const inputs = new Map<string, { input: HTMLInputElement; how: HTMLElement; wrong: HTMLElement; field: Field }>();
  const head = new Map<string, HTMLInputElement>();
  let key = MIDDLE_C, shown: Record<string, string> | null = null;

  const hint = ({ how, usual: [low, high], unit }: Field, decimals: number) => {
    const usual = range(low, high, decimals);
    return `${how}${usual ? `. Usual: ${usual} ${unit}`.trimEnd() : ""}`;
  };
  const field = (of: Field, decimals = 0): HTMLElement => {
    const id = `reading-${of.name}`;
    // A telephone's keys for numbers have no letters: conditions are answered in words, and have no unit that follows.
    const isQuestion = of.unit === YES_OR_NO;
    const words = of.name === "key" || of.name === "leads" || isQuestion;
    const input = h("input", { id, type: "text", inputmode: words ? "text" : "decimal", autocomplete: "off", spellcheck: "false", list: isQuestion ? "yes-or-no" : null, "aria-describedby": `${id}-wrong ${id}-how` });
    const how = h("p", { class: "soft", id: `${id}-how` }, hint(of, decimals));
    const wrong = h("p", { class: "bad", id: `${id}-wrong`, hidden: true });
    inputs.set(of.name, { input, how, wrong, field: of });
    return h("div", { class: "reading", "data-field": of.name }, named(h("label", { for: id }), of.term ?? `quantity.${of.name}`, of.label), h("span", { class: "number" }, input, h("span", { class: "unit" }, isQuestion ? "" : of.unit)), wrong, how);
  };

  const given = (): Record<string, string> =>
    Object.fromEntries([...inputs].map(([name, { input }]) => [name, input.value.trim()] as const).filter(([, text]) => text !== ""));

  const point = (faults: ReadingFault[]) => {
    const general: string[] = [];
    for (const { input, wrong } of inputs.values()) {
      wrong.hidden = true;
      input.removeAttribute("aria-invalid");
    }
    for (const { name, found, expected } of faults) {
      const place = inputs.get(name);
      if (!place) {
        general.push(`${found}; expected ${expected}.`.replace(/^./, (first) => first.toUpperCase()));
        continue;
      }
      place.wrong.textContent = `${found}; expected ${expected}`;
      place.wrong.hidden = false;
      place.input.setAttribute("aria-invalid", "true");
      const folded = place.input.closest("details");
      if (folded) folded.open = true;
    }
    wrongAll.textContent = general.join(" ");
    wrongAll.hidden = general.length === 0;
  };

  const take = async (): Promise<void> => {
    const readings = given();
    app.bench.drop("diagnose");
    sheet.classList.add("waiting");
    try {
      const told = await app.bench.ask<Answer>({ kind: "diagnose", readings }, "diagnose");
      if (!same(readings, given())) return;
      point("faults" in told ? told.faults : []);
      if ("faults" in told) {
        sheet.replaceChildren();
        say(told.faults.map(({ found, expected }) => `${found}; expected ${expected}`).join(". "));
      } else {
        const [one] = told.answer.keys;
        sheet.replaceChildren(...sheetOf(one!, told.answer, HEAD.map((name): [Label, string] => [`diagnose.${name}`, head.get(name)!.value.trim()]).filter(([, text]) => text), (name) => inputs.get(name)!.field.how));
        say(one!.causes.length ? `${one!.causes.length === 1 ? "1 cause" : `${one!.causes.length} causes`}: ${one!.causes.map(({ name }) => name).join("; ")}.` : one!.verdict);
        await ranges(one!.key);
      }
      sheet.classList.remove("waiting");
      print.disabled = "faults" in told;
    } catch (error) {
      if (error instanceof Dropped) return;
      point([{ name: "", found: (error as Error).message, expected: "readings that can be diagnosed" }]);
    }
  };

  /** Usual ranges beside the fields are those of the key. */
  const ranges = async (of: number): Promise<void> => {
    if (of === key) return;
    key = of;
    for (const one of await app.bench.ask<Measurable[]>({ kind: "diagnosable", key })) inputs.get(one.name)!.how.textContent = hint(one, one.decimals);
  };

  const print = named(h("button", { type: "button", id: "print", disabled: true, onclick: () => window.print() }), "diagnose.print");
  const clear = named(h("button", { type: "button", id: "clear", onclick: () => void app.change({ readings: {} }) }), "diagnose.clear");
  form.addEventListener("submit", (event) => {
    event.preventDefault();
    // What is typed and asked for again is answered again: it may be nothing.
    if (same(given(), app.state.readings)) void take();
    else void app.change({ readings: given() });
  });
  form.addEventListener("change", ({ target }) => {
    if ((HEAD as readonly string[]).includes((target as HTMLInputElement).name)) void (sheet.childElementCount && take());
    else void app.change({ readings: given() });
  });

  const build = async () => {
    const all = await app.bench.ask<Measurable[]>({ kind: "diagnosable", key: MIDDLE_C });
    const of = (name: string) => (name === "leads" ? field(LEADS as Field) : ((one) => field(one, one.decimals))(all.find((one) => one.name === name)!));
    const rest = all.filter(({ name }) => !FIRST.includes(name));
    const titled = (name: (typeof HEAD)[number]) => {
      const input = h("input", { type: "text", id: `head-${name}`, name, autocomplete: "off", maxlength: 400 });
      head.set(name, input);
      return h("div", { class: "reading" }, named(h("label", { for: `head-${name}` }), `diagnose.${name}`), h("span", { class: "number" }, input));
    };
    form.append(
      h("datalist", { id: "yes-or-no" }, ...YES_OR_NO.split("|").map((value) => h("option", { value }))),
      h("div", { class: "fields" }, field(KEY as Field), ...FIRST.map(of)),
      h("details", {}, named(h("summary"), "diagnose.more"), h("div", { class: "fields" }, ...rest.map(({ name }) => of(name)))),
      h("details", {}, named(h("summary"), "diagnose.head"), h("div", { class: "fields" }, ...HEAD.map(titled))),
      wrongAll,
      h("div", { class: "row" }, named(h("button", { type: "submit", id: "diagnose" }), "diagnose.diagnose"), print, clear),
    );
    follow();
  };

  into.append(
    h("p", { class: "soft" }, "For your own piano. Enter what you measured of one key, however little; leave the rest empty."),
    h("div", { class: "columns" }, form, sheet),
  );
  const follow = () => {
    if (inputs.size === 0 || app.state.tab !== "diagnose") return;
    const { readings } = app.state;
    if (shown !== null && same(shown, readings)) return;
    const first = shown === null;
    shown = readings;
    for (const [name, { input }] of inputs) if (input.value.trim() !== (readings[name] ?? "")) input.value = readings[name] ?? "";
    if (Object.keys(readings).length) void take();
    else {
      sheet.replaceChildren();
      print.disabled = true;
      if (!first) point([]);
    }
  };
  app.onchange.push(follow);
  void build();
};
