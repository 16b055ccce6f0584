"""Exports and products say which version of a result they are of, and its digest: other programs read this."""
import json
import unittest

import numpy as np
from cli import CliTest
from osgeo import gdal

gdal.UseExceptions()
MESHES = {"ply": b"comment ", "obj": b"# ", "off": b"# ", "vtu": b"<!-- "}


class Stamps(CliTest):
    def setUp(self):
        super().setUp()
        random = np.random.default_rng(5)
        self.points = np.column_stack([random.random((400, 2)) * 20, random.random(400)])
        np.save(self.folder / "points.npy", self.points)
        np.save(self.folder / "gone.npy", np.array([7, 300]))

    def triangulate(self, name="out", dim=2, *options):
        self.ok("triangulate", "points.npy", "-o", name, "--dim", str(dim), "--tiles", "4", "--quiet", *options)

    def stamp(self, name="out"):
        manifest = json.loads((self.folder / name / "manifest.json").read_text())
        return {"version": manifest.get("version", 1), "digest": manifest["digest2"]}

    def make(self, command, *options, target):
        self.ok(command, *options, "-o", target, "--quiet", "--overwrite")
        return self.folder / target

    def of_metadata(self, items, before=""):
        return {"version": int(items[f"{before}RESULT_VERSION"]), "digest": items[f"{before}RESULT_DIGEST"]}

    def layer_stamps(self, path):
        opened = gdal.OpenEx(str(path), gdal.OF_VECTOR)
        return [self.of_metadata(opened.GetLayer(i).GetMetadata()) for i in range(opened.GetLayerCount())]

    def check_all(self, stamp, name="out"):
        line = f"result: version {stamp['version']}, digest {stamp['digest']}".encode()
        for ending, mark in MESHES.items():
            self.assertIn(mark + line, self.make("export", name, target=f"mesh.{ending}").read_bytes()[:1000])
        self.make("export", name, "--format", "vtu", target="parts/")
        for file in (self.folder / "parts").iterdir():
            self.assertIn(line, file.read_bytes())
        self.assertIn(line, self.make("alpha", name, "--alpha", "2", target="alpha.ply").read_bytes())
        for command, *options in (("export",), ("contours", "--interval", "0.2"), ("voronoi",), ("alpha", "--alpha", "2")):
            made = json.loads(self.make(command, name, *options, target="map.geojson").read_text())
            self.assertEqual(made["result"], stamp, command)
            read = gdal.OpenEx(str(self.folder / "map.geojson"), gdal.OF_VECTOR)
            self.assertGreater(read.GetLayer(0).GetFeatureCount(), 0)
            stamps = self.layer_stamps(self.make(command, name, *options, target="map.gpkg"))
            self.assertEqual(stamps, [stamp] * len(stamps), command)
            self.assertGreaterEqual(len(stamps), 1)
        for command, *options in (("dem",), ("dem", "--hillshade"), ("dem", "--method", "natural"), ("density",)):
            path = self.make(command, name, "--res", "0.5", *options, target="raster.tif")
            self.assertEqual(self.of_metadata(gdal.Open(str(path)).GetMetadata()), stamp, (command, options))

    def test_each_version_is_told(self):
        self.triangulate()
        first = self.stamp()
        self.assertEqual(first["version"], 1)
        self.check_all(first)
        before = self.make("dem", "out", "--res", "0.5", target="before.tif").read_bytes()
        self.ok("update", "out", "--remove-ids", "gone.npy", "--keep-versions", "2", "--quiet")
        second = self.stamp()
        self.assertEqual(second["version"], 2)
        self.assertNotEqual(second["digest"], first["digest"])
        self.check_all(second)
        again = self.make("dem", "out", "--version", "1", "--res", "0.5", target="again.tif")
        self.assertEqual(again.read_bytes(), before)

    def test_a_product_of_two_results_names_both(self):
        self.triangulate()
        self.triangulate("other", 2, "--crop", "0,0,20,15")
        self.ok("volume", "out", "other", "--difference", "d.tif", "--res", "0.5", "--quiet")
        items = gdal.Open(str(self.folder / "d.tif")).GetMetadata()
        self.assertEqual(self.of_metadata(items), self.stamp())
        self.assertEqual(self.of_metadata(items, "LOWER_"), self.stamp("other"))

    def test_files_of_equal_results_are_equal_whatever_their_tiles(self):
        made = set()
        for number, options in enumerate((("--tiles", "1"), ("--tiles", "7"), ("--tiles", "7", "--store", "points"), ("--tiles", "60"))):
            self.ok("triangulate", "points.npy", "-o", f"r{number}", "--dim", "2", "--quiet", *options)
            made.add(self.make("dem", f"r{number}", "--res", "0.25", target="dem.tif").read_bytes())
            made.add(self.make("dem", "points.npy", "--res", "0.25", target="dem.tif").read_bytes())
        self.assertEqual(len(made), 1)

    def test_a_surface_is_no_result(self):
        self.triangulate(dim=3)
        path = self.make("surface", "out", "--sensor", "vertical", target="surface.ply")
        self.assertNotIn(b"comment result: ", path.read_bytes()[:1000])
        self.assertIn(self.stamp()["digest"].encode(), path.read_bytes()[:1000])
        self.ok("verify", "surface.ply", "--of", "out", "--quiet")

    def test_info_tells_what_a_mesh_was_made_of(self):
        self.triangulate()
        stamp = self.stamp()
        for ending in ("ply", "obj"):
            path = self.make("export", "out", target=f"mesh.{ending}")
            told = json.loads(self.ok("info", path.name, "--json"))
            self.assertEqual(told["files"][0]["result"], stamp)
            self.assertRegex(self.ok("info", path.name), rf"made of +version 1 of a result, digest {stamp['digest']}")
            other = self.write(f"other.{ending}", "# result: version 1, digest 12\nv 1 2 3\n" if ending == "obj" else
                               "ply\nformat ascii 1.0\ncomment result: version\nelement vertex 1\n"
                               "property double x\nproperty double y\nproperty double z\nend_header\n1 2 3\n")
            self.assertIsNone(json.loads(self.ok("info", other, "--json"))["files"][0]["result"])


if __name__ == "__main__":
    unittest.main()
