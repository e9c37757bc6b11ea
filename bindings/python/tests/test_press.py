"""One press: what comes out, how it is read, that it is the command's own."""

import io
import json
import os
import pickle
import shutil
import subprocess
from pathlib import Path

import erard
import numpy as np
import pytest


def test_columns_are_views_that_cannot_be_written(run: erard.Run) -> None:
    key = run["key_m"]
    assert key is run["key_m"] and not key.flags.writeable and not key.flags.owndata
    with pytest.raises(ValueError):
        key[0] = 1.0
    with pytest.raises(ValueError):
        key.flags.writeable = True
    assert all(len(values) == len(run["time_s"]) for values in run.values())
    assert run.units["hammer_rad_per_s"] == "rad/s" and run.columns[:4] == ["time_s", "force_N", "key_m", "hammer_rise_m"]
    with pytest.raises(KeyError, match="hammer_rise_m"):
        run["hammer"]


def test_events(run: erard.Run) -> None:
    assert run.hammer_speed == run.events["hammer_speed"] == run.impacts[0][1]
    assert run.events["let_off"] <= run.events["hammer_contact"] == run.impacts[0][0]
    with pytest.raises(TypeError):
        run.events["let_off"] = 0.0  # type: ignore[index]
    assert run.trusted and run.energy is not None and abs(run.energy["residual_relative"]) < 0.01
    soft = erard.load("concert-grand").press(force=0.2, duration=0.05)
    assert soft.hammer_speed is None and "hammer_contact" not in soft.events and "not reached" in repr(soft)


def test_arrow_shares_the_memory(run: erard.Run) -> None:
    pa = pytest.importorskip("pyarrow")
    address = run["key_m"].__array_interface__["data"][0]
    table = pa.table(run)
    assert table["key_m"].chunk(0).buffers()[1].address == address
    assert table.schema.field("key_m").metadata == {b"unit": b"m"}
    frame = run.to_pandas()
    assert np.shares_memory(frame["key_m"].to_numpy(), run["key_m"]) and frame.attrs["units"]["key_m"] == "m"
    polars = run.to_polars()
    assert np.shares_memory(polars["key_m"].to_numpy(allow_copy=False), run["key_m"])
    assert polars.columns == run.columns == table.column_names
    data = run.to_xarray()
    assert data["key_m"].attrs["units"] == "m" and data["key_m"].dims == ("time_s",)


def test_duckdb_reads_it(run: erard.Run) -> None:
    duckdb = pytest.importorskip("duckdb")
    played = duckdb.from_arrow(pytest.importorskip("pyarrow").RecordBatchReader.from_stream(run))
    assert played.columns == run.columns
    [(deepest,)] = duckdb.sql("select max(key_m) from run").fetchall()  # DuckDB finds it by its name.
    assert deepest == run["key_m"].max()


def test_pickles_and_compares(grand: erard.Instrument, run: erard.Run) -> None:
    again = pickle.loads(pickle.dumps(run))
    assert again == run and not again["key_m"].flags.writeable and again.svg() == run.svg()
    assert run == grand.press(force=5.0, duration=0.2) and run != grand.press(force=5.1, duration=0.2)
    varied = grand.vary({"body.hammer.mass": "+0.8 g"}, let_off="-0.2 mm")
    assert pickle.loads(pickle.dumps(varied)) == varied != grand
    assert hash(grand) == hash(erard.load("concert-grand"))
    with pytest.raises(TypeError):
        hash(run)


def test_strokes(grand: erard.Instrument) -> None:
    constant = grand.press(force=5.0, duration=0.1)
    sampled = grand.press(force=np.full(101, 5.0), dt=1e-3, duration=0.1)
    assert np.array_equal(constant["key_m"], sampled["key_m"])
    assert grand.press(stroke="mf").title == "mf, pressed" == grand.press().title
    # A level is a speed of the hammer, whoever plays it.
    for hand in (None, erard.Hand(mass_kg=0.05)):
        assert grand.press(hammer_speed=2.5, touch="struck", hand=hand, duration=0.1).hammer_speed == pytest.approx(2.5, rel=1e-3)
    # The joints of the struck touch are its default, to the bit; stiff ones need another hand for the same level.
    own = grand.press(hammer_speed=2.5, touch="struck", duration=0.1)
    typed = grand.press(hammer_speed=2.5, touch="struck", hand=erard.Hand(joints_m_per_n=0.2e-3, joints_s=8e-3), duration=0.1)
    stiff = grand.press(hammer_speed=2.5, touch="struck", hand=erard.Hand(joints_m_per_n=0.0), duration=0.1)
    assert np.array_equal(own["key_m"], typed["key_m"]) and not np.array_equal(own["key_m"], stiff["key_m"])
    soft = grand.press(force=6.0, hand=erard.Hand(start_m_per_s=0.3, joints_m_per_n=0.5e-3), duration=0.1)
    assert abs(soft.hammer_speed / grand.press(force=6.0, hand=erard.Hand(start_m_per_s=0.3), duration=0.1).hammer_speed - 1.0) > 0.05  # type: ignore[operator]
    with pytest.raises(erard.InputError, match="compliance of the joints"):
        grand.press(force=6.0, hand=erard.Hand(joints_m_per_n=1.0))
    with pytest.raises(erard.InputError, match="reaches 0.0.* to 6"):
        grand.press(hammer_speed=8.0)
    assert grand.press(stroke="mf", drive="force").hammer_speed == pytest.approx(1.898, abs=1e-3)
    assert grand.press(stroke="ff", touch="struck").hammer_speed > grand.press(stroke="pp").hammer_speed  # type: ignore[operator]
    depth = 0.0045 * (1 - np.cos(np.pi * np.linspace(0, 1, 51)))
    rigid = grand.press(rigid=depth, dt=1e-3, duration=0.05)
    assert np.allclose(rigid["key_m"][::20], depth, atol=2e-5)
    soft = grand.press(motion=depth, dt=1e-3, duration=0.05)
    # Half-way down the key is behind the fingertip that pushes it.
    assert 0 < soft["key_m"][500] < depth[25]


def test_a_run_drives_again(grand: erard.Instrument, run: erard.Run, tmp_path: Path) -> None:
    """As a mapping, a data frame, a CSV and a Parquet file: the force of a run gives the run, to the bit where it is constant."""
    path = tmp_path / "run.csv"
    run.to_pandas().to_csv(path, index=False)
    run.to_pandas().to_parquet(tmp_path / "run.parquet")
    for recorded in (run, dict(run), run.to_pandas(), run.to_polars()):
        again = grand.press(stroke=recorded, duration=0.2)
        assert again.hammer_speed == run.hammer_speed and np.array_equal(again["key_m"], run["key_m"])
    for file in (path, str(tmp_path / "run.parquet")):
        again = grand.press(stroke=erard.Recording(file, zero=False, low_pass=None), duration=0.2)
        assert again.hammer_speed == run.hammer_speed and np.array_equal(again["key_m"], run["key_m"])


@pytest.mark.parametrize("name", ["concert-grand", "concert-grand-rigid"])
def test_the_key_that_was_recorded_is_the_key_that_is_driven(name: str) -> None:
    """The front of a key that bends, too: imposed on it, its recorded travel gives the run again, and so does the recorded force, of which every fifth
    sample is enough. A stroke that swells from nothing is also given again by the fingertip's motion, which key and
    force tell; one that begins with a force is not, for a fingertip that begins in touch has pressed the key down before the run starts."""
    own = erard.load(name)
    swelling, sudden = own.press(stroke="mf", duration=0.12), own.press(force=5.0, duration=0.12)
    struck = own.press(stroke="mf", touch="struck", duration=0.12)
    for run in (swelling, sudden, struck):
        # The force of a hand that arrives jumps: it takes every sample.
        every = 1 if run is struck else 5
        force = {"time_s": run["time_s"][::every], "force_N": run["force_N"][::every]}
        assert own.press(stroke=force, duration=0.12).hammer_speed == pytest.approx(run.hammer_speed, rel=1e-4)
        rigid = own.press(stroke=run, drive="rigid", duration=0.12)
        assert rigid.hammer_speed == pytest.approx(run.hammer_speed, rel=1e-4)
        # Where a recording ends the key stops, and its spline knows that some samples before.
        assert np.allclose(rigid["key_m"][:-20], run["key_m"][:-20], rtol=0, atol=1e-7)
    for drive in ("force", "motion"):
        again = own.press(stroke=swelling, drive=drive, duration=0.12)
        assert again.hammer_speed == pytest.approx(swelling.hammer_speed, rel=1e-4), drive
        assert again.events["hammer_contact"] == pytest.approx(swelling.events["hammer_contact"], abs=1e-5), drive
    late = own.press(stroke=sudden, drive="motion", duration=0.12)
    assert late["key_m"][0] > 5e-5 and "begins with a force" in late.notes[0]
    assert not own.press(stroke=swelling, drive="motion", duration=0.12).notes


WRONG = [
    ({"force": "5 N"}, "a number"),
    ({"force": -1.0}, "cannot pull"),
    ({"force": float("nan")}, "finite"),
    ({"force": [1.0, 2.0]}, "dt"),
    ({"force": np.full((2, 9), 5.0), "dt": 1e-3}, r"shape \(2, 9\)"),
    ({"force": [1.0, np.nan], "dt": 1e-3}, "sample 1 is nan"),
    ({"force": np.full(9, 5j), "dt": 1e-3}, "complex"),
    ({"force": 5.0, "stroke": "mf"}, "force and stroke"),
    ({"force": 5.0, "drive": "motion"}, "a recording only"),
    ({"force": 5.0, "touch": "struck"}, "a built-in stroke only"),
    ({"motion": 0.01, "dt": 1e-3}, "a single number"),
    ({"stroke": "mezzoforte"}, "pp, p, mf, f, ff or a recording"),
    ({"stroke": "none.csv"}, "cannot be read"),
    ({"stroke": {"time_s": [0.0, 0.1], "force_N": [5.0, 5.0]}, "drive": "rigid"}, "position_m"),
    ({"stroke": {"time_s": [0.0, 0.1], "force_N": [5j, 5j]}}, "complex"),
    ({"stroke": {"time_s": [0.0, 0.1], "force_N": [5.0, np.inf]}}, "not a finite number"),
    ({"tolerance": "fine"}, "a number"),
    ({"record_every": 2.5}, "a whole number"),
    ({"model": "two-dof"}, "one-dof"),
    ({"step": 1.0}, "1e-8 to 1e-3 s"),
    ({"duration": -1.0}, "positive"),
]


@pytest.mark.parametrize(("arguments", "told"), WRONG, ids=[told for _, told in WRONG])
def test_wrong_arguments(grand: erard.Instrument, arguments: dict, told: str) -> None:
    with pytest.raises(erard.InputError, match=told) as raised:
        grand.press(**arguments)
    assert raised.value.key or raised.value.file or "position_m" in told


def test_recordings_from_elsewhere(run: erard.Run, grand: erard.Instrument) -> None:
    """Whatever has columns, with channels turned and late ones put back; empty cells are reported."""
    plain = erard.Recording(run, zero=False, low_pass=None)
    pa = pytest.importorskip("pyarrow")
    for other in (run.to_xarray(), pa.table(run), run.to_polars()):
        assert erard.Recording(other, zero=False, low_pass=None) == plain
    time_s = run["time_s"]
    mine = {"t (ms)": 1e3 * time_s, "F": -run["force_N"], "x": run["key_m"]}
    columns = {"time": "t (ms)", "force": "F:N", "position": "x:m"}
    with pytest.raises(erard.InputError, match="F"):
        erard.Recording(mine, columns={"time": "t (ms)", "force": "F"})
    stated = erard.Recording(mine, columns=columns, zero={"force_N": 0.5}, low_pass=None)
    raw = erard.Recording(mine, columns=columns, zero=False, low_pass=None)
    later = np.linspace(0.01, 0.1, 50)
    assert np.allclose(stated.at("force_N", later), raw.at("force_N", later) - 0.5, atol=1e-12)
    assert any("as was said" in note for note in stated.notes)
    turned = erard.Recording(mine, columns=columns, zero=False, low_pass=None, invert=["force_N"], delay={"force_N": 2e-3})
    at = np.linspace(0.01, 0.1, 50)
    assert np.allclose(turned.at("force_N", at), plain.at("force_N", at + 2e-3)) and np.allclose(turned.at("key_m", at), plain.at("key_m", at))
    with pytest.raises(erard.InputError, match="force_N, key_m, hammer_rise_m"):
        erard.Recording(run, invert=["force"])
    with pytest.raises(erard.InputError, match="finite"):
        plain.at("key_m", [np.nan])
    gap = np.where(np.abs(time_s - 0.1) < 0.005, np.nan, run["key_m"])
    assert any("empty" in note for note in erard.Recording({"time_s": time_s, "key_m": gap}).notes)


def test_the_other_model_and_the_pins(grand: erard.Instrument, run: erard.Run) -> None:
    simple = grand.press(force=5.0, duration=0.2, model="one-dof")
    assert "hammer_rise_m" not in simple and {"key_start", "key_bottom"} <= set(simple.events) and "one degree" in simple.instrument
    pins = grand.press(force=5.0, duration=0.2, reactions=True)
    assert pins.columns[: len(run.columns)] == run.columns and all(np.array_equal(pins[name], run[name]) for name in run)
    assert pins.units["key_rad_per_s2"] == "rad/s2" and pins.units["key_back_pin_y_N"] == "N"
    assert np.all(np.isfinite(pins["key_back_pin_y_N"]))
    # At rest the balance rail, and the dry balance pin beside it, carry the key (140 g) and what presses it down, less
    # what the punching carries. The check leans on the hammer at a slant, so that a part of its force comes on top.
    down = 5.0 + sum(pins[name][-1] for name in ("capstan_heel_N", "key_damper_N")) + 0.140 * 9.81
    on_top = pins["balance_rail_N"][-1] + pins["key_back_pin_y_N"][-1] - (down - pins["key_front_N"][-1])
    assert 0.0 < on_top < np.hypot(pins["check_N"][-1], pins["check_tangential_N"][-1])
    alone = grand.press(stroke={"time_s": run["time_s"], "key_m": run["key_m"]}, drive="motion", duration=0.05)
    assert any("without a recorded force" in note for note in alone.notes) and not run.notes


def test_losses_by_pin_and_contact(grand: erard.Instrument, run: erard.Run) -> None:
    """They are those of the ledger, part by part, and asking for them changes no bit."""
    lost = grand.press(force=5.0, duration=0.2, losses=True)
    assert lost == run and run.losses is None and lost.losses is not None
    rows = lost.losses
    assert {(row["kind"], row["name"]) for row in rows} == {("pin", name) for name in grand.bodies} | {("contact", name) for name in grand.zones}
    assert [row["loss_J"] for row in rows] == sorted((row["loss_J"] for row in rows), reverse=True)
    assert sum(row["share"] for row in rows) == pytest.approx(1.0)
    energy, pins, contacts = lost.energy, [r for r in rows if r["kind"] == "pin"], [r for r in rows if r["kind"] == "contact"]
    assert energy is not None and lost.energy == run.energy
    for name, own, key in (("pivot_dry_J", pins, "dry_J"), ("pivot_viscous_J", pins, "viscous_or_felt_J"), ("coulomb_J", contacts, "dry_J"), ("felt_J", contacts, "viscous_or_felt_J")):  # fmt: skip
        assert sum(row[key] for row in own) == pytest.approx(energy[name], rel=1e-6, abs=1e-9), name
    assert pickle.loads(pickle.dumps(lost)).losses == rows


def test_figures(run: erard.Run, grand: erard.Instrument, tmp_path: Path) -> None:
    assert run.svg().startswith("<svg") and "let-off" in run.svg() and run.svg() in run._repr_html_()
    pytest.importorskip("matplotlib").use("Agg")
    assert len(run.plot().axes) == 4 and len(run.plot("key_m").axes) == 1
    [above] = [child for child in run.plot().axes[0].get_children() if type(child).__name__ == "SecondaryAxis"]
    told = ", ".join(label.get_text() for label in above.get_xticklabels())
    assert sorted(told.split(", ")) == sorted(name.replace("_", " ") for name in run.events if name != "hammer_speed")
    drawing = grand.draw("let_off", stroke="mf", labels=True, forces=True)
    drawing.save(tmp_path / "action.svg")
    assert (tmp_path / "action.svg").read_text() == drawing._repr_svg_() and "let off" in drawing.svg
    assert grand.draw().svg != drawing.svg and "at rest" in grand._repr_html_()
    with pytest.raises(erard.InputError, match="no check"):
        grand.draw("check", force=0.5)


@pytest.mark.skipif(not os.environ.get("ERARD"), reason="ERARD names no command to compare with")
def test_the_command_gives_the_same_bits(grand: erard.Instrument, tmp_path: Path) -> None:
    command = shutil.which(os.environ["ERARD"])
    assert command
    out = tmp_path / "out"
    arguments = [command, "press", "--force-step", "5", "--duration", "0.1", "--reactions", "--losses", "--out", str(out)]
    subprocess.run(arguments, check=True, capture_output=True)
    lost = json.loads((out / "losses.json").read_text())["losses"]
    run = grand.press(force=5.0, duration=0.1, reactions=True, losses=True)
    assert run.losses == lost
    table = np.genfromtxt(io.StringIO((out / "run.csv").read_text()), delimiter=",", names=True)
    assert list(table.dtype.names) == run.columns
    for name in run.columns:
        assert np.array_equal(table[name], run[name]), name
    # The figure too, but for the line that says what made it.
    assert run.svg().count("<path") == (out / "run.svg").read_text().count("<path")
