"""A million strokes on two processes: what a core does under Dask, beside the command's own study.

    python benchmarks/million.py [--strokes 1000000] [--workers 2] [--native 20000] [--erard PATH] [--folder FOLDER]

A constant force of 3 to 12 N for 0.12 s on variants of let-off and hammer mass, in chunks of 4096 strokes, each a Parquet file. The processes are
started first, and timed on their own. Efficiency is strokes for each second of the processor: that of the workers beside that of `erard study`,
which plays a part of the same grid in one process, in the same lanes; other work on the machine then counts for little. Interrupted with a
`--folder`, the same call goes on where it was.
"""

from __future__ import annotations

import argparse
import os
import resource
import subprocess
import tempfile
import time
from pathlib import Path
from typing import Any

import erard
import numpy as np
from erard import distributed

DURATION_S = 0.12
FORCES = 40
#: How long the workers are watched before they work, s.
IDLE_S = 5.0


def grid(strokes: int) -> tuple[dict[str, np.ndarray], np.ndarray]:
    """What is varied, and the forces: so many combinations, or a few more."""
    forces = min(FORCES, strokes)
    side = int(np.ceil(np.sqrt(strokes / forces)))
    axes = {"let_off": np.linspace(-5e-4, 5e-4, side), "body.hammer.mass": np.linspace(0.9, 1.1, side)}
    return axes, np.linspace(3.0, 12.0, forces)


def spent() -> float:
    """Seconds of the processor that this process and its threads have had."""
    return time.process_time()


def native(command: str, strokes: int) -> tuple[int, float, float]:
    """The command's study: strokes, wall s, processor s."""
    axes, forces = grid(strokes)
    side = len(axes["let_off"])
    with tempfile.TemporaryDirectory() as folder:
        arguments = [command, "study", "--vary", f"let_off=-0.5mm..0.5mm:{side}", "--vary", f"body.hammer.mass=x0.9..1.1:{side}"]
        arguments += ["--vary", f"force=3..12:{len(forces)}", "--duration", str(DURATION_S), "--rows", "1", "--out", folder, "--force"]
        before, start = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
        subprocess.run(arguments, check=True, capture_output=True)
        wall, after = time.perf_counter() - start, resource.getrusage(resource.RUSAGE_CHILDREN)
    return side * side * len(forces), wall, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def clustered(strokes: int, workers: int, folder: str) -> tuple[int, float, float, Any]:
    """The same over a LocalCluster: strokes, wall s, processor s of the workers, the parts."""
    import dask
    from distributed import Client, LocalCluster

    axes, forces = grid(strokes)
    start = time.perf_counter()
    quiet = dask.config.set(distributed.QUIET)
    with quiet, LocalCluster(n_workers=workers, threads_per_worker=1, dashboard_address=":0", silence_logs=40) as cluster, Client(cluster) as client:
        client.run(erard.load, "concert-grand")
        print(f"cluster: {workers} processes, started in {time.perf_counter() - start:.1f} s", flush=True)
        # What Dask takes of a core whether it works or not counts by the clock: on a machine that does other work, too,
        # it counts for more.
        before, start = sum(client.run(spent).values()), time.perf_counter()
        time.sleep(IDLE_S)
        upkeep = (sum(client.run(spent).values()) - before) / (time.perf_counter() - start)
        print(f"upkeep: {100 * upkeep / workers:.1f} % of a core for each worker that waits", flush=True)
        before, start = sum(client.run(spent).values()), time.perf_counter()
        parts = distributed.study(erard.load("concert-grand"), folder, axes, force=list(forces), duration=DURATION_S, client=client)
        wall, busy = time.perf_counter() - start, sum(client.run(spent).values()) - before
    return parts.read(["force_N"]).num_rows, wall, busy, parts


def main() -> None:
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("--strokes", type=int, default=1_000_000, help="how many at least")
    options.add_argument("--workers", type=int, default=2)
    options.add_argument("--native", type=int, default=20_000, help="strokes of the command's study")
    options.add_argument("--erard", default=os.environ.get("ERARD"), help="the command to compare with")
    options.add_argument("--folder", help="where the parts go; by default they are thrown away")
    asked = options.parse_args()
    with tempfile.TemporaryDirectory() as thrown:
        count, wall, busy, parts = clustered(asked.strokes, asked.workers, asked.folder or str(Path(thrown) / "study"))
        size = sum(file.stat().st_size for file in parts.path.glob("part-*")) / 1e6
    if parts.computed < parts.parts:
        print(f"{parts.parts - parts.computed} of {parts.parts} parts were there already: nothing is compared")
        return
    print(f"{count} strokes in {wall:.1f} s: {count / wall:.0f} a second; {parts.parts} files, {size:.1f} MB")
    print(f"workers: {busy:.1f} s of the processor, {count / busy:.0f} strokes for each")
    if not asked.erard:
        print("native: not compared; --erard names the command")
        return
    played, alone, own = native(asked.erard, min(asked.native, asked.strokes))
    print(f"native study: {played} strokes in {alone:.1f} s, {own:.1f} s of the processor, {played / own:.0f} strokes for each")
    print(f"efficiency of a core under Dask: {100 * (count / busy) / (played / own):.0f} %")


if __name__ == "__main__":
    main()
