"""The command `erard fit` and `erard.fit` are one fit."""

import json
import os
import shutil
import subprocess
from pathlib import Path

import erard
import numpy as np
import pytest

RECORDINGS = Path(__file__).parents[3] / "recordings"
VARY = ["body.hammer.mass", "body.key_back.friction", "zone.capstan_heel.stiffness", "let_off"]
SIGMA = {"force_N": 0.02, "key_m": 1e-5, "hammer_rise_m": 5e-5}


def command() -> str:
    """The command as `ERARD` names it, or as it is found."""
    found = os.environ.get("ERARD") or shutil.which("erard")
    if found is None:
        pytest.skip("no command `erard` is here; ERARD names it")
    return found


def test_the_command_finds_the_same(tmp_path: Path) -> None:
    """The same code on the same recordings, prepared in the same way: every number to the bit."""
    paths = [RECORDINGS / f"heavier-{nuance}.csv" for nuance in ("mf", "f")]
    bounds = {"body.hammer.mass": ("x0.5", "x2"), "let_off": ("-1 mm", "+1 mm")}
    ends = {"body.hammer.mass": (0.5, 2.0), "let_off": (-1e-3, 1e-3)}
    fitted = erard.fit(erard.load("concert-grand"), [erard.Recording(path) for path in paths], parameters=VARY, bounds=bounds, sigma=SIGMA, restarts=1)
    ran = subprocess.run(
        [
            command(), "fit", "concert-grand", *map(str, paths), "--parameters", ",".join(VARY),
            "--bounds", "body.hammer.mass=x0.5..2", "--bounds", "let_off=-1..1", "--sigma", "force=0.02,position=1e-5,hammer=5e-5",
            "--restarts", "1", "--no-pictures", "--json", "--out", str(tmp_path / "fit"),
        ],
        check=not fitted.doubts, capture_output=True, text=True,
    )  # fmt: skip
    said = json.loads(ran.stdout)
    assert [row["name"] for row in said["parameters"]] == VARY
    for row in said["parameters"]:
        name = row["name"]
        assert (row["varied"]["value"], row["varied"]["std"]) == (fitted.x[name], fitted.std[name]), name
        assert (row["value"], row["std"]) == (fitted.values[name], fitted.errors[name]), name
        assert (row["varied"]["low"], row["varied"]["high"]) == ends.get(name, (row["varied"]["low"], row["varied"]["high"]))
    assert said["covariance"] == fitted.cov.tolist() and said["singular_values"] == fitted.singular_values.tolist()
    assert (said["chi2_reduced"], said["chi2_expected"]) == (fitted.chi2_reduced, fitted.chi2_expected)
    assert (said["strokes"], said["samples"]) == (fitted.evaluations, len(fitted.residuals))
    assert [(doubt["kind"], doubt["text"]) for doubt in said["doubts"]] == fitted.doubts and ran.returncode == bool(fitted.doubts)


def test_the_command_stores_the_same_preparation(tmp_path: Path) -> None:
    """What was done to a recording with noise and a clock that is not even: in a run here, and in the command's results."""
    noise = np.random.default_rng(4)
    t = (np.arange(1200) + 0.3 * noise.random(1200)) / 4000.0
    force = np.interp(t, [0.1, 0.12], [0.0, 6.0]) + 0.12 + 0.02 * noise.standard_normal(1200)
    file = tmp_path / "noisy.csv"
    file.write_text("time_s,force_N\n" + "".join(f"{a!r},{b!r}\n" for a, b in zip(t.tolist(), force.tolist(), strict=True)), encoding="utf-8")
    own = erard.load("concert-grand").press(stroke=str(file), duration=0.2).preparation
    said = subprocess.run([command(), "press", str(file), "--duration", "0.2", "--json", "--out", str(tmp_path / "run")], check=True, capture_output=True, text=True)
    [stored] = [source["preparation"] for source in json.loads(said.stdout)["made_by"]["sources"] if source["kind"] == "recording"]
    assert own == stored and own[0]["resampled_Hz"] and own[0]["low_pass_Hz"]
