"""tessera voronoi in 2D: cells within the hull, against SciPy, GEOS and exact fractions; the same bytes for any tiling."""
import math
import unittest
from fractions import Fraction

import numpy as np
import scipy.spatial
from cells import VoronoiTest, clouds, hull_area, rings_of, turn
from cli import IO, USAGE
from osgeo import ogr


def centre(a, b, c):
    """The circumcentre, rounded once."""
    (ax, ay), (bx, by), (cx, cy) = [[Fraction(v) for v in p] for p in (a, b, c)]
    bx, by, cx, cy = bx - ax, by - ay, cx - ax, cy - ay
    d = 2 * (bx * cy - by * cx)
    bb, cc = bx * bx + by * by, cx * cx + cy * cy
    return float(ax + (bb * cy - cc * by) / d), float(ay + (cc * bx - bb * cx) / d)


class Planar(VoronoiTest):
    def test_cells_fill_the_hull_without_gap_or_overlap(self):
        for name, points in clouds().items():
            with self.subTest(cloud=name):
                said = self.write_cells(self.triangulate(points))
                cells = self.cells()
                unique = len({tuple(p) for p in points.tolist()})
                self.assertEqual(said["cells"], unique)
                self.assertEqual((said["thin"], said["shapeless"]), (0, 0))
                self.assertEqual(said["duplicates"], len(points) - unique)
                area = hull_area(points)
                border = self.assert_covers(cells, area)
                self.assertAlmostEqual(said["area"] / float(area), 1, delta=1e-9)
                # The border is one closed line.
                ends = {a: b for a, b in border}
                at, count = border[0][0], 0
                while count < len(border):
                    at, count = ends[at], count + 1
                self.assertEqual(at, border[0][0])

    def test_whole_cells_are_those_of_scipy(self):
        for name in "uniform", "map", "duplicates":
            points = np.unique(clouds()[name], axis=0)
            with self.subTest(cloud=name):
                said = self.write_cells(self.triangulate(points), "--clip", "none")
                origin, width = points.min(axis=0), np.ptp(points)
                diagram = scipy.spatial.Voronoi((points - origin) / width)
                hull = set(scipy.spatial.ConvexHull(points - origin).vertices.tolist())
                degree = np.diff(scipy.spatial.Delaunay((points - origin) / width).vertex_neighbor_vertices[0])
                self.assertEqual(said["unbounded"], len(hull))
                self.assertEqual(said["shapeless"], len(hull))
                for vertex, (geometry, row) in self.cells().items():
                    self.assertEqual(row["unbounded"], "1" if vertex in hull else "0")
                    self.assertEqual(int(row["neighbours"]), degree[vertex])
                    if vertex in hull:
                        self.assertTrue(geometry.IsEmpty())
                        self.assertEqual((row["area"], row["centroid_x"]), ("inf", ""))
                        continue
                    region = diagram.vertices[diagram.regions[diagram.point_region[vertex]]]
                    shape = scipy.spatial.ConvexHull(region)
                    np.testing.assert_allclose(float(row["area"]) / width**2, shape.volume, rtol=1e-6)
                    middle = geometry.Centroid()
                    for axis, value in ("centroid_x", middle.GetX()), ("centroid_y", middle.GetY()):
                        self.assertAlmostEqual(float(row[axis]), value, delta=1e-9 * max(1, abs(value)))

    def test_corners_are_circumcentres_rounded_once(self):
        for name in "uniform", "map", "far", "thin":
            points = clouds()[name][:200]
            with self.subTest(cloud=name):
                out = self.triangulate(points)
                self.ok("export", out, "-o", self.folder / "mesh.csv", "--overwrite")
                right = {centre(*points[[int(row["v0"]), int(row["v1"]), int(row["v2"])]])
                         for row in self.rows("mesh.csv")}
                self.write_cells(out, "--clip", "none")
                found = {p[:2] for geometry, _ in self.cells().values() for ring in rings_of(geometry) for p in ring}
                self.assertTrue(found)
                self.assertLessEqual(found, right)

    def test_a_corner_of_many_cells_is_one_point(self):
        points = np.concatenate([clouds()["cocircular"] * 8 + 1 / 8, [[1 / 8, 200], [300, -100], [-300, -100]]])
        self.write_cells(self.triangulate(points), "--clip", "none")
        met = [vertex for vertex, (geometry, _) in self.cells().items()
               for ring in rings_of(geometry) if (1 / 8, 1 / 8) in ring]
        self.assertEqual(sorted(met), list(range(12)))

    def test_the_same_bytes_for_any_tiles_and_threads(self):
        for name in "lattice", "map", "far", "blue mountains":
            points = clouds()[name]
            first = {}
            for options in ((), ("--tiles", "7"), ("--tiles", "7", "--store", "points"), ("--tiles", "60")):
                out = self.triangulate(points, *options)
                for clip in "hull", "none", "0.2,0.3,9.7,6.5":
                    if clip[0] == "0":
                        low, size = points.min(axis=0), np.ptp(points, axis=0)
                        clip = "%r,%r,%r,%r" % (*(low + size * 0.2).tolist(), *(low + size * 0.7).tolist())
                    for ending in "csv", "geojson":
                        with self.subTest(cloud=name, options=options, clip=clip, ending=ending):
                            self.write_cells(out, "--clip", clip, "--threads", 1 + 2 * len(options),
                                             name="cells." + ending)
                            text = (self.folder / ("cells." + ending)).read_bytes()
                            self.assertEqual(text, first.setdefault((clip, ending), text))

    def test_all_formats_have_the_same_cells_and_the_attributes_of_points(self):
        rng = np.random.default_rng(3)
        lines = ["x y z area flag"] + ["%r %r %r %r %d" % (*rng.random(3), i / 8, i % 3) for i in range(150)]
        self.write("cloud.xyz", "\n".join(lines) + "\n")
        self.ok("triangulate", self.folder / "cloud.xyz", "-o", self.out, "--dim", "2", "--columns", "x,y,z,area,flag",
                "--attributes", "all", "--crs", "EPSG:2154", "--quiet")
        self.write_cells(self.out)
        cells = self.cells()
        fields = list(cells[0][1])
        self.assertEqual(fields[:7], ["geom", "id", "area", "neighbours", "unbounded", "centroid_x", "centroid_y"])
        self.assertIn("area_", fields)
        for ending in "gpkg", "fgb", "geojson":
            self.write_cells(self.out, name="cells." + ending)
            data = ogr.Open(str(self.folder / ("cells." + ending)))
            layer = data.GetLayer(0)
            self.assertEqual(layer.GetFeatureCount(), len(cells))
            self.assertEqual(layer.GetSpatialRef().GetAuthorityCode(None), "2154")
            seen = []
            for feature in layer:
                geometry, row = cells[feature.GetField("id")]
                seen.append(feature.GetField("id"))
                self.assertEqual(rings_of(feature.GetGeometryRef()), rings_of(geometry))
                for field in fields[2:]:
                    self.assertEqual(float(feature.GetField(field)), float(row[field]), field)
            if ending != "fgb":  # in the order of its index
                self.assertEqual(seen, sorted(cells))
            self.assertEqual(sorted(seen), sorted(cells))
        self.assertEqual([p.name for p in self.folder.iterdir() if "cells" in p.name and p.name.count(".") > 1], [])

    def test_columns_of_measures_come_along(self):
        out = self.triangulate(clouds()["uniform"], "--tiles", "5")
        self.ok("measure", out, "--voronoi", "--quiet")
        self.write_cells(out, "--clip", "none")
        for row in self.rows():
            if row["unbounded"] == "0":
                self.assertAlmostEqual(float(row["voronoi_area"]) / float(row["area"]), 1, delta=1e-12)
                self.assertEqual(row["voronoi_neighbours"], row["neighbours"])

    def test_point_files_in_one_step(self):
        np.save(self.folder / "cloud.npy", clouds()["uniform"])
        self.write_cells(self.triangulate(clouds()["uniform"]), name="first.csv")
        self.ok("voronoi", self.folder / "cloud.npy", "-o", self.folder / "second.csv", "--quiet")
        self.assertEqual((self.folder / "first.csv").read_text(), (self.folder / "second.csv").read_text())

    def test_points_at_the_ends_of_doubles(self):
        for scale in 1e300, 1e-300, 5e-324:
            points = np.round(np.random.default_rng(2).random((40, 2)) * 64) * scale
            with self.subTest(scale=scale):
                self.write_cells(self.triangulate(points))
                for vertex, (geometry, _) in self.cells().items():
                    for ring in rings_of(geometry):
                        for a, b, c in zip(ring, ring[1:], ring[2:]):
                            self.assertGreaterEqual(turn(a[:2], b[:2], c[:2]), 0 if scale > 1e-320 else -math.inf)

    def test_wrong_input_is_refused(self):
        out = self.triangulate(clouds()["uniform"])
        target = self.folder / "cells.gpkg"
        self.refused(USAGE, "voronoi", says="no result folder")
        self.refused(USAGE, "voronoi", out, says="-o FILE.gpkg")
        self.refused(USAGE, "voronoi", out, "-o", self.folder / "cells.shp", says=".gpkg, .fgb, .geojson or .csv")
        self.refused(USAGE, "voronoi", out, "-o", target, "--clip", "1,1,1,2", says="no area")
        self.refused(USAGE, "voronoi", out, "-o", target, "--clip", "1,2,3", says="--clip")
        self.refused(USAGE, "voronoi", out, "-o", target, "--clip", "nan,0,1,1", says="--clip")
        self.refused(USAGE, "voronoi", out, "-o", target, "--clip", "land.svg", says=".geojson")
        self.assertFalse(target.exists())
        target.write_text("mine")
        self.refused(USAGE, "voronoi", out, "-o", target, says="exists already")
        self.assertEqual(target.read_text(), "mine")
        self.refused(IO, "voronoi", self.folder / "nothing", "-o", self.folder / "a.csv", says="nothing")
        self.refused(IO, "voronoi", out, "-o", self.folder / "no" / "a.csv", says="no")
        tile = next((out / "tiles").glob("*.vtu"))
        data = bytearray(tile.read_bytes())
        data[-200] ^= 1
        tile.write_bytes(data)
        done = self.run_tessera("voronoi", out, "-o", self.folder / "b.csv")
        self.assertNotEqual(done.returncode, 0)
        self.assertEqual([p.name for p in self.folder.iterdir() if p.name.startswith(("a.csv", "b.csv", ".b"))], [])


if __name__ == "__main__":
    unittest.main()
