"""From points or files to a triangulation in tiles, and what is known before."""
from __future__ import annotations

import json
import typing
import warnings

import numpy.typing as npt

from . import _tessera
from ._errors import UsageError
from ._options import file_names, job_options, point_array
from ._progress import Progress
from ._records import columns_of, point_records
from ._triangulation import Path, Triangulation


def triangulate(source: npt.ArrayLike | Path | typing.Sequence[Path] = (), dim: int | None = None,
                max_points_per_tile: int | None = None, folder: Path | None = None, overwrite: bool = False,
                threads: int | None = None, memory: int | str | None = None,
                attributes: typing.Iterable[str] | typing.Mapping[str, npt.ArrayLike] = (),
                neighbors: bool = True, skip_invalid: bool = False,
                progress: typing.Callable[[Progress], object] | None = None, recursive: bool = False, *,
                tiles: int | None = None, partition: str = "kdtree", crop: typing.Sequence[float] | None = None,
                classes: typing.Iterable[int] = (), returns: str = "all", without: typing.Iterable[str] = (),
                resolution: float | None = None, crs: Path | None = None, heights: bool = True,
                input_list: Path | None = None, resume: bool = False, columns: typing.Iterable[str] = (),
                keep: str = "first", store: str = "auto") -> Triangulation:
    """The exact Delaunay triangulation of points of any number, in tiles, on several threads, within given memory.

    Parameters
    ----------
    source
        Points: an array or a DataFrame, n x 2 or n x 3, of any numbers and any strides. It is used in place when it is
        float64 and C-contiguous, and must then not change meanwhile; otherwise it is converted. Numbers that float64
        would round (int64 beyond 2^53, longdouble) are refused: the result is exact for the points given.
        Or files: a path, a folder, a pattern ("block/*.laz"), or a list of them, which together make one cloud.
    dim
        2 or 3. None: the number of columns; for files 3, or 2 when they hold x and y alone. Arrays and files with z are
        triangulated by x and y with dim=2; see `heights`.
    max_points_per_tile
        A tile is worked on in memory, at about 700 bytes a point. None: chosen from memory and threads.
    tiles
        The number of tiles, instead of their size.
    partition
        "kdtree", "grid", "octree" or "random".
    folder
        The result folder, which stays, for tessera.open() and the programs in docs/formats.md. None: a temporary
        folder, removed with the Triangulation; tiles that were read stay good.
    overwrite
        Replace an earlier result in `folder`. Otherwise that is an error.
    resume
        Of files: go on with the unfinished run of the same job in `folder`, or start one; and when it is interrupted,
        leave in `folder` what there is of it.
    threads
        None: all processors this process may use.
    memory
        Bytes, or "800M", "4G" (2^20, 2^30). None: 70 % of what is free.
    crop
        (xmin, ymin, xmax, ymax), or in 3D (xmin, ymin, zmin, xmax, ymax, zmax): points outside are left out.
    crs
        The coordinate system of all points, whatever files say: "EPSG:n", WKT, or a file with one. None: what they say.
    classes
        Of files: points of these LAS classes only, [2, 9].
    returns
        Of files: the "first", "last" or "single" return of each pulse only, or "all".
    without
        Of files: no points with one of these flags, ["withheld", "synthetic", "overlap", "key_point"].
    columns
        Of text and .npy files: what their columns are, in their order, whatever a header says: "x", "y", "z", the name of
        an attribute, or "_" to leave one out, ["p", "y", "x", "z"] or "p,y,x,z". (): what the files say.
    resolution
        Of COPC files: the octree levels down to the first whose points are at most so far apart. None: all.
    heights
        In 2D, of points with z: keep it as the attribute "z".
    keep
        In 2D, of points with equal x and y: the "first" is the vertex, the "last", the "lowest" or the "highest".
    attributes
        Of the points. From files: ["intensity", "classification"], or "all". Of an array: a dict or DataFrame of
        columns, {"mass": m}, with a value for each row, bool (kept as uint8), integers, float32 or float64; "z" of an
        n x 2 array are heights. They are copied. See Tile.attributes.
    store
        What the result holds: "cells"; "points", a tenth of the bytes, from which cells are made again when they are
        asked for; or "auto": points for clouds of more than 50 million.
    neighbors
        Keep the neighbours of cells: 33 bytes a tetrahedron on disk instead of 17.
    skip_invalid
        Leave points with NaN or infinite coordinates out. Otherwise they are an error.
    progress
        Called some ten times a second, in this thread, with a Progress. What it raises ends the job and comes out.
    recursive
        Take the files in subfolders of folders, too.
    input_list
        A text file that names more files, one a line; relative ones begin at its folder.

    Returns
    -------
    Triangulation

    Raises
    ------
    Error
        One of its subclasses, with a sentence. Nothing half-written is left.
    KeyboardInterrupt
        On Ctrl-C, within a moment, when called in the main thread. Nothing half-written is left.

    The GIL is released while the engine works. Warns with a UserWarning of what is doubtful in files.

    Examples
    --------
    >>> import numpy as np, tessera
    >>> t = tessera.triangulate(np.random.default_rng(1).random((1000, 3)), max_points_per_tile=300)
    >>> t.n_vertices, len(t) > 1
    (1000, True)
    >>> sum(len(tile.cells[~tile.ghost]) for tile in t) == t.n_cells
    True
    """
    values = dict(attributes.items()) if hasattr(attributes, "items") else None
    options = job_options(dim, max_points_per_tile=max_points_per_tile, folder=folder, overwrite=overwrite,
                          threads=threads, memory=memory, attributes=() if values is not None else attributes, neighbors=neighbors,
                          skip_invalid=skip_invalid, recursive=recursive, tiles=tiles, partition=partition, crop=crop,
                          classes=classes, returns=returns, without=without, resolution=resolution, crs=crs,
                          heights=heights, input_list=input_list, resume=resume, columns=columns, keep=keep, store=store)
    if progress is not None and not callable(progress):
        raise UsageError("progress must be callable")
    report = None if progress is None else lambda *figures: progress(Progress(*figures))

    files = file_names(source, input_list)
    if files is not None:
        if values is not None:
            raise UsageError('attributes of files are names, as ["intensity"]: columns are of arrays')
        return Triangulation(_tessera.triangulate_files(files, options, report, warn))
    points = point_array(source)
    if dim == 3 and points.shape[1] == 2:
        raise UsageError("dim is 3, but points have 2 columns: x and y alone are triangulated in 2D")
    options.dimension(dim or points.shape[1])
    if classes:
        raise UsageError("classes are of files: choose rows of your array")
    if columns:
        raise UsageError("columns are of files: choose and order those of your array")
    if values is None and attributes:
        raise UsageError('attributes of an array are columns, as {"mass": values}: names are of files')
    if not values and dim in (None, points.shape[1]):
        return Triangulation(_tessera.triangulate_points(points, options, report, warn))
    rows = point_records(points, values or {})
    options.attributes([name for name in values or {} if name != "z"])
    return Triangulation(_tessera.triangulate_records(rows, columns_of(rows), options, report, warn))


def info(source: Path | typing.Sequence[Path] = (), dim: int | None = None, **options: typing.Any) -> dict[str, typing.Any]:
    """What `tessera info --json` says: of files, what is in them and what triangulating them would take; of a result
    folder, what it is. Reads no more than headers and a sample.

    Parameters
    ----------
    source
        Files, as of triangulate(), or one result folder.
    dim, options
        As of triangulate(): they say what would be triangulated, and how.
    """
    files = file_names(source, options.get("input_list"))
    if files is None:
        raise UsageError("info() is of files: it takes a path, a pattern, or a list of them")
    return json.loads(_tessera.describe(files, job_options(dim, **options)))


def warn(sentence: str) -> None:
    """Where triangulate() was called."""
    warnings.warn(sentence, stacklevel=3)
