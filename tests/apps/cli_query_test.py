"""tessera query: what a user asks, and what is said to wrong questions."""
import json
import math
import pathlib
import unittest

import numpy

from cli import CORRUPT, IO, USAGE, BAD_INPUT, CliTest


class Query(CliTest):
    def ground(self):
        """A 2D result with heights z = x + 2 y, of which the points are the ids' lattice: id = 10 x + y."""
        self.write("ground.csv", "x,y,z,intensity\n" + "".join(f"{x},{y},{x + 2 * y},{x * y}\n" for x in range(10) for y in range(10)))
        self.ok("triangulate", "ground.csv", "--dim", "2", "-o", self.out, "--tiles", "3", "--attributes", "all", "--quiet")

    def test_a_point_has_a_cell_with_vertices_and_neighbors(self):
        self.ground()
        answer = json.loads(self.ok("query", self.out, "locate", "4.25,5.5", "--json"))
        ids = {vertex["id"] for vertex in answer["vertices"]}
        self.assertTrue(ids < {45, 46, 55, 56}, ids)
        for vertex in answer["vertices"]:
            self.assertEqual(vertex["point"], [vertex["id"] // 10, vertex["id"] % 10])
        self.assertEqual(len(answer["neighbors"]), 3)
        text = self.ok("query", self.out, "locate", "4.25,5.5")
        self.assertTrue(text.startswith(f"cell {answer['cell']} of tile {answer['tile']}\n"), text)
        self.assertIn("outside the hull", self.ok("query", self.out, "locate", "-1,5"))
        self.assertIsNone(json.loads(self.ok("query", self.out, "locate", "-1,5", "--json"))["cell"])

    def test_many_points_in_every_format(self):
        self.ground()
        self.write("where.xyz", "4.25 5.5\n20 3\n0 0\n")
        table = self.ok("query", self.out, "locate", "--points", "where.xyz").splitlines()
        self.assertEqual(table[0], "x,y,tile,cell,v0,v1,v2")
        self.assertEqual(table[2], "20,3,,,,,")
        lines = self.json_lines(self.ok("query", self.out, "locate", "--points", "where.xyz", "--json"))
        self.assertEqual(table[1], ",".join(map(str, lines[0]["point"] + [lines[0]["tile"], lines[0]["cell"]] + lines[0]["vertices"])))
        self.assertIsNone(lines[1]["cell"])
        self.ok("query", self.out, "locate", "--points", "where.xyz", "-o", "where.npy")
        array = numpy.load(self.folder / "where.npy")
        self.assertEqual(array.shape, (3, 5))
        self.assertEqual(list(array[0]), [lines[0]["tile"], lines[0]["cell"]] + lines[0]["vertices"])
        self.assertEqual(list(array[1]), [-1] * 5)
        self.refused(USAGE, "query", self.out, "locate", "--points", "where.xyz", "-o", "where.npy", says="--overwrite")
        self.ok("query", self.out, "locate", "--points", "where.xyz", "-o", "where.csv")
        self.assertEqual((self.folder / "where.csv").read_text().splitlines(), table)

    def test_columns_of_a_file_with_points_have_the_names_that_are_given(self):
        self.ground()
        self.write("plain.csv", "4.25,5.5\n2,7.5\n")
        self.write("survey.csv", "P1,5.5,4.25,EP\nP2,7.5,2,GND\n")
        self.assertEqual(self.ok("query", self.out, "locate", "--points", "survey.csv", "--columns", "_,y,x"),
                         self.ok("query", self.out, "locate", "--points", "plain.csv"))
        self.assertEqual(self.ok("query", self.out, "interpolate", "survey.csv", "--value", "z", "--columns", "_,y,x"),
                         self.ok("query", self.out, "interpolate", "plain.csv", "--value", "z"))
        self.refused(USAGE, "query", self.out, "star", "1", "--columns", "x,y", says="--columns describes a file with points")
        self.refused(USAGE, "query", self.out, "locate", "1,2", "--columns", "x,y", says="--columns describes a file with points")
        self.refused(USAGE, "query", self.out, "locate", "--points", "plain.csv", "--columns", "x,z", says="--columns: no column is called y")
        self.write("counts.csv", "1,600,500,7\n2,601,500,8\n3,602,501,8\n")
        self.assertIn("warning: counts.csv has no header", self.run_tessera("query", self.out, "locate", "--points", "counts.csv").stderr)

    def test_a_star_has_cells_neighbors_and_an_area(self):
        self.ground()
        inside = json.loads(self.ok("query", self.out, "star", "44", "--json"))
        self.assertEqual(inside["voronoi_volume"], 1)
        self.assertTrue({34, 54, 43, 45} <= {vertex["id"] for vertex in inside["neighbors"]})
        self.assertTrue(all(44 in cell["vertices"] for cell in inside["cells"]))
        self.assertEqual(self.ok("query", self.out, "star", "44", "--tile", inside["vertex"]["tile"]),
                         self.ok("query", self.out, "star", "44"))
        corner = json.loads(self.ok("query", self.out, "star", "0", "--json"))
        self.assertIsNone(corner["voronoi_volume"])
        self.assertTrue(corner["on_hull"])
        self.assertIn("unbounded", self.ok("query", self.out, "star", "0"))

    def test_neighbours_are_those_of_the_star(self):
        self.ground()
        star = json.loads(self.ok("query", self.out, "star", "44", "--json"))
        ids = [vertex["id"] for vertex in star["neighbors"]]
        told = json.loads(self.ok("query", self.out, "neighbours", "44", "--json"))
        self.assertEqual(told, {"asked": 44, "vertex": 44, "on_hull": False, "neighbors": ids})
        self.assertEqual(self.ok("query", self.out, "neighbours", "44", "--tile", star["vertex"]["tile"]),
                         f"vertex 44 has {len(ids)} neighbours: {' '.join(map(str, ids))}\n")
        self.assertIn("vertex 0, on the hull, has ", self.ok("query", self.out, "neighbours", "0"))

    def test_one_answer_has_the_format_that_is_asked_for_or_is_refused(self):
        self.ground()
        for question, about in (("star", "44"), ("neighbours", "44"), ("locate", "4.25,5.5")):
            as_json = self.ok("query", self.out, question, about, "--json")
            self.assertEqual(self.ok("query", self.out, question, about, "--format", "json"), as_json)
            for other in ("csv", "npy", "nonsense"):
                self.refused(USAGE, "query", self.out, question, about, "--format", other, says=f"--format {other}")

    def test_cells_of_a_box_and_a_polygon_in_every_format(self):
        self.ground()
        self.ok("query", self.out, "cells", "--bbox", "2.1,2.1,3.9,3.9", "-o", "part.geojson")
        features = json.loads((self.folder / "part.geojson").read_text())["features"]
        self.assertEqual(len(features), 8)
        for feature in features:
            for x, y, z in feature["geometry"]["coordinates"][0]:
                self.assertEqual(z, x + 2 * y)
                self.assertTrue(2 <= x <= 4 and 2 <= y <= 4)
        self.write("area.geojson", json.dumps({"type": "Polygon", "coordinates": [[[2.1, 2.1], [3.9, 2.1], [3.9, 3.9], [2.1, 3.9], [2.1, 2.1]]]}))
        for name in ("part.vtu", "part.ply", "part.off", "part.msh", "part.csv"):
            self.assertIn("8 cells", self.ok("query", self.out, "cells", "--polygon", "area.geojson", "-o", name))
            self.assertTrue((self.folder / name).exists())
        self.ok("query", self.out, "cells", "--polygon", "area.geojson", "-o", "part", "--format", "npy")
        cells = numpy.load(self.folder / "part" / "cells.npy")
        points = numpy.load(self.folder / "part" / "points.npy")
        ids = numpy.load(self.folder / "part" / "ids.npy")
        neighbors = numpy.load(self.folder / "part" / "neighbors.npy")
        self.assertEqual((cells.shape, points.shape), ((8, 3), (9, 2)))
        self.assertTrue((ids == 10 * points[:, 0] + points[:, 1]).all())
        self.assertEqual((neighbors == -1).sum(), 8, "the rim of the part")
        self.refused(USAGE, "query", self.out, "cells", "--bbox", "50,50,60,60", "-o", "none.vtu", says="no cell")
        self.assertFalse((self.folder / "none.vtu").exists())

    def test_heights_and_attributes_between_the_vertices(self):
        self.ground()
        self.write("points.csv", "x,y\n4.25,5.5\n7.125,0.5\n8,9\n11,1\n")
        for method in ("linear", "natural"):
            table = self.ok("query", self.out, "interpolate", "points.csv", "--value", "z", "--method", method).splitlines()
            self.assertEqual(table[0], "x,y,value")
            values = [line.split(",")[2] for line in table[1:]]
            for value, right in zip(values, (15.25, 8.125, 26)):
                self.assertAlmostEqual(float(value), right, places=12)
            self.assertEqual(values[3], "")
        line = self.json_lines(self.ok("query", self.out, "interpolate", "points.csv", "--value", "intensity", "--method",
                                       "natural", "--weights", "--json"))[0]
        self.assertAlmostEqual(sum(line["weights"]), 1, places=12)
        self.assertAlmostEqual(sum(w * (v // 10) * (v % 10) for v, w in zip(line["vertices"], line["weights"])), line["value"], places=9)
        self.ok("query", self.out, "interpolate", "points.csv", "--value", "z", "-o", "values.npy")
        array = numpy.load(self.folder / "values.npy")
        self.assertEqual(array.shape, (4,))
        self.assertTrue(math.isnan(array[3]))

    def test_a_partition_without_order_and_hardly_any_memory_change_no_answer(self):
        cloud = self.xyz(n=3000)
        where = self.xyz("where.xyz", n=2000, seed=2)
        answers = set()
        for partition, tiles, memory in (("kdtree", 1, "1G"), ("random", 5, "1"), ("octree", 9, "1G")):
            out = self.folder / partition
            self.ok("triangulate", cloud, "-o", out, "--partition", partition, "--tiles", tiles, "--quiet")
            lines = self.json_lines(self.ok("query", out, "locate", "--points", where, "--memory", memory, "--json"))
            answers.add(tuple(tuple(sorted(line.get("vertices", ()))) for line in lines))
        self.assertEqual(len(answers), 1)

    def test_wrong_questions_get_a_sentence(self):
        self.ground()
        out = self.out
        for says, question in [("is not a question", ["height", "1,1"]), ("is not a point", ["locate", "a,b"]),
                               ("has 1 coordinates", ["locate", "4"]), ("one point", ["locate"]),
                               ("source index", ["star", "x"]), ("has no vertex 100", ["star", "100"]), ("has no vertex 100", ["neighbours", "100"]),
                               ("belongs to 'star' and 'neighbours'", ["locate", "1,1", "--tile", "0"]),
                               ("the questions are locate, star, neighbours, cells and interpolate", ["where", "1"]),
                               ("--bbox or --polygon", ["cells", "-o", "a.vtu"]), ("add -o", ["cells", "--bbox", "0,0,1,1"]),
                               ("--bbox", ["cells", "--bbox", "0,0,1", "-o", "a.vtu"]),
                               ("intensity, z", ["interpolate", "ground.csv", "--value", "heat"]),
                               ("--value", ["interpolate", "ground.csv"]),
                               ("--method", ["interpolate", "ground.csv", "--value", "z", "--method", "cubic"]),
                               ("belongs to 'cells'", ["locate", "1,1", "--bbox", "0,0,1,1"]),
                               ("npy", ["locate", "--points", "ground.csv", "--format", "xls"]),
                               ("holds only values", ["interpolate", "ground.csv", "--value", "z", "--weights", "-o", "a.npy"])]:
            with self.subTest(question=question):
                self.refused(USAGE, "query", out, *question, says=says)
        self.refused(IO, "query", self.folder / "none", "locate", "1,1")
        self.refused(IO, "query", out, "locate", "--points", "none.csv", says="none.csv")
        self.write("bad.csv", "1,2\n3,x\n")
        self.refused(BAD_INPUT, "query", out, "locate", "--points", "bad.csv", "-o", "a.csv", says=("bad.csv", "line 2"))
        self.assertFalse((self.folder / "a.csv").exists())
        self.write("bad.geojson", "[]")
        self.refused(BAD_INPUT, "query", out, "cells", "--polygon", "bad.geojson", "-o", "a.vtu", says="bad.geojson")

    def test_a_damaged_tile_is_named(self):
        self.ground()
        for tile in sorted((pathlib.Path(self.out) / "tiles").glob("*.vtu")):
            whole = bytearray(tile.read_bytes())
            whole[len(whole) // 2] ^= 1
            tile.write_bytes(whole)
        self.refused(CORRUPT, "query", self.out, "locate", "4.25,5.5", says=(".vtu", "damaged"))
        self.refused(CORRUPT, "query", self.out, "cells", "--bbox", "0,0,9,9", "-o", "a.vtu", says=".vtu")


if __name__ == "__main__":
    unittest.main()
