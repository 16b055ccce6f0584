"""Memory beside a slow node: of four nodes one runs a tenth of the time, the others have what is for it, and stay within what
they were given. POINTS=4M MEMORY=1G TILES=64 SLOW_FIGURES=1 runs a large one and prints what each took."""
import os
import pathlib
import re
import signal
import threading
import time

import local_cluster
from daemon import DaemonTest
from local_cluster import free_port

POINTS = os.environ.get("POINTS", "400k")
TILES = int(os.environ.get("TILES", "32"))
MEMORY = os.environ.get("MEMORY", "128M")
# By the memory model: docs/benchmarks.md.
WITHIN = 1.05


def mebibytes(text):
    return int(text[:-1]) << (10 if text.endswith("G") else 0)


class Slow:
    """A process that is stopped nine tenths of the time, in turns so short that its lease does not end."""

    def __init__(self, process):
        self.process, self.over = process, threading.Event()
        self.thread = threading.Thread(target=self.run)

    def run(self):
        while not self.over.is_set():
            self.process.send_signal(signal.SIGSTOP)
            self.over.wait(0.18)
            self.process.send_signal(signal.SIGCONT)
            time.sleep(0.02)

    def __enter__(self):
        self.thread.start()

    def __exit__(self, *_):
        self.over.set()
        self.thread.join()


class SlowNode(DaemonTest):
    wait_until = local_cluster.ClusterTest.wait_until
    joined = local_cluster.ClusterTest.joined
    wait_for_members = local_cluster.ClusterTest.wait_for_members
    status = local_cluster.ClusterTest.status
    result = local_cluster.ClusterTest.result

    def setUp(self):
        super().setUp()
        (self.folder / "inputs").mkdir()
        self.tessera("certs", "init", "certs")
        self.tessera("certs", "node", "certs", *"abcd")
        self.tessera("generate", "uniform", "-n", POINTS, "-o", "inputs/cloud.npy", "--quiet")
        self.port, self.http = free_port(), free_port()
        self.coordinator = self.start("--cluster", f"127.0.0.1:{self.port}", "--certs", self.folder / "certs", "--node-name",
                                      "a", "--memory", MEMORY, listen=f"127.0.0.1:{self.http}", inputs=self.folder / "inputs")
        self.nodes = {name: local_cluster.Node(self, name, self.port, "certs", "--memory", MEMORY, "--threads", "2")
                      for name in "bcd"}
        self.wait_for_members(4)

    def job(self, name):
        status, _, job = self.coordinator.request(
            "POST", "/v1/processes/triangulate/execution",
            {"inputs": {"inputs": [str(self.folder / "inputs/cloud.npy")], "output": name, "tiles": TILES}})
        self.assertEqual(status, 201, job)
        began = time.monotonic()
        digest = self.result(job["jobID"])
        return digest, time.monotonic() - began, self.status(job["jobID"])

    def peaks(self):
        """The most resident memory of each process so far, in MiB."""
        processes = {"a": self.coordinator.process} | {name: node.process for name, node in self.nodes.items()}
        return {name: int(re.search(r"VmHWM:\s+(\d+)", pathlib.Path(f"/proc/{process.pid}/status").read_text())[1]) >> 10
                for name, process in processes.items()}

    def test_everybody_stays_within_the_memory_given(self):
        with Slow(self.nodes["d"].process):
            digest, slow_s, status = self.job("slow")
        slow = self.peaks()
        self.assertEqual(status.get("nodesLost", 0), 0, "the slow node was given up: nothing was shown")
        equal, even_s, _ = self.job("even")
        self.assertEqual(equal, digest)
        if os.environ.get("SLOW_FIGURES"):
            print(f"\n{POINTS} points, {TILES} tiles, {MEMORY} each: {slow_s:.1f} s beside a node at a tenth, {even_s:.1f} s "
                  f"without; MiB at most {slow}, then {self.peaks()}")
        for name, most in self.peaks().items():
            self.assertLessEqual(most, WITHIN * mebibytes(MEMORY), name)


if __name__ == "__main__":
    import unittest
    unittest.main()
