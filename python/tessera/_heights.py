"""Heights above the ground."""
from __future__ import annotations

import os
import pathlib
import typing

from . import _tessera
from ._errors import UsageError
from ._options import Path, file_names, index, memory_bytes, positive
from ._triangulation import Triangulation


class HeightsFile(typing.NamedTuple):
    """A file that hag() has copied."""

    input: pathlib.Path
    output: pathlib.Path
    points: int
    outside: int
    """The points outside of the hull of the ground."""


def hag(source: Path | typing.Sequence[Path], folder: Path, *, ground: Path | Triangulation | None = None,
        ground_class: int | None = None, format: str | None = None, outside: float | None = None,
        replace: bool = False, overwrite: bool = False, threads: int | None = None,
        memory: int | str | None = None) -> list[HeightsFile]:
    """Copies LAS and LAZ files, and gives each point the dimension HeightAboveGround: its height above the ground.

    The height of the ground is linear in the triangle that contains the place of the point. Everything else in the
    files stays as it is. LAZ stays LAZ, COPC stays COPC.

    Parameters
    ----------
    source
        A path, a folder, a pattern ("block/*.laz"), or a list of these. All files share one ground.
    folder
        The folder for the copies, which have the names of their files.
    ground
        The ground, as a 2D Triangulation or the folder of a 2D result. None: the ground points of all files.
    ground_class
        The LAS class of the ground points. None: 2.
    format
        "las" or "laz". None: as each file is.
    outside
        The height of points outside of the hull of the ground. None: NaN.
    replace
        Replaces a dimension HeightAboveGround that a file has already.
    overwrite
        Replaces copies that exist.
    threads, memory
        As for triangulate().

    Returns a HeightsFile for each file. The GIL is released; Ctrl-C leaves no half-written file.
    """
    files = file_names(source)
    if files is None:
        raise UsageError("hag() is for files: it takes a path, a pattern, or a list of them")
    request = _tessera.HeightsRequest()
    if ground is not None:
        request.ground(os.fspath(ground.folder if isinstance(ground, Triangulation) else ground))
    if ground_class is not None:
        request.ground_class(index(ground_class, "ground_class", 256))
    if format is not None:
        request.format(format)
    if outside is not None:
        request.outside(float(outside))
    request.replace(replace)
    request.overwrite(overwrite)
    request.threads(positive(threads, "threads", 1025))
    request.memory_bytes(memory_bytes(memory))
    return [HeightsFile(*made) for made in _tessera.write_heights(files, os.fspath(folder), request)]
