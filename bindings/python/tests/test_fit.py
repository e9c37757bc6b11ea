"""Fits find what made the data, and say what the data do not tell."""

import pickle
import warnings

import erard
import numpy as np
import pytest

NOISE = {"key_m": 1e-5, "hammer_rise_m": 5e-5}


@pytest.fixture(scope="module")
def rigid() -> erard.Instrument:
    """Six bodies: fits want many strokes. It has a name of its own, so that no fixture of the session is made of it."""
    return erard.load("concert-grand-rigid")


def recorded(true: erard.Instrument, seed: int = 0, stroke: str = "mf", late_s: float = 0.0) -> dict[str, np.ndarray]:
    run, rng = true.press(stroke=stroke, duration=0.12), np.random.default_rng(seed)
    found = {"time_s": run["time_s"][::5], "force_N": run["force_N"][::5]}
    for column, sigma in NOISE.items():
        found[column] = np.interp(found["time_s"] - late_s, run["time_s"], run[column])
        found[column] = found[column] + sigma * rng.standard_normal(len(found["time_s"]))
    return found


TRUE = {"body.hammer.mass": 1.05, "body.key.friction": 0.8, "zone.capstan_heel.stiffness": 1.3, "let_off": 2e-4}
BOUNDS = {"let_off": ("-1 mm", "+1 mm")}


def texts(changes: dict[str, float]) -> dict[str, str]:
    """Turns of screws and factors of other parameters, as `Instrument.vary` reads them."""
    return {name: f"{by:+}" if name == "let_off" else f"x{by}" for name, by in changes.items()}


@pytest.fixture(scope="module")
def found(rigid: erard.Instrument) -> erard.Fit:
    data = [recorded(rigid.vary(texts(TRUE)), seed, stroke) for seed, stroke in enumerate(["p", "f"])]
    return erard.fit(rigid, data, parameters=list(TRUE), bounds=BOUNDS, sigma=NOISE)


def test_the_truth_is_found_within_its_errors(found: erard.Fit) -> None:
    for name, true in TRUE.items():
        assert abs(found.x[name] - true) < 4 * found.std[name], (name, found.x[name], found.std[name])
    assert found.chi2_reduced == pytest.approx(1.0, abs=0.05) and not found.unseen
    assert list(found.noise.values()) == [1e-5, 5e-5, 1e-5, 5e-5]
    for title, sigma in found.noise.items():
        assert found.rms_at_start[title] > found.rms[title] == pytest.approx(sigma, rel=0.1)
    assert found.cov.shape == (4, 4) and np.allclose(np.diag(found.correlation), 1.0)
    assert found.instrument == found._problem.asked.instrument.vary(texts(found.x))
    assert found.values["body.hammer.mass"] == pytest.approx(found.instrument.parameters["body.hammer.mass"].value)
    text = str(found)
    assert all(name in text for name in TRUE) and "+-" in text and text.replace("&", "&amp;")[:20] in found._repr_html_()
    pytest.importorskip("matplotlib").use("Agg")
    assert len(found.plot().axes) == 8


def test_derivatives_of_the_model_find_the_same(rigid: erard.Instrument, found: erard.Fit) -> None:
    """In place of differences: the same place within a fifth of its errors, and the same errors."""
    data = [recorded(rigid.vary(texts(TRUE)), seed, stroke) for seed, stroke in enumerate(["p", "f"])]
    exact = erard.fit(rigid, data, parameters=list(TRUE), bounds=BOUNDS, sigma=NOISE, jacobian="gradient")
    assert exact.differentiated > 0 == found.differentiated and "with derivatives" in str(exact)
    for name in TRUE:
        assert abs(exact.x[name] - found.x[name]) < 0.2 * found.std[name], (name, exact.x[name], found.x[name], found.std[name])
        assert exact.std[name] == pytest.approx(found.std[name], rel=0.2), name


def test_both_jacobians_are_one(rigid: erard.Instrument) -> None:
    """Column by column, delays included, up to the impact; differences of the residuals themselves agree."""
    impact_s = rigid.vary(texts(TRUE)).press(stroke="mf").events["hammer_contact"]
    late = recorded(rigid.vary(texts(TRUE)), late_s=0.3e-3)
    late = {column: values[late["time_s"] < impact_s] for column, values in late.items()}
    fitted = erard.fit(rigid, late, parameters=list(TRUE), bounds=BOUNDS, sigma=NOISE, delays=True, restarts=0)
    problem, point = fitted._problem, fitted._point
    exact, differences = problem.jacobian(point, exact=True), problem.jacobian(point)
    assert exact.shape == (len(fitted.residuals), 6)
    assert np.array_equal(problem.residuals(point[None])[0], fitted.residuals)
    for k, (own, other) in enumerate(zip(exact.T, differences.T, strict=True)):
        size = np.linalg.norm(other)
        assert np.linalg.norm(own - other) < 0.05 * size
        both = problem.residuals(point + np.outer([1e-3, -1e-3], np.arange(6) == k))
        assert np.linalg.norm((both[0] - both[1]) / 2e-3 - other) < 0.05 * size


def test_scipy_finds_the_same(rigid: erard.Instrument) -> None:
    """Another solver of the same residuals, through the same stages: the same place within a tenth of its errors. What it raises is raised."""
    pytest.importorskip("scipy")
    data = recorded(rigid.vary({"body.hammer.mass": "x1.05"}))
    options = {"parameters": ["body.hammer.mass"], "sigma": NOISE, "restarts": 0}
    own, other = (erard.fit(rigid, data, minimizer=minimizer, **options) for minimizer in ("erard", "scipy"))
    assert other.message != own.message and other.message.startswith(("`", "Both", "The"))
    assert other.x["body.hammer.mass"] == pytest.approx(own.x["body.hammer.mass"], abs=0.1 * own.std["body.hammer.mass"])
    assert other.std["body.hammer.mass"] == pytest.approx(own.std["body.hammer.mass"], rel=0.01)
    with pytest.raises(erard.InputError, match="erard or scipy"):
        erard.fit(rigid, data, minimizer="minpack", **options)

    def breaks(*_: object) -> None:
        raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        own._problem._inner.fit(([], "linear", "differences", 0, 5), breaks, None)


def test_fits_pickle_and_compare(found: erard.Fit) -> None:
    again = pickle.loads(pickle.dumps(found))
    assert again == found and str(again) == str(found) and again.channels == found.channels
    assert again.instrument == found.instrument and (again != found) is False


def test_what_is_not_seen_is_said(rigid: erard.Instrument) -> None:
    """A soft stroke that never reaches the check tells nothing of its felt."""
    data = recorded(rigid, stroke="pp")
    cut = {name: values[:150] for name, values in data.items()}
    blind = erard.fit(rigid, cut, parameters=["body.hammer.mass", "zone.check.stiffness"], sigma=NOISE, bounds={"body.hammer.mass": ("x0.5", "x2")})
    assert blind.std["zone.check.stiffness"] > 100
    assert any("zone.check.stiffness" in told for told in blind.unseen) and "Not seen" in str(blind)
    assert blind.singular_values[-1] < 1 < blind.singular_values[0]


def test_noise_is_told_by_the_recording(rigid: erard.Instrument) -> None:
    fitted = erard.fit(rigid, recorded(rigid), parameters=["body.hammer.mass"])
    assert list(fitted.noise.values()) == pytest.approx([1e-5, 5e-5], rel=0.3)


def test_noise_of_what_drives_makes_errors_larger(rigid: erard.Instrument) -> None:
    data = recorded(rigid)
    fits = [erard.fit(rigid, data, parameters=["body.hammer.mass"], sigma={**NOISE, "force_N": force}) for force in (0.0, 0.05)]
    assert fits[1].std["body.hammer.mass"] > 3 * fits[0].std["body.hammer.mass"]
    assert fits[0].chi2_expected == 1.0 < fits[1].chi2_expected
    assert "the noise of force_N, which drives the model," not in " ".join(str(fits[0]).split())
    # At 1 kHz neither rest nor spectrum tells it.
    coarse = {name: values[::4] for name, values in data.items()}
    assert erard.Recording(coarse, zero=False, low_pass=None).noise("force_N") is None
    with pytest.warns(erard.DoubtfulFitWarning, match="the noise of force_N, which drives the model, is unknown"):
        unknown = erard.fit(rigid, coarse, parameters=["body.hammer.mass"], sigma=NOISE)
    assert "noise_unknown" in [doubt.kind for doubt in unknown.doubts]
    told = " ".join(str(unknown).split())
    assert told.startswith("Doubtful: ") and "the noise of force_N, which drives the model, is unknown" in told


def test_delays_are_estimated(rigid: erard.Instrument) -> None:
    late = recorded(rigid.vary({"body.hammer.mass": "x1.05"}), late_s=0.4e-3)
    fitted = erard.fit(rigid, late, parameters=["body.hammer.mass"], delays=True)
    assert list(fitted.delays.values()) == pytest.approx([0.4e-3, 0.4e-3], abs=0.05e-3)
    assert abs(fitted.x["body.hammer.mass"] - 1.05) < 5 * fitted.std["body.hammer.mass"]


def test_a_motion_drives_and_the_force_is_fitted(rigid: erard.Instrument) -> None:
    # Up to the punching: there micrometres of the key's position are newtons.
    run = rigid.vary({"body.key.friction": "x0.7"}).press(stroke="p", duration=0.3)
    rows = slice(0, int(np.count_nonzero(np.maximum.accumulate(run["key_m"]) < 8e-3)), 5)
    data = {column: run[column][rows] for column in ("time_s", "key_m", "force_N")}
    fitted = erard.fit(rigid, data, parameters=["body.key.friction"], drive="rigid", columns=["force_N"], sigma={"force_N": 0.02})
    assert fitted.x["body.key.friction"] == pytest.approx(0.7, abs=0.1)


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        ({"parameters": []}, "one name or more"),
        ({"parameters": "let_off"}, "list of names"),
        ({"parameters": ["leton"]}, "nearest `let_off`"),
        ({"parameters": ["body.hammer.mass_g"]}, "number of the file"),
        ({"parameters": ["let_off"], "bounds": {"let_off": (1e-3, -1e-3)}}, "increasing"),
        ({"parameters": ["let_off"], "bounds": {"drop": (0, 1e-3)}}, "not varied"),
        ({"parameters": ["let_off"], "columns": ["string_N"]}, "to compare"),
        ({"parameters": ["let_off"], "sigma": {"string_N": 1.0}}, "neither compared"),
        ({"parameters": ["let_off"], "bounds": {"let_off": "1 mm"}}, "two values"),
        ({"parameters": ["let_off"], "start": {"drop": 0.0}}, "not varied"),
        ({"parameters": ["let_off"], "start": {"let_off": 1.0}}, "its bounds"),
        ({"parameters": ["let_off"], "loss": "square"}, "soft_l1"),
        ({"parameters": ["let_off"], "jacobian": "exact"}, "differences or gradient"),
        ({"parameters": ["let_off"], "max_evaluations": 0}, "a whole number"),
    ],
)
def test_wrong_arguments(rigid: erard.Instrument, run: erard.Run, arguments: dict, told: str) -> None:
    with pytest.raises(erard.InputError, match=told):
        erard.fit(rigid, run, **arguments)
    with pytest.raises(erard.InputError, match="time"):
        erard.fit(rigid, {"force_N": [1.0, 2.0]}, parameters=["let_off"])


def test_the_posterior_agrees(rigid: erard.Instrument) -> None:
    pytest.importorskip("emcee")
    fitted = erard.fit(rigid, recorded(rigid), parameters=["body.hammer.mass"], sigma={**NOISE, "force_N": 0.0}, bounds={"body.hammer.mass": ("x0.5", "x2")})
    drawn = erard.sample(fitted, walkers=8, length=40, burn=20, seed=3)
    assert drawn.mean["body.hammer.mass"] == pytest.approx(fitted.x["body.hammer.mass"], abs=3 * fitted.std["body.hammer.mass"])
    assert drawn.std["body.hammer.mass"] == pytest.approx(fitted.std["body.hammer.mass"], rel=0.5)
    low, high = drawn.interval()["body.hammer.mass"]
    assert low < drawn.mean["body.hammer.mass"] < high
    assert np.array_equal(drawn.samples, erard.sample(fitted, walkers=8, length=40, burn=20, seed=3).samples)


@pytest.mark.nightly
def test_two_samplers_agree(rigid: erard.Instrument) -> None:
    """Walkers without derivatives, and Hamiltonian steps with them."""
    pytest.importorskip("emcee")
    pytest.importorskip("nutpie")
    early = {name: values[:200] for name, values in recorded(rigid).items()}
    fitted = erard.fit(rigid, early, parameters=["body.hammer.mass"], sigma={**NOISE, "force_N": 0.0}, bounds={"body.hammer.mass": ("x0.5", "x2")})
    walked = erard.sample(fitted, walkers=8, length=60, burn=30)
    drawn = erard.sample(fitted, sampler="nuts", walkers=1, length=80, burn=60)
    assert drawn.samples.shape == (80, 1)
    name = "body.hammer.mass"
    assert drawn.mean[name] == pytest.approx(walked.mean[name], abs=fitted.std[name])
    assert drawn.std[name] == pytest.approx(walked.std[name], rel=0.5)
    with pytest.raises(erard.InputError, match="emcee or nuts"):
        erard.sample(fitted, sampler="gibbs")


@pytest.mark.nightly
def test_the_posterior_heeds_the_noise_of_what_drives(rigid: erard.Instrument) -> None:
    """With it the hammer's mass is known many times worse; the covariance of the fit and the samples say the same."""
    pytest.importorskip("emcee")
    options = {"parameters": ["body.hammer.mass"], "bounds": {"body.hammer.mass": ("x0.5", "x2")}}
    fitted = erard.fit(rigid, recorded(rigid), sigma={**NOISE, "force_N": 0.05}, **options)
    alone = erard.fit(rigid, recorded(rigid), sigma={**NOISE, "force_N": 0.0}, **options)
    drawn = erard.sample(fitted, walkers=8, length=60, burn=30, seed=3)
    assert fitted.std["body.hammer.mass"] > 4 * alone.std["body.hammer.mass"]
    assert drawn.std["body.hammer.mass"] == pytest.approx(fitted.std["body.hammer.mass"], rel=0.5)


def test_recordings_pickle(rigid: erard.Instrument) -> None:
    recording = erard.Recording(recorded(rigid))
    assert pickle.loads(pickle.dumps(recording)) == recording


#: The sets whose coverage is counted, as those of Rust's test: each has one parameter more than the one before.
COVERED = ["body.hammer.mass", "zone.capstan_heel.stiffness", "body.key.friction", "let_off"]


def short(true: erard.Instrument, seed: int) -> dict[str, np.ndarray]:
    """Until 3 ms after the impact: a fit beyond it has doubts, and claims no coverage."""
    end_s = true.press(stroke="mf", duration=0.12).events["hammer_contact"] + 3e-3
    data = recorded(true, seed)
    return {column: values[data["time_s"] <= end_s] for column, values in data.items()}


def covered(rigid: erard.Instrument, each: int, sigma: dict[str, float] | None) -> dict[tuple[int, str], list[float]]:
    """How many errors the fitted numbers are from the true ones, by set and parameter, of grands drawn up to 20 % away."""
    off: dict[tuple[int, str], list[float]] = {}
    for count in range(1, len(COVERED) + 1):
        for n in range(each):
            rng = np.random.default_rng([count, n, sigma is None])
            true = {name: 2e-4 * rng.uniform(-1, 1) if name == "let_off" else 1 + 0.2 * rng.uniform(-1, 1) for name in COVERED[:count]}
            data = short(rigid.vary(texts(true)), seed=10_000 * count + n)
            with warnings.catch_warnings():
                warnings.simplefilter("ignore", erard.DoubtfulFitWarning)
                found = erard.fit(rigid, data, parameters=list(true), bounds=BOUNDS if "let_off" in true else None, sigma=sigma, restarts=0, progress=False)
            for name, value in true.items():
                off.setdefault((count, name), []).append((found.x[name] - value) / found.std[name])
    return off


def check_coverage(all_off: list[float], alpha_z: float = 2.576) -> None:
    """Within one and two errors as often as a normal number, by a binomial test."""
    for errors, share in ((1.0, 0.6827), (2.0, 0.9545)):
        within, fits = sum(abs(off) <= errors for off in all_off), len(all_off)
        assert abs(within - share * fits) < alpha_z * (fits * share * (1 - share)) ** 0.5, (errors, within, fits)


KNOWN = {**NOISE, "force_N": 0.0}


def test_the_truth_lies_within_the_errors_as_often_as_it_should(rigid: erard.Instrument) -> None:
    """With known noise, few of each set; over all together, at 1 %."""
    check_coverage([one for off in covered(rigid, 3, KNOWN).values() for one in off])


@pytest.mark.nightly
@pytest.mark.parametrize("sigma", [KNOWN, None], ids=["told", "from the recording"])
def test_the_truth_lies_within_the_errors_for_every_parameter(rigid: erard.Instrument, sigma: dict[str, float] | None) -> None:
    """Of 200 recordings of each set, by parameter: three times the scatter of the count is allowed, for there are twenty counts."""
    for (count, name), off in covered(rigid, 200, sigma).items():
        print(count, name, [sum(abs(one) <= errors for one in off) / len(off) for errors in (1.0, 2.0)])
        check_coverage(off, 3.0)
