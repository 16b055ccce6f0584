"""Voids: the array is the table of the command, and the column says the zones of points."""
import csv
import os
import pathlib
import subprocess
import tempfile
import unittest

import numpy as np
import tessera

TESSERA = os.environ["TESSERA"]


class Voids(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def test_the_array_is_the_table_of_the_command(self):
        for dim in 2, 3:
            points = np.random.default_rng(1).random((500, dim))
            t = tessera.triangulate(points, dim, periodic=1, folder=self.folder / f"box{dim}")
            found = t.voids(memory="1G", threads=2)
            subprocess.run([TESSERA, "voids", t.folder, "-o", self.folder / "voids.csv", "--overwrite", "--quiet"], check=True)
            with open(self.folder / "voids.csv", newline="") as file:
                rows = {int(row["zone"]): row for row in csv.DictReader(file)}
            self.assertEqual(found["zone"].tolist(), sorted(rows))
            for name in found.dtype.names:
                key = name.replace("volume", "area") if dim == 2 else name
                if name == "z" and dim == 2:
                    self.assertEqual(found["z"].tolist(), [0] * len(found))
                    continue
                wanted = [rows[zone][key] for zone in found["zone"].tolist()]
                self.assertEqual(found[name].tolist(), [float(value) if value else -1 for value in wanted], name)
            here = t.voids(self.folder / f"here{dim}.csv")
            self.assertEqual((self.folder / f"here{dim}.csv").read_bytes(), (self.folder / "voids.csv").read_bytes())
            np.testing.assert_array_equal(here, found)
            zone = np.concatenate([tile.attributes["zone"][~tile.foreign] for tile in t])
            self.assertEqual(dict(zip(*map(np.ndarray.tolist, np.unique(zone, return_counts=True)))),
                             dict(zip(found["zone"].tolist(), found["zone_points"].tolist())))

    def test_errors_name_the_argument(self):
        t = tessera.triangulate(np.random.default_rng(1).random((50, 2)), 2)
        with self.assertRaisesRegex(tessera.UsageError, "by: 'weight' is no density"):
            t.voids(by="weight")
        (self.folder / "voids.csv").touch()
        with self.assertRaisesRegex(tessera.UsageError, "exists already; overwrite=True replaces it"):
            t.voids(self.folder / "voids.csv")


if __name__ == "__main__":
    unittest.main()
