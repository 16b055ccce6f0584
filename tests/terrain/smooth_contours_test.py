"""tessera contours --smooth, --min-length, index lines: against means of samples that NumPy takes of a raster."""
import json
import math
import random
import sqlite3
import unittest

import numpy as np
from cli import USAGE, CliTest
from osgeo import gdal, ogr

gdal.UseExceptions()
ogr.UseExceptions()
TILINGS = (("1",), ("7",), ("9", "--partition", "random"))
WEIGHTS = np.array([1, 3, 5, 7, 7, 5, 3, 1], dtype=float)


class SmoothContours(CliTest):
    def hills(self, name="hills.csv", step=0.0):
        """Bumps of some metres, noise, a hole, and with `step` heights in whole steps: flats, and cliffs at levels."""
        dice = random.Random(3)
        rows = []
        for _ in range(6000):
            x, y = dice.uniform(0, 60), dice.uniform(0, 40)
            if math.hypot(x - 20, y - 12) < 4:
                continue
            z = 3 * math.sin(x / 9) + 2 * math.cos(y / 7) + dice.gauss(0, 0.05)
            rows.append((1000 + x, -20 + y, round(z / step) * step if step else z))
        return self.write(name, "x,y,z\n" + "".join(f"{x!r},{y!r},{z!r}\n" for x, y, z in rows))

    def triangulate(self, cloud, *tiles):
        out = self.folder / ("out" + "-".join(tiles))
        self.ok("triangulate", cloud, "--dim", "2", "--tiles", *tiles, "-o", out, "--quiet", "--overwrite")
        return out

    def lines(self, out, *options, name="lines.geojson"):
        self.ok("contours", out, "-o", name, "--overwrite", "--quiet", *map(str, options))
        return (self.folder / name).read_bytes()

    def nodes(self, out, size, max_edge):
        """The smooth surface by NumPy: values of nodes by (column, row), from a raster of the samples."""
        self.ok("dem", out, "--res", repr(size / 4), "--type", "float64", "--max-edge", str(max_edge), "-o", "samples.tif", "--overwrite", "--quiet")
        raster = gdal.Open(str(self.folder / "samples.tif"))
        left, _, _, top, _, _ = raster.GetGeoTransform()
        z = np.full((raster.RasterYSize + 32, raster.RasterXSize + 32), np.nan)
        z[16:-16, 16:-16] = raster.ReadAsArray()[::-1]
        column0, row0 = round(left / (size / 4)) - 16, round(top / (size / 4)) - raster.RasterYSize - 16
        values, weight = {}, np.outer(WEIGHTS, WEIGHTS)
        for j in range(math.ceil((row0 + 4) / 4), (row0 + z.shape[0] - 4) // 4 + 1):
            for i in range(math.ceil((column0 + 4) / 4), (column0 + z.shape[1] - 4) // 4 + 1):
                window = z[4 * j - 4 - row0:4 * j + 4 - row0, 4 * i - 4 - column0:4 * i + 4 - column0]
                both = np.isfinite(window) & np.isfinite(window[::-1, ::-1])
                if 2 * weight[both].sum() >= weight.sum():
                    values[i, j] = (weight[both] * window[both]).sum() / weight[both].sum()
        return values

    def compare(self, text, values, size, interval):
        """Each line goes from side to side of squares that have four nodes, through heights of its level; each side that
        a level passes has one line there."""
        squares = {(i, j) for i, j in values if {(i + 1, j), (i, j + 1), (i + 1, j + 1)} <= values.keys()}
        sides = {}  # of squares, and how many they have
        for i, j in squares:
            for side in ((i, j, 1, 0), (i, j, 0, 1), (i, j + 1, 1, 0), (i + 1, j, 0, 1)):
                sides[side] = sides.get(side, 0) + 1
        passed = set()
        for feature in json.loads(text)["features"]:
            level, line = feature["properties"]["elevation"], np.array(feature["geometry"]["coordinates"])
            self.assertEqual(set(line[:, 2]), {level})
            closed = (line[0] == line[-1]).all()
            for at, (x, y) in enumerate((line[1:] if closed else line)[:, :2] / size):
                across, up = abs(x - round(x)) > 1e-9, abs(y - round(y)) > 1e-9
                self.assertNotEqual(across, up)
                side = (math.floor(x + (0 if across else 0.5)), math.floor(y + (0 if up else 0.5)), int(across), int(up))
                i, j, right, high = side
                a, b = values[i, j], values[i + right, j + high]
                self.assertTrue(min(a, b) <= level + 1e-5 and level - 1e-5 <= max(a, b), (a, b, level))
                part = (x - i) if across else (y - j)
                self.assertLess(abs(part - np.clip((level - a) / (b - a), 1 / 1024, 1023 / 1024)) * abs(b - a), 1e-5)
                self.assertNotIn((side, level), passed)
                passed.add((side, level))
                if not closed and at in (0, len(line) - 1):
                    self.assertEqual(sides[side], 1)  # where the surface ends
        for i, j, right, high in sides:
            a, b = sorted((values[i, j], values[i + right, j + high]))
            for k in range(math.ceil(a / interval + 1e-5), math.ceil(b / interval - 1e-5)):
                self.assertIn(((i, j, right, high), float(k * interval)), passed)
        return len(passed)

    def test_lines_are_those_of_local_means_for_every_tiling(self):
        cloud = self.hills()
        for size, interval in ((1.5, 0.5), (0.375, 1)):
            texts = []
            for tiles in TILINGS:
                out = self.triangulate(cloud, *tiles)
                texts.append(self.lines(out, "--interval", interval, "--smooth", size, "--max-edge", 3, "--threads", len(texts) + 1,
                                        *(("--memory", "20M") if len(texts) == 1 else ())))
            self.assertEqual(len(set(texts)), 1)
            self.assertGreater(self.compare(texts[0], self.nodes(out, size, 3), size, interval), 500)

    def test_lines_touch_nothing(self):
        """Neither themselves nor each other, also where the ground is flat at levels and steep between them."""
        for cloud in (self.hills(), self.hills("steps.csv", 0.5)):
            out = self.triangulate(cloud, "7")
            shapes = []
            for feature in json.loads(self.lines(out, "--interval", "0.25", "--smooth", "0.7"))["features"]:
                shape = ogr.CreateGeometryFromJson(json.dumps(feature["geometry"]))
                shape.FlattenTo2D()
                self.assertTrue(shape.IsSimple())
                shapes.append((shape, feature["properties"]["elevation"]))
            self.assertGreater(len(shapes), 20)
            for i, (shape, level) in enumerate(shapes):
                for other, _ in shapes[:i]:
                    self.assertFalse(shape.Intersects(other), level)

    def test_higher_ground_is_on_the_left(self):
        out = self.triangulate(self.write("cone.csv", "x,y,z\n" + "".join(
            f"{x},{y},{-math.hypot(x - 15.2, y - 15.1)!r}\n" for x in range(31) for y in range(31))), "7")
        lines = json.loads(self.lines(out, "--interval", "2", "--smooth", "1"))["features"]
        closed = [np.array(each["geometry"]["coordinates"]) for each in lines if each["geometry"]["coordinates"][0] == each["geometry"]["coordinates"][-1]]
        self.assertGreaterEqual(len(closed), 5)
        for line in closed:  # counterclockwise
            self.assertGreater((line[:-1, 0] * line[1:, 1] - line[1:, 0] * line[:-1, 1]).sum(), 0)

    def test_flat_ground_at_a_level_has_a_line_where_it_falls_and_no_crumbs(self):
        rows = [(x * 0.31, y * 0.31, 10.1 if math.hypot(x - 50, y - 40) < 25 else 9.4) for x in range(100) for y in range(80)]
        out = self.triangulate(self.write("plate.csv", "x,y,z\n" + "".join(f"{x!r},{y!r},{z!r}\n" for x, y, z in rows)), "7")
        self.assertEqual(len(json.loads(self.lines(out, "--interval", "0.1", "--base", "10", "--smooth", "1"))["features"]), 7)

    def test_a_box_has_the_lines_of_the_whole(self):
        out = self.triangulate(self.hills(), "20")
        whole = json.loads(self.lines(out, "--interval", "0.5", "--smooth", "1"))["features"]
        part = json.loads(self.lines(out, "--interval", "0.5", "--smooth", "1", "--bbox", "1010.3,-10,1030.6,5"))["features"]
        segments = [{(each["properties"]["elevation"], *a, *b) for each in lines
                     for a, b in zip(map(tuple, each["geometry"]["coordinates"]), map(tuple, each["geometry"]["coordinates"][1:]))}
                    for lines in (whole, part)]
        self.assertLess(segments[1], segments[0])
        inside = {s for s in segments[0] if 1010.3 < s[1] < 1030.6 and -10 < s[2] < 5}
        self.assertGreater(len(inside), 100)
        self.assertLessEqual(inside, segments[1])

    def test_shorter_lines_are_left_out_and_counted(self):
        out = self.triangulate(self.hills(), "7")
        for smooth in ((), ("--smooth", "1")):
            def lengths(text):
                return [np.hypot(*np.diff(np.array(each["geometry"]["coordinates"])[:, :2], axis=0).T).sum() for each in json.loads(text)["features"]]
            all_lines = lengths(self.lines(out, "--interval", "0.5", *smooth))
            kept = lengths(self.lines(out, "--interval", "0.5", "--min-length", "9", *smooth))
            self.assertEqual(kept, [length for length in all_lines if length >= 9])
            self.assertGreater(len(all_lines), len(kept))
            told = self.ok("contours", out, "--interval", "0.5", "--min-length", "9", "-o", "a.gpkg", "--overwrite", *smooth)
            self.assertIn(f"\n{len(all_lines) - len(kept)} shorter line", told)
            facts = json.loads(self.ok("contours", out, "--interval", "0.5", "--min-length", "9", "-o", "a.gpkg", "--overwrite", "--json", *smooth).splitlines()[-1])
            self.assertEqual((facts["lines"], facts["shorter"]), (len(kept), len(all_lines) - len(kept)))

    def test_index_lines_are_those_of_each_fifth_level(self):
        out = self.triangulate(self.hills(), "7")
        for options, base, every in (((), 0, 5), (("--base", "0.3"), 0.3, 5), (("--index-every", "4"), 0, 4), (("--index-every", "1"), 0, 1)):
            for feature in json.loads(self.lines(out, "--interval", "0.2", *options))["features"]:
                number = round((feature["properties"]["elevation"] - base) / 0.2)
                self.assertIs(feature["properties"]["index"], number % every == 0)
        self.lines(out, "--interval", "0.2", "--smooth", "1", name="a.gpkg")
        rows = sqlite3.connect(self.folder / "a.gpkg").execute('SELECT elevation, "index" FROM contours').fetchall()
        self.assertEqual({index for _, index in rows}, {0, 1})
        for elevation, index in rows:
            self.assertEqual(index, int(round(elevation / 0.2) % 5 == 0))
        source = ogr.Open(str(self.folder / "a.gpkg"))
        field = source.GetLayer().GetLayerDefn().GetFieldDefn(1)
        self.assertEqual((field.GetName(), field.GetSubType()), ("index", ogr.OFSTBoolean))

    def test_what_makes_no_sense_is_refused(self):
        out = self.triangulate(self.hills(), "1")
        for options, words in ((("--smooth", "0"), ("--smooth", "distance")), (("--smooth", "-1"), ("--smooth", "distance")),
                               (("--smooth", "1e-9"), ("--smooth", "too")), (("--smooth", "nan"), ("--smooth",)),
                               (("--min-length", "0"), ("--min-length",)), (("--index-every", "0"), ("--index-every",)),
                               (("--smooth", "1", "--interval", "1e-12"), ("--interval: is too small",))):
            self.refused(USAGE, "contours", out, *(("--interval", "1") if "--interval" not in options else ()), *options, "-o", "no.gpkg", says=words)
            self.assertFalse((self.folder / "no.gpkg").exists())


if __name__ == "__main__":
    unittest.main()
