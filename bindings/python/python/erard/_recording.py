"""Recordings of strokes, from a file, a table or a run."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, Union

import numpy as np

from . import _erard
from ._common import choice, floats, mapping, names_of, number, real, refused, text_of
from ._errors import InputError, MissingFileError
from ._table import Table

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    from ._types import Ready

    RecordingLike = Union["Recording", Table, Mapping[str, ArrayLike], str, "os.PathLike[str]", Any]


#: Columns that a recording can have.
_CHANNELS = ("force_N", "key_m", "hammer_rise_m", "hammer_rise_m_per_s")


class Recording(Table):
    """Recording of a stroke, with columns and units recognised, prepared to drive a key or to be compared.

    Parameters
    ----------
    source : run, mapping, data frame, path or Recording
        Columns by title: one for the time and any of force, position (of the key front or of the fingertip, down
        positive) and the hammer's rise or speed. Titles contain the unit: `time_s`, `force_N`, `key_m`,
        `hammer_rise_m`, `hammer_rise_m_per_s`, `Force (gf)`, `Travel [mm]`. The source is a mapping of arrays or
        supports the Arrow PyCapsule protocol. A path is a CSV file or, if it ends in .parquet, a Parquet file. Cells
        that are nan or empty were not sampled; `notes` reports the length of bridged gaps.
    columns : str or mapping of str to str, optional
        Columns to read if the titles are not recognised: "time=Time (s),position=Displacement (mm),force=F [gf]", or a
        mapping of roles to titles.
    position : {"key", "fingertip", "key-back"}, optional
        Part whose position was recorded; by default as the title says, else the key. "key-back" is for a sensor behind
        the balance pin, calibrated at the front; only `compare` drives that point.
    zero : bool or mapping of {"force_N", "key_m", "hammer_rise_m", "hammer_rise_m_per_s"} to float
        Whether to subtract from each channel its mean in the rest before the touch. A mapping gives the reading of a
        channel at its zero, N, m or m/s, in the file's own sign; the zeros of other channels are taken from the rest.
    low_pass : float, "own" or None
        Cut-off of a low-pass filter, Hz, applied forward and backward; "own" sets it from each channel's own noise;
        `None` filters nothing.
    invert : sequence of {"force_N", "key_m", "hammer_rise_m", "hammer_rise_m_per_s"}
        Channels whose sign is inverted.
    delay : mapping of {"force_N", "key_m", "hammer_rise_m", "hammer_rise_m_per_s"} to float, optional
        Delay of a channel behind the others, s.

    Raises
    ------
    InputError
        If the source is wrong; the error holds file, line (or row), column, what was found and what is expected.

    Examples
    --------
    >>> import numpy as np, erard
    >>> t = np.linspace(0, 0.2, 201)
    >>> mine = erard.Recording({"Time (ms)": 1e3 * t, "Force (gf)": 400 + 0 * t}, zero=False)
    >>> mine
    <erard.Recording table: 201 rows, time_s, force_N>
    >>> round(float(mine["force_N"][0]), 3)
    3.923
    """

    def __init__(
        self,
        source: RecordingLike,
        *,
        columns: str | Mapping[str, str] | None = None,
        position: str | None = None,
        zero: bool | Mapping[str, float] = True,
        low_pass: float | str | None = "own",
        invert: Sequence[str] = (),
        delay: Mapping[str, float] | None = None,
    ) -> None:
        own = isinstance(low_pass, str) and low_pass == "own"
        if isinstance(low_pass, str) and not own:
            raise refused("low_pass", low_pass, "a number of Hz, 'own' or None")
        if isinstance(columns, Mapping):
            columns = ",".join(f"{role}={title}" for role, title in columns.items())
        columns = None if columns is None else text_of("columns", columns, "a text or a mapping of roles to titles")
        position = None if position is None else choice("position", position, ("key", "fingertip", "key-back"))
        late = [(str(name), number(f"delay[{name!r}]", s)) for name, s in mapping("delay", delay).items()]
        hz = None if own or low_pass is None else number("low_pass", low_pass)
        if not isinstance(zero, (bool, np.bool_, Mapping)):
            raise refused("zero", zero, "True, False or a mapping of columns to numbers")
        zeros = [(str(name), number(f"zero[{name!r}]", at)) for name, at in (zero.items() if isinstance(zero, Mapping) else ())]
        ready = (position, isinstance(zero, Mapping) or bool(zero), hz, own, names_of("invert", invert), late, zeros)
        if isinstance(source, Recording):
            name, source = source.name, dict(source)
        elif isinstance(source, (str, os.PathLike)):
            path = os.fspath(source)
            if not path.endswith((".parquet", ".pq")):
                self._made(_erard.Recording.load(path, columns, ready), ready)
                return
            name, source = path, _parquet(path)
        else:
            name = "table"
        table = _arrays(source)
        titles = list(table)
        self._made(_erard.Recording.table(name, titles, list(table.values()), columns, ready), ready)

    def _made(self, inner: _erard.Recording, ready: Ready) -> None:
        self._inner, self._ready = inner, ready
        columns = inner.columns()
        for values in columns.values():
            values.flags.writeable = False
        super().__init__(dict(columns))

    @property
    def name(self) -> str:
        """Name of the recording in messages: its file, or "table"."""
        return self._inner.name

    @property
    def position_of(self) -> str:
        """Part whose position was recorded: "key", "fingertip" or "key-back"."""
        return self._inner.position_of

    @property
    def notes(self) -> list[str]:
        """Report of the preparation: changes and observations, one in each line."""
        return self._inner.notes

    def noise(self, column: str) -> float | None:
        """Returns the root mean square noise of a channel, measured in its rest or its spectrum.

        Parameters
        ----------
        column : {"force_N", "key_m", "hammer_rise_m", "hammer_rise_m_per_s"}

        Returns
        -------
        float or None
            Noise, N, m or m/s; `None` if neither shows it.
        """
        return self._inner.noise(choice("column", column, _CHANNELS))

    def at(self, column: str, time_s: ArrayLike) -> NDArray[np.float64]:
        """Returns a channel, prepared and interpolated.

        Parameters
        ----------
        column : {"force_N", "key_m", "hammer_rise_m", "hammer_rise_m_per_s"}
        time_s : array_like
            Times, s, of shape (T,).

        Returns
        -------
        ndarray of shape (T,)
            N, m or m/s.
        """
        found = self._inner.at(choice("column", column, _CHANNELS), floats("time_s", np.atleast_1d(time_s), 1))
        if found is None:
            raise InputError(f"{column} was not recorded; there are {', '.join(self)}", key="column", found=str(column))
        return found

    def _again(self, columns: Mapping[str, NDArray[np.float64]]) -> Recording:
        """Returns a recording with other samples of the same channels, prepared in the same way."""
        return _unpickled(self.name, {name: np.ascontiguousarray(values) for name, values in columns.items()}, self._ready)

    def __repr__(self) -> str:
        return f"<erard.Recording {self.name}: {len(self['time_s'])} rows, {', '.join(self)}>"

    def __reduce__(self) -> tuple[Any, ...]:
        return _unpickled, (self.name, {name: np.asarray(values) for name, values in self.items()}, self._ready)


def _unpickled(name: str, columns: dict[str, Any], ready: Ready) -> Recording:
    recording = Recording.__new__(Recording)
    recording._made(_erard.Recording.table(name, list(columns), list(columns.values()), None, ready), ready)
    return recording


def _parquet(path: str) -> Mapping[str, Any]:
    import pyarrow.parquet as pq

    try:
        table = pq.read_table(path)
    except (OSError, ValueError) as error:
        if not os.path.isfile(path):
            raise MissingFileError(f"{path}: cannot be read: there is no such file", file=path) from None
        raise InputError(f"{path}: is no Parquet file that can be read: {error}", file=path) from None
    return {name: column.to_numpy() for name, column in zip(table.column_names, table.columns, strict=True)}


def _arrays(source: Any) -> dict[str, NDArray[np.float64]]:
    """Returns the numeric columns of a source that has columns."""
    is_frame = type(source).__module__.partition(".")[0] in ("pandas", "polars")
    if not isinstance(source, Mapping) and hasattr(source, "__arrow_c_stream__") and not is_frame:
        import pyarrow as pa

        source = pa.table(source)
    if hasattr(source, "column_names"):
        names = list(source.column_names)
    elif isinstance(source, Mapping):
        # An xarray data set counts its coordinates among its variables.
        names = list(source.variables) if hasattr(source, "variables") else list(source)
    elif hasattr(source, "columns"):
        names = [str(name) for name in source.columns]
    else:
        kind = type(source).__name__
        raise InputError(f"a recording is a run, a mapping of arrays with `time_s`, a data frame or a path; found {kind}", found=kind)
    found: dict[str, NDArray[np.float64]] = {}
    for name in names:
        if np.iscomplexobj(source[name]):
            raise InputError(f"{name}: found complex numbers, expected real ones", key=str(name), found="complex numbers")
        try:
            found[str(name)] = real(source[name])
        except (TypeError, ValueError):
            continue  # A column of text is none of ours.
    if single := [name for name, values in found.items() if values.ndim == 0]:
        raise refused(single[0], found[single[0]].item(), "an array of numbers, one for each sample")
    lengths = {name: len(values) if values.ndim == 1 else values.shape for name, values in found.items()}
    if len(set(lengths.values())) > 1:
        told = ", ".join(f"{name}: {length}" for name, length in lengths.items())
        raise InputError(f"columns of equal length are expected; found {told}", found=told)
    return found


def as_recording(source: RecordingLike) -> Recording:
    """Returns the recording itself, or makes one of the source, prepared as a file is by the command; a run, which is
    computed, is left as it is."""
    if isinstance(source, Recording):
        return source
    if isinstance(source, Table):
        return Recording(source, zero=False, low_pass=None)
    return Recording(source)
