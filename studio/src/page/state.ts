// What the page shows, as one value: kept in the address, undone and redone.

import { exampleOf } from "./examples";

/** Where an action's file comes from. */
export type Base = { builtin: string } | { key: number; keyboard: string } | { text: string };
/** A file, and the dials that were turned from where it has them. */
export interface Setting {
  base: Base;
  turns: Record<string, number>;
}

export interface State {
  /** The example that is shown, by its id; none: empty. */
  example: string;
  a: Setting;
  b: Setting | null;
  beside: boolean;
  tab: string;
  /** How firm the fingertip is, N/mm. */
  firmness: number;
  /** Whether the key front itself follows the pointer, without a fingertip. */
  imposed: boolean;
  /** How hard a computer key presses, N. */
  force: number;
  /** How far the sustain pedal lifts its rail, mm. */
  pedal: number;
  /** How slowly one looks back. */
  speed: number;
  /** Whether what happens now is as slow. */
  slow: boolean;
  forces: boolean;
  names: boolean;
  /** Whether curves are B's less A's. */
  difference: boolean;
  /** What is seen of the picture, mm: left, top, width, height; null is all of it. */
  view: number[] | null;
  /** The keyboard that is played, by its name. */
  keyboard: string;
  /** What was measured of one's own piano, as it was typed, by the names of erard_diagnose_quantities. */
  readings: Record<string, string>;
}

export const FIRST: State = {
  example: "", a: { base: { builtin: "concert-grand" }, turns: {} }, b: null, beside: false, tab: "play", firmness: 0.8, imposed: false, force: 5, pedal: 0,
  speed: 1 / 50, slow: false, forces: true, names: false, difference: false, view: null, keyboard: "concert-grand", readings: {},
};

/** As far as the engine's rail goes, mm. */
export const MAX_PEDAL_MM = 10;

/** As far as a key front is moved whose motion is imposed, m: into the felt under it, with some tens of newtons. */
export const DEEPEST_M = 0.0102;

export const same = (a: unknown, b: unknown): boolean => JSON.stringify(a) === JSON.stringify(b);

const squeeze = async (text: string): Promise<string> => {
  const stream = new Blob([text]).stream().pipeThrough(new CompressionStream("deflate-raw"));
  const bytes = new Uint8Array(await new Response(stream).arrayBuffer());
  let binary = "";
  for (const byte of bytes) binary += String.fromCharCode(byte);
  return btoa(binary).replaceAll("+", "-").replaceAll("/", "_").replace(/=+$/, "");
};

/** Longest text that an address may hold once it is unpacked, bytes: a file is some 40 000. */
const MAX_FILE_BYTES = 2_000_000;

const unsqueeze = async (text: string): Promise<string> => {
  const binary = atob(text.replaceAll("-", "+").replaceAll("_", "/"));
  const bytes = Uint8Array.from(binary, (character) => character.charCodeAt(0));
  const reader = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate-raw")).getReader();
  const decoder = new TextDecoder();
  let out = "";
  for (;;) {
    const { value, done } = await reader.read();
    if (done) return out + decoder.decode();
    out += decoder.decode(value, { stream: true });
    if (out.length > MAX_FILE_BYTES) throw new Error("the file in the address is too long");
  }
};

const written = async ({ base, turns }: Setting): Promise<string> => {
  const of = "builtin" in base ? base.builtin : "key" in base ? (base.keyboard === FIRST.keyboard ? `key:${base.key}` : `key:${base.key}:${base.keyboard}`) : `file:${await squeeze(base.text)}`;
  return [of, ...Object.entries(turns).map(([name, value]) => `${name}:${Number(value.toPrecision(8))}`)].join(";");
};

const read = async (text: string): Promise<Setting> => {
  const [of, ...changes] = text.split(";");
  const turns: Record<string, number> = {};
  for (const change of changes) {
    const [name, value] = change.split(":");
    if (name && Number.isFinite(Number(value))) turns[name] = Number(value);
  }
  if (of!.startsWith("file:")) return { base: { text: await unsqueeze(of!.slice(5)) }, turns };
  if (of!.startsWith("key:")) {
    const [key, keyboard] = of!.slice(4).split(":");
    return { base: { key: Number(key), keyboard: keyboard ?? FIRST.keyboard }, turns };
  }
  return { base: { builtin: of! }, turns };
};

/** The part of the address behind the #: what differs from the first state. */
export const toHash = async (state: State): Promise<string> => {
  const hash = new URLSearchParams();
  if (state.example) hash.set("example", state.example);
  if (!same(state.a, FIRST.a)) hash.set("a", await written(state.a));
  if (state.b) hash.set("b", await written(state.b));
  if (state.beside) hash.set("beside", "1");
  if (state.tab !== FIRST.tab) hash.set("tab", state.tab);
  if (state.firmness !== FIRST.firmness) hash.set("firm", String(state.firmness));
  if (state.imposed) hash.set("imposed", "1");
  if (state.force !== FIRST.force) hash.set("force", String(state.force));
  if (state.pedal) hash.set("pedal", String(state.pedal));
  if (state.speed !== FIRST.speed) hash.set("slower", String(Math.round(1 / state.speed)));
  if (state.slow) hash.set("slow", "1");
  if (!state.forces) hash.set("forces", "0");
  if (state.names) hash.set("names", "1");
  if (state.difference) hash.set("difference", "1");
  if (state.view) hash.set("view", state.view.map((value) => Number(value.toFixed(1))).join(","));
  if (state.keyboard !== FIRST.keyboard) hash.set("keys", state.keyboard);
  if (Object.keys(state.readings).length) hash.set("readings", Object.entries(state.readings).map(([name, text]) => `${name}:${text.replaceAll(";", ",")}`).join(";"));
  return hash.toString().replaceAll("%3A", ":").replaceAll("%3B", ";").replaceAll("%2C", ",");
};

/** What an address asks for; what cannot be read in it is as at first, and said. */
export const fromHash = async (text: string): Promise<{ state: State; fault: string | null }> => {
  const hash = new URLSearchParams(text.replace(/^#/, ""));
  const state: State = structuredClone(FIRST);
  const number = (key: string, from: number, to: number, otherwise: number) => {
    const value = Number(hash.get(key) ?? NaN);
    return value >= from && value <= to ? value : otherwise;
  };
  state.example = exampleOf(hash.get("example") ?? "")?.id ?? "";
  let fault: string | null = null;
  try {
    if (hash.has("a")) state.a = await read(hash.get("a")!);
    if (hash.has("b")) state.b = await read(hash.get("b")!);
  } catch (error) {
    fault = `The address holds a file that cannot be read: ${error instanceof Error ? error.message : error}`;
  }
  state.beside = hash.get("beside") === "1";
  state.tab = hash.get("tab") ?? FIRST.tab;
  state.firmness = number("firm", 0.05, 50, FIRST.firmness);
  state.imposed = hash.get("imposed") === "1";
  state.force = number("force", 0.1, 50, FIRST.force);
  state.pedal = number("pedal", 0, MAX_PEDAL_MM, FIRST.pedal);
  state.speed = 1 / number("slower", 1, 1000, 1 / FIRST.speed);
  state.slow = hash.get("slow") === "1";
  state.forces = hash.get("forces") !== "0";
  state.names = hash.get("names") === "1";
  state.difference = hash.get("difference") === "1";
  const view = (hash.get("view") ?? "").split(",").map(Number);
  if (view.length === 4 && view.every(Number.isFinite) && view[2]! > 0 && view[3]! > 0) state.view = view;
  state.keyboard = hash.get("keys") ?? FIRST.keyboard;
  for (const reading of (hash.get("readings") ?? "").split(";")) {
    const [name, ...text] = reading.split(":");
    if (name && text.length) state.readings[name] = text.join(":").slice(0, 200);
  }
  return { state, fault };
};
