"""Lists the releases of kawai-kg-3c-releases-raw.csv: `python releases.py [FOLDER]` writes kawai-kg-3c-releases.csv here, or there. Needs NumPy.

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


def main() -> None:
    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else HERE
    raw = np.genfromtxt(HERE / "kawai-kg-3c-releases-raw.csv", delimiter=",", names=True)
    lines = []
    for number in np.unique(raw["release"]):
        rows = raw[raw["release"] == number]
        key_mm = np.convolve(place_mm(rows["key"]), np.ones(MEAN) / MEAN, "valid")
        found = release(rows["time_s"][MEAN // 2 :][: len(key_mm)], key_mm)
        if found:
            # Every other one chooses, so that slow and fast releases, and early and late ones, are on both sides.
            role = "choose" if len(lines) % 2 == 0 else "judge"
            lines.append(f"{int(number)},{rows['time_s'][0]:.4f},{role},{found[0]:.1f},{found[1]:.2f}\n")
    (folder / "kawai-kg-3c-releases.csv").write_text("release,from_s,role,home_ms,rebound_mm\n" + "".join(lines))


if __name__ == "__main__":
    main()
