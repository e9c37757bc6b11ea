"""Manners: interrupts, threads, imports, types."""

import os
import pickle
import signal
import subprocess
import sys
import textwrap
import threading
import time
from collections.abc import Callable
from pathlib import Path

import erard
import numpy as np
import pytest

#: What takes longer than an interrupt may. The forces never hold still, for an action at rest is simulated in no time;
#: the regulation starts far off.
LONG = {
    "press": "grand.press(force=forces, dt=1e-3, progress=False)",
    "play": "erard.Action(grand).play(many)",
    "rollout": "erard.rollout(grand, force=np.full((4000, 1001), 5.0), dt=1e-3, progress=False)",
    "study": "erard.study(grand, let_off=np.linspace(-1e-4, 1e-4, 4000), force=5.0, progress=False)",
    "gradient": "erard.gradient(grand, force=5.0, progress=False)",
    "measured study": "erard.study(grand, let_off=np.linspace(-1e-4, 1e-4, 12), force=5.0, duration=0.02, measure=['repetition_rate_hz', 'double_strike_m_per_s'], progress=False)",
    "measure": "grand.measure(progress=False)",
    "regulate": "far_off.regulate(dip='11 mm', blow='43 mm', let_off='3 mm', drop='2.5 mm', check='20 mm', norms=True, follow=True, progress=False)",
    "draw": "grand.draw(240.0, force=forces, dt=1e-3)",
    "keyboard": "erard.keyboard(keys=range(1, 89), progress=False)",
    "kinematics": "grand.kinematics(steps=1_000_000)",
    "validate": "grand.validate(progress=False)",
}


@pytest.mark.skipif(os.name == "nt", reason="signals are POSIX's")
@pytest.mark.parametrize("what", LONG)
def test_control_c_ends_it(what: str) -> None:
    """The handler is called from within the extension: after a return Python would call it, too, however long that took. Its own handler is
    what the child starts with, for whoever runs the tests may have had interrupts ignored."""
    code = f"""
        import signal, sys, time, numpy as np, erard
        inside = []
        def profile(frame, event, function):
            if event == "c_call":
                inside.append(function.__module__ or type(function.__self__).__module__)
            elif inside and event in ("c_return", "c_exception"):
                inside.pop()
        def heard(number, frame):
            interrupted = inside[-1] if inside else None
            print(interrupted, flush=True)
            raise KeyboardInterrupt
        forces = 5.0 + 2.0 * np.random.default_rng(0).standard_normal(240_000)
        many = np.tile(forces, 20)
        signal.signal(signal.SIGINT, heard)
        grand = erard.load("concert-grand")
        far_off = grand.vary(let_off="+1.5 mm", drop="+1 mm", capstan_height="-0.5 mm", back_check="+1 mm")
        print("ready", flush=True)
        try:
            sys.setprofile(profile)
            {LONG[what]}
        except KeyboardInterrupt:
            sys.setprofile(None)
            print(time.time(), flush=True)
    """
    # What is interrupted has begun by then: before its measures a study plays its strokes, 0.4 s beside other work. On
    # a busy machine it may take longer.
    begins_s = {"kinematics": 0.1, "measured study": 1.0}.get(what, 0.3)
    for wait_s in (begins_s, 3 * begins_s):
        child = subprocess.Popen([sys.executable, "-c", textwrap.dedent(code)], stdout=subprocess.PIPE, text=True)
        assert child.stdout
        assert child.stdout.readline() == "ready\n"
        time.sleep(wait_s)
        sent = time.time()
        child.send_signal(signal.SIGINT)
        interrupted, ended = child.stdout.readline().strip(), child.stdout.readline().strip()
        child.wait(30)
        if interrupted.startswith("erard._erard"):
            break
    assert ended, f"{what} ended before it was interrupted, or ignored it"
    assert interrupted.startswith("erard._erard"), f"{what} was interrupted in {interrupted}"
    # 0.2 s on an idle machine; where others compile, the second process waits for its turn.
    limit = float(os.environ.get("ERARD_INTERRUPT_S", "0.2"))
    assert float(ended) - sent < limit


def test_everything_pickles_compares_and_says_what_it_is(grand: erard.Instrument, run: erard.Run) -> None:
    action = erard.Action(grand)
    action.play([5.0] * 100)
    things = [
        grand, grand.parameters["let_off"], run, erard.Recording(run), action, action.reading, action.play([5.0] * 3), grand.draw(),
        grand.measure(only=["dip_mm"]), grand.kinematics(), grand.compare(run, drives=["force"], models=["action"]), erard.keyboard(keys=[40]),
        erard.rollout(grand, force=[[5.0, 5.0]], dt=1e-3), erard.study(grand, let_off=[0.0], force=5.0, duration=0.05),
        erard.gradient(grand, ["let_off"], force=5.0, duration=0.05, compare=False),
    ]  # fmt: skip
    for thing in things:
        again = pickle.loads(pickle.dumps(thing))
        assert again == thing and not again != thing, thing
        assert " object at 0x" not in repr(thing), thing
    action.step(5.0)
    assert pickle.loads(pickle.dumps(things[4])) != erard.Action(grand)
    for wrong in (erard.Action, erard.gradient, lambda x: erard.study(x, let_off=[0.0]), lambda x: erard.fit(x, run, parameters=["let_off"])):
        with pytest.raises(erard.InputError, match="erard.load"):
            wrong("concert-grand")


@pytest.mark.parametrize("what", ["press", "play"])
def test_other_threads_go_on(grand: erard.Instrument, what: str) -> None:
    """Python's lock is free while a press runs, and while an action plays."""
    done = threading.Event()
    action = erard.Action(grand)
    # Forces that never hold still: an action at rest is simulated in no time.
    forces = np.tile([1.0, 2.0], 200_000)
    work = {"press": lambda: grand.press(force=5.0, duration=20.0, progress=False), "play": lambda: action.play(forces)}
    thread = threading.Thread(target=lambda: (work[what](), done.set()))
    thread.start()
    turns = 0
    while not done.wait(0.001):
        turns += 1
    thread.join()
    assert turns > 20


def test_what_numpy_masks_is_not_played(grand: erard.Instrument) -> None:
    """A mask says that a number is none; nothing else may stand in its place unasked."""
    masked = np.ma.masked_array([1.0, 1e6, 2.0], mask=[False, True, False])
    plays = (
        lambda: grand.press(force=masked, dt=0.01, progress=False),
        lambda: erard.rollout(grand, force=masked[None, :], dt=0.01, progress=False),
        lambda: erard.study(grand, let_off=masked, force=5.0, progress=False),
        lambda: erard.Action(grand).play(masked),
    )
    for play in plays:
        with pytest.raises(erard.InputError, match="1 masked value"):
            play()
    # A mask that hides nothing is none.
    grand.press(force=np.ma.masked_array([1.0, 2.0], mask=False), dt=0.01, progress=False)


def test_forces_that_only_pull_are_refused(grand: erard.Instrument) -> None:
    """As the command refuses them: in a constant force, in samples, in rollouts."""
    plays = (
        lambda: grand.press(force=-5.0, duration=0.02, progress=False),
        lambda: grand.press(force=[-5.0, -1.0], dt=0.01, progress=False),
        lambda: erard.rollout(grand, force=[[-5.0, -5.0]], dt=0.01, progress=False),
    )
    for play in plays:
        with pytest.raises(erard.InputError, match="cannot pull it up"):
            play()


def test_progress_is_told_and_may_raise(grand: erard.Instrument, capsys: pytest.CaptureFixture[str]) -> None:
    grand.press(force=5.0, duration=5.0, progress=True)
    assert "press" in capsys.readouterr().err
    grand.press(force=5.0, duration=0.1)
    assert capsys.readouterr().err == ""


#: Parts of the package that are imported on first use.
LATER = {f"erard.{part}" for part in ("_fit", "_parts", "_plot", "_posterior", "dataset", "distributed", "environments", "judge")}
#: What their first use imports of them.
FIRST_USE = {
    "__name__": set(),
    "fit": {"erard._fit"},
    "sample": {"erard._fit", "erard._posterior"},
    "dataset": {"erard._parts", "erard.dataset"},
    "distributed": {"erard._parts", "erard.distributed"},
    "judge": {"erard.judge"},
}


@pytest.mark.parametrize("name", FIRST_USE)
def test_import_brings_nothing_along(name: str) -> None:
    """Only NumPy: no figures, tables, clusters or solvers of others before a function that needs them is called."""
    code = f"import sys; before = set(sys.modules); import erard; erard.{name}; print(*(set(sys.modules) - before))"
    modules = set(subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout.split())
    assert modules & LATER == FIRST_USE[name]
    assert {module.partition(".")[0] for module in modules} - sys.stdlib_module_names == {"erard", "numpy"}


def test_types_are_those_of_the_stubs(tmp_path: Path) -> None:
    """mypy is content with the package, and stubtest finds in the extension what its stubs say.

    stubtest writes over mypy's cache but does not read it, so it has its own; and the stubs need nothing of what the
    package beside them imports.
    """
    pytest.importorskip("mypy")
    root = Path(__file__).parent.parent
    if not (root / "pyproject.toml").exists():
        pytest.skip("not in the source tree")
    done = subprocess.run([sys.executable, "-m", "mypy"], cwd=root, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    config = tmp_path / "mypy.ini"
    config.write_text(f"[mypy]\ncache_dir = {tmp_path / 'cache'}\n[mypy-erard]\nfollow_imports = skip\n", encoding="utf-8")
    stubtest = [sys.executable, "-m", "mypy.stubtest", "erard._erard", "--mypy-config-file", str(config)]
    done = subprocess.run(stubtest, cwd=root, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr


def test_types_refuse_a_text_as_a_force(tmp_path: Path) -> None:
    pytest.importorskip("mypy")
    file = tmp_path / "typed.py"
    file.write_text("import erard\nimport numpy as np\n\ngrand = erard.load('concert-grand')\ngrand.press(force='5 N')\ngrand.press(force=np.ones(3), dt=1e-3)\n")
    checked = subprocess.run([sys.executable, "-m", "mypy", "--cache-dir", str(tmp_path), str(file)], capture_output=True, text=True, check=False)
    assert checked.returncode == 1 and checked.stdout.count("[arg-type]") == 1 and "typed.py:5" in checked.stdout, checked.stdout


def test_a_truth_value_is_no_number() -> None:
    """`force=True` is a mistake, not 1 N; the same of counts, arrays and of numpy's own bool."""
    grand = erard.load("concert-grand")
    for call in (
        lambda: grand.press(force=True),
        lambda: grand.press(force=np.bool_(True)),
        lambda: grand.press(force=[True, False], dt=1e-3),
        lambda: grand.press(force=5.0, record_every=True),
        lambda: erard.Action(grand).step(force=True),
        lambda: grand.vary(let_off=True),
    ):
        with pytest.raises(erard.InputError, match="True|truth|bool"):
            call()


def test_what_is_no_flag_no_name_and_no_key_is_refused_in_words() -> None:
    """One reader for each kind of argument: key, what was found, what is expected."""
    grand = erard.load("concert-grand")
    calls: dict[str, Callable[[], object]] = {
        "single": lambda: erard.study(grand, let_off=[0.0], single="no"),  # type: ignore[arg-type]
        "ledger": lambda: erard.rollout(grand, force=[[5.0, 5.0]], dt=1e-3, ledger=None),  # type: ignore[arg-type]
        "reactions": lambda: grand.press(force=5.0, reactions=1),  # type: ignore[arg-type]
        "norms": lambda: grand.regulate(norms="no"),  # type: ignore[arg-type]
        "compare": lambda: erard.gradient(grand, ["let_off"], force=5.0, compare="no"),  # type: ignore[arg-type]
        "model": lambda: grand.press(force=5.0, model=None),  # type: ignore[arg-type]
        "touch": lambda: grand.press(stroke="mf", touch=True),  # type: ignore[arg-type]
        "solver": lambda: grand.press(force=5.0, solver=1),  # type: ignore[arg-type]
        "rest": lambda: grand.measure(rest=None),  # type: ignore[arg-type]
        "key": lambda: grand.measure(key=True),
        "asked": lambda: erard.load(None),  # type: ignore[arg-type]
        "saved": lambda: erard.Action(grand).restore("state"),  # type: ignore[arg-type]
        "column": lambda: erard.unit_of(3),  # type: ignore[arg-type]
    }
    for key, call in calls.items():
        with pytest.raises(erard.InputError) as refused:
            call()
        error = refused.value
        assert error.key == key and error.found and error.expected and f"{key}: found {error.found}, expected {error.expected}" == str(error), key


def test_numpy_and_pandas_read_a_run() -> None:
    pd = pytest.importorskip("pandas")
    run = erard.load("concert-grand").press(force=5.0, duration=0.05)
    array = np.asarray(run)
    assert array.shape == (len(run["time_s"]), len(run.columns)) and array.dtype == np.float64
    assert np.array_equal(array[:, run.columns.index("key_m")], run["key_m"])
    frame = pd.DataFrame(run, columns=run.columns)
    assert frame.shape == array.shape and np.array_equal(frame["key_m"], run["key_m"])
    assert list(run.to_pandas().columns) == run.columns and pd.DataFrame(run).shape == array.shape
    # A study has a column of texts: objects side by side, as pandas does it.
    grand = erard.load("concert-grand")
    study = erard.study(grand, let_off=[0.0, 1e-4], duration=0.05)
    array = np.asarray(study)
    assert array.dtype == object and array.shape == (2, len(study.columns)) == pd.DataFrame(study).shape
    assert list(array[:, study.columns.index("let_off")]) == [0.0, 1e-4] and list(array[:, study.columns.index("error")]) == ["", ""]
    with pytest.raises(TypeError, match="'error'.*texts"):
        np.asarray(study, dtype=float)
    with pytest.raises(TypeError, match="'key_m'.*many samples"):
        np.asarray(erard.rollout(grand, force=[[5.0, 5.0]], dt=1e-3))


def test_one_stroke_whatever_holds_its_numbers(tmp_path: Path) -> None:
    """A mapping, a data frame and a file with the same noisy numbers give the same stroke, to the bit, and the run tells how
    they were prepared. A computed force that begins at 5 N has no zero in it, in any of them."""
    pd = pytest.importorskip("pandas")
    grand = erard.load("concert-grand")
    t = np.arange(0, 0.3, 2.5e-4)
    noisy = np.where(t < 0.1, 0.0, 6.0) + 0.12 + 0.02 * np.random.default_rng(1).standard_normal(len(t))
    computed = np.where(t < 0.1, 5.0, 8.0)
    for force, told in ((noisy, "zero: 0.1"), (computed, "computed, not measured")):
        mapping = {"time_s": t, "force_N": force}
        file = tmp_path / "force.csv"
        file.write_text("time_s,force_N\n" + "".join(f"{a!r},{b!r}\n" for a, b in zip(t.tolist(), force.tolist(), strict=True)))
        runs = [grand.press(stroke=source, duration=0.3) for source in (mapping, pd.DataFrame(mapping), str(file))]
        studies = [erard.study(grand, let_off=[0.0], stroke=source, duration=0.3) for source in (mapping, str(file))]
        slopes = erard.gradient(grand, ["let_off"], stroke=mapping, duration=0.05, compare=False, unconverged="nan")
        assert slopes.notes == runs[0].notes
        for run in runs + studies:
            assert any(told in note for note in run.notes), run.notes
            assert run.preparation == runs[0].preparation and pickle.loads(pickle.dumps(run)).preparation == run.preparation
        for run in runs:
            assert np.array_equal(run["key_m"], runs[0]["key_m"])
        [channel] = runs[0].preparation
        assert channel["channel"] == "force" and channel["resampled_Hz"] is None
        assert (channel["zero"] is None) == (force is computed) == (channel["low_pass_Hz"] is None)
    assert runs[0].hammer_speed > 2.0  # 5 N, then 8 N: not 0, then 3 N.


def test_failed_rows_are_warned_of() -> None:
    grand = erard.load("concert-grand")
    with pytest.warns(erard.FailedStrokesWarning, match=r"2 of 3 strokes failed.*let_off: found -1, 1 m, expected .* m"):
        study = erard.study(grand, let_off=[-1, 0, 1], duration=0.05)
    assert list(study.errors) == [0, 2]


def test_a_snapshot_of_other_settings_is_refused() -> None:
    grand = erard.load("concert-grand")
    saved = erard.Action(grand, step=100e-6).save()
    action = erard.Action(grand)
    before = action.save()
    with pytest.raises(erard.InputError):
        action.restore(saved)
    assert action.save() == before
