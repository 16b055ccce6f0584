"""Triangulations as meshes of PyVista."""
from __future__ import annotations

import typing

import numpy as np

from ._mesh import mesh_of
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
    alone = isinstance(source, Tile)
    mesh = mesh_of([source] if isinstance(source, Tile) else list(source), source.dim, foreign=alone)
    points = np.zeros((len(mesh.ids), 3))
    points[:, : source.dim] = mesh.points
    if heights and source.dim == 2 and "z" in mesh.attributes:
        points[:, 2] = mesh.attributes.pop("z")
    cells = np.column_stack([np.full(len(mesh.cells), source.dim + 1), mesh.cells])
    grid = pyvista.UnstructuredGrid(cells.ravel(), np.full(len(cells), _CELL_TYPE[source.dim], np.uint8), points)
    grid.point_data["id"] = mesh.ids
    for name, values in mesh.attributes.items():
        grid.point_data[name] = values
    for name, values in mesh.cell_columns.items():
        grid.cell_data[name] = values
    return grid
