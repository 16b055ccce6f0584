"""Questions to periodic results: the answers are those of the middle one of 3 copies along each axis that has a period."""
import itertools
import json
import os
import pathlib
import subprocess
import tempfile
import unittest

import numpy as np
import tessera


def copied(points, periods):
    """The points with offsets -1, 0 and 1 along the axes that have a period, and the offsets; those of 0 come first."""
    offsets = [np.array(o) for o in itertools.product(*[(0, -1, 1) if length else (0,) for length in periods])]
    return np.concatenate([points + offset * periods for offset in offsets]), np.repeat(offsets, len(points), axis=0)


def write(path, points, values):
    names = ["x", "y", "z"][: points.shape[1]] + ["value"]
    np.savetxt(path, np.column_stack([points, values]), "%.17g", ",", header=",".join(names), comments="")


def clouds():
    rng = np.random.default_rng(6)
    for d in 2, 3:
        side = 6 if d == 2 else 3
        lattice = np.stack(np.meshgrid(*[np.arange(side, dtype=float)] * d), -1).reshape(-1, d)
        uniform = rng.integers(0, 2**16, (60, d)) * side / 2**16
        for periods in [side] * d, [side] + [0] * (d - 1):
            yield "uniform", uniform, np.array(periods, float)
            yield "lattice", lattice, np.array(periods, float)
        yield "few", uniform[:2], np.array([side] * d, float)
        yield "one", uniform[:1], np.array([side] * d, float)
        yield "long", uniform * [1 / 64] + [0] * d, np.array([side / 64] + [side] * (d - 1), float)


class PeriodicQuestions(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def results(self, points, periods):
        values = np.arange(len(points)) ** 2 % 7.0
        write(self.folder / "points.csv", points, values)
        copies, offsets = copied(points, periods)
        write(self.folder / "copies.csv", copies, np.tile(values, len(copies) // len(points)))
        options = {"dim": points.shape[1], "attributes": ["value"]}
        big = tessera.triangulate(self.folder / "copies.csv", **options)
        for tiles in 1, 7:
            yield big, offsets, tessera.triangulate(self.folder / "points.csv", periodic=tuple(periods), tiles=tiles, **options)

    def test_points_are_in_the_cells_of_copies(self):
        rng = np.random.default_rng(7)
        for name, points, periods in clouds():
            box = np.where(periods > 0, periods, points.max(axis=0) + 1)
            asked = rng.random((200, points.shape[1])) * box
            for big, _, t in self.results(points, periods):
                with self.subTest(cloud=name, periods=list(periods), tiles=len(t)):
                    found, expected = t.locate(asked), big.locate(asked)
                    inside = expected.vertices[:, 0] >= 0
                    self.assertGreater(inside.sum(), 50)
                    np.testing.assert_array_equal(found.vertices[:, 0] >= 0, inside)
                    np.testing.assert_array_equal(np.sort(found.vertices, axis=1)[inside],
                                                  np.sort(expected.vertices % len(points), axis=1)[inside])
                    tiles = {tile.id: tile for tile in t}
                    for tile, cell, vertices in zip(found.tiles, found.cells, found.vertices):
                        if tile >= 0:
                            self.assertFalse(tiles[tile].ghost[cell])
                            self.assertEqual(sorted(tiles[tile].ids[tiles[tile].cells[cell]]), sorted(vertices))
                    values = t.interpolate(asked, "value")
                    np.testing.assert_allclose(values, big.interpolate(asked, "value"), rtol=1e-12, atol=1e-12)
                    # Whole periods change nothing; these sums are not rounded.
                    coarse = np.floor(asked * 1024) / 1024
                    moved = coarse + rng.integers(-3, 4, coarse.shape) * periods
                    np.testing.assert_array_equal(t.locate(moved).vertices, t.locate(coarse).vertices)
                    np.testing.assert_array_equal(t.interpolate(moved, "value"), t.interpolate(coarse, "value"))

    def test_values_at_points_are_those_of_the_points(self):
        for name, points, periods in clouds():
            answers = []
            for _, _, t in self.results(points, periods):
                with self.subTest(cloud=name, periods=list(periods), tiles=len(t)):
                    np.testing.assert_array_equal(t.interpolate(points, "value"), np.arange(len(points)) ** 2 % 7.0)
                    found = t.locate(points)
                    self.assertTrue((found.vertices == np.arange(len(points))[:, None]).any(axis=1).all())
                    answers.append(np.sort(found.vertices, axis=1))
                    np.testing.assert_array_equal(answers[0], answers[-1], "ties do not depend on tiles")

    def test_stars_are_those_of_copies(self):
        for name, points, periods in clouds():
            n = len(points)
            for big, _, t in self.results(points, periods):
                with self.subTest(cloud=name, periods=list(periods), tiles=len(t)):
                    for vertex in range(0, n, 7):
                        star, expected = t.star(vertex), big.star(vertex)
                        self.assertEqual(sorted(star.neighbors), sorted(expected.neighbors % n))
                        self.assertEqual(sorted(map(sorted, star.cells.tolist())), sorted(map(sorted, (expected.cells % n).tolist())))
                        np.testing.assert_allclose(star.voronoi_volume, expected.voronoi_volume, rtol=1e-12)
                        self.assertEqual(t.neighbours(vertex).tolist(), sorted(set((expected.neighbors % n).tolist()) - {vertex}))

    def test_the_command_tells_images_and_refuses_areas(self):
        points = np.random.default_rng(8).integers(0, 64, (40, 2)) / 16
        write(self.folder / "points.csv", points, points[:, 0])
        out = self.folder / "out"
        tessera.triangulate(self.folder / "points.csv", dim=2, periodic=4, attributes=["value"], folder=out, tiles=3)

        def run(*words):
            return subprocess.run([os.environ["TESSERA"], "query", out, *words], text=True, capture_output=True)
        told = json.loads(run("star", "0", "--json").stdout)
        for neighbour in told["neighbors"]:
            np.testing.assert_array_equal(neighbour["point"], points[neighbour["id"]] + 4 * np.array(neighbour.get("offset", (0, 0))))
        told = json.loads(run("locate", "3.999,3.999", "--json").stdout)
        self.assertEqual(len(told["vertices"]), 3)
        self.assertEqual(json.loads(run("locate", "-0.001,-0.001", "--json").stdout)["vertices"], told["vertices"])
        for words in ("cells", "--bbox", "0,0,1,1", "-o", str(self.folder / "cells.ply")), ("interpolate", str(self.folder / "points.csv"), "--value", "value", "--method", "natural"):
            refused = run(*words)
            self.assertEqual(refused.returncode, 2, refused)
            self.assertIn("the triangulation of a periodic cloud, which does not answer questions for", refused.stderr)
        self.assertFalse((self.folder / "cells.ply").exists())


if __name__ == "__main__":
    unittest.main()
