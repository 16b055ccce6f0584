"""Arrays of all kinds come in, and none is rounded."""
import decimal
import fractions
import gc
import sys
import unittest

import numpy as np
import pandas
import tessera
from tessera._arrays import exact_float64

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

    def test_arrays_of_objects_are_taken_number_by_number(self):
        half = fractions.Fraction(1, 2)
        self.assert_same(LATTICE.astype(object))
        self.assert_same([[0, half], [decimal.Decimal("0.25"), 1], [2**80, True], [np.float32(3), np.int8(-4)]],
                         np.array([[0, 0.5], [0.25, 1], [2.0**80, 1], [3, -4]]))
        for number, at in ((fractions.Fraction(1, 3), "no float64"), (decimal.Decimal("0.1"), "no float64"), (10**400, "no float64"),
                           (2**53 + 1, "no float64"), (None, "must be a number"), ("1", "must be a number"), (1j, "must be a number")):
            points = np.array([[0, 0], [1, 0], [0, 1], [5, number]], object)
            with self.subTest(number), self.assertRaisesRegex(tessera.UsageError, rf"^points\[3, 1\] is .*{at}"):
                tessera.Delaunay(points)

    def test_integers_beside_floats_are_not_rounded_on_the_way(self):
        with self.assertRaisesRegex(tessera.UsageError, r"points\[3, 0\] is 9007199254740993, which no float64"):
            tessera.Delaunay([[0, 0.5], [1, 0], [0, 1], [2**53 + 1, 3]])
        self.assert_same([[0, 0.5], [1, 0], [0, 1], [2**60, 3]], np.array([[0, 0.5], [1, 0], [0, 1], [2.0**60, 3]]))

    def check_frames(self, frame_of):
        """`frame_of` makes a DataFrame of columns by name."""
        points = clouds.random(60, 3)
        frame = frame_of({"x": points[:, 0], "y": points[:, 1], "z": points[:, 2]})
        self.assert_same(frame, points)
        np.testing.assert_array_equal(tessera.triangulate(frame).points(), points)
        f = tessera.LinearNDInterpolator(frame, frame["z"])
        np.testing.assert_array_equal(f(frame), points[:, 2])
        np.testing.assert_array_equal(f(frame["x"], frame["y"], frame["z"]), points[:, 2])
        mixed = frame_of({"x": np.array([0, 1, 0, 2**53 + 1]), "y": np.array([0, 0, 1, 1.5])})
        with self.assertRaisesRegex(tessera.UsageError, r"points\['x'\]\[3\] is 9007199254740993, which no float64"):
            tessera.Delaunay(mixed)
        with self.assertRaisesRegex(tessera.UsageError, r"points\['y'\] must hold integers or floats, not <U1"):
            tessera.Delaunay(frame_of({"x": np.arange(3.0), "y": np.array(["a", "b", "c"])}))

    def test_frames_are_taken_column_by_column(self):
        class Frame:  # as much of pandas as is used: columns of their own types, by position
            def __init__(self, columns):
                self.columns, self.values = list(columns), list(columns.values())
                self.iloc = self

            def __len__(self):
                return len(self.values[0])

            def __getitem__(self, key):
                return self.values[self.columns.index(key) if isinstance(key, str) else key[1]]

        self.check_frames(Frame)

    def test_frames_of_pandas(self):
        points = clouds.random(60, 2)
        frame = pandas.DataFrame(points, columns=["x", "y"], index=range(100, 160))
        self.assert_same(frame, points)
        self.assert_same(frame.convert_dtypes(), points)
        np.testing.assert_array_equal(tessera.LinearNDInterpolator(frame, frame["y"])(frame), points[:, 1])
        with self.assertRaisesRegex(tessera.UsageError, "must be a number"):
            tessera.Delaunay(pandas.DataFrame({"x": [0, 1, None, 2], "y": [0, 0, 1, 1]}, dtype="Int64"))

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
        self.assertIs(exact_float64(points, "points"), points)
        before = sys.getrefcount(points)
        tessera.triangulate(points)
        gc.collect()
        self.assertEqual(sys.getrefcount(points), before)


if __name__ == "__main__":
    unittest.main()
