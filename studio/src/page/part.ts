// The part that is pointed at or taken: its name, what it is for, its numbers now, and what one turns of it.
import type { Pose, Scene } from "../engine/protocol";
import type { App } from "./app";
import { byId, fixed, h, say } from "./dom";
import { mainPart, PARTS, type PartText } from "./parts";
import { Dials } from "./screws";
import { type Called, called, type Label, named, onlanguage, speaks } from "./terms";

export interface Chosen {
  action: number;
  part: string;
}

/** A part of a drawing that nothing is written about has its body's numbers. */
const textOf = (part: string): PartText => PARTS[part] ?? { does: "" };

/** The contacts of a part, as numbers of the scene's zones. */
const zonesOf = (scene: Scene, part: string, body: number | null): number[] => {
  const { zones } = textOf(part);
  const all = scene.zones.map((_, zone) => zone);
  if (zones) return all.filter((zone) => zones.includes(scene.zones[zone]!.name));
  return body === null ? [] : all.filter((zone) => scene.zones[zone]!.disc === body || scene.zones[zone]!.curve === body);
};

/** Its numbers, a name and a value each. */
const numbersOf = (scene: Scene, pose: Pose | undefined, part: string, body: number | null): [Called, string][] => {
  const all: [Called, string][] = [], add = (what: Label, value: string) => all.push([called(what), value]);
  const carried = body === null || part === "finger" ? undefined : scene.bodies[body];
  if (carried) {
    const weight = called("part.numbers.weight");
    all.push([weight.lang ? weight : { ...weight, text: `weight of the ${carried.name.replaceAll("_", " ")}` }, `${fixed(carried.mass_g, 1)} g`]);
    if (pose) add("part.numbers.turned", `${fixed(((pose.angles[body!]! - carried.angle) * 180) / Math.PI, 2)}\u00b0`);
  }
  if (part === "finger" && pose) add("part.numbers.force", `${fixed(pose.finger_force_n, 2)} N`);
  if (part === "key" && pose) add("part.numbers.travel", `${fixed(1e3 * pose.key_m, 2)} mm`);
  if (part.startsWith("hammer") && body !== null && pose) {
    add("part.numbers.rise", `${fixed(1e3 * pose.hammer_rise_m, 2)} mm`);
    add("part.numbers.speed", `${fixed(pose.hammer_rise_m_per_s, 2)} m/s`);
  }
  for (const zone of zonesOf(scene, part, body)) {
    const force = pose?.contacts[5 * zone] ?? 0;
    const { name, label } = scene.zones[zone]!;
    all.push([called(`zone.${name}`, label.replace(" - ", " \u2013 ")), force > 0 ? `${fixed(force, 2)} N` : called("part.numbers.free").text]);
  }
  return all;
};

export const partCard = (app: App): void => {
  const card = byId("part"), pointed = byId("pointed"), list = byId<HTMLSelectElement>("parts");
  const name = h("h2"), does = h("p"), numbers = h("dl"), sliders = h("div", { class: "dials" }), drag = h("p", { class: "soft" });
  const close = h("button", { type: "button", class: "back", "aria-label": "Close", onclick: () => choose(null) }, "\u00d7");
  card.append(h("div", { class: "row" }, name, close), does, numbers, sliders, drag);
  let chosen: Chosen | null = null, hovered: Chosen | null = null;
  let dials: [Dials, Dials] | null = null, made = "";

  const bodyOf = ({ action, part }: Chosen): number | null => app.pictures.map((picture) => picture.bodyOf(action, part)).find((body) => body !== undefined) ?? null;
  const mark = () => app.pictures.forEach((picture) => picture.mark(chosen ?? hovered));
  const toldOf = (which: Chosen) => {
    const scene = app.scenes[which.action];
    return scene ? numbersOf(scene, app.poses[which.action], which.part, bodyOf(which)) : [];
  };
  const show = () => {
    pointed.hidden = !hovered || hovered.part === chosen?.part;
    if (hovered && !pointed.hidden) {
      const turns = app.movable(hovered.part, hovered.action);
      const part = called(`part.${hovered.part}`, hovered.part), free = called("part.numbers.free").text;
      const told = toldOf(hovered).filter(([, value]) => value !== free).slice(0, 4).map(([{ text }, value]) => `${text} ${value}`);
      const text = [part.text, ...told, ...(turns ? [`${called("part.numbers.drag").text}: ${called(`screw.${turns.dial.name}`, turns.label).text}`] : [])].join(" \u00b7 ");
      if (pointed.textContent !== text) pointed.textContent = text;
      speaks(pointed, part.lang);
    }
    card.hidden = !chosen;
    if (!chosen) return;
    const told = toldOf(chosen), key = told.map(([{ text }]) => text).join("|");
    if (key !== made) {
      made = key;
      numbers.replaceChildren(...told.flatMap(([{ text, lang }]) => [h("dt", { lang }, text), h("dd", { lang })]));
    }
    told.forEach(([, value], k) => {
      const cell = numbers.children[2 * k + 1]!;
      if (cell.textContent !== value) cell.textContent = value;
    });
  };
  const choose = (next: Chosen | null) => {
    const before = chosen;
    chosen = next;
    made = "";
    list.value = next?.part ?? "";
    mark();
    show();
    if (!next) {
      if (before && card.contains(document.activeElement)) list.focus();
      return;
    }
    const text = textOf(next.part), turns = app.movable(next.part, next.action);
    name.replaceChildren(named(h("span"), `part.${next.part}`, next.part), app.scenes.length > 1 ? (next.action ? ", B" : ", A") : "");
    does.textContent = text.does;
    drag.textContent = turns ? `Drag it in the picture: ${turns.label}.` : "";
    dials ??= [0, 1].map((which) => new Dials(app, which, sliders, { of: () => textOf(chosen?.part ?? "").dials ?? [] })) as [Dials, Dials];
    sliders.replaceChildren();
    dials[next.action]!.anew();
    say(next.part);
  };
  app.onchoose = choose;
  app.onpoint = (next) => {
    hovered = next;
    mark();
    show();
  };
  list.addEventListener("change", () => choose(list.value ? { action: 0, part: list.value } : null));
  card.addEventListener("keydown", (event) => {
    if (event.key === "Escape") choose(null);
  });
  app.onframe.push(show);
  onlanguage.push(show);
  app.onchange.push(() => {
    const parts = [...new Set((app.scenes[0]?.labels ?? []).map(({ text }) => mainPart(text)))].sort();
    if (list.options.length !== parts.length + 1) list.replaceChildren(named(new Option("", ""), "tool.no-part"), ...parts.map((part) => named(new Option("", part), `part.${part}`, part)));
    if (chosen && (chosen.action >= app.scenes.length || (!parts.includes(chosen.part) && bodyOf(chosen) === null))) return choose(null);
    list.value = chosen?.part ?? "";
    mark();
    if (chosen) dials?.[chosen.action]!.follow();
  });
};
