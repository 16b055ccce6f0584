"""Results as Python's own: sequences, contexts, pickles."""
import collections.abc
import concurrent.futures
import multiprocessing
import pickle
import unittest

import numpy as np
import tessera

import clouds


def cells_of(tile):
    return np.sort(tile.ids[tile.cells[~tile.ghost]], axis=1).tolist()


class Slices(unittest.TestCase):
    def setUp(self):
        self.t = tessera.triangulate(clouds.random(2000, 3), max_points_per_tile=200)

    def test_a_slice_is_a_sequence_of_the_same_tiles(self):
        ids = [tile.id for tile in self.t]
        self.assertGreater(len(ids), 8)
        for part in (slice(2, 5), slice(None), slice(-3, None), slice(None, None, -2), slice(5, 2), slice(0, 10**6)):
            tiles = self.t[part]
            self.assertIsInstance(tiles, collections.abc.Sequence)
            self.assertEqual((len(tiles), [tile.id for tile in tiles]), (len(ids[part]), ids[part]))
            self.assertEqual([tile.id for tile in tiles[1:][::-1]], ids[part][1:][::-1])
        self.assertEqual(self.t[2:5][-1].id, ids[4])
        self.assertRegex(repr(self.t[2:5]), "^<tessera.Tiles: 3 of <tessera.Triangulation of 2000")

    def test_an_index_is_an_integer_of_any_kind_within_the_sequence(self):
        self.assertEqual(self.t[np.int64(1)].id, self.t[1].id)
        for index in (len(self.t), -len(self.t) - 1):
            with self.assertRaises(IndexError):
                self.t[index]
        with self.assertRaises(IndexError):
            self.t[2:5][3]
        for index in ("1", 1.0, None):
            with self.assertRaises(TypeError):
                self.t[index]


class Kept(unittest.TestCase):
    def test_tiles_that_are_kept_as_points_have_the_same_arrays(self):
        points = clouds.random(2000, 3)
        mass = np.arange(len(points))
        with (tessera.triangulate(points, max_points_per_tile=300, attributes={"mass": mass}, store="cells") as cells,
              tessera.triangulate(points, max_points_per_tile=300, attributes={"mass": mass}, store="points") as kept):
            self.assertEqual((kept.digest, kept.n_cells, len(kept)), (cells.digest, cells.n_cells, len(cells)))
            self.assertEqual({path.suffix for path in (kept.folder / "tiles").iterdir()}, {".pts"})
            for one, other in zip(cells, kept):
                for name in ("points", "ids", "foreign", "cells", "ghost", "neighbors"):
                    np.testing.assert_array_equal(getattr(one, name), getattr(other, name), name)
                np.testing.assert_array_equal(one.attributes["mass"], other.attributes["mass"])
            kept.verify()
            with self.assertRaisesRegex(tessera.UsageError, "^store: 'half' is not one of auto, cells and points"):
                tessera.triangulate(points, store="half")


class Contexts(unittest.TestCase):
    def test_the_end_of_the_context_removes_a_temporary_result(self):
        with tessera.triangulate(clouds.random(500, 2)) as t:
            folder, tile, part = t.folder, t[0], t[:1]
            self.assertTrue(folder.is_dir())
        self.assertFalse(folder.exists())
        self.assertEqual(len(tile.points), 500)
        self.assertEqual(repr(t), "<tessera.Triangulation, closed>")
        for call in (lambda: t[0], lambda: len(t), lambda: part[0], lambda: t.digest, t.verify, lambda: pickle.dumps(t)):
            with self.assertRaisesRegex(tessera.UsageError, "closed"):
                call()
        t.close()

    def test_it_ends_with_what_is_raised_in_it(self):
        with self.assertRaises(ZeroDivisionError), tessera.triangulate(clouds.random(500, 2)) as t:
            folder = t.folder
            1 / 0
        self.assertFalse(folder.exists())


class Pickles(unittest.TestCase):
    def test_a_result_is_pickled_as_its_folder(self):
        t = tessera.triangulate(clouds.random(500, 3), max_points_per_tile=100)
        again = pickle.loads(pickle.dumps(t))
        self.assertEqual((again.digest, again.folder), (t.digest, t.folder))
        data, folder = pickle.dumps(t), t.folder
        del again
        self.assertTrue(folder.is_dir(), "it is the first one's")
        t.close()
        with self.assertRaisesRegex(tessera.IoError, str(folder)):
            pickle.loads(data)

    def test_a_tile_is_pickled_as_its_arrays(self):
        points = clouds.random(300, 2)
        for neighbors in (True, False):
            with tessera.triangulate(points, max_points_per_tile=100, neighbors=neighbors) as t:
                tile = t[0]
                again = pickle.loads(pickle.dumps(tile))
            for name in ("id", "dim", "points", "ids", "foreign", "cells", "ghost", "neighbors"):
                mine, theirs = getattr(tile, name), getattr(again, name)
                np.testing.assert_array_equal(mine, theirs)
                if isinstance(mine, np.ndarray):
                    self.assertEqual((mine.dtype, theirs.flags.writeable), (theirs.dtype, False))
            self.assertEqual(again.attributes, {})
            self.assertEqual(repr(again), repr(tile))

    def test_a_delaunay_is_pickled_as_its_arrays(self):
        points = np.concatenate([clouds.lattice(6, 3), clouds.lattice(6, 3)[:10]])
        tri = tessera.Delaunay(points)
        again = pickle.loads(pickle.dumps(tri))
        queries = clouds.random(500, 3) * 7 - 1
        for name in ("points", "simplices", "neighbors", "coplanar", "convex_hull"):
            np.testing.assert_array_equal(getattr(again, name), getattr(tri, name))
        np.testing.assert_array_equal(again.find_simplex(queries), tri.find_simplex(queries))

    def test_arrays_that_cannot_be_those_of_a_delaunay_are_refused(self):
        restored, arrays = tessera.Delaunay(clouds.random(20, 2)).__reduce__()
        for at, value in ((1, 20), (1, -1), (2, 10**6), (2, -2), (0, np.nan)):
            wrong = [array.copy() for array in arrays]
            wrong[at][0, 0] = value
            with self.subTest(at=at, value=value), self.assertRaises(tessera.UsageError):
                restored(*wrong)
        with self.assertRaises(tessera.UsageError):
            restored(arrays[0], arrays[1][1:], *arrays[2:])

    def test_tiles_and_results_go_to_pools_and_come_back(self):
        t = tessera.triangulate(clouds.random(1000, 3), max_points_per_tile=200)
        with concurrent.futures.ProcessPoolExecutor(2, multiprocessing.get_context("forkserver")) as pool:
            self.assertEqual([*pool.map(cells_of, t, timeout=120)], [*map(cells_of, t)])
            tiles = [*pool.map(t.__getitem__, range(len(t)), timeout=120)]
        self.assertEqual([*map(cells_of, tiles)], [*map(cells_of, t)])


if __name__ == "__main__":
    unittest.main()
