// The page: gets the engine, and puts panels and keys to work.
import "uplot/dist/uPlot.min.css";
import { engine } from "../engine/load";
import { App } from "./app";
import { byId, h, say } from "./dom";
import { comparePanel } from "./compare";
import { diagnosePanel } from "./diagnose";
import { exampleStrip } from "./example";
import { filePanel } from "./file";
import { keyboardPanel } from "./keyboard";
import { numbers } from "./numbers";
import { partCard } from "./part";
import { PEDAL_MM, playPanel } from "./play";
import { screwsPanel } from "./screws";
import { called, languages, missing, named, onlanguage } from "./terms";

// Scripts run here, so that nothing is missing.
document.getElementById("still")?.remove();

const SPEEDS = [1, 2, 5, 10, 20, 50, 100, 200, 500, 1000];

const begin = async (): Promise<void> => {
  const app = new App(await engine());
  await languages(byId<HTMLSelectElement>("language"));
  const on = (id: string, act: () => void) => byId(id).addEventListener("click", act);
  const pictures = (act: (picture: App["pictures"][number]) => void) => app.pictures.forEach(act);
  on("whole", () => pictures((picture) => picture.lookWhole()));
  on("close-up", () => pictures((picture) => picture.lookClose()));
  on("zoom-in", () => pictures((picture) => picture.zoom(0.8)));
  on("zoom-out", () => pictures((picture) => picture.zoom(1.25)));
  on("undo", () => void app.undo());
  on("redo", () => void app.redo());
  on("live", () => app.goLive());
  on("replay", () => app.replay());
  on("link", async () => {
    const link = await app.link(), word = byId("link").firstElementChild!;
    history.replaceState(null, "", link);
    try {
      await navigator.clipboard.writeText(link);
      say("The link is copied.");
      named(word, "tool.copied");
    } catch {
      named(word, "tool.in-address");
    }
    setTimeout(() => named(word, "tool.link"), 2000);
  });
  const boxes = [["arrows", "forces"], ["naming", "names"]] as const;
  for (const [id, what] of boxes) byId(id).addEventListener("change", ({ target }) => void app.change({ [what]: (target as HTMLInputElement).checked }));
  byId<HTMLInputElement>("beside").addEventListener("change", ({ target }) => void app.change({ beside: (target as HTMLInputElement).checked }));
  const speed = byId<HTMLSelectElement>("speed");
  for (const slower of SPEEDS) speed.add(slower === 1 ? named(new Option("", "1"), "tool.real-time") : new Option(`1/${slower}`, String(1 / slower)));
  speed.addEventListener("change", () => app.setSpeed(Number(speed.value)));
  const slow = byId<HTMLInputElement>("slow");
  slow.addEventListener("change", () => void app.change({ slow: slow.checked }));
  const time = byId<HTMLInputElement>("time");
  time.addEventListener("input", () => app.seek(Number(time.value)));

  const instrument = byId<HTMLSelectElement>("instrument");
  instrument.addEventListener("change", () => void app.setBase(0, { builtin: instrument.value }));

  // Panels, one at a time.
  const panels = [
    { id: "play", make: playPanel },
    { id: "screws", make: screwsPanel },
    { id: "file", make: filePanel },
    { id: "compare", make: comparePanel },
    { id: "keyboard", make: keyboardPanel },
    { id: "diagnose", make: diagnosePanel },
  ] as const;
  const tabs = document.querySelector(".tabs")!;
  const made = panels.map(({ id, make }) => {
    const tab = named(h("button", { type: "button", role: "tab", id: `tab-${id}`, "aria-controls": `panel-${id}`, onclick: () => void app.change({ tab: id }) }), `tab.${id}`);
    tabs.append(tab);
    const panel = h("div", { role: "tabpanel", id: `panel-${id}`, "aria-labelledby": `tab-${id}`, tabindex: 0 });
    byId("panels").append(panel);
    make(app, panel);
    return { id, tab, panel };
  });
  // A tab is as wide as when it is chosen.
  const widths = () => made.forEach(({ id, tab }) => (tab.dataset.title = called(`tab.${id}`).text));
  onlanguage.push(widths);
  widths();
  const show = () => {
    if (!made.some(({ id }) => id === app.state.tab)) app.state.tab = "play";
    for (const { id, tab, panel } of made) {
      const chosen = id === app.state.tab;
      tab.setAttribute("aria-selected", String(chosen));
      tab.tabIndex = chosen ? 0 : -1;
      panel.hidden = !chosen;
    }
    const { base } = app.state.a;
    const own = "builtin" in base ? [] : [new Option("key" in base ? `key ${base.key} of the keyboard` : "a file of yours", "")];
    instrument.replaceChildren(...own, ...app.builtin.map((name) => new Option(name, name)));
    instrument.value = "builtin" in base ? base.builtin : "";
    document.body.className = app.state.tab;
    for (const [id, what] of boxes) byId<HTMLInputElement>(id).checked = app.state[what];
    const slower = SPEEDS.reduce((best, one) => (Math.abs(Math.log(one * app.state.speed)) < Math.abs(Math.log(best * app.state.speed)) ? one : best));
    speed.value = String(1 / slower);
    slow.checked = app.state.slow;
    byId<HTMLButtonElement>("undo").disabled = !app.canUndo;
    byId<HTMLButtonElement>("redo").disabled = !app.canRedo;
  };
  tabs.addEventListener("keydown", (event) => {
    const key = (event as KeyboardEvent).key;
    const now = made.findIndex(({ id }) => id === app.state.tab);
    const next = key === "ArrowRight" ? now + 1 : key === "ArrowLeft" ? now - 1 : key === "Home" ? 0 : key === "End" ? made.length - 1 : null;
    if (next === null) return;
    event.preventDefault();
    const to = made[(next + made.length) % made.length]!;
    void app.change({ tab: to.id });
    to.tab.focus();
  });
  app.onchange.unshift(show);
  numbers(app, byId("numbers"));
  partCard(app);
  exampleStrip(app);

  // Keys. The space bar is a finger, unless the focus is on something that takes it itself.
  const takes = (target: EventTarget | null) => target instanceof Element && target.matches("input:not([type=range]), textarea, select, button, a[href], [role=tab], summary, .keys");
  // A control that was clicked has done its work: it does not keep the space bar from the key.
  let pointer = false;
  for (const event of ["pointerdown", "keydown"] as const) addEventListener(event, () => (pointer = event === "pointerdown"), { capture: true });
  const leave = (target: EventTarget | null) => {
    if (target instanceof HTMLElement && target === document.activeElement) target.blur();
  };
  document.addEventListener("click", ({ detail, target }) => {
    if (detail > 0) leave((target as Element).closest("button, summary, input[type=checkbox]"));
  });
  document.addEventListener("change", ({ target }) => {
    if (pointer && target instanceof HTMLSelectElement) leave(target);
  });
  let space = false;
  window.addEventListener("keydown", (event) => {
    if ((event.ctrlKey || event.metaKey) && event.key.toLowerCase() === "z" && !(event.target instanceof HTMLTextAreaElement)) {
      event.preventDefault();
      void (event.shiftKey ? app.redo() : app.undo());
      return;
    }
    if (event.ctrlKey || event.altKey || event.metaKey || takes(event.target)) return;
    if (event.key === " " || event.key === "Enter") {
      event.preventDefault();
      if (event.repeat) return;
      space = true;
      app.push(app.state.force);
    } else if (event.key === "r") app.replay();
    else if (event.key === "l") app.goLive();
    else if (event.key === "p" && app.scenes.some(({ pedal }) => pedal)) void app.change({ pedal: app.state.pedal ? 0 : PEDAL_MM });
    else if (event.key === "0") pictures((picture) => picture.lookWhole());
    else if (event.key === "9") pictures((picture) => picture.lookClose());
    else if (event.key === "+") pictures((picture) => picture.zoom(0.8));
    else if (event.key === "-") pictures((picture) => picture.zoom(1.25));
  });
  window.addEventListener("keyup", (event) => {
    if (!space || (event.key !== " " && event.key !== "Enter")) return;
    space = false;
    app.push(0);
  });
  addEventListener("blur", () => app.push(0));
  // For tests.
  Object.assign(window, { studio: app, terms: { missing } });
  await app.start();
  show();
  document.documentElement.dataset.ready = "true";
};

begin().catch((error: unknown) => {
  const place = byId("fault");
  place.textContent = `The studio cannot begin: ${error instanceof Error ? error.message : error}`;
  place.hidden = false;
});
if ("serviceWorker" in navigator && import.meta.env.PROD) void navigator.serviceWorker.register("./sw.js").catch(() => {});
