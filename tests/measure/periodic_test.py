"""Columns of periodic results: those of the same cloud copied without a period, for any tiles, threads and kinds."""
import collections
import itertools
import json
import shutil
import unittest

import numpy as np
from cli import CORRUPT, CliTest
from tile_arrays import read_tile

OFFSETS = {d: list(itertools.product((-1, 0, 1), repeat=d)) for d in (2, 3)}  # in their order
OF_CELLS = {d: [("area", "volume")[d - 2], "radius_ratio", "least_angle", "largest_angle", "circumradius"] for d in (2, 3)}
OF_VERTICES = {2: ["star_area", "voronoi_area", "voronoi_boundary", "voronoi_neighbours", "voronoi_x", "voronoi_y", "density"],
               3: ["star_volume", "voronoi_volume", "voronoi_surface", "voronoi_neighbours", "voronoi_x", "voronoi_y",
                   "voronoi_z", "density"]}
ALL = "--volume", "--quality", "--voronoi", "--density"


def exact(points):
    """The points, such that images are not rounded."""
    return np.round(np.asarray(points, float) * 2**30) / 2**30


def uniform(n, d, seed=1, lengths=None):
    return exact(np.random.default_rng(seed).random((n, d)) * (lengths or [1.0] * d))


def lattice(side, d):
    return np.stack(np.meshgrid(*[np.arange(float(side))] * d, indexing="ij"), -1).reshape(-1, d)


def key_of(corners):
    """Of a cell with the vertices [(id, offset)]: such that the least one has the offset 0."""
    corners = sorted(corners)
    least = corners[0][1]
    return tuple((i, tuple(a - b for a, b in zip(o, least))) for i, o in corners)


class Found:
    """cells: {key: values}; vertices: {id: values}; main: the keys of main cells. Every copy has the same values."""

    def __init__(self, folder):
        self.manifest = json.loads((folder / "manifest.json").read_text())
        d = self.dimension = self.manifest["dimension"]
        self.cells, self.vertices, self.main = {}, {}, []
        for entry in self.manifest["tiles"]:
            arrays = read_tile(folder / entry.get("file", "tiles/%06d.vtu" % entry["tile"]))
            ids = arrays["PointData/id"].tolist()
            offsets = arrays.get("PointData/period_offset", np.zeros((len(ids), 3), int))[:, :d]
            vertices = list(zip(ids, map(tuple, offsets.tolist())))
            of_vertices = list(zip(*(arrays["PointData/" + name].tolist() for name in OF_VERTICES[d])))
            for (vertex, _), values in zip(vertices, of_vertices):
                np.testing.assert_array_equal(self.vertices.setdefault(vertex, values), values)
            corners = arrays["Cells/connectivity"].reshape(-1, d + 1).tolist()
            main = (arrays["CellData/vtkGhostType"] == 0).tolist()
            of_cells = list(zip(*(arrays["CellData/" + name].tolist() for name in OF_CELLS[d])))
            for cell, is_main, values in zip(corners, main, of_cells):
                key = key_of([vertices[v] for v in cell])
                assert self.cells.setdefault(key, values) == values, key
                if is_main:
                    self.main.append(key)
        assert len(self.main) == len(set(self.main)) == self.manifest["counts"]["cells"]
        self.total = next(c["total"] for c in self.manifest["columns"] if c["name"] in ("area", "volume"))
        self.everything = (self.cells, {v: repr(values) for v, values in self.vertices.items()}, self.total)

    def column(self, name):
        at = OF_VERTICES[self.dimension].index(name)
        return np.array([self.vertices[v][at] for v in sorted(self.vertices)])


class PeriodicColumns(CliTest):
    def made(self, points, *options, measure=ALL, out=None):
        np.save(self.folder / "cloud.npy", points)
        out = out or self.out
        self.ok("triangulate", self.folder / "cloud.npy", "-o", out, "--overwrite", "--quiet", "--dim", points.shape[1], *options)
        self.ok("measure", out, *measure)
        self.ok("verify", out, "--quiet")
        return out

    def copies(self, points, lengths, out):
        """What the middle copy has in a cloud of all near copies, as Found would have it of the periodic result."""
        d = points.shape[1]
        offsets = [o for o in OFFSETS[d] if all(k == 0 or lengths[axis] > 0 for axis, k in enumerate(o))]
        # The ids are in the order of images: by point, then by offset.
        big = (points[:, None, :] + np.array(offsets)[None] * np.array(lengths)).reshape(-1, d)
        self.made(big, "--tiles", "1", out=out)
        found = Found(out)
        middle, n = offsets.index((0,) * d), len(offsets)
        image = lambda v: (v // n, offsets[v % n])
        vertices = {v // n: values for v, values in found.vertices.items() if v % n == middle}
        cells = {}
        for key, values in found.cells.items():
            corners = [image(v) for v, _ in key]
            if any(o == (0,) * d for _, o in corners):
                self.assertEqual(cells.setdefault(key_of(corners), values), values)
        return cells, vertices

    def test_values_are_those_of_copies_without_a_period(self):
        clouds = [(uniform(200, 3), (1, 1, 1)), (uniform(150, 3, 2, [1, 2, 4]), (1, 2, 4)), (uniform(150, 3, 3), (1, 0, 1)),
                  (uniform(150, 3, 4), (0, 0, 1)), (uniform(400, 2, 5), (1, 1)), (uniform(300, 2, 6), (0, 1)),
                  (lattice(4, 3), (4, 4, 4)), (lattice(6, 2), (6, 6)), (lattice(5, 3), (0, 5, 5)),
                  (exact(0.5 + np.random.default_rng(7).normal(size=(150, 3)) ** 3 / 64), (1, 1, 1))]
        for points, lengths in clouds:
            with self.subTest(lengths=lengths, first=points[:2].tolist()):
                d = points.shape[1]
                cells, vertices = self.copies(np.mod(points, [length or np.inf for length in lengths]), lengths, self.folder / "copies")
                self.made(points, "--tiles", "5", "--periodic", ",".join(map(str, lengths)))
                found = Found(self.out)
                self.assertEqual(found.cells, {key: cells[key] for key in found.cells})
                self.assertEqual(len(found.cells), len(cells))
                open_axes = sum(length == 0 for length in lengths)
                on_hull = np.isinf(found.column(OF_VERTICES[d][1]))
                self.assertEqual(on_hull.any(), open_axes > 0)
                for vertex, values in found.vertices.items():
                    np.testing.assert_array_equal(values, vertices[vertex], str(vertex))
                if open_axes == 0:
                    self.assertEqual(found.total, np.prod(lengths))

    def test_bits_are_the_same_for_any_tiles_threads_and_kinds(self):
        rng = np.random.default_rng(3)
        halos = exact(np.mod(rng.random((6, 1, 3)) + rng.normal(size=(6, 100, 3)) * 0.01, 1).reshape(-1, 3))
        for points, periods in ((uniform(700, 3), "1"), (halos, "1"), (uniform(700, 2), "1,1"), (lattice(5, 3), "5"),
                                (uniform(500, 3), "1,0,1")):
            first = None
            for tiles, threads, options in ((1, 1, []), (8, 2, ["--no-neighbors"]), (8, 2, ["--store", "points"]),
                                            (60, 3, ["--partition", "random"]), (8, 1, ["--store", "points", "--no-neighbors"])):
                with self.subTest(periods=periods, tiles=tiles, options=options):
                    out = self.made(points, "--periodic", periods, "--tiles", tiles, *options, measure=[*ALL, "--threads", threads])
                    if "points" in options:
                        self.ok("materialise", out, "--quiet")
                        self.ok("verify", out, "--quiet")
                    found = Found(out)
                    first = first or found
                    self.assertEqual(found.everything, first.everything)

    def test_lattices_are_known_exactly(self):
        for side, d in ((1, 2), (3, 2), (8, 2), (1, 3), (2, 3), (5, 3)):
            found = Found(self.made(lattice(side, d), "--periodic", side, "--tiles", 3))
            self.assertEqual(found.total, side**d)
            volume, surface = OF_VERTICES[d][1:3]
            np.testing.assert_allclose(found.column(volume), 1, rtol=1e-14)
            np.testing.assert_allclose(found.column(surface), 2 * d, rtol=1e-14)
            np.testing.assert_allclose(found.column("density"), 1, rtol=1e-15)
            np.testing.assert_allclose(np.stack([found.column("voronoi_" + axis) for axis in "xyz"[:d]], 1), lattice(side, d), atol=1e-14)

    def test_few_points_fill_the_box(self):
        for d in 2, 3:
            for n in range(1, 11):
                for periods in ([1, 1, 1][:d], [1, 3, 0.25][:d]):
                    with self.subTest(dimension=d, points=n, periods=periods):
                        points = uniform(n, d, n, periods)
                        found = Found(self.made(points, "--periodic", ",".join(map(str, periods)), "--tiles", 1 + n % 3))
                        box = np.prod(periods)
                        self.assertEqual(found.total, box)
                        self.assert_whole(found, box)
                        cells, vertices = self.copies(points, periods, self.folder / "copies")
                        self.assertEqual(found.vertices, {v: vertices[v] for v in found.vertices})

    def assert_whole(self, found, box):
        """Voronoi cells fill the box, and densities add up to the mass."""
        d = found.dimension
        volumes, stars, densities = (found.column(name) for name in (OF_VERTICES[d][1], OF_VERTICES[d][0], "density"))
        self.assertTrue((volumes > 0).all() and (volumes <= box * (1 + 1e-12)).all())
        np.testing.assert_allclose(volumes.sum(), box, rtol=1e-12)
        np.testing.assert_allclose(stars.sum() / (d + 1), box, rtol=1e-12)
        np.testing.assert_allclose((densities * stars).sum() / (d + 1), self.mass or len(volumes), rtol=1e-12)

    mass = None

    def test_many_points_fill_the_box(self):
        rng = np.random.default_rng(8)
        halos = exact(np.mod(rng.random((20, 1, 3)) + rng.normal(size=(20, 100, 3)) * 10.0 ** -rng.integers(1, 5, (20, 1, 1)), 1).reshape(-1, 3))
        for points, period in ((uniform(3000, 3), "1"), (uniform(3000, 2), "1"), (np.unique(halos, axis=0), "1")):
            found = Found(self.made(points, "--periodic", period, "--tiles", 6))
            self.assertEqual(found.total, 1)
            self.assert_whole(found, 1)

    def test_duplicates_and_masses_count(self):
        points = uniform(500, 3)
        found = Found(self.made(np.vstack([points, points[:50] + 1, points[:20]]), "--periodic", "1", "--tiles", "4"))
        self.mass = 570
        self.assert_whole(found, 1)
        rows = np.zeros(500, [("x", "f8"), ("y", "f8"), ("z", "f8"), ("m", "f4")])
        rows["x"], rows["y"], rows["z"] = points.T
        rows["m"] = np.arange(500)
        np.save(self.folder / "rows.npy", rows)
        for store in "cells", "points":
            self.ok("triangulate", "rows.npy", "-o", self.out, "--overwrite", "--quiet", "--periodic", "1", "--tiles", "4",
                    "--attributes", "m", "--store", store)
            self.ok("measure", self.out, "--volume", "--density", "--mass", "m")
            self.ok("materialise", self.out, "--quiet")
            values = collections.defaultdict(set)
            for entry in json.loads((self.out / "manifest.json").read_text())["tiles"]:
                arrays = read_tile(self.out / entry.get("file", "tiles/%06d.vtu" % entry["tile"]))
                for row in zip(*(arrays["PointData/" + name].tolist() for name in ("id", "m", "star_volume", "density_m"))):
                    values[row[0]].add(row[1:])
            self.assertEqual({len(one) for one in values.values()}, {1})
            mass = sum(density * star for one in values.values() for _, star, density in one) / 4
            self.assertAlmostEqual(mass / np.arange(500.0).sum(), 1, delta=1e-12)

    def test_columns_are_told_kept_and_checked(self):
        points = uniform(800, 3)
        for store in "cells", "points":
            out = self.made(points, "--periodic", "1", "--tiles", "4", "--store", store)
            self.assertIn("star_volume of vertices", self.ok("info", out))
            self.assertIn("voronoi_volume", self.ok("columns", out))
            self.assertEqual(json.loads((out / "manifest.json").read_text())["format_version"], 6)
            self.assertIn("already", self.ok("measure", out, "--volume"))
            if store == "points":
                self.ok("materialise", out, "-o", "made", "--quiet")
                self.ok("verify", "made", "--quiet")
                self.assertEqual(Found(self.folder / "made").everything, cells.everything)
            else:
                cells = Found(out)
            file = out / json.loads((out / "manifest.json").read_text())["tiles"][1]["file"]
            whole = file.read_bytes()
            for at in len(whole) - 100, len(whole) * 3 // 4:
                file.write_bytes(whole[:at] + bytes([whole[at] ^ 1]) + whole[at + 1:])
                self.refused(CORRUPT, "verify", out, says=file.name)
            file.write_bytes(whole)
            self.ok("verify", out, "--quiet")
            shutil.rmtree(out)


if __name__ == "__main__":
    unittest.main()
