"""The result of one press."""

from __future__ import annotations

import types
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from . import _erard
from ._common import quantity, read_only
from ._errors import Extra
from ._table import Table

if TYPE_CHECKING:
    import matplotlib.figure
    import numpy as np
    import xarray
    from numpy.typing import NDArray


class Run(Table):
    """Result of one press: a mapping of columns, with events, impacts and energy losses.

    Columns are read-only arrays, without a copy: `time_s`, `force_N` (force of the finger, pushing positive), `key_m`
    (travel of the key front from rest, down positive), `hammer_rise_m` (rise of the strike point, up positive),
    `hammer_rise_m_per_s` (its speed), for every body `NAME_rad` and `NAME_rad_per_s` (counter-clockwise positive), and
    for every contact zone `NAME_N` (normal force) and, with friction, `NAME_tangential_N`.

    Attributes
    ----------
    events : mapping
        Times in s on the stroke's clock by event (`key_start`, `toe_contact`, `let_off`, `hammer_contact`,
        `key_bottom`, `check`), and `hammer_speed` in m/s (total). Events that did not happen are left out.
    impacts : list of (float, float)
        Time (s) and total hammer speed (m/s) of every impact on the string.
    warnings : list of str
        Reasons not to trust the run; empty if there are none.
    notes : list of str
        How a recorded stroke was prepared (zero, resampling, low-pass, noise), and remarks on how it drives the key
        differently from its data.
    preparation : list of dict
        The same of each channel as data, as the command's results store it in `made_by`: `zero` in N or m,
        `resampled_Hz`, `low_pass_Hz` and others, `None` for what was not done; empty if no recording was played.

    Examples
    --------
    >>> import erard
    >>> run = erard.load("concert-grand").press(force=5.0)
    >>> run.hammer_speed == run.events["hammer_speed"]
    True
    >>> run["key_m"].flags.writeable
    False
    """

    title: str
    events: Mapping[str, float]
    impacts: list[tuple[float, float]]
    warnings: list[str]
    notes: list[str]
    preparation: list[dict[str, Any]]

    def __init__(self, columns: dict[str, NDArray[np.float64]], about: dict[str, Any], title: str) -> None:
        super().__init__(dict(columns))
        self._about = about
        self.title = title
        self.events = types.MappingProxyType({name: at for name, at in about["events"].items() if at is not None})
        self.impacts = about["impacts"]
        self.warnings, self.notes, self.preparation = about["warnings"], about["notes"], about["preparation"]

    @property
    def instrument(self) -> str:
        """Name of the instrument."""
        return str(self._about["instrument"])

    @property
    def hammer_speed(self) -> float | None:
        """Total speed of the strike point at the first impact, m/s; `None` without an impact."""
        return self._about["events"]["hammer_speed"]  # type: ignore[no-any-return]

    @property
    def hammer_speed_normal(self) -> float | None:
        """Component of the hammer speed along the string's normal, m/s, which compresses the felt; `None` without an
        impact.

        >>> import erard
        >>> run = erard.load("concert-grand").press(force=5.0)
        >>> 0.9 < run.hammer_speed_normal / run.hammer_speed < 1.0
        True
        """
        return self._about["hammer_speed_normal"]  # type: ignore[no-any-return]

    @property
    def free_flight_s(self) -> float | None:
        """Time from let-off to the impact, s; `None` if either is missing."""
        return self._about["free_flight_s"]  # type: ignore[no-any-return]

    @property
    def peak_force_N(self) -> float:
        """Largest force of the finger, N."""
        return float(self._about["peak_force_N"])

    @property
    def energy(self) -> Mapping[str, float] | None:
        """Energy balance of the run: work of the drive and losses, J, and the unexplained share in `residual_relative`;
        `None` if it was not computed."""
        own = self._about["energy"]
        return None if own is None else types.MappingProxyType(own)

    @property
    def losses(self) -> list[dict[str, Any]] | None:
        """Energy losses by pin and by contact, J, the largest first; `None` without `press(losses=True)`.

        The rows are those of the command's losses.json: `name` (a pin's body, or the contact; for modal strings
        "strings", "bridge" or "rocking", the rocking of the dampers' felts), `kind` ("pin", "contact", or "strings" for
        these three), `label`, `dry_J` (sliding friction), `viscous_or_felt_J`, `loss_J` (the sum) and `share` (of all
        losses).
        """
        own: list[dict[str, Any]] | None = self._about.get("losses")
        return own

    @property
    def work(self) -> Mapping[str, int]:
        """Numbers of steps, of unconverged steps and of Newton iterations."""
        return {name: self._about[name] for name in ("steps", "unconverged_steps", "newton_iterations")}

    @property
    def trusted(self) -> bool:
        """Whether the run has no warnings."""
        return not self.warnings

    def summary(self) -> dict[str, float | None]:
        """Returns the key results of the run in one row.

        Returns
        -------
        dict of str to float or None
            Times of all events (s; `None` for those that did not happen), hammer speed (m/s), free flight (s) and peak
            force (N).
        """
        row: dict[str, float | None] = {}
        for name, at in self._about["events"].items():
            row["hammer_speed_m_per_s" if name == "hammer_speed" else f"{name}_s"] = at
        return row | {"free_flight_s": self.free_flight_s, "peak_force_N": self.peak_force_N}

    def svg(self) -> str:
        """Returns the figure of the run, as `erard press` draws it.

        Returns
        -------
        str
            SVG.
        """
        return _erard.figure({name: self[name] for name in self}, self._about, self.title)

    def plot(self, *columns: str, ax: Any = None) -> matplotlib.figure.Figure:
        """Draws columns over the time with matplotlib.

        Parameters
        ----------
        *columns : str
            Names of columns; by default force, key, hammer and string.
        ax : matplotlib Axes, optional
            Axes to draw all columns on; by default a new figure.

        Returns
        -------
        matplotlib.figure.Figure
        """
        from ._plot import run_figure

        return run_figure(self, columns, ax)

    def to_xarray(self) -> xarray.Dataset:
        """Returns a labelled data set over `time_s`, with units as attributes.

        Returns
        -------
        xarray.Dataset
        """
        with Extra("tables"):
            import xarray as xr

        units = self.units
        variables = {
            name: ("time_s", values, {"units": units[name]}) for name, values in self.items() if name != "time_s"
        }
        attributes = {"instrument": self.instrument, "stroke": self.title, **self.events}
        return xr.Dataset(variables, coords={"time_s": ("time_s", self["time_s"], {"units": "s"})}, attrs=attributes)

    def __eq__(self, other: object) -> bool:
        same = super().__eq__(other)
        if same is not True:
            return same
        assert isinstance(other, Run)
        return dict(self.events) == dict(other.events) and self.impacts == other.impacts

    __hash__ = None

    def __repr__(self) -> str:
        ms = {name: 1e3 * at for name, at in self.events.items() if name != "hammer_speed"}
        told = ", ".join(f"{name.replace('_', ' ')} {at:.1f} ms" for name, at in ms.items())
        speed = quantity(self.hammer_speed, "m/s") if self.hammer_speed else "the string is not reached"
        doubt = "" if self.trusted else f"; cannot be trusted: {self.warnings[0]}"
        return f"<erard.Run {self.instrument}, {self.title}: hammer {speed}; {told}; {len(self['time_s'])} rows{doubt}>"

    def _repr_html_(self) -> str:
        return f'<div style="max-width: 1180px">{self.svg()}</div>'

    def __getstate__(self) -> dict[str, Any]:
        import numpy as np

        columns = {name: np.asarray(values) for name, values in self.items()}
        return {"columns": columns, "about": self._about, "title": self.title}

    def __setstate__(self, state: dict[str, Any]) -> None:
        columns = {name: read_only(values) for name, values in state["columns"].items()}
        Run.__init__(self, columns, state["about"], state["title"])
