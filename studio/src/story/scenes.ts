// The eight steps: which action each of them plays, how it is seen, when time slows down, and what there is to say of a
// press. Every number that is said comes from the engine.
import type { Events, Pose, Slow } from "../engine/protocol";
import { fixed } from "../page/dom";
import type { View } from "../page/picture";
import type { Setup } from "./live";
import { type Press, path, ramp, weight } from "./strokes";

export interface Now {
  press: Press;
  pose: Pose;
  events: Events;
  resting: boolean;
  /** Which position its switch has, and for each what its last press was. */
  option: number;
  last: (Press | null)[];
}

export interface Step {
  /** An action, or one for each position of a switch. */
  setups: (Setup & { label?: string })[];
  /** What is seen, mm: left, top, width and height; and on a phone. */
  wide: View;
  narrow: View;
  slow: Slow[];
  /** How hard the button presses, N. */
  press_n: number;
  /** What "Show me" plays. */
  show: string;
  facts: (now: Now) => [string, string][];
  /** What came of it, and whether the task is done. */
  outcome: (now: Now) => [text: string, done: boolean];
  /** A depth that the slider marks, mm. */
  mark_mm?: number;
  plot?: boolean;
}

const WHOLE: View = [-326, -190, 662, 236], BACK: View = [58, -188, 282, 216], INNER: View = [64, -168, 208, 160];
const DAMPER: View = [76, -194, 262, 202];
/** The last way to the string, and what follows an impact. */
const NEAR: Slow[] = [
  { of: "hammer", from_m: 0.030, to_m: 0.06, going: 1, least_m_per_s: 0.25, pace: 1 / 30 },
  { of: "impact", for_s: 0.012, pace: 1 / 40 },
];
/** The first approach; then the hammer drums, and nobody waits for every beat of it. */
const DRUM: Slow[] = [
  { of: "hammer", from_m: 0.030, to_m: 0.06, going: 1, least_m_per_s: 0.9, pace: 1 / 30 },
  { of: "impact", for_s: 0.003, pace: 1 / 12 },
];
/** From the toe's meeting with the button on. */
const LET_OFF: Slow[] = [
  { of: "hammer", from_m: 0.032, to_m: 0.06, going: 1, least_m_per_s: 0.2, pace: 1 / 40 },
  { of: "hammer", from_m: 0.0415, to_m: 0.06, going: 1, least_m_per_s: 0.2, pace: 1 / 120 },
  { of: "impact", for_s: 0.008, pace: 1 / 80 },
];
const CATCH: Slow[] = [
  { of: "hammer", from_m: 0.034, to_m: 0.06, going: 1, least_m_per_s: 0.25, pace: 1 / 20 },
  { of: "impact", for_s: 0.004, pace: 1 / 40 },
  { of: "hammer", from_m: 0.012, to_m: 0.05, going: 0, least_m_per_s: 0.12, pace: 1 / 10 },
];
const REPEAT: Slow[] = [
  { of: "impact", for_s: 0.006, pace: 1 / 30 },
  { of: "hammer", from_m: 0.036, to_m: 0.06, going: 1, least_m_per_s: 0.3, pace: 1 / 25 },
  { of: "key", from_m: 0.0012, to_m: 0.0088, going: -1, least_m_per_s: 0.01, pace: 1 / 12 },
];

const GRAND: Setup = { base: "concert-grand" }, STRINGS: Setup = { base: "concert-grand-strings", sounds: true };
const mm = (m: number, decimals = 1): string => `${fixed(1e3 * m, decimals)}\u00a0mm`;
const times = (count: number): string => (count === 0 ? "not at all" : count === 1 ? "once" : count === 2 ? "twice" : `${count} times`);
const KEY = (now: Now): [string, string] => ["key down", mm(now.pose.key_m)];
const HAMMER = (now: Now): [string, string] => ["hammer up", mm(now.pose.hammer_rise_m)];
const SWING = (now: Now): [string, string] => ["string swings", mm(now.pose.swing_m, 2)];
const IMPACTS = (now: Now): [string, string] => ["impacts", String(now.press.impacts)];
const SOFT = "Too soft. The hammer was set free, and fell back before it reached the string. A real piano is silent, too. Press faster.";
/** A hammer that was let go and did not arrive. */
const soft = ({ press, pose }: Now): boolean => press.impacts === 0 && press.deepest_mm > 9 && press.highest_mm > 40 && 1e3 * pose.hammer_rise_m < press.highest_mm - 0.3 && Math.abs(pose.hammer_rise_m_per_s) < 0.1;
const WAITING: [string, boolean] = ["", false];
const going = ({ press }: Now): boolean => press.deepest_mm > 0.5;

/** The action without its repetition lever, and with a fixed rail on which the hammer rests: the file's lever is put
 * out of the knuckle's reach, and the cushion under the shank stands on the ground. */
export const simple = (text: string): string => {
  const zone = (name: string, change: (lines: string) => string): void => {
    const from = text.indexOf(`[[zone]]\nname = "${name}"`), next = text.indexOf("\n[[", from + 1);
    const lines = text.slice(from, next), changed = change(lines);
    if (from < 0 || next < 0 || changed === lines) throw new Error(`the file's zone ${name} is not as this step expects it`);
    text = text.slice(0, from) + changed + text.slice(next);
  };
  zone("lever_knuckle", (lines) => lines.replace(/(\[zone\.line\][\s\S]*?point_mm = \{ value = \[-37, )[\d.]+\]/, "$18]"));
  zone("hammer_rest", (lines) => lines.replace(/(\[zone\.line\]\nbody = )"whippen"(\npoint_mm = \{ value = )\[[^\]]*\]/, '$1"ground"$2[196.3, 75]'));
  return text;
};

const twice = ({ press }: Now): string =>
  `You pressed ${times(press.presses)}; the key came up ${fixed(press.released_mm, 1)} mm in between. The hammer struck ${times(press.impacts)}.`;

/** A key that is pressed, comes up halfway, and is pressed again. */
const TWICE: Omit<Step, "setups" | "outcome"> = {
  wide: INNER, narrow: INNER, slow: REPEAT, press_n: 5, mark_mm: 5,
  show: path([0, 0], [0.05, 0], [0.09, 9.4], [0.3, 9.4], [0.4, 5.4], [0.5, 5.4], [0.54, 9.4], [0.8, 9.4], [1.1, 0], [1.2, 0]),
  facts: (now) => [["presses", String(now.press.presses)], IMPACTS(now)],
};
/** What is said until the second press; `raised` is what has happened on the key's way up. */
const first = (now: Now, raised: string): [string, boolean] => {
  const { press: g } = now;
  if (!going(now)) return WAITING;
  if (g.presses === 1 && soft(now)) return [SOFT, false];
  if (!g.presses) return ["Press, all the way down.", false];
  if (g.up_mm > 1) return [`The key has come up ${fixed(g.up_mm, 1)} mm${raised}. Now press again.`, false];
  return [`It struck ${times(g.impacts)}. Let the key come up halfway, and press again.`, false];
};

export const STEPS: Record<string, Step> = {
  lever: {
    setups: [GRAND], wide: WHOLE, narrow: WHOLE, slow: NEAR, press_n: 4, mark_mm: 5,
    show: path([0, 0], [0.05, 0], [0.9, 5], [2.2, 5], [2.9, 0], [3, 0]),
    facts: (now) => [KEY(now), HAMMER(now), ["ratio", now.pose.key_m > 5e-4 ? `${fixed(now.pose.hammer_rise_m / now.pose.key_m, 1)} times` : "\u2013"]],
    outcome: (now) => {
      const { key_m, hammer_rise_m } = now.pose;
      if (now.press.impacts && key_m > 8e-3) return [`All the way: the hammer struck at ${fixed(now.press.hammer_speed_m_per_s, 1)} m/s, some six times as fast as the key moved. Now come up to halfway.`, false];
      if (!going(now)) return WAITING;
      if (key_m < 5e-4) return ["The key is up again. Press it to halfway, and hold it there.", false];
      const half = key_m > 4.5e-3 && key_m < 5.6e-3;
      return [`The key is ${mm(key_m)} down, and the hammer has risen by ${mm(hammer_rise_m)}: ${fixed(hammer_rise_m / Math.max(key_m, 1e-4), 1)} times as far.`, half];
    },
  },
  flight: {
    setups: [{ ...STRINGS, turns: { let_off: 4 } }], wide: BACK, narrow: BACK, slow: DRUM, press_n: 5,
    show: weight(5, 0.9),
    facts: (now) => [IMPACTS(now), SWING(now)],
    outcome: (now) => {
      const { press: g } = now;
      if (!g.impacts) return going(now) ? ["The hammer is on its way. Press it all the way.", false] : WAITING;
      const so_far = `The hammer has struck the string ${times(g.impacts)}, and ${now.pose.key_m > 8e-3 ? "cannot get away" : "is free at last"}.`;
      if (Number.isNaN(g.later_m)) return [`${so_far} The swing was ${mm(g.swing_m, 2)}. Keep the key down.`, false];
      return [`${so_far} Half a second after the first impact the string swings by ${mm(g.later_m, 2)}; it was ${mm(g.swing_m, 2)}.`, true];
    },
  },
  escapement: {
    setups: [STRINGS], wide: INNER, narrow: INNER, slow: LET_OFF, press_n: 5,
    show: weight(5, 0.9),
    facts: (now) => [["below the string", now.pose.hammer_rise_m < 0.0475 ? mm(0.0475 - now.pose.hammer_rise_m) : "0.0 mm"], SWING(now)],
    outcome: (now) => {
      const { press: g, events } = now;
      if (soft(now)) return [SOFT, false];
      if (!g.impacts) return going(now) ? ["The jack pushes. Go on, all the way down.", false] : WAITING;
      const free = Number.isFinite(events.free_flight_s) ? `set free ${fixed(1e3 * events.free_flight_s, 1)} ms before it struck, at ${fixed(g.hammer_speed_m_per_s, 1)} m/s` : `and struck at ${fixed(g.hammer_speed_m_per_s, 1)} m/s`;
      const so_far = `The hammer was ${free}. It struck ${times(g.impacts)}.`;
      if (Number.isNaN(g.later_m)) return [`${so_far} The swing was ${mm(g.swing_m, 2)}. Keep the key down.`, false];
      return [`${so_far} Half a second later the string still swings by ${mm(g.later_m, 2)} of ${mm(g.swing_m, 2)}.`, g.impacts === 1];
    },
  },
  check: {
    setups: [{ ...GRAND, turns: { back_check: -4 }, label: "without check" }, { ...GRAND, label: "with check" }],
    wide: BACK, narrow: BACK, slow: CATCH, press_n: 6,
    show: weight(6, 0.9),
    facts: (now) => [IMPACTS(now), ["below the string", mm(Math.max(0.0475 - now.pose.hammer_rise_m, 0))]],
    outcome: (now) => {
      const { press: g, option, last } = now;
      const both = (last[0]?.impacts ?? 0) > 1 && (last[1]?.impacts ?? 0) === 1;
      if (!g.impacts) return soft(now) ? [SOFT, both] : [going(now) ? "Press firmly, all the way down." : "", both];
      if (!option) return [g.impacts > 1 ? `Nothing caught the hammer. It struck ${times(g.impacts)}. Now put the check back.` : "It struck once, so far. Keep the key down; if it stays at once, press harder.", both];
      const held = now.pose.key_m > 8.5e-3 && Math.abs(now.pose.hammer_rise_m_per_s) < 0.02 && now.pose.hammer_rise_m > 0.02;
      return [`It struck ${times(g.impacts)}${held ? `, and is held ${mm(0.0475 - now.pose.hammer_rise_m, 0)} below the string` : ""}.${both ? "" : " Compare: press without the check."}`, both];
    },
  },
  damper: {
    setups: [{ ...STRINGS, label: "pedal up" }, { ...STRINGS, pedal_mm: 7, label: "pedal down" }], wide: DAMPER, narrow: DAMPER, press_n: 5,
    slow: [
      { of: "hammer", from_m: 0.036, to_m: 0.06, going: 1, least_m_per_s: 0.25, pace: 1 / 20 },
      { of: "impact", for_s: 0.01, pace: 1 / 30 },
      { of: "key", from_m: 0.003, to_m: 0.007, going: -1, least_m_per_s: 0.01, pace: 1 / 15 },
    ],
    show: weight(5, 0.7),
    facts: (now) => [KEY(now), SWING(now)],
    outcome: (now) => {
      const { press: g, option, last } = now;
      const seen = [0, 1].every((which) => (which === option ? g : last[which])?.impacts && ((which === option ? g : last[which])?.up_mm ?? 0) > 7);
      if (!g.impacts) return soft(now) ? [SOFT, seen] : [going(now) ? "Press faster, all the way down." : "", seen];
      const swing = `The string swings by ${mm(now.pose.swing_m, 3)}; at most it was ${mm(g.swing_m, 3)}.`;
      if (g.up_mm < 7) return [`${swing} Now let go.`, seen];
      return [option ? `The key is up, the pedal is down. ${swing}` : `The key is up, and the damper lies on the string. ${swing}${seen ? "" : " Now with the pedal."}`, seen];
    },
  },
  again: {
    ...TWICE, setups: [{ ...GRAND, edit: simple }],
    outcome: (now) => {
      const { press: g } = now;
      if (!going(now) || g.presses < 2) return first(now, "");
      return g.impacts < g.presses ? [`${twice(now)} The jack stood in front of the knuckle, and pushed nothing.`, true] : [`${twice(now)} That was far enough for the jack. Now try it with less.`, false];
    },
  },
  erard: {
    ...TWICE, setups: [GRAND],
    outcome: (now) => {
      const { press: g } = now;
      if (!going(now) || g.presses < 2) return first(now, ", and the lever has raised the hammer");
      return g.impacts >= g.presses && g.released_mm < 6.5 ? [`${twice(now)} The jack was back under the knuckle in time.`, true] : [`${twice(now)} ${g.impacts < g.presses ? "A press was too soft, or came before the jack was back." : "Now try it with less."}`, false];
    },
  },
  touch: {
    setups: [GRAND], wide: WHOLE, narrow: WHOLE, slow: NEAR, press_n: 12, plot: true,
    show: ramp(4, 9.8),
    facts: (now) => [KEY(now), ["finger", `${fixed(now.pose.finger_force_n * 101.97, 0)} g`]],
    outcome: (now) => {
      const { press: g } = now;
      if (!going(now)) return WAITING;
      if (g.impacts) return [`That was fast: up to ${fixed(g.hardest_n, 1)} N, as ${fixed(g.hardest_n * 101.97, 0)} grams weigh. The hammer struck at ${fixed(g.hammer_speed_m_per_s, 1)} m/s.`, false];
      return g.deepest_mm < 9 ? [`At this depth the finger carries ${fixed(now.pose.finger_force_n * 101.97, 0)} grams.`, false] : ["Slow enough: the hammer did not even strike. The curve shows the damper halfway, then the notch.", true];
    },
  },
};
