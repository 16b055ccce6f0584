"""A peer with a certificate of the cluster that breaks every rule (hostile_proxy): no process ends, takes memory beyond its bound, or
touches anything outside its folders; and when the peer is gone the next job is right. HOSTILE_S seconds, SEED, SHARE of frames."""
import os
import pathlib
import re
import signal
import subprocess
import tempfile
import time
import unittest

from daemon import TESSERAD, DaemonTest
from hostile_proxy import Figures, Mutator, Proxy
from local_cluster import Node, free_port

SECONDS = float(os.environ.get("HOSTILE_S", "25"))
SEED = int(os.environ.get("SEED", "1"))
SHARE = float(os.environ.get("SHARE", "0.03"))
JOB_S = 5  # that each may take
MEMORY_MIB = 256
FRAMES_MIB = 256  # that may be under way together: actors/cluster/frames.h


class Begun:
    """A process that only works for the cluster."""

    def __init__(self, test, *options):
        self.log = tempfile.TemporaryFile()
        test.addCleanup(self.log.close)
        clean = {k: v for k, v in os.environ.items() if not k.startswith("TESSERA")}
        self.process = subprocess.Popen([TESSERAD, "--data", str(test.folder / "data"), *options], env=clean, cwd=test.folder / "outside",
                                        stdout=subprocess.DEVNULL, stderr=self.log)
        test.addCleanup(self.end)

    said = Node.said
    end = Node.end


class Hostile(DaemonTest):
    def setUp(self):
        super().setUp()
        self.tessera("certs", "init", "certs")
        self.tessera("certs", "node", "certs", "a", "b", "c", "e")
        (self.folder / "inputs").mkdir()
        self.tessera("generate", "uniform", "-n", "60k", "-o", "inputs/cloud.npy", "--quiet")
        for name in ("evil", "outside"):
            (self.folder / name).mkdir()
        self.ports = {name: free_port() for name in "abc"}
        self.doors = {name: free_port() for name in "abc"}  # where the others believe them to be
        self.http = free_port()
        data, evil = str(self.folder / "data").encode(), str(self.folder / "evil").encode()
        self.mutator, self.figures = Mutator(SEED, SHARE, [(data, evil)]), Figures()
        for name in "abc":
            proxy = Proxy(self.doors[name], self.ports[name], self.folder / "certs", "e", self.mutator, self.figures)
            self.addCleanup(proxy.end)
        self.coordinator = self.start(*self.of("a"), listen=f"127.0.0.1:{self.http}", inputs=self.folder / "inputs")
        self.nodes = {name: self.begin(name) for name in "bc"}
        self.wait_for_members()

    def of(self, name):
        return ("--cluster", f"127.0.0.1:{self.ports[name]}", "--advertise", f"127.0.0.1:{self.doors[name]}", "--certs",
                str(self.folder / "certs"), "--node-name", name, "--lease", "4s", "--grace", "20s", "--memory", f"{MEMORY_MIB}M")

    def begin(self, name):
        return Begun(self, *self.of(name), "--join", f"127.0.0.1:{self.doors['a']}", "--threads", "1", "--metrics", "none")

    def wait_until(self, holds, what):
        end = time.monotonic() + 300
        while not holds():
            self.assertLess(time.monotonic(), end, what())
            time.sleep(0.1)

    def free(self):
        return {node["name"] for node in self.coordinator.request("GET", "/v1/nodes")[2]["nodes"] if node["state"] == "free"}

    def wait_for_members(self):
        self.wait_until(lambda: self.free() == set("abc"), lambda: f"{self.free()}\n{self.all_said()}")

    def all_said(self):
        return "\n".join([self.coordinator.messages()[-4000:], *(node.said()[-4000:] for node in self.nodes.values())])

    def submit(self, output):
        status, _, job = self.coordinator.request(
            "POST", "/v1/processes/triangulate/execution",
            {"inputs": {"inputs": [str(self.folder / "inputs/cloud.npy")], "output": output, "tiles": 12, "overwrite": True}})
        self.assertEqual(status, 201, job)
        return job["jobID"]

    def status(self, job):
        return self.coordinator.request("GET", f"/v1/jobs/{job}")[2]

    def digest(self, output):
        job = self.submit(output)
        self.wait_until(lambda: self.status(job)["status"] not in ("accepted", "running"), lambda: f"{self.status(job)}\n{self.all_said()}")
        self.assertEqual(self.status(job)["status"], "successful", self.status(job))
        return self.coordinator.request("GET", f"/v1/triangulations/{output}")[2]["digest"]

    def processes(self):
        return {"a": self.coordinator.process, **{name: node.process for name, node in self.nodes.items()}}

    def assert_well(self):
        for name, process in self.processes().items():
            self.assertIsNone(process.poll(), f"{name} has ended with {process.returncode}\n{self.all_said()}")
            peak = int(re.search(r"VmHWM:\s+(\d+) kB", pathlib.Path(f"/proc/{process.pid}/status").read_text())[1])
            self.assertLess(peak, (MEMORY_MIB + FRAMES_MIB) << 10, f"{name}\n{self.all_said()}")

    def test_no_process_is_brought_down(self):
        alone = self.digest("undisturbed")
        ended = {}
        self.mutator.on.set()
        until, jobs = time.monotonic() + SECONDS, 0
        while time.monotonic() < until:
            job = self.submit(f"disturbed-{jobs}")  # one that was dismissed may still have its name for a while
            jobs += 1
            # A word that was lost may be waited for without end: TCP loses none.
            given_up = min(until, time.monotonic() + JOB_S)
            while self.status(job)["status"] in ("accepted", "running") and time.monotonic() < given_up:
                self.assert_well()
                time.sleep(0.2)
            if self.status(job)["status"] in ("accepted", "running"):
                self.coordinator.request("DELETE", f"/v1/jobs/{job}")
                self.wait_until(lambda: self.status(job)["status"] not in ("accepted", "running"), lambda: f"{self.status(job)}\n{self.all_said()}")
            ended[self.status(job)["status"]] = ended.get(self.status(job)["status"], 0) + 1
        self.mutator.on.clear()
        self.assert_well()
        # Words that were changed may have told a node to end, or whom it must not reach: as a supervisor does.
        for name, node in list(self.nodes.items()):
            node.end(signal.SIGKILL)
            self.nodes[name] = self.begin(name)
        self.wait_for_members()
        self.assertEqual(self.digest("after"), alone)
        self.assertEqual(list((self.folder / "evil").iterdir()), [])
        self.assertEqual(list((self.folder / "outside").iterdir()), [])
        f = self.figures
        print(f"figures: {f.frames} frames, {f.changed} of them changed, {f.connections} connections, {jobs} jobs {ended}, seed {SEED}")
        self.assertGreater(f.changed, 0)


if __name__ == "__main__":
    unittest.main()
