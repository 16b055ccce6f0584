"""Clients that submit, stop, resume, watch and forget jobs at once, while the daemon is killed again and again (SIGKILL): each job that
was accepted is there or is said to be forgotten, has ended, and is right; a key makes one job. JOBS, KILLS, SEED."""
import http.client
import os
import random
import threading
import time
import unittest

import numpy

from daemon import ENDED, DaemonTest
from local_cluster import free_port

JOBS, KILLS = int(os.environ.get("JOBS", "24")), int(os.environ.get("KILLS", "3"))
SEED = int(os.environ.get("SEED", "1"))
CLIENTS = 8
GONE = (ConnectionError, http.client.HTTPException, AssertionError)  # the last: no answer while nobody listens


class Storm(DaemonTest):
    def setUp(self):
        super().setUp()
        self.inputs = self.folder / "inputs"
        self.inputs.mkdir()
        random_points = numpy.random.default_rng(SEED)
        self.digests = []
        for points in (2_000, 30_000, 120_000):
            numpy.save(self.inputs / f"{points}.npy", random_points.random((points, 3)))
            self.tessera("triangulate", self.inputs / f"{points}.npy", "-o", f"{points}", "--quiet")
            digest = next(line.split()[-1] for line in self.tessera("info", f"{points}").splitlines() if "digest" in line)
            self.digests.append((f"{points}.npy", digest))
        self.port, self.failures = free_port(), []
        self.begin()

    def begin(self):
        self.daemon = self.start(listen=f"127.0.0.1:{self.port}", inputs=self.inputs)

    def ask(self, method, path, body=None, headers=None):
        """The answer of whichever daemon there is, in the end: what is asked may be done twice."""
        while True:
            try:
                return self.daemon.request(method, path, body, headers)
            except GONE:
                time.sleep(0.01)  # until another one listens

    def life_of(self, number, rng, jobs, watchers):
        """Submits a job, perhaps twice, and does to it what users do."""
        cloud, digest = rng.choice(self.digests)
        body = {"inputs": {"inputs": [cloud], "output": f"r{number}", "tiles": rng.choice([1, 4, 9])}}
        ids = set()
        for _ in range(rng.choice([1, 1, 2])):
            status, _, job = self.ask("POST", "/v1/processes/triangulate/execution", body, {"Idempotency-Key": f"key-{number}"})
            while status in (429, 503):
                status, _, job = self.ask("POST", "/v1/processes/triangulate/execution", body, {"Idempotency-Key": f"key-{number}"})
            self.assertIn(status, (200, 201), job)
            ids.add(job["jobID"])
        self.assertEqual(len(ids), 1, f"two jobs of one key: {ids}")
        job = ids.pop()
        if rng.random() < 0.25:
            watcher = threading.Thread(target=self.watch, args=(job,))
            watcher.start()
            watchers.append(watcher)
        wanted = "successful"
        if rng.random() < 0.3:
            wanted = self.stopped(job, resumed=rng.random() < 0.8)
        jobs[job] = (number, digest, wanted)
        if wanted == "successful" and rng.random() < 0.2:
            self.until_ended(job)
            self.assertIn(self.ask("DELETE", f"/v1/jobs/{job}")[0], (200, 404, 410))
            jobs[job] = (number, digest, "forgotten")

    def stopped(self, job, resumed):
        time.sleep(0.2)  # anything between waiting and the end
        status = self.ask("DELETE", f"/v1/jobs/{job}")[0]
        if status in (404, 410):
            return "forgotten"
        ended = self.until_ended(job)
        if ended is None or ended["status"] == "successful":  # it had ended: the DELETE has forgotten it, or came when it was ending
            return "forgotten or successful"
        self.assertEqual(ended["status"], "dismissed", ended)
        if not resumed:
            return "dismissed"
        answer = self.ask("POST", f"/v1/jobs/{job}/resume")
        self.assertIn(answer[0], (200, 409), answer)  # 409: the resume that got no answer was heard
        return "successful"

    def until_ended(self, job):
        while True:
            status, _, answer = self.ask("GET", f"/v1/jobs/{job}")
            if status in (404, 410):
                return None
            if answer["status"] in ENDED:
                return answer
            time.sleep(0.05)

    def watch(self, job):
        while True:
            try:
                for _ in self.daemon.events(f"/v1/jobs/{job}/events"):
                    pass
                status, _, answer = self.daemon.request("GET", f"/v1/jobs/{job}")
                if status != 200 or answer["status"] in ENDED:
                    return
            except GONE:
                time.sleep(0.01)

    def client(self, numbers, jobs, watchers, rng):
        try:
            for number in numbers:
                self.life_of(number, rng, jobs, watchers)
        except BaseException as failure:  # told by the thread of the test
            self.failures.append(failure)

    def test_jobs_outlast_every_kill(self):
        began = time.monotonic()
        jobs, watchers = {}, []
        clients = [threading.Thread(target=self.client, args=(range(c, JOBS, CLIENTS), jobs, watchers, random.Random(SEED * 1000 + c)))
                   for c in range(CLIENTS)]
        for client in clients:
            client.start()
        rng, killed = random.Random(SEED), 0
        while killed < KILLS:
            time.sleep(rng.uniform(0.5, 4))  # any moment
            self.daemon.end(9)
            self.begin()
            killed += 1
        for thread in clients + watchers:
            thread.join()
        if self.failures:
            raise self.failures[0]
        self.assertEqual(len(jobs), JOBS)
        right = 0
        for job, (number, digest, wanted) in jobs.items():
            ended = self.until_ended(job)
            # Whoever ran at three deaths is given up, with a sentence, and goes on when it is asked to.
            while ended and ended["status"] == "failed" and "the daemon died" in ended["problem"]["detail"]:
                self.assertEqual(self.ask("POST", f"/v1/jobs/{job}/resume")[0], 200)
                ended = self.until_ended(job)
            state = ended["status"] if ended else "forgotten"
            self.assertIn(state, wanted.split(" or "), f"{job}: {ended}")
            if state == "successful":
                self.assertEqual(self.ask("GET", f"/v1/triangulations/r{number}")[2]["digest"], digest)
                right += 1
        listed = {job["jobID"] for job in self.ask("GET", "/v1/jobs?limit=1000")[2]["jobs"]}
        self.assertLessEqual(listed, set(jobs))
        self.assertEqual(self.daemon.end(), 0, self.daemon.messages())
        left = [str(p) for p in (self.folder / "data").rglob("*") if ".tmp" in p.name or p.name.startswith(".desk")]
        self.assertEqual(left, [])
        print(f"figures: {JOBS} jobs, {killed} kills, {right} results right, {len(watchers)} watchers, "
              f"{time.monotonic() - began:.0f} s, SEED={SEED}")


if __name__ == "__main__":
    unittest.main()
