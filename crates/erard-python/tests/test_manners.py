"""Manners: interrupts, threads, imports, types."""

import os
import signal
import subprocess
import sys
import textwrap
import threading
import time
from pathlib import Path

import erard
import pytest

LONG = {
    "press": "grand.press(force=5.0, duration=600.0, progress=False)",
    "rollout": "erard.rollout(grand, force=np.full((4000, 1001), 5.0), dt=1e-3, progress=False)",
    "study": "erard.study(grand, let_off=np.linspace(-1e-4, 1e-4, 4000), force=5.0, progress=False)",
    "measure": "grand.measure(progress=False)",
    "regulate": "grand.regulate(norms=True, progress=False)",
}


@pytest.mark.skipif(os.name == "nt", reason="signals are POSIX's")
@pytest.mark.parametrize("what", LONG)
def test_control_c_ends_it(what: str) -> None:
    code = f"""
        import signal, time, numpy as np, erard
        signal.signal(signal.SIGINT, signal.default_int_handler)
        grand = erard.load("concert-grand")
        print("ready", flush=True)
        try:
            {LONG[what]}
        except KeyboardInterrupt:
            print(time.time(), flush=True)
    """
    child = subprocess.Popen([sys.executable, "-c", textwrap.dedent(code)], stdout=subprocess.PIPE, text=True)
    assert child.stdout
    assert child.stdout.readline() == "ready\n"
    time.sleep(0.6)
    sent = time.time()
    child.send_signal(signal.SIGINT)
    answer = child.stdout.readline()
    child.wait(30)
    assert answer, f"{what} ended before it was interrupted, or did not heed it"
    # 0.2 s on an idle machine; where others compile, the second process waits for its turn.
    limit = float(os.environ.get("ERARD_INTERRUPT_S", "0.2"))
    assert float(answer) - sent < limit


def test_other_threads_go_on(grand: erard.Instrument) -> None:
    """Python's lock is free while a press runs."""
    done = threading.Event()
    thread = threading.Thread(target=lambda: (grand.press(force=5.0, duration=20.0, progress=False), done.set()))
    thread.start()
    turns = 0
    while not done.wait(0.001):
        turns += 1
    thread.join()
    assert turns > 20


def test_progress_is_told_and_may_raise(grand: erard.Instrument, capsys: pytest.CaptureFixture[str]) -> None:
    grand.press(force=5.0, duration=5.0, progress=True)
    assert "press" in capsys.readouterr().err
    grand.press(force=5.0, duration=0.1)
    assert capsys.readouterr().err == ""


def test_import_is_quick_and_brings_nothing_along() -> None:
    code = "import sys, erard; print(*sorted({'scipy', 'pandas', 'matplotlib', 'dask', 'pyarrow', 'tqdm'} & set(sys.modules)))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == ""


def test_types_are_those_of_the_stubs() -> None:
    """mypy is content with the package, and stubtest finds in the extension what its stubs say."""
    pytest.importorskip("mypy")
    root = Path(__file__).parent.parent
    if not (root / "pyproject.toml").exists():
        pytest.skip("not in the source tree")
    done = subprocess.run([sys.executable, "-m", "mypy"], cwd=root, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    done = subprocess.run([sys.executable, "-m", "mypy.stubtest", "erard._erard"], cwd=root, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
