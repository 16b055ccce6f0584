"""Results that are kept as points: the same triangulation, in a tenth of the bytes, with cells whenever they are asked for."""
import json
import shutil
import unittest

from cli import CORRUPT, IGN, USAGE, CliTest


class Points(CliTest):
    def tiles(self, name):
        return {p.name: p.read_bytes() for p in (self.folder / name / "tiles").iterdir()}

    def told(self, name):
        return self.json_lines(self.ok("info", name, "--json"))[0]

    def both(self, *args):
        """The same cloud with cells and with points; the two are the same triangulation."""
        for name in ("cells", "points"):
            shutil.rmtree(self.folder / name, ignore_errors=True)
            self.ok("triangulate", *args, "-o", name, "--store", name, "--quiet")
        cells, points = self.told("cells"), self.told("points")
        for what in ("digest", "vertices", "cells", "duplicates", "bounds", "heights"):
            self.assertEqual(cells[what], points[what], what)
        self.assertEqual([{**tile, "bytes": 0, "xxh3": 0, "file": 0} for tile in cells["tiles"]],
                         [{**tile, "bytes": 0, "xxh3": 0, "file": 0} for tile in points["tiles"]])
        self.assertEqual({p.rsplit(".")[-1] for p in self.tiles("points")}, {"pts"})
        self.assertEqual((cells["tiles_of_points"], points["tiles_of_points"]), (0, len(points["tiles"])))
        self.assertIn("kept as points", self.ok("info", "points"))
        self.ok("verify", "points", "--quiet")

    def test_they_make_the_same_files_of_cells(self):
        copies = self.xyz(n=700).read_text()
        cloud = self.write("copies.xyz", copies + copies[:copies.index("\n", 2000) + 1])
        lattice = self.write("lattice.xyz", "".join(f"{x} {y} {z}\n" for x in range(12) for y in range(11) for z in range(10)))
        for args in ([cloud, "--tiles", "5"], [cloud, "--tiles", "9", "--dim", "2"],
                     [cloud, "--partition", "random", "--tiles", "4"], [cloud, "--tiles", "40"],
                     [cloud, "--tiles", "6", "--kernel", "cgal"], [cloud, "--tiles", "5", "--no-neighbors"],
                     [lattice, "--tiles", "7"], [lattice, "--partition", "octree", "--tiles", "8", "--threads", "1"],
                     [lattice, "--partition", "random", "--tiles", "5", "--kernel", "cgal"]):
            with self.subTest(args):
                self.both(*args)
                self.ok("verify", "points", "--against-cgal", "--quiet")
                shutil.rmtree(self.folder / "made", ignore_errors=True)
                self.ok("materialise", "points", "-o", "made", "--quiet")
                self.assertEqual(self.tiles("made"), self.tiles("cells"))
                for name in ("duplicates.bin", "triangulation.pvtu"):
                    made, right = (self.folder / folder / name for folder in ("made", "cells"))
                    self.assertEqual(made.exists() and made.read_bytes(), right.exists() and right.read_bytes())
                self.ok("verify", "made", "--quiet")

    def test_memory_and_tiles_that_sleep_change_nothing(self):
        self.ok("generate", "uniform", "-n", "120k", "-o", "cloud.npy", "--seed", "4")
        files = set()
        for options in (["--memory", "2G"], ["--memory", "150M"], ["--memory", "150M", "--threads", "1"]):
            shutil.rmtree(self.folder / "points", ignore_errors=True)
            self.ok("triangulate", "cloud.npy", "-o", "points", "--store", "points", "--tiles", "24", "--quiet", *options)
            files.add(tuple(sorted(self.tiles("points").items())))
        self.assertEqual(len(files), 1)
        self.ok("triangulate", "cloud.npy", "-o", "cells", "--store", "cells", "--tiles", "24", "--quiet")
        self.assertEqual(self.told("points")["digest"], self.told("cells")["digest"])
        self.ok("verify", "points", "--quiet")
        size = lambda name: sum(len(data) for data in self.tiles(name).values())
        self.assertLess(size("points") * 6, size("cells"))

    def test_large_tiles_have_their_cells_in_the_order_of_a_job(self):
        self.ok("generate", "uniform", "-n", "4300k", "--seed", "3", "-o", "cloud.npy")
        self.both("cloud.npy", "--dim", "2", "--tiles", "12")
        shutil.copytree(self.folder / "points", self.folder / "measured")
        self.ok("materialise", "points", "--quiet", "--threads", "2")
        made = {name.replace("-2.vtu", ".vtu"): data for name, data in self.tiles("points").items() if name.endswith(".vtu")}
        self.assertEqual(made, self.tiles("cells"))
        self.ok("verify", "points", "--quiet")
        # Columns of such tiles come in canonical order.
        for name in ("cells", "measured"):
            self.ok("measure", name, "--volume", "--quiet", "--threads", "2")
        self.ok("materialise", "measured", "-o", "made", "--quiet", "--threads", "2")
        measured = {name.replace("-2.vtu", ".vtu"): data for name, data in self.tiles("cells").items() if "-2" in name}
        self.assertEqual(self.tiles("made"), measured)
        self.ok("verify", "made", "--quiet")

    def test_lidar_answers_alike_with_both_kinds_of_tiles(self):
        self.both(f"{IGN}/*.las", "--dim", "2", "--tiles", "6", "--attributes", "intensity")
        box = self.told("points")["tiles"]
        bounds = self.told("points")["bounds"]
        x, y = ((bounds["min"][i] + bounds["max"][i]) / 2 for i in (0, 1))
        self.ok("materialise", "points", "-o", "mixed", "--bbox", f"{x - 1},{y - 1},{x},{y}", "--quiet")
        kinds = {name.rsplit(".")[-1] for name in self.tiles("mixed")}
        self.assertEqual(kinds, {"pts", "vtu"}, box)
        self.ok("verify", "mixed", "--quiet")
        self.write("asked.xyz", f"{x} {y}\n{x + 1} {y + 2}\n")
        answers = {}
        for name in ("cells", "points", "mixed"):
            self.ok("dem", name, "-o", f"{name}.tif", "--res", "2", "--quiet")
            self.ok("contours", name, "-o", f"{name}.geojson", "--interval", "5", "--quiet")
            self.ok("export", name, "-o", f"{name}.ply", "--quiet")
            self.ok("tileset", name, "-o", f"{name}-tiles", "--quiet")
            found = [self.ok("query", name, what, *rest) for what, *rest in
                     (("locate", f"{x},{y}"), ("interpolate", "asked.xyz", "--value", "z"), ("star", "1000"))]
            tileset = sorted((p.name, p.read_bytes()) for p in (self.folder / f"{name}-tiles" / "nodes").iterdir())
            files = [(self.folder / f"{name}{ending}").read_bytes() for ending in (".tif", ".geojson", ".ply")]
            answers[name] = (found, files, tileset)
        self.assertEqual(answers["points"], answers["cells"])
        self.assertEqual(answers["mixed"], answers["cells"])

    def test_damage_is_a_sentence(self):
        self.both(self.xyz(n=2000), "--tiles", "3")
        tile = self.folder / "points" / "tiles" / "000001.pts"
        whole = tile.read_bytes()
        for at in (3, len(whole) // 2, len(whole) - 1):
            tile.write_bytes(whole[:at] + bytes([whole[at] ^ 4]) + whole[at + 1:])
            self.refused(CORRUPT, "verify", "points", says="000001.pts")
            self.refused(CORRUPT, "export", "points", "-o", "x.ply", says="000001.pts")
            self.refused(CORRUPT, "materialise", "points", says="000001.pts")
            self.refused(CORRUPT, "materialise", "points", "-o", "made", says="000001.pts")
            self.assertFalse((self.folder / "made").exists())
        for shorter in (0, 10, len(whole) - 1):
            tile.write_bytes(whole[:shorter])
            self.refused(CORRUPT, "export", "points", "-o", "x.ply", says="000001.pts")
        other = (self.folder / "points" / "tiles" / "000002.pts").read_bytes()
        tile.write_bytes(other)
        self.refused(CORRUPT, "export", "points", "-o", "x.ply", says="000001.pts")

    def test_what_cannot_be_is_refused(self):
        cloud = self.xyz(n=300)
        self.refused(USAGE, "triangulate", cloud, "-o", self.out, "--store", "half", says="--store: 'half' is not one of auto, cells and points")
        self.ok("triangulate", cloud, "-o", self.out, "--quiet")
        self.assertIn("no tile of this result is kept as points", self.ok("materialise", self.out))
        self.refused(USAGE, "materialise", self.out, "-o", self.out, says="exists already")
        self.refused(USAGE, "materialise", self.out, "-o", "x", "--bbox", "1,2", says="--bbox")


if __name__ == "__main__":
    unittest.main()
