"""The recordings of a real piano are what their script makes of what was read."""

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

RECORDINGS = Path(__file__).parents[3] / "recordings"


def test_the_law_of_the_sensor_is_the_scripts() -> None:
    pytest.importorskip("scipy")
    made = subprocess.run([sys.executable, "-c", "import calibrate; print(calibrate.law())"], cwd=RECORDINGS, check=True, capture_output=True, text=True).stdout
    source = (Path(__file__).parents[3] / "crates/erard-live/src/sensor.rs").read_text()
    kept = source.split("pub const CNY70: [f64; 16] = [")[1].split("]")[0]
    np.testing.assert_allclose(json.loads(made), [float(one) for one in kept.split(",") if one.strip()], atol=1.1e-4)


@pytest.fixture(scope="module")
def made_anew(tmp_path_factory: pytest.TempPathFactory) -> Path:
    pytest.importorskip("scipy")
    folder = tmp_path_factory.mktemp("recordings")
    subprocess.run([sys.executable, RECORDINGS / "calibrate.py", folder], check=True)
    return folder


@pytest.mark.parametrize("stroke", ["slow", "medium", "fast", "repeated", "struck-1", "struck-2", "struck-3", "struck-4"])
def test_recordings_are_made_by_their_script(stroke: str, made_anew: Path) -> None:
    name = f"kawai-kg-3c-{stroke}.csv"
    made, kept = (np.loadtxt(folder / name, delimiter=",", skiprows=1) for folder in (made_anew, RECORDINGS))
    assert kept.shape[0] > (800 if stroke.startswith("struck") else 1000)
    # The last digit that is written may round otherwise.
    np.testing.assert_allclose(made, kept, atol=0.011)


@pytest.mark.parametrize("script", ["releases", "hammers"])
def test_times_are_taken_by_their_script(script: str, tmp_path: Path) -> None:
    subprocess.run([sys.executable, RECORDINGS / f"{script}.py", tmp_path], check=True)
    name = f"kawai-kg-3c-{script}.csv"
    assert (tmp_path / name).read_text() == (RECORDINGS / name).read_text()
