"""tessera tileset: what is in the tree, that its levels join, how far they are off, and that others can read it."""
import collections
import json
import os
import pathlib
import random
import subprocess
import unittest

import numpy as np
import tiles3d
from cli import CORRUPT, IO, MEMORY, USAGE, CliTest
from stored import Stored
from tile_arrays import read_tile

IGN = pathlib.Path(os.environ["IGN"])
PACKAGES = pathlib.Path(os.environ["WEB_PACKAGES"])
STEP = 0.5  # points are on a lattice far wider than what is rounded, so that each is known again

BOX = {"type": "array", "items": {"type": "number"}, "minItems": 12, "maxItems": 12}
TILE = {"type": "object", "required": ["boundingVolume", "geometricError"], "additionalProperties": False, "properties": {
    "boundingVolume": {"type": "object", "required": ["box"], "additionalProperties": False, "properties": {"box": BOX}},
    "geometricError": {"type": "number", "minimum": 0}, "refine": {"enum": ["ADD", "REPLACE"]},
    "transform": {"type": "array", "items": {"type": "number"}, "minItems": 16, "maxItems": 16},
    "content": {"type": "object", "required": ["uri"], "additionalProperties": False,
                "properties": {"uri": {"type": "string"}, "extras": {}}},
    "children": {"type": "array", "minItems": 1, "uniqueItems": True, "items": {"$ref": "#/definitions/tile"}}, "extras": {}}}
SCHEMA = {"type": "object", "required": ["asset", "geometricError", "root"], "additionalProperties": False,  # of tileset.schema.json, 1.1
          "definitions": {"tile": TILE}, "properties": {
              "asset": {"type": "object", "required": ["version"], "additionalProperties": False,
                        "properties": {"version": {"const": "1.1"}, "tilesetVersion": {"type": "string"}, "extras": {}}},
              "geometricError": {"type": "number", "minimum": 0}, "root": {"$ref": "#/definitions/tile"}, "extras": {}}}


class Result(Stored):
    """Rows of vertices as arrays, in place of ids."""

    def __init__(self, folder):
        super().__init__(folder)
        ids = sorted(self.points)
        number = {vertex: i for i, vertex in enumerate(ids)}
        self.points = np.array([self.points[vertex] for vertex in ids])
        self.cells = np.array([[number[vertex] for vertex in cell] for cell in self.cells])
        self.columns = {name: [values[vertex] for vertex in ids] for name, values in self.attributes.items()}
        owners = {}
        for path in (folder / "tiles").iterdir():
            arrays = read_tile(path)
            owners.update(zip(arrays["PointData/id"].tolist(), arrays["PointData/owner"].tolist()))
        self.columns["owner"] = [owners[vertex] for vertex in ids]


def known(surface, origin):
    """The triangles as sets of lattice points: vertices are found again, whatever node they come from."""
    places = (surface.positions[:, :2] - origin) / STEP
    assert np.abs(places - places.round()).max() < 0.1
    rows = [tuple(row) for row in places.round().astype(int).tolist()]
    return [tuple(rows[v] for v in triangle) for triangle in surface.triangles]


def border(triangles):
    edges = collections.Counter(frozenset(edge) for a, b, c in triangles for edge in ((a, b), (b, c), (c, a)))
    return {edge for edge, times in edges.items() if times == 1}


def heights(points, surface):
    """How far each point is above or below the surface: by looking at every triangle."""
    a, b, c = (surface.positions[surface.triangles[:, k]] for k in range(3))
    all_of = (b[:, 0] - a[:, 0]) * (c[:, 1] - a[:, 1]) - (b[:, 1] - a[:, 1]) * (c[:, 0] - a[:, 0])
    found = []
    for x, y, z in points:
        wa = (b[:, 0] - x) * (c[:, 1] - y) - (b[:, 1] - y) * (c[:, 0] - x)
        wb = (c[:, 0] - x) * (a[:, 1] - y) - (c[:, 1] - y) * (a[:, 0] - x)
        with np.errstate(all="ignore"):
            wa, wb = wa / all_of, wb / all_of
            height = np.abs(wa * a[:, 2] + wb * b[:, 2] + (1 - wa - wb) * c[:, 2] - z)
            inside = (wa > -1e-3) & (wb > -1e-3) & (wa + wb < 1 + 1e-3)
        found.append(height[inside].min() if inside.any() else np.nan)
    return np.array(found)


class Tilesets(CliTest):
    def cloud(self, n=30000, origin=(0, 0), relief=20.0, name="cloud.csv"):
        dice = random.Random(5)
        side = int((3 * n) ** 0.5)
        places = dice.sample(range(side * side), n)
        rows = [(origin[0] + i % side * STEP, origin[1] + i // side * STEP, relief * np.sin(i % side / 40) * np.cos(i // side / 30),
                 dice.randrange(3000), dice.choice((2, 6))) for i in places]
        return self.write(name, "x,y,z,intensity,classification\n" + "".join(
            f"{x!r},{y!r},{float(z)!r},{i},{c}\n" for x, y, z, i, c in rows))

    def result(self, *options, **cloud):
        out = self.folder / "out"
        self.ok("triangulate", self.cloud(**cloud), "--dim", "2", "-o", out, "--quiet", "--overwrite", "--attributes",
                "intensity,classification", *options)
        return out

    def tileset(self, out, *options, name="tiles"):
        told = json.loads(self.ok("tileset", out, "-o", name, "--json", *options).splitlines()[-1])
        return told, *tiles3d.read(self.folder / name)

    def test_the_leaves_have_each_cell_once_and_levels_join(self):
        for tiles in (("--tiles", "1"), ("--tiles", "7"), ("--tiles", "9", "--partition", "octree"), ("--tiles", "6", "--partition", "grid")):
            with self.subTest(tiles=tiles):
                out = self.result(*tiles)
                told, document, root = self.tileset(out, "--overwrite")
                stored = Result(out)
                cells = collections.Counter(frozenset(tuple((stored.points[v][:2] / STEP).round().astype(int)) for v in cell)
                                            for cell in stored.cells)
                leaves = root.leaves()
                self.assertEqual(collections.Counter(frozenset(t) for leaf in leaves for t in known(leaf.surface, 0)), cells)
                self.assertEqual(told["triangles"], len(stored.cells))
                self.assertEqual((told["nodes"], told["leaves"]), (len(root.all()), len(leaves)))
                self.assertGreater(len(root.children), 1)
                for node in root.all():
                    if node.children:
                        below = [t for leaf in node.leaves() for t in known(leaf.surface, 0)]
                        self.assertEqual(border(known(node.surface, 0)), border(below), node.path)
                        self.assertLess(len(node.surface.triangles), max(len(below), 16385))
                        self.assertGreaterEqual(node.error, max(child.error for child in node.children))
                    else:
                        self.assertEqual(node.error, 0)
                        self.assertLessEqual(len(node.surface.triangles), 16384)

    def test_errors_are_what_the_surfaces_are_off(self):
        _, _, root = self.tileset(self.result("--tiles", "3"))
        inner = [node for node in root.all() if node.children]
        self.assertGreater(len(inner), 0)
        for node in inner:
            points = np.unique(np.concatenate([child.surface.positions.round(3) for child in node.children]), axis=0)
            points = points[np.unique(points[:, :2].round(1), axis=0, return_index=True)[1]]  # borders are in two of them
            kept = {tuple(row) for row in (node.surface.positions[:, :2] / STEP).round().astype(int).tolist()}
            gone = [point for point in points if tuple((point[:2] / STEP).round().astype(int).tolist()) not in kept]
            off = np.concatenate([heights(gone, node.surface), np.zeros(len(points) - len(gone))])
            self.assertFalse(np.isnan(off).any())
            step = node.error - max(child.error for child in node.children)
            self.assertGreater(step, 0)
            self.assertAlmostEqual(step, np.sqrt((off ** 2).mean()), delta=0.02 * step + 2 * node.surface.step[2])

    def test_vertices_keep_what_they_have(self):
        out = self.result("--tiles", "4")
        _, document, root = self.tileset(out)
        stored = Result(out)
        of = {tuple((p[:2] / STEP).round().astype(int)): i for i, p in enumerate(stored.points)}
        for node in root.all():
            s = node.surface
            rows = [of[tuple(r)] for r in (s.positions[:, :2] / STEP).round().astype(int)]
            self.assertLess(np.abs(s.positions - stored.points[rows]).max(0).tolist(), (s.step * 0.51).tolist())
            for name, column in (("_INTENSITY", "intensity"), ("_CLASSIFICATION", "classification"), ("_TILE", "owner")):
                self.assertEqual(s.attributes[name].tolist(), [stored.columns[column][row] for row in rows], name)
            centre, half = node.box
            self.assertTrue((np.abs(s.positions - centre) <= half + s.step).all())
        self.assertEqual(document["extras"]["classes"], [2, 6])
        self.assertEqual(document["extras"]["intensityMax"], max(stored.columns["intensity"]))
        self.assertEqual(document["extras"]["vertices"], len(stored.points))

    def test_large_coordinates_lose_nothing(self):
        origin = (885000.0, 6290000.0)
        _, _, root = self.tileset(self.result("--tiles", "3", origin=origin, n=20000))
        for node in root.all():
            known(node.surface, np.array(origin))
            self.assertLess(np.abs(node.surface.document["nodes"][0]["translation"]).max(), 1000)

    def test_made_again_it_is_the_same(self):
        out = self.result("--tiles", "5", n=20000)
        self.tileset(out, name="a")
        self.tileset(out, name="b")
        self.assertEqual(*(sorted((p.name, p.read_bytes()) for p in (self.folder / name).rglob("*.*") if p.is_file()) for name in "ab"))

    def test_flat_and_small_surfaces_are_one_leaf(self):
        _, document, root = self.tileset(self.result(n=50, relief=0))
        self.assertEqual((root.children, root.error), ([], 0))
        self.assertEqual(document["extras"]["heights"], [0, 0])

    def test_long_cells_are_left_out_when_asked(self):
        out = self.result("--tiles", "3", n=5000)
        told, _, root = self.tileset(out, "--max-edge", "2")
        stored = Result(out)
        corners = stored.points[stored.cells][:, :, :2]
        longest = np.sqrt(((corners - np.roll(corners, 1, 1)) ** 2).sum(2)).max(1)
        self.assertGreater(told["left_out"], 0)
        self.assertEqual(told["triangles"], int((longest <= 2).sum()))
        self.assertEqual(sum(len(leaf.surface.triangles) for leaf in root.leaves()), told["triangles"])
        self.refused(USAGE, "tileset", out, "--max-edge", "0.01", "-o", "none", says="no triangles")

    def test_it_fits_the_schema_and_the_validator_finds_no_errors(self):
        import jsonschema
        out = self.folder / "ground"
        self.ok("triangulate", *sorted(IGN.glob("*.las")), "--dim", "2", "--tiles", "5", "-o", out, "--quiet")
        _, document, root = self.tileset(out)
        jsonschema.validate(document, SCHEMA)
        with self.assertRaises(jsonschema.ValidationError):
            jsonschema.validate({**document, "root": {**document["root"], "refine": "replace"}}, SCHEMA)
        program = self.write("validate.js", """
            const validator = require(process.argv[2]), fs = require("fs");
            (async () => { for (const file of process.argv.slice(3)) {
                const report = await validator.validateBytes(new Uint8Array(fs.readFileSync(file)), {ignoredIssues: ["UNSUPPORTED_EXTENSION"]});
                console.log(JSON.stringify(report.issues)); } })();""")
        names = [str(node.path) for node in root.all()]
        bad = self.folder / "bad.glb"
        bad.write_bytes(root.data.replace(b'"VEC3"', b'"VEC9"'))
        done = subprocess.run(["node", str(program), str(PACKAGES / "gltf-validator"), *names, str(bad)], capture_output=True, text=True, check=True)
        reports = [json.loads(line) for line in done.stdout.splitlines()]
        self.assertEqual(len(reports), len(names) + 1)
        self.assertGreater(reports.pop()["numErrors"], 0)
        for name, report in zip(names, reports):
            self.assertEqual((report["numErrors"], report["numWarnings"]), (0, 0), (name, report))

    def test_what_cannot_be_is_refused_and_leaves_nothing(self):
        out = self.result("--tiles", "2", n=2000)
        flat = self.folder / "3d"
        self.ok("triangulate", self.folder / "cloud.csv", "--dim", "3", "-o", flat, "--quiet")
        self.refused(USAGE, "tileset", flat, "-o", "x", says="3D result")
        self.refused(USAGE, "tileset", out, says="-o")
        self.refused(MEMORY, "tileset", out, "-o", "x", "--memory", "1", says="memory")
        spread = self.folder / "spread"
        self.ok("triangulate", self.folder / "cloud.csv", "--dim", "2", "--tiles", "3", "--partition", "random", "-o", spread, "--quiet")
        self.refused(USAGE, "tileset", spread, "-o", "x", says="side by side")
        mine = self.folder / "mine"
        mine.mkdir()
        (mine / "letter.txt").write_text("dear")
        self.refused(USAGE, "tileset", out, "-o", mine, says="exists already")
        self.refused(USAGE, "tileset", out, "-o", mine, "--overwrite", says="is not a tileset")
        self.assertEqual((mine / "letter.txt").read_text(), "dear")
        self.refused(IO, "tileset", out, "-o", mine / "letter.txt" / "x")
        tile = out / "tiles/000001.vtu"
        tile.write_bytes(tile.read_bytes()[:-500] + bytes(500))
        self.refused(CORRUPT, "tileset", out, "-o", "x", says="000001.vtu")
        self.assertEqual([p for p in self.folder.iterdir() if p.name.startswith("x")], [])


if __name__ == "__main__":
    unittest.main()
