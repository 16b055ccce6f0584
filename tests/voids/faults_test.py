"""Wrong input, stale and damaged results, an interrupted search; and a real snapshot against brute force."""
import os
import pathlib
import unittest

import numpy as np
from brute import Stored, expected, table
from cli import CORRUPT, IO, USAGE
from voids_test import VoidsTest

SHARED = pathlib.Path(os.environ.get("SHARED_DATA", ""))


class Faults(VoidsTest):
    def cloud(self, n=300, dimension=2, *options):
        return self.triangulate(np.random.default_rng(1).random((n, dimension)), None, *options)

    def measured(self, out):
        for _ in range(2):  # the second time removes the older version
            self.ok("measure", out, "--voronoi", "--quiet")

    def test_wrong_arguments_are_told_before_anything_is_read(self):
        self.refused(USAGE, "voids", says="no result folder is given; try 'tessera voids --help'")
        self.refused(IO, "voids", self.folder / "none", says="none")
        out = self.cloud()
        before = self.files(out)
        self.refused(USAGE, "voids", out, "--by", "mass", says="--by: 'mass' is no density; give voronoi, density")
        self.refused(USAGE, "voids", out, "--by", "density_", says="is no density")
        self.refused(USAGE, "voids", out, "--by", "density_mass", says="mass")
        self.refused(USAGE, "voids", out, "-o", "voids.h5", says="voids.h5: '.h5' is not a format of voids; the formats are .csv")
        for name in "voids.csv", "voids.void", "voids.zone", "voids.txt":
            (self.folder / name).write_text("mine")
            target = "voids.csv" if name == "voids.csv" else "voids.txt"
            self.refused(USAGE, "voids", out, "-o", self.folder / target, says=f"{name}: exists already; --overwrite replaces it")
            self.assertEqual((self.folder / name).read_text(), "mine")
            (self.folder / name).unlink()
        self.assertEqual(self.files(out), before)

    def test_a_second_search_changes_nothing(self):
        out = self.cloud()
        first = self.voids(out)
        self.assertEqual((first["made"], first["version"]), (True, 3))  # the second version has the Voronoi columns
        again = self.voids(out, "-o", self.folder / "voids.csv")
        self.assertEqual((again["made"], again["version"], again["zones"]), (False, 3, first["zones"]))
        self.assertEqual(len(table(self.folder / "voids.csv")), first["zones"])
        said = self.ok("voids", out)
        self.assertIn("the result has the column zone already, and was not changed", said)
        self.ok("verify", out)

    def test_columns_that_exist_are_not_computed_again(self):
        out = self.cloud()
        self.ok("measure", out, "--voronoi", "--quiet")
        self.assertEqual(self.voids(out)["version"], 3)

    def test_a_name_that_is_taken_is_told(self):
        (self.folder / "named.csv").write_text("x,y,zone\n" + "".join(f"{x},{x * x % 7},1\n" for x in range(9)))
        self.ok("triangulate", self.folder / "named.csv", "-o", self.out, "--dim", "2", "--attributes", "zone", "--quiet")
        self.refused(USAGE, "voids", self.out, says="its vertices have an attribute 'zone' already")

    def test_a_region_is_refused(self):
        self.cloud(300, 3)
        self.ok("region", self.folder / "cloud.npy", "--bbox", "0.2,0.2,0.6,0.6", "-o", self.folder / "part", "--quiet")
        self.refused(USAGE, "voids", self.folder / "part", says="is a region")

    def test_a_damaged_column_is_told_with_its_file(self):
        out = self.cloud(300, 2, "--tiles", "3")
        self.measured(out)
        file = out / "tiles/000001-2.vtu"
        data = bytearray(file.read_bytes())
        data[-3000] ^= 1
        file.write_bytes(data)
        before = self.files(out)
        self.refused(CORRUPT, "voids", out, "-o", self.folder / "voids.csv", says="000001-2.vtu")
        self.assertEqual(self.files(out), before)
        self.assertFalse((self.folder / "voids.csv").exists())

    def test_a_folder_that_does_not_exist_gets_no_file_and_no_version(self):
        out = self.cloud()
        self.measured(out)
        before = self.files(out)
        self.refused(IO, "voids", out, "-o", self.folder / "none/voids.csv", says="none")
        self.assertEqual(self.files(out), before)

    def test_an_update_says_that_it_cannot_carry_zones_over(self):
        out = self.cloud()
        self.voids(out)
        np.save(self.folder / "more.npy", np.array([[0.5, 0.5]]))
        self.refused(USAGE, "update", out, "--add", self.folder / "more.npy", says="the computed column 'zone'")

    def test_zones_are_attributes_of_vertices(self):
        out = self.cloud()
        self.voids(out)
        self.ok("export", out, "-o", self.folder / "arrays", "--format", "npy", "--quiet")
        ids, zone = (np.load(self.folder / "arrays" / name) for name in ("ids.npy", "zone.npy"))
        self.assertEqual(dict(zip(ids.tolist(), zone.tolist())), Stored(out).columns["zone"])
        self.assertIn("zone of vertices (version 3)", self.ok("info", out))


class Real(VoidsTest):
    def test_a_snapshot_is_as_brute_force(self):
        snapshot = SHARED / "lcdm_gas.gadget"
        if not os.access(snapshot, os.R_OK):
            self.skipTest("there are no shared data")
        files = set()
        for tiles, memory in (1, "4G"), (30, "1M"):
            self.ok("triangulate", snapshot, "-o", self.out, "--periodic", "50000", "--overwrite", "--quiet", "--tiles", tiles)
            self.voids(self.out, "-o", self.folder / "voids.csv", "--overwrite", "--memory", memory)
            files.add((self.folder / "voids.csv").read_bytes())
        self.assertEqual(len(files), 1)
        stored = Stored(self.out)
        wanted = expected(stored)
        self.assertEqual(stored.columns["zone"], wanted.zone)
        self.check_table(table(self.folder / "voids.csv"), wanted, 3)


if __name__ == "__main__":
    unittest.main()
