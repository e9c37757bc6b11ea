// What was played last, to be heard: rendered by the workshop, action after action. Loaded when it is asked for.
import type { Stroke } from "../engine/protocol";
import type { App } from "./app";
import { fixed } from "./dom";
import { play } from "./sound";

/** How much of a note is heard, s. */
const NOTE_S = 2;
/** Where nothing was played yet. */
const USUAL: Stroke = { nuance: "mf", struck: false };

/** Plays the last stroke on these actions, one after the other. @returns once it begins, what is heard; a sentence. */
export const hear = async (app: App, actions: number[]): Promise<string> => {
  const stroke = app.lastStroke ?? USUAL;
  const notes: Float32Array[] = [], said: string[] = [];
  for (const which of actions) {
    const { text, instead } = await app.strung(which);
    const note = await app.bench.ask<Float32Array>({ kind: "sound", text, stroke, seconds: NOTE_S }, "sound");
    const peak_n = note.reduce((most, n) => Math.max(most, Math.abs(n)), 0);
    const name = actions.length > 1 ? `${app.names[which]}: ` : "";
    const called = "csv" in stroke ? "the recording" : `${stroke.nuance}, ${stroke.struck ? "struck" : "pressed"}`;
    said.push(`${name}${called}${instead ? ` on ${instead}, with the same screws turned` : ""}, at most ${fixed(peak_n, 1)} N`);
    notes.push(note);
  }
  app.sounds = notes;
  await new Promise<void>((resolve, reject) => {
    play(notes, resolve).catch(reject);
  });
  return `Heard: the strings\u2019 force on the bridge, not what the soundboard radiates, at the same gain for all notes. ${said.join("; ")}.`;
};
