"""Densities and fields of a result on a grid."""
from __future__ import annotations

import operator
import os
import typing
import warnings

import numpy as np
import numpy.typing as npt

from . import _tessera
from ._errors import UsageError
from ._options import Path, memory_bytes


class Density(typing.NamedTuple):
    """A density or a field on a grid of pixels or voxels."""

    values: npt.NDArray[np.float64]
    """ny x nx in 2D, nz x ny x nx in 3D, all ascending; for the curl in 3D and the shear with one more index, the component. NaN where a
    field has no value; a density is 0 outside of the hull."""
    origin: tuple[float, ...]
    """The least corner of the grid: (x, y) or (x, y, z)."""
    widths: tuple[float, ...]
    """The widths of a pixel or voxel, along the same axes."""
    mass: float
    """Of a density: the mass of all points; of a field 0."""
    grid_mass: float
    """Of a density: the mass of the grid, which is that of the points if the grid covers them."""

    @property
    def res(self) -> float | None:
        """The width of a pixel or voxel, if it is the same along all axes."""
        return self.widths[0] if len(set(self.widths)) == 1 else None

    @property
    def __array_interface__(self) -> dict[str, typing.Any]:
        """NumPy, and what uses its interface, take this as the array `values`."""
        return self.values.__array_interface__


class Densities:
    """The grids that can be made of a Triangulation."""

    _triangulation: _tessera.Triangulation

    @typing.overload
    def density(self, path: None = ..., *, res: float | None = ..., grid: int | typing.Sequence[int] | None = ...,
                mass: str | None = ..., field: str | None = ..., divergence: typing.Sequence[str] | None = ...,
                curl: typing.Sequence[str] | None = ..., shear: typing.Sequence[str] | None = ..., sample: bool = ...,
                bbox: npt.ArrayLike | None = ..., memory: int | str | None = ..., threads: int = ...,
                overwrite: bool = ...) -> Density: ...

    @typing.overload
    def density(self, path: Path, *, res: float | None = ..., grid: int | typing.Sequence[int] | None = ...,
                mass: str | None = ..., field: str | None = ..., divergence: typing.Sequence[str] | None = ...,
                curl: typing.Sequence[str] | None = ..., shear: typing.Sequence[str] | None = ..., sample: bool = ...,
                bbox: npt.ArrayLike | None = ..., memory: int | str | None = ..., threads: int = ...,
                overwrite: bool = ...) -> None: ...

    def density(self, path=None, *, res=None, grid=None, mass=None, field=None, divergence=None, curl=None, shear=None,
                sample=False, bbox=None, memory=None, threads=0, overwrite=False):
        """Puts the density of the points (DTFE), or a field, on a grid of pixels (2D) or voxels (3D): the exact mean of the
        linear function over each of them. Without a path returns a Density; with `path` writes a .npy, .h5 or .fits, or in 2D
        a .tif.

        Parameters
        ----------
        res
            The width of a pixel or voxel, in units of the coordinates. Along a periodic axis the period must be a multiple of
            it.
        grid
            Instead of `res`, the number of pixels or voxels along all axes, or (nx, ny) or (nx, ny, nz). They fill the period;
            along axes without one `bbox`, or the bounds of the result.
        mass
            The attribute of the vertices that has their masses. None: each point has the mass 1.
        field
            Instead of the density, the mean of this attribute of the vertices.
        divergence, curl, shear
            Instead of the density, the mean divergence, curl, or shear of the vector with these attributes as components.
            The curl is a number in 2D, and a vector in 3D. The shear, the symmetric part of the gradient without its trace,
            has the components xx and xy, in 3D xx, xy, xz, yy and yz.
        sample
            The values at the centres of pixels or voxels, not the means over them.
        bbox
            The box that the grid covers: (xmin, ymin, xmax, ymax), or in 3D (xmin, ymin, zmin, xmax, ymax, zmax). None: the
            bounds of the result, and along a periodic axis the period.
        memory
            The memory for tiles and sums: bytes, or "800M", "4G". None: 70 % of the free memory.
        threads
            The number of threads. 0: all processors.
        overwrite
            Replaces an existing file of the same name. Otherwise such a file is an error.

        The values depend on the triangulation alone, to the last bit. Warns with a UserWarning if there is something to say
        of them. The GIL is released; Ctrl-C leaves nothing half-written.
        """
        asked = {"field": [field] if field is not None else None, "divergence": divergence, "curl": curl,
                 "shear": shear}
        given = {kind: list(names) for kind, names in asked.items() if names is not None}
        if len(given) > 1:
            raise UsageError(" and ".join(given) + " cannot both be on one grid: give one of them")
        kind, names = next(iter(given.items()), ("density", []))
        box = [] if bbox is None else [float(x) for x in np.asarray(bbox, dtype=float).ravel()]
        if (res is None) == (grid is None):
            raise UsageError("give either res, the width of a pixel or voxel, or grid, the number of them")
        voxels = [] if grid is None else [operator.index(n) for n in np.atleast_1d(np.asarray(grid, dtype=object))]
        request = _tessera.DensityRequest(float(res or 0), voxels, box, kind, names, mass or "", bool(sample), memory_bytes(memory), threads)
        if path is None:
            values, origin, widths, total, grid_mass, note = _tessera.draw_density(self._triangulation, request)
        else:
            note = _tessera.write_density(self._triangulation, os.fspath(path), request, bool(overwrite))
        if note:
            warnings.warn(note, stacklevel=2)
        return None if path is not None else Density(values, origin, widths, total, grid_mass)
