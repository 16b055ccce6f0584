"""What `tessera measure` has stored, read by the specification of the files alone."""
import json
import pathlib

import numpy as np
from tile_arrays import read_tile


class Measured:
    """volumes: {sorted ids of a cell: value}; stars: {id: value}; cells: as stored, by points; all from main cells."""

    def __init__(self, folder):
        folder = pathlib.Path(folder)
        self.manifest = json.loads((folder / "manifest.json").read_text())
        self.dimension = self.manifest["dimension"]
        name = "area" if self.dimension == 2 else "volume"
        self.volumes, self.stars, self.cells = {}, {}, []
        for entry in self.manifest["tiles"]:
            arrays = read_tile(folder / entry.get("file", "tiles/%06d.vtu" % entry["tile"]))
            ids, points = arrays["PointData/id"], arrays["Points"][:, :self.dimension]
            corners = arrays["Cells/connectivity"].reshape(-1, self.dimension + 1)
            main = arrays["CellData/vtkGhostType"] == 0
            for cell, value in zip(np.sort(ids[corners], axis=1).tolist(), arrays["CellData/" + name].tolist()):
                if self.volumes.setdefault(tuple(cell), value) != value:
                    raise AssertionError(f"cell {cell} has two values")
            for vertex, value in zip(ids.tolist(), arrays["PointData/star_" + name].tolist()):
                if self.stars.setdefault(vertex, value) != value:
                    raise AssertionError(f"vertex {vertex} has two values")
            self.cells.extend(points[corners[main]])
        self.columns = {column["name"]: column for column in self.manifest["columns"]}
        self.total = self.columns[name]["total"]
