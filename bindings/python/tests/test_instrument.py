"""Loading, varying, and the technician's work."""

import pickle
import re
from pathlib import Path

import erard
import numpy as np
import pytest


def test_values_as_people_write_them(grand: erard.Instrument) -> None:
    def value(instrument: erard.Instrument, name: str) -> float:
        return instrument.parameters[name].value

    mass = value(grand, "body.hammer.mass")
    for change, expected in [("8.7 g", 8.7e-3), ("+0.8 g", mass + 0.8e-3), ("*1.5", 1.5 * mass), (1.5 * mass, 1.5 * mass), ("x1.5", 1.5 * mass), ("0.3 oz", 0.3 * 28.349523125e-3)]:
        assert value(grand.vary({"body.hammer.mass": change}), "body.hammer.mass") == pytest.approx(expected, rel=1e-12)
    before = value(grand, "let_off")
    assert value(grand.vary(let_off="-0.2 mm"), "let_off") == pytest.approx(before - 2e-4, abs=1e-15)
    assert value(grand.vary(let_off=-2e-4), "let_off") == pytest.approx(-2e-4, abs=1e-15)
    assert value(grand.vary(let_off="= -0.2 mm"), "let_off") == pytest.approx(-2e-4, abs=1e-15)
    by_path = grand.vary({"body.hammer.mass_g": "+0.3 g"})
    assert value(by_path, "body.hammer.mass") == pytest.approx(mass + 0.3e-3, rel=1e-12)
    assert grand.vary({}) == grand == grand.vary(let_off=before)


def test_parameters_tell_their_spread(grand: erard.Instrument) -> None:
    parameters = grand.parameters
    assert parameters["let_off"].unit == "m" and parameters["let_off"].is_screw
    spread = [p for p in parameters.values() if p.spread]
    assert spread and all(p.spread[0] < p.value < p.spread[1] for p in spread)  # type: ignore[index]
    assert {p.certainty for p in parameters.values()} <= {"measured", "read", "second-hand", "estimate", None}


@pytest.mark.parametrize(
    ("change", "told"),
    [
        ({"let_off": "1 g"}, "not one of its units; expected m, dm, cm, mm"),
        ({"let_off": "1"}, "out of range"),
        ({"body.key.friction": "x2"}, "type `body.key_back.friction`"),
        ({"let_of": "1 mm"}, "nearest `let_off`"),
        ({"body.hammer.mass": -1.0}, "out of range"),
        ({"body.hammer.mass": float("nan")}, "finite"),
        ({"body.hammer.mass": None}, "a number"),
        ({"body.hammer.mass_g": -3.0}, "mass_g"),
    ],
)
def test_wrong_changes(grand: erard.Instrument, change: dict[str, object], told: str) -> None:
    with pytest.raises(erard.InputError, match=told) as raised:
        grand.vary(change)  # type: ignore[arg-type]
    assert raised.value.key is not None


def test_files(tmp_path: Path, grand: erard.Instrument) -> None:
    path = tmp_path / "mine.toml"
    path.write_text(grand.text)
    assert erard.load(path) == grand
    path.write_text(grand.text.replace("gravity_m_s2", "gravity_m_s3", 1))
    with pytest.raises(erard.InputError) as raised:
        erard.load(path)
    error = raised.value
    assert error.file and error.file.endswith("mine.toml") and error.line and str(error.line) in str(error)
    with pytest.raises(FileNotFoundError):
        erard.load(tmp_path / "none.toml")
    with pytest.raises(erard.InputError, match="steinway-o"):
        erard.load("steinway")
    with pytest.raises(erard.InputError, match="1 to 88"):
        erard.load("concert-grand:key=89")
    assert erard.load("concert-grand:key=1") != erard.load("concert-grand:key=88")


def test_an_instrument_knows_its_key(grand: erard.Instrument) -> None:
    lowest = erard.load("concert-grand:key=A0")
    assert lowest == erard.load("concert-grand:key=1") and (lowest.key, grand.key, lowest.sample) == (1, None, None)
    changed = pickle.loads(pickle.dumps(lowest.vary({"gravity_m_s2": 9.8})))
    for one in (lowest, changed, erard.Instrument(lowest.text), lowest.regulate(let_off="2.2 mm")):
        assert one.key == 1
    assert lowest.measure()["norms_for_key"] == 1 and lowest.measure(key="a0")["norms_for_key"] == 1
    # Strike weights of the bass, in the sheet's own table.
    assert {usual for label, _, usual in lowest.measure(only=["strike_weight_g"]).lines()} == {"10.3-12.4"}
    assert {usual for label, _, usual in grand.measure(key="C8", only=["strike_weight_g"]).lines()} == {"4.6-5.8"}
    with pytest.raises(erard.InputError, match=r"that of key 1 \(A0\)"):
        lowest.measure(key=40)
    with pytest.raises(erard.InputError, match="A0 to C8"):
        grand.measure(key="H4")


def test_measure_and_regulate(grand: erard.Instrument) -> None:
    sheet = grand.measure(only=["let_off_mm", "down_weight_g"])
    assert set(sheet) == {"let_off_mm", "down_weight_g"} and "let-off" in repr(sheet) and "<table>" in sheet._repr_html_()
    with pytest.raises(erard.InputError, match="down_weight_g"):
        grand.measure(only=["up"])
    wider = grand.regulate(let_off="2.2 mm")
    assert wider.regulation and wider.regulation["all_met"] and grand.regulation is None
    assert wider.measure(only=["let_off_mm"])["let_off_mm"] == pytest.approx(2.2, abs=0.05)
    # The new file's own text says it, and a number in SI units is the same goal.
    assert erard.Instrument(wider.text) == wider == grand.regulate(let_off=2.2e-3)
    with pytest.raises(erard.InputError, match="a length from"):
        grand.regulate(dip="10 mm/s")
    for name in ("repetition_spring", "spring"):
        with pytest.raises(erard.InputError, match="a speed from"):
            grand.regulate(**{name: "10 mm"})
    with pytest.raises(erard.InputError, match="is no goal; expected .*repetition_spring.*damper_start"):
        grand.regulate(leton="1 mm")


def test_geometry_keyboard_and_comparison(grand: erard.Instrument, run: erard.Run) -> None:
    own = grand.kinematics()
    assert own["leverage"][0] == pytest.approx(own.summary["leverage_at_rest"], rel=1e-6)
    # A long way is gone in pieces, and is the same way.
    fine, coarse = grand.kinematics(end=0.008, steps=50_000), grand.kinematics(end=0.008, steps=50)
    assert len(fine["key_m"]) == 50_001 and fine["leverage"][::1000] == pytest.approx(coarse["leverage"], rel=1e-12)
    with pytest.raises(erard.InputError, match="c7f-like"):
        erard.kinematics("c8")
    keys = erard.keyboard(keys=[40])
    assert list(keys["note"]) == ["C4"] and keys.to_arrow().num_rows == 1
    assert list(keys["error"]) == [""]
    with pytest.raises(erard.InputError, match="1 to 88"):
        erard.keyboard(keys=[0])
    compared = grand.compare(run, drives=["force"], models=["action"])
    assert compared.errors[0]["explained"] > 0.9999 and compared.verdicts
    with pytest.raises(erard.InputError, match="force, motion or rigid"):
        grand.compare(run, drives=["magic"])


def test_a_key_that_cannot_be_weighed_has_its_reason(tmp_path: Path) -> None:
    (tmp_path / "grand.toml").write_text(erard.load("concert-grand").text)
    leads = 'name = "leads"\nbody = "key"\nat_mm = [-100, 0]\nmass_g = [{ key = 40, value = 0 }, { key = 88, value = 300 }]'
    head = 'format = "erard-keyboard/1"\nname = "Mine"\ninstrument = "grand.toml"\ninstrument_key = 40'
    (tmp_path / "mine.toml").write_text(f"{head}\n\n[[added_mass]]\n{leads}\n")
    keys = erard.keyboard(tmp_path / "mine.toml", keys=[40, 88])
    assert keys["error"][0] == "" and "slowly pressed key" in keys["error"][1]
    assert np.isnan(keys["down_weight_g"][1]) and not keys["trusted"][1] and keys["down_weight_g"][0] > 0


@pytest.mark.slow
def test_validate(grand: erard.Instrument) -> None:
    rows = grand.validate()
    assert {row["verdict"] for row in rows} <= {"met", "missed", "did not happen", "not modelled", "nothing published"}
    assert sum(row["verdict"] == "met" for row in rows) > len(rows) // 2


def test_a_diagnosis() -> None:
    """Causes that are named, and those that are open; readings that cannot be are refused, all of them at once."""
    found = erard.diagnose(key="C4", down_weight_g=58, up_weight_g="18 g", let_off_mm=None)
    # Where it rubs is open.
    causes = [cause["probability"] for cause in found["undecided"]]
    assert found["key"] == 40 and found["is_work"] and causes == sorted(causes, reverse=True) and not found.is_key_assumed
    assert len(found["causes"]) <= 2 and found["undecided"][0]["name"] in repr(found) and "<table>" in found._repr_html_()
    assert erard.diagnose(down_weight_g=50, up_weight_g=24).is_key_assumed
    # Balance weight and friction weight instead of down-weight and up-weight.
    same = erard.diagnose(key="C4", bw=38, friction_weight_g="20 g", let_off_mm=None)
    assert same["readings"] == found["readings"] and same["undecided"] == found["undecided"]
    # Conditions of the weighing, in words or as truth values; a damper in the weights is refused.
    assert erard.diagnose(down_weight_g=50, up_weight_g=25, measured_at_mm=0)["readings"][0]["value"] == 52.6
    alone = erard.diagnose(down_weight_g=9, up_weight_g=3, stack_on=False)
    assert [line["name"] for line in alone["readings"]] == ["key_alone_friction_g"]
    with pytest.raises(erard.InputError, match="with the pedal down"):
        erard.diagnose(down_weight_g=60, dampers_lifted="no")
    with pytest.raises(erard.InputError, match="expected 38 g, which follows from these"):
        erard.diagnose(down_weight_g=58, up_weight_g=18, balance_weight_g=30)
    with pytest.raises(erard.InputError) as error:
        erard.diagnose(down_weight_g=18, up_weight_g=58)
    assert error.value.key
    for wrong in ({}, {"dawn_weight_g": 58.0}, {"down_weight_g": float("nan")}, {"key": 89, "down_weight_g": 58.0}):
        with pytest.raises(erard.InputError):
            erard.diagnose(**wrong)


TYPED = Path(__file__).parents[3] / "crates" / "erard-core" / "tests" / "typed.tsv"


@pytest.mark.parametrize("row", [row for row in TYPED.read_text(encoding="utf-8").splitlines()[1:]])
def test_texts_are_read_as_by_the_other_fronts(grand: erard.Instrument, row: str) -> None:
    """The table holds what the command, and what C and Python make of a text."""
    name, text, _, expected = row.split("\t")
    kind, told = expected.split(" ", 1)
    if kind == "no":
        with pytest.raises(erard.InputError, match=re.escape(told)):
            grand.vary({name: text})
        return
    own = {"set_off": "let_off", "body.wippen.mass": "body.whippen.mass"}.get(name, name)
    now, by = grand.parameters[own].value, float(told)
    wanted = by if kind == "set" else now + by if kind == "add" else now * by
    assert grand.vary({name: text}).parameters[own].value == pytest.approx(wanted, rel=1e-9, abs=1e-12)


REGISTERED = TYPED.with_name("typed-register.tsv")


def test_the_register_is_read_as_by_the_other_fronts() -> None:
    """The table is generated from the register: every name, unit and spelling; Python takes the column `other`."""
    tried, files, by_path = 0, {}, {}
    for row in REGISTERED.read_text(encoding="utf-8").splitlines()[1:]:
        instrument, name, text, _, expected, path, _ = row.split("\t")
        if instrument not in files:
            files[instrument] = erard.load(instrument)
            by_path |= {(instrument, one.path): one for one in files[instrument].parameters.values()}
        file = files[instrument]
        kind, told = expected.split(" ", 1)
        tried += 1
        if kind == "no":
            with pytest.raises(erard.InputError, match=re.escape(told)):
                file.vary({name: text})
            continue
        changed = file.vary({name: text})
        own = by_path.get((instrument, path))
        if own is None:
            # A number of the file, by its path.
            continue
        now, by = own.value, float(told)
        wanted = by if kind == "set" else now + by if kind == "add" else now * by
        assert changed.parameters[own.name].value == pytest.approx(wanted, rel=1e-8, abs=1e-15), row
    assert tried > 400
