"""Voronoi cells of results."""
from __future__ import annotations

import os
import typing
import warnings

from . import _tessera
from ._options import Path, memory_bytes


class VoronoiFile(typing.NamedTuple):
    """What a file of Voronoi cells has."""

    cells: int
    """How many cells were written."""
    unbounded: int
    """Those among them that are unbounded as a whole; in 3D without a clip these are not written."""
    outside: int
    """Cells that do not meet the clip, and are not written."""
    size: float
    """The sum of the finite areas or volumes."""


class VoronoiCells:
    """The Voronoi cells that can be made of a Triangulation."""

    _triangulation: _tessera.Triangulation

    def voronoi(self, path: Path, *, clip: str | Path | typing.Sequence[float] | None = None,
                memory: int | str | None = None, threads: int = 0, overwrite: bool = False) -> VoronoiFile:
        """Writes the Voronoi cells of the points: of a 2D result polygons as .gpkg, .fgb, .geojson or .csv, of a 3D
        result polyhedra as .vtu.

        Parameters
        ----------
        clip
            To what cells are clipped: "hull" (the convex hull; in 2D), "none", a box (xmin, ymin, xmax, ymax) or (xmin,
            ymin, zmin, xmax, ymax, zmax), or in 2D a file of polygons: .gpkg, .fgb or .geojson. None: "hull" in 2D, "none"
            in 3D.
        memory
            The memory for tiles: bytes, or "800M", "4G". None: 70 % of the free memory.
        threads
            The number of threads. 0: all processors.
        overwrite
            Replaces an existing file of the same name. Otherwise such a file is an error.

        Corners are computed exactly and rounded once. Raises UsageError for a region, and when no cell meets the clip.
        Warns with a UserWarning if the coordinates have no coordinate system. The GIL is released; Ctrl-C leaves nothing
        half-written.
        """
        request = _tessera.VoronoiRequest(memory_bytes(memory), threads, bool(overwrite))
        if clip is None:
            pass
        elif isinstance(clip, (str, os.PathLike)):
            name = os.fspath(clip)
            if name == "hull":
                request.clip_to_hull()
            elif name == "none":
                request.clip_to_nothing()
            else:
                request.clip_to_file(name)
        else:
            request.clip_to_box([float(x) for x in clip])
        *counts, size, note = _tessera.write_voronoi(self._triangulation, os.fspath(path), request)
        if note:
            warnings.warn(note, stacklevel=2)
        return VoronoiFile(*counts, size)
