"""All that `import tessera` gives. The package reads this module at the first use of a name."""
from . import _tessera
from ._alpha import AlphaShape
from ._arrow import from_arrow
from ._delaunay import Delaunay
from ._densities import Density
from ._errors import (BadInputError, CorruptError, Error, InternalError, InterruptedJobError, IoError, MemoryLimitError,
                      NotDelaunayError, UsageError)
from ._heights import HeightsFile, hag
from ._interpolate import LinearNDInterpolator
from ._progress import Progress
from ._progress_bar import ProgressBar
from ._pyvista import to_pyvista
from ._questions import Located, Part, Star, Weights
from ._surfaces import Contour, Profile, Raster
from ._tile import Tile
from ._region import region
from ._triangulate import info, triangulate
from ._triangulation import Columns, Measures, Proof, Tiles, Triangulation, open
from ._job import Event, Job
from ._live import Live, PointsChanged, VersionMade
from ._update import Update
from ._view import View
from ._viewer import ViewerLink
from ._volumes import VolumeTable
from ._voronoi import VoronoiFile
from .client import Client, connect

__version__ = _tessera.version()

__all__ = ["triangulate", "region", "open", "info", "hag", "from_arrow", "to_pyvista", "HeightsFile", "connect",
           "Client", "Job", "Event", "View", "ViewerLink", "Live", "PointsChanged", "VersionMade", "Triangulation",
           "Tile", "Tiles", "Located", "Star", "Part", "Raster", "AlphaShape", "Contour", "Profile", "Density",
           "VolumeTable", "VoronoiFile", "Update", "Weights", "Progress", "ProgressBar", "Proof", "Columns", "Measures",
           "Delaunay", "LinearNDInterpolator", "Error", "UsageError", "BadInputError", "IoError", "CorruptError",
           "NotDelaunayError", "MemoryLimitError", "InterruptedJobError", "InternalError"]
# help() and messages show these names as members of the package.
for _public in __all__:
    globals()[_public].__module__ = __package__
del _public
