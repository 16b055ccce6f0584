"""tessera region: the cells of a place, of files that are not triangulated."""
import json
import random
import sys
import unittest

import numpy as np

from cli import BAD_INPUT, IGN, IO, MEMORY, USAGE, CliTest

sys.path.insert(0, str(__import__("pathlib").Path(__file__).resolve().parents[1] / "store"))
from tile_arrays import read_tile  # noqa: E402

BLOCK = sorted(IGN.glob("*.las"))
BOX = (770540, 6277560, 770545, 6277565)


def text(box):
    return ",".join(map(str, box))


class RegionTest(CliTest):
    def cells(self, folder):
        """The cells of a result, as rows of sorted source indices, and where these are."""
        arrays = self.folder / (folder.name + "-arrays")
        self.ok("export", folder, "-o", arrays, "--format", "npy", "--no-z", "--quiet")
        return self.arrays(arrays)

    def arrays(self, folder):
        ids, points = np.load(folder / "ids.npy"), np.load(folder / "points.npy")
        cells = np.sort(ids[np.load(folder / "cells.npy")], axis=1)
        return {tuple(cell) for cell in cells.tolist()}, dict(zip(ids.tolist(), points.tolist()))

    def test_are_those_of_the_whole_with_their_indices(self):
        whole, part = self.folder / "whole", self.out
        self.ok("triangulate", *BLOCK, "--dim", "2", "-o", whole, "--quiet")
        done = json.loads(self.ok("region", *BLOCK, "--dim", "2", "--bbox", text(BOX), "-o", part, "--json"))
        self.assertTrue(done["complete"])
        self.assertLess(done["points_read"], done["points"])
        expected, at = self.cells(whole)
        found, _ = self.cells(part)
        self.assertEqual(len(found), done["cells"])
        self.assertEqual(found - expected, set())
        x0, y0, x1, y1 = BOX
        inside = {i for i, (x, y) in at.items() if x0 <= x <= x1 and y0 <= y <= y1}
        self.assertGreater(len(inside), 100)
        self.assertEqual({cell for cell in expected if inside & set(cell)} - found, set())
        for cell in found:  # no further than touching the box
            corners = np.array([at[i] for i in cell])
            self.assertTrue((corners.max(0) >= (x0, y0)).all() and (corners.min(0) <= (x1, y1)).all())

    def test_of_a_polygon_are_those_that_a_question_to_the_whole_finds(self):
        dice, (x0, y0) = random.Random(3), BOX[:2]
        polygons = [[[[x0, y0], [x0 + 9, y0 + 1], [x0 + 2, y0 + 7]]],
                    [[[x0 - 5, y0 - 5], [x0 + 9, y0 - 5], [x0 + 9, y0 + 9], [x0 - 5, y0 + 9]], [[x0, y0], [x0 + 4, y0], [x0 + 4, y0 + 4]]],
                    [[[x0 - 20, y0 - 20], [x0 + 20, y0 + 20], [x0 - 20, y0 - 19.99]]],  # thin, across its box
                    [[[x0 - 300, y0], [x0 - 290, y0], [x0 - 290, y0 + 200]]],  # over the hull
                    [[[x0 + dice.uniform(-9, 9), y0 + dice.uniform(-9, 9)] for _ in range(8)]]]  # crosses itself
        for dimension, few in (("2", polygons), ("3", polygons[:1])):
            whole = self.folder / ("whole" + dimension)
            self.ok("triangulate", *BLOCK, "--dim", dimension, "--class", "2", "-o", whole, "--quiet")
            for number, rings in enumerate(few):
                name = f"{dimension}-{number}"
                area = self.write(name + ".geojson", json.dumps({"type": "Polygon", "coordinates": rings}))
                args = ("--polygon", area, "-o", self.folder / name, "--format", "npy", "--overwrite")
                asked = self.run_tessera("query", whole, "cells", *args, "--quiet")
                with self.subTest(name=name):
                    if asked.returncode != 0:
                        self.assertEqual((asked.returncode, number), (USAGE, 3), asked.stderr)
                        self.refused(USAGE, "region", *BLOCK, "--dim", dimension, "--class", "2", *args, says=("--polygon", "no cell"))
                        continue
                    expected, at = self.arrays(self.folder / name)
                    done = json.loads(self.ok("region", *BLOCK, "--dim", dimension, "--class", "2", *args, "--json"))
                    found, also_at = self.arrays(self.folder / name)
                    self.assertTrue(done["complete"])
                    self.assertGreater(len(found), 10)
                    self.assertEqual((found, also_at), (expected, at))
        self.ok("region", *BLOCK, "--dim", "2", "--class", "2", "--polygon", self.folder / "2-0.geojson", "-o", self.out, "--quiet")
        region = json.loads(self.ok("info", self.out, "--json"))["region"]
        self.assertEqual((region["min"], region["complete"]), ([x0, y0, None], False))  # not all that meet the box
        arrays = read_tile(self.out / "tiles" / "000000.vtu")
        self.assertEqual(set(arrays["CellData/final"].tolist()), {1})
        self.refused(USAGE, "region", *BLOCK, "--polygon", "2-0.geojson", "--bbox", "0,0,1,1", "-o", "b", says="either --bbox or --polygon")
        self.refused(BAD_INPUT, "region", *BLOCK, "--polygon", self.write("line.geojson", '{"type":"LineString","coordinates":[[0,0],[1,1]]}'), "-o", "b", says="Polygon")

    def test_of_a_polygon_of_another_system_is_refused(self):
        x0, y0 = BOX[:2]
        whole = self.folder / "whole"
        self.ok("triangulate", BLOCK[0], "--dim", "2", "--class", "2", "-o", whole, "--quiet")
        before = self.files()
        for name, ring, says in (("EPSG:2056", [[x0, y0], [x0 + 9, y0 + 1], [x0 + 2, y0 + 7]], "EPSG:2056"),
                                 (None, [[3.8, 43.5], [3.9, 43.5], [3.9, 43.6]], "degrees")):
            crs = {"crs": {"type": "name", "properties": {"name": name}}} if name else {}
            area = self.write("area.geojson", json.dumps({"type": "Polygon", "coordinates": [ring], **crs}))
            self.refused(BAD_INPUT, "region", BLOCK[0], "--dim", "2", "--polygon", area, "-o", "b", says=["area.geojson: its coordinates", says, "ogr2ogr -t_srs EPSG:2154"])
            self.refused(BAD_INPUT, "query", whole, "cells", "--polygon", area, "-o", "b.ply", says=["area.geojson: its coordinates", says, "ogr2ogr -t_srs"])
            area.unlink()
        self.assertEqual(self.files(), before)

    def test_of_everything_is_the_whole(self):
        """With its indices, whatever is left out, and points that two files have."""
        more = self.write("more.xyz", b"770540 6277560 30\n770545 6277561 31\n")
        args = (*BLOCK, more, BLOCK[0], "--dim", "2")
        whole = self.folder / "whole"
        self.ok("triangulate", *args, "-o", whole, "--quiet")
        self.ok("region", *args, "--bbox", "0,0,1e9,1e9", "-o", self.out, "--quiet")
        whole, part = (json.loads(self.ok("info", folder, "--json")) for folder in (whole, self.out))
        self.assertEqual(part["digest"], whole["digest"])
        self.assertEqual(part["points"], whole["points"])

    def test_tells_that_it_is_a_region(self):
        self.ok("region", *BLOCK, "--dim", "2", "--bbox", text(BOX), "-o", self.out, "--quiet")
        info = json.loads(self.ok("info", self.out, "--json"))
        self.assertEqual(info["region"]["min"], [*BOX[:2], None])
        self.assertTrue(info["region"]["complete"])
        self.assertIn("all cells that meet it", self.ok("info", self.out))
        # What a region does not need was not read: nobody has counted what filters drop.
        self.assertEqual([info[key] for key in ("filtered", "invalid", "duplicates")], [None] * 3)
        self.assertNotIn("filtered out", self.ok("info", self.out))
        self.assertIn(f"{info['points']:,}".replace(",", " ") + " in the files, of which", self.ok("info", self.out))
        self.refused(USAGE, "verify", self.out, says="holds a region of a triangulation")

    def test_equal_regions_are_equal_files(self):
        for name in ("a", "b"):
            self.ok("region", *BLOCK, "--dim", "2", "--bbox", text(BOX), "-o", self.folder / name, "--quiet",
                    *["--scan-files"] * (name == "b"))
        tiles = [(self.folder / name / "tiles" / "000000.vtu").read_bytes() for name in ("a", "b")]
        self.assertEqual(*tiles)

    def test_as_a_file_of_another_program(self):
        target = self.folder / "part.ply"
        self.assertIn("part.ply: ", self.ok("region", *BLOCK, "--dim", "2", "--bbox", text(BOX), "-o", target))
        self.assertEqual(target.read_bytes()[:3], b"ply")
        self.refused(USAGE, "region", *BLOCK, "--dim", "2", "--bbox", text(BOX), "-o", target, says="exists already")

    def test_beyond_its_limits(self):
        args = ("region", *BLOCK, "--bbox", text(BOX), "--dim", "2", "-o", self.out)
        self.refused(MEMORY, *args, "--max-points", "1000", says=["--max-points", "more units are needed", "ign_77050", ".las, in (770499.98, 6277"])
        self.assertFalse(self.out.exists())
        self.refused(MEMORY, *args, "--max-points", "1000", "--partial", says="--max-points")

    def test_what_is_known_beyond_its_limits(self):
        box = (770500, 6277500, 770599, 6277501)  # along the lower border: what is above is needed at the corners
        done = json.loads(self.ok("region", *BLOCK, "--bbox", text(box), "--dim", "2", "-o", self.out, "--json",
                                  "--max-points", "80k", "--partial"))
        self.assertFalse(done["complete"])
        self.assertGreater(done["final"], 0)
        self.assertLess(done["final"], done["cells"])
        final = read_tile(self.out / "tiles" / "000000.vtu")["CellData/final"]
        self.assertEqual((final.size, final.sum()), (done["cells"], done["final"]))
        self.ok("export", self.out, "-o", self.folder / "p", "--format", "npy", "--quiet")
        np.testing.assert_array_equal(np.load(self.folder / "p" / "final.npy"), final)
        self.ok("export", self.out, "-o", self.folder / "p.vtu", "--quiet")
        self.assertIn(b'Name="final"', (self.folder / "p.vtu").read_bytes()[:4000])
        self.refused(USAGE, "export", self.out, "-o", self.folder / "p.ply", says="cannot mark which are")

    def test_wrong_questions(self):
        cloud = self.xyz(columns=2)
        self.refused(USAGE, "region", cloud, "-o", self.out, says="--bbox")
        self.refused(USAGE, "region", "--bbox", "0,0,1,1", "-o", self.out, says="no input file")
        self.refused(USAGE, "region", cloud, "--bbox", "0,0,1,1", says="-o")
        self.refused(USAGE, "region", cloud, "--bbox", "0,0,0,1,1,1", "-o", self.out, says="--bbox")
        self.refused(USAGE, "region", cloud, "--bbox", "1,1,0,0", "-o", self.out, says="--bbox")
        self.refused(USAGE, "region", cloud, "--bbox", "8,8,9,9", "-o", self.out, says="no cell")
        self.assertFalse(self.out.exists())
        self.refused(IO, "region", self.folder / "none.las", "--bbox", "0,0,1,1", "-o", self.out, says="none.las")
        line = self.write("line.xyz", "".join(f"{i} {i}\n" for i in range(9)))
        self.refused(BAD_INPUT, "region", line, "--bbox", "1,1,2,2", "-o", self.out, says="all files")
        self.ok("region", cloud, "--bbox", ".4,.4,.6,.6", "-o", self.out, "--quiet")
        self.refused(USAGE, "region", cloud, "--bbox", ".4,.4,.6,.6", "-o", self.out, says="--overwrite")
        self.ok("region", cloud, "--bbox", ".4,.4,.5,.5", "-o", self.out, "--quiet", "--overwrite")


if __name__ == "__main__":
    unittest.main()
