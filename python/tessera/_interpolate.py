"""Interpolation between scattered points, on the exact triangulation."""
from __future__ import annotations

import typing

import numpy as np
import numpy.typing as npt

from ._arrays import exact_float64
from ._delaunay import Delaunay
from ._errors import UsageError
from ._options import point_array


class LinearNDInterpolator:
    """Piecewise linear interpolation in 2D and 3D: a drop-in for scipy.interpolate.LinearNDInterpolator.

    Parameters
    ----------
    points
        n x 2 or n x 3, as for Delaunay, or a finished Delaunay.
    values
        n x ...: real or complex values. The value of the first of several equal points counts.
    fill_value
        The value outside the convex hull.
    rescale
        Shifts and scales the points to a unit box before they are triangulated. This changes the triangulation.

    The simplex of a point is found exactly, as by Delaunay.find_simplex: the hull itself is inside, and a point beyond
    it by a rounding error is outside. At the given points the result is their value, bit for bit. Elsewhere it is
    between the values of the corners, and right to some ten digits, also in simplices that are nearly flat.

    Examples
    --------
    >>> f = tessera.LinearNDInterpolator([[0, 0], [1, 0], [0, 1], [1, 1]], [0, 1, 2, 3])
    >>> f(0.5, 0.25), f([[1, 1], [2, 2]])
    (array(1.), array([ 3., nan]))
    """

    def __init__(self, points: npt.ArrayLike | Delaunay, values: npt.ArrayLike, fill_value: complex = np.nan,
                 rescale: bool = False):
        self._offset = self._scale = None
        if isinstance(points, Delaunay):
            if rescale:
                raise UsageError("rescale=True: a finished Delaunay cannot be rescaled; give the points instead")
            self.tri = points
        else:
            given = point_array(points)
            if rescale:
                self._offset, self._scale = given.mean(axis=0), np.ptp(given, axis=0)
                self._scale[~(self._scale > 0)] = 1
                given = (given - self._offset) / self._scale
            self.tri = Delaunay(given)
        array = np.asarray(values)
        array = array.astype(np.complex128 if array.dtype.kind == "c" else np.float64)
        if array.ndim == 0 or len(array) != self.tri.npoints:
            raise UsageError(f"values have the shape {array.shape}: there must be one for each of the {self.tri.npoints} points")
        self.values = array
        """The values, one for each point: float64 or complex128."""
        self.fill_value = fill_value

    @property
    def points(self) -> npt.NDArray[np.float64]:
        """The points that were triangulated (rescaled, if `rescale` was given)."""
        return self.tri.points

    def __repr__(self) -> str:
        return f"<tessera.LinearNDInterpolator of {self.tri.npoints} points in {self.tri.ndim}D>"

    def __call__(self, *xi: npt.ArrayLike) -> np.ndarray:
        """Returns the values at `xi`: an array of shape (..., ndim), or ndim arrays of coordinates that broadcast.

        The shape of the result is (...), followed by the shape of a value.
        """
        queries = self._queries(xi)
        flat = np.ascontiguousarray(queries.reshape(-1, self.tri.ndim))
        corners = self.values.reshape(len(self.values), -1)
        result = np.full((len(flat), corners.shape[1]), self.fill_value, np.result_type(corners, type(self.fill_value)))
        chunk = 1 << 16
        for begin in range(0, len(flat), chunk):
            part = flat[begin : begin + chunk]
            found = self.tri.find_simplex(part)
            weights = self.tri._delaunay.weights(part, found)
            inside = np.flatnonzero(found >= 0)
            result[begin + inside] = np.einsum("ni,nij->nj", weights[inside], corners[self.tri.simplices[found[inside]]])
        return result.reshape(queries.shape[:-1] + self.values.shape[1:])

    def _queries(self, xi: tuple[typing.Any, ...]) -> np.ndarray:
        ndim = self.tri.ndim
        one = xi[0] if len(xi) == 1 else xi
        if isinstance(one, tuple):
            if len(one) != ndim:
                raise UsageError(f"there are {len(one)} arrays of coordinates: there must be {ndim}")
            queries = np.stack(np.broadcast_arrays(*(exact_float64(x, "xi") for x in one)), axis=-1)
        else:
            queries = exact_float64(one, "xi")
            if queries.ndim == 1 and queries.size % ndim == 0:
                queries = queries.reshape(-1, ndim)
        if queries.ndim == 0 or queries.shape[-1] != ndim:
            raise UsageError(f"xi has the shape {queries.shape}: its last axis must be the {ndim} coordinates")
        return queries if self._scale is None else (queries - self._offset) / self._scale
