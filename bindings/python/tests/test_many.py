"""Many strokes at once."""

import pickle
from concurrent.futures import ProcessPoolExecutor

import erard
import numpy as np
import pytest


def forces(count: int, samples: int = 101) -> np.ndarray:
    return np.repeat(np.linspace(3.0, 12.0, count)[:, None], samples, axis=1)


def test_every_stroke_is_a_press(grand: erard.Instrument) -> None:
    force = forces(9)
    rollout = erard.rollout([grand], force=force, dt=1e-3, columns=["force_N", "key_m", "hammer_rise_m", "hammer_rad"])
    for row in (0, 4, 8):
        run = grand.press(force=force[row], dt=1e-3, duration=0.1)
        assert rollout["hammer_speed_m_per_s"][row] == pytest.approx(run.hammer_speed, rel=1e-6)
        for name in ("key_m", "hammer_rise_m", "hammer_rad"):
            size = np.abs(run[name]).max()
            assert np.allclose(rollout[name][row], run[name][::20], atol=1e-6 * size), name
    assert rollout["key_m"].shape == force.shape and np.array_equal(rollout["force_N"], force)
    assert not rollout["key_m"].flags.writeable and not rollout.errors
    assert pickle.loads(pickle.dumps(rollout)) == rollout


def test_the_same_bits_on_any_number_of_threads(grand: erard.Instrument) -> None:
    one, two = (erard.rollout(grand, force=forces(20), dt=1e-3, threads=threads) for threads in (1, 2))
    assert one == two


def test_variants_and_motions(grand: erard.Instrument) -> None:
    variants = [grand.vary({"body.hammer.mass": f"x{factor}"}) for factor in (0.9, 1.0, 1.1)]
    rollout = erard.rollout(variants, force=np.full((3, 101), 6.0), dt=1e-3)
    assert np.all(np.diff(rollout["hammer_speed_m_per_s"]) < 0)
    depth = 0.0045 * (1 - np.cos(np.pi * np.linspace(0, 1, 51)))
    rigid = erard.rollout(grand, rigid=np.stack([depth, 0.9 * depth]), dt=1e-3, columns=["key_m", "force_N", "string_N"])
    assert np.allclose(rigid["key_m"][0], depth, atol=2e-5) and rigid["force_N"].max() > 0.3


def test_steps_divide_the_samples(grand: erard.Instrument) -> None:
    coarse = erard.rollout(grand, force=forces(2, 61), dt=1.7e-3, columns=["key_m"])
    run = grand.press(force=forces(2, 61)[1], dt=1.7e-3, duration=60 * 1.7e-3, step=50e-6)
    assert np.allclose(coarse["key_m"][1], np.interp(coarse.time_s, run["time_s"], run["key_m"]), atol=2e-6)


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        ({"force": [1.0, 2.0], "dt": 1e-3}, r"shape \(2,\)"),
        ({"force": [[1.0, np.nan]], "dt": 1e-3}, r"sample \(0, 1\) is nan"),
        ({"force": [[1.0]], "dt": 1e-3}, "two samples"),
        ({"force": [["a", "b"]], "dt": 1e-3}, "array of numbers"),
        ({"force": [[1.0, 1.0]], "dt": 0.0}, "dt"),
        ({"dt": 1e-3}, "expected one of force"),
        ({"force": [[1.0, 1e9]], "dt": 1e-3}, "at most 10000 N"),
        ({"force": [[1.0, 1.0]], "dt": 1e-3, "threads": 0}, "threads"),
        ({"force": [[1.0, 1.0]], "dt": 1e-3, "columns": ["key_mm"]}, "`key_mm`"),
        ({"force": [[1.0, 1.0]], "dt": 1e-3, "columns": "key_m"}, "a list of names"),
        ({"force": [[1j, 1.0]], "dt": 1e-3}, "complex"),
    ],
)
def test_wrong_arguments(grand: erard.Instrument, arguments: dict, told: str) -> None:
    with pytest.raises(erard.InputError, match=told):
        erard.rollout(grand, **arguments)
    with pytest.raises(erard.InputError, match="one for each row"):
        erard.rollout([grand, grand], force=forces(3), dt=1e-3)


def test_studies(grand: erard.Instrument) -> None:
    turns = np.linspace(-5e-4, 5e-4, 5)
    study = erard.study(grand, let_off=turns, force=[5.0, 8.0])
    assert study.shape == (5, 2) and study.columns[:2] == ["let_off", "force_N"]
    row = 2 * 1 + 1
    run = grand.vary(let_off=float(turns[1])).press(force=8.0)
    assert study["hammer_speed_m_per_s"][row] == pytest.approx(run.hammer_speed, rel=1e-6)
    assert study["let_off_s"][row] == pytest.approx(run.events["let_off"], abs=1e-7)
    labelled = study.to_xarray()["hammer_speed_m_per_s"]
    assert labelled.sel(force_N=8.0).values[1] == study["hammer_speed_m_per_s"][row]
    grams = 1e3 * grand.parameters["body.hammer.mass"].value
    by_path = erard.study(grand, {"body.hammer.mass_g": [0.95 * grams, 1.05 * grams]}, stroke="mf", measure=["strike_weight_g"])
    assert by_path["strike_weight_g"][0] < by_path["strike_weight_g"][1]
    assert pickle.loads(pickle.dumps(study)) == study
    fails = erard.study(grand, {"body.hammer.mass": [1e-3 * grams, -1.0]}, force=5.0)
    assert list(fails["failed"]) == [False, True] and "cannot be varied" in fails.errors[1]
    assert np.isnan(fails["hammer_speed_m_per_s"][1])
    assert list(fails["error"]) == ["", fails.errors[1]] and list(fails.errors) == [1] and "1 failed" in repr(fails)
    frame = fails.to_pandas()
    assert list(frame["error"]) == list(fails["error"]) and fails.to_arrow()["error"].to_pylist() == list(fails["error"])
    assert pickle.loads(pickle.dumps(fails)) == fails
    with pytest.raises(erard.InputError, match="nothing is varied"):
        erard.study(grand, force=5.0)


def test_a_variant_that_fails_has_its_reason(grand: erard.Instrument) -> None:
    """A number that the reader refuses, and a screw at which nothing can be measured: rows, beside others that stand."""
    grams = 1e3 * grand.parameters["body.hammer.mass"].value
    by_path = erard.study(grand, {"body.hammer.mass_g": [grams, -1.0]}, force=5.0, duration=0.1)
    assert list(by_path["failed"]) == [False, True] and "mass_g" in by_path["error"][1]
    own = grand.parameters["capstan_height"].value
    sheet = erard.study(grand, capstan_height=[own, own + 0.02], force=5.0, duration=0.1, measure=["key_ratio"])
    assert not sheet["failed"].any() and np.isnan(sheet["key_ratio"][1]) and sheet["key_ratio"][0] > 0.4
    assert sheet["error"][0] == "" and sheet["error"][1].startswith("not measured: cannot be measured")
    assert sheet.errors == {1: sheet["error"][1]} and "failed" not in repr(sheet)


def test_what_is_varied_has_units_and_is_drawn_over(grand: erard.Instrument) -> None:
    study = erard.study(grand, {"let_off": [-2e-4, 0.0, 2e-4], "body.hammer.mass": ["x0.9", "x1.1"]}, force=5.0, duration=0.06)
    assert (study.units["let_off"], study.units["body.hammer.mass"]) == ("m", "kg")
    assert study.to_xarray()["let_off"].attrs["units"] == "m" and study.to_arrow().schema.field("let_off").metadata == {b"unit": b"m"}
    pytest.importorskip("matplotlib").use("Agg")
    [panel] = study.plot().axes
    assert panel.get_xlabel() == "let_off (mm)" and len(panel.lines) == 2
    assert list(panel.lines[1].get_ydata()) == list(study["hammer_speed_m_per_s"][1::2])
    [panel] = study.plot("let_off_s", over="body.hammer.mass").axes
    assert panel.get_xlabel() == "body.hammer.mass (g)" and len(panel.lines) == 3
    with pytest.raises(erard.InputError, match="let_off, body.hammer.mass"):
        study.plot(over="drop")


def test_what_was_sampled_goes_along(grand: erard.Instrument) -> None:
    """Into data frames and data bases as lists, into xarray as a second dimension."""
    rollout = erard.rollout(grand, force=forces(3), dt=1e-3)
    pa = pytest.importorskip("pyarrow")
    table = pa.table(rollout)
    assert table.column_names == rollout.columns and table.schema.field("key_m").metadata == {b"unit": b"m"}
    assert np.array_equal(np.array(table["key_m"].to_pylist()), rollout["key_m"])
    assert np.array_equal(rollout.to_polars()["key_m"].to_numpy(), rollout["key_m"])
    assert rollout.to_xarray()["key_m"].dims == ("stroke", "time_s")


def test_studies_read_values_as_people_write_them(grand: erard.Instrument) -> None:
    grams = 1e3 * grand.parameters["body.hammer.mass"].value
    told = erard.study(grand, {"let_off": ["-0.2 mm", "+0.1 mm"], "body.hammer.mass": [f"{1.1 * grams} g"]}, force=5.0)
    assert np.allclose(told["let_off"], grand.parameters["let_off"].value + np.array([-2e-4, 1e-4])) and np.allclose(told["body.hammer.mass"], 1.1e-3 * grams)
    for wrong, why in (({"let_off": ["1 g"]}, "not one of its units"), ({"body.hammer.mass_g": ["9 g"]}, "not texts"), ({"let_off": [1j]}, "complex")):
        with pytest.raises(erard.InputError, match=why):
            erard.study(grand, wrong, force=5.0)
    with pytest.raises(erard.InputError, match="found none"):
        erard.study(grand, let_off=[0.0], force=[])
    with pytest.raises(erard.InputError, match="a list of names"):
        erard.study(grand, let_off=[0.0], measure="dip_mm")


def speed(arguments: tuple[erard.Instrument, float]) -> float | None:
    instrument, force = arguments
    return instrument.press(force=force, duration=0.1).hammer_speed


def test_a_process_pool_plays_pickled_instruments(grand: erard.Instrument) -> None:
    heavy = grand.vary({"body.hammer.mass": "x1.1"})
    work = [(grand, 5.0), (heavy, 5.0)]
    with ProcessPoolExecutor(2) as pool:
        assert list(pool.map(speed, work)) == [speed(one) for one in work]
