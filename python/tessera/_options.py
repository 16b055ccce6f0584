"""Checks the arguments of triangulate(), and turns them into the options of the library."""
from __future__ import annotations

import math
import os
import re
import typing

import numpy as np
import numpy.typing as npt

from . import _tessera
from ._arrays import exact_float64
from ._errors import UsageError

Path = typing.Union[str, "os.PathLike[str]"]


def job_options(dim: int | None, *, max_points_per_tile: int | None = None, folder: Path | None = None,
                overwrite: bool = False, threads: int | None = None, memory: int | str | None = None,
                attributes: typing.Iterable[str] = (), neighbors: bool = True, skip_invalid: bool = False,
                recursive: bool = False, tiles: int | None = None, partition: str = "kdtree",
                crop: typing.Sequence[float] | None = None, classes: typing.Iterable[int] = (),
                returns: str = "all", without: typing.Iterable[str] = (), resolution: float | None = None,
                columns: typing.Iterable[str] = (), keep: str = "first", store: str = "auto",
                crs: Path | None = None, heights: bool = True,
                periodic: float | typing.Sequence[float] | str | None = None, periodic_snap: str = "yes",
                input_list: Path | None = None, resume: bool = False,
                scans: typing.Iterable[int] = (), particles: typing.Iterable[int | str] = (),
                hdu: int | str | None = None, cosmology: typing.Sequence[float] | None = None, endpoint: str | None = None, profile: str | None = None,
                anonymous: bool = False, requester_pays: bool = False) -> _tessera.Options:
    """Returns the options of triangulate(). `dim` None: the dimension of the files."""
    options = _tessera.Options()
    if dim not in (None, 2, 3):
        raise UsageError(f"dim is {dim!r}: tessera triangulates in 2 or 3 dimensions")
    options.dimension(dim or 0)
    if folder is not None:
        if not os.fspath(folder):
            raise UsageError("folder is empty: None makes a temporary one")
        options.folder(os.fspath(folder))
    options.overwrite(overwrite)
    options.resume(resume)
    options.max_points_per_tile(positive(max_points_per_tile, "max_points_per_tile", 2**63))
    options.tiles(positive(tiles, "tiles", 10**6 + 1))
    options.partition(partition)
    options.threads(positive(threads, "threads", 1025))
    options.memory_bytes(memory_bytes(memory))
    options.neighbors(neighbors)
    options.skip_invalid(skip_invalid)
    options.recursive(recursive)
    options.heights(heights)
    if crop is not None:
        options.crop(exact_float64(crop, "crop").ravel().tolist())
    if isinstance(periodic, str) and periodic == "file":
        options.periodic_files(True)
    elif periodic is not None:
        options.periodic(exact_float64(periodic, "periodic").ravel().tolist())
    options.periodic_snap(periodic_snap)
    options.classes([positive(number + 1, "classes", 257) - 1 for number in classes])
    options.scans([positive(number + 1, "scans", 2**32) - 1 for number in scans])
    options.particles([str(kind) for kind in ([particles] if isinstance(particles, (int, str)) else particles)])
    if hdu is not None:
        options.hdu(str(hdu))
    if cosmology is not None:
        numbers = exact_float64(cosmology, "cosmology").ravel().tolist()
        if len(numbers) != 2:
            raise UsageError("cosmology must be two numbers: H0 in km/s/Mpc, and the density of matter")
        options.cosmology(*numbers)
    options.returns(returns)
    options.keep(keep)
    options.store(store)
    options.without([without] if isinstance(without, str) else list(without))
    options.columns(columns.split(",") if isinstance(columns, str) else list(columns))
    if resolution is not None:
        if not 0 < resolution < math.inf:
            raise UsageError(f"resolution is {resolution!r}: it must be None or a distance above 0")
        options.resolution(resolution)
    if crs is not None:
        options.crs(os.fsencode(crs))
    if input_list is not None:
        options.input_list(os.fspath(input_list))
    options.endpoint(endpoint or "")
    options.profile(profile or "")
    options.anonymous(anonymous)
    options.requester_pays(requester_pays)
    options.attributes([attributes] if isinstance(attributes, str) else list(attributes))
    return options


def point_array(points: npt.ArrayLike) -> npt.NDArray[np.float64]:
    """Returns `points` as from exact_float64(). Raises UsageError unless the shape is n x 2 or n x 3."""
    array = exact_float64(points, "points")
    if array.ndim != 2 or array.shape[1] not in (2, 3):
        raise UsageError(f"points have the shape {array.shape}: it must be (n, 2) or (n, 3)")
    return array


def file_names(source: typing.Any, input_list: Path | None = None) -> list[bytes] | None:
    """Returns the files that `source` names, as bytes; None if it is neither a path nor a list of paths."""
    if isinstance(source, (str, os.PathLike)):
        return [os.fsencode(source)]
    names = source.tolist() if getattr(source, "ndim", 0) == 1 and hasattr(source, "tolist") else source
    if not isinstance(names, (list, tuple)) or not all(isinstance(path, (str, os.PathLike)) for path in names):
        return None
    return [os.fsencode(path) for path in names] if names or input_list is not None else None


def positive(value: int | None, name: str, end: int) -> int:
    """Returns `value`, which must be in [1, end); 0 for None, which lets the library choose."""
    if value is None:
        return 0
    if not isinstance(value, (int, np.integer)) or not 1 <= value < end:
        raise UsageError(f"{name} is {value!r}: it must be None or an integer from 1 to {end - 1}")
    return int(value)


def index(value: int, name: str, end: int) -> int:
    """Returns `value`, which must be in [0, end)."""
    if not isinstance(value, (int, np.integer)) or not 0 <= value < end:
        raise UsageError(f"{name} is {value!r}: it must be one integer from 0 to {end - 1}")
    return int(value)


def memory_bytes(memory: int | str | None) -> int:
    """Returns the number of bytes that `memory` means, an argument of triangulate(); 0 for None."""
    if not isinstance(memory, str):
        return positive(memory, "memory", 2**63)
    parts = re.fullmatch(r"(\d+(?:\.\d+)?)([KMGT]?)", memory)
    if not parts:
        raise UsageError(f"memory is {memory!r}: it must be a number of bytes, or like '800M' or '4G'")
    return positive(int(float(parts[1]) * 1024 ** " KMGT".index(parts[2] or " ")), "memory", 2**63)
