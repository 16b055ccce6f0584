"""A daemon asked in Python: jobs, events, results, and what goes wrong."""
import json
import os
import pathlib
import socket
import sys
import tempfile
import threading
import unittest

import numpy as np
import tessera

import clouds

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "client"))
from fake_server import FakeServer, xxh3  # noqa: E402, F401


class ClientTest(unittest.TestCase):
    def setUp(self):
        held = tempfile.TemporaryDirectory(prefix="tessera-python-")
        self.addCleanup(held.cleanup)
        self.folder = pathlib.Path(held.name)
        self.server = FakeServer(token="secret-token")
        self.addCleanup(lambda: self.server.stop())
        self.client = tessera.connect(self.server.url, "secret-token")

    def make_result(self, name="block", **options):
        t = tessera.triangulate(clouds.random(1000, 3), max_points_per_tile=300, folder=self.folder / f"made-{name}", **options)
        self.server.results[name] = t.folder
        return t


class Jobs(ClientTest):
    def test_a_job_from_submit_to_result(self):
        made = self.make_result()
        self.server.on_submit = lambda job: threading.Thread(target=lambda: (
            job.tell("running", phase="routing"), job.tell(kind="log", text="half"), job.tell("successful", triangulation="block"))).start()
        job = self.client.submit("a.laz", "block", dim=3, max_points_per_tile=300, memory=2**30, classes=(2, 9), crop=np.array([0, 0, 1, 1.5]),
                                 attributes="all", neighbors=False, tiles=None)
        self.assertEqual(self.server.jobs[job.id].inputs, {
            "inputs": ["a.laz"], "output": "block", "dim": 3, "tile_points": 300, "memory": str(2**30), "class": [2, 9],
            "crop": [0, 0, 1, 1.5], "attributes": ["all"], "neighbors": False})
        seen = []
        t = job.result(self.folder / "out", progress=seen.append)
        self.assertIsInstance(t, tessera.Triangulation)
        self.assertEqual((t.digest, len(t)), (made.digest, len(made)))
        t.verify()
        self.assertEqual((seen[0].id, seen[0].kind, seen[-1].status["status"]), (0, "status", "successful"))
        self.assertEqual(job.status()["triangulation"], "block")

    def test_the_same_key_is_sent_again(self):
        for _ in range(2):
            self.client.submit(["a", pathlib.Path("b")], key="k1")
        self.assertEqual([request[2]["Idempotency-Key"] for request in self.server.requests], ["k1", "k1"])
        self.assertEqual(self.server.jobs["j1"].inputs["inputs"], ["a", "b"])

    def test_a_failure_is_raised_by_its_cause(self):
        for cause, kind in ((3, tessera.BadInputError), (7, tessera.MemoryLimitError), (0, tessera.InternalError)):
            job = self.server.add_job("j1", status="failed", problem={"detail": "so it is", "cause": cause})
            with self.assertRaisesRegex(kind, "^so it is$"):
                self.client.job("j1").wait()
        job.tell("dismissed")
        with self.assertRaises(tessera.InterruptedJobError):
            self.client.job("j1").wait()
        self.server.refusals["POST", "/v1/processes/triangulate/execution"] = (422, {"detail": "memory: too small", "cause": 7})
        with self.assertRaisesRegex(tessera.MemoryLimitError, "memory: too small"):
            self.client.submit("a")

    def test_watching_goes_on_when_the_daemon_comes_back(self):
        job = self.server.add_job("j1")
        events = self.client.job("j1").watch()
        self.assertEqual(next(events).status["status"], "accepted")
        job.tell("running", phase="routing")
        event = next(events)
        self.assertEqual((event.id, event.kind, event.status["phase"]), (1, "status", "routing"))
        self.server.stop()
        job.tell("running", phase="collecting")
        self.server.start()
        self.assertEqual(next(events).status["phase"], "collecting")
        self.assertEqual(self.server.asked("GET", "/events$")[-1][2]["Last-Event-ID"], "1")
        job.tell("successful")
        self.assertEqual([event.status["status"] for event in events][-1], "successful")

    def test_patience_ends(self):
        self.server.add_job("j1")
        events = self.client.job("j1").watch(patience=0)
        next(events)
        self.server.stop()
        with self.assertRaises(tessera.IoError):
            next(events)
        self.server.start()

    def test_cancel_and_resume(self):
        job = self.client.job("j1")
        mine = self.server.add_job("j1", status="running")
        job.cancel()
        self.assertEqual(job.status()["status"], "dismissed")
        with self.assertRaisesRegex(tessera.UsageError, "has ended already: dismissed"):
            job.cancel()
        self.assertEqual(len(self.server.asked("DELETE", "")), 1)
        job.resume()
        self.assertEqual(mine.fields["starts"], 2)
        with self.assertRaisesRegex(tessera.UsageError, "there is no job j2"):
            self.client.job("j2").status()

    def test_nodes_are_told_and_drained(self):
        self.assertEqual(self.client.nodes(), [])
        self.server.nodes = [{"name": "a b", "state": "free", "threads": 2}]
        self.assertEqual(self.client.nodes()[0]["threads"], 2)
        self.assertEqual(self.client.drain("a b")["state"], "draining")
        with self.assertRaisesRegex(tessera.UsageError, "there is no node 'c'"):
            self.client.drain("c")

    def test_lists_have_all_pages(self):
        for i in range(7):
            self.server.add_job(f"j{i}", status="running" if i % 2 else "accepted")
        self.server.page = 3
        self.assertEqual([job["jobID"] for job in self.client.jobs()], [f"j{i}" for i in range(7)])
        self.assertEqual(len(self.client.jobs("running")), 3)
        self.assertEqual(self.client.results(), [])


class Export(ClientTest):
    def test_what_a_server_says_leads_nowhere_else(self):
        self.make_result()
        (self.folder / "x.py").write_text("mine")
        before = sorted(self.folder.rglob("*"))
        for target, path in (("arr", "exports/PWNED"), ("arr", "exports/arr"), ("arr", "exports/arr/../../PWNED"), ("arr", "/etc/PWNED"),
                             ("arr", "exports/arrow/x"), ("x.off", "exports/x.py"), ("x.off", "exports/y.off"),
                             ("x.off", "exports/a/x.off"), ("x.off", "exports/../x.off"), ("x.csv", "exports/x.off")):
            def hostile(job, path=path):
                job.outcome = {"written": [{"path": path, "bytes": 5, "xxh3": "0000000000000000"}]}
                job.tell("successful", triangulation="block")
            self.server.on_submit = hostile
            with self.assertRaisesRegex(tessera.CorruptError, "which files the export has written"):
                self.client.export("block", self.folder / target, "npy" if target == "arr" else None, overwrite=True)
            self.assertEqual(self.server.asked("GET", "PWNED"), [])
            self.assertEqual(sorted(self.folder.rglob("*")), before, path)
        self.assertEqual((self.folder / "x.py").read_text(), "mine")


class Fetch(ClientTest):
    def content(self, folder):
        return {path.relative_to(folder): path.read_bytes() for path in pathlib.Path(folder).rglob("*") if path.is_file()}

    def test_a_fetch_that_was_cut_goes_on(self):
        made = self.make_result()
        out = self.folder / "out"
        self.server.cut_files_after = [5000]
        with self.assertRaises(tessera.IoError):
            self.client.fetch("block", out, patience=0)
        self.assertFalse((out / "manifest.json").exists())
        with self.assertRaises(tessera.IoError):
            tessera.open(out)
        self.server.requests.clear()
        t = self.client.fetch("block", out)
        self.assertEqual(self.server.asked("GET", "/tiles/")[0][2]["Range"], "bytes=5000-")
        self.assertEqual(self.content(out), self.content(made.folder))
        self.assertEqual(t.digest, made.digest)
        count = len(self.server.requests)
        self.assertEqual(self.client.fetch("block", out).digest, made.digest)
        self.assertEqual(len(self.server.requests), count + 1, "the manifest alone")

    def test_results_of_other_tiles_are_fetched(self):
        made = self.make_result(store="points")
        t = self.client.fetch("block", self.folder / "out")
        self.assertEqual(self.content(self.folder / "out"), self.content(made.folder))
        t.verify()
        manifest = pathlib.Path(made.folder) / "manifest.json"
        good = manifest.read_text()
        for name in ("../x", "/etc/passwd", "tiles/../../x", "tiles/000000.txt", "tiles/000000-2.vtu/x"):
            manifest.write_text(good.replace('"kind":"points"', f'"kind":"points","file":"{name}"', 1))
            with self.assertRaisesRegex(tessera.CorruptError, "manifest of block"):
                self.client.fetch("block", self.folder / "other")

    def test_connections_that_end_are_made_again_where_they_were(self):
        made = self.make_result()
        self.server.cut_files_after = [1000, 0, 2000, 50]
        self.client.fetch("block", self.folder / "out")
        self.assertEqual(self.content(self.folder / "out"), self.content(made.folder))
        asked = [request[2] for request in self.server.asked("GET", "/files/tiles/")]
        self.assertEqual([request.get("Range") for request in asked[:4]], [None, "bytes=1000-", "bytes=1000-", "bytes=3000-"])
        self.assertTrue(all(request["If-Range"].startswith('"xxh3-') for request in asked if "Range" in request))

    def test_damage_on_the_way_is_found(self):
        name = f"tiles/{self.make_result()[0].id:06}.vtu"
        self.server.spoil[name] = lambda content: content[:-100] + b"!" + content[-99:]
        with self.assertRaisesRegex(tessera.CorruptError, "its checksum is"):
            self.client.fetch("block", self.folder / "out")
        self.assertFalse((self.folder / "out" / name).exists())
        self.server.spoil.clear()
        (self.folder / "out" / (name + ".tmp")).write_bytes(b"x" * 5000)  # the beginning of something else
        self.client.fetch("block", self.folder / "out").verify()

    def test_another_length_is_found(self):
        name = f"tiles/{self.make_result()[0].id:06}.vtu"
        self.server.spoil[name] = lambda content: content + b"x"
        with self.assertRaisesRegex(tessera.CorruptError, "bytes on the server"):
            self.client.fetch("block", self.folder / "out")
        self.assertFalse((self.folder / "out" / name).exists())
        self.server.spoil["manifest.json"] = lambda content: b"[]"
        with self.assertRaisesRegex(tessera.CorruptError, "manifest of block"):
            self.client.fetch("block", self.folder / "new")

    def test_what_is_something_else_is_not_touched(self):
        self.make_result()
        for folder in (self.folder, self.folder / "made-block" / "tiles"):
            with self.assertRaisesRegex(tessera.UsageError, "is not empty"):
                self.client.fetch("block", folder)
        with self.assertRaises(tessera.UsageError):
            self.client.fetch("nothing", self.folder / "new")
        self.assertFalse((self.folder / "new").exists())


class Failures(ClientTest):
    def test_nobody_is_there(self):
        with socket.socket() as nobody:
            nobody.bind(("127.0.0.1", 0))
            with self.assertRaisesRegex(tessera.IoError, "cannot be reached"):
                tessera.connect(f"http://127.0.0.1:{nobody.getsockname()[1]}").jobs()

    def test_tokens(self):
        with self.assertRaisesRegex(tessera.UsageError, "does not know this token"):
            tessera.connect(self.server.url, "wrong").jobs()
        with self.assertRaisesRegex(tessera.UsageError, "needs a token"):
            tessera.connect(self.server.url, "").jobs()
        with self.assertRaisesRegex(tessera.UsageError, "token"):
            tessera.connect(self.server.url, "a\r\nb")
        self.assertEqual(tessera.connect(self.server.url + "/?token=secret-token").jobs(), [])
        os.environ["TESSERA_TOKEN"] = "secret-token"
        self.addCleanup(os.environ.pop, "TESSERA_TOKEN")
        self.assertEqual(tessera.connect(self.server.url).jobs(), [])

    def test_addresses_and_answers_that_are_none(self):
        for url in ("localhost:7070", "ftp://x", "http://a:99999", "http://u:p@a"):
            with self.assertRaises(tessera.UsageError):
                tessera.connect(url)
        for foreign in ((200, "text/html", b"<html>"), (404, "text/plain", b""), (200, "application/json", b"[1]")):
            self.server.foreign = foreign
            for call in (self.client.jobs, self.client.job("j1").wait):
                with self.assertRaisesRegex(tessera.UsageError, "not a Tessera server"):
                    call()

    def test_links_do_not_leave_the_server(self):
        self.server.foreign = (200, "application/json", json.dumps(
            {"jobs": [{"jobID": "x"}], "links": [{"rel": "next", "href": "http://other.example/steal"}]}).encode())
        with self.assertRaisesRegex(tessera.IoError, "links to another"):
            self.client.jobs()

    def test_tls_of_nobody_is_told(self):
        with self.assertRaisesRegex(tessera.UsageError, "the server does not speak TLS"):
            tessera.connect(self.server.url.replace("http", "https")).jobs()


if __name__ == "__main__":
    unittest.main()
