"""One press: what comes out, how it is read, that it is the command's own."""

import io
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
    assert run.units["hammer_rad_per_s"] == "rad/s" and run.columns[:4] == ["time_s", "force_N", "key_m", "hammer_head_m"]
    with pytest.raises(KeyError, match="hammer_head_m"):
        run["hammer"]


def test_events(run: erard.Run) -> None:
    assert run.hammer_speed == run.events["hammer_speed"] == run.strikes[0][1]
    assert run.events["let_off"] <= run.events["hammer_contact"] == run.strikes[0][0]
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
    assert grand.press(stroke="ff", touch="struck").hammer_speed > grand.press(stroke="pp").hammer_speed  # type: ignore[operator]
    depth = 0.0045 * (1 - np.cos(np.pi * np.linspace(0, 1, 51)))
    rigid = grand.press(rigid=depth, dt=1e-3, duration=0.05)
    assert np.allclose(rigid["key_m"][::20], depth, atol=2e-5)
    soft = grand.press(motion=depth, dt=1e-3, duration=0.05)
    # Half-way down the key is behind the fingertip that pushes it.
    assert 0 < soft["key_m"][500] < depth[25]


def test_a_run_drives_again(grand: erard.Instrument, run: erard.Run, tmp_path: Path) -> None:
    """As a mapping, a data frame, a CSV and a Parquet file: the force of a run gives the run, but for the first row, which says half of the force
    that begins there: 25 us of the 35 ms up to the blow, a share of 7e-4 of its impulse at most."""
    path = tmp_path / "run.csv"
    run.to_pandas().to_csv(path, index=False)
    run.to_pandas().to_parquet(tmp_path / "run.parquet")
    for recorded in (run, dict(run), run.to_pandas(), run.to_polars()):
        again = grand.press(stroke=recorded, duration=0.2)
        assert again.hammer_speed == pytest.approx(run.hammer_speed, rel=7e-4)
    for file in (path, str(tmp_path / "run.parquet")):
        again = grand.press(stroke=erard.Recording(file, zero=False, low_pass=None), duration=0.2)
        assert again.hammer_speed == pytest.approx(run.hammer_speed, rel=7e-4)


@pytest.mark.parametrize("name", ["concert-grand", "concert-grand-rigid"])
def test_the_key_that_was_recorded_is_the_key_that_is_driven(name: str) -> None:
    """The front of a key that bends, too: imposed on it, its recorded travel gives the run again. A stroke that swells from nothing is given again
    by its force and by the fingertip's motion, which key and force tell; one that begins with a force is not by the motion, for a fingertip that
    begins in touch has pressed the key down before the run starts."""
    own = erard.load(name)
    swelling, sudden = own.press(stroke="mf", duration=0.12), own.press(force=5.0, duration=0.12)
    for run in (swelling, sudden):
        rigid = own.press(stroke=run, drive="rigid", duration=0.12)
        assert rigid.hammer_speed == pytest.approx(run.hammer_speed, rel=1e-4)
        # Where a recording ends the key stops, and its spline knows that some samples before.
        assert np.allclose(rigid["key_m"][:-20], run["key_m"][:-20], rtol=0, atol=1e-7)
    for drive in ("force", "motion"):
        again = own.press(stroke=swelling, drive=drive, duration=0.12)
        assert again.hammer_speed == pytest.approx(swelling.hammer_speed, rel=1e-4), drive
        assert again.events["hammer_contact"] == pytest.approx(swelling.events["hammer_contact"], abs=1e-5), drive
    assert own.press(stroke=sudden, drive="motion", duration=0.12)["key_m"][0] > 5e-5


def test_figures(run: erard.Run, grand: erard.Instrument, tmp_path: Path) -> None:
    assert run.svg().startswith("<svg") and "let-off" in run.svg() and run.svg() in run._repr_html_()
    pytest.importorskip("matplotlib").use("Agg")
    assert len(run.plot().axes) == 4 and len(run.plot("key_m").axes) == 1
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
    arguments = [command, "press", "--force-step", "5", "--duration", "0.1", "--out", str(out)]
    subprocess.run(arguments, check=True, capture_output=True)
    run = grand.press(force=5.0, duration=0.1)
    table = np.genfromtxt(io.StringIO((out / "run.csv").read_text()), delimiter=",", names=True)
    assert list(table.dtype.names) == run.columns
    for name in run.columns:
        assert np.array_equal(table[name], run[name]), name
    # The figure too, but for the line that says what made it.
    assert run.svg().count("<path") == (out / "run.svg").read_text().count("<path")
