// The gallery: what each example shows, the address of the workbench that it opens, and what is played there. The page,
// the build that draws its picture, and the tests read this list. No page and no engine here.

/** @typedef {{ nuance: string, struck: boolean } | { csv: string, name: string }} Stroke */
/**
 * @typedef {object} Example
 * @property {string} id
 * @property {string} title
 * @property {string} see What there is to see, in a sentence or two.
 * @property {string} address Behind the # of the workbench, without the example's own name.
 * @property {{ nuance: string, struck: boolean }} [stroke] The stroke that is played.
 * @property {{ nuance: string, struck: boolean }} [other] What action B is played with, where that is another stroke.
 * @property {[number, number, number][]} [touches] Instead of a stroke: forces, from when to when, s, and N.
 * @property {[number, number]} [at] The impact that is looked at once the stroke is over: of which action, and which of
 * its impacts, from 1; none: now.
 * @property {boolean} [passage] Whether the keyboard's passage is played.
 * @property {"hammers" | "weights" | "swings" | "notes"} picture What the small picture shows.
 * @property {[number, number]} [during_s] What of the stroke it shows.
 * @property {number} [near_m] Of hammers only what is nearer to the string than this, m.
 */

/** How long what is played takes, s: the built-in strokes, and the forces. */
export const LENGTH_S = 0.95;
/** How fast a force of an example grows and fades, s. */
const RAMP_S = 0.01;

/** Two actions side by side, their hammers in the picture. */
const BESIDE = "beside=1&view=-8.8,-183.9,338.8,225.9";

/** @type {Example[]} */
export const EXAMPLES = [
  {
    id: "worn-regulation", title: "Worn regulation", picture: "hammers", during_s: [0.17, 0.37], near_m: 0.015,
    see: "One soft press on two actions. A is regulated, and sounds. B has worn for years: the hammer is let off too far below the string, falls back, and nothing sounds. The sheets under Compare say what is out of range.",
    address: `tab=compare&b=concert-grand;capstan_height:-0.15;let_off:-0.4;drop:0.3;repetition_spring:-6;back_check:-1;front_punching:-0.8&${BESIDE}`,
    touches: [[0.05, 0.5, 0.66]], at: [0, 1],
  },
  {
    id: "double-strike", title: "Double strike", picture: "hammers", during_s: [0, 0.4],
    see: "One forte on two actions. B has too much felt under the key: its back check comes up too little to catch the hammer, which bounces and strikes a second time. A strikes once.",
    address: `tab=compare&b=concert-grand;front_punching:1.8&${BESIDE}`,
    stroke: { nuance: "f", struck: false }, at: [1, 2],
  },
  {
    id: "capstan-moved", title: "Capstan moved", picture: "weights",
    see: "On B the capstan stands 8 mm further back. The lever at the key is longer: the sheets under Compare show that the key takes more weight to go down, and the same hand throws the hammer less fast.",
    address: `tab=compare&b=concert-grand;capstan:150.23&${BESIDE}`,
    stroke: { nuance: "mf", struck: false }, at: [0, 1],
  },
  {
    id: "struck-beside-pressed", title: "Struck beside pressed", picture: "hammers", during_s: [0, 0.09],
    see: "One action, one loudness, two touches. A is pressed: the hand rests on the key first. B is struck: the hand arrives moving. Both hammers are equally fast, but B\u2019s is there in about half the time. The curves show how differently the key goes down.",
    address: `tab=compare&b=concert-grand&${BESIDE}`,
    stroke: { nuance: "f", struck: false }, other: { nuance: "f", struck: true }, at: [1, 1],
  },
  {
    id: "lost-repetition", title: "Lost repetition", picture: "hammers", during_s: [0.03, 0.42],
    see: "Two quick presses; between them the key comes up by half. On A the repetition spring lifts the hammer, the jack slips back under the knuckle, and the second note sounds. On B the spring is slack: the jack is not back, and the second press is silent.",
    address: `tab=compare&b=concert-grand;repetition_spring:-16&${BESIDE}`,
    touches: [[0.05, 0.25, 5], [0.275, 0.45, 5]], at: [0, 2],
  },
  {
    id: "heavy-touch", title: "Heavy touch", picture: "hammers", during_s: [0.03, 0.075],
    see: "One hand on two actions. B\u2019s hammer is heavy: it arrives later, and slower. The sheets under Compare show the weights that make it so.",
    address: `tab=compare&b=heavy-touch&${BESIDE}`,
    stroke: { nuance: "mf", struck: false }, at: [0, 1],
  },
  {
    id: "pedal", title: "Pedal", picture: "swings", during_s: [0, 0.95],
    see: "The key has come back, and the string still swings: the sustain pedal holds its damper up. Press P, or move the pedal\u2019s slider: the damper falls, and the note ends.",
    address: "a=concert-grand-strings&pedal=7",
    stroke: { nuance: "mf", struck: false },
  },
  {
    id: "lost-notes", title: "Lost notes", picture: "notes",
    see: "Twelve notes a second, three on each key. On this heavy keyboard only the first of each three sounds: key and hammer are not back in time for the others. Choose the keyboard concert-grand and play the passage again: all twelve sound.",
    address: "tab=keyboard&keys=heavy-touch",
    passage: true,
  },
];

/** @param {string} id @returns {Example | undefined} */
export const exampleOf = (id) => EXAMPLES.find((one) => one.id === id);

/** @param {Example} example */
export const addressOf = ({ id, address }) => `example=${id}&${address}`;

/** What is played: a built-in stroke, or its forces as a table. @param {Example} example @returns {Stroke | null} */
export const strokeOf = ({ stroke, touches, title }) => {
  if (!touches) return stroke ?? null;
  const rows = ["time_s,force_N"];
  for (let n = 0; n <= 700; n++) {
    const time = n / 1000;
    const force = touches.reduce((sum, [from, to, newton]) => sum + (time < from || time > to ? 0 : newton * Math.min(1, (time - from) / RAMP_S, (to - time) / RAMP_S)), 0);
    rows.push(`${time.toFixed(3)},${force.toFixed(4)}`);
  }
  return { csv: rows.join("\n"), name: title };
};

/** The keyboard's passage: keys that are repeated three times each, so many a second, pressed by so much for this share
 * of their time. */
export const PASSAGE = { keys: [40, 40, 40, 44, 44, 44, 45, 45, 45, 47, 47, 47], period_s: 1 / 12, share: 0.7, force_n: 5 };

/** Its forces on keys, in the order of time: when, s, which key, and the force, N; 0 lets it go.
 * @returns {[number, number, number][]} */
export const passage = () => {
  const { keys, period_s, share, force_n } = PASSAGE;
  return keys.flatMap((key, n) => /** @type {[number, number, number][]} */ ([[n * period_s, key, force_n], [(n + share) * period_s, key, 0]]));
};
