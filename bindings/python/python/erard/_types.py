"""Types that the extension's stubs and the modules share."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeAlias, TypedDict

import numpy as np
from numpy.typing import NDArray

Floats: TypeAlias = NDArray[np.float64]
Change: TypeAlias = tuple[str, float | str]
Progress: TypeAlias = Callable[[float], None] | None


#: Preparation of a recording: part whose position it is, zero from the rest, low-pass in Hz, low-pass by each channel's
#: own noise, inverted columns, delays of columns, s, and stated zeros of columns.
Ready: TypeAlias = tuple[str | None, bool, float | None, bool, list[str], list[tuple[str, float]], list[tuple[str, float]]]


class Steps(TypedDict):
    """All settings of the steps."""

    step: float
    theta: float
    solver: str
    friction: str
    friction_width: float
    hand: tuple[float, float, float, float, float, float | None, float | None] | None


class Fitted(TypedDict):
    """Result of a fit."""

    #: Name, unit, whether it is a factor, bounds, and whether it ended at one.
    free: list[tuple[str, str, bool, float, float, bool]]
    point: Floats
    message: str
    x: list[float]
    std: list[float]
    #: SI value and standard deviation.
    values: list[tuple[float, float]]
    #: 95 % intervals of the SI values.
    intervals: list[tuple[float, float]]
    independent_samples: float
    cov: Floats
    inner_cov: Floats
    sensors_cov: Floats
    residuals: Floats
    degrees_of_freedom: int
    chi2_reduced: float | None
    chi2_expected: float | None
    singular_values: Floats
    unseen: list[str]
    jacobian_agreement: float
    time_step_agreement: float
    #: Title, noise, whether it is known, its correlation time, root mean square misfit at the start and at the end,
    #: delay.
    channels: list[tuple[str, float, bool, float, float, float, float | None]]
    #: Two parameters by index, and their correlation.
    correlated: list[tuple[int, int, float]]
    evaluations: int
    differentiated: int
    #: Parameter, its explanation, quantity of the bench, its unit, before the fit, fitted, standard deviation.
    meanings: list[tuple[str, str, str, str, float, float, float]]
    #: Kind and sentence.
    doubts: list[tuple[str, str]]


class Work(TypedDict):
    """Settings of many strokes, and columns to record."""

    threads: int | None
    single: bool
    ledger: bool
    columns: list[str]
    every: int
    tolerance: float | None
