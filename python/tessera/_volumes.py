"""Volumes between two surfaces."""
from __future__ import annotations

import os
import typing
import warnings

import numpy as np
import numpy.typing as npt

from . import _tessera
from ._errors import UsageError
from ._options import Path
from ._surfaces import number_or_none


class VolumeTable(typing.NamedTuple):
    """Volumes between a surface A, before, and a surface B, after: n rows, one for each polygon, or one for all."""

    cut: npt.NDArray[np.float64]
    """The volume where A lies above B: material to take away to come from A to B."""
    fill: npt.NDArray[np.float64]
    """The volume where B lies above A: material to add."""
    net: npt.NDArray[np.float64]
    """cut - fill."""
    mean: npt.NDArray[np.float64]
    """The mean of A - B over the covered area; NaN where nothing is covered."""
    area: npt.NDArray[np.float64]
    """The area of the polygon; without polygons, of what A or B covers."""
    covered: npt.NDArray[np.float64]
    """The part of it that A and B cover. Volumes are those over this part."""
    uncovered: npt.NDArray[np.float64]
    """The rest: holes, and what is outside of a hull."""
    uncovered_by_a: npt.NDArray[np.float64]
    """The part that A does not cover."""
    uncovered_by_b: npt.NDArray[np.float64]
    """The part that B does not cover."""
    polygons: npt.NDArray[np.int64]
    """The numbers of the polygons in their file; empty without polygons."""
    names: list[str]
    """The names of the polygons; empty without polygons."""
    area_unit: str = ""
    """The unit of areas, for example "metre^2"; "" when unknown."""
    volume_unit: str = ""
    """The unit of volumes."""


def table_of(rows: list[dict[str, typing.Any]], area_unit: str, volume_unit: str) -> VolumeTable:
    """Returns the table in the outcome of a daemon's job. Raises KeyError, TypeError or ValueError if it is none."""
    columns = VolumeTable._fields[:VolumeTable._fields.index("polygons")]
    numbers = {column: np.array([np.nan if row[column] is None else row[column] for row in rows], np.float64)
               for column in columns}
    polygons = [row for row in rows if "polygon" in row]
    return VolumeTable(**numbers, polygons=np.array([row["polygon"] for row in polygons], np.int64),
                       names=[str(row["name"]) for row in polygons], area_unit=area_unit, volume_unit=volume_unit)


class SurfaceVolumes:
    """The volumes that a Triangulation can compute under its surface."""

    _triangulation: _tessera.Triangulation

    def volume(self, other: SurfaceVolumes | None = None, *, plane: float | None = None, base: Path | None = None,
               within: Path | None = None, name: str = "", max_edge: float | None = None, max_radius: float | None = None, value: str = "z",
               difference: Path | None = None, res: float | None = None, overwrite: bool = False) -> VolumeTable:
        """Computes the volumes between this surface A, of a 2D result, and a surface B: exactly on the triangles of
        both.

        Parameters
        ----------
        other
            B, as another 2D result. Give one of `other`, `plane` and `base`.
        plane
            B is the level plane at this height.
        base
            B is spanned by the vertices of the polygons of this file, which have heights. Each polygon is a row. Files
            of polygons are GeoPackage, GeoJSON, FlatGeobuf or Shapefile.
        within
            A row for each polygon of this file: the volumes inside of the polygon.
        name
            The attribute that names the polygons. "": name or id, if there is one.
        max_edge
            Cells with a longer edge in the plane are holes.
        max_radius
            Cells with a larger circumradius in the plane are holes, too.
        value
            The attribute of the vertices that has the heights.
        difference, res
            Also writes A - B as a Cloud Optimized GeoTIFF with pixels of the width `res`: above 0 where A lies above B.
        overwrite
            Replaces an existing file. Otherwise such a file is an error.

        Warns with a UserWarning if the coordinates have no coordinate system. The GIL is released; Ctrl-C leaves nothing
        half-written.
        """
        if (difference is None) != (res is None):
            raise UsageError("difference and res go together: a file, and the width of its pixels")
        path = lambda file: None if file is None else os.fspath(file)
        lower = None if other is None else other._triangulation
        request = _tessera.VolumeRequest(number_or_none(plane), path(base), path(within), name, number_or_none(max_edge), number_or_none(max_radius), value)
        columns, area_unit, volume_unit, note = _tessera.volumes(self._triangulation, lower, request)
        if difference is not None:
            _tessera.write_difference(self._triangulation, lower, os.fspath(difference), float(res), request, bool(overwrite))
        if note:
            warnings.warn(note, stacklevel=2)
        numbers = columns.pop("polygon", [])
        names = columns.pop("name", [])
        return VolumeTable(**{key: np.array(values, np.float64) for key, values in columns.items()},
                           polygons=np.array(numbers, np.int64), names=names, area_unit=area_unit, volume_unit=volume_unit)
