"""Ground truth for sensor pianos: sensor readings with the true events.

Builders of hybrid and silent pianos compute the hammer speed from optical sensors, and have no labelled data. This
module draws strokes of every kind from named distributions with a seed, plays them on the simulated action, and reads
them with realistic sensors: with a range, a characteristic, noise, a sampling rate and an analogue-to-digital
converter. Labels accompany the counts.

>>> from erard import dataset
>>> plan = dataset.Plan(count=4, seed=7, keys=(40,), chunk=4)
>>> table = dataset.chunk(plan, 0)
>>> table.num_rows, table["key_counts"][0].values.type
(4, DataType(uint16))
>>> dataset.chunk(plan, 0).equals(table)
True
"""

from __future__ import annotations

import dataclasses
import json
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ._common import bar, unit_of, whole
from ._errors import Extra, InputError
from ._instrument import Instrument, load
from ._many import rollout
from ._parts import Folder, digest, in_order, write_parquet, write_whole
from ._version import __version__

if TYPE_CHECKING:
    import pyarrow
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

#: From sample to sample of the forces and of what the sensors see before they sample it, s.
DT_S = 0.25e-3


@dataclass(frozen=True)
class Uniform:
    """Uniform distribution between two bounds."""

    low: float
    high: float

    def __post_init__(self) -> None:
        _increasing(self, -np.inf)

    def draw(self, rng: np.random.Generator) -> float:
        return float(rng.uniform(self.low, self.high))


@dataclass(frozen=True)
class LogUniform:
    """Log-uniform distribution: the logarithm is uniform between those of two positive bounds."""

    low: float
    high: float

    def __post_init__(self) -> None:
        _increasing(self, 0.0)

    def draw(self, rng: np.random.Generator) -> float:
        return float(np.exp(rng.uniform(np.log(self.low), np.log(self.high))))


@dataclass(frozen=True)
class Normal:
    """Normal distribution, cut off at three standard deviations."""

    mean: float
    std: float

    def __post_init__(self) -> None:
        if not (np.isfinite(self.mean) and np.isfinite(self.std) and self.std >= 0):
            raise InputError(f"{self}: expected finite numbers, and no negative deviation", key="std", found=str(self.std))

    def draw(self, rng: np.random.Generator) -> float:
        return self.mean + self.std * float(np.clip(rng.standard_normal(), -3.0, 3.0))


def _increasing(one: Uniform | LogUniform, above: float) -> None:
    if not (above < one.low <= one.high < np.inf):
        least = "" if np.isinf(above) else f" above {above:g}"
        raise InputError(f"{one}: expected low <= high, finite{least}", key="low", found=str(one.low))


Distribution = Uniform | LogUniform | Normal


@dataclass(frozen=True)
class Sensor:
    """Sensor with its converter.

    Attributes
    ----------
    name : str
        Name of the sensor; its counts are the column `NAME_counts`.
    column : str
        Measured quantity, a column of a run: "key_m" (down positive) or "hammer_rise_m" (up positive).
    from_m, to_m : float
        Travel at zero counts and at full scale, m; outside, the sensor saturates.
    curvature : float
        Curvature of the characteristic c(s) = s (1 + curvature (1 - s)), s from 0 to 1 over the travel. 0 is straight;
        positive bends upward, as for a reflective sensor that comes near. Between -1 and 1 the characteristic is
        monotonic.
    noise : float
        Root mean square of white noise before the converter, as a share of the full scale.
    bits : int
        Bits of the converter, 1 to 16.
    rate_hz : float
        Samples per second.
    gain : Distribution
        Gain of each key's sensor: its full scale over the nominal one.
    """

    name: str
    column: str
    from_m: float
    to_m: float
    curvature: float = 0.0
    noise: float = 1e-3
    bits: int = 10
    rate_hz: float = 1000.0
    gain: Distribution = field(default_factory=lambda: Normal(1.0, 0.03))

    def __post_init__(self) -> None:
        if self.column not in ("key_m", "hammer_rise_m"):
            raise InputError(f"sensor {self.name}: found column {self.column!r}, expected 'key_m' or 'hammer_rise_m'", key="column")
        if not 1 <= self.bits <= 16:
            raise InputError(f"sensor {self.name}: found {self.bits} bits, expected 1 to 16", key="bits")
        if not (self.to_m > self.from_m and -1 <= self.curvature <= 1 and self.noise >= 0):
            raise InputError(f"sensor {self.name}: expected from_m < to_m, a curvature of -1 to 1 and no negative noise", key="from_m")
        if not 10 <= self.rate_hz <= 1 / DT_S:
            raise InputError(f"sensor {self.name}: found {self.rate_hz} Hz, expected 10 to {1 / DT_S:.0f}", key="rate_hz")

    def characteristic(self, way_m: Array, gain: float = 1.0) -> Array:
        """Returns the sensor's reading of a travel, as a share of the full scale, without noise and converter; an array
        of equal shape."""
        share = np.clip((way_m - self.from_m) / (self.to_m - self.from_m), 0.0, 1.0)
        bent: Array = gain * share * (1 + self.curvature * (1 - share))
        return bent

    def read(self, way_m: Array, rng: np.random.Generator, gain: float = 1.0) -> NDArray[np.uint16]:
        """Returns the counts for a travel sampled at the sensor's rate."""
        full = 2**self.bits - 1
        read = self.characteristic(way_m, gain) + self.noise * rng.standard_normal(way_m.shape)
        counts: NDArray[np.uint16] = np.clip(np.round(full * read), 0, full).astype(np.uint16)
        return counts


#: Under the key: a reflective sensor that sees all of the key's travel.
UNDER_KEY = Sensor("key", "key_m", from_m=0.0, to_m=0.0105, curvature=0.35, noise=1.5e-3, bits=10, rate_hz=1000.0)
#: At the hammer's shank: a fork that a vane enters in the last twelve millimetres before the string.
AT_SHANK = Sensor("shank", "hammer_rise_m", from_m=0.034, to_m=0.046, curvature=-0.2, noise=2e-3, bits=12, rate_hz=4000.0)


@dataclass(frozen=True)
class Kind:
    """Kind of stroke, and its share.

    The force of `pressed` swells and holds; `struck` begins with the finger's impact; `repeated` presses a second time
    before the key is back at rest; `half` releases the key before let-off.
    """

    name: str
    share: float


KINDS = (Kind("pressed", 0.4), Kind("struck", 0.25), Kind("repeated", 0.2), Kind("half", 0.15))


@dataclass(frozen=True)
class Plan:
    """Plan of a data set. The same plan gives the same data, to the bit, on every machine.

    Attributes
    ----------
    count : int
        Strokes.
    seed : int
    keyboard : str
        A built-in keyboard or a TOML file.
    keys : tuple of int
        Keys to play, 1 to 88.
    kinds : tuple of Kind
        Kinds of strokes with their shares.
    force_N : Distribution
        Largest force of a stroke, N.
    rise_s : Distribution
        Rise time of the force, s.
    regulation : mapping of str to Distribution
        Turns of screws, m, drawn for every misregulated stroke.
    misregulated : float
        Share of misregulated strokes.
    sensors : tuple of Sensor
    duration_s : float
        Duration of every recording, s.
    chunk : int
        Number of strokes in a part. It belongs to the plan, because random numbers are drawn chunk by chunk.
    """

    count: int = 1000
    seed: int = 0
    keyboard: str = "concert-grand"
    keys: tuple[int, ...] = tuple(range(4, 88, 7))
    kinds: tuple[Kind, ...] = KINDS
    force_N: Distribution = field(default_factory=lambda: LogUniform(1.5, 25.0))
    rise_s: Distribution = field(default_factory=lambda: LogUniform(0.004, 0.06))
    regulation: Mapping[str, Distribution] = field(
        default_factory=lambda: {
            "let_off": Normal(0.0, 0.4e-3),
            "capstan_height": Normal(0.0, 0.15e-3),
            "drop": Normal(0.0, 0.4e-3),
            "back_check": Normal(0.0, 0.3e-3),
        }
    )
    misregulated: float = 0.25
    sensors: tuple[Sensor, ...] = (UNDER_KEY, AT_SHANK)
    duration_s: float = 0.4
    chunk: int = 256

    def __post_init__(self) -> None:
        for name in ("count", "chunk"):
            whole(name, getattr(self, name))
        whole("seed", self.seed, 0)
        for name, low, high in (("count", 1, 10**9), ("chunk", 1, 10**6), ("misregulated", 0, 1), ("duration_s", 0.05, 10)):
            found = getattr(self, name)
            if not low <= found <= high:
                raise InputError(f"{name}: found {found}, expected {low} to {high}", key=name, found=str(found))
        if not self.keys or not all(1 <= key <= 88 for key in self.keys):
            raise InputError(f"keys: found {self.keys}, expected numbers from 1 to 88", key="keys")
        if not self.kinds or any(kind.name not in _SHAPES or not kind.share >= 0 for kind in self.kinds) or not sum(k.share for k in self.kinds) > 0:
            raise InputError(f"kinds: expected shares, not all of them zero, of {', '.join(_SHAPES)}", key="kinds")
        if len({sensor.name for sensor in self.sensors}) != len(self.sensors):
            raise InputError("sensors: expected different names", key="sensors")

    @property
    def parts(self) -> int:
        """Number of parts."""
        return -(-self.count // self.chunk)

    def about(self) -> dict[str, Any]:
        """Returns the plan as plain data, with distributions by name."""

        def plain(value: Any) -> Any:
            if dataclasses.is_dataclass(value) and not isinstance(value, type):
                own = {f.name: plain(getattr(value, f.name)) for f in dataclasses.fields(value)}
                return {"distribution": type(value).__name__, **own} if isinstance(value, Distribution) else own
            if isinstance(value, Mapping):
                return {str(key): plain(one) for key, one in value.items()}
            return [plain(one) for one in value] if isinstance(value, (tuple, list)) else value

        found: dict[str, Any] = plain(self)
        return found


def _smooth(t: Array, start: float, rise: float) -> Array:
    """Returns a raised cosine from 0 to 1."""
    found: Array = 0.5 - 0.5 * np.cos(np.pi * np.clip((t - start) / rise, 0.0, 1.0))
    return found


def _pressed(t: Array, force: float, rise: float, rng: np.random.Generator) -> Array:
    held = rng.uniform(0.15, 0.35)
    return force * _smooth(t, 0.005, rise) * (1 - _smooth(t, 0.005 + held, 0.03))


def _struck(t: Array, force: float, rise: float, rng: np.random.Generator) -> Array:
    held, knock = rng.uniform(0.15, 0.35), rng.uniform(0.004, 0.01)
    first = _smooth(t, 0.005, knock / 2) * (1 - _smooth(t, 0.005 + knock / 2, knock / 2))
    return force * first + 0.5 * force * _smooth(t, 0.005 + knock, rise) * (1 - _smooth(t, 0.005 + held, 0.03))


def _repeated(t: Array, force: float, rise: float, rng: np.random.Generator) -> Array:
    held, gap = rng.uniform(0.06, 0.12), rng.uniform(0.02, 0.08)
    second = 0.005 + held + gap
    once = _smooth(t, 0.005, rise) * (1 - _smooth(t, 0.005 + held, 0.015))
    return force * (once + rng.uniform(0.6, 1.2) * _smooth(t, second, rise) * (1 - _smooth(t, second + 0.12, 0.03)))


def _half(t: Array, force: float, rise: float, rng: np.random.Generator) -> Array:
    # So much momentum as carries the key some way, not to let-off.
    force, until = min(force, 3.0), rng.uniform(0.006, 0.014)
    return force * _smooth(t, 0.005, min(rise, until)) * (1 - _smooth(t, 0.005 + until, 0.01))


_SHAPES = {"pressed": _pressed, "struck": _struck, "repeated": _repeated, "half": _half}

#: What every column of the data means, for the card.
COLUMNS = {
    "stroke": "number of the stroke in the data set",
    "key": "key, 1 (A0) to 88 (C8)",
    "kind": "what was meant: pressed, struck, repeated, half",
    "force_N": "largest force of the finger, N",
    "rise_s": "how long the force rose, s",
    "misregulated": "whether screws were turned away from the regulated action",
    "turned_SCREW_m": "by how much this one, m",
    "hammer_speed_m_per_s": "label: speed of the strike point at the first impact, m/s; null where the string is not reached",
    "hammer_contact_s": "label: when that is, s from the recording's start",
    "impacts": "label: every impact on the string, its instant (s) and hammer speed (m/s)",
    "impact_count": "label: number of these; 2 or more is a repetition or a double strike",
    "double_strike": "label: a second impact within 0.05 s of another, which the pianist did not mean",
    "let_off_s": "label: the last push on the knuckle before the string, s",
    "key_bottom_s": "label: the key meets its front punching, s",
    "release_s": "label: the key comes back above half of its travel for the last time, s; null where it does not",
    "check_s": "label: the tail meets the back check, s",
    "trusted": "whether nothing speaks against the simulation's numbers",
    "SENSOR_counts": "counts of the sensor's converter, one list for each stroke, from the recording's start",
    "SENSOR_gain": "full scale of this key's sensor over the nominal one: what calibration has to find",
}


def _instruments(plan: Plan, turns: Mapping[str, Array], keys: Sequence[int]) -> list[Instrument]:
    own = {key: load(f"{plan.keyboard}:key={key}") for key in set(keys)}
    found = []
    for row, key in enumerate(keys):
        by = {name: f"{float(values[row]):+}" for name, values in turns.items() if values[row] != 0.0}
        found.append(own[key].vary(by) if by else own[key])
    return found


def chunk(plan: Plan, index: int, *, threads: int | None = None) -> pyarrow.Table:
    """Computes one part of a data set.

    Parameters
    ----------
    plan : Plan
    index : int
        Index of the part, 0 to `plan.parts` - 1.
    threads : int, optional
        Number of threads; by default the number of cores. The data do not depend on it.

    Returns
    -------
    pyarrow.Table
        One row for each stroke; `COLUMNS` describes the columns.
    """
    with Extra("tables"):
        import pyarrow as pa

    if not 0 <= index < plan.parts:
        raise InputError(f"index: found {index}, expected 0 to {plan.parts - 1}", key="index", found=str(index))
    rng = np.random.default_rng([plan.seed, index])
    first = index * plan.chunk
    count = min(plan.chunk, plan.count - first)
    t: Array = DT_S * np.arange(round(plan.duration_s / DT_S) + 1, dtype=np.float64)
    shares = np.array([kind.share for kind in plan.kinds])
    kinds = [plan.kinds[k].name for k in rng.choice(len(shares), size=count, p=shares / shares.sum())]
    keys = [int(key) for key in rng.choice(plan.keys, size=count)]
    peaks = np.array([plan.force_N.draw(rng) for _ in range(count)])
    rises = np.array([plan.rise_s.draw(rng) for _ in range(count)])
    wrong = rng.random(count) < plan.misregulated
    turns = {name: np.array([own.draw(rng) for _ in range(count)]) * wrong for name, own in plan.regulation.items()}
    force = np.stack(
        [_SHAPES[kind](t, peak, rise, rng) for kind, peak, rise in zip(kinds, peaks, rises, strict=True)]
    )
    played = rollout(_instruments(plan, turns, keys), force=force, dt=DT_S, threads=threads, progress=False)

    columns: dict[str, Any] = {
        "stroke": pa.array(np.arange(first, first + count)),
        "key": pa.array(keys, pa.int16()),
        "kind": pa.array(kinds),
        "force_N": pa.array(peaks),
        "rise_s": pa.array(rises),
        "misregulated": pa.array(wrong),
    }
    columns |= {f"turned_{name}_m": pa.array(values) for name, values in turns.items()}
    for name in ("hammer_speed_m_per_s", "hammer_contact_s", "let_off_s", "key_bottom_s", "check_s"):
        columns[name] = pa.array(played[name], from_pandas=True)
    impacts = played.impacts
    pair = pa.list_(pa.struct([("time_s", pa.float64()), ("hammer_speed_m_per_s", pa.float64())]))
    columns["impacts"] = pa.array([[{"time_s": at, "hammer_speed_m_per_s": v} for at, v in own] for own in impacts], pair)
    columns["impact_count"] = pa.array(played["impact_count"], pa.int16())
    instants = [np.array([at for at, _ in own]) for own in impacts]
    columns["double_strike"] = pa.array([bool(np.any(np.diff(own) < 0.05)) for own in instants])
    columns["release_s"] = pa.array(_released(played["key_m"], t), from_pandas=True)
    columns["trusted"] = pa.array(played["trusted"])
    for sensor in plan.sensors:
        gains = [sensor.gain.draw(np.random.default_rng([plan.seed, key, *sensor.name.encode()])) for key in keys]
        own_t = np.arange(int(plan.duration_s * sensor.rate_hz) + 1) / sensor.rate_hz
        ways = np.stack([np.interp(own_t, t, way) for way in played[sensor.column]])
        counts = [sensor.read(way, rng, gain) for way, gain in zip(ways, gains, strict=True)]
        columns[f"{sensor.name}_counts"] = pa.array([one.tolist() for one in counts], pa.list_(pa.uint16()))
        columns[f"{sensor.name}_gain"] = pa.array(gains)
    fields = [pa.field(name, values.type, metadata={"unit": unit_of(name)}) for name, values in columns.items()]
    return pa.Table.from_arrays(list(columns.values()), schema=pa.schema(fields))


def _released(key_m: NDArray[Any], t: Array) -> Array:
    """Returns the last time at which the key rises above half of its travel, s; nan if it does not."""
    found = np.full(len(key_m), np.nan)
    for row, way in enumerate(key_m):
        above = way < 0.5 * np.nanmax(way)
        back = np.flatnonzero(~above[:-1] & above[1:])
        if back.size and above[-1]:
            found[row] = t[back[-1] + 1]
    return found


def opened(plan: Plan, folder: str | os.PathLike[str]) -> Folder:
    """Opens the folder of a data set and writes its data card. If the folder holds parts of the same plan, the work
    continues.

    Parameters
    ----------
    plan : Plan
    folder : str or path

    Returns
    -------
    Folder
        Folder with its parts and the indices of missing ones.
    """
    parts = Folder(folder, {"what": "dataset", "version": __version__, "plan": plan.about()}, plan.parts)
    write_whole(parts.path / "README.md", lambda to: to.write_text(card(plan), encoding="utf-8"))
    return parts


def write(plan: Plan, folder: str | os.PathLike[str], *, progress: bool | None = None) -> Path:
    """Writes a data set: Parquet parts, `manifest.json`, and the data card `README.md`. A repeated call continues
    interrupted work.

    Parameters
    ----------
    plan : Plan
    folder : str or path
    progress : bool, optional
        Whether to show a progress bar.

    Returns
    -------
    Path
        The folder. `erard.distributed.dataset` writes the same files on a cluster.
    """
    parts = opened(plan, folder)
    missing = parts.missing
    with bar(progress, "data set") as tell:
        for done, _ in enumerate(in_order(missing, lambda i: write_parquet(parts.part(i), chunk(plan, i)))):
            if tell is not None:
                tell((done + 1) / len(missing))
    return parts.path


def read(folder: str | os.PathLike[str], columns: Sequence[str] | None = None) -> pyarrow.Table:
    """Reads a written data set as one table.

    Parameters
    ----------
    folder : str or path
    columns : sequence of str, optional

    Returns
    -------
    pyarrow.Table
    """
    with Extra("tables"):
        import pyarrow as pa
    import pyarrow.parquet as pq

    files = sorted(Path(folder).glob("part-*.parquet"))
    if not files:
        raise InputError(f"{os.fspath(folder)}: holds no parts of a data set", file=os.fspath(folder))
    return pa.concat_tables([pq.read_table(file, columns=None if columns is None else list(columns)) for file in files])


def card(plan: Plan) -> str:
    """Returns the data card: content of the data, how they were made, and their limits.

    Parameters
    ----------
    plan : Plan

    Returns
    -------
    str
        Markdown.
    """
    sensors = "\n".join(
        f"- `{s.name}_counts`: {s.column}, {1e3 * s.from_m:g} to {1e3 * s.to_m:g} mm, {s.bits} bits, {s.rate_hz:g} Hz, noise "
        f"{s.noise:g} of full scale, curvature {s.curvature:g}"
        for s in plan.sensors
    )
    columns = "\n".join(f"| `{name}` | {what} |" for name, what in COLUMNS.items())
    return f"""# Strokes of a simulated grand piano, with ground truth

{plan.count} strokes on {len(plan.keys)} keys of the keyboard `{plan.keyboard}`, made by erard {__version__} from the plan below (digest
{digest(plan.about())}, seed {plan.seed}). The same plan gives the same files.

## What it is for

To try algorithms that tell a hammer's speed, its instant, releases and repetitions from sensors, against what truly happened.

## What it is not

A simulation: no wear, no humidity, no crosstalk of neighbouring keys, no vibration of the frame, no player who listens. Most numbers of the
instrument are estimates (`erard check` tells their sources). Sensors have white noise and a smooth characteristic; lamps that drift, and
daylight, are not there. Forces are drawn shapes, not recordings of pianists.

## Sensors

{sensors}

## Columns

| column | meaning |
|---|---|
{columns}

## Plan

```json
{json.dumps(plan.about(), indent=1)}
```
"""
