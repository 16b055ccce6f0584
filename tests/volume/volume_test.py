"""tessera volume: cut and fill are those of exact fractions, and have the same bytes for all tiles and threads."""
import csv
import io
import json
import math
import pathlib
import unittest

import numpy as np
from cli import BAD_INPUT, IO, USAGE, CliTest
from exact import surface_of, volumes
from osgeo import gdal, ogr, osr

gdal.UseExceptions()
CLOUDS = pathlib.Path(__file__).resolve().parent.parent / "data" / "clouds"
VOLUMES, AREAS = ("cut", "fill", "net"), ("area", "covered", "uncovered", "uncovered_by_a", "uncovered_by_b")


def lattice(side, step=1.0, corner=(0.0, 0.0), height=lambda x, y: 0 * x):
    x, y = np.meshgrid(corner[0] + np.arange(side) * step, corner[1] + np.arange(side) * step)
    return np.column_stack([x.ravel(), y.ravel(), height(x, y).ravel()])


def rough(side, step=1.0, corner=(0.0, 0.0), seed=1):
    rng = np.random.default_rng(seed)
    return lattice(side, step, corner, lambda x, y: rng.integers(-3, 4, x.shape).astype(float))


def scattered(n, seed, low=0.0, high=6.0):
    rng = np.random.default_rng(seed)
    return np.column_stack([rng.uniform(low, high, (n, 2)), rng.normal(size=n)])


SQUARE = [[(1.5, 1.5), (4.5, 1.5), (4.5, 4.5), (1.5, 4.5), (1.5, 1.5)]]
ON_LATTICE = [[(1, 1), (4, 1), (5, 5), (1, 4), (1, 1)], [(2, 2), (2, 3), (3, 3), (3, 2), (2, 2)]]
PARTLY_OUTSIDE = [[(-2, 3), (3, -2), (9, 4), (3, 2.5), (-2, 3)]]


class Volume(CliTest):
    def result(self, points, name, *options):
        """A result of these points, of which each has its height."""
        file = self.folder / (name + ".npy")
        np.save(file, np.asarray(points, float))
        self.ok("triangulate", file, "-o", self.folder / name, "--dim", 2, "--quiet", "--overwrite", *options)
        return self.folder / name

    def polygons(self, shapes, name="shapes.geojson", heights=None):
        """A GeoJSON file with a feature for each list of rings."""
        lift = lambda ring: [[*p[:2], *([float(heights(*p[:2]))] if heights else [])] for p in ring]
        features = [{"type": "Feature", "properties": {"name": f"shape {i}"},
                     "geometry": {"type": "Polygon", "coordinates": [lift(ring) for ring in rings]}}
                    for i, rings in enumerate(shapes)]
        return self.write(name, json.dumps({"type": "FeatureCollection", "features": features}))

    def rows(self, *args):
        return json.loads(self.ok("volume", *args, "--json").splitlines()[-1])["rows"]

    def check(self, row, right):
        """Equal to 1e-12 of cut + fill, or of the area."""
        scale = float(right["cut"] + right["fill"])
        for name in VOLUMES:
            self.assertLessEqual(abs(row[name] - float(right[name])), 1e-12 * scale, (name, row, float(right[name])))
        for name in AREAS:
            self.assertLessEqual(abs(row[name] - float(right[name])), 2e-12 * float(right["area"]),
                                 (name, row, float(right[name])))
        if right["covered"]:
            self.assertLessEqual(abs(row["mean"] - float(right["net"] / right["covered"])),
                                 1e-11 * scale / float(right["covered"]))
        else:
            self.assertIsNone(row["mean"])

    def test_pairs_of_surfaces_are_those_of_fractions(self):
        slope = lambda x, y: 2 * x - y / 2 + 1
        cases = {
            "same lattice": (rough(6), rough(6, seed=2)),
            "half a step apart": (rough(6), rough(6, corner=(.5, .5), seed=3)),
            "a vertex in each second vertex": (rough(7), rough(4, step=2.0, seed=4)),
            "edges in one line": (rough(6), rough(6, corner=(.5, 0), seed=5)),
            "side by side": (rough(4), rough(4, corner=(3.0, 0), seed=6)),
            "far from each other": (rough(4), rough(4, corner=(30.0, 0), seed=6)),
            "one plane in two lattices": (lattice(6, height=slope), lattice(5, 1.3, (.2, .1), slope)),
            "scattered": (scattered(60, 7), scattered(50, 8)),
            "scattered on a lattice": (scattered(60, 9), rough(6, seed=10)),
            "a far outlier": (np.vstack([scattered(40, 11), [[1e6, 3, 5]]]), scattered(40, 12)),
            "slivers": (np.vstack([scattered(30, 13), [[3, -1e-7, 2], [3.3, -2e-7, 1]]]), scattered(30, 14)),
            "on a circle": (np.array([[3 + 2.5 * math.cos(t), 3 + 2.5 * math.sin(t), t] for t in np.arange(0, 6.2, .3)]),
                            rough(6, seed=15)),
        }
        for name, (a, b) in cases.items():
            with self.subTest(case=name):
                one, other = self.result(a, "one"), self.result(b, "other")
                row = self.rows(one, other)[0]
                right = volumes(surface_of(one), surface_of(other))
                self.check(row, right)
                back = self.rows(other, one)[0]
                self.assertAlmostEqual(back["cut"], row["fill"], delta=1e-12 * (row["cut"] + row["fill"]))

    def test_a_surface_and_itself_have_nothing_between_them(self):
        for points in rough(7), scattered(200, 1), scattered(100, 2) * [1e6, 1e6, 1e-3]:
            one = self.result(points, "one")
            same = self.result(points, "same", "--tiles", 5)
            row = self.rows(one, same)[0]
            self.assertEqual([row[k] for k in ("cut", "fill", "net", "mean", "uncovered")], [0, 0, 0, 0, 0])
            self.assertEqual(row["area"], row["covered"])

    def test_coplanar_surfaces_have_nothing_between_them(self):
        slope = lambda x, y: x - 3 * y + 2
        row = self.rows(self.result(lattice(7, height=slope), "one"), self.result(lattice(9, .75, (.25, .5), slope), "other"))[0]
        self.assertEqual((row["cut"], row["fill"]), (0, 0))
        self.assertAlmostEqual(row["covered"], 5.75 * 5.5, delta=1e-12)

    def test_a_raised_surface_is_area_times_height_away(self):
        points = np.column_stack([np.random.default_rng(3).integers(0, 1000, (400, 2)) / 8,
                                  np.random.default_rng(4).integers(0, 64, 400) / 4])
        one = self.result(points, "one")
        other = self.result(points + [0, 0, 1], "other")
        row = self.rows(other, one)[0]
        self.assertAlmostEqual(row["cut"] / row["area"], 1, delta=1e-14)
        self.assertEqual((row["fill"], row["uncovered"]), (0, 0))
        self.assertEqual(self.rows(one, other)[0]["fill"], row["cut"])

    def test_known_solids_over_a_plane(self):
        pyramid = self.result([[0, 0, 0], [4, 0, 0], [4, 4, 0], [0, 4, 0], [2, 2, 3]], "pyramid")
        row = self.rows(pyramid, "--plane", 0)[0]
        self.assertEqual((row["cut"], row["fill"], row["area"], row["uncovered"]), (16, 0, 16, 0))
        row = self.rows(pyramid, "--plane", 3)[0]
        self.assertEqual((row["cut"], row["fill"], row["net"]), (0, 32, -32))
        row = self.rows(pyramid, "--plane", 1.5)[0]
        self.assertEqual((row["cut"], row["fill"]), (2, 10))  # an eighth of the pyramid, and 24 - 16 + 2
        n = 360
        rim = [[math.cos(2 * math.pi * k / n), math.sin(2 * math.pi * k / n), 0] for k in range(n)]
        cone = self.result(rim + [[0, 0, 1]], "cone")
        self.assertAlmostEqual(self.rows(cone, "--plane", 0)[0]["cut"], n / 6 * math.sin(2 * math.pi / n), delta=1e-14)

    def test_planes_are_those_of_fractions(self):
        for points in rough(6), scattered(80, 21):
            one = self.result(points, "one")
            for level in -0.5, 0, 1:
                with self.subTest(level=level):
                    self.check(self.rows(one, "--plane", level)[0], volumes(surface_of(one), level))

    def test_polygons_are_those_of_fractions(self):
        shapes = [SQUARE, ON_LATTICE, PARTLY_OUTSIDE, [[(20, 20), (21, 20), (20, 21), (20, 20)]]]
        file = self.polygons(shapes)
        for a, b in (rough(6), rough(6, corner=(.5, .5), seed=3)), (scattered(50, 31), rough(6, seed=32)):
            one, other = self.result(a, "one"), self.result(b, "other")
            for lower, right in (([other], surface_of(other)), (["--plane", 0.25], 0.25)):
                rows = self.rows(one, *lower, "--within", file)
                self.assertEqual([row["name"] for row in rows], [f"shape {i}" for i in range(len(shapes))])
                for row, rings in zip(rows, shapes):
                    self.check(row, volumes(surface_of(one), right, rings))

    def test_a_base_is_spanned_by_the_rim(self):
        heap = lattice(9, height=lambda x, y: np.maximum(0, 3 - np.hypot(x - 4, y - 4)) + .1 * x)
        rim = [[(1, 1), (7, 1), (7, 7), (1, 7), (1, 1)]]
        base = self.polygons([rim], heights=lambda x, y: .1 * x)
        one = self.result(heap, "one")
        row = self.rows(one, "--base", base)[0]
        # The base is a plane here; so it is also a surface of two triangles.
        plane = self.result(lattice(2, 6.0, (1.0, 1.0), lambda x, y: .1 * x), "plane")
        right = self.rows(one, plane, "--within", base)[0]
        for name in VOLUMES + AREAS:
            self.assertAlmostEqual(row[name], right[name], delta=1e-12 * (right["area"] + right["cut"]))
        self.assertEqual(row["uncovered"], 0)
        self.assertGreater(row["cut"], 25)

    def test_bytes_are_the_same_for_all_tiles_kinds_and_threads(self):
        shapes = self.polygons([SQUARE, ON_LATTICE, PARTLY_OUTSIDE])
        clouds = [(rough(16, .4, seed=41), rough(16, .4, (.2, .2), 42)), (scattered(1500, 43), scattered(1200, 44))]
        for a, b in clouds:
            seen = set()
            for tiles, kind, threads, memory in ((1, "cells", 1, "1G"), (7, "points", 4, "1G"), (60, "cells", 3, "8M"),
                                                 (60, "points", 2, "1G"), (7, "cells", 2, "8M")):
                one = self.result(a, "one", "--tiles", tiles, "--store", kind)
                other = self.result(b, "other", "--tiles", tiles + 5, "--store", kind)
                said = ""
                for more in (), ("--within", shapes), ("--max-edge", ".6"):
                    self.ok("volume", one, other, *more, "-o", "t.csv", "--overwrite", "--threads", threads,
                            "--memory", memory)
                    said += (self.folder / "t.csv").read_text()
                said += self.ok("volume", one, "--plane", ".25", "--within", shapes, "--threads", threads)
                seen.add(said)
            self.assertEqual(len(seen), 1)

    def test_long_edges_are_holes(self):
        points = np.vstack([rough(5), rough(5, corner=(10.0, 0), seed=2)])
        one = self.result(points, "one")
        row = self.rows(one, self.result(lattice(16, height=lambda x, y: 0 * x - 5), "other"), "--max-edge", 2)[0]
        self.assertEqual((row["covered"], row["uncovered_by_a"], row["uncovered_by_b"]), (32, 225 - 32, 0))
        self.assertIn("cells with longer edges are left out",
                      self.run_tessera("volume", one, "--plane", 0, "--max-edge", 2).stderr)

    def test_heights_that_are_not_numbers_are_holes(self):
        self.write("holes.csv", "x,y,z\n" + "".join(f"{x},{y},{'nan' if (x, y) == (2, 2) else 1}\n" for x in range(5) for y in range(5)))
        done = self.run_tessera("volume", "holes.csv", "--plane", 0)
        if done.returncode == 0:
            self.assertRegex(done.stdout, r"cut +1[0-9]\b")
            self.assertIn("without a height", done.stderr)
        else:  # refused as a point that is not finite
            self.assertEqual(done.returncode, BAD_INPUT)

    def test_tables_say_the_same_in_every_format(self):
        one, other = self.result(rough(6), "one", "--crs", "EPSG:2154"), self.result(rough(6, seed=2), "other", "--crs", "EPSG:2154")
        shapes = self.polygons([SQUARE, [[(20, 20), (21, 20), (20, 21), (20, 20)]]])
        rows = self.rows(one, other, "--within", shapes)
        for name in "t.csv", "t.json", "t.gpkg":
            self.assertIn(f"{name}: 2 polygons", self.ok("volume", one, other, "--within", shapes, "-o", name))
            self.refused(USAGE, "volume", one, other, "--within", shapes, "-o", name, says="exists already")
        table = list(csv.DictReader(io.StringIO((self.folder / "t.csv").read_text())))
        self.assertEqual([{k: float(line[k] or "nan") for k in VOLUMES + AREAS} for line in table],
                         [{k: row[k] for k in VOLUMES + AREAS} for row in rows])
        self.assertEqual([line["mean"] == "" for line in table], [False, True])
        self.assertEqual(json.loads((self.folder / "t.json").read_text())["rows"], rows)
        self.assertEqual(json.loads((self.folder / "t.json").read_text())["area_unit"], "metre^2")
        data = ogr.Open(str(self.folder / "t.gpkg"))
        layer = data.GetLayer(0)
        self.assertEqual(layer.GetSpatialRef().GetAuthorityCode(None), "2154")
        found = [{k: feature.GetField(k) for k in rows[0]} for feature in layer]
        self.assertEqual(found, rows)
        layer.ResetReading()
        feature = layer.GetNextFeature()  # which has its geometry only while it exists itself
        self.assertEqual(feature.GetGeometryRef().Area(), 9)
        feature = layer = data = None
        said = self.ok("volume", one, other)
        self.assertIn("where A lies above B: material to take away to come from A to B", said)
        self.assertRegex(said, r"cut +[0-9.]+ metre\^3")

    def test_formats_of_polygons_give_the_same(self):
        one = self.result(rough(6), "one", "--crs", "EPSG:2154")
        right = self.rows(one, "--plane", 0, "--within", self.polygons([ON_LATTICE, SQUARE]))
        reference = osr.SpatialReference()
        reference.ImportFromEPSG(2154)
        for driver, ending in ("GPKG", "gpkg"), ("FlatGeobuf", "fgb"), ("ESRI Shapefile", "shp"):
            path = str(self.folder / ("shapes." + ending))
            data = ogr.GetDriverByName(driver).CreateDataSource(path)
            layer = data.CreateLayer("shapes", reference, ogr.wkbPolygon, *([["SPATIAL_INDEX=NO"]] if ending == "fgb" else []))
            layer.CreateField(ogr.FieldDefn("name", ogr.OFTString))
            for i, rings in enumerate([ON_LATTICE, SQUARE]):
                feature = ogr.Feature(layer.GetLayerDefn())
                feature.SetField("name", f"shape {i}")
                feature.SetGeometry(ogr.CreateGeometryFromJson(json.dumps({"type": "Polygon", "coordinates": rings})))
                layer.CreateFeature(feature)
            feature = layer = data = None
            with self.subTest(driver=driver):
                rows = self.rows(one, "--plane", 0, "--within", path)
                for row, other in zip(rows, right, strict=True):
                    self.assertEqual(row["name"], other["name"])
                    for key in VOLUMES + AREAS:
                        self.assertAlmostEqual(row[key], other[key], delta=1e-12 * (other["area"] + other["cut"]))

    def test_the_raster_is_the_difference_of_two_rasters(self):
        one, other = self.result(scattered(300, 51), "one"), self.result(scattered(300, 52, 2, 9), "other")
        drawn = {}
        self.ok("volume", one, other, "--difference", "d.tif", "--res", ".05")
        box = "2,2,6,6"
        for name in "one", "other":
            self.ok("dem", self.folder / name, "--res", ".05", "--type", "float64", "--bbox", box, "-o", name + ".tif")
        read = lambda name: (gdal.Open(str(self.folder / name)).ReadAsArray(),
                             gdal.Open(str(self.folder / name)).GetGeoTransform())
        (a, at), (b, bt), (d, dt) = read("one.tif"), read("other.tif"), read("d.tif")
        x, y = round((dt[0] - at[0]) / .05), round((at[3] - dt[3]) / .05)
        crop = lambda values: values[y:y + d.shape[0], x:x + d.shape[1]]
        np.testing.assert_array_equal(d, (crop(a) - crop(b)).astype(np.float32))
        self.assertGreater(np.isfinite(d).sum(), 1000)
        self.assertGreater(np.isnan(d).sum(), 0)
        self.ok("volume", one, "--plane", 2, "--difference", "p.tif", "--res", ".05")
        p, pt = read("p.tif")
        self.ok("dem", one, "--res", ".05", "--type", "float64", "-o", "whole.tif")
        np.testing.assert_array_equal(p, (read("whole.tif")[0] - 2).astype(np.float32))
        base = self.polygons([SQUARE], heights=lambda x, y: x + y)
        self.ok("volume", one, "--base", base, "--difference", "b.tif", "--res", ".05")
        values, vt = read("b.tif")
        self.assertEqual(np.isfinite(values).sum(), 3600)
        rows, columns = np.indices(values.shape)
        x, y = vt[0] + (columns + .5) * .05, vt[3] - (rows + .5) * .05
        whole, wt = read("whole.tif")
        i, j = np.rint((wt[3] - y) / .05 - .5).astype(int), np.rint((x - wt[0]) / .05 - .5).astype(int)
        np.testing.assert_allclose(values, (whole[i, j] - x - y).astype(np.float32), atol=1e-5)

    def test_real_clouds_in_one_step(self):
        names = sorted((CLOUDS.parent.parent.parent / "data" / "ign").glob("*.la[sz]"))[:1] or [CLOUDS / "pdal_mvk_thin.las"]
        for name in [CLOUDS / "pdal_mvk_thin.las", *names]:
            with self.subTest(cloud=name.name):
                self.ok("triangulate", name, "--dim", 2, "--class", 2, "-o", "ground", "--overwrite", "--quiet", "--tiles", 6)
                self.ok("triangulate", name, "--dim", 2, "-o", "all", "--overwrite", "--quiet", "--tiles", 9, "--store", "points")
                row = self.rows("ground", "all")[0]
                one_step = self.rows(name, "all", "--class", "2")[0]
                self.assertEqual(one_step, row)
                # The net volume is the difference of the volumes over a plane, in a polygon that both cover.
                bounds = json.loads((self.folder / "ground" / "manifest.json").read_text())["bounds"]
                low, high = np.array(bounds["lo"][:2] if isinstance(bounds, dict) else bounds[0][:2]), np.array(
                    bounds["hi"][:2] if isinstance(bounds, dict) else bounds[1][:2])
                middle, half = (low + high) / 2, (high - low) / 8
                ring = [tuple(middle + half * [dx, dy]) for dx, dy in ((-1, -1), (1, -1), (1.1, 1), (-1, .9), (-1, -1))]
                file = self.polygons([[ring]])
                crs = json.loads((self.folder / "ground" / "manifest.json").read_text()).get("crs", "")
                both = self.rows("ground", "all", "--within", file)[0]
                a, b = (self.rows(surface, "--plane", 10, "--within", file)[0] for surface in ("ground", "all"))
                self.assertEqual(both["uncovered"], 0, crs)
                scale = max(abs(a["net"]), abs(b["net"]), both["cut"] + both["fill"])
                self.assertAlmostEqual(both["net"], a["net"] - b["net"], delta=1e-11 * scale)
                same = self.rows("all", "all")[0]
                self.assertEqual((same["cut"], same["fill"], same["uncovered"]), (0, 0, 0))

    def test_wrong_input_is_refused_in_a_sentence(self):
        one = self.result(rough(6), "one", "--crs", "EPSG:2154")
        other = self.result(rough(6), "other", "--crs", "EPSG:25832")
        self.refused(USAGE, "volume", says="no surface is given")
        self.refused(USAGE, "volume", one, says="give one thing to compare with")
        self.refused(USAGE, "volume", one, one, "--plane", 1, says="give one thing to compare with")
        self.refused(USAGE, "volume", one, "--plane", "nan", says="--plane")
        self.refused(USAGE, "volume", one, "--plane", "1e999", says="--plane")
        self.refused(USAGE, "volume", one, "--plane", 1, "--max-edge", -1, says="--max-edge")
        self.refused(USAGE, "volume", one, "--plane", 1, "--name", "x", says="--name names polygons")
        self.refused(USAGE, "volume", one, "--plane", 1, "-o", "t.txt", says="t.txt: is not a name of a table")
        self.refused(USAGE, "volume", one, "--plane", 1, "-o", "t.gpkg", says="a GeoPackage holds polygons")
        self.refused(USAGE, "volume", one, "--plane", 1, "--difference", "t.tif", says="--res")
        self.refused(USAGE, "volume", one, "--plane", 1, "--res", 1, says="--difference")
        self.refused(BAD_INPUT, "volume", one, other, says=["other", "volumes need one coordinate system"])
        self.refused(IO, "volume", one, "nowhere", says="nowhere")
        self.ok("triangulate", self.xyz(n=50), "-o", "solid", "--dim", 3, "--quiet")
        self.refused(USAGE, "volume", "solid", "--plane", 1, says="is a 3D result")
        plane = ["volume", one, "--plane", 1]
        bow = self.polygons([[[(0, 0), (4, 4), (4, 0), (0, 4), (0, 0)]]], "bow.geojson")
        self.refused(BAD_INPUT, *plane, "--within", bow, says=["bow.geojson: feature 0 is not valid", "elf-intersection"])
        flat = self.polygons([[[(0, 0), (4, 4), (2, 2), (0, 0)]]], "flat.geojson")
        self.refused(BAD_INPUT, *plane, "--within", flat, says="flat.geojson: feature 0")
        line = self.write("line.geojson", json.dumps({"type": "LineString", "coordinates": [[0, 0], [1, 1]]}))
        self.refused(BAD_INPUT, *plane, "--within", line, says="line.geojson: feature 0 is a LINESTRING, not a polygon")
        self.refused(BAD_INPUT, *plane, "--within", self.write("x.geojson", "no json"), says="x.geojson: is not JSON")
        # GDAL would fetch such a system, also one of a geometry, whatever the case of the member's name.
        for member in '"crs": {"type": "link", "properties": {"href": "http://127.0.0.1:9/x"}}', '"CRS": {"properties": {}, "Type": "URL"}':
            polygon = '{"type": "Polygon", %s, "coordinates": [[[0, 0], [1, 0], [1, 1], [0, 0]]]}' % member
            self.refused(BAD_INPUT, *plane, "--within", self.write("link.geojson", polygon), says=["link.geojson", "as a link"])
        empty = self.write("empty.geojson", json.dumps({"type": "FeatureCollection", "features": []}))
        self.refused(BAD_INPUT, *plane, "--within", empty, says="empty.geojson")
        self.refused(IO, *plane, "--within", "none.gpkg", says="none.gpkg")
        square = self.polygons([SQUARE])
        self.refused(BAD_INPUT, "volume", one, "--base", square, says="has no heights")
        self.refused(USAGE, "volume", one, "--base", square, "--within", square, says="--within cannot be given")
        self.refused(USAGE, *plane, "--within", square, "--name", "nothing", says=["--name", "they have name"])
        reference = osr.SpatialReference()
        reference.ImportFromEPSG(25832)
        data = ogr.GetDriverByName("GPKG").CreateDataSource(str(self.folder / "utm.gpkg"))
        layer = data.CreateLayer("shapes", reference, ogr.wkbPolygon)
        feature = ogr.Feature(layer.GetLayerDefn())
        feature.SetGeometry(ogr.CreateGeometryFromJson(json.dumps({"type": "Polygon", "coordinates": SQUARE})))
        layer.CreateFeature(feature)
        feature = layer = data = None
        self.refused(BAD_INPUT, *plane, "--within", "utm.gpkg", says=["utm.gpkg", "coordinates are those of"])
        left = [name for name in self.files() if name.endswith((".csv", ".tif", ".parts", ".result"))]
        self.assertEqual(left, [])


if __name__ == "__main__":
    unittest.main()
