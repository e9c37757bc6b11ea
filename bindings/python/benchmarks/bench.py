"""How quick the front is: import, a press, a rollout beside the command's own study, the size of the extension.

    python benchmarks/bench.py [--quick] [--erard PATH]

Times are the best of several. `--erard` names the command (target/release/erard) whose `study` the rollout is held against: the same strokes,
in lanes, on all cores; both are timed for N and for 2 N strokes, and the difference counts, so that neither pays for its start. Processor
seconds are printed beside those of the clock: on a busy machine only they can be compared.
"""

from __future__ import annotations

import argparse
import os
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import erard
import numpy as np


def best(times: int, work: Callable[[], object]) -> float:
    """The shortest of so many times, s."""
    found = []
    for _ in range(times):
        start = time.perf_counter()
        work()
        found.append(time.perf_counter() - start)
    return min(found)


def processor() -> float:
    """Seconds of the processor that this process and those that it started and awaited have had."""
    own = (resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
    return sum(one.ru_utime + one.ru_stime for one in own)


def spent(times: int, work: Callable[[], object]) -> tuple[float, float]:
    """The least that so many times took: s of the clock, s of the processor."""
    found = []
    for _ in range(times):
        start, before = time.perf_counter(), processor()
        work()
        found.append((time.perf_counter() - start, processor() - before))
    return min(row[0] for row in found), min(row[1] for row in found)


def imports(times: int) -> tuple[float, float]:
    """Import of numpy, and of erard beyond it, ms: each in a process of its own."""
    code = "import time; a = time.perf_counter(); import numpy; b = time.perf_counter(); import erard; c = time.perf_counter(); print(b - a, c - b)"
    rows = [
        [1e3 * float(x) for x in subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout.split()]
        for _ in range(times)
    ]
    return min(row[0] for row in rows), min(row[1] for row in rows)


def main() -> None:
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("--quick", action="store_true", help="fewer strokes, fewer repetitions")
    options.add_argument("--erard", default=os.environ.get("ERARD"), help="the command to compare with")
    asked = options.parse_args()
    times, strokes = (2, 400) if asked.quick else (5, 4000)

    own, beyond = imports(3 * times)
    print(f"import: numpy {own:.0f} ms, erard {beyond:.0f} ms more")
    extension = next(Path(erard.__file__).parent.glob("_erard*"))
    print(f"extension: {extension.stat().st_size / 1e6:.1f} MB")
    grand = erard.load("concert-grand")
    print(f"press of 0.3 s: {1e3 * best(times, lambda: grand.press(force=5.0, duration=0.3, progress=False)):.1f} ms")
    action = erard.Action(grand)
    print(f"one step from Python: {1e6 * best(times, lambda: [action.step(force=4.5) for _ in range(2000)]) / 2000:.2f} us")

    def played(count: int) -> Callable[[], object]:
        force = np.repeat(np.linspace(3.0, 12.0, count)[:, None], 151, axis=1)
        return lambda: erard.rollout(grand, force=force, dt=1e-3, columns=(), progress=False)

    def sampled(count: int) -> Callable[[], object]:
        force = np.repeat(np.linspace(3.0, 12.0, count)[:, None], 151, axis=1)
        return lambda: erard.rollout(grand, force=force, dt=1e-3, progress=False)

    def per_stroke(of: Callable[[int], Callable[[], object]]) -> np.ndarray:
        """s of the clock and of the processor."""
        return (np.array(spent(times, of(2 * strokes))) - np.array(spent(times, of(strokes)))) / strokes

    def told(per: np.ndarray) -> str:
        return f"{1 / per[0]:.0f} strokes of 0.15 s per second, {1 / per[1]:.0f} per second of the processor"

    front, with_samples = per_stroke(played), per_stroke(sampled)
    print(f"rollout: {told(front)}")
    print(f"rollout, two columns of 151 samples each: {told(with_samples)}")
    if not asked.erard:
        print("native: not compared; --erard names the command")
        return
    with tempfile.TemporaryDirectory() as folder:

        def native(count: int) -> Callable[[], object]:
            arguments = [asked.erard, "study", "--vary", f"force=3..12:{count}", "--duration", "0.15", "--rows", "1", "--out", folder, "--force"]
            return lambda: subprocess.run(arguments, capture_output=True, check=True)

        beside = per_stroke(native)
    print(f"native study: {told(beside)}")
    share, by_processor = 100 * beside / front
    print(f"the rollout has {share:.0f} % of its throughput by the clock, {by_processor:.0f} % by the processor")


if __name__ == "__main__":
    main()
