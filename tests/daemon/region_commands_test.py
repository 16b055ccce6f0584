"""region, dem and contours with --server, and what they say of regions."""
import json
import subprocess
import unittest

import regions_test
from daemon import TESSERA

INPUTS = regions_test.INPUTS


class Commands(regions_test.WithDaemon):
    """region, dem and contours with --server: the same words and files as without, and nothing left behind."""

    def setUp(self):
        super().setUp()
        self.server = ["--server", f"{self.daemon.url}#token={self.daemon.token}"]
        self.execute("triangulate", **INPUTS, dim=2, output="ground", tiles=4)
        self.result = self.folder / "data/results/ground"

    def exports(self):
        folder = self.result / "exports"
        return sorted(file.name for file in folder.iterdir() if not file.name.endswith(".owner")) if folder.exists() else []

    def says_no(self, says, *args):
        done = subprocess.run([TESSERA, *map(str, args), *self.server], cwd=self.folder, text=True, capture_output=True)
        self.assertGreater(done.returncode, 0, done.stdout)
        self.assertEqual(done.stdout, "")
        self.assertIn(says, done.stderr.splitlines()[-1])

    def test_drawings_are_told_and_written_as_here(self):
        for near, far, args in (("a.tif", "b.tif", ("--res", 0.5, "--max-edge", 1)), ("a.tif", "b.tif", ("--res", 1, "--hillshade", "--bbox", ",".join(map(repr, self.middle())))),
                                ("a.geojson", "b.geojson", ("--interval", 1, "--max-edge", 1)), ("a.geojson", "b.geojson", ("--interval", 2, "--base", 0.25)),
                                ("a.geojson", "b.geojson", ("--interval", 0.5, "--smooth", 1, "--min-length", 3, "--index-every", 2))):
            command = "dem" if near.endswith(".tif") else "contours"
            for also in ((), ("--json",)):
                with self.subTest(f"{command} {args} {also}"):
                    here = self.tessera(command, self.result, *args, *also, "-o", near, "--overwrite")
                    there = self.tessera(command, "ground/", *args, *also, "-o", far, "--overwrite", *self.server)
                    self.assertEqual(there.splitlines()[-len(here.splitlines()):], here.replace(near, far).splitlines())
                    if not also:
                        self.assertEqual(there, here.replace(near, far))
                    self.assertEqual((self.folder / far).read_bytes(), (self.folder / near).read_bytes())
        self.assertEqual(self.exports(), [])
        # What others have drawn stays.
        self.execute("dem", triangulation="ground", res=5)
        before = (self.result / "exports/dem.tif").read_bytes()
        self.tessera("dem", "ground", "--res", 1, "-o", "dem.tif", *self.server)
        self.assertEqual(((self.result / "exports/dem.tif").read_bytes(), self.exports()), (before, ["dem.tif"]))
        # Detached it is fetched later.
        job = self.tessera("dem", "ground", "--res", 1, "-o", "later.tif", "--detach", "--quiet", *self.server).strip()
        self.assertEqual(self.daemon.wait(job)["status"], "successful")
        self.tessera("fetch", job, "-o", "fetched.tif", *self.server)
        self.assertEqual((self.folder / "fetched.tif").read_bytes(), (self.folder / "dem.tif").read_bytes())
        self.assertEqual(self.exports(), ["dem.tif", "later.tif"])
        self.says_no("exists already", "fetch", job, "-o", "fetched.tif")
        self.assertEqual(self.daemon.end(), 0, self.daemon.messages())

    def test_an_export_in_local_coordinates_is_that_of_here(self):
        here = self.tessera("export", self.result, "-o", "a.ply", "--local")
        there = self.tessera("export", "ground", "-o", "b.ply", "--local", *self.server)
        self.assertEqual(there, here.replace("a.ply", "b.ply"))
        self.assertEqual((self.folder / "b.ply").read_bytes(), (self.folder / "a.ply").read_bytes())
        self.says_no("--local: works only with ply, obj, off and stl; vtu keeps coordinates as they are", "export", "ground", "-o", "b.vtu", "--local")
        self.assertEqual(self.daemon.end(), 0, self.daemon.messages())

    def test_a_region_is_told_as_here(self):
        args = ("--dim", 2, f"--bbox={','.join(map(repr, self.middle()))}")
        first = self.tessera("region", "*50_627755.las", *args, "-o", "part/", *self.server).splitlines()
        here = self.tessera("region", self.cloud, *args, "-o", "part").splitlines()
        self.assertEqual(first[0], here[0])
        self.assertEqual(first[1].rpartition(", ")[0], here[1].rpartition(", ")[0])  # but for the seconds
        self.assertEqual(self.tile(self.folder / "data/results/part"), self.tile(self.folder / "part"))
        told = json.loads(self.tessera("region", "*50_627755.las", *args, "-o", "again", "--json", *self.server).splitlines()[-1])
        self.assertEqual((told["output"], told["points_read"]), ("again", 0))
        self.assertEqual(self.daemon.end(), 0, self.daemon.messages())

    def test_a_region_of_a_polygon_and_what_is_drawn_of_it_are_told_as_here(self):
        box = self.middle()
        (self.folder / "area.geojson").write_text(json.dumps(
            {"type": "Polygon", "coordinates": [[box[:2], [box[2], box[1]], box[2:], box[:2]]]}))
        (self.folder / "system.prj").write_text(subprocess.run(["gdalsrsinfo", "-o", "wkt2", "EPSG:2154"], check=True, text=True,
                                                               capture_output=True).stdout)
        for name, crs in (("code", "EPSG:2154"), ("text", "system.prj")):
            args = ("--dim", 2, "--polygon", "area.geojson", "--crs", crs)
            first = self.tessera("region", "*50_627755.las", *args, "-o", name, *self.server).splitlines()
            here = self.tessera("region", self.cloud, *args, "-o", name).splitlines()
            self.assertEqual(first[0], here[0])
            self.assertEqual(self.tile(self.folder / "data/results" / name), self.tile(self.folder / name))
            self.tessera("fetch", name, "-o", f"{name}-fetched", *self.server)
            one, other = (json.loads((self.folder / folder / "manifest.json").read_text()) for folder in (name, f"{name}-fetched"))
            self.assertEqual((one["crs"], one["digest2"], one["region"]), (other["crs"], other["digest2"], other["region"]))
            self.assertIn("EPSG:2154" if name == "code" else "Lambert-93", one["crs"])
            for command, size, file in (("dem", "--res", "a.tif"), ("contours", "--interval", "a.geojson")):
                here = self.tessera(command, f"{name}-fetched", size, 0.5, "-o", file, "--overwrite")
                near = (self.folder / file).read_bytes()
                # As a name of a result it is refused while a folder here is called so.
                (self.folder / name).rename(self.folder / "elsewhere")
                self.assertEqual(self.tessera(command, name, size, 0.5, "-o", file, "--overwrite", *self.server), here)
                (self.folder / "elsewhere").rename(self.folder / name)
                self.assertEqual((self.folder / file).read_bytes(), near)
        for says, *args in (("--crs", "--polygon", "area.geojson", "--crs", "2154"), ("none.geojson", "--polygon", "none.geojson"),
                            ("--bbox or --polygon", "--polygon", "area.geojson", "--bbox", "0,0,1,1"),
                            ("system.prj", "--polygon", "system.prj")):
            self.says_no(says, "region", "*50_627755.las", "--dim", 2, *args, "-o", "none")
        self.assertEqual(self.daemon.end(), 0, self.daemon.messages())

    def test_what_is_wrong_gets_a_sentence(self):
        (self.folder / "folder.tif").mkdir()
        (self.folder / "there.tif").write_text("mine")
        (self.folder / "ground2").mkdir()
        region = ("region", "*50_627755.las", "--dim", 2)
        for says, *args in (("none called 'none'", "dem", "none", "--res", 1, "-o", "x.tif"),
                            ("ground2 is a folder here", "contours", "ground2", "--interval", 1, "-o", "x.gpkg"),
                            ("x.png", "dem", "ground", "--res", 1, "-o", "x.png"),
                            ("x.tif", "contours", "ground", "--interval", 1, "-o", "x.tif"),
                            ("folder.tif: is a folder", "dem", "ground", "--res", 1, "-o", "folder.tif"),
                            ("there.tif: exists already", "dem", "ground", "--res", 1, "-o", "there.tif"),
                            ("no/such: there is no such folder", "dem", "ground", "--res", 1, "-o", "no/such/x.tif"),
                            ("--res", "dem", "ground", "-o", "x.tif"),
                            ("nothing", "dem", "ground", "--res", 1, "--value", "nothing", "-o", "x.tif"),
                            ("--bbox", *region, "-o", "part"),
                            ("ending", *region, "--bbox", "0,0,1,1", "-o", "part.vtu"),
                            ("no cell", *region, "--bbox", "0,0,1,1", "-o", "part"),
                            ("inputs", "region", "none.las", "--bbox", "0,0,1,1", "-o", "part"),
                            ("standard input", "region", "-", "--bbox", "0,0,1,1", "-o", "part"),
                            ("--input-list", "region", "--input-list", "list", "--bbox", "0,0,1,1", "-o", "part"),
                            ("ground", *region, "--bbox", "0,0,1,1", "-o", "ground")):
            with self.subTest(args):
                self.says_no(says, *args)
        self.assertEqual(sorted(one.name for one in self.folder.iterdir()), ["data", "folder.tif", "ground2", "there.tif"])
        self.assertEqual(((self.folder / "there.tif").read_text(), self.exports()), ("mine", []))
        self.assertEqual([one.name for one in (self.folder / "data/results").iterdir() if not one.name.startswith(".desk-")], ["ground"])
        self.assertEqual(self.daemon.end(), 0, self.daemon.messages())


if __name__ == "__main__":
    unittest.main()
