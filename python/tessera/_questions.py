"""Questions to a finished triangulation."""
from __future__ import annotations

import json
import typing

import numpy as np
import numpy.typing as npt

from . import _tessera
from ._arrays import exact_float64
from ._errors import UsageError
from ._options import index, positive
from ._tile import Tile, cell_word


class Located(typing.NamedTuple):
    """The cells that contain n points. All numbers are -1 for a point outside the hull."""

    tiles: npt.NDArray[np.int64]
    """The main tile of each point's cell, as Tile.id: n."""
    cells: npt.NDArray[np.int64]
    """The row of each cell in Tile.cells of that tile: n."""
    vertices: npt.NDArray[np.int64]
    """The vertices of each cell, as ranks in the input: n x (dim+1)."""


class Star(typing.NamedTuple):
    """A vertex with its neighbours and the m cells around it."""

    vertex: int
    """The rank of the vertex in the input; for a duplicate that of the kept point."""
    tile: int
    """The tile that owns the vertex."""
    point: npt.NDArray[np.float64]
    """The coordinates of the vertex: dim."""
    voronoi_volume: float
    """The volume of the vertex's Voronoi cell, in 2D its area; infinite for a vertex of the hull."""
    neighbors: npt.NDArray[np.int64]
    """The ranks of the neighbours, ascending."""
    cells: npt.NDArray[np.int64]
    """The vertices of each cell, as ranks: m x (dim+1)."""
    cell_tiles: npt.NDArray[np.int32]
    """The main tile of each cell: m."""


class Weights(typing.NamedTuple):
    """The vertices that make up interpolated values, with their weights.

    The vertices of point i are vertices[offsets[i]:offsets[i+1]], and its weights weights[offsets[i]:offsets[i+1]].
    """

    offsets: npt.NDArray[np.int64]
    """n + 1 numbers for n points."""
    vertices: npt.NDArray[np.int64]
    """Ranks in the input."""
    weights: npt.NDArray[np.float64]
    """The weights of a point inside the hull add up to 1."""


class Part(Tile):
    """Some cells of a triangulation as one tile. No vertex is foreign, and no cell is a ghost."""

    def __repr__(self) -> str:
        return f"<tessera.Part: {len(self.points)} points, {len(self.cells)} {cell_word(self.dim)}>"


class Answers:
    """The questions that a Triangulation answers. Up to 1 GiB of tiles stay in memory for the next question."""

    _triangulation: _tessera.Triangulation
    _questions: _tessera.Questions | None = None

    def _asked(self) -> _tessera.Questions:
        triangulation = self._triangulation  # raises UsageError if it is closed
        if self._questions is None:
            self._questions = _tessera.Questions(triangulation, 0, 0)
        return self._questions

    def _points(self, points: npt.ArrayLike) -> npt.NDArray[np.float64]:
        array, dim = exact_float64(points, "points"), self._triangulation.dimension
        if array.ndim != 2 or array.shape[1] != dim:
            raise UsageError(f"points have the shape {array.shape}: it must be (n, {dim})")
        return array

    def locate(self, points: npt.ArrayLike) -> Located:
        """Finds the cell that contains each of n x dim points. The answer is exact, and cells contain their boundary.

        If several cells contain a point, the answer is the cell whose sorted ranks come first, so it does not depend on
        the tiles. All processors are used, the GIL is released, and Ctrl-C ends the call.
        """
        return Located(*self._asked().locate(self._points(points), self._triangulation.dimension))

    def star(self, vertex: int, tile: int | None = None) -> Star:
        """Returns the cells and neighbours of a vertex, and the volume of its Voronoi cell.

        `vertex` is the rank of the vertex in the input. `tile` is the tile that owns the vertex; without it tiles are
        read until the vertex is found. Raises UsageError if there is no such point. docs/python.md shows how to compute
        volumes and densities for all points at once.
        """
        rank = index(vertex, "vertex", 2**63 - 1)
        owner = None if tile is None else index(tile, "tile", 10**6)
        return Star(*self._asked().star(rank, owner, self._triangulation.dimension))

    def neighbours(self, vertex: int, tile: int | None = None) -> npt.NDArray[np.int64]:
        """Returns the ranks of the vertices that share an edge with a vertex, ascending.

        `vertex` and `tile` are as in star(), and so are the errors.
        """
        rank = index(vertex, "vertex", 2**63 - 1)
        owner = None if tile is None else index(tile, "tile", 10**6)
        return self._asked().neighbours(rank, owner)

    def cells(self, bbox: npt.ArrayLike | None = None, polygon: typing.Any = None, limit: int | None = None) -> Part:
        """Returns the cells that have a point in common with a box or with polygons, as one tile.

        Parameters
        ----------
        bbox
            A closed box: dim lower bounds, then dim upper bounds.
        polygon
            A ring of n x 2 points, or GeoJSON as a dict or text, in the coordinates of the result. The even-odd rule
            holds, so polygons may have holes. The boundary belongs to the polygon. In 3D a polygon is a prism without
            ends.
        limit
            Raises MemoryLimitError for more cells than that. None: no limit.

        Raises UsageError unless exactly one of bbox and polygon is given, and BadInputError for GeoJSON without
        polygons.
        """
        most = positive(limit, "limit", 2**63) or 2**64 - 1
        if (bbox is None) == (polygon is None):
            raise UsageError("give either bbox or polygon")
        if bbox is not None:
            return Part(self._asked().cells_of_box(exact_float64(bbox, "bbox").ravel().tolist(), most))
        if not isinstance(polygon, (str, dict)):
            ring = exact_float64(polygon, "polygon")
            if ring.ndim != 2 or ring.shape[1] != 2:
                raise UsageError(f"polygon has the shape {ring.shape}: it must be (n, 2)")
            polygon = {"type": "Polygon", "coordinates": [ring.tolist()]}
        text = polygon if isinstance(polygon, str) else json.dumps(polygon)
        return Part(self._asked().cells_of_polygons(text, most))

    @typing.overload
    def interpolate(self, points: npt.ArrayLike, value: str = ..., method: str = ...,
                    weights: typing.Literal[False] = ...) -> npt.NDArray[np.float64]: ...

    @typing.overload
    def interpolate(self, points: npt.ArrayLike, value: str = ..., method: str = ..., *,
                    weights: typing.Literal[True]) -> tuple[npt.NDArray[np.float64], Weights]: ...

    def interpolate(self, points, value="z", method="linear", weights=False):
        """Interpolates an attribute of the vertices at n x dim points. Returns n values, NaN outside the hull.

        Parameters
        ----------
        value
            The name of the attribute; "z" in a 2D result is the height.
        method
            "linear": barycentric in the cell that contains the point. "natural": Sibson's natural neighbours.
        weights
            Also returns the Weights.
        """
        if method not in ("linear", "natural"):
            raise UsageError(f"method is {method!r}: it must be 'linear' or 'natural'")
        values, *rest = self._asked().interpolate(self._points(points), value, method == "natural", bool(weights))
        return (values, Weights(*rest)) if weights else values
