"""tessera dem: which cell has a pixel, its value, and the file, against exact arithmetic, SciPy and GDAL."""
import math
import os
import pathlib
import random
import subprocess
import unittest
from fractions import Fraction

import numpy as np
from cli import CORRUPT, IO, USAGE, CliTest
from osgeo import gdal, osr
from scipy.interpolate import LinearNDInterpolator
from scipy.spatial import Delaunay
from stored import Stored

gdal.UseExceptions()
TILINGS = (("1",), ("7",), ("64",), ("9", "--partition", "random"))


def exact(number):
    return Fraction(float(number))


def has(corners, x, y):
    """Whether a counterclockwise cell has the point once that is moved to the right, and up by much less."""
    for (ax, ay), (bx, by) in zip(corners, corners[1:] + corners[:1]):
        side = (bx - ax) * (y - ay) - (by - ay) * (x - ax)
        if side < 0 or (side == 0 and not (-(by - ay), bx - ax) > (0, 0)):
            return False
    return True


def drawn(stored, res, column0, row_top, width, height, max_edge=math.inf):
    """The raster as fractions say, and how many cells have each pixel."""
    values, count = np.full((height, width), np.nan), np.zeros((height, width), int)
    xs = [exact((column0 + i + 0.5) * res) for i in range(width)]
    ys = [exact((row_top - 1 - j + 0.5) * res) for j in range(height)]
    for cell in stored.cells:
        p = [tuple(map(exact, stored.points[v])) for v in cell]
        (ax, ay, az), (bx, by, bz), (cx, cy, cz) = p
        double = (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)
        if max(math.hypot(*(float(u - v) for u, v in zip(a[:2], b[:2]))) for a, b in zip(p, p[1:] + p[:1])) > max_edge:
            continue
        for i, x in enumerate(xs):
            if not min(ax, bx, cx) <= x <= max(ax, bx, cx):
                continue
            for j, y in enumerate(ys):
                if has([c[:2] for c in p], x, y):
                    count[j, i] += 1
                    b = ((x - ax) * (cy - ay) - (y - ay) * (cx - ax)) / double
                    c = ((bx - ax) * (y - ay) - (by - ay) * (x - ax)) / double
                    values[j, i] = float(az + b * (bz - az) + c * (cz - az))
    return values, count


class Dem(CliTest):
    def cloud(self, kind, n=300):
        dice = random.Random(7)
        if kind == "lattice":  # centres of pixels are on vertices and edges
            rows = [(x / 2, y / 2, dice.randrange(9)) for x in range(13) for y in range(9)]
        elif kind == "diagonals":
            rows = [(x + y, x - y, dice.random()) for x in range(9) for y in range(9)]
        elif kind == "far":
            rows = [(885000 + dice.randrange(4000) / 100, 6290000 + dice.randrange(4000) / 100, dice.random() * 50) for _ in range(n)]
        elif kind == "thin":
            rows = [(i * 0.37, (i * i % 7) * 2.0**-40 + (5 if i % 2 else 0), dice.random()) for i in range(60)]
        else:
            rows = [(dice.uniform(-9, 9), dice.uniform(-6, 6), dice.random()) for _ in range(n)]
        return self.write(kind + ".csv", "x,y,z\n" + "".join(f"{x!r},{y!r},{z!r}\n" for x, y, z in rows))

    def triangulate(self, cloud, *tiles):
        out = self.folder / ("out" + "-".join(tiles))
        self.ok("triangulate", cloud, "--dim", "2", "--tiles", *tiles, "-o", out, "--quiet", "--overwrite")
        return out

    def dem(self, out, name="dem.tif", *options, res="0.25"):
        self.ok("dem", out, "--res", res, "-o", name, "--overwrite", "--quiet", *options)
        return gdal.Open(str(self.folder / name))

    def test_each_pixel_is_the_exact_cells_for_every_tiling(self):
        for kind, res in (("lattice", "0.25"), ("lattice", "0.5"), ("lattice", "1"), ("diagonals", "0.5"), ("far", "0.7"),
                          ("thin", "0.4"), ("uniform", "0.3")):
            cloud = self.cloud(kind)
            rasters = []
            for tiles in TILINGS:
                out = self.triangulate(cloud, *tiles)
                file = self.dem(out, "dem.tif", "--type", "float64", "--threads", str(len(rasters) + 1), res=res)
                rasters.append(file.ReadAsArray())
            left, width, _, top, _, height = file.GetGeoTransform()
            self.assertEqual((width, height), (float(res), -float(res)))
            right, count = drawn(Stored(out), float(res), round(left / width), round(top / width), file.RasterXSize, file.RasterYSize)
            with self.subTest(kind=kind, res=res):
                self.assertLessEqual(count.max(), 1)
                self.assertGreater(count.sum(), 20)
                np.testing.assert_array_equal(np.isnan(rasters[0]), count == 0)
                np.testing.assert_allclose(rasters[0], right, rtol=0, atol=1e-9)
                for other in rasters[1:]:
                    np.testing.assert_array_equal(rasters[0].view("u8"), other.view("u8"))

    def test_long_cells_have_no_pixels(self):
        out = self.triangulate(self.cloud("uniform"), "7")
        file = self.dem(out, "dem.tif", "--type", "float64", "--max-edge", "1.25", res="0.3")
        left, width, _, top, _, _ = file.GetGeoTransform()
        right, _ = drawn(Stored(out), 0.3, round(left / width), round(top / width), file.RasterXSize, file.RasterYSize, 1.25)
        self.assertTrue(20 < np.isnan(right).sum() < right.size - 20)
        np.testing.assert_allclose(file.ReadAsArray(), right, rtol=0, atol=1e-9)

    def test_a_plane_stays_one(self):
        dice = random.Random(3)
        rows = [(dice.uniform(0, 50), dice.uniform(0, 30)) for _ in range(2000)]
        cloud = self.write("plane.csv", "x,y,z\n" + "".join(f"{x!r},{y!r},{3 + 0.5 * x - 2 * y!r}\n" for x, y in rows))
        file = self.dem(self.triangulate(cloud, "7"), "dem.tif", "--type", "float64")
        raster, (left, res, _, top, _, _) = file.ReadAsArray(), file.GetGeoTransform()
        x = left + (np.arange(raster.shape[1]) + 0.5) * res
        y = top - (np.arange(raster.shape[0]) + 0.5) * res
        there = ~np.isnan(raster)
        self.assertGreater(there.mean(), 0.9)
        error = np.abs(raster - (3 + 0.5 * x[None, :] - 2 * y[:, None]))[there]
        self.assertLess(error.max(), 1e-10)

    def test_scipy_and_gdal_find_the_same_heights(self):
        dice = random.Random(5)
        points = np.array([(dice.uniform(0, 40), dice.uniform(0, 40), dice.random()) for _ in range(3000)])
        cloud = self.write("p.csv", "x,y,z\n" + "".join("%r,%r,%r\n" % tuple(map(float, p)) for p in points))
        file = self.dem(self.triangulate(cloud, "7"), "dem.tif", "--type", "float64")
        raster, (left, res, _, top, _, _) = file.ReadAsArray(), file.GetGeoTransform()
        height, width = raster.shape
        x, y = left + (np.arange(width) + 0.5) * res, top - (np.arange(height) + 0.5) * res
        right = LinearNDInterpolator(Delaunay(points[:, :2]), points[:, 2])(*np.meshgrid(x, y))
        np.testing.assert_array_equal(np.isnan(raster), np.isnan(right))
        np.testing.assert_allclose(raster, right, rtol=0, atol=1e-9)
        vrt = self.write("p.vrt", '<OGRVRTDataSource><OGRVRTLayer name="p"><SrcDataSource relativeToVRT="1">p.csv</SrcDataSource><GeometryType>wkbPoint25D</GeometryType>'
                         '<GeometryField encoding="PointFromColumns" x="x" y="y" z="z"/></OGRVRTLayer></OGRVRTDataSource>')
        grid = gdal.Grid("", str(self.folder / vrt), format="MEM", outputType=gdal.GDT_Float64, width=width, height=height,
                         outputBounds=[left, top, left + width * res, top - height * res], algorithm="linear:radius=0:nodata=-1").ReadAsArray()
        both = ~np.isnan(raster) & (grid != -1)
        self.assertGreater(both.sum(), 0.99 * (~np.isnan(raster)).sum())
        np.testing.assert_allclose(raster[both], grid[both], rtol=0, atol=1e-6)

    def test_rasters_of_different_boxes_line_up(self):
        out = self.triangulate(self.cloud("uniform"), "7")
        whole = self.dem(out, res="0.3")
        left, res, _, top, _, _ = whole.GetGeoTransform()
        part = self.dem(out, "part.tif", "--bbox", "-2.05,-3,4.4,2.1", res="0.3")
        part_left, _, _, part_top, _, _ = part.GetGeoTransform()
        x, y = round((part_left - left) / res), round((top - part_top) / res)
        array = part.ReadAsArray()
        np.testing.assert_array_equal(whole.ReadAsArray()[y:y + array.shape[0], x:x + array.shape[1]].view("u4"), array.view("u4"))
        self.assertAlmostEqual(part_left, -2.1)

    def test_a_box_outside_of_the_surface_is_refused(self):
        out = self.triangulate(self.write("p.csv", "x,y,z\n1,1,0\n9,1,1\n1,9.5,2\n3,2,5\n"), "2")
        before = sorted(os.listdir(self.folder))
        for box in ("100,100,103,103", "2,10,3,11", "8,8,8.5,8.5"):  # the last one only of the hull
            self.refused(USAGE, "dem", out, "--res", "0.25", "--bbox", box, "-o", "a.tif",
                         says="--bbox: no cell meets it; the points of the result lie at x from 1 to 9, y from 1 to 9.5")
        self.assertEqual(sorted(os.listdir(self.folder)), before)
        self.assertFalse(np.isnan(self.dem(out, "a.tif", "--bbox", "1,1,2,2", res="0.25").ReadAsArray()).any())

    def test_a_box_needs_no_other_tiles(self):
        out = self.triangulate(self.cloud("uniform"), "64")
        box = ("--bbox", "-2.05,-3,0.4,-1")
        part = self.dem(out, "part.tif", *box, res="0.3").ReadAsArray()
        self.assertFalse(np.isnan(part).any())
        needless = 0
        for tile in sorted((out / "tiles").glob("*.vtu")):  # what is not read may be anything
            kept = tile.read_bytes()
            tile.write_bytes(b"nothing")
            if self.run_tessera("dem", out, "--res", "0.3", "-o", "a.tif", "--overwrite", *box).returncode == 0:
                np.testing.assert_array_equal(gdal.Open(str(self.folder / "a.tif")).ReadAsArray().view("u4"), part.view("u4"))
                needless += 1
            else:
                tile.write_bytes(kept)
        self.assertTrue(30 < needless < 64)

    def test_the_file_is_cloud_optimized_with_system_and_overviews(self):
        dice = random.Random(1)
        cloud = self.write("p.csv", "x,y,z,intensity\n" + "".join(
            f"{700000 + dice.uniform(0, 300)!r},{6600000 + dice.uniform(0, 200)!r},{dice.random()!r},{dice.randrange(99)}\n" for _ in range(5000)))
        self.ok("triangulate", cloud, "--dim", "2", "--crs", "EPSG:2154", "--attributes", "intensity", "--tiles", "7", "-o", self.out, "--quiet")
        file = self.dem(self.out)
        self.assertEqual(file.GetMetadataItem("LAYOUT", "IMAGE_STRUCTURE"), "COG")
        self.assertGreater(file.GetRasterBand(1).GetOverviewCount(), 0)
        self.assertTrue(math.isnan(file.GetRasterBand(1).GetNoDataValue()))
        self.assertEqual(file.GetRasterBand(1).DataType, gdal.GDT_Float32)
        right = osr.SpatialReference()
        right.ImportFromEPSG(2154)
        self.assertTrue(file.GetSpatialRef().IsSame(right))
        # Hardly any memory: blocks and GDAL's cache are emptied again and again.
        few = self.dem(self.out, "few.tif", "--memory", "1M")
        np.testing.assert_array_equal(file.ReadAsArray().view("u4"), few.ReadAsArray().view("u4"))
        intensity = self.dem(self.out, "i.tif", "--value", "intensity", res="1")
        self.assertTrue(0 < np.nanmax(intensity.ReadAsArray()) <= 98)
        self.assertEqual(intensity.GetRasterBand(1).GetDescription(), "intensity")

    def test_a_hillshade_is_gdaldems_for_every_tiling(self):
        shades = []
        for tiles in TILINGS:
            out = self.triangulate(self.cloud("uniform", 3000), *tiles)
            shades.append(self.dem(out, "shade.tif", "--hillshade", "--azimuth", "250.5", "--altitude", "30", "--max-edge", "1", res="0.05").ReadAsArray())
        self.dem(out, "dem.tif", "--max-edge", "1", res="0.05")
        subprocess.run(["gdaldem", "hillshade", "-q", "-compute_edges", "-az", "250.5", "-alt", "30", "dem.tif", "right.tif"], cwd=self.folder, check=True)
        right = gdal.Open(str(self.folder / "right.tif")).ReadAsArray()
        self.assertGreater(len(np.unique(right)), 50)
        self.assertTrue(0.01 < (right == 0).mean() < 0.5)
        for shade in shades:
            np.testing.assert_array_equal(shade, right)
        file = self.dem(out, "shade.tif", "--hillshade")
        self.assertEqual((file.GetRasterBand(1).DataType, file.GetRasterBand(1).GetNoDataValue()), (gdal.GDT_Byte, 0))
        self.assertEqual(file.GetMetadataItem("LAYOUT", "IMAGE_STRUCTURE"), "COG")
        self.refused(USAGE, "dem", out, "--res", "1", "-o", "b.tif", "--hillshade", "--type", "float64", says="bytes")
        self.refused(USAGE, "dem", out, "--res", "1", "-o", "b.tif", "--hillshade", "--altitude", "91", says="--altitude")
        self.refused(USAGE, "dem", out, "--res", "1", "-o", "b.tif", "--azimuth", "91", says="--hillshade")

    def test_wrong_orders_get_a_sentence_and_leave_nothing(self):
        out = self.triangulate(self.cloud("uniform"), "2")
        space = self.folder / "space"
        self.ok("triangulate", self.cloud("uniform"), "--dim", "3", "-o", space, "--quiet")
        self.write("flat.csv", "x,y\n0,0\n1,0\n0,1\n")
        flat = self.folder / "flat"
        self.ok("triangulate", "flat.csv", "-o", flat, "--quiet")
        (self.folder / "taken.tif").write_text("mine")
        before = sorted(os.listdir(self.folder))
        for status, says, order in (
                (USAGE, "3D result", [space, "--res", "1", "-o", "a.tif"]), (USAGE, "no heights", [flat, "--res", "1", "-o", "a.tif"]),
                (USAGE, "--res", [out, "-o", "a.tif"]), (USAGE, "--res", [out, "--res", "0", "-o", "a.tif"]),
                (USAGE, "--res", [out, "--res", "-1", "-o", "a.tif"]), (USAGE, "--res", [out, "--res", "1e-13", "-o", "a.tif"]),
                (USAGE, "too large", [out, "--res", "1e-7", "-o", "a.tif"]), (USAGE, "-o", [out, "--res", "1"]),
                (USAGE, ".tif", [out, "--res", "1", "-o", "a.png"]), (USAGE, "--overwrite", [out, "--res", "1", "-o", "taken.tif"]),
                (USAGE, "heat", [out, "--res", "1", "--value", "heat", "-o", "a.tif"]),
                (USAGE, "int8", [out, "--res", "1", "--type", "int8", "-o", "a.tif"]),
                (USAGE, "--bbox", [out, "--res", "1", "--bbox", "1,1,0,0", "-o", "a.tif"]),
                (IO, "none/a.tif", [out, "--res", "1", "-o", "none/a.tif"]), (IO, "manifest", [self.folder / "none", "--res", "1", "-o", "a.tif"])):
            with self.subTest(order=order):
                self.refused(status, "dem", *order, says=says)
        for tile in sorted((pathlib.Path(out) / "tiles").glob("*.vtu")):
            damaged = bytearray(tile.read_bytes())
            damaged[len(damaged) // 2] ^= 1
            tile.write_bytes(damaged)
        self.refused(CORRUPT, "dem", out, "--res", "1", "-o", "a.tif", says=".vtu")
        self.assertEqual(sorted(os.listdir(self.folder)), before)


if __name__ == "__main__":
    unittest.main()
