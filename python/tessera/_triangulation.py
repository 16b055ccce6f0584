"""Triangulations of any size, in tiles."""
from __future__ import annotations

import collections.abc
import json
import operator
import os
import pathlib
import typing
import warnings

import numpy as np
import numpy.typing as npt

from . import _tessera
from ._errors import UsageError
from ._options import Path, memory_bytes
from ._questions import Answers
from ._surfaces import Surfaces
from ._tile import Tile, cell_word


class Proof(typing.NamedTuple):
    """What was counted and passed when a result was proved."""

    cells: int
    facets: int
    hull_facets: int
    vertices: int
    checks: tuple[str, ...]
    """A line for each check."""


class Measures(typing.NamedTuple):
    """What was measured of a triangulation."""

    total: float
    """Over all cells, rounded once: the same for any tiles and threads."""
    unit: str
    """"metre^3"; "" when nobody knows."""
    made: bool
    """False when the columns were there already."""


class Columns(collections.abc.Mapping):
    """What was computed of a triangulation and stored with it, by name: t.columns["volume"] reads the values of all tiles.

    Of cells one value for each row of simplices(); of vertices one for each row of points(), NaN (or 0, if they are whole
    numbers) in the rows of duplicates.
    """

    def __init__(self, triangulation: Triangulation):
        self._of = triangulation
        self.info: dict[str, dict[str, typing.Any]] = {one["name"]: one for one in triangulation._triangulation.columns()}
        """By name: what it is of ("cells" or "vertices"), type, unit, and the version of the result it came with."""

    def __len__(self) -> int:
        return len(self.info)

    def __iter__(self) -> typing.Iterator[str]:
        return iter(self.info)

    def __getitem__(self, name: str) -> np.ndarray:
        column = self.info[name]
        dtype = np.dtype(column["type"])
        if column["of"] == "cells":
            values, end = np.empty(self._of.n_cells, dtype), 0
            for tile in self._of:
                main = tile.cell_columns[name][~tile.ghost]
                values[end : end + len(main)] = main
                end += len(main)
            return values
        values = np.full(self._of.n_points, np.nan if dtype.kind == "f" else 0, dtype)
        for tile in self._of:
            own = ~tile.foreign
            values[tile.ids[own]] = tile.attributes[name][own]
        return values

    def __repr__(self) -> str:
        text = ", ".join(f"{name} of {one['of']}" for name, one in self.info.items())
        return f"<tessera.Columns: {text or 'none'}>"


class Tiles(collections.abc.Sequence):
    """Some tiles of a triangulation, t[2:5]: a sequence like the triangulation itself, each read when it is asked for."""

    def __init__(self, triangulation: Triangulation, indices: range):
        self._of = triangulation
        self._indices = indices

    def __len__(self) -> int:
        return len(self._indices)

    def __getitem__(self, index):
        if isinstance(index, slice):
            return Tiles(self._of, self._indices[index])
        at, size = operator.index(index), len(self)
        if not -size <= at < size:
            raise IndexError(f"no tile {at}: there are {size}")
        return Tile(self._of._triangulation.tile(self._indices[at]))

    def __repr__(self) -> str:
        return f"<tessera.Tiles: {len(self)} of {self._of!r}>"


class Triangulation(Answers, Surfaces):
    """A finished triangulation on disk: a sequence of tiles, each read when it is asked for.

    `len(t)` is the number of tiles with points, `t[i]` reads one, `for tile in t` one after the other: no more than one
    or two are in memory. From triangulate() or open().
    """

    def __init__(self, triangulation: _tessera.Triangulation):
        self._held: _tessera.Triangulation | None = triangulation

    @property
    def _triangulation(self) -> _tessera.Triangulation:
        if self._held is None:
            raise UsageError("the triangulation is closed")
        return self._held

    def close(self) -> None:
        """Lets go of the result, as the end of `with` does: a temporary folder is removed; tiles that were read stay good."""
        self._held = self._questions = None

    def __enter__(self) -> Triangulation:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def __reduce__(self) -> tuple[typing.Any, ...]:
        """Pickled is the name of the folder: of a temporary one, good as long as this object."""
        return open, (os.path.abspath(self.folder),)

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
        """Points that equal another one, which is the vertex: the first, or what `keep` has chosen."""
        return self._triangulation.duplicates

    @property
    def n_duplicates_at_other_heights(self) -> int | None:
        """In 2D those of them whose height is not that of the vertex; None when heights are not known."""
        return self._triangulation.duplicates_at_other_heights

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

    @typing.overload
    def __getitem__(self, index: int) -> Tile: ...

    @typing.overload
    def __getitem__(self, index: slice) -> Tiles: ...

    def __getitem__(self, index):
        """Reads tile `index`, from -len(t) to len(t)-1, from disk; the GIL is released. Of a slice: Tiles."""
        return Tiles(self, range(len(self)))[index]

    def __iter__(self) -> typing.Iterator[Tile]:
        return iter(Tiles(self, range(len(self))))

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

    def export(self, target: Path, format: str | None = None, heights: bool = True, overwrite: bool = False,
               index: bool = True, max_edge: float | None = None, local: bool = False) -> None:
        """Writes the cells, each once, for other programs: t.export("mesh.ply").

        Parameters
        ----------
        target
            With an ending, one file; else a folder with a file for each tile ("npy": a folder of arrays).
        format
            "ply", "vtu", "off", "obj", "mesh", "msh", "mshb", "dxf", "landxml", "npy", "geojson", "gpkg" or "csv"
            (docs/formats.md). None: as the ending of `target` says.
        heights
            2D: the attribute "z", if the points have one, becomes the third coordinate.
        overwrite
            Replace files of the same names. Otherwise that is an error.
        index
            GeoPackage: write a spatial index. Without it writing is four times as fast, but maps are slow.
        max_edge
            Leave out cells with an edge longer than this, in units of the coordinates (2D: in the plane), and vertices that
            no cell has then.
        local
            "ply", "obj" and "off": coordinates count from the whole-numbered corner of the box, for programs that keep
            floats of 32 bits. The file says in a comment where the corner is.

        Warns with a UserWarning of what the format could not keep. The GIL is released; Ctrl-C leaves nothing half-written.
        """
        request = _tessera.ExportRequest()
        request.format(format or "")
        request.heights(heights)
        request.overwrite(overwrite)
        request.index(index)
        request.local(local)
        if max_edge is not None:
            request.max_edge(max_edge)
        note = self._triangulation.export_to(os.fspath(target), request)
        if note:
            warnings.warn(note, stacklevel=2)

    def verify(self, memory: int | str | None = None, scratch: Path | None = None, against_cgal: bool = False) -> Proof:
        """Proves, from the files alone and within memory, that they hold the Delaunay triangulation of their points.

        Parameters
        ----------
        memory
            For facets before they are sorted on disk: bytes, or "800M", "4G". None: 70 % of what is free.
        scratch
            Where to sort them. None: the system's temporary folder.
        against_cgal
            Also build the whole triangulation with CGAL in memory, and compare every cell.

        Raises NotDelaunayError with the first violation, CorruptError for damaged files, KeyboardInterrupt on Ctrl-C.
        """
        request = _tessera.VerifyRequest()
        request.memory_bytes(memory_bytes(memory))
        request.scratch(os.fspath(scratch or ""))
        request.against_cgal(against_cgal)
        proof = self._triangulation.verify(request)
        return Proof(proof.cells, proof.facets, proof.hull_facets, proof.vertices, tuple(proof.checks))

    @property
    def columns(self) -> Columns:
        """What was computed of the triangulation so far, and stored with it: t.columns["volume"]. See measure()."""
        return Columns(self)

    def measure(self, volume: bool = False, memory: int | str | None = None, threads: int = 0) -> Measures:
        """Computes columns and adds them to the result folder, as a new version of the result, which this object then is.

        Parameters
        ----------
        volume
            The volume of each cell, as t.columns["volume"], and of each vertex that of the cells around it, as
            t.columns["star_volume"]. In 2D they are areas in the plane, "area" and "star_area".
        memory
            For tiles: bytes, or "800M", "4G". None: 70 % of what is free.
        threads
            0: all processors.

        Who reads the result meanwhile is not disturbed. Ctrl-C leaves the result as it was. Columns that are there already
        are not computed again. Warns with a UserWarning of values that need a word.
        """
        request = _tessera.MeasureRequest()
        request.volume(volume)
        request.memory_bytes(memory_bytes(memory))
        request.threads(threads)
        total, unit, made, note = self._triangulation.measure(request)
        self._questions = None
        if note:
            warnings.warn(note, stacklevel=2)
        return Measures(total, unit, made)

    def info(self) -> dict[str, typing.Any]:
        """What `tessera info --json` says of the result: inputs, box, CRS, tiles, digest, seconds, ..."""
        return json.loads(self._triangulation.describe())

    def __repr__(self) -> str:
        if self._held is None:
            return "<tessera.Triangulation, closed>"
        return (f"<tessera.Triangulation of {self.n_points} points: {self.n_cells} {cell_word(self.dim)} "
                f"in {len(self)} {'tile' if len(self) == 1 else 'tiles'}, {self.folder}>")


def open(folder: Path) -> Triangulation:
    """The triangulation in a result folder, of triangulate(folder=...) or of the command `tessera triangulate`.

    Raises IoError when there is none, CorruptError when it is damaged.
    """
    return Triangulation(_tessera.Triangulation.open(os.fspath(folder)))
