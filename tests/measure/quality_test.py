"""tessera measure --quality: shapes of cells are right to 1e-9, also of flat ones, and do not depend on tiles and threads."""
import decimal
import itertools
import json
import math
import unittest

import numpy as np
from cli import USAGE, CliTest
from tile_arrays import read_tile

from volumes_test import clouds, exact_volume

COLUMNS = ["radius_ratio", "least_angle", "largest_angle", "circumradius"]
decimal.getcontext().prec = 60
# Clouds have numbers whose products are far beyond those of doubles.
decimal.getcontext().Emax, decimal.getcontext().Emin = 10**6, -10**6


def vector(a, b):
    return [x - y for x, y in zip(b, a)]


def dot(a, b):
    return sum((x * y for x, y in zip(a, b)), decimal.Decimal(0))


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def length(a):
    return dot(a, a).sqrt()


def degrees(sine, cosine):
    """Of two numbers with a common factor."""
    scale = max(abs(sine), abs(cosine))
    return math.degrees(math.atan2(float(sine / scale), float(cosine / scale)))


def shape(corners):
    """Radius ratio, least and largest angle, and circumradius, with 60 digits until the last step."""
    p = [[decimal.Decimal(float(x)) for x in row] for row in corners]
    volume = exact_volume(corners)
    volume = decimal.Decimal(volume.numerator) / decimal.Decimal(volume.denominator)
    if len(p) == 3:
        edges = [length(vector(p[(k + 1) % 3], p[(k + 2) % 3])) for k in range(3)]
        radius = edges[0] * edges[1] * edges[2] / (4 * volume)
        inner = 2 * volume / sum(edges)
        angles = [degrees(2 * volume, dot(vector(p[k], p[(k + 1) % 3]), vector(p[k], p[(k + 2) % 3]))) for k in range(3)]
        return float(2 * inner / radius), min(angles), max(angles), float(radius)
    a, b, c = (vector(p[0], p[k]) for k in (1, 2, 3))
    bc, ca, ab = cross(b, c), cross(c, a), cross(a, b)
    centre = [dot(a, a) * bc[i] + dot(b, b) * ca[i] + dot(c, c) * ab[i] for i in range(3)]
    radius = length(centre) / (12 * volume)
    areas = (length(bc) + length(ca) + length(ab) + length(cross(vector(a, b), vector(a, c)))) / 2
    angles = []
    for i, j in itertools.combinations(range(4), 2):
        k, m = (x for x in range(4) if x not in (i, j))
        edge = vector(p[i], p[j])
        one, other = cross(edge, vector(p[i], p[k])), cross(edge, vector(p[i], p[m]))
        angles.append(degrees(length(cross(one, other)), dot(one, other)))
    return float(9 * volume / areas / radius), min(angles), max(angles), float(radius)


class Quality(CliTest):
    def measured(self, points, *options, threads=2):
        """{sorted ids of a cell: (values, corners)}, of all tiles."""
        np.save(self.folder / "cloud.npy", points)
        self.ok("triangulate", self.folder / "cloud.npy", "-o", self.out, "--overwrite", "--quiet", "--dim", points.shape[1],
                "--store", "cells", *options)
        self.ok("measure", self.out, "--quality", "--threads", threads)
        manifest, found = json.loads((self.out / "manifest.json").read_text()), {}
        for entry in manifest["tiles"]:
            arrays = read_tile(self.out / entry.get("file", "tiles/%06d.vtu" % entry["tile"]))
            ids, at = arrays["PointData/id"], arrays["Points"][:, :points.shape[1]]
            cells = arrays["Cells/connectivity"].reshape(-1, points.shape[1] + 1)
            for row, values in zip(cells, zip(*(arrays["CellData/" + name].tolist() for name in COLUMNS))):
                one = found.setdefault(tuple(np.sort(ids[row]).tolist()), (values, at[row]))
                self.assertEqual(one[0], values)  # in every tile that has the cell
        return found

    def test_values_are_those_of_many_digits(self):
        for d in 2, 3:
            for name, points in clouds(d).items():
                with self.subTest(dimension=d, cloud=name):
                    for values, corners in list(self.measured(points[:400], "--tiles", "3").values())[::3]:
                        right = shape(corners)
                        # Cells of numbers from 1e-30 to 1e30 are flatter than any others.
                        rtol = 1e-6 if name == "mixed" else 1e-9
                        for k, atol in enumerate((0, 1e-9, 1e-9, 0)):  # angles in degrees
                            np.testing.assert_allclose(values[k], right[k], rtol=rtol, atol=atol, err_msg=str(corners))

    def test_bits_are_the_same_for_all_tiles_and_threads(self):
        for d in 2, 3:
            for name in "uniform", "grid", "mixed":
                first = None
                for options, threads in ((["--tiles", "1"], 1), (["--tiles", "7"], 2), (["--tiles", "40", "--partition", "random"], 3)):
                    found = {cell: values for cell, (values, _) in self.measured(clouds(d)[name], *options, threads=threads).items()}
                    first = first or found
                    self.assertEqual(found, first)

    def test_cells_of_a_square_and_a_cube_have_the_angles_of_halves(self):
        square = np.stack(np.meshgrid(np.arange(5.0), np.arange(5.0)), -1).reshape(-1, 2)
        for values, _ in self.measured(square, "--tiles", "2").values():
            np.testing.assert_allclose(values, (2 * (math.sqrt(2) - 1), 45, 90, math.sqrt(.5)), rtol=1e-14)
        for ratio, least, largest, radius in (v for v, _ in self.measured(np.stack(
                np.meshgrid(*[np.arange(4.0)] * 3), -1).reshape(-1, 3), "--tiles", "3").values()):
            self.assertAlmostEqual(radius, math.sqrt(.75), 12)
            self.assertTrue(0 < ratio < 1 and 0 < least <= largest < 180)

    def test_together_with_volumes_they_are_one_version(self):
        np.save(self.folder / "cloud.npy", clouds(3)["uniform"][:200])
        self.ok("triangulate", self.folder / "cloud.npy", "-o", self.out, "--quiet", "--tiles", "3")
        told = json.loads(self.ok("measure", self.out, "--volume", "--quality", "--json").splitlines()[-1])
        self.assertEqual((told["version"], told["columns"]), (2, ["volume", "star_volume", *COLUMNS]))
        self.assertGreater(told["total"], 0)
        again = json.loads(self.ok("measure", self.out, "--quality", "--json").splitlines()[-1])
        self.assertEqual((again["version"], again["made"], again["columns"], again["total"]), (2, False, COLUMNS, None))
        self.ok("verify", self.out)
        table = self.ok("columns", self.out)
        for name in COLUMNS:
            self.assertIn(name, table)
        self.ok("export", self.out, "-o", self.folder / "mesh.vtu", "--quiet")
        self.assertIn(b"circumradius", (self.folder / "mesh.vtu").read_bytes())

    def test_one_measure_after_the_other_keeps_both(self):
        np.save(self.folder / "cloud.npy", clouds(2)["uniform"][:200])
        self.ok("triangulate", self.folder / "cloud.npy", "-o", self.out, "--quiet", "--tiles", "2", "--dim", "2")
        self.ok("measure", self.out, "--quality")
        told = json.loads(self.ok("measure", self.out, "--volume", "--quality", "--json").splitlines()[-1])
        self.assertEqual((told["version"], told["made"], told["columns"]), (3, True, ["area", "star_area", *COLUMNS]))
        self.refused(USAGE, "measure", self.out, says="there is nothing to measure; --volume and --quality measure cells, --voronoi")


if __name__ == "__main__":
    unittest.main()
