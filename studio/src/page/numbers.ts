// The numbers of a press beside the action.
import type { App } from "./app";
import { byId, fixed, h, say } from "./dom";
import type { Events, Pose } from "../engine/protocol";
import { type Label, named } from "./terms";

interface Line {
  name: Label;
  title: string;
  unit: string;
  of(events: Events, pose: Pose, hammer_speed_m_per_s: number | undefined): string;
}

const ms = (value: number): string => (Number.isFinite(value) ? fixed(1e3 * value, 1) : "\u2013");
const LINES: Line[] = [
  { name: "number.hammer-speed", title: "of the strike point at the first impact of the last press", unit: "m/s", of: (_, __, speed) => fixed(speed, 2) },
  { name: "number.impacts", title: "of the hammer on the string since the press began", unit: "", of: (e) => String(e.impact_count) },
  { name: "number.last-push", title: "on the knuckle, from the key's start", unit: "ms", of: (e) => ms(e.let_off_s - e.key_start_s) },
  { name: "number.free-flight", title: "from the last push to the string", unit: "ms", of: (e) => ms(e.free_flight_s) },
  { name: "number.key-bottom", title: "positive: the hammer strikes before the key is down", unit: "ms", of: (e) => ms(e.key_bottom_after_impact_s) },
  { name: "number.check", title: "the back check catches the hammer, from the impact", unit: "ms", of: (e) => ms(e.check_s - e.hammer_contact_s) },
  { name: "number.key", title: "travel of the key's front now", unit: "mm", of: (_, pose) => fixed(1e3 * pose.key_m, 2) },
  { name: "number.finger", title: "its force now", unit: "N", of: (_, pose) => fixed(pose.finger_force_n, 2) },
];

const SOFT = "Too soft to sound: the hammer was let off and fell back before it reached the string. Press faster.";

export const numbers = (app: App, into: HTMLElement): void => {
  const cells = LINES.map((line) => {
    const value = h("dd");
    into.append(h("div", { title: line.title }, named(h("dt"), line.name), value));
    return value;
  });
  // A press that went all the way and did not sound is no fault of the page, which says so.
  const soft = byId("soft");
  app.onframe.push(({ events: [first] }) => {
    const silent = first !== undefined && Number.isFinite(first.toe_contact_s) && Number.isFinite(first.key_bottom_s) && !Number.isFinite(first.hammer_contact_s);
    if (soft.hidden === !silent) return;
    soft.hidden = !silent;
    soft.textContent = silent ? SOFT : "";
    if (silent) say(SOFT);
  });
  app.onframe.push(({ events, poses }) => {
    into.classList.toggle("pair", poses.length > 1);
    LINES.forEach((line, index) => {
      const each = poses.map((pose, which) => line.of(events[which]!, pose, app.hammerSpeedOf(which)));
      const text = `${each.join(" | ")} ${line.unit}`.trim();
      if (cells[index]!.textContent !== text) cells[index]!.textContent = text;
    });
  });
};
