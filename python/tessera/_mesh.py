"""The vertices and cells of several tiles as one mesh."""
from __future__ import annotations

import typing

import numpy as np
import numpy.typing as npt

from ._errors import UsageError
from ._tile import Tile


class Mesh(typing.NamedTuple):
    """Vertices, each once, and main cells."""

    ids: npt.NDArray[np.int64]
    points: npt.NDArray[np.float64]
    cells: npt.NDArray[np.int64]
    """The vertices of each cell, as rows of `points`."""
    attributes: dict[str, npt.NDArray[typing.Any]]
    cell_columns: dict[str, npt.NDArray[typing.Any]]


def mesh_of(tiles: typing.Sequence[Tile], dim: int, foreign: bool = False) -> Mesh:
    """Joins tiles. foreign: also takes points that other tiles own, which one tile alone needs."""
    if any(tile.offsets is not None for tile in tiles):
        raise UsageError("the corners of periodic cells are images of points, and only tiles have offsets: use them")
    own = [np.full(len(tile.ids), True) if foreign else ~tile.foreign for tile in tiles]
    main = [~tile.ghost for tile in tiles]
    ids = joined([tile.ids[kept] for tile, kept in zip(tiles, own)], np.empty(0, np.int64))
    points = joined([tile.points[kept] for tile, kept in zip(tiles, own)], np.empty((0, dim)))
    corners = joined([tile.ids[tile.cells[kept]] for tile, kept in zip(tiles, main)], np.empty((0, dim + 1), np.int64))
    order = np.argsort(ids)
    return Mesh(ids, points, order[np.searchsorted(ids, corners, sorter=order)],
                {name: np.concatenate([tile.attributes[name][kept] for tile, kept in zip(tiles, own)])
                 for name in (tiles[0].attributes if tiles else ())},
                {name: np.concatenate([tile.cell_columns[name][kept] for tile, kept in zip(tiles, main)])
                 for name in (tiles[0].cell_columns if tiles else ())})


def joined(parts: list[npt.NDArray[typing.Any]], otherwise: npt.NDArray[typing.Any]) -> npt.NDArray[typing.Any]:
    """Returns the parts as one array; without parts `otherwise`."""
    return np.concatenate(parts) if parts else otherwise
