"""Tables of Apache Arrow: as points of triangulations, and made of them."""
from __future__ import annotations

import typing

import numpy as np

from . import _arrow_c
from ._arrays import exact_float64
from ._errors import UsageError
from ._records import TAKEN
from ._triangulate import triangulate
from ._triangulation import Triangulation


def from_arrow(table: typing.Any, dim: int | None = None, **options: typing.Any) -> Triangulation:
    """Triangulates the rows of an Arrow table: of pyarrow, Polars, DuckDB, GeoPandas or any package whose tables have
    __arrow_c_stream__. pyarrow is not needed.

    Parameters
    ----------
    table
        A table with the columns "x", "y" and perhaps "z", of integers, floats or bool, without nulls. The other columns
        become attributes; a column "id" is left out, because it means the rank of a point in a result.
    dim, options
        As for triangulate(). With dim=2 the column "z" is the height.

    The values are copied. Numbers that float64 would round are refused, as triangulate() refuses them.
    """
    if not hasattr(table, "__arrow_c_stream__"):
        raise UsageError(f"table is of the type {type(table).__name__}: it must be an Arrow table, with __arrow_c_stream__")
    if "attributes" in options:
        raise UsageError("attributes of an Arrow table are its columns: choose the columns of the table instead")
    parts: dict[str, list[typing.Any]] = {}
    for batch in _arrow_c.batches(table):
        for name, values in batch.items():
            parts.setdefault(name, []).append(values)
    columns = {name: np.concatenate(values) for name, values in parts.items()}
    axes = [axis for axis in ("x", "y", "z") if axis in columns]
    if axes[:2] != ["x", "y"]:
        raise UsageError(f"the Arrow table has the columns {', '.join(columns) or 'none, or no rows'}: it must have x and y, and may have z")
    points = np.column_stack([exact_float64(columns[axis], f"column {axis}") for axis in axes])
    others = {name: values for name, values in columns.items() if name not in TAKEN}
    return triangulate(points, dim, attributes=others, **options)
