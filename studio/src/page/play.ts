// Play: how firm the finger is, how hard a key presses, strokes that are built in, and a recording that is dropped onto
// the page.
import type { App } from "./app";
import { fixed, h, save, say } from "./dom";
import { MAX_PEDAL_MM } from "./state";
import { called, type Label, named, spoken } from "./terms";

/** A pedal that is down, mm of its rail: dampers are clear of the strings. */
export const PEDAL_MM = 7;

/** A slider over decades: its place is the logarithm. */
const decades = (label: Label, unit: string, from: number, to: number, decimals: number, value: () => number, set: (value: number) => void) => {
  const output = h("output");
  const input = spoken(h("input", { type: "range", min: Math.log10(from), max: Math.log10(to), step: 0.01 }), label, called(label).text);
  const show = () => {
    input.value = String(Math.log10(value()));
    output.textContent = `${fixed(value(), decimals)} ${unit}`;
    input.setAttribute("aria-valuetext", output.textContent);
  };
  input.addEventListener("input", () => {
    set(Number((10 ** Number(input.value)).toPrecision(2)));
    show();
  });
  show();
  return { row: h("label", { class: "slider" }, named(h("span"), label), output, input), show };
};

export const playPanel = (app: App, into: HTMLElement): void => {
  const firm = decades("play.firmness", "N/mm", 0.1, 20, 2, () => app.state.firmness, (firmness) => void app.change({ firmness }, "firmness"));
  const force = decades("play.force", "N", 0.5, 30, 1, () => app.state.force, (value) => void app.change({ force: value }));
  const imposed = h("input", { type: "checkbox", id: "imposed" });
  imposed.addEventListener("change", () => void app.change({ imposed: imposed.checked }));
  const pedalled = h("output"), pedal = h("input", { type: "range", min: 0, max: MAX_PEDAL_MM, step: 0.05, id: "pedal" });
  spoken(pedal, "play.pedal", called("play.pedal").text);
  pedal.addEventListener("input", () => void app.change({ pedal: Number(pedal.value) }));
  const pedalRow = h("div", { hidden: true }, h("label", { class: "slider" }, named(h("span"), "play.pedal"), pedalled, pedal), h("p", { class: "soft" }, "Dampers lie on the strings at 0, half at 2 mm, and are clear of them at 7. ", h("kbd", {}, "P"), " puts it down and lifts it."));
  const press = named(h("button", { type: "button", class: "press", id: "press" }), "play.press");
  const down = (event: PointerEvent) => {
    press.setPointerCapture(event.pointerId);
    app.push(app.state.force);
  };
  press.addEventListener("pointerdown", down);
  for (const over of ["pointerup", "pointercancel"] as const) press.addEventListener(over, () => app.push(0));
  press.addEventListener("keydown", (event) => {
    if (event.key !== " " && event.key !== "Enter") return;
    event.preventDefault();
    if (!event.repeat) app.push(app.state.force);
  });
  press.addEventListener("keyup", (event) => {
    event.preventDefault();
    app.push(0);
  });
  // A switch or a reader of the screen clicks without a pointer.
  press.addEventListener("click", ({ detail }) => {
    if (detail !== 0) return;
    app.push(app.state.force);
    setTimeout(() => app.push(0), 250);
  });

  const strokes = h("div", { class: "strokes", role: "group", "aria-label": "Built-in strokes" });
  for (const struck of [false, true]) {
    const row = h("div", {}, named(h("span"), struck ? "play.struck" : "play.pressed"));
    for (const nuance of ["pp", "p", "mf", "f", "ff"]) {
      row.append(h("button", { type: "button", "aria-label": `${nuance}, ${struck ? "struck" : "pressed"}`, onclick: () => app.stroke({ nuance, struck }) }, nuance));
    }
    strokes.append(row);
  }

  const saved = named(h("button", { type: "button", id: "save-run", disabled: true }), "play.save");
  saved.addEventListener("click", async () => {
    const stroke = app.lastStroke, text = app.loaded[0]?.text;
    if (!stroke || text === undefined) return;
    saved.disabled = true;
    try {
      save(await app.bench.ask<string>({ kind: "run", text, stroke }), "run.csv", "text/csv");
      say("The run is saved.");
    } catch (error) {
      app.notice((error as Error).message);
    }
    saved.disabled = false;
  });
  const listen = named(h("button", { type: "button", id: "hear" }), "play.hear"), said = h("p", { class: "soft", id: "hear-said", role: "status" });
  app.hears(listen, said, 0);
  const recorded = h("p", { class: "soft", id: "recorded" });
  const done = h("ul", { class: "soft", id: "made-ready" });
  let kept: { csv: string; name: string; rows?: boolean } | null = null;
  const again = named(h("button", { type: "button", hidden: true, onclick: () => kept && app.stroke(kept) }), "play.again");
  const read = async (file: File) => {
    const head = new Uint8Array(await file.slice(0, 4).arrayBuffer());
    if (new TextDecoder("latin1").decode(head) !== "PAR1") return { csv: await file.text(), name: file.name };
    const { tableOf } = await import("./parquet");
    const csv = await tableOf(await file.arrayBuffer(), (titles) => app.bench.ask({ kind: "columns", titles }));
    return { csv, name: file.name, rows: true };
  };
  const play = async (file: File) => {
    if (file.size > 50_000_000) return app.notice(`${file.name} is larger than 50 MB; a stroke of some seconds is enough.`);
    try {
      kept = await read(file);
    } catch (error) {
      const message = `${file.name}: ${(error as Error).message.replace(/^recording:\s*/, "")}`;
      say(message);
      return app.notice(message);
    }
    recorded.textContent = `${file.name}, ${Math.ceil(file.size / 1000)} kB`;
    again.hidden = false;
    app.stroke(kept);
    say(`Plays ${file.name}.`);
  };
  const choose = h("input", { type: "file", accept: ".csv,.txt,.parquet,text/csv,text/plain", class: "unseen", id: "recording", "aria-label": "Open a recorded stroke" });
  choose.addEventListener("change", () => {
    const file = choose.files?.[0];
    choose.value = "";
    if (file) void play(file);
  });
  // A file may be dropped anywhere: a stroke is played, an instrument is opened.
  addEventListener("dragover", (event) => event.preventDefault());
  window.addEventListener("drop", (event) => {
    event.preventDefault();
    const file = event.dataTransfer?.files[0];
    if (!file) return;
    if (/\.toml$/i.test(file.name)) void file.text().then((text) => document.dispatchEvent(new CustomEvent("instrument", { detail: text })));
    else void play(file);
  });

  into.append(
    h("p", {}, "Drag the key down in the picture: the pointer is the end of a soft fingertip. Or hold ", h("kbd", {}, "space"), ", or this:"),
    press,
    firm.row,
    h("p", { class: "soft" }, "Soft: the pointer goes far for little force. Firm: the key follows it."),
    h("label", { class: "row" }, imposed, named(h("span"), "play.imposed")),
    force.row,
    pedalRow,
    named(h("h2"), "play.strokes"),
    h("p", { class: "soft" }, "Each is played from rest, by the hand and the fingertip of ", h("kbd", {}, "erard press"), ", and gives the numbers of that command."),
    strokes,
    h("div", { class: "row" }, saved, listen),
    said,
    named(h("h2"), "play.recording"),
    h("p", { class: "soft" }, "A CSV or Parquet file with a column for the time and one for force or position (a run.csv is one), dropped onto the page or opened here. It is prepared as by the command: its zero is the rest before the touch."),
    h("div", { class: "row" }, named(h("button", { type: "button", onclick: () => choose.click() }), "play.open"), again, choose),
    recorded,
    done,
    named(h("h2"), "play.back"),
    h("p", { class: "soft" }, "The last second is always kept, every step of it. ", h("kbd", {}, "R"), " replays it, ", h("kbd", {}, "L"), " goes back to now; drag the slider or the curves to look at an instant. Speeds go down to 1/1000."),
  );
  app.onchange.push(() => {
    firm.show();
    imposed.checked = app.state.imposed;
    force.show();
    pedalRow.hidden = !app.scenes.some((scene) => scene.pedal);
    pedal.value = String(app.state.pedal);
    pedalled.textContent = `${fixed(app.state.pedal, 2)} mm`;
    pedal.setAttribute("aria-valuetext", pedalled.textContent);
  });
  app.onstroke.push(() => (saved.disabled = false));
  app.onstroke.push((told) => done.replaceChildren(...told.map((line) => h("li", {}, line))));
};
