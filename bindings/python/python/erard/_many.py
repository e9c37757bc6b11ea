"""Many strokes at once: rollouts and studies."""

from __future__ import annotations

import math
import warnings
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, Union, Unpack

import numpy as np

from . import _erard
from ._common import Stepping, bar, flag, floats, items_of, mapping, names_of, number, refused, step_of, steps, unmasked, whole
from ._errors import Extra, FailedStrokesWarning, InputError
from ._instrument import Instrument, instrument_of, preparation_of, stroke_of
from ._table import Table

if TYPE_CHECKING:
    import matplotlib.figure
    import xarray
    from numpy.typing import ArrayLike, NDArray

    from ._common import Hand
    from ._instrument import Parameter
    from ._recording import RecordingLike
    from ._types import Steps, Work

    Axis = Union[float, Sequence[float], NDArray[Any]]

#: Columns of results that every stroke has, besides its samples and `error`.
OUTCOMES = (
    "key_start_s",
    "toe_contact_s",
    "let_off_s",
    "hammer_contact_s",
    "hammer_speed_m_per_s",
    "key_bottom_s",
    "check_s",
    "impact_count",
    "hammer_highest_m",
    "unconverged_steps",
    "energy_residual_relative",
    "failed",
    "trusted",
)


def work(
    threads: int | None,
    single: bool,
    ledger: bool,
    columns: Sequence[str] = (),
    every: int = 1,
    tolerance: float | None = None,
) -> Work:
    """Returns the settings of the work and of the recorded columns as the extension takes them."""
    threads = None if threads is None else whole("threads", threads)
    names = names_of("columns", columns)
    return {
        "threads": threads, "single": flag("single", single), "ledger": flag("ledger", ledger), "columns": names, "every": every, "tolerance": tolerance,
    }  # fmt: skip


def outcomes(found: dict[str, Any]) -> dict[str, NDArray[Any]]:
    """Returns the columns of results of every stroke, read-only."""
    columns = {name: found[name] for name in OUTCOMES}
    columns["impact_count"] = np.nan_to_num(columns["impact_count"]).astype(np.int64)
    columns["unconverged_steps"] = np.nan_to_num(columns["unconverged_steps"]).astype(np.int64)
    columns["error"] = np.array(found["error"], dtype=object)
    for values in columns.values():
        values.flags.writeable = False
    return columns


class Strokes(Table):
    """Results of many strokes, one row for each."""

    @property
    def errors(self) -> dict[int, str]:
        """Reasons of failed strokes and measurements, by row; their results are nan."""
        return {row: error for row, error in enumerate(self["error"]) if error}

    def _warn(self, more: str = "") -> None:
        """Warns of failed strokes, with the first reason; `more` is what is known beside it."""
        if failed := self.errors:
            row, reason = next(iter(failed.items()))
            told = f"{len(failed)} of {len(self['failed'])} strokes failed, and their results are nan; row {row}: {reason}{more}"
            warnings.warn(told, FailedStrokesWarning, stacklevel=3)

    def _failed(self) -> str:
        """Returns the number of failed strokes, in words."""
        count = int(np.count_nonzero(self["failed"]))
        return f", {count} failed" if count else ""


class Rollout(Strokes):
    """Results of N strokes of T samples.

    Columns of shape (N,) hold the results of every stroke, by the names of a study's columns: times such as
    `let_off_s`, s, nan for events that did not happen; `hammer_speed_m_per_s`; `impact_count`; `failed`; `trusted`;
    `error`, the reason of a failed stroke, else empty. Columns of shape (N, T) hold the samples at `time_s`.

    Attributes
    ----------
    time_s : ndarray of shape (T,)
        Times of the samples, s.
    errors : dict of int to str
        Reasons of failed strokes, by row; their results are nan.
    doubts : list of str
        Reasons not to trust strokes: for each kind, the number of strokes and the worst of them.
    impacts : list of list of (float, float)
        Impacts of each stroke on the string: time (s) and total hammer speed (m/s).
    """

    def __init__(
        self,
        time_s: NDArray[np.float64],
        columns: dict[str, NDArray[Any]],
        doubts: list[str],
        impacts: list[list[tuple[float, float]]],
    ) -> None:
        super().__init__(columns)
        time_s.flags.writeable = False
        self.time_s, self.doubts, self.impacts = time_s, doubts, impacts

    def to_xarray(self) -> xarray.Dataset:
        """Returns a labelled data set with the dimensions `stroke` and `time_s`, and units as attributes.

        Returns
        -------
        xarray.Dataset
        """
        with Extra("tables"):
            import xarray as xr

        units = self.units
        variables = {
            name: (("stroke", "time_s")[: values.ndim], values, {"units": units[name]}) for name, values in self.items()
        }
        coordinates = {"time_s": ("time_s", self.time_s, {"units": "s"})}
        return xr.Dataset(variables, coords=coordinates)

    def __repr__(self) -> str:
        count = len(self["failed"])
        sampled = ", ".join(name for name, values in self.items() if values.ndim == 2) or "nothing"
        return f"<erard.Rollout of {count} strokes{self._failed()}; {len(self.time_s)} samples of {sampled}>"

    def __getstate__(self) -> dict[str, Any]:
        return {
            "columns": {name: np.asarray(values) for name, values in self.items()},
            "time_s": np.asarray(self.time_s),
            "doubts": self.doubts,
            "impacts": self.impacts,
        }

    def __setstate__(self, state: dict[str, Any]) -> None:
        for values in state["columns"].values():
            values.flags.writeable = False
        Rollout.__init__(self, state["time_s"], state["columns"], state["doubts"], state["impacts"])


def divided(dt: float, own: Steps, instruments: Sequence[Instrument]) -> tuple[Steps, int]:
    """Returns settings whose step divides the time between samples evenly and is not longer than given, and the number
    of these steps."""
    every = max(1, math.ceil(dt / step_of(own, *(one._inner.usual_step_s for one in instruments)) - 1e-9))
    even: Steps = {**own, "step": dt / every}
    return even, every


def rollout(
    instruments: Instrument | Sequence[Instrument],
    *,
    force: ArrayLike | None = None,
    motion: ArrayLike | None = None,
    rigid: ArrayLike | None = None,
    dt: float,
    columns: Sequence[str] = ("key_m", "hammer_rise_m"),
    threads: int | None = None,
    single: bool = False,
    ledger: bool = True,
    progress: bool | None = None,
    **how: Unpack[Stepping],
) -> Rollout:
    """Plays many strokes at once, on all cores and in their vector lanes, without Python's lock.

    Each stroke has the same results as with `Instrument.press`, to rounding. The bits do not depend on the number of
    threads.

    Parameters
    ----------
    instruments : Instrument or sequence of Instrument
        One instrument for all strokes, or one for each. Instruments that differ only in parameters share lanes.
    force : array_like of shape (N, T)
        Force of the finger, N, pushing positive: N strokes of T samples. Between samples the force is interpolated as
        in `Instrument.press` and stroke files of the command: by monotone cubics (Fritsch and Carlson).
    motion, rigid : array_like of shape (N, T)
        Instead of `force`: prescribed position of the fingertip, or of the key front itself, m down from rest;
        interpolated by cubic splines that start and end at rest.
    dt : float
        Time between samples, s. The run lasts (T - 1) dt; its steps divide dt evenly.
    columns : sequence of str
        Columns of a run to sample at the same times. Vector lanes do not record contact forces (`string_N`), nor the
        finger's force under a motion: with these columns, strokes are played one by one on all cores.
    threads : int, optional
        Number of threads; by default the number of cores.
    single : bool
        Compute in single precision: twice as many strokes side by side; hammer speeds are accurate to about 1e-4.
    ledger : bool
        Compute the energy balance, which `trusted` checks. With `ledger=False` a rollout takes a third of the time, and
        `trusted` checks everything but the energy.
    progress : bool, optional
        Whether to show a progress bar.
    **how
        Settings of the steps: `step` (largest step, s), `theta`, `solver`, `friction`, `friction_width`.

    Returns
    -------
    Rollout
        Arrays of shape (N,) and (N, T). If a stroke fails, only its row is nan.

    Raises
    ------
    InputError
        If an argument is wrong, such as its shape or a number that is not finite.

    Examples
    --------
    >>> import erard, numpy as np
    >>> grand = erard.load("concert-grand")
    >>> force = np.repeat(np.linspace(4, 12, 5)[:, None], 101, axis=1)
    >>> r = erard.rollout(grand, force=force, dt=1e-3)
    >>> r["key_m"].shape, bool(np.all(np.diff(r["hammer_speed_m_per_s"]) > 0))
    ((5, 101), True)
    """
    given = {name: values for name, values in (("force", force), ("motion", motion), ("rigid", rigid)) if values is not None}
    if len(given) != 1:
        found = " and ".join(given) or "none"
        raise InputError(f"found {found}; expected one of force, motion and rigid", key="force", found=found)
    [(kind, values)] = given.items()
    array = floats(kind, values, 2)
    if array.shape[1] < 2:
        shape = f"shape {array.shape}"
        raise InputError(f"{kind}: found {shape}, expected two samples or more for each stroke", key=kind, found=shape)
    wanted = "an Instrument, as erard.load gives it, or one for each stroke"
    own = [instruments] if isinstance(instruments, Instrument) else items_of("instruments", instruments, wanted)
    if not own or not all(isinstance(one, Instrument) for one in own):
        raise refused("instruments", instruments, wanted)
    dt = number("dt", dt)
    if dt <= 0:
        raise InputError(f"dt: found {dt}, expected a positive number of seconds", key="dt", found=str(dt))
    even, every = divided(dt, steps(how), own)
    with bar(progress, "rollout") as tell:
        found_all = _erard.rollout(
            [one._inner for one in own], kind, array, dt, even, work(threads, single, ledger, columns, every), tell
        )
    sampled = {name: found_all[name][:, : array.shape[1]] for name in columns}
    for samples in sampled.values():
        samples.flags.writeable = False
    time_s = dt * np.arange(array.shape[1], dtype=np.float64)
    rolled = Rollout(time_s, outcomes(found_all) | sampled, found_all["doubts"], found_all["impacts"])
    rolled._warn()
    return rolled


class Study(Strokes):
    """Results of a stroke on many variants of an instrument: one row for each combination of varied values; the last
    name varies fastest.

    Columns are the varied values by name, then the results by the names of a study's columns, then the measured lines.
    A variant that cannot be made, played or measured has nan in its row and the reason in the column `error`.

    Attributes
    ----------
    axes : dict of str to ndarray
        Varied names and their values.
    errors : dict of int to str
        Reasons of failed strokes, by row.
    doubts : list of str
        Reasons not to trust strokes.
    notes, preparation : list
        How a recorded stroke was prepared, as in `Run`.
    """

    notes: list[str]
    preparation: list[dict[str, Any]]

    def __init__(
        self,
        axes: dict[str, NDArray[np.float64]],
        columns: dict[str, NDArray[Any]],
        doubts: list[str],
        axis_units: Mapping[str, str] | None = None,
        told: tuple[list[str], list[dict[str, Any]]] = ([], []),
    ) -> None:
        super().__init__(columns)
        self.axes, self.doubts = axes, doubts
        self.notes, self.preparation = told
        self._own_units = dict(axis_units or {})

    @property
    def shape(self) -> tuple[int, ...]:
        """Number of values of each axis."""
        return tuple(len(values) for values in self.axes.values())

    def to_xarray(self) -> xarray.Dataset:
        """Returns a labelled data set with the varied names as dimensions, and units as attributes.

        Returns
        -------
        xarray.Dataset
        """
        with Extra("tables"):
            import xarray as xr

        names = list(self.axes)
        units = self.units
        variables = {
            name: (names, values.reshape(self.shape), {"units": units[name]})
            for name, values in self.items()
            if name not in self.axes
        }
        coordinates = {name: (name, values, {"units": units[name]}) for name, values in self.axes.items()}
        return xr.Dataset(variables, coords=coordinates)

    def plot(self, column: str = "hammer_speed_m_per_s", *, over: str | None = None) -> matplotlib.figure.Figure:
        """Draws a column over one axis, with one curve for each combination of the others.

        Parameters
        ----------
        column : str
        over : str, optional
            The axis; by default the one with the most values.

        Returns
        -------
        matplotlib.figure.Figure
        """
        from ._plot import study_figure

        if not isinstance(column, str) or column not in self:
            raise refused("column", column, f"one of {', '.join(self)}")
        if not (over is None or isinstance(over, str) and over in self.axes):
            raise refused("over", over, f"one of {', '.join(self.axes)}")
        return study_figure(self, column, over or max(self.axes, key=lambda name: len(self.axes[name])))

    def __repr__(self) -> str:
        over = " x ".join(f"{len(values)} {name}" for name, values in self.axes.items())
        return f"<erard.Study over {over}: {len(self['failed'])} strokes{self._failed()}>"

    def __getstate__(self) -> dict[str, Any]:
        columns = {name: np.asarray(values) for name, values in self.items()}
        own = {"axes": self.axes, "columns": columns, "doubts": self.doubts}
        return own | {"axis_units": dict(self._own_units), "told": (self.notes, self.preparation)}

    def __setstate__(self, state: dict[str, Any]) -> None:
        for values in state["columns"].values():
            values.flags.writeable = False
        Study.__init__(self, state["axes"], state["columns"], state["doubts"], state["axis_units"], state["told"])


def study(
    instrument: Instrument,
    vary: Mapping[str, Axis] | None = None,
    /,
    *,
    force: Axis | None = None,
    stroke: str | RecordingLike | None = None,
    touch: str = "pressed",
    drive: str | None = None,
    duration: float | None = None,
    measure: Sequence[str] = (),
    threads: int | None = None,
    single: bool = False,
    progress: bool | None = None,
    step: float | None = None,
    theta: float = 0.5,
    tolerance: float | None = None,
    hand: Hand | None = None,
    **more: Axis,
) -> Study:
    """Plays a stroke on many variants of an instrument: all combinations of the varied values.

    Parameters
    ----------
    instrument : Instrument
    vary, **more : mapping of str to array_like
        Names and their values in SI units, as `Instrument.vary` takes them; numbers of the file are in their own unit.
        Texts ("-0.2 mm", "8.7 g", "x1.1") are converted to values.
    force : float or array_like, optional
        Constant force from the start on, N; several forces are one more axis.
    stroke, touch, drive, duration
        As in `Instrument.press`; by default the built-in mf.
    measure : sequence of str
        Lines of the technician's sheet to measure on every variant, such as "down_weight_g".
    threads, single, progress
        As in `rollout`.
    step, theta : float
        Step length, s, and parameter theta of the time-stepping scheme.
    tolerance : float, optional
        Tolerance for adaptive steps, 1e-9 to 0.1, as in `Instrument.press`; strokes are then played one by one on all
        cores. Not with `single`.
    hand : Hand, optional
        Hand between stroke and key.

    Returns
    -------
    Study

    Examples
    --------
    >>> import erard, numpy as np
    >>> grand = erard.load("concert-grand")
    >>> s = erard.study(grand, let_off=np.linspace(-5e-4, 5e-4, 5), force=[4, 8])
    >>> s.shape, s.columns[:2], s.to_xarray()["hammer_speed_m_per_s"].dims
    ((5, 2), ['let_off', 'force_N'], ('let_off', 'force_N'))
    """
    own, instrument, measure = steps({"step": step, "theta": theta, "hand": hand}), instrument_of(instrument), names_of("measure", measure)
    axes = {str(name): axis(instrument, str(name), values) for name, values in {**mapping("vary", vary), **more}.items()}
    forces = None
    if force is not None:
        if stroke is not None:
            raise InputError("force and stroke are given; expected one of them", key="stroke")
        forces = floats("force", np.atleast_1d(force), 1)
        if not forces.size:
            raise InputError("force: found none, expected one or more", key="force")
        if bad := [f for f in forces if not 0 <= f <= 1e4]:
            raise InputError(f"force: found {bad[0]}, expected numbers from 0 to 10000 N", key="force", found=str(bad[0]))
    several = forces is not None and len(forces) > 1
    if not (axes or several) or any(len(values) == 0 for values in axes.values()):
        raise InputError("nothing is varied; expected names with values, as in let_off=[-1e-4, 0, 1e-4]")
    made = None if forces is not None else stroke_of(instrument, stroke=stroke, touch=touch, drive=drive, hand=hand)
    duration = None if duration is None else number("duration", duration)
    accuracy = None if tolerance is None else number("tolerance", tolerance)
    if accuracy is not None and flag("single", single):
        raise InputError("tolerance and single are given; expected one of them: adaptive steps are computed in doubles", key="single")
    keep = work(threads, single, True, tolerance=accuracy)
    with bar(progress, "study") as tell:
        found = played(instrument, axes, made, forces, None, measure, duration, own, keep, tell)
    known = instrument.parameters
    # A parameter's unit is known; of a number of the file its path tells.
    units = {name: known[name].unit or "1" for name in axes if name in known}
    rows = dict(zip([*axes, "force_N"], found["varied"], strict=False))
    if several:
        assert forces is not None
        axes["force_N"] = forces
    else:
        rows.pop("force_N", None)
    columns = rows | outcomes(found) | dict(zip(measure, found["measured"], strict=True))
    for values in columns.values():
        values.flags.writeable = False
    studied = Study(axes, columns, found["doubts"], units, ([], []) if made is None else (made.notes, preparation_of(made)))
    studied._warn("".join(_outside(known[name], values) for name, values in axes.items() if name in known))
    return studied


def _outside(parameter: Parameter, values: NDArray[np.float64]) -> str:
    """Returns which values are outside a parameter's range, in words; empty if none is."""
    low, high = parameter.range
    outside = values[(values < low) | (values > high)]
    if not outside.size:
        return ""
    found = ", ".join(f"{value:g}" for value in outside[:3]) + (", ..." if outside.size > 3 else "")
    unit = f" {parameter.unit}" if parameter.unit else ""
    return f"; {parameter.name}: found {found}{unit}, expected {low:g} to {high:g}{unit} (a text may have another unit, as in \"-1 mm\")"


def played(
    instrument: Instrument,
    axes: Mapping[str, NDArray[np.float64]],
    stroke: _erard.Stroke | None,
    forces: NDArray[np.float64] | None,
    rows: tuple[int, int] | None,
    measure: Sequence[str],
    duration: float | None,
    own: Steps,
    keep: Work,
    tell: Any,
) -> dict[str, Any]:
    """Returns the results of the combinations of a study, or of some rows of it, as the extension names them."""
    values = [(name, own_values.tolist()) for name, own_values in axes.items()]
    constant = None if forces is None else forces.tolist()
    return _erard.study(instrument._inner, values, stroke, constant, rows, list(measure), duration, own, keep, tell)


def axis(instrument: Instrument, name: str, values: Any) -> NDArray[np.float64]:
    """Returns the values of a varied name in SI units; converts texts to such numbers."""
    given = np.atleast_1d(unmasked(name, values))
    if given.dtype.kind not in "USO" or not any(isinstance(value, str) for value in given.ravel()):
        return floats(name, given, 1)
    known = instrument.parameters.get(name)
    if known is None:
        instrument.vary({name: str(given.ravel()[0])})  # It says what there is.
        raise InputError(f"{name} is a number of the file: expected numbers, not texts", key=name)

    def number_of(value: Any) -> float:
        asked = str(value) if isinstance(value, str) else number(name, value)
        return instrument.vary({name: asked}).parameters[name].value

    return floats(name, [number_of(value) for value in given.tolist()], 1)
