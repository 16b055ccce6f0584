"""The class Triangulation: a triangulation of any size, in tiles on disk."""
from __future__ import annotations

import collections.abc
import json
import operator
import os
import pathlib
import re
import typing
import warnings

import numpy as np
import numpy.typing as npt

from . import _arrow_c, _tessera
from ._alpha import AlphaShapes
from ._errors import UsageError
from ._html import table
from ._options import Path, index, memory_bytes
from ._questions import Answers
from ._densities import Densities
from ._surfaces import Surfaces
from ._tile import Tile, cell_word
from ._update import Changes
from ._volumes import SurfaceVolumes
from ._view import View, view_of
from ._voronoi import VoronoiCells


class Proof(typing.NamedTuple):
    """The outcome of a proof: what was counted, and which checks the result has passed."""

    cells: int
    facets: int
    hull_facets: int
    vertices: int
    checks: tuple[str, ...]
    """One line for each check."""


class Measures(typing.NamedTuple):
    """The outcome of Triangulation.measure()."""

    total: float
    """The sum of the volumes of all cells, rounded once, if volumes were asked for; else 0. It does not depend on tiles or
    threads."""
    unit: str
    """For example "metre^3"; "" if the unit is not known."""
    made: bool
    """False if the result had the columns already."""


class Columns(typing.Mapping[str, "npt.NDArray[typing.Any]"]):
    """The columns of a triangulation, by name. A column is an array that was computed and stored with the result.

    t.columns["volume"] reads the values from all tiles. A column of cells has one value for each row of simplices(). A
    column of vertices has one value for each row of points(); the rows of duplicates are NaN (0 in columns of
    integers).
    """

    def __init__(self, triangulation: Triangulation):
        self._of = triangulation
        self.info: dict[str, dict[str, typing.Any]] = {one["name"]: one for one in triangulation._triangulation.columns()}
        """For each name a dict: "of" ("cells" or "vertices"), "type", "unit", and the "version" of the result that
        brought the column."""

    def __len__(self) -> int:
        return len(self.info)

    def __iter__(self) -> typing.Iterator[str]:
        return iter(self.info)

    def __getitem__(self, name: str) -> npt.NDArray[typing.Any]:
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
    """Some tiles of a triangulation, as t[2:5] returns them: a sequence that reads a tile each time you index it."""

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
            raise IndexError(f"there is no tile {at}: there are {size} tiles")
        return Tile(self._of._triangulation.tile(self._indices[at]))

    def __repr__(self) -> str:
        return f"<tessera.Tiles: {len(self)} of {self._of!r}>"


class Triangulation(Answers, Surfaces, Densities, SurfaceVolumes, AlphaShapes, VoronoiCells, Changes):
    """A finished triangulation on disk, from triangulate(), region() or open(): a sequence of tiles.

    `len(t)` is the number of tiles with points. `t[i]` reads a tile from disk. `for tile in t` reads one tile after the
    other, so only one or two tiles are in memory at a time.
    """

    def __init__(self, triangulation: _tessera.Triangulation):
        self._held: _tessera.Triangulation | None = triangulation

    @property
    def _triangulation(self) -> _tessera.Triangulation:
        if self._held is None:
            raise UsageError("the triangulation is closed")
        return self._held

    def close(self) -> None:
        """Closes the triangulation, as the end of `with` does. A temporary folder is removed. Tiles that were read
        before can still be used."""
        self._held = self._questions = None

    def __enter__(self) -> Triangulation:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def __reduce__(self) -> tuple[typing.Any, ...]:
        """Pickles the name of the folder. A temporary folder exists only as long as this object."""
        return open, (os.path.abspath(self.folder),)

    @property
    def dim(self) -> int:
        """The dimension: 2 or 3."""
        return self._triangulation.dimension

    @property
    def n_points(self) -> int:
        """The number of points that were read, duplicates included."""
        return self._triangulation.points_read

    @property
    def n_vertices(self) -> int:
        """The number of vertices, which are the distinct points."""
        return self._triangulation.vertices

    @property
    def n_duplicates(self) -> int:
        """The number of points that are no vertices because they equal another point. `keep` says which of equal points
        is the vertex; by default the first."""
        return self._triangulation.duplicates

    @property
    def n_duplicates_at_other_heights(self) -> int | None:
        """In 2D the number of duplicates whose height is not that of the vertex; None if heights are not known."""
        return self._triangulation.duplicates_at_other_heights

    @property
    def n_cells(self) -> int:
        """The number of triangles (2D) or tetrahedra (3D), each counted once."""
        return self._triangulation.cells

    @property
    def digest(self) -> str:
        """32 hexadecimal digits. Two results have the same digest if and only if they are the same triangulation of the
        same points in the same order, whatever their tiles are. "" for results of software that made no digest."""
        return self._triangulation.digest

    @property
    def folder(self) -> pathlib.Path:
        """The result folder. A temporary folder is removed with this object; tiles already read can still be used."""
        return self._triangulation.folder

    @property
    def crs(self) -> str:
        """The coordinate reference system, from the input files or the argument `crs`; "" if it is not known."""
        return self._triangulation.crs

    @property
    def period(self) -> tuple[float, ...]:
        """The period along each axis, 0 along axes without one."""
        return tuple(self._triangulation.period[: self.dim])

    def __len__(self) -> int:
        return self._triangulation.tiles

    @typing.overload
    def __getitem__(self, index: int) -> Tile: ...

    @typing.overload
    def __getitem__(self, index: slice) -> Tiles: ...

    def __getitem__(self, index):
        """Reads tile `index`, from -len(t) to len(t)-1, from disk; the GIL is released. For a slice returns Tiles."""
        return Tiles(self, range(len(self)))[index]

    def __iter__(self) -> typing.Iterator[Tile]:
        return iter(Tiles(self, range(len(self))))

    def simplices(self) -> npt.NDArray[np.int64]:
        """Returns all cells in one array: n_cells x (dim+1) ranks of points in the input (rows, if the input was an
        array).

        The array takes 8 (dim+1) bytes a cell, some 200 bytes a point in 3D. One tile is in memory at a time. Raises
        UsageError for a periodic triangulation, whose cells have images of points (Tile.offsets).
        """
        if any(self.period):
            raise UsageError("the corners of periodic cells are images of points: read the tiles, which have offsets")
        cells = np.empty((self.n_cells, self.dim + 1), np.int64)
        end = 0
        for tile in self:
            main = tile.cells[~tile.ghost]
            cells[end : end + len(main)] = tile.ids[main]
            end += len(main)
        return cells

    def points(self) -> npt.NDArray[np.float64]:
        """Returns the coordinates of the vertices by rank in the input, n_points x dim, for use with simplices().

        The rows of duplicates are NaN; no simplex has them. The array takes 8 dim bytes a point. One tile is in memory
        at a time.
        """
        points = np.full((self.n_points, self.dim), np.nan)
        for tile in self:
            own = ~tile.foreign
            points[tile.ids[own]] = tile.points[own]
        return points

    def export(self, target: Path, format: str | None = None, heights: bool = True, overwrite: bool = False,
               index: bool = True, max_edge: float | None = None, local: bool = False, max_radius: float | None = None,
               names: typing.Sequence[str] = ()) -> None:
        """Writes the cells, each once, for other programs: t.export("mesh.ply").

        Parameters
        ----------
        target
            A name with an ending is one file; a name without an ending is a folder with a file for each tile ("npy": a
            folder of arrays).
        format
            "ply", "vtu", "off", "obj", "stl", "glb", "mesh", "msh", "mshb", "dxf", "landxml", "npy", "geojson",
            "gpkg" or "csv", or of the points "h5", "fits", "table", "zobov", "zobov64" or "ndnet" (docs/formats.md). None: the format of the ending of `target`.
        heights
            2D: the attribute "z", if the points have it, becomes the third coordinate.
        overwrite
            Replaces existing files of the same names. Otherwise such files are an error.
        index
            GeoPackage: writes a spatial index. Writing is four times as fast without an index, but maps are slow.
        max_edge
            Leaves out cells with an edge longer than this, and vertices that then have no cell. In units of the
            coordinates (2D: in the plane).
        local
            "ply", "obj", "off" and "stl": writes coordinates relative to the lower corner of the box, rounded down to
            whole numbers, for programs that keep 32-bit floats. The file says in a comment where the corner is.
        max_radius
            Leaves out cells with a circumradius larger than this, like max_edge. Circumradii are compared exactly.
        names
            "h5", "fits", "table" and "ndnet": the attributes and columns of vertices to write. Empty: all, for "ndnet"
            the column "density".

        Warns with a UserWarning of what the format could not keep. The GIL is released; Ctrl-C leaves nothing
        half-written.
        """
        request = _tessera.ExportRequest()
        request.format(format or "")
        request.heights(heights)
        request.overwrite(overwrite)
        request.index(index)
        request.local(local)
        if max_edge is not None:
            request.max_edge(max_edge)
        if max_radius is not None:
            request.max_radius(max_radius)
        if names:
            request.names(list(names))
        note = self._triangulation.export_to(os.fspath(target), request)
        if note:
            warnings.warn(note, stacklevel=2)

    def verify(self, memory: int | str | None = None, scratch: Path | None = None, against_cgal: bool = False) -> Proof:
        """Proves from the files alone that the result is the Delaunay triangulation of its points.

        Parameters
        ----------
        memory
            The memory for facets: bytes, or "800M", "4G". More facets are sorted on disk. None: 70 % of the free
            memory.
        scratch
            The folder in which facets are sorted. None: the system's temporary folder.
        against_cgal
            Also triangulates all points with CGAL in memory, and compares every cell.

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
        """The columns of the triangulation, by name: t.columns["volume"]. measure() computes columns."""
        return Columns(self)

    def measure(self, volume: bool = False, memory: int | str | None = None, threads: int = 0,
                quality: bool = False, voronoi: bool = False, density: bool = False, mass: str | None = None) -> Measures:
        """Computes columns and adds them to the result folder, as a new version of the result. This object becomes the
        new version.

        Parameters
        ----------
        volume
            The volume of each cell, as t.columns["volume"], and for each vertex the sum of the volumes of its cells, as
            t.columns["star_volume"]. In 2D these are areas in the plane, "area" and "star_area".
        memory
            The memory for tiles: bytes, or "800M", "4G". None: 70 % of the free memory.
        threads
            The number of threads. 0: all processors.
        quality
            The shape of each cell: t.columns["radius_ratio"] (dim times the radius of the inscribed sphere, divided by
            that of the circumsphere: 1 for a regular cell, near 0 for a flat one), "least_angle" and "largest_angle"
            (degrees; in 3D dihedral angles), and "circumradius".
        voronoi
            The Voronoi cell of each vertex: t.columns["voronoi_volume"] and "voronoi_surface" (in 2D "voronoi_area" and
            "voronoi_boundary"; infinite on the hull), "voronoi_neighbours", and the centroid "voronoi_x", "voronoi_y",
            "voronoi_z" (NaN on the hull).
        density
            The density of each vertex, as t.columns["density"]: (dimension + 1) times its mass, divided by the volume of
            the cells around it. Each point has the mass 1, duplicates included.
        mass
            The attribute of the vertices that has their masses, for density; the column is then "density_NAME".

        Other programs can read the result at the same time. Ctrl-C leaves the result as it was. Existing columns are
        not computed again. Warns with a UserWarning if there is something to say about the values.
        """
        request = _tessera.MeasureRequest()
        request.volume(volume)
        request.quality(quality)
        request.voronoi(voronoi)
        request.density(density)
        request.mass(mass or "")
        request.memory_bytes(memory_bytes(memory))
        request.threads(threads)
        total, unit, made, note = self._triangulation.measure(request)
        self._questions = None
        if note:
            warnings.warn(note, stacklevel=2)
        return Measures(total, unit, made)

    def info(self) -> dict[str, typing.Any]:
        """Returns the output of `tessera info --json` as a dict: inputs, box, CRS, tiles, digest, seconds, ..."""
        return json.loads(self._triangulation.describe())

    def __arrow_c_stream__(self, requested_schema: object = None) -> object:
        """Gives the vertices to packages that read Arrow tables, as pyarrow.table(t) or polars.DataFrame(t), without
        pyarrow: the columns x, y and in 3D z, the attributes, and "id", the rank in the input; a batch for each tile."""
        example = next(iter(self), None)
        first = {axis: np.empty(0) for axis in "xyz"[: self.dim]} if example is None else vertex_columns(example)
        return _arrow_c.stream_of({name: values[:0] for name, values in first.items()}, map(vertex_columns, self))

    def _repr_html_(self) -> str:
        """What notebooks show."""
        if self._held is None:
            return table("Triangulation, closed", {})
        return table(f"Triangulation in {self.dim}D", {
            "points": self.n_points, "vertices": self.n_vertices, "duplicates": self.n_duplicates or None,
            cell_word(self.dim): self.n_cells, "tiles": len(self), "coordinate system": self._system_name(), "folder": self.folder,
            "digest": self.digest})

    def view(self, height: int = 480, max_triangles: int = 500_000) -> View:
        """Draws the surface of a 2D result, or the hull of a 3D result, in a notebook: coloured by height, to be turned,
        moved and zoomed as in docs/viewer.md.

        Parameters
        ----------
        height
            The height of the picture, in pixels.
        max_triangles
            Raises UsageError for more triangles: the page holds all of them. Client.view() draws results of any size.
        """
        return view_of(self, index(height, "height", 100_000), index(max_triangles, "max_triangles", 2**31))

    def _system_name(self) -> str:
        """The name in quotation marks that begins the WKT of the coordinate system, which is long."""
        name = re.match(r'[A-Z_]+\["([^"]+)"', self.crs)
        return name[1] if name else self.crs

    def __repr__(self) -> str:
        if self._held is None:
            return "<tessera.Triangulation, closed>"
        return (f"<tessera.Triangulation of {self.n_points} points: {self.n_cells} {cell_word(self.dim)} "
                f"in {len(self)} {'tile' if len(self) == 1 else 'tiles'}, {self.folder}>")


def vertex_columns(tile: Tile) -> dict[str, npt.NDArray[typing.Any]]:
    """Returns the coordinates, attributes and ids of the vertices that a tile owns, each as an array by itself."""
    own = ~tile.foreign
    columns = {axis: tile.points[own, i] for i, axis in enumerate("xyz"[: tile.dim])}
    columns.update({name: values[own] for name, values in tile.attributes.items()})
    columns["id"] = tile.ids[own]
    return columns


def open(folder: Path, version: int | None = None) -> Triangulation:
    """Opens the triangulation in a result folder, from triangulate(folder=...) or the command `tessera triangulate`.

    "s3://bucket/folder" and "https://host/folder" are results in object stores: give them as text. They are read, and
    cannot be changed.
    `version` is the number of an older version of the result, as `tessera log` lists them; default: the newest. Raises
    IoError if there is no result, CorruptError if the result is damaged, and UsageError if the version is not kept.
    """
    if version is None:
        return Triangulation(_tessera.Triangulation.open(os.fspath(folder)))
    return Triangulation(_tessera.Triangulation.open(os.fspath(folder), version))
