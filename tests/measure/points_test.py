"""Results that are kept as points are measured as they are, and have the values of those with files of cells."""
import json
import shutil
import unittest

from cli import CORRUPT, IGN, CliTest
from measured import Measured


class Points(CliTest):
    def tiles(self, name):
        """Files of the newest version, under the names of the first one."""
        manifest = json.loads((self.folder / name / "manifest.json").read_text())
        files = [(f"tiles/{entry['tile']:06}.{'pts' if entry.get('kind') else 'vtu'}", entry) for entry in manifest["tiles"]]
        return {file: (self.folder / name / entry.get("file", file)).read_bytes() for file, entry in files}

    def make(self, *cloud, bbox):
        """The same triangulation with cells, with points and with both, not measured."""
        for name in ("cells", "points", "mixed", "made"):
            shutil.rmtree(self.folder / name, ignore_errors=True)
        for name in ("cells", "points"):
            self.ok("triangulate", *cloud, "-o", name, "--store", name, "--quiet")
        self.ok("materialise", "points", "-o", "mixed", "--bbox", bbox, "--quiet")
        self.assertEqual({name[-3:] for name in self.tiles("mixed")}, {"pts", "vtu"})

    def measure(self, name, *args):
        said = json.loads(self.ok("measure", name, "--volume", "--json", *args).splitlines()[-1])
        self.assertTrue(said["made"])
        self.ok("verify", name, "--quiet")
        return said["total"]

    def test_they_have_the_values_of_files_of_cells(self):
        cloud = self.xyz(n=3000)
        lattice = self.write("lattice.xyz", "".join(f"{x} {y} {z}\n" for x in range(9) for y in range(8) for z in range(7)))
        for args, bbox in (([cloud, "--tiles", "6"], "0,0,0.1,0.1"), ([cloud, "--tiles", "5", "--dim", "2"], "0,0,0.1,0.1"),
                           ([cloud, "--tiles", "4", "--no-neighbors"], "0,0,0.1,0.1"), ([lattice, "--tiles", "7"], "0,0,1,1")):
            with self.subTest(args):
                self.make(*args, bbox=bbox)
                names = "cells", "points", "mixed"
                totals = [self.measure(name, "--threads", str(1 + i)) for i, name in enumerate(names)]
                self.assertEqual(totals, totals[:1] * 3)
                columns = [json.loads(self.ok("columns", name, "--json"))["columns"] for name in names]
                self.assertEqual([[(c["name"], c["of"], c["type"]) for c in one] for one in columns[1:]],
                                 [[(c["name"], c["of"], c["type"]) for c in columns[0]]] * 2)
                for name in names:
                    self.ok("export", name, "-o", f"{name}-arrays", "--format", "npy", "--quiet")
                arrays = [{p.name: p.read_bytes() for p in (self.folder / f"{name}-arrays").iterdir()} for name in names]
                self.assertEqual(arrays[1:], arrays[:1] * 2)
                for name in names:
                    shutil.rmtree(self.folder / f"{name}-arrays")
                # Cells take them along.
                right = self.tiles("cells")
                self.ok("materialise", "points", "-o", "made", "--quiet")
                self.assertEqual(self.tiles("made"), right)
                made = Measured(self.folder / "made")
                self.assertEqual((len(made.volumes), made.total), (made.manifest["counts"]["cells"], totals[0]))
                self.ok("verify", "made", "--quiet")
                self.assertIn("already", self.ok("measure", "made", "--volume"))
                for name in ("points", "mixed"):
                    self.ok("materialise", name, "--quiet")
                    self.assertEqual(self.tiles(name), right)
                    self.ok("verify", name, "--quiet")

    def test_before_or_after_cells_are_made_are_the_same_files(self):
        self.make(self.xyz(n=2000), "--tiles", "4", bbox="0,0,0.1,0.1")
        self.measure("mixed")
        self.ok("materialise", "mixed", "--quiet")
        self.ok("materialise", "points", "--quiet")
        self.measure("points")
        self.assertEqual(self.tiles("points"), self.tiles("mixed"))

    def test_folders_of_their_own_have_the_columns_too(self):
        self.make(self.xyz(n=2000), "--tiles", "4", bbox="0,0,0.1,0.1")
        for name in ("cells", "points"):
            self.measure(name)
        self.ok("materialise", "points", "-o", "made", "--bbox", "0,0,0.1,0.1", "--quiet")
        self.assertEqual({name[-3:] for name in self.tiles("made")}, {"pts", "vtu"})
        self.ok("verify", "made", "--quiet")
        self.ok("materialise", "made", "--quiet")
        self.assertEqual(self.tiles("made"), self.tiles("cells"))
        self.ok("materialise", "cells", "-o", "copy", "--quiet")  # which has cells already
        self.ok("verify", "copy", "--quiet")
        self.assertEqual(Measured(self.folder / "copy").stars, Measured(self.folder / "cells").stars)

    def test_lidar_shows_them_wherever_they_are_seen(self):
        self.make(f"{IGN}/*.las", "--dim", "2", "--tiles", "6", "--attributes", "intensity", bbox=self.corner())
        self.assertEqual(self.measure("cells"), self.measure("mixed"))
        seen = {}
        for name in ("cells", "mixed"):
            self.ok("dem", name, "-o", f"{name}.tif", "--res", "2", "--value", "star_area", "--quiet")
            for ending in (".vtu", ".ply", ".geojson", ".gpkg", ".csv"):
                self.ok("export", name, "-o", f"{name}{ending}", "--quiet")
            self.ok("tileset", name, "-o", f"{name}-tiles", "--quiet")
            nodes = sorted((p.name, p.read_bytes()) for p in (self.folder / f"{name}-tiles" / "nodes").iterdir())
            asked = self.ok("query", name, "interpolate", self.folder / "asked.xyz", "--value", "star_area")
            files = [(self.folder / f"{name}{ending}").read_bytes() for ending in (".tif", ".vtu", ".ply", ".geojson", ".csv")]
            self.assertIn(b'Name="area"', files[1])
            self.assertIn(b'"area":', files[3])
            seen[name] = files, nodes, asked
        self.assertEqual(seen["mixed"], seen["cells"])

    def corner(self):
        self.ok("triangulate", f"{IGN}/*.las", "-o", "looked", "--dim", "2", "--quiet")
        bounds = json.loads(self.ok("info", "looked", "--json").splitlines()[0])["bounds"]
        x, y = ((bounds["min"][i] + bounds["max"][i]) / 2 for i in (0, 1))
        self.write("asked.xyz", f"{x} {y}\n{x + 1} {y + 2}\n")
        return f"{x - 1},{y - 1},{x},{y}"

    def test_damage_is_a_sentence(self):
        self.make(self.xyz(n=2000), "--tiles", "3", bbox="0,0,0.1,0.1")
        self.measure("points")
        tile = self.folder / "points" / "tiles" / "000001-2.pts"
        whole = tile.read_bytes()
        tile.write_bytes(whole[:-1] + bytes([whole[-1] ^ 1]))
        self.refused(CORRUPT, "verify", "points", says="000001-2.pts: its checksum is")
        self.refused(CORRUPT, "export", "points", "-o", "x.ply",
                     says="000001-2.pts, foreign points, attribute 'star_volume', block 0: is damaged")
        self.refused(CORRUPT, "materialise", "points", "-o", "made", says="000001-2.pts")
        self.assertFalse((self.folder / "made").exists())
        # What is of cells stands before that: read where cells have columns alone.
        at = len(whole) - 12_000
        tile.write_bytes(whole[:at] + bytes([whole[at] ^ 1]) + whole[at + 1:])
        self.refused(CORRUPT, "export", "points", "-o", "x.vtu", says="000001-2.pts, cells, column 'volume', block 0: is damaged")
        tile.write_bytes(whole)
        self.ok("verify", "points", "--quiet")

    def test_a_damaged_tile_gets_no_columns(self):
        self.make(self.xyz(n=2000), "--tiles", "3", bbox="0,0,0.1,0.1")
        tile = self.folder / "points" / "tiles" / "000001.pts"
        whole = tile.read_bytes()
        tile.write_bytes(whole[:-1] + bytes([whole[-1] ^ 1]))
        before = self.files(self.folder / "points")
        self.refused(CORRUPT, "measure", "points", "--volume", says="000001.pts")
        self.assertEqual(self.files(self.folder / "points"), before)


if __name__ == "__main__":
    unittest.main()
