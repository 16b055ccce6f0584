"""One tile of a triangulation."""
from __future__ import annotations

import types
import typing

import numpy as np
import numpy.typing as npt

from . import _tessera


class Tile:
    """One tile with its m cells and n points. The points are the tile's own, and foreign ones that its cells need.

    The arrays are read-only views of the tile's memory, not copies. Each array keeps that memory alive, also when the
    Tile is deleted. `cells[~ghost]`, over all tiles, are the triangulation, each cell once.
    """

    def __init__(self, tile: _tessera.Tile | types.SimpleNamespace):
        self._tile = tile

    @property
    def id(self) -> int:
        """The tile's number, unique in the triangulation."""
        return self._tile.id

    @property
    def dim(self) -> int:
        """The dimension: 2 or 3."""
        return self._tile.dimension

    @property
    def points(self) -> npt.NDArray[np.float64]:
        """The coordinates of the points, n x dim, in the units of the input and bit for bit those of the input."""
        return self._tile.points

    @property
    def ids(self) -> npt.NDArray[np.int64]:
        """The rank of each point in the whole input, counted from 0 over all files: n. For an array: the row."""
        return self._tile.ids

    @property
    def foreign(self) -> npt.NDArray[np.bool_]:
        """True for points that another tile owns: n. `points[~foreign]`, over all tiles, are the vertices, each once."""
        return self._tile.foreign

    @property
    def offsets(self) -> npt.NDArray[np.int8] | None:
        """In a periodic triangulation: how many periods each point lies away from the point of the same id in the box.

        n x dim numbers -1, 0 or 1. `points` are the coordinates of the images. A point with an offset is foreign, even
        if its id is that of a point of this tile. None if no point of the tile is an image.
        """
        offsets = self._tile.offsets
        return offsets[:, : self.dim] if len(offsets) else None

    @property
    def cells(self) -> npt.NDArray[np.int32]:
        """The vertices of each cell, as rows of `points`: m x (dim+1), positively oriented: det(p1-p0, ...) > 0."""
        return self._tile.cells

    @property
    def ghost(self) -> npt.NDArray[np.bool_]:
        """True for cells that another tile counts, and that are here as copies: m."""
        return self._tile.ghost

    @property
    def neighbors(self) -> npt.NDArray[np.int32] | None:
        """The cell of this tile across the facet opposite each vertex: m x (dim+1). None if neighbours were not stored.

        -1 is outside the convex hull. -2 is a cell that only other tiles hold. If the tile owns no vertex of the facet,
        -2 may also be outside the hull.
        """
        neighbors = self._tile.neighbors
        return neighbors if len(neighbors) == len(self._tile.cells) else None

    @property
    def attributes(self) -> dict[str, np.ndarray]:
        """The attributes of the points that triangulate() kept, by name: n values each, of the type that they had in
        the input. Columns of vertices (Triangulation.measure()) are among them."""
        return self._tile.attributes

    @property
    def cell_columns(self) -> dict[str, np.ndarray]:
        """The columns of cells (Triangulation.measure()), by name: m values each."""
        return self._tile.cell_columns

    def __reduce__(self) -> tuple[typing.Any, ...]:
        return loaded_tile, (self.id, self.dim, *map(np.array, (self.points, self.ids, self.foreign, self.cells, self.ghost,
                                                                self._tile.neighbors)),
                             {name: np.array(values) for name, values in self.attributes.items()},
                             {name: np.array(values) for name, values in self.cell_columns.items()},
                             np.array(self._tile.offsets))

    def __repr__(self) -> str:
        return f"<tessera.Tile {self.id}: {len(self.points)} points, {len(self.cells)} {cell_word(self.dim)}>"


def loaded_tile(id: int, dim: int, points: np.ndarray, ids: np.ndarray, foreign: np.ndarray, cells: np.ndarray,
                ghost: np.ndarray, neighbors: np.ndarray, attributes: dict[str, np.ndarray],
                cell_columns: dict[str, np.ndarray], offsets: np.ndarray = np.empty((0, 3), np.int8)) -> Tile:
    """Returns a tile that was pickled. It consists of arrays and needs no result folder."""
    for array in (points, ids, foreign, cells, ghost, neighbors, offsets, *attributes.values(),
                  *cell_columns.values()):
        array.setflags(write=False)
    return Tile(types.SimpleNamespace(id=id, dimension=dim, points=points, ids=ids, foreign=foreign, cells=cells,
                                      ghost=ghost, neighbors=neighbors, attributes=attributes, cell_columns=cell_columns, offsets=offsets))


def cell_word(dim: int) -> str:
    return "triangles" if dim == 2 else "tetrahedra"
