"""Voronoi cells: the file of the function has the same bytes as that of the command, and errors name the argument."""
import os
import pathlib
import subprocess
import tempfile
import unittest

import numpy as np
import tessera

TESSERA = os.environ["TESSERA"]
SQUARE = '{"type": "Polygon", "coordinates": [[[1, 1], [3, 1], [3, 3], [1, 3], [1, 1]]]}'


class Voronoi(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def lattice(self, dim, side=5):
        """Points whose cells inside are unit squares or cubes."""
        axes = np.meshgrid(*[np.arange(side, dtype=float)] * dim)
        points = np.stack([axis.ravel() for axis in axes], axis=1)
        return tessera.triangulate(points, dim, folder=self.folder / f"lattice{dim}")

    def command(self, t, name, *options):
        subprocess.run([TESSERA, "voronoi", t.folder, "-o", self.folder / name, "--quiet", *options], check=True)
        return (self.folder / name).read_bytes()

    def test_files_are_those_of_the_command(self):
        flat, space = self.lattice(2), self.lattice(3, 4)
        (self.folder / "square.geojson").write_text(SQUARE)
        box2, box3 = (0.75, 0.75, 2.25, 2.25), (0.75, 0.75, 0.75, 2.25, 2.25, 2.25)
        square = self.folder / "square.geojson"
        for t, ending, clip, flag, size in (
                (flat, ".csv", None, None, 16), (flat, ".geojson", "hull", "hull", 16), (flat, ".csv", box2, box2, 2.25),
                (flat, ".geojson", square, square, 4), (flat, ".csv", "none", "none", 9), (space, ".vtu", box3, box3, 3.375),
                (space, ".vtu", None, None, 8)):
            with self.subTest(ending=ending, clip=clip, dim=t.dim):
                target = self.folder / f"here{ending}"
                told = t.voronoi(target, clip=clip, overwrite=True, memory="1G", threads=2)
                self.assertEqual(told.size, size)
                text = ",".join(map(str, flag)) if isinstance(flag, tuple) else flag
                there = self.command(t, f"there{ending}", "--overwrite", *([] if flag is None else ["--clip", text]))
                self.assertEqual(target.read_bytes(), there)

    def test_what_was_written_is_counted(self):
        told = self.lattice(2).voronoi(self.folder / "cells.csv", clip=(0.75, 0.75, 2.25, 2.25))
        self.assertEqual((told.cells, told.unbounded, told.outside), (4, 0, 21))

    def test_errors_name_what_is_wrong(self):
        t = self.lattice(2)
        target = self.folder / "cells.csv"
        for clip, says in (((1, 2, 3), "clip"), ((1, 1, 1, 5), "clip"), ((float("nan"), 0, 1, 1), "clip"), ("x.txt", "x.txt")):
            with self.subTest(clip=clip), self.assertRaisesRegex(tessera.UsageError, says):
                t.voronoi(target, clip=clip)
        with self.assertRaises(tessera.UsageError):
            t.voronoi(self.folder / "cells.vtu")
        self.assertFalse(target.exists())
        t.voronoi(target)
        with self.assertRaisesRegex(tessera.UsageError, "exists already; overwrite=True"):
            t.voronoi(target)


if __name__ == "__main__":
    unittest.main()
