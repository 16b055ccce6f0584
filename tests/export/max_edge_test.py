"""Exports without long cells: in every format the same cells, the vertices they have, and nothing else."""
import itertools
import json
import unittest

import numpy as np

import readers
from cli import USAGE
from stored import ExportTest

SOLID = {"vtu": lambda path: readers.vtu(path, 4), "msh": lambda path: readers.by_gmsh(path, 4),
         "mesh": lambda path: readers.by_gmsh(path, 4), "ply": readers.ply_with_cells, "off": readers.off}
FLAT = {"vtu": lambda path: readers.vtu(path, 3), "msh": lambda path: readers.by_gmsh(path, 3),
        "mesh": lambda path: readers.by_gmsh(path, 3), "off": readers.off}
LAYERS = ("geojson", "gpkg", "vrt")


def longest_edge(stored, cell):
    places = [stored.points[i][:stored.dimension] for i in cell]
    return max(np.linalg.norm(np.subtract(a, b)) for a, b in itertools.combinations(places, 2))


def shorten(stored, limit):
    """`stored`, without long cells and without vertices that are left alone. How many cells are left out."""
    before = len(stored.cells)
    stored.cells = [cell for cell in stored.cells if longest_edge(stored, cell) <= limit]
    used = set(itertools.chain.from_iterable(stored.cells))
    stored.points = {i: p for i, p in stored.points.items() if i in used}
    return before - len(stored.cells)


class MaxEdge(ExportTest):
    def short(self, limit, *options, n=900, cloud=None):
        stored = self.stored(cloud or self.xyz(n=n), "--overwrite", *options)
        all_points = len(stored.points)
        self.left_out = shorten(stored, limit)
        self.assertGreater(self.left_out, 0)
        self.assertLess(len(stored.points), all_points, "some vertices are left alone")
        self.assertGreater(len(stored.cells), 50)
        return stored

    def test_every_format_of_solids_holds_the_short_cells(self):
        for more in ([], ["--no-neighbors"]):
            stored = self.short(0.16, "--tiles", "5", *more)
            for ending, read in SOLID.items():
                points, cells, _ = read(self.export(f"mesh.{ending}", "--max-edge", "0.16"))
                self.check_mesh(stored, points, cells)
            points, cells, _ = readers.pvtu(
                self.export("parts", "--format", "vtu", "--max-edge", "0.16") / "triangulation.pvtu", 4)
            self.check_mesh(stored, points, cells, whole=False)
        self.assertFalse((self.export("arrays", "--format", "npy", "--max-edge", "0.16") / "neighbors.npy").exists())

    def test_every_format_of_triangles_holds_the_short_ones_with_and_without_heights(self):
        for more in ([], ["--no-z"]):
            stored = self.short(0.04, "--dim", "2", "--tiles", "6")
            if more:
                stored.points = {i: p[:2] + (0.0,) for i, p in stored.points.items()}
            for ending, read in FLAT.items():
                points, cells, _ = read(self.export(f"mesh.{ending}", "--max-edge", "0.04", *more))
                self.check_mesh(stored, points, cells)
            for ending in LAYERS:
                layer = readers.Layer(self.export(f"mesh.{ending}", "--max-edge", "0.04", *more))
                self.assertEqual(sorted(layer.ids), stored.cells, ending)
            union = readers.Layer(self.export("tables", "--format", "csv", "--max-edge", "0.04") / "triangulation.vrt")
            self.assertEqual(sorted(union.ids), stored.cells)

    def test_arrays_hold_the_neighbours_that_are_left(self):
        for options, limit in ((["--tiles", "5"], 0.16), (["--tiles", "6", "--dim", "2"], 0.04)):
            stored = self.short(limit, *options)
            folder = self.export("arrays", "--format", "npy", "--max-edge", limit)
            points, cells, ids, tile, neighbors = (
                np.load(folder / f"{name}.npy") for name in ("points", "cells", "ids", "tile", "neighbors"))
            self.assertEqual(sorted(map(tuple, ids[cells].tolist())), stored.cells)
            self.assertEqual(sorted(ids.tolist()), sorted(stored.points))
            self.assertEqual([tuple(p) for p in points.tolist()],
                             [stored.points[i][:stored.dimension] for i in ids.tolist()])
            self.assertEqual(len(tile), len(cells))
            self.assertEqual(neighbors.tolist(), readers.neighbors_of(cells).tolist())

    def test_vtu_tells_the_longest_edge_and_the_tile_of_every_cell(self):
        for options in (["--dim", "2"], ["--dim", "3"]):
            stored = self.stored(self.xyz(n=400), "--tiles", "3", "--overwrite", *options)
            for path, read in ((self.export("mesh.vtu"), readers.vtu),
                               (self.export("parts", "--format", "vtu") / "triangulation.pvtu", readers.pvtu)):
                points, cells, data = read(path, stored.corners)
                ids = data["id"]
                expected = [longest_edge(stored, cell) for cell in ids[cells].tolist()]
                arrays = readers.cell_data(path)
                np.testing.assert_allclose(arrays["longest_edge"], expected, rtol=1e-14)
                self.assertEqual(np.bincount(arrays["tile"]).tolist(),
                                 [t["main_cells"] for t in stored.manifest["tiles"]])

    def test_a_cliff_is_no_long_edge(self):
        cloud = self.write("cliff.xyz", "".join(f"{x} {y} {1000 * (x > 2)}\n" for x in range(6) for y in range(6)))
        stored = self.stored(cloud, "--dim", "2")
        points, cells, _ = readers.vtu(self.export("mesh.vtu", "--max-edge", "1.5"), 3)
        self.check_mesh(stored, points, cells)

    def test_tiles_of_which_nothing_is_left_have_no_files(self):
        dense = "".join(f"{x / 10} {y / 10} 0\n" for x in range(30) for y in range(30))
        sparse = "".join(f"{10 + x} {10 * y} 0\n" for x in range(30) for y in range(30))
        self.stored(self.write("both.xyz", dense + sparse), "--dim", "2", "--tiles", "8")
        folder = self.export("parts", "--format", "ply", "--max-edge", "0.2")
        kept = {path.name for path in folder.iterdir()}
        self.assertTrue(kept)
        self.assertLess(len(kept), 8)
        self.assertEqual(len(list(self.export("parts", "--format", "ply").iterdir())), 8)
        self.refused(USAGE, "export", self.out, "-o", "parts", "--format", "ply", "--max-edge", "0.2", "--overwrite",
                     says="would stay")

    def test_the_summary_says_how_many_are_left_out(self):
        stored = self.short(0.16, "--tiles", "5")
        told = self.ok("export", self.out, "-o", "a.vtu", "--max-edge", "0.16")
        self.assertIn(f"{len(stored.points)} vertices", told.replace(" ", "", 1).replace("\u202f", ""))
        self.assertIn("longer edges than 0.16 are left out", told)
        event = json.loads(self.ok("export", self.out, "-o", "b.vtu", "--max-edge", "0.16", "--json"))
        self.assertEqual((event["vertices"], event["cells"], event["left_out"]),
                         (len(stored.points), len(stored.cells), self.left_out))
        self.assertNotIn("left out", self.ok("export", self.out, "-o", "c.vtu"))

    def test_when_nothing_is_left_the_shortest_longest_edge_is_named(self):
        stored = self.stored(self.xyz(n=200), "--tiles", "3")
        shortest = min(longest_edge(stored, cell) for cell in stored.cells)
        before = self.files()
        for target in (["-o", "a.vtu"], ["-o", "tiles", "--format", "ply"], ["-o", "arrays", "--format", "npy"]):
            self.refused(USAGE, "export", self.out, *target, "--max-edge", "1e-6",
                         says=["no cell is left", repr(shortest)[:12], "--max-edge"])
        self.assertEqual(self.files(), before)
        self.ok("export", self.out, "-o", "a.vtu", "--max-edge", repr(shortest * (1 + 1e-15)))

    def test_wrong_lengths_are_refused(self):
        self.stored(self.xyz(n=50))
        for wrong in ("0", "-1", "nan", "inf", "two", "1e999", ""):
            self.refused(USAGE, "export", self.out, "-o", "a.vtu", "--max-edge=" + wrong, says="--max-edge")
        config = self.write("wrong.toml", "[export]\nmax-edge = -2\n")
        self.refused(USAGE, "export", self.out, "-o", "a.vtu", "--config", config, says=["line 2", "max-edge"])


if __name__ == "__main__":
    unittest.main()
