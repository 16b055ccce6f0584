"""t.update(): the outcome is the triangulation from scratch of the points that are left."""
import unittest

import numpy as np
import tessera

import clouds
from triangulation_test import FolderTest


def vertices(t, name):
    """The attribute of each vertex, by id."""
    values = {}
    for tile in t:
        values.update(zip(tile.ids[~tile.foreign].tolist(), tile.attributes[name][~tile.foreign].tolist()))
    return values


class Update(FolderTest):
    def expect_as_from_scratch(self, t, points, gone, **options):
        """`points`: by id; those that are gone become NaN, so that the others keep their ids."""
        left = np.array(points)
        left[gone] = np.nan
        scratch = tessera.triangulate(left, skip_invalid=True, **options)
        self.assertEqual((t.digest, t.n_duplicates), (scratch.digest, scratch.n_duplicates))
        for name in options.get("attributes", ()):
            self.assertEqual(vertices(t, name), vertices(scratch, name))
        t.verify()

    def test_points_are_removed_and_added(self):
        for dim in (2, 3):
            for store in ("cells", "points"):
                with self.subTest(dim=dim, store=store):
                    points = np.round(clouds.random(900, dim) * 9)
                    value = np.arange(900) * 7
                    t = tessera.triangulate(points[:700], max_points_per_tile=100, store=store, attributes={"value": value[:700]})
                    gone = np.arange(0, 700, 3)
                    made = t.update(points[700:], gone, attributes={"value": value[700:]}, output=self.folder / f"{dim}{store}", threads=2)
                    self.assertEqual((made.first_id, made.removed, made.added), (700, len(gone), 200))
                    self.assertIsNot(made.triangulation, t)
                    self.assertLessEqual(made.tiles_changed, made.tiles_awake)
                    self.expect_as_from_scratch(made.triangulation, points, gone, attributes={"value": value})
                    again = made.triangulation.update(remove=[1, 850], output=self.folder / f"{dim}{store}2")
                    self.assertEqual((again.added, again.removed), (0, 2))
                    self.expect_as_from_scratch(again.triangulation, points, [*gone, 1, 850], attributes={"value": value})

    def test_new_points_take_places(self):
        points = np.round(clouds.random(300, 2) * 9)
        new = np.array([points[5], points[6], [20.5, 3]])
        heights = {"z": np.arange(303.0)}
        t = tessera.triangulate(points, attributes={"z": heights["z"][:300]})
        made = t.update(new, attributes={"z": heights["z"][300:]}, replace=True, output=self.folder / "replaced")
        gone = np.flatnonzero((points[:, None] == new).all(axis=2).any(axis=1))
        self.assertEqual(made.removed, len(gone))
        self.expect_as_from_scratch(made.triangulation, np.concatenate([points, new]), gone, attributes=heights)
        with_z = np.column_stack([new, heights["z"][300:]])
        other = t.update(with_z, replace=True, output=self.folder / "columns")
        self.assertEqual(other.triangulation.digest, made.triangulation.digest)

    def test_what_is_wrong_is_an_error(self):
        t = tessera.triangulate(clouds.random(100, 3), attributes={"value": np.arange(100)})
        to = self.folder / "wrong"
        for arguments, sentence in (({"remove": [100]}, "there is no point 100 to remove"),
                                    ({"remove": [3, -1]}, r"remove\[1\] is -1"),
                                    ({"remove": [0.5]}, "must be a list of integers"),
                                    ({"add": [[0, 1]]}, "the result is 3D"),
                                    ({"add": [[0, 1, 2]]}, "value"),
                                    ({"attributes": {"value": [1]}}, "there are none"),
                                    ({"add": [[0, 1, 2]], "attributes": {"value": np.array([1.5])}}, "other types")):
            with self.subTest(**arguments), self.assertRaisesRegex(tessera.UsageError, sentence):
                t.update(**arguments, output=to)
            self.assertFalse(to.exists())
        with self.assertRaisesRegex(tessera.BadInputError, "nan"):
            t.update([[0, 1, np.nan]], attributes={"value": np.array([1])}, output=to)
        self.assertFalse(to.exists())


if __name__ == "__main__":
    unittest.main()
