"""Voids of a result."""
from __future__ import annotations

import os

import numpy as np
import numpy.typing as npt

from . import _tessera
from ._options import Path, memory_bytes


class Voids:
    """The voids of a Triangulation."""

    _triangulation: _tessera.Triangulation
    _questions: object

    def voids(self, path: Path | None = None, *, by: str = "voronoi", memory: int | str | None = None, threads: int = 0,
              overwrite: bool = False) -> npt.NDArray[np.void]:
        """Finds voids by a watershed of the density, as ZOBOV does: docs/voids.md defines them. Adds the column "zone" of
        vertices to the result folder, as a new version of the result: the row of the core of the vertex's zone; -1: in no
        zone. This object becomes the new version. Returns a structured array with a row a zone, in the order of the cores:

        zone, core_density, x, y, z
            The row of the core in the input, its density and place.
        zone_points, zone_volume
            The points of the zone, and the sum of their Voronoi cells (in 2D areas).
        saddle_vertex, saddle_density, parent
            Where the void of the zone flows out, and the core of the zone of whose void this one is a part; -1: nowhere.
        void_zones, void_points, void_volume, contrast, probability
            Of the void: its zones, their points and volume, the density of the saddle divided by the core's, and how
            probable that is by chance.

        Parameters
        ----------
        path
            A file to write, too: a .csv, or a .txt for the files .txt, .zone and .void of ZOBOV.
        by
            The density of a vertex: "voronoi", 1 over the volume of its Voronoi cell; "density" or "density_NAME", the
            columns of measure(). The column of zones is then "zone_density", .... Missing columns are computed.
        memory
            The memory for tiles: bytes, or "800M", "4G". None: 70 % of the free memory.
        threads
            The number of threads. 0: all processors.
        overwrite
            Replaces existing files.
        """
        found, _, _, _ = self._triangulation.find_voids(by, os.fspath(path) if path is not None else "", bool(overwrite),
                                                        memory_bytes(memory), threads)
        self._questions = None
        return found
