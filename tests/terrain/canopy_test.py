"""Canopy models: of the points with equal x and y, --keep chooses the vertex, for every tiling and kind of tiles."""
import random
import struct
import unittest

import numpy as np
from cli import USAGE, CliTest
from osgeo import gdal

gdal.UseExceptions()


class Canopy(CliTest):
    columns, rows = 17, 13

    def las_of(self, name, points):
        """A LAS file of points (x, y, z, intensity), coordinates in hundredths."""
        header = bytearray(227)
        header[:4] = b"LASF"
        header[24:26] = bytes((1, 2))
        struct.pack_into("<HIIBHI", header, 94, 227, 227, 0, 0, 20, len(points))
        struct.pack_into("<ddd", header, 131, 0.01, 0.01, 0.01)
        x, y, z = (np.array([p[k] for p in points]) / 100 for k in range(3))
        struct.pack_into("<dddddd", header, 179, x.max(), x.min(), y.max(), y.min(), z.max(), z.min())
        body = b"".join(struct.pack("<iiiHBBbBH", px, py, pz, i, 9, 1, 0, 0, 0) for px, py, pz, i in points)
        path = self.folder / name
        path.write_bytes(bytes(header) + body)
        return path

    def forest(self):
        """Places of a lattice, which is degenerate, each with several returns, in two files."""
        dice = random.Random(4)
        places = [(100 * x + 50, 100 * y + 50) for x in range(self.columns) for y in range(self.rows)]
        points = [(x, y, dice.randrange(0, 2500), dice.randrange(1000)) for x, y in places for _ in range(dice.randrange(1, 5))]
        dice.shuffle(points)
        points += [points[0][:2] + (points[0][2], 777)]  # also an equal height
        half = len(points) // 2
        return points, [self.las_of("a.las", points[:half]), self.las_of("b.las", points[half:])]

    def kept(self, points, keep):
        best = {}
        for index, (x, y, z, intensity) in enumerate(points):
            rank = {"first": index, "last": -index, "lowest": (z, index), "highest": (-z, index)}[keep]
            if (x, y) not in best or rank < best[x, y][0]:
                best[x, y] = (rank, z / 100, intensity)
        return best

    def drawn(self, out, *options):
        """A raster whose pixels have their centres on the vertices."""
        self.ok("dem", *out, "--res", "1", "-o", "dem.tif", "--type", "float64", "--overwrite", "--quiet", *options)
        return gdal.Open(str(self.folder / "dem.tif")).ReadAsArray()

    def test_the_kept_point_is_the_vertex_for_every_tiling_and_kind(self):
        points, files = self.forest()
        self.ok("triangulate", *files, "--dim", "2", "-o", "ground", "--quiet")
        self.ok("hag", *files, "-o", "packed", "--format", "laz", "--ground", "ground", "--outside", "0", "--quiet")
        packed = [self.folder / "packed" / name for name in ("a.laz", "b.laz")]
        for keep in ("first", "last", "lowest", "highest"):
            right = np.full((2, self.rows, self.columns), np.nan)
            for (x, y), (_, z, intensity) in self.kept(points, keep).items():
                right[:, self.rows - 1 - y // 100, x // 100] = z, intensity
            # The pixels on the right and upper edges of the hull are outside.
            right[:, 0, :] = right[:, :, -1] = np.nan
            for inputs, tiles, store in ((files, "1", "cells"), (packed, "7", "points"), (packed, "30", "cells")):
                out = self.folder / f"{keep}{tiles}"
                self.ok("triangulate", *inputs, "--dim", "2", "--keep", keep, "--attributes", "intensity", "--tiles", tiles, "--store", store, "-o", out, "--quiet")
                for method in ("linear", "natural", "laplace"):
                    for value, wanted in zip(("z", "intensity"), right):
                        np.testing.assert_array_equal(self.drawn([out], "--method", method, "--value", value), wanted)
            for method in ("linear", "natural"):  # in one step
                np.testing.assert_array_equal(self.drawn(packed, "--method", method, "--keep", keep), right[0])

    def test_a_policy_that_does_not_exist_is_refused(self):
        _, files = self.forest()
        self.refused(USAGE, "dem", *files, "--res", "1", "--keep", "middle", "-o", "a.tif", says="'middle' is not one of first, last, lowest and highest")
        self.assertFalse((self.folder / "a.tif").exists())


if __name__ == "__main__":
    unittest.main()
