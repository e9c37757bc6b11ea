"""Derivatives of a press: what wide differences see, by every kind of name."""

import math
import pickle
from collections.abc import Callable
from typing import Any

import erard
import numpy as np
import pytest

NAMES = ["let_off", "capstan_height", "zone.jack_knuckle.friction", "spring.repetition.torque", "force"]


@pytest.fixture(scope="module")
def rigid() -> erard.Instrument:
    return erard.load("concert-grand-rigid")


@pytest.fixture(scope="module")
def found(rigid: erard.Instrument) -> erard.Gradient:
    return erard.gradient(rigid, NAMES, force=5.0, columns=["key_m", "hammer_rise_m"], duration=0.12, unconverged="nan")


def test_speeds_and_instants_are_a_runs(rigid: erard.Instrument, found: erard.Gradient) -> None:
    run = rigid.press(force=5.0, duration=0.12, step=25e-6)
    assert found.value["hammer_speed_m_per_s"] == pytest.approx(run.hammer_speed, rel=1e-4)
    assert found.value["let_off_s"] == pytest.approx(run.events["let_off"], abs=2e-6)
    assert list(found) == found.outcomes and found.jacobian.shape == (len(found.outcomes), 5)
    row = found.outcomes.index("hammer_speed_m_per_s")
    assert found.in_shorter_steps is not None and np.allclose(found.in_shorter_steps[row], found.jacobian[row], rtol=0.1, atol=1e-3)
    key = np.interp(found.time_s, run["time_s"], run["key_m"])
    # Up to the key's bottom: later a little more or less of anything is much.
    before = found.time_s < run.events["key_bottom"]
    assert np.allclose(found.columns["key_m"][before], key[before], rtol=0, atol=2e-6)


def test_they_are_what_wide_differences_see(rigid: erard.Instrument, found: erard.Gradient) -> None:
    """Over 0.01 mm or 1 %, thousands of times what one step resolves; from two windows, for the results are curved.

    The capstan moves the rest, which has corners: differences of the key's first motion over 0.01 mm are a quarter off those over 0.001 mm and less, which
    agree with each other.
    """
    half = {"let_off": 1e-5, "capstan_height": 1e-6, "force": 0.02}

    def press(name: str, by: float) -> erard.Run:
        own = rigid if name == "force" else rigid.vary({name: f"{by:+}" if name in half else f"x{1.0 + by}"})
        return own.press(force=5.0 + (by if name == "force" else 0.0), duration=0.12, step=10e-6)

    for k, name in enumerate(NAMES):
        by = half.get(name, 0.01)
        runs = {share: press(name, share * by) for share in (-1.0, -0.5, 0.5, 1.0)}

        def slope(get: Callable[[erard.Run], Any], by: float = by, runs: dict[float, erard.Run] = runs) -> Any:
            far, near = (np.subtract(get(runs[share]), get(runs[-share])) / (2 * share * by) for share in (1.0, 0.5))
            return (4 * near - far) / 3

        assert found["hammer_speed_m_per_s"][name] == pytest.approx(slope(lambda run: run.hammer_speed), rel=0.05), name
        assert found["hammer_contact_s"][name] == pytest.approx(slope(lambda run: run.events["hammer_contact"]), rel=0.05), name
        before = found.time_s < 0.9 * runs[-1.0].events["hammer_contact"]
        for column in ("key_m", "hammer_rise_m"):
            seen = slope(lambda run, column=column: np.interp(found.time_s, run["time_s"], run[column]))
            own = found.column_jacobian[column][:, k]
            assert np.linalg.norm((own - seen)[before]) < 0.1 * np.linalg.norm(seen[before]) + 1e-12, (name, column)


def test_a_path_of_the_file_is_the_same_number(rigid: erard.Instrument) -> None:
    """A friction coefficient by its own name, as a factor, and by its path, as itself; also where it has been set."""
    name, path = "zone.jack_knuckle.friction", "zone.jack_knuckle.friction_coefficient"
    for own in (rigid, rigid.vary({path: 1.1 * rigid.parameters[name].value})):
        g = erard.gradient(own, [name, path], outcomes=["hammer_speed_m_per_s"], force=5.0, compare=False)
        factor, itself = g.jacobian[0]
        assert itself * own.parameters[name].value == pytest.approx(factor, rel=1e-6) and g.in_shorter_steps is None
    point = erard.gradient(rigid, ["zone.string.disc.center_mm.x"], force=5.0, compare=False)
    assert np.all(np.isfinite(point.jacobian))


def test_the_rest_moves_or_is_held(rigid: erard.Instrument) -> None:
    """The rest of `press` moves with a friction; held, the same friction only works on the press."""
    names, half = ["body.hammer.friction", "body.jack.friction"], 1e-2
    moving, held = (
        erard.gradient(rigid, names, outcomes=["hammer_speed_m_per_s"], force=5.0, rest=rest)["hammer_speed_m_per_s"] for rest in ("moves", "held")
    )
    for name in names:
        speeds = [rigid.vary({name: f"x{1.0 + by}"}).press(force=5.0, duration=0.12, step=5e-6).hammer_speed for by in (-half, half)]
        assert moving[name] == pytest.approx((speeds[1] - speeds[0]) / (2 * half), rel=0.02), name
        assert abs(held[name] / moving[name] - 1) > 0.3, name


def test_by_default_it_is_every_parameter(rigid: erard.Instrument) -> None:
    g = erard.gradient(rigid, outcomes=["hammer_speed_m_per_s"], stroke="ff", duration=0.08, compare=False)
    assert g.parameters == list(rigid.parameters) and g["hammer_speed_m_per_s"]["zone.check.stiffness"] == 0.0
    table = pytest.importorskip("pandas") and g.to_pandas()
    assert table.loc["hammer_speed_m_per_s", "let_off"] == g["hammer_speed_m_per_s"]["let_off"]


def test_what_does_not_happen_is_no_number(rigid: erard.Instrument) -> None:
    g = erard.gradient(rigid, ["let_off"], outcomes=["hammer_speed_m_per_s"], force=0.1, duration=0.05, compare=False)
    assert math.isnan(g.value["hammer_speed_m_per_s"]) and math.isnan(g.jacobian[0, 0])
    assert "hammer_speed_m_per_s" not in erard.gradient(rigid, ["let_off"], force=0.1, duration=0.05, compare=False)


def test_it_pickles_and_compares(found: erard.Gradient) -> None:
    again = pickle.loads(pickle.dumps(found))
    assert again == found and "hammer_speed_m_per_s" in repr(found) and "<table>" in found._repr_html_()
    with pytest.raises(ValueError, match="read-only"):
        found.jacobian[0, 0] = 1.0
    with pytest.raises(KeyError, match="expected one of"):
        found["loudness"]


@pytest.mark.parametrize(
    ("by", "arguments", "told"),
    [
        (["let_of"], {}, "nearest `let_off`"),
        ("let_off", {}, "list of names"),
        (["let_off", "let_off"], {}, "each once"),
        (["force"], {"stroke": "mf"}, "constant force"),
        (["let_off"], {"outcomes": ["loudness"]}, "hammer_speed_m_per_s"),
        (["let_off"], {"columns": ["string_N"]}, "hammer_rise_m"),
        (["let_off"], {"record_every": 0}, "whole number"),
        (["let_off"], {"friction": "tanh"}, "set-valued"),
        (["let_off"], {"step": float("nan")}, "finite"),
        (["let_off"], {"force": float("nan")}, "finite"),
        (["let_off"], {"force": [1.0, float("nan")], "dt": 1e-3}, "sample 1 is nan"),
        (["let_off"], {"rigid": [0.0, 1e-3, 2e-3], "dt": 1e-2, "columns": ["force_N"]}, "rigid drive"),
        (["let_off"], {"threads": 0}, "found 0"),
        (["let_off"], {"rest": "frozen"}, "moves or held"),
        (["let_off"], {"unconverged": "warn"}, "raise or nan"),
    ],
)
def test_wrong_arguments(rigid: erard.Instrument, by: list[str], arguments: dict, told: str) -> None:
    with pytest.raises(erard.InputError, match=told):
        erard.gradient(rigid, by, **arguments)


def test_what_has_no_derivatives_says_so() -> None:
    with pytest.raises(erard.InputError, match="modal strings"):
        erard.gradient(erard.load("concert-grand-strings"), ["let_off"], force=5.0)
    with pytest.raises(erard.InputError, match="expected an Instrument"):
        erard.gradient("concert-grand", ["let_off"])  # type: ignore[arg-type]
