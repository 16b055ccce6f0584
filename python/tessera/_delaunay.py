"""The class Delaunay, with the interface of SciPy's."""
from __future__ import annotations

import functools
import typing

import numpy as np
import numpy.typing as npt

from . import _tessera
from ._arrays import exact_float64
from ._errors import UsageError
from ._options import point_array
from ._tile import cell_word

# The facet opposite each vertex of a positively oriented simplex, counterclockwise when seen from outside.
FACETS = {2: ((1, 2), (2, 0), (0, 1)), 3: ((1, 2, 3), (0, 3, 2), (0, 1, 3), (0, 2, 1))}


class Delaunay:
    """The Delaunay triangulation of points in memory: in 2D and 3D, a drop-in for scipy.spatial.Delaunay.

    Parameters
    ----------
    points
        n x 2 or n x 3, of any integer or float type, as for triangulate(). Points are never rounded.
    furthest_site, incremental, qhull_options
        Arguments of SciPy's class, here so that positional arguments mean the same. UsageError for other values than
        the defaults.

    Raises
    ------
    UsageError
        For arrays of another shape or type (a ValueError, as SciPy's).
    BadInputError
        For points that are not finite, too few, or all on one line or plane. SciPy raises QhullError for the latter.
    KeyboardInterrupt
        On Ctrl-C, within a moment. The GIL is released while the library works.

    These things differ from SciPy:

    - The result is exact. Every distinct point is a vertex, no simplex is flat, and cospherical points are
      triangulated, too, always in the same way. (SciPy's Qhull may leave points out, or merge facets.) For points in
      general position the simplices are those of SciPy.
    - So `coplanar` lists duplicates only.
    - `find_simplex` is exact: the boundary is inside, and a point that is beyond it by a rounding error is outside.
      SciPy's default tolerance takes such a point for inside. `bruteforce` makes no difference; `tol` must be None or
      0.
    - `points`, `simplices` and `neighbors` are read-only; copy them to change them.
    - Simplices are positively oriented in 3D, too, and the facets of `convex_hull` are oriented consistently.
    - `equations`, `plane_distance`, `lift_points`, `paraboloid_scale`, `paraboloid_shift` and `good` describe Qhull's
      paraboloid and do not exist here. `add_points` does not exist, either. SciPy's interpolators use them, so they do
      not take this class; use tessera.LinearNDInterpolator.

    Examples
    --------
    >>> tri = tessera.Delaunay([[0, 0], [1, 0], [0, 1], [1, 1.1]])
    >>> tri.simplices.shape, tri.nsimplex
    ((2, 3), 2)
    >>> tri.find_simplex([[5, 5]])
    array([-1], dtype=int32)
    """

    furthest_site = False

    def __init__(self, points: npt.ArrayLike, furthest_site: bool = False, incremental: bool = False,
                 qhull_options: str | None = None):
        if furthest_site:
            raise UsageError("furthest_site=True: tessera makes nearest-site triangulations only")
        if incremental:
            raise UsageError("incremental=True: tessera triangulates all points at once; make a new Delaunay of them all")
        if qhull_options is not None:
            raise UsageError("qhull_options: tessera does not use Qhull; being exact, it needs none of them")
        self._delaunay = _tessera.Delaunay(point_array(points))

    @property
    def points(self) -> npt.NDArray[np.float64]:
        """The points, npoints x ndim: a read-only copy of the argument."""
        return self._delaunay.points

    @property
    def simplices(self) -> npt.NDArray[np.int32]:
        """The vertices of each simplex, as indices of points: nsimplex x (ndim+1), read-only.

        2D: counterclockwise. 3D: det(p1-p0, p2-p0, p3-p0) > 0.
        """
        return self._delaunay.simplices

    @property
    def neighbors(self) -> npt.NDArray[np.int32]:
        """The simplex across the facet opposite each vertex: nsimplex x (ndim+1), read-only; -1 outside the hull."""
        return self._delaunay.neighbors

    @property
    def ndim(self) -> int:
        """The dimension: 2 or 3."""
        return self.points.shape[1]

    @property
    def npoints(self) -> int:
        """The number of points, duplicates included."""
        return len(self.points)

    @property
    def nsimplex(self) -> int:
        """The number of simplices."""
        return len(self.simplices)

    @functools.cached_property
    def min_bound(self) -> npt.NDArray[np.float64]:
        """The least coordinate along each axis: ndim numbers."""
        return self.points.min(axis=0)

    @functools.cached_property
    def max_bound(self) -> npt.NDArray[np.float64]:
        """The greatest coordinate along each axis: ndim numbers."""
        return self.points.max(axis=0)

    @functools.cached_property
    def convex_hull(self) -> npt.NDArray[np.int32]:
        """The facets of the convex hull, as indices of points: nfaces x ndim.

        Counterclockwise around the hull in 2D, counterclockwise when seen from outside in 3D.
        """
        simplex, opposite = np.nonzero(self.neighbors == -1)
        return self.simplices[simplex[:, None], np.array(FACETS[self.ndim])[opposite]]

    @functools.cached_property
    def coplanar(self) -> npt.NDArray[np.int32]:
        """The points that are no vertices because they equal an earlier point: ncoplanar x 3, ascending.

        The columns are the index of the point, a simplex with the vertex that it equals, and the index of that vertex.
        """
        duplicate, vertex = self._delaunay.duplicates.T
        return np.column_stack([duplicate, self.vertex_to_simplex[vertex], vertex])

    @functools.cached_property
    def vertex_to_simplex(self) -> npt.NDArray[np.int32]:
        """For each point a simplex with this vertex: npoints. For a duplicate a simplex of its equal vertex."""
        simplex = np.empty(self.npoints, np.int32)
        for corners in self.simplices.T:
            simplex[corners] = np.arange(self.nsimplex, dtype=np.int32)
        duplicate, vertex = self._delaunay.duplicates.T
        simplex[duplicate] = simplex[vertex]
        return simplex

    @functools.cached_property
    def vertex_neighbor_vertices(self) -> tuple[npt.NDArray[np.int32], npt.NDArray[np.int32]]:
        """(indptr, indices): the neighbours of point k are indices[indptr[k]:indptr[k+1]], ascending.

        Duplicates have no neighbours.
        """
        return self._delaunay.vertex_neighbors()

    @functools.cached_property
    def transform(self) -> npt.NDArray[np.float64]:
        """Affine maps to barycentric coordinates, nsimplex x (ndim+1) x ndim.

        `b = transform[i, :ndim] @ (x - transform[i, ndim])` are the coordinates of x for the first ndim vertices of
        simplex i; the last coordinate is 1 - b.sum(). NaN for simplices that are nearly flat (condition number above
        4.5e12), as in SciPy. These numbers are rounded; find_simplex does not use them. The array is made when it is
        first used, and takes 8 ndim (ndim+1) bytes a simplex.
        """
        return self._delaunay.transform()

    def find_simplex(self, xi: npt.ArrayLike, bruteforce: bool = False,
                     tol: float | None = None) -> npt.NDArray[np.int32]:
        """Finds a simplex that contains each point of `xi`. A simplex contains its boundary; the test is exact.

        Parameters
        ----------
        xi
            Points, of shape (..., ndim).
        bruteforce
            Makes no difference.
        tol
            Must be None or 0: no point outside counts as inside.

        Returns
        -------
        Indices of simplices, int32, of shape (...); -1 outside the convex hull and for coordinates that are not finite.
        """
        if tol:
            raise UsageError(f"tol is {tol}: tessera finds simplices exactly, without a tolerance")
        queries = exact_float64(xi, "xi")
        if queries.ndim == 0 or queries.shape[-1] != self.ndim:
            raise UsageError(f"xi has the shape {queries.shape}: its last axis must be the {self.ndim} coordinates")
        return self._delaunay.find_simplex(queries.reshape(-1, self.ndim)).reshape(queries.shape[:-1])

    def close(self) -> None:
        """Does nothing. SciPy's method ends incremental processing, which does not exist here."""

    def __reduce__(self) -> tuple[typing.Any, ...]:
        """Pickles the arrays, so that loading does not triangulate again."""
        return restored, tuple(map(np.array, (self.points, self.simplices, self.neighbors, self._delaunay.duplicates)))

    def __repr__(self) -> str:
        return f"<tessera.Delaunay of {self.npoints} points: {self.nsimplex} {cell_word(self.ndim)}>"


def restored(points: np.ndarray, simplices: np.ndarray, neighbors: np.ndarray, duplicates: np.ndarray) -> Delaunay:
    """Returns the Delaunay with these arrays, which was pickled."""
    tri = Delaunay.__new__(Delaunay)
    tri._delaunay = _tessera.Delaunay.restore(points, simplices, neighbors, duplicates)
    return tri
