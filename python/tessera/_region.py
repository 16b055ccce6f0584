"""Regions of raw clouds."""
from __future__ import annotations

import typing

import numpy.typing as npt

from . import _tessera
from ._arrays import exact_float64
from ._errors import UsageError
from ._options import Path, file_names, job_options, positive
from ._triangulate import warn
from ._triangulation import Triangulation


def region(source: Path | typing.Sequence[Path], bbox: npt.ArrayLike, dim: int | None = None, *,
           scan_files: bool = False, max_points: int | None = None, max_seconds: float | None = None,
           folder: Path | None = None, overwrite: bool = False, threads: int | None = None,
           memory: int | str | None = None, **options: typing.Any) -> Triangulation:
    """Returns the cells of a place of raw files, without triangulating the rest of the points.

    These are exactly those cells of the triangulation of all points of the files that have a point in common with the
    box. Ranks of points (Tile.ids) are those of the whole triangulation.

    Parameters
    ----------
    source, dim, folder, overwrite, threads, memory, options
        As for triangulate(). Options about tiles have no effect.
    bbox
        A closed box: (xmin, ymin, xmax, ymax), or in 3D (xmin, ymin, zmin, xmax, ymax, zmax).
    scan_files
        Reads all files once to learn where their points are, instead of relying on the boxes that the files state.
    max_points, max_seconds
        Raises MemoryLimitError if more points would have to be triangulated, or if the call takes longer. The message
        says what is still needed.

    Raises UsageError if no cell meets the box. The GIL is released; Ctrl-C leaves nothing half-written.
    """
    files = file_names(source, options.get("input_list"))
    if files is None:
        raise UsageError("region() is for files: it takes a path, a pattern, or a list of them")
    request = _tessera.RegionRequest()
    request.scan_files(scan_files)
    if max_points is not None:
        request.max_points(positive(max_points, "max_points", 2**63))
    if max_seconds is not None:
        request.max_seconds(float(max_seconds))
    chosen = job_options(dim, folder=folder, overwrite=overwrite, threads=threads, memory=memory, **options)
    box = exact_float64(bbox, "bbox").ravel().tolist()
    return Triangulation(_tessera.triangulate_region(files, box, chosen, request, warn))
