"""Exports of periodic results: vertices are images, each once, and cells are in one piece."""
import csv
import itertools
import json
import unittest

import numpy as np

import readers
from cli import USAGE
from stored import ExportTest
from tile_arrays import read_tile

FLAT = "ply vtu off obj stl glb mesh msh mshb dxf landxml npy geojson gpkg csv".split()
ENDINGS = {"mshb": ".msh", "landxml": ".xml"}
SOLID = "ply vtu off mesh msh mshb npy".split()


def key_of(corners):
    """Of a cell with the vertices [(id, offset)]: such that the least one has the offset 0."""
    corners = sorted((int(i), tuple(map(int, o))) for i, o in corners)
    least = corners[0][1]
    return tuple((i, tuple(a - b for a, b in zip(o, least))) for i, o in corners)


def exact(points):
    return np.round(np.asarray(points, float) * 2**30) / 2**30


def clouds():
    rng = np.random.default_rng(3)
    lattice = np.stack(np.meshgrid(*[np.arange(4.0)] * 3, indexing="ij"), -1).reshape(-1, 3)
    yield "uniform", exact(rng.random((400, 3))), "1,1,1"
    yield "open", exact(rng.random((300, 3))), "1,0,1"
    yield "flat", exact(rng.random((300, 2))), "1,1"
    yield "strip", exact(rng.random((200, 2))), "0,1"
    yield "lattice", lattice, "4,4,4"
    yield "few", exact(rng.random((3, 3))), "1,1,1"
    yield "one", np.array([[0.25, 0.5]]), "1,2"


class Exports(ExportTest):
    def made(self, points, periods, *options):
        np.save(self.folder / "cloud.npy", points)
        self.ok("triangulate", "cloud.npy", "-o", self.out, "--overwrite", "--quiet", "--dim", points.shape[1],
                "--periodic", periods, *options)
        self.period = np.array([float(p) for p in periods.split(",")])
        manifest = json.loads((self.out / "manifest.json").read_text())
        keys = []
        for entry in manifest["tiles"]:
            arrays = read_tile(self.out / "tiles" / ("%06d.vtu" % entry["tile"]))
            ids = arrays["PointData/id"]
            offsets = arrays.get("PointData/period_offset", np.zeros((len(ids), 3), int))
            cells = arrays["Cells/connectivity"].reshape(-1, points.shape[1] + 1)[arrays["CellData/vtkGhostType"] == 0]
            keys += [key_of([(ids[v], offsets[v]) for v in cell]) for cell in cells]
        self.keys = sorted(keys)

    def check(self, points, at, ids, offsets, cells, whole=True):
        """Vertices lie where their offsets say, no image comes twice, and the cells are those of the result."""
        d = points.shape[1]
        self.assertTrue((at[:, :d] == points[ids] + offsets[:, :d] * self.period).all())
        if whole:
            self.assertEqual(len(set(zip(ids.tolist(), map(tuple, offsets.tolist())))), len(ids))
            self.assertEqual(np.bincount(ids[~offsets.any(axis=1)], minlength=len(points)).tolist(), [1] * len(points))
        self.assertEqual(sorted(key_of([(ids[v], offsets[v]) for v in cell]) for cell in cells), self.keys)
        # A vertex that is no point of the box is there because a cell has it.
        self.assertTrue(set(np.flatnonzero(offsets.any(axis=1))) <= set(np.unique(cells)))

    def test_vertices_are_images_and_cells_are_those_of_the_result(self):
        for (name, points, periods), tiles in itertools.product(clouds(), (1, 7)):
            with self.subTest(cloud=name, tiles=tiles):
                self.made(points, periods, "--tiles", tiles)
                d = points.shape[1]
                at, cells, data = readers.vtu(self.export("mesh.vtu"), d + 1)
                self.check(points, at, data["id"].astype(int), data["period_offset"], cells)
                if d == 3:
                    at, cells, data = readers.ply_with_cells(self.export("mesh.ply"))
                    offsets = np.column_stack([data["period_offset_" + axis] for axis in "xyz"]).astype(int)
                    self.check(points, at, data["id"].astype(int), offsets, cells)
                self.check_arrays(points)
                folder = self.export("parts", "--format", "vtu")
                at, cells, data = readers.pvtu(folder / "triangulation.pvtu", d + 1)
                self.check(points, at, data["id"].astype(int), data["period_offset"], cells, whole=False)

    def check_arrays(self, points):
        folder = self.export("arrays", "--format", "npy")
        at, ids, offsets, cells, neighbors = (np.load(folder / f"{name}.npy")
                                              for name in ("points", "ids", "period_offset", "cells", "neighbors"))
        self.assertEqual(offsets.dtype, np.int8)
        self.check(points, at, ids.astype(int), offsets, cells)
        facets = {}
        corners = [[(ids[v], offsets[v]) for v in cell] for cell in cells]
        for c, cell in enumerate(corners):
            for k in range(len(cell)):
                facets.setdefault(key_of(cell[:k] + cell[k + 1:]), []).append((c, k))
        expected = np.full(cells.shape, -1)
        for (c, k), (other, j) in (sides for sides in facets.values() if len(sides) == 2):
            expected[c, k], expected[other, j] = other, c
        self.assertTrue((neighbors == expected).all())
        if (self.period > 0).all():
            self.assertTrue((neighbors >= 0).all())

    def test_every_format_takes_a_periodic_result(self):
        for points, periods, formats in ((exact(np.random.default_rng(1).random((200, 2))), "1,1", FLAT),
                                         (exact(np.random.default_rng(1).random((200, 3))), "1,1,1", SOLID)):
            self.made(points, periods, "--tiles", 4)
            for name in formats:
                with self.subTest(format=name, dimension=points.shape[1]):
                    if name == "npy":
                        self.assertTrue((self.export("arrays", "--format", name) / "period_offset.npy").exists())
                    else:
                        self.assertGreater(self.export("one" + ENDINGS.get(name, "." + name), "--format", name).stat().st_size, 1000)
                        self.assertEqual(len(list(self.export(f"{name}-tiles", "--format", name).glob("0*"))), 4)

    def test_a_whole_period_is_filled_once(self):
        self.made(exact(np.random.default_rng(5).random((300, 3))), "1,1,1", "--tiles", 5)
        at, cells, _ = readers.by_gmsh(self.export("mesh.msh"), 4)
        edges = at[cells][:, 1:] - at[cells][:, :1]
        self.assertAlmostEqual(np.linalg.det(edges).sum() / 6, 1, places=12)
        self.assertGreater(np.linalg.det(edges).min(), 0)

    def test_cells_of_maps_have_the_offsets_of_their_corners(self):
        points = exact(np.random.default_rng(2).random((100, 2)))
        self.made(points, "1,1", "--tiles", 3)
        rows = list(csv.DictReader(self.export("mesh.csv").read_text().splitlines()))
        keys = [key_of([(row[f"v{k}"], (row[f"v{k}_offset_x"], row[f"v{k}_offset_y"], 0)) for k in range(3)]) for row in rows]
        self.assertEqual(sorted(keys), self.keys)
        features = json.loads(self.export("mesh.geojson").read_text())["features"]
        for feature in features:
            told = feature["properties"]
            for k, corner in enumerate(feature["geometry"]["coordinates"][0][:3]):
                offset = [told[f"v{k}_offset_x"], told[f"v{k}_offset_y"]]
                self.assertEqual(corner[:2], (points[told[f"v{k}"]] + offset).tolist())

    def test_long_edges_are_left_out_in_one_piece(self):
        points = exact(np.random.default_rng(4).random((300, 3)))
        for tiles in (1, 6):
            self.made(points, "1,1,1", "--tiles", tiles)
            at, cells, data = readers.vtu(self.export("mesh.vtu", "--max-edge", "0.2"), 4)
            self.assertEqual(sorted(np.unique(cells)), list(range(len(at))))
            whole = readers.vtu(self.export("all.vtu"), 4)
            longest = lambda at, cells: np.max([np.linalg.norm(at[cells[:, i]] - at[cells[:, j]], axis=1)
                                                for i, j in itertools.combinations(range(4), 2)], axis=0)
            self.assertEqual(len(cells), (longest(whole[0], whole[1]) <= 0.2).sum())
            self.assertLessEqual(longest(at, cells).max(), 0.2)

    def test_bytes_depend_on_the_tiles_alone(self):
        points = exact(np.random.default_rng(6).random((500, 3)))
        files = {}
        for threads, store in ((1, "cells"), (3, "cells"), (2, "points")):
            self.made(points, "1,1,1", "--tiles", 5, "--threads", threads, "--store", "cells")
            if store == "points":
                self.ok("triangulate", "cloud.npy", "-o", self.out, "--overwrite", "--quiet", "--periodic", "1", "--tiles", 5, "--store", store)
            for ending in ("ply", "vtu", "off"):
                made = self.export(f"mesh.{ending}").read_bytes()
                self.assertEqual(files.setdefault(ending, made), made)


class Refusals(ExportTest):
    def test_a_column_of_another_export_is_refused(self):
        self.stored(self.xyz(n=50))
        for target in ("mesh.ply", "box.vol"):
            self.refused(USAGE, "export", self.out, "-o", target, "--names", "mass", says="--names: works only with h5, fits, table and ndnet")


if __name__ == "__main__":
    unittest.main()
