// What one needs to know of each part of a grand's action, by its name in the drawing: what it is for, the contacts
// that it is part of, what one turns of it, and which way it is turned by hand. The numbers are the engine's.

export interface PartText {
  does: string;
  /** Zones of the file that end on it; a moving part that names none has all of its body's. */
  zones?: string[];
  /** Dials that change it. */
  dials?: string[];
  /** What dragging it turns: a dial in mm, and what of the hand's way counts for it, to the right and up. */
  drag?: { dial: string; along: [number, number] };
}

const UP: [number, number] = [0, 1], DOWN: [number, number] = [0, -1], LEFT: [number, number] = [-1, 0], RIGHT: [number, number] = [1, 0];

export const PARTS: Record<string, PartText> = {
  "key frame": { does: "Carries the key on its balance rail, and ends its way at the front and at the back.", zones: [] },
  "front punching": {
    does: "Felt that stops the key: it sets the dip. Thicker is less dip, and less aftertouch.",
    zones: ["key_front"], dials: ["front_punching", "front_felt"], drag: { dial: "front_punching", along: UP },
  },
  "balance rail": { does: "The key turns on its pin, a little more than half-way to the back.", zones: [] },
  "back rail cloth": {
    does: "The key's back rests here: it sets how high the key's front stands.",
    zones: ["key_back_rail"], dials: ["back_rail_cloth"], drag: { dial: "back_rail_cloth", along: UP },
  },
  string: {
    does: "The hammer strikes it and is thrown back. Its height above the resting hammer is the blow distance.",
    zones: ["string"], dials: ["string_height"], drag: { dial: "string_height", along: UP },
  },
  "damper stop rail": { does: "Stops the damper's lever, so that the damper does not fly on after a loud note.", zones: ["damper_stop"] },
  "hammer rail": { does: "Carries the hammers' flanges, and below it the let-off buttons.", zones: [] },
  "let-off button": {
    does: "Stops the jack's toe: the jack tips out from under the knuckle, and the hammer flies on alone. Higher is closer to the string.",
    zones: ["let_off_button"], dials: ["let_off"], drag: { dial: "let_off", along: UP },
  },
  "whippen rail": { does: "Carries the whippens' flanges.", dials: ["spread"], zones: [] },
  key: {
    does: "Drag it down: the pointer is the far end of a soft fingertip. It bends at its balance pin under a hard press.",
    zones: ["key_front", "key_back_rail", "capstan_heel", "key_damper"], dials: ["leads", "key_bending", "pivots"],
  },
  "key lead": { does: "Lead that makes up for the hammer's weight: it lightens the touch, and adds inertia.", zones: [], dials: ["leads"] },
  capstan: {
    does: "Lifts the whippen by its heel. Higher is a higher hammer line, and a shorter blow distance; further back is a shorter lever.",
    zones: ["capstan_heel"], dials: ["capstan_height", "capstan"], drag: { dial: "capstan_height", along: UP },
  },
  damper: { does: "Lies on the string and keeps it still; the key lifts it half-way down.", zones: ["damper_rest", "damper_left", "damper_right"] },
  "damper lever": {
    does: "The key's end lifts it, and with it the damper.",
    zones: ["key_damper", "damper_rest", "damper_stop", "damper_tray"], dials: ["damper_timing"], drag: { dial: "damper_timing", along: UP },
  },
  "back check": {
    does: "Catches the hammer's tail after the impact, by felt and leather that hold by friction.",
    zones: ["check"], dials: ["back_check", "back_check_angle", "check_felt"], drag: { dial: "back_check", along: LEFT },
  },
  whippen: { does: "The lever between key and hammer: it carries the jack and the repetition lever.", dials: ["spread", "repetition_spring"] },
  "heel cushion": { does: "Cloth under the whippen that the capstan lifts.", zones: ["capstan_heel"] },
  "repetition lever": {
    does: "Holds the hammer up by its knuckle after the check lets go, so that the jack slips back under it: the double escapement.",
    dials: ["repetition_spring", "lever_height"], drag: { dial: "lever_height", along: UP },
  },
  jack: {
    does: "Pushes the hammer up by its knuckle until its toe meets the let-off button.",
    dials: ["jack_position", "jack_spring", "knuckle_friction"], drag: { dial: "jack_position", along: RIGHT },
  },
  knuckle: {
    does: "Leather and cloth on the shank that the jack pushes. Closer to the hammer's centre the hammer is faster, and heavier at the key.",
    zones: ["jack_knuckle", "lever_knuckle"], dials: ["knuckle", "knuckle_felt", "knuckle_friction"], drag: { dial: "knuckle", along: RIGHT },
  },
  "hammer flange": { does: "The hammer turns about its pin.", dials: ["spread", "pivots"], zones: [] },
  "drop screw": {
    does: "Stops the repetition lever just before the string, so that the hammer drops a little after let-off.",
    zones: ["drop_screw"], dials: ["drop"], drag: { dial: "drop", along: DOWN },
  },
  "hammer shank": { does: "Carries the hammer. It bends: at a loud note the head is behind its root by millimetres.", zones: ["jack_knuckle", "lever_knuckle", "hammer_rest"], dials: ["shank_bending", "knuckle"] },
  "hammer felt": { does: "Wool, stiffer the more it is pressed: a loud note is brighter.", zones: ["string"], dials: ["hammer_felt", "string_height"] },
  "hammer moulding": { does: "The hammer's wood, with the tail that the back check catches. Each gram of it weighs five to six grams at the key.", zones: ["string", "check"], dials: ["hammer"] },
  finger: { does: "A spring and a damper that only push. The Play panel sets how firm it is.", zones: [] },
};

/** `hammer moulding, tail` is a detail of the `hammer moulding`. */
export const mainPart = (name: string): string => name.split(",")[0]!.trim();
