"""Alpha shapes and limits of circumradii from Python: the same as of the command."""
import json
import os
import pathlib
import subprocess
import tempfile
import unittest

import numpy as np
import tessera


class AlphaShapes(unittest.TestCase):
    def setUp(self):
        self.held = tempfile.TemporaryDirectory()
        self.addCleanup(self.held.cleanup)
        self.folder = pathlib.Path(self.held.name)
        rng = np.random.default_rng(1)
        self.points = {d: rng.random((500, d)) for d in (2, 3)}
        self.made = {d: tessera.triangulate(points, max_points_per_tile=100, folder=self.folder / f"out{d}")
                     for d, points in self.points.items()}

    def command(self, *arguments):
        done = subprocess.run([os.environ["TESSERA"], *map(str, arguments)], check=True, capture_output=True, text=True)
        return json.loads(done.stdout)

    def test_arrays_are_what_the_command_writes(self):
        for d, t in self.made.items():
            for alpha in "auto", 0.08:
                for general in False, True:
                    with self.subTest(dimension=d, alpha=alpha, general=general):
                        shape = t.alpha_shape(alpha=alpha, general=general)
                        path = self.folder / "command.ply"
                        told = self.command("alpha", t.folder, "--alpha", alpha, "-o", path, "--json", "--overwrite", *["--general"] * general)
                        self.assertEqual((shape.radius, shape.cells, len(shape.ids)), (told["radius"], told["cells"], told["vertices"]))
                        for name in "facets", "singular_facets", "singular_edges", "singular_vertices":
                            self.assertEqual(len(getattr(shape, name)), told[name])
                        np.testing.assert_array_equal(shape.points, self.points[d][shape.ids])
                        self.assertEqual(shape.facets.shape[1], d)
                        self.assertEqual(t.alpha_shape(self.folder / "mine.ply", alpha=alpha, general=general, overwrite=True), shape.radius)
                        self.assertEqual((self.folder / "mine.ply").read_bytes(), path.read_bytes())

    def test_the_area_within_is_that_of_the_cells(self):
        t, shape = self.made[2], self.made[2].alpha_shape(alpha=0.05)
        a, b = (shape.points[shape.facets[:, k]] for k in (0, 1))
        within = (a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]).sum() / 2
        t.export(self.folder / "arrays", format="npy", max_radius=0.05)
        corners = self.points[2][np.load(self.folder / "arrays" / "ids.npy")][np.load(self.folder / "arrays" / "cells.npy")]
        self.assertEqual(len(corners), shape.cells)
        self.assertAlmostEqual(within, np.abs(np.linalg.det(corners[:, 1:] - corners[:, :1])).sum() / 2)

    def test_wrong_radii_are_refused(self):
        for wrong in 0, -1.0, float("nan"), float("inf"), "large":
            with self.assertRaisesRegex(tessera.UsageError, "^alpha: must be a radius"):
                self.made[2].alpha_shape(alpha=wrong)
            if wrong != "large":
                with self.assertRaisesRegex(tessera.UsageError, "^max_radius: must be a length"):
                    self.made[2].export(self.folder / "a.ply", max_radius=wrong)
        with self.assertRaisesRegex(tessera.UsageError, "no cell has a circumradius.*alpha"):
            self.made[2].alpha_shape(self.folder / "a.ply", alpha=1e-9)
        with self.assertRaisesRegex(tessera.UsageError, "3D"):
            self.made[3].alpha_shape(self.folder / "a.gpkg", alpha=1)
        self.assertEqual(len(self.made[2].alpha_shape(alpha=1e-9).facets), 0)

    def test_drawings_leave_out_large_cells(self):
        points = np.c_[self.points[2], np.ones(500)]
        t = tessera.triangulate(points, dim=2, folder=self.folder / "ground")
        limit = 0.04
        self.assertGreater(np.isnan(t.dem(res=0.01, max_radius=limit).values).sum(), np.isnan(t.dem(res=0.01).values).sum())
        self.assertGreater(len(set(t.profile([[0, 0.5], [1, 0.5]], max_radius=limit).parts.tolist())), 1)
        self.assertEqual(t.contours(interval=0.5, base=0.25, max_radius=limit), [])


if __name__ == "__main__":
    unittest.main()
