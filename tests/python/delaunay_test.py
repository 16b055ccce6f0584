"""tessera.Delaunay against scipy.spatial.Delaunay, and against what a Delaunay triangulation is."""
import copy
import gc
import pickle
import resource
import sys
import unittest

import numpy as np
import scipy.interpolate
import scipy.spatial
import tessera

import clouds


class AgainstScipy(unittest.TestCase):
    def pairs(self, sizes=(4, 5, 10, 100, 1000)):
        for dim in (2, 3):
            for n in sizes:
                for seed in range(3):
                    points = clouds.random(n, dim, seed)
                    with self.subTest(dim=dim, n=n, seed=seed):
                        yield tessera.Delaunay(points), scipy.spatial.Delaunay(points)

    def test_simplices_are_the_same(self):
        for ours, theirs in self.pairs():
            self.assertEqual(clouds.simplex_set(ours.simplices), clouds.simplex_set(theirs.simplices))
            self.assertEqual(ours.nsimplex, theirs.nsimplex)

    def test_attributes_have_the_same_types_and_shapes(self):
        for ours, theirs in self.pairs(sizes=(30,)):
            for name in ("points", "simplices", "neighbors", "convex_hull", "coplanar", "vertex_to_simplex", "transform",
                         "min_bound", "max_bound"):
                mine, scipys = getattr(ours, name), getattr(theirs, name)
                self.assertEqual((mine.dtype, mine.shape), (scipys.dtype, scipys.shape), name)
            for mine, scipys in zip(ours.vertex_neighbor_vertices, theirs.vertex_neighbor_vertices):
                self.assertEqual((mine.dtype, mine.shape), (scipys.dtype, scipys.shape))
            for name in ("ndim", "npoints", "nsimplex", "furthest_site"):
                self.assertEqual(getattr(ours, name), getattr(theirs, name), name)
            np.testing.assert_array_equal(ours.min_bound, theirs.min_bound)
            np.testing.assert_array_equal(ours.max_bound, theirs.max_bound)

    def test_the_hull_is_the_same(self):
        for ours, theirs in self.pairs():
            self.assertEqual(clouds.simplex_set(ours.convex_hull), clouds.simplex_set(theirs.convex_hull))

    def test_neighbors_of_vertices_are_the_same(self):
        for ours, theirs in self.pairs():
            (starts, mine), (their_starts, scipys) = ours.vertex_neighbor_vertices, theirs.vertex_neighbor_vertices
            np.testing.assert_array_equal(starts, their_starts)
            for begin, end in zip(starts, starts[1:]):
                np.testing.assert_array_equal(mine[begin:end], np.sort(scipys[begin:end]))

    def test_barycentric_coordinates_are_those_of_scipys_transform(self):
        for ours, theirs in self.pairs():
            # Rows by the sorted vertices; scaled by the condition, to which both are rounded.
            queries = clouds.random(20, ours.ndim, seed=9)
            index = {tuple(sorted(row)): i for i, row in enumerate(theirs.simplices.tolist())}
            for i, row in enumerate(ours.simplices.tolist()):
                j = index[tuple(sorted(row))]
                mine, scipys = barycentric(ours, i, queries), barycentric(theirs, j, queries)
                edges = ours.points[row[:-1]] - ours.points[row[-1]]
                np.testing.assert_allclose(mine[:, np.argsort(row)], scipys[:, np.argsort(theirs.simplices[j])],
                                           atol=1e-13 * np.linalg.cond(edges) * np.abs(scipys).max())

    def test_duplicates_are_coplanar_as_in_scipy(self):
        points = clouds.random(40, 2)
        points[[7, 30, 39]] = points[[3, 3, 12]]
        ours, theirs = tessera.Delaunay(points), scipy.spatial.Delaunay(points)
        self.assertEqual(ours.coplanar[:, [0, 2]].tolist(), [[7, 3], [30, 3], [39, 12]])
        self.assertEqual((ours.coplanar.dtype, len(ours.coplanar)), (theirs.coplanar.dtype, len(theirs.coplanar)))
        for _, simplex, vertex in ours.coplanar:
            self.assertIn(vertex, ours.simplices[simplex])
        np.testing.assert_array_equal(ours.vertex_to_simplex[[7, 30, 39]], ours.coplanar[:, 1])
        same = np.arange(40)
        same[ours.coplanar[:, 0]] = ours.coplanar[:, 2]
        self.assertEqual(clouds.simplex_set(ours.simplices), clouds.simplex_set(np.sort(same[theirs.simplices])))
        starts, _ = ours.vertex_neighbor_vertices
        self.assertEqual(np.diff(starts)[[7, 30, 39]].tolist(), [0, 0, 0])

    def test_scipys_interpolators_do_not_take_it(self):
        """As docs/python.md says. When this fails, SciPy has learnt to, and the guide can say so."""
        tri = tessera.Delaunay(clouds.random(30, 2))
        with self.assertRaises(Exception):
            scipy.interpolate.LinearNDInterpolator(tri, np.arange(30.0))

    def test_interpolation_as_everybody_writes_it_equals_scipys(self):
        for dim in (2, 3):
            points, values, queries = clouds.random(300, dim), clouds.random(300, 1, 2)[:, 0], clouds.random(500, dim, 3)
            tri = tessera.Delaunay(points)
            simplex = tri.find_simplex(queries)
            b = np.einsum("nij,nj->ni", tri.transform[simplex, :dim], queries - tri.transform[simplex, dim])
            weights = np.column_stack([b, 1 - b.sum(axis=1)])
            result = np.where(simplex >= 0, (values[tri.simplices[simplex]] * weights).sum(axis=1), np.nan)
            expected = scipy.interpolate.LinearNDInterpolator(points, values)(queries)
            np.testing.assert_allclose(result, expected, rtol=0, atol=1e-9)


def barycentric(tri, simplex, queries):
    """As SciPy documents it: len(queries) x (ndim+1)."""
    d = tri.ndim
    b = tri.transform[simplex, :d].dot(np.transpose(queries - tri.transform[simplex, d]))
    return np.c_[np.transpose(b), 1 - b.sum(axis=0)]


class Exact(unittest.TestCase):
    def test_lattices_are_delaunay_and_fill_their_hull(self):
        for dim, side in ((2, 8), (3, 4)):
            for factor in (1.0, 0.1, 1e-200):  # tenths: nearly a lattice; 1e-200: squares vanish in doubles
                with self.subTest(dim=dim, factor=factor):
                    points = clouds.lattice(side, dim) * factor
                    exact, scale = clouds.integers([[points.max()]])
                    volume = clouds.fractions.Fraction(exact[0][0], scale) ** dim
                    clouds.assert_delaunay(self, points, tessera.Delaunay(points).simplices, volume)

    def test_cocircular_points_are_triangulated(self):
        points = [[a, b] for a in range(-65, 66) for b in range(-65, 66) if a * a + b * b == 65 * 65]
        tri = tessera.Delaunay(points)
        self.assertEqual(tri.nsimplex, len(points) - 2)
        self.assertEqual(len(tri.convex_hull), len(points))
        self.assertEqual(min(clouds.volumes(points, tri.simplices)) > 0, True)

    def test_the_order_of_points_changes_nothing(self):
        for points in (clouds.lattice(4, 3), clouds.random(200, 3)):
            order = np.random.default_rng(4).permutation(len(points))
            shuffled = tessera.Delaunay(points[order])
            self.assertEqual(clouds.simplex_set(order[shuffled.simplices]),
                             clouds.simplex_set(tessera.Delaunay(points).simplices))

    def test_points_far_from_the_origin_are_not_rounded(self):
        # Some 2^-10 apart at 2^40: their squares differ in the 100th bit.
        points = 2.0**40 + np.random.default_rng(1).permutation(2**12)[:80].reshape(40, 2) * 2.0**-10
        hull = tessera.Delaunay(points).convex_hull
        exact, scale = clouds.integers(points)
        doubled = sum(exact[a][0] * exact[b][1] - exact[a][1] * exact[b][0] for a, b in hull.tolist())
        clouds.assert_delaunay(self, points, tessera.Delaunay(points).simplices,
                               clouds.fractions.Fraction(doubled, 2 * scale**2))

    def test_simplices_are_positive_and_hull_facets_face_outwards(self):
        for dim in (2, 3):
            points = clouds.random(100, dim)
            tri = tessera.Delaunay(points)
            self.assertGreater(min(clouds.volumes(clouds.integers(points)[0], tri.simplices)), 0)
            inner = points.mean(axis=0)
            for facet in tri.convex_hull:
                corners = points[facet]
                side = np.linalg.det(np.vstack([corners[1:] - corners[0], inner - corners[0]]))
                # 2D: the inside is on the left; 3D: below a facet that is counterclockwise from above.
                self.assertGreater(side if dim == 2 else -side, 0)

    def test_neighbors_are_mutual_and_opposite_their_vertex(self):
        for points in (clouds.random(300, 2), clouds.random(300, 3), clouds.lattice(5, 3)):
            tri = tessera.Delaunay(points)
            for i, (corners, across) in enumerate(zip(tri.simplices.tolist(), tri.neighbors.tolist())):
                for k, j in enumerate(across):
                    if j >= 0:
                        facet = set(corners) - {corners[k]}
                        self.assertLess(facet, set(tri.simplices[j].tolist()))
                        self.assertIn(i, tri.neighbors[j])

    def test_every_vertex_has_a_simplex_of_its_own(self):
        tri = tessera.Delaunay(clouds.lattice(5, 3))
        self.assertTrue((tri.simplices[tri.vertex_to_simplex] == np.arange(125)[:, None]).any(axis=1).all())

    def test_flat_simplices_have_no_transform(self):
        tri = tessera.Delaunay([[0, 0], [2, 0], [1, 1e-14], [1, 1]])
        self.assertEqual(sorted(np.isnan(tri.transform).all(axis=(1, 2)).tolist()), [False, False, True])


class Object(unittest.TestCase):
    def test_options_of_qhull_are_refused_with_a_sentence(self):
        points = clouds.random(10, 2)
        for option in ({"furthest_site": True}, {"incremental": True}, {"qhull_options": "QJ"}):
            with self.assertRaisesRegex(tessera.UsageError, next(iter(option))):
                tessera.Delaunay(points, **option)
        tri = tessera.Delaunay(points, False, False, None)
        tri.close()
        for name in ("equations", "add_points", "plane_distance"):
            self.assertFalse(hasattr(tri, name))

    def test_arrays_are_read_only_and_outlive_their_object(self):
        points = clouds.random(5000, 3)
        tri = tessera.Delaunay(points)
        simplices, neighbors, kept = tri.simplices, tri.neighbors, tri.points
        with self.assertRaises(ValueError):
            simplices[0] = 0
        copied = simplices.copy(), neighbors.copy()
        del tri
        gc.collect()
        filler = [np.full(100000, 7) for _ in range(50)]  # what would come in their place
        np.testing.assert_array_equal(simplices, copied[0])
        np.testing.assert_array_equal(neighbors, copied[1])
        np.testing.assert_array_equal(kept, points)
        del filler

    def test_the_points_given_may_change_afterwards(self):
        points = clouds.random(100, 2)
        given = points.copy()
        tri = tessera.Delaunay(given)
        given[:] = 0
        np.testing.assert_array_equal(tri.points, points)

    def test_it_is_pickled_and_copied_as_its_points(self):
        tri = tessera.Delaunay(clouds.lattice(4, 3))
        for again in (pickle.loads(pickle.dumps(tri)), copy.deepcopy(tri)):
            np.testing.assert_array_equal(again.simplices, tri.simplices)

    def test_nothing_leaks(self):
        points = clouds.random(20000, 2)

        def work():
            tri = tessera.Delaunay(points)
            return (tri.simplices[0], tri.neighbors[0], tri.transform[0], tri.convex_hull, tri.coplanar,
                    tri.vertex_neighbor_vertices, tri.find_simplex(points[:10]))

        def refused():
            with self.assertRaises(tessera.BadInputError):
                tessera.Delaunay(np.zeros((100, 2)))

        for _ in range(5):
            work(), refused()
        counts, peak = sys.getrefcount(points), resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
        for _ in range(60):
            work(), refused()
        self.assertEqual(sys.getrefcount(points), counts)
        # One triangulation holds some 3 MB; 60 of them would be 180.
        self.assertLess(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - peak, 30_000)


if __name__ == "__main__":
    unittest.main()
