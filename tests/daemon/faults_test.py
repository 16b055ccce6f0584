"""What happens to the real daemon: a full disk, a folder that cannot be written, a stop, jumping clocks, deadly jobs."""
import http.client
import json
import os
import pathlib
import signal
import subprocess
import time
import unittest

import numpy

from daemon import DaemonTest

FAKETIME = pathlib.Path("/usr/lib/x86_64-linux-gnu/faketime/libfaketime.so.1")
TEMPORARY_DISK = unittest.skipIf(os.geteuid() != 0, "only root may mount")


class Faults(DaemonTest):
    def setUp(self):
        super().setUp()
        self.inputs = self.folder / "inputs"
        self.inputs.mkdir()
        self.cloud("small", 2000)

    def cloud(self, name, points):
        numpy.save(self.inputs / f"{name}.npy", numpy.random.default_rng(1).random((points, 3)))

    def start(self, *options, **more):
        return super().start(*options, inputs=self.inputs, **more)

    def submit(self, daemon, cloud, output, **more):
        status, _, job = daemon.request("POST", "/v1/processes/triangulate/execution",
                                        {"inputs": {"inputs": [f"{cloud}.npy"], "output": output, **more}})
        self.assertEqual(status, 201, job)
        return job["jobID"]

    def test_inputs_are_named_from_their_folder_on(self):
        """In answers, jobs and their logs: where they lie on the machine is nobody's business."""
        (self.inputs / "block").mkdir()
        (self.inputs / "block/torn.npy").write_bytes((self.inputs / "small.npy").read_bytes()[:1000])
        daemon = self.start()
        body = {"inputs": {"inputs": ["block/torn.npy"], "output": "torn"}}
        said = [daemon.request("POST", "/v1/processes/info/execution", {"inputs": {"inputs": ["block/torn.npy"]}}),
                daemon.request("POST", "/v1/processes/triangulate/estimate", body)]
        self.assertEqual([status for status, _, _ in said], [422, 422])
        status, _, job = daemon.request("POST", "/v1/processes/triangulate/execution", body)
        if status == 201:
            said.append((0, {}, daemon.wait(job["jobID"])["problem"]))
        else:
            said.append((status, {}, job))
        for _, _, problem in said:
            self.assertRegex(problem["detail"], "(^|[ '\"])block/torn.npy[,:] ")
            self.assertNotIn(str(self.folder), json.dumps(problem))
        self.assertEqual(daemon.end(), 0, daemon.messages())

    def until(self, daemon, job, *states, phase=None):
        """The job's status once it is one of those, and in that phase."""
        for _, _, data in daemon.events(f"/v1/jobs/{job}/events"):
            status = (data or {}).get("status", {})
            if status.get("status") in states and phase in (None, status.get("phase")):
                return status
        self.fail(f"job {job} was never {states}: {daemon.request('GET', f'/v1/jobs/{job}')[2]}")

    def successful(self, daemon, job):
        last = daemon.wait(job)
        self.assertEqual(last["status"], "successful", last)
        return last

    def mount(self, megabytes):
        disk = self.folder / "data"
        disk.mkdir()
        if subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={megabytes}m", "tmpfs", disk]).returncode != 0:
            self.skipTest("tmpfs cannot be mounted here")
        self.addCleanup(subprocess.run, ["umount", "-l", disk], check=True)
        return disk

    @staticmethod
    def fill(disk):
        with open(disk / "filler", "ab", buffering=0) as filler:
            piece = bytes(1 << 16)
            try:
                while filler.write(piece) == len(piece):
                    pass
            except OSError:
                pass

    @TEMPORARY_DISK
    def test_a_disk_that_fills_up_fails_the_job_that_meets_it_and_nothing_else(self):
        disk = self.mount(1024)
        self.cloud("large", 800_000)
        daemon = self.start()
        before = self.submit(daemon, "small", "before")
        self.successful(daemon, before)
        job = self.submit(daemon, "large", "block")
        self.until(daemon, job, "running", phase="triangulating")
        daemon.process.send_signal(signal.SIGSTOP)  # filling it takes a while
        self.fill(disk)
        daemon.process.send_signal(signal.SIGCONT)
        last = daemon.wait(job)
        self.assertEqual(last["status"], "failed", last)
        self.assertEqual((last["problem"]["status"], last["problem"]["cause"]), (507, 4), last)
        self.assertIn("No space left on device", last["problem"]["detail"])
        self.fill(disk)  # what it had made is gone
        status, _, problem = daemon.request("POST", "/v1/processes/triangulate/execution",
                                            {"inputs": {"inputs": ["small.npy"]}})
        self.assertEqual(status, 507, problem)
        self.assertEqual(len(daemon.request("GET", "/v1/jobs")[2]["jobs"]), 2)
        self.assertEqual(daemon.request("GET", "/v1/triangulations/before/files/manifest.json")[0], 200)
        (disk / "filler").unlink()
        self.assertEqual(daemon.request("POST", f"/v1/jobs/{job}/resume")[0], 200)
        self.successful(daemon, job)
        self.assertEqual(daemon.end(), 0, daemon.messages())
        self.assertEqual(sorted(p.name for p in (disk / "results").iterdir()), ["before", "block"])
        self.tessera("verify", disk / "results/block")

    @TEMPORARY_DISK
    def test_a_daemon_that_starts_on_a_full_disk_serves_and_removes_results(self):
        disk = self.mount(256)
        daemon = self.start()
        for name in ("first", "second"):
            self.successful(daemon, self.submit(daemon, "small", name))
        daemon.end(signal.SIGKILL)
        self.fill(disk)
        daemon = self.start()  # what it needs of the disk it has kept for this
        self.assertEqual(daemon.request("GET", "/v1/triangulations/first/files/manifest.json")[0], 200)
        self.assertEqual(len(daemon.request("GET", "/v1/jobs")[2]["jobs"]), 2)
        self.fill(disk)
        status, _, problem = daemon.request("POST", "/v1/processes/triangulate/execution",
                                            {"inputs": {"inputs": ["small.npy"]}})
        self.assertEqual(status, 507, problem)
        self.assertEqual(daemon.request("DELETE", "/v1/triangulations/first")[0], 204)
        jobs = [job["jobID"] for job in daemon.request("GET", "/v1/jobs")[2]["jobs"]]
        for job in jobs:
            self.fill(disk)
            self.assertEqual(daemon.request("DELETE", f"/v1/jobs/{job}")[0], 200)
        daemon.end(signal.SIGKILL)
        (disk / "filler").unlink()
        daemon = self.start()
        for job in jobs:
            self.assertEqual(daemon.request("GET", f"/v1/jobs/{job}")[0], 410)
        self.successful(daemon, self.submit(daemon, "small", "third"))
        self.assertTrue((disk / "reserve").exists())
        self.assertEqual(daemon.end(), 0, daemon.messages())

    @TEMPORARY_DISK
    def test_a_folder_that_cannot_be_written_is_refused_at_the_start_and_said_afterwards(self):
        disk = self.mount(256)
        daemon = self.start()
        self.successful(daemon, self.submit(daemon, "small", "before"))
        subprocess.run(["mount", "-o", "remount,ro", disk], check=True)
        status, _, problem = daemon.request("POST", "/v1/processes/triangulate/execution",
                                            {"inputs": {"inputs": ["small.npy"]}})
        self.assertEqual((status, problem["cause"]), (500, 4), problem)
        self.assertIn("Read-only file system", problem["detail"])
        self.assertEqual(daemon.request("GET", "/v1/triangulations/before/files/manifest.json")[0], 200)
        self.assertEqual(len(daemon.request("GET", "/v1/jobs")[2]["jobs"]), 1)
        subprocess.run(["mount", "-o", "remount,rw", disk], check=True)
        self.successful(daemon, self.submit(daemon, "small", "after"))
        self.assertEqual(daemon.end(), 0, daemon.messages())
        subprocess.run(["mount", "-o", "remount,ro", disk], check=True)
        with self.assertRaisesRegex(AssertionError, "data.*Read-only file system"):
            self.start()

    def test_a_stopped_daemon_goes_on_where_it_was(self):
        self.cloud("large", 300_000)
        daemon = self.start()
        job = self.submit(daemon, "large", "block")
        self.until(daemon, job, "running")
        asked = http.client.HTTPConnection("127.0.0.1", daemon.port)
        self.addCleanup(asked.close)
        asked.connect()
        daemon.process.send_signal(signal.SIGSTOP)
        asked.request("GET", "/v1/jobs", headers={"Authorization": f"Bearer {daemon.token}"})
        time.sleep(float(os.environ.get("TESSERA_STOP_S", "1")))  # the stop is the fault
        daemon.process.send_signal(signal.SIGCONT)
        self.assertEqual(asked.getresponse().status, 200)
        self.assertEqual(self.successful(daemon, job)["starts"], 1)
        self.assertEqual(daemon.end(), 0, daemon.messages())

    @unittest.skipIf(not FAKETIME.exists(), "libfaketime is missing: deploy/install-deps.sh")
    def test_jumps_of_the_clock_change_no_order_and_lose_nothing(self):
        clock = self.folder / "clock"
        clock.write_text("+0\n")
        daemon = self.start(env={"LD_PRELOAD": str(FAKETIME), "FAKETIME_TIMESTAMP_FILE": str(clock),
                                 "FAKETIME_NO_CACHE": "1", "FAKETIME_DONT_FAKE_MONOTONIC": "1"})
        jobs, years = [], []
        for jump in ("+0", "+3650d", "-3650d", "+1d"):
            clock.write_text(jump + "\n")
            jobs.append(self.submit(daemon, "small", f"r{len(jobs)}"))
            years.append(int(self.successful(daemon, jobs[-1])["created"][:4]))
        self.assertEqual((years[1] > years[0], years[2] < years[0]), (True, True), years)  # it did jump
        self.assertEqual(jobs, sorted(jobs))
        listed = daemon.request("GET", "/v1/jobs")[2]["jobs"]
        self.assertEqual([job["jobID"] for job in listed], jobs[::-1])
        ids = [int(event) for job in jobs for event, _, _ in daemon.events(f"/v1/jobs/{job}/events", 1) if event]
        self.assertGreater(len(ids), 3 * len(jobs))
        self.assertEqual(ids, sorted(set(ids)))
        self.assertEqual(daemon.end(), 0, daemon.messages())
        daemon = self.start()  # the clock is right again
        later = self.submit(daemon, "small", "later")
        self.assertGreater(later, jobs[-1])
        self.successful(daemon, later)
        self.assertEqual(daemon.end(), 0)

    def test_what_a_job_asks_beyond_its_share_is_said(self):
        daemon = self.start()
        job = self.submit(daemon, "small", "block", memory="64G", threads=64)
        log = daemon.request("GET", f"/v1/jobs/{job}/log")[2].decode()
        self.assertIn("threads: 64 are asked for, but a job gets 2 here; memory: 64.0 GiB are asked for, but a job gets 1.00 GiB here", log)
        self.successful(daemon, job)
        self.assertEqual(daemon.end(), 0)

    def test_a_job_that_kills_the_daemon_is_given_up_and_its_neighbours_end(self):
        self.cloud("large", 800_000)
        daemon = self.start()
        deadly = self.submit(daemon, "large", "deadly")
        neighbour = self.submit(daemon, "small", "neighbour")
        while (last := daemon.request("GET", f"/v1/jobs/{deadly}")[2])["status"] != "failed":
            if last["status"] == "successful":  # it has ended before it could be killed
                deadly = self.submit(daemon, "large", "deadly", overwrite=True)
            if self.until(daemon, deadly, "running", "successful")["status"] == "running":
                daemon.end(signal.SIGKILL)  # as the system does to who has taken all memory
                daemon = self.start()
        self.successful(daemon, neighbour)
        self.assertEqual((last["status"], last["starts"], last["resumable"]), ("failed", 3, True), last)
        self.assertIn("the daemon died 3 times", last["problem"]["detail"])
        self.assertIn("the daemon died 3 times", daemon.messages())
        self.assertEqual(daemon.request("POST", f"/v1/jobs/{deadly}/resume")[0], 200)
        self.successful(daemon, deadly)
        self.assertEqual(daemon.end(), 0)


if __name__ == "__main__":
    unittest.main()
