"""tessera update: the result of a change is that of a triangulation from scratch."""
import json
import os
import shutil
import unittest

import numpy as np
from cli import BAD_INPUT, CORRUPT, IO, USAGE, CliTest


class Update(CliTest):
    def setUp(self):
        super().setUp()
        self.random = np.random.default_rng(7)

    def manifest(self, result):
        return json.loads((self.folder / result / "manifest.json").read_text())

    def save(self, name, points):
        np.save(self.folder / name, points)
        return name

    def update(self, *args):
        return json.loads(self.ok("update", *args, "--json").splitlines()[-1])

    def triangulate(self, points, out, *args):
        self.ok("triangulate", self.save(f"{out}.npy", points), "-o", out, "--quiet", *args)

    def expect_as_from_scratch(self, result, points, dim):
        """`points`: by source index, with NaN for points that were removed."""
        self.triangulate(points, "scratch", "--dim", dim, "--skip-invalid", "--overwrite")
        expected, got = self.manifest("scratch"), self.manifest(result)
        for key in ("digest2", "bounds"):
            self.assertEqual(got[key], expected[key], key)
        for key in ("vertices", "cells", "duplicates"):
            self.assertEqual(got["counts"][key], expected["counts"][key], key)
        self.ok("verify", result, "--quiet")

    def clouds(self, dim):
        yield "uniform", self.random.random((3000, dim))
        yield "lattice", self.random.integers(0, 30, (3000, dim)).astype(float)
        if dim == 3:
            terrain = self.random.random((3000, 3))
            terrain[:, 2] = np.round(np.sin(6 * terrain[:, 0]) * np.cos(5 * terrain[:, 1]), 2)
            yield "terrain", terrain

    def test_chains_of_changes_give_the_results_of_triangulations_from_scratch(self):
        for dim in (2, 3):
            for name, cloud in self.clouds(dim):
                many = ((1, "cells"), (7, "cells"), (60, "points")) if name == "lattice" else ((7, "points"),)
                for tiles, store in many:
                    with self.subTest(dim=dim, cloud=name, tiles=tiles, store=store):
                        self.chain(cloud, str(dim), str(tiles), store)

    def chain(self, cloud, dim, tiles, store):
        for name in ("r0", "r1", "r2", "r3"):
            shutil.rmtree(self.folder / name, ignore_errors=True)
        self.triangulate(cloud[:2000], "r0", "--dim", dim, "--tiles", tiles, "--store", store)
        told = self.update("r0", "--add", self.save("more.npy", cloud[2000:]), "-o", "r1")
        self.assertEqual((told["added"], told["first_new_id"]), (1000, 2000))
        self.expect_as_from_scratch("r1", cloud, dim)
        gone = np.unique(self.random.integers(0, 3000, 300))
        self.update("r1", "--remove-ids", self.save("ids.npy", gone), "-o", "r2", "--threads", "3")
        left = cloud.copy()
        left[gone] = np.nan
        self.expect_as_from_scratch("r2", left, dim)
        lo, hi = np.nanquantile(left, 0.3, axis=0)[:2], np.nanquantile(left, 0.5, axis=0)[:2]
        box = ",".join(repr(float(v)) for v in (*lo, *hi))
        self.update("r2", "--remove-box", box, "--add", self.save("again.npy", cloud[gone]), "-o", "r3")
        inside = ((left[:, :2] >= lo) & (left[:, :2] <= hi)).all(axis=1)
        left[inside] = np.nan
        self.expect_as_from_scratch("r3", np.concatenate([left, cloud[gone]]), dim)

    def test_a_class_is_removed_and_added_points_bring_their_attributes(self):
        def rows(count, first):
            out = np.zeros(count, [("x", "f8"), ("y", "f8"), ("z", "f8"), ("classification", "u1"), ("rank", "u4")])
            for axis in "xyz":
                out[axis] = self.random.random(count)
            out["classification"] = np.arange(first, first + count) % 5
            out["rank"] = np.arange(first, first + count)
            return out

        first, more = rows(1000, 0), rows(200, 1000)
        self.triangulate(first, "out", "--attributes", "classification,rank", "--tiles", "9")
        dry = self.update("out", "--remove-class", "1,3", "--dry-run")
        self.assertEqual((dry["event"], dry["removed"]), ("would_update", 400))
        told = self.update("out", "--remove-class", "1,3", "--add", self.save("more.npy", more), "-o", "next")
        self.assertEqual((told["removed"], told["vertices"]), (400, 800))
        self.ok("export", "next", "-o", "exported/", "--format", "npy")
        ranks = np.load(self.folder / "exported" / "rank.npy")
        both = np.concatenate([first, more])
        kept = (both["rank"] >= 1000) | ~np.isin(both["classification"], (1, 3))
        np.testing.assert_array_equal(np.sort(ranks), np.flatnonzero(kept))
        points = np.load(self.folder / "exported" / "points.npy")
        both = both[ranks]
        np.testing.assert_array_equal(points, np.stack([both[axis] for axis in "xyz"], axis=1))

    def rows(self, count, first, wide=6):
        """Points on few places of the plane, so that most have duplicates, with attributes of their own."""
        out = np.zeros(count, [("x", "f8"), ("y", "f8"), ("z", "f8"), ("classification", "u1"), ("gps_time", "f8"), ("rank", "u4")])
        out["x"], out["y"] = self.random.integers(0, wide, (2, count))
        out["z"] = self.random.integers(0, 4, count)
        out["classification"] = self.random.integers(0, 4, count)
        out["gps_time"] = self.random.integers(0, 100, count)
        out["rank"] = np.arange(first, first + count)
        return out

    ATTRIBUTES = ("--dim", "2", "--attributes", "classification,gps_time,rank")

    def vertices(self, result):
        """The attributes of the vertices, by rank."""
        self.ok("export", result, "-o", f"{result}-npy/", "--format", "npy", "--overwrite", "--quiet")
        arrays = [np.load(self.folder / f"{result}-npy" / f"{name}.npy") for name in ("rank", "classification", "gps_time")]
        return np.stack(arrays, axis=1)[np.argsort(arrays[0])]

    def expect_rows(self, result, rows, gone, *args):
        """As from scratch without the rows that are gone, attributes of vertices included."""
        left = rows.copy()
        left["x"][gone] = np.nan
        self.triangulate(left, "scratch", *self.ATTRIBUTES, "--skip-invalid", "--overwrite", *args)
        expected, got = self.manifest("scratch"), self.manifest(result)
        self.assertEqual(got["digest2"], expected["digest2"])
        self.assertEqual(got["counts"]["duplicates"], expected["counts"]["duplicates"])
        for name in ("duplicates.bin", "duplicate-rows.bin"):
            self.assertEqual(got["checksums"].get(name), expected["checksums"].get(name), name)
        np.testing.assert_array_equal(self.vertices(result), self.vertices("scratch"))
        self.ok("verify", result, "--quiet")

    def test_duplicates_are_chosen_by_their_own_attributes_and_take_the_places_of_vertices(self):
        rows = self.rows(500, 0)
        for keep in ("first", "last", "lowest", "highest"):
            for tiles, store in (("1", "cells"), ("7", "points"), ("20", "cells")):
                args = ("--keep", keep, "--tiles", tiles, "--store", store)
                self.triangulate(rows[:400], "out", *self.ATTRIBUTES, "--overwrite", *args)
                for how, gone in ((("--remove-class", "1,2"), np.isin(rows["classification"], (1, 2))),
                                  (("--remove-time", "30..70"), (rows["gps_time"] >= 30) & (rows["gps_time"] <= 70)),
                                  (("--remove-box", "1,1,2,3,4,3"), (rows["x"] >= 1) & (rows["x"] <= 3) & (rows["y"] >= 1) &
                                   (rows["z"] >= 2) & (rows["z"] <= 3) & (rows["y"] <= 4))):
                    with self.subTest(keep=keep, tiles=tiles, how=how):
                        shutil.rmtree(self.folder / "next", ignore_errors=True)
                        gone[400:] = False
                        told = self.update("out", *how, "--add", self.save("more.npy", rows[400:]), "-o", "next")
                        self.assertEqual(told["removed"], gone.sum())
                        self.expect_rows("next", rows, gone, "--keep", keep)

    def test_replace_puts_new_points_in_the_places_of_all_equal_ones(self):
        rows = self.rows(300, 0)
        self.triangulate(rows[:260], "out", *self.ATTRIBUTES, "--tiles", "5")
        told = self.update("out", "--add", self.save("more.npy", rows[260:]), "--replace", "-o", "next")
        places = set(zip(rows["x"][260:], rows["y"][260:]))
        gone = np.array([i < 260 and (row["x"], row["y"]) in places for i, row in enumerate(rows)])
        self.assertEqual((told["removed"], told["first_new_id"]), (gone.sum(), 260))
        self.expect_rows("next", rows, gone)

    POLYGONS = {"type": "FeatureCollection", "features": [{"type": "Feature", "properties": {}, "geometry": geometry} for geometry in (
        {"type": "Polygon", "coordinates": [[[2, 2], [12, 2], [12, 9], [2, 9], [2, 2]], [[4, 4], [4, 7], [9, 7], [9, 4], [4, 4]]]},
        {"type": "MultiPolygon", "coordinates": [[[[0, 0], [5, 5], [0, 5], [0, 0]]], [[[14, 14], [17, 14], [17, 15], [14, 14]]]]})]}

    def test_the_points_of_polygons_are_removed_those_on_their_boundaries_included(self):
        from osgeo import ogr
        (self.folder / "area.geojson").write_text(json.dumps(self.POLYGONS))
        for driver, name in (("GPKG", "area.gpkg"), ("FlatGeobuf", "area.fgb"), ("ESRI Shapefile", "area.shp")):
            file = ogr.GetDriverByName(driver).CreateDataSource(str(self.folder / name))
            layer = file.CreateLayer("area", geom_type=ogr.wkbMultiPolygon)
            for feature in self.POLYGONS["features"]:
                made = ogr.Feature(layer.GetLayerDefn())
                made.SetGeometry(ogr.ForceToMultiPolygon(ogr.CreateGeometryFromJson(json.dumps(feature["geometry"]))))
                layer.CreateFeature(made)
            del layer, file, made
        shapes = [ogr.CreateGeometryFromJson(json.dumps(feature["geometry"])) for feature in self.POLYGONS["features"]]
        cloud = self.random.integers(0, 40, (1200, 2)) / 2
        inside = np.zeros(len(cloud), bool)
        for i, (x, y) in enumerate(cloud):
            at = ogr.Geometry(ogr.wkbPoint)
            at.AddPoint_2D(x, y)
            inside[i] = any(shape.Intersects(at) for shape in shapes)
        self.triangulate(cloud, "out", "--dim", "2", "--tiles", "12")
        left = cloud.copy()
        left[inside] = np.nan
        for name in ("area.geojson", "area.gpkg", "area.fgb", "area.shp"):
            with self.subTest(name=name):
                shutil.rmtree(self.folder / "next", ignore_errors=True)
                told = self.update("out", "--remove-polygon", name, "-o", "next")
                self.assertEqual(told["removed"], inside.sum())
                self.expect_as_from_scratch("next", left, "2")

    def test_the_points_of_an_input_are_removed(self):
        rows = [self.rows(150, first) for first in (0, 150, 300, 450)]
        for name, part in zip("abc", rows):
            self.save(f"{name}.npy", part)
        self.ok("triangulate", "a.npy", "b.npy", "c.npy", "-o", "out", *self.ATTRIBUTES, "--tiles", "4", "--quiet")
        told = self.manifest("out")["inputs"]
        self.assertEqual([(one["first_id"], one["points"]) for one in told], [(0, 150), (150, 150), (300, 150)])
        self.save("b2.npy", rows[3])
        self.update("out", "--remove-input", str(self.folder / "b.npy"), "--add", "b2.npy", "-o", "next")
        gone = (np.arange(600) >= 150) & (np.arange(600) < 300)
        self.expect_rows("next", np.concatenate(rows), gone)
        self.update("next", "--add", "b.npy", "--add", "a.npy", "-o", "again")
        self.refused(USAGE, "update", "again", "--remove-input", "b.npy", "--dry-run",
                     says="'b.npy' was read 2 times (points 150 to 299, points 600 to 749); name one of them by its first "
                          "point, for example 'b.npy@600'")
        self.refused(USAGE, "update", "again", "--remove-input", "d.npy", "--dry-run", says="no points came from 'd.npy'; the inputs are")
        self.update("again", "--remove-input", "b.npy@600", "--remove-input", "c.npy", "-o", "last")
        every = np.arange(900)
        gone = ((every >= 150) & (every < 450)) | ((every >= 600) & (every < 750))
        self.expect_rows("last", np.concatenate([*rows, rows[1], rows[0]]), gone)
        manifest = self.manifest("last")
        for one in manifest["inputs"]:
            del one["first_id"], one["points"]
        (self.folder / "last" / "manifest.json").write_text(json.dumps(manifest))
        self.refused(USAGE, "update", "last", "--remove-input", "c.npy", "--dry-run", says="the manifest does not tell which points came from 'c.npy'")

    def test_a_damaged_file_of_attributes_is_told(self):
        self.triangulate(self.rows(300, 0), "out", *self.ATTRIBUTES)
        file = self.folder / "out" / "duplicate-rows.bin"
        data = bytearray(file.read_bytes())
        data[7] ^= 1
        file.write_bytes(data)
        for command in (["verify", "out"], ["update", "out", "--remove-class", "1", "-o", "next"]):
            self.refused(CORRUPT, *command, says="duplicate-rows.bin")
        self.assertFalse((self.folder / "next").exists())

    def test_unchanged_tiles_are_links_and_the_old_result_stays(self):
        cloud = self.random.random((20000, 2))
        self.triangulate(cloud, "out", "--tiles", "40", "--dim", "2")
        told = self.update("out", "--remove-ids", self.save("one.npy", np.array([5])), "-o", "next")
        self.assertLessEqual(told["tiles_changed"], 4)
        linked = sum(os.path.samefile(file, self.folder / "next" / "tiles" / file.name)
                     for file in (self.folder / "out" / "tiles").iterdir())
        self.assertEqual(linked, 40 - told["tiles_changed"])
        shutil.rmtree(self.folder / "out")
        left = cloud.copy()
        left[5] = np.nan
        self.expect_as_from_scratch("next", left, "2")

    def test_what_is_wrong_gets_a_sentence_and_leaves_nothing(self):
        self.triangulate(self.random.random((100, 3)), "out")
        ids = self.save("ids.npy", np.array([3, 1000]))
        for args, status, sentence in (
                (["--remove-ids", ids], USAGE, "there is no point 1000 to remove"),
                (["--remove-ids", self.save("real.npy", np.array([1.5]))], BAD_INPUT, "holds type '<f8'"),
                (["--remove-ids", self.save("minus.npy", np.array([2, -1]))], BAD_INPUT, "place 1 is -1"),
                (["--remove-ids", "none.npy"], IO, "none.npy"),
                (["--remove-class", "7"], USAGE, "has no attribute 'classification'"),
                (["--remove-class", "700"], USAGE, "700"),
                (["--remove-box", "0,0,1"], USAGE, "--remove-box"),
                (["--remove-time", "7"], USAGE, "interval of times"),
                (["--remove-time", "7..nan"], USAGE, "--remove-time"),
                (["--remove-time", "7..3"], USAGE, "its end is before its begin"),
                (["--remove-time", "3..7"], USAGE, "has no attribute 'gps_time'"),
                (["--remove-polygon", "area.txt"], USAGE, "is no file of polygons by its ending"),
                (["--remove-polygon", "none.geojson"], IO, "none.geojson"),
                (["--replace", "--remove-ids", ids], USAGE, "--replace needs new points"),
                (["--remove-box=-1,-1,2,2"], USAGE, "no points would be left"),
                (["--add", self.save("flat.npy", np.array([[0, 0, np.nan]]))], BAD_INPUT, "flat.npy"),
                ([], USAGE, "nothing is to be changed")):
            with self.subTest(args=args):
                self.refused(status, "update", "out", *args, "-o", "next", says=sentence)
                self.assertFalse((self.folder / "next").exists())
        self.refused(USAGE, "update", "out", "--remove-box", "0,0,0.1,0.1", "-o", "out", says="exists already")
        self.refused(USAGE, "update", "-o", "next", "--remove-ids", ids, says="no result folder is given")


if __name__ == "__main__":
    unittest.main()
