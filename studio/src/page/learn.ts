// Learn: six short scenes that run the real model. Each says in a few sentences what there is to be seen, sets the
// action up, and gives something to try.
import type { App } from "./app";
import { h, later } from "./dom";
import type { Setting } from "./state";

interface Trial {
  label: string;
  act(app: App): void;
}

interface Scene {
  title: string;
  text: string[];
  a?: Setting;
  b?: Setting;
  close: boolean;
  tries: Trial[];
  watch: string;
}

const GRAND: Setting = { base: { builtin: "concert-grand" }, turns: {} };
const HEAVY: Setting = { base: { builtin: "concert-grand" }, turns: { hammer: 12.5 } };

/** Plays a stroke, and shows it again slowly once it is over. */
const slowly = (nuance: string, struck: boolean, speed = 1 / 50): ((app: App) => void) => (app) => {
  app.setSpeed(speed);
  app.stroke({ nuance, struck });
  app.replayWhenOver();
};
/** The key's front, s and mm: down, held, back up by four millimetres only, and down once more. */
const AGAIN = [[0, 0], [0.01, 0], [0.05, 9.4], [0.13, 9.4], [0.19, 5.4], [0.2, 5.4], [0.24, 9.4], [0.36, 9.4], [0.6, 0], [0.61, 0]] as const;
/** From place to place on half a cosine, a row every millisecond: a curve through few points would overshoot. */
const gesture = (through: readonly (readonly [number, number])[]): string => {
  const rows = ["time_s,position_m"];
  for (let n = 0; n <= 1000 * through.at(-1)![0]; n++) {
    const time = n / 1000, next = Math.max(through.findIndex(([at]) => at >= time), 1);
    const [from, start] = through[next - 1]!, [to, end] = through[next]!;
    const down = start + (end - start) * (0.5 - 0.5 * Math.cos((Math.PI * (time - from)) / (to - from)));
    rows.push(`${time.toFixed(3)},${(down / 1000).toFixed(10)}`);
  }
  return rows.join("\n");
};
/** Plays a table, and shows it again slowly once it is over. */
const played = (csv: string, name: string, speed: number) => (app: App): void => {
  app.setSpeed(speed);
  app.stroke({ csv, name });
  app.replayWhenOver();
};
const again = played(gesture(AGAIN), "again", 1 / 20);
/** A force that grows within 12 ms and then is the same, whatever moves. */
const steady = played("time_s,force_N\n0,0\n0.012,5\n0.3,5\n0.31,0", "5 N", 1 / 50);
/** Turns a dial of A, and then does something. */
const turned = (dial: string, value: number | null, then?: (app: App) => void): ((app: App) => void) => (app) => {
  app.letGo();
  void app.turn(0, dial, value).then(() => then?.(app));
};

const SCENES: Scene[] = [
  {
    title: "What escapement is",
    text: [
      "The jack pushes the hammer up by its knuckle. Just before the string its toe meets the let-off button, the jack tips away, and for the last millimetre and a half the hammer flies alone.",
      "Without that the key would press the hammer against the string and choke the note.",
    ],
    a: GRAND,
    close: true,
    tries: [
      { label: "Show it slowly", act: slowly("mf", false) },
      { label: "Button 3 mm higher, and hold", act: turned("let_off", 3, (app) => app.push(4)) },
      { label: "As it was", act: turned("let_off", null) },
    ],
    watch: "Watch the arrow at the knuckle vanish while the hammer still rises. With the button too high it never does: the hammer stays at the string.",
  },
  {
    title: "Why a held note is still",
    text: [
      "After the impact the hammer falls back and its tail is caught by the back check: felt and leather hold it by dry friction, 13 mm below the string.",
      "Friction that sticks holds without moving at all. Hold the key, and the page stops computing, for no number changes any more.",
    ],
    a: GRAND,
    close: true,
    tries: [
      { label: "Press and hold", act: (app) => app.push(6) },
      { label: "Let go", act: (app) => app.push(0) },
      { label: "Check bent away, and hold", act: turned("back_check", -4, (app) => app.push(6)) },
      { label: "As it was", act: turned("back_check", null) },
    ],
    watch: "Hold: the clock says \u201cat rest\u201d, with the forces still there. With the check bent away nothing catches the hammer, and it strikes once more.",
  },
  {
    title: "What aftertouch is",
    text: [
      "When the jack has escaped, the key has about one more millimetre to go before its front punching: the aftertouch, which makes sure that the jack gets out of the way even in a soft blow.",
      "A thicker punching takes it away. The back check, which stands on the key, then comes up too little to catch the hammer at once, and a loud note sounds twice.",
    ],
    a: GRAND,
    close: false,
    tries: [
      { label: "A loud note", act: slowly("f", false, 1 / 20) },
      { label: "2 mm more punching", act: turned("front_punching", 1.8, slowly("f", false, 1 / 20)) },
      { label: "As it was", act: turned("front_punching", null) },
    ],
    watch: "Count the impacts, in the numbers and in the string\u2019s curve.",
  },
  {
    title: "Why a heavy hammer feels heavy",
    text: [
      "The hammer moves five to six times as fast as the key, so that its weight counts five to six times at the finger, and its inertia thirty times. Four fifths of what a pianist has to set in motion is the hammer.",
      "B has a hammer four grams heavier: the same force of the finger takes longer, and gives it less speed.",
    ],
    a: GRAND,
    b: HEAVY,
    close: false,
    tries: [
      { label: "5 N on both", act: steady },
      { label: "Fortissimo", act: slowly("ff", false) },
      { label: "Lighter B: 6 g", act: (app) => void app.turn(1, "hammer", 6).then(() => steady(app)) },
    ],
    watch: "The numbers of the impact stand side by side: A | B.",
  },
  {
    title: "Why repetition fails",
    text: [
      "For a second note the jack has to be back under the knuckle before the key is pressed again. The repetition lever holds the hammer up meanwhile, so that less than half of the key\u2019s way is enough: Érard\u2019s double escapement.",
      "With a weak repetition spring the lever does not hold the hammer up, the jack stays beside the knuckle, and the second press lifts nothing.",
    ],
    a: GRAND,
    close: true,
    tries: [
      { label: "Down, 4 mm up, down again", act: again },
      { label: "The same with a weak spring", act: turned("repetition_spring", -18, again) },
      { label: "As it was", act: turned("repetition_spring", null) },
    ],
    watch: "Count the impacts, then look at the jack\u2019s top when the second press begins.",
  },
  {
    title: "Why the key bottoms before the hammer strikes",
    text: [
      "Press fortissimo, and the key is down while the hammer still has some millimetres to go: the force that throws it bends key and shank and squeezes the felts, so that the finger is ahead of the hammer.",
      "Pressed softly, or struck from the air, the hammer is thrown ahead of the key and strikes first. So the key\u2019s bottom does not tell the instant of the note: a keyboard that listens there is early or late by milliseconds.",
    ],
    a: GRAND,
    close: false,
    tries: [
      { label: "pp", act: slowly("pp", false, 1 / 20) },
      { label: "mf", act: slowly("mf", false, 1 / 20) },
      { label: "ff", act: slowly("ff", false, 1 / 50) },
      { label: "mf, struck", act: slowly("mf", true, 1 / 20) },
    ],
    watch: "\u201ckey bottom \u2212 hammer\u201d in the numbers: negative where the key is first.",
  },
];

export const learnPanel = (app: App, into: HTMLElement): void => {
  const list = h("ol", { class: "scenes" });
  const place = h("article", { class: "scene", id: "scene", tabindex: -1 });
  into.append(h("nav", { "aria-label": "Scenes" }, list), place);
  let shown = -1;
  const setUp = later(0, async (scene: Scene) => {
    app.letGo();
    await app.change({ a: structuredClone(scene.a ?? GRAND), b: scene.b ? structuredClone(scene.b) : null, beside: false });
    app.pictures.forEach((picture) => (scene.close ? picture.lookClose() : picture.lookWhole()));
  });
  const buttons = SCENES.map((scene, index) => {
    const button = h("button", { type: "button", onclick: () => void app.change({ scene: index }) }, scene.title);
    list.append(h("li", {}, button));
    return button;
  });
  app.onchange.push(() => {
    if (app.state.tab !== "learn") {
      shown = -1;
      return;
    }
    const index = Math.min(app.state.scene, SCENES.length - 1);
    buttons.forEach((button, n) => (n === index ? button.setAttribute("aria-current", "true") : button.removeAttribute("aria-current")));
    if (index === shown) return;
    shown = index;
    const scene = SCENES[index]!;
    const tries = scene.tries.map(({ label, act }) => h("button", { type: "button", onclick: () => act(app) }, label));
    place.replaceChildren(
      h("h2", {}, scene.title),
      ...scene.text.map((text) => h("p", {}, text)),
      h("div", { class: "row tries" }, ...tries),
      h("p", { class: "watch" }, scene.watch),
    );
    setUp(scene);
  });
};
