"""triangulate(), which makes triangulations in tiles, and info()."""
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
                keep: str = "first", store: str = "auto", scans: typing.Iterable[int] = (),
                periodic: float | typing.Sequence[float] | str | None = None, periodic_snap: str = "yes",
                particles: typing.Iterable[int | str] = (), hdu: int | str | None = None,
                cosmology: typing.Sequence[float] | None = None,
                endpoint: str | None = None, profile: str | None = None, anonymous: bool = False,
                requester_pays: bool = False) -> Triangulation:
    """Computes the exact Delaunay triangulation of any number of points: in tiles, on threads, within a memory limit.

    Parameters
    ----------
    source
        Points: an array or a DataFrame, n x 2 or n x 3, of any numeric type and strides. A C-contiguous float64 array
        is used in place, and must not change during the call; others are converted. Numbers that float64 would round
        (int64 beyond 2^53, longdouble) are refused, because the result is exact for the points that you give.
        Or files: a path, a folder, a pattern ("block/*.laz"), an address ("https://host/block.copc.laz",
        "s3://bucket/block/"), or a list of these, which together make one cloud.
    dim
        2 or 3. None: the number of columns; for files 3, or 2 if they have x and y alone. With dim=2 arrays and files
        with z are triangulated by x and y; see `heights`.
    max_points_per_tile
        The size of tiles. A tile needs about 700 bytes a point of memory. None: chosen from memory and threads.
    tiles
        The number of tiles, in place of their size.
    partition
        How space is cut into tiles: "kdtree", "grid", "octree" or "random".
    folder
        The result folder, which stays, for tessera.open() and the programs in docs/formats.md. None: a temporary
        folder, which is removed with the Triangulation. Tiles that were read before can still be used.
    overwrite
        Replaces an earlier result in `folder`. Otherwise such a result is an error.
    resume
        For files: continues the unfinished run of the same job in `folder`, or starts one. If this run is interrupted,
        it stays in `folder` and can be continued.
    threads
        The number of threads. None: all processors that this process may use.
    memory
        Bytes, or "800M", "4G" (M is 2^20, G is 2^30). None: 70 % of the free memory.
    crop
        Leaves out points outside the closed box (xmin, ymin, xmax, ymax), or in 3D also (xmin, ymin, zmin, xmax, ymax,
        zmax).
    crs
        The coordinate system of all points, in place of what the files say: "EPSG:n", WKT, or a file with one of these.
        None: what the files say.
    periodic
        The cloud is periodic: its box begins at 0, and opposite sides are the same place. One period for all axes, or
        one for each axis, 0 for an axis without a period; or "file": what the snapshot says. See Tile.offsets.
    periodic_snap
        "yes": rounds coordinates and periods with too many binary digits for exact images, with a warning. "no": such
        numbers are errors.
    classes
        For files: takes only points of these LAS classes, for example [2, 9].
    scans
        For E57 and PTX files: takes only points of these scans, which each file numbers from 0.
    particles
        For snapshots: takes only particles of these types, for example ["gas", "stars"]: "gas", "dark-matter",
        "disk", "bulge", "stars", "black-holes", "neutrinos", or numbers from 0 to 6.
    returns
        For files: takes only the "first", "last" or "single" return of each laser pulse, or "all".
    without
        For files: leaves out points with one of these flags, ["withheld", "synthetic", "overlap", "key_point"].
    columns
        For text and .npy files: the names of the columns in order, in place of those in the files: "x", "y", "z", the
        name of an attribute, or "_" for a column to leave out. ["p", "y", "x", "z"] or "p,y,x,z". For FITS tables:
        which columns are coordinates, "x=XPOS,y=YPOS,z=ZPOS", "position=POS", or "ra=RA,dec=DEC" with "redshift=Z" or
        "distance=D". (): what the files say.
    hdu
        For FITS: the number or the name of the table. None: the first one.
    cosmology
        For FITS: turns redshifts into comoving distances, in a flat universe: H0 in km/s/Mpc, and the density of
        matter, for example (70, 0.3). None: redshifts are refused.
    resolution
        For COPC files: reads the octree levels down to the first whose points are at most so far apart. None: all.
    heights
        In 2D, for points with z: keeps z as the attribute "z".
    keep
        In 2D: which of several points with equal x and y is the vertex: the "first", "last", "lowest" or "highest".
    attributes
        The attributes of the points to keep. For files: their names, ["intensity", "classification"], or "all". For an
        array: a dict or DataFrame of columns, {"mass": m}, with a value for each row. The type is bool (kept as uint8),
        an integer, float32 or float64. For an n x 2 array "z" is the height. Values are copied. See Tile.attributes.
    store
        What the result stores: "cells"; "points", which takes a tenth of the bytes, and cells are made again when they
        are read; or "auto": points for clouds of more than 50 million points, else cells.
    neighbors
        Stores the neighbours of cells: 33 bytes a tetrahedron on disk instead of 17.
    skip_invalid
        Leaves out points with NaN or infinite coordinates. Otherwise such a point is an error.
    progress
        A function that is called some ten times a second, in this thread, with a Progress. If it raises an exception,
        the job ends and triangulate() raises the same exception.
    recursive
        Takes the files in subfolders of folders, too.
    input_list
        A text file that names more files, one a line. Relative names are relative to the folder of this file.
    endpoint, profile
        For s3://: the address of another server than Amazon's, and the profile in ~/.aws. None: as the environment says.
    anonymous, requester_pays
        For s3://: does not sign requests, for open data; and agrees to pay for the transfer.

    Returns
    -------
    Triangulation

    Raises
    ------
    Error
        One of its subclasses. The message is a sentence. Nothing half-written is left.
    KeyboardInterrupt
        On Ctrl-C, within a moment, if called in the main thread. Nothing half-written is left, except with `resume`.

    The GIL is released while the library works. Warns with a UserWarning of anything doubtful in the files.

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
                          heights=heights, input_list=input_list, resume=resume, columns=columns, keep=keep, store=store,
                          scans=scans, particles=particles, hdu=hdu, cosmology=cosmology, periodic=periodic,
                          periodic_snap=periodic_snap, endpoint=endpoint, profile=profile,
                          anonymous=anonymous, requester_pays=requester_pays)
    if progress is not None and not callable(progress):
        raise UsageError("progress must be callable")
    report = None if progress is None else lambda *figures: progress(Progress(*figures))

    files = file_names(source, input_list)
    if files is not None:
        if values is not None:
            raise UsageError('attributes of files must be names, for example ["intensity"]; columns of values are for arrays')
        return Triangulation(_tessera.triangulate_files(files, options, report, warn))
    points = point_array(source)
    if dim == 3 and points.shape[1] == 2:
        raise UsageError("dim is 3, but points have 2 columns: x and y alone are triangulated in 2D")
    options.dimension(dim or points.shape[1])
    if classes:
        raise UsageError("classes are for files: choose rows of your array instead")
    if scans:
        raise UsageError("scans are for files: choose rows of your array instead")
    if particles or hdu is not None or cosmology is not None:
        raise UsageError("particles, hdu and cosmology are for files")
    if columns:
        raise UsageError("columns are for files: choose and order the columns of your array instead")
    if values is None and attributes:
        raise UsageError('attributes of an array must be columns of values, for example {"mass": values}; names are for files')
    if not values and dim in (None, points.shape[1]):
        return Triangulation(_tessera.triangulate_points(points, options, report, warn))
    rows = point_records(points, values or {})
    options.attributes([name for name in values or {} if name != "z"])
    return Triangulation(_tessera.triangulate_records(rows, columns_of(rows), options, report, warn))


def info(source: Path | typing.Sequence[Path] = (), dim: int | None = None, **options: typing.Any) -> dict[str, typing.Any]:
    """Returns the output of `tessera info --json` as a dict. Reads only headers and a sample of the points.

    For files it says what is in them, and what triangulating them would take. For a result folder it says what the
    result is.

    Parameters
    ----------
    source
        Files, as for triangulate(), or one result folder.
    dim, options
        As for triangulate(): they say what would be triangulated, and how.
    """
    files = file_names(source, options.get("input_list"))
    if files is None:
        raise UsageError("info() is for files: it takes a path, a pattern, or a list of them")
    return json.loads(_tessera.describe(files, job_options(dim, **options)))


def warn(sentence: str) -> None:
    """Warns with a UserWarning that names the line that called triangulate() or region()."""
    warnings.warn(sentence, stacklevel=3)
