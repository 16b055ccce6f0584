"""Regions, rasters and lines as jobs of the daemon, and questions to results that are regions: what is said to be final is so."""
import json
import re
import unittest

import numpy as np

from daemon import IGN, DaemonTest

INPUTS = {"inputs": ["ign_77050_627755.las"]}


class WithDaemon(DaemonTest):
    def setUp(self):
        super().setUp()
        self.daemon = self.start()
        self.cloud = IGN / "ign_77050_627755.las"

    def execute(self, process, **inputs):
        status, _, job = self.daemon.request("POST", f"/v1/processes/{process}/execution", {"inputs": inputs})
        self.assertEqual(status, 201, job)
        job = self.daemon.wait(job["jobID"])
        self.assertEqual(job["status"], "successful", job)
        return job, self.daemon.request("GET", f"/v1/jobs/{job['jobID']}/results")[2].get("outcome", {}).get("value")

    def refused(self, process, **inputs):
        status, _, told = self.daemon.request("POST", f"/v1/processes/{process}/execution", {"inputs": inputs})
        self.assertGreaterEqual(status, 400, told)
        return status, told["detail"]

    def estimate(self, process, **inputs):
        status, _, told = self.daemon.request("POST", f"/v1/processes/{process}/estimate", {"inputs": inputs})
        self.assertEqual(status, 200, told)
        return told

    def middle(self, half=10):
        box = json.loads(self.tessera("info", self.cloud, "--json"))["files"][0]["bounds"]
        x, y = ((box["min"][axis] + box["max"][axis]) / 2 for axis in (0, 1))
        return [x - half, y - half, x + half, y + half]

    def tile(self, folder):
        (file,) = (folder / "tiles").iterdir()
        return file.read_bytes()


class Jobs(WithDaemon):
    def test_a_region_is_that_of_the_command_and_what_was_read_is_kept(self):
        box = self.middle()
        told = self.estimate("region", **INPUTS, bbox=box, dim=2)
        self.assertTrue(told["accepted"])
        job, outcome = self.execute("region", **INPUTS, bbox=box, dim=2, output="part")
        self.assertGreater(outcome["read_bytes"], 0)
        self.assertTrue(outcome["complete"])
        self.tessera("region", self.cloud, "--dim", 2, f"--bbox={','.join(map(repr, box))}", "-o", "here")
        self.assertEqual(self.tile(self.folder / "data/results/part"), self.tile(self.folder / "here"))
        other = self.middle(20)
        _, again = self.execute("region", **INPUTS, bbox=other, dim=2, output="more")
        self.assertEqual((again["read_bytes"], again["points_read"]), (0, 0))
        self.tessera("region", self.cloud, "--dim", 2, f"--bbox={','.join(map(repr, other))}", "-o", "there")
        self.assertEqual(self.tile(self.folder / "data/results/more"), self.tile(self.folder / "there"))
        # With other options it is another cloud.
        _, other = self.execute("region", **INPUTS, bbox=box, dim=2, attributes=["intensity"], output="other")
        self.assertGreater(other["read_bytes"], 0)
        ring = [[box[0], box[1]], [box[2], box[1]], [box[0], box[3]], [box[0], box[1]]]
        _, outcome = self.execute("region", **INPUTS, dim=2, output="triangle",
                                  polygon=json.dumps({"type": "Polygon", "coordinates": [ring]}))
        (self.folder / "area.geojson").write_text(json.dumps({"type": "Polygon", "coordinates": [ring]}))
        self.tessera("region", self.cloud, "--dim", 2, "--polygon", "area.geojson", "-o", "corner")
        self.assertEqual(self.tile(self.folder / "data/results/triangle"), self.tile(self.folder / "corner"))
        names = [one["name"] for one in self.daemon.request("GET", "/v1/triangulations")[2]["triangulations"]]
        self.assertEqual(names, ["more", "other", "part", "triangle"])

        self.assertEqual(self.refused("region", **INPUTS, bbox=box, output="part")[0], 409)
        for inputs, says in (({}, "bbox or polygon"), ({"bbox": [1, 2, 3]}, "bbox"), ({"bbox": [2, 2, 1, 1]}, "bbox"),
                             ({"polygon": "{"}, "polygon: is not JSON"), ({"bbox": box, "polygon": "{}"}, "bbox or polygon"),
                             ({"bbox": box, "max_seconds": 0}, "max_seconds")):
            status, detail = self.refused("region", **INPUTS, **inputs)
            self.assertEqual(status, 400, detail)
            self.assertIn(says, detail)
        self.assertEqual(self.daemon.end(), 0, self.daemon.messages())

    def test_a_region_that_needs_more_than_it_may_fails_or_is_a_part(self):
        box = self.middle()
        told = self.estimate("region", **INPUTS, bbox=box, dim=2, max_points=100)
        self.assertFalse(told["accepted"])
        self.assertIn("100", told["reason"])
        status, _, job = self.daemon.request("POST", "/v1/processes/region/execution",
                                             {"inputs": INPUTS | {"bbox": box, "dim": 2, "max_points": 100}})
        job = self.daemon.wait(job["jobID"])
        self.assertEqual((job["status"], job["problem"]["status"]), ("failed", 422), job)
        self.assertIn("max_points", job["problem"]["detail"])
        self.assertEqual(self.daemon.request("GET", "/v1/triangulations")[2]["triangulations"], [])
        self.assertEqual(self.daemon.end(), 0, self.daemon.messages())

    def test_rasters_and_lines_are_the_files_of_the_command(self):
        self.execute("triangulate", **INPUTS, dim=2, output="ground", tiles=4)
        result = self.folder / "data/results/ground"
        told = self.estimate("dem", triangulation="ground", res=0.5)
        self.assertTrue(told["accepted"])
        self.assertGreater(told["resultBytes"], 0)
        self.assertTrue(self.estimate("contours", triangulation="ground", interval=1)["accepted"])
        _, outcome = self.execute("dem", triangulation="ground", res=0.5, max_edge=5)
        self.tessera("dem", result, "--res", 0.5, "--max-edge", 5, "-o", "dem.tif")
        self.assertEqual((result / "exports/dem.tif").read_bytes(), (self.folder / "dem.tif").read_bytes())
        self.assertEqual((outcome["output"], outcome["written"][0]["path"]), ("dem.tif", "exports/dem.tif"))
        self.execute("contours", triangulation="ground", interval=1, output="lines.geojson")
        self.tessera("contours", result, "--interval", 1, "-o", "lines.geojson")
        self.assertEqual((result / "exports/lines.geojson").read_bytes(), (self.folder / "lines.geojson").read_bytes())
        self.assertEqual(self.refused("dem", triangulation="ground", res=1)[0], 409)
        self.execute("dem", triangulation="ground", res=1, overwrite=True, hillshade=True)
        for process, inputs, status, says in (
                ("dem", {"triangulation": "none", "res": 1}, 422, "none called"),
                ("dem", {"triangulation": "ground"}, 400, "res"),
                ("dem", {"triangulation": "ground", "res": 1, "output": "x.png"}, 400, ".tif"),
                ("dem", {"triangulation": "ground", "res": 1, "azimuth": 3}, 400, "hillshade"),
                ("dem", {"triangulation": "ground", "res": 1e-9}, 400, "res"),
                ("contours", {"triangulation": "ground"}, 400, "interval"),
                ("contours", {"triangulation": "ground", "interval": 1, "output": "../x.gpkg"}, 400, "output")):
            with self.subTest(f"{process} {inputs}"):
                self.assertEqual(self.refused(process, **inputs)[0], status)
                self.assertIn(says, self.refused(process, **inputs)[1])
        self.assertEqual(sorted(file.name for file in (result / "exports").iterdir() if not file.name.endswith(".owner")),
                         ["dem.tif", "lines.geojson"])
        self.assertEqual(self.daemon.end(), 0, self.daemon.messages())

    def test_rasters_and_lines_of_a_region_are_the_files_of_the_command(self):
        box = self.middle()
        corner = json.dumps({"type": "Polygon", "coordinates": [[box[:2], [box[2], box[1]], box[2:], box[:2]]]})
        self.execute("region", **INPUTS, bbox=box, dim=2, output="square")
        self.execute("region", **INPUTS, polygon=corner, dim=2, output="corner")
        inner = self.middle(4)
        for name, near, final in (("square", inner, True), ("square", None, False), ("corner", None, False)):
            where = {"bbox": near} if near else {}
            flags = ("--bbox", ",".join(map(repr, near))) if near else ()
            for process, inputs, args, file in (("dem", {"res": 0.5, "output": "a.tif"}, ("--res", 0.5), "a.tif"),
                                                ("contours", {"interval": 0.5, "output": "a.geojson"}, ("--interval", 0.5), "a.geojson")):
                with self.subTest(f"{process} of {name} {near}"):
                    self.assertTrue(self.estimate(process, triangulation=name, **inputs, **where)["accepted"])
                    _, outcome = self.execute(process, triangulation=name, overwrite=True, **inputs, **where)
                    result = self.folder / "data/results" / name
                    told = json.loads(self.tessera(process, result, *args, *flags, "-o", file, "--overwrite", "--json").splitlines()[-1])
                    self.assertEqual((result / "exports" / file).read_bytes(), (self.folder / file).read_bytes())
                    # What is not provably that of the whole is said not to be.
                    self.assertEqual(outcome.get("note"), told.get("note"))
                    self.assertEqual("the region does not hold all cells" not in outcome.get("note", ""), final)
        self.execute("region", **INPUTS, bbox=inner, dim=3, output="cube")
        for process, inputs in (("dem", {"res": 1}), ("contours", {"interval": 1})):
            status, detail = self.refused(process, triangulation="cube", **inputs)
            self.assertEqual(status, 400)
            self.assertIn("3D", detail)
        self.assertEqual(self.daemon.end(), 0, self.daemon.messages())


class Questions(WithDaemon):
    """Of the whole and of a region of it: whatever is final in an answer of the region is what the whole answers."""

    def ask(self, name, question, body=None, method=None):
        status, headers, found = self.daemon.request(method or ("POST" if body else "GET"), f"/v1/triangulations/{name}/{question}", body)
        self.assertEqual(status, 200, found)
        return headers["Tessera-Final"] == "true", found

    def test_final_answers_of_a_region_are_those_of_the_whole(self):
        box = self.middle(6)
        x, y = (box[0] + box[2]) / 2, (box[1] + box[3]) / 2
        places = np.random.default_rng(5).uniform(-9, 9, (500, 2)) + [x, y]
        for dim in (2, 3):
            self.execute("triangulate", **INPUTS, dim=dim, output=f"whole{dim}", tiles=5)
            low, high = self.daemon.request("GET", f"/v1/triangulations/whole{dim}")[2]["bounds"][dim - 1::dim] if dim == 3 else (0, 0)
            asked = box if dim == 2 else box[:2] + [low] + box[2:] + [(low + high) / 2]
            self.execute("region", **INPUTS, dim=dim, bbox=asked, output=f"part{dim}")
            heights = np.random.default_rng(6).uniform(low, high, (500, dim - 2))
            points = np.hstack([places, heights]).tolist()
            all_final, part = self.ask(f"part{dim}", "locate", {"points": points})
            whole = self.ask(f"whole{dim}", "locate", {"points": points})[1]["answers"]
            self.assertFalse(all_final)
            final = 0
            for point, here, there in zip(points, part["answers"], whole):
                inside = all(low <= at <= high for at, low, high in zip(point, asked, asked[dim:]))
                self.assertTrue(here["final"] or not inside, point)
                if not here["final"]:
                    continue
                final += 1
                self.assertEqual(sorted(here.get("vertices", [])), sorted(there.get("vertices", [])), point)
            self.assertGreater(final, 100)
            self.assertLess(final, 500)

            # Stars, of vertices of cells that are there.
            vertices = sorted({v for one in part["answers"] for v in one.get("vertices", [])})[::7]
            stars = 0
            for vertex in vertices:
                told, star = self.ask(f"part{dim}", f"vertices/{vertex}/star")
                self.assertEqual(told, star["final"])
                if not told:
                    continue
                stars += 1
                right = self.ask(f"whole{dim}", f"vertices/{vertex}/star")[1]
                cells = [sorted(map(sorted, (cell["vertices"] for cell in one["cells"]))) for one in (star, right)]
                self.assertEqual(*cells)
                self.assertEqual(star["on_hull"], right["on_hull"])
                self.assertAlmostEqual(*(one["voronoi_volume"] or 0 for one in (star, right)), 6)
            self.assertGreater(stars, 5)

            if dim == 2:
                for method in ("linear", "natural"):
                    _, here = self.ask("part2", f"interpolate?method={method}", {"points": points})
                    _, there = self.ask("whole2", f"interpolate?method={method}", {"points": points})
                    compared = 0
                    for one, other in zip(here["answers"], there["answers"]):
                        if one["final"]:
                            compared += 1
                            self.assertEqual(one["value"] is None, other["value"] is None)
                            self.assertLess(abs((one["value"] or 0) - (other["value"] or 0)), 1e-9)
                    self.assertGreater(compared, 100)
                self.drawn(box, x, y)
            known = next(point for point, one in zip(points, part["answers"]) if one["final"] and one.get("vertices"))
            details, one = self.ask(f"part{dim}", "locate?point=" + ",".join(map(repr, known)))
            self.assertTrue(one["final"])
            self.assertIs(details, all(cell is None or cell.get("final", True) for cell in one["neighbors"]))
        self.assertEqual(self.daemon.end(), 0, self.daemon.messages())

    def drawn(self, box, x, y):
        near = ",".join(map(repr, [x - 4, y - 4, x + 4, y + 4]))
        far = ",".join(map(repr, [x - 8, y - 8, x + 8, y + 8]))

        def cells(name, where):
            told, found = self.ask(name, f"cells?bbox={where}&limit=1000000")
            return told, sorted(sorted(feature["geometry"]["coordinates"][0][:-1]) for feature in found["features"])
        self.assertEqual(cells("part2", near), cells("whole2", near))
        told, some = cells("part2", far)
        self.assertFalse(told)
        self.assertLess(len(some), len(cells("whole2", far)[1]))

        def answer(name, question):  # without the digest of the result that answers
            told, found = self.ask(name, f"{question}bbox={near}")
            if isinstance(found, bytes):
                return told, re.sub(rb'(RESULT_DIGEST">)\w+', rb"\1", found)
            return told, {key: value for key, value in found.items() if key != "result"}
        for question in ("dem?res=0.5&", "contours?interval=0.5&"):
            self.assertEqual(answer("part2", question), answer("whole2", question))
            self.assertFalse(self.ask("part2", f"{question}bbox={far}")[0])
        line = f"profile?line={x - 4},{y - 3}%20{x + 4},{y + 2}"
        self.assertEqual(self.ask("part2", line), self.ask("whole2", line))
        self.assertEqual(self.ask("part2", line + "&f=geojson")[1]["geometry"]["type"], "MultiLineString")
        self.assertFalse(self.ask("part2", f"profile?line={x},{y}%20{x + 9},{y}&f=json")[0])
        body = {"type": "LineString", "coordinates": [[x - 4, y - 3], [x + 4, y + 2]]}
        self.assertEqual(self.ask("part2", "profile", body), self.ask("whole2", line))
        # The command tells the same.
        lines = self.tessera("query", self.folder / "data/results/part2", "locate", f"{x},{y}", "--json")
        self.assertTrue(json.loads(lines)["final"])


if __name__ == "__main__":
    unittest.main()
