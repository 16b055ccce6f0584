"""tessera.LinearNDInterpolator beside SciPy's, and where SciPy's gives up."""
import fractions
import pickle
import unittest

import numpy as np
import scipy.interpolate
import tessera

import clouds


def linear(points):
    """2 + x - 3 y (+ 5 z), in float64."""
    return 2 + points @ np.array([1, -3, 5])[: points.shape[-1]]


class BesideScipy(unittest.TestCase):
    def test_the_values_are_scipys(self):
        for dim in (2, 3):
            points, queries = clouds.random(500, dim), clouds.random(2000, dim, 2) * 1.2 - 0.1
            for shape in ((), (1,), (2, 3)):
                for kind in (float, complex):
                    values = np.random.default_rng(3).random((500, *shape)).astype(kind)
                    mine = tessera.LinearNDInterpolator(points, values)(queries)
                    theirs = scipy.interpolate.LinearNDInterpolator(points, values)(queries)
                    self.assertEqual((mine.shape, mine.dtype), (theirs.shape, theirs.dtype))
                    # Qhull's hull is a rounding error wider, so the outside may differ on it, but not here.
                    np.testing.assert_allclose(mine, theirs, rtol=1e-9, atol=1e-12)
                    self.assertTrue(0 < np.isnan(mine).any(axis=tuple(range(1, mine.ndim))).mean() < 1)

    def test_it_is_called_as_scipys(self):
        points, values = clouds.random(200, 2), np.arange(200)
        for rescale in (False, True):
            mine = tessera.LinearNDInterpolator(points * [1, 1000], values, fill_value=-1, rescale=rescale)
            theirs = scipy.interpolate.LinearNDInterpolator(points * [1, 1000], values, fill_value=-1, rescale=rescale)
            x, y = np.linspace(0, 1, 7), np.linspace(0, 1000, 5)
            grid = np.meshgrid(x, y)
            for arguments in (tuple(grid), (np.stack(grid, -1),), ((x[:, None], y),), (0.5, y), ([0.5, 500],), (0.5, 500)):
                a, b = mine(*arguments), theirs(*arguments)
                self.assertEqual(a.shape, b.shape)
                np.testing.assert_allclose(a, b, rtol=1e-9)
        np.testing.assert_array_equal(mine.values, theirs.values.ravel())

    def test_what_does_not_fit_is_refused(self):
        points = clouds.random(20, 3)
        f = tessera.LinearNDInterpolator(points, np.zeros(20))
        for call in (lambda: tessera.LinearNDInterpolator(points, np.zeros(19)), lambda: f(0.5, 0.5), lambda: f(0.5),
                     lambda: tessera.LinearNDInterpolator(points, 1), lambda: f(np.zeros((4, 2))),
                     lambda: tessera.LinearNDInterpolator(tessera.Delaunay(points), np.zeros(20), rescale=True)):
            with self.assertRaises(tessera.UsageError):
                call()


class Exactly(unittest.TestCase):
    def test_at_the_points_the_values_are_theirs_bit_for_bit(self):
        for points in (clouds.random(300, 2), clouds.random(300, 3), clouds.lattice(6, 3), clouds.lattice(12, 2)):
            values = np.random.default_rng(5).random(len(points))
            np.testing.assert_array_equal(tessera.LinearNDInterpolator(points, values)(points), values)

    def test_of_equal_points_the_first_counts(self):
        f = tessera.LinearNDInterpolator([[0, 0], [1, 0], [0, 1], [1, 0]], [0, 5, 0, 7])
        self.assertEqual(f(1, 0), 5)

    def test_the_boundary_is_inside_and_a_rounding_error_beyond_it_is_not(self):
        f = tessera.LinearNDInterpolator([[0, 0], [3, 1], [0, 1]], [0, 3, 0])
        self.assertEqual(f(1.5, 0.5), 1.5)
        self.assertTrue(np.isnan(f(1.5, np.nextafter(0.5, 0))))

    def test_linear_functions_come_out_in_flat_simplices_of_any_size(self):
        for dim in (2, 3):
            for flatness in (1e-3, 1e-9, 1e-14):
                for scale in (1, 2.0**-1000, 2.0**900):
                    points = clouds.random(200, dim, 7)
                    points[:, -1] *= flatness
                    hull = tessera.Delaunay(points)
                    inside = points[hull.simplices[:300]].mean(axis=1)
                    values = points[:, 0] + points[:, 1]  # of the coordinates that differ most
                    f = tessera.LinearNDInterpolator(points * scale, values)
                    found = f(inside * scale)
                    exact = np.array([float(sum(map(fractions.Fraction, row[:2].tolist()))) for row in inside])
                    known = ~np.isnan(found)
                    self.assertGreater(known.mean(), 0.9)
                    np.testing.assert_allclose(found[known], exact[known], rtol=1e-9)

    def test_values_stay_between_those_of_the_corners(self):
        points = clouds.random(400, 3)
        values = np.random.default_rng(6).random(400)
        f = tessera.LinearNDInterpolator(points, values)
        queries = clouds.random(2000, 3, 9)
        found = f.tri.find_simplex(queries)
        queries, corners = queries[found >= 0], values[f.tri.simplices[found[found >= 0]]]
        results = f(queries)
        self.assertTrue(((results >= corners.min(axis=1) - 1e-15) & (results <= corners.max(axis=1) + 1e-15)).all())

    def test_it_is_pickled(self):
        points = clouds.random(100, 2)
        f = tessera.LinearNDInterpolator(points, linear(points), fill_value=7)
        again = pickle.loads(pickle.dumps(f))
        queries = clouds.random(100, 2, 4) * 2
        np.testing.assert_array_equal(again(queries), f(queries))


if __name__ == "__main__":
    unittest.main()
