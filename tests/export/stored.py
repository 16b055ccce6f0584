"""The result that the command wrote, as its specification says, and results to export."""
import json
import pathlib
import shutil

import numpy as np
from cli import CliTest
from tile_arrays import read_tile


class Stored:
    """What an export must hold: points by id, and the main cells by the ids of their vertices, in order."""

    def __init__(self, folder):
        self.manifest = json.loads((pathlib.Path(folder) / "manifest.json").read_text())
        self.dimension = self.manifest["dimension"]
        self.corners = self.dimension + 1
        self.points, self.attributes, cells = {}, {}, []
        for entry in self.manifest["tiles"]:
            arrays = read_tile(pathlib.Path(folder) / "tiles" / ("%06d.vtu" % entry["tile"]))
            ids = arrays["PointData/id"]
            main = arrays["CellData/vtkGhostType"] == 0
            cells.append(ids[arrays["Cells/connectivity"].reshape(-1, self.corners)[main]])
            self.points.update(zip(ids.tolist(), map(tuple, arrays["Points"].tolist())))
            for attribute in self.manifest["attributes"]:
                values = arrays["PointData/" + attribute["name"]]
                self.attributes.setdefault(attribute["name"], {}).update(zip(ids.tolist(), values.tolist()))
        if "z" in self.attributes:
            self.points = {i: (x, y, self.attributes["z"][i]) for i, (x, y, _) in self.points.items()}
        self.cells = sorted(map(tuple, np.concatenate(cells).tolist()))


def volumes(corners):
    """Of cells given as an array m x (d+1) x d: signed areas or volumes."""
    edges = corners[:, 1:] - corners[:, :1]
    return np.linalg.det(edges) / (2 if corners.shape[2] == 2 else 6)


class ExportTest(CliTest):
    def stored(self, cloud, *options):
        self.ok("triangulate", cloud, "-o", self.out, "--quiet", *options)
        return Stored(self.out)

    def export(self, target, *options):
        shutil.rmtree(self.folder / target, ignore_errors=True)  # a folder of an earlier export
        self.ok("export", self.out, "-o", target, "--quiet", "--overwrite", *options)
        return self.folder / target

    def check_mesh(self, stored, points, cells, whole=True, flat=False):
        """Points bit for bit, cells vertex for vertex; `points` of a merged file are all the result's, each once."""
        expected = {i: p[:2] + (0.0,) for i, p in stored.points.items()} if flat else stored.points
        by_place = {np.array(p).tobytes(): i for i, p in expected.items()}
        self.assertEqual(len(by_place), len(expected))
        ids = np.array([by_place[np.array(p, dtype=float).tobytes()] for p in np.asarray(points)])
        if whole:
            self.assertEqual(sorted(ids), sorted(expected))
        self.assertEqual(sorted(map(tuple, ids[np.asarray(cells)].tolist())), stored.cells)
        return ids
