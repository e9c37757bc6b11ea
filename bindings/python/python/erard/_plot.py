"""Figures with matplotlib, which is imported only here."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from ._common import names_of, unit_of
from ._errors import Extra, InputError

if TYPE_CHECKING:
    from matplotlib.figure import Figure

#: Columns drawn by default.
USUAL = ("force_N", "key_m", "hammer_rise_m", "string_N")
#: Colours that colour-blind people can distinguish (Okabe and Ito).
COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#000000")


class DrawnRun(Protocol):
    """The part of a run that a figure needs."""

    title: str
    events: Mapping[str, float]

    @property
    def hammer_speed(self) -> float | None: ...
    @property
    def instrument(self) -> str: ...
    def __getitem__(self, column: str, /) -> Any: ...
    def __contains__(self, column: object, /) -> bool: ...


class DrawnStudy(Protocol):
    """The part of a study that a figure needs."""

    @property
    def axes(self) -> Mapping[str, Any]: ...
    @property
    def units(self) -> Mapping[str, str]: ...
    @property
    def shape(self) -> tuple[int, ...]: ...
    def __getitem__(self, column: str, /) -> Any: ...


class DrawnFit(Protocol):
    """The part of a fit that a figure needs."""

    @property
    def channels(self) -> Sequence[Any]: ...


def _scaled(column: str, values: Any) -> tuple[Any, str]:
    unit = unit_of(column)
    return (1e3 * values, "mm") if unit == "m" else (values, unit)


def _once(figure: Figure) -> Figure:
    """Closes the figure in a notebook, which would otherwise show it twice, and returns it."""
    with Extra("plot"):
        import matplotlib
        import matplotlib.pyplot as plt

    if "inline" in matplotlib.get_backend():
        plt.close(figure)
    return figure


def run_figure(run: DrawnRun, columns: Sequence[str], ax: Any) -> Figure:
    """Draws columns of a run over time, one panel below the other, with events as lines."""
    with Extra("plot"):
        import matplotlib.pyplot as plt

    shown = tuple(names_of("columns", columns)) or tuple(name for name in USUAL if name in run)
    if ax is None:
        figure, axes = plt.subplots(
            len(shown), 1, sharex=True, squeeze=False, figsize=(8, 1 + 1.5 * len(shown)), layout="constrained"
        )
        panels = list(axes[:, 0])
    else:
        if not hasattr(ax, "figure") or not hasattr(ax, "secondary_xaxis"):
            raise InputError(f"ax: found {ax!r}, expected matplotlib's Axes", key="ax", found=repr(ax))
        figure, panels = ax.figure, [ax] * len(shown)
    ms = 1e3 * run["time_s"]
    for colour, (panel, name) in enumerate(zip(panels, shown, strict=True)):
        values, unit = _scaled(name, run[name])
        panel.plot(ms, values, color=COLOURS[colour % len(COLOURS)], label=name)
        panel.set_ylabel(f"{name.rsplit('_', 1)[0]} ({unit})" if ax is None else unit)
    instants = sorted((1e3 * at, name) for name, at in run.events.items() if name != "hammer_speed")
    for at, _ in instants:
        for panel in dict.fromkeys(panels):
            panel.axvline(at, color="0.7", linewidth=0.8, zorder=0)
    # Names stand above the figure; what is nearer together than a line is high shares a place.
    near, places = 0.03 * (ms[-1] - ms[0]), list[tuple[float, list[str]]]()
    for at, name in instants:
        if places and at - places[-1][0] < near:
            places[-1][1].append(name.replace("_", " "))
        else:
            places.append((at, [name.replace("_", " ")]))
    top = panels[0].secondary_xaxis("top")
    labels = [", ".join(names) for _, names in places]
    top.set_xticks([at for at, _ in places], labels, rotation=20, ha="left", rotation_mode="anchor", fontsize="x-small", color="0.35")
    top.tick_params(length=0)
    if ax is not None:
        ax.legend()
    panels[-1].set_xlabel("time (ms)")
    speed = "" if run.hammer_speed is None else f", hammer {run.hammer_speed:.2f} m/s"
    panels[0].set_title(f"{run.instrument}: {run.title}{speed}", fontsize="medium")
    return figure if ax is not None else _once(figure)


def study_figure(study: DrawnStudy, column: str, over: str) -> Figure:
    """Draws a column over an axis, with one curve for each combination of the others (a legend for at most ten)."""
    with Extra("plot"):
        import matplotlib.pyplot as plt

    names = [name for name in study.axes if name != over]
    along = list(study.axes).index(over)
    values = np.moveaxis(study[column].reshape(study.shape), along, -1).reshape(-1, study.shape[along])
    others = np.meshgrid(*(study.axes[name] for name in names), indexing="ij") if names else []
    figure, panel = plt.subplots(figsize=(7, 4), layout="constrained")
    x, unit = study.axes[over], study.units[over]
    if unit in ("m", "kg", "N m"):
        x, unit = 1e3 * x, {"m": "mm", "kg": "g", "N m": "N mm"}[unit]
    for row, curve in enumerate(values):
        label = ", ".join(f"{name} {grid.ravel()[row]:.4g}" for name, grid in zip(names, others, strict=False))
        told = label if 1 < len(values) <= 10 else None
        panel.plot(x, curve, "." if len(x) == 1 else "-", color=COLOURS[row % len(COLOURS)], label=told)
    if 1 < len(values) <= 10:
        panel.legend(fontsize="small")
    panel.set_xlabel(f"{over} ({unit})")
    panel.set_ylabel(f"{column} ({study.units[column]})")
    return _once(figure)


def fit_figure(fit: DrawnFit) -> Figure:
    """Draws measured and fitted values above and residuals in units of the noise below, one column for each channel."""
    with Extra("plot"):
        import matplotlib.pyplot as plt

    channels = fit.channels
    figure, axes = plt.subplots(
        2,
        len(channels),
        sharex="col",
        squeeze=False,
        figsize=(1 + 4 * len(channels), 5),
        height_ratios=(2, 1),
        layout="constrained",
    )
    for (above, below), channel in zip(axes.T, channels, strict=True):
        ms = 1e3 * channel.time_s
        measured, unit = _scaled(channel.column, channel.measured)
        fitted, _ = _scaled(channel.column, channel.fitted)
        above.plot(ms, measured, ".", color="0.6", markersize=2, label="measured")
        above.plot(ms, fitted, color=COLOURS[1], label="fitted")
        above.set_ylabel(f"{channel.column.rsplit('_', 1)[0]} ({unit})")
        above.set_title(channel.title, fontsize="small")
        left = (channel.measured - channel.fitted) / channel.sigma
        below.axhspan(-2, 2, color="0.93")
        below.plot(ms, left, ".", color=COLOURS[0], markersize=2)
        below.set_xlabel("time (ms)")
        below.set_ylim(-max(4.0, float(np.max(np.abs(left)))), max(4.0, float(np.max(np.abs(left)))))
    axes[0, 0].legend(fontsize="small")
    axes[1, 0].set_ylabel("left over (sigma)")
    return _once(figure)


