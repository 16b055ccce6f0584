"""Questions to results over HTTP: the answers are those of the command, and nothing that is asked does harm."""
import concurrent.futures
import gzip
import io
import json
import pathlib
import unittest

import numpy as np

from daemon import IGN, DaemonTest

PLACE = "/v1/triangulations/{}/"


class Questions(DaemonTest):
    def setUp(self):
        super().setUp()
        self.daemon = self.start()
        for name, dim, tiles in (("flat", 2, 6), ("solid", 3, 6)):
            inputs = {"inputs": ["ign_77050_627755.las"], "output": name, "dim": dim, "tiles": tiles}
            status, _, job = self.daemon.request("POST", "/v1/processes/triangulate/execution", {"inputs": inputs})
            self.assertEqual(status, 201, job)
            self.assertEqual(self.daemon.wait(job["jobID"])["status"], "successful")
        box = self.daemon.request("GET", "/v1/triangulations/solid")[2]["bounds"]
        low, high = np.array(box[:3]), np.array(box[3:])
        points = np.random.default_rng(7).random((400, 3)) * (high - low) * 1.2 + low - (high - low) * 0.1
        self.points = {"flat": points[:, :2], "solid": points}
        self.middle = ((low + high) / 2).tolist()

    def result(self, name):
        return self.folder / "data/results" / name

    def ask(self, method, name, question, body=None, kind=None, **headers):
        return self.daemon.request(method, PLACE.format(name) + question, body,
                                   ({"Content-Type": kind} if kind else {}) | headers)

    def write(self, points, ending):
        path = self.folder / f"points{ending}"
        if ending == ".npy":
            np.save(path, points)
        else:
            np.savetxt(path, points, delimiter=",", fmt="%.17g")
        return path

    def test_one_point_and_a_star_are_what_the_command_prints(self):
        for name, points in self.points.items():
            for point in points[:20]:
                text = ",".join(map(repr, point.tolist()))
                status, headers, found = self.ask("GET", name, f"locate?point={text}")
                self.assertEqual((status, headers["Tessera-Final"]), (200, "true"))
                self.assertEqual(found, json.loads(self.tessera("query", self.result(name), "locate", text, "--json")))
            inside = [corner["id"] for corner in self.ask("GET", name, f"locate?point={','.join(map(str, self.middle))}")[2]["vertices"]]
            for vertex in inside:
                star = self.ask("GET", name, f"vertices/{vertex}/star")[2]
                self.assertEqual(star, json.loads(self.tessera("query", self.result(name), "star", vertex, "--json")))
                tile = star["vertex"]["tile"]
                self.assertEqual(self.ask("GET", name, f"vertices/{vertex}/star?tile={tile}")[2], star)

    def test_many_points_are_answered_as_by_the_command_in_every_format(self):
        kinds = {".csv": "text/csv", ".npy": "application/x-npy"}
        for name, points in self.points.items():
            value = "z" if name == "flat" else None
            for ending, kind in kinds.items():
                file = self.write(points, ending)
                out = self.folder / f"{name}-cells{ending}"
                self.tessera("query", self.result(name), "locate", "--points", file, "-o", out)
                status, headers, body = self.ask("POST", name, "locate", file.read_bytes(), kind)
                self.assertEqual((status, headers["Content-Type"], body), (200, kind, out.read_bytes()))
                if not value:
                    continue
                for method in ("linear", "natural"):
                    out = self.folder / f"{name}-{method}{ending}"
                    self.tessera("query", self.result(name), "interpolate", file, "--value", value, "--method", method, "-o", out)
                    status, _, body = self.ask("POST", name, f"interpolate?value={value}&method={method}", file.read_bytes(), kind)
                    self.assertEqual((status, body), (200, out.read_bytes()))
        lines = self.tessera("query", self.result("flat"), "interpolate", self.write(self.points["flat"], ".csv"), "--value", "z",
                             "--weights", "--json").splitlines()
        status, headers, found = self.ask("POST", "flat", "interpolate?weights=true", {"points": self.points["flat"].tolist()})
        self.assertEqual((status, headers["Content-Type"]), (200, "application/json"))
        self.assertEqual(found["answers"], [json.loads(line) for line in lines])
        array = np.load(io.BytesIO(self.ask("POST", "solid", "locate?f=npy", {"points": self.points["solid"].tolist()})[2]))
        self.assertEqual((array.shape, array.dtype), ((400, 6), np.int64))

    def test_places_of_another_system_are_refused(self):
        line = {"type": "LineString", "coordinates": [[3.87, 43.59], [3.88, 43.6]]}
        polygon = {"type": "Polygon", "coordinates": [[[3.8, 43.5], [3.9, 43.5], [3.9, 43.6]]]}
        crs = {"crs": {"type": "name", "properties": {"name": "urn:ogc:def:crs:OGC:1.3:CRS84"}}}
        for question, shape in (("profile", line), ("cells", polygon)):
            for more, says in (({}, "look like degrees"), (crs, "those of WGS 84 (EPSG:4326)")):
                status, _, problem = self.ask("POST", "flat", question, json.dumps(shape | more).encode(), "application/geo+json")
                self.assertEqual(status, 422, problem)
                self.assertIn("the body: its coordinates", problem["detail"])
                self.assertIn(says, problem["detail"])
        for question in ("dem?res=1", "contours?interval=1"):
            status, _, problem = self.ask("GET", "flat", question + "&bbox=0,0,9,9")
            self.assertEqual(status, 400, problem)
            self.assertIn("bbox: no cell meets it; the points of the result lie at x from", problem["detail"])

    def test_cells_and_rasters_are_the_files_of_the_command(self):
        x, y, _ = self.middle
        box = f"{x - 9},{y - 9},{x + 9},{y + 9}"
        for name, ending in (("flat", "geojson"), ("flat", "ply"), ("flat", "vtu"), ("solid", "ply"), ("solid", "vtu")):
            out = self.folder / f"{name}.{ending}"
            self.tessera("query", self.result(name), "cells", "--bbox", box, "-o", out)
            status, headers, body = self.ask("GET", name, f"cells?bbox={box}&f={ending}&limit=1000000")
            same = json.loads(out.read_bytes()) if "json" in headers["Content-Type"] else out.read_bytes()
            self.assertEqual((status, body), (200, same), (name, ending))
        ring = [[x - 9, y - 9], [x + 9, y - 9], [x, y + 9], [x - 9, y - 9]]
        bow = [[x - 9, y - 9], [x + 9, y + 9], [x + 9, y - 9], [x - 9, y + 9], [x - 9, y - 9]]
        for shape in (ring, bow):  # a ring that crosses itself has the inside that even and odd give it
            polygon = {"type": "Polygon", "coordinates": [shape]}
            file = self.folder / "area.geojson"
            file.write_text(json.dumps(polygon))
            out = self.folder / "part.geojson"
            self.tessera("query", self.result("flat"), "cells", "--polygon", file, "-o", out, "--overwrite")
            status, _, body = self.ask("POST", "flat", "cells", json.dumps(polygon).encode(), "application/geo+json")
            self.assertEqual((status, body), (200, json.loads(out.read_bytes())))
        out = self.folder / "dem.tif"
        self.tessera("dem", self.result("flat"), "--res", "0.5", "--bbox", box, "--max-edge", "5", "-o", out)
        status, headers, body = self.ask("GET", "flat", f"dem?res=0.5&bbox={box}&max-edge=5")
        self.assertEqual((status, headers["Content-Type"].split(";")[0], body), (200, "image/tiff", out.read_bytes()))
        out = self.folder / "lines.geojson"
        self.tessera("contours", self.result("flat"), "--interval", "0.5", "--bbox", box, "--smooth", "1", "--min-length", "2", "--index-every", "3", "-o", out)
        status, _, body = self.ask("GET", "flat", f"contours?interval=0.5&bbox={box}&smooth=1&min-length=2&index-every=3")
        self.assertEqual((status, body), (200, json.loads(out.read_bytes())))
        self.assertEqual(self.ask("GET", "flat", f"contours?interval=0.5&smooth=0.001")[0], 422)
        line = f"{x - 9},{y - 9} {x + 9},{y + 9}"
        for digits in ("all", "2", "data"):
            status, _, body = self.ask("GET", "flat", f"profile?line={line.replace(' ', '%20')}&digits={digits}")
            self.assertEqual((status, body.decode()), (200, self.tessera("profile", self.result("flat"), "--line", line, "--digits", digits)))

    def test_wrong_questions_are_refused_with_a_sentence(self):
        csv, npy = "text/csv", "application/x-npy"
        near = ",".join(str(at + side) for side in (-1, 1) for at in self.middle)
        far = {"type": "Polygon", "coordinates": [[[999, 0], [1000, 0], [999, 1]]]}
        for name, method, question, body, kind, status, says in (
                ("none", "GET", "locate?point=1,2", None, None, 404, "there is no triangulation 'none'"),
                ("flat", "GET", "locate", None, None, 400, "point: '' is not a point"),
                ("flat", "GET", "locate?point=1", None, None, 400, "has 1 coordinates, and the result is 2D"),
                ("solid", "GET", "locate?point=1,2", None, None, 400, "has 2 coordinates, and the result is 3D"),
                ("flat", "GET", "locate?point=nan,2", None, None, 400, "is not a point"),
                ("flat", "GET", "locate?point=1,2&colour=red", None, None, 400, "colour"),
                ("flat", "GET", "vertices/x/star", None, None, 400, "source index"),
                ("flat", "GET", "vertices/999999999/star", None, None, 400, "999999999"),
                ("flat", "GET", "vertices/1/star?tile=-1", None, None, 400, "tile: "),
                ("flat", "GET", "cells", None, None, 400, "bbox"),
                ("flat", "GET", "cells?bbox=1,2,3", None, None, 400, "bbox: "),
                ("flat", "GET", "cells?bbox=0,0,1,1", None, None, 422, "no cell meets"),
                ("flat", "GET", "cells?bbox=0,0,9e9,9e9&limit=10", None, None, 422, "more than 10 cells, which is the limit"),
                ("flat", "GET", "cells?bbox=0,0,9e9,9e9&limit=0", None, None, 400, "limit: "),
                ("flat", "GET", "cells?bbox=0,0,9e9,9e9&f=npy", None, None, 400, "f: the format npy is a folder"),
                ("flat", "GET", "cells?bbox=0,0,9e9,9e9&f=/etc/x", None, None, 400, "/etc/x"),
                ("solid", "GET", f"cells?bbox={near}&f=geojson", None, None, 400, "geojson"),
                ("flat", "POST", "cells", b"{", "application/json", 422, "the body: is not JSON"),
                ("flat", "POST", "cells", b"[" * 100, "application/json", 400, "too deep"),
                ("flat", "POST", "cells", json.dumps(far).encode(), "application/geo+json", 422, "no cell meets"),
                ("flat", "POST", "locate", b"1,2", None, 415, "Content-Type"),
                ("flat", "POST", "locate", b"x,y\n1,nan\n", csv, 422, "the body"),
                ("flat", "POST", "locate", b"", csv, 422, "the body"),
                ("flat", "POST", "locate", b"no array", npy, 422, "the body"),
                ("flat", "POST", "locate", sorted(IGN.glob("*.las"))[0].read_bytes()[:9999], csv, 422, "the body: is not text"),
                ("flat", "POST", "locate", gzip.compress(b"1,2\n3,4\n"), csv, 422, "the body: is not text"),
                ("flat", "POST", "locate", b"1,2\n", npy, 422, "the body"),
                ("flat", "POST", "interpolate", b"ply\nformat ascii 1.0\n", npy, 422, "the body: is not a NumPy array"),
                ("flat", "POST", "locate", b'{"points": []}', "application/json", 422, "not empty"),
                ("flat", "POST", "locate", b'{"points": [[1]]}', "application/json", 422, "points[0]: must be a list of 2"),
                ("flat", "POST", "locate", b'{"points": [[1, "2"]]}', "application/json", 422, "not a number"),
                ("solid", "POST", "locate", b"1,2\n3,4\n", csv, 422, "the body"),
                ("flat", "POST", "interpolate?value=colour", b"1,2\n", csv, 400, "triangulation 'flat': its vertices have no attribute 'colour'"),
                ("solid", "POST", "interpolate", b"1,2,3\n", csv, 400, "value: "),
                ("flat", "POST", "interpolate?method=cubic", b"1,2\n", csv, 400, "method: 'cubic'"),
                ("flat", "POST", "interpolate?weights=true&f=npy", b"1,2\n", csv, 400, "weights need csv or json"),
                ("flat", "GET", "dem", None, None, 400, "res: "),
                ("flat", "GET", "dem?res=0.001", None, None, 422, "at most: ask for a smaller bbox or a larger res"),
                ("flat", "GET", "dem?res=1&value=colour", None, None, 400, "no attribute 'colour'"),
                ("flat", "GET", "dem?res=1&type=int", None, None, 400, "type: 'int'"),
                ("solid", "GET", "dem?res=9", None, None, 400, "triangulation 'solid': is a 3D result")):
            with self.subTest(f"{method} {name}/{question}"):
                answer = self.ask(method, name, question, body, kind)
                self.assertEqual(answer[0], status, answer[2])
                self.assertIn(says, answer[2]["detail"])
                self.assertNotIn(str(self.folder), answer[2]["detail"])
                self.assertNotIn("/proc", answer[2]["detail"])
        self.assertEqual(list((self.folder / "data/answers").iterdir()), [])
        self.assertEqual(self.daemon.end(), 0, self.daemon.messages())

    def test_many_ask_at_once_and_a_result_may_go_meanwhile(self):
        points = self.points["flat"].tolist()
        right = self.ask("POST", "flat", "interpolate?method=natural", {"points": points})[2]
        with concurrent.futures.ThreadPoolExecutor(8) as callers:
            asked = [callers.submit(self.ask, "POST", "flat", "interpolate?method=natural", {"points": points}) for _ in range(40)]
            for one in asked:
                self.assertEqual(one.result()[::2], (200, right))
            asked = [callers.submit(self.ask, "POST", "flat", "interpolate?method=natural", {"points": points}) for _ in range(60)]
            self.assertEqual(self.daemon.request("DELETE", "/v1/triangulations/flat")[0], 204)
            for one in asked:
                status, _, body = one.result()
                self.assertIn(status, (200, 404, 410), body)
                if status == 200:
                    self.assertEqual(body, right)
        self.assertEqual(self.ask("POST", "flat", "interpolate", {"points": points})[0], 404)
        # Nothing of it is open any more.
        links = [link.resolve() for link in pathlib.Path(f"/proc/{self.daemon.process.pid}/fd").iterdir()]
        self.assertEqual([link for link in links if "flat" in link.name or "removed" in str(link)], [])

    def test_an_answer_is_known_by_its_etag_until_another_result_has_the_name(self):
        question = f"locate?point={self.middle[0]},{self.middle[1]}"
        _, headers, _ = self.ask("GET", "flat", question)
        status, _, body = self.ask("GET", "flat", question, **{"If-None-Match": headers["ETag"]})
        self.assertEqual((status, body), (304, b""))
        inputs = {"inputs": ["ign_77050_627755.las"], "output": "flat", "dim": 2, "tiles": 3, "overwrite": True}
        job = self.daemon.request("POST", "/v1/processes/triangulate/execution", {"inputs": inputs})[2]
        self.assertEqual(self.daemon.wait(job["jobID"])["status"], "successful")
        self.assertEqual(self.ask("GET", "flat", question, **{"If-None-Match": headers["ETag"]})[0], 200)

    def test_a_damaged_tile_is_told_and_harms_no_other_question(self):
        tiles = sorted((self.result("flat") / "tiles").iterdir())
        for tile in tiles:
            data = bytearray(tile.read_bytes())
            data[len(data) // 2] ^= 255
            tile.write_bytes(data)
        status, _, body = self.ask("GET", "flat", f"locate?point={self.middle[0]},{self.middle[1]}")
        self.assertEqual((status, body["cause"]), (500, 5), body)
        self.assertIn("triangulation 'flat', tiles/", body["detail"])
        self.assertEqual(self.ask("GET", "solid", f"locate?point={','.join(map(str, self.middle))}")[0], 200)


if __name__ == "__main__":
    unittest.main()
