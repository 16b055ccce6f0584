"""A result that a daemon keeps in memory, to which points are added and from which points are removed."""
from __future__ import annotations

import io
import typing

import numpy as np
import numpy.typing as npt

from ._errors import IoError, UsageError
from ._http import SILENCE_OF_EVENTS_S
from ._job import quoted, sent_events
from ._transfer import PATIENCE_S, Patience

if typing.TYPE_CHECKING:
    from .client import Client


class PointsChanged(typing.NamedTuple):
    """What a change has done."""

    version: int
    """The version that has the change, and maybe changes of others."""
    ids: range
    """The source indices of the new points, in their order."""
    equal: int
    """How many of the new points are equal to others. The rule of the result says which of equal points is the vertex."""
    removed: int


class VersionMade(typing.NamedTuple):
    """A version of a live result."""

    version: int
    added: int
    removed: int
    changed: list[tuple[float, ...]]
    """Boxes, each with its lower corner, then its upper one: all cells that are new or gone lie in them."""
    everything: bool
    """Versions were missed, so any cell may have changed, and `changed` is empty."""


class Live:
    """A live result of a daemon, from Client.live(). All methods may be called from any thread."""

    def __init__(self, client: Client, name: str):
        self._http, self._path = client._http, f"/triangulations/{quoted(name)}"

    def add(self, points: npt.ArrayLike, replace: bool = False) -> PointsChanged:
        """Adds points. When add() returns, they survive the end of the daemon.

        Parameters
        ----------
        points
            An array, n x dim. For a result with attributes or heights a structured array with the fields x, y, z and
            the attributes, of the types that the result has. The daemon takes 1 MiB at a time.
        replace
            True: a new point takes the place of all points of the result with its coordinates (in 2D with its x and y).
            These are removed, with their duplicates.

        Raises UsageError if the result is not live, or if you may not change it.
        """
        array = np.asarray(points)
        if array.dtype.names is None:
            array = np.ascontiguousarray(array, dtype=np.float64)
            if array.ndim != 2:
                raise UsageError("points: must be an array of n x 2 or n x 3 coordinates, or a structured array")
        return self._change("POST", array, "?replace=true" if replace else "")

    def remove(self, ids: npt.ArrayLike) -> PointsChanged:
        """Removes points, by their source indices. The source index of a removed point is never used again."""
        array = np.atleast_1d(np.asarray(ids))
        if array.ndim != 1 or array.dtype.kind not in "iu" or (array < 0).any():
            raise UsageError("ids: must be source indices, whole numbers that are not negative")
        return self._change("DELETE", array.astype("<i8"))

    def _change(self, method: str, array: np.ndarray, query: str = "") -> PointsChanged:
        body = io.BytesIO()
        np.save(body, array, allow_pickle=False)
        with self._http.open(method, f"{self._path}/points{query}", {"Content-Type": "application/x-npy"}, body.getvalue()) as answer:
            told = self._http.document(answer)
        try:
            first = int(told["firstID"])
            return PointsChanged(int(told["version"]), range(first, first + int(told["added"])), int(told["equal"]), int(told["removed"]))
        except (KeyError, TypeError, ValueError):
            raise self._http.no_tessera() from None

    def status(self) -> dict[str, typing.Any]:
        """Returns a dict of "version" (the newest, in memory), "storedVersion" (that of the files), "vertices",
        "pointsAdded" and "pointsRemoved" (since the stored version). Raises UsageError if the result is not live."""
        told = self._http.ask("GET", self._path)
        if not isinstance(told.get("live"), dict):
            raise UsageError(f"triangulation '{told.get('name', '')}' is not live")
        return dict(told["live"])

    def events(self, last: int | None = None, patience: float = PATIENCE_S) -> typing.Iterator[VersionMade]:
        """Yields each version after version `last`, as it is made. None: from now on.

        The loop ends only when you leave it. If the daemon does not answer any more, events() waits for it, `patience`
        seconds at most, and then raises IoError.
        """
        after = None if last is None else str(last)
        waiting = Patience(patience)
        while True:
            try:
                headers = {"Accept": "text/event-stream", **({} if after is None else {"Last-Event-ID": after})}
                with self._http.open("GET", f"{self._path}/events", headers, timeout=SILENCE_OF_EVENTS_S) as stream:
                    if not stream.headers.get("Content-Type", "").startswith("text/event-stream"):
                        raise self._http.no_tessera()
                    waiting.restart()
                    for number, sent in sent_events(self._http, stream):
                        if sent.get("kind") != "version":
                            continue
                        after = number
                        yield self._version(sent)
            except IoError as gone:
                if not self._http.heard:
                    raise
                waiting.wait(gone)
            else:
                waiting.wait()

    def _version(self, sent: dict[str, typing.Any]) -> VersionMade:
        try:
            made = sent["made"]
            boxes = [tuple(map(float, box["bounds"])) for box in made["changed"]]
            return VersionMade(int(made["version"]), int(made["added"]), int(made["removed"]), boxes, bool(made["everything"]))
        except (KeyError, TypeError, ValueError):
            raise self._http.no_tessera() from None
