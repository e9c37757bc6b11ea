// What was played last, to be heard: rendered by the workshop, action after action. Loaded when it is asked for.
import { HEARD, NOTE_S, type Note, type Stroke } from "../engine/protocol";
import type { App } from "./app";
import { fixed } from "./dom";
import { play } from "./sound";

/** Where nothing was played yet. */
const USUAL: Stroke = { nuance: "mf", struck: false };

/** Plays the last stroke on these actions, one after the other. @returns once it begins, what is heard; a sentence. */
export const hear = async (app: App, actions: number[]): Promise<string> => {
  const stroke = app.lastStroke ?? USUAL;
  const notes: Note[] = [], said: string[] = [];
  for (const which of actions) {
    const { text, instead } = await app.strung(which);
    const note = await app.bench.ask<Note>({ kind: "sound", text, stroke, pedal_m: 0, seconds: NOTE_S }, "sound");
    const peak = Math.max(...note.channels.map((samples) => samples.reduce((most, n) => Math.max(most, Math.abs(n)), 0)));
    const name = actions.length > 1 ? `${app.names[which]}: ` : "";
    const called = "csv" in stroke ? "the recording" : `${stroke.nuance}, ${stroke.struck ? "struck" : "pressed"}`;
    said.push(`${name}${called}${instead ? ` on ${instead}, with the same screws turned` : ""}, at most ${fixed(peak, note.unit === "Pa" ? 2 : 1)} ${note.unit}`);
    notes.push(note);
  }
  app.sounds = notes;
  await play(notes);
  const heard = [...new Set(notes.map((note) => HEARD[note.unit]))].join("; ");
  return `Heard, at the same gain for all notes: ${heard}. ${said.join("; ")}.`;
};
