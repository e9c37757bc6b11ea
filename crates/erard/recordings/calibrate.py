"""Makes the kawai-kg-3c strokes in mm of what was read: `python calibrate.py [FOLDER]` writes them here, or there. Needs NumPy and SciPy.

Source and what is estimated: README.md beside this file.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
from scipy.interpolate import PchipInterpolator

HERE = Path(__file__).parent
MM_PER_INCH = 25.4
#: What the converter read less an offset, over a gain, at marks of a ruler: the author's tables. Key: 1/32 inch at its
#: front; hammer: 1/64 inch at its shank.
KEY_OFFSET, KEY_GAIN = 0.3, 0.58
KEY_READ = [0, 0.0015, 0.0035, 0.0064, 0.0115, 0.0165, 0.0260, 0.0365, 0.0570, 0.0810, 0.1450, 0.2250, 0.3650, 0.5700, 0.8100, 1.0]
KEY_MM = np.arange(16) / 32 * MM_PER_INCH
HAMMER_OFFSET, HAMMER_GAIN = 0.69, 0.29
HAMMER_READ = [0, 0.015, 0.04, 0.11, 0.17, 0.28, 0.39, 0.57, 0.75, 0.9, 1.0]
SHANK_MM = np.array([*range(10), 9.5]) / 64 * MM_PER_INCH
#: The head's whole way, mm, which the author gives as about two inches, and the shank's, mm: from the first mark to
#: where all his strokes turn round.
BLOW_MM, SHANK_WAY_MM = 2 * MM_PER_INCH, 3.78
#: Below, mm, the sensors hardly see anything: what they read at rest counts as 0, and what lies between is spread
#: evenly.
KEY_SEEN_MM, HAMMER_SEEN_MM = 2.0, 6.0
#: A stroke begins with so much rest, s.
REST_S = 0.1
#: Where each stroke was read, and how much of it is made, s.
STROKES = {"slow": ("raw", 10), "medium": ("raw", 10), "fast": ("raw", 10), "repeated": ("judge-raw", 0.6)}


def position(read: np.ndarray, table: list[float], marks_mm: np.ndarray) -> np.ndarray:
    """A sensor's reading as a place on the ruler, mm: through the table's points, monotone between them, straight on beyond."""
    curve = PchipInterpolator(table, marks_mm)
    slope = curve.derivative()
    inside = np.clip(read, table[0], table[-1])
    return curve(inside) + (read - inside) * slope(inside)


def from_rest(place_mm: np.ndarray, rest: np.ndarray, seen_mm: float) -> np.ndarray:
    """Way from the rest, mm, of places that are right from `seen_mm` on."""
    rest_mm = np.median(place_mm[rest])
    return np.where(place_mm < seen_mm, (place_mm - rest_mm) * seen_mm / (seen_mm - rest_mm), place_mm)


def main() -> None:
    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else HERE
    for stroke, (file, until_s) in STROKES.items():
        raw = np.genfromtxt(HERE / f"kawai-kg-3c-{file}.csv", delimiter=",", names=True, dtype=None, encoding="utf-8")
        rows = raw[raw["stroke"] == stroke]
        time_s = rows["time_s"] - rows["time_s"][0]
        rows, time_s = rows[time_s < until_s], time_s[time_s < until_s]
        key_mm = position((rows["key"] - KEY_OFFSET) / KEY_GAIN, KEY_READ, KEY_MM)
        shank_mm = position((rows["hammer"] - HAMMER_OFFSET) / HAMMER_GAIN, HAMMER_READ, SHANK_MM)
        rest = time_s < REST_S
        key_mm = from_rest(key_mm, rest, KEY_SEEN_MM)
        hammer_mm = from_rest(shank_mm * BLOW_MM / SHANK_WAY_MM, rest, HAMMER_SEEN_MM)
        lines = [f"{t:.4f},{k:.3f},{h:.2f}\n" for t, k, h in zip(time_s, key_mm, hammer_mm, strict=True)]
        (folder / f"kawai-kg-3c-{stroke}.csv").write_text("time_s,key_mm,hammer_head_mm\n" + "".join(lines))


if __name__ == "__main__":
    main()
