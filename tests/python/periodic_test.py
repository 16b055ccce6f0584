"""Periodic triangulations in Python: tiles have images, with offsets; what cannot do with them says so."""
import pickle
import unittest

import numpy as np
import tessera


def cells_of(t):
    """Each cell as a set of (id, offset), shifted such that its least vertex has the offset 0."""
    found = set()
    for tile in t:
        offsets = tile.offsets if tile.offsets is not None else np.zeros((len(tile.ids), tile.dim), np.int8)
        for cell in tile.cells[~tile.ghost]:
            corners = sorted((int(tile.ids[v]), tuple(int(n) for n in offsets[v])) for v in cell)
            least = corners[0][1]
            found.add(tuple((i, tuple(a - b for a, b in zip(o, least))) for i, o in corners))
    return found


class Periodic(unittest.TestCase):
    def test_tiles_have_the_images_of_points(self):
        points = np.random.default_rng(1).integers(0, 2**20, (500, 3)) * 4 / 2**20
        with tessera.triangulate(points, periodic=4, tiles=5) as t, tessera.triangulate(points, periodic=(4, 4, 4), tiles=1) as one:
            self.assertEqual((t.period, t.digest), ((4, 4, 4), one.digest))
            self.assertEqual(cells_of(t), cells_of(one))
            self.assertEqual(len(cells_of(t)), t.n_cells)
            volume = 0
            for tile in t:
                np.testing.assert_array_equal(tile.points, points[tile.ids] + 4 * tile.offsets)
                self.assertTrue((tile.foreign | (tile.offsets == 0).all(1)).all())
                corners = tile.points[tile.cells[~tile.ghost]]
                volume += np.linalg.det(corners[:, 1:] - corners[:, :1]).sum() / 6
                again = pickle.loads(pickle.dumps(tile))
                np.testing.assert_array_equal(again.offsets, tile.offsets)
            self.assertAlmostEqual(volume, 64, places=9)
            self.assertGreater(len(t.verify().checks), 5)

    def test_some_axes_have_no_period(self):
        points = np.random.default_rng(2).integers(0, 64, (300, 2)) / 64
        with tessera.triangulate(points, periodic=(1, 0)) as t:
            self.assertEqual(t.period, (1, 0))
            self.assertTrue((t[0].offsets[:, 1] == 0).all())
            t.verify()
        with tessera.triangulate(points) as t:
            self.assertEqual((t.period, t[0].offsets), ((0, 0), None))

    def test_numbers_that_images_would_round(self):
        points = [[0.1, 0.2, 0.3]]
        with self.assertWarnsRegex(UserWarning, "coordinates were rounded"):
            tessera.triangulate(points, periodic=1).verify()
        with self.assertRaisesRegex(tessera.BadInputError, r"row 0: x has too many binary digits .*\(periodic_snap='yes' rounds it\)"):
            tessera.triangulate(points, periodic=1, periodic_snap="no")
        with self.assertRaisesRegex(tessera.UsageError, "periodic_snap: 'maybe' is neither yes nor no"):
            tessera.triangulate(points, periodic=1, periodic_snap="maybe")
        with self.assertRaisesRegex(tessera.UsageError, "periodic: the period -1 is negative"):
            tessera.triangulate(points, periodic=-1)

    def test_what_knows_no_periods_says_so(self):
        points = np.random.default_rng(3).integers(0, 64, (300, 2)) / 64
        with tessera.triangulate(points, periodic=1) as t:
            for work in (lambda: t.locate([[0.5, 0.5]]), lambda: t.star(0)):
                with self.assertRaisesRegex(tessera.UsageError, "the triangulation of a periodic cloud"):
                    work()
            with self.assertRaisesRegex(tessera.UsageError, "corners of periodic cells are images"):
                t.simplices()
            self.assertEqual(t.points().shape, (300, 2))


if __name__ == "__main__":
    unittest.main()
