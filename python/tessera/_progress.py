"""The progress of a job."""
from __future__ import annotations

import typing


class Progress(typing.NamedTuple):
    """The progress of a job, for a progress callback."""

    phase: str
    """"planning", "routing", "triangulating", "splaying", "collecting", "finishing", "done"."""
    points_total: int
    """0 while unknown."""
    points_routed: int
    points_triangulated: int
    tiles_total: int
    """0 while unknown."""
    tiles_triangulated: int
    tiles_stored: int
    seconds: float
    """The time since the job began."""
