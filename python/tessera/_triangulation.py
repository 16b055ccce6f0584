"""Triangulations of any size, in tiles."""
from __future__ import annotations

import os
import pathlib
import re
import typing
import warnings

import numpy as np
import numpy.typing as npt

from . import _tessera
from ._arrays import exact_float64
from ._errors import UsageError
from ._progress import Progress

Path = typing.Union[str, "os.PathLike[str]"]


class Tile:
    """One tile: its n points, its own and those of other tiles that its cells need, and its m cells.

    The arrays are read-only views of the tile's memory, not copies. Each of them keeps that memory alive, also when the
    Tile is gone. `cells[~ghost]`, over all tiles, are the triangulation, each cell once.
    """

    def __init__(self, tile: _tessera.Tile):
        self._tile = tile

    @property
    def id(self) -> int:
        """The tile's number, unique in the triangulation."""
        return self._tile.id

    @property
    def dim(self) -> int:
        """2 or 3."""
        return self._tile.dimension

    @property
    def points(self) -> npt.NDArray[np.float64]:
        """Coordinates, n x dim, in input units, bit for bit those of the input."""
        return self._tile.points

    @property
    def ids(self) -> npt.NDArray[np.int64]:
        """The rank of each point in the whole input, counted from 0 over all files: n. Of arrays: the row."""
        return self._tile.ids

    @property
    def foreign(self) -> npt.NDArray[np.bool_]:
        """True for points that another tile owns: n. `points[~foreign]`, over all tiles, are the vertices, each once."""
        return self._tile.foreign

    @property
    def cells(self) -> npt.NDArray[np.int32]:
        """Triangles or tetrahedra as rows of `points`: m x (dim+1). All positively oriented: det(p1-p0, ...) > 0."""
        return self._tile.cells

    @property
    def ghost(self) -> npt.NDArray[np.bool_]:
        """True for cells that are here as a copy and belong to another tile: m."""
        return self._tile.ghost

    @property
    def neighbors(self) -> npt.NDArray[np.int32] | None:
        """The cell of this tile across the facet opposite each vertex: m x (dim+1). None when they were not kept.

        -1 is outside the convex hull, -2 a cell that only other tiles hold. When no vertex of the facet is the tile's
        own, -2 may also be outside.
        """
        neighbors = self._tile.neighbors
        return neighbors if len(neighbors) == len(self._tile.cells) else None

    @property
    def attributes(self) -> dict[str, np.ndarray]:
        """The attributes of the points that triangulate() was asked for, by name: n values each, of their file's type."""
        return self._tile.attributes

    def __repr__(self) -> str:
        return f"<tessera.Tile {self.id}: {len(self.points)} points, {len(self.cells)} {cell_word(self.dim)}>"


class Triangulation:
    """A finished triangulation on disk: a sequence of tiles, each read when it is asked for.

    `len(t)` is the number of tiles with points, `t[i]` reads one, `for tile in t` one after the other: no more than one
    or two are in memory. From triangulate() or open().
    """

    def __init__(self, triangulation: _tessera.Triangulation):
        self._triangulation = triangulation

    @property
    def dim(self) -> int:
        """2 or 3."""
        return self._triangulation.dimension

    @property
    def n_points(self) -> int:
        """Points read, n_duplicates of them included."""
        return self._triangulation.points_read

    @property
    def n_vertices(self) -> int:
        """Different points: the vertices."""
        return self._triangulation.vertices

    @property
    def n_duplicates(self) -> int:
        """Points that equal one read before, which is the vertex."""
        return self._triangulation.duplicates

    @property
    def n_cells(self) -> int:
        """Triangles (2D) or tetrahedra (3D), each counted once."""
        return self._triangulation.cells

    @property
    def digest(self) -> str:
        """32 hexadecimal digits, equal for two results if and only if they are the same triangulation of the same points
        in the same order, whatever their tiles. "" for results of software that made none."""
        return self._triangulation.digest

    @property
    def folder(self) -> pathlib.Path:
        """The result folder. A temporary one goes with this object; tiles that were read stay good."""
        return self._triangulation.folder

    @property
    def crs(self) -> str:
        """The coordinate reference system as the input files say it; "" when they say none."""
        return self._triangulation.crs

    def __len__(self) -> int:
        return self._triangulation.tiles

    def __getitem__(self, index: int) -> Tile:
        """Reads tile `index`, from -len(t) to len(t)-1, from disk. The GIL is released."""
        size = len(self)
        if not -size <= index < size:
            raise IndexError(f"no tile {index}: there are {size}")
        return Tile(self._triangulation.tile(index % size))

    def __iter__(self) -> typing.Iterator[Tile]:
        for index in range(len(self)):
            yield self[index]

    def simplices(self) -> npt.NDArray[np.int64]:
        """All cells in one array, n_cells x (dim+1) ranks of points in the input (rows, if the input was an array).

        Takes 8 (dim+1) bytes a cell, some 200 bytes a point in 3D, besides one tile at a time.
        """
        cells = np.empty((self.n_cells, self.dim + 1), np.int64)
        end = 0
        for tile in self:
            main = tile.cells[~tile.ghost]
            cells[end : end + len(main)] = tile.ids[main]
            end += len(main)
        return cells

    def points(self) -> npt.NDArray[np.float64]:
        """The vertices' coordinates by rank in the input, n_points x dim, to go with simplices().

        NaN in the rows of duplicates: no simplex has them. Takes 8 dim bytes a point, besides one tile at a time.
        """
        points = np.full((self.n_points, self.dim), np.nan)
        for tile in self:
            own = ~tile.foreign
            points[tile.ids[own]] = tile.points[own]
        return points

    def export(self, target: Path, format: str | None = None, heights: bool = True, overwrite: bool = False) -> None:
        """Writes the cells, each once, for other programs: t.export("mesh.ply").

        Parameters
        ----------
        target
            With an ending, one file; else a folder with a file for each tile ("npy": a folder of arrays).
        format
            "ply", "vtu", "off", "obj", "mesh", "msh", "npy", "geojson", "gpkg" or "csv" (docs/formats.md). None: as the
            ending of `target` says.
        heights
            2D: the attribute "z", if the points have one, becomes the third coordinate.
        overwrite
            Replace files of the same names. Otherwise that is an error.

        Warns with a UserWarning of what the format could not keep. The GIL is released; Ctrl-C leaves nothing half-written.
        """
        note = self._triangulation.export_to(os.fspath(target), format or "", heights, overwrite)
        if note:
            warnings.warn(note, stacklevel=2)

    def __repr__(self) -> str:
        return (f"<tessera.Triangulation of {self.n_points} points: {self.n_cells} {cell_word(self.dim)} "
                f"in {len(self)} tiles, {self.folder}>")


def triangulate(source: npt.ArrayLike | Path | typing.Sequence[Path], dim: int | None = None,
                max_points_per_tile: int | None = None, folder: Path | None = None, overwrite: bool = False,
                threads: int | None = None, memory: int | str | None = None, attributes: typing.Iterable[str] = (),
                neighbors: bool = True, skip_invalid: bool = False,
                progress: typing.Callable[[Progress], object] | None = None, recursive: bool = False) -> Triangulation:
    """The exact Delaunay triangulation of points of any number, in tiles, on several threads, within given memory.

    Parameters
    ----------
    source
        Points: an array, n x 2 or n x 3, of any integer or float type and any strides. It is used in place when it is
        float64 and C-contiguous, and must then not change meanwhile; otherwise it is converted. Numbers that float64
        would round (int64 beyond 2^53, longdouble) are refused: the result is exact for the points given.
        Or files: a path, a folder, a pattern ("block/*.laz"), or a list of them, which together make one cloud.
    dim
        2 or 3. None: the number of columns; for files 3, or 2 when they hold x and y alone. Files with z are
        triangulated by x and y with dim=2.
    max_points_per_tile
        A tile is worked on in memory, at about 700 bytes a point. None: chosen from memory and threads.
    folder
        The result folder, which stays, for tessera.open() and the programs in docs/formats.md. None: a temporary
        folder, removed with the Triangulation; tiles that were read stay good.
    overwrite
        Replace an earlier result in `folder`. Otherwise that is an error.
    threads
        None: all processors this process may use.
    memory
        Bytes, or "800M", "4G" (2^20, 2^30). None: 70 % of what is free.
    attributes
        Of the points, from files: ["intensity", "classification"], or "all". See Tile.attributes.
    neighbors
        Keep the neighbours of cells: 33 bytes a tetrahedron on disk instead of 17.
    skip_invalid
        Leave points with NaN or infinite coordinates out. Otherwise they are an error.
    progress
        Called some ten times a second, in this thread, with a Progress. What it raises ends the job and comes out.
    recursive
        Take the files in subfolders of folders, too.

    Returns
    -------
    Triangulation

    Raises
    ------
    Error
        One of its subclasses, with a sentence. Nothing half-written is left.
    KeyboardInterrupt
        On Ctrl-C, within a moment, when called in the main thread. Nothing half-written is left.

    The GIL is released while the engine works.

    Examples
    --------
    >>> import numpy as np, tessera
    >>> t = tessera.triangulate(np.random.default_rng(1).random((1000, 3)), max_points_per_tile=300)
    >>> t.n_vertices, len(t) > 1
    (1000, True)
    >>> sum(len(tile.cells[~tile.ghost]) for tile in t) == t.n_cells
    True
    """
    options = _tessera.Options()
    if folder is not None:
        options.folder = os.fspath(folder)
        if not os.fspath(folder):
            raise UsageError("folder is empty: None makes a temporary one")
    options.overwrite = overwrite
    options.max_points_per_tile = positive(max_points_per_tile, "max_points_per_tile", 2**63)
    options.threads = positive(threads, "threads", 1025)
    options.memory_bytes = memory_bytes(memory)
    options.neighbors = neighbors
    options.skip_invalid = skip_invalid
    options.recursive = recursive
    options.attributes = [attributes] if isinstance(attributes, str) else list(attributes)
    if dim not in (None, 2, 3):
        raise UsageError(f"dim is {dim!r}: tessera triangulates in 2 or 3 dimensions")
    if progress is not None and not callable(progress):
        raise UsageError("progress must be callable")
    report = None if progress is None else lambda *figures: progress(Progress(*figures))

    files = file_names(source)
    if files is not None:
        options.dimension = dim or 0
        return Triangulation(_tessera.triangulate_files(files, options, report))
    if options.attributes:
        raise UsageError("attributes come from files: index your own arrays with Tile.ids")
    points = point_array(source)
    if dim not in (None, points.shape[1]):
        raise UsageError(f"dim is {dim}, but points have {points.shape[1]} columns: pass points[:, :{dim}]")
    options.dimension = points.shape[1]
    return Triangulation(_tessera.triangulate_points(points, options, report))


def open(folder: Path) -> Triangulation:
    """The triangulation in a result folder, of triangulate(folder=...) or of the command `tessera triangulate`.

    Raises IoError when there is none, CorruptError when it is damaged.
    """
    return Triangulation(_tessera.Triangulation.open(os.fspath(folder)))


def point_array(points: npt.ArrayLike) -> npt.NDArray[np.float64]:
    """`points` as exact_float64() gives them, n x 2 or n x 3; UsageError otherwise."""
    array = exact_float64(points, "points")
    if array.ndim != 2 or array.shape[1] not in (2, 3):
        raise UsageError(f"points have the shape {array.shape}: it must be (n, 2) or (n, 3)")
    return array


def file_names(source: typing.Any) -> list[bytes] | None:
    """The files that `source` names, as the system writes them; None when it is no path and no list of them."""
    if isinstance(source, (str, os.PathLike)):
        source = [source]
    if isinstance(source, (list, tuple)) and source and all(isinstance(path, (str, os.PathLike)) for path in source):
        return [os.fsencode(path) for path in source]
    return None


def positive(value: int | None, name: str, end: int) -> int:
    """`value`, from 1 to under `end`; 0 for None, which is how the library is told to choose."""
    if value is None:
        return 0
    if not isinstance(value, (int, np.integer)) or not 1 <= value < end:
        raise UsageError(f"{name} is {value!r}: it must be None or an integer from 1 to {end - 1}")
    return int(value)


def memory_bytes(memory: int | str | None) -> int:
    """Bytes, from what triangulate() takes as `memory`."""
    if not isinstance(memory, str):
        return positive(memory, "memory", 2**63)
    parts = re.fullmatch(r"(\d+(?:\.\d+)?)([KMGT]?)", memory)
    if not parts:
        raise UsageError(f"memory is {memory!r}: it must be a number of bytes, or like '800M' or '4G'")
    return positive(int(float(parts[1]) * 1024 ** " KMGT".index(parts[2] or " ")), "memory", 2**63)


def cell_word(dim: int) -> str:
    return "triangles" if dim == 2 else "tetrahedra"
