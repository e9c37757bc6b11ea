"""The package accepts and refuses the numbers that the command and the C interface accept and refuse."""

import csv
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import erard
import numpy as np
import pytest

RANGES = Path(__file__).parents[3] / "crates" / "erard-core" / "tests" / "ranges.csv"


TIME_S = np.arange(60) * 1e-3
RECORDED = {"time_s": TIME_S, "force_N": 5.0 * (TIME_S > 0.0205), "key_m": 0.005 * np.clip((TIME_S - 0.02) / 0.02, 0.0, 1.0)}


def grand() -> erard.Instrument:
    return erard.load("concert-grand")


def whole(value: str) -> int | float:
    """A whole number where it is one."""
    return int(value) if value.lstrip("-").isdigit() else float(value)


def pressed(**how: Any) -> erard.Run:
    return grand().press(force=5.0, duration=1e-3, **how)


def played(**how: Any) -> erard.Run:
    return grand().press(stroke=erard.Recording(RECORDED, **how), duration=1e-3)


def fitted(**how: Any) -> erard.Fit:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", erard.DoubtfulFitWarning)
        sigma = {"force_N": 0.0, "key_m": 1e-4}
        return erard.fit(erard.load("concert-grand-rigid"), RECORDED, parameters=["body.hammer.mass"], sigma=sigma, **how)


def last(name: str, value: str, step_s: float) -> dict[str, list[float]]:
    """A recording that ends at the value."""
    return {"time_s": [0.0, step_s, 2 * step_s, 3 * step_s], name: [0.0, 0.0, 0.0, float(value)]}


OFFERED: dict[str, Callable[[str], object]] = {
    "step_s": lambda value: erard.load("concert-grand").press(force=5.0, duration=1e-3, step=float(value)),
    "duration_s": lambda value: erard.load("concert-grand").press(force=5.0, duration=float(value)),
    "force_n": lambda value: erard.load("concert-grand").press(force=float(value), duration=1e-3),
    "hammer_speed_m_per_s": lambda value: erard.load("concert-grand").press(hammer_speed=float(value)),
    "live_force_n": lambda value: erard.Action(erard.load("concert-grand")).step(force=float(value)),
    "live_position_m": lambda value: erard.Action(erard.load("concert-grand")).step(motion=(float(value), 0.0)),
    "live_speed_m_per_s": lambda value: erard.Action(erard.load("concert-grand")).step(motion=(0.0, float(value))),
    "key": lambda value: erard.load(f"concert-grand:key={value}"),
    "hammer_mass_factor": lambda value: erard.load("concert-grand").vary({"body.hammer.mass": f"*{value}"}),
    "theta": lambda value: pressed(theta=float(value)),
    "tolerance": lambda value: pressed(tolerance=float(value)),
    "friction_width_rad_per_s": lambda value: pressed(friction="tanh", friction_width=float(value)),
    "record_every": lambda value: pressed(record_every=whole(value)),
    "hand_mass_kg": lambda value: pressed(hand=erard.Hand(mass_kg=float(value))),
    "joints_mm_per_n": lambda value: pressed(hand=erard.Hand(joints_m_per_n=1e-3 * float(value), joints_s=8e-3)),
    "joints_ms": lambda value: pressed(hand=erard.Hand(joints_m_per_n=2e-4, joints_s=1e-3 * float(value))),
    "recorded_force_n": lambda value: grand().press(stroke=last("force_N", value, 1e-3), duration=3e-3),
    "recorded_key_m": lambda value: grand().press(stroke=last("key_m", value, 0.1), drive="motion", duration=1e-3),
    "low_pass_hz": lambda value: played(low_pass=float(value)),
    "delay_s": lambda value: played(delay={"force_N": float(value)}),
    "study_force_n": lambda value: erard.study(grand(), force=[1.0, float(value)], duration=1e-3),
    "study_tolerance": lambda value: erard.study(grand(), force=[1.0, 2.0], duration=1e-3, tolerance=float(value)),
    "drawn_at_s": lambda value: grand().draw(float(value), force=5.0),
    "kinematics_steps": lambda value: erard.kinematics("c7f-like", steps=whole(value)),  # type: ignore[arg-type]
    "measured_key": lambda value: grand().measure(key=whole(value), only=["dip_mm"]),  # type: ignore[arg-type]
    "down_weight_g": lambda value: erard.diagnose(up_weight_g=20, down_weight_g=float(value)),
    "fit_restarts": lambda value: fitted(max_evaluations=2, restarts=whole(value)),
    "fit_evaluations": lambda value: fitted(restarts=0, max_evaluations=whole(value)),
    "let_off_turned_mm": lambda value: erard.load("concert-grand").vary(let_off=f"+{value} mm".replace("+-", "-")),
}


with RANGES.open() as file:
    ROWS = [(row["quantity"], row["value"], row["accepted"] == "yes") for row in csv.DictReader(file)]


@pytest.mark.parametrize(("quantity", "value", "accepted"), ROWS)
def test_numbers_are_refused_as_by_the_other_fronts(quantity: str, value: str, accepted: bool) -> None:
    call = OFFERED[quantity]
    if accepted:
        call(value)
    else:
        with pytest.raises((erard.InputError, ValueError)):
            call(value)
