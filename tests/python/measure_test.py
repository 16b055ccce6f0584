"""t.measure() and t.columns."""
import pickle
import unittest

import numpy as np
import tessera

import clouds
from triangulation_test import FolderTest


def volumes(points, cells):
    edges = points[cells[:, 1:]] - points[cells[:, :1]]
    return np.linalg.det(edges) / (2 if points.shape[1] == 2 else 6)


class Measure(FolderTest):
    def test_columns_have_the_order_of_simplices_and_points(self):
        for dim, name, store in (2, "area", "cells"), (3, "volume", "cells"), (2, "area", "points"), (3, "volume", "points"):
            points = np.concatenate([clouds.random(800, dim), clouds.random(1, dim)])
            points[-1] = points[0]  # a duplicate
            t = tessera.triangulate(points, max_points_per_tile=200, store=store)
            self.assertEqual((len(t.columns), repr(t.columns)), (0, "<tessera.Columns: none>"))
            measured = t.measure(volume=True, threads=2, memory="500M")
            self.assertTrue(measured.made)
            self.assertEqual(list(t.columns), [name, "star_" + name])
            self.assertEqual(t.columns.info[name]["of"], "cells")
            cells = t.simplices()
            expected = volumes(points, cells)
            np.testing.assert_allclose(t.columns[name], expected, rtol=1e-6)
            self.assertAlmostEqual(measured.total, expected.sum(), places=12)
            stars = np.zeros(len(points))
            np.add.at(stars, cells, t.columns[name][:, None])
            found = t.columns["star_" + name]
            self.assertTrue(np.isnan(found[-1]))
            np.testing.assert_allclose(found[:-1], stars[:-1], rtol=1e-12)
            again = t.measure(volume=True)
            self.assertEqual((again.made, again.total), (False, measured.total))
            with self.assertRaises(KeyError):
                t.columns["none"]

    def test_tiles_have_them(self):
        for store in "cells", "points":
            with self.subTest(store):
                self.look_at_tiles(tessera.triangulate(clouds.random(500, 3), max_points_per_tile=200, store=store))

    def look_at_tiles(self, t):
        before = t[0]
        t.measure(volume=True)
        after = t[0]
        self.assertEqual((list(before.cell_columns), list(before.attributes)), ([], []))
        self.assertEqual((list(after.cell_columns), list(after.attributes)), (["volume"], ["star_volume"]))
        np.testing.assert_array_equal(before.cells, after.cells)
        copy = pickle.loads(pickle.dumps(after))
        np.testing.assert_array_equal(copy.cell_columns["volume"], after.cell_columns["volume"])
        self.assertGreater(t.interpolate([[0.5, 0.5, 0.5]], value="star_volume")[0], 0)
        self.assertEqual([column["name"] for column in t.info()["columns"]], ["volume", "star_volume"])
        t.verify()

    def test_densities(self):
        for dim in 2, 3:
            points = np.concatenate([clouds.random(400, dim), clouds.random(400, dim)[:10]])
            t = tessera.triangulate(points, max_points_per_tile=100)
            grid = t.density(res=0.125)
            self.assertEqual((grid.values.ndim, grid.mass, len(grid.origin)), (dim, 410, dim))
            self.assertAlmostEqual(grid.values.sum() * 0.125 ** dim, 410, places=8)
            t.density(self.folder / f"grid{dim}.npy", res=0.125)
            np.testing.assert_array_equal(np.load(self.folder / f"grid{dim}.npy"), grid.values)
            self.assertTrue(t.measure(density=True).made)
            names = ["density"] * dim
            curl = t.density(res=0.25, curl=names, bbox=[0.25] * dim + [0.75] * dim).values
            self.assertEqual(curl.shape, (2, 2) if dim == 2 else (2, 2, 2, 3))
            box = tessera.triangulate(np.round(points * 2**30) / 2**30, periodic=1, max_points_per_tile=100)  # no rounding
            grid = box.density(grid=(8, 5, 3)[:dim])
            self.assertEqual(grid.values.shape, (8, 5, 3)[:dim][::-1])
            self.assertEqual((grid.origin, grid.widths, grid.res), ((0,) * dim, (1 / 8, 1 / 5, 1 / 3)[:dim], None))
            self.assertAlmostEqual(grid.values.sum() * np.prod(grid.widths), 410, places=8)
            self.assertEqual(box.density(res=0.25).res, 0.25)
            self.assertTrue(box.measure(density=True).made)
            shear = box.density(grid=np.int64(4), shear=names).values
            self.assertEqual(shear.shape, (4,) * dim + ((2,) if dim == 2 else (5,)))
            with self.assertRaisesRegex(tessera.UsageError, "res: does not divide the period 1 along x"):
                box.density(res=0.3)
            for options in ({}, {"res": 1, "grid": 4}):
                with self.assertRaisesRegex(tessera.UsageError, "give either res, the width of a pixel or voxel, or grid"):
                    box.density(**options)
            with self.assertRaisesRegex(tessera.UsageError, "field and curl cannot both be on one grid"):
                t.density(res=1, field="density", curl=names)
            with self.assertRaisesRegex(tessera.UsageError, "bbox"):
                t.density(res=1, bbox=[1, 2, 3])

    def test_nothing_to_measure_is_told(self):
        t = tessera.triangulate(clouds.random(50, 2))
        with self.assertRaisesRegex(tessera.UsageError, "there is nothing to measure; volume=True and quality=True measure cells, voronoi=True measures the Voronoi cells of vertices, density=True the densities of vertices"):
            t.measure()


if __name__ == "__main__":
    unittest.main()
