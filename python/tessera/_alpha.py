"""Alpha shapes of results."""
from __future__ import annotations

import os
import typing

import numpy as np
import numpy.typing as npt

from . import _tessera
from ._errors import UsageError
from ._options import Path


class AlphaShape(typing.NamedTuple):
    """An alpha shape. Facets are triangles in 3D and edges in 2D; they name vertices by their places in `ids`."""

    radius: float
    """The radius of the shape: its cells have a circumradius up to this."""
    cells: int
    """How many cells the shape has."""
    ids: npt.NDArray[np.int64]
    """The source indices of the n vertices, ascending. In a periodic result vertices are images: a point can be several
    of them, and those in the box come first."""
    points: npt.NDArray[np.float64]
    """The vertices: n x dim. In a periodic result, `numpy.floor(points / period)` is how many periods each lies away."""
    facets: npt.NDArray[np.int64]
    """The boundary: m x dim. Counterclockwise seen from outside in 3D; with the shape on the left in 2D."""
    singular_facets: npt.NDArray[np.int64]
    """Facets of no cell in the shape; only with general=True."""
    singular_edges: npt.NDArray[np.int64]
    """In 3D, edges of no facet in the shape: k x 2; only with general=True."""
    singular_vertices: npt.NDArray[np.int64]
    """Vertices of no edge in the shape; only with general=True."""


class AlphaShapes:
    """The alpha shapes that a Triangulation can make."""

    _triangulation: _tessera.Triangulation

    @typing.overload
    def alpha_shape(self, path: None = ..., *, alpha: float | typing.Literal["auto"] = ..., general: bool = ...,
                    overwrite: bool = ...) -> AlphaShape: ...

    @typing.overload
    def alpha_shape(self, path: Path, *, alpha: float | typing.Literal["auto"] = ..., general: bool = ...,
                    overwrite: bool = ...) -> float: ...

    def alpha_shape(self, path=None, *, alpha="auto", general=False, overwrite=False):
        """Makes an alpha shape: what cells of a circumradius up to `alpha` enclose. Without a path returns an
        AlphaShape. With `path` writes a .ply, or for a 2D result polygons as .gpkg, .geojson or .fgb, and returns the
        radius.

        Parameters
        ----------
        alpha
            The radius, in units of the coordinates. "auto": the least radius for which the shape is one piece that has
            all points.
        general
            Also makes singular facets, edges and vertices (docs/alpha.md).
        overwrite
            Replaces an existing file of the same name. Otherwise such a file is an error.

        Circumradii are compared exactly. Raises UsageError for a region, and for a file when no cell is in the shape.
        The GIL is released; Ctrl-C leaves nothing half-written.
        """
        if isinstance(alpha, str) and alpha != "auto":
            raise UsageError(f"alpha: must be a radius or 'auto', not {alpha!r}")
        request = _tessera.AlphaRequest(None if isinstance(alpha, str) else float(alpha), bool(general), bool(overwrite))
        if path is None:
            return AlphaShape(*_tessera.make_alpha_shape(self._triangulation, request))
        return _tessera.write_alpha_shape(self._triangulation, os.fspath(path), request)
