"""Rasters' systems, hillshades, contour lines and profiles: the same as of the command, and what they are."""
import json
import os
import pathlib
import subprocess
import tempfile
import unittest
import warnings

import numpy as np
import tessera
from osgeo import gdal

gdal.UseExceptions()

IGN = pathlib.Path(os.environ["IGN"])


class Lines(unittest.TestCase):
    def setUp(self):
        self.held = tempfile.TemporaryDirectory()
        self.addCleanup(self.held.cleanup)
        self.folder = pathlib.Path(self.held.name)
        self.ground = tessera.triangulate(IGN, dim=2, classes=[2], max_points_per_tile=3000, folder=self.folder / "ground",
                                          attributes=["intensity"])
        low = np.array(self.ground.info()["bounds"]["min"])[:2]
        self.box = [*(low + 20), *(low + 60)]
        self.line = low + [[10, 10], [60, 55], [80, 55.5]]

    def same_as_of_the_command(self, name, write, *command):
        """write(path) and the command write the same bytes."""
        mine, theirs = self.folder / name, self.folder / f"command-{name}"
        write(mine)
        subprocess.run([os.environ["TESSERA"], command[0], self.ground.folder, *map(str, command[1:]), "-o", theirs],
                       check=True, capture_output=True)
        self.assertEqual(mine.read_bytes(), theirs.read_bytes())
        return mine

    def test_local_exports_are_those_of_the_command(self):
        self.same_as_of_the_command("ground.ply", lambda path: self.ground.export(path, local=True), "export", "--local")

    def test_contour_lines_are_those_of_the_command(self):
        box = ",".join(map(repr, self.box))
        path = self.same_as_of_the_command(
            "lines.geojson", lambda path: self.ground.contours(path, interval=0.5, base=0.2, bbox=self.box, max_edge=5),
            "contours", "--interval", 0.5, "--base", 0.2, "--bbox", box, "--max-edge", 5)
        features = json.loads(path.read_text())["features"]
        lines = self.ground.contours(interval=0.5, base=0.2, bbox=self.box, max_edge=5)
        self.assertGreater(len(lines), 5)
        self.assertEqual([line.value for line in lines], [each["properties"]["elevation"] for each in features])
        for line, each in zip(lines, features):
            self.assertEqual(line.points.tolist(), [point[:2] for point in each["geometry"]["coordinates"]])
            self.assertLess(np.abs(self.ground.interpolate(line.points[1:-1]) - line.value).max(initial=0), 1e-6)
        self.assertGreater(len(self.ground.contours(interval=0.5, base=0.2)), len(lines))
        self.assertEqual({line.value % 50 for line in self.ground.contours(interval=50, value="intensity")}, {0})
        self.assertEqual(self.ground.contours(interval=1000, base=500), [])
        self.ground.contours(self.folder / "lines.gpkg", interval=1)
        self.assertTrue((self.folder / "lines.gpkg").read_bytes().startswith(b"SQLite"))

    def test_a_profile_is_that_of_the_command(self):
        text = " ".join(f"{x!r},{y!r}" for x, y in self.line.tolist())
        path = self.same_as_of_the_command("profile.csv", lambda path: self.ground.profile(self.line, path, max_edge=5, digits="all"),
                                           "profile", "--line", text, "--max-edge", 5, "--digits", "all")
        table = np.loadtxt(path, delimiter=",", skiprows=1)
        profile = self.ground.profile(self.line, max_edge=5)
        self.assertGreater(len(table), 20)
        np.testing.assert_array_equal(np.column_stack(profile[:3] + (profile.parts,)), table)
        np.testing.assert_allclose(self.ground.interpolate(profile.points), profile.values, atol=1e-6)
        self.assertEqual(profile.points[0].tolist(), self.line[0].tolist())

        for digits in (None, 2):
            self.same_as_of_the_command(f"rounded{digits}.csv", lambda path: self.ground.profile(self.line, path, digits=digits),
                                        "profile", "--line", text, "--digits", "data" if digits is None else digits)
        with self.assertWarnsRegex(UserWarning, "^the surface begins .* after the line's beginning"):
            self.ground.profile(self.line - [[100, 0], [0, 0], [0, 0]], self.folder / "outside.csv")

    def test_lines_for_maps_are_those_of_the_command(self):
        path = self.same_as_of_the_command(
            "map.geojson", lambda path: self.ground.contours(path, interval=0.25, smooth=1, min_length=5, index_every=2),
            "contours", "--interval", 0.25, "--smooth", 1, "--min-length", 5, "--index-every", 2)
        features = json.loads(path.read_text())["features"]
        lines = self.ground.contours(interval=0.25, smooth=1, min_length=5, index_every=2)
        self.assertEqual([(line.value, line.index) for line in lines],
                         [(each["properties"]["elevation"], each["properties"]["index"]) for each in features])
        self.assertEqual({line.index for line in lines}, {False, True})
        self.assertGreater(min(np.hypot(*np.diff(line.points, axis=0).T).sum() for line in lines), 5)

    def test_a_hillshade_is_that_of_the_command(self):
        plain = self.same_as_of_the_command("a.tif", lambda path: self.ground.dem(path, res=1, hillshade=True),
                                            "dem", "--res", 1, "--hillshade")
        lit = self.same_as_of_the_command(
            "b.tif", lambda path: self.ground.dem(path, res=1, bbox=self.box, hillshade=True, azimuth=90, altitude=30),
            "dem", "--res", 1, "--bbox", ",".join(map(repr, self.box)), "--hillshade", "--azimuth", 90, "--altitude", 30)
        self.assertNotEqual(plain.read_bytes(), lit.read_bytes())
        with self.assertRaisesRegex(tessera.UsageError, "^hillshade=True: a shaded raster has pixels of bytes"):
            self.ground.dem(res=1, hillshade=True, doubles=True)
        for path, more in ((plain, {}), (lit, {"bbox": self.box, "azimuth": 90, "altitude": 30})):
            raster = self.ground.dem(res=1, hillshade=True, **more)
            bytes_of_file = gdal.Open(str(path)).ReadAsArray()
            np.testing.assert_array_equal(np.nan_to_num(raster.values, nan=0), bytes_of_file)
            self.assertEqual(np.isnan(raster.values).sum(), (bytes_of_file == 0).sum())
            self.assertGreater(len(np.unique(raster.values)), 50)

    def test_rasters_have_the_system_of_the_result(self):
        raster = self.ground.dem(res=5)
        self.assertEqual(raster.crs, self.ground.crs)
        self.assertIn("Lambert-93", raster.crs)
        self.assertEqual(tessera.triangulate(np.random.default_rng(1).random((50, 3)), dim=2).dem(res=0.5).crs, "")

    def test_lines_of_coordinates_without_a_system_warn_in_files_alone(self):
        t = tessera.triangulate(np.random.default_rng(1).random((50, 3)), dim=2)
        with self.assertWarnsRegex(UserWarning, "coordinate") as caught:
            t.contours(self.folder / "a.geojson", interval=0.1)
        self.assertEqual(caught.filename, __file__)
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            self.assertGreater(len(t.contours(interval=0.1)), 3)

    def test_what_makes_no_sense_is_refused_by_its_name(self):
        def refused(sentence, call, *arguments, **named):
            with self.subTest(sentence), self.assertRaisesRegex(tessera.UsageError, sentence):
                call(*arguments, **named)

        t, out = self.ground, self.folder / "there.csv"
        out.write_text("mine")
        for interval in (0, -1, np.nan, np.inf):
            refused("^interval: must be a length", t.contours, interval=interval)
        refused("^interval: is too small", t.contours, interval=1e-12)
        refused("^base: must be finite", t.contours, interval=1, base=np.inf)
        refused("^bbox must be", t.contours, interval=1, bbox=[0, 0, 1])
        refused("^bbox: is an empty box", t.contours, interval=1, bbox=[1, 1, 0, 0])
        refused("^bbox: must be finite", t.contours, interval=1, bbox=[0, 0, np.nan, 1])
        refused("^max_edge: must be a length", t.contours, interval=1, max_edge=-1)
        refused("^smooth: must be a length", t.contours, interval=1, smooth=0)
        refused("^smooth: is too small", t.contours, interval=1, smooth=1e-9)
        refused("^min_length: must be a length", t.contours, interval=1, min_length=-1)
        refused("^index_every: must be from 1", t.contours, interval=1, index_every=0)
        refused("^digits is 18", t.profile, self.line, self.folder / "a.csv", digits=18)
        refused("'colour'", t.contours, interval=1, value="colour")
        refused("png", t.contours, self.folder / "a.png", interval=1)
        refused("^line has the shape", t.profile, [[0, 0]])
        refused("^line has the shape", t.profile, [[0, 0, 0], [1, 1, 1]])
        refused("^line: point 1 is not finite", t.profile, [[0, 0], [np.nan, 1]])
        refused("meets no cell", t.profile, [[0, 0], [1, 1]])
        refused("^max_edge: must be a length", t.profile, self.line, max_edge=0)
        refused("there.csv: exists already; overwrite=True replaces it", t.profile, self.line, out)
        self.assertEqual(out.read_text(), "mine")
        t.profile(self.line, out, overwrite=True)
        self.assertTrue(out.read_text().startswith("distance,x,y,z,part\n"))
        refused("^hillshade=True: a shaded raster has pixels of bytes, so doubles cannot be given with it", t.dem, self.folder / "a.tif", res=1, hillshade=True, doubles=True)
        refused("^azimuth and altitude are for a hillshade", t.dem, self.folder / "a.tif", res=1, azimuth=3)
        refused("^altitude", t.dem, self.folder / "a.tif", res=1, hillshade=True, altitude=91)
        solid = tessera.triangulate(np.random.default_rng(1).random((50, 3)))
        refused("3D result", solid.contours, interval=1)
        refused("3D result", solid.profile, [[0, 0], [1, 1]])
