"""What the viewer is shown of 3D results: hull, sections and cells as glTF, which a reader of our own takes apart."""
import collections
import json
import os
import pathlib
import subprocess
import unittest

import numpy as np
import tiles3d
from daemon import DaemonTest
from tile_arrays import read_tile

PACKAGES = pathlib.Path(os.environ["WEB_PACKAGES"])


def facets_of(cells):
    """Of rows of four: facets as rows of three, each seen from outside."""
    return np.concatenate([cells[:, order] for order in ([1, 2, 3], [0, 3, 2], [0, 1, 3], [0, 2, 1])])


class Shapes(DaemonTest):
    def setUp(self):
        super().setUp()
        self.daemon = self.start()
        self.files = []
        for name, dim in (("flat", 2), ("solid", 3)):
            inputs = {"inputs": ["ign_77050_627755.las"], "output": name, "dim": dim, "tiles": 6, "attributes": ["intensity", "classification"]}
            status, _, job = self.daemon.request("POST", "/v1/processes/triangulate/execution", {"inputs": inputs})
            self.assertEqual(status, 201, job)
            self.assertEqual(self.daemon.wait(job["jobID"])["status"], "successful")
        result = self.folder / "data/results/solid"
        self.cells = {}    # by tile: of each cell of its file the corners
        self.values = {}   # by tile: of each cell the corners' intensities
        ids = []
        for file in sorted((result / "tiles").glob("*.vtu")):
            arrays = read_tile(file)
            rows = arrays["Cells/connectivity"].reshape(-1, 4)
            self.cells[int(file.stem)] = arrays["Points"][rows]
            self.values[int(file.stem)] = arrays["PointData/intensity"][rows]
            ids.append(arrays["PointData/id"][rows[arrays["CellData/vtkGhostType"] == 0]])
        self.main = np.concatenate([self.cells[tile][read_tile(result / f"tiles/{tile:06d}.vtu")["CellData/vtkGhostType"] == 0] for tile in self.cells])
        self.ids = np.concatenate(ids)
        box = self.daemon.request("GET", "/v1/triangulations/solid")[2]["bounds"]
        self.low, self.high = np.array(box[:3]), np.array(box[3:])

    def ask(self, question, name="solid"):
        return self.daemon.request("GET", f"/v1/triangulations/{name}/shapes/{question}")

    def shape(self, question):
        status, headers, data = self.ask(question)
        self.assertEqual((status, headers["Content-Type"]), (200, "model/gltf-binary"), data)
        self.files.append(data)
        origin = json.loads(data[20:20 + int.from_bytes(data[12:16], "little")])["scenes"][0]["extras"]["origin"]
        glb = tiles3d.Glb(data, [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, *origin, 1])
        low, high = glb.attributes["_CELL"].astype(int).T
        tiles = glb.attributes["_TILE"].astype(int)
        corners = np.array([self.cells[tile][cell] for tile, cell in zip(tiles, low + 65536 * high)])
        return glb, glb.document["scenes"][0]["extras"], corners, list(zip(tiles, low + 65536 * high))

    def test_the_hull_is_that_of_the_stored_cells(self):
        glb, told, corners, names = self.shape("hull")
        times = collections.Counter(frozenset(facet) for facet in facets_of(self.ids).tolist())
        self.assertEqual(len(glb.triangles), sum(1 for n in times.values() if n == 1))
        # Each vertex is one of its cell's, and has that one's values.
        away = np.linalg.norm(corners - glb.positions[:, None], axis=2)
        self.assertLess(away.min(1).max(), np.linalg.norm(glb.step))
        right = np.array([self.values[tile][cell] for tile, cell in names])
        self.assertTrue((right == glb.attributes["_INTENSITY"].astype(int)[:, None]).any(1).all())
        # Closed, and turned outwards: it encloses what the cells fill.
        a, b, c = (glb.positions[glb.triangles[:, k]] - self.low for k in range(3))
        edges = self.main[:, 1:] - self.main[:, :1]
        volume = np.linalg.det(edges).sum() / 6
        self.assertAlmostEqual(np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6 / volume, 1, delta=1e-3)
        self.assertEqual((told["kind"], told["cells"], told["tiles"]), ("hull", len(set(names)), 6))
        self.check_files()

    def test_without_long_edges_it_is_the_border_of_the_other_cells(self):
        edges = np.linalg.norm(self.main[:, [0, 0, 0, 1, 1, 2]] - self.main[:, [1, 2, 3, 2, 3, 3]], axis=2).max(1)
        lengths = np.array(self.shape("hull")[1]["edgeLengths"])
        wanted = np.quantile(edges, np.linspace(0, 1, 101), method="inverted_cdf")
        self.assertTrue(((lengths >= wanted * (1 - 1e-12)) & (lengths < wanted * 1.03)).all())
        for longest in (0.8, 3.0):
            glb, told, corners, names = self.shape(f"hull?max-edge={longest}&limit=1000000")
            times = collections.Counter(frozenset(facet) for facet in facets_of(self.ids[edges <= longest]).tolist())
            self.assertEqual(len(glb.triangles), sum(1 for n in times.values() if n == 1))
            self.assertEqual(told["cells"], len(set(names)))
            self.assertLessEqual(np.linalg.norm(corners[:, [0, 0, 0, 1, 1, 2]] - corners[:, [1, 2, 3, 2, 3, 3]], axis=2).max(), longest)
            # Closed, and turned outwards.
            a, b, c = (glb.positions[glb.triangles[:, k]] - self.low for k in range(3))
            rows = self.main[edges <= longest]
            volume = np.linalg.det(rows[:, 1:] - rows[:, :1]).sum() / 6
            self.assertAlmostEqual(np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6 / volume, 1, delta=2e-2)
        middle = (self.low + self.high) / 2
        box = ",".join(map(repr, [*(middle - 4).tolist(), *(middle + 4).tolist()]))
        every, short = self.shape(f"cells?bbox={box}"), self.shape(f"cells?bbox={box}&max-edge=2")
        of = lambda shape: np.linalg.norm(shape[2][:, [0, 0, 0, 1, 1, 2]] - shape[2][:, [1, 2, 3, 2, 3, 3]], axis=2).max(1)
        self.assertEqual(set(short[3]), {name for name, length in zip(every[3], of(every)) if length <= 2})
        plane = f"section?through={','.join(map(repr, middle.tolist()))}&normal=1,0,0"
        every, short = self.shape(plane), self.shape(f"{plane}&max-edge=2")
        self.assertEqual(set(short[3]), {name for name, length in zip(every[3], of(every)) if length <= 2})
        self.check_files()

    def test_a_section_fills_what_the_plane_has_of_the_hull(self):
        hull = self.shape("hull")[0]
        facets = hull.positions[hull.triangles]
        middle = (self.low + self.high) / 2
        for normal in (np.array([0, 0, 1.0]), np.array([1.0, 0, 0]), np.array([0.6, -0.5, 3])):
            text = ",".join(map(repr, middle.tolist())) + "&normal=" + ",".join(map(repr, normal.tolist()))
            glb, told, corners, names = self.shape(f"section?through={text}")
            unit = normal / np.linalg.norm(normal)
            self.assertLess(np.abs((glb.positions - middle) @ unit).max(), np.linalg.norm(glb.step))
            sides = (corners - middle) @ unit
            self.assertTrue(((sides.max(1) >= 0) & (sides.min(1) <= 0)).all())
            on_both = ((self.main - middle) @ unit >= 0).any(1) & ((self.main - middle) @ unit < -1e-9).any(1)
            self.assertLessEqual(abs(len(set(names)) - on_both.sum()), 0.02 * on_both.sum())  # those cut at a vertex alone are left out
            self.assertEqual(told["cells"], len(set(names)))
            triangles = glb.positions[glb.triangles]
            area = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]) @ unit / 2
            # The same by its border: where the plane cuts the hull.
            border = 0
            for facet in facets:
                above = (facet - middle) @ unit >= 0
                if above.all() or not above.any():
                    continue
                heights = (facet - middle) @ unit
                cut = {}
                for k in range(3):
                    n = (k + 1) % 3
                    if above[k] != above[n]:
                        cut[above[k]] = facet[k] + (facet[n] - facet[k]) * heights[k] / (heights[k] - heights[n])
                border += np.cross(cut[False] - middle, cut[True] - middle) @ unit / 2
            self.assertAlmostEqual(area.sum() / abs(border), 1, delta=2e-3)
        # Of a part of it, those pieces that are there.
        box = ",".join(map(repr, [*self.low.tolist(), *middle.tolist()]))
        whole = self.shape(f"section?through={text}")[3]
        part = self.shape(f"section?through={text}&bbox={box}")[3]
        self.assertLess(set(part), set(whole))
        # Beside the hull there is a scene with nothing in it.
        status, _, empty = self.ask(f"section?through={self.high[0] + 5!r},0,0&normal=1,0,0")
        self.assertEqual(status, 200)
        self.files.append(empty)
        self.check_files()

    def test_cells_are_drawn_towards_their_means(self):
        middle = (self.low + self.high) / 2
        box = ",".join(map(repr, [*(middle - 4).tolist(), *(middle + 4).tolist()]))
        for shrink in (1, 0.4):
            glb, told, corners, names = self.shape(f"cells?bbox={box}&shrink={shrink}")
            self.assertEqual(len(glb.positions), 4 * told["cells"])
            self.assertEqual(len(glb.triangles), 4 * told["cells"])
            self.assertEqual(len(set(names)), told["cells"])
            rows = corners[::4]
            wanted = rows.mean(1, keepdims=True) + shrink * (rows - rows.mean(1, keepdims=True))
            self.assertLess(np.abs(glb.positions.reshape(-1, 4, 3) - wanted).max(), np.linalg.norm(glb.step))
            # Each is closed, and seen from outside.
            a, b, c = (glb.positions[glb.triangles[:, k]] - middle for k in range(3))
            volume = np.linalg.det(rows[:, 1:] - rows[:, :1]).sum() / 6 * shrink ** 3
            self.assertAlmostEqual(np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6 / volume, 1, delta=1e-2)
        self.check_files()

    def test_a_cell_is_told_by_its_name(self):
        names = self.shape("hull")[3][:10]
        for tile, cell in names:
            status, _, found = self.daemon.request("GET", f"/v1/triangulations/solid/locate?cell={tile},{cell}")
            self.assertEqual((status, found["tile"], found["cell"]), (200, tile, cell))
            self.assertEqual([corner["point"] for corner in found["vertices"]], self.cells[tile][cell].tolist())
            self.assertIn(None, found["neighbors"])
        for wrong, said in (("1", "cell: must be TILE,CELL"), ("a,b", "cell: must be"), ("1,-1", "cell: must be"), ("0,1&point=1,2,3", "cell: must be"),
                            ("99999,1", "has no tile 99999"), ("0,99999999", "no main cell 99999999")):
            status, _, problem = self.daemon.request("GET", f"/v1/triangulations/solid/locate?cell={wrong}")
            self.assertEqual(status, 400, problem)
            self.assertIn(said, problem["detail"])

    def test_what_cannot_be_shown_is_a_sentence(self):
        box = ",".join(map(repr, [*self.low.tolist(), *self.high.tolist()]))
        for question, status, said in (
                ("hull?max-edge=0", 400, "max-edge: "), ("cells?bbox=0,0,0,1,1,1&max-edge=x", 400, "max-edge: "), ("hull?limit=10", 422, "the hull has more than 10 cells"), ("hull?limit=0", 400, "limit: "),
                (f"cells?bbox={box}&limit=100", 422, "the area has more than 100 cells"), ("cells", 400, "bbox"),
                (f"cells?bbox={box}&shrink=2", 400, "shrink: must be"), ("section?normal=0,0,1", 400, "through: "),
                ("section?through=0,0,0&normal=0,0,0", 400, "normal: "), ("section?through=0,0,nan&normal=0,0,1", 400, "through: "),
                (f"section?through={','.join(map(repr, ((self.low + self.high) / 2).tolist()))}&normal=0,0,1&limit=5", 422, "the section has more than 5")):
            found = self.ask(question)
            self.assertEqual(found[0], status, (question, found))
            self.assertIn(said, found[2]["detail"])
        for question in ("hull", "cells?bbox=0,0,1,1", "section?through=0,0,0&normal=0,0,1"):
            found = self.ask(question, "flat")
            self.assertEqual(found[0], 400)
            self.assertIn("2D result", found[2]["detail"])

    def check_files(self):
        names = []
        for i, data in enumerate(self.files):
            names.append(self.folder / f"{i}.glb")
            names[-1].write_bytes(data)
        bad = self.folder / "bad.glb"
        bad.write_bytes(self.files[0].replace(b'"VEC3"', b'"VEC9"'))
        program = self.folder / "validate.js"
        program.write_text("""
            const validator = require(process.argv[2]), fs = require("fs");
            (async () => { for (const file of process.argv.slice(3)) {
                const report = await validator.validateBytes(new Uint8Array(fs.readFileSync(file)), {ignoredIssues: ["UNSUPPORTED_EXTENSION"]});
                console.log(JSON.stringify(report.issues)); } })();""")
        done = subprocess.run(["node", program, PACKAGES / "gltf-validator", *names, bad], capture_output=True, text=True, check=True)
        reports = [json.loads(line) for line in done.stdout.splitlines()]
        self.assertEqual(len(reports), len(names) + 1)
        self.assertGreater(reports.pop()["numErrors"], 0)
        for report in reports:
            self.assertEqual((report["numErrors"], report["numWarnings"]), (0, 0), report)


if __name__ == "__main__":
    unittest.main()
