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
from . import _tessera
from ._alpha import AlphaShape
from ._delaunay import Delaunay
from ._densities import Density
from ._errors import (BadInputError, CorruptError, Error, InternalError, InterruptedJobError, IoError, MemoryLimitError,
                      NotDelaunayError, UsageError)
from ._heights import HeightsFile, hag
from ._interpolate import LinearNDInterpolator
from ._progress import Progress
from ._questions import Located, Part, Star, Weights
from ._surfaces import Contour, Profile, Raster
from ._tile import Tile
from ._region import region
from ._triangulate import info, triangulate
from ._triangulation import Columns, Measures, Proof, Tiles, Triangulation, open
from ._job import Event, Job
from ._live import Live, PointsChanged, VersionMade
from ._update import Update
from ._volumes import VolumeTable
from ._voronoi import VoronoiFile
from .client import Client, connect

__version__ = _tessera.version()

__all__ = ["triangulate", "region", "open", "info", "hag", "HeightsFile", "connect", "Client", "Job", "Event", "Live", "PointsChanged", "VersionMade", "Triangulation", "Tile", "Tiles", "Located", "Star", "Part", "Raster", "AlphaShape", "Contour", "Profile", "Density", "VolumeTable", "VoronoiFile", "Update", "Weights", "Progress", "Proof", "Columns", "Measures", "Delaunay", "LinearNDInterpolator", "Error", "UsageError", "BadInputError",
           "IoError", "CorruptError", "NotDelaunayError", "MemoryLimitError", "InterruptedJobError", "InternalError"]
# help() and messages show these names as members of the package.
for _public in __all__:
    globals()[_public].__module__ = __name__
del _public
