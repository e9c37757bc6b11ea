"""Parameters of an instrument fitted to recordings: least squares, and what the data do and do not tell.

The fit is the extension's, and so that of the command `erard fit`. Here its results become arrays, figures and pickles, and SciPy's solver can be asked for.
"""

from __future__ import annotations

import html
import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple, TypeAlias, Unpack

import numpy as np

from . import _erard
from ._common import Stepping, counter, mapping, names_of, number, steps, whole
from ._errors import DoubtfulFitWarning, Extra, InputError
from ._instrument import Instrument, instrument_of
from ._recording import Recording, as_recording

if TYPE_CHECKING:
    import matplotlib.figure
    from numpy.typing import NDArray

    from ._recording import RecordingLike
    from ._types import Fitted, Steps

    Array: TypeAlias = NDArray[np.float64]

#: Who minimises.
MINIMIZERS = ("erard", "scipy")


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


class Doubt(NamedTuple):
    """A reason to doubt a fit.

    Attributes
    ----------
    kind : str
        "no_impact": the recording's hammer reaches the string, the fitted model's does not. "misfit": more is left over than noise explains, or noise
        was estimated from residuals that follow each other, as noise does not.
        "bound": a parameter ended at a bound. "restarts": attempts from several starts ended at different places. "beyond_impact": data go on
        beyond the first impact. "derivatives": they depend on the step of their differences. "noise_unknown": a column's noise is not known;
        a drive's then counts as zero, a compared column's is estimated from the residuals. "recording": a recording does not look as it should.
    text : str
        What was found, and what it means.
    """

    kind: str
    text: str


class Asked(NamedTuple):
    """The parts of a problem."""

    instrument: Instrument
    vary: list[str]
    bounds: list[tuple[str, tuple[float, float]]]
    recordings: list[Recording]
    drive: str | None
    columns: list[str] | None
    delay: bool
    sigma: list[tuple[str, float]]
    own: Steps
    threads: int | None


class Problem:
    """Residuals and their Jacobian over the inner parameters: those of the instrument, then the delays in ms. It is pickled as what it is made of."""

    def __init__(self, asked: Asked, sigma: list[float] | None = None) -> None:
        self.asked = asked
        inner = [recording._inner for recording in asked.recordings]
        self._inner = _erard.Problem(
            asked.instrument._inner, asked.vary, asked.bounds, inner, asked.drive, asked.columns, asked.delay, asked.sigma, asked.own, asked.threads
        )
        if sigma is not None:
            self._inner.set_sigma(sigma)

    def __reduce__(self) -> tuple[Any, ...]:
        return Problem, (self.asked, self._inner.sigma())

    def bounds(self) -> tuple[Array, Array]:
        """Lower and upper bounds of the inner parameters."""
        low, high = self._inner.bounds()
        return np.array(low), np.array(high)

    def outer(self, points: Array) -> Array:
        """Points, row by row, as `vary` takes them."""
        return self._inner.outer(np.ascontiguousarray(points))

    def residuals(self, points: Array, tell: Callable[[int], None] | None = None) -> Array:
        """Fitted less measured, over the noise, of points row by row, played side by side; nan where one cannot be played."""
        return self._inner.residuals(np.ascontiguousarray(points), tell)

    def jacobian(self, point: Array, exact: bool = False) -> Array:
        """Derivatives of the residuals at a point, by differences or by those of the model itself: (M, P)."""
        return self._inner.jacobian(list(point), exact)

    def channels(self, point: Array) -> list[Channel]:
        """Every measured quantity beside what the model makes of it at a point."""
        return [
            Channel(title, column, times, measured, fitted, sigma, delay_s)
            for title, _, column, times, measured, fitted, sigma, delay_s in self._inner.curves(list(point))
        ]


class Fit:
    """The result of a fit.

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
        Root mean square of each channel's noise, N or m: as given, as read from the recording, or else estimated from the residuals.
    rms_at_start, rms : dict of str to float
        Root mean square of fitted less measured of each channel where the fit began, and of the result, N or m.
    residuals : ndarray of shape (M,)
        Fitted less measured, over the noise.
    chi2_reduced : float or None
        Sum of their squares over the degrees of freedom; None where the noise of a channel was estimated from its residuals, which makes it 1
        whatever the fit is worth.
    chi2_expected : float or None
        What it should be if the model were true: 1 for the sensors' noise, and what the drive's noise adds, which moves the model itself.
    doubts : list of Doubt
        What makes the answer doubtful; empty where nothing does. `erard.fit` warns of them by a `DoubtfulFitWarning`.
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

    def __init__(self, problem: Problem, found: Fitted) -> None:
        self._problem, self._found = problem, found
        self._point, self.message = found["point"], found["message"]
        names = [row[0] for row in found["free"]]
        self.x = dict(zip(names, found["x"], strict=True))
        self.std = dict(zip(names, found["std"], strict=True))
        self.values = {name: value for name, (value, _) in zip(names, found["values"], strict=True)}
        self.errors = {name: error for name, (_, error) in zip(names, found["values"], strict=True)}
        self.cov, self._inner_cov, self._sensors_cov = found["cov"], found["inner_cov"], found["sensors_cov"]
        self.correlation: Array = self.cov / np.outer(found["std"], found["std"])
        self.residuals, self.degrees_of_freedom = found["residuals"], found["degrees_of_freedom"]
        self.chi2_reduced, self.chi2_expected = found["chi2_reduced"], found["chi2_expected"]
        self.doubts = [Doubt(kind, text) for kind, text in found["doubts"]]
        self.singular_values, self.unseen = found["singular_values"], found["unseen"]
        self.jacobian_agreement = found["jacobian_agreement"]
        channels = found["channels"]
        self.noise = {title: sigma for title, sigma, *_ in channels}
        self.rms_at_start = {title: start for title, _, _, start, *_ in channels}
        self.rms = {title: end for title, _, _, _, end, _ in channels}
        self.delays = {title: delay for title, *_, delay in channels if delay is not None}
        self.evaluations, self.differentiated = found["evaluations"], found["differentiated"]

    @property
    def instrument(self) -> Instrument:
        """The instrument with what was fitted."""
        return self._problem.asked.instrument.vary(self.x)

    @property
    def channels(self) -> list[Channel]:
        """Every measured quantity beside what was fitted to it."""
        return self._problem.channels(self._point)

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
        for name, unit, is_factor, low, high, at_bound in self._found["free"]:
            told = f"{'*' if is_factor else ''}{self.x[name]:.5g} +- {self.std[name]:.2g}"
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
        rows = [("", "value", "as vary takes it", "bounds"), *self.rows()]
        wide = [max(len(row[k]) for row in rows) for k in range(4)]
        lines += ["  " + "  ".join(cell.ljust(width) for cell, width in zip(row, wide, strict=True)).rstrip() for row in rows]
        for name, explanation, quantity, unit, before, value, std in self._found["meanings"]:
            lines += [f"  {name} is {explanation}: {quantity} {value:.4g} +- {std:.2g} {unit}, at the start {before:.4g} {unit}"]
        names = list(self.x)
        if pairs := self._found["correlated"]:
            lines += ["Correlations above 0.5", *(f"  {names[i]} and {names[j]}: {r:+.2f}" for i, j, r in pairs)]
        lines += ["Fitted less measured, root mean square, SI"]
        for title, noise, is_known, start, end, _ in self._found["channels"]:
            lines += [f"  {title}: {start:.3g} at the start, {end:.3g} at the end; noise {noise:.3g}{'' if is_known else ', from the residuals'}"]
        lines += [f"Delay of {title}: {1e3 * delay:.3f} ms" for title, delay in self.delays.items()]
        lines += [f"Not seen: {told}" for told in self.unseen]
        return "\n".join(lines)

    def __eq__(self, other: object) -> bool:
        """Whether the same was fitted to the same data, and the same found."""
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
    vary: Sequence[str],
    drive: str | None = None,
    columns: Sequence[str] | None = None,
    sigma: Mapping[str, float] | None = None,
    delay: bool = False,
    bounds: Mapping[str, tuple[float, float]] | None = None,
    start: Mapping[str, float] | None = None,
    loss: str = "linear",
    jacobian: str = "differences",
    minimizer: str = "erard",
    restarts: int = 5,
    most: int = 50,
    threads: int | None = None,
    progress: bool | None = None,
    **how: Unpack[Stepping],
) -> Fit:
    """Fits parameters of an instrument to recordings, by least squares.

    Each recording drives the model, by its force where it has one, and what else was recorded is compared. The fit is that of the command
    `erard fit`, to the bit: a trust region within the bounds moves the parameters; the derivatives are central differences, all variants
    played side by side in vector lanes. What drives is prepared as the `Recording` was; what is compared is not filtered, for a filter makes
    noise look smaller than it is.

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
        What is compared, of "force_N", "key_m", "hammer_head_m", "hammer_head_m_per_s"; by default all but what drives.
    sigma : mapping of str to float, optional
        The noise of a column, root mean square, N or m; that of the drive, too, whose effect on the parameters is part of their errors. By default it
        is read from the rest before the touch or the spectrum; where neither tells it, from what is left over. Where nothing tells that of the
        drive it counts as none. Both are doubts: a load cell's 20 mN can make errors ten times larger.
    delay : bool
        Estimate for every column how much later it was written down than what drives.
    bounds : mapping of str to (float, float), optional
        Of a parameter, as `vary` takes it. By default as far as the instrument's file says that its number may be off; where it does not say, a factor
        from 0.2 to 5, or a fiftieth of what a screw can do.
    start : mapping of str to float, optional
        Where to begin, as `vary` takes it.
    loss : {"linear", "soft_l1", "huber", "cauchy"}
        "linear" is plain least squares; the others give outliers less weight. The covariance is that of plain least squares.
    jacobian : {"differences", "gradient"}
        Where the derivatives of the last steps and of the covariance come from: central differences, or the model's own (`gradient`), which need no
        step but cost more. The first steps, which are to look past what jumps, are differences in any case.
        Both find the same; a Jacobian of the model's own derivatives takes about six times as long, for differences are played side by side in lanes.
    minimizer : {"erard", "scipy"}
        Who minimises: the library itself, or `scipy.optimize.least_squares` on the same residuals, through the same stages.
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
        `x`, `std`, `cov`, `doubts`, `residuals`, `plot()`, `instrument`, `unseen`; printed it is a report.

    Warns
    -----
    DoubtfulFitWarning
        Where `Fit.doubts` is not empty.

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
    >>> found = erard.fit(grand, mine, vary=["body.hammer.mass"], sigma={"key_m": 1e-5, "force_N": 0.0})
    >>> found.doubts
    []
    >>> bool(abs(found.x["body.hammer.mass"] - 1.04) < 4 * found.std["body.hammer.mass"])
    True
    """
    if minimizer not in MINIMIZERS:
        raise InputError(f"minimizer: found {minimizer!r}, expected {' or '.join(MINIMIZERS)}", key="minimizer", found=str(minimizer))
    restarts, most = whole("restarts", restarts, 0), whole("most", most)
    sources: list[Any] = list(recordings) if isinstance(recordings, (list, tuple)) else [recordings]
    asked = Asked(
        instrument_of(instrument),
        names_of("vary", vary),
        [(name, _bounds(name, limits)) for name, limits in mapping("bounds", bounds).items()],
        [as_recording(source) for source in sources],
        drive,
        None if columns is None else names_of("columns", columns),
        bool(delay),
        [(name, number(f"sigma[{name!r}]", value)) for name, value in mapping("sigma", sigma).items()],
        steps(how),
        None if threads is None else whole("threads", threads),
    )
    begin = [(name, number(f"start[{name!r}]", value)) for name, value in mapping("start", start).items()]
    problem = Problem(asked)
    with counter(progress, "fit", "strokes") as tell:
        found = problem._inner.fit((begin, loss, jacobian, restarts, most), _by_scipy if minimizer == "scipy" else None, tell)
    fitted = Fit(problem, found)
    if fitted.doubts:
        warnings.warn("doubtful fit: " + "; ".join(doubt.text for doubt in fitted.doubts), DoubtfulFitWarning, stacklevel=2)
    return fitted


def _bounds(name: str, limits: Any) -> tuple[float, float]:
    if isinstance(limits, str) or np.shape(limits) != (2,):
        raise InputError(f"bounds[{name!r}]: found {limits!r}, expected two numbers, as in (0.5, 2.0)", key="bounds", found=repr(limits))
    low, high = (number(f"bounds[{name!r}]", bound) for bound in limits)
    return low, high


def _by_scipy(
    residuals: Callable[[Array], Array], jacobian: Callable[[Array], Array], start: Array, low: Array, high: Array, loss: str, most: int
) -> tuple[list[float], list[float], str]:
    """`scipy.optimize.least_squares` over the extension's residuals."""
    with Extra("scipy"):
        from scipy.optimize import least_squares

    # The extension keeps points within their bounds; SciPy wants them strictly within.
    inside = np.clip(start, np.nextafter(low, high), np.nextafter(high, low))
    solved = least_squares(residuals, inside, jac=jacobian, bounds=(low, high), x_scale="jac", loss=loss, max_nfev=most)
    return solved.x.tolist(), solved.fun.tolist(), str(solved.message).rstrip(".")
