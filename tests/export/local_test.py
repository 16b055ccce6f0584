"""Exports whose coordinates count from a corner: readers that keep floats keep centimetres, and nothing else is changed."""
import json
import unittest

import numpy as np

import readers
from cli import USAGE
from stored import ExportTest

LOW = (770500, 6277550, -3)


class Local(ExportTest):
    def cloud(self):
        rng = np.random.default_rng(3)
        rows = np.round(rng.random((300, 3)) * [40, 30, 9], 2) + [770500.25, 6277550.5, -2.75]
        return self.write("cloud.xyz", "".join(f"{x:.2f} {y:.2f} {z:.2f}\n" for x, y, z in rows.tolist()))

    def check(self, stored, points, cells, corner, whole=True):
        lifted = np.asarray(points, float)[:, :3] + corner
        self.assertLess(np.abs(lifted[:, :2].min(0) - LOW[:2]).max(), 3)
        expected = np.array(list(stored.points.values()))
        nearest = [expected[np.abs(expected - p).max(1).argmin()] for p in lifted]
        np.testing.assert_allclose(lifted, nearest, rtol=0, atol=1e-5)
        self.check_mesh(stored, nearest, cells, whole=whole)

    def obj(self, path):
        lines = [line.split() for line in path.read_text().splitlines()]
        return (np.array([line[1:] for line in lines if line[0] == "v"], float),
                np.array([line[1:] for line in lines if line[0] == "f"], int) - 1)

    def off(self, path):
        lines = path.read_text().splitlines()
        path.write_text("\n".join(line for line in lines if not line.startswith("#")))
        return readers.off(path)[:2]

    def test_points_count_from_a_whole_numbered_corner(self):
        for dimension, formats in ((2, ("ply", "obj", "off")), (3, ("ply", "off"))):
            corner = (*LOW[:2], LOW[2] if dimension == 3 else 0)
            stored = self.stored(self.cloud(), "--dim", dimension, "--tiles", "4", "--overwrite")
            said = "coordinates count from %d %d %d" % corner
            for name in formats:
                with self.subTest(dimension=dimension, format=name):
                    path = self.folder / f"mesh.{name}"
                    self.assertIn(said, self.ok("export", self.out, "-o", path, "--local", "--overwrite"))
                    self.assertIn(said.encode(), path.read_bytes())
                    if name == "ply":
                        found = readers.ply(path, 3) if dimension == 2 else readers.ply_with_cells(path)
                    else:
                        found = getattr(self, name)(path)
                    self.check(stored, *found[:2], corner)
                    self.assertEqual(json.loads(self.ok("export", self.out, "-o", path, "--local", "--overwrite", "--json"))["corner"],
                                     list(corner))
                    self.assertNotIn("corner", self.ok("export", self.out, "-o", path, "--overwrite", "--json"))
                    self.assertNotIn(b"count from", path.read_bytes())

    def test_the_files_of_all_tiles_have_one_corner(self):
        stored = self.stored(self.cloud(), "--dim", "2", "--tiles", "4")
        folder, cells = self.export("parts", "--format", "obj", "--local"), 0
        for path in folder.iterdir():
            points, triangles = self.obj(path)
            cells += len(triangles)
            self.assertIn("coordinates count from 770500 6277550 0", path.read_text())
            self.assertTrue((points[:, :2] >= 0).all() and (points[:, :2] <= 42).all())
        self.assertEqual(cells, len(stored.cells))

    def test_other_formats_refuse(self):
        self.stored(self.cloud(), "--dim", "2")
        before = self.files()
        for name in ("a.vtu", "a.gpkg", "a.xml", "a.msh"):
            self.refused(USAGE, "export", self.out, "-o", name, "--local", says="--local: works only with ply, obj, off and stl")
        self.assertEqual(self.files(), before)


if __name__ == "__main__":
    unittest.main()
