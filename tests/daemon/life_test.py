"""The daemon from start to end: jobs, results, signals, kill -9, a second start."""
import json
import os
import pathlib
import random
import signal
import unittest

from daemon import ENDED, IGN, DaemonTest


def execute(daemon, process="triangulate", **inputs):
    return daemon.request("POST", f"/v1/processes/{process}/execution", {"inputs": inputs})


class Life(DaemonTest):
    def test_a_job_over_http_gives_what_the_command_gives(self):
        daemon = self.start()
        status, head, job = execute(daemon, inputs=["*.las"], output="block", tiles=12)
        self.assertEqual(status, 201, job)
        self.assertIn(job["jobID"], head["Location"])
        seen = [data["status"]["status"] for _, _, data in daemon.events(f"/v1/jobs/{job['jobID']}/events", 0)
                if data and "status" in data]
        self.assertEqual(seen[-1], "successful", seen)
        last = daemon.request("GET", f"/v1/jobs/{job['jobID']}")[2]
        self.assertEqual((last["status"], last["progress"]), ("successful", 100))
        info = daemon.request("GET", "/v1/triangulations/block")[2]
        self.tessera("triangulate", *sorted(map(str, IGN.glob("*.las"))), "-o", "here", "--tiles", "5")
        self.assertEqual(info["digest"], json.loads(self.tessera("info", "here", "--json"))["digest"])
        self.tessera("verify", self.folder / "data/results/block")
        self.assertEqual(daemon.end(), 0, daemon.messages())

    def test_a_wrong_job_is_refused_with_the_field(self):
        daemon = self.start()
        status, head, problem = execute(daemon, inputs=["*.las"], partition="spiral")
        self.assertEqual((status, head["Content-Type"]), (400, "application/problem+json"), problem)
        self.assertEqual(problem["cause"], 2)
        self.assertIn("partition", problem["detail"])
        self.assertNotIn("--partition", problem["detail"])
        status, _, problem = execute(daemon, inputs=["nothing.las"])
        self.assertEqual((status, problem["cause"]), (422, 4), problem)
        self.assertIn("nothing.las", problem["detail"])
        self.assertEqual(daemon.end(), 0)

    def test_nobody_gets_in_without_a_token(self):
        daemon = self.start()
        status, _, problem = daemon.request("GET", "/v1/jobs", token=False)
        self.assertEqual(status, 401, problem)
        self.assertEqual(daemon.end(), 0)
        tokens = self.folder / "data/tokens"
        self.assertEqual(tokens.stat().st_mode & 0o777, 0o600)
        self.assertNotIn(daemon.token, daemon.messages())

    def test_nobody_else_reads_what_it_keeps(self):
        before = os.umask(0o022)  # that of most shells
        self.addCleanup(os.umask, before)
        daemon = self.start("--uploads")
        status, _, job = execute(daemon, inputs=["*.las"], output="block", tiles=4)
        self.assertEqual(status, 201, job)
        self.assertEqual(daemon.request("PUT", "/v1/uploads/d/f.xyz", b"1 2 3\n")[0], 204)
        self.assertEqual(daemon.wait(job["jobID"])["status"], "successful")
        data = self.folder / "data"
        kept = [data, *data.rglob("*")]
        for name in ("tokens", "results/block/manifest.json", f"jobs/{job['jobID']}/job.json", "uploads/d/f.xyz"):
            self.assertIn(data / name, kept)
        self.assertEqual([str(path) for path in kept if path.stat().st_mode & 0o077], [])
        self.assertNotIn("chmod", daemon.messages())
        self.assertEqual(daemon.end(), 0)
        # One that is open from before stays so, and the log says it.
        data.chmod(0o755)
        daemon = self.start()
        self.assertIn(f"{data}: other users can read this folder", daemon.messages())
        self.assertEqual(data.stat().st_mode & 0o777, 0o755)
        self.assertEqual(daemon.end(), 0)

    def test_a_token_that_is_taken_out_is_refused_after_sighup(self):
        daemon = self.start()
        tokens = self.folder / "data/tokens"
        other = "0123456789abcdef" * 4
        tokens.write_text(f"other read {other}\n")
        daemon.process.send_signal(signal.SIGHUP)
        while daemon.request("GET", "/v1/jobs")[0] == 200:
            pass
        asked = {"Authorization": f"Bearer {other}"}
        self.assertEqual(daemon.request("GET", "/v1/jobs", headers=asked)[0], 200)
        self.assertEqual(daemon.request("POST", "/v1/processes/verify/execution", {"inputs": {}}, headers=asked)[0], 403)
        self.assertEqual(daemon.end(), 0)

    def test_two_daemons_do_not_share_a_folder(self):
        lease = {"TESSERAD_LIMITS_DATA_LEASE": "3s"}  # the second one waits that long
        self.start(env=lease)
        with self.assertRaisesRegex(AssertionError, "status 4 .*data"):
            self.start(env=lease)

    def test_beyond_the_loopback_it_does_not_start_without_tls(self):
        with self.assertRaisesRegex(AssertionError, "certificate"):
            self.start(listen="0.0.0.0:0")

    def test_after_kill_9_every_job_ends_as_if_nothing_had_been(self):
        rng = random.Random(7)
        daemon = self.start()
        jobs = []
        for i in range(4):
            status, _, job = execute(daemon, inputs=["*.las"], output=f"r{i}", tiles=8 + i)
            self.assertEqual(status, 201, job)
            jobs.append(job["jobID"])
        for _ in range(2):  # a third death would be blamed on a job that ran each time
            # From the first event on: the jobs may have ended before anybody listens.
            going, events = set(jobs), rng.randrange(1, 12)
            for _, _, data in daemon.events("/v1/events", 1):
                if data and data.get("status", {}).get("status") in ENDED:
                    going.discard(data["status"]["jobID"])
                events -= 1
                if events <= 0 or not going:
                    break
            daemon.end(signal.SIGKILL)
            daemon = self.start()
        last = [daemon.wait(job) for job in jobs]
        self.assertEqual([job["status"] for job in last], ["successful"] * 4, last)
        digests = {daemon.request("GET", f"/v1/triangulations/r{i}")[2]["digest"] for i in range(4)}
        self.assertEqual(len(digests), 1)
        listed = daemon.request("GET", "/v1/jobs")[2]
        self.assertEqual(sorted(job["jobID"] for job in listed["jobs"]), sorted(jobs))
        self.assertEqual(daemon.end(), 0)
        left = [p for p in pathlib.Path(self.folder, "data").rglob("*") if p.name in (".run", ".lock") or ".tmp" in p.name]
        self.assertEqual(left, [])

    def test_sigterm_leaves_a_running_job_for_the_next_start(self):
        daemon = self.start()
        job = execute(daemon, inputs=["*.las"], output="block", tiles=40)[2]["jobID"]
        for _, _, data in daemon.events(f"/v1/jobs/{job}/events", 0):
            if data and data.get("status", {}).get("status") == "running":
                break
        self.assertEqual(daemon.end(), 0, daemon.messages())
        daemon = self.start()
        self.assertEqual(daemon.wait(job)["status"], "successful")
        self.assertEqual(daemon.end(), 0)


if __name__ == "__main__":
    unittest.main()
