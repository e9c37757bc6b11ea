"""The recordings of a real piano are what their script makes of what was read."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

RECORDINGS = Path(__file__).parents[3] / "recordings"


@pytest.mark.parametrize("stroke", ["slow", "medium", "fast", "repeated"])
def test_recordings_are_made_by_their_script(stroke: str, tmp_path: Path) -> None:
    pytest.importorskip("scipy")
    subprocess.run([sys.executable, RECORDINGS / "calibrate.py", tmp_path], check=True)
    name = f"kawai-kg-3c-{stroke}.csv"
    made, kept = (np.loadtxt(folder / name, delimiter=",", skiprows=1) for folder in (tmp_path, RECORDINGS))
    assert kept.shape[0] > 1000
    # The last digit that is written may round otherwise.
    np.testing.assert_allclose(made, kept, atol=0.011)
