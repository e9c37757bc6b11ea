// A worker for what takes its time: files checked, sheets measured, screws turned. The player never waits for it.
import { Library, LibraryError } from "./library";
import { STEP_S } from "./played";
import { type FromWorkshop, type Note, SOUND_STEP_S, type Task, type ToWorkshop } from "./protocol";

let library: Library;
const say = (message: FromWorkshop) => postMessage(message);

/** A note as it is heard; without samples where strings are rigid. */
const sound = (instrument: number, { stroke: of, pedal_m, seconds }: Extract<Task, { kind: "sound" }>): Note => {
  const { raw } = library;
  const action = library.made(raw.erard_action_of_instrument(instrument, SOUND_STEP_S, 0)), place = raw.erard_memory_new(16);
  const stroke = library.stroke(instrument, of);
  const bridge_n = (): number => {
    library.done(raw.erard_action_bridge_force(action, place));
    return library.f64(place, 1)[0]!;
  };
  try {
    const steps = raw.erard_action_string_places(action, 0, 0) ? Math.round(seconds / SOUND_STEP_S) : 0;
    library.done(raw.erard_action_set_pedal(action, pedal_m));
    const rest_n = bridge_n(), radiates = raw.erard_action_pressure(action, place) === 0;
    const note: Note = { unit: radiates ? "Pa" : "N", channels: [new Float32Array(steps), new Float32Array(steps)], bridge_n: new Float32Array(steps) };
    for (let n = 0; n < steps; n++) {
      library.done(raw.erard_action_step_stroke(action, stroke, 0));
      const force_n = (note.bridge_n[n] = bridge_n() - rest_n);
      if (radiates) library.done(raw.erard_action_pressure(action, place));
      for (const [side, numbers] of note.channels.entries()) numbers[n] = radiates ? library.f64(place, 2)[side]! : force_n;
    }
    return note;
  } finally {
    raw.erard_stroke_free(stroke);
    raw.erard_memory_free(place, 16);
    raw.erard_action_free(action);
  }
};

const answer = (task: Task): unknown => {
  const { raw } = library;
  const textOf = (instrument: number): string => {
    try {
      return library.taken(raw.erard_instrument_text(instrument, 0, 0));
    } finally {
      raw.erard_instrument_free(instrument);
    }
  };
  switch (task.kind) {
    case "builtin":
      return library.json(raw.erard_builtin_names(0, 0));
    case "base": {
      if ("text" in task.of) return task.of.text;
      if ("key" in task.of) {
        const { key, keyboard } = task.of;
        return textOf(library.made(library.given(keyboard, (at) => raw.erard_instrument_of_keyboard(at, key, 0))));
      }
      return textOf(library.made(library.given(task.of.builtin, (at) => raw.erard_instrument_builtin(at, 0))));
    }
    case "turned":
      return library.withInstrument(task.text, (base) =>
        textOf(library.made(library.given(JSON.stringify(task.turns), (at) => raw.erard_instrument_with_dials(base, at, 0)))));
    case "dials":
      return library.withInstrument(task.text, (instrument) => library.json(raw.erard_instrument_dials(instrument, 0, 0)));
    case "dial-typed":
      return library.withInstrument(task.text, (instrument) =>
        library.given(task.dial, (dial) => library.given(task.typed, (typed) => {
          const place = raw.erard_memory_new(8);
          try {
            library.done(raw.erard_instrument_dial_typed(instrument, dial, typed, place));
            return library.f64(place, 1)[0]!;
          } finally {
            raw.erard_memory_free(place, 8);
          }
        })));
    case "vary":
      return library.withInstrument(task.text, (instrument) =>
        library.given(task.called, (called) => library.given(task.change, (change) => {
          library.done(raw.erard_instrument_vary_field(instrument, called, change));
          return library.taken(raw.erard_instrument_text(instrument, 0, 0));
        })));
    case "sheet":
      return library.json(raw.erard_sheet_lines(task.key, 0, 0));
    case "check":
      return library.given(task.text, (at, length) => library.json(raw.erard_file_check(at, length, 0, 0)));
    case "columns":
      return library.given(JSON.stringify(task.titles), (at) => library.json(raw.erard_recording_columns(at, 0, 0)));
    case "run":
      return library.withInstrument(task.text, (instrument) => {
        const stroke = library.stroke(instrument, task.stroke);
        try {
          return library.taken(raw.erard_stroke_run_csv(instrument, stroke, STEP_S, 0, 0));
        } finally {
          raw.erard_stroke_free(stroke);
        }
      });
    case "sound":
      return library.withInstrument(task.text, (instrument) => sound(instrument, task));
    case "try":
      return library.withInstrument(task.text, (instrument) => library.json(raw.erard_instrument_test_press(instrument, 0, 0)));
    case "measure":
      return library.withInstrument(task.text, (instrument) =>
        library.given(task.lines, (at) => library.json(raw.erard_instrument_measure(instrument, 0, at, 0, 0, 0, 0))));
    case "regulate":
      return library.withInstrument(task.text, (instrument) => library.json(raw.erard_instrument_regulate(instrument, 0, 0, 0, 0, 0)));
    case "diagnosable":
      return library.json(raw.erard_diagnose_quantities(task.key, 0, 0));
    case "diagnose":
      return library.given(JSON.stringify(task.readings), (at) => {
        const faults = library.json<unknown[]>(raw.erard_diagnose_check(at, 0, 0));
        return faults.length ? { faults } : { answer: library.json(raw.erard_diagnose(at, 0, 0)) };
      });
  }
};

addEventListener("message", async ({ data }: MessageEvent<ToWorkshop>) => {
  if (data.kind === "open") {
    library = await Library.open(data.module);
    return say({ kind: "ready" });
  }
  try {
    say({ kind: "done", id: data.id, answer: answer(data.task) });
  } catch (error) {
    const fault = !(error instanceof LibraryError);
    say({ kind: "failed", id: data.id, message: error instanceof Error ? error.message : String(error), fault });
  }
});
