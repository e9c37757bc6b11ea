"""Tables of named columns: the base of runs, rollouts and studies."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from ._common import unit_of
from ._errors import Extra

if TYPE_CHECKING:
    import pandas
    import polars
    import pyarrow
    from numpy.typing import NDArray


class Table(Mapping[str, "NDArray[Any]"]):
    """Named columns of equal length, as read-only arrays.

    A table is a mapping and supports the Arrow PyCapsule
    protocol: `polars.DataFrame(table)`, `pyarrow.table(table)`, `pandas.DataFrame.from_arrow(table)` and DuckDB read it
    without a copy. `numpy.asarray(table)` has shape (T, C), a column for each name, of objects where a column holds
    texts, as pandas does it; `pandas.DataFrame(table)` has these columns without their names, and `to_pandas` with them.
    """

    _columns: dict[str, NDArray[Any]]
    #: Units of columns whose names do not end with a unit.
    _own_units: Mapping[str, str] = {}

    def __init__(self, columns: dict[str, NDArray[Any]]) -> None:
        self._columns = columns

    @property
    def columns(self) -> list[str]:
        """Names of the columns, in order; a name ends with its unit."""
        return list(self._columns)

    @property
    def units(self) -> dict[str, str]:
        """Unit of every column; "1" for a number without unit."""
        return {name: self._unit(name) for name in self._columns}

    def _unit(self, column: str) -> str:
        return self._own_units.get(column) or unit_of(column)

    def __getitem__(self, column: str) -> NDArray[Any]:
        try:
            return self._columns[column]
        except KeyError:
            raise KeyError(f"there is no column {column!r}; there are {', '.join(self._columns)}") from None

    def __iter__(self) -> Iterator[str]:
        return iter(self._columns)

    def __len__(self) -> int:
        return len(self._columns)

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> NDArray[np.float64]:
        """Returns the columns side by side as an array of shape (T, C), in the order of `columns`: of doubles, or of
        objects where a column holds texts."""
        if sampled := [name for name, values in self._columns.items() if values.ndim != 1]:
            raise TypeError(f"column {sampled[0]!r} of this {type(self).__name__} has many samples in a row; take one column, as in table[{sampled[0]!r}]")
        if copy is False:
            raise ValueError("the columns are apart in memory: an array of all of them is a copy")
        texts = [name for name, values in self._columns.items() if values.dtype.kind not in "fiub"]
        kind = np.dtype((object if texts else np.float64) if dtype is None else dtype)
        if texts and kind.kind != "O":
            raise TypeError(f"column {texts[0]!r} of this {type(self).__name__} holds texts; leave out dtype, or take columns of numbers, as in table[{next(iter(self), '')!r}]")
        array = np.empty((len(next(iter(self._columns.values()), ())), len(self._columns)), dtype=kind)
        for index, values in enumerate(self._columns.values()):
            array[:, index] = values
        return array

    def __eq__(self, other: object) -> bool:
        if type(other) is not type(self):
            return NotImplemented
        assert isinstance(other, Table)
        return list(self) == list(other) and all(_same(self[name], other[name]) for name in self)

    __hash__ = None  # type: ignore[assignment]

    def to_pandas(self) -> pandas.DataFrame:
        """Returns a pandas data frame of the one-dimensional columns; `attrs["units"]` holds their units.

        Returns
        -------
        pandas.DataFrame
        """
        with Extra("tables"):
            import pandas as pd

        frame = pd.DataFrame(self._flat(), copy=False)
        frame.attrs["units"] = {name: self._unit(name) for name in frame.columns}
        return frame

    def to_polars(self) -> polars.DataFrame:
        """Returns a polars data frame; samples of shape (N, T) become a column of arrays.

        Returns
        -------
        polars.DataFrame
        """
        with Extra("tables"):
            import polars as pl

        return pl.DataFrame(self)

    def to_arrow(self) -> pyarrow.Table:
        """Returns an Arrow table; each field's metadata holds its `unit`. Samples of shape (N, T) become a column of
        fixed-size lists.

        Returns
        -------
        pyarrow.Table
        """
        with Extra("tables"):
            import pyarrow as pa

        return pa.table(self)

    def __repr__(self) -> str:
        rows = len(next(iter(self._columns.values()), ()))
        return f"<erard.{type(self).__name__} of {rows} rows: {', '.join(self)}>"

    def _flat(self) -> dict[str, NDArray[Any]]:
        return {name: values for name, values in self._columns.items() if values.ndim == 1}

    def __arrow_c_stream__(self, requested_schema: object = None) -> object:
        with Extra("tables"):
            import nanoarrow as na

        children, fields = [], []
        rows = 0
        for name, values in self._columns.items():
            rows = len(values)
            if values.ndim == 2:
                kind = na.fixed_size_list(na.float64(), values.shape[1])
                every = np.ascontiguousarray(values, dtype=np.float64).reshape(-1)
                inner = na.c_array_from_buffers(na.float64(), every.size, [None, every])
                fields.append(na.Schema(kind, name=name, metadata={"unit": self._unit(name)}))
                children.append(na.c_array_from_buffers(kind, rows, [None], children=[inner]))
                continue
            match values.dtype.kind:
                case "f":
                    kind, array = na.float64(), na.c_array_from_buffers(na.float64(), rows, [None, values])
                case "b":
                    bits = np.packbits(values, bitorder="little")
                    kind, array = na.bool_(), na.c_array_from_buffers(na.bool_(), rows, [None, bits])
                case "i" | "u":
                    whole = np.ascontiguousarray(values, dtype=np.int64)
                    kind, array = na.int64(), na.c_array_from_buffers(na.int64(), rows, [None, whole])
                case _:
                    kind, array = na.string(), na.c_array([str(value) for value in values], na.string())
            fields.append(na.Schema(kind, name=name, metadata={"unit": self._unit(name)}))
            children.append(array)
        schema = na.struct(fields)
        struct = na.c_array_from_buffers(schema, rows, [None], children=children)
        return na.c_array_stream(struct).__arrow_c_stream__(requested_schema)


def _same(a: NDArray[Any], b: NDArray[Any]) -> bool:
    return bool(np.array_equal(a, b, equal_nan=a.dtype.kind == "f"))
