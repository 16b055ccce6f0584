"""What docs/formats.md says of meshio: every format that it reads has the points, the cells and the data of the result."""
import contextlib
import io
import random
import unittest

import meshio
import numpy as np

from max_edge_test import longest_edge, shorten
from stored import ExportTest

BOTH = {"vtu": "vtu", "mesh": "mesh", "msh": "msh", "mshb": "msh"}  # format, ending
FLAT = BOTH | {"off": "off", "obj": "obj"}
WITH_DATA = {"vtu", "msh", "mshb"}
MAIN = {2: "triangle", 3: "tetra"}
FACET = {2: "line", 3: "triangle"}


def joined(mesh, kind):
    return np.concatenate([block.data for block in mesh.cells if block.type == kind])


class Meshio(ExportTest):
    def cloud(self):
        rng = random.Random(7)
        head = ("ply\nformat ascii 1.0\nelement vertex 400\nproperty double x\nproperty double y\nproperty double z\n"
                "property float weight\nproperty uchar kind\nproperty int depth\nend_header\n")
        rows = "".join(f"{rng.random()} {rng.random()} {rng.random()} {rng.randrange(64) / 8} {rng.randrange(256)} "
                       f"{rng.randrange(-999, 999)}\n" for _ in range(400))
        return self.write("cloud.ply", head + rows)

    def check(self, stored, path, with_data):
        mesh = meshio.read(path)
        ids = self.check_mesh(stored, mesh.points, joined(mesh, MAIN[stored.dimension]))
        self.assertLessEqual({block.type for block in mesh.cells}, {MAIN[stored.dimension], FACET[stored.dimension]})
        if with_data:
            for name in ("weight", "kind", "depth"):
                values = np.ravel(mesh.point_data[name]).tolist()
                self.assertEqual(values, [stored.attributes[name][i] for i in ids.tolist()])
        return mesh, ids

    def check_lengths(self, stored, mesh, ids):
        for block, lengths in zip(mesh.cells, mesh.cell_data["longest_edge"], strict=True):
            expected = [longest_edge(stored, cell) for cell in ids[block.data].tolist()]
            np.testing.assert_allclose(np.ravel(lengths), expected)

    def test_it_reads_the_formats_that_are_named_for_it(self):
        for dimension, formats, limit in ((2, FLAT, 0.06), (3, BOTH, 0.2)):
            for options in ([], ["--max-edge", str(limit)]):
                stored = self.stored(self.cloud(), "--dim", dimension, "--attributes", "all", "--tiles", "4", "--overwrite")
                if options:
                    self.assertGreater(shorten(stored, limit), 0)
                for name, ending in formats.items():
                    with self.subTest(dimension=dimension, format=name, options=options):
                        path = self.export("mesh." + ending, "--format", name, *options)
                        mesh, ids = self.check(stored, path, name in WITH_DATA)
                        if "longest_edge" in mesh.cell_data:
                            self.check_lengths(stored, mesh, ids)
                        self.assertEqual("longest_edge" in mesh.cell_data, name in WITH_DATA)
                        self.assertEqual(any(block.type == FACET[dimension] for block in mesh.cells), ending == "msh")

    def test_it_reads_the_file_of_each_tile(self):
        for dimension in (2, 3):
            stored = self.stored(self.xyz(n=500), "--dim", dimension, "--tiles", "3", "--overwrite")
            for name in ("msh", "mshb", "vtu", "mesh"):
                meshes = [meshio.read(path) for path in self.export("parts", "--format", name).iterdir()
                          if path.suffix != ".pvtu"]
                self.assertEqual(sum(len(joined(mesh, MAIN[dimension])) for mesh in meshes), len(stored.cells), name)

    def test_what_it_refuses_is_what_the_document_says(self):
        self.stored(self.xyz(n=100), "--dim", "3")
        for name in ("off", "ply"):
            with self.assertRaises((SystemExit, meshio.ReadError)), contextlib.redirect_stdout(io.StringIO()), \
                    contextlib.redirect_stderr(io.StringIO()):
                meshio.read(self.export("mesh." + name))


if __name__ == "__main__":
    unittest.main()
