"""What docs/security.md and docs/operations.md promise of roles, bounds, the audit and older versions, at the real daemon."""
import resource
import signal
import time
import unittest
import urllib.parse

from daemon import IGN, DaemonTest

LAS = {"inputs": {"inputs": ["*.las"]}}


class Promises(DaemonTest):
    def start_with_roles(self, *options, **more):
        """A daemon with a token of each role: what asks with it."""
        daemon = self.start(*options, **more)
        roles = {role: f"{role}{'0123456789' * 6}" for role in ("read", "submit", "admin")}
        lines = [f"{role} {role} {token}" for role, token in roles.items()] + [f"other submit {'abcdefghij' * 6}"]
        (self.folder / "data/tokens").write_text("\n".join(lines) + "\n")
        daemon.process.send_signal(signal.SIGHUP)
        tokens = roles | {"other": "abcdefghij" * 6}

        def ask(role, method, path, body=None):
            return daemon.request(method, path, body, {"Authorization": f"Bearer {tokens[role]}"})
        # Until the signal has come. Nobody asks before: a refusal would be told of, and others of the same second not.
        while "tokens, certificate and key were read again" not in daemon.messages():
            time.sleep(0.01)
        return daemon, ask

    def execute(self, ask, role, process, **inputs):
        status, _, answer = ask(role, "POST", f"/v1/processes/{process}/execution", {"inputs": inputs})
        return status, answer

    def wait(self, daemon, ask, job):
        daemon.token = "admin" + "0123456789" * 6
        self.assertEqual(daemon.wait(job)["status"], "successful")

    def test_roles(self):
        daemon, ask = self.start_with_roles("--uploads")
        self.assertEqual(self.execute(ask, "read", "triangulate", **LAS["inputs"])[0], 403)
        self.assertEqual(ask("read", "POST", "/v1/processes/triangulate/estimate", LAS)[0], 403)
        self.assertEqual(ask("read", "PUT", "/v1/uploads/a/b", b"x")[0], 403)
        status, job = self.execute(ask, "submit", "triangulate", inputs=["*.las"], output="block")
        self.assertEqual(status, 201, job)
        self.wait(daemon, ask, job["jobID"])
        for role in ("read", "submit", "admin", "other"):
            self.assertEqual(ask(role, "GET", "/v1/triangulations/block")[0], 200)
        status, exported = self.execute(ask, "submit", "export", triangulation="block", output="mesh.ply")
        self.assertEqual(status, 201, exported)
        self.wait(daemon, ask, exported["jobID"])
        file = "/v1/triangulations/block/files/exports/mesh.ply"
        self.assertEqual([ask(role, "DELETE", file)[0] for role in ("read", "other", "submit", "submit")], [403, 403, 204, 404])
        for path in (f"/v1/jobs/{job['jobID']}", "/v1/triangulations/block"):
            self.assertEqual([ask(role, "DELETE", path)[0] for role in ("read", "other")], [403, 403], path)
        self.assertEqual(ask("submit", "DELETE", "/v1/triangulations/block")[0], 204)
        self.assertEqual(ask("admin", "DELETE", f"/v1/jobs/{job['jobID']}")[0], 200)
        self.assertEqual(daemon.end(), 0)

    def test_the_audit_tells_who_did_what_and_of_refusals_and_no_token(self):
        daemon, ask = self.start_with_roles()
        _, job = self.execute(ask, "submit", "triangulate", inputs=["*.las"], output="block")
        ask("other", "DELETE", f"/v1/jobs/{job['jobID']}")
        self.wait(daemon, ask, job["jobID"])
        ask("admin", "DELETE", "/v1/triangulations/block")
        daemon.request("GET", "/v1/jobs", token=False)
        daemon.request("GET", "/v1/jobs", headers={"Authorization": "Bearer wrong"})
        self.execute(ask, "read", "verify", triangulation="block")
        self.assertEqual(daemon.end(), 0)
        log = daemon.messages()
        for line in (f"audit: submit (submit) from 127.0.0.1: POST /v1/processes/triangulate/execution: 201, ../../jobs/{job['jobID']}",
                     f"audit: other (submit) from 127.0.0.1: DELETE /v1/jobs/{job['jobID']}: 403, job {job['jobID']} belongs to another caller",
                     "audit: admin (admin) from 127.0.0.1: DELETE /v1/triangulations/block: 204",
                     "audit: nobody (none) from 127.0.0.1: GET /v1/jobs: 401, a token is needed",
                     "audit: read (read) from 127.0.0.1: POST /v1/processes/verify/execution: 403"):
            self.assertIn(line, log)
        another = ("audit: nobody from 127.0.0.1: and 1 more refusal",  # within a second, or later
                   "audit: nobody (none) from 127.0.0.1: GET /v1/jobs: 401, the service does not know this token")
        self.assertEqual(sum(line in log for line in another), 1, log)
        for token in (daemon.token, "0123456789" * 6, "abcdefghij" * 6, "wrong"):
            self.assertNotIn(token, log)

    def test_no_line_of_the_log_is_more_than_text(self):
        evil = "x\x1b]0;t\x07\x9b2J\x85\u2028\u202e\u2066\n\x7fy"
        for kind in ("text", "json"):
            daemon = self.start("--log", kind)
            status, _, problem = daemon.request("POST", "/v1/processes/triangulate/execution", {"inputs": {"inputs": [evil]}})
            self.assertEqual(status, 422, problem)
            self.assertEqual(daemon.request("DELETE", "/v1/triangulations/" + urllib.parse.quote("x\x9b\u202e\u2028"))[0], 404)
            self.assertEqual(daemon.end(), 0)
            log = daemon.messages()
            self.assertGreaterEqual(log.count("audit: "), 2, log)
            bad = [c for c in log if c != "\n" and (ord(c) < 0x20 or 0x7f <= ord(c) < 0xa0 or c in "\u2028\u202e\u2066")]
            self.assertEqual(bad, [], log)

    def test_bounds(self):
        daemon = self.start("--uploads", env={"TESSERAD_LIMITS_QUEUED": "1", "TESSERAD_LIMITS_POINTS": "200000"})
        post = "/v1/processes/triangulate/execution"
        status, _, problem = daemon.request("POST", post, b" " * ((1 << 20) + 1), {"Content-Type": "application/json"})
        self.assertEqual((status, problem["title"]), (413, "Content Too Large"), problem)
        self.assertEqual(daemon.request("GET", "/v1", headers={"X-Long": "x" * 9000})[0], 431)
        status, _, problem = daemon.request("POST", post, LAS)
        self.assertEqual((status, problem["cause"]), (422, 7), problem)
        self.assertIn("262 813 points", problem["detail"])
        one = {"inputs": {"inputs": [sorted(IGN.glob("*.las"))[0].name]}}
        self.assertEqual(daemon.request("POST", post, one)[0], 201)
        while True:  # one runs, one waits; jobs that end in between make room for others
            status, _, problem = daemon.request("POST", post, one)
            if status != 201:
                break
        self.assertEqual((status, problem["cause"]), (429, 4), problem)
        self.assertEqual(daemon.end(), 0)

    def test_a_full_disk_is_told_and_harms_nothing(self):
        # A file cannot be longer than this: the system says so as it says that a disk is full.
        before = resource.getrlimit(resource.RLIMIT_FSIZE)
        resource.setrlimit(resource.RLIMIT_FSIZE, (2 << 20, before[1]))
        try:
            daemon = self.start("--uploads")
        finally:
            resource.setrlimit(resource.RLIMIT_FSIZE, before)
        status, _, problem = daemon.request("PUT", "/v1/uploads/a/large.las", b"x" * (32 << 20))  # most of it after the answer
        self.assertEqual((status, problem["cause"]), (507, 4), problem)
        self.assertEqual(daemon.request("PUT", "/v1/uploads/a/small.las", b"x")[0], 204)
        self.assertEqual(daemon.end(), 0)

    def test_an_older_daemon_refuses_what_a_newer_one_wrote(self):
        daemon = self.start()
        self.assertEqual(daemon.end(), 0)
        note = self.folder / "data/format"
        note.write_text(f"{int(note.read_text()) + 1}\n")
        with self.assertRaisesRegex(AssertionError, "was written by a newer version of tesserad"):
            self.start()


if __name__ == "__main__":
    unittest.main()
