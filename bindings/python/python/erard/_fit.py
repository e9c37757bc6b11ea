"""Parameters of an instrument fitted to recordings: least squares, and what the data do and do not tell."""

from __future__ import annotations

import html
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, TypeAlias, Unpack

import numpy as np

from . import _erard
from ._common import Stepping, counter, number, steps, whole
from ._errors import InputError, SimulationError
from ._instrument import Instrument, Parameter, instrument_of
from ._many import divided, work
from ._recording import Recording, as_recording

if TYPE_CHECKING:
    import matplotlib.figure
    from numpy.typing import NDArray

    from ._recording import RecordingLike
    from ._types import Steps

    Array: TypeAlias = NDArray[np.float64]

#: What can be fitted of a recording, and the noise that is taken where nothing tells it, N and m.
COLUMNS = {"force_N": 0.02, "key_m": 10e-6, "hammer_head_m": 50e-6}
#: Samples per second at most: above, a recording says more of its noise than of the action.
RATE_HZ = 4000.0
#: Strokes whose drive is disturbed by its own noise, to see what that does to the parameters.
DISTURBED = 48
#: Beyond so many times the misfit that the sensors' noise explains, the fit begins again elsewhere.
MISFIT = 1.03
#: Two fits whose misfits differ by less have ended at the same place.
AGREED = 1.005
#: How long after the blow the first look lasts, s.
AFTER_THE_BLOW_S = 2e-3
#: Samples at both ends of a recorded motion that are not compared.
SPLINE_ENDS = 10
#: Steps of the differences, as shares of a factor or of the way that a screw may go: the middle one is used, all are
#: compared.
DIFFERENCES = (4e-3, 1e-3, 2.5e-4)
#: How the Jacobian of the last steps is found.
JACOBIANS = ("differences", "gradient")
#: What `scipy.optimize.least_squares` makes of squares.
LOSSES = ("linear", "soft_l1", "huber", "cauchy")
#: The step at first: long enough to look past what jumps.
COARSE = 1e-2


@dataclass(frozen=True, eq=False)
class Channel:
    """One measured quantity of one recording beside what was fitted to it; arrays of shape (T,), SI units."""

    title: str
    column: str
    time_s: Array
    measured: Array
    fitted: Array
    sigma: float
    delay_s: float

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Channel):
            return NotImplemented
        return all(np.array_equal(one, two) for one, two in zip(vars(self).values(), vars(other).values(), strict=True))


@dataclass(frozen=True)
class _Free:
    """A parameter that is fitted, and how it is counted: the logarithm of its factor, or its turn over a scale."""

    parameter: Parameter
    low: float
    high: float

    @property
    def scale(self) -> float:
        return 1.0 if self.parameter.is_factor else (self.high - self.low) / 2

    def inner(self, x: float) -> float:
        return math.log(x) if self.parameter.is_factor else x / self.scale

    def outer(self, p: float) -> float:
        return math.exp(p) if self.parameter.is_factor else p * self.scale

    def slope(self, p: float) -> float:
        """d outer / d inner."""
        return math.exp(p) if self.parameter.is_factor else self.scale

    @property
    def width(self) -> float:
        """Half of what it may be, as it is counted."""
        return (self.inner(self.high) - self.inner(self.low)) / 2


def _free(instrument: Instrument, names: Sequence[str], bounds: Mapping[str, tuple[float, float]]) -> list[_Free]:
    known = instrument.parameters
    if isinstance(names, str):
        raise InputError(f"vary: found {names!r}, expected a list of names", key="vary", found=names)
    found = []
    for name in names:
        if name not in known:
            instrument.vary({name: 1.0})  # It says what there is.
            raise InputError(f"vary: {name} is a number of the file; expected a screw or a parameter", key="vary", found=name)
        own = known[name]
        spread = own.spread
        # A narrow one says how far grands of this kind differ, not how far off a guess may be.
        if spread is not None and spread[1] >= 2.3 * spread[0]:
            usual = spread
        else:
            usual = (0.2, 5.0) if own.is_factor else (-0.02 * own.range[1], 0.02 * own.range[1])
        limits = bounds.get(name, usual)
        if isinstance(limits, str) or np.shape(limits) != (2,):
            raise InputError(f"bounds[{name!r}]: found {limits!r}, expected two numbers, as in (0.5, 2.0)", key="bounds", found=repr(limits))
        low, high = (number(f"bounds[{name!r}]", bound) for bound in limits)
        if not (own.range[0] <= low < high <= own.range[1]):
            raise InputError(f"bounds: {name} from {low} to {high}; expected two increasing numbers in {own.range}", key="bounds")
        found.append(_Free(own, low, high))
    if not found or len(set(names)) != len(names):
        raise InputError("vary: expected one name or more, each once", key="vary")
    if unknown := set(bounds) - set(names):
        raise InputError(f"bounds: {', '.join(sorted(unknown))} are not varied", key="bounds")
    return found


class _Data:
    """One recording: what drives the model, what is compared."""

    def __init__(self, source: RecordingLike, drive: str | None, wanted: Sequence[str] | None, own: Steps) -> None:
        self.recording: Recording = as_recording(source)
        self.stroke = _erard.Stroke.recorded(self.recording._inner, drive)
        self.own, self.drive = own, drive
        self.driving = driving = {"force": "force_N"}.get(self.stroke.drive, "key_m")
        self.columns = [name for name in COLUMNS if name in self.recording and name != driving]
        if wanted is not None:
            if missing := [name for name in wanted if name not in COLUMNS or name not in self.recording]:
                raise InputError(f"columns: {missing[0]!r} was not recorded", key="columns", found=missing[0])
            self.columns = [name for name in wanted if name != driving]
        if not self.columns:
            told = ", ".join(self.recording)
            raise InputError(f"{self.recording.name}: driven by its {self.stroke.drive} nothing else is there to be fitted ({told})")
        times = self.recording["time_s"]
        span = float(times[-1] - times[0])
        dt = max(float(np.median(np.diff(times))), 1.0 / RATE_HZ)
        self.steps, self.every = divided(dt, own)
        self.time_s: Array = self.stroke.start_s + dt * np.arange(int(span / dt) + 1, dtype=np.float64)
        # Where a recorded motion ends it stops, and its spline rings over some samples at both ends: forces there are
        # nobody's.
        ends = 0 if self.driving == "force_N" else SPLINE_ENDS
        if len(self.time_s) < 2 * ends + 2:
            raise InputError(f"{self.recording.name}: found {len(self.time_s)} samples, expected {2 * ends + 2} or more")
        self.compared = slice(ends, len(self.time_s) - ends)
        self.duration_s = dt * (len(self.time_s) - 1)
        self.measured = {name: self.recording.at(name, self.time_s)[self.compared] for name in self.columns}
        self.rows = len(self.time_s[self.compared])

    def __getstate__(self) -> dict[str, Any]:
        return {**vars(self), "stroke": None}

    def __setstate__(self, state: dict[str, Any]) -> None:
        vars(self).update(state)
        self.stroke = _erard.Stroke.recorded(self.recording._inner, self.drive)

    def disturbed(self, instrument: Instrument, sigma: float, count: int, threads: int | None) -> dict[str, Array]:
        """What the model does when noise of this size is added to what drives it: arrays (count, T)."""
        rng = np.random.default_rng(0)
        table = {name: np.asarray(values) for name, values in self.recording.items()}
        strokes = []
        for _ in range(count):
            noisy = table[self.driving] + sigma * rng.standard_normal(len(table["time_s"]))
            # Prepared as the recording was: its zero and its filter are no disturbance.
            again = self.recording._again({**table, self.driving: noisy})
            strokes.append(_erard.Stroke.recorded(again._inner, self.drive))
        keep = work(threads, False, False, self.columns, self.every)
        jobs = [(0, row) for row in range(count)]
        found = _erard.play_all([instrument._inner], strokes, jobs, self.duration_s, self.steps, keep, None)
        return {name: found[name][:, : len(self.time_s)] for name in self.columns}

    def simulate(self, instrument: Instrument, names: list[str], values: Array, threads: int | None) -> dict[str, Array]:
        """What the model does with rows of values: arrays (rows, T); a row that fails is nan."""
        keep = work(threads, False, False, self.columns, self.every)
        found = _erard.study(
            instrument._inner, names, values, self.stroke, None, self.duration_s, self.steps, keep, None
        )
        return {name: found[name][:, : len(self.time_s)] for name in self.columns}


class _Problem:
    """Residuals and their Jacobian over the inner parameters: those of the instrument, then the delays in ms."""

    def __init__(self, instrument: Instrument, free: list[_Free], data: list[_Data], delay: bool, threads: int | None) -> None:
        self.instrument, self.free, self.data, self.threads = instrument, free, data, threads
        self.channels = [(i, name) for i, one in enumerate(data) for name in one.columns]
        self.delays = len(self.channels) if delay else 0
        self.sigma = np.array([COLUMNS[name] for _, name in self.channels])
        self.evaluations, self.differentiated = 0, 0
        #: Whether the Jacobian of fine steps comes from derivatives of the model itself.
        self.exact = False
        self._kept: tuple[bytes, Array] | None = None
        #: Rows that count; at first those up to the blow.
        self.weights: Array | float = 1.0
        #: Columns that drive and of whose noise nothing is known.
        self.silent: list[str] = []
        #: Receives how many strokes were played.
        self.tell: Callable[[int], None] | None = None

    def until_the_blow(self, point: Array) -> Array:
        """1 for rows up to shortly after the blow, 0 for later ones, on which a little more or less of anything has large effects."""
        instrument = self.instrument.vary({one.parameter.name: one.outer(p) for one, p in zip(self.free, point, strict=False)})
        parts = []
        for i, name in self.channels:
            one = self.data[i]
            found = _erard.play_all(
                [instrument._inner], [one.stroke], [(0, 0)], one.duration_s, one.steps, work(self.threads, False, False), None
            )
            blow = float(found["hammer_contact_s"][0])
            times = one.time_s[one.compared]
            parts.append((times <= blow + AFTER_THE_BLOW_S).astype(np.float64) if math.isfinite(blow) else np.ones(len(times)))
        return np.concatenate(parts)

    @property
    def names(self) -> list[str]:
        return [one.parameter.name for one in self.free]

    def simulate(self, points: Array) -> list[dict[str, Array]]:
        """Every recording at every point (rows of inner parameters)."""
        outer = np.array([[one.outer(p) for one, p in zip(self.free, row, strict=False)] for row in points])
        self.evaluations += len(points) * len(self.data)
        if self.tell is not None:
            self.tell(len(points) * len(self.data))
        return [one.simulate(self.instrument, self.names, np.ascontiguousarray(outer), self.threads) for one in self.data]

    def drive_noise(self, point: Array, known: Mapping[str, float]) -> Array:
        """How the residuals move when the drive is disturbed by its own noise: (M, K), none where it has none."""
        instrument = self.instrument.vary({one.parameter.name: one.outer(p) for one, p in zip(self.free, point, strict=False)})
        moved: list[Array] = []
        undisturbed = self.simulate(point[None])
        for i, one in enumerate(self.data):
            sigma = known.get(one.driving, one.recording.noise(one.driving) or 0.0)
            own = [sigma_k for (j, _), sigma_k in zip(self.channels, self.sigma, strict=True) if j == i]
            rows = one.rows * len(one.columns)
            if sigma == 0.0:
                moved.append(np.zeros((rows, 0)))
                continue
            played = one.disturbed(instrument, sigma, DISTURBED, self.threads)
            self.evaluations += DISTURBED
            kept = one.compared
            parts = [(played[name] - undisturbed[i][name])[:, kept] / s for name, s in zip(one.columns, own, strict=True)]
            moved.append(np.nan_to_num(np.concatenate(parts, axis=1).T))
        total, offset = sum(block.shape[1] for block in moved), 0
        found = np.zeros((sum(block.shape[0] for block in moved), total))
        # Every recording has noise of its own.
        row = 0
        for block in moved:
            found[row : row + block.shape[0], offset : offset + block.shape[1]] = block
            row, offset = row + block.shape[0], offset + block.shape[1]
        return found

    def _delay_s(self, point: Array, channel: int) -> float:
        return 1e-3 * float(point[len(self.free) + channel]) if self.delays else 0.0

    def fitted(self, point: Array, played: list[dict[str, Array]], row: int) -> list[Array]:
        """What each channel should read, its delay included."""
        found = []
        for channel, (i, name) in enumerate(self.channels):
            curve, delay_s = played[i][name][row], self._delay_s(point, channel)
            times = self.data[i].time_s
            late = curve if delay_s == 0.0 else np.interp(times - delay_s, times, curve)
            found.append(late[self.data[i].compared])
        return found

    def _left(self, point: Array, played: list[dict[str, Array]], row: int) -> Array:
        curves = self.fitted(point, played, row)
        parts = [
            (curve - self.data[i].measured[name]) / sigma
            for curve, (i, name), sigma in zip(curves, self.channels, self.sigma, strict=True)
        ]
        found: Array = np.concatenate(parts) * self.weights
        return found

    def residuals(self, point: Array) -> Array:
        if self._kept is not None and self._kept[0] == point.tobytes():
            return self._kept[1]
        left = self._left(point, self.simulate(point[None]), 0)
        if not np.all(np.isfinite(left)):
            # A variant that cannot be played is worse than any other.
            left = np.full_like(left, 1e6)
        self._kept = (point.tobytes(), left)
        return left

    def jacobian(self, point: Array, share: float = DIFFERENCES[1]) -> Array:
        """By derivatives of the model where they are asked for and the step is the usual one, else by differences."""
        return self.by_gradient(point) if self.exact and share == DIFFERENCES[1] else self.by_differences(point, share)

    def by_gradient(self, point: Array) -> Array:
        """Each recording once in numbers that carry derivatives, eight parameters at a time."""
        instrument = self.instrument.vary({one.parameter.name: one.outer(p) for one, p in zip(self.free, point, strict=False)})
        by: list[tuple[str, tuple[_erard.Instrument, _erard.Instrument, float] | None]] = [(name, None) for name in self.names]
        played = []
        for one in self.data:
            played.append(
                _erard.gradient(instrument._inner, by, one.stroke, one.duration_s, one.steps, one.every, self.threads, None)
            )
            self.differentiated += 1
            if self.tell is not None:
                self.tell(1)
        # Of a factor the logarithm counts, and the extension's factors begin at this instrument's: d/dlog is d/dfactor.
        scales = np.array([one.scale for one in self.free])
        blocks = []
        for channel, (i, name) in enumerate(self.channels):
            one, delay_s = self.data[i], self._delay_s(point, channel)
            times = one.time_s
            curves = [played[i]["columns"][name], *played[i]["column_slopes"][name]]
            moved = [np.interp(times - delay_s, times, curve[: len(times)]) for curve in curves]
            block = np.zeros((one.rows, len(point)))
            block[:, : len(self.free)] = (np.array(moved[1:]).T * scales)[one.compared]
            if self.delays:
                # 1e-3 s are what a delay is counted in.
                block[:, len(self.free) + channel] = -1e-3 * np.gradient(moved[0], times)[one.compared]
            blocks.append(block / self.sigma[channel])
        weights = self.weights if isinstance(self.weights, float) else self.weights[:, None]
        found: Array = np.nan_to_num(np.concatenate(blocks) * weights)
        return found

    def by_differences(self, point: Array, share: float) -> Array:
        """By central differences, all of them side by side in lanes."""
        count = len(self.free)
        by = np.array([share if one.parameter.is_factor else share * one.width for one in self.free])
        inside = np.clip
        low = np.array([one.inner(one.low) for one in self.free])
        high = np.array([one.inner(one.high) for one in self.free])
        points = np.repeat(point[None], 2 * count + 1, axis=0)
        for k in range(count):
            points[2 * k, k] = inside(point[k] - by[k], low[k], high[k])
            points[2 * k + 1, k] = inside(point[k] + by[k], low[k], high[k])
        played = self.simulate(points)
        columns = []
        for k in range(count):
            below, above = (self._left(points[row], played, row) for row in (2 * k, 2 * k + 1))
            columns.append((above - below) / (points[2 * k + 1, k] - points[2 * k, k]))
        self._kept = (point.tobytes(), self._left(point, played, 2 * count))
        for channel in range(self.delays):
            moved = []
            for sign in (-1.0, 1.0):
                other = point.copy()
                other[count + channel] += sign * 1e-2
                moved.append(self._left(other, played, 2 * count))
            columns.append((moved[1] - moved[0]) / 2e-2)
        found: Array = np.nan_to_num(np.column_stack(columns))
        return found


class Fit:
    """What a fit found.

    Attributes
    ----------
    x : dict of str to float
        What was fitted, as `Instrument.vary` takes it: turns of screws (m, rad, N m), factors of other parameters. `instrument` is the
        instrument with it.
    std : dict of str to float
        Standard deviations of `x`, from the covariance.
    values, errors : dict of str to float
        The same in SI units: masses, stiffnesses, settings.
    cov : ndarray of shape (P, P)
        Covariance of `x`, in its order.
    correlation : ndarray of shape (P, P)
    delays : dict of str to float
        How much later than the drive each channel was written down, s; empty where that was not estimated.
    noise : dict of str to float
        Root mean square of each channel's noise, N or m: estimated, or as given.
    residuals : ndarray of shape (M,)
        Fitted less measured, over the noise.
    chi2_reduced : float
        Sum of their squares over the degrees of freedom.
    chi2_expected : float
        What it should be if the model were true: 1 for the sensors' noise, and what the drive's noise adds, which moves the model itself.
    singular_values : ndarray of shape (P,)
        Of the Jacobian, every parameter counted in halves of what its bounds allow: below 1 a direction is known no better from the data than
        from its bounds.
    unseen : list of str
        Such directions in words.
    jacobian_agreement : float
        How far the Jacobian by differences depends on their step: the largest relative change of a column from one step to one sixteen times
        as long; with `jacobian="gradient"` from the derivatives to differences in the longer step. Where it is large, the recordings jump with the
        parameters, and the errors are to be doubted.
    """

    def __init__(
        self,
        problem: _Problem,
        point: Array,
        jacobian: Array,
        agreement: float,
        disturbed: Array,
        message: str,
    ) -> None:
        self._problem, self._point, self.message = problem, point, message
        free = problem.free
        count = len(free)
        self._names = problem.names
        self.x = {one.parameter.name: one.outer(p) for one, p in zip(free, point, strict=False)}
        self.residuals = problem.residuals(point)
        self.degrees_of_freedom = len(self.residuals) - len(point)
        self.chi2_reduced = float(self.residuals @ self.residuals) / self.degrees_of_freedom
        widths = np.array([one.width for one in free] + [1.0] * problem.delays)
        _, self.singular_values, directions = np.linalg.svd(jacobian * widths, full_matrices=False)
        self._directions = directions
        # What no sample sees is not known at all: its error is large, not zero.
        seen = np.maximum(self.singular_values, 1e-9 * max(float(self.singular_values[0]), 1e-300))
        scaled = (directions.T / seen) * widths[:, None]
        # Misfit beyond what the noise of sensors and drive explains makes all errors larger.
        self.chi2_expected = explained_by(disturbed)
        excess = max(1.0, self.chi2_reduced / self.chi2_expected)
        by_drive = scaled @ (left_of(jacobian * widths, seen, directions) @ disturbed) / math.sqrt(DISTURBED)
        inner = excess * (scaled @ scaled.T + by_drive @ by_drive.T)
        self._inner_cov, self._sensors_cov = inner, scaled @ scaled.T
        slopes = np.array([one.slope(p) for one, p in zip(free, point, strict=False)])
        self.cov = inner[:count, :count] * np.outer(slopes, slopes)
        self.std = dict(zip(self._names, map(float, np.sqrt(np.diag(self.cov))), strict=True))
        self.correlation = self.cov / np.outer(list(self.std.values()), list(self.std.values()))
        self.jacobian_agreement = agreement
        self.noise = {problem_title(problem, k): float(sigma) for k, sigma in enumerate(problem.sigma)}
        delays = enumerate(point[count:])
        self.delays = {problem_title(problem, k): 1e-3 * float(delay) for k, delay in delays}
        self.evaluations, self.differentiated = problem.evaluations, problem.differentiated

    @property
    def instrument(self) -> Instrument:
        """The instrument with what was fitted."""
        return self._problem.instrument.vary(self.x)

    @property
    def values(self) -> dict[str, float]:
        """What was fitted, in SI units."""
        own = self.instrument.parameters
        return {name: own[name].value for name in self.x}

    @property
    def errors(self) -> dict[str, float]:
        """Standard deviations in SI units."""
        own = self._problem.instrument.parameters
        return {name: std * (abs(own[name].value) if own[name].is_factor else 1.0) for name, std in self.std.items()}

    @property
    def unseen(self) -> list[str]:
        """Directions that the data tell no better than the bounds, in words."""
        told = []
        names = [*self._names, *(f"delay of {title}" for title in self.delays)]
        for value, direction in zip(self.singular_values, self._directions, strict=True):
            if value >= 1.0:
                continue
            large = np.argsort(-np.abs(direction))
            parts = [k for k in large if abs(direction[k]) > 0.3 * abs(direction[large[0]])][:4]
            sign = math.copysign(1.0, direction[parts[0]])
            words = ", ".join(f"{names[k]} {'up' if sign * direction[k] > 0 else 'down'}" for k in parts)
            told.append(f"{words}: the data leave {1.0 / max(float(value), 1e-12):.2g} times what the bounds allow")
        return told

    @property
    def channels(self) -> list[Channel]:
        """Every measured quantity beside what was fitted to it."""
        problem = self._problem
        curves = problem.fitted(self._point, problem.simulate(self._point[None]), 0)
        return [
            Channel(
                problem_title(problem, k),
                name,
                problem.data[i].time_s[problem.data[i].compared],
                problem.data[i].measured[name],
                curves[k],
                float(problem.sigma[k]),
                problem._delay_s(self._point, k),
            )
            for k, (i, name) in enumerate(problem.channels)
        ]

    def plot(self) -> matplotlib.figure.Figure:
        """Draws measured and fitted, and what is left over in units of the noise, channel by channel.

        Returns
        -------
        matplotlib.figure.Figure
        """
        from ._plot import fit_figure

        return fit_figure(self)

    def rows(self) -> list[tuple[str, str, str, str]]:
        """The rows of the report.

        Returns
        -------
        list of (str, str, str, str)
            Name, fitted value with its standard deviation and unit, the factor or turn, and the bounds.
        """
        found = []
        for one in self._problem.free:
            name, own = one.parameter.name, one.parameter
            value, error = self.values[name], self.errors[name]
            at_bound = min(abs(self.x[name] - one.low), abs(self.x[name] - one.high)) < 1e-3 * (one.high - one.low)
            told = f"{'*' if own.is_factor else ''}{self.x[name]:.5g} +- {self.std[name]:.2g}"
            bounds = f"{one.low:.4g} to {one.high:.4g}{' (at its end)' if at_bound else ''}"
            found.append((name, f"{value:.6g} +- {error:.2g} {own.unit}".rstrip(), told, bounds))
        return found

    def __str__(self) -> str:
        with_derivatives = f" and {self.differentiated} with derivatives" if self.differentiated else ""
        lines = [
            f"Fit of {self._problem.instrument.name} to {len(self._problem.data)} recordings, {len(self.residuals)} samples",
            f"  {self.message}; {self.evaluations} strokes played{with_derivatives}",
            f"  reduced chi2 {self.chi2_reduced:.3f}, of which the noise of sensors and drive explains {self.chi2_expected:.3f}",
        ]
        rows = [("", "value", "as vary takes it", "bounds"), *self.rows()]
        wide = [max(len(row[k]) for row in rows) for k in range(4)]
        lines += ["  " + "  ".join(cell.ljust(width) for cell, width in zip(row, wide, strict=True)).rstrip() for row in rows]
        pairs = [
            (abs(self.correlation[i, j]), f"  {a} and {b}: {self.correlation[i, j]:+.2f}")
            for i, a in enumerate(self._names)
            for j, b in enumerate(self._names[:i])
            if abs(self.correlation[i, j]) > 0.5
        ]
        if pairs:
            lines += ["Correlations above 0.5"] + [told for _, told in sorted(pairs, reverse=True)]
        lines += [f"Noise of {title}: {sigma:.3g}" for title, sigma in self.noise.items()]
        lines += [f"Delay of {title}: {1e3 * delay:.3f} ms" for title, delay in self.delays.items()]
        lines += [f"Not seen: {told}" for told in self.unseen]
        if silent := self._problem.silent:
            lines.append(
                f"The noise of {' and '.join(silent)}, which drives, is not known, and counts as none: where it has some, the errors above are too small; "
                f"sigma={{{', '.join(f'{name!r}: ...' for name in silent)}}} says it"
            )
        if self.jacobian_agreement > 0.1:
            lines.append(
                f"Doubtful: derivatives by differences change by {100 * self.jacobian_agreement:.0f} % with the length of their steps; "
                "the recordings jump with a parameter, and the errors above are too sure of themselves"
            )
        return "\n".join(lines)

    def __eq__(self, other: object) -> bool:
        """Whether the same was fitted to the same data, and the same found."""
        if not isinstance(other, Fit):
            return NotImplemented
        same = self.x == other.x and self.noise == other.noise and self._problem.instrument == other._problem.instrument
        return same and np.array_equal(self.cov, other.cov) and np.array_equal(self.residuals, other.residuals)

    __hash__ = None  # type: ignore[assignment]

    def __repr__(self) -> str:
        told = ", ".join(f"{name} {self.x[name]:.4g} +- {self.std[name]:.1g}" for name in self._names)
        return f"<erard.Fit: {told}>"

    def _repr_html_(self) -> str:
        return f"<pre>{html.escape(str(self))}</pre>"


def explained_by(disturbed: Array) -> float:
    """What the reduced chi2 should be: 1, and what a typical disturbance of the drive adds, recording by recording."""
    if disturbed.shape[1] == 0:
        return 1.0
    squares: Array = np.sum(disturbed**2, axis=0).reshape(-1, DISTURBED)
    typical = float(np.sum(np.median(squares, axis=1)))
    return 1.0 + typical / len(disturbed)


def left_of(scaled: Array, seen: Array, directions: Array) -> Array:
    """Left singular vectors, transposed, of a matrix whose right ones and values are known: (P, M)."""
    found: Array = ((scaled @ directions.T) / seen).T
    return found


def problem_title(problem: _Problem, channel: int) -> str:
    """What a channel is called: its column, and which recording where there are several."""
    i, name = problem.channels[channel]
    return name if len(problem.data) == 1 else f"{name} of recording {i}"


def fit(
    instrument: Instrument,
    recordings: RecordingLike | Sequence[RecordingLike],
    *,
    vary: Sequence[str],
    drive: str | None = None,
    columns: Sequence[str] | None = None,
    sigma: Mapping[str, float] | None = None,
    delay: bool = False,
    bounds: Mapping[str, tuple[float, float]] | None = None,
    start: Mapping[str, float] | None = None,
    loss: str = "linear",
    jacobian: str = "differences",
    restarts: int = 5,
    most: int = 50,
    threads: int | None = None,
    progress: bool | None = None,
    **how: Unpack[Stepping],
) -> Fit:
    """Fits parameters of an instrument to recordings, by least squares.

    Each recording drives the model, by its force where it has one, and what else was recorded is compared. `scipy.optimize.least_squares`
    moves the parameters; the derivatives are central differences, all variants played side by side in vector lanes.

    Parameters
    ----------
    instrument : Instrument
        Where the fit starts, and what is held fixed.
    recordings : recording or list of recordings
        A run, a mapping of arrays with `time_s`, a data frame, a file, or a `Recording`; several are fitted at once.
    vary : sequence of str
        What is fitted: screws and parameters by their names (`Instrument.parameters`).
    drive : {"force", "motion", "rigid"}, optional
        What of the recordings drives the model.
    columns : sequence of str, optional
        What is compared, of "force_N", "key_m", "hammer_head_m"; by default all but what drives.
    sigma : mapping of str to float, optional
        The noise of a column, root mean square, N or m; that of the drive, too, whose effect on the parameters is part of their errors. By default it
        is read from the rest before the touch or the spectrum; where neither tells it, from what is left over. Where nothing tells that of the
        drive it counts as none, and the report says so: a load cell's 20 mN can make errors ten times larger.
    delay : bool
        Estimate for every column how much later it was written down than what drives.
    bounds : mapping of str to (float, float), optional
        Of a parameter, as `vary` takes it. By default as far as the instrument's file says that its number may be off; where it does not say, a factor
        from 0.2 to 5, or a fiftieth of what a screw can do.
    start : mapping of str to float, optional
        Where to begin, as `vary` takes it.
    loss : {"linear", "soft_l1", "huber", "cauchy"}
        "linear" is plain least squares; the others heed outliers less. The covariance is that of plain least squares.
    jacobian : {"differences", "gradient"}
        Where the derivatives of the last steps and of the covariance come from: central differences, or the model's own (`gradient`), which need no
        step but cost more. The first steps, which are to look past what jumps, are differences in any case.
        Both find the same; a Jacobian of the model's own derivatives takes about six times as long, for differences are played side by side in lanes.
    restarts : int
        How often the fit may begin again elsewhere, until two have ended alike with no more left over than noise: where friction sticks and felts
        open, sums of squares have more than one minimum.
    most : int
        Most steps of the solver.
    threads : int, optional
        By default as many as there are cores.
    progress : bool, optional
        Count the strokes that are played; by default on a terminal or in a notebook, if it takes more than a second.
    **how
        How to step, as in `Instrument.press`.

    Returns
    -------
    Fit
        `x`, `std`, `cov`, `residuals`, `plot()`, `instrument`, `unseen`; printed it is a report.

    Raises
    ------
    InputError
        Where a name, a bound or a recording is wrong.
    SimulationError
        Where the model cannot be played where the fit starts.

    Examples
    --------
    >>> import erard, numpy as np
    >>> grand = erard.load("concert-grand")
    >>> true = grand.vary({"body.hammer.mass": 1.04})
    >>> run, rng = true.press(stroke="p", duration=0.1), np.random.default_rng(1)
    >>> mine = {"time_s": run["time_s"][::20], "force_N": run["force_N"][::20],
    ...         "key_m": run["key_m"][::20] + 1e-5 * rng.standard_normal(101)}
    >>> found = erard.fit(grand, mine, vary=["body.hammer.mass"], sigma={"key_m": 1e-5})
    >>> bool(abs(found.x["body.hammer.mass"] - 1.04) < 4 * found.std["body.hammer.mass"])
    True
    """
    with counter(progress, "fit", "strokes") as tell:
        return _fit(
            instrument_of(instrument), recordings, vary, drive, columns, sigma, delay, bounds, start, loss, jacobian, restarts, most, threads,
            tell, steps(how),
        )  # fmt: skip


def _fit(
    instrument: Instrument,
    recordings: RecordingLike | Sequence[RecordingLike],
    vary: Sequence[str],
    drive: str | None,
    columns: Sequence[str] | None,
    sigma: Mapping[str, float] | None,
    delay: bool,
    bounds: Mapping[str, tuple[float, float]] | None,
    start: Mapping[str, float] | None,
    loss: str,
    jacobian: str,
    restarts: int,
    most: int,
    threads: int | None,
    tell: Callable[[int], None] | None,
    own: Steps,
) -> Fit:
    from scipy.optimize import least_squares

    if loss not in LOSSES:
        raise InputError(f"loss: found {loss!r}, expected {', '.join(LOSSES)}", key="loss", found=str(loss))
    if jacobian not in JACOBIANS:
        raise InputError(f"jacobian: found {jacobian!r}, expected {' or '.join(JACOBIANS)}", key="jacobian", found=str(jacobian))
    restarts, most = whole("restarts", restarts, 0), whole("most", most)
    sources: list[Any] = list(recordings) if isinstance(recordings, (list, tuple)) else [recordings]
    if not sources:
        raise InputError("recordings: found none, expected one or more", key="recordings")
    free = _free(instrument, vary, bounds or {})
    data = [_Data(source, drive, columns, own) for source in sources]
    problem = _Problem(instrument, free, data, delay, threads)
    problem.tell = tell
    known = {name: number(f"sigma[{name!r}]", value) for name, value in (sigma or {}).items()}
    usable = {name for _, name in problem.channels} | {one.driving for one in data}
    if unknown := set(known) - usable:
        raise InputError(f"sigma: {', '.join(sorted(unknown))} is not compared and does not drive", key="sigma")
    told = [known.get(name, data[i].recording.noise(name)) for i, name in problem.channels]
    problem.silent = sorted({one.driving for one in data if one.driving not in known and one.recording.noise(one.driving) is None})
    problem.sigma = np.array([COLUMNS[name] if s is None else s for s, (_, name) in zip(told, problem.channels, strict=True)])
    if np.any(problem.sigma <= 0):
        raise InputError("sigma: expected positive numbers", key="sigma")
    low = np.array([one.inner(one.low) for one in free] + [-20.0] * problem.delays)
    high = np.array([one.inner(one.high) for one in free] + [20.0] * problem.delays)
    asked = {name: number(f"start[{name!r}]", value) for name, value in (start or {}).items()}
    if unknown := set(asked) - set(problem.names):
        raise InputError(f"start: {', '.join(sorted(unknown))} is not varied", key="start")
    for one in free:
        if not one.low <= asked.get(one.parameter.name, one.low) <= one.high:
            begun = asked[one.parameter.name]
            raise InputError(f"start: {one.parameter.name} at {begun}; its bounds are {one.low} and {one.high}", key="start", found=str(begun))
    first = [one.inner(asked.get(one.parameter.name, 1.0 if one.parameter.is_factor else 0.0)) for one in free]
    margin = 1e-6 * (high - low)
    begin = np.clip(np.array(first + [0.0] * problem.delays), low + margin, high - margin)
    if np.all(problem.residuals(begin) == 1e6):
        raise SimulationError("the instrument cannot be played where the fit starts")
    if jacobian == "gradient":
        if any(data[i].stroke.drive == "rigid" and name == "force_N" for i, name in problem.channels):
            told_why = "force_N has no derivatives under a rigid drive, whose force is what its motion takes"
            raise InputError(f"jacobian: {told_why}; expected differences", key="jacobian", found=jacobian)
        # What has no derivatives says so before the work begins.
        problem.by_gradient(begin)
        problem.exact = True

    def solve(point: Array, share: float, loss: str, most: int) -> tuple[Array, float, str]:
        problem._kept = None
        solved = least_squares(
            problem.residuals, point, jac=lambda p: problem.jacobian(p, share), bounds=(low, high), x_scale="jac",
            loss=loss, max_nfev=most,
        )  # fmt: skip
        return np.asarray(solved.x, dtype=np.float64), float(np.mean(solved.fun**2)), str(solved.message).rstrip(".")

    rng = np.random.default_rng(0)
    ends: list[float] = []
    best: tuple[float, Array, str, Array] | None = None
    for attempt in range(1 + restarts):
        from_here = begin
        if attempt and best is not None:
            # Not far: from elsewhere in wide bounds few come back.
            far = 0.2 * np.minimum(high - low, 1.0) * (np.arange(len(begin)) < len(free))
            away = best[1] + far * rng.uniform(-1, 1, len(begin))
            from_here = np.clip(away, low + margin, high - margin)
        # First what leads to the blow, which is smooth; then all of it, in steps that look past what jumps.
        problem.weights = problem.until_the_blow(from_here)
        point, _, _ = solve(from_here, COARSE, "soft_l1", 20)
        problem.weights = 1.0
        point, _, _ = solve(point, COARSE, "soft_l1", 15)
        point, left, message = solve(point, DIFFERENCES[1], loss, most)
        for _ in range(3):
            # The noise that nothing tells is estimated with the parameters held and the other way round, until neither
            # moves.
            if all(s is not None for s in told) or _noise(problem, point, told):
                break
            point, left, message = solve(point, DIFFERENCES[1], loss, most)
        ends.append(left)
        if best is None or left < best[0]:
            best = (left, point, message, problem.drive_noise(point, known))
        # Two that end alike, and leave no more than the sensors' noise, have found the place.
        if sum(end < AGREED * best[0] for end in ends) >= 2 and best[0] <= MISFIT:
            break
    _, point, message, disturbed = best  # type: ignore[misc]
    problem._kept = None
    found, wide = problem.jacobian(point), problem.by_differences(point, DIFFERENCES[0])
    other = found if problem.exact else problem.by_differences(point, DIFFERENCES[2])
    problem.tell = None
    return Fit(problem, point, found, _agreement(wide, other), disturbed, message)


def _noise(problem: _Problem, point: Array, told: Sequence[float | None]) -> bool:
    """Estimates the noise of every channel of which nothing tells it from what is left over; whether it stays as it was."""
    left = np.split(problem.residuals(point), np.cumsum([problem.data[i].rows for i, _ in problem.channels])[:-1])
    share = 1.0 - len(point) / sum(map(len, left))
    before = problem.sigma.copy()
    for k, own in enumerate(told):
        if own is None:
            problem.sigma[k] *= max(float(np.sqrt(np.mean(left[k] ** 2) / share)), 1e-9)
    return bool(np.all(np.abs(problem.sigma / before - 1.0) < 0.02))


def _agreement(one: Array, other: Array) -> float:
    """The largest relative difference between columns of two Jacobians."""
    size = np.linalg.norm(other, axis=0)
    return float(np.max(np.linalg.norm(one - other, axis=0) / np.where(size > 0, size, 1.0)))


class Posterior:
    """Samples of what the parameters may be, given the recordings.

    Attributes
    ----------
    samples : ndarray of shape (S, P)
        As `Instrument.vary` takes them, in the order of `names`.
    names : list of str
    acceptance : float
        Share of the proposals that were accepted; 0.2 to 0.5 is well.
    """

    def __init__(self, names: list[str], samples: Array, acceptance: float) -> None:
        self.names, self.samples, self.acceptance = names, samples, acceptance

    @property
    def mean(self) -> dict[str, float]:
        """Means of the samples."""
        return dict(zip(self.names, map(float, self.samples.mean(axis=0)), strict=True))

    @property
    def std(self) -> dict[str, float]:
        """Standard deviations of the samples."""
        return dict(zip(self.names, map(float, self.samples.std(axis=0)), strict=True))

    def interval(self, share: float = 0.95) -> dict[str, tuple[float, float]]:
        """The middle interval of every parameter that holds a share of the samples.

        Parameters
        ----------
        share : float
            From 0 to 1.

        Returns
        -------
        dict of str to (float, float)
        """
        low, high = np.quantile(self.samples, [(1 - share) / 2, (1 + share) / 2], axis=0)
        return {name: (float(a), float(b)) for name, a, b in zip(self.names, low, high, strict=True)}

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Posterior) and self.names == other.names and np.array_equal(self.samples, other.samples)

    __hash__ = None  # type: ignore[assignment]

    def __repr__(self) -> str:
        told = ", ".join(f"{name} {self.mean[name]:.4g} +- {self.std[name]:.1g}" for name in self.names)
        return f"<erard.Posterior of {len(self.samples)} samples, acceptance {self.acceptance:.2f}: {told}>"


def sample(
    found: Fit,
    *,
    sampler: str = "emcee",
    walkers: int | None = None,
    length: int = 200,
    burn: int = 100,
    seed: int = 0,
    progress: bool | None = None,
) -> Posterior:
    """Samples the posterior of a fit: Gaussian noise as the fit found it, within its bounds all alike (logarithms of factors).

    Noise of what drives and misfit beyond all noise widen it as they widen the errors of the fit: the likelihood is that of the sensors' noise, its
    curvature at the best point adjusted (Chandler and Bate, Biometrika 94, 2007).

    Parameters
    ----------
    found : Fit
    sampler : {"emcee", "nuts"}
        emcee's walkers need no derivatives, and are played side by side in lanes. "nuts" is Hamiltonian sampling by nutpie (`pip install erard[nuts]`) with the
        model's own derivatives; each of its steps costs some ten presses with derivatives, one after the other, so that it is slower but for many
        parameters that depend on each other.
    walkers : int, optional
        Of emcee at least twice as many as there are parameters (default 32), half of them side by side; of "nuts" chains, one after the other (default 2).
    length, burn : int
        Steps of every walker that are kept, and that are thrown away before.
    seed : int
    progress : bool, optional
        Count the strokes that are played.

    Returns
    -------
    Posterior
    """
    if not isinstance(found, Fit):
        raise InputError(f"found: found {type(found).__name__}, expected what erard.fit found", key="found")
    if sampler not in ("emcee", "nuts"):
        raise InputError(f"sampler: found {sampler!r}, expected emcee or nuts", key="sampler", found=str(sampler))
    if walkers is None:
        walkers = 32 if sampler == "emcee" else 2
    walkers, length, burn = whole("walkers", walkers), whole("length", length), whole("burn", burn, 0)
    problem = found._problem
    count = len(problem.free) + problem.delays
    if sampler == "emcee" and walkers < 2 * count:
        raise InputError(f"walkers: found {walkers}, expected {2 * count} or more", key="walkers", found=str(walkers))
    low = np.array([one.inner(one.low) for one in problem.free] + [-20.0] * problem.delays)
    high = np.array([one.inner(one.high) for one in problem.free] + [20.0] * problem.delays)

    # Nearer to the best point by so much as the sensors' errors are smaller than all of them.
    sizes = np.sqrt(np.diag(found._sensors_cov))
    sensors, everything = (np.linalg.cholesky(cov / np.outer(sizes, sizes)) for cov in (found._sensors_cov, found._inner_cov))
    nearer = sizes[:, None] * (sensors @ np.linalg.inv(everything)) / sizes

    rng = np.random.default_rng(seed)
    spread = np.sqrt(np.clip(np.diag(found._inner_cov), 0.0, ((high - low) / 6) ** 2))
    first = np.clip(found._point + spread * rng.standard_normal((walkers, count)), low + 1e-9, high - 1e-9)
    with counter(progress, "sample", "strokes") as problem.tell:
        try:
            draw = _by_emcee if sampler == "emcee" else _by_nuts
            chain, acceptance = draw(found, first, nearer, low, high, length, burn, seed)
        finally:
            problem.tell = None
    outer = np.column_stack([[one.outer(p) for p in chain[:, k]] for k, one in enumerate(problem.free)])
    return Posterior(problem.names, outer, acceptance)


def _by_emcee(
    found: Fit, first: Array, nearer: Array, low: Array, high: Array, length: int, burn: int, seed: int
) -> tuple[Array, float]:
    import emcee

    problem = found._problem

    def log_probability(points: Array) -> Array:
        inside = np.all((points > low) & (points < high), axis=1)
        found_log = np.full(len(points), -np.inf)
        if not np.any(inside):
            return found_log
        kept = found._point + (points[inside] - found._point) @ nearer.T
        played = problem.simulate(kept)
        left = np.array([problem._left(kept[row], played, row) for row in range(len(kept))])
        chi2 = np.sum(left**2, axis=1)
        found_log[inside] = np.where(np.isfinite(chi2), -0.5 * chi2, -np.inf)
        return found_log

    walkers, count = first.shape
    sampler = emcee.EnsembleSampler(walkers, count, log_probability, vectorize=True)
    sampler.random_state = np.random.RandomState(seed).get_state()
    sampler.run_mcmc(first, burn + length)
    return sampler.get_chain(discard=burn, flat=True), float(np.mean(sampler.acceptance_fraction))


def _by_nuts(
    found: Fit, first: Array, nearer: Array, low: Array, high: Array, length: int, burn: int, seed: int
) -> tuple[Array, float]:
    """The no-U-turn sampler over the logits of where the parameters stand between their bounds."""
    import nutpie
    from nutpie.compiled_pyfunc import from_pyfunc

    problem, width = found._problem, high - low
    chains, count = first.shape

    def place(z: Array) -> Array:
        return low + width / (1.0 + np.exp(-z))

    def make_logp() -> Callable[[Array], tuple[float, Array]]:
        def logp(z: Array) -> tuple[float, Array]:
            share = np.clip(1.0 / (1.0 + np.exp(-z)), 1e-12, 1.0 - 1e-12)
            slope = width * share * (1.0 - share)
            kept = found._point + nearer @ (place(z) - found._point)
            kept = np.clip(kept, low + 1e-9 * width, high - 1e-9 * width)
            left = problem.residuals(kept)
            by_place = -(left @ problem.by_gradient(kept)) @ nearer
            return -0.5 * float(left @ left) + float(np.sum(np.log(slope))), by_place * slope + 1.0 - 2.0 * share

        return logp

    def make_expand(*_: Any) -> Callable[[Array], dict[str, Array]]:
        return lambda z: {"inner": place(z)}

    starts = iter(np.log((first - low) / (high - first)))
    model = from_pyfunc(
        count, make_logp, make_expand, [np.dtype(np.float64)], [(count,)], ["inner"],
        make_initial_point_fn=lambda _: next(starts, np.log((found._point - low) / (high - found._point))),
    )  # fmt: skip
    trace = nutpie.sample(model, draws=length, tune=burn, chains=chains, cores=1, seed=seed, save_warmup=False, progress_bar=False)
    chain: Array = np.asarray(trace.posterior["inner"]).reshape(-1, count)
    return chain, float(np.mean(np.asarray(trace.sample_stats["mean_tree_accept"])))
