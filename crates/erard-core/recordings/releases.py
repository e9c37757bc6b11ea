"""Lists the releases of kawai-kg-3c-releases-raw.csv: `python releases.py [FOLDER]` writes kawai-kg-3c-releases.csv and
kawai-kg-3c-let-go.csv here, or there. Needs NumPy.

Source, calibration and what is estimated: README.md beside this file.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

HERE = Path(__file__).parent
#: What the converter read less an offset, over a gain, at marks of 1/32 inch at the key's front: the author's table.
OFFSET, GAIN = 0.3, 0.58
READ = np.array([0.0064, 0.0115, 0.0165, 0.0260, 0.0365, 0.0570, 0.0810, 0.1450, 0.2250, 0.3650, 0.5700, 0.8100, 1.0])
MARKS_MM = np.arange(3, 16) / 32 * 25.4
#: The key, mm, over the logarithm of its reading: a smooth curve through the marks, for their own irregularity makes
#: local speeds wrong by a quarter.
CURVE = np.polynomial.Polynomial.fit(np.log(READ), MARKS_MM, 3)
#: The first millimetres, which the sensor hardly sees: reading and mm, from the slow press of the file with two
#: sensors, head over kinematic ratio. The first is what it reads at rest.
FIRST = np.array([[0.0017, 0], [0.0025, 0.5], [0.003, 0.9], [0.004, 1.5], [0.0058, 2.2], [0.0089, 3.0]])
#: Means of so many samples.
MEAN = 3
#: The key has left where it was held when it is so far above its bottom, mm, is home when it is so far below its rest,
#: mm, and a release that takes longer, s, is a finger that leads the key up.
BOTTOM_MM, LEFT_MM, HOME_MM, LONGEST_S = 11.8, 1.0, 0.5, 0.06
#: A key that comes back farther than this, mm, was pressed again.
PRESSED_MM = 5.0
#: Releases in which the finger slid off a key that it had held for a third of a second or longer, so that the key was
#: alone. The author's description names them: the fastest of the damper's file, and events 4 and 16 of the file with
#: two sensors, which are 100 more here. In all others the finger goes up with the key, or may.
LET_GO = (1, 3, 19, 41, 104, 116)
#: Numbers above are events of the file with two sensors, plus this.
OTHER_FILE = 100
#: Way over which the speed upward is taken, mm below rest.
SPEED_MM = (9.0, 4.0)
#: A hump lies above the first of these and reaches the second, mm: the sensor is known to 0.2 mm there. The time of its
#: top is the middle of the time that it spends within the third of its largest. Humps that begin later than this after
#: the key has landed, s, belong to the next press.
HUMP_MM, TOP_MM, FLAT_MM, HUMPS_S = 0.2, 0.3, 0.1, 0.05
#: The travel of a key that was let go is written from here to there, ms after it has landed.
TRAVEL_MS = (-30.0, 70.0)


def place_mm(raw: np.ndarray) -> np.ndarray:
    """The key at its front, mm below its rest."""
    read = (raw - OFFSET) / GAIN
    join = FIRST[-1]
    return np.where(read < join[0], np.interp(read, *FIRST.T), CURVE(np.log(np.maximum(read, join[0]))))


def release(time_s: np.ndarray, key_mm: np.ndarray) -> tuple[float, float] | None:
    """Time home, ms, and rebound, mm; nothing where the key was led up or pressed again."""
    down = np.flatnonzero(key_mm >= BOTTOM_MM - LEFT_MM)
    if not len(down):
        return None
    left = down[-1] + 1
    home = left + np.flatnonzero(key_mm[left:] < HOME_MM)
    if not len(home) or time_s[home[0]] - time_s[left] > LONGEST_S:
        return None
    back = key_mm[home[0] :]
    away = np.flatnonzero(back >= HOME_MM)
    again = np.flatnonzero(back[away[0] :] < HOME_MM) if len(away) else away
    if not len(again):
        return None
    rebound_mm = float(back[away[0] :][: again[0]].max())
    return None if rebound_mm > PRESSED_MM else (1e3 * (time_s[home[0]] - time_s[left]), rebound_mm)


def speed_m_per_s(time_s: np.ndarray, key_mm: np.ndarray) -> float:
    """Speed of the key upward, from its last leaving the lower end of SPEED_MM to its first reaching the upper one."""
    left = np.flatnonzero(key_mm >= SPEED_MM[0])[-1] + 1
    up = left + np.flatnonzero(key_mm[left:] < SPEED_MM[1])[0]
    instants = [
        time_s[row - 1] + (key_mm[row - 1] - at) / (key_mm[row - 1] - key_mm[row]) * (time_s[row] - time_s[row - 1])
        for row, at in zip((left, up), SPEED_MM, strict=True)
    ]
    return (SPEED_MM[0] - SPEED_MM[1]) / 1e3 / (instants[1] - instants[0])


def landed(key_mm: np.ndarray) -> int:
    """The row in which the key is home for the first time after it has left where it was held."""
    left = np.flatnonzero(key_mm >= BOTTOM_MM - LEFT_MM)[-1] + 1
    return int(left + np.flatnonzero(key_mm[left:] < HOME_MM)[0])


def humps(time_s: np.ndarray, key_mm: np.ndarray) -> list[tuple[float, float]]:
    """Time of the top, ms after the key has landed, and height, mm, of every hump; nothing where one does not end."""
    home = landed(key_mm)
    down = home + np.flatnonzero(key_mm[home:] <= HUMP_MM)[0]
    found, row = [], down
    while row < len(key_mm) and time_s[row] - time_s[home] < HUMPS_S:
        end = row
        while end < len(key_mm) and key_mm[end] > HUMP_MM:
            end += 1
        if end > row and key_mm[row:end].max() >= TOP_MM:
            if end == len(key_mm):
                return []
            flat = row + np.flatnonzero(key_mm[row:end] >= key_mm[row:end].max() - FLAT_MM)
            found.append((1e3 * ((time_s[flat[0]] + time_s[flat[-1]]) / 2 - time_s[home]), float(key_mm[row:end].max())))
        row = end + 1
    return found


def main() -> None:
    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else HERE
    raw = np.genfromtxt(HERE / "kawai-kg-3c-releases-raw.csv", delimiter=",", names=True)
    lines, counts, travels = [], {}, []
    for number in np.unique(raw["release"]):
        rows = raw[raw["release"] == number]
        key_mm = np.convolve(place_mm(rows["key"]), np.ones(MEAN) / MEAN, "valid")
        time_s = rows["time_s"][MEAN // 2 :][: len(key_mm)]
        found = release(time_s, key_mm)
        if found:
            kind = "let go" if number in LET_GO else "led up"
            # Every other one chooses, so that slow and fast releases, and early and late ones, are on both sides. Those
            # of the file with two sensors were added later, and are counted by kind.
            series = kind if number > OTHER_FILE else ""
            counts[series] = counts.get(series, 0) + 1
            role = "choose" if counts[series] % 2 else "judge"
            tops = humps(time_s, key_mm)
            cells = [f"{int(number)},{rows['time_s'][0]:.4f},{role},{kind},{found[0]:.1f},{found[1]:.2f}"]
            cells += [f"{speed_m_per_s(time_s, key_mm):.3f}", str(len(tops) or "")]
            cells += [f"{top_ms:.1f},{top_mm:.2f}" for top_ms, top_mm in tops[:2]] + [","] * (2 - len(tops[:2]))
            lines.append(",".join(cells) + "\n")
            if kind == "let go":
                time_ms = 1e3 * (time_s - time_s[landed(key_mm)])
                shown = (time_ms > TRAVEL_MS[0] - 0.1) & (time_ms < TRAVEL_MS[1] + 0.1)
                rows = zip(time_ms[shown], key_mm[shown], strict=True)
                travels += [f"{int(number)},{role},{at_ms + 0.0:.1f},{at_mm:.2f}\n" for at_ms, at_mm in rows]
    header = "release,from_s,role,kind,home_ms,rebound_mm,speed_m_per_s,humps,first_ms,first_mm,second_ms,second_mm\n"
    (folder / "kawai-kg-3c-releases.csv").write_text(header + "".join(lines))
    (folder / "kawai-kg-3c-let-go.csv").write_text("release,role,time_ms,key_mm\n" + "".join(travels))


if __name__ == "__main__":
    main()
