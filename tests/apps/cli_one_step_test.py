"""What commands make of a result, they make of point files in one step."""
import unittest

from cli import IGN, IO, USAGE, CliTest


class OneStep(CliTest):
    def setUp(self):
        super().setUp()
        self.files_of_points = sorted(str(p) for p in IGN.glob("*.las"))

    def same(self, name, *args, ending=""):
        """In two steps and in one; but for what is asked for, nothing is left."""
        self.ok(name, "ground", "-o", f"two{ending}", "--quiet", *args)
        before = set(self.folder.iterdir())
        self.ok(name, *self.files_of_points, "-o", f"one{ending}", "--quiet", *args)
        self.assertEqual({p.name for p in set(self.folder.iterdir()) - before}, {f"one{ending}"})
        one, two = self.folder / f"one{ending}", self.folder / f"two{ending}"
        if one.is_dir():
            self.assertEqual({str(p.relative_to(one)): p.is_dir() or p.read_bytes() for p in one.rglob("*")},
                             {str(p.relative_to(two)): p.is_dir() or p.read_bytes() for p in two.rglob("*")})
        else:
            self.assertEqual(one.read_bytes(), two.read_bytes())

    def test_products_are_those_of_a_result(self):
        self.ok("triangulate", *self.files_of_points, "-o", "ground", "--dim", "2", "--store", "cells", "--quiet")
        self.same("dem", "--res", "1", ending=".tif")
        self.same("contours", "--interval", "5", ending=".geojson")
        self.same("tileset")
        bounds = self.json_lines(self.ok("info", "ground", "--json"))[0]["bounds"]
        line = " ".join(f"{bounds[end][0]},{bounds[end][1]}" for end in ("min", "max"))
        self.same("profile", "--line", line, ending=".csv")
        self.ok("export", "ground", "-o", "two.ply", "--quiet")
        self.ok("export", *self.files_of_points, "--dim", "2", "-o", "one.ply", "--quiet")
        self.assertEqual((self.folder / "one.ply").read_bytes(), (self.folder / "two.ply").read_bytes())

    def test_the_result_can_be_kept_and_points_chosen(self):
        done = self.ok("dem", f"{IGN}/*.las", "--res", "2", "-o", "dem.tif", "--keep-result", "kept", "--class", "2,9", "--keep", "lowest")
        self.assertIn("dem.tif", done)
        told = self.json_lines(self.ok("info", "kept", "--json"))[0]
        self.assertEqual((told["dimension"], told["keep"]), (2, "lowest"))
        self.assertGreater(told["filtered"], 0)
        self.ok("verify", "kept", "--quiet")
        self.ok("dem", "kept", "--res", "2", "-o", "again.tif", "--quiet")
        self.assertEqual((self.folder / "dem.tif").read_bytes(), (self.folder / "again.tif").read_bytes())

    def test_wrong_input_gets_a_sentence_and_leaves_nothing(self):
        cloud = self.xyz(n=300)
        self.ok("triangulate", cloud, "-o", "ground", "--dim", "2", "--quiet")
        before = sorted(self.files(self.folder))
        self.refused(USAGE, "dem", "ground", cloud, "--res", "1", "-o", "dem.tif", says="ground")
        self.refused(USAGE, "dem", "ground", "--res", "1", "-o", "dem.tif", "--keep-result", "kept", says="--keep-result")
        self.refused(USAGE, "dem", cloud, "--res", "1", "-o", "dem.tif", "--keep-result", "ground", says="ground: holds a finished result")
        self.refused(IO, "dem", "missing.las", "--res", "1", "-o", "dem.tif", says="missing.las")
        self.refused(IO, "dem", "*.laz", "--res", "1", "-o", "dem.tif", says="*.laz")
        self.refused(USAGE, "dem", says="no result folder")
        self.refused(IO, "dem", cloud, "--res", "1", "-o", "none/dem.tif", says="there is no folder none")
        self.refused(USAGE, "dem", cloud, "--res", "1", "-o", "dem.tif", "--value", "colour", says="colour")
        self.assertEqual(sorted(self.files(self.folder)), before)


if __name__ == "__main__":
    unittest.main()
