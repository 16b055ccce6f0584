"""voronoi, density, alpha and volume with --server: the same words and files as without, and nothing left behind."""
import json
import subprocess
import unittest

import regions_test
from daemon import TESSERA

INPUTS = regions_test.INPUTS


class Products(regions_test.WithDaemon):
    def setUp(self):
        super().setUp()
        self.server = ["--server", f"{self.daemon.url}#token={self.daemon.token}"]
        self.execute("triangulate", **INPUTS, dim=2, output="ground", tiles=4)
        self.result = self.folder / "data/results/ground"
        west, south, east, north = self.middle()
        ring = [[west, south], [east, south], [east, north], [west, north], [west, south]]
        self.square = {"type": "FeatureCollection", "features": [
            {"type": "Feature", "properties": {"name": "middle"}, "geometry": {"type": "Polygon", "coordinates": [ring]}}]}
        (self.folder / "square.geojson").write_text(json.dumps(self.square))

    def exports(self):
        folder = self.result / "exports"
        return sorted(file.name for file in folder.iterdir() if not file.name.endswith(".owner")) if folder.exists() else []

    def test_products_are_told_and_written_as_here(self):
        box = ",".join(map(repr, self.middle()))
        for command, ending, args in (
                ("voronoi", ".csv", ()), ("voronoi", ".geojson", ("--clip", "square.geojson")), ("voronoi", ".csv", (f"--clip={box}",)),
                ("density", ".npy", ("--res", 2)), ("density", ".tif", ("--res", 1, f"--bbox={box}", "--sample")),
                ("density", ".npy", ("--res", 2, "--field", "z")), ("alpha", ".ply", ("--alpha", 2, "--general")),
                ("alpha", ".geojson", ("--alpha", "auto")), ("volume", ".csv", ("--plane", 20, "--max-edge", 5)),
                ("volume", ".json", ("--plane", 20, "--within", "square.geojson"))):
            for also in ((), ("--json",)):
                with self.subTest(f"{command} {args} {also}"):
                    near, far = f"a{ending}", f"b{ending}"
                    here = self.tessera(command, self.result, *args, *also, "-o", near, "--overwrite")
                    there = self.tessera(command, "ground/", *args, *also, "-o", far, "--overwrite", *self.server)
                    self.assertEqual(there.splitlines()[-len(here.splitlines()):], here.replace(near, far).splitlines())
                    self.assertEqual((self.folder / far).read_bytes(), (self.folder / near).read_bytes())
        self.assertEqual(self.exports(), [])
        self.assertEqual(self.daemon.end(), 0, self.daemon.messages())

    def test_the_second_result_of_a_volume_is_another_of_the_daemon(self):
        self.execute("triangulate", **INPUTS, dim=2, output="after", tiles=1, crop=self.middle())
        other = self.folder / "data/results/after"
        here = self.tessera("volume", self.result, other, "-o", "a.csv")
        there = self.tessera("volume", "ground", "after/", "-o", "b.csv", *self.server)
        self.assertEqual(there, here.replace("a.csv", "b.csv"))
        self.assertEqual((self.folder / "b.csv").read_bytes(), (self.folder / "a.csv").read_bytes())
        self.says_no("second: there is none called 'none'", "volume", "ground", "none", "-o", "c.csv")
        self.assertEqual(self.daemon.end(), 0, self.daemon.messages())

    def says_no(self, says, *args):
        done = subprocess.run([TESSERA, *map(str, args), *self.server], cwd=self.folder, text=True, capture_output=True)
        self.assertGreater(done.returncode, 0, done.stdout)
        self.assertIn(says, done.stderr.splitlines()[-1])
        self.assertNotIn(str(self.folder), done.stderr)

    def test_polygons_that_make_no_sense_are_refused_in_words_of_the_caller(self):
        def write(**members):
            (self.folder / "wrong.geojson").write_text(json.dumps({**self.square, **members}))
        write(features=[])
        self.says_no("has no polygon", "voronoi", "ground", "-o", "c.csv", "--clip", "wrong.geojson")
        # A system that is a link is never fetched; GDAL would.
        write(crs={"type": "link", "properties": {"href": "http://127.0.0.1:1/crs", "type": "proj4"}})
        self.tessera("volume", "ground", "--plane", 20, "--within", "wrong.geojson", "-o", "linked.csv", *self.server)
        write(crs={"type": "name", "properties": {"name": "EPSG:4326"}})
        self.says_no("transform it first", "volume", "ground", "--plane", "20", "--within", "wrong.geojson", "-o", "c.csv")
        self.says_no("must end in", "alpha", "ground", "--alpha", "auto", "-o", "c.vtu")
        self.assertEqual(self.exports(), [])
        self.assertFalse((self.folder / "c.csv").exists())
        self.assertEqual(self.daemon.end(), 0, self.daemon.messages())


if __name__ == "__main__":
    unittest.main()
