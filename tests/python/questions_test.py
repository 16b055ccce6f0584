"""Questions to a result: against SciPy, the in-memory triangulation, the command, and arithmetic."""
import concurrent.futures
import json
import os
import pickle
import subprocess
import tempfile
import unittest

import numpy as np
import scipy.spatial
import tessera



def rows(cells):
    return sorted(map(tuple, np.sort(cells, axis=1).tolist()))


class Questions(unittest.TestCase):
    def setUp(self):
        random = np.random.default_rng(3)
        self.points = {dim: random.random((1500, dim)) for dim in (2, 3)}
        self.asked = {dim: random.random((500, dim)) * 1.2 - 0.1 for dim in (2, 3)}
        self.results = {dim: tessera.triangulate(self.points[dim], max_points_per_tile=300) for dim in (2, 3)}

    def test_points_are_in_the_cells_that_scipy_finds(self):
        for dim, t in self.results.items():
            scipys = scipy.spatial.Delaunay(self.points[dim])
            simplex = scipys.find_simplex(self.asked[dim])
            found = t.locate(self.asked[dim])
            inside = simplex >= 0
            self.assertTrue(50 < inside.sum() < 500)
            self.assertEqual((found.tiles >= 0).tolist(), inside.tolist())
            self.assertTrue((found.vertices[~inside] == -1).all() and (found.cells[~inside] == -1).all())
            self.assertEqual(np.sort(found.vertices[inside], axis=1).tolist(),
                             np.sort(scipys.simplices[simplex[inside]], axis=1).tolist())
            tiles = {tile.id: tile for tile in t}
            for which, cell, vertices in zip(found.tiles[inside], found.cells[inside], found.vertices[inside]):
                self.assertEqual(tiles[which].ids[tiles[which].cells[cell]].tolist(), vertices.tolist())

    def test_stars_are_those_of_all_cells(self):
        for dim, t in self.results.items():
            everything = t.simplices()
            on_hull = set(scipy.spatial.ConvexHull(self.points[dim]).vertices.tolist())
            area = 0
            for vertex in range(0, 1500, 50):
                star = t.star(vertex)
                around = everything[(everything == vertex).any(axis=1)]
                self.assertEqual((star.vertex, rows(star.cells)), (vertex, rows(around)))
                self.assertEqual(star.neighbors.tolist(), sorted(set(around.ravel().tolist()) - {vertex}))
                self.assertEqual(t.neighbours(vertex).tolist(), star.neighbors.tolist())
                self.assertEqual(t.neighbours(np.int64(vertex), star.tile).tolist(), star.neighbors.tolist())
                self.assertEqual(star.point.tolist(), self.points[dim][vertex].tolist())
                self.assertEqual(np.isinf(star.voronoi_volume), vertex in on_hull)
                self.assertEqual(rows(t.star(vertex, tile=star.tile).cells), rows(around))
                area += 0 if vertex in on_hull else star.voronoi_volume
            self.assertGreater(area, 0)

    def test_linear_functions_come_back_and_weights_tell_how(self):
        with tempfile.TemporaryDirectory() as folder:
            np.save(folder + "/plane.npy", np.column_stack([self.points[2], self.points[2] @ [2, -3] + 1]))
            t = tessera.triangulate(folder + "/plane.npy", dim=2, max_points_per_tile=300)
        wanted = self.asked[2] @ [2, -3] + 1
        inside = t.locate(self.asked[2]).tiles >= 0
        for method in ("linear", "natural"):
            values, weights = t.interpolate(self.asked[2], method=method, weights=True)
            self.assertEqual(np.isnan(values).tolist(), (~inside).tolist())
            self.assertLess(np.abs(values - wanted)[inside].max(), 1e-9)
            self.assertEqual(values.tobytes(), t.interpolate(self.asked[2], "z", method).tobytes())
            heights = self.points[2] @ [2, -3] + 1
            for i in np.flatnonzero(inside)[:50]:
                of = slice(weights.offsets[i], weights.offsets[i + 1])
                self.assertAlmostEqual(weights.weights[of].sum(), 1, 12)
                self.assertAlmostEqual(weights.weights[of] @ heights[weights.vertices[of]], values[i], 9)
                self.assertLess(np.abs(weights.weights[of] @ self.points[2][weights.vertices[of]] - self.asked[2][i]).max(), 1e-9)

    def test_cells_of_boxes_and_polygons_are_the_command_s(self):
        with tempfile.TemporaryDirectory() as folder:
            for dim, t in self.results.items():
                box = [0.3] * dim + [0.5] * dim
                ring = [[0.2, 0.2], [0.8, 0.3], [0.4, 0.9]]
                geojson = {"type": "Polygon", "coordinates": [ring]}
                with open(f"{folder}/area.geojson", "w") as file:
                    json.dump(geojson, file)
                for name, part, option in (("box", t.cells(bbox=box), ("--bbox", ",".join(map(str, box)))),
                                           ("ring", t.cells(polygon=ring), ("--polygon", f"{folder}/area.geojson"))):
                    out = f"{folder}/{name}{dim}"
                    subprocess.run([os.environ["TESSERA"], "query", t.folder, "cells", *option, "--format", "npy", "-o", out], check=True,
                                   stdout=subprocess.DEVNULL)
                    ids, cells = np.load(out + "/ids.npy"), np.load(out + "/cells.npy")
                    self.assertGreater(len(cells), 20)
                    self.assertEqual(rows(part.ids[part.cells]), rows(ids[cells]))
                    self.assertEqual(self.points[dim][part.ids].tolist(), part.points.tolist())
                    self.assertFalse(part.ghost.any() or part.foreign.any())
                for polygon in (geojson, json.dumps(geojson)):
                    self.assertEqual(rows((same := t.cells(polygon=polygon)).ids[same.cells]), rows(part.ids[part.cells]))
                self.assertEqual(len(t.cells(bbox=[5] * dim + [6] * dim).cells), 0)
                self.assertEqual(rows((back := pickle.loads(pickle.dumps(part))).ids[back.cells]), rows(part.ids[part.cells]))

    def test_threads_may_ask_at_once(self):
        t = self.results[3]
        right = t.locate(self.asked[3])
        with concurrent.futures.ThreadPoolExecutor(4) as pool:
            for found in pool.map(t.locate, [self.asked[3]] * 16):
                self.assertEqual(found.vertices.tolist(), right.vertices.tolist())

    def test_what_makes_no_sense_is_refused(self):
        t = self.results[2]
        for question in (lambda: t.locate([[0.5, 0.5, 0.5]]), lambda: t.locate([[0.5, np.nan]]), lambda: t.locate([0.5, 0.5]),
                         lambda: t.star(10**9), lambda: t.star(-1), lambda: t.neighbours(10**9), lambda: t.neighbours(-1), lambda: t.cells(), lambda: t.cells(bbox=[0, 0, 1]),
                         lambda: t.cells(bbox=[1, 0, 0, 1]), lambda: t.cells(bbox=[0, 0, 1, np.nan]), lambda: t.cells([0, 0, 1, 1], [[0, 0]]),
                         lambda: t.interpolate([[0.5, 0.5]]), lambda: t.interpolate([[0.5, 0.5]], "z", "cubic")):
            self.assertRaises(tessera.UsageError, question)
        for polygon in ([[0, 0], [1, 1]], {"type": "Point"}, "{", [[0, 0], [np.nan, 1], [1, 0]]):
            self.assertRaises(tessera.BadInputError, t.cells, polygon=polygon)
        self.assertRaises(tessera.MemoryLimitError, t.cells, [0, 0, 1, 1], limit=10)
        with tempfile.TemporaryDirectory() as folder:
            kept = tessera.triangulate(self.points[2], folder=folder + "/out", max_points_per_tile=300)
            for tile in os.listdir(folder + "/out/tiles"):
                with open(f"{folder}/out/tiles/{tile}", "r+b") as file:
                    file.seek(-20, os.SEEK_END)
                    file.write(b"damaged")
            self.assertRaises(tessera.CorruptError, kept.locate, [[0.5, 0.5]])
        t.close()
        self.assertRaises(tessera.UsageError, t.locate, [[0.5, 0.5]])


class Surfaces(unittest.TestCase):
    def setUp(self):
        random = np.random.default_rng(5)
        self.points = np.column_stack([random.random((3000, 2)) * 100, random.random(3000)])
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        self.file = self.folder.name + "/cloud.npy"
        np.save(self.file, self.points)
        self.ground = tessera.triangulate(self.file, dim=2, max_points_per_tile=500)

    def test_a_raster_is_the_interpolated_heights_and_the_file_of_the_command(self):
        raster = self.ground.dem(res=0.7, bbox=[10, 20, 60, 55.5], doubles=True)
        rows, columns = raster.values.shape
        x = raster.left + (np.arange(columns) + 0.5) * raster.res
        y = raster.top - (np.arange(rows) + 0.5) * raster.res
        at = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
        self.assertLess(np.abs(self.ground.interpolate(at) - raster.values.ravel()).max(), 1e-9)
        mine, theirs = self.folder.name + "/a.tif", self.folder.name + "/b.tif"
        with self.assertWarnsRegex(UserWarning, "coordinate"):
            self.ground.dem(mine, res=0.7, bbox=[10, 20, 60, 55.5])
        subprocess.run([os.environ["TESSERA"], "dem", self.ground.folder, "--res", "0.7", "--bbox", "10,20,60,55.5", "-o", theirs],
                       check=True, capture_output=True)
        with open(mine, "rb") as a, open(theirs, "rb") as b:
            self.assertEqual(a.read(), b.read())
        rounded = self.ground.dem(res=0.7, bbox=[10, 20, 60, 55.5])
        self.assertEqual(rounded.values.tobytes(), raster.values.astype(np.float32).astype(float).tobytes())
        whole, gaps = self.ground.dem(res=1), self.ground.dem(res=1, max_edge=2)
        self.assertTrue(0 < (~np.isnan(gaps.values)).sum() < (~np.isnan(whole.values)).sum() < whole.values.size)

    def test_rasters_that_make_no_sense_are_refused(self):
        for wrong in ({"res": 0}, {"res": np.nan}, {"res": 1, "bbox": [0, 0, 1]}, {"res": 1, "bbox": [1, 1, 0, 0]},
                      {"res": 1, "max_edge": -1}, {"res": 1, "value": "colour"}):
            self.assertRaises(tessera.UsageError, self.ground.dem, **wrong)
        self.assertRaises(tessera.UsageError, self.ground.dem, self.folder.name + "/a.png", res=1)
        self.assertRaises(tessera.UsageError, tessera.triangulate(self.points, max_points_per_tile=500).dem, res=1)

    def test_a_region_has_the_cells_of_the_whole_that_meet_it(self):
        for dim, box in ((2, [20, 30, 26, 35]), (3, [20, 30, 0.2, 26, 35, 0.4])):
            whole = tessera.triangulate(self.file, dim=dim, max_points_per_tile=500)
            wanted = whole.cells(bbox=box)
            part = tessera.region([self.file], box, dim)
            (tile,) = part
            self.assertEqual(rows(tile.ids[tile.cells]), rows(wanted.ids[wanted.cells]))
            self.assertRaises(tessera.UsageError, part.verify)
            self.assertRaises(tessera.UsageError, part.locate, [[1] * dim])  # beside its cells nothing is known
        kept = tessera.region(self.file, [20, 30, 26, 35], 2, folder=self.folder.name + "/part")
        self.assertEqual(tessera.open(self.folder.name + "/part").n_cells, kept.n_cells)
        self.assertRaises(tessera.UsageError, tessera.region, self.file, [20, 30, 26, 35], 2, folder=self.folder.name + "/part")

    def test_regions_that_make_no_sense_are_refused(self):
        for box, dim in (([0, 0, 1], 2), ([900, 900, 901, 901], 2), ([0, 0, np.inf, 1], 2), ([0, 0, 0, 1, 1, 1], 2), ([9, 9, 0, 0], 2)):
            self.assertRaises(tessera.UsageError, tessera.region, self.file, box, dim)
        self.assertRaises(tessera.UsageError, tessera.region, self.points, [0, 0, 1, 1])
        self.assertRaises(tessera.IoError, tessera.region, "none.laz", [0, 0, 1, 1])
        self.assertRaises(tessera.MemoryLimitError, tessera.region, self.file, [0, 0, 50, 50], 2, max_points=10)


if __name__ == "__main__":
    unittest.main()
