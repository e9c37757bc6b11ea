"""Least-squares fits of instrument parameters to recordings, with their uncertainties.

The extension fits, as the command `erard fit` does. This module turns the results into arrays, figures and pickles, and
offers SciPy's solver.
"""

from __future__ import annotations

import html
import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple, TypeAlias, Unpack

import numpy as np

from . import _erard
from ._common import Stepping, choice, counter, flag, mapping, names_of, number, refused, steps, text_of, value_of, whole
from ._errors import DoubtfulFitWarning, Extra, InputError
from ._instrument import DRIVES, Instrument, instrument_of
from ._recording import Recording, as_recording

if TYPE_CHECKING:
    import matplotlib.figure
    from numpy.typing import NDArray

    from ._recording import RecordingLike
    from ._types import Fitted, Steps

    Array: TypeAlias = NDArray[np.float64]

#: Names of the minimizers.
MINIMIZERS = ("erard", "scipy")


@dataclass(frozen=True, eq=False)
class Channel:
    """One measured quantity of one recording with its fitted values; arrays of shape (T,), SI units."""

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


class Doubt(NamedTuple):
    """Reason to doubt a fit.

    Attributes
    ----------
    kind : str
        "no_impact": the hammer reaches the string in the recording, but not in the fitted model. "misfit": the
        residuals exceed the noise, or their course is not that of noise. "too_short": the noise is correlated for so long
        that the recordings hold fewer than ten independent samples for each parameter, and no errors are given. "bound": a parameter ended at
        a bound. "restarts": fits from several starts ended at different points. "beyond_impact": the data continue
        after the first impact. "derivatives": the derivatives depend on the step of their differences. "noise_unknown":
        the noise of a column is unknown; it is taken as zero for a drive and estimated from the residuals for a
        compared column. "recording": a recording does not look as it should.
    text : str
        Finding and its meaning.
    """

    kind: str
    text: str


class Asked(NamedTuple):
    """Arguments of a problem."""

    instrument: Instrument
    parameters: list[str]
    bounds: list[tuple[str, tuple[float | str, float | str]]]
    recordings: list[Recording]
    drive: str | None
    columns: list[str] | None
    delays: bool
    sigma: list[tuple[str, float]]
    own: Steps
    threads: int | None


class Problem:
    """Residuals and their Jacobian over the inner parameters: those of the instrument, then the delays in ms. Pickling
    keeps the arguments and the noise."""

    def __init__(self, asked: Asked, sigma: list[tuple[float, float]] | None = None) -> None:
        self.asked = asked
        inner = [recording._inner for recording in asked.recordings]
        self._inner = _erard.Problem(
            asked.instrument._inner, asked.parameters, asked.bounds, inner, asked.drive, asked.columns, asked.delays, asked.sigma, asked.own, asked.threads
        )
        if sigma is not None:
            self._inner.set_sigma(sigma)

    def __reduce__(self) -> tuple[Any, ...]:
        return Problem, (self.asked, self._inner.sigma())

    def bounds(self) -> tuple[Array, Array]:
        """Returns lower and upper bounds of the inner parameters, each of shape (P,)."""
        low, high = self._inner.bounds()
        return np.array(low), np.array(high)

    def outer(self, points: Array) -> Array:
        """Converts inner points, row by row, to turns and factors as in `Fit.x`."""
        return self._inner.outer(np.ascontiguousarray(points))

    def residuals(self, points: Array, tell: Callable[[int], None] | None = None) -> Array:
        """Returns the residuals, (fitted - measured) / noise, whitened as the noise is correlated, one row for each
        point; nan for points that cannot be played."""
        return self._inner.residuals(np.ascontiguousarray(points), tell)

    def jacobian(self, point: Array, exact: bool = False) -> Array:
        """Returns the derivatives of the residuals at a point, (M, P): differences, or the model's own if `exact`."""
        return self._inner.jacobian(list(point), exact)

    def channels(self, point: Array) -> list[Channel]:
        """Returns every measured quantity with the model's values at a point."""
        return [
            Channel(title, column, times, measured, fitted, sigma, delay_s)
            for title, _, column, times, measured, fitted, sigma, delay_s in self._inner.curves(list(point))
        ]


class Fit:
    """Result of a fit.

    Attributes
    ----------
    x : dict of str to float
        Fitted changes from the instrument at the start: turns of screws (m, rad, N m), factors of other parameters.
        `instrument` is the instrument with these changes, `values` holds the values.
    std : dict of str to float
        Standard deviations of `x`, from the covariance, due to noise alone. nan, like `cov`, if the recordings are too
        short for the correlation of their noise ("too_short" among the doubts).
    values, errors : dict of str to float
        Fitted parameters and their standard deviations in SI units: masses, stiffnesses, settings.
    intervals : dict of str to (float, float)
        95 % intervals of `values`: Student's, because the estimates of noise and correlation scatter, too.
    independent_samples : float
        Number of independent samples that have as precise a mean as the compared ones. Errors need ten for every
        parameter and delay.
    correlation_times : dict of str to float
        Correlation time of the noise of each channel, s, estimated from the residuals: the correlation falls as
        exp(-t / time). 0 for white noise.
    cov : ndarray of shape (P, P)
        Covariance of `x`, in the order of its names.
    correlation : ndarray of shape (P, P)
    delays : dict of str to float
        Delay of each channel behind the drive, s; empty if delays were not estimated.
    noise : dict of str to float
        Root mean square noise of each channel, N, m or m/s: as given, as measured on the recording, or estimated from
        the residuals.
    rms_at_start, rms : dict of str to float
        Root mean square of (fitted - measured) of each channel at the start of the fit and at its end, N, m or m/s.
    residuals : ndarray of shape (M,)
        Residuals, (fitted - measured) / noise.
    chi2_reduced : float or None
        Sum of the squared residuals, whitened as their noise is correlated, over the degrees of freedom. `None` if a channel's noise was estimated from its
        residuals, because the value is then 1 for any fit.
    chi2_expected : float or None
        Expected `chi2_reduced` of a true model: 1 from the sensors' noise, plus the contribution of the drive's noise.
    doubts : list of Doubt
        Reasons to doubt the result; empty if there are none. `erard.fit` reports them in a `DoubtfulFitWarning`.
    singular_values : ndarray of shape (P,)
        Singular values of the Jacobian, with each parameter scaled by half the width of its bounds. Below 1, the data
        determine a direction no better than its bounds do.
    unseen : list of str
        Directions with a singular value below 1, in words.
    jacobian_agreement : float
        Sensitivity of the Jacobian to the step of the differences: the largest relative change of a column between one
        step and a step sixteen times as long; with `jacobian="gradient"`, between the derivatives and differences with
        the longer step. If it is large, the model jumps with the parameters, and the errors are not reliable.
    time_step_agreement : float
        Error of the Jacobian due to the time step: the largest relative error of a column, estimated as twice its change
        in half the step.
    """

    def __init__(self, problem: Problem, found: Fitted) -> None:
        self._problem, self._found = problem, found
        self._point, self.message = found["point"], found["message"]
        names = [row[0] for row in found["free"]]
        self.x = dict(zip(names, found["x"], strict=True))
        self.std = dict(zip(names, found["std"], strict=True))
        self.intervals = dict(zip(names, found["intervals"], strict=True))
        self.independent_samples = found["independent_samples"]
        self.values = {name: value for name, (value, _) in zip(names, found["values"], strict=True)}
        self.errors = {name: error for name, (_, error) in zip(names, found["values"], strict=True)}
        self.cov, self._inner_cov, self._sensors_cov = found["cov"], found["inner_cov"], found["sensors_cov"]
        self.correlation: Array = self.cov / np.outer(found["std"], found["std"])
        self.residuals, self.degrees_of_freedom = found["residuals"], found["degrees_of_freedom"]
        self.chi2_reduced, self.chi2_expected = found["chi2_reduced"], found["chi2_expected"]
        self.doubts = [Doubt(kind, text) for kind, text in found["doubts"]]
        self.singular_values, self.unseen = found["singular_values"], found["unseen"]
        self.jacobian_agreement = found["jacobian_agreement"]
        self.time_step_agreement = found["time_step_agreement"]
        channels = found["channels"]
        self.noise = {title: sigma for title, sigma, *_ in channels}
        self.correlation_times = {title: time_s for title, _, _, time_s, *_ in channels}
        self.rms_at_start = {title: start for title, _, _, _, start, *_ in channels}
        self.rms = {title: end for title, _, _, _, _, end, _ in channels}
        self.delays = {title: delay for title, *_, delay in channels if delay is not None}
        self.evaluations, self.differentiated = found["evaluations"], found["differentiated"]

    @property
    def instrument(self) -> Instrument:
        """Instrument with the fitted values."""
        start = self._problem.asked.instrument
        known = start.parameters
        return start.vary({name: f"{by:+}" if known[name].is_screw else f"x{by}" for name, by in self.x.items()})

    @property
    def channels(self) -> list[Channel]:
        """Every measured quantity with its fitted values."""
        return self._problem.channels(self._point)

    def plot(self) -> matplotlib.figure.Figure:
        """Draws measured and fitted values, and the residuals in units of the noise, channel by channel.

        Returns
        -------
        matplotlib.figure.Figure
        """
        from ._plot import fit_figure

        return fit_figure(self)

    def rows(self) -> list[tuple[str, str, str, str]]:
        """Returns the rows of the report.

        Returns
        -------
        list of (str, str, str, str)
            Name, fitted value with its standard deviation and unit, the factor or turn, and the bounds.
        """
        found = []
        for name, unit, is_factor, low, high, at_bound in self._found["free"]:
            told = f"{'x' if is_factor else ''}{self.x[name]:.5g} +- {self.std[name]:.2g}"
            bounds = f"{low:.4g} to {high:.4g}{' (at its end)' if at_bound else ''}"
            found.append((name, f"{self.values[name]:.6g} +- {self.errors[name]:.2g} {unit}".rstrip(), told, bounds))
        return found

    def __str__(self) -> str:
        with_derivatives = f" and {self.differentiated} with derivatives" if self.differentiated else ""
        asked = self._problem.asked
        lines = [
            *(f"Doubtful: {doubt.text}." for doubt in self.doubts),
            f"Fit of {asked.instrument.name} to {len(asked.recordings)} recordings, {len(self.residuals)} samples",
            f"  {self.message}; {self.evaluations} strokes played{with_derivatives}",
            "  reduced chi2: not a test, because the noise is estimated from the residuals"
            if self.chi2_reduced is None or self.chi2_expected is None
            else f"  reduced chi2 {self.chi2_reduced:.3f}, of which the noise of sensors and drive explains {self.chi2_expected:.3f}",
        ]
        rows = [("", "value", "change", "bounds"), *self.rows()]
        wide = [max(len(row[k]) for row in rows) for k in range(4)]
        lines += ["  " + "  ".join(cell.ljust(width) for cell, width in zip(row, wide, strict=True)).rstrip() for row in rows]
        for name, explanation, quantity, unit, before, value, std in self._found["meanings"]:
            lines += [f"  {name} is {explanation}: {quantity} {value:.4g} +- {std:.2g} {unit}, at the start {before:.4g} {unit}"]
        names = list(self.x)
        if pairs := self._found["correlated"]:
            lines += ["Correlations above 0.5", *(f"  {names[i]} and {names[j]}: {r:+.2f}" for i, j, r in pairs)]
        lines += ["Fitted less measured, root mean square, SI"]
        for title, noise, is_known, time_s, start, end, _ in self._found["channels"]:
            whence = ("" if is_known else ", from the residuals") + (f", correlated over {1e3 * time_s:.2f} ms" if time_s > 0.0 else "")
            lines += [f"  {title}: {start:.3g} at the start, {end:.3g} at the end; noise {noise:.3g}{whence}"]
        lines += [f"Delay of {title}: {1e3 * delay:.3f} ms" for title, delay in self.delays.items()]
        lines += [f"Not seen: {told}" for told in self.unseen]
        return "\n".join(lines)

    def __eq__(self, other: object) -> bool:
        """Whether instrument, noise, fitted values, covariance and residuals are equal."""
        if not isinstance(other, Fit):
            return NotImplemented
        same = self.x == other.x and self.noise == other.noise and self._problem.asked.instrument == other._problem.asked.instrument
        return same and np.array_equal(self.cov, other.cov) and np.array_equal(self.residuals, other.residuals)

    __hash__ = None  # type: ignore[assignment]

    def __repr__(self) -> str:
        told = ", ".join(f"{name} {self.x[name]:.4g} +- {self.std[name]:.1g}" for name in self.x)
        return f"<erard.Fit: {told}>"

    def _repr_html_(self) -> str:
        return f"<pre>{html.escape(str(self))}</pre>"


def fit(
    instrument: Instrument,
    recordings: RecordingLike | Sequence[RecordingLike],
    *,
    parameters: Sequence[str],
    drive: str | None = None,
    columns: Sequence[str] | None = None,
    sigma: Mapping[str, float] | None = None,
    delays: bool = False,
    bounds: Mapping[str, tuple[float | str, float | str]] | None = None,
    start: Mapping[str, float | str] | None = None,
    loss: str = "linear",
    jacobian: str = "differences",
    minimizer: str = "erard",
    restarts: int = 5,
    max_evaluations: int = 50,
    threads: int | None = None,
    progress: bool | None = None,
    **how: Unpack[Stepping],
) -> Fit:
    """Fits parameters of an instrument to recordings, by least squares.

    Each recording drives the model, by its force if there is one, and its other columns are compared with the model.
    The results are those of the command `erard fit`, to the bit. A trust-region method moves the parameters within
    their bounds; the derivatives are central differences, with all variants played side by side in vector lanes. The
    driving column is prepared as the `Recording` was; compared columns are not filtered, because a filter makes the
    noise look too small.

    Parameters
    ----------
    instrument : Instrument
        Start of the fit; it holds all parameters that are not fitted.
    recordings : recording or list of recordings
        A run, a mapping of arrays with `time_s`, a data frame, a file, or a `Recording`; several are fitted together.
    parameters : sequence of str
        Names of the screws and parameters to fit (`Instrument.parameters`).
    drive : {"force", "motion", "rigid"}, optional
        Quantity of the recordings that drives the model.
    columns : sequence of str, optional
        Compared columns, of "force_N", "key_m", "hammer_rise_m", "hammer_rise_m_per_s"; by default all but the driving
        one.
    sigma : mapping of str to float, optional
        Root mean square noise of columns, N, m or m/s. The errors of the parameters include the noise of the drive. By
        default the noise is measured in the rest before the touch or in the spectrum. If neither shows it, it is
        estimated from the residuals for a compared column and taken as zero for the drive; each of these is a doubt.
        The 20 mN of a load cell can make errors ten times larger.
    delays : bool
        Whether to estimate the delay of every column behind the drive.
    bounds : mapping of str to (float or str, float or str), optional
        Bounds of parameters, as `Instrument.vary` takes them: ("x0.5", "x2"), ("-1 mm", "+1 mm"), (8e-3, 12e-3). By default they are the uncertainty that the instrument's file
        states; without one, a factor of 0.2 to 5, or for a screw a fiftieth of its range.
    start : mapping of str to float or str, optional
        Start values, as `Instrument.vary` takes them.
    loss : {"linear", "soft_l1", "huber", "cauchy"}
        "linear" is plain least squares; the others give outliers less weight. The covariance is that of plain least squares.
    jacobian : {"differences", "gradient"}
        Derivatives of the last steps and of the covariance: central differences, or the model's own derivatives
        ("gradient"), which depend on no step. The first steps always use differences, which smooth over jumps. Both
        give the same result. A Jacobian of the model's own derivatives takes about six times as long, because
        differences are played side by side in lanes.
    minimizer : {"erard", "scipy"}
        Minimizer: the library's own, or `scipy.optimize.least_squares` on the same residuals and through the same
        stages.
    restarts : int
        Largest number of restarts from other points. Restarts end when two fits agree and their residuals are no larger
        than the noise. With sticking friction and opening felts, the sum of squares has more than one minimum.
    max_evaluations : int
        Largest number of solver steps.
    threads : int, optional
        Number of threads; by default the number of cores.
    progress : bool, optional
        Whether to count the strokes that are played; by default on a terminal or in a notebook, after one second.
    **how
        Settings of the steps, as in `Instrument.press`.

    Returns
    -------
    Fit
        The result; printing it gives a report.

    Warns
    -----
    DoubtfulFitWarning
        If `Fit.doubts` is not empty.

    Raises
    ------
    InputError
        If a name, a bound or a recording is wrong.
    SimulationError
        If the model cannot be played at the start of the fit.

    Examples
    --------
    >>> import erard, numpy as np
    >>> grand = erard.load("concert-grand")
    >>> true = grand.vary({"body.hammer.mass": "x1.04"})
    >>> run, rng = true.press(stroke="p", duration=0.1), np.random.default_rng(1)
    >>> mine = {"time_s": run["time_s"][::20], "force_N": run["force_N"][::20],
    ...         "key_m": run["key_m"][::20] + 1e-5 * rng.standard_normal(101)}
    >>> found = erard.fit(grand, mine, parameters=["body.hammer.mass"], sigma={"key_m": 1e-5, "force_N": 0.0})
    >>> found.doubts
    []
    >>> bool(abs(found.x["body.hammer.mass"] - 1.04) < 4 * found.std["body.hammer.mass"])
    True
    """
    choice("minimizer", minimizer, MINIMIZERS)
    choice("jacobian", jacobian, ("differences", "gradient"))
    text_of("loss", loss, "the name of a loss")
    restarts, max_evaluations = whole("restarts", restarts, 0), whole("max_evaluations", max_evaluations)
    sources: list[Any] = list(recordings) if isinstance(recordings, (list, tuple)) else [recordings]
    asked = Asked(
        instrument_of(instrument),
        names_of("parameters", parameters),
        [(name, _bounds(name, limits)) for name, limits in mapping("bounds", bounds).items()],
        [as_recording(source) for source in sources],
        None if drive is None else choice("drive", drive, DRIVES),
        None if columns is None else names_of("columns", columns),
        flag("delays", delays),
        [(name, number(f"sigma[{name!r}]", value)) for name, value in mapping("sigma", sigma).items()],
        steps(how),
        None if threads is None else whole("threads", threads),
    )
    begin = [(name, value_of(f"start[{name!r}]", value)) for name, value in mapping("start", start).items()]
    problem = Problem(asked)
    with counter(progress, "fit", "strokes") as tell:
        found = problem._inner.fit((begin, loss, jacobian, restarts, max_evaluations), _by_scipy if minimizer == "scipy" else None, tell)
    fitted = Fit(problem, found)
    if fitted.doubts:
        warnings.warn("doubtful fit: " + "; ".join(doubt.text for doubt in fitted.doubts), DoubtfulFitWarning, stacklevel=2)
    return fitted


def _bounds(name: str, limits: Any) -> tuple[float | str, float | str]:
    if isinstance(limits, str) or np.shape(limits) != (2,):
        raise refused(f"bounds[{name!r}]", limits, 'two values, as in ("x0.5", "x2")')
    low, high = (value_of(f"bounds[{name!r}]", bound) for bound in limits)
    return low, high


def _by_scipy(
    residuals: Callable[[Array], Array], jacobian: Callable[[Array], Array], start: Array, low: Array, high: Array, loss: str, max_evaluations: int
) -> tuple[list[float], list[float], str]:
    """Minimizes the extension's residuals with `scipy.optimize.least_squares`."""
    with Extra("scipy"):
        from scipy.optimize import least_squares

    # The extension keeps points within their bounds; SciPy wants them strictly within.
    inside = np.clip(start, np.nextafter(low, high), np.nextafter(high, low))
    solved = least_squares(residuals, inside, jac=jacobian, bounds=(low, high), x_scale="jac", loss=loss, max_nfev=max_evaluations)
    return solved.x.tolist(), solved.fun.tolist(), str(solved.message).rstrip(".")
