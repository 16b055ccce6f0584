"""Processes of a cluster are killed at random moments of its jobs, and each result is the one of the command. KILLS, COORDINATOR_KILLS,
A_JOB (how many while one job runs), POINTS or CLOUD (a file), TILES, MEMORY, SEED make it longer."""
import os
import pathlib
import random
import shutil
import statistics
import sys
import time

from namespaces import SEED, ClusterTest

KILLS = int(os.environ.get("KILLS", "2"))
COORDINATOR_KILLS = int(os.environ.get("COORDINATOR_KILLS", "2"))
A_JOB = int(os.environ.get("A_JOB", "1"))
CLOUD = os.environ.get("CLOUD")
MEMORY = os.environ.get("MEMORY", "512M")


class Kills(ClusterTest):
    tiles = os.environ.get("TILES", "16")

    def make_cloud(self):
        if not CLOUD:
            return super().make_cloud()
        (self.folder / "inputs").mkdir()
        return pathlib.Path(shutil.copy(CLOUD, self.folder / "inputs"))

    def setUp(self):
        super().setUp()
        self.chance = random.Random(SEED)
        self.processes = {name: self.start(name) for name in "abcd"}
        self.wait_for_members(4)
        begin = time.monotonic()
        self.assert_right(self.submit("undisturbed"))
        self.undisturbed = time.monotonic() - begin

    def start(self, name):
        if name != "a":
            return self.node(name, "--memory", MEMORY)
        self.first = self.coordinator("a", "--memory", MEMORY)
        self.wait_until(lambda: self.tessera("nodes", check=False).returncode == 0, self.first.said)
        return self.first

    def runs(self, job):
        return self.job(job)["status"] in ("accepted", "running")

    def kill_while_jobs_run(self, names, count):
        """At any moments of as long as a job takes undisturbed; A_JOB of them, but when it ends before."""
        killed, took = 0, []
        while killed < count:
            name, begin, before = f"job-{len(took)}", time.monotonic(), killed
            job = self.submit(name)
            for moment in sorted(self.chance.random() * self.undisturbed for _ in range(min(A_JOB, count - killed))):
                while self.runs(job) and time.monotonic() < begin + moment:
                    time.sleep(max(0, min(0.2, begin + moment - time.monotonic())))
                if not self.runs(job):
                    break
                victim = self.chance.choice(names)
                self.processes[victim].end()
                self.processes[victim] = self.start(victim)
                killed += 1
            self.assert_right(job)
            took.append(time.monotonic() - begin)
            if killed == before:  # the machine is faster than it was
                self.undisturbed = min(self.undisturbed, took[-1])
            self.remove(name)
            self.wait_for_members(4)
        print(f"figures: {killed} killed in {len(took)} jobs, seed {SEED}; a job took "
              f"{statistics.median(took):.1f} s in the median, {max(took):.1f} s at most, {self.undisturbed:.1f} s undisturbed",
              file=sys.stderr)

    def test_nodes(self):
        self.kill_while_jobs_run("bcd", KILLS)

    def test_the_coordinator(self):
        self.kill_while_jobs_run("a", COORDINATOR_KILLS)
