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
           scan: bool = False, max_points: int | None = None, max_seconds: float | None = None,
           folder: Path | None = None, overwrite: bool = False, threads: int | None = None,
           memory: int | str | None = None, **options: typing.Any) -> Triangulation:
    """The cells of a place, without triangulating the rest: exactly those cells of the triangulation of all points of these
    files that have a point in common with a box, with the ranks of all points.

    Parameters
    ----------
    source, dim, folder, overwrite, threads, memory, options
        As of triangulate(); what says how space is cut into tiles does not count.
    bbox
        Closed: (xmin, ymin, xmax, ymax), or in 3D (xmin, ymin, zmin, xmax, ymax, zmax).
    scan
        Read all files once and see where their points are, instead of believing the boxes that they state.
    max_points, max_seconds
        MemoryLimitError, with what is still needed, when more would have to be triangulated, or it takes longer.

    Raises UsageError when no cell meets the box. The GIL is released; Ctrl-C leaves nothing half-written.
    """
    files = file_names(source, options.get("input_list"))
    if files is None:
        raise UsageError("region() is of files: it takes a path, a pattern, or a list of them")
    request = _tessera.RegionRequest()
    request.scan(scan)
    if max_points is not None:
        request.max_points(positive(max_points, "max_points", 2**63))
    if max_seconds is not None:
        request.max_seconds(float(max_seconds))
    chosen = job_options(dim, folder=folder, overwrite=overwrite, threads=threads, memory=memory, **options)
    box = exact_float64(bbox, "bbox").ravel().tolist()
    return Triangulation(_tessera.triangulate_region(files, box, chosen, request, warn))
