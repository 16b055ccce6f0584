"""tessera update: the result of a change is that of a triangulation from scratch."""
import json
import os
import shutil
import unittest

import numpy as np
from cli import BAD_INPUT, IO, USAGE, CliTest


class Update(CliTest):
    def setUp(self):
        super().setUp()
        self.random = np.random.default_rng(7)

    def manifest(self, result):
        return json.loads((self.folder / result / "manifest.json").read_text())

    def save(self, name, points):
        np.save(self.folder / name, points)
        return name

    def update(self, *args):
        return json.loads(self.ok("update", *args, "--json").splitlines()[-1])

    def triangulate(self, points, out, *args):
        self.ok("triangulate", self.save(f"{out}.npy", points), "-o", out, "--quiet", *args)

    def expect_as_from_scratch(self, result, points, dim):
        """`points`: by source index, with NaN for points that were removed."""
        self.triangulate(points, "scratch", "--dim", dim, "--skip-invalid", "--overwrite")
        expected, got = self.manifest("scratch"), self.manifest(result)
        for key in ("digest2", "bounds"):
            self.assertEqual(got[key], expected[key], key)
        for key in ("vertices", "cells", "duplicates"):
            self.assertEqual(got["counts"][key], expected["counts"][key], key)
        self.ok("verify", result, "--quiet")

    def clouds(self, dim):
        yield "uniform", self.random.random((3000, dim))
        yield "lattice", self.random.integers(0, 30, (3000, dim)).astype(float)
        if dim == 3:
            terrain = self.random.random((3000, 3))
            terrain[:, 2] = np.round(np.sin(6 * terrain[:, 0]) * np.cos(5 * terrain[:, 1]), 2)
            yield "terrain", terrain

    def test_chains_of_changes_give_the_results_of_triangulations_from_scratch(self):
        for dim in (2, 3):
            for name, cloud in self.clouds(dim):
                many = ((1, "cells"), (7, "cells"), (60, "points")) if name == "lattice" else ((7, "points"),)
                for tiles, store in many:
                    with self.subTest(dim=dim, cloud=name, tiles=tiles, store=store):
                        self.chain(cloud, str(dim), str(tiles), store)

    def chain(self, cloud, dim, tiles, store):
        for name in ("r0", "r1", "r2", "r3"):
            shutil.rmtree(self.folder / name, ignore_errors=True)
        self.triangulate(cloud[:2000], "r0", "--dim", dim, "--tiles", tiles, "--store", store)
        told = self.update("r0", "--add", self.save("more.npy", cloud[2000:]), "-o", "r1")
        self.assertEqual((told["added"], told["first_new_id"]), (1000, 2000))
        self.expect_as_from_scratch("r1", cloud, dim)
        gone = np.unique(self.random.integers(0, 3000, 300))
        self.update("r1", "--remove-ids", self.save("ids.npy", gone), "-o", "r2", "--threads", "3")
        left = cloud.copy()
        left[gone] = np.nan
        self.expect_as_from_scratch("r2", left, dim)
        lo, hi = np.nanquantile(left, 0.3, axis=0)[:2], np.nanquantile(left, 0.5, axis=0)[:2]
        box = ",".join(repr(float(v)) for v in (*lo, *hi))
        self.update("r2", "--remove-box", box, "--add", self.save("again.npy", cloud[gone]), "-o", "r3")
        inside = ((left[:, :2] >= lo) & (left[:, :2] <= hi)).all(axis=1)
        left[inside] = np.nan
        self.expect_as_from_scratch("r3", np.concatenate([left, cloud[gone]]), dim)

    def test_a_class_is_removed_and_added_points_bring_their_attributes(self):
        def rows(count, first):
            out = np.zeros(count, [("x", "f8"), ("y", "f8"), ("z", "f8"), ("classification", "u1"), ("rank", "u4")])
            for axis in "xyz":
                out[axis] = self.random.random(count)
            out["classification"] = np.arange(first, first + count) % 5
            out["rank"] = np.arange(first, first + count)
            return out

        first, more = rows(1000, 0), rows(200, 1000)
        self.triangulate(first, "out", "--attributes", "classification,rank", "--tiles", "9")
        dry = self.update("out", "--remove-class", "1,3", "--dry-run")
        self.assertEqual((dry["event"], dry["removed"]), ("would_update", 400))
        told = self.update("out", "--remove-class", "1,3", "--add", self.save("more.npy", more), "-o", "next")
        self.assertEqual((told["removed"], told["vertices"]), (400, 800))
        self.ok("export", "next", "-o", "exported/", "--format", "npy")
        ranks = np.load(self.folder / "exported" / "rank.npy")
        both = np.concatenate([first, more])
        kept = (both["rank"] >= 1000) | ~np.isin(both["classification"], (1, 3))
        np.testing.assert_array_equal(np.sort(ranks), np.flatnonzero(kept))
        points = np.load(self.folder / "exported" / "points.npy")
        both = both[ranks]
        np.testing.assert_array_equal(points, np.stack([both[axis] for axis in "xyz"], axis=1))

    def test_unchanged_tiles_are_links_and_the_old_result_stays(self):
        cloud = self.random.random((20000, 2))
        self.triangulate(cloud, "out", "--tiles", "40", "--dim", "2")
        told = self.update("out", "--remove-ids", self.save("one.npy", np.array([5])), "-o", "next")
        self.assertLessEqual(told["tiles_changed"], 4)
        linked = sum(os.path.samefile(file, self.folder / "next" / "tiles" / file.name)
                     for file in (self.folder / "out" / "tiles").iterdir())
        self.assertEqual(linked, 40 - told["tiles_changed"])
        shutil.rmtree(self.folder / "out")
        left = cloud.copy()
        left[5] = np.nan
        self.expect_as_from_scratch("next", left, "2")

    def test_what_is_wrong_gets_a_sentence_and_leaves_nothing(self):
        self.triangulate(self.random.random((100, 3)), "out")
        ids = self.save("ids.npy", np.array([3, 1000]))
        for args, status, sentence in (
                (["--remove-ids", ids], USAGE, "there is no point 1000 to remove"),
                (["--remove-ids", self.save("real.npy", np.array([1.5]))], BAD_INPUT, "holds type '<f8'"),
                (["--remove-ids", self.save("minus.npy", np.array([2, -1]))], BAD_INPUT, "place 1 is -1"),
                (["--remove-ids", "none.npy"], IO, "none.npy"),
                (["--remove-class", "7"], USAGE, "has no attribute 'classification'"),
                (["--remove-class", "700"], USAGE, "700"),
                (["--remove-box", "0,0,1"], USAGE, "--remove-box"),
                (["--remove-box=-1,-1,2,2"], USAGE, "no points would be left"),
                (["--add", self.save("flat.npy", np.array([[0, 0, np.nan]]))], BAD_INPUT, "flat.npy"),
                ([], USAGE, "nothing is to be changed")):
            with self.subTest(args=args):
                self.refused(status, "update", "out", *args, "-o", "next", says=sentence)
                self.assertFalse((self.folder / "next").exists())
        self.refused(USAGE, "update", "out", "--remove-box", "0,0,0.1,0.1", "-o", "out", says="exists already")
        self.refused(USAGE, "update", "-o", "next", "--remove-ids", ids, says="no result folder is given")


if __name__ == "__main__":
    unittest.main()
