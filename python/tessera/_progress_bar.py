"""A progress bar for notebooks and terminals."""
from __future__ import annotations

import sys
import typing

from ._html import bar
from ._job import Event, share_of_status
from ._progress import Progress


class ProgressBar:
    """A bar for the argument `progress` of triangulate(), and of Job.wait() and other calls that wait for a daemon.

    tessera.triangulate(points, progress=tessera.ProgressBar())

    In a notebook the bar is a widget if the package ipywidgets is installed, else a line of HTML. Elsewhere the bar is a
    line of text on standard error, if that is a terminal. Each bar is for one job.
    """

    def __init__(self) -> None:
        self._show = _shown()

    def __call__(self, made: Progress | Event) -> None:
        """Shows the progress."""
        if isinstance(made, Progress):
            self._show(share_of(made), made.phase)
        elif made.status:
            self._show(share_of_status(made.status), str(made.status.get("phase") or made.status.get("status") or ""))


def share_of(made: Progress) -> float:
    """Returns how much of a job is done, from 0 to 1: reading, triangulating and storing count a third each."""
    if made.phase == "done":
        return 1.0
    parts = [(made.points_routed, made.points_total), (made.points_triangulated, made.points_total), (made.tiles_stored, made.tiles_total)]
    return sum(min(done / total, 1.0) for done, total in parts if total > 0) / 3


def _shown() -> typing.Callable[[float, str], None]:
    """Returns the function that shows a share and a phase here."""
    ipython = sys.modules.get("IPython")  # loaded by the notebook, or not needed
    shell = ipython.get_ipython() if ipython is not None else None
    if shell is not None and hasattr(shell, "kernel"):
        return _widget() or _line_of_html()
    return _line_of_text if sys.stderr is not None and sys.stderr.isatty() else lambda share, phase: None


def _widget() -> typing.Callable[[float, str], None] | None:
    """None if ipywidgets is missing."""
    try:
        import ipywidgets
    except ImportError:
        return None
    from IPython.display import display
    filled, phase_text = ipywidgets.FloatProgress(value=0.0, min=0.0, max=1.0), ipywidgets.Label()
    display(ipywidgets.HBox([filled, phase_text]))

    def show(share: float, phase: str) -> None:
        filled.value = share
        phase_text.value = f"{share:.0%} {phase}"

    return show


def _line_of_html() -> typing.Callable[[float, str], None]:
    from IPython.display import HTML, display
    handle = display(HTML(bar(0.0, "")), display_id=True)

    def show(share: float, phase: str) -> None:
        handle.update(HTML(bar(share, f"{share:.0%} {phase}")))

    return show


def _line_of_text(share: float, phase: str) -> None:
    filled = round(30 * share)
    # Two spaces more than the longest phase needs: a shorter text does not leave letters of a longer one.
    sys.stderr.write(f"\r[{'#' * filled}{'.' * (30 - filled)}] {share:4.0%} {phase:<15}" + ("\n" if share >= 1 else ""))
    sys.stderr.flush()
