"""tessera density of periodic results: means against fractions, masses, boxes over the border, all tiles, refusals."""
import collections
import itertools
import json
import math
import os
import pathlib
import unittest

import numpy as np
import scipy.interpolate
from cli import USAGE
from exact_clip import Q, integrals, volume
from gridded import DensityTest, lattice
from tile_arrays import read_tile

ROOT = pathlib.Path(__file__).resolve().parents[2]
MORE = ROOT.parent / "shared" / "data"  # further clouds, which need not be there


def exact(points):
    """The points, such that images are not rounded."""
    return np.round(np.asarray(points, float) * 2**30) / 2**30


def uniform(n, d, lengths, seed=1):
    return exact(np.random.default_rng(seed).random((n, d)) * np.array(lengths))


class PeriodicGrids(DensityTest):
    def periodic(self, points, lengths, *options, names=()):
        return self.triangulate(points, "--periodic", ",".join(map(repr, map(float, lengths))), *options, names=names)

    def main_cells(self):
        """[[(point, offset)]] of the main cells, and the coordinates of the points, which are in their own order."""
        cells, points = [], {}
        for entry in json.loads((self.out / "manifest.json").read_text())["tiles"]:
            arrays = read_tile(self.out / "tiles" / ("%06d.vtu" % entry["tile"]))
            ids, at = arrays["PointData/id"].tolist(), arrays["Points"]
            offsets = arrays.get("PointData/period_offset", np.zeros((len(ids), 3), int)).tolist()
            for v, (i, offset) in enumerate(zip(ids, offsets)):
                if not any(offset):
                    points[i] = at[v].tolist()
            corners = arrays["Cells/connectivity"].reshape(-1, len(self.lengths) + 1)
            for cell in corners[arrays["CellData/vtkGhostType"] == 0].tolist():
                cells.append([(ids[v], tuple(offsets[v][:len(self.lengths)])) for v in cell])
        return cells, points

    def exact_means(self, lengths, voxels, f=None):
        """By voxel: the mean density, or the mean of the values `f`, with fractions. All axes have a period."""
        d = len(lengths)
        cells, points = self.main_cells()
        res = [Q(length) / n for length, n in zip(lengths, voxels)]
        # In units of voxels all of them have the width 1.
        corner = lambda i, o: tuple((Q(points[i][axis]) + o[axis] * Q(lengths[axis])) / res[axis] for axis in range(d))
        if f is None:
            stars = collections.defaultdict(Q)
            for cell in cells:
                size = volume([corner(*v) for v in cell], d)
                for i, _ in cell:
                    stars[i] += size
            f = {i: (d + 1) / star for i, star in stars.items()}
        sums = collections.defaultdict(Q)
        for cell in cells:
            found = integrals([corner(*v) for v in cell], [range(d + 1)], [Q(f[i]) for i, _ in cell], 1)
            for at, (integral, _) in found.items():
                sums[tuple(i % n for i, n in zip(at, voxels))] += integral
        unit = math.prod(res)
        return np.array([float(sums[at]) for at in np.ndindex(*voxels)]).reshape(voxels), float(unit)

    def test_means_are_those_of_exact_clipping(self):
        clouds = {2: {"one point": [[0.25, 0.75]], "two points": [[0.25, 0.75], [0.5, 0.125]], "lattice": lattice(3, 2) / 4,
                      "random": uniform(9, 2, [1, 1])},
                  3: {"one point": [[0.25, 0.75, 0.5]], "random": uniform(4, 3, [1, 1, 1])}}
        for d, sizes in ((2, [(4, 4), (7, 3), (1, 1)]), (3, [(2, 2, 2), (3, 1, 2)])):
            for lengths in [1.0] * d, [1.0, 2.0, 1.0][:d]:
                for name, points in clouds[d].items():
                    points, self.lengths = np.asarray(points, float), lengths
                    values_at = np.random.default_rng(1).integers(-8, 8, len(points)) / 4
                    self.periodic(np.column_stack([points, values_at]), lengths, "--tiles", "1", "--store", "cells", names=["f"])
                    for voxels in sizes:
                        with self.subTest(lengths=lengths, cloud=name, voxels=voxels):
                            wanted, unit = self.exact_means(lengths, voxels)
                            values, said = self.grid("--grid", ",".join(map(str, voxels)))
                            self.assertEqual((said["size"], said["origin"]), (list(voxels), [0] * d))
                            self.assertEqual((said["period"], said["known"]), (lengths, math.prod(voxels)))
                            np.testing.assert_allclose(values * unit, wanted, rtol=1e-12)
                            self.assertAlmostEqual(said["grid_mass"] / len(points), 1, delta=1e-13)
                            wanted, _ = self.exact_means(lengths, voxels, values_at)
                            values, _ = self.grid("--grid", ",".join(map(str, voxels)), "--field", "f")
                            np.testing.assert_allclose(values, wanted, atol=1e-12)

    def test_grids_are_those_of_the_middle_of_many_copies(self):
        for d, n in (2, 60), (3, 40):
            for lengths in itertools.product((1.0, 0.0), repeat=d):
                if not any(lengths):
                    continue
                points = uniform(n, d, [1] * d, seed=d)
                field = np.random.default_rng(3).normal(size=(n, d))
                names = ["u", "v", "w"][:d]
                cloud = np.column_stack([points, field])
                offsets = np.array([o for o in itertools.product((-2, -1, 0, 1, 2), repeat=d)
                                    if all(k == 0 or length > 0 for k, length in zip(o, lengths))])
                copies = np.vstack([np.column_stack([points + o, field]) for o in offsets])
                one, many = self.folder / "one", self.folder / "many"
                self.triangulate(cloud, "--periodic", ",".join(map(repr, lengths)), "--tiles", "3", names=names, out=one)
                self.triangulate(copies, names=names, out=many)
                box = [0 if length > 0 else -1 for length in lengths] + [1 if length > 0 else 2 for length in lengths]
                for options in ([], ["--sample"], ["--field", "u"], ["--field", "u", "--sample"],
                                ["--divergence", ",".join(names)], ["--curl", ",".join(names)], ["--shear", ",".join(names)]):
                    with self.subTest(lengths=lengths, options=options):
                        shared = ("--res", "0.125", "--bbox", ",".join(map(str, box)), *options)
                        found, wanted = self.grid(*shared, out=one)[0], self.grid(*shared, out=many)[0]
                        self.assertEqual(found.shape, wanted.shape)
                        np.testing.assert_allclose(found, wanted, rtol=1e-9, atol=1e-9)

    def test_the_grid_has_the_mass_of_the_points(self):
        rng = np.random.default_rng(4)
        for d in 2, 3:
            halo = exact(np.abs(rng.normal(0.5, 1e-5, (150, d)) % 1))
            for name, points in (("lattice", lattice(4, d) / 4), ("one point", exact(rng.random((1, d)))),
                                 ("few", exact(rng.random((3, d)))), ("clustered", np.vstack([halo, uniform(150, d, [1] * d)])),
                                 ("at the border", np.vstack([np.zeros((1, d)), exact(rng.random((9, d)) * 1e-6)]))):
                masses = 10.0 ** rng.integers(-8, 8, len(points))
                self.periodic(np.column_stack([points, masses]), [1.0] * d, "--tiles", "4", names=["m"])
                for voxels in 1, 3, 7, 16 if d == 2 else 8:
                    for options, mass in ((), len(points)), (("--mass", "m"), masses.sum()):
                        values, said = self.grid("--grid", voxels, *options)
                        with self.subTest(d=d, cloud=name, voxels=voxels, options=options):
                            self.assertEqual(said["known"], voxels ** d)
                            self.assertAlmostEqual(said["mass"] / mass, 1, delta=1e-14)
                            self.assertAlmostEqual(said["grid_mass"] / mass, 1, delta=1e-13)
                            self.assertAlmostEqual(math.fsum(values.ravel()) / voxels ** d / mass, 1, delta=1e-12)
                if name == "lattice":
                    np.testing.assert_allclose(self.grid("--grid", 7)[0], 4 ** d, rtol=1e-12)
                    np.testing.assert_allclose(self.grid("--grid", 8, "--sample")[0], 4 ** d, rtol=1e-12)

    def test_bytes_are_the_same_for_all_tiles_threads_and_memory(self):
        rng = np.random.default_rng(9)
        for d in 2, 3:
            names = ["u", "v", "w"][:d]
            for name, points, n in (("random", uniform(400, d, [1] * d), 23), ("few", uniform(3, d, [1] * d), 11),
                                    ("lattice", lattice(6, d) / 8, 9)):
                cloud = np.column_stack([points, rng.normal(size=(len(points), d))])
                for options in ([], ["--sample"], ["--shear", ",".join(names)]):
                    first = None
                    for tiles, store, threads, memory in (1, "cells", 1, "4G"), (8, "points", 2, "64M"), (90, "cells", 3, "1G"):
                        self.periodic(cloud, [1.0] * d, "--tiles", tiles, "--store", store, names=names)
                        self.ok("density", self.out, "--grid", n, "-o", "grid.npy", "--overwrite", "--quiet",
                                "--threads", threads, "--memory", memory, *options)
                        found = (self.folder / "grid.npy").read_bytes()
                        first = first or found
                        self.assertEqual(found, first, (d, name, options, tiles))

    def test_a_box_may_reach_over_the_border(self):
        for d in 2, 3:
            self.periodic(uniform(50, d, [1] * d), [1.0] * d, "--tiles", "3")
            whole, _ = self.grid("--res", "0.125")
            for lo, hi in (-0.25, 0.25), (0.5, 1.5), (0.875, 1), (-0.5, 0.5), (3, 3.5):
                part, said = self.grid("--res", "0.125", "--bbox", ",".join([str(lo)] * d + [str(hi)] * d))
                rows = np.arange(round(lo * 8), round(hi * 8)) % 8
                np.testing.assert_array_equal(part, whole[np.ix_(*[rows] * d)])
                self.assertEqual(said["origin"], [lo] * d)

    def test_fields_on_a_torus(self):
        for d in 2, 3:
            points = uniform(300, d, [1] * d)
            names = ["u", "v", "w"][:d]
            waves = np.sin(2 * np.pi * points + np.arange(d))
            self.periodic(np.column_stack([points, waves, np.full(300, 0.1)]), [1.0] * d, "--tiles", "3", names=[*names, "c"])
            np.testing.assert_allclose(self.grid("--grid", 9, "--field", "c")[0], 0.1, rtol=1e-14)
            for kind in "divergence", "curl", "shear":
                values, _ = self.grid("--grid", 9, "--" + kind, ",".join(names))
                total = values.reshape(9 ** d, -1).mean(0)  # a gradient has the mean 0 around a torus
                np.testing.assert_allclose(total, 0, atol=1e-12)
            # The gradient of sin(2 pi x) is 2 pi cos(2 pi x), which the cells of 300 points follow roughly.
            values, _ = self.grid("--grid", 4, "--shear", ",".join(names))
            self.assertEqual(values.shape, (4,) * d + ({2: 2, 3: 5}[d],))
            self.assertGreater(values[..., 0].max(), 2)

    def test_samples_are_linear_between_the_images(self):
        for d in 2, 3:
            points = uniform(40, d, [1] * d)
            f = np.random.default_rng(2).normal(size=40)
            self.periodic(np.column_stack([points, f]), [1.0] * d, names=["f"])
            offsets = np.array(list(itertools.product((-1, 0, 1), repeat=d)))
            copies = (points[:, None] + offsets).reshape(-1, d)
            linear = scipy.interpolate.LinearNDInterpolator(copies, np.repeat(f, len(offsets)))
            values, said = self.grid("--grid", 6, "--field", "f", "--sample")
            centres = (np.stack(np.meshgrid(*[np.arange(6)] * d, indexing="ij"), -1) + 0.5) / 6
            np.testing.assert_allclose(values, linear(centres), atol=1e-9)
            self.assertEqual(said["known"], 6 ** d)

    def test_widths_that_do_not_fit_are_refused(self):
        self.periodic(uniform(20, 2, [1, 1]), [1.0, 0.0])
        for options, says in ((["--res", "0.3"], "--res: does not divide the period 1 along x; the next widths that do are "
                                                 "0.333333333333333 and 0.25, or give --grid"),
                              (["--res", "2"], "the next widths that do are 1 and 0.5"),
                              (["--grid", "0"], "'0' is not a number of voxels along an axis"),
                              (["--grid", "4,x"], "'4,x' is not a number of voxels along an axis"),
                              (["--grid", "4,4,4"], "--grid: has 3 numbers, but takes 1, or one for each of the 2 axes"),
                              (["--grid", "4", "--res", "0.25"], "--res and --grid both say how large a pixel is"),
                              (["--grid", "4", "--bbox", "0,0,1,1"], "counts the pixels of the whole period; with --bbox, give --res"),
                              (["--res", "0.25", "--bbox", "-1,0,0.5,1"], "--bbox: is longer than the period along x, 1"),
                              (["--res", "0.25", "--bbox", "0.1,0,1.1,1"], "--bbox: is longer than the period along x, 1")):
            self.refused(USAGE, "density", self.out, *options, "-o", "grid.npy", says=says)
        self.assertFalse((self.folder / "grid.npy").exists())
        # The user writes decimals; the voxels fill the period.
        values, said = self.grid("--res", "0.3333333333333")
        self.assertEqual((said["size"][0], said["widths"][0]), (3, 1 / 3))

    def test_a_real_cloud(self):
        cloud = MORE / "lcdm_gas.gadget"
        if not os.access(cloud, os.R_OK):
            self.skipTest(f"{cloud} is not here")
        self.ok("triangulate", cloud, "-o", self.out, "--quiet", "--tiles", "6", "--periodic", "50000")
        values, said = self.grid("--grid", 16)
        self.assertEqual((said["size"], said["mass"]), ([16] * 3, 65536))
        self.assertAlmostEqual(values.sum() * math.prod(said["widths"]) / said["mass"], 1, delta=1e-12)


if __name__ == "__main__":
    unittest.main()
