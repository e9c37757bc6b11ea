"""Times of hammers that come home, from kawai-kg-3c-hammers-raw.csv: `python hammers.py [FOLDER]` writes kawai-kg-3c-hammers.csv here, or there. Needs NumPy.

The sensor is not calibrated, and need not be: only instants are taken at which it reads what it reads at rest.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

HERE = Path(__file__).parent
#: The hammer rests in the last of so many rows.
REST = 50
#: A hammer that reads more than this is still up.
UP = 0.35


def crossings_s(time_s: np.ndarray, hammer: np.ndarray) -> list[float]:
    """Instants from the fall on at which the hammer passes its place of rest: in, out, in, out, in."""
    above = hammer - np.median(hammer[-REST:])
    fall = np.flatnonzero(hammer > UP)[-1]
    rows = fall + np.flatnonzero(np.diff(np.sign(above[fall:])) != 0)
    instants = time_s[rows] + above[rows] / (above[rows] - above[rows + 1]) * (time_s[rows + 1] - time_s[rows])
    return [float(one) for one in instants[:5]]


def main() -> None:
    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else HERE
    raw = np.genfromtxt(HERE / "kawai-kg-3c-hammers-raw.csv", delimiter=",", names=True, dtype=None, encoding="utf-8")
    lines = []
    for recording in dict.fromkeys(raw["recording"]):
        rows = raw[raw["recording"] == recording]
        t = crossings_s(rows["time_s"], rows["hammer"])
        times = [1e3 * (t[b] - t[a]) for a, b in ((0, 1), (1, 2), (2, 3), (3, 4))]
        lines.append(f"{recording},judge," + ",".join(f"{one:.1f}" for one in times) + "\n")
    header = "recording,role,sinks_ms,bounces_ms,sinks_again_ms,bounces_again_ms\n"
    (folder / "kawai-kg-3c-hammers.csv").write_text(header + "".join(lines))


if __name__ == "__main__":
    main()
