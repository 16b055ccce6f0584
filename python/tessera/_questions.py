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
    """Where n points are. Outside the hull all numbers are -1."""

    tiles: npt.NDArray[np.int64]
    """The main tile of each point's cell, its Tile.id: n."""
    cells: npt.NDArray[np.int64]
    """The cell's row in that tile's `cells`: n."""
    vertices: npt.NDArray[np.int64]
    """The ranks of its vertices in the input: n x (dim+1)."""


class Star(typing.NamedTuple):
    """What is around a vertex."""

    vertex: int
    """Its rank in the input; of equal points that of the one that was kept."""
    tile: int
    """The tile that owns it."""
    point: npt.NDArray[np.float64]
    voronoi_volume: float
    """Of its Voronoi cell, in 2D the area: infinite for a vertex of the hull."""
    neighbors: npt.NDArray[np.int64]
    """Ranks, ascending."""
    cells: npt.NDArray[np.int64]
    """Ranks, m x (dim+1)."""
    cell_tiles: npt.NDArray[np.int32]
    """The main tile of each cell."""


class Weights(typing.NamedTuple):
    """Of which vertices values are made: those of point i are vertices[offsets[i]:offsets[i+1]]."""

    offsets: npt.NDArray[np.int64]
    vertices: npt.NDArray[np.int64]
    weights: npt.NDArray[np.float64]
    """They add up to 1 for each point inside the hull."""


class Part(Tile):
    """Some cells of a triangulation as one tile: all vertices are its own, all cells main."""

    def __repr__(self) -> str:
        return f"<tessera.Part: {len(self.points)} points, {len(self.cells)} {cell_word(self.dim)}>"


class Answers:
    """What a Triangulation answers. Tiles that were read stay in memory, 1 GiB of them, for the next question."""

    _triangulation: _tessera.Triangulation
    _questions: _tessera.Questions | None = None

    def _asked(self) -> _tessera.Questions:
        triangulation = self._triangulation  # UsageError when it is closed
        if self._questions is None:
            self._questions = _tessera.Questions(triangulation, 0, 0)
        return self._questions

    def _points(self, points: npt.ArrayLike) -> npt.NDArray[np.float64]:
        array, dim = exact_float64(points, "points"), self._triangulation.dimension
        if array.ndim != 2 or array.shape[1] != dim:
            raise UsageError(f"points have the shape {array.shape}: it must be (n, {dim})")
        return array

    def locate(self, points: npt.ArrayLike) -> Located:
        """Which cell has each of n x dim points, exactly; boundaries are included.

        Of several cells it is the one whose sorted ranks come first, whatever the tiles. All processors work at it; the
        GIL is released; Ctrl-C ends it.
        """
        return Located(*self._asked().locate(self._points(points), self._triangulation.dimension))

    def star(self, vertex: int, tile: int | None = None) -> Star:
        """The cells and neighbours of a vertex, told by its rank in the input, and the volume of its Voronoi cell.

        `tile`: the one that owns it, if it is known; else tiles are read until it is found. UsageError for no such point.
        It is of one vertex; docs/python.md shows densities of all points at once.
        """
        rank = index(vertex, "vertex", 2**63 - 1)
        owner = None if tile is None else index(tile, "tile", 10**6)
        return Star(*self._asked().star(rank, owner, self._triangulation.dimension))

    def cells(self, bbox: npt.ArrayLike | None = None, polygon: typing.Any = None, limit: int | None = None) -> Part:
        """The cells that have a point in common with a box or with polygons, as one tile.

        Parameters
        ----------
        bbox
            Closed: dim lower bounds, then dim upper ones.
        polygon
            A ring of n x 2 points, or GeoJSON as a dict or text, with holes, in the coordinates of the result; by the
            even-odd rule, its boundary included. In 3D a prism without ends.
        limit
            MemoryLimitError for more cells than that. None: as many as there are.

        Raises UsageError when no argument, or both, say where; BadInputError for GeoJSON that holds no polygon.
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
        """An attribute of the vertices at n x dim points: n values, NaN outside the hull.

        Parameters
        ----------
        value
            The attribute's name; "z" of a 2D result are its heights.
        method
            "linear": barycentric in the cell that has the point. "natural": Sibson's natural neighbours.
        weights
            Return also the Weights.
        """
        if method not in ("linear", "natural"):
            raise UsageError(f"method is {method!r}: it must be 'linear' or 'natural'")
        values, *rest = self._asked().interpolate(self._points(points), value, method == "natural", bool(weights))
        return (values, Weights(*rest)) if weights else values
