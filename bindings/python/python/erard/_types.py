"""Types that the extension's stubs and the modules share."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeAlias, TypedDict

import numpy as np
from numpy.typing import NDArray

Floats: TypeAlias = NDArray[np.float64]
Change: TypeAlias = tuple[str, float | str]
Progress: TypeAlias = Callable[[float], None] | None


#: How a recording is prepared: whose position it is, zero from the rest, low-pass in Hz, or by each channel's own
#: noise, columns that are turned, and how late columns are, s.
Ready: TypeAlias = tuple[str | None, bool, float | None, bool, list[str], list[tuple[str, float]]]


class Steps(TypedDict):
    """How to step, complete."""

    step: float
    theta: float
    solver: str
    friction: str
    friction_width: float
    hand: tuple[float, float, float, float, float] | None


class Work(TypedDict):
    """Who plays many strokes, and what is kept."""

    threads: int | None
    single: bool
    ledger: bool
    columns: list[str]
    every: int
