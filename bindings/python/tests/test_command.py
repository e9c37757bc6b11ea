"""The command `erard fit` and `erard.fit` find the same in the same recording."""

import json
import os
import shutil
import subprocess
from pathlib import Path

import erard
import pytest

pytest.importorskip("scipy")
RECORDINGS = Path(__file__).parents[3] / "recordings"
VARY = ["body.hammer.mass", "body.key_back.friction", "zone.capstan_heel.stiffness", "let_off"]
SIGMA = {"force_N": 0.02, "key_m": 1e-5, "hammer_head_m": 5e-5}


def command() -> str:
    """The command as `ERARD` names it, or as it is found."""
    found = os.environ.get("ERARD") or shutil.which("erard")
    if found is None:
        pytest.skip("no command `erard` is here; ERARD names it")
    return found


def test_the_command_finds_the_same(tmp_path: Path) -> None:
    """Parameters within a tenth of their errors, errors within a quarter (each plays 48 disturbed strokes of its own), misfit to a hundredth."""
    paths = [RECORDINGS / f"heavier-{nuance}.csv" for nuance in ("mf", "f")]
    # Prepared alike: the command filters what drives alone, Python's recordings are filtered as a whole or not at all.
    recordings = [erard.Recording(path, zero=True, low_pass=None) for path in paths]
    bounds = {"body.hammer.mass": (0.5, 2.0), "let_off": (-1e-3, 1e-3)}
    fitted = erard.fit(erard.load("concert-grand"), recordings, vary=VARY, bounds=bounds, sigma=SIGMA)
    ran = subprocess.run(
        [
            command(), "fit", "concert-grand", *map(str, paths), "--vary", ",".join(VARY), "--low-pass", "off",
            "--bounds", "body.hammer.mass=0.5..2", "--bounds", "let_off=-1..1", "--sigma", "force=0.02,position=1e-5,hammer=5e-5",
            "--no-pictures", "--json", "--out", str(tmp_path / "fit"),
        ],
        check=True, capture_output=True, text=True,
    )  # fmt: skip
    said = json.loads(ran.stdout)
    assert [row["name"] for row in said["parameters"]] == VARY
    for row in said["parameters"]:
        own, std = fitted.x[row["name"]], fitted.std[row["name"]]
        assert row["varied"]["value"] == pytest.approx(own, abs=0.1 * std), row["name"]
        assert row["varied"]["std"] == pytest.approx(std, rel=0.25), row["name"]
        assert row["value"] == pytest.approx(fitted.values[row["name"]], abs=0.1 * fitted.errors[row["name"]])
    assert said["chi2_reduced"] == pytest.approx(fitted.chi2_reduced, rel=0.01)
    assert said["samples"] == len(fitted.residuals)
