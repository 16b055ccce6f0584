"""Gmsh files, as Gmsh reads them: tiles and boundary as groups, attributes of vertices, lengths of cells."""
import random
import unittest

import gmsh
import numpy as np

import readers
from max_edge_test import longest_edge, shorten
from stored import ExportTest, volumes


class Mesh:
    """All that Gmsh finds in a file, with vertices by their coordinates' row."""

    def __init__(self, path, dimension):
        gmsh.initialize()
        try:
            gmsh.option.setNumber("General.Terminal", 0)
            gmsh.open(str(path))
            get = gmsh.model.mesh
            tags, places, _ = get.getNodes()
            self.points = places.reshape(-1, 3)
            row = np.empty(int(tags.max()) + 1, int)
            row[tags] = np.arange(len(tags))
            self.groups, self.cells, self.kinds, self.nodes = {}, {}, set(), {}
            for d, tag in gmsh.model.getPhysicalGroups():
                name = gmsh.model.getPhysicalName(d, tag)
                entities = gmsh.model.getEntitiesForPhysicalGroup(d, tag)
                assert list(entities) == [tag], (name, entities)
                kinds, numbers, nodes = get.getElements(d, tag)
                self.groups[name] = (d, tag)
                self.kinds |= set(kinds.tolist())
                rows = row[nodes[0]].reshape(-1, d + 1) if len(nodes) else np.empty((0, d + 1), int)
                self.nodes[name] = row[get.getNodes(d, tag)[0]]
                if name == "boundary":
                    self.boundary = rows
                else:
                    self.cells[name] = rows
                for number, cell in zip(numbers[0].tolist() if len(numbers) else [], rows):
                    self.nodes.setdefault("elements", {})[number] = cell
            self.box = gmsh.model.getBoundingBox(-1, -1)
            self.data = {}
            for view in gmsh.view.getTags():
                name = gmsh.option.getString(f"View[{gmsh.view.getIndex(view)}].Name")
                kind, numbers, values, _, parts = gmsh.view.getModelData(view, 0)
                assert parts == 1
                where = row[numbers] if kind == "NodeData" else numbers
                self.data[name] = (kind, dict(zip(where.tolist(), [float(v[0]) for v in values])))
            gmsh.option.setNumber("Mesh.MshFileVersion", 2.2)
            gmsh.write(str(path) + ".old.msh")
        finally:
            gmsh.finalize()


class Gmsh(ExportTest):
    def cloud(self):
        rng = random.Random(5)
        head = ("ply\nformat ascii 1.0\nelement vertex 400\nproperty double x\nproperty double y\nproperty double z\n"
                "property float weight\nproperty uchar a\"quoted\"name\nproperty short depth\nend_header\n")
        rows = "".join(f"{rng.random()} {rng.random()} {rng.random()} {rng.randrange(64) / 8} {rng.randrange(256)} "
                       f"{rng.randrange(-999, 999)}\n" for _ in range(400))
        return self.write("cloud.ply", head + rows)

    def check(self, stored, mesh, whole=True):
        d = stored.dimension
        cells = np.concatenate(list(mesh.cells.values()))
        ids = self.check_mesh(stored, mesh.points, cells, whole=whole) if whole else None
        self.assertEqual(mesh.kinds, {1, 2} if d == 2 else {2, 4})
        self.check_boundary(mesh, cells, d)
        np.testing.assert_allclose(mesh.box, [*mesh.points.min(0), *mesh.points.max(0)])
        return ids, cells

    def check_boundary(self, mesh, cells, d):
        """It is the facets of one cell alone, each once, turned outwards."""
        sides = np.argwhere(readers.neighbors_of(cells) == -1)
        expected = {frozenset(np.delete(cells[c], k)): cells[c][k] for c, k in sides.tolist()}
        self.assertEqual(len(mesh.boundary), len(expected))
        found = {frozenset(facet): facet for facet in mesh.boundary.tolist()}
        self.assertEqual(set(found), set(expected))
        inside = np.array([[*found[facet], apex] for facet, apex in expected.items()])
        self.assertTrue((np.sign(volumes(mesh.points[inside][:, :, :d])) == (1 if d == 2 else -1)).all())

    def test_text_and_binary_hold_tiles_boundary_and_data(self):
        for d in (2, 3):
            stored = self.stored(self.cloud(), "--dim", d, "--attributes", "all", "--tiles", "4", "--overwrite")
            for name in ("msh", "mshb"):
                with self.subTest(dimension=d, format=name):
                    path = self.export("mesh.msh", "--format", name)
                    self.assertEqual(path.read_bytes()[:20], b"$MeshFormat\n4.1 %d 8\n" % (name == "mshb"))
                    mesh = Mesh(path, d)
                    ids, cells = self.check(stored, mesh)
                    tiles = {t["tile"]: t for t in stored.manifest["tiles"]}
                    self.assertEqual(mesh.groups, {"boundary": (d - 1, 1)} | {f"tile {t}": (d, t + 1) for t in tiles})
                    for t, entry in tiles.items():
                        self.assertEqual(len(mesh.cells[f"tile {t}"]), entry["main_cells"])
                        self.assertEqual(len(mesh.nodes[f"tile {t}"]), entry["own_points"])
                    names = {"weight": "weight", 'a"quoted"name': "a'quoted'name", "depth": "depth"}
                    self.assertEqual(set(mesh.data), {*names.values(), "longest_edge"})
                    for attribute, shown in names.items():
                        kind, values = mesh.data[shown]
                        self.assertEqual(kind, "NodeData")
                        self.assertEqual([values[row] for row in range(len(ids))],
                                         [stored.attributes[attribute][i] for i in ids.tolist()])
                    kind, values = mesh.data["longest_edge"]
                    self.assertEqual(kind, "ElementData")
                    elements = mesh.nodes["elements"]
                    self.assertEqual(set(values), set(elements))
                    np.testing.assert_allclose([values[e] for e in elements],
                                               [longest_edge(stored, ids[elements[e]].tolist()) for e in elements])

    def test_the_boundary_is_that_of_the_cells_that_are_left(self):
        for options, limit in ((["--tiles", "5"], "0.16"), (["--tiles", "6", "--dim", "2"], "0.04")):
            stored = self.stored(self.xyz(n=900), "--overwrite", *options)
            self.assertGreater(shorten(stored, float(limit)), 0)
            path = self.export("mesh.msh", "--max-edge", limit)
            self.check(stored, Mesh(path, stored.dimension))
            whole = path.read_bytes()
            self.stored("cloud.xyz", "--overwrite", "--no-neighbors", *options)
            self.assertEqual(self.export("again.msh", "--max-edge", limit).read_bytes(), whole,
                             "neighbours that are not stored are found")

    def test_each_tile_has_the_boundary_of_its_own_cells(self):
        for d in (2, 3):
            stored = self.stored(self.xyz(n=500), "--tiles", "3", "--dim", d, "--overwrite")
            folder = self.export("parts", "--format", "mshb")
            for entry in stored.manifest["tiles"]:
                mesh = Mesh(folder / ("%06d.msh" % entry["tile"]), d)
                self.assertEqual(set(mesh.groups), {"boundary", f"tile {entry['tile']}"})
                cells = mesh.cells[f"tile {entry['tile']}"]
                self.assertEqual(len(cells), entry["main_cells"])
                self.check_boundary(mesh, cells, d)

    def test_gmsh_writes_the_older_version_for_programs_that_know_no_other(self):
        stored = self.stored(self.xyz(n=200), "--tiles", "2")
        path = self.export("mesh.msh")
        self.check(stored, Mesh(path, 3))
        points, cells, _ = readers.by_gmsh(path.with_name("mesh.msh.old.msh"), 4)
        self.assertEqual(len(cells), len(stored.cells))

    def test_a_tile_without_cells_has_no_boundary(self):
        stored = self.stored(self.xyz(n=40), "--dim", "2", "--tiles", "20")
        empty = [t["tile"] for t in stored.manifest["tiles"] if t["main_cells"] == 0]
        self.assertTrue(empty)
        for name in ("msh", "mshb"):
            mesh = Mesh(self.export("mesh.msh", "--format", name), 2)
            self.check(stored, mesh)
            folder = self.export("parts", "--format", name)
            self.assertEqual(readers.groups_of(folder / ("%06d.msh" % empty[0])), [f"tile {empty[0]}"])

    def test_the_ending_of_binary_files_is_that_of_all(self):
        self.stored(self.xyz(n=50))
        self.assertIn("mesh.msh:", self.ok("export", self.out, "-o", "mesh.mshb"))
        self.assertIn("mesh.msh", self.files())
        self.refused(2, "export", self.out, "-o", "mesh.mshb", says=["mesh.msh", "exists already"])


if __name__ == "__main__":
    unittest.main()
