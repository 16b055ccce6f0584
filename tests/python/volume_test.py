"""Volumes from Python: the same as of the command."""
import json
import os
import pathlib
import subprocess
import tempfile
import unittest
import warnings

import numpy as np
import tessera

IGN = pathlib.Path(os.environ["IGN"])


class Volume(unittest.TestCase):
    def setUp(self):
        held = tempfile.TemporaryDirectory()
        self.addCleanup(held.cleanup)
        self.folder = pathlib.Path(held.name)

    def test_a_table_is_that_of_the_command(self):
        before = tessera.triangulate(IGN, dim=2, classes=[2], folder=self.folder / "before", max_points_per_tile=9000)
        after = tessera.triangulate(IGN, dim=2, returns="first", folder=self.folder / "after", max_points_per_tile=20000)
        low = np.array(before.info()["bounds"]["min"])[:2]
        shape = self.folder / "shape.geojson"
        corners = [(20, 20), (60, 25), (50, 70), (20, 20)]
        shape.write_text(json.dumps({"type": "Feature", "properties": {"name": "a field"}, "geometry": {
            "type": "Polygon", "coordinates": [[(low + corner).tolist() for corner in corners]]}}))
        for given, options in (({}, []), ({"within": shape, "max_edge": 5}, ["--within", shape, "--max-edge", 5])):
            table = before.volume(after, **given)
            done = subprocess.run([os.environ["TESSERA"], "volume", before.folder, after.folder, *map(str, options), "--json"],
                                  check=True, capture_output=True, text=True)
            rows = json.loads(done.stdout.splitlines()[-1])["rows"]
            for name in "cut", "fill", "net", "mean", "area", "covered", "uncovered", "uncovered_by_a", "uncovered_by_b":
                self.assertEqual(getattr(table, name).tolist(), [row[name] for row in rows])
            self.assertEqual(table.names, [row["name"] for row in rows if "name" in row])
            self.assertEqual((table.area_unit, table.volume_unit), ("metre^2", "metre^3"))

    def test_a_pyramid_over_planes(self):
        points = np.array([[0, 0], [4, 0], [4, 4], [0, 4], [2, 2]], float)
        pyramid = tessera.triangulate(points, dim=2, attributes={"z": np.array([0., 0, 0, 0, 3])})
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            table = pyramid.volume(plane=0)
        self.assertEqual(len(caught), 1)  # there is no coordinate system
        self.assertEqual((table.cut.tolist(), table.fill.tolist(), table.area.tolist()), ([16], [0], [16]))
        self.assertEqual((table.names, table.polygons.tolist()), ([], []))

    def test_wrong_arguments_are_refused(self):
        pyramid = tessera.triangulate(np.random.default_rng(1).random((20, 2)), dim=2, attributes={"z": np.zeros(20)})
        for wrong in ({}, {"plane": float("nan")}, {"plane": 1, "base": "a.gpkg"}, {"plane": 1, "res": 1},
                      {"plane": 1, "value": "height"}):
            with self.assertRaises(tessera.UsageError):
                pyramid.volume(**wrong)
        with self.assertRaisesRegex(tessera.UsageError, "give one thing to compare with"):
            pyramid.volume()


if __name__ == "__main__":
    unittest.main()
