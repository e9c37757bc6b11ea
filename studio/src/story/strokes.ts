// Strokes that a figure plays by itself, and what is counted of a press. No page and no engine here.

/** From place to place of the key's front, s and mm, on half a cosine each, a row every millisecond: a curve through
 * few
 * points would overshoot. */
export const path = (...through: [number, number][]): string => {
  const rows = ["time_s,position_m"];
  for (let n = 0; n <= 1000 * through.at(-1)![0]; n++) {
    const time = n / 1000, next = Math.max(through.findIndex(([at]) => at >= time), 1);
    const [from, start] = through[next - 1]!, [to, end] = through[next]!;
    const down = start + (end - start) * (0.5 - 0.5 * Math.cos((Math.PI * (time - from)) / (to - from)));
    rows.push(`${time.toFixed(3)},${(down / 1000).toFixed(10)}`);
  }
  return rows.join("\n");
};

/** A force that is on the key within 12 ms, and for so long, N and s. */
export const weight = (newton: number, seconds: number): string => `time_s,force_N\n0,0\n0.012,${newton}\n${seconds},${newton}\n${seconds + 0.01},0\n${seconds + 0.3},0`;

/** Down at a steady pace: a press as slow as a scale's. */
export const ramp = (seconds: number, mm: number): string => {
  const rows = ["time_s,position_m"];
  for (let n = 0; n <= 200; n++) rows.push(`${((n / 200) * seconds).toFixed(4)},${((Math.max(n - 4, 0) / 196) * 1e-3 * mm).toFixed(8)}`);
  return rows.join("\n");
};

/** Where the key counts as down, mm of its front's travel. */
const DOWN_MM = 8.6;
/** How far it comes up at least, so that going down again is another press, mm. */
const AGAIN_MM = 1.5;

/** What has happened since the key left its rest. */
export class Press {
  /** How often the key went down, and how far it came up before it last did, mm. */
  presses = 0;
  released_mm = 0;
  impacts = 0;
  hammer_speed_m_per_s = 0;
  first_impact_s = NaN;
  last_impact_s = NaN;
  /** The largest swing of the string, m, and the swing half a second after the first impact. */
  swing_m = 0;
  later_m = NaN;
  deepest_mm = 0;
  highest_mm = 0;
  hardest_n = 0;
  private least_mm = 0;
  private down = false;

  /** The key's front now, mm, and what else a frame says. */
  see(now: { time_s: number; key_mm: number; hammer_mm: number; finger_force_n: number; swing_m: number; impacts: { time_s: number; hammer_speed_m_per_s: number }[] }): void {
    for (const { time_s, hammer_speed_m_per_s } of now.impacts) {
      if (!this.impacts) {
        this.first_impact_s = time_s;
        this.hammer_speed_m_per_s = hammer_speed_m_per_s;
      }
      this.impacts += 1;
      this.last_impact_s = time_s;
    }
    const { key_mm } = now;
    this.deepest_mm = Math.max(this.deepest_mm, key_mm);
    this.highest_mm = Math.max(this.highest_mm, now.hammer_mm);
    this.hardest_n = Math.max(this.hardest_n, now.finger_force_n);
    this.swing_m = Math.max(this.swing_m, now.swing_m);
    if (Number.isNaN(this.later_m) && now.time_s > this.first_impact_s + 0.5) this.later_m = now.swing_m;
    this.least_mm = Math.min(this.least_mm, key_mm);
    if (!this.down && key_mm > DOWN_MM) {
      this.down = true;
      this.presses += 1;
      if (this.presses > 1) this.released_mm = 9.4 - this.least_mm;
      this.least_mm = key_mm;
    } else if (this.down && key_mm < DOWN_MM - AGAIN_MM) this.down = false;
  }

  /** How far the key has come up since it was last down, mm. */
  get up_mm(): number {
    return this.presses && !this.down ? 9.4 - this.least_mm : 0;
  }
}
