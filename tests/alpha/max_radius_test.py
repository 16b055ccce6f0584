"""--max-radius: the commands leave out exactly the cells of a larger circumradius, by fractions; beside --max-edge."""
import json
import math
import shutil
import unittest

import numpy as np
from cli import USAGE, CliTest
from command_test import rounded_up, squared_radius
from stored import Stored


class MaxRadius(CliTest):
    def setUp(self):
        super().setUp()
        rng = np.random.default_rng(2)
        lattice = np.stack(np.meshgrid(np.arange(10.0), np.arange(10.0)), -1).reshape(-1, 2)
        self.points = np.c_[np.concatenate([lattice, 10 * rng.random((60, 2)), [[14, 5]]]), 1 + rng.random(161)]

    def triangulate(self, points, d):
        np.save(self.folder / "cloud.npy", points)
        self.ok("triangulate", self.folder / "cloud.npy", "-o", self.out, "--overwrite", "--quiet", "--dim", d, "--tiles", "5")
        stored = Stored(self.out)
        radii = {cell: rounded_up(*squared_radius([stored.points[v][:d] for v in cell])) for cell in stored.cells}
        return stored, radii

    def told(self, *order):
        shutil.rmtree(self.folder / "arrays", ignore_errors=True)  # an export does not replace files of another shape
        return json.loads(self.ok(*order, "--overwrite", "--json").splitlines()[-1])

    def test_exports_have_the_cells_within_the_limit(self):
        for d in 2, 3:
            stored, radii = self.triangulate(self.points, d)
            some = sorted(radii.values())[len(radii) // 2]
            for limit in some, math.nextafter(some, 0), math.sqrt(0.5), math.nextafter(math.sqrt(0.5), 0):
                with self.subTest(dimension=d, limit=limit):
                    order = ("export", self.out, "-o", "arrays", "--format", "npy", "--max-radius", repr(limit))
                    kept = sorted(cell for cell, radius in radii.items() if radius <= limit)
                    told = self.told(*order)
                    self.assertEqual((told["cells"], told["left_out"]), (len(kept), len(radii) - len(kept)))
                    ids = np.load(self.folder / "arrays" / "ids.npy")
                    cells = ids[np.load(self.folder / "arrays" / "cells.npy")]
                    self.assertEqual(sorted(map(tuple, cells.tolist())), kept)
                    longest = {cell: max(math.dist(stored.points[u][:d], stored.points[v][:d]) for u in cell for v in cell) for cell in kept}
                    both = self.told(*order, "--max-edge", "0.8")
                    self.assertEqual(both["cells"], sum(length <= 0.8 for length in longest.values()))
            least = min(radii.values())
            self.refused(USAGE, "export", self.out, "-o", "a.vtu", "--max-radius", repr(math.nextafter(least, 0)),
                         says=["no cell is left", repr(least), "--max-radius"])
            self.refused(USAGE, "export", self.out, "-o", "a.vtu", "--max-radius", "1e-9", "--max-edge", "1e-9",
                         says=["no cell is left", "--max-edge", "--max-radius"])
            self.assertIn("larger circumradii than 0.5 are left out", self.ok("export", self.out, "-o", f"{d}.vtu", "--max-radius", "0.5"))

    def test_drawings_leave_the_same_cells_out(self):
        stored, radii = self.triangulate(self.points, 2)
        limit = 0.75
        kept = [cell for cell, radius in radii.items() if radius <= limit]
        left_out = len(radii) - len(kept)
        self.assertGreater(left_out, 0)
        self.assertEqual(self.told("contours", self.out, "--interval", "0.1", "-o", "a.geojson", "--max-radius", limit)["left_out"], left_out)
        self.assertEqual(self.told("tileset", self.out, "-o", "tiles", "--max-radius", limit)["left_out"], left_out)
        told = self.told("dem", self.out, "--res", "0.1", "-o", "a.tif", "--max-radius", limit)
        self.assertEqual(told["left_out"], left_out)
        whole = self.told("dem", self.out, "--res", "0.1", "-o", "a.tif")
        area = sum(abs(np.linalg.det(np.diff([stored.points[v][:2] for v in cell], axis=0))) / 2 for cell in kept)
        self.assertLess(told["pixels"], whole["pixels"])
        self.assertLess(abs(told["pixels"] / 100 - area), 0.05 * area)
        line = ("--line", "-1,5.05 15,5.05")
        gaps = self.told("profile", self.out, *line, "-o", "a.csv", "--max-radius", limit)
        self.assertGreater(gaps["after"], self.told("profile", self.out, *line, "-o", "a.csv")["after"])

    def test_wrong_limits_are_refused(self):
        self.triangulate(self.points, 2)
        for wrong in "0", "-1", "nan", "inf", "x":
            for order in (("export", "-o", "a.vtu"), ("dem", "--res", "1", "-o", "a.tif"), ("contours", "--interval", "1", "-o", "a.gpkg"),
                          ("profile", "--line", "0,0 1,1"), ("tileset", "-o", "tiles")):
                self.refused(USAGE, order[0], self.out, *order[1:], "--max-radius=" + wrong, says="--max-radius")


if __name__ == "__main__":
    unittest.main()
