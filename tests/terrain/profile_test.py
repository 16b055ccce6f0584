"""tessera profile: where a line crosses the triangles of a result, against all triangles and exact fractions."""
import csv
import io
import json
import math
import os
import random
import unittest
from fractions import Fraction

from cli import BAD_INPUT, IO, USAGE, CliTest
from stored import Stored

TILINGS = (("1",), ("7",), ("64",), ("9", "--partition", "random"))


def side(a, b, p):
    return (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0])


class Surface:
    def __init__(self, out, max_edge=math.inf):
        stored = Stored(out)
        self.cells = []
        for cell in stored.cells:
            p = [stored.points[v] for v in cell]
            if max(math.dist(a[:2], b[:2]) for a, b in zip(p, p[1:] + p[:1])) <= max_edge:
                self.cells.append([tuple(map(Fraction, v)) for v in p])

    def profile(self, line):
        """Rows (distance, x, y, z, part), exact but for the distance."""
        rows, before, part, last = [], 0.0, 0, None
        for start, end in zip(line, line[1:]):
            a, b = tuple(map(Fraction, start)), tuple(map(Fraction, end))
            if a == b:
                continue
            places, joined = {}, set()  # by the part of the leg
            for cell in self.cells:
                mine = {}
                sides = [side(a, b, v) for v in cell]
                if all(s > 0 for s in sides) or all(s < 0 for s in sides):
                    continue
                for k in range(3):
                    u, v = cell[k], cell[(k + 1) % 3]
                    if sides[k] == 0:
                        axis = 0 if a[0] != b[0] else 1
                        mine[(u[axis] - a[axis]) / (b[axis] - a[axis])] = u
                    if sides[k] * sides[(k + 1) % 3] < 0:
                        t = sides[k] / (sides[k] - sides[(k + 1) % 3])
                        at = tuple(p + t * (q - p) for p, q in zip(u, v))
                        axis = 0 if a[0] != b[0] else 1
                        mine[(at[axis] - a[axis]) / (b[axis] - a[axis])] = at
                mine = {s: p for s, p in mine.items() if 0 <= s <= 1}
                for s, end_point in ((Fraction(0), a), (Fraction(1), b)):
                    areas = [side(cell[k], cell[(k + 1) % 3], end_point) for k in range(3)]
                    if min(areas) >= 0 and s not in mine:
                        z = sum(areas[k] * cell[(k + 2) % 3][2] for k in range(3)) / sum(areas)
                        mine[s] = (*end_point, z)
                places.update(mine)
                if len(mine) > 1:
                    joined.add((min(mine), max(mine)))
            order = sorted(places)
            length = math.dist(start, end)
            for i, s in enumerate(order):
                if i == 0 and s == 0 and last == 1:
                    continue
                if rows and (i == 0 or (order[i - 1], s) not in joined):
                    part += 1
                rows.append((before + float(s) * length, *map(float, places[s]), part))
            last = order[-1] if order else None
            before += length
        return rows


class Profile(CliTest):
    def cloud(self, kind):
        dice = random.Random(7)
        if kind == "lattice":
            rows = [(x, y, dice.randrange(9)) for x in range(14) for y in range(11)]
        elif kind == "holes":
            rows = [(x, y, dice.randrange(9)) for x in range(14) for y in range(11) if dice.random() < 0.8]
        elif kind == "far":
            rows = [(885000 + dice.randrange(1300) / 100, 6290000 + dice.randrange(1000) / 100, dice.random() * 50) for _ in range(300)]
        else:
            rows = [(dice.uniform(0, 13), dice.uniform(0, 10), dice.random()) for _ in range(300)]
        return self.write(kind + ".csv", "x,y,z\n" + "".join(f"{x!r},{y!r},{z!r}\n" for x, y, z in rows))

    def triangulate(self, cloud, *tiles):
        out = self.folder / ("out" + "-".join(tiles))
        self.ok("triangulate", cloud, "--dim", "2", "--tiles", *tiles, "-o", out, "--quiet", "--overwrite")
        return out

    def test_lines_are_crossed_exactly_for_every_tiling(self):
        lines = [[(1, 1), (9, 7)], [(0, 0), (10, 10)], [(2, 3), (11, 3), (11, 8), (2.5, 8.5)], [(-3, 5), (20, 5.5)],  # along edges, through vertices
                 [(-5, -1), (0, 20)], [(-1, 4), (5, -1), (14.5, 4), (7, 12)], [(3, 3), (3, 3), (4.25, 4.25)], [(6.5, 5.25), (6.5, 5)],
                 [(2, 2), (8, 8), (2, 2)], [(-1, 11), (14, -1), (0.5, 0.5)]]
        for kind, max_edge in (("lattice", None), ("holes", 1.5), ("uniform", None), ("uniform", 1.0), ("far", 1.0)):
            answers = []
            shift = (885000, 6290000) if kind == "far" else (0, 0)
            moved = [[(x + shift[0], y + shift[1]) for x, y in line] for line in lines]
            for tiles in TILINGS:
                out = self.triangulate(self.cloud(kind), *tiles)
                told = []
                for line in moved:
                    order = ["profile", out, "--digits", "all", "--line", " ".join(f"{x!r},{y!r}" for x, y in line), *(("--max-edge", str(max_edge)) if max_edge else ())]
                    done = self.run_tessera(*order)
                    told.append(done.stdout if done.returncode == 0 else "nothing")
                    self.assertIn(done.returncode, (0, USAGE), done.stderr)
                answers.append(told)
            surface, met = Surface(out, max_edge or math.inf), 0
            for line, *told in zip(moved, *answers):
                with self.subTest(kind=kind, max_edge=max_edge, line=line):
                    self.assertEqual(len(set(told)), 1)
                    right = surface.profile(line)
                    if told[0] == "nothing":
                        self.assertEqual(right, [])
                        continue
                    rows = list(csv.reader(io.StringIO(told[0])))
                    self.assertEqual(rows[0], ["distance", "x", "y", "z", "part"])
                    found = [tuple(map(float, row)) for row in rows[1:]]
                    self.assertEqual(len(found), len(right))
                    for a, b in zip(found, right):
                        self.assertEqual(a[4], b[4])
                        for u, v in zip(a, b):
                            self.assertLess(abs(u - v), 1e-9 * max(1, abs(v)))
                    met += 1
            self.assertGreater(met, 5)

    def test_numbers_are_rounded_to_what_data_carry(self):
        for kind, line, most in (("far", "885003,6290003 885033.3,6290029.7", 4), ("uniform", "-8,-5 8.7,5.1", 9)):
            out = self.triangulate(self.cloud(kind), "7")
            def rows(*options):
                return list(csv.reader(io.StringIO(self.ok("profile", out, "--line", line, *options))))[1:]
            exact = rows("--digits", "all")
            self.assertGreater(max(len(number) for row in exact for number in row), 15)
            highest = max(abs(float(row[3])) for row in exact)
            least = 4 if highest >= 1 else 4 - math.floor(math.log10(highest))
            for options, places, values in (((), most, least), (("--digits", "data"), most, least), (("--digits", "2"), 2, 2), (("--digits", "0"), 0, 0)):
                rounded = rows(*options)
                self.assertEqual(len(rounded), len(exact))
                for a, b in zip(rounded, exact):
                    self.assertEqual(a[4], b[4])
                    for column, decimals in enumerate((places, places, places, values)):
                        self.assertRegex(a[column], rf"^-?[0-9]+(\.[0-9]{{0,{max(decimals - 1, 0)}}}[1-9])?$" if decimals else "^-?[0-9]+$")
                        self.assertNotEqual(a[column], "-0")
                        self.assertLessEqual(abs(float(a[column]) - float(b[column])), 0.5000001 * 10.0 ** -decimals)
            for wrong in ("18", "-1", "x", "1.5", ""):
                self.refused(USAGE, "profile", out, "--line", line, "--digits", wrong, says="--digits")

    def test_ends_and_gaps_are_told(self):
        rows = [(x, y, x) for x in range(20) for y in range(5) if not 6 < x < 12]
        out = self.triangulate(self.write("gap.csv", "x,y,z\n" + "".join(f"{x},{y},{z}\n" for x, y, z in rows)), "3")
        order = ("profile", out, "--max-edge", "2", "--line", "-3,2.5 23.5,2.5")
        done = self.run_tessera(*order)
        self.assertEqual(done.stderr, "note: the surface begins 3 after the line's beginning, ends 4.5 before its end, has 1 gap of 6\n")
        self.assertEqual(self.run_tessera(*order, "--quiet").stderr, "")
        done = self.run_tessera(*order, "-o", "a.csv")
        self.assertRegex(done.stdout, "^a.csv: [0-9]+ points, in 2 parts\n$")
        self.assertIn("has 1 gap of 6", done.stderr)
        facts = json.loads(self.ok(*order, "-o", "a.csv", "--overwrite", "--json"))
        self.assertEqual([facts[key] for key in ("parts", "before", "after", "gaps", "between")], [2, 3, 4.5, 1, 6])
        inside = self.run_tessera("profile", out, "--line", "1,1 5,3", "-o", "b.csv")
        self.assertEqual((inside.returncode, inside.stderr), (0, ""))
        self.assertRegex(inside.stdout, "^b.csv: [0-9]+ points, in one part\n$")

    def test_a_line_of_a_file(self):
        out = self.triangulate(self.cloud("uniform"), "7")
        text = self.ok("profile", out, "--line", "1,1 9,7 3,8")
        self.write("a.geojson", json.dumps({"type": "Feature", "geometry": {"type": "LineString", "coordinates": [[1, 1], [9, 7, 5], [3, 8]]}}))
        self.ok("profile", out, "--line", "a.geojson", "-o", "a.csv")
        self.assertEqual((self.folder / "a.csv").read_text(), text)
        self.refused(USAGE, "profile", out, "--line", "a.geojson", "-o", "a.csv", says="--overwrite")
        self.write("b.geojson", json.dumps({"type": "MultiLineString", "coordinates": [[[1, 1], [9, 7]], [[1, 1], [3, 3]]]}))
        self.refused(BAD_INPUT, "profile", out, "--line", "b.geojson", says="2 lines")
        self.write("c.geojson", json.dumps({"type": "Polygon", "coordinates": [[[1, 1], [9, 7], [3, 3]]]}))
        self.refused(BAD_INPUT, "profile", out, "--line", "c.geojson", says="LineString")

    def test_a_line_of_another_system_is_refused(self):
        rows = "".join(f"{770500 + x},{6277500 + y},{x * y}\n" for x in range(9) for y in range(9))
        cloud = self.write("p.csv", "x,y,z\n" + rows)
        placed, bare = self.folder / "placed", self.folder / "bare"
        self.ok("triangulate", cloud, "--dim", "2", "--crs", "EPSG:2154", "-o", placed, "--quiet")
        self.ok("triangulate", cloud, "--dim", "2", "-o", bare, "--quiet")

        def line(name, coordinates):
            crs = {"crs": {"type": "name", "properties": {"name": name}}} if name else {}
            return self.write("a.geojson", json.dumps({"type": "LineString", "coordinates": coordinates, **crs}))
        here, degrees = [[770501, 6277501], [770507, 6277505]], [[3.87, 43.59], [3.88, 43.6]]
        crs84 = "urn:ogc:def:crs:OGC:1.3:CRS84"
        right = self.ok("profile", placed, "--line", "770501,6277501 770507,6277505")
        same = ("urn:ogc:def:crs:EPSG::2154", "EPSG:2154", "http://www.opengis.net/def/crs/EPSG/0/2154", "what nobody knows", None)
        for result, names in ((placed, same), (bare, (*same, crs84, "EPSG:2056"))):
            for name in names:
                self.assertEqual(self.ok("profile", result, "--line", line(name, here)), right)
        for name in ("EPSG:2056", crs84):
            self.refused(BAD_INPUT, "profile", placed, "--line", line(name, here),
                         says=["a.geojson: its coordinates are those of", "Lambert-93 (EPSG:2154)", "ogr2ogr -t_srs EPSG:2154"])
        self.refused(BAD_INPUT, "profile", placed, "--line", line(crs84, degrees), says=["those of WGS 84 (EPSG:4326)"])
        self.refused(BAD_INPUT, "profile", placed, "--line", line(None, degrees),
                     says=["a.geojson: its coordinates look like degrees", "x from 770500 to 770508", "-t_srs EPSG:2154"])
        for name in (None, crs84):
            self.refused(BAD_INPUT, "profile", bare, "--line", line(name, degrees), says=["look like degrees", "ogr2ogr -t_srs does"])

    def test_few_tiles_are_read(self):
        out = self.triangulate(self.cloud("uniform"), "64")
        text = self.ok("profile", out, "--line", "6,5 6.5,5.5")
        needless = 0
        for tile in sorted((out / "tiles").glob("*.vtu")):
            kept = tile.read_bytes()
            tile.write_bytes(b"nothing")
            done = self.run_tessera("profile", out, "--line", "6,5 6.5,5.5")
            if done.returncode == 0:
                self.assertEqual(done.stdout, text)
                needless += 1
            else:
                tile.write_bytes(kept)
        self.assertGreater(needless, 40)

    def test_wrong_orders_get_a_sentence(self):
        out = self.triangulate(self.cloud("uniform"), "2")
        space = self.folder / "space"
        self.ok("triangulate", self.cloud("uniform"), "--dim", "3", "-o", space, "--quiet")
        before = sorted(os.listdir(self.folder))
        for status, says, order in (
                (USAGE, "3D result", [space, "--line", "0,0 1,1"]), (USAGE, "--line", [out]), (USAGE, "fewer than two", [out, "--line", "0,0"]),
                (USAGE, "neither", [out, "--line", "0,0 1;1"]), (USAGE, "no cell", [out, "--line", "50,50 60,60"]),
                (USAGE, "no cell", [out, "--line", "5,5 5,5"]), (USAGE, "heat", [out, "--line", "0,0 1,1", "--value", "heat"]),
                (IO, "none.geojson", [out, "--line", "none.geojson"]), (IO, "manifest", [self.folder / "none", "--line", "0,0 1,1"])):
            with self.subTest(order=order):
                self.refused(status, "profile", *order, says=says)
        self.assertEqual(sorted(os.listdir(self.folder)), before)


if __name__ == "__main__":
    unittest.main()
