// The small pictures of the gallery, drawn from what the engine computes: hammers on their way to the string, weights,
// a string that swings, notes that sound.
import { EXAMPLES, PASSAGE, passage, strokeOf } from "./src/page/examples.js";

const WIDE = 160, TALL = 84, STEP_S = 50e-6;
/** Where the string lies, and where a hammer rests, px of the picture. */
const STRING = 10, REST = 78;
/** Bytes of ErardReading, ErardImpact and ErardInput. */
const READING_BYTES = 112, IMPACT_BYTES = 24, INPUT_BYTES = 72;

/** @param exports The engine's. @returns a picture by the id of its example. */
export const pictures = (erard) => {
  const bytes = () => new Uint8Array(erard.memory.buffer);
  const doubles = (at, count) => new Float64Array(erard.memory.buffer, at, count);
  const words = (at) => new Uint32Array(erard.memory.buffer, at);
  const textAt = (at) => new TextDecoder().decode(bytes().slice(at, bytes().indexOf(0, at)));
  const made = (at) => {
    if (at === 0) throw new Error(textAt(erard.erard_last_error()));
    return at;
  };
  const done = (status) => {
    if (status < 0) throw new Error(textAt(erard.erard_last_error()) || textAt(erard.erard_status_text(status)));
  };
  const given = (text, call) => {
    const utf8 = new TextEncoder().encode(text), at = erard.erard_memory_new(utf8.length + 1);
    bytes().set(utf8, at);
    const answer = call(at, utf8.length);
    erard.erard_memory_free(at, utf8.length + 1);
    return answer;
  };
  const struct = (size) => {
    const at = erard.erard_memory_new(size);
    words(at)[0] = size;
    return at;
  };
  /** An action as an address has it. */
  const instrument = (written) => {
    const [name, ...turns] = written.split(";");
    const base = made(given(name, (at) => erard.erard_instrument_builtin(at, 0)));
    if (!turns.length) return base;
    const values = Object.fromEntries(turns.map((turn) => turn.split(":")).map(([dial, value]) => [dial, Number(value)]));
    return made(given(JSON.stringify(values), (at) => erard.erard_instrument_with_dials(base, at, 0)));
  };
  /** Plays a stroke; `each` is given the time, the reading and the action after every step. */
  const play = (of, stroke, reference, pedal_m, until_s, each) => {
    const action = made(erard.erard_action_of_instrument(of, STEP_S, 0)), reading = struct(READING_BYTES);
    done(erard.erard_action_set_pedal(action, pedal_m));
    const played = made("csv" in stroke
      ? given(stroke.csv, (at, length) => erard.erard_stroke_new(of, at, length, 0))
      : given(stroke.nuance, (at) => erard.erard_stroke_builtin(reference, at, stroke.struck ? 1 : 0, 0)));
    for (let n = 0; n * STEP_S < until_s; n++) {
      done(erard.erard_action_step_stroke(action, played, reading));
      each(n * STEP_S, doubles(reading + 8, 10), action);
    }
  };
  const svg = (inside) => `<svg viewBox="0 0 ${WIDE} ${TALL}" aria-hidden="true">${inside}</svg>`;
  const line = (kind, points) => `<polyline class="${kind}" points="${thin(points, 0.35).map(([x, y]) => `${Number(x.toFixed(1))},${Number(y.toFixed(1))}`).join(" ")}"/>`;
  const string = `<line class="wire" x1="0" x2="${WIDE}" y1="${STRING}" y2="${STRING}"/>`;

  /** How far a hammer rises until it meets its string, m: by a fortissimo, which always does. */
  const blowOf = (of) => {
    let blow = null;
    play(of, { nuance: "ff", struck: false }, of, 0, 0.1, (_, reading) => {
      if (words(reading.byteOffset + 80)[0] > 0) blow ??= reading[5];
    });
    return blow;
  };
  const hammers = (a, b, { during_s: [from, to], near_m, other, ...example }) => {
    const stroke = strokeOf(example);
    const curve = (of, stroke) => {
      const points = [];
      play(of, stroke, a, 0, to, (time, reading) => {
        if (time >= from && Math.round(time / STEP_S) % 20 === 0) points.push([time, reading[5]]);
      });
      return points;
    };
    // Both strings lie at one height: what is drawn is how far a hammer is from its own.
    const blows = [blowOf(a), blowOf(b)], scale = (REST - STRING) / (near_m ?? Math.max(...blows));
    const drawn = (points, which) => line("ab"[which], points.map(([time, rise]) => [(WIDE * (time - from)) / (to - from), STRING + Math.max(blows[which] - rise, 0) * scale]).filter(([, y]) => y <= TALL));
    return svg(string + drawn(curve(b, other ?? stroke), 1) + drawn(curve(a, stroke), 0));
  };
  const weights = (a, b) => {
    const grams = [a, b].map((of) => JSON.parse(textAt(made(given("down_weight_g", (at) => erard.erard_instrument_measure(of, 0, at, 0, 0, 0, 0))))).down_weight_g);
    const scale = (TALL - 20) / Math.max(...grams);
    return svg(grams.map((g, n) => `<rect class="${"ab"[n]}" x="${28 + 60 * n}" y="${(TALL - g * scale).toFixed(1)}" width="44" height="${(g * scale).toFixed(1)}"/><text x="${50 + 60 * n}" y="${(TALL - 5 - g * scale).toFixed(1)}">${g.toFixed(0)} g</text>`).join(""));
  };
  const swings = (a, { during_s: [from, to], stroke }) => {
    const swing = (pedal_m) => {
      const points = [];
      let places = 0, shape = 0, most = 0;
      play(a, stroke, a, pedal_m, to, (time, _, action) => {
        if (!places) {
          places = erard.erard_action_string_places(action, 0, 0);
          shape = erard.erard_memory_new(8 * places);
        }
        erard.erard_action_string_shape(action, shape, places);
        most = Math.max(most, ...new Float32Array(erard.memory.buffer, shape, places).map(Math.abs));
        // The largest of each ten milliseconds: the envelope.
        if (Math.round(time / STEP_S) % 200 !== 199) return;
        points.push([time, most]);
        most = 0;
      });
      return points;
    };
    const held = swing(7e-3), damped = swing(0), largest = Math.max(...held.map(([, m]) => m));
    const middle = TALL / 2;
    const band = (points, kind) => {
      const x = (time) => (WIDE * (time - from)) / (to - from), half = (m) => ((middle - 6) * m) / largest;
      const up = thin(points.map(([time, m]) => [x(time), middle - half(m)]), 0.35), down = up.map(([at, y]) => [at, 2 * middle - y]).reverse();
      return `<polygon class="${kind}" points="${[...up, ...down].map(([at, y]) => `${at.toFixed(1)},${y.toFixed(1)}`).join(" ")}"/>`;
    };
    return svg(band(held, "b") + band(damped, "a"));
  };
  const notes = (keyboard) => {
    const all = made(given(keyboard, (at) => erard.erard_keyboard_builtin(at, STEP_S, 0)));
    const input = struct(INPUT_BYTES), impacts = erard.erard_memory_new(64 * IMPACT_BYTES), count = erard.erard_memory_new(8);
    words(impacts)[0] = IMPACT_BYTES;
    const sounded = new Set();
    let step = 0;
    const walk = (to) => {
      if (to === step) return;
      done(erard.erard_keyboard_step(all, to - step, impacts, 64, count));
      for (let n = 0; n < words(count)[0]; n++) sounded.add(Math.floor(doubles(impacts + IMPACT_BYTES * n + 8, 1)[0] / PASSAGE.period_s));
      step = to;
    };
    for (const [time, key, force] of passage()) {
      walk(Math.round(time / STEP_S));
      words(input)[1] = force > 0 ? 1 : 0;
      doubles(input + 8, 6).set([force, 0, 0, 0, 0, 0]);
      done(erard.erard_keyboard_drive(all, key, input));
    }
    walk(step + Math.round(0.2 / STEP_S));
    const rows = [...new Set(PASSAGE.keys)], wide = WIDE / PASSAGE.keys.length;
    return svg(PASSAGE.keys.map((key, n) => `<rect class="${sounded.has(n) ? "a" : "lost"}" x="${(n * wide + 1.5).toFixed(1)}" y="${TALL - 22 - 18 * rows.indexOf(key)}" width="${(wide - 3).toFixed(1)}" height="12" rx="2"/>`).join(""));
  };

  return Object.fromEntries(EXAMPLES.map((example) => {
    const address = new URLSearchParams(example.address);
    const a = instrument(address.get("a") ?? "concert-grand"), b = instrument(address.get("b") ?? "concert-grand");
    const draw = { hammers: () => hammers(a, b, example), weights: () => weights(a, b), swings: () => swings(a, example), notes: () => notes(address.get("keys")) };
    return [example.id, draw[example.picture]()];
  }));
};

/** Leaves out points that lie within so much of the line between others. */
const thin = (points, within) => {
  if (points.length < 3) return points;
  const [first, last] = [points[0], points.at(-1)];
  const [dx, dy] = [last[0] - first[0], last[1] - first[1]], length = Math.hypot(dx, dy) || 1;
  let far = 0, at = 0;
  points.forEach(([x, y], n) => {
    const off = Math.abs(dy * (x - first[0]) - dx * (y - first[1])) / length;
    if (off > far) [far, at] = [off, n];
  });
  return far <= within ? [first, last] : [...thin(points.slice(0, at + 1), within).slice(0, -1), ...thin(points.slice(at), within)];
};
