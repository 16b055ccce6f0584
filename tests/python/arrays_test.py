"""Arrays of all kinds come in, and none is rounded."""
import gc
import sys
import unittest

import numpy as np
import tessera

import clouds

LATTICE = np.random.default_rng(5).permutation(clouds.lattice(12, 2))[:60]


class Arrays(unittest.TestCase):
    def assert_same(self, points, expected=LATTICE):
        tri = tessera.Delaunay(points)
        np.testing.assert_array_equal(tri.points, expected)
        np.testing.assert_array_equal(tri.simplices, tessera.Delaunay(expected).simplices)

    def test_every_type_gives_the_same_triangulation(self):
        for code in "bBhHiIlLqQefdg":
            with self.subTest(type=np.dtype(code).name):
                self.assert_same(LATTICE.astype(code))
                self.assert_same(LATTICE.astype(np.dtype(code).newbyteorder()))

    def test_every_layout_gives_the_same_triangulation(self):
        wide = np.zeros((2 * len(LATTICE), 5))
        wide[::2, 4:0:-2] = LATTICE
        packed = np.zeros(len(LATTICE), [("tag", "u1"), ("xy", "f8", 2)])
        packed["xy"] = LATTICE
        for name, points in {"Fortran": np.asfortranarray(LATTICE), "slice": wide[::2, 4:0:-2], "unaligned": packed["xy"],
                             "backwards": LATTICE[::-1].copy()[::-1], "read-only": np.broadcast_to(LATTICE, LATTICE.shape),
                             "lists": LATTICE.tolist(), "tuples": tuple(map(tuple, LATTICE))}.items():
            with self.subTest(name):
                self.assert_same(points)

    def test_float16_and_float32_keep_their_value(self):
        points = clouds.random(50, 2)
        for code in "ef":
            self.assert_same(points.astype(code), points.astype(code).astype(float))

    def test_what_float64_would_round_is_refused(self):
        rows = [[0, 0], [1, 0], [0, 1]]
        for code, last in {"q": 2**53 + 1, "Q": 2**64 - 1, "g": np.longdouble(1) / 3}.items():
            for source in (tessera.Delaunay, tessera.triangulate):
                points = np.array([*rows, [5, last]], code)
                with self.subTest(code), self.assertRaisesRegex(tessera.UsageError, r"points\[3, 1\].*does not round"):
                    source(points)
        exact = [*rows, [5, 2**60]]
        self.assert_same(np.array(exact, "q"), np.array(exact, float))
        self.assert_same(np.array([*rows, [-(2**63), 2**62]], "q"), np.array([*rows, [-(2.0**63), 2.0**62]]))

    def test_what_is_no_array_of_numbers_is_refused(self):
        for points in (np.zeros((4, 2), complex), [["a", "b"]], [[1, 2], [3]], np.array([[None, 1]]), {1, 2}, None,
                       np.ma.masked_less(LATTICE, 1)):
            with self.subTest(points), self.assertRaises(ValueError) as caught:
                tessera.Delaunay(points)
            self.assertIsInstance(caught.exception, tessera.UsageError)

    def test_wrong_shapes_are_refused(self):
        for shape in ((6,), (6, 1), (6, 4), (2, 3, 3), ()):
            for source in (tessera.Delaunay, tessera.triangulate):
                with self.subTest(shape), self.assertRaisesRegex(tessera.UsageError, r"\(n, 2\) or \(n, 3\)"):
                    source(np.zeros(shape))

    def test_points_that_span_nothing_or_are_not_finite_are_bad_input(self):
        for points in (np.empty((0, 2)), [[1, 2]], [[0, 0], [1, 1], [2, 2]], np.eye(3), [[0, 0], [1, 0], [0, np.nan]],
                       [[0, 0], [1, 0], [0, np.inf]]):
            for source in (tessera.Delaunay, tessera.triangulate):
                with self.subTest(points), self.assertRaises(tessera.BadInputError) as caught:
                    source(points)
                self.assertIsInstance(caught.exception, ValueError)
                self.assertEqual(caught.exception.cause, "bad_input")

    def test_a_fitting_array_is_not_copied_by_triangulate(self):
        points = clouds.random(1000, 3)
        self.assertIs(tessera._arrays.exact_float64(points, "points"), points)
        before = sys.getrefcount(points)
        tessera.triangulate(points)
        gc.collect()
        self.assertEqual(sys.getrefcount(points), before)


if __name__ == "__main__":
    unittest.main()
