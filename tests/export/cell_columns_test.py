"""Columns of cells in exports, as other programs read them."""
import csv
import unittest

import meshio
import numpy as np
from osgeo import ogr

from gmsh_test import Mesh
from max_edge_test import shorten
from stored import ExportTest

ogr.UseExceptions()
MAIN, FACET = {2: "triangle", 3: "tetra"}, {2: "line", 3: "triangle"}


class CellColumns(ExportTest):
    def measured(self, *options):
        """The result, and by the sorted ids of each cell what NumPy's arrays say of it."""
        stored = self.stored(self.xyz(n=500), "--overwrite", *options)
        self.ok("measure", self.out, "--volume", "--quiet")
        folder = self.export("arrays", "--format", "npy")
        cells = np.sort(np.load(folder / "ids.npy")[np.load(folder / "cells.npy")], axis=1)
        self.name = "area" if stored.dimension == 2 else "volume"
        return stored, dict(zip(map(tuple, cells.tolist()), np.load(folder / f"cell_{self.name}.npy").tolist()))

    def check(self, ids, cells, facets, of_cells, of_facets, expected):
        """Values by rows of vertices; a facet has that of the one cell that it belongs to."""
        found = {tuple(cell): value for cell, value in zip(np.sort(ids[cells], axis=1).tolist(), of_cells)}
        self.assertEqual(found, {cell: expected[cell] for cell in found})
        beside = {}
        for cell, value in found.items():
            for k in range(len(cell)):
                beside.setdefault(cell[:k] + cell[k + 1:], []).append(value)
        outside = {facet: values[0] for facet, values in beside.items() if len(values) == 1}
        self.assertEqual({tuple(f): v for f, v in zip(np.sort(ids[facets], axis=1).tolist(), of_facets)}, outside)
        return found

    def test_gmsh_and_meshio_find_them_at_cells_and_at_the_boundary(self):
        for d in (2, 3):
            stored, expected = self.measured("--dim", d, "--tiles", "4")
            for name in ("msh", "mshb"):
                with self.subTest(dimension=d, format=name):
                    path = self.export("mesh.msh", "--format", name)
                    mesh = Mesh(path, d)
                    cells = np.concatenate(list(mesh.cells.values()))
                    ids = self.check_mesh(stored, mesh.points, cells)
                    kind, values = mesh.data[self.name]
                    self.assertEqual(kind, "ElementData")
                    rows = mesh.nodes["elements"]
                    self.assertEqual(set(values), set(rows))
                    of_cells = [e for e in rows if len(rows[e]) == d + 1]
                    of_facets = [e for e in rows if len(rows[e]) == d]
                    found = self.check(ids, np.array([rows[e] for e in of_cells]), np.array([rows[e] for e in of_facets]),
                                       [values[e] for e in of_cells], [values[e] for e in of_facets], expected)
                    self.assertEqual(found, expected)
                    self.assertEqual(mesh.data["star_" + self.name][0], "NodeData")

                    read = meshio.read(path)
                    ids = self.check_mesh(stored, read.points, self.joined(read, MAIN[d]))
                    found = self.check(ids, self.joined(read, MAIN[d]), self.joined(read, FACET[d]),
                                       self.values(read, MAIN[d]), self.values(read, FACET[d]), expected)
                    self.assertEqual(found, expected)
                    self.assertIn("star_" + self.name, read.point_data)

    def joined(self, mesh, kind):
        return np.concatenate([block.data for block in mesh.cells if block.type == kind])

    def values(self, mesh, kind):
        return np.concatenate([np.ravel(values) for block, values in zip(mesh.cells, mesh.cell_data[self.name], strict=True)
                               if block.type == kind]).tolist()

    def test_gmsh_finds_them_where_cells_are_left_out_and_in_the_file_of_a_tile(self):
        for d, limit in ((2, 0.08), (3, 0.25)):
            stored, expected = self.measured("--dim", d, "--tiles", "4")
            paths = [*self.export("parts", "--format", "mshb").iterdir()]
            self.assertEqual(len(paths), 4)
            by_place = {np.array(p).tobytes(): i for i, p in stored.points.items()}
            self.assertGreater(shorten(stored, limit), 0)
            paths.append(self.export("mesh.msh", "--max-edge", limit))
            for path in paths:
                read = meshio.read(path)
                ids = np.array([by_place[p.tobytes()] for p in read.points])
                found = self.check(ids, self.joined(read, MAIN[d]), self.joined(read, FACET[d]),
                                   self.values(read, MAIN[d]), self.values(read, FACET[d]), expected)
                self.assertTrue(found)
            self.assertEqual(sorted(found), sorted(tuple(sorted(cell)) for cell in stored.cells))

    def test_tables_have_a_field_for_each(self):
        _, expected = self.measured("--dim", "2", "--tiles", "3")
        table = self.export("mesh.csv")
        with open(table, newline="") as file:
            rows = list(csv.DictReader(file))
        self.assertEqual(list(rows[0]), ["geom", "tid", "local", "main", "v0", "v1", "v2", "area"])
        self.assertEqual({tuple(sorted(int(row[v]) for v in ("v0", "v1", "v2"))): float(row["area"]) for row in rows},
                         expected)
        for path in (table.with_suffix(".vrt"), self.export("tables", "--format", "csv") / "triangulation.vrt"):
            source = ogr.Open(str(path))
            layer = source.GetLayer(0)
            fields = layer.GetLayerDefn()
            self.assertEqual(fields.GetFieldDefn(fields.GetFieldIndex("area")).GetTypeName(), "Real")
            found = {tuple(sorted(feature.GetField(v) for v in ("v0", "v1", "v2"))): feature.GetField("area")
                     for feature in layer}
            self.assertEqual(found, expected)

    def test_before_they_are_computed_there_are_none(self):
        self.stored(self.xyz(n=50), "--dim", "2")
        self.assertEqual(self.export("mesh.csv").read_text().splitlines()[0], "geom,tid,local,main,v0,v1,v2")
        self.assertEqual(set(Mesh(self.export("mesh.msh"), 2).data), {"longest_edge"})


if __name__ == "__main__":
    unittest.main()
