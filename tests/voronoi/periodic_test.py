"""tessera voronoi of periodic results: the whole cells of the points in the box, unwrapped; they fill the box."""
import unittest

import numpy as np
from cells import VoronoiTest
from cli import USAGE
from space_test import Polyhedra


def uniform(n, d, seed=1):
    return np.random.default_rng(seed).integers(0, 2**30, (n, d)) / 2**30


def lattice(side, d):
    return np.stack(np.meshgrid(*[np.arange(float(side))] * d, indexing="ij"), -1).reshape(-1, d)


class Periodic(VoronoiTest):
    def test_polygons_fill_the_box_around_their_points(self):
        for points, side in ((uniform(500, 2), 1), (uniform(3, 2, 2), 1), (uniform(1, 2, 3), 1), (lattice(7, 2), 7), (lattice(1, 2), 1)):
            files = []
            for tiles in 1, 4, 30:
                out = self.triangulate(points, "--periodic", side, "--tiles", tiles)
                said = self.write_cells(out)
                self.assertEqual((said["cells"], said["unbounded"], said["shapeless"]), (len(points), 0, 0))
                self.assertAlmostEqual(said["area"] / side**2, 1, delta=1e-12)
                files.append((self.folder / "cells.csv").read_bytes())
            self.assertEqual(files[1:], files[:1] * 2)
            for vertex, (geometry, row) in self.cells().items():
                corners = np.array(geometry.GetGeometryRef(0).GetPoints())[:-1, :2] - points[vertex]
                self.assertAlmostEqual(float(row["area"]), geometry.GetArea(), delta=1e-13 * side**2)
                # No image of a point is nearer to a corner, and the point is within the cell.
                self.assertTrue((corners.min(axis=0) < 0).all() and (corners.max(axis=0) > 0).all())
                images = (points[:, None] + side * (lattice(5, 2) - 2)[None]).reshape(-1, 2) - points[vertex]
                nearest = np.linalg.norm(corners[:, None] - images[None], axis=2).min(axis=1)
                np.testing.assert_allclose(nearest, np.linalg.norm(corners, axis=1), rtol=1e-9)
            for name in "cells.gpkg", "cells.geojson":
                self.write_cells(out, name=name)

    def test_polyhedra_fill_the_box(self):
        for points, side in ((uniform(200, 3), 1), (uniform(2, 3, 2), 1), (uniform(1, 3, 3), 1), (lattice(4, 3), 4), (lattice(1, 3), 1)):
            files = []
            for options in (["--tiles", 1], ["--tiles", 5], ["--tiles", 5, "--store", "points"]):
                out = self.triangulate(points, "--periodic", side, *options)
                said = self.write_cells(out, name="cells.vtu")
                self.assertEqual((said["cells"], said["unbounded"], said["thin"]), (len(points), 0, 0))
                self.assertAlmostEqual(said["volume"] / side**3, 1, delta=1e-12)
                files.append((self.folder / "cells.vtu").read_bytes())
            self.assertEqual(files[1:], files[:1] * 2)
            shapes = Polyhedra(self.folder / "cells.vtu")
            np.testing.assert_array_equal(shapes.data["id"], np.arange(len(points)))
            for vertex, faces in enumerate(shapes.cells):
                corners = shapes.points[sorted({c for face in faces for c in face})] - points[vertex]
                self.assertTrue((corners.min(axis=0) < 0).all() and (corners.max(axis=0) > 0).all())
                self.assertLess(np.abs(corners).max(), side)
            if (points % 1 == 0).all():
                np.testing.assert_allclose(shapes.data["volume"], 1, rtol=1e-14)
                np.testing.assert_allclose(shapes.data["centroid"], points, atol=1e-14)

    def test_axes_without_a_period_have_a_hull(self):
        out = self.triangulate(uniform(300, 2), "--periodic", "1,0", "--tiles", 3)
        said = self.write_cells(out)
        self.assertTrue(0 < said["unbounded"] < 100)
        self.assertEqual(said["cells"], 300)

    def test_a_clip_is_refused(self):
        out = self.triangulate(uniform(50, 2), "--periodic", "1")
        for clip in "hull", "0,0,1,1":
            self.refused(USAGE, "voronoi", out, "-o", "cells.csv", "--clip", clip, says=["are written whole", "leave --clip out"])
        self.write_cells(out, "--clip", "none")


if __name__ == "__main__":
    unittest.main()
