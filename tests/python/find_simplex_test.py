"""Delaunay.find_simplex against every simplex in turn, and against SciPy's."""
import concurrent.futures
import unittest

import numpy as np
import scipy.spatial
import tessera

import clouds


def holds(points, simplex, query):
    """Whether the simplex, boundary included, holds the query. All in integers."""
    corners = [points[i] for i in simplex]
    for k in range(len(corners)):
        with_query = corners[:k] + [query] + corners[k + 1 :]
        if clouds.determinant([[a - b for a, b in zip(p, with_query[0])] for p in with_query[1:]]) < 0:
            return False
    return True


class FindSimplex(unittest.TestCase):
    def assert_found(self, points, queries):
        """Every query is in its simplex, or, when there is none, in no simplex at all."""
        tri = tessera.Delaunay(points)
        exact, _ = clouds.integers(np.vstack([points, queries]))
        simplices = tri.simplices.tolist()
        for query, found in zip(exact[len(points) :], tri.find_simplex(queries)):
            if found >= 0:
                self.assertTrue(holds(exact, simplices[found], query))
            else:
                self.assertFalse(any(holds(exact, simplex, query) for simplex in simplices))

    def test_random_queries(self):
        for dim in (2, 3):
            self.assert_found(clouds.random(60, dim), clouds.random(200, dim, 2) * 1.4 - 0.2)

    def test_vertices_edges_and_facets_of_lattices_count_as_inside(self):
        for dim in (2, 3):
            points = clouds.lattice(4, dim)
            queries = np.vstack([points, points + 0.5, points - 0.5 * np.eye(dim)[0], points * 0.75, points + 3])
            self.assert_found(points, queries)
            self.assertGreaterEqual(tessera.Delaunay(points).find_simplex(points).min(), 0)

    def test_vertices_are_found_and_a_hair_outside_is_outside(self):
        for dim in (2, 3):
            points = clouds.random(500, dim)
            tri = tessera.Delaunay(points)
            self.assertTrue((tri.simplices[tri.find_simplex(points)] == np.arange(500)[:, None]).any(axis=1).all())
        square = tessera.Delaunay([[0, 0], [1, 0], [0, 1], [1, 1]])
        self.assertGreaterEqual(square.find_simplex([1, 0.3]), 0)
        self.assertEqual(square.find_simplex([np.nextafter(1, 2), 0.3]), -1)

    def test_it_is_scipys_in_general_position(self):
        for dim in (2, 3):
            points, queries = clouds.random(1000, dim), clouds.random(3000, dim, 2) * 1.2 - 0.1
            ours, theirs = tessera.Delaunay(points), scipy.spatial.Delaunay(points)
            mine, scipys = ours.find_simplex(queries), theirs.find_simplex(queries)
            np.testing.assert_array_equal(mine >= 0, scipys >= 0)
            inside = mine >= 0
            np.testing.assert_array_equal(np.sort(ours.simplices[mine[inside]]), np.sort(theirs.simplices[scipys[inside]]))
            np.testing.assert_array_equal(ours.find_simplex(queries, bruteforce=True, tol=0), mine)

    def test_shapes_and_types_are_scipys(self):
        points = clouds.random(30, 3)
        ours, theirs = tessera.Delaunay(points), scipy.spatial.Delaunay(points)
        for shape in ((3,), (5, 3), (0, 3), (2, 4, 3), (2, 0, 4, 3)):
            queries = np.full(shape, 0.5)
            mine, scipys = ours.find_simplex(queries), theirs.find_simplex(queries)
            self.assertEqual((type(mine), mine.dtype, mine.shape), (type(scipys), scipys.dtype, scipys.shape))
        for queries in (np.zeros((5, 2)), 1.0, np.zeros(4)):
            with self.assertRaises(ValueError):
                ours.find_simplex(queries)
        with self.assertRaisesRegex(tessera.UsageError, "tol"):
            ours.find_simplex(points, tol=1e-9)

    def test_what_is_not_finite_is_outside(self):
        tri = tessera.Delaunay(clouds.random(30, 2))
        self.assertEqual(tri.find_simplex([[np.nan, 0.5], [np.inf, 0.5], [0.5, -np.inf]]).tolist(), [-1, -1, -1])

    def test_many_threads_find_the_same(self):
        tri, queries = tessera.Delaunay(clouds.random(2000, 3)), clouds.random(40000, 3, 2)
        with concurrent.futures.ThreadPoolExecutor(4) as pool:
            results = list(pool.map(tri.find_simplex, [queries] * 8))
        for result in results:
            np.testing.assert_array_equal(result, results[0])


if __name__ == "__main__":
    unittest.main()
