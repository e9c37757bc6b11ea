"""Makes the kawai-kg-3c strokes in mm of what was read: `python calibrate.py [FOLDER]` writes them here, or there. Needs NumPy and SciPy.

Source and what is estimated: README.md beside this file.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import releases
from scipy.interpolate import PchipInterpolator

HERE = Path(__file__).parent
MM_PER_INCH = 25.4
#: What the converter read less an offset, over a gain, at marks of 1/64 inch at the hammer's shank: the author's table.
HAMMER_OFFSET, HAMMER_GAIN = 0.69, 0.29
HAMMER_READ = np.array([0, 0.015, 0.04, 0.11, 0.17, 0.28, 0.39, 0.57, 0.75, 0.9, 1.0])
SHANK_MM = np.array([*range(10), 9.5]) / 64 * MM_PER_INCH
#: Added to the hammer's reading before its logarithm is taken: it makes a cubic fit the marks within 0.1 mm.
HAMMER_SHIFT = 0.03
#: The head's whole way, mm, which the author gives as about two inches, and the shank's, mm: from the first mark to
#: where all his strokes turn round.
BLOW_MM, SHANK_WAY_MM = 2 * MM_PER_INCH, 3.78
#: Below, mm, the sensors hardly see anything: what they read at rest counts as 0, and what lies between is spread
#: evenly.
KEY_SEEN_MM, HAMMER_SEEN_MM = 2.0, 6.0
#: The key's curve through the marks holds from this place on, mm; below, the slow press does.
KEY_MARKS_MM = 2.3
#: A stroke begins with so much rest, s.
REST_S = 0.1
#: Where each stroke was read, and how much of it is made, s.
STROKES = {"slow": ("raw", 10), "medium": ("raw", 10), "fast": ("raw", 10), "repeated": ("judge-raw", 0.6)}
STROKES |= {f"struck-{n}": ("judge-raw", 10) for n in range(1, 5)}


def key_curve() -> PchipInterpolator:
    """The key at its front, mm, over the logarithm of its reading: a cubic through the author's marks, and below them the slow press."""
    seen = np.linspace(np.log(releases.FIRST[1, 0]), 0.0, 400)
    seen = seen[releases.CURVE(seen) >= KEY_MARKS_MM]
    first = releases.FIRST[releases.FIRST[:, 1] < KEY_MARKS_MM - 0.3]
    return PchipInterpolator([*np.log(first[:, 0]), *seen], [*first[:, 1], *releases.CURVE(seen)])


def shank_mm(read: np.ndarray) -> np.ndarray:
    """The shank, mm, from the sensor's reading: a cubic in the logarithm of the shifted reading, through the author's marks; below the first mark, where a hammer sinks into its rest, straight on."""
    cubic = np.polynomial.Polynomial.fit(np.log(HAMMER_READ + HAMMER_SHIFT), SHANK_MM, 3)
    at_first, slope = np.log(HAMMER_SHIFT), cubic.deriv()(np.log(HAMMER_SHIFT)) / HAMMER_SHIFT
    return np.where(read < 0, cubic(at_first) + slope * read, cubic(np.log(np.maximum(read, 0) + HAMMER_SHIFT)))


def from_rest(place_mm: np.ndarray, rest: np.ndarray, seen_mm: float) -> np.ndarray:
    """Way from the rest, mm, of places that are right from `seen_mm` on."""
    rest_mm = np.median(place_mm[rest])
    return np.where(place_mm < seen_mm, (place_mm - rest_mm) * seen_mm / (seen_mm - rest_mm), place_mm)


def law(steps: int = 15) -> list[float]:
    """Readings of the key at even shares of its travel, from 0 at rest to 1 at the bottom: the law `cny70` of `erard calibrate`."""
    curve, rest = key_curve(), releases.FIRST[0, 0]
    logs = np.linspace(np.log(rest), 0.0, 200_001)
    read = np.exp(np.interp(np.arange(steps + 1) / steps * curve(0.0), curve(logs), logs))
    return [round(float(one), 4) for one in (read - rest) / (1 - rest)]


def main() -> None:
    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else HERE
    for stroke, (file, until_s) in STROKES.items():
        raw = np.genfromtxt(HERE / f"kawai-kg-3c-{file}.csv", delimiter=",", names=True, dtype=None, encoding="utf-8")
        rows = raw[raw["stroke"] == stroke]
        time_s = rows["time_s"] - rows["time_s"][0]
        rows, time_s = rows[time_s < until_s], time_s[time_s < until_s]
        read = np.maximum((rows["key"] - releases.OFFSET) / releases.GAIN, releases.FIRST[0, 0])
        key_mm = key_curve()(np.log(read))
        head_mm = shank_mm((rows["hammer"] - HAMMER_OFFSET) / HAMMER_GAIN) * BLOW_MM / SHANK_WAY_MM
        rest = time_s < REST_S
        key_mm = from_rest(key_mm, rest, KEY_SEEN_MM)
        hammer_mm = from_rest(head_mm, rest, HAMMER_SEEN_MM)
        lines = [f"{t:.4f},{k:.3f},{h:.2f}\n" for t, k, h in zip(time_s, key_mm, hammer_mm, strict=True)]
        (folder / f"kawai-kg-3c-{stroke}.csv").write_text("time_s,key_mm,hammer_head_mm\n" + "".join(lines))


if __name__ == "__main__":
    main()
