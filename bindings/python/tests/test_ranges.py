"""The package accepts and refuses the numbers that the command and the C interface accept and refuse."""

import csv
from collections.abc import Callable
from pathlib import Path

import erard
import pytest

RANGES = Path(__file__).parents[3] / "crates" / "erard" / "tests" / "ranges.csv"


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
