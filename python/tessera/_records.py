"""Turns arrays of points with further columns into the rows that the library takes."""
from __future__ import annotations

import re
import typing

import numpy as np
import numpy.typing as npt

from ._errors import UsageError

TAKEN = ("x", "y", "z", "id", "owner", "vtkGhostType")


def point_records(points: npt.NDArray[np.float64], attributes: typing.Mapping[str, npt.ArrayLike]) -> np.ndarray:
    """Returns `points` and the columns as one array of rows. Without columns it shares the memory of `points`."""
    axes = [(axis, "<f8") for axis in "xyz"[: points.shape[1]]]
    if not attributes:
        return points.reshape(-1).view(np.dtype(axes))
    columns = {name: column(name, values, points) for name, values in attributes.items()}
    rows = np.empty(len(points), np.dtype(axes + [(name, values.dtype.str) for name, values in columns.items()]))
    for axis, (name, _) in enumerate(axes):
        rows[name] = points[:, axis]
    for name, values in columns.items():
        rows[name] = values
    return rows


def columns_of(rows: np.ndarray) -> str:
    """Returns the columns of `rows` in the form of the header of a .npy file."""
    return repr([(name, kind[0].str) for name, kind in rows.dtype.fields.items()])


def column(name: typing.Any, values: npt.ArrayLike, points: npt.NDArray[np.float64]) -> np.ndarray:
    """Returns the values of an attribute as an array. Raises UsageError for what a result cannot keep."""
    if not isinstance(name, str) or not re.fullmatch(r"[^\x00-\x1f\x7f/'\"\\]+", name) or len(name.encode(errors="replace")) > 64:
        raise UsageError(f"attributes: {name!r} is no name: it must be text of at most 64 bytes, without / and quotation marks")
    if name in TAKEN and not (name == "z" and points.shape[1] == 2):
        raise UsageError(f"attributes: {name!r} means something else in a result: give another name")
    if np.ma.is_masked(values):
        raise UsageError(f"attributes[{name!r}] has masked entries: leave those rows out")
    given = np.asarray(values)
    if given.shape != (len(points),):
        raise UsageError(f"attributes[{name!r}] has the shape {given.shape}: it must be ({len(points)},), a value for each point")
    if given.dtype.kind not in "buif" or given.dtype.itemsize > 8 or given.dtype == np.float16:
        raise UsageError(f"attributes[{name!r}] has the type {given.dtype}: it must be bool, an integer, float32 or float64")
    return given
