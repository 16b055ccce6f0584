"""Asking a daemon: jobs as if they ran here, whatever happens to the daemon, the connection and the watcher."""
import json
import os
import signal
import subprocess
import threading
import unittest

from cli import BAD_INPUT, INTERRUPTED, IO, MEMORY, OK, TESSERA, USAGE
from cli_server import ServerTest


class Triangulate(ServerTest):
    def test_it_is_as_if_it_ran_here(self):
        here = self.make_result()
        self.server.on_submit = self.succeed
        done = self.run_tessera("triangulate", "a.laz", "b.laz", "-o", "block")
        self.assertEqual(done.returncode, OK, done.stderr)

        def figures(text):
            return [line for line in text.splitlines() if not line.startswith(("time", "memory", "result"))]
        self.assertEqual(figures(done.stdout), figures(here))
        self.assertRegex(done.stdout, r"(?m)^result +block \(")
        (submitted,) = self.server.asked("POST", "^/v1/processes/triangulate/execution$")
        self.assertEqual(json.loads(submitted[3]), {"inputs": {"inputs": ["a.laz", "b.laz"], "output": "block"}})
        self.assertRegex(submitted[2]["Idempotency-Key"], "^[0-9a-f]{32}$")

    def test_every_option_reaches_the_field_of_its_name(self):
        self.ok("triangulate", "a.laz", "-o", "block/", "--detach", "--dim", 2, "--max-points-per-tile", "1.5M", "--partition", "grid",
                "--threads", 3, "--memory", "4G", "--kernel", "cgal", "--no-neighbors", "--crop", "-1,0.5,2e3,4", "--class", "2,9",
                "--attributes", "red,intensity", "--resolution", "0.25", "--returns", "first", "--without", "withheld,overlap",
                "--recursive", "--overwrite", "--no-z", "--skip-invalid", "--columns", "p,y,x", "--keep", "last", "--store", "points", env={"TESSERA_CRS": "EPSG:2154"})
        inputs = self.server.jobs["j1"].inputs
        crs = inputs.pop("crs")
        self.assertIn("2154", crs)
        self.assertEqual(inputs, {
            "inputs": ["a.laz"], "output": "block", "dim": 2, "tile_points": 1500000, "partition": "grid", "threads": 3,
            "memory": "4G", "kernel": "cgal", "neighbors": False, "crop": [-1, 0.5, 2000, 4], "class": [2, 9],
            "attributes": ["red", "intensity"], "resolution": 0.25, "returns": "first", "without": ["withheld", "overlap"],
            "recursive": True, "overwrite": True, "heights": False, "skip_invalid": True, "columns": ["p", "y", "x"], "keep": "last", "store": "points"})
        self.ok("triangulate", "a.laz", "-o", "b", "--detach", "--tiles", 7, "--threads", "auto")
        self.assertEqual(self.server.jobs["j2"].inputs, {"inputs": ["a.laz"], "output": "b", "tiles": 7})

    def test_what_is_wrong_is_found_before_the_daemon_is_asked(self):
        for option, value in (("--dim", "4"), ("--memory", "4GB"), ("--crop", "1,2"), ("--class", "2,x")):
            self.refused(USAGE, "triangulate", "a.laz", "-o", "x", option, value, says=option)
        self.refused(USAGE, "triangulate", "-", "-o", "x", says="standard input")
        self.refused(USAGE, "triangulate", "a", "-o", "x", "--input-list", "l", says="--input-list")
        self.refused(USAGE, "triangulate", "a", "-o", "x", "--resume", says=["--resume", "'tessera resume ID'"])
        self.assertEqual(self.server.requests, [])

    def test_an_empty_server_is_none(self):
        self.refused(IO, "triangulate", "missing.las", "-o", "x", "--server", "", says="missing.las")
        self.refused(USAGE, "triangulate", "missing.las", "-o", "x", "--server", "", "--detach", says="--detach")
        self.assertEqual(self.server.requests, [])

    def test_detached_it_says_how_to_look_again(self):
        said = self.ok("triangulate", "a.laz", "-o", "x", "--detach")
        self.assertEqual(said, "job j1 is accepted; 'tessera watch j1' shows it, 'tessera cancel j1' stops it\n")
        url = f"{self.server.url}/?token=secret-token"
        said = self.ok("triangulate", "a.laz", "-o", "x", "--detach", "--server", url)
        self.assertIn(f"'tessera watch j2 --server {self.server.url}'", said)
        (line,) = self.json_lines(self.ok("triangulate", "a.laz", "-o", "x", "--detach", "--json"))
        self.assertEqual((line["event"], line["id"], line["status"]), ("job", "j3", "accepted"))
        self.assertEqual(self.ok("triangulate", "a.laz", "-o", "x", "--detach", "--quiet"), "j4\n")

    def test_json_has_progress_and_summary(self):
        self.make_result()
        def work(job):
            job.tell("running", phase="splaying", figures={"elapsed": 100, "pointsTotal": 2000, "tilesTotal": 4, "tilesAsleep": 1})
            # A second passes before the display shows what did not change: the job goes on when it has been seen.
            seen.wait(60)
            job.tell("successful", triangulation="block")
        seen = threading.Event()
        self.server.on_submit = lambda job: threading.Thread(target=work, args=(job,)).start()
        process = subprocess.Popen([TESSERA, "triangulate", "a", "-o", "block", "--json"], stdout=subprocess.PIPE, text=True,
                                   env=os.environ | self.asking)
        lines = []
        for line in process.stdout:
            lines.append(json.loads(line))
            if lines[-1]["event"] == "progress":
                seen.set()
        self.assertEqual(process.wait(60), OK)
        process.stdout.close()
        self.assertEqual(lines[-1]["event"], "summary")
        shown = [line for line in lines if line["event"] == "progress"]
        self.assertEqual((shown[0]["phase"], shown[0]["tiles_asleep"], shown[0]["points_total"]), ("splaying", 1, 2000))
        self.assertGreater(shown[0]["elapsed_s"], 100)
        self.assertEqual([line["status"] for line in lines if line["event"] == "job"][-1], "successful")
        self.assertEqual(lines[-1]["vertices"], 2000)
        self.assertEqual(lines[-1]["out"], "block")


class Watch(ServerTest):
    def watch(self, *more):
        process = subprocess.Popen([TESSERA, "watch", "j1", *more], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
                                   env=os.environ | self.asking)
        self.addCleanup(process.stdout.close)
        self.addCleanup(process.stderr.close)
        self.addCleanup(lambda: process.poll() is None and (process.kill(), process.wait()))
        return process

    def await_streams(self, count):
        """Until so many have begun to listen."""
        with self.server.changed:
            self.assertTrue(self.server.changed.wait_for(lambda: len(self.listening) >= count, 60))

    def setUp(self):
        super().setUp()
        self.listening = []
        def on_events(job, handler):
            with self.server.changed:
                self.listening.append(handler.headers.get("Last-Event-ID"))
                self.server.changed.notify_all()
        self.server.on_events = on_events
        self.job = self.server.add_job("j1")

    def test_ctrl_c_leaves_the_job_alone_and_says_how_to_look_again(self):
        for number in (signal.SIGINT, signal.SIGTERM):
            count = len(self.listening)
            process = self.watch()
            self.await_streams(count + 1)
            process.send_signal(number)
            _, errors = process.communicate(timeout=60)
            self.assertEqual(process.returncode, INTERRUPTED)
            self.assertIn("tessera: detached; the job continues: 'tessera watch j1' shows it again, 'tessera cancel j1' stops it",
                          errors)
        self.assertEqual(self.server.asked("DELETE", ""), [])

    def test_a_job_that_has_ended_is_told_at_once(self):
        self.make_result()
        self.job.tell("successful", triangulation="block")
        self.assertIn("tetrahedra", self.ok("watch", "j1"))
        self.job.tell("failed", problem={"detail": "a.laz: is damaged", "cause": BAD_INPUT})
        self.refused(BAD_INPUT, "watch", "j1", says="a.laz: is damaged")
        self.job.tell("dismissed", resumable=True)
        self.refused(INTERRUPTED, "watch", "j1", says=["was cancelled", "'tessera resume j1' continues it"])
        self.refused(USAGE, "watch", "j9", says="there is no job j9")

    def test_a_daemon_that_is_killed_and_comes_back_is_waited_for(self):
        process = self.watch()
        self.assertEqual(process.stderr.readline(), "job j1 is accepted\n")
        self.job.tell("running", phase="routing")
        with self.server.changed:
            self.assertTrue(self.server.changed.wait_for(lambda: self.server.last_sent == 1, 60))
        self.server.stop()
        line = process.stderr.readline()
        while "waiting until the daemon answers" not in line:
            self.assertNotEqual(line, "", "it ended")
            line = process.stderr.readline()
        self.assertIn(self.server.url, line)
        self.job.tell("running", phase="collecting")
        self.server.start()
        self.await_streams(2)
        self.assertEqual(self.listening, [None, "1"])
        self.job.tell("failed", problem={"detail": "the disk is full", "cause": IO})
        _, errors = process.communicate(timeout=60)
        self.assertEqual(process.returncode, IO)
        self.assertIn("tessera: the disk is full", errors)

    def test_what_ended_while_the_daemon_was_gone_is_told(self):
        process = self.watch("--quiet")
        self.await_streams(1)
        self.server.stop()
        self.job.fields.update(status="failed", problem={"detail": "too bad", "cause": MEMORY})  # and no event of it
        self.server.start()
        _, errors = process.communicate(timeout=60)
        self.assertEqual((process.returncode, errors), (MEMORY, "tessera: too bad\n"))

    def test_patience_ends(self):
        process = self.watch("--patience", "0")
        self.await_streams(1)
        self.server.stop()
        _, errors = process.communicate(timeout=60)
        self.assertEqual(process.returncode, IO)
        self.assertIn(self.server.url, errors)
        self.server.start()

    def test_another_kind_of_job_has_its_outcome(self):
        self.job.fields["processID"] = "verify"
        self.job.outcome = {"passed": ["the hull is convex"], "cells": 12, "facets": 30, "hull_facets": 6, "vertices": 7}
        self.job.tell("successful", message="is done", triangulation="block")
        said = self.ok("watch", "j1")
        self.assertIn("ok  the hull is convex\nblock is the Delaunay triangulation of its 7 vertices: 12 cells", said)
        self.assertEqual(self.json_lines(self.ok("watch", "j1", "--json"))[-1], self.job.outcome)
        self.job.outcome = {}
        self.assertEqual(self.ok("watch", "j1"), "job j1: successful: is done\n")


if __name__ == "__main__":
    unittest.main()
