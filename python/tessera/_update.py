"""Changes of results: points that are removed and added."""
from __future__ import annotations

import os
import typing

import numpy as np
import numpy.typing as npt

from . import _tessera
from ._errors import UsageError
from ._options import Path, point_array
from ._records import columns_of, point_records

if typing.TYPE_CHECKING:
    from ._triangulation import Triangulation


class Update(typing.NamedTuple):
    """The outcome of Triangulation.update()."""

    triangulation: Triangulation
    """The changed result: a new Triangulation with `output`, else the same object."""
    first_id: int
    """The id of the first new point. The others follow."""
    removed: int
    """How many points were removed, those included that others have replaced."""
    added: int
    """How many points were added."""
    equal: int
    """How many of these have the coordinates of other points."""
    tiles_awake: int
    """How many tiles were triangulated again."""
    tiles_changed: int
    """How many of these have changed."""


class Changes:
    """The changes that can be made to a Triangulation."""

    _triangulation: _tessera.Triangulation
    _held: _tessera.Triangulation | None

    def update(self, add: npt.ArrayLike | None = None, remove: npt.ArrayLike | None = None, *,
               attributes: typing.Mapping[str, npt.ArrayLike] | None = None, output: Path | None = None,
               replace: bool = False, threads: int = 0) -> Update:
        """Removes points of the result and adds others, at the cost of what changes. The outcome is the triangulation
        from scratch of the points that are left, with the same ids.

        Parameters
        ----------
        add
            New points, n x dim. Their ids go on where those of the result end.
        remove
            The ids of points to remove: ranks in the input, vertices or duplicates.
        attributes
            The attributes of the new points, {"intensity": values}: those of the result, of the same types. In 2D "z" is
            the height; an n x 3 array has it, too.
        output
            The folder of the new result, which must not exist. Unchanged tiles are hard links. None: the result itself
            gets a new version, and this object becomes the new version.
        replace
            New points take the places of all points with the same coordinates, which are removed. Otherwise such a new
            point is a duplicate, or with another `keep` than "first" it may become the vertex.
        threads
            The number of threads. 0: all processors.

        A vertex that is removed gives its place to the next of the points with the same coordinates. Raises UsageError
        for an id that does not exist, for other attributes than those of the result, and when the points that are left
        do not span space. The GIL is released; Ctrl-C leaves nothing half-written.
        """
        request = _tessera.UpdateRequest(bool(replace), threads)
        if output is not None:
            request.output(os.fspath(output))
        if remove is not None:
            request.remove(point_ids(remove))
        rows = None
        if add is not None:
            points = point_array(add)
            dim = self._triangulation.dimension
            if points.shape[1] < dim:
                raise UsageError(f"points have the shape {points.shape}, but the result is {dim}D")
            rows = point_records(points, dict(attributes or {}))
            request.add(rows, columns_of(rows))
        elif attributes:
            raise UsageError("attributes are those of new points, and there are none: give add=points")
        first_id, removed, added, equal, awake, changed = _tessera.update(self._triangulation, request)
        made = _tessera.Triangulation.open(os.fspath(self._triangulation.folder if output is None else output))
        triangulation = typing.cast("Triangulation", self)
        if output is None:
            self._held = made
            triangulation._questions = None
        else:
            triangulation = type(triangulation)(made)
        return Update(triangulation, first_id, removed, added, equal, awake, changed)


def point_ids(ids: npt.ArrayLike) -> npt.NDArray[np.uint64]:
    """Returns ids as unsigned numbers. Raises UsageError for what is no list of ids."""
    given = np.asarray(ids)
    if given.size == 0:
        return np.empty(0, np.uint64)
    if given.ndim != 1 or given.dtype.kind not in "ui":
        raise UsageError(f"remove has the shape {given.shape} and the type {given.dtype}: it must be a list of integers")
    if given.dtype.kind == "i" and given.min() < 0:
        raise UsageError(f"remove[{int(given.argmin())}] is {given.min()}: ids are not negative")
    return np.ascontiguousarray(given, np.uint64)
