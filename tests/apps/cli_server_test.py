"""Asking a daemon: jobs as if they ran here, whatever happens to the daemon, the connection and the watcher."""
import json
import os
import pathlib
import signal
import socket
import subprocess
import sys
import threading
import unittest

from cli import BAD_INPUT, INTERNAL, INTERRUPTED, IO, MEMORY, OK, TESSERA, USAGE, CliTest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "client"))
from fake_server import FakeServer  # noqa: E402


class ServerTest(CliTest):
    def setUp(self):
        super().setUp()
        self.server = FakeServer(token="secret-token")
        self.addCleanup(lambda: self.server.stop())
        self.asking = {"TESSERA_SERVER": self.server.url, "TESSERA_TOKEN": "secret-token"}

    def run_tessera(self, *args, env=None, **more):
        return super().run_tessera(*args, env=getattr(self, "asking", {}) | (env or {}), **more)

    def local(self, *args):
        return super().run_tessera(*args)

    def make_result(self, name="block", **more):
        out = self.folder / f"made-{name}"
        done = CliTest.run_tessera(self, "triangulate", self.xyz(f"{name}.xyz", **more), "-o", out, "--tiles", 4)
        self.assertEqual(done.returncode, OK, done.stderr)
        self.server.results[name] = out
        return done.stdout

    def succeed(self, job):
        job.tell("running", phase="triangulating", points=2000, started="2026-01-02T03:04:05Z",
                 tiles={"total": 4, "triangulated": 2, "asleep": 0, "stored": 0})
        job.tell(kind="log", text="half of it is done")
        job.tell("successful", triangulation="block", progress=100)


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
                "--recursive", "--overwrite", env={"TESSERA_CRS": "EPSG:2154"})
        inputs = self.server.jobs["j1"].inputs
        crs = inputs.pop("crs")
        self.assertIn("2154", crs)
        self.assertEqual(inputs, {
            "inputs": ["a.laz"], "output": "block", "dim": 2, "tile_points": 1500000, "partition": "grid", "threads": 3,
            "memory": "4G", "kernel": "cgal", "neighbors": False, "crop": [-1, 0.5, 2000, 4], "class": [2, 9],
            "attributes": ["red", "intensity"], "resolution": 0.25, "returns": "first", "without": ["withheld", "overlap"],
            "recursive": True, "overwrite": True})
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
            job.tell("running", phase="splaying", points=2000, tiles={"total": 4, "triangulated": 4, "asleep": 1, "stored": 0})
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
        self.assertEqual([line["status"] for line in lines if line["event"] == "job"][-1], "successful")
        self.assertEqual(lines[-1]["vertices"], 2000)
        self.assertEqual(lines[-1]["out"], "block")


class Failures(ServerTest):
    def test_the_cause_of_the_problem_is_the_exit_status(self):
        for cause in (USAGE, BAD_INPUT, IO, MEMORY, INTERNAL):
            problem = {"detail": f"memory: too small for {cause}", "cause": cause, "status": 422}
            self.server.on_submit = lambda job: (job.tell("running"), job.tell("failed", problem=problem))
            self.refused(cause, "triangulate", "a", "-o", "x", says=f"tessera: memory: too small for {cause}")

    def test_a_refused_job_says_why(self):
        path = "/v1/processes/triangulate/execution"
        self.server.refusals["POST", path] = (422, {"detail": "memory: 1 GiB is too little, 5 GiB are needed", "cause": MEMORY})
        self.refused(MEMORY, "triangulate", "a", "-o", "x", says="memory: 1 GiB is too little, 5 GiB are needed")
        self.server.refusals["POST", path] = (429, {"detail": "10000 jobs wait already"})
        self.refused(IO, "triangulate", "a", "-o", "x", says="10000 jobs wait already")

    def test_nobody_is_there(self):
        with socket.socket() as nobody:
            nobody.bind(("127.0.0.1", 0))
            url = f"http://127.0.0.1:{nobody.getsockname()[1]}"
            self.refused(IO, "jobs", "--server", url, says=[url, "no server can be reached there: Connection refused"])

    def test_a_wrong_token_and_none(self):
        self.refused(USAGE, "jobs", env={"TESSERA_TOKEN": "wrong"}, says=["does not know this token", "--token-file"])
        self.refused(USAGE, "jobs", env={"TESSERA_TOKEN": ""}, says=["wants a token", "TESSERA_TOKEN"])
        self.refused(USAGE, "jobs", env={"TESSERA_TOKEN": "a\nb: c"}, says="token")
        self.assertTrue(all("\n" not in request[2].get("Authorization", "") for request in self.server.requests))

    def test_the_token_comes_from_a_file_or_the_address_too(self):
        token = self.write("token", "secret-token\n")
        self.ok("jobs", "--token-file", token, env={"TESSERA_TOKEN": "wrong"})
        self.ok("jobs", "--server", self.server.url + "/?token=secret-token", env={"TESSERA_TOKEN": ""})
        self.refused(IO, "jobs", "--token-file", "nowhere", says="nowhere")
        self.refused(USAGE, "jobs", "--token-file", self.write("empty", "\n"), says="holds no token")

    def test_an_address_that_is_none(self):
        for url in ("localhost:7070", "ftp://x/", "http://host:0"):
            self.refused(USAGE, "jobs", "--server", url, says="--server: ")
        self.refused(USAGE, "jobs", env={"TESSERA_SERVER": ""}, says=["no daemon is named", "TESSERA_SERVER"])

    def test_something_else_answers(self):
        for foreign in ((200, "text/html", b"<html>"), (404, "text/html", b"no"), (200, "application/json", b"[1, 2]"),
                        (200, "application/json", b"{"), (500, "application/json", b"\xff")):
            self.server.foreign = foreign
            self.refused(USAGE, "jobs", says=[self.server.url, "no Tessera server"])
            self.refused(USAGE, "watch", "j1", says="no Tessera server")

    def test_what_answers_speaks_no_http(self):
        with socket.create_server(("127.0.0.1", 0)) as listener:
            def greet():
                connection, _ = listener.accept()
                with connection:
                    connection.sendall(b"SSH-2.0-OpenSSH_9.2\r\n")
                    connection.recv(10000)
            thread = threading.Thread(target=greet)
            thread.start()
            url = f"http://127.0.0.1:{listener.getsockname()[1]}"
            self.refused(USAGE, "jobs", "--server", url, says="no HTTP is spoken there")
            thread.join()

    def test_a_field_that_no_message_has_is_passed_over(self):
        self.server.add_job("j1")
        self.assertIn("j1", self.ok("jobs"))


class Tls(ServerTest):
    def setUp(self):
        super().setUp()
        for name, subject in (("good", "IP:127.0.0.1"), ("other", "DNS:other.example")):
            subprocess.run(["openssl", "req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:P-256", "-nodes", "-days",
                            "2", "-subj", "/CN=x", "-addext", f"subjectAltName={subject}", "-keyout", self.folder / f"{name}.key",
                            "-out", self.folder / f"{name}.crt"], check=True, capture_output=True)
            self.write(f"{name}.pem", (self.folder / f"{name}.crt").read_bytes() + (self.folder / f"{name}.key").read_bytes())

    def serve(self, name):
        server = FakeServer(certificate=self.folder / f"{name}.pem")
        self.addCleanup(server.stop)
        return server

    def test_a_trusted_certificate_is_taken_and_others_are_not(self):
        server = self.serve("good")
        server.add_job("j1")
        self.assertIn("j1", self.ok("jobs", "--server", server.url, "--ca", self.folder / "good.crt"))
        count = len(server.requests)
        self.refused(USAGE, "jobs", "--server", server.url, says=["certificate", "not trusted", "--ca"])
        self.refused(USAGE, "jobs", "--server", server.url, "--ca", self.folder / "other.crt", says="not trusted")
        self.refused(IO, "jobs", "--server", server.url, "--ca", self.write("no.pem", "x"), says="no.pem")
        other = self.serve("other")
        self.refused(USAGE, "jobs", "--server", other.url, "--ca", self.folder / "other.crt", says="not trusted")
        self.assertEqual((len(server.requests), len(other.requests)), (count, 0), "no token was sent there")

    def test_tls_and_none_are_told_apart(self):
        self.refused(USAGE, "jobs", "--server", self.server.url.replace("http", "https"), says="no TLS is spoken there")


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
            self.assertIn("tessera: detached; the job goes on: 'tessera watch j1' shows it again, 'tessera cancel j1' stops it",
                          errors)
        self.assertEqual(self.server.asked("DELETE", ""), [])

    def test_a_job_that_has_ended_is_told_at_once(self):
        self.make_result()
        self.job.tell("successful", triangulation="block")
        self.assertIn("tetrahedra", self.ok("watch", "j1"))
        self.job.tell("failed", problem={"detail": "a.laz: is damaged", "cause": BAD_INPUT})
        self.refused(BAD_INPUT, "watch", "j1", says="a.laz: is damaged")
        self.job.tell("dismissed", resumable=True)
        self.refused(INTERRUPTED, "watch", "j1", says=["was cancelled", "'tessera resume j1' goes on"])
        self.refused(USAGE, "watch", "j9", says="there is no job j9")

    def test_a_daemon_that_is_killed_and_comes_back_is_waited_for(self):
        process = self.watch()
        self.assertEqual(process.stderr.readline(), "job j1 waits for its turn\n")
        self.job.tell("running", phase="routing")
        with self.server.changed:
            self.assertTrue(self.server.changed.wait_for(lambda: self.server.last_sent == 1, 60))
        self.server.stop()
        line = process.stderr.readline()
        while "is waited for" not in line:
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
        self.job.outcome = {"passed": ["hull"], "cells": 12}
        self.job.tell("successful", message="proved")
        self.assertEqual(self.ok("watch", "j1"), "job j1: successful: proved\n")
        self.assertEqual(self.json_lines(self.ok("watch", "j1", "--json"))[-1], self.job.outcome)


class Jobs(ServerTest):
    def test_they_are_listed_over_all_pages(self):
        self.assertEqual(self.ok("jobs"), "there are no jobs\n")
        for i in range(7):
            self.server.add_job(f"j{i}", status="running" if i % 2 else "accepted", phase="splaying")
        self.server.page = 3
        lines = self.ok("jobs").splitlines()
        self.assertRegex(lines[0], "^JOB +STATUS")
        self.assertEqual([line.split()[0] for line in lines[1:]], [f"j{i}" for i in range(7)])
        self.assertIn("joining tiles", lines[2])
        self.assertEqual([job["id"] for job in self.json_lines(self.ok("jobs", "--json", "--limit", 5))],
                         [f"j{i}" for i in range(5)])
        self.assertEqual([job["status"] for job in self.json_lines(self.ok("jobs", "--json", "--status", "running"))],
                         ["running"] * 3)
        self.refused(USAGE, "jobs", "--limit", 0, says="--limit")

    def test_one_is_told(self):
        self.server.add_job("a b/c", status="failed", problem={"detail": "no space", "cause": IO}, resumable=True, starts=2,
                            started="2026-01-02T03:04:06Z")
        text = self.ok("job", "a b/c")
        for part in ("failed, 0 %, can be resumed", "problem       no space", "for the 2. time"):
            self.assertIn(part, text)
        (line,) = self.json_lines(self.ok("job", "a b/c", "--json"))
        self.assertEqual((line["problem"], line["starts"]), ({"detail": "no space", "cause": IO}, 2))
        self.assertTrue(self.server.asked("GET", "^/v1/jobs/a%20b%2Fc$"))
        self.refused(USAGE, "job", says="tessera jobs")
        self.refused(USAGE, "job", "x", says="there is no job x")

    def test_cancel_stops_what_runs_and_forgets_nothing(self):
        job = self.server.add_job("j1", status="running")
        self.assertEqual(self.ok("cancel", "j1"), "job j1 is cancelled; 'tessera resume j1' goes on with it\n")
        self.assertEqual(job.fields["status"], "dismissed")
        self.refused(USAGE, "cancel", "j1", says="has ended already: dismissed")
        self.assertEqual(len(self.server.asked("DELETE", "")), 1)

    def test_resume_goes_on_and_watches(self):
        self.make_result()
        self.server.on_submit = self.succeed
        self.server.add_job("j1", status="failed", resumable=True)
        self.assertIn("tetrahedra", self.ok("resume", "j1"))
        self.refused(USAGE, "resume", "j1", says="cannot be resumed")
        self.server.add_job("j2", status="dismissed", resumable=True)
        self.server.on_submit = lambda job: None
        self.assertIn("job j2 is running", self.ok("resume", "j2", "--detach"))


if __name__ == "__main__":
    unittest.main()
