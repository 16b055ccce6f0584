"""tessera dem --method natural and laplace: each pixel against exact arithmetic, CGAL, and every tiling."""
import math
import os
import random
import unittest
from fractions import Fraction

import numpy as np
from cli import CORRUPT, USAGE, CliTest
from osgeo import gdal

gdal.UseExceptions()
TILINGS = (("1", "cells"), ("7", "points"), ("60", "cells"))


def cross(a, b):
    return a[0] * b[1] - a[1] * b[0]


def minus(a, b):
    return (a[0] - b[0], a[1] - b[1])


def clipped(polygon, site, q):
    """The part of a convex polygon that is nearer to q, or as near, as to the site."""
    normal = minus(site, q)
    offset = (site[0] ** 2 - q[0] ** 2 + site[1] ** 2 - q[1] ** 2) / 2
    side = [p[0] * normal[0] + p[1] * normal[1] - offset for p in polygon]
    kept = []
    for i, p in enumerate(polygon):
        j = (i + 1) % len(polygon)
        if side[i] <= 0:
            kept.append(p)
        if (side[i] < 0 < side[j]) or (side[j] < 0 < side[i]):
            part = side[i] / (side[i] - side[j])
            kept.append((p[0] + part * (polygon[j][0] - p[0]), p[1] + part * (polygon[j][1] - p[1])))
    return kept


def area2(polygon):
    return sum(cross(p, polygon[(i + 1) % len(polygon)]) for i, p in enumerate(polygon))


def voronoi_cell(points, q):
    """The Voronoi cell of q among the points, within a box that is much larger than the hull, and the points near it."""
    far = Fraction(10 ** 12)
    polygon = [(q[0] - far, q[1] - far), (q[0] + far, q[1] - far), (q[0] + far, q[1] + far), (q[0] - far, q[1] + far)]
    order = sorted(range(len(points)), key=lambda i: (points[i][0] - q[0]) ** 2 + (points[i][1] - q[1]) ** 2)
    for i in order:
        reach = max((p[0] - q[0]) ** 2 + (p[1] - q[1]) ** 2 for p in polygon)
        if (points[i][0] - q[0]) ** 2 + (points[i][1] - q[1]) ** 2 > 4 * reach:
            break
        polygon = clipped(polygon, points[i], q)
    return polygon


def right_value(points, heights, q, method):
    """By definition: Voronoi cells are cut out of the plane by bisectors, with fractions. q is inside the hull."""
    if q in points:
        return heights[points.index(q)]
    cell = voronoi_cell(points, q)
    total, value = Fraction(0), Fraction(0)
    for i, p in enumerate(points):
        middle = ((p[0] + q[0]) / 2, (p[1] + q[1]) / 2)
        d = minus(p, q)
        on = [c for c in cell if (c[0] - middle[0]) * d[0] + (c[1] - middle[1]) * d[1] == 0]
        if len(on) < 2:
            continue
        if method == "laplace":
            # Both are multiples of the vector from q to p turned by 90 degrees, so the quotient is a fraction.
            steps = [cross(d, minus(c, middle)) / (d[0] ** 2 + d[1] ** 2) for c in on]
            weight = max(steps) - min(steps)
        else:
            taken = cell
            for j, other in enumerate(points):
                if j != i:
                    taken = clipped_to(taken, p, other)
                    if len(taken) < 3:
                        break
            weight = area2(taken) if len(taken) >= 3 else Fraction(0)
        total += weight
        value += weight * heights[i]
    return float(value / total)


def clipped_to(polygon, site, other):
    return clipped(polygon, other, site) if polygon else polygon


class Natural(CliTest):
    def points(self, kind):
        dice = random.Random(11)
        if kind == "lattice":  # centres of pixels are on vertices, edges and centres of circles
            return [(x / 2, y / 2, dice.randrange(9)) for x in range(9) for y in range(7)]
        if kind == "circle":  # 12 cocircular points with whole coordinates, and some inside
            ring = [(x, y) for x in range(-5, 6) for y in range(-5, 6) if x * x + y * y == 25]
            return [(x, y, dice.random()) for x, y in ring + [(9, 9), (-9, 9), (-9, -9), (9, -9), (1, 0)]]
        if kind == "thin":  # a hull with nearly collinear points
            return [(i * 0.37, (i * i % 7) * 2.0**-40 + (5 if i % 2 else 0), dice.random()) for i in range(30)]
        if kind == "far":
            return [(885000 + dice.randrange(1000) / 100, 6290000 + dice.randrange(800) / 100, 300 + dice.random()) for _ in range(60)]
        if kind == "outlier":
            return [(dice.uniform(-4, 4), dice.uniform(-3, 3), dice.random()) for _ in range(40)] + [(1e5, 2e4, 3.0), (-3e6, 1.0, 2.0)]
        return [(dice.uniform(-4, 4), dice.uniform(-3, 3), dice.random()) for _ in range(60)]

    def cloud(self, points, name="cloud.csv"):
        return self.write(name, "x,y,z\n" + "".join("%r,%r,%r\n" % p for p in points))

    def triangulate(self, cloud, tiles, store="cells"):
        out = self.folder / f"out{tiles}{store}"
        self.ok("triangulate", cloud, "--dim", "2", "--tiles", tiles, "--store", store, "-o", out, "--quiet", "--overwrite")
        return out

    def dem(self, out, method, *options, name="dem.tif"):
        self.ok("dem", out, "-o", name, "--method", method, "--type", "float64", "--overwrite", "--quiet", *options)
        file = gdal.Open(str(self.folder / name))
        return file.ReadAsArray(), file.GetGeoTransform()

    def test_each_pixel_is_right_for_every_tiling(self):
        for kind, res, box in (("lattice", 0.25, None), ("lattice", 0.3, None), ("circle", 1, None), ("circle", 0.7, None), ("thin", 0.6, None),
                               ("far", 0.7, None), ("outlier", 0.5, "-3,-3,3,3"), ("uniform", 0.5, None)):
            points = self.points(kind)
            cloud = self.cloud(points)
            exact = [(Fraction(x), Fraction(y)) for x, y, _ in points]
            heights = [Fraction(z) for _, _, z in points]
            options = ["--res", str(res)] + (["--bbox", box] if box else [])
            rasters = {}
            for tiles, store in TILINGS:
                out = self.triangulate(cloud, tiles, store)
                if not rasters:
                    linear, place = self.dem(out, "linear", *options)
                for method in ("natural", "laplace"):
                    raster, _ = self.dem(out, method, "--threads", str(1 + len(rasters) % 3), *options)
                    rasters.setdefault(method, []).append(raster)
                    np.testing.assert_array_equal(np.isnan(raster), np.isnan(linear))
            for method, made in rasters.items():
                with self.subTest(kind=kind, res=res, method=method):
                    for other in made[1:]:
                        np.testing.assert_array_equal(made[0].view("u8"), other.view("u8"))
                    rows, columns = np.nonzero(~np.isnan(made[0]))
                    self.assertGreater(len(rows), 20)
                    left, top = round(place[0] / res), round(place[3] / res)
                    every = max(1, len(rows) // 16)
                    for row, column in list(zip(rows, columns))[::every]:
                        q = (Fraction((left + int(column) + 0.5) * res), Fraction((top - 1 - int(row) + 0.5) * res))
                        wanted = right_value(exact, heights, q, method)
                        if self.on_hull(exact, q):
                            wanted = linear[row, column]
                        self.assertLess(abs(made[0][row, column] - wanted), 1e-10, (row, column))

    def on_hull(self, points, q):
        """Whether q is on an edge of the hull."""
        for a in points:
            for b in points:
                if a == b or cross(minus(b, a), minus(q, a)) != 0:
                    continue
                if all(cross(minus(b, a), minus(p, a)) >= 0 for p in points):
                    return True
        return False

    def test_a_plane_stays_one(self):
        dice = random.Random(3)
        rows = [(dice.uniform(0, 50), dice.uniform(0, 30)) for _ in range(3000)]
        out = self.triangulate(self.cloud([(x, y, 3 + 0.5 * x - 2 * y) for x, y in rows]), "7")
        for method in ("natural", "laplace"):
            raster, (left, res, _, top, _, _) = self.dem(out, method, "--res", "0.25")
            x = left + (np.arange(raster.shape[1]) + 0.5) * res
            y = top - (np.arange(raster.shape[0]) + 0.5) * res
            there = ~np.isnan(raster)
            self.assertGreater(there.mean(), 0.9)
            self.assertLess(np.abs(raster - (3 + 0.5 * x[None, :] - 2 * y[:, None]))[there].max(), 1e-9)

    def test_boxes_threads_memory_and_kinds_give_the_same_pixels(self):
        dice = random.Random(5)
        points = [(round(dice.uniform(0, 40), 1), round(dice.uniform(0, 40), 1), dice.random()) for _ in range(4000)]
        cloud = self.cloud(points)
        out = self.triangulate(cloud, "60")
        for method in ("natural", "laplace"):
            whole, place = self.dem(out, method, "--res", "0.3")
            for tiles, store, more in (("1", "points", ()), ("7", "cells", ("--threads", "4")), ("60", "points", ("--memory", "1M"))):
                raster, _ = self.dem(self.triangulate(cloud, tiles, store), method, "--res", "0.3", *more)
                np.testing.assert_array_equal(whole.view("u8"), raster.view("u8"))
            part, there = self.dem(out, method, "--res", "0.3", "--bbox", "10,11,14,13")
            column, row = round((there[0] - place[0]) / 0.3), round((place[3] - there[3]) / 0.3)
            np.testing.assert_array_equal(whole[row:row + part.shape[0], column:column + part.shape[1]].view("u8"), part.view("u8"))
            # In one step.
            self.ok("dem", cloud, "-o", "one.tif", "--method", method, "--type", "float64", "--res", "0.3", "--quiet", "--overwrite")
            np.testing.assert_array_equal(whole.view("u8"), gdal.Open(str(self.folder / "one.tif")).ReadAsArray().view("u8"))

    def test_neighbours_without_a_finite_value_make_no_pixel(self):
        rows = [(x, y, 7.0) for x in range(9) for y in range(9)]
        for bad in (math.nan, math.inf):
            rows[40] = (4, 4, bad)
            raster, _ = self.dem(self.triangulate(self.cloud(rows), "1"), "natural", "--res", "0.7")
            self.assertTrue(np.isnan(raster[4:7, 4:7]).any())
            self.assertEqual(set(raster[~np.isnan(raster)]), {7.0})

    def test_large_and_tiny_coordinates(self):
        dice = random.Random(9)
        rows = [(dice.uniform(0, 8), dice.uniform(0, 8), dice.random()) for _ in range(200)]
        found = {}
        for scale in (2.0**-300, 1.0, 2.0**300):
            out = self.triangulate(self.cloud([(x * scale, y * scale, z) for x, y, z in rows]), "7")
            for method in ("natural", "laplace"):
                raster, _ = self.dem(out, method, "--res", repr(0.5 * scale))
                found.setdefault(method, []).append(raster)
        for rasters in found.values():
            for other in rasters:
                np.testing.assert_allclose(rasters[2], other, rtol=0, atol=1e-9)

    def test_wrong_orders_get_a_sentence_and_leave_nothing(self):
        out = self.triangulate(self.cloud(self.points("uniform")), "2")
        before = sorted(os.listdir(self.folder))
        self.refused(USAGE, "dem", out, "--res", "1", "-o", "a.tif", "--method", "cubic", says="'cubic' is not a method")
        self.refused(USAGE, "dem", out, "--res", "1", "-o", "a.tif", "--method", "natural", "--value", "heat", says="heat")
        for tile in sorted((out / "tiles").glob("*.vtu")):
            damaged = bytearray(tile.read_bytes())
            damaged[len(damaged) // 2] ^= 1
            tile.write_bytes(damaged)
        self.refused(CORRUPT, "dem", out, "--res", "1", "-o", "a.tif", "--method", "natural", says=".vtu")
        self.assertEqual(sorted(os.listdir(self.folder)), before)


if __name__ == "__main__":
    unittest.main()
