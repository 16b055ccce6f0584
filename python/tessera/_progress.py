"""How far a job is."""
from __future__ import annotations

import typing


class Progress(typing.NamedTuple):
    """How far a job is: what a progress callback is given."""

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
    """Since the job began."""
