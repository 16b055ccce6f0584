"""Columns as users see them: in tables, in exports, in answers, in rasters; and what is damaged."""
import json
import shutil
import struct
import unittest

import numpy as np
from cli import CORRUPT, IO, USAGE, CliTest
from measured import Measured


class Columns(CliTest):
    def surface(self):
        rng = np.random.default_rng(5)
        points = np.concatenate([rng.random((900, 2)) * 100, rng.random((900, 1))], 1)
        np.savetxt(self.folder / "ground.xyz", points)
        self.ok("triangulate", self.folder / "ground.xyz", "-o", self.out, "--dim", "2", "--tiles", "3", "--quiet")

    def test_a_table_and_info_tell_of_them(self):
        self.surface()
        self.assertIn("no columns", self.ok("columns", self.out))
        self.assertEqual(json.loads(self.ok("columns", self.out, "--json")),
                         {"result": str(self.out), "version": 1, "columns": []})
        self.assertNotIn("columns", self.ok("info", self.out))
        said = self.ok("measure", self.out, "--volume")
        total = Measured(self.out).total
        self.assertIn(f"area of all cells: {total!r}", said)
        columns = json.loads(self.ok("columns", self.out, "--json"))
        self.assertEqual(columns["version"], 2)
        self.assertEqual([(c["name"], c["of"], c["type"], c.get("total")) for c in columns["columns"]],
                         [("area", "cells", "float64", total), ("star_area", "vertices", "float64", None)])
        self.assertIn("--volume", columns["columns"][0]["command"])
        table = self.ok("columns", self.out).splitlines()
        self.assertEqual(table[1].split()[:4], ["name", "of", "type", "unit"])
        self.assertEqual(table[2].split()[:3], ["area", "cells", "float64"])
        self.assertIn("columns             area of cells, star_area of vertices (version 2)", self.ok("info", self.out))
        self.assertEqual(json.loads(self.ok("info", self.out, "--json"))["columns"], columns["columns"])
        self.refused(USAGE, "columns", says="no result folder")
        self.refused(IO, "columns", self.folder / "none", says="none")

    def test_they_are_made_once(self):
        self.surface()
        first = json.loads(self.ok("measure", self.out, "--volume", "--json").splitlines()[-1])
        self.assertEqual((first["version"], first["made"], first["columns"]), (2, True, ["area", "star_area"]))
        again = json.loads(self.ok("measure", self.out, "--volume", "--json").splitlines()[-1])
        self.assertEqual((again["version"], again["made"], again["total"]), (2, False, first["total"]))
        self.assertIn("nothing was changed", self.ok("measure", self.out, "--volume"))

    def test_other_arrays_are_stored_as_they_were(self):
        self.surface()
        from tile_arrays import read_tile
        before = {p.name: read_tile(p) for p in (self.out / "tiles").iterdir()}
        self.ok("measure", self.out, "--volume", "--quiet")
        for name, arrays in before.items():
            after = read_tile(self.out / "tiles" / name.replace(".vtu", "-2.vtu"))
            self.assertEqual(set(after) - set(arrays), {"CellData/area", "PointData/star_area"})
            for array, values in arrays.items():
                np.testing.assert_array_equal(after[array], values)

    def test_vertices_have_them_as_attributes_and_cells_in_exports(self):
        self.surface()
        self.ok("measure", self.out, "--volume", "--quiet")
        result = Measured(self.out)
        self.ok("export", self.out, "-o", self.folder / "arrays", "--format", "npy", "--quiet")
        arrays = {p.stem: np.load(p) for p in (self.folder / "arrays").iterdir()}
        ids = arrays["ids"]
        self.assertEqual(arrays["star_area"].tolist(), [result.stars[i] for i in ids.tolist()])
        cells = np.sort(ids[arrays["cells"]].astype(int), axis=1)
        self.assertEqual(arrays["cell_area"].tolist(), [result.volumes[tuple(cell)] for cell in cells.tolist()])
        for name in "mesh.vtu", "mesh.geojson", "mesh.gpkg", "mesh.ply":
            self.ok("export", self.out, "-o", self.folder / name, "--quiet")
        features = json.loads((self.folder / "mesh.geojson").read_text())["features"]
        self.assertEqual(sorted(f["properties"]["area"] for f in features), sorted(result.volumes.values()))
        self.assertIn(b"star_area", (self.folder / "mesh.ply").read_bytes()[:1000])
        places = self.folder / "places.csv"
        places.write_text("50,50\n")
        asked = self.ok("query", self.out, "interpolate", places, "--value", "star_area")
        self.assertRegex(asked, "[0-9]")
        self.ok("dem", self.out, "--res", "5", "--value", "star_area", "-o", self.folder / "stars.tif", "--quiet")

    def test_vtk_reads_them_from_the_master_file(self):
        try:
            import vtk
            from vtk.util.numpy_support import vtk_to_numpy
        except ImportError:
            self.skipTest("there is no VTK for this Python")
        self.surface()
        self.ok("measure", self.out, "--volume", "--quiet")
        for file, kind in (self.out / "triangulation.pvtu", vtk.vtkXMLPUnstructuredGridReader), \
                (self.folder / "mesh.vtu", vtk.vtkXMLUnstructuredGridReader):
            if not file.exists():
                self.ok("export", self.out, "-o", file, "--quiet")
            reader = kind()
            reader.SetFileName(str(file))
            reader.Update()
            grid = reader.GetOutput()
            values = vtk_to_numpy(grid.GetCellData().GetArray("area"))
            ghost = grid.GetCellData().GetArray("vtkGhostType")
            main = vtk_to_numpy(ghost) == 0 if ghost else np.ones(len(values), bool)
            self.assertEqual(sorted(values[main].tolist()), sorted(Measured(self.out).volumes.values()))
            self.assertIsNotNone(grid.GetPointData().GetArray("star_area"))

    def test_a_damaged_column_is_told_with_its_place(self):
        self.surface()
        self.ok("measure", self.out, "--volume", "--quiet")
        file = self.out / "tiles" / "000001-2.vtu"
        data = bytearray(file.read_bytes())
        result = Measured(self.out)
        places = [data.find(struct.pack("<d", area)) for area in set(result.volumes.values()) - set(result.stars.values())]
        data[max(places)] ^= 1  # one of the tile's cells
        file.write_bytes(data)
        self.refused(CORRUPT, "export", self.out, "-o", self.folder / "mesh.vtu", says="000001-2.vtu, CellData/area: block")
        self.refused(CORRUPT, "verify", self.out, says="000001-2.vtu: its checksum is")
        self.ok("export", self.out, "-o", self.folder / "mesh.off", "--quiet")  # which has no columns of cells

    def test_a_damaged_tile_gets_no_columns(self):
        self.surface()
        file = self.out / "tiles" / "000001.vtu"
        data = bytearray(file.read_bytes())
        data[-200] ^= 1
        file.write_bytes(data)
        before = self.files(self.out)
        self.refused(CORRUPT, "measure", self.out, "--volume", says="000001.vtu")
        self.assertEqual(self.files(self.out), before)

    def test_manifests_that_cannot_be_are_refused(self):
        self.surface()
        self.ok("measure", self.out, "--volume", "--quiet")
        good = (self.out / "manifest.json").read_text()
        for old, new in (('"tiles/000001-2.vtu"', '"tiles/../000001-2.vtu"'), ('"tiles/000001-2.vtu"', '"tiles/000002-2.vtu"'),
                         ('"tiles/000001-2.vtu"', '"tiles/000001-3.vtu"'), ('"tiles/000001-2.vtu"', '"tiles/000001-02.vtu"'),
                         ('"version": 2', '"version": 1'), ('"of": "cells"', '"of": "edges"'),
                         ('"name": "area"', '"name": "tile"'), ('"name": "area"', '"name": "star_area"')):
            with self.subTest(change=new):
                self.assertIn(old, good)
                (self.out / "manifest.json").write_text(good.replace(old, new, 1))
                self.refused(CORRUPT, "columns", self.out, says="manifest.json")

    def test_names_that_are_taken_are_told(self):
        (self.folder / "named.csv").write_text("x,y,star_area\n0,0,1\n1,0,2\n0,1,3\n1,1,4\n")
        self.ok("triangulate", self.folder / "named.csv", "-o", self.out, "--dim", "2", "--attributes", "star_area",
                "--quiet")
        self.refused(USAGE, "measure", self.out, "--volume", says="have an attribute 'star_area' already")

    def test_regions_are_measured_with_a_sentence(self):
        rng = np.random.default_rng(6)
        np.savetxt(self.folder / "cloud.xyz", rng.random((3000, 3)))
        self.ok("region", self.folder / "cloud.xyz", "--bbox", "0.2,0.2,0.4,0.5", "-o", self.out, "--quiet")
        self.assertIn("the result is a region", self.ok("measure", self.out, "--volume"))
        result = Measured(self.out)
        self.assertEqual(len(result.volumes), result.manifest["counts"]["cells"])

    def test_older_formats_are_read_and_not_changed(self):
        import os
        import pathlib
        data = pathlib.Path(os.environ["IGN"]).parents[1] / "tests" / "data" / "format-2"
        found = [p.parent for p in data.rglob("manifest.json")]
        for old in found:
            shutil.rmtree(self.out, ignore_errors=True)
            shutil.copytree(old, self.out)
            self.refused(USAGE, "measure", self.out, "--volume", says="format version 2")
            self.assertIn("no columns", self.ok("columns", self.out))
        self.assertTrue(found)


if __name__ == "__main__":
    unittest.main()
