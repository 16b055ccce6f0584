"""What the daemon opens for texts of callers, and that a pipe that they name stops nobody."""
import json
import os
import pathlib
import sys
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "daemon"))

import opens
import texts
from daemon import DaemonTest

import files


class DaemonOpens(DaemonTest):
    @classmethod
    def setUpClass(cls):
        opens.need_strace()

    def setUp(self):
        super().setUp()
        self.canary = str(self.folder / "canary")
        os.mkfifo(self.canary)
        self.inputs = self.folder / "inputs"
        self.inputs.mkdir()
        (self.inputs / "plain.las").write_bytes(files.las())

    def run_job(self, process, **inputs):
        status, _, job = self.daemon.request("POST", f"/v1/processes/{process}/execution", {"inputs": inputs})
        self.assertEqual(status, 201, job)
        return self.daemon.wait(job["jobID"])

    def watched(self, ask):
        """Nothing but inputs, results and the system's own is opened while `ask` runs; the daemon still answers, and ends."""
        watching = opens.Attached(self.daemon.process.pid, self.folder / "trace")
        try:
            ask()
            self.assertEqual(self.daemon.request("GET", "/v1/triangulations")[0], 200)
            self.assertEqual(self.daemon.request("GET", "/v1/caller")[0], 200)
        finally:
            seen = watching.end()
        mine = (f"{self.folder}/data", str(self.inputs))
        strange = [path for path in opens.opened(seen)
                   if path.startswith(("/", "..", "~")) and not os.path.normpath(path).startswith(mine)]
        self.assertEqual(strange, [])
        self.assertEqual([call for call in seen if os.path.normpath(call[1]).startswith(self.canary)], [])
        self.assertNotEqual(seen, [], "nothing was seen at all")

    def test_texts_of_callers(self):
        self.daemon = self.start(inputs=self.inputs)
        evil = texts.refused(self.canary) | {f"log {i}": "a[ +init=/proc/self/fd/2:foo" for i in range(4)}
        told = []

        def ask():
            for name, text in evil.items():
                for process, more in (("triangulate", {"dim": 2}), ("info", {}), ("region", {"bbox": [0, 0, 9, 9], "output": "r"})):
                    inputs = {"inputs": ["plain.las"], "crs": text, **more}
                    for way in ("estimate", "execution"):
                        status, _, answer = self.daemon.request("POST", f"/v1/processes/{process}/{way}", {"inputs": inputs})
                        told.append((name, process, way, status, answer if isinstance(answer, dict) else {}))
        self.watched(ask)
        for name, process, way, status, answer in told:
            if way == "execution" or process != "info":
                self.assertIn(status, (400, 404, 405), (name, process, way, answer))
        self.assertEqual(self.daemon.end(), 0)
        # Each refusal is a line of the log: nobody else has read it.
        self.assertGreaterEqual(self.daemon.messages().count("audit"), 2 * len(evil))

    def test_files_of_strangers_as_inputs(self):
        for i, text in enumerate(texts.refused(self.canary).values()):
            if len(text) < 60000:
                (self.inputs / f"{i}.las").write_bytes(files.las(wkt=text))
                (self.inputs / f"k{i}.las").write_bytes(files.las(citation="ESRI PE String = " + text))
        self.daemon = self.start(inputs=self.inputs)

        def ask():
            for name in sorted(file.name for file in self.inputs.iterdir()):
                self.daemon.request("POST", "/v1/processes/triangulate/estimate", {"inputs": {"inputs": [name], "dim": 2}})
            self.assertEqual(self.run_job("triangulate", inputs=["10.las", "plain.las"], dim=2, output="r")["status"], "successful")
        self.watched(ask)
        self.assertEqual(self.daemon.end(), 0)

    def test_results_of_strangers(self):
        self.daemon = self.start(inputs=self.inputs)
        self.assertEqual(self.run_job("triangulate", inputs=["plain.las"], dim=2, output="block")["status"], "successful")
        self.assertEqual(self.daemon.end(), 0)
        path = self.folder / "data/results/block/manifest.json"
        manifest = json.loads(path.read_text())
        for name in ("no keyword, +init", "grids of a datum", "a PROJ string in a projected system", "an authority with +init",
                     "a PROJ string in a remark of WKT 2", "a file of a transformation", "grids of heights"):
            path.write_text(json.dumps(manifest | {"crs": texts.refused(self.canary)[name]}))
            self.daemon = self.start(inputs=self.inputs)

            def ask():
                for target in ("/v1/collections", "/v1/collections/block", "/v1/triangulations/block", "/v1/collections/block/items",
                               "/v1/collections/block/map?width=9&height=9"):
                    self.daemon.request("GET", target)
                for process, more in (("export", {"output": "a.gpkg"}), ("export", {"output": "a.xml"}), ("dem", {"res": 50}),
                                      ("contours", {"interval": 200})):
                    self.daemon.wait(self.daemon.request("POST", f"/v1/processes/{process}/execution", {
                        "inputs": {"triangulation": "block", "overwrite": True, **more}})[2]["jobID"])
                for target in ("/v1/collections", "/v1/collections/block.contours/items", "/v1/collections/block.dem/map?width=9&height=9"):
                    self.daemon.request("GET", target)
            with self.subTest(name):
                self.watched(ask)
            self.assertEqual(self.daemon.end(), 0)

    def test_bodies_are_what_their_type_says(self):
        """Who may only read reaches no reader of files but those of text and NumPy."""
        self.daemon = self.start(inputs=self.inputs)
        self.assertEqual(self.run_job("triangulate", inputs=["plain.las"], dim=2, output="block")["status"], "successful")
        canary = self.canary
        bodies = {"las": files.las(wkt=texts.refused(canary)["grids of a datum"]), "ply": files.ply(canary), "obj": files.obj(canary),
                  "off": files.off(canary), "stl": files.stl(canary), "gzip": files.gz(canary), "zstd": files.zstd_with_dictionary(7),
                  "pickle": files.npy_of_objects(canary)}
        told = {}

        def ask():
            for name, body in bodies.items():
                for kind in ("text/csv", "application/x-npy"):
                    told[name, kind] = self.daemon.request("POST", "/v1/triangulations/block/locate", body, {"Content-Type": kind})
            for body in (b"\x0a\x0b/etc/passwd", b"\xff" * 50, b"\x0b" * 1000):
                self.daemon.request("POST", "/v1/triangulations/block/locate", body, {"Content-Type": "application/x-protobuf"})
                self.daemon.request("POST", "/v1/processes/triangulate/execution", body, {"Content-Type": "application/x-protobuf"})
            for body in (b"[" * 100000, b'{"points":' * 1000, b'{"points":[{"$ref":"file://%s"}]}' % canary.encode()):
                self.daemon.request("POST", "/v1/triangulations/block/locate", body, {"Content-Type": "application/json"})
        self.watched(ask)
        for (name, kind), (status, _, answer) in told.items():
            self.assertEqual(status, 422, (name, kind, answer))
            if name in ("las", "ply", "gzip", "zstd") or (name == "pickle" and kind == "text/csv"):
                self.assertIn("the body: is not", answer["detail"], (name, kind))
        good = self.daemon.request("POST", "/v1/triangulations/block/locate", b"x,y\n500,500\n", {"Content-Type": "text/csv"})
        self.assertEqual(good[0], 200, good[2])
        self.assertEqual(self.daemon.end(), 0)


if __name__ == "__main__":
    unittest.main()
