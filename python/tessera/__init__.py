"""Tessera: exact Delaunay triangulations in 2D and 3D, of any size.

There are two ways to triangulate.

    tri = tessera.Delaunay(points)        in memory, in one piece: a drop-in for scipy.spatial.Delaunay

    t = tessera.triangulate("block/*.laz", memory="4G", progress=print)
    for tile in t:                        any size: on disk, in tiles; one tile at a time is in memory
        tetrahedra = tile.points[tile.cells[~tile.ghost]]

The result is exact: it is the Delaunay triangulation of the coordinates as they are given, and rounding plays no part.
For cospherical points it is always the same triangulation, which a symbolic perturbation chooses. docs/python.md is the
guide.
"""
import importlib
import typing

if typing.TYPE_CHECKING:
    from ._public import *
    from ._public import __all__, __version__
else:
    # Importing tessera is quick. The first use of a name loads NumPy and the C++ library.
    def __getattr__(name):
        # Names of modules inside are asked for while _public is being imported.
        if not name.startswith("_") or name in ("__all__", "__version__"):
            public = importlib.import_module("._public", __name__)
            globals().update({one: getattr(public, one) for one in (*public.__all__, "__all__", "__version__")})
            if name in globals():
                return globals()[name]
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")

    def __dir__():
        return sorted({*__getattr__("__all__"), *globals()})
