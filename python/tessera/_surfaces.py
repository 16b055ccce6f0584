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


class Raster(typing.NamedTuple):
    """A surface, drawn."""

    values: npt.NDArray[np.float64]
    """height x width, from the top; NaN where there is no value."""
    left: float
    top: float
    """Of its corner, in the coordinates of the result."""
    res: float
    crs: str = ""
    """The coordinate reference system, as that of the result; "" when there is none."""


class Contour(typing.NamedTuple):
    """A line at one height; higher ground is on its left."""

    value: float
    """Its height, or what else `value` asked for."""
    points: npt.NDArray[np.float64]
    """n x 2; a closed line ends with its first point."""
    index: bool = False
    """Whether it is an index line, of each fifth level."""


class Profile(typing.NamedTuple):
    """A surface along a line: n places where the line or the surface bends, in their order."""

    distances: npt.NDArray[np.float64]
    """From the line's beginning, in the plane."""
    points: npt.NDArray[np.float64]
    """n x 2."""
    values: npt.NDArray[np.float64]
    """The heights, or what else `value` asked for."""
    parts: npt.NDArray[np.int64]
    """Places of one part are joined by straight lines; between parts there is no surface."""


class Surfaces:
    """What is drawn of a Triangulation."""

    _triangulation: _tessera.Triangulation

    @typing.overload
    def dem(self, path: None = ..., *, res: float, bbox: npt.ArrayLike | None = ..., max_edge: float | None = ...,
            value: str = ..., doubles: bool = ..., overwrite: bool = ..., hillshade: bool = ...,
            azimuth: float | None = ..., altitude: float | None = ...) -> Raster: ...

    @typing.overload
    def dem(self, path: Path, *, res: float, bbox: npt.ArrayLike | None = ..., max_edge: float | None = ...,
            value: str = ..., doubles: bool = ..., overwrite: bool = ..., hillshade: bool = ...,
            azimuth: float | None = ..., altitude: float | None = ...) -> None: ...

    def dem(self, path=None, *, res, bbox=None, max_edge=None, value="z", doubles=False, overwrite=False,
            hillshade=False, azimuth=None, altitude=None):
        """The surface of a 2D result as a raster: written to `path`, a Cloud Optimized GeoTIFF, or, without one, returned.

        Parameters
        ----------
        res
            The width and height of a pixel, in units of the coordinates.
        bbox
            (xmin, ymin, xmax, ymax): what the raster covers. None: the bounds of the result.
        max_edge
            No pixels in cells with a longer edge in the plane.
        value
            An attribute of the vertices; "z" are the heights.
        doubles
            Pixels of 64 bits; otherwise they are rounded to 32.
        overwrite
            Replace a file of the same name. Otherwise that is an error.
        hillshade
            A hillshade of the surface, from 1 to 255, as `gdaldem hillshade -compute_edges` makes it of the raster. In files
            its pixels are bytes, and 0 where there is none.
        azimuth, altitude
            The light of a hillshade: degrees from north, clockwise, and above the horizon. None: 315 and 45.

        Warns with a UserWarning when the coordinates have no system. The GIL is released; Ctrl-C leaves nothing half-written.
        """
        if not hillshade and not (azimuth is None and altitude is None):
            raise UsageError("azimuth and altitude are of a hillshade: give hillshade=True")
        light = (315.0 if azimuth is None else float(azimuth), 45.0 if altitude is None else float(altitude)) if hillshade else None
        request = _tessera.RasterRequest(float(res), plane_box(bbox), number_or_none(max_edge), value, bool(doubles), light)
        if path is None:
            values, left, top = _tessera.draw_raster(self._triangulation, request)
            return Raster(values, left, top, float(res), self._triangulation.crs)
        note = _tessera.write_raster(self._triangulation, os.fspath(path), request, bool(overwrite))
        if note:
            warnings.warn(note, stacklevel=2)
        return None

    @typing.overload
    def contours(self, path: None = ..., *, interval: float, base: float = ..., bbox: npt.ArrayLike | None = ...,
                 max_edge: float | None = ..., value: str = ..., smooth: float | None = ..., min_length: float | None = ...,
                 index_every: int = ..., overwrite: bool = ...) -> list[Contour]: ...

    @typing.overload
    def contours(self, path: Path, *, interval: float, base: float = ..., bbox: npt.ArrayLike | None = ...,
                 max_edge: float | None = ..., value: str = ..., smooth: float | None = ..., min_length: float | None = ...,
                 index_every: int = ..., overwrite: bool = ...) -> None: ...

    def contours(self, path=None, *, interval, base=0.0, bbox=None, max_edge=None, value="z", smooth=None, min_length=None,
                 index_every=5, overwrite=False):
        """The contour lines of a 2D result: written to `path`, a .gpkg or .geojson, or, without one, returned as a list.

        Parameters
        ----------
        interval
            Between levels, in units of the heights.
        base
            A level.
        bbox
            (xmin, ymin, xmax, ymax): only lines in the cells that meet it, uncut. None: all.
        max_edge
            No lines in cells with a longer edge in the plane.
        value
            An attribute of the vertices; "z" are the heights.
        smooth
            Lines of a smooth surface, for maps: means of the surface in squares of this size, in units of the coordinates.
        min_length
            Without lines that are shorter in the plane, closed or not.
        index_every
            Level base + k interval is an index line when this divides k.
        overwrite
            Replace a file of the same name. Otherwise that is an error.

        Lines come by level, always in the same order. Warns with a UserWarning when the coordinates have no system and a
        file is written. The GIL is released; Ctrl-C leaves nothing half-written.
        """
        request = _tessera.ContourRequest(float(interval), float(base), plane_box(bbox), number_or_none(max_edge), value,
                                          number_or_none(smooth), number_or_none(min_length), index(index_every, "index_every", 1_000_001))
        if path is None:
            values, offsets, points, flags = _tessera.draw_contours(self._triangulation, request)
            return [Contour(*line) for line in zip(values.tolist(), np.split(points, offsets[1:-1]), flags.astype(bool).tolist())]
        note = _tessera.write_contours(self._triangulation, os.fspath(path), request, bool(overwrite))
        if note:
            warnings.warn(note, stacklevel=2)
        return None

    @typing.overload
    def profile(self, line: npt.ArrayLike, path: None = ..., *, max_edge: float | None = ..., value: str = ...,
                digits: None = ..., overwrite: bool = ...) -> Profile: ...

    @typing.overload
    def profile(self, line: npt.ArrayLike, path: Path, *, max_edge: float | None = ..., value: str = ...,
                digits: int | typing.Literal["all"] | None = ..., overwrite: bool = ...) -> None: ...

    def profile(self, line, path=None, *, max_edge=None, value="z", digits=None, overwrite=False):
        """The surface of a 2D result along a line: written to `path` as CSV, or, without one, returned.

        Parameters
        ----------
        line
            n x 2 points, two or more.
        max_edge
            Cells with a longer edge in the plane are not part of the surface.
        value
            An attribute of the vertices; "z" are the heights.
        digits
            Of files: decimals of all numbers, 0 to 17, or "all": those of the doubles themselves. None: as the data carry.
        overwrite
            Replace a file of the same name. Otherwise that is an error.

        Warns with a UserWarning when a file is written and there is no surface below some of the line: it tells the gaps.
        Raises UsageError for a line that meets no cell. The GIL is released; Ctrl-C leaves nothing half-written.
        """
        given = exact_float64(line, "line")
        if given.ndim != 2 or given.shape[1] != 2 or len(given) < 2:
            raise UsageError(f"line has the shape {given.shape}: it must be (n, 2), of two points or more")
        if digits not in (None, "all"):
            digits = index(digits, "digits", 18)
        request = _tessera.ProfileRequest(number_or_none(max_edge), value, -1 if digits == "all" else digits)
        if path is None:
            return Profile(*_tessera.draw_profile(self._triangulation, given, request))
        note = _tessera.write_profile(self._triangulation, given, os.fspath(path), request, bool(overwrite))
        if note:
            warnings.warn(note, stacklevel=2)
        return None


def plane_box(bbox: npt.ArrayLike | None) -> list[float] | None:
    """`bbox` as four numbers; UsageError otherwise."""
    box = None if bbox is None else exact_float64(bbox, "bbox").ravel().tolist()
    if box is not None and len(box) != 4:
        raise UsageError("bbox must be (xmin, ymin, xmax, ymax)")
    return box


def number_or_none(value: float | None) -> float | None:
    return None if value is None else float(value)
