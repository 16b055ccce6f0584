"""tessera update without -o, tessera log and --version: versions of a result."""
import json
import os
import re
import shutil
import subprocess
import threading
import unittest

import numpy as np
from cli import BAD_INPUT, CORRUPT, TESSERA, USAGE, CliTest
from tile_arrays import read_tile


class Versions(CliTest):
    def setUp(self):
        super().setUp()
        self.random = np.random.default_rng(11)

    def manifest(self, result="out"):
        return json.loads((self.folder / result / "manifest.json").read_text())

    def save(self, name, points):
        np.save(self.folder / name, points)
        return name

    def triangulate(self, points, out="out", *args):
        self.ok("triangulate", self.save(f"{out}.npy", points), "-o", out, "--quiet", *args)

    def update(self, *args, result="out"):
        return json.loads(self.ok("update", result, *args, "--json").splitlines()[-1])

    def remove(self, *ids):
        return ("--remove-ids", self.save("ids.npy", np.array(ids)))

    def log(self, result="out"):
        return json.loads(self.ok("log", result, "--json"))

    def info(self, *args):
        return json.loads(self.ok("info", *args, "--json"))

    def tiles(self, result="out"):
        return sorted(file.name for file in (self.folder / result / "tiles").iterdir())

    def expect_as_from_scratch(self, points, dim, tiles):
        """`points`: by source index, with NaN for points that were removed."""
        self.triangulate(points, "scratch", "--dim", dim, "--skip-invalid", "--overwrite")
        expected, got = self.manifest("scratch"), self.manifest()
        for key in ("digest2", "bounds"):
            self.assertEqual(got[key], expected[key], key)
        for key in ("vertices", "cells", "duplicates"):
            self.assertEqual(got["counts"][key], expected["counts"][key], key)
        self.assertEqual(got["version"], tiles)
        self.ok("verify", "out", "--quiet")

    def test_each_change_is_a_version_that_equals_a_triangulation_from_scratch(self):
        for dim, tiles, store in (("2", "7", "cells"), ("3", "7", "points"), ("2", "60", "points"), ("3", "1", "cells")):
            with self.subTest(dim=dim, tiles=tiles, store=store):
                shutil.rmtree(self.out, ignore_errors=True)
                # Many equal points, and many on the hull.
                cloud = self.random.integers(0, 20, (1500, int(dim))).astype(float)
                self.triangulate(cloud[:1000], "out", "--dim", dim, "--tiles", tiles, "--store", store)
                told = self.update("--add", self.save("more.npy", cloud[1000:]), "--keep-versions", "10")
                self.assertEqual((told["output"], told["version"], told["first_new_id"]), ("out", 2, 1000))
                self.expect_as_from_scratch(cloud, dim, 2)
                gone = np.unique(self.random.integers(0, 1500, 200))
                self.update(*self.remove(*gone), "--threads", "3")
                left = cloud.copy()
                left[gone] = np.nan
                self.expect_as_from_scratch(left, dim, 3)
                side = np.flatnonzero(left[:, 0] < 4)  # the bounds shrink, and tiles lose all points
                self.update(*self.remove(*side))
                left[side] = np.nan
                self.expect_as_from_scratch(left, dim, 4)
                self.update("--add", self.save("again.npy", cloud[:300]))  # tiles get points again
                self.expect_as_from_scratch(np.concatenate([left, cloud[:300]]), dim, 5)
                log = self.log()
                self.assertEqual((log["version"], log["keep_versions"]), (5, 10))
                for version in log["versions"]:
                    number = version["version"]
                    self.assertTrue(version["readable"])
                    self.ok("verify", "out", "--version", number, "--quiet")
                    info = self.info("out", "--version", number)
                    for key in ("vertices", "cells", "digest", "version"):
                        self.assertEqual(info[key], version[key], key)
                changes = [(v["added"], v["removed"], v["input_files"]) for v in log["versions"]]
                self.assertEqual(changes, [(1000, 0, 1), (500, 0, 1), (0, len(gone), 0), (0, len(side), 0), (300, 0, 1)])

    def test_a_change_of_a_point_reads_and_writes_few_tiles(self):
        cloud = self.random.random((30000, 2))
        self.triangulate(cloud, "out", "--tiles", "100", "--dim", "2", "--store", "points")
        shutil.copytree(self.out, self.folder / "copy")
        one = self.save("one.npy", np.array([[0.5, 0.5]]))
        told = self.update("--add", one)
        self.assertLessEqual(told["tiles_awake"], 6)
        entry = self.log()["versions"][-1]
        self.assertEqual((entry["tiles_written"], entry["tiles"]), (told["tiles_changed"], 100))
        self.expect_as_from_scratch(np.concatenate([cloud, [[0.5, 0.5]]]), "2", 2)
        # All other files are damaged, and nobody notices.
        near = sorted(range(100), key=lambda tile: self.distance(tile, 0.5))[:told["tiles_awake"] + 4]
        for tile in set(range(100)) - set(near):
            (self.folder / "copy" / "tiles" / f"{tile:06}.pts").write_bytes(b"damaged")
        self.update("--add", one, result="copy")
        self.assertEqual(self.manifest("copy")["digest2"], self.manifest()["digest2"])
        # A vertex on the bounds: only tiles along one side are read.
        lowest = int(np.argmin(cloud[:, 0]))
        self.assertLessEqual(self.update(*self.remove(lowest))["tiles_changed"], 6)
        left = np.concatenate([cloud, [[0.5, 0.5]]])
        left[lowest] = np.nan
        self.expect_as_from_scratch(left, "2", 3)

    def distance(self, tile, place):
        """Of a tile's box from (place, place)."""
        box = self.manifest()["partition"]["boxes"][tile]
        lo, hi = (np.array([float(v) for v in box[key]][:2]) for key in ("lo", "hi"))
        return float(np.hypot(*np.maximum(0, np.maximum(lo - place, place - hi))))

    def test_old_versions_are_read_by_every_command_as_long_as_they_are_kept(self):
        points = np.column_stack([self.random.random((400, 2)) * 10, self.random.random(400)])
        self.triangulate(points, "out", "--dim", "2", "--attributes", "z", "--tiles", "4")
        before = self.products(None, "before")
        self.update(*self.remove(*range(0, 400, 7)), "--keep-versions", "2")
        after = self.products(None, "after")
        self.assertEqual(self.products(1, "old"), before)
        self.assertEqual(self.products(2, "new"), after)
        self.assertNotEqual(before, after)
        # The path of the manifest does the same, also for two versions in one command.
        self.assertEqual(self.info("out/.versions/000001.json")["vertices"], 400)
        table = self.ok("volume", "out/.versions/000001.json", "out")
        self.assertIn("volume", table)
        for number in (3, 9):
            self.refused(USAGE, "info", "out", "--version", number,
                         says=f"out: version {number} does not exist; the versions 1 and 2 can be read")
        self.update(*self.remove(1))
        self.update(*self.remove(2))
        self.refused(USAGE, "verify", "out", "--version", "1", says="out: version 1 is not kept any more; the versions 2, 3 and 4 can be read")
        self.refused(USAGE, "dem", "out", "--version", "0", "--res", "1", "-o", "x.tif", says="--version")
        self.refused(USAGE, "update", "out/.versions/000002.json", *self.remove(3), says="only the newest version can be changed")
        self.refused(USAGE, "update", "out", *self.remove(3), "--keep-versions", "0", says="--keep-versions")
        self.refused(USAGE, "update", "out", *self.remove(3), "--keep-versions", "2", "-o", "next", says="--keep-versions")

    def test_a_change_that_neither_adds_nor_removes_makes_no_version(self):
        self.triangulate(self.random.random((300, 3)), "out", "--tiles", "3")
        before = {p: p.read_bytes() for p in self.out.rglob("*") if p.is_file()}
        none = self.save("none.npy", np.zeros(0, np.uint64))
        for change in (("--remove-ids", none), ("--remove-box", "5,5,6,6"), ("--add", self.save("no.npy", np.zeros((0, 3))), "--replace")):
            self.assertRegex(self.ok("update", "out", *change), "nothing has changed: .* the newest version is still 1")
            told = json.loads(self.ok("update", "out", *change, "--json"))
            self.assertEqual((told["event"], told["unchanged"], told["version"], told["removed"], told["added"]), ("updated", True, 1, 0, 0))
            self.assertEqual({p: p.read_bytes() for p in self.out.rglob("*") if p.is_file()}, before)
            self.assertFalse((self.folder / "out.update").exists())
        self.ok("update", "out", "--remove-ids", none, "-o", "next", "--quiet")  # a new folder is what was asked for
        self.ok("verify", "next", "--quiet")

    def without_version(self, made):
        """Of a product, without the number of the version that it is of."""
        return re.sub(rb'("version":|"RESULT_VERSION">)\d', rb"\1-", made)

    def products(self, version, name):
        """What the commands make of a version, as bytes."""
        of = ("out",) if version is None else ("out", "--version", version)
        made = []
        (self.folder / "line.csv").write_text("1,1\n9,8\n")
        for command, *options, ending in (("dem", "--res", "0.5", ".tif"), ("dem", "--res", "0.5", "--method", "natural", ".tif"),
                                          ("contours", "--interval", "0.1", ".geojson"), ("export", ".ply"), ("voronoi", ".csv"),
                                          ("alpha", "--alpha", "auto", ".geojson"), ("volume", "--plane", "0.5", ".csv"),
                                          ("profile", "--line", "1,1 9,8", ".csv"), ("density", "--res", "1", ".tif")):
            target = self.folder / f"{name}-{command}{ending}"
            self.ok(command, *of, *options, "-o", target, "--quiet", "--overwrite")
            made.append(re.sub(rb"(before|after|old|new)-", b"", target.read_bytes()))
        made.append(json.loads(self.ok("query", *of, "locate", "5,5", "--json"))["cell"])
        made.append(self.ok("query", *of, "neighbours", "3"))
        made.append(self.ok("query", *of, "interpolate", "line.csv", "--value", "z"))
        return made

    def test_the_log_tells_what_each_version_is(self):
        self.triangulate(self.random.random((300, 3)), "out", "--tiles", "3", "--store", "points")
        self.ok("materialise", "out", "--quiet")
        self.update(*self.remove(4, 5), "--keep-versions", "3")
        self.ok("measure", "out", "--volume", "--quiet")
        versions = self.log()["versions"]
        self.assertEqual([v["version"] for v in versions], [1, 2, 3, 4])
        self.assertEqual([v["readable"] for v in versions], [True] * 4)
        self.assertEqual([v["columns"] for v in versions], [[], [], [], ["volume", "star_volume"]])
        self.assertEqual([[os.path.basename(v["command"][0]), v["command"][1]] for v in versions],
                         [["tessera", "triangulate"], ["tessera", "materialise"], ["tessera", "update"], ["tessera", "measure"]])
        self.assertEqual([v["vertices"] for v in versions], [300, 300, 298, 298])
        self.assertEqual(versions[2]["digest"], versions[3]["digest"])
        for version in versions:
            self.assertRegex(version["time"], r"^20\d\d-\d\d-\d\dT\d\d:\d\d:\d\dZ$")
            self.assertGreater(version["bytes_written"], 1000)
        lines = self.ok("log", "out").splitlines()
        self.assertEqual(len(lines), 5)
        self.assertTrue(lines[0].startswith("version  time"))
        self.assertIn("columns volume, star_volume", lines[4])
        self.assertIn("-2 ", lines[3])
        # A result that was never changed has one version.
        self.triangulate(self.random.random((100, 3)), "other")
        self.assertEqual([v["added"] for v in self.log("other")["versions"]], [100])
        (self.out / ".versions" / "log.json").write_text("no log")
        self.refused(CORRUPT, "log", "out", says="out/.versions/log.json: is damaged")
        self.ok("verify", "out", "--quiet")

    def columns_of(self, result):
        """{what of (the ids of) which vertex or cell: bits}. All files that have a vertex or a cell must agree."""
        manifest, values = self.manifest(result), {}
        names = [("Cell" if column["of"] == "cells" else "Point", column["name"]) for column in manifest["columns"]]
        for entry in manifest["tiles"]:
            arrays = read_tile(self.folder / result / entry.get("file", "tiles/%06d.vtu" % entry["tile"]))
            ids = arrays["PointData/id"]
            cells = np.sort(ids[arrays["Cells/connectivity"].reshape(-1, manifest["dimension"] + 1)], axis=1)
            for of, name in names:
                column = arrays[f"{of}Data/{name}"]
                bits = column.view("u8") if column.dtype == np.dtype("<f8") else column
                for row, value in zip(ids.tolist() if of == "Point" else map(tuple, cells.tolist()), bits.tolist()):
                    self.assertEqual(values.setdefault((name, row), value), value, (result, entry["tile"], name, row))
        return values

    def test_columns_are_what_measuring_from_scratch_gives(self):
        measures = ("--volume", "--quality", "--voronoi", "--density", "--quiet", "--threads", "2")
        for dim, tiles in (("2", "1"), ("2", "12"), ("3", "7")):
            with self.subTest(dim=dim, tiles=tiles):
                shutil.rmtree(self.out, ignore_errors=True)
                grid = self.random.integers(0, 6, (100, int(dim))).astype(float) / 4
                cloud = np.concatenate([self.random.random((300, int(dim))), grid])
                self.triangulate(cloud, "out", "--dim", dim, "--tiles", tiles)
                self.ok("measure", "out", *measures)
                self.update("--add", self.save("more.npy", self.random.random((3, int(dim)))), "--threads", "2")
                gone = np.unique(self.random.integers(0, 400, 12))
                self.update(*self.remove(*gone))
                self.ok("verify", "out", "--quiet")
                left = np.concatenate([cloud, np.load(self.folder / "more.npy")])
                left[gone] = np.nan
                self.triangulate(left, "scratch", "--dim", dim, "--skip-invalid", "--overwrite")
                self.ok("measure", "scratch", *measures)
                self.assertEqual(self.manifest()["digest2"], self.manifest("scratch")["digest2"])
                self.assertEqual(self.columns_of("out"), self.columns_of("scratch"))
                self.assertEqual(*(self.manifest(each)["columns"][0]["total"] for each in ("out", "scratch")))

    def test_columns_of_tiles_kept_as_points_are_made_again(self):
        points = np.column_stack([self.random.random((2000, 2)), self.random.random(2000)])
        self.triangulate(points, "out", "--dim", "2", "--tiles", "9", "--store", "points", "--attributes", "z")
        self.ok("measure", "out", "--volume", "--voronoi", "--quiet")
        one = self.save("one.npy", np.array([[0.4, 0.4, 7.0]]))
        told = self.update("--add", one)
        self.assertLess(self.log()["versions"][-1]["tiles_written"], 9)
        self.assertLess(told["tiles_changed"], 5)
        self.ok("verify", "out", "--quiet")
        self.triangulate(np.concatenate([points, np.load(self.folder / one)]), "scratch", "--dim", "2", "--tiles", "9", "--attributes", "z")
        self.ok("measure", "scratch", "--volume", "--voronoi", "--quiet")
        self.ok("materialise", "out", "--quiet")
        self.assertEqual(self.columns_of("out"), self.columns_of("scratch"))
        removed = self.remove(5)
        self.ok("update", "out", *removed, "-o", "next", "--quiet")
        self.ok("verify", "next", "--quiet")
        self.ok("update", "out", *removed, "--quiet")
        self.assertEqual(self.columns_of("next"), self.columns_of("out"))
        self.ok("update", "next", "--add", one, "--quiet")
        self.ok("verify", "next", "--quiet")
        # Densities, of points and of an attribute, where only duplicates come and go, too.
        for mass in ((), ("--mass", "z")):
            self.ok("measure", "next", "--density", *mass, "--quiet")
        again = self.save("again.npy", points[[700, 701, 702]])
        told = json.loads(self.ok("update", "next", "--add", again, "--json").splitlines()[-1])
        self.assertEqual((told["tiles_changed"], told["duplicates"]), (0, 3))
        self.assertGreater(self.log("next")["versions"][-1]["tiles_written"], 0)
        self.ok("update", "next", *self.remove(702), "--quiet")
        left = np.concatenate([points, np.load(self.folder / one), np.load(self.folder / one), np.load(self.folder / again)])
        left[[5, 702]] = np.nan
        self.triangulate(left, "scratch", "--dim", "2", "--tiles", "9", "--attributes", "z", "--skip-invalid", "--overwrite")
        for measure in (("--volume", "--voronoi"), ("--density",), ("--density", "--mass", "z")):
            self.ok("measure", "scratch", *measure, "--quiet")
        self.assertEqual(self.columns_of("next"), self.columns_of("scratch"))
        self.assertEqual(*(self.manifest(each)["columns"][0]["total"] for each in ("next", "scratch")))
        # A column that nothing makes.
        manifest = (self.folder / "next/manifest.json").read_text()
        (self.folder / "next/manifest.json").write_text(manifest.replace('"density_z"', '"density_q"'))
        self.refused(USAGE, "update", "next", *self.remove(6), says="no attribute 'q'")

    def test_tiles_that_grow_too_large_are_split_and_every_command_reads_them(self):
        grow = self.random.random((300, 3)) * (4, 4, 1) + (1, 1, 0)
        for store in ("cells", "points"):
            with self.subTest(store=store):
                shutil.rmtree(self.out, ignore_errors=True)
                points = np.column_stack([self.random.random((400, 2)) * 10, self.random.random(400)])
                given = ("--dim", "2", "--attributes", "z")
                self.triangulate(points, "out", *given, "--tiles", "4", "--store", store)
                self.ok("measure", "out", "--volume", "--voronoi", "--quiet")
                before = self.products(None, "before")
                told = self.update("--add", self.save("more.npy", grow), "--max-points-per-tile", "70", "--keep-versions", "9")
                self.assertGreater(told["tiles_split"], 0)
                self.assertGreater(told["tiles"], 4 + 300 / 70)
                partition = self.manifest()["partition"]
                self.assertEqual(partition["split_above"], 70)
                self.assertEqual(len(partition["boxes"]), partition["tiles"])
                self.ok("verify", "out", "--quiet")
                self.assertEqual(self.products(2, "old"), before)  # with the partition of that time
                self.ok("verify", "out", "--version", "2", "--quiet")
                self.triangulate(np.concatenate([points, grow]), "scratch", *given, "--tiles", "9", "--overwrite")
                self.assertEqual(self.manifest()["digest2"], self.manifest("scratch")["digest2"])
                for command, *options in (("dem", "--res", "0.5"), ("contours", "--interval", "0.1"), ("profile", "--line", "1,1 9,8")):
                    ending = ".geojson" if command == "contours" else ".csv" if command == "profile" else ".tif"
                    made = [self.folder / f"{result}{ending}" for result in ("out", "scratch")]
                    for file in made:
                        self.ok(command, file.stem, *options, "-o", file.name, "--quiet", "--overwrite")
                    one, other = (self.without_version(file.read_bytes().replace(b"scratch", b"out")) for file in made)
                    self.assertEqual(one, other, command)
                self.products(None, "after")
                self.ok("tileset", "out", "-o", f"tileset-{store}", "--quiet")
                self.ok("measure", "scratch", "--volume", "--voronoi", "--quiet")
                if store == "points":
                    self.ok("materialise", "out", "--quiet")
                self.assertEqual(self.columns_of("out"), self.columns_of("scratch"))

    def test_a_reader_keeps_its_version_while_others_are_written(self):
        cloud = self.random.random((4000, 3))
        self.triangulate(cloud, "out", "--tiles", "12", "--store", "points")
        digest = self.manifest()["digest2"]
        errors, stop = [], threading.Event()

        def read():
            while not stop.is_set():
                done = self.run_tessera("verify", "out", "--json")
                if done.returncode != 0:
                    errors.append(done.stderr)

        readers = [threading.Thread(target=read) for _ in range(2)]
        for reader in readers:
            reader.start()
        for i in range(6):
            self.update(*self.remove(*range(100 * i, 100 * i + 50)))
        stop.set()
        for reader in readers:
            reader.join()
        self.assertEqual(errors, [])
        self.assertNotEqual(self.manifest()["digest2"], digest)

    def test_updaters_that_wait_take_turns(self):
        self.triangulate(self.random.random((3000, 3)), "out", "--tiles", "5")
        clean = {k: v for k, v in os.environ.items() if not k.startswith("TESSERA")}
        for i in range(4):
            self.save(f"ids{i}.npy", np.arange(10 * i, 10 * i + 10))
        waiting = [subprocess.Popen([TESSERA, "update", "out", "--remove-ids", f"ids{i}.npy", "--wait", "--keep-versions", "9"], cwd=self.folder, env=clean, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
                   for i in range(4)]
        for one in waiting:
            said = one.communicate(timeout=120)
            self.assertEqual(one.returncode, 0, said)
        manifest = self.manifest()
        self.assertEqual((manifest["version"], manifest["counts"]["vertices"]), (5, 2960))
        self.ok("verify", "out", "--quiet")
        self.assertEqual([v["removed"] for v in self.log()["versions"]], [0, 10, 10, 10, 10])

    def test_a_surface_is_checked_against_the_version_that_it_was_made_of(self):
        x, y = np.meshgrid(np.arange(12.0), np.arange(12.0))
        ground = np.column_stack([x.ravel(), y.ravel(), np.sin(x.ravel())]) + self.random.random((144, 3)) / 10
        self.triangulate(ground, "out", "--tiles", "3")
        self.ok("surface", "out", "-o", "mesh.ply", "--sensor", "vertical", "--quiet")
        self.update(*self.remove(5, 6), "--keep-versions", "2")
        self.refused(USAGE, "verify", "mesh.ply", "--of", "out",
                     says=("another triangulation than mesh.ply was made of", "it was made of version 1 of this result"))
        self.ok("verify", "mesh.ply", "--of", "out", "--version", "1", "--quiet")
        self.update(*self.remove(7))
        self.update(*self.remove(8))
        self.refused(USAGE, "verify", "mesh.ply", "--of", "out", says="version 1 of this result, which is not kept any more")

    def test_an_error_leaves_the_version_that_stands(self):
        self.triangulate(self.random.random((100, 3)), "out", "--tiles", "2")
        before = self.contents()
        for args, status, sentence in ((self.remove(3, 1000), USAGE, "there is no point 1000 to remove"),
                                       (("--remove-box=-1,-1,2,2",), USAGE, "no points would be left"),
                                       (("--add", self.save("bad.npy", np.array([[0, 0, np.nan]]))), BAD_INPUT, "bad.npy")):
            self.refused(status, "update", "out", *args, says=sentence)
            self.assertEqual(self.contents(), before)

    def contents(self):
        return {str(p.relative_to(self.out)): p.is_dir() or p.read_bytes()
                for p in self.out.rglob("*") if p.name != "log.json"}  # which has the time


if __name__ == "__main__":
    unittest.main()
