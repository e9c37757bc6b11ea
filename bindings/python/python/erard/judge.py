"""Judge of algorithms that turn the readings of key sensors into notes, on data sets of `erard scan`.

A data set holds the readings of sensors under the keys, and the true time and hammer speed of each strike. The judge
gives an algorithm only the readings, or reads the notes that it found, and reports missed strikes, false notes, and the
errors of speeds and times. This file needs only NumPy and can be copied out of the package; as a program it judges a
table of notes:

    erard scan pieces/hanon.mid --cases --out data
    python -m erard.judge data notes.csv                # columns key, time_s, hammer_speed_m_per_s (or velocity)
    python -m erard.judge data --algorithm slope --train nominal

Three simple algorithms are included for comparison: `TwoPoints`, `SlopeAtLetOff` and `OneDegreeHammer`.

>>> from erard import judge
>>> truth = judge.Notes([40, 40], [1.0, 2.0], [0.5, 2.0])
>>> found = judge.Notes([40, 40, 40], [1.001, 1.05, 2.0], [0.5, 0.4, 2.1])
>>> score = judge.compare(truth, found)
>>> score.matched, score.missed, score.false, score.doubled
(2, 0, 0, 1)
>>> round(float(score.speed_error[1]), 3)
0.05
"""

from __future__ import annotations

import argparse
import csv
import json
import sys
import tomllib
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    Floats = NDArray[np.float64]

#: A note found so long before or after a strike may be that strike, s. A trill of 13 Hz strikes every 77 ms.
WITHIN_S = 0.035
#: A surplus note so long after a strike that was found is a double of it, s; later it is a false one.
DOUBLED_S = 0.2
#: A hammer this slow sounds with velocity 1 or less, m/s: such strikes need not be found, and may be.
FAINT_M_PER_S = 0.25


def velocity(hammer_speed_m_per_s: ArrayLike) -> Floats:
    """Returns the MIDI velocities of hammer speeds, 52 + 25 log2(v) (Goebl's law, which `erard` uses); not limited to 0
    to 127.

    Parameters
    ----------
    hammer_speed_m_per_s : array_like
        Hammer speeds at the string, m/s.

    Returns
    -------
    ndarray of float64
    """
    return np.asarray(52.0 + 25.0 * np.log2(np.asarray(hammer_speed_m_per_s, dtype=np.float64)))


def speed(velocities: ArrayLike) -> Floats:
    """Returns the hammer speeds of MIDI velocities, m/s: the inverse of `velocity`.

    Parameters
    ----------
    velocities : array_like
        MIDI velocities, which may have fractions.

    Returns
    -------
    ndarray of float64
    """
    return np.asarray(2.0 ** ((np.asarray(velocities, dtype=np.float64) - 52.0) / 25.0))


class Notes:
    """Notes, in the order of time.

    Parameters
    ----------
    key : array_like of int
        Keys, from 1 (A0) to 88.
    time_s : array_like
        Time of each impact on the string, s, on the clock of the readings.
    hammer_speed_m_per_s : array_like
        Hammer speeds at the string, m/s, positive.
    optional : array_like of bool, optional
        Flags true strikes that need not be found, such as bounces of a hammer. Strikes slower than `FAINT_M_PER_S` need
        not be found either.

    Raises
    ------
    ValueError
        If the columns differ in length, or a number is not finite, not positive or not a key.
    """

    def __init__(self, key: ArrayLike, time_s: ArrayLike, hammer_speed_m_per_s: ArrayLike, optional: ArrayLike | None = None) -> None:
        keys, times, speeds = (np.atleast_1d(np.asarray(column, dtype=np.float64)) for column in (key, time_s, hammer_speed_m_per_s))
        free = np.zeros(len(keys), dtype=bool) if optional is None else np.atleast_1d(np.asarray(optional, dtype=bool))
        if not len(keys) == len(times) == len(speeds) == len(free):
            raise ValueError(f"key, time_s and hammer_speed_m_per_s have {len(keys)}, {len(times)} and {len(speeds)} numbers; expected as many of each")
        sound = np.isfinite(keys) & np.isfinite(times) & np.isfinite(speeds) & (speeds > 0) & (keys >= 1) & (keys <= 88) & (keys % 1 == 0)
        if not sound.all():
            first = int(np.flatnonzero(~sound)[0])
            found = f"key {keys[first]:g}, {times[first]:g} s, {speeds[first]:g} m/s"
            raise ValueError(f"note {first + 1}: found {found}; expected a key from 1 to 88, a finite instant and a positive speed")
        order = np.argsort(times, kind="stable")
        self.key: NDArray[np.int64] = keys[order].astype(np.int64)
        self.time_s: Floats = times[order]
        self.hammer_speed_m_per_s: Floats = speeds[order]
        self.optional: NDArray[np.bool_] = free[order]

    def __len__(self) -> int:
        return len(self.key)

    @classmethod
    def read(cls, path: str | Path, shift_s: float = 0.0) -> Notes:
        """Reads notes from a CSV or a Standard MIDI File.

        Parameters
        ----------
        path : str or Path
            A CSV with the columns `key`, `time_s`, and `hammer_speed_m_per_s` or `velocity`, as `erard live --out-file notes.csv`
            writes it; or a MIDI file (`pip install mido` reads it).
        shift_s : float, optional
            Time to add, s: the start of the file on the clock of the readings.

        Returns
        -------
        Notes

        Raises
        ------
        ValueError
            If the file cannot be read; the message names file, line and column.
        """
        path = Path(path)
        if path.suffix.lower() in (".mid", ".midi"):
            return cls._of_midi(path, shift_s)
        rows = table(path)
        heads = rows[0].keys() if rows else ()
        loud = "hammer_speed_m_per_s" if "hammer_speed_m_per_s" in heads else "velocity"
        key, time_s, by = (column(rows, name, path) for name in ("key", "time_s", loud))
        # Nothing that sounds is slower: velocity 0 is what is left of a strike below 1.
        return cls(key, time_s + shift_s, by if loud == "hammer_speed_m_per_s" else speed(by))

    @classmethod
    def _of_midi(cls, path: Path, shift_s: float) -> Notes:
        try:
            import mido
        except ModuleNotFoundError as error:
            raise ValueError(f"{path}: MIDI files are read by mido, which is not installed: pip install mido; or give a CSV") from error
        keys, times, counts, now, low = [], [], [], 0.0, 0
        try:
            for message in mido.MidiFile(path):
                now += message.time
                if message.type == "control_change" and message.control == 88:
                    low = message.value
                elif message.type in ("note_on", "note_off"):
                    if message.type == "note_on" and message.velocity > 0 and 21 <= message.note <= 108:
                        keys.append(message.note - 20)
                        times.append(now + shift_s)
                        counts.append(message.velocity + low / 128)
                    low = 0
        except (OSError, EOFError, ValueError, KeyError) as error:
            raise ValueError(f"{path}: is no MIDI file that can be read: {error}") from error
        return cls(keys, times, speed(counts))


def table(path: str | Path) -> list[dict[str, str]]:
    """Reads the rows of a CSV as dictionaries of text.

    Parameters
    ----------
    path : str or Path

    Returns
    -------
    list of dict

    Raises
    ------
    ValueError
        If the file cannot be read.
    """
    try:
        with Path(path).open(newline="", encoding="utf-8-sig") as file:
            return list(csv.DictReader(line for line in file if not line.startswith("#")))
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise ValueError(f"{path}: cannot be read: {error}") from error


def column(rows: Sequence[Mapping[str, str]], name: str, path: str | Path) -> Floats:
    """Returns a column of numbers.

    Parameters
    ----------
    rows : sequence of mapping
        Rows of `table`.
    name : str
        The column's name.
    path : str or Path
        The file, for messages.

    Returns
    -------
    ndarray of float64

    Raises
    ------
    ValueError
        If there is no such column, or a cell is not a number.
    """
    values = []
    for number, row in enumerate(rows, start=2):
        cell = row.get(name)
        if cell is None:
            raise ValueError(f"{path}: column `{name}` is missing; found {', '.join(str(head) for head in row)}")
        try:
            values.append(float(cell))
        except ValueError:
            raise ValueError(f"{path}, line {number}: {name} is `{cell}`; expected a number") from None
    return np.array(values)


@dataclass(frozen=True)
class Scan:
    """Readings of the sensors of all keys: the only data that an algorithm gets.

    Attributes
    ----------
    path : Path
        Stream of readings, as `erard live` reads it.
    profile : Path
        Readings at the keys' stops, for `erard live --calibration`.
    bits, rate_hz, noise_percent : float
        Bits of the converter, readings of each key per second, and standard deviation of the noise, % of a key's
        travel.
    """

    path: Path
    profile: Path
    bits: int
    rate_hz: float
    noise_percent: float

    def keys(self) -> Iterator[tuple[int, Floats, Floats]]:
        """Yields for each key its number, the times of its readings, s, and the travel of its front, mm, down positive.

        Returns
        -------
        iterator of tuple of int, ndarray, ndarray
            Keys at rest are not read: see `strokes`.
        """
        with self.profile.open("rb") as file:
            profile = tomllib.load(file)
        stops = {entry["number"]: (entry["rest"], entry["pressed"]) for entry in profile["key"]}
        with self.path.open() as stream:
            next(stream)
            rows = np.array([line.split(",") for line in stream if "s" not in line], dtype=np.float64).reshape(-1, 3)
        for key in np.unique(rows[:, 1]).astype(int):
            own = rows[rows[:, 1] == key]
            rest, pressed = stops[int(key)]
            yield int(key), 1e-6 * own[:, 0], profile["travel_mm"] * (own[:, 2] - rest) / (pressed - rest)


def strokes(t: Floats, x: Floats) -> Iterator[tuple[Floats, Floats]]:
    """Splits a key's readings at gaps of 50 ms or more, in which it was at rest and not read.

    Parameters
    ----------
    t, x : ndarray
        Times, s, and travel, mm, down positive, of one key.

    Returns
    -------
    iterator of tuple of ndarray, ndarray
    """
    gaps = np.flatnonzero(np.diff(t) > 0.05) + 1
    yield from zip(np.split(t, gaps), np.split(x, gaps), strict=True)


class DataSet:
    """Data set of `erard scan`.

    Parameters
    ----------
    folder : str or Path

    Attributes
    ----------
    about : dict
        Content of `scan.json`: sensors, keys, seeds, and the program that made it.
    scans : list of Scan
        Readings of the sensors.
    truth : Notes
        True strikes.

    Raises
    ------
    ValueError
        If the folder holds no data set.
    """

    def __init__(self, folder: str | Path) -> None:
        folder = Path(folder)
        try:
            self.about: dict[str, Any] = json.loads((folder / "scan.json").read_text(encoding="utf-8"))
        except (OSError, ValueError) as error:
            raise ValueError(f"{folder}: is no data set of `erard scan`: {error}") from error
        if self.about.get("format") != "erard-scan/1":
            raise ValueError(f"{folder / 'scan.json'}: format is {self.about.get('format')!r}; expected 'erard-scan/1'")
        self.scans = [
            Scan(folder / one["file"], folder / one["profile"], one["bits"], one["rate_hz"], one["noise_percent"]) for one in self.about["scans"]
        ]
        path = folder / self.about["truth"]
        rows = table(path)
        self.truth = Notes(*(column(rows, name, path) for name in ("key", "time_s", "hammer_speed_m_per_s", "again")))
        path = folder / self.about["windows"]
        rows = table(path)
        self._cases = [row["case"] for row in rows]
        self._windows = np.stack([column(rows, name, path) for name in ("key", "from_s", "to_s")], axis=1)

    def cases(self, notes: Notes) -> NDArray[np.str_]:
        """Returns the case that was played on the key of each note at its time; empty if there was none.

        Parameters
        ----------
        notes : Notes

        Returns
        -------
        ndarray of str
        """
        found = np.full(len(notes), "", dtype="U32")
        for name, (key, from_s, to_s) in zip(self._cases, self._windows, strict=True):
            found[(notes.key == key) & (notes.time_s >= from_s) & (notes.time_s < to_s)] = name
        return found


@dataclass(frozen=True)
class Score:
    """Comparison of found notes with true strikes.

    Attributes
    ----------
    true, found : Notes
        Notes that were compared.
    pairs : ndarray of int, shape (n, 2)
        Indices of matching strikes and notes, without optional strikes.
    missing, surplus, double : ndarray of int
        Indices of missed strikes, of false notes, and of double notes.
    """

    true: Notes
    found: Notes
    pairs: NDArray[np.int64]
    missing: NDArray[np.int64]
    surplus: NDArray[np.int64]
    double: NDArray[np.int64]

    @property
    def matched(self) -> int:
        """Number of strikes that were found."""
        return len(self.pairs)

    @property
    def missed(self) -> int:
        """Number of strikes that were missed."""
        return len(self.missing)

    @property
    def false(self) -> int:
        """Number of notes without a strike."""
        return len(self.surplus)

    @property
    def doubled(self) -> int:
        """Number of surplus notes shortly after a strike that was found."""
        return len(self.double)

    @property
    def speed_error(self) -> Floats:
        """Errors of the found speeds, as shares of the true ones."""
        pairs = self.pairs
        return np.asarray(self.found.hammer_speed_m_per_s[pairs[:, 1]] / self.true.hammer_speed_m_per_s[pairs[:, 0]] - 1.0)

    @property
    def velocity_error(self) -> Floats:
        """Errors of the found speeds in MIDI velocities, each 2.8 % of the speed."""
        return np.asarray(25.0 * np.log2(1.0 + self.speed_error))

    @property
    def time_error(self) -> Floats:
        """Errors of the found times, s; late is positive."""
        return np.asarray(self.found.time_s[self.pairs[:, 1]] - self.true.time_s[self.pairs[:, 0]])

    def summary(self) -> dict[str, float]:
        """Returns counts, and median, 5th and 95th percentile of each error.

        Returns
        -------
        dict of str to float
            Counts and percentiles; errors are NaN if nothing matched.
        """
        told: dict[str, float] = {"matched": self.matched, "missed": self.missed, "false": self.false, "doubled": self.doubled}
        for name, errors in (("speed_percent", 100.0 * self.speed_error), ("velocity_counts", self.velocity_error), ("time_ms", 1e3 * self.time_error)):
            values = np.percentile(errors, [5, 50, 95]) if len(errors) else np.full(3, np.nan)
            told |= {f"{name}_{which}": float(value) for which, value in zip(("p5", "median", "p95"), values, strict=True)}
        return told


def compare(true: Notes, found: Notes) -> Score:
    """Compares notes with the truth.

    Each note matches at most one strike of its key within `WITHIN_S`. The nearest in time match first, and strikes that
    must be found before those that need not (bounces, and hammers slower than `FAINT_M_PER_S`). An unmatched note is a
    double if a found strike lies within `DOUBLED_S` before it, else it is false.

    Parameters
    ----------
    true, found : Notes

    Returns
    -------
    Score
    """
    free = true.optional | (true.hammer_speed_m_per_s < FAINT_M_PER_S)
    of_true, of_found = np.full(len(true), -1), np.full(len(found), -1)
    for key in np.unique(found.key):
        ours, theirs = np.flatnonzero(true.key == key), np.flatnonzero(found.key == key)
        for wanted in (ours[~free[ours]], ours[free[ours]]):
            gaps = np.abs(true.time_s[wanted][:, None] - found.time_s[theirs][None, :])
            for index in np.argsort(gaps, axis=None, kind="stable"):
                row, col = divmod(int(index), len(theirs))
                if gaps[row, col] > WITHIN_S:
                    break
                strike, note = wanted[row], theirs[col]
                if of_true[strike] < 0 and of_found[note] < 0:
                    of_true[strike], of_found[note] = note, strike
    left = np.flatnonzero(of_found < 0)

    def is_double(note: np.int64) -> bool:
        after = found.time_s[note] - true.time_s[(true.key == found.key[note]) & (of_true >= 0)]
        return bool(((after > -WITHIN_S) & (after <= DOUBLED_S)).any())

    doubles = np.array([is_double(note) for note in left], dtype=np.bool_)
    matched = np.flatnonzero((of_true >= 0) & ~free)
    pairs = np.stack([matched, of_true[matched]], axis=1)
    return Score(true, found, pairs, np.flatnonzero((of_true < 0) & ~free), left[~doubles], left[doubles])


#: An algorithm: it gets the readings and returns notes, or tuples of key, instant (s) and hammer speed (m/s).
Algorithm = Callable[[Scan], "Notes | Iterable[tuple[int, float, float]]"]


def judge(data: DataSet, scan: Scan, algorithm: Algorithm) -> Score:
    """Runs an algorithm on readings and compares its notes with the truth, which the algorithm does not get.

    Parameters
    ----------
    data : DataSet
    scan : Scan
        A scan of the data set.
    algorithm : callable
        Function that takes a `Scan` and returns `Notes` or tuples of key, time (s) and hammer speed (m/s).

    Returns
    -------
    Score
    """
    found = algorithm(scan)
    if not isinstance(found, Notes):
        rows = np.array(list(found), dtype=np.float64).reshape(-1, 3)
        found = Notes(rows[:, 0], rows[:, 1], rows[:, 2])
    return compare(data.truth, found)


class Baseline:
    """Algorithm that measures one quantity u of a press and maps u to the hammer speed.

    The map is a parabola in logarithms, log v = a + b log u + c (log u)^2. The time of a note is d + e / u after the
    measurement. A press makes no note if its u is a tenth below the smallest u of a sounding press. `train` fits these
    coefficients to a data set, as a maker would on their own piano. A subclass finds the measurements in the readings
    of one key, smoothed by a mean over 2 ms. The default heights and ratios were chosen among a few on the built-in
    grand.
    """

    #: Readings are smoothed over this time, s.
    SMOOTH_S = 2e-3

    def __init__(self) -> None:
        self.curve: Floats = np.array([0.0, 1.0, 0.0])
        self.delay: Floats = np.zeros(2)
        self.range: tuple[float, float] = (1e-3, np.inf)

    def measure(self, t: Floats, x: Floats) -> Iterator[tuple[float, float]]:
        """Yields the measurements in the readings of one key: time, s, and u, positive.

        Parameters
        ----------
        t, x : ndarray
            Times, s, and travel of the key front, mm, beginning at rest.

        Returns
        -------
        iterator of tuple of float, float
        """
        raise NotImplementedError

    def __call__(self, scan: Scan) -> Notes:
        """Returns the notes of readings.

        Parameters
        ----------
        scan : Scan

        Returns
        -------
        Notes
        """
        key, t, u = self._measured(scan)
        sounds = u > 0.9 * self.range[0]
        key, t, u = key[sounds], t[sounds], u[sounds]
        # Beyond what it was trained on the curve goes on straight.
        inside = np.clip(u, *self.range)
        log = np.log(inside)
        slope = np.maximum(self.curve[1] + 2.0 * self.curve[2] * log, 0.1)
        v = np.exp(self.curve[0] + self.curve[1] * log + self.curve[2] * log**2 + slope * (np.log(u) - log))
        return Notes(key, t + self.delay[0] + self.delay[1] / inside, np.clip(v, 0.02, 12.0))

    def _measured(self, scan: Scan) -> tuple[Floats, Floats, Floats]:
        count = max(1, round(self.SMOOTH_S * scan.rate_hz))
        rows = [
            (key, *one)
            for key, t, x in scan.keys()
            for t_s, x_s in strokes(t, x)
            if len(t_s) > count
            for one in self.measure(*(np.convolve(values, np.full(count, 1 / count), mode="valid") for values in (t_s, x_s)))
        ]
        found = np.array(rows, dtype=np.float64).reshape(-1, 3)
        return found[:, 0], found[:, 1], found[:, 2]

    def train(self, data: DataSet, scan: Scan) -> None:
        """Fits map and delay to the strikes of a data set that start from rest: those with no other strike of the key
        for 0.3 s before and after.

        Parameters
        ----------
        data : DataSet
        scan : Scan
            A scan of the data set.

        Raises
        ------
        ValueError
            If fewer than ten strikes were measured.
        """
        key, t, u = self._measured(scan)
        true, rows = data.truth, []
        for index in np.flatnonzero(true.hammer_speed_m_per_s >= FAINT_M_PER_S):
            others = np.abs(true.time_s[true.key == true.key[index]] - true.time_s[index])
            near = np.flatnonzero((key == true.key[index]) & (np.abs(t - true.time_s[index]) < 0.1))
            if np.count_nonzero(others < 0.3) == 1 and len(near) > 0:
                rows.append((u[near[0]], true.hammer_speed_m_per_s[index], true.time_s[index] - t[near[0]]))
        if len(rows) < 10:
            raise ValueError(f"{scan.path}: {len(rows)} strikes from rest were measured; expected ten or more to train with")
        u_s, v, late = np.array(rows).T
        self.curve = np.polynomial.polynomial.polyfit(np.log(u_s), np.log(v), 2)
        self.range = (float(u_s.min()), float(u_s.max()))
        self.delay = np.linalg.lstsq(np.stack([np.ones_like(u_s), 1.0 / u_s], axis=1), late, rcond=None)[0]


def _crossing(t: Floats, x: Floats, i: int, height: float) -> float:
    """Returns the time at which a key passes a height downward, between the readings i - 1 and i."""
    return float(t[i - 1] + (t[i] - t[i - 1]) * (height - x[i - 1]) / (x[i] - x[i - 1]))


class TwoPoints(Baseline):
    """Two switches at two heights. u is the mean speed of the key between them, m/s.

    Parameters
    ----------
    heights : tuple of float, optional
        Travel at the two heights, mm. The key must rise above the first to be measured again.
    """

    def __init__(self, heights: tuple[float, float] = (3.0, 8.5)) -> None:
        super().__init__()
        self.heights = heights

    def measure(self, t: Floats, x: Floats) -> Iterator[tuple[float, float]]:
        """Yields the measurements in the readings of one key: time, s, and u.

        Parameters
        ----------
        t, x : ndarray

        Returns
        -------
        iterator of tuple of float, float
        """
        (upper, lower), began = self.heights, None
        for i in range(1, len(x)):
            if x[i - 1] < upper <= x[i]:
                began = _crossing(t, x, i, upper)
            if x[i - 1] < lower <= x[i] and began is not None:
                ended = _crossing(t, x, i, lower)
                yield ended, 1e-3 * (lower - upper) / max(ended - began, 1e-5)
                began = None


class SlopeAtLetOff(Baseline):
    """Key speed at let-off. u is the slope of a straight line through the readings of the last millimetres, m/s.

    Parameters
    ----------
    let_off : float, optional
        Travel of the key at let-off, mm.
    over : float, optional
        Travel over which the line is fitted, mm, with at least three readings.
    rearm : float, optional
        Rise of the key above the let-off before it is measured again, mm.
    """

    def __init__(self, let_off: float = 8.0, over: float = 2.0, rearm: float = 2.0) -> None:
        super().__init__()
        self.let_off, self.over, self.rearm = let_off, over, rearm

    def measure(self, t: Floats, x: Floats) -> Iterator[tuple[float, float]]:
        """Yields the measurements in the readings of one key: time, s, and u.

        Parameters
        ----------
        t, x : ndarray

        Returns
        -------
        iterator of tuple of float, float
        """
        armed = True
        for i in range(1, len(x)):
            if x[i] < self.let_off - self.rearm:
                armed = True
            elif armed and x[i] >= self.let_off:
                armed = False
                first = lowest = i
                # Back to the line's length, or to where the key turned: 0.15 mm of rising may be noise.
                while first > 0 and (i - first < 2 or (x[first - 1] > self.let_off - self.over and x[first - 1] < x[lowest] + 0.15)):
                    first -= 1
                    lowest = first if x[first] < x[lowest] else lowest
                own = slice(max(min(lowest, i - 2), 0), i + 1)
                dt = t[own] - t[own].mean()
                slope = 1e-3 * float(dt @ (x[own] - x[own].mean()) / (dt @ dt))
                if slope > 1e-3:
                    yield _crossing(t, x, i, self.let_off), slope


class OneDegreeHammer(Baseline):
    """Model of a mass that the key throws: a lever pushes it up until let-off; it flies on against gravity, hits the
    string at the blow distance, bounces, and is caught. u is its speed at the string, m/s.

    Parameters
    ----------
    ratio : float, optional
        Hammer travel over key travel.
    let_off, reset : float, optional
        Travel of the key, mm, at which the lever releases the mass on the way down, and engages again on the way up.
    blow : float, optional
        Blow distance from rest to the string, mm.
    gravity : float, optional
        Deceleration of the flight, m/s2; a value above gravity represents friction.
    """

    def __init__(self, ratio: float = 5.5, let_off: float = 7.5, reset: float = 5.0, blow: float = 46.0, gravity: float = 25.0) -> None:
        super().__init__()
        self.ratio, self.let_off, self.reset, self.blow, self.gravity = ratio, let_off, reset, blow, gravity

    def measure(self, t: Floats, x: Floats) -> Iterator[tuple[float, float]]:
        """Yields the measurements in the readings of one key: time, s, and u.

        Parameters
        ----------
        t, x : ndarray

        Returns
        -------
        iterator of tuple of float, float
        """
        blow, caught = 1e-3 * self.blow, 1e-3 * (self.blow - 15.0)
        held, hammer, v = True, 0.0, 0.0
        for i in range(1, len(x)):
            h, before, pushed = t[i] - t[i - 1], hammer, 1e-3 * self.ratio * x[i]
            hammer, v = hammer + v * h - 0.5 * self.gravity * h * h, v - self.gravity * h
            if held and hammer <= pushed:
                # The lever carries the hammer, which never drags behind.
                hammer, v = pushed, 1e-3 * self.ratio * (x[i] - x[i - 1]) / h
            if not held and hammer < min(caught, pushed):
                hammer, v = min(caught, pushed), 0.0
            if held and x[i] >= self.let_off:
                held = False
            elif not held and x[i] < self.reset:
                held = True
            if hammer >= blow and v > 0.0:
                yield float(t[i - 1] + h * np.clip((blow - before) / max(hammer - before, 1e-9), 0.0, 1.0)), v
                hammer, v = blow, -0.3 * v


#: The baselines by name.
BASELINES: dict[str, type[Baseline]] = {"two-points": TwoPoints, "slope": SlopeAtLetOff, "one-degree": OneDegreeHammer}


def report(data: DataSet, score: Score) -> str:
    """Returns a score as text: counts by case, and errors.

    Parameters
    ----------
    data : DataSet
    score : Score

    Returns
    -------
    str
    """
    true, found = data.cases(score.true), data.cases(score.found)
    lines = [f"{'case':16}{'matched':>9}{'missed':>9}{'false':>9}{'doubled':>9}"]
    for case in [*dict.fromkeys(data._cases), ""]:
        counts = [
            np.count_nonzero(true[score.pairs[:, 0]] == case), np.count_nonzero(true[score.missing] == case),
            np.count_nonzero(found[score.surplus] == case), np.count_nonzero(found[score.double] == case),
        ]  # fmt: skip
        if case or any(counts):
            lines.append(f"{case or '(no case)':16}" + "".join(f"{count:9}" for count in counts))
    told = score.summary()
    lines.append(f"{'all':16}" + "".join(f"{told[name]:9}" for name in ("matched", "missed", "false", "doubled")))
    for name, title in (("speed_percent", "error of speed, %"), ("velocity_counts", "error of velocity, counts"), ("time_ms", "error of instant, ms")):
        low, middle, high = (told[f"{name}_{which}"] for which in ("p5", "median", "p95"))
        lines.append(f"{title}: median {middle:.2f}, 5 to 95 % of notes {low:.2f} to {high:.2f}")
    return "\n".join(lines)


def main(arguments: Sequence[str] | None = None) -> int:
    """Runs the program.

    Parameters
    ----------
    arguments : sequence of str, optional
        Arguments; by default those of this process.

    Returns
    -------
    int
        Exit code: 0, or 2 for wrong input.
    """
    parser = argparse.ArgumentParser(prog="erard.judge", description="Compares notes that an algorithm made of key sensors with the truth.")
    parser.add_argument("data", help="folder of `erard scan`")
    parser.add_argument("notes", nargs="?", help="notes: CSV (key, time_s, hammer_speed_m_per_s or velocity) or MIDI file")
    parser.add_argument("--shift", type=float, default=0.0, metavar="S", help="added to the notes' instants, s")
    parser.add_argument("--algorithm", choices=BASELINES, help="judge a baseline on each scan instead")
    parser.add_argument("--train", metavar="FOLDER", help="data set that the baseline is trained on, of one sensor or the same ones")
    parser.add_argument("--json", action="store_true", help="print the counts and errors as JSON")
    asked = parser.parse_args(arguments)
    if (asked.notes is None) == (asked.algorithm is None) or (asked.algorithm is None) != (asked.train is None):
        parser.error("expected notes, or --algorithm with --train")
    try:
        data = DataSet(asked.data)
        if asked.notes is not None:
            scores = {asked.notes: compare(data.truth, Notes.read(asked.notes, asked.shift))}
        else:
            trained = DataSet(asked.train)
            scores = {}
            for scan in data.scans:
                algorithm = BASELINES[asked.algorithm]()
                algorithm.train(trained, next((one for one in trained.scans if one.path.name == scan.path.name), trained.scans[0]))
                scores[scan.path.name] = judge(data, scan, algorithm)
    except (OSError, ValueError) as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    if asked.json:
        print(json.dumps({name: score.summary() for name, score in scores.items()}, indent=2))
    else:
        print("\n\n".join(f"{name}\n{report(data, score)}" for name, score in scores.items()))
    return 0


if __name__ == "__main__":
    sys.exit(main())
