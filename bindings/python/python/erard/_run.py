"""One press."""

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
    """The result of one press: a mapping of columns, and the instants of its events.

    Columns are read-only views of the memory in which they were computed: `time_s`, `force_N` (of the finger, pushing positive), `key_m` (of the
    front, from rest, down positive), `hammer_head_m` (of the strike point, up positive), `hammer_head_m_per_s` (its speed), of every body
    `NAME_rad` and `NAME_rad_per_s` (counter-clockwise), and of every contact `NAME_N` (normal) and, where it has friction, `NAME_tangential_N`.

    Attributes
    ----------
    events : mapping
        Instants in s on the stroke's clock by their names (`key_start`, `toe_contact`, `let_off`, `hammer_contact`, `key_bottom`, `check`) and
        `hammer_speed` in m/s (total); only what happened.
    impacts : list of (float, float)
        Instant (s) and total speed (m/s) of every impact on the string.
    warnings : list of str
        Why the run cannot be trusted; empty if nothing speaks against it.
    notes : list of str
        Where the stroke does not drive quite as it says.

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

    def __init__(self, columns: dict[str, NDArray[np.float64]], about: dict[str, Any], title: str) -> None:
        super().__init__(dict(columns))
        self._about = about
        self.title = title
        self.events = types.MappingProxyType({name: at for name, at in about["events"].items() if at is not None})
        self.impacts = about["impacts"]
        self.warnings, self.notes = about["warnings"], about["notes"]

    @property
    def instrument(self) -> str:
        """Name of the instrument."""
        return str(self._about["instrument"])

    @property
    def hammer_speed(self) -> float | None:
        """Total speed of the strike point where it meets the string, m/s; `None` where it does not."""
        return self._about["events"]["hammer_speed"]  # type: ignore[no-any-return]

    @property
    def hammer_speed_normal(self) -> float | None:
        """Its part along the string's normal, m/s, which presses the felt; `None` where the string is not met.

        >>> import erard
        >>> run = erard.load("concert-grand").press(force=5.0)
        >>> 0.9 < run.hammer_speed_normal / run.hammer_speed < 1.0
        True
        """
        return self._about["hammer_speed_normal"]  # type: ignore[no-any-return]

    @property
    def free_flight_s(self) -> float | None:
        """From the last push on the knuckle to the string, s."""
        return self._about["free_flight_s"]  # type: ignore[no-any-return]

    @property
    def peak_force_N(self) -> float:
        """Largest force of the finger, N."""
        return float(self._about["peak_force_N"])

    @property
    def energy(self) -> Mapping[str, float] | None:
        """The ledger at the end: work of the drive and where it was lost, J, and the share that is not explained."""
        own = self._about["energy"]
        return None if own is None else types.MappingProxyType(own)

    @property
    def losses(self) -> list[dict[str, Any]] | None:
        """Where the energy went by pin and by contact, the largest loss first, if `press(losses=True)` asked for it; J.

        The rows are those of the command's losses.json: `name` (the body of a pin, or the contact; of modal strings "strings", "bridge" or
        "rocking", dampers' felts that are rocked), `kind` ("pin", "contact" or, of these three, "strings"), `label`, `dry_J` (dry friction, sliding), `viscous_or_felt_J`, `loss_J` (both) and `share` (of all).
        """
        own: list[dict[str, Any]] | None = self._about.get("losses")
        return own

    @property
    def work(self) -> Mapping[str, int]:
        """Steps taken, those that did not converge, and Newton iterations."""
        return {name: self._about[name] for name in ("steps", "unconverged_steps", "newton_iterations")}

    @property
    def trusted(self) -> bool:
        """Whether nothing speaks against the numbers."""
        return not self.warnings

    def summary(self) -> dict[str, float | None]:
        """The numbers of the run in one row.

        Returns
        -------
        dict of str to float or None
            Every event (s; `None` where it did not happen), the hammer's speed, the free flight, the peak force.
        """
        row: dict[str, float | None] = {}
        for name, at in self._about["events"].items():
            row["hammer_speed_m_per_s" if name == "hammer_speed" else f"{name}_s"] = at
        return row | {"free_flight_s": self.free_flight_s, "peak_force_N": self.peak_force_N}

    def svg(self) -> str:
        """The figure of the run, as `erard press` draws it.

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
            Names; by default the force, the key, the hammer and the string.
        ax : matplotlib Axes, optional
            Draws all of them there.

        Returns
        -------
        matplotlib.figure.Figure
        """
        from ._plot import run_figure

        return run_figure(self, columns, ax)

    def to_xarray(self) -> xarray.Dataset:
        """A labelled data set over `time_s`, units as attributes.

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
