"""Changes of results as jobs of the daemon: the digest is that of the command, everybody reads one version at a time,
and what is refused changes nothing."""
import http.client
import json
import shutil
import signal
import subprocess
import threading
import unittest

import numpy as np

from daemon import TESSERA, DaemonTest

RUNNING = ("accepted", "running")
SQUARE = {"type": "Polygon", "coordinates": [[[0.1, 0.1], [0.4, 0.1], [0.4, 0.4], [0.1, 0.4], [0.1, 0.1]]]}


class WithResult(DaemonTest):
    TILES = 12
    POINTS = 6000

    def setUp(self):
        super().setUp()
        self.inputs = self.folder / "inputs"
        self.inputs.mkdir()
        random = np.random.default_rng(3)
        cloud = random.random((self.POINTS, 3))
        cloud[::7] = np.round(cloud[::7], 1)  # equal and cospherical points
        np.save(self.inputs / "cloud.npy", cloud)
        np.save(self.inputs / "more.npy", np.round(random.random((300, 3)) * 0.2, 3))
        np.save(self.inputs / "other.npy", np.round(random.random((300, 3)) * 0.3 + 0.6, 3))
        self.daemon = self.start_daemon()

    def start_daemon(self):
        return self.start(inputs=self.inputs)

    def triangulate(self, name="cloud", dim=3, **more):
        return self.execute("triangulate", inputs=["cloud.npy"], output=name, dim=dim, tiles=self.TILES, **more)

    def submit(self, process, **inputs):
        status, _, job = self.daemon.request("POST", f"/v1/processes/{process}/execution", {"inputs": inputs})
        self.assertEqual(status, 201, job)
        return job["jobID"]

    def done(self, job):
        status = self.daemon.wait(job)
        self.assertEqual(status["status"], "successful", status)
        return self.daemon.request("GET", f"/v1/jobs/{job}/results")[2].get("outcome", {}).get("value")

    def execute(self, process, **inputs):
        return self.done(self.submit(process, **inputs))

    def update(self, **inputs):
        return self.execute("update", triangulation="cloud", **inputs)

    def refused(self, process="update", **inputs):
        status, _, told = self.daemon.request("POST", f"/v1/processes/{process}/execution", {"inputs": inputs})
        self.assertGreaterEqual(status, 400, told)
        self.assertNotIn(str(self.folder), told["detail"])
        return status, told["detail"]

    def failed(self, **inputs):
        status = self.daemon.wait(self.submit("update", triangulation="cloud", **inputs))
        self.assertEqual(status["status"], "failed", status)
        self.assertNotIn(str(self.folder / "data"), status["message"])
        return status["message"]

    def info(self, name="cloud"):
        return self.daemon.request("GET", f"/v1/triangulations/{name}")[2]

    def manifest(self, folder):
        return json.loads((self.folder / folder / "manifest.json").read_text())

    def digest(self, folder):
        return self.manifest(folder)["digest2"]

    def here(self, *args):
        """The same change by the command, of a result that is a copy."""
        return json.loads(self.tessera("update", "here", *args, "--json").splitlines()[-1])

    def copy(self, name="cloud"):
        shutil.copytree(self.folder / "data/results" / name, self.folder / "here")

    def left(self):
        """What is in the data folder beside results."""
        return [path.name for path in (self.folder / "data/results").iterdir() if path.name.startswith(".unfinished")]


class Changes(WithResult):
    def test_changes_are_those_of_the_command(self):
        self.triangulate()
        self.copy()
        ids = [5, 6, 700, 5999]
        np.save(self.folder / "ids.npy", np.array(ids, np.uint64))
        for inputs, args in (
                ({"inputs": ["more.npy"]}, ("--add", self.inputs / "more.npy")),
                ({"remove_ids": ids}, ("--remove-ids", "ids.npy")),
                ({"remove_box": [0.5, 0.5, 0.5, 0.7, 0.7, 0.7], "inputs": ["other.npy"], "replace": True},
                 ("--remove-box", "0.5,0.5,0.5,0.7,0.7,0.7", "--add", self.inputs / "other.npy", "--replace")),
                ({"remove_input": ["more.npy"], "keep_versions": 3},
                 ("--remove-input", self.inputs / "more.npy", "--keep-versions", 3))):
            with self.subTest(args=args):
                there, here = self.update(**inputs), self.here(*args)
                for told in (there, here):
                    for order_decides in ("points_sent", "tiles_awake"):
                        told.pop(order_decides)
                self.assertEqual(there, here | {"output": "cloud"})
                self.assertEqual(self.info()["version"], here["version"])
                self.assertEqual(self.info()["digest"], here["digest"])
        self.assertEqual(self.left(), [])
        self.execute("verify", triangulation="cloud")
        told = self.daemon.request("GET", "/v1/triangulations/cloud/versions")[2]
        expected = json.loads(self.tessera("log", "here", "--json"))
        for key in ("version", "added", "removed", "vertices", "cells", "digest", "readable"):
            self.assertEqual([each[key] for each in told["versions"]], [each[key] for each in expected["versions"]], key)
        self.assertEqual((told["result"], told["version"], told["keep_versions"]), ("cloud", 5, 3))
        self.assertEqual([each["command"][1] for each in told["versions"]], ["triangulate"] + 4 * ["update"])
        self.assertEqual(self.daemon.request("GET", "/v1/triangulations/none/versions")[0], 404)
        self.assertEqual(self.daemon.end(), 0, self.daemon.messages())

    def test_a_new_result_and_a_dry_run_leave_the_old_one(self):
        self.triangulate(dim=2)
        before = self.manifest("data/results/cloud")
        told = self.update(remove_polygon=json.dumps(SQUARE), output="next")
        self.assertEqual((told["output"], told["version"]), ("next", 1))
        (self.folder / "square.geojson").write_text(json.dumps(SQUARE))
        self.copy()
        here = self.here("--remove-polygon", "square.geojson")
        self.assertEqual(told["digest"], here["digest"])
        self.assertEqual(self.info("next")["digest"], here["digest"])
        self.assertIn("there is a triangulation called 'next' already",
                      self.refused(triangulation="cloud", remove_ids=[1], output="next")[1])
        self.update(remove_ids=[1, 2], output="next", overwrite=True)
        self.assertEqual(self.info("next")["vertices"], self.info()["vertices"] - 2)
        dry = self.update(remove_ids=[1], dry_run=True)
        self.assertEqual((dry["event"], dry["removed"]), ("would_update", 1))
        self.assertGreater(dry["tiles_awake"], 0)
        status, _, estimate = self.daemon.request("POST", "/v1/processes/update/estimate",
                                                  {"inputs": {"triangulation": "cloud", "remove_ids": [1]}})
        self.assertEqual((status, estimate["accepted"]), (200, True), estimate)
        self.assertLessEqual(dry["tiles_awake"], int(estimate["tiles"]))
        self.assertLessEqual(int(estimate["tiles"]), self.TILES)
        self.assertLessEqual(dry["bytes"], int(estimate["resultBytes"]))
        self.assertGreater(estimate["seconds"], 0)
        status, _, process = self.daemon.request("GET", "/v1/processes/update")
        self.assertIn("estimate", [link["rel"] for link in process["links"]])
        self.assertEqual(self.manifest("data/results/cloud"), before)
        self.assertEqual(self.left(), [])
        self.assertEqual(self.daemon.end(), 0, self.daemon.messages())

    def test_what_is_refused_changes_nothing(self):
        self.triangulate()
        self.triangulate("plane", dim=2)
        before = self.manifest("data/results/cloud")
        for inputs, says in (
                ({}, "nothing is to be changed"), ({"replace": True, "remove_ids": [1]}, "replace: needs new points"),
                ({"remove_box": [1, 2, 3]}, "remove_box"), ({"remove_box": [2, 2, 1, 1]}, "remove_box"),
                ({"remove_class": [256]}, "remove_class: 256 is not a LAS class"), ({"remove_time": [1]}, "remove_time"),
                ({"remove_time": [2, 1]}, "remove_time: its end is before its begin"),
                ({"remove_polygon": "{"}, "remove_polygon: is not JSON"), ({"remove_ids": [-1]}, "remove_ids"),
                ({"remove_ids": [1], "keep_versions": 0}, "keep_versions"), ({"remove_ids": [1], "output": "cloud"}, "output"),
                ({"remove_ids": [1], "keep_versions": 2, "output": "a"}, "keep_versions"),
                ({"remove_ids": [1], "memory": "0"}, "memory"), ({"inputs": ["../secret.npy"]}, "inputs"),
                ({"remove_ids": [1], "output": "a/b"}, "output"), ({"remove_ids": [1], "overwrite": True}, "overwrite")):
            with self.subTest(inputs=inputs):
                status, detail = self.refused(triangulation="cloud", **inputs)
                self.assertIn(says, detail)
                self.assertIn(status, (400, 422))
        self.assertIn("there is none called 'none'", self.refused(triangulation="none", remove_ids=[1])[1])
        self.assertIn("none.npy", self.refused(triangulation="cloud", inputs=["none.npy"])[1])
        status, detail = self.refused(triangulation="cloud", remove_ids=list(range(10**9, 10**9 + 60_000)))
        self.assertEqual(status, 413, detail)
        self.assertIn("at most 256 KiB are allowed", detail)
        np.save(self.inputs / "nan.npy", np.full((3, 3), np.nan))
        with_attribute = np.zeros(3, [("x", float), ("y", float), ("z", float), ("intensity", np.uint16)])
        np.save(self.inputs / "attribute.npy", with_attribute)
        for inputs, says in (({"remove_ids": [6000]}, "6000"), ({"inputs": ["nan.npy"]}, "nan.npy"),
                             ({"remove_class": [2]}, "classification"), ({"remove_time": [1, 2]}, "gps_time"),
                             ({"remove_input": ["none.npy"]}, "none.npy"),
                             ({"remove_box": [-1, -1, 2, 2]}, "no points would be left")):
            with self.subTest(inputs=inputs):
                self.assertIn(says, self.failed(**inputs))
        self.assertEqual(self.manifest("data/results/cloud"), before)
        self.assertEqual(self.left(), [])
        self.assertEqual(self.daemon.end(), 0, self.daemon.messages())

    def test_the_command_asks_the_daemon(self):
        self.triangulate()
        self.copy()
        server = ["--server", f"{self.daemon.url}#token={self.daemon.token}"]
        np.save(self.folder / "ids.npy", np.array([1, 2, 3]))
        for also in ((), ("--json",)):
            there = self.tessera("update", "cloud/", "--remove-ids", "ids.npy", "--dry-run", *also, *server)
            here = self.tessera("update", "here", "--remove-ids", "ids.npy", "--dry-run", *also)
            words = lambda text: [line.partition(", in about")[0].partition('"seconds"')[0] for line in text.splitlines()]
            self.assertEqual(words(there)[-len(words(here)):], words(here))
        there = self.tessera("update", "cloud", "--remove-ids", "ids.npy", "--add", "more.npy", *server)
        here = self.tessera("update", "here", "--remove-ids", "ids.npy", "--add", self.inputs / "more.npy")
        self.assertEqual(there.splitlines(), here.replace("here,", "cloud,").splitlines())
        self.assertEqual(self.digest("here"), self.digest("data/results/cloud"))
        lines = self.tessera("log", "cloud/", *server).splitlines()
        self.assertEqual([line.split()[0] for line in lines], ["version", "1", "2"])
        self.assertIn("+300 -3", lines[2])
        self.assertEqual(json.loads(self.tessera("log", "cloud", "--json", *server))["version"], 2)
        for args, says in ((("update", "cloud", "--remove-ids", "ids.npy", "--wait"), "--wait is not for a job of a daemon"),
                           (("update", "cloud", "--resume", "--remove-class", "2"), "--resume is not for a job"),
                           (("log", "none"), "there is no triangulation 'none'")):
            done = subprocess.run([TESSERA, *args, *server], cwd=self.folder, text=True, capture_output=True)
            self.assertNotEqual(done.returncode, 0)
            self.assertIn(says, done.stderr)
        self.assertEqual(self.daemon.end(), 0, self.daemon.messages())


class Readers(WithResult):
    def ask(self, connection, path):
        connection.request("GET", path, headers={"Authorization": f"Bearer {self.daemon.token}"})
        answer = connection.getresponse()
        return answer.status, answer.headers, answer.read()

    def test_every_answer_is_of_one_version(self):
        self.triangulate()
        path = "/v1/triangulations/cloud/cells?bbox=0.05,0.05,0.05,0.12,0.12,0.12&f=msh"
        seen, tags, problems, stop = {}, {}, [], threading.Event()

        def reader():
            connection = http.client.HTTPConnection("127.0.0.1", self.daemon.port)
            while not stop.is_set():
                status, headers, body = self.ask(connection, path)
                if status != 200:
                    problems.append((status, body))
                    return
                seen.setdefault(int(headers["Tessera-Version"]), set()).add(body)
            connection.close()

        threads = [threading.Thread(target=reader) for _ in range(3)]
        for thread in threads:
            thread.start()
        try:
            for i in range(4):
                told = self.update(**({"inputs": ["more.npy"], "keep_versions": 9} if i % 2 == 0 else {"remove_input": ["more.npy"]}
                                      if i == 1 else {"remove_box": [0, 0, 0, 0.11, 0.11, 0.11]}))
                self.assertEqual(told["version"], i + 2)
        finally:
            stop.set()
            for thread in threads:
                thread.join()
        self.assertEqual(problems, [])
        connection = http.client.HTTPConnection("127.0.0.1", self.daemon.port)
        # Each version, asked for by its number, has the answer that was given while it was the newest.
        for version in range(1, 6):
            status, headers, body = self.ask(connection, f"{path}&version={version}")
            self.assertEqual((status, headers["Tessera-Version"]), (200, str(version)), body)
            tags[version] = headers["ETag"]
            self.assertLessEqual(seen.get(version, set()), {body}, version)
        self.assertGreater(len(seen), 1, "no answer came while the result was changed")
        self.assertEqual(len(set(tags.values())), 5)
        for version, says in ((6, b"version 6 does not exist"), ("x", b"version"), (0, b"version")):
            status, _, body = self.ask(connection, f"{path}&version={version}")
            self.assertEqual(status, 400, body)
            self.assertIn(says, body)
            self.assertNotIn(b"/proc/", body)
        connection.close()
        self.assertEqual(self.daemon.end(), 0, self.daemon.messages())


class Restarts(WithResult):
    TILES = 24
    POINTS = 40_000

    def test_a_change_goes_on_after_a_restart_and_after_a_kill(self):
        self.triangulate()
        self.copy()
        for how in (signal.SIGTERM, signal.SIGKILL):
            more = "more.npy" if how == signal.SIGTERM else "other.npy"
            job = self.submit("update", triangulation="cloud", inputs=[more], remove_box=[0.4, 0.4, 0.4, 0.6, 0.6, 0.6])
            while self.daemon.request("GET", f"/v1/jobs/{job}")[2]["status"] == "accepted":
                pass
            self.daemon.end(how)
            self.daemon = self.start_daemon()
            told = self.done(job)
            here = self.here("--add", self.inputs / more, "--remove-box", "0.4,0.4,0.4,0.6,0.6,0.6")
            self.assertEqual({key: told[key] for key in ("version", "digest", "removed", "added", "cells")},
                             {key: here[key] for key in ("version", "digest", "removed", "added", "cells")})
            self.assertEqual(self.left(), [])
        job = self.submit("update", triangulation="cloud", remove_box=[0, 0, 0, 0.5, 0.5, 0.5])
        self.daemon.request("DELETE", f"/v1/jobs/{job}")
        status = self.daemon.wait(job)
        if status["status"] == "dismissed":
            self.assertEqual(self.info()["version"], 3)
            while self.daemon.request("POST", f"/v1/jobs/{job}/resume")[0] == 409:
                pass
            self.done(job)
        self.assertEqual(self.digest("data/results/cloud"), self.here("--remove-box", "0,0,0,0.5,0.5,0.5")["digest"])
        self.assertEqual(self.left(), [])
        self.assertEqual(self.daemon.end(), 0, self.daemon.messages())


if __name__ == "__main__":
    unittest.main()
