"""tessera density --field, --divergence, --curl, --shear: means against fractions; constant and linear fields come out as they are."""
import unittest

import numpy as np
from cli import USAGE
from exact_clip import Q, determinant, integrals
from gridded import DensityTest, clouds, lattice


def gradient(edges, rises):
    """Of the linear function that rises so much along the edges, by Cramer's rule."""
    whole = determinant(edges)
    return [determinant([row[:j] + [rise] + row[j + 1:] for row, rise in zip(edges, rises)]) / whole for j in range(len(edges))]


def derivatives(by):
    """by[i][j]: component i along axis j."""
    d = len(by)
    trace = sum(by[i][i] for i in range(d))
    places = [(0, 0), (0, 1)] if d == 2 else [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2)]
    curl = [by[1][0] - by[0][1]] if d == 2 else [by[2][1] - by[1][2], by[0][2] - by[2][0], by[1][0] - by[0][1]]
    shear = [(by[i][j] + by[j][i]) / 2 - (trace / d if i == j else 0) for i, j in places]
    return {"divergence": [trace], "curl": curl, "shear": shear}


class Fields(DensityTest):
    def centres(self, values, said):
        d = len(said["size"])
        return (np.stack(np.meshgrid(*map(np.arange, values.shape[:d]), indexing="ij"), -1) + self.first(said) + 0.5) * said["res"]

    def test_means_are_those_of_exact_clipping(self):
        for d in 2, 3:
            rng = np.random.default_rng(d)
            for name in "lattice, other voxels", "random", "slivers", "far from the origin":
                points, res = clouds(d)[name]
                with self.subTest(dimension=d, cloud=name):
                    self.triangulate(np.column_stack([points, rng.normal(size=len(points))]), "--tiles", "3", names=["f"])
                    arrays = self.cells()
                    expected = integrals(arrays["points"], arrays["cells"], arrays["f"].tolist(), res)
                    values, said = self.grid("--res", repr(res), "--field", "f")
                    first, voxel = self.first(said), float(res) ** d
                    for at in np.ndindex(values.shape):
                        integral, part = expected.pop(tuple((first + at).tolist()), (0, 0))
                        if float(part) < 1e-9 * voxel:
                            self.assertTrue(np.isnan(values[at]) or float(part) > 0.9e-9 * voxel)
                            continue
                        self.assertAlmostEqual(values[at], float(integral / part), delta=1e-12)
                    self.assertEqual(expected, {})

    def test_a_constant_field_is_constant(self):
        rng = np.random.default_rng(1)
        for d in 2, 3:
            for value in 0.1, -1e300, 3e-310:
                points = np.column_stack([rng.random((300, d)), np.full(300, value)])
                self.triangulate(points, "--tiles", "4", names=["f"])
                for options in ([], ["--sample"]):
                    values, said = self.grid("--res", "0.11", "--field", "f", *options)
                    known = values[~np.isnan(values)]
                    self.assertEqual(len(known), said["known"])
                    self.assertGreater(len(known), 40)
                    np.testing.assert_allclose(known, value, rtol=1e-15 if value != 3e-310 else 1e-12)

    def test_linear_fields_and_their_derivatives(self):
        rng = np.random.default_rng(2)
        for d in 2, 3:
            slopes, start = rng.normal(size=(d, d)), rng.normal(size=d)
            for points in (np.vstack([rng.random((200, d)), lattice(2, d)]), lattice(12 if d == 2 else 6, d, 0.2),
                           np.vstack([rng.random((100, d)), lattice(2, d), np.full((1, d), 30.0)])):
                names = ["u", "v", "w"][:d]
                self.triangulate(np.column_stack([points, points @ slopes.T + start]), "--tiles", "3", names=names)
                box = ["--bbox", ",".join(["0.2"] * d + ["0.8"] * d)]  # within the hull
                for options in ([], ["--sample"]):
                    for i, name in enumerate(names):
                        values, said = self.grid("--res", "0.1", "--field", name, *box, *options)
                        np.testing.assert_allclose(values, self.centres(values, said) @ slopes[i] + start[i], atol=1e-12)
                    values, _ = self.grid("--res", "0.1", "--divergence", ",".join(names), *box, *options)
                    np.testing.assert_allclose(values, np.trace(slopes), atol=1e-10)
                    values, said = self.grid("--res", "0.1", "--curl", ",".join(names), *box, *options)
                    turn = slopes - slopes.T
                    curl = turn[1, 0] if d == 2 else [turn[2, 1], turn[0, 2], turn[1, 0]]
                    np.testing.assert_allclose(values, np.broadcast_to(curl, values.shape), atol=1e-10)
                    self.assertEqual(said["components"], 1 if d == 2 else 3)
                    values, said = self.grid("--res", "0.1", "--shear", ",".join(names), *box, *options)
                    shear = (slopes + slopes.T) / 2 - np.eye(d) * np.trace(slopes) / d
                    shear = [shear[i, j] for i, j in ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2)) if j < d and (d == 3 or i == 0)]
                    np.testing.assert_allclose(values, np.broadcast_to(shear, values.shape), atol=1e-10)
                    self.assertEqual(said["components"], len(shear))

    def test_derivatives_are_those_of_fractions(self):
        for d in 2, 3:
            rng = np.random.default_rng(d)
            points = np.round(rng.random((14 if d == 2 else 8, d)) * 64) / 64
            field = rng.integers(-9, 9, (len(points), d)) / 8
            names = ["u", "v", "w"][:d]
            self.triangulate(np.column_stack([points, field]), "--tiles", "2", names=names)
            arrays = self.cells()
            slopes = {}  # by component: (integral, volume) of each voxel
            for cell in arrays["cells"].tolist():
                corners = [[Q(float(x)) for x in arrays["points"][v]][:d] for v in cell]
                edges = [[x - y for x, y in zip(p, corners[0])] for p in corners[1:]]
                by = [gradient(edges, [Q(float(arrays[name][v])) - Q(float(arrays[name][cell[0]])) for v in cell[1:]])
                      for name in names]
                for kind, values in derivatives(by).items():
                    for c, value in enumerate(values):
                        found = integrals(arrays["points"], [cell], dict.fromkeys(cell, value), "0.25")
                        for at, (integral, part) in found.items():
                            old = slopes.setdefault((kind, c), {}).get(at, (0, 0))
                            slopes[kind, c][at] = old[0] + integral, old[1] + part
            for kind in "divergence", "curl", "shear":
                values, said = self.grid("--res", "0.25", "--" + kind, ",".join(names))
                values = values.reshape(*said["size"], -1)
                self.assertEqual(values.shape[-1], said["components"])
                for at in np.ndindex(*said["size"]):
                    for c in range(values.shape[-1]):
                        integral, part = slopes[kind, c].get(tuple((self.first(said) + at).tolist()), (0, 0))
                        if float(part) > 1e-8 * 0.25 ** d:
                            right = float(integral / part)
                            self.assertAlmostEqual(values[at][c], right, delta=1e-11 * max(1, abs(right)), msg=(kind, c))

    def test_bytes_are_the_same_for_all_tiles_and_threads(self):
        rng = np.random.default_rng(3)
        for d in 2, 3:
            points = rng.random((300, d))
            names = ["u", "v", "w"][:d]
            cloud = np.column_stack([points, rng.normal(size=(300, d))])
            for options in (["--field", "u"], ["--divergence", ",".join(names)], ["--curl", ",".join(names)],
                            ["--shear", ",".join(names)], ["--field", "u", "--sample"]):
                first = None
                for tiles, store, threads in (1, "points", 1), (7, "cells", 2), (60, "points", 3):
                    self.triangulate(cloud, "--tiles", tiles, "--store", store, names=names)
                    self.ok("density", self.out, "--res", "0.07", "-o", "grid.npy", "--overwrite", "--quiet", "--threads", threads,
                            "--memory", "200M", *options)
                    found = (self.folder / "grid.npy").read_bytes()
                    first = first or found
                    self.assertEqual(found, first, (d, options, tiles))

    def test_values_that_are_no_numbers_leave_voxels_without_a_value(self):
        points = np.column_stack([lattice(6, 2), np.arange(36.0)])
        np.save(self.folder / "cloud.npy", points[:, :2])
        rows = "\n".join("%r %r %s" % (x, y, "nan" if (x, y) == (2, 2) else f) for x, y, f in points.tolist())
        self.write("cloud.txt", "x y f\n" + rows + "\n")
        self.ok("triangulate", "cloud.txt", "-o", self.out, "--dim", "2", "--attributes", "f", "--quiet")
        values, said = self.grid("--res", "0.5", "--field", "f")
        missing = np.isnan(values)
        self.assertEqual(100 - missing.sum(), said["known"])
        self.assertTrue(missing[3:5, 3:5].all() and not missing[:, 7:].any() and not missing[7:].any())
        self.refused(3, "density", self.out, "--res", "1", "--mass", "f", "-o", "mass.npy",
                     says="the attribute 'f' of vertex 14 is nan, but a mass must be finite")
        self.assertFalse((self.folder / "mass.npy").exists())

    def test_wrong_names_are_refused(self):
        self.triangulate(np.column_stack([lattice(4, 2), np.zeros((16, 2))]), names=["u", "v"])
        for options, says in ((["--field", "w"], "its vertices have no attribute 'w'; they have u, v"),
                              (["--mass", "w"], "its vertices have no attribute 'w'"),
                              (["--field", "u,v"], "--field: takes the name of one attribute"),
                              (["--divergence", "u"], "--divergence: takes the names of 2 attributes"),
                              (["--curl", "u,v,u"], "--curl: takes the names of 2 attributes"),
                              (["--shear", "u,v,u"], "--shear: takes the names of 2 attributes"),
                              (["--shear", "u,v", "--curl", "u,v"], "--curl and --shear cannot both be on one grid"),
                              (["--field", "u", "--curl", "u,v"], "--field and --curl cannot both be on one grid"),
                              (["--field", "u", "--mass", "v"], "--mass: has the masses for a density, but a field has none")):
            self.refused(USAGE, "density", self.out, "--res", "1", "-o", "grid.npy", *options, says=says)
        self.assertFalse((self.folder / "grid.npy").exists())


if __name__ == "__main__":
    unittest.main()
