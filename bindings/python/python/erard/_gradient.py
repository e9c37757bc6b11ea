"""Derivatives of a press: speeds, times and columns with respect to parameters of the instrument."""

from __future__ import annotations

import html
from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any, Unpack

import numpy as np

from . import _erard
from ._common import Stepping, bar, choice, flag, names_of, number, quantity, read_only, step_of, steps, whole
from ._errors import Extra, InputError
from ._instrument import Instrument, instrument_of, stroke_of

if TYPE_CHECKING:
    import pandas
    from numpy.typing import ArrayLike, NDArray

    from ._instrument import Force
    from ._recording import RecordingLike

#: Quantities with derivatives, by the names of a study's columns.
QUANTITIES = (
    "hammer_speed_m_per_s",
    "let_off_s",
    "hammer_contact_s",
    "key_bottom_s",
    "key_bottom_after_impact_s",
    "free_flight_s",
    "key_start_s",
    "toe_contact_s",
    "key_start_to_hammer_s",
)
#: Columns with derivatives.
COLUMNS = ("key_m", "hammer_rise_m", "force_N")
#: Options for the rest while a parameter changes.
RESTS = ("moves", "held")
#: Half width of the differences from a number of the file to the mechanism's parameters: share of the number, and least
#: value.
HALF, LEAST = 1e-4, 1e-9


class Gradient(Mapping[str, Mapping[str, float]]):
    """First derivatives of a press with respect to parameters: a mapping of quantities, each a mapping of parameters.

    Attributes
    ----------
    outcomes, parameters : list of str
        Quantities, and the parameters that they are differentiated by.
    value : dict of str to float
        Values of the quantities; nan for events that did not happen.
    jacobian : ndarray of shape (Q, P)
        Derivatives of the quantities (rows) by the parameters (columns), in SI units: per metre of a
        screw's turn (rad, N m), per factor of another parameter (for one percent, take a hundredth), per file unit of a
        number of the file, per N of the force.
    in_shorter_steps : ndarray of shape (Q, P) or None
        The same derivatives with steps a fifth shorter; `None` without `compare`. The difference is not an error bar:
        it misses errors that do not depend on the step length.
    unresolved_effect : ndarray of shape (Q, P) or None
        Change of each derivative with the treatment of unresolved friction switches; zero if there are none, `None`
        without `compare`.
    refused : dict of (str, str) to str
        Derivatives that do not converge and are nan in `jacobian`: quantity and parameter, with the reason, which names
        the friction switch from which on two step lengths disagree, and differences to both sides. Empty if such a
        derivative raises an error.
    time_s : ndarray of shape (T,)
        Times of the columns' samples, s; empty without columns.
    columns : dict of str to ndarray of shape (T,)
        Sampled columns.
    column_jacobian : dict of str to ndarray of shape (T, P)
        Derivatives of the samples.
    notes : list of str
        How a recorded stroke was prepared, and remarks on how it drives the key, as in `Run`.
    switches, unresolved : int
        Number of friction switches at which derivatives jumped, and number of those that could not be separated from
        another one.

    Examples
    --------
    >>> import erard
    >>> g = erard.gradient(erard.load("concert-grand-rigid"), ["body.hammer.mass", "let_off"], outcomes=["hammer_speed_m_per_s"], force=5.0)
    >>> g["hammer_speed_m_per_s"]["let_off"] == float(g.jacobian[0, 1])
    True
    """

    def __init__(
        self,
        outcomes: list[str],
        parameters: list[str],
        value: dict[str, float],
        jacobian: NDArray[np.float64],
        in_shorter_steps: NDArray[np.float64] | None,
        unresolved_effect: NDArray[np.float64] | None,
        refused: dict[tuple[str, str], str],
        time_s: NDArray[np.float64],
        columns: dict[str, NDArray[np.float64]],
        column_jacobian: dict[str, NDArray[np.float64]],
        switches: tuple[int, int],
        title: str,
    ) -> None:
        self.outcomes, self.parameters, self.value, self.jacobian, self.refused = outcomes, parameters, value, read_only(jacobian), refused
        self.in_shorter_steps, self.unresolved_effect = in_shorter_steps, unresolved_effect
        self.time_s, self.columns, self.column_jacobian = read_only(time_s), columns, column_jacobian
        for array in (*columns.values(), *column_jacobian.values(), in_shorter_steps, unresolved_effect):
            if array is not None:
                read_only(array)
        self.switches, self.unresolved = switches
        self.notes: list[str] = []
        self.title = title

    def __getitem__(self, key: str) -> Mapping[str, float]:
        if key not in self.outcomes:
            raise KeyError(f"{key!r}: expected one of {', '.join(self.outcomes)}")
        return dict(zip(self.parameters, map(float, self.jacobian[self.outcomes.index(key)]), strict=True))

    def __iter__(self) -> Iterator[str]:
        return iter(self.outcomes)

    def __len__(self) -> int:
        return len(self.outcomes)

    def to_pandas(self) -> pandas.DataFrame:
        """Returns the derivatives as a table, one row for each quantity.

        Returns
        -------
        pandas.DataFrame
        """
        with Extra("tables"):
            import pandas as pd

        return pd.DataFrame(np.array(self.jacobian), index=pd.Index(self.outcomes), columns=pd.Index(self.parameters))

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Gradient):
            return NotImplemented
        same = self.outcomes == other.outcomes and self.parameters == other.parameters and np.array_equal(self.jacobian, other.jacobian, equal_nan=True)
        if not same or set(self.column_jacobian) != set(other.column_jacobian):
            return False
        return all(np.array_equal(slopes, other.column_jacobian[name]) for name, slopes in self.column_jacobian.items())

    __hash__ = None  # type: ignore[assignment]

    def _rows(self) -> list[tuple[str, ...]]:
        rows = [("", "value", *self.parameters)]
        for k, name in enumerate(self.outcomes):
            others = [None] * len(self.parameters) if self.in_shorter_steps is None else list(self.in_shorter_steps[k])
            cells = [
                quantity(float(slope), "") + ("" if other is None else f" ({quantity(float(other), '')})")
                for slope, other in zip(self.jacobian[k], others, strict=True)
            ]
            rows.append((name, quantity(self.value[name], ""), *cells))
        return rows

    def __repr__(self) -> str:
        rows = self._rows()
        wide = [max(len(row[k]) for row in rows) for k in range(len(rows[0]))]
        lines = ["  ".join(cell.ljust(width) for cell, width in zip(row, wide, strict=True)).rstrip() for row in rows]
        unresolved = f", {self.unresolved} of them unresolved" if self.unresolved else ""
        brackets = "" if self.in_shorter_steps is None else "; in brackets: in steps a fifth shorter"
        why = [f"refused: {sentence}" for sentence in self.refused.values()]
        return "\n".join([f"<erard.Gradient of {self.title}: {self.switches} switches of friction{unresolved}{brackets}", *lines, *why, ">"])

    def _repr_html_(self) -> str:
        cells = (f"<tr>{''.join(f'<td>{html.escape(cell)}</td>' for cell in row)}</tr>" for row in self._rows())
        return f"<table><caption>{html.escape(self.title)}</caption>{''.join(cells)}</table>"


def variables(instrument: Instrument, parameters: Sequence[str]) -> list[tuple[str, tuple[_erard.Instrument, _erard.Instrument, float] | None]]:
    """Returns the variables of the extension: names that it knows, and for any other number of the file two
    instruments, one on each side."""
    known = instrument.parameters
    found: list[tuple[str, tuple[_erard.Instrument, _erard.Instrument, float] | None]] = []
    for name in parameters:
        if name in known or name == "force":
            found.append((name, None))
            continue
        value = instrument._inner.number_at(name)
        if value is None:
            instrument.vary({name: 1.0})  # It says what there is.
            raise InputError(f"parameters: {name} has no number to begin with; expected one that the file gives, or that was set to a bare number", key="parameters", found=name)
        half = max(HALF * abs(value), LEAST)
        low, high = (instrument.vary({name: value + sign * half})._inner for sign in (-1.0, 1.0))
        found.append((name, (low, high, 2.0 * half)))
    return found


def gradient(
    instrument: Instrument,
    parameters: Sequence[str] | None = None,
    *,
    outcomes: Sequence[str] | None = None,
    columns: Sequence[str] = (),
    record_every: int = 20,
    force: Force | None = None,
    dt: float | None = None,
    stroke: str | RecordingLike | None = None,
    touch: str = "pressed",
    motion: ArrayLike | None = None,
    rigid: ArrayLike | None = None,
    drive: str | None = None,
    duration: float | None = None,
    rest: str = "moves",
    compare: bool = True,
    unconverged: str | None = None,
    threads: int | None = None,
    progress: bool | None = None,
    **how: Unpack[Stepping],
) -> Gradient:
    """Presses the key once and computes the derivatives of speeds, times and columns with respect to parameters.

    The press is played with forward derivatives, eight at a time. It starts at the rest of `Instrument.press`, with
    friction that truly sticks. Where sliding stops or reverses, derivatives jump, and steps end there (the book,
    "Derivatives").

    For many parameters, `study` is cheaper: differences between presses that are played side by side cost less than
    derivatives. Use derivatives for one or a few parameters, sample by sample, or where the step of a difference is in
    doubt.

    Parameters
    ----------
    instrument : Instrument
    parameters : sequence of str, optional
        Screws and parameters by name, any number of the file by its path, and "force" for a constant force; by default
        all of `Instrument.parameters`.
    outcomes : sequence of str, optional
        Quantities, by the names of a study's columns, such as "hammer_speed_m_per_s", "let_off_s",
        "key_start_to_hammer_s"; by default all those that happen.
    columns : sequence of str
        Columns to differentiate sample by sample: "key_m", "hammer_rise_m", "force_N" (not with `rigid`).
    record_every : int
        Number of steps between two samples of the columns.
    force, dt, stroke, touch, motion, rigid, drive, duration
        Stroke, as in `Instrument.press`.
    rest : {"moves", "held"}
        Rest while a parameter changes; with dry friction an action can rest in a range of poses. "moves": the action
        settles anew from the drawn pose, as in each `press`. "held": friction holds the pose that the action has.
    compare : bool
        Whether to repeat the press with steps a fifth shorter and compare. A derivative does not converge if it differs
        by more than a tenth and by an amount that matters for its quantity.
    unconverged : {"raise", "nan"}, optional
        Treatment of a derivative that does not converge. "raise": the call raises an error that names the friction
        switch from which on it does not converge. "nan": the derivative is nan, and `Gradient.refused` gives the
        reason. The default is "raise" if `outcomes` is given, else "nan".
    threads : int, optional
        Number of threads; by default the number of cores.
    progress : bool, optional
        Whether to show a progress bar.
    **how
        Settings of the steps: `step` (s, default 25e-6), `theta`, `solver`.

    Returns
    -------
    Gradient

    Raises
    ------
    InputError
        If a name is wrong, or if the model has no derivatives: friction that grows at rest, felts with a set-valued
        loss, modal strings, friction="tanh".
    SimulationError
        If a derivative does not converge and `unconverged` is "raise".

    Examples
    --------
    >>> import erard
    >>> grand = erard.load("concert-grand-rigid")
    >>> speed, contact = "hammer_speed_m_per_s", "hammer_contact_s"
    >>> g = erard.gradient(grand, ["force", "body.hammer.mass"], outcomes=[speed, contact], force=5.0, columns=["key_m"])
    >>> g[speed]["force"] > 0 > g[contact]["force"]
    True
    >>> g.column_jacobian["key_m"].shape == (len(g.time_s), 2)
    True
    """
    instrument = instrument_of(instrument)
    names = list(instrument.parameters) if parameters is None else names_of("parameters", parameters)
    if len(set(names)) != len(names):
        raise InputError("parameters: expected names, each once", key="parameters")
    if "force" in names and (force is None or np.ndim(force) != 0):
        raise InputError("parameters: `force` is what a constant force is differentiated by; expected force=, a number", key="parameters", found="force")
    asked, sampled = names_of("outcomes", outcomes), names_of("columns", columns)
    for key, given, known in (("outcomes", asked, QUANTITIES), ("columns", sampled, COLUMNS)):
        if unknown := [name for name in given if name not in known]:
            raise InputError(f"{key}: found {unknown[0]!r}, expected {', '.join(known)}", key=key, found=unknown[0])
    own = steps({"step": 25e-6, **how})
    every = whole("record_every", record_every)
    unconverged = unconverged if unconverged is not None else ("raise" if asked else "nan")
    choice("rest", rest, RESTS)
    choice("unconverged", unconverged, ("raise", "nan"))
    made = stroke_of(
        instrument, force=force, dt=dt, stroke=stroke, touch=touch, motion=motion, rigid=rigid, drive=drive, hand=how.get("hand")
    )
    if made.drive == "rigid" and "force_N" in sampled:
        raise InputError("columns: force_N has no derivatives under a rigid drive, whose force is what its motion takes", key="columns", found="force_N")
    length = None if duration is None else number("duration", duration)
    threads = None if threads is None else whole("threads", threads)
    sides = variables(instrument, names)
    how_asked = (rest == "held", flag("compare", compare), unconverged == "raise", asked)
    with bar(progress, "gradient") as tell:
        found = _erard.gradient(instrument._inner, sides, made, length, own, every if sampled else None, how_asked, threads, tell)
    told = asked or [name for name in QUANTITIES if found["values"][name] is not None]

    def matrix(of: str) -> NDArray[np.float64]:
        return np.array([found[of][name] for name in told], dtype=np.float64).reshape(len(told), len(names))

    shorter, unresolved = (matrix("in_shorter_steps"), matrix("unresolved")) if compare else (None, None)
    value = {name: float("nan") if found["values"][name] is None else float(found["values"][name]) for name in told}
    count = len(next(iter(found["columns"].values()), ()))
    time_s = made.start_s + step_of(own, instrument._inner.usual_step_s) * every * np.arange(count, dtype=np.float64)
    computed = Gradient(
        told, names, value, matrix("slopes"), shorter, unresolved, {(of, by): why for of, by, why in found["refused"]}, time_s,
        {name: found["columns"][name] for name in sampled},
        {name: np.ascontiguousarray(found["column_slopes"][name].T) for name in sampled},
        (found["switches"][0], found["switches"][1]), f"{instrument.name}, {made.title}",
    )  # fmt: skip
    computed.notes = made.notes
    return computed
