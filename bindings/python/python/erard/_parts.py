"""Results in parts: files that appear complete or not at all, so that interrupted work can continue."""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ._errors import InputError

if TYPE_CHECKING:
    import pyarrow


def digest(about: dict[str, Any]) -> str:
    """Returns the identity of a piece of work: a hash of its description with sorted keys."""
    return hashlib.sha256(json.dumps(about, sort_keys=True).encode()).hexdigest()[:16]


class Folder:
    """Folder of parts of one piece of work, described by its `manifest.json`."""

    def __init__(self, path: str | os.PathLike[str], about: dict[str, Any], count: int) -> None:
        self.path, self.count = Path(path), count
        manifest = self.path / "manifest.json"
        if self.path.exists() and not self.path.is_dir():
            raise InputError(f"{self.path}: is a file; expected a folder, or a path where one can be made", file=str(self.path))
        described = {**about, "parts": count}
        if manifest.exists():
            found = json.loads(manifest.read_text(encoding="utf-8"))
            if digest(found) != digest(json.loads(json.dumps(described))):
                raise InputError(
                    f"{self.path}: holds parts of another piece of work; give another folder, or the same work to go on with it",
                    file=str(manifest),
                )
        else:
            if self.path.exists() and any(self.path.iterdir()):
                raise InputError(f"{self.path}: is not empty, and has no manifest.json", file=str(self.path))
            self.path.mkdir(parents=True, exist_ok=True)
            write_whole(manifest, lambda to: to.write_text(json.dumps(described, indent=1), encoding="utf-8"))

    def part(self, index: int) -> Path:
        """Returns the file of a part, from 0."""
        return self.path / f"part-{index:06d}.parquet"

    @property
    def missing(self) -> list[int]:
        """Indices of the parts that are missing."""
        return [index for index in range(self.count) if not self.part(index).exists()]


def write_whole(path: Path, write: Callable[[Path], Any]) -> None:
    """Writes a temporary file and renames it, so that the file appears complete or not at all."""
    beside = path.with_name(f".{path.name}.{os.getpid()}")
    try:
        write(beside)
        os.replace(beside, path)
    finally:
        beside.unlink(missing_ok=True)


def write_parquet(path: Path, table: pyarrow.Table) -> None:
    """Writes a table as one Parquet file, complete or not at all."""
    import pyarrow.parquet as pq

    write_whole(path, lambda to: pq.write_table(table, to, compression="zstd"))


def in_order(indices: Iterable[int], work: Callable[[int], Any]) -> Iterator[int]:
    """Does the work in this process, one part after the other."""
    for index in indices:
        work(index)
        yield index
