"""tessera update: a result grows by a neighbouring file, and shrinks again by --remove-input. Afterwards it is what it was.

With MORE_CLOUDS, a folder of real point files, and MORE_NEIGHBOURS=1 all files there that adjoin are tried, in both
orders, too (tests/nightly.sh).
"""
import filecmp
import itertools
import json
import os
import pathlib
import shutil
import unittest

from cli import CliTest

CLOUDS = pathlib.Path(__file__).resolve().parents[1] / "data" / "clouds"
MORE = pathlib.Path(os.environ.get("MORE_CLOUDS", ""))
ATTRIBUTES = ("--attributes", "intensity,classification,gps_time")


class Neighbours(CliTest):
    def manifest(self, result):
        return json.loads((self.folder / result / "manifest.json").read_text())

    def update(self, *args):
        return json.loads(self.ok("update", *args, "--json").splitlines()[-1])

    def expect_same_cells(self, got, expected):
        got, expected = self.manifest(got), self.manifest(expected)
        for key in ("digest2", "bounds"):
            self.assertEqual(got[key], expected[key], key)
        for key in ("vertices", "cells", "duplicates"):
            self.assertEqual(got["counts"][key], expected["counts"][key], key)

    # Tiles that a change has not touched are links to the files from before the change. Tiles beside one that was split
    # have new files, too, because these files tell whose each vertex is.
    def expect_untouched(self, before, after, told):
        links = 0
        tiles = list((self.folder / after / "tiles").iterdir())
        for tile in tiles:
            old = self.folder / before / "tiles" / tile.name
            links += old.exists() and old.samefile(tile)
        if told["way"] == "exchange" and not told["tiles_split"]:
            self.assertGreaterEqual(links, told["tiles"] - told["tiles_changed"])

    def expect_same_files(self, got, expected):
        names = sorted(tile.name for tile in (self.folder / expected / "tiles").iterdir())
        self.assertEqual(sorted(tile.name for tile in (self.folder / got / "tiles").iterdir()), names)
        folders = [self.folder / result / "tiles" for result in (got, expected)]
        _, different, errors = filecmp.cmpfiles(*folders, names, shallow=False)
        self.assertEqual((different, errors), ([], []))

    def grow_and_shrink(self, first, second, dim, tiles, store, *attributes):
        kind = ("--dim", dim, *attributes)
        for name in ("out", "grown", "back", "both"):
            shutil.rmtree(self.folder / name, ignore_errors=True)
        self.ok("triangulate", first, "-o", "out", "--quiet", *kind, "--tiles", tiles, "--store", store)
        grown = self.update("out", "--add", second, "-o", "grown")
        self.ok("triangulate", first, second, "-o", "both", "--quiet", *kind)  # the digest is that of any tiling
        self.expect_same_cells("grown", "both")
        self.expect_untouched("out", "grown", grown)
        back = self.update("grown", "--remove-input", second, "-o", "back")
        self.assertEqual(back["removed"], grown["added"])
        self.expect_same_cells("back", "out")
        self.expect_untouched("grown", "back", back)
        if not grown["tiles_split"]:  # parts of a tile that was split stay parts
            self.expect_same_files("back", "out")
        for result in ("grown", "back"):
            self.ok("verify", result, "--quiet")
        return grown, back

    def test_a_result_that_grows_by_a_neighbour_and_loses_it_again_is_what_it_was(self):
        middle, east = CLOUDS / "ign_77050_627755.laz", CLOUDS / "ign_77055_627755.laz"
        for dim, tiles, store, attributes in (("2", "40", "cells", ATTRIBUTES), ("2", "7", "points", ()), ("3", "9", "points", ATTRIBUTES)):
            with self.subTest(dim=dim, tiles=tiles, store=store):
                grown, back = self.grow_and_shrink(middle, east, dim, tiles, store, *attributes)
                self.assertEqual(grown["added"], 72770)
                self.assertEqual(grown["tiles"], back["tiles"])

    def test_the_four_files_of_a_block_come_and_go_in_any_order(self):
        block = [CLOUDS / f"ign_{x}_{y}.laz" for x in (77050, 77055) for y in (627755, 627760)]
        self.ok("triangulate", block[0], "-o", "r0", "--quiet", "--dim", "2", "--tiles", "30", *ATTRIBUTES)
        for i, new in enumerate(block[1:]):
            self.update(f"r{i}", "--add", new, "-o", f"r{i + 1}")
        self.ok("triangulate", *block, "-o", "all", "--quiet", "--dim", "2", *ATTRIBUTES)
        self.expect_same_cells("r3", "all")
        self.update("r3", "--remove-input", block[2], "--remove-input", block[1], "-o", "r4")
        self.update("r4", "--remove-input", block[3], "-o", "r5")
        self.expect_same_cells("r5", "r0")
        self.expect_same_files("r5", "r0")

    @unittest.skipUnless(os.environ.get("MORE_NEIGHBOURS"), "MORE_NEIGHBOURS is not set")
    def test_all_files_of_a_folder_that_adjoin(self):
        done = 0
        bounds = {file: self.bounds(file) for file in sorted(MORE.glob("*.laz"))}
        for first, second in itertools.permutations(bounds, 2):
            if not self.adjoin(bounds[first], bounds[second]):
                continue
            for dim, store in itertools.product(("2", "3"), ("cells", "points")):
                with self.subTest(first=first.name, second=second.name, dim=dim, store=store):
                    self.grow_and_shrink(first, second, dim, "60", store, *ATTRIBUTES)
                    done += 1
        self.assertGreater(done, 0, f"no two files of {MORE} adjoin")
        print(f"figures: {done} results grew and shrank")

    def bounds(self, file):
        told = json.loads(self.ok("info", file, "--json").splitlines()[-1])["files"][0]["bounds"]
        return told["min"][:2], told["max"][:2]

    # Files of one survey that touch: no gap of more than a tenth of their widths, and no overlap.
    def adjoin(self, first, second):
        (lo, hi), (lo2, hi2) = first, second
        gaps = [max(a2 - b, a - b2) for a, b, a2, b2 in zip(lo, hi, lo2, hi2)]
        width = min(b - a for a, b in zip([*lo, *lo2], [*hi, *hi2]))
        return -1e-6 * width <= max(gaps) <= width / 10
