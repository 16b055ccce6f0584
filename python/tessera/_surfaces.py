"""The surface of a 2D result: rasters, contour lines, profiles."""
from __future__ import annotations

import os
import typing
import warnings

import numpy as np
import numpy.typing as npt

from . import _tessera
from ._arrays import exact_float64
from ._errors import UsageError
from ._options import Path, index

_METHODS = ("linear", "natural", "laplace")


class Raster(typing.NamedTuple):
    """A surface as a raster."""

    values: npt.NDArray[np.float64]
    """The pixels: height x width, from the top row down; NaN for pixels without a value."""
    left: float
    """The x of the upper left corner, in the coordinates of the result."""
    top: float
    """The y of the upper left corner."""
    res: float
    """The width and height of a pixel."""
    crs: str = ""
    """The coordinate reference system of the result; "" if it has none."""

    @property
    def __array_interface__(self) -> dict[str, typing.Any]:
        """NumPy, and what uses its interface, take this as the array `values`."""
        return self.values.__array_interface__


class Contour(typing.NamedTuple):
    """A contour line. Higher ground is on its left."""

    value: float
    """The height of the line, or its level of the attribute that `value` named."""
    points: npt.NDArray[np.float64]
    """n x 2; a closed line ends with its first point."""
    index: bool = False
    """Whether the line is an index line; see `index_every`."""


class Profile(typing.NamedTuple):
    """A surface along a line, at the n places where the line or the surface bends, in the order of the line."""

    distances: npt.NDArray[np.float64]
    """The distance of each place from the beginning of the line, in the plane: n."""
    points: npt.NDArray[np.float64]
    """The places: n x 2."""
    values: npt.NDArray[np.float64]
    """The heights, or the values of the attribute that `value` named: n."""
    parts: npt.NDArray[np.int64]
    """n numbers: straight lines join places of the same part; between parts there is no surface."""


class Surfaces:
    """The drawings that a Triangulation can make of its surface."""

    _triangulation: _tessera.Triangulation

    @typing.overload
    def dem(self, path: None = ..., *, res: float, bbox: npt.ArrayLike | None = ..., max_edge: float | None = ..., max_radius: float | None = ...,
            value: str = ..., doubles: bool = ..., overwrite: bool = ..., hillshade: bool = ...,
            azimuth: float | None = ..., altitude: float | None = ..., method: str = ...) -> Raster: ...

    @typing.overload
    def dem(self, path: Path, *, res: float, bbox: npt.ArrayLike | None = ..., max_edge: float | None = ..., max_radius: float | None = ...,
            value: str = ..., doubles: bool = ..., overwrite: bool = ..., hillshade: bool = ...,
            azimuth: float | None = ..., altitude: float | None = ..., method: str = ...) -> None: ...

    def dem(self, path=None, *, res, bbox=None, max_edge=None, max_radius=None, value="z", doubles=False, overwrite=False,
            hillshade=False, azimuth=None, altitude=None, method="linear"):
        """Draws the surface of a 2D result as a raster. Without a path returns a Raster; with `path` writes a Cloud
        Optimized GeoTIFF.

        Parameters
        ----------
        res
            The width and height of a pixel, in units of the coordinates.
        bbox
            The box that the raster covers: (xmin, ymin, xmax, ymax). None: the bounds of the result.
        max_edge
            Leaves out cells with a longer edge in the plane; their pixels have no value.
        max_radius
            Leaves out cells with a larger circumradius in the plane; their pixels have no value.
        value
            The attribute of the vertices to draw; "z" is the height.
        doubles
            Pixels have 64 bits; otherwise values are rounded to 32 bits.
        overwrite
            Replaces an existing file of the same name. Otherwise such a file is an error.
        hillshade
            Draws a hillshade instead: the one that `gdaldem hillshade -compute_edges` makes of the raster, with values
            from 1 to 255. In files its pixels are bytes, 0 where there is no value.
        azimuth, altitude
            The direction of the light for a hillshade: degrees clockwise from north, and degrees above the horizon.
            None: 315 and 45.
        method
            How values follow from the vertices: "linear" in each cell, "natural" (Sibson's natural neighbours) or
            "laplace" (natural neighbours, with other weights).

        Warns with a UserWarning if a file is written and the coordinates have no coordinate system. The GIL is
        released; Ctrl-C leaves nothing half-written.
        """
        if not hillshade and not (azimuth is None and altitude is None):
            raise UsageError("azimuth and altitude are for a hillshade: give hillshade=True")
        if method not in _METHODS:
            raise UsageError(f"method is {method!r}; it must be one of {', '.join(_METHODS)}")
        light = (315.0 if azimuth is None else float(azimuth), 45.0 if altitude is None else float(altitude)) if hillshade else None
        request = _tessera.RasterRequest(float(res), plane_box(bbox), number_or_none(max_edge), number_or_none(max_radius), value, bool(doubles), light,
                                         _METHODS.index(method))
        if path is None:
            values, left, top = _tessera.draw_raster(self._triangulation, request)
            return Raster(values, left, top, float(res), self._triangulation.crs)
        note = _tessera.write_raster(self._triangulation, os.fspath(path), request, bool(overwrite))
        if note:
            warnings.warn(note, stacklevel=2)
        return None

    @typing.overload
    def contours(self, path: None = ..., *, interval: float, base: float = ..., bbox: npt.ArrayLike | None = ...,
                 max_edge: float | None = ..., max_radius: float | None = ..., value: str = ..., smooth: float | None = ..., min_length: float | None = ...,
                 index_every: int = ..., overwrite: bool = ...) -> list[Contour]: ...

    @typing.overload
    def contours(self, path: Path, *, interval: float, base: float = ..., bbox: npt.ArrayLike | None = ...,
                 max_edge: float | None = ..., max_radius: float | None = ..., value: str = ..., smooth: float | None = ..., min_length: float | None = ...,
                 index_every: int = ..., overwrite: bool = ...) -> None: ...

    def contours(self, path=None, *, interval, base=0.0, bbox=None, max_edge=None, max_radius=None, value="z", smooth=None, min_length=None,
                 index_every=5, overwrite=False):
        """Draws the contour lines of a 2D result. Returns a list; with `path` writes a .gpkg or .geojson instead.

        Parameters
        ----------
        interval
            The distance between levels, in units of the heights.
        base
            One of the levels; the others are base + k interval.
        bbox
            Draws only the lines in cells that meet the box (xmin, ymin, xmax, ymax), not cut at the box. None: all
            lines.
        max_edge
            Draws no lines in cells with a longer edge in the plane.
        max_radius
            Draws no lines in cells with a larger circumradius in the plane.
        value
            The attribute of the vertices to draw; "z" is the height.
        smooth
            Draws the lines of a smooth surface, for maps: the means of the surface in squares of this size, in units of
            the coordinates. None: the lines of the triangulated surface itself.
        min_length
            Leaves out lines that are shorter in the plane, closed or not.
        index_every
            The level base + k interval is an index line if this number divides k.
        overwrite
            Replaces an existing file of the same name. Otherwise such a file is an error.

        Lines are sorted by level, and their order is always the same. Warns with a UserWarning if a file is written and
        the coordinates have no coordinate system. The GIL is released; Ctrl-C leaves nothing half-written.
        """
        request = _tessera.ContourRequest(float(interval), float(base), plane_box(bbox), number_or_none(max_edge), number_or_none(max_radius), value,
                                          number_or_none(smooth), number_or_none(min_length), index(index_every, "index_every", 1_000_001))
        if path is None:
            values, offsets, points, flags = _tessera.draw_contours(self._triangulation, request)
            return [Contour(*line) for line in zip(values.tolist(), np.split(points, offsets[1:-1]), flags.astype(bool).tolist())]
        note = _tessera.write_contours(self._triangulation, os.fspath(path), request, bool(overwrite))
        if note:
            warnings.warn(note, stacklevel=2)
        return None

    @typing.overload
    def profile(self, line: npt.ArrayLike, path: None = ..., *, max_edge: float | None = ..., max_radius: float | None = ..., value: str = ...,
                digits: None = ..., overwrite: bool = ...) -> Profile: ...

    @typing.overload
    def profile(self, line: npt.ArrayLike, path: Path, *, max_edge: float | None = ..., max_radius: float | None = ..., value: str = ...,
                digits: int | typing.Literal["all"] | None = ..., overwrite: bool = ...) -> None: ...

    def profile(self, line, path=None, *, max_edge=None, max_radius=None, value="z", digits=None, overwrite=False):
        """Draws the surface of a 2D result along a line. Without a path returns a Profile; with `path` writes CSV.

        Parameters
        ----------
        line
            n x 2 points, at least two.
        max_edge
            Cells with a longer edge in the plane are not part of the surface.
        max_radius
            Cells with a larger circumradius in the plane are not part of the surface.
        value
            The attribute of the vertices to draw; "z" is the height.
        digits
            The number of decimals in a file, 0 to 17, or "all": so many that the same doubles are read back. None: the
            precision that the data have.
        overwrite
            Replaces an existing file of the same name. Otherwise such a file is an error.

        Warns with a UserWarning if a file is written and parts of the line have no surface below them; the warning
        tells the gaps. Raises UsageError for a line that meets no cell. The GIL is released; Ctrl-C leaves nothing
        half-written.
        """
        given = exact_float64(line, "line")
        if given.ndim != 2 or given.shape[1] != 2 or len(given) < 2:
            raise UsageError(f"line has the shape {given.shape}: it must be (n, 2), of two points or more")
        if digits not in (None, "all"):
            digits = index(digits, "digits", 18)
        request = _tessera.ProfileRequest(number_or_none(max_edge), number_or_none(max_radius), value, -1 if digits == "all" else digits)
        if path is None:
            return Profile(*_tessera.draw_profile(self._triangulation, given, request))
        note = _tessera.write_profile(self._triangulation, given, os.fspath(path), request, bool(overwrite))
        if note:
            warnings.warn(note, stacklevel=2)
        return None


def plane_box(bbox: npt.ArrayLike | None) -> list[float] | None:
    """Returns `bbox` as four numbers, or None for None. Raises UsageError for another number of them."""
    box = None if bbox is None else exact_float64(bbox, "bbox").ravel().tolist()
    if box is not None and len(box) != 4:
        raise UsageError("bbox must be (xmin, ymin, xmax, ymax)")
    return box


def number_or_none(value: float | None) -> float | None:
    return None if value is None else float(value)
