"""Missed and false notes and errors of speed of keys with contacts and of sensed hammers: the tables of docs/notes/live.md.

    python benchmarks/boards.py --erard COMMAND [--quick] [--out FOLDER]

`erard scan` plays its cases on two grands (`concert-grand:sample=1` and `2`) whose keys differ by what a technician leaves, and gives where each key is
8000 times a second, and what sensors at the hammers' shanks read. Contacts are scanned here, as a keybed does: at a period, from four phases, at
instants that are not quite its own (the jitter, unknown to the stamps), and with contacts that bounce. Then `erard live` plays the edges with the table
that `erard calibrate` makes of the file's own grand, which is neither of the two. It takes NumPy.
"""

from __future__ import annotations

import argparse
import os
import subprocess
from collections.abc import Iterable
from concurrent.futures import ThreadPoolExecutor
from itertools import product
from pathlib import Path

import numpy as np
from sensors import PP_M_PER_S, judge

GRANDS = (1, 2)
#: How finely the keys' motions are known.
FINE = ("--bits", "20", "--rate", "8000", "--noise", "0")
#: Depths of the contacts, mm.
CONTACTS = ("3,6.5", "3,8.5", "3,5,8.5")
#: Scan period, us; jitter, a share of the period; longest bounce of a contact, ms.
SCANS = ((4000, 0, 0), (1000, 0, 0), (250, 0, 0), (1000, 0.5, 0), (1000, 0, 2), (1000, 0.5, 2), (250, 0.5, 2))
PHASES = (0.0, 0.25, 0.5, 0.75)
BITS, RATES, NOISES = (8, 12), (1000, 4000), (0.02, 0.2)
#: Groups of cases: strokes from rest, from half-way, and what gives no note.
GROUPS = {
    "plain strokes": ("stroke", "staccato", "slow-release"),
    "half-way": ("repress", "shallow-repress", "trembling"),
    "trill": ("trill",),
    "bobbling": ("bobbling",),
    "silent, half strokes": ("silent-press", "half-stroke"),
}


def ran(command: list[str]) -> None:
    """Runs a command, which says nothing unless it fails."""
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode != 0:
        raise SystemExit(f"{' '.join(command)}: {done.stderr}")


def scanned(erard: str, folder: Path, grand: int, arguments: list[str]) -> judge.DataSet:
    """A data set of the cases on a grand, made if it is not there."""
    if not (folder / "scan.json").exists():
        ran([erard, "scan", "--cases", "--keyboard", f"concert-grand:sample={grand}", "--seed", str(grand), *arguments, "--out", str(folder)])
    return judge.DataSet(folder)


def played(erard: str, stream: Path, profile: Path) -> judge.Notes:
    """The notes of `erard live`."""
    # A folder each: the commands run side by side.
    notes = stream.with_suffix("") / "notes.csv"
    notes.parent.mkdir(exist_ok=True)
    ran([erard, "live", str(stream), "--calibration", str(profile), "--keyboard", "concert-grand", "--out-file", str(notes), "--force", "--quiet"])
    return judge.Notes.read(notes)


def bouncing(times_s: np.ndarray, longest_s: float, rng: np.random.Generator) -> np.ndarray:
    """Instants at which a contact changes, with up to four bounces after each of its edges, none beyond the next edge."""
    all_s = []
    for at_s, next_s in zip(times_s, [*times_s[1:], np.inf], strict=True):
        all_s.append(at_s)
        until_s = min(rng.uniform(0, longest_s), 0.9 * (next_s - at_s))
        all_s += sorted(at_s + rng.uniform(0, until_s, 2 * int(rng.integers(1, 5))))
    return np.array(all_s)


Motions = list[tuple[int, np.ndarray, np.ndarray]]


def crossings(t: np.ndarray, x: np.ndarray, depth_mm: float) -> np.ndarray:
    """Instants at which a key passes a depth, first down, then up, and so on."""
    below = np.concatenate([[False], x >= depth_mm, [False]])
    changes = np.flatnonzero(below[1:] != below[:-1])
    times, places = np.concatenate([t[:1], t, t[-1:]]), np.concatenate([[0.0], x, [0.0]])
    way = places[changes + 1] - places[changes]
    return times[changes] + (times[changes + 1] - times[changes]) * (depth_mm - places[changes]) / np.where(way == 0.0, 1.0, way)


def keybed(motions: Motions, to: Path, depths_mm: list[float], period_us: float, jitter: float, bounce_ms: float, phase: float) -> None:
    """Writes the edges that a keybed sends of keys' motions."""
    rng = np.random.default_rng(1)
    period_s, sent = 1e-6 * period_us, []
    for (key, t, x), (contact, depth_mm) in product(motions, enumerate(depths_mm, start=1)):
        times_s = crossings(t, x, depth_mm)
        changes_s = bouncing(times_s, 1e-3 * bounce_ms, rng) if bounce_ms else times_s
        # Only scans near a change can see it; the keys are scanned one after the other.
        first = (phase + key / 88) % 1.0
        near = np.unique(np.floor(changes_s / period_s - first).astype(int)[:, None] + np.arange(-1, 4))
        stamps_s = (near + first) * period_s
        looks_s = stamps_s + period_s * jitter * rng.uniform(-0.5, 0.5, len(near))
        made = np.searchsorted(changes_s, looks_s, side="right") % 2 == 1
        before = False
        for at_s, now in zip(stamps_s, made, strict=True):
            if now != before:
                sent.append((at_s, f"{1e6 * at_s:.0f},{key},{contact},{'made' if now else 'open'}"))
                before = now
    to.write_text("\n".join(["time_us,key,contact,state", *(line for _, line in sorted(sent))]) + "\n")


def cells(told: Iterable[tuple[judge.DataSet, judge.Score]]) -> dict[str, str]:
    """Missed and false notes and the error from pp on, by group, over data sets."""
    told, found = list(told), {}
    for group, cases in GROUPS.items():
        strikes, missed, false, errors = 0, 0, 0, []
        for data, score in told:
            of_true, of_found = (np.isin(data.cases(notes), cases) for notes in (score.true, score.found))
            loud = score.true.hammer_speed_m_per_s[score.pairs[:, 0]] >= PP_M_PER_S
            own = of_true[score.pairs[:, 0]]
            errors.append(score.velocity_error[own & loud])
            strikes += int(np.count_nonzero(own)) + int(np.count_nonzero(of_true[score.missing]))
            missed += int(np.count_nonzero(of_true[score.missing]))
            false += int(np.count_nonzero(of_found[np.concatenate([score.surplus, score.double])]))
        all_errors = np.concatenate(errors)
        rms = f"{np.sqrt(np.mean(all_errors**2)):.1f}" if len(all_errors) else "-"
        found[f"{group} ({strikes})"] = f"{missed}, {false}, {rms}"
    return found


def table(heads: list[str], rows: list[tuple[list[str], dict[str, str]]]) -> str:
    """A table of cells, whose groups are its columns."""
    groups = list(rows[0][1])
    lines = ["| " + " | ".join([*heads, *groups]) + " |", "|---" * (len(heads) + len(groups)) + "|"]
    return "\n".join([*lines, *("| " + " | ".join([*own, *of.values()]) + " |" for own, of in rows)])


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--erard", default="erard", help="the command")
    parser.add_argument("--quick", action="store_true", help="one grand, two contacts and two scans, no hammers")
    parser.add_argument("--out", type=Path, default=Path("erard-out-boards"), help="folder of the data sets; those that are there are used again")
    asked = parser.parse_args()
    asked.out.mkdir(parents=True, exist_ok=True)
    grands, contacts, scans = (GRANDS[:1], CONTACTS[:1], SCANS[1:6:4]) if asked.quick else (GRANDS, CONTACTS, SCANS)

    keys = {grand: scanned(asked.erard, asked.out / f"keys-{grand}", grand, list(FINE)) for grand in grands}
    motions = {grand: list(data.scans[0].keys()) for grand, data in keys.items()}

    def of_contacts(one: tuple[str, tuple[float, float, float]]) -> tuple[list[str], dict[str, str]]:
        depths, (period_us, jitter, bounce_ms) = one
        profile = asked.out / f"contacts-{depths}-{period_us}.toml"
        told = []
        for grand, phase in product(grands, PHASES):
            stream = asked.out / f"contacts-{depths}-{grand}-{period_us}-{jitter}-{bounce_ms}-{phase}.csv"
            keybed(motions[grand], stream, [float(depth) for depth in depths.split(",")], period_us, jitter, bounce_ms, phase)
            told.append((keys[grand], judge.compare(keys[grand].truth, played(asked.erard, stream, profile))))
        return [depths.replace(",", ", "), f"{period_us}", f"{100 * jitter:g}", f"{bounce_ms:g}"], cells(told)

    for depths, period_us in product(contacts, sorted({scan[0] for scan in scans})):
        profile = asked.out / f"contacts-{depths}-{period_us}.toml"
        ran([asked.erard, "calibrate", "--contacts", depths, "--scan-period", str(period_us), "--bounce", "0.002", "--out-file", str(profile), "--force"])
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        rows = list(pool.map(of_contacts, [(depths, scan) for depths in contacts for scan in scans]))
    print(table(["contacts, mm", "scan, us", "jitter, %", "bounces, ms"], rows))
    if asked.quick:
        return
    sensors = ["--hammers", *(word for name, values in (("bits", BITS), ("rate", RATES), ("noise", NOISES)) for word in (f"--{name}", ",".join(map(str, values))))]
    hammers = [scanned(asked.erard, asked.out / f"hammers-{grand}", grand, sensors) for grand in grands]

    def of_hammers(index: int) -> tuple[list[str], dict[str, str]]:
        own = [(data, data.scans[index]) for data in hammers]
        told = [(data, judge.compare(data.truth, played(asked.erard, scan.path, scan.profile))) for data, scan in own]
        scan = own[0][1]
        return [f"{scan.bits}", f"{scan.rate_hz:g}", f"{scan.noise_percent:g}"], cells(told)

    with ThreadPoolExecutor(os.cpu_count()) as pool:
        rows = list(pool.map(of_hammers, range(len(hammers[0].scans))))
    print()
    print(table(["bits", "rate, Hz", "noise, %"], rows))


if __name__ == "__main__":
    main()
