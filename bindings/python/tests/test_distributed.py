"""Work over a cluster: the same bits as alone, resumed where it stopped, whole though workers die."""

import os
import signal
import threading
import time
from pathlib import Path

import erard
import numpy as np
import pytest

pytest.importorskip("distributed")
pytest.importorskip("pyarrow")
from erard import dataset, distributed  # noqa: E402

AXES = {"let_off": np.linspace(-5e-4, 5e-4, 12), "body.hammer.mass": [0.9, 1.1]}
OUTCOMES = ("hammer_speed_m_per_s", "let_off_s", "key_bottom_s", "trusted")


def same(one, other) -> bool:
    """To the bit; what did not happen is nan in both."""
    return one.schema.equals(other.schema) and one.to_pandas().equals(other.to_pandas())


@pytest.fixture(scope="module")
def cluster():
    from distributed import Client, LocalCluster

    with LocalCluster(n_workers=2, threads_per_worker=1, processes=True, dashboard_address=":0") as own, Client(own) as client:
        yield client


def test_a_study_is_the_same_whoever_computes_it(grand: erard.Instrument, cluster, tmp_path: Path) -> None:
    alone = erard.study(grand, AXES, force=5.0)
    two = distributed.study(grand, tmp_path / "two", AXES, force=5.0, chunk=8, client=cluster, progress=False)
    one = distributed.study(grand, tmp_path / "one", AXES, force=5.0, chunk=8, workers=1, processes=False, progress=False)
    assert same(two.read(), one.read()) and two.parts == 3 == two.computed
    for name in ("let_off", "body.hammer.mass"):
        assert np.array_equal(two.read()[name].to_numpy(), alone[name])
    for name in OUTCOMES:
        assert np.allclose(two.read()[name].to_numpy(zero_copy_only=False), alone[name], rtol=1e-9, equal_nan=True), name
    # What is there is not computed again; other work is not mixed in.
    (tmp_path / "two" / "part-000001.parquet").unlink()
    again = distributed.study(grand, tmp_path / "two", AXES, force=5.0, chunk=8, client=cluster, progress=False)
    assert again.computed == 1 and same(again.read(), one.read())
    with pytest.raises(erard.InputError, match="another piece of work"):
        distributed.study(grand, tmp_path / "two", AXES, force=6.0, chunk=8, client=cluster, progress=False)


def test_rollouts_fits_and_data_sets(grand: erard.Instrument, cluster, tmp_path: Path) -> None:
    force = np.repeat(np.linspace(3.0, 12.0, 10)[:, None], 101, axis=1)
    parts = distributed.rollout(grand, tmp_path / "r", force=force, dt=1e-3, chunk=4, client=cluster, progress=False)
    table, alone = parts.read(), erard.rollout(grand, force=force, dt=1e-3)
    assert np.allclose(np.array(table["key_m"].to_pylist()), alone["key_m"], rtol=0, atol=1e-9)
    parts.to_zarr(tmp_path / "r.zarr")
    zarr = pytest.importorskip("zarr")
    group = zarr.open_group(str(tmp_path / "r.zarr"), mode="r")
    assert group["key_m"].shape == (10, 101) and group["key_m"].attrs["units"] == "m"
    plan = dataset.Plan(count=12, seed=1, keys=(40,), chunk=4)
    over = distributed.dataset(plan, tmp_path / "d", client=cluster, progress=False)
    assert over.read().equals(dataset.read(dataset.write(plan, tmp_path / "e", progress=False)))
    pytest.importorskip("scipy")
    runs = [grand.vary({"body.hammer.mass": f"x{f}"}).press(force=5.0, duration=0.06) for f in (0.95, 1.05)]
    fits = distributed.fit(grand, runs, parameters=["body.hammer.mass"], columns=["key_m"], sigma={"key_m": 1e-5}, client=cluster)
    assert [fit["x"]["body.hammer.mass"] for fit in fits] == pytest.approx([0.95, 1.05], abs=0.01)


@pytest.mark.skipif(os.name == "nt", reason="signals are POSIX's")
def test_a_worker_that_dies_loses_nothing(grand: erard.Instrument, tmp_path: Path) -> None:
    from distributed import Client, LocalCluster

    axes = {"let_off": np.linspace(-5e-4, 5e-4, 600)}
    with LocalCluster(n_workers=2, threads_per_worker=1, processes=True, dashboard_address=":0") as own, Client(own) as client:
        [victim, _] = client.run(os.getpid).values()

        def kill() -> None:
            folder = tmp_path / "s"
            while not list(folder.glob("part-*")):
                time.sleep(0.01)
            os.kill(victim, signal.SIGKILL)

        killer = threading.Thread(target=kill)
        killer.start()
        parts = distributed.study(grand, tmp_path / "s", axes, force=5.0, chunk=50, client=client, progress=False)
        killer.join()
        assert parts.parts == 12 and parts.read().num_rows == 600
    assert np.array_equal(parts.read()["let_off"].to_numpy(), axes["let_off"])
