"""Triangulations as meshes of PyVista."""
from __future__ import annotations

import typing

import numpy as np

from ._tile import Tile
from ._triangulation import Triangulation

# VTK's numbers for triangles and tetrahedra, by dimension.
_CELL_TYPE = {2: 5, 3: 10}


def to_pyvista(source: Triangulation | Tile, heights: bool = True) -> typing.Any:
    """Returns a triangulation or a tile as a pyvista.UnstructuredGrid, for plots and VTK's filters.

    The grid has the vertices, and each cell once; of a tile the cells that are not ghosts. Attributes of the points are
    point data, beside "id", the rank of each point in the input. Columns of cells are cell data.

    Parameters
    ----------
    source
        A Triangulation, which must fit in memory, or a Tile.
    heights
        2D: the attribute "z", if the points have it, becomes the third coordinate. Otherwise that is 0.

    Raises ImportError if the package pyvista is not installed.
    """
    try:
        import pyvista
    except ImportError:
        raise ImportError("to_pyvista() needs the package pyvista, which is not installed: pip install pyvista") from None
    tiles = [source] if isinstance(source, Tile) else list(source)
    own = [np.full(len(tile.ids), True) if isinstance(source, Tile) else ~tile.foreign for tile in tiles]
    main = [~tile.ghost for tile in tiles]
    ids = _joined([tile.ids[kept] for tile, kept in zip(tiles, own)], np.int64)
    points = np.zeros((len(ids), 3))
    points[:, : source.dim] = np.concatenate([tile.points[kept] for tile, kept in zip(tiles, own)] or [np.empty((0, source.dim))])
    data = {name: _joined([tile.attributes[name][kept] for tile, kept in zip(tiles, own)], np.float64)
            for name in (tiles[0].attributes if tiles else ())}
    if heights and source.dim == 2 and "z" in data:
        points[:, 2] = data.pop("z")
    order = np.argsort(ids)
    corners = np.concatenate([tile.ids[tile.cells[kept]] for tile, kept in zip(tiles, main)] or [np.empty((0, source.dim + 1), np.int64)])
    rows = order[np.searchsorted(ids, corners, sorter=order)]
    cells = np.column_stack([np.full(len(rows), source.dim + 1), rows])
    grid = pyvista.UnstructuredGrid(cells.ravel(), np.full(len(rows), _CELL_TYPE[source.dim], np.uint8), points)
    grid.point_data["id"] = ids
    for name, values in data.items():
        grid.point_data[name] = values
    for name in (tiles[0].cell_columns if tiles else ()):
        grid.cell_data[name] = _joined([tile.cell_columns[name][kept] for tile, kept in zip(tiles, main)], np.float64)
    return grid


def _joined(parts: list[np.ndarray[typing.Any, typing.Any]], otherwise: typing.Any) -> np.ndarray[typing.Any, typing.Any]:
    """Returns the parts as one array; without parts an empty one of the type `otherwise`."""
    return np.concatenate(parts) if parts else np.empty(0, otherwise)
