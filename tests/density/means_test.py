"""tessera density: means over pixels and voxels against fractions, masses, and the same bytes for all tiles."""
import json
import os
import pathlib
import unittest

import numpy as np
import scipy.interpolate
import scipy.spatial
from cli import USAGE
from exact_clip import densities, integrals
from gridded import DensityTest, clouds, lattice

ROOT = pathlib.Path(__file__).resolve().parents[2]
MORE = ROOT.parent / "shared" / "data"  # further clouds, which need not be there


class Means(DensityTest):
    def test_means_are_those_of_exact_clipping(self):
        for d in 2, 3:
            for name, (points, res) in clouds(d).items():
                with self.subTest(dimension=d, cloud=name):
                    self.triangulate(points, "--tiles", "3")
                    arrays = self.cells()
                    self.assertEqual(len(arrays["points"]), len(points))
                    exact = densities(arrays["points"], arrays["cells"], np.ones(len(points)))
                    expected = integrals(arrays["points"], arrays["cells"], exact, res)
                    values, said = self.grid("--res", repr(res))
                    first, voxel = self.first(said), float(res) ** d
                    largest = max(float(i) for i, _ in expected.values())
                    for at in np.ndindex(values.shape):
                        right = float(expected.pop(tuple((first + at).tolist()), (0, 0))[0]) / voxel
                        self.assertAlmostEqual(values[at], right, delta=1e-13 * largest / voxel + 1e-12 * right)
                    self.assertEqual(expected, {})
                    self.assertAlmostEqual(said["mass"], len(points), delta=0)
                    self.assertAlmostEqual(said["grid_mass"] / len(points), 1, delta=1e-13)

    def test_cells_are_those_of_scipy(self):
        rng = np.random.default_rng(5)
        for d in 2, 3:
            points = rng.random((60, d))
            self.triangulate(points, "--tiles", "4")
            arrays = self.cells()
            mine = {tuple(sorted(c)) for c in arrays["ids"][arrays["cells"]].tolist()}
            self.assertEqual(mine, {tuple(sorted(c)) for c in scipy.spatial.Delaunay(points).simplices.tolist()})

    def test_the_grid_has_the_mass_of_the_points(self):
        rng = np.random.default_rng(3)
        for d, res in (2, 0.013), (3, 0.11):
            masses = rng.random(3000) * 10.0 ** rng.integers(-8, 8, 3000)
            points = np.column_stack([rng.random((3000, d)) ** 3, masses])
            points = np.vstack([points, points[:200]])  # duplicates
            self.triangulate(points, "--tiles", "6", names=["m"])
            values, said = self.grid("--res", res)
            self.assertEqual(said["mass"], 3200)
            self.assertAlmostEqual(values.sum() * res ** d / 3200, 1, delta=1e-12)
            values, said = self.grid("--res", res, "--mass", "m")
            self.assertAlmostEqual(values.sum() * res ** d / masses.sum(), 1, delta=1e-12)
            self.assertAlmostEqual(said["grid_mass"] / said["mass"], 1, delta=1e-13)
            self.assertIn("the 200 duplicates have no part in the masses", said["note"])

    def test_bytes_are_the_same_for_all_tiles_threads_and_memory(self):
        rng = np.random.default_rng(9)
        for d in 2, 3:
            for name, points in (("random", rng.random((600, d)) * [1, 3, 2][:d]), ("lattice", lattice(30 if d == 2 else 9, d)),
                                 ("spread", rng.random((400, d)) * 10.0 ** rng.integers(-6, 2, (400, d)))):
                res = repr(float(np.ptp(points, axis=0).max()) / 25)
                for options in ([], ["--sample"]):
                    first = None
                    for tiles, store, threads, memory in (1, "cells", 1, "4G"), (7, "points", 2, "64M"), (60, "cells", 3, "1G"):
                        self.triangulate(points, "--tiles", tiles, "--partition", "random" if tiles == 7 else "kdtree",
                                         "--store", store)
                        self.ok("density", self.out, "--res", res, "-o", "grid.npy", "--overwrite", "--quiet",
                                "--threads", threads, "--memory", memory, *options)
                        found = (self.folder / "grid.npy").read_bytes()
                        first = first or found
                        self.assertEqual(found, first, (d, name, options, tiles))

    def test_samples_are_linear_between_the_vertices(self):
        rng = np.random.default_rng(4)
        for d in 2, 3:
            points = rng.random((200, d))
            self.triangulate(points, "--tiles", "5")
            arrays = self.cells()
            exact = np.array([float(x) for x in densities(arrays["points"], arrays["cells"], np.ones(200))])
            values, said = self.grid("--res", "0.083", "--sample")
            centres = (np.stack(np.meshgrid(*map(np.arange, values.shape), indexing="ij"), -1) + self.first(said) + 0.5) * 0.083
            right = np.nan_to_num(scipy.interpolate.LinearNDInterpolator(arrays["points"], exact)(centres))
            np.testing.assert_allclose(values, right, rtol=1e-9, atol=1e-9)

    def test_each_centre_of_a_lattice_has_one_cell(self):
        # Centres are vertices, and on edges and facets. Those on the greater sides of the hull are outside.
        for d in 2, 3:
            self.triangulate(lattice(5, d) + 0.5, "--tiles", "4")
            values, _ = self.grid("--res", "1", "--sample", "--bbox", ",".join(["0"] * d + ["6"] * d))
            known = values > 0
            self.assertTrue(known[(slice(0, 4),) * d].all())
            self.assertEqual(known.sum(), 4 ** d)

    def test_a_box_gives_a_part_of_the_grid(self):
        rng = np.random.default_rng(8)
        for d in 2, 3:
            self.triangulate(rng.random((500, d)), "--tiles", "3")
            whole, about = self.grid("--res", "0.125")
            part, said = self.grid("--res", "0.125", "--bbox", ",".join(["0.25"] * d + ["0.75"] * d))
            shift = self.first(said) - self.first(about)
            np.testing.assert_array_equal(part, whole[tuple(slice(s, s + n) for s, n in zip(shift, part.shape))])
            self.assertEqual(part.shape, (4,) * d)

    def test_extreme_sizes(self):
        rng = np.random.default_rng(2)
        for d in 2, 3:
            for scale in 1e-90, 1e90:
                self.triangulate(rng.random((50, d)) * scale, "--tiles", "2")
                _, said = self.grid("--res", repr(scale * 0.3))
                self.assertAlmostEqual(said["grid_mass"] / 50, 1, delta=1e-13)
            # The volumes of the small cells are below what a double holds.
            points = np.vstack([rng.random((30, d)) * 1e-130, np.eye(d), -np.eye(d)])
            self.triangulate(points, "--tiles", "2")
            values, said = self.grid("--res", "0.3")
            self.assertTrue(np.isfinite(values).all())
            self.assertAlmostEqual(said["grid_mass"] / len(points), 1, delta=1e-13)

    def test_real_clouds(self):
        real = [(ROOT / "tests/data/clouds/csf_sample_begin.ply", 10)]
        for name, res in ("galaxy_20k", 20), ("lcdm_gas", 2500):
            if os.access(MORE / f"{name}.bin", os.R_OK):
                np.save(self.folder / f"{name}.npy", np.fromfile(MORE / f"{name}.bin").reshape(-1, 3))
                real.append((self.folder / f"{name}.npy", res))
        for path, res in real:
            self.ok("triangulate", path, "-o", self.out, "--overwrite", "--quiet", "--tiles", "6")
            values, said = self.grid("--res", res)
            self.assertAlmostEqual(values.sum() * float(res) ** 3 / said["mass"], 1, delta=1e-12)

    def test_densities_are_a_column_of_vertices(self):
        points = np.vstack([lattice(6, 2), lattice(2, 2), lattice(2, 2)])
        points = np.column_stack([points, np.arange(len(points)) + 1.0])
        self.triangulate(points, "--tiles", "3", names=["m"])
        said = json.loads(self.ok("measure", self.out, "--density", "--json").splitlines()[-1])
        self.assertEqual((said["columns"], said["note"]), (["density"], ""))
        said = json.loads(self.ok("measure", self.out, "--density", "--mass", "m", "--volume", "--json").splitlines()[-1])
        self.assertEqual(said["columns"], ["area", "star_area", "density_m"])
        self.assertIn("the 8 duplicates have no part", said["note"])
        arrays = self.cells()
        count = np.ones(36)
        np.add.at(count, [0, 1, 6, 7], 2)
        np.testing.assert_allclose(arrays["density"], 3 * count[arrays["ids"]] / arrays["star_area"], rtol=1e-15)
        np.testing.assert_allclose(arrays["density_m"], 3 * arrays["m"] / arrays["star_area"], rtol=1e-15)
        self.ok("verify", self.out)
        self.refused(USAGE, "measure", self.out, "--volume", "--mass", "m", says="--mass: has no effect without --density")


if __name__ == "__main__":
    unittest.main()
