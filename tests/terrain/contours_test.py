"""tessera contours: every line against a brute-force extraction from all triangles, for any tiling."""
import collections
import json
import math
import os
import pathlib
import random
import sqlite3
import unittest
from fractions import Fraction

import numpy as np
from cli import CORRUPT, IO, USAGE, CliTest
from osgeo import gdal, ogr, osr
from scipy.spatial import cKDTree
from stored import Stored

gdal.UseExceptions()
TILINGS = (("1",), ("7",), ("64",), ("9", "--partition", "random"))


class Surface:
    """All triangles of a result, but those with long edges."""

    def __init__(self, out, max_edge=math.inf):
        stored = Stored(out)
        self.at = np.array([stored.points[i] for i in sorted(stored.points)])
        number = {i: n for n, i in enumerate(sorted(stored.points))}
        cells = np.array([[number[v] for v in cell] for cell in stored.cells])
        corners = self.at[cells][:, :, :2]
        longest = np.sqrt((np.diff(corners[:, [0, 1, 2, 0]], axis=1)**2).sum(axis=2)).max(axis=1)
        self.cells = cells[longest <= max_edge]
        beside = collections.defaultdict(list)
        for a, b, c in self.cells.tolist():
            for u, v, apex in ((a, b, c), (b, c, a), (c, a, b)):
                beside[min(u, v), max(u, v)].append(apex)
        self.beside = beside
        border = np.array([edge for edge, apices in beside.items() if len(apices) == 1])
        self.border = self.at[border[:, 0], :2], self.at[border[:, 1], :2]

    def segments(self, level):
        """The border of what is at or above the level and has an area, inside of the surface: an array n x 2 x 2."""
        z, found = self.at[:, 2], []
        heights = z[self.cells]
        for cell in self.cells[(heights.min(axis=1) < level) & (level < heights.max(axis=1))].tolist():
            ends = [self.at[v, :2] for v in cell if z[v] == level]
            for u, v in ((cell[0], cell[1]), (cell[1], cell[2]), (cell[2], cell[0])):
                if (z[u] - level) * (z[v] - level) < 0:
                    u, v = min(u, v), max(u, v)
                    ends.append(self.at[u, :2] + (level - z[u]) / (z[v] - z[u]) * (self.at[v, :2] - self.at[u, :2]))
            assert len(ends) == 2
            found.append(ends)
        for (u, v), apices in self.beside.items():
            if z[u] == level and z[v] == level and len(apices) == 2 and (z[apices[0]] < level) != (z[apices[1]] < level):
                found.append([self.at[u, :2], self.at[v, :2]])
        return np.array(found).reshape(-1, 2, 2)

    def is_border(self, p):
        """Whether a point is on an edge that has a cell on one side only."""
        a, b = self.border
        t = np.clip(((p - a) * (b - a)).sum(axis=1) / ((b - a)**2).sum(axis=1), 0, 1)[:, None]
        return np.abs(a + t * (b - a) - p).max(axis=1).min() < 1e-6


class Contours(CliTest):
    def cloud(self, kind):
        dice = random.Random(7)
        if kind == "lattice":  # flat grounds, ridges, hollows, peaks at the levels
            rows = [(x, y, dice.randrange(4)) for x in range(24) for y in range(20)]
        elif kind == "holes":
            rows = [(x, y, dice.randrange(4)) for x in range(24) for y in range(20) if dice.random() < 0.8]
        elif kind == "steps":
            rows = [(x, y, (x // 4 + y // 5) % 3) for x in range(24) for y in range(20)]
        elif kind == "ridges":
            rows = [(x + (y % 2) * 0.5, y, -abs(y % 6 - 3)) for x in range(15) for y in range(19)]
        elif kind == "far":
            rows = [(885000 + dice.randrange(4000) / 100, 6290000 + dice.randrange(4000) / 100, dice.random() * 5) for _ in range(700)]
        elif kind == "flat":
            rows = [(x, y, 2) for x in range(9) for y in range(9)]
        else:
            rows = [(dice.uniform(-9, 9), dice.uniform(-6, 6), dice.gauss(0, 2)) for _ in range(900)]
        return self.write(kind + ".csv", "x,y,z\n" + "".join(f"{x!r},{y!r},{z!r}\n" for x, y, z in rows))

    def triangulate(self, cloud, *tiles):
        out = self.folder / ("out" + "-".join(tiles))
        self.ok("triangulate", cloud, "--dim", "2", "--tiles", *tiles, "-o", out, "--quiet", "--overwrite")
        return out

    def lines(self, out, interval, *options, name="lines.geojson"):
        self.ok("contours", out, "--interval", str(interval), "-o", name, "--overwrite", "--quiet", *options)
        return (self.folder / name).read_bytes()

    def compare(self, text, surface, interval, base=0.0):
        """Lines are the segments of the brute force, each once; what is not closed ends at the border."""
        by_level, lines = collections.defaultdict(list), 0
        for feature in json.loads(text)["features"]:
            line = np.array(feature["geometry"]["coordinates"])
            self.assertEqual(set(line[:, 2]), {feature["properties"]["elevation"]})
            by_level[feature["properties"]["elevation"]].append(line[:, :2])
            lines += 1
        low, high = surface.at[surface.cells.ravel(), 2].min(), surface.at[surface.cells.ravel(), 2].max()
        levels = [float(Fraction(str(base)) + k * Fraction(str(interval))) for k in range(math.floor((low - base) / interval), math.ceil((high - base) / interval) + 1)]
        self.assertLessEqual(set(by_level), set(levels))
        near = 1e-14 * max(1.0, np.abs(surface.at[:, :2]).max())  # a rounding or two
        for level in levels:
            right = surface.segments(level)
            if len(right) == 0:
                self.assertEqual(by_level[level], [])
                continue
            # Numbers of points: those of the brute force that are one but for rounding have one.
            ends = right.reshape(-1, 2)
            tree = cKDTree(ends)
            first = np.array([min(tree.query_ball_point(p, near)) for p in ends])
            wanted = collections.Counter(frozenset(pair) for pair in first.reshape(-1, 2).tolist() if pair[0] != pair[1])
            self.assertEqual(set(wanted.values()), {1})
            found = collections.Counter()
            for line in by_level[level]:
                distance, number = tree.query(line)
                self.assertLess(distance.max(), near)
                number = first[number]
                found.update(frozenset(pair) for pair in zip(number.tolist(), number[1:].tolist()) if pair[0] != pair[1])
                if (line[0] != line[-1]).any():
                    self.assertTrue(surface.is_border(line[0]) and surface.is_border(line[-1]), line)
            self.assertEqual(found, wanted)
        return lines

    def test_lines_are_those_of_all_triangles_for_every_tiling(self):
        for kind, interval, base, max_edge in (("lattice", 1, 0, None), ("holes", 0.5, 0, 1.5), ("holes", 1, 0, 1.5), ("steps", 1, 0, None), ("ridges", 1, 0, None),
                                               ("ridges", 1.5, 0, None), ("far", 0.7, 0.1, None), ("uniform", 1, 0, None),
                                               ("uniform", 0.25, 0, 1.0), ("flat", 1, 0, None)):
            texts = []
            for tiles in TILINGS:
                out = self.triangulate(self.cloud(kind), *tiles)
                texts.append(self.lines(out, interval, "--base", str(base), "--threads", str(len(texts) + 1),
                                        *(("--max-edge", str(max_edge)) if max_edge else ())))
            with self.subTest(kind=kind, interval=interval, max_edge=max_edge):
                self.assertEqual(len(set(texts)), 1)
                lines = self.compare(texts[0], Surface(out, max_edge or math.inf), interval, base)
                self.assertEqual(lines == 0, kind == "flat")

    def test_lines_of_real_clouds(self):
        files = sorted(pathlib.Path(os.environ["IGN"]).glob("*.las"))
        self.ok("triangulate", *files, "--dim", "2", "--class", "2", "--tiles", "7", "-o", self.out, "--quiet")
        for interval, max_edge in ((0.25, None), (0.5, 2.0)):
            text = self.lines(self.out, interval, *(("--max-edge", str(max_edge)) if max_edge else ()))
            self.assertGreater(self.compare(text, Surface(self.out, max_edge or math.inf), interval), 3)

    def test_higher_ground_is_on_the_left(self):
        rows = "".join(f"{x},{y},{-(x * x + y * y)}\n{x + 50},{y},{x * x + y * y}\n" for x in range(-9, 10) for y in range(-9, 10))
        text = self.lines(self.triangulate(self.write("p.csv", "x,y,z\n" + rows), "7"), 7, "--base", "0.5")
        sides = set()
        for feature in json.loads(text)["features"]:
            x, y, _ = np.array(feature["geometry"]["coordinates"]).T
            if x[0] == x[-1] and y[0] == y[-1]:
                sides.add((bool(x.mean() > 25), bool((x[:-1] * y[1:] - x[1:] * y[:-1]).sum() > 0)))
        self.assertEqual(sides, {(False, True), (True, False)})  # around the peak counterclockwise

    def test_levels_are_decimals(self):
        rows = "".join(f"{x},{y},{(x + 1) / 10 if y == 4 else 0 if y < 4 else 9}\n" for x in range(9) for y in range(9))  # 0.3 is no 3 * 0.1
        self.assertNotEqual(3 * 0.1, 0.3)
        text = self.lines(self.triangulate(self.write("p.csv", "x,y,z\n" + rows), "2"), 0.1)
        found = {f["properties"]["elevation"]: f["geometry"]["coordinates"] for f in json.loads(text)["features"]}
        for x in range(9):
            self.assertIn([x, 4, (x + 1) / 10], found[(x + 1) / 10])

    def test_hardly_any_memory_gives_the_same_lines(self):
        out = self.triangulate(self.cloud("uniform"), "7")
        self.assertEqual(self.lines(out, 0.01), self.lines(out, 0.01, "--memory", "1M", name="few.geojson"))

    def test_a_box_has_whole_cells_and_needs_no_other_tiles(self):
        out = self.triangulate(self.cloud("uniform"), "64")
        box = (1.0, 1.0, 3.0, 3.0)
        whole = self.lines(out, 0.5)
        argument = ("--bbox", ",".join(map(str, box)))
        part = self.lines(out, 0.5, *argument)

        def segments(text, only=lambda pair: True):
            pairs = [(f["properties"]["elevation"], *sorted((tuple(a), tuple(b)))) for f in json.loads(text)["features"]
                     for a, b in zip(f["geometry"]["coordinates"], f["geometry"]["coordinates"][1:])]
            return {pair for pair in pairs if only(pair)}

        def inside(pair):
            return any(box[0] <= p[0] <= box[2] and box[1] <= p[1] <= box[3] for p in pair[1:])
        self.assertLess(segments(part), segments(whole))
        self.assertEqual(segments(part, inside), segments(whole, inside))
        needless = 0
        for tile in sorted((out / "tiles").glob("*.vtu")):  # what is not read may be anything
            kept = tile.read_bytes()
            tile.write_bytes(b"nothing")
            done = self.run_tessera("contours", out, "--interval", "0.5", "-o", "part.geojson", "--overwrite", *argument)
            if done.returncode == 0:
                self.assertEqual((self.folder / "part.geojson").read_bytes(), part)
                needless += 1
                continue
            self.assertEqual(done.returncode, CORRUPT, done.stderr)
            tile.write_bytes(kept)
        self.assertGreater(needless, 30)

    def test_a_box_outside_of_the_surface_is_refused(self):
        out = self.triangulate(self.write("p.csv", "x,y,z\n1,1,0\n9,1,1\n1,9.5,2\n3,2,5\n"), "2")
        before = sorted(os.listdir(self.folder))
        for box in ("100,100,103,103", "2,10,3,11", "8,8,8.5,8.5"):  # the last one only of the hull
            for name in ("a.gpkg", "a.geojson"):
                self.refused(USAGE, "contours", out, "--interval", "1", "--bbox", box, "-o", name,
                             says="--bbox: no cell meets it; the points of the result lie at x from 1 to 9, y from 1 to 9.5")
        self.assertEqual(sorted(os.listdir(self.folder)), before)

    def test_files_have_system_and_elevation(self):
        dice = random.Random(1)
        cloud = self.write("p.csv", "x,y,z,intensity\n" + "".join(
            f"{700000 + dice.uniform(0, 300)!r},{6600000 + dice.uniform(0, 200)!r},{dice.random() * 9!r},{dice.randrange(99)}\n" for _ in range(2000)))
        self.ok("triangulate", cloud, "--dim", "2", "--crs", "EPSG:2154", "--attributes", "intensity", "--tiles", "7", "-o", self.out, "--quiet")
        right = osr.SpatialReference()
        right.ImportFromEPSG(2154)
        counts = []
        for name in ("a.gpkg", "a.geojson"):
            said = json.loads(self.ok("contours", self.out, "--interval", "1", "-o", name, "--json").splitlines()[-1])
            file = ogr.Open(str(self.folder / name))
            layer = file.GetLayer(0)
            self.assertTrue(layer.GetSpatialRef().IsSame(right))
            self.assertEqual(layer.GetGeomType(), ogr.wkbLineString25D)
            lines = [(f.GetField("elevation"), f.GetGeometryRef().Clone()) for f in layer]
            self.assertEqual((said["lines"], said["vertices"], said["levels"]),
                             (len(lines), sum(g.GetPointCount() for _, g in lines), len({z for z, _ in lines})))
            self.assertTrue(all(g.GetPoint(0)[2] == z for z, g in lines))
            counts.append(said["lines"])
        self.assertEqual(len(set(counts)), 1)
        base = sqlite3.connect(self.folder / "a.gpkg")
        self.assertEqual(base.execute("select count(*) from rtree_contours_geom").fetchone()[0], counts[0])
        self.ok("contours", self.out, "--interval", "20", "--value", "intensity", "-o", "i.gpkg", "--quiet")
        file = ogr.Open(str(self.folder / "i.gpkg"))
        layer = file.GetLayer(0)
        self.assertEqual(layer.GetGeomType(), ogr.wkbLineString)
        self.assertEqual({f.GetField("intensity") for f in layer}, {20.0, 40.0, 60.0, 80.0})

    def test_wrong_orders_get_a_sentence_and_leave_nothing(self):
        out = self.triangulate(self.cloud("uniform"), "2")
        space = self.folder / "space"
        self.ok("triangulate", self.cloud("uniform"), "--dim", "3", "-o", space, "--quiet")
        (self.folder / "taken.gpkg").write_text("mine")
        before = sorted(os.listdir(self.folder))
        for status, says, order in (
                (USAGE, "3D result", [space, "--interval", "1", "-o", "a.gpkg"]), (USAGE, "--interval", [out, "-o", "a.gpkg"]),
                (USAGE, "--interval", [out, "--interval", "0", "-o", "a.gpkg"]), (USAGE, "--interval", [out, "--interval", "1e-13", "-o", "a.gpkg"]),
                (USAGE, "too small", [out, "--interval", "1e-8", "-o", "a.gpkg"]), (USAGE, "-o", [out, "--interval", "1"]),
                (USAGE, ".gpkg", [out, "--interval", "1", "-o", "a.shp"]), (USAGE, "--overwrite", [out, "--interval", "1", "-o", "taken.gpkg"]),
                (USAGE, "heat", [out, "--interval", "1", "--value", "heat", "-o", "a.gpkg"]),
                (USAGE, "--base", [out, "--interval", "1", "--base", "nan", "-o", "a.gpkg"]),
                (IO, "none", [out, "--interval", "1", "-o", "none/a.gpkg"]), (IO, "manifest", [self.folder / "none", "--interval", "1", "-o", "a.gpkg"])):
            with self.subTest(order=order):
                self.refused(status, "contours", *order, says=says)
        for tile in sorted((pathlib.Path(out) / "tiles").glob("*.vtu")):
            damaged = bytearray(tile.read_bytes())
            damaged[len(damaged) // 2] ^= 1
            tile.write_bytes(damaged)
        self.refused(CORRUPT, "contours", out, "--interval", "1", "-o", "a.gpkg", says=".vtu")
        self.assertEqual(sorted(os.listdir(self.folder)), before)


if __name__ == "__main__":
    unittest.main()
