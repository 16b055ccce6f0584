"""tessera measure --volume: values are exact, rounded once, and do not depend on tiles and threads."""
import fractions
import math
import unittest

import numpy as np
from cli import USAGE, CliTest
from measured import Measured
from scipy.spatial import ConvexHull


def exact_volume(corners):
    """Of a cell, as a fraction."""
    p = [[fractions.Fraction(float(x)) for x in row] for row in corners]
    e = [[a - b for a, b in zip(row, p[0])] for row in p[1:]]
    if len(e) == 2:
        return (e[0][0] * e[1][1] - e[0][1] * e[1][0]) / 2
    return (e[0][0] * (e[1][1] * e[2][2] - e[1][2] * e[2][1]) - e[0][1] * (e[1][0] * e[2][2] - e[1][2] * e[2][0])
            + e[0][2] * (e[1][0] * e[2][1] - e[1][1] * e[2][0])) / 6


def clouds(d):
    rng = np.random.default_rng(d)
    side = 40 if d == 2 else 11
    sphere = rng.normal(size=(600, d))
    return {"uniform": rng.random((1500, d)),
            "grid": np.stack(np.meshgrid(*[np.arange(side) * 0.1] * d, indexing="ij"), -1).reshape(-1, d),
            "sphere": sphere / np.linalg.norm(sphere, axis=1, keepdims=True),
            "far": rng.random((800, d)) * 1e-3 + 1e6,
            "small": rng.random((300, d)) * 1e-100,
            "mixed": rng.random((400, d)) * 10.0 ** rng.integers(-30, 30, (400, d))}


class Volumes(CliTest):
    def cloud(self, points, name="cloud.npy"):
        np.save(self.folder / name, points)
        return self.folder / name

    def measured(self, points, *options, measure=()):
        """The result, and the last line but notes that the command printed."""
        self.ok("triangulate", self.cloud(points), "-o", self.out, "--overwrite", "--quiet", "--dim", points.shape[1],
                *options)
        self.ok("measure", self.out, "--volume", *measure)
        return Measured(self.out)

    def test_cells_are_the_nearest_doubles_and_the_sum_is_that_of_the_hull(self):
        for d in 2, 3:
            for name, points in clouds(d).items():
                with self.subTest(dimension=d, cloud=name):
                    result = self.measured(points, "--tiles", "4")
                    exact = [exact_volume(cell) for cell in result.cells]
                    values = sorted(result.volumes.values())
                    self.assertEqual(values, sorted(map(float, exact)))
                    self.assertEqual(result.total, float(sum(exact)))
                    if name not in ("small", "mixed"):  # what Qhull can
                        hull = ConvexHull(points - points.min(axis=0)).volume
                        self.assertAlmostEqual(result.total / hull, 1, delta=1e-9)
                    # A vertex' star is the sum of its cells, each of which has d + 1 vertices.
                    self.assertAlmostEqual(math.fsum(result.stars.values()) / (d + 1) / result.total, 1, delta=1e-12)

    def test_a_star_is_the_sum_of_the_cells_around(self):
        for d in 2, 3:
            result = self.measured(clouds(d)["uniform"][:400], "--tiles", "5")
            around = {}
            for cell, value in result.volumes.items():
                for vertex in cell:
                    around.setdefault(vertex, []).append(value)
            self.assertEqual(set(around), set(result.stars))
            for vertex, values in around.items():
                self.assertAlmostEqual(result.stars[vertex] / math.fsum(values), 1, delta=1e-14)

    def test_a_cube_has_the_volume_of_a_cube(self):
        result = self.measured(np.stack(np.meshgrid(*[np.arange(9.0)] * 3), -1).reshape(-1, 3), "--tiles", "7")
        self.assertEqual(result.total, 512)

    def test_bits_are_the_same_for_all_tiles_and_threads(self):
        for d in 2, 3:
            for name in "uniform", "grid", "mixed":
                points, first = clouds(d)[name], None
                for options in (["--tiles", "1"], ["--tiles", "7"], ["--tiles", "50"], ["--tiles", "7", "--no-neighbors"],
                                ["--tiles", "5", "--partition", "random"], ["--tiles", "6", "--partition", "grid"]):
                    for threads in 1, 2, 4:
                        with self.subTest(dimension=d, cloud=name, options=options, threads=threads):
                            result = self.measured(points, *options, measure=["--threads", threads])
                            found = (result.volumes, result.stars, result.total)
                            first = first or found
                            self.assertEqual(found, first)

    def test_what_a_double_does_not_hold_is_told(self):
        rng = np.random.default_rng(1)
        points = rng.random((60, 3)) * 1e120
        self.ok("triangulate", self.cloud(points), "-o", self.out, "--quiet")
        said = self.ok("measure", self.out, "--volume")
        self.assertIn("beyond what a double holds", said)
        self.assertIn("volume of all cells: inf", said)
        self.assertIn(math.inf, Measured(self.out).volumes.values())
        self.ok("verify", self.out)

    def test_memory_is_bounded_and_little_of_it_is_enough(self):
        result = self.measured(clouds(3)["uniform"], "--tiles", "20", measure=["--memory", "64M", "--threads", "2"])
        self.assertAlmostEqual(result.total, ConvexHull(clouds(3)["uniform"]).volume, delta=1e-9)

    def test_what_has_no_cells_is_no_result_to_measure(self):
        for points in ([[0.0, 0, 0]], [[0.0, 0, 0], [1, 1, 1]], [[float(i), i, i] for i in range(9)]):
            done = self.run_tessera("triangulate", self.cloud(np.array(points)), "-o", self.out, "--quiet")
            self.assertNotEqual(done.returncode, 0)
            self.refused(4, "measure", self.out, "--volume", says="out")

    def test_nothing_to_measure_is_told(self):
        self.measured(clouds(2)["uniform"][:50])
        self.refused(USAGE, "measure", self.out, says="--volume")
        self.refused(USAGE, "measure", says="no result folder")
        self.refused(4, "measure", self.folder / "none", "--volume", says="none")


if __name__ == "__main__":
    unittest.main()
