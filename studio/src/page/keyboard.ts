// The keyboard: 88 actions of one piano, each with its own hammer, leads and dampers, under ten fingers.
import uPlot from "uplot";
import { STEP_S } from "../engine/played";
import { type FromKeys, HEARD, type Heard, type KeyImpact, type Scene } from "../engine/protocol";
import type { App } from "./app";
import { fixed, h, say } from "./dom";
import { PASSAGE, passage } from "./examples";
import { Picture } from "./picture";
import { PEDAL_MM } from "./play";
import type { Speaker } from "./sound";
import { FIRST } from "./state";
import { called, named, onlanguage, speaks } from "./terms";

const NAMES = ["C", "C\u266f", "D", "D\u266f", "E", "F", "F\u266f", "G", "G\u266f", "A", "A\u266f", "B"];
/** Key 1 is the lowest A. */
const nameOf = (key: number): string => `${NAMES[(key + 8) % 12]}${Math.floor((key + 8) / 12)}`;
const isSharp = (key: number): boolean => [1, 3, 6, 8, 10].includes((key + 8) % 12);
/** The computer's keys, as they lie: the lower rows are an octave and a half from the C below middle C on, the upper
 * ones from middle C on. */
const ROWS = ["KeyZ", "KeyS", "KeyX", "KeyD", "KeyC", "KeyV", "KeyG", "KeyB", "KeyH", "KeyN", "KeyJ", "KeyM", "Comma", "KeyL", "Period", "Semicolon", "Slash"];
const UPPER = ["KeyQ", "Digit2", "KeyW", "Digit3", "KeyE", "KeyR", "Digit5", "KeyT", "Digit6", "KeyY", "Digit7", "KeyU", "KeyI", "Digit9", "KeyO", "Digit0", "KeyP"];
const MIDDLE_C = 40;
/** How hard a finger presses at a key's back and at its front edge, N. */
const SOFT_N = 1.2, HARD_N = 18;
/** What the drawing counts as a full dip and a full blow distance, m. */
const DIP_M = 0.0105, BLOW_M = 0.048;
/** How far a finger that drags a key may go above and below the key's rest, m: at the bottom it presses with some 30 N,
 * as fingers do. */
const HIGHEST_M = 0.005, DEEPEST_M = 0.0115;
const KEYS = 88;

/** What the bridge's curve shows, s, and in so many points: the least and the greatest force of each hundredth. */
const HEARD_S = 0.5, POINTS = 500;
/** What is left of the meter's level from frame to frame. */
const FALLS = 0.9;

type Frame = Extract<FromKeys, { kind: "frame" }>;

export const keyboardPanel = (app: App, into: HTMLElement): void => {
  const canvas = h("canvas", { class: "keys", tabindex: 0, id: "keys", role: "application", "aria-label": "88 keys. On the computer's keyboard Z is the C below middle C, Q is middle C; arrow keys choose a key, space presses it." });
  const chosen = h("output", { id: "chosen" });
  const told = h("p", { class: "soft", id: "keys-said" }, "The 88 actions are getting ready \u2026");
  const list = h("ol", { class: "impacts", id: "impacts" });
  const open = named(h("button", { type: "button", id: "open-key" }), "keyboard.open");
  /** The chosen key's action, as it moves. */
  const inside = h("div", { class: "inside" });
  const numbers = h("p", { class: "soft", id: "key-numbers" });
  let finger_m: number | null = null;
  let scene: Scene | null = null, asked = 0, drawn = 0;
  const picture = new Picture(inside, "The chosen key's action", {
    press: (down_m) => (finger_m = down_m === null ? null : Math.min(Math.max(down_m, -HIGHEST_M), DEEPEST_M)),
    point: () => {}, choose: () => {}, way: () => null, take: () => null,
  });
  const heard = h("div", { class: "plot", id: "heard", role: "img", "aria-label": "Force of the strings on the bridge in the last half second", hidden: true });
  const level = h("output", { id: "bridge-level" });
  const piano = h("select", { id: "which-keyboard", "aria-label": "Keyboard" });
  const pedal = h("input", { type: "checkbox", id: "keys-pedal" });
  const sound = named(h("button", { type: "button", id: "sound", "aria-pressed": "false" }), "keyboard.sound");
  const meter = h("meter", { id: "sound-level", min: 0, max: 1, high: 0.9, hidden: true, "aria-label": "Loudness" });
  const sound_said = h("p", { class: "soft", id: "sound-said", role: "status" });
  const sounding = h("div", { class: "row", hidden: true }, h("label", {}, pedal, " ", named(h("span"), "keyboard.pedal")), sound, meter, level);
  /** Who plays: a worker, or the audio thread. */
  let engine: Speaker | null = null;
  /** Whether it is heard. */
  let aloud = false;
  /** The keyboard that it has, and the length of its steps, s. */
  let opened = "", step_s = STEP_S;
  let ready = false, waiting = false, late_s = 0;
  let frame: Frame | null = null;
  let key = MIDDLE_C;
  let changed = new Map<number, number>();
  /** Who holds which key: pointers and computer keys. */
  const held = new Map<string, number>();
  const struck = new Float64Array(KEYS + 1);
  /** The passage: what is said of it, its notes, whether it waits for the keyboard, and the hammer speed of each note
   * that has sounded, m/s; null while it is not played. */
  const score = h("p", { id: "passage-said", role: "status" }), row = h("ol", { class: "passage", id: "passage-notes" });
  const again = named(h("button", { type: "button", id: "passage", onclick: () => perform() }), "keyboard.passage");
  let asked_for = false, sounded: (number | null)[] | null = null;
  const perform = () => {
    asked_for = !ready;
    if (!ready) return;
    sounded = PASSAGE.keys.map(() => null);
    score.textContent = "";
    row.replaceChildren(...PASSAGE.keys.map((one) => h("li", {}, nameOf(one))));
    choose(PASSAGE.keys[0]!, false);
    engine!.tell({ kind: "passage", turns: passage() });
  };
  app.onpassage = perform;
  /** What a frame brought of the passage: which of its notes have sounded, and, once it is over, which have not. */
  const listen = (impacts: KeyImpact[], passage_s: number | null) => {
    if (!sounded || passage_s === null) return;
    for (const { key, hammer_speed_m_per_s, at_s } of impacts) {
      const note = at_s === null ? -1 : Math.floor(at_s / PASSAGE.period_s);
      if (PASSAGE.keys[note] !== key) continue;
      sounded[note] ??= hammer_speed_m_per_s;
      row.children[note]!.className = "sounded";
    }
    if (passage_s < (PASSAGE.keys.length + 1) * PASSAGE.period_s) return;
    const lost = sounded.filter((one) => one === null).length;
    sounded.forEach((one, n) => one === null && row.children[n]!.replaceChildren(h("s", {}, nameOf(PASSAGE.keys[n]!)), h("span", { class: "unseen" }, " lost")));
    score.textContent = `${PASSAGE.keys.length - lost} of ${PASSAGE.keys.length} notes sounded${lost ? `; ${lost} were lost.` : "."}`;
    sounded = null;
  };

  /** The keyboard that the state names, if there is one of that name. */
  const wanted = () => (app.keyboards.includes(app.state.keyboard) ? app.state.keyboard : FIRST.keyboard);
  /** Which start this is: what an older one still says counts no more. */
  let starts = 0;
  const start = async () => {
    if (engine || starting) return;
    starting = true;
    const own = ++starts;
    const hears = (data: FromKeys) => own === starts && got(data);
    opened = wanted();
    try {
      if (aloud) {
        const made = await (await import("./sound")).speaker(app.engine, opened, hears);
        if (own !== starts) return made.end();
        engine = made;
      }
    } catch (error) {
      if (own !== starts) return;
      aloud = false;
      sound_said.textContent = `No sound: ${(error as Error).message}.`;
    }
    if (!engine) {
      const worker = new Worker(new URL("../engine/keys.worker.ts", import.meta.url), { type: "module" });
      worker.onmessage = ({ data }: MessageEvent<FromKeys>) => hears(data);
      engine = { tell: (message) => worker.postMessage(message), end: () => worker.terminate() };
      engine.tell({ kind: "open", module: app.engine, name: opened, step_s: STEP_S });
    }
    starting = false;
    sound.setAttribute("aria-pressed", String(aloud));
    if (pedal.checked) lift();
  };
  let starting = false;
  const got = (data: FromKeys) => {
    if (data.kind === "ready") {
      ready = true;
      step_s = data.step_s;
      rang = new Float64Array(Math.round(HEARD_S / step_s));
      told.textContent = "";
      look();
      if (asked_for) perform();
    } else if (data.kind === "shown") {
      if (data.key !== key) return;
      scene = data.scene;
      sounding.hidden = heard.hidden = scene.string === null;
      picture.show([{ index: 0, scene }], false, drawn > 0);
      drawn = data.key;
    } else if (data.kind === "fault") {
      ready = false;
      told.textContent = `The keyboard has stopped: ${data.message}.`;
      told.append(" ", h("button", { type: "button", onclick: () => restart() }, "Start it again"));
    } else take(data);
  };
  const lift = () => engine?.tell({ kind: "pedal", lift_m: pedal.checked ? PEDAL_MM / 1e3 : 0 });
  pedal.addEventListener("change", lift);
  const stop = () => {
    engine?.end();
    engine = null;
    starts += 1;
    starting = ready = waiting = false;
    asked = 0;
    finger_m = null;
    sounded = null;
    row.replaceChildren();
    score.textContent = "";
    scene = frame = null;
    rang.fill(0);
    held.clear();
    changed.clear();
    meter.hidden = true;
    loud = 0;
    sound.setAttribute("aria-pressed", "false");
    told.textContent = "The 88 actions are getting ready \u2026";
  };
  const restart = () => {
    stop();
    void start();
  };
  sound.addEventListener("click", () => {
    aloud = !aloud;
    sound_said.textContent = "";
    restart();
  });
  /** What the loudspeaker got: how loud, and whether it broke off. */
  const tell = ({ unit, peak, clipped, dropouts, lost_s }: Heard) => {
    meter.hidden = false;
    meter.value = Math.max(Math.min(peak, 1), FALLS * meter.value);
    if (clipped) loud += clipped;
    const text = `Heard: ${HEARD[unit]}; ${dropouts ? `${dropouts} drop-${dropouts === 1 ? "out" : "outs"}, ${fixed(lost_s, 1)} s` : "no drop-outs"}${loud ? `; ${loud} samples were too loud` : ""}.`;
    if (sound_said.textContent !== text) sound_said.textContent = text;
  };
  let loud = 0;
  const look = () => {
    if (!ready || asked === key) return;
    asked = key;
    finger_m = null;
    engine!.tell({ kind: "show", key });
  };
  const take = (data: Frame) => {
    waiting = false;
    frame = data;
    app.keysLate = late_s = data.late_s;
    if (scene && data.shown && data.shown.key === drawn) {
      const at = data.shown.key - 1;
      picture.draw([{
        time_s: 0, key_m: data.key_m[at]!, hammer_rise_m: data.hammer_rise_m[at]!, finger_force_n: data.finger_force_n[at]!, string_n: 0, hammer_rise_m_per_s: 0,
        angles: data.shown.angles, contacts: new Float32Array(5 * scene.zones.length), string: new Float32Array(), swing_m: 0,
      }]);
      const key = called("number.key");
      const text = `${key.text} ${fixed(1e3 * data.key_m[at]!, 2)} mm, ${called("curve.hammer").text} ${fixed(1e3 * data.hammer_rise_m[at]!, 1)} mm, ${called("number.finger").text} ${fixed(data.finger_force_n[at]!, 2)} N`;
      if (numbers.textContent !== text) numbers.textContent = text;
      speaks(numbers, key.lang);
    }
    const now = performance.now();
    listen(data.impacts, data.passage_s);
    for (const impact of data.impacts) {
      struck[impact.key] = now;
      list.prepend(h("li", {}, `${nameOf(impact.key)} ${fixed(impact.hammer_speed_m_per_s, 2)} m/s`));
    }
    while (list.children.length > 12) list.lastChild!.remove();
    if (data.steps > 0) app.keysTiming.push([data.cost_ms, data.steps, data.awake]);
    if (app.keysTiming.length > 5000) app.keysTiming.splice(0, 2500);
    const load = data.steps ? (data.cost_ms / (1e3 * data.steps * step_s)) * 100 : 0;
    told.textContent = data.awake ? `${data.awake} ${data.awake === 1 ? "key" : "keys"} awake, ${fixed(load, 0)} % of real time${late_s > 0.05 ? `; ${fixed(late_s, 1)} s were left out: this machine was busy` : ""}` : held.size ? `${held.size} ${held.size === 1 ? "key is" : "keys are"} held, and still: nothing is computed.` : "All keys rest: nothing is computed.";
    if (data.bridge_n.length) hear(data.bridge_n);
    if (data.sound) tell(data.sound);
    draw();
  };

  // ------------------------------------------------------------------------------------------------------- the bridge
  /** The force after each of the last steps, N, oldest first. */
  let rang = new Float64Array();
  let plot: uPlot | null = null, inks = "";
  onlanguage.push(() => (inks = ""));
  const hear = (forces: Float32Array) => {
    const all = rang.length, kept = Math.min(forces.length, all);
    rang.copyWithin(0, kept);
    rang.set(forces.subarray(forces.length - kept), all - kept);
    const style = getComputedStyle(heard);
    const ink = (name: string) => style.getPropertyValue(name).trim();
    if (!plot || inks !== ink("--curve-hammer")) {
      plot?.destroy();
      inks = ink("--curve-hammer");
      speaks(heard, called("keyboard.bridge").lang);
      const axis = { stroke: ink("--soft"), grid: { stroke: ink("--grid"), width: 1 }, ticks: { stroke: ink("--grid"), width: 1 } };
      plot = new uPlot({
        width: Math.max(heard.clientWidth - 4, 160), height: 150, title: called("keyboard.bridge").text, legend: { show: false }, cursor: { show: false },
        scales: { x: { time: false }, y: { range: (_, low, high) => [Math.min(low ?? 0, -1) * 1.05, Math.max(high ?? 0, 1) * 1.05] } },
        axes: [{ ...axis, size: 28, label: "ms", labelSize: 14, labelFont: "11px system-ui, sans-serif", labelGap: -1 }, { ...axis, size: 42 }],
        series: [{ label: "ms" }, { label: "N", stroke: inks, width: 1 }],
      }, [[], []], heard);
    }
    // Of each stretch the least and the greatest: nothing that sounds falls between two points.
    const each = (2 * all) / POINTS, times = new Float64Array(POINTS), values = new Float64Array(POINTS);
    for (let n = 0; n < POINTS; n += 2) {
      const part = rang.subarray((n / 2) * each, (n / 2 + 1) * each);
      [values[n], values[n + 1]] = [Math.min(...part), Math.max(...part)];
      [times[n], times[n + 1]] = [0.25, 0.75].map((share) => 1e3 * step_s * ((n / 2 + share) * each - all)) as [number, number];
    }
    plot.setData([times, values] as unknown as uPlot.AlignedData);
    const loudest = Math.max(...values.subarray(-POINTS / 10)), least = Math.min(...values.subarray(-POINTS / 10));
    const text = `force on the bridge: ${fixed(least, 1)} to ${fixed(loudest, 1)} N in the last 50 ms`;
    if (level.textContent !== text) level.textContent = text;
  };
  new ResizeObserver(() => plot?.setSize({ width: Math.max(heard.clientWidth - 4, 160), height: 150 })).observe(heard);

  const press = (who: string, which: number | null, force: number) => {
    const was = held.get(who);
    if (was !== undefined && was !== which) {
      held.delete(who);
      if (![...held.values()].includes(was)) changed.set(was, 0);
    }
    if (which !== null) {
      held.set(who, which);
      changed.set(which, force);
    }
  };

  // ----------------------------------------------------------------------------------------------------------- drawing
  const whites = Array.from({ length: KEYS }, (_, n) => n + 1).filter((one) => !isSharp(one));
  /** Where a screen is too narrow for fingers on all 88, so many white keys are shown, from the one that the buttons
   * choose. */
  const narrow = () => canvas.clientWidth > 0 && canvas.clientWidth < 640;
  let first = whites.indexOf(MIDDLE_C) - 3;
  const layout = () => {
    const { width, height } = canvas;
    const count = narrow() ? 15 : whites.length, from = narrow() ? first : 0;
    const white = width / count, top = height * 0.42;
    return { width, height, white, from, top, black: white * 0.62, blackDown: top + (height - top) * 0.6 };
  };
  const placeOf = (which: number): [number, number] => {
    const { white, black, from } = layout();
    if (!isSharp(which)) return [(whites.indexOf(which) - from) * white, white];
    return [(whites.indexOf(which - 1) - from + 1) * white - black / 2, black];
  };
  const shift = (by: number) => {
    first = Math.min(Math.max(first + by, 0), whites.length - 15);
    draw();
  };
  const lower = named(h("button", { type: "button", onclick: () => shift(-7) }), "keyboard.lower"), higher = named(h("button", { type: "button", onclick: () => shift(7) }), "keyboard.higher");
  const octaves = h("div", { class: "row" }, lower, higher);
  const draw = () => {
    const context = canvas.getContext("2d");
    const bounds = canvas.getBoundingClientRect();
    if (!context || bounds.width === 0) return;
    const scale = devicePixelRatio || 1;
    const [w, tall] = [Math.round(bounds.width * scale), Math.round(bounds.height * scale)];
    if (canvas.width !== w || canvas.height !== tall) [canvas.width, canvas.height] = [w, tall];
    octaves.hidden = !narrow();
    const { width, height, top, blackDown } = layout();
    const style = getComputedStyle(canvas);
    const ink = (name: string) => style.getPropertyValue(name).trim();
    context.fillStyle = ink("--paper");
    context.fillRect(0, 0, width, height);
    // Hammers rise to their strings.
    const string = top * 0.12, rest = top * 0.88;
    context.strokeStyle = ink("--soft");
    context.lineWidth = scale;
    context.beginPath();
    context.moveTo(0, string);
    context.lineTo(width, string);
    context.stroke();
    const now = performance.now();
    for (const sharps of [false, true]) {
      for (let which = 1; which <= KEYS; which++) {
        if (isSharp(which) !== sharps) continue;
        const [x, wide] = placeOf(which);
        const depth = frame ? Math.min(Math.max(frame.key_m[which - 1]! / DIP_M, 0), 1.2) : 0;
        const down = depth * 5 * scale, bottom = sharps ? blackDown : height;
        context.fillStyle = sharps ? mix([38, 36, 34], [120, 70, 40], depth) : mix([252, 250, 245], [236, 190, 120], depth);
        context.fillRect(x + 0.5 * scale, top, wide - scale, bottom - top - 6 * scale + down);
        if (!sharps) {
          context.fillStyle = "#b9b2a4";
          context.fillRect(x + wide - 0.5 * scale, top, scale, bottom - top);
        }
        context.fillStyle = sharps ? "#000" : "#c9c2b4";
        context.fillRect(x + 0.5 * scale, bottom - 6 * scale + down, wide - scale, 3 * scale);
        if (which === key) {
          context.strokeStyle = ink("--link");
          context.lineWidth = 2.5 * scale;
          context.strokeRect(x + 2 * scale, top + 2 * scale, wide - 4 * scale, bottom - top - 8 * scale);
          context.lineWidth = scale;
        }
        const rise = frame ? frame.hammer_rise_m[which - 1]! / BLOW_M : 0;
        const y = rest + (string - rest) * Math.min(Math.max(rise, 0), 1.05);
        const glow = Math.max(0, 1 - (now - struck[which]!) / 400);
        const middle = x + wide / 2;
        context.strokeStyle = ink("--grid-strong");
        context.beginPath();
        context.moveTo(middle, rest + 4 * scale);
        context.lineTo(middle, y);
        context.stroke();
        context.fillStyle = struck[which]! > 0 && glow > 0 ? mix([208, 52, 44], [150, 140, 120], 1 - glow) : ink("--hammer");
        context.beginPath();
        context.ellipse(middle, y + 4 * scale, Math.max(wide * 0.3, 1.5 * scale), 5 * scale, 0, 0, 7);
        context.fill();
      }
    }
    context.fillStyle = "#6a655d";
    context.font = `${10 * scale}px system-ui, sans-serif`;
    context.textAlign = "center";
    if (layout().white > 13 * scale) for (const which of whites) if (nameOf(which).startsWith("C")) context.fillText(nameOf(which), placeOf(which)[0] + layout().white / 2, height - 12 * scale);
  };
  const mix = (from: number[], to: number[], share: number) => `rgb(${from.map((one, k) => Math.round(one + (to[k]! - one) * Math.min(share, 1))).join(" ")})`;

  const hit = (event: PointerEvent): { which: number; force: number } | null => {
    const bounds = canvas.getBoundingClientRect();
    const x = ((event.clientX - bounds.left) / bounds.width) * canvas.width, y = ((event.clientY - bounds.top) / bounds.height) * canvas.height;
    const { top, blackDown, white, height, from } = layout();
    if (y < top || y > height) return null;
    const strength = (back: number, front: number) => SOFT_N * (HARD_N / SOFT_N) ** Math.min(Math.max((y - back) / (front - back), 0), 1);
    if (y < blackDown) {
      for (let which = 1; which <= KEYS; which++) {
        const [left, wide] = placeOf(which);
        if (isSharp(which) && x >= left && x < left + wide) return { which, force: strength(top, blackDown) };
      }
    }
    const which = whites[Math.floor(x / white) + from];
    return which === undefined ? null : { which, force: strength(top, height) };
  };
  canvas.addEventListener("pointerdown", (event) => {
    const at = hit(event);
    if (!at) return;
    canvas.setPointerCapture(event.pointerId);
    choose(at.which, false);
    press(`pointer ${event.pointerId}`, at.which, at.force);
  });
  canvas.addEventListener("pointermove", (event) => {
    if (!held.has(`pointer ${event.pointerId}`)) return;
    const at = hit(event);
    if (at) press(`pointer ${event.pointerId}`, at.which, at.force);
  });
  for (const over of ["pointerup", "pointercancel"] as const) canvas.addEventListener(over, (event) => press(`pointer ${event.pointerId}`, null, 0));
  const choose = (which: number, aloud = true) => {
    key = Math.min(Math.max(which, 1), KEYS);
    const at = whites.indexOf(isSharp(key) ? key - 1 : key);
    if (at < first || at >= first + 15) first = Math.min(Math.max(at - 7, 0), whites.length - 15);
    chosen.textContent = `${nameOf(key)}, key ${key}`;
    look();
    if (aloud) say(`${nameOf(key).replace("\u266f", " sharp ")}, key ${key}`);
    draw();
  };
  canvas.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.altKey || event.metaKey) return;
    const steps: Record<string, number> = { ArrowLeft: -1, ArrowRight: 1, ArrowDown: -12, ArrowUp: 12 };
    const lower = ROWS.indexOf(event.code), upper = UPPER.indexOf(event.code);
    if (event.key in steps) choose(key + steps[event.key]!);
    else if (event.key === " ") event.repeat || press("space", key, app.state.force);
    else if (event.key === "Enter") open.click();
    else if (lower >= 0) event.repeat || press(event.code, MIDDLE_C - 12 + lower, app.state.force);
    else if (upper >= 0) event.repeat || press(event.code, MIDDLE_C + upper, app.state.force);
    else return;
    event.preventDefault();
  });
  canvas.addEventListener("keyup", (event) => press(event.key === " " ? "space" : event.code, null, 0));
  canvas.addEventListener("blur", () => [...held.keys()].forEach((who) => press(who, null, 0)));
  open.addEventListener("click", () => void app.change({ a: { base: { key, keyboard: opened }, turns: {} }, tab: "play" }));
  const ten = named(h("button", { type: "button", id: "ten" }), "keyboard.ten");
  ten.addEventListener("click", () => {
    const chord = [16, 20, 23, 28, 32, 40, 44, 47, 52, 56];
    chord.forEach((which, n) => press(`ten ${n}`, which, 8));
    setTimeout(() => chord.forEach((_, n) => press(`ten ${n}`, null, 0)), 1500);
  });

  into.append(
    h("p", {}, "Every key is an action of its own, from heavy bass hammers to light treble ones. Press near the front edge to play loud, further back to play softly. Above is the action of the key that was pressed last: its key can be dragged, too."),
    h("div", { class: "row" }, h("label", {}, named(h("span"), "keyboard.keyboard"), " ", piano), again),
    row,
    score,
    inside,
    h("div", { class: "row" }, chosen, numbers, open, ten),
    canvas,
    octaves,
    told,
    sounding,
    sound_said,
    heard,
    named(h("h2"), "keyboard.impacts"),
    list,
    h("p", { class: "soft" }, "With the keyboard in focus, ", h("kbd", {}, "Z"), " \u2026 ", h("kbd", {}, "/"), " play from C3 on, ", h("kbd", {}, "Q"), " \u2026 ", h("kbd", {}, "P"), " from middle C, C4, on; the force is that of the Play panel."),
  );
  choose(MIDDLE_C, false);
  const tick = (now: number) => {
    if (app.state.tab === "keyboard") {
      if (ready && !waiting) {
        waiting = true;
        engine!.tell({ kind: "frame", wall_ms: now, forces: [...changed], finger_m });
        changed = new Map();
      }
    }
    requestAnimationFrame(tick);
  };
  requestAnimationFrame(tick);
  new ResizeObserver(draw).observe(canvas);
  app.onchange.push(() => {
    if (app.state.tab !== "keyboard") {
      // Nobody plays what is not seen.
      if (aloud) {
        aloud = false;
        sound_said.textContent = "";
        stop();
      }
      return;
    }
    if (piano.options.length !== app.keyboards.length) piano.replaceChildren(...app.keyboards.map((name) => new Option(name, name)));
    piano.value = wanted();
    if (engine && opened !== wanted()) restart();
    else void start();
    draw();
  });
  piano.addEventListener("change", () => void app.change({ keyboard: piano.value }));
};
