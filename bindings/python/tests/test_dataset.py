"""Data sets: the same from the same plan, labels that are true, sensors as they are described."""

from pathlib import Path

import erard
import numpy as np
import pytest
from erard import dataset

pytest.importorskip("pyarrow")
PLAN = dataset.Plan(count=20, seed=3, keys=(1, 40, 88), chunk=8)


def test_the_same_plan_gives_the_same_data(tmp_path: Path) -> None:
    one = dataset.write(PLAN, tmp_path / "one", progress=False)
    whole = dataset.read(one)
    assert whole.num_rows == 20 and whole["stroke"].to_pylist() == list(range(20))
    assert dataset.chunk(PLAN, 1, threads=1).equals(dataset.chunk(PLAN, 1, threads=2))
    # Interrupted after its first part, it goes on to the same.
    (one / "part-000001.parquet").unlink()
    assert dataset.read(dataset.write(PLAN, one, progress=False)).equals(whole)
    with pytest.raises(erard.InputError, match="another piece of work"):
        dataset.write(dataset.Plan(count=20, seed=4, keys=(40,), chunk=8), one)
    text = (one / "README.md").read_text()
    assert all(word in text for word in ("seed 3", "What it is not", "key_counts", "hammer_speed_m_per_s"))
    assert {"hammer_contact_s", "release_s", "double_strike"} <= set(whole.column_names)
    units = {name: whole.schema.field(name).metadata[b"unit"] for name in ("force_N", "hammer_speed_m_per_s", "turned_let_off_m", "key_counts")}
    assert units == {"force_N": b"N", "hammer_speed_m_per_s": b"m/s", "turned_let_off_m": b"m", "key_counts": b"1"}


def test_labels_are_what_happened() -> None:
    table = dataset.chunk(dataset.Plan(count=40, seed=5, keys=(40,), chunk=40, misregulated=0.0), 0)
    rows = table.to_pylist()
    half = [row for row in rows if row["kind"] == "half"]
    assert half and np.mean([row["impact_count"] == 0 for row in half]) > 0.5
    assert any(row["impact_count"] >= 2 for row in rows if row["kind"] == "repeated")
    for row in rows:
        assert len(row["impacts"]) == row["impact_count"]
        if row["impact_count"]:
            assert row["impacts"][0] == {"time_s": row["hammer_contact_s"], "hammer_speed_m_per_s": row["hammer_speed_m_per_s"]}
        else:
            assert row["hammer_speed_m_per_s"] is None
        assert not any(row[f"turned_{screw}_m"] for screw in ("let_off", "capstan_height"))


def test_sensors_read_as_they_are_described() -> None:
    sensor = dataset.Sensor("s", "key_m", from_m=0.0, to_m=0.01, bits=8, noise=0.0, curvature=0.5)
    rng = np.random.default_rng(0)
    ways = np.linspace(-0.002, 0.012, 200)
    counts = sensor.read(ways, rng)
    assert counts.min() == 0 and counts.max() == 255 and np.all(np.diff(counts.astype(int)) >= 0)
    assert sensor.read(np.array([0.005]), rng)[0] == round(255 * 0.5 * 1.25)
    noisy = dataset.Sensor("s", "key_m", from_m=0.0, to_m=0.01, bits=16, noise=0.01)
    spread = np.std(noisy.read(np.full(4000, 0.005), rng) / 65535)
    assert spread == pytest.approx(0.01, rel=0.1)


@pytest.mark.parametrize(
    ("make", "told"),
    [
        (lambda: dataset.Plan(count=0), "count"),
        (lambda: dataset.Plan(keys=(0,)), "1 to 88"),
        (lambda: dataset.Plan(count=1.5), "whole number"),
        (lambda: dataset.Plan(seed=-1), "seed"),
        (lambda: dataset.Plan(kinds=(dataset.Kind("half", 0.0),)), "not all of them zero"),
        (lambda: dataset.Uniform(1.0, 0.0), "low <= high"),
        (lambda: dataset.LogUniform(0.0, 1.0), "above 0"),
        (lambda: dataset.Normal(0.0, -1.0), "deviation"),
        (lambda: dataset.Sensor("s", "key_m", 0.0, 0.01, bits=17), "bits"),
        (lambda: dataset.Sensor("s", "string_N", 0.0, 0.01), "string_N"),
        (lambda: dataset.Sensor("s", "key_m", 0.01, 0.0), "from_m"),
        (lambda: dataset.chunk(PLAN, 9), "index"),
        (lambda: dataset.read("no-such-folder"), "no parts"),
    ],
)
def test_wrong_plans(make, told: str) -> None:
    with pytest.raises(erard.InputError, match=told):
        make()
