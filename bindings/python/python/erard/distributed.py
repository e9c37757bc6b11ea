"""Studies, rollouts, fits and data sets on a Dask cluster, for work that is too large for one machine.

The work is divided into chunks of fixed size, large enough to fill the lanes of a processor many times. Each chunk
becomes one Parquet file, which appears complete or not at all. If a worker dies, another one repeats its chunk;
interrupted work continues where it stopped. Results have the same bits for any number of workers.

Without a client, a `LocalCluster` with one process for each core does the work. `client` takes any
`distributed.Client`, e.g. of SLURM, Kubernetes or SSH. Workers need this package and access to a shared folder.

>>> import erard, numpy as np, tempfile
>>> from erard import distributed
>>> grand = erard.load("concert-grand")
>>> with tempfile.TemporaryDirectory() as folder:
...     done = distributed.study(grand, folder + "/s", {"let_off": np.linspace(-5e-4, 5e-4, 8)}, force=5.0, chunk=4, workers=1, processes=False)
...     done.read().num_rows, done.parts
(8, 2)
"""

from __future__ import annotations

import os
import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ._common import bar, floats
from ._errors import DoubtfulFitWarning, Extra, InputError
from ._instrument import Instrument
from ._many import rollout as _rollout
from ._parts import Folder, write_parquet

if TYPE_CHECKING:
    import pyarrow
    from numpy.typing import ArrayLike

    from .dataset import Plan

#: Strokes in a chunk unless told otherwise: a second or two of one core, and a megabyte of results.
CHUNK = 4096
#: Chunks that are with the cluster at a time, for each worker: the next is there when one is done, and no more waits in
#: memory.
AHEAD = 2
#: Dask's configuration for workers that compute: its profiler, its ticks and its monitors wake every 10 to 500 ms,
#: which takes 2.4 % of each worker's core whether it works or not; so they take 0.4 %.
QUIET: dict[str, Any] = {
    "distributed.worker.profile.enabled": False,
    "distributed.admin.tick.interval": "500ms",
    "distributed.worker.memory.monitor-interval": "1s",
    "distributed.admin.system-monitor.interval": "5s",
}
#: How often a chunk is tried when workers die under it.
TRIES = 3


class Parts:
    """Folder of results.

    Attributes
    ----------
    path : Path
    parts : int
        Number of Parquet files.
    computed : int
        Number of files that this call computed; the others already existed.
    """

    def __init__(self, path: Path, parts: int, computed: int) -> None:
        self.path, self.parts, self.computed = path, parts, computed

    def read(self, columns: Sequence[str] | None = None) -> pyarrow.Table:
        """Returns all rows, in order.

        Parameters
        ----------
        columns : sequence of str, optional
        """
        import pyarrow as pa
        import pyarrow.parquet as pq

        files = sorted(self.path.glob("part-*.parquet"))
        return pa.concat_tables([pq.read_table(file, columns=None if columns is None else list(columns)) for file in files])

    def to_zarr(self, path: str | os.PathLike[str]) -> None:
        """Writes the numeric columns as a Zarr group, one array for each column, with units as attributes.

        Parameters
        ----------
        path : str or path
        """
        import zarr

        table = self.read()
        group = zarr.open_group(os.fspath(path), mode="w")
        for name in table.column_names:
            column = table[name].combine_chunks()
            if column.type == "string":
                continue  # Zarr has no text that all its readers know: why strokes failed stands in the Parquet files.
            if hasattr(column.type, "value_type"):
                values = np.array(column.to_pylist())
            else:
                values = column.to_numpy(zero_copy_only=False)
            array = group.create_array(name, data=np.ascontiguousarray(values))
            metadata = table.schema.field(name).metadata or {}
            array.attrs["units"] = metadata.get(b"unit", b"1").decode()

    def __repr__(self) -> str:
        return f"<erard.distributed.Parts {self.path}: {self.parts} files, {self.computed} computed now>"


@contextmanager
def _client(client: Any, workers: int | None, processes: bool) -> Iterator[Any]:
    if client is not None:
        yield client
        return
    with Extra("distributed"):
        import dask
        from distributed import Client, LocalCluster

    count = workers or os.cpu_count() or 1
    with dask.config.set(QUIET), LocalCluster(  # type: ignore[no-untyped-call,unused-ignore]
        n_workers=count, threads_per_worker=1, processes=processes, dashboard_address=":0", silence_logs=40
    ) as cluster, Client(cluster) as own:  # type: ignore[no-untyped-call,unused-ignore]
        yield own


def _each(
    missing: list[int],
    job: Callable[..., int],
    arguments: Callable[[int], tuple[Any, ...]],
    shared: tuple[Any, ...],
    client: Any,
    progress: bool | None,
    what: str,
) -> None:
    """Runs the jobs on a cluster, a few ahead for each worker; yields the index of each job when its file exists."""
    with Extra("distributed"):
        from distributed import as_completed

    if not missing:
        return
    common = client.scatter(shared, broadcast=True, hash=False)
    waiting = iter(missing)

    def submit(index: int) -> Any:
        return client.submit(job, index, common, *arguments(index), pure=False, retries=TRIES)

    width = max(1, AHEAD * len(client.scheduler_info()["workers"]))
    with bar(progress, what) as tell:
        first = [submit(index) for _, index in zip(range(width), waiting, strict=False)]
        running: Any = as_completed(first, with_results=True)  # type: ignore[no-untyped-call,unused-ignore]
        for done, _ in enumerate(running):
            if tell is not None:
                tell((done + 1) / len(missing))
            following = next(waiting, None)
            if following is not None:
                running.add(submit(following))


def _study_chunk(index: int, shared: tuple[Any, ...], rows: tuple[int, int]) -> int:
    """Plays one chunk of a study: some of its combinations."""
    from ._common import steps
    from ._instrument import stroke_of
    from ._many import outcomes, played, work

    instrument, folder, axes, forces, options = shared
    made = None if forces is not None else stroke_of(
        instrument, stroke=options["stroke"], touch=options["touch"], hand=options.get("hand")
    )
    own = steps({"step": options["step"], "theta": options["theta"], "hand": options.get("hand")})
    keep = work(options["threads"], options["single"], True)
    found = played(instrument, axes, made, forces, rows, [], options["duration"], own, keep, None)
    columns = dict(zip([*axes, "force_N"], found["varied"], strict=False))
    _write(folder, index, columns | outcomes(found))
    return index


def _write(folder: str, index: int, columns: dict[str, Any]) -> None:
    import pyarrow as pa

    from ._common import unit_of

    errors = columns.pop("error")
    fields, arrays = [], []
    for name, values in columns.items():
        metadata = {"unit": unit_of(name)}
        if values.ndim == 2:
            flat = pa.array(np.ascontiguousarray(values).ravel())
            array = pa.FixedSizeListArray.from_arrays(flat, values.shape[1])
        else:
            array = pa.array(np.ascontiguousarray(values))
        fields.append(pa.field(name, array.type, metadata=metadata))
        arrays.append(array)
    fields.append(pa.field("error", pa.string()))
    arrays.append(pa.array([error or None for error in errors], pa.string()))
    path = Path(folder) / f"part-{index:06d}.parquet"
    write_parquet(path, pa.Table.from_arrays(arrays, schema=pa.schema(fields)))


def study(
    instrument: Instrument,
    folder: str | os.PathLike[str],
    vary: Mapping[str, ArrayLike],
    *,
    force: float | Sequence[float] | None = None,
    stroke: str | None = None,
    touch: str = "pressed",
    duration: float | None = None,
    chunk: int = CHUNK,
    threads: int = 1,
    single: bool = False,
    client: Any = None,
    workers: int | None = None,
    processes: bool = True,
    progress: bool | None = None,
    step: float | None = None,
    theta: float = 0.5,
) -> Parts:
    """Runs `erard.study` in chunks on a cluster and writes Parquet files.

    Parameters
    ----------
    instrument : Instrument
    folder : str or path
        Folder of the parts; if it holds parts of the same work, the work continues.
    vary : mapping of str to array_like
        Screws and parameters with their values, as `erard.study` takes them; all combinations are played, and the last
        name varies fastest.
    force, stroke, touch, duration, single, step, theta
        As in `erard.study`.
    chunk : int
        Number of strokes in a part.
    threads : int
        Number of threads for each chunk.
    client : distributed.Client, optional
        Cluster; by default a `LocalCluster`.
    workers : int, optional
        Number of workers of the `LocalCluster`; by default the number of cores.
    processes : bool
        Whether these workers are processes, or threads of this process.
    progress : bool, optional
        Whether to show a progress bar.

    Returns
    -------
    Parts
    """
    axes = {str(name): floats(str(name), np.atleast_1d(values), 1) for name, values in vary.items()}
    known = instrument.parameters
    if unknown := [name for name in axes if name not in known]:
        instrument.vary({unknown[0]: 1.0})  # It says what there is.
        raise InputError(f"{unknown[0]} is a number of the file; expected screws and parameters", key=unknown[0])
    several = None if force is None else floats("force", np.atleast_1d(force), 1)
    if several is not None and stroke is not None:
        raise InputError("force and stroke are given; expected one of them", key="stroke")
    shape = [len(values) for values in axes.values()] + ([] if several is None else [len(several)])
    count = int(np.prod(shape))
    if chunk < 1 or count < 1:
        raise InputError(f"found {count} strokes in chunks of {chunk}; expected one of each or more", key="chunk")
    options = {
        "stroke": stroke, "touch": touch, "duration": duration, "threads": threads, "single": single, "step": step, "theta": theta,
    }  # fmt: skip
    about = {
        "what": "study",
        "instrument": instrument.text,
        "changes": [list(change) for change in instrument.changes],
        "axes": {name: values.tolist() for name, values in axes.items()},
        "force_N": None if several is None else several.tolist(),
        "chunk": chunk,
        **{key: value for key, value in options.items() if key != "threads"},
    }
    parts = Folder(folder, about, -(-count // chunk))
    missing = parts.missing

    def arguments(index: int) -> tuple[Any, ...]:
        return ((index * chunk, min(count, (index + 1) * chunk)),)

    with _client(client, workers, processes) as own:
        _each(missing, _study_chunk, arguments, (instrument, str(parts.path), axes, several, options), own, progress, "study")
    return Parts(parts.path, parts.count, len(missing))


def _rollout_chunk(index: int, shared: tuple[Any, ...], rows: np.ndarray) -> int:
    """Plays one chunk of a rollout."""
    instrument, folder, kind, options = shared
    arguments: dict[str, Any] = {kind: rows, **options}
    found = _rollout(instrument, **arguments, progress=False)
    _write(folder, index, dict(found))
    return index


def rollout(
    instrument: Instrument,
    folder: str | os.PathLike[str],
    *,
    force: ArrayLike | None = None,
    motion: ArrayLike | None = None,
    rigid: ArrayLike | None = None,
    dt: float,
    columns: Sequence[str] = ("key_m", "hammer_rise_m"),
    chunk: int = CHUNK,
    threads: int = 1,
    client: Any = None,
    workers: int | None = None,
    processes: bool = True,
    progress: bool | None = None,
    **how: Any,
) -> Parts:
    """Runs `erard.rollout` in chunks on a cluster and writes Parquet files; samples become lists of T values.

    Parameters
    ----------
    instrument : Instrument
    folder : str or path
        Folder of the parts; if it holds parts of the same work, the work continues.
    force, motion, rigid : array_like of shape (N, T)
        As in `erard.rollout`; a memory-mapped array is read chunk by chunk.
    dt, columns, threads, **how
        As in `erard.rollout`.
    chunk, client, workers, processes, progress
        As in `study`.

    Returns
    -------
    Parts
    """
    given = {name: values for name, values in (("force", force), ("motion", motion), ("rigid", rigid)) if values is not None}
    if len(given) != 1:
        raise InputError(f"found {' and '.join(given) or 'none'}; expected one of force, motion and rigid", key="force")
    [(kind, asked)] = given.items()
    array = np.asanyarray(asked)
    if array.ndim != 2:
        raise InputError(f"{kind}: found an array of shape {array.shape}, expected one of 2 dimensions", key=kind)
    options = {"dt": dt, "columns": list(columns), "threads": threads, **how}
    import hashlib

    about = {
        "what": "rollout",
        "instrument": instrument.text,
        "changes": [list(change) for change in instrument.changes],
        "kind": kind,
        "shape": list(array.shape),
        "values": hashlib.sha256(np.ascontiguousarray(array, dtype=np.float64).tobytes()).hexdigest(),
        "chunk": chunk,
        **{key: value for key, value in options.items() if key != "threads"},
    }
    parts = Folder(folder, about, -(-len(array) // chunk))
    missing = parts.missing

    def arguments(index: int) -> tuple[Any, ...]:
        return (np.ascontiguousarray(array[index * chunk : (index + 1) * chunk], dtype=np.float64),)

    with _client(client, workers, processes) as own:
        _each(missing, _rollout_chunk, arguments, (instrument, str(parts.path), kind, options), own, progress, "rollout")
    return Parts(parts.path, parts.count, len(missing))


def _fit_one(instrument: Instrument, recordings: Any, options: dict[str, Any]) -> dict[str, Any]:
    from ._fit import fit as one

    with warnings.catch_warnings():
        # They are part of the answer.
        warnings.simplefilter("ignore", DoubtfulFitWarning)
        found = one(instrument, recordings, **options)
    return {
        "x": found.x, "std": found.std, "chi2_reduced": found.chi2_reduced, "noise": found.noise, "unseen": found.unseen,
        "doubts": found.doubts, "report": str(found),
    }  # fmt: skip


def fit(
    instrument: Instrument,
    recordings: Sequence[Any],
    *,
    parameters: Sequence[str],
    client: Any = None,
    workers: int | None = None,
    processes: bool = True,
    **options: Any,
) -> list[dict[str, Any]]:
    """Runs `erard.fit` on a cluster for many independent recordings (or lists of them), one fit for each.

    Parameters
    ----------
    instrument : Instrument
    recordings : sequence
        Recordings, or lists of recordings that are fitted together.
    parameters, **options
        As in `erard.fit`.
    client, workers, processes
        As in `study`.

    Returns
    -------
    list of dict
        Results in the order of the recordings: `x`, `std`, `chi2_reduced`, `noise`, `unseen`, `doubts`, `report`.
    """
    asked = {"parameters": list(parameters), "threads": 1, **options}
    with _client(client, workers, processes) as own:
        shared = own.scatter(instrument, broadcast=True, hash=False)
        return list(own.gather([own.submit(_fit_one, shared, one, asked, pure=False, retries=TRIES) for one in recordings]))


def _dataset_chunk(index: int, shared: tuple[Any, ...]) -> int:
    """Computes one chunk of a data set."""
    from .dataset import chunk

    plan, folder = shared
    write_parquet(Path(folder) / f"part-{index:06d}.parquet", chunk(plan, index, threads=1))
    return index


def dataset(
    plan: Plan,
    folder: str | os.PathLike[str],
    *,
    client: Any = None,
    workers: int | None = None,
    processes: bool = True,
    progress: bool | None = None,
) -> Parts:
    """Runs `erard.dataset.write` on a cluster: the files are the same, to the bit.

    Parameters
    ----------
    plan : erard.dataset.Plan
    folder : str or path
        Folder of the parts and the data card.
    client, workers, processes, progress
        As in `study`.

    Returns
    -------
    Parts
    """
    from .dataset import opened

    parts = opened(plan, folder)
    missing = parts.missing
    with _client(client, workers, processes) as own:
        _each(missing, _dataset_chunk, lambda _: (), (plan, str(parts.path)), own, progress, "data set")
    return Parts(parts.path, parts.count, len(missing))
