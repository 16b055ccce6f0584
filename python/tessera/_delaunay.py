"""SciPy's Delaunay, by tessera."""
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

# The facet opposite each vertex of a positively oriented simplex, seen counterclockwise from outside.
FACETS = {2: ((1, 2), (2, 0), (0, 1)), 3: ((1, 2, 3), (0, 3, 2), (0, 1, 3), (0, 2, 1))}


class Delaunay:
    """The Delaunay triangulation of points in memory: in 2D and 3D, a drop-in for scipy.spatial.Delaunay.

    Parameters
    ----------
    points
        n x 2 or n x 3, as for triangulate(): any integer or float type, never rounded.
    furthest_site, incremental, qhull_options
        SciPy's, for its positional order; anything but their defaults is refused with a UsageError.

    Raises
    ------
    UsageError
        For arrays of another shape or type (a ValueError, as SciPy's).
    BadInputError
        For points that are not finite, too few, or all on one line or plane. SciPy raises QhullError for the latter.
    KeyboardInterrupt
        On Ctrl-C, within a moment. The GIL is released meanwhile.

    What differs from SciPy:

    - Exact. Every different point is a vertex, no simplex is flat, and cospherical points are triangulated too, always
      the same way (SciPy's Qhull may leave points out, or merge facets). In general position the simplices are SciPy's.
    - `coplanar` therefore lists duplicates only.
    - `find_simplex` is exact: a point counts as inside on the boundary itself, but not a rounding error beyond it,
      where SciPy's default tolerance still says yes. `bruteforce` makes no difference; `tol` has to be None or 0.
    - `points`, `simplices` and `neighbors` are read-only; copy them to change them.
    - 3D simplices are positively oriented too, and the facets of `convex_hull` consistently.
    - `equations`, `plane_distance`, `lift_points`, `paraboloid_scale`, `paraboloid_shift` and `good` describe Qhull's
      paraboloid and are not there; neither is `add_points`. SciPy's own interpolators use them, so they do not take this
      object: LinearNDInterpolator here does.

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
        """The points, npoints x ndim: a read-only copy of those given."""
        return self._delaunay.points

    @property
    def simplices(self) -> npt.NDArray[np.int32]:
        """Indices of points, nsimplex x (ndim+1), read-only. 2D: counterclockwise. 3D: det(p1-p0, p2-p0, p3-p0) > 0."""
        return self._delaunay.simplices

    @property
    def neighbors(self) -> npt.NDArray[np.int32]:
        """Of each simplex the one opposite vertex k, nsimplex x (ndim+1), read-only; -1 outside the convex hull."""
        return self._delaunay.neighbors

    @property
    def ndim(self) -> int:
        """2 or 3."""
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
        """The least coordinate along each axis: ndim."""
        return self.points.min(axis=0)

    @functools.cached_property
    def max_bound(self) -> npt.NDArray[np.float64]:
        """The greatest coordinate along each axis: ndim."""
        return self.points.max(axis=0)

    @functools.cached_property
    def convex_hull(self) -> npt.NDArray[np.int32]:
        """Indices of points, nfaces x ndim: the hull's facets. 2D: counterclockwise; 3D: so when seen from outside."""
        simplex, opposite = np.nonzero(self.neighbors == -1)
        return self.simplices[simplex[:, None], np.array(FACETS[self.ndim])[opposite]]

    @functools.cached_property
    def coplanar(self) -> npt.NDArray[np.int32]:
        """Points that are no vertices, because they equal an earlier one: ncoplanar x 3, ascending.

        Columns: the point, a simplex with the vertex it equals, that vertex.
        """
        duplicate, vertex = self._delaunay.duplicates.T
        return np.column_stack([duplicate, self.vertex_to_simplex[vertex], vertex])

    @functools.cached_property
    def vertex_to_simplex(self) -> npt.NDArray[np.int32]:
        """A simplex that has the point as a vertex: npoints. Of a duplicate: one of the point it equals."""
        simplex = np.empty(self.npoints, np.int32)
        for corners in self.simplices.T:
            simplex[corners] = np.arange(self.nsimplex, dtype=np.int32)
        duplicate, vertex = self._delaunay.duplicates.T
        simplex[duplicate] = simplex[vertex]
        return simplex

    @functools.cached_property
    def vertex_neighbor_vertices(self) -> tuple[npt.NDArray[np.int32], npt.NDArray[np.int32]]:
        """(indptr, indices): the neighbours of point k are indices[indptr[k]:indptr[k+1]], ascending; none of duplicates."""
        return self._delaunay.vertex_neighbors()

    @functools.cached_property
    def transform(self) -> npt.NDArray[np.float64]:
        """Affine maps to barycentric coordinates, nsimplex x (ndim+1) x ndim.

        `b = transform[i, :ndim] @ (x - transform[i, ndim])` are the coordinates of x to the first ndim vertices of
        simplex i; the last is 1 - b.sum(). NaN for simplices that are nearly flat (condition number over 4.5e12), as in
        SciPy. Rounded, unlike find_simplex. Takes 8 ndim (ndim+1) bytes a simplex, once it is asked for.
        """
        return self._delaunay.transform()

    def find_simplex(self, xi: npt.ArrayLike, bruteforce: bool = False,
                     tol: float | None = None) -> npt.NDArray[np.int32]:
        """A simplex that holds each point of `xi`, its boundary included, exactly; -1 outside the convex hull and for NaN.

        Parameters
        ----------
        xi
            Points, (..., ndim).
        bruteforce
            Makes no difference.
        tol
            None or 0: nothing outside counts as inside.

        Returns
        -------
        Indices of simplices, int32, with the shape (...) of `xi` without its last axis.
        """
        if tol:
            raise UsageError(f"tol is {tol}: tessera finds simplices exactly, without a tolerance")
        queries = exact_float64(xi, "xi")
        if queries.ndim == 0 or queries.shape[-1] != self.ndim:
            raise UsageError(f"xi has the shape {queries.shape}: its last axis must be the {self.ndim} coordinates")
        return self._delaunay.find_simplex(queries.reshape(-1, self.ndim)).reshape(queries.shape[:-1])

    def close(self) -> None:
        """Does nothing: SciPy's ends incremental work, which there is none of."""

    def __reduce__(self) -> tuple[typing.Any, ...]:
        """Pickled are the arrays: what is loaded is not triangulated again."""
        return restored, tuple(map(np.array, (self.points, self.simplices, self.neighbors, self._delaunay.duplicates)))

    def __repr__(self) -> str:
        return f"<tessera.Delaunay of {self.npoints} points: {self.nsimplex} {cell_word(self.ndim)}>"


def restored(points: np.ndarray, simplices: np.ndarray, neighbors: np.ndarray, duplicates: np.ndarray) -> Delaunay:
    """A Delaunay that was pickled."""
    tri = Delaunay.__new__(Delaunay)
    tri._delaunay = _tessera.Delaunay.restore(points, simplices, neighbors, duplicates)
    return tri
