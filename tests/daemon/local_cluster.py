"""Daemons as one cluster on 127.0.0.1, over TLS, for tests."""
import json
import os
import re
import signal
import socket
import subprocess
import tempfile
import time

from daemon import TESSERAD, DaemonTest

USUAL = {"--memory": "512M", "--threads": "1", "--metrics": "none"}  # of a node
LEASE = "10s"  # a busy machine may not let a process run for seconds


given_ports = set()


def free_port():
    """One that nobody else was given here: the system may offer again what nobody listens at yet."""
    while True:
        with socket.socket() as probe:
            probe.bind(("127.0.0.1", 0))
            port = probe.getsockname()[1]
        if port not in given_ports:
            given_ports.add(port)
            return port


class Logged:
    """A process with a log."""

    def said(self):
        self.log.seek(0)
        return self.log.read().decode()

    def end(self, how=signal.SIGKILL):
        if self.process.poll() is None:
            self.process.send_signal(how)
        return self.process.wait(timeout=60)


class Node(Logged):
    """A process that only works for the cluster."""

    def __init__(self, test, name, join, certs="certs", *options, enter=None):
        self.port = free_port()
        self.log = tempfile.TemporaryFile()
        test.addCleanup(self.log.close)
        clean = {k: v for k, v in os.environ.items() if not k.startswith("TESSERA")}
        self.process = subprocess.Popen(
            [TESSERAD, "--data", str(test.folder / "data"), "--cluster", f"127.0.0.1:{self.port}", "--join",
             f"127.0.0.1:{join}", "--certs", str(test.folder / certs), "--node-name", name, "--lease", LEASE,
             *options, *(word for usual in USUAL.items() if usual[0] not in options for word in usual)],
            env=clean, preexec_fn=enter, stdout=subprocess.DEVNULL, stderr=self.log)
        test.addCleanup(self.end)

class ClusterTest(DaemonTest):
    """Four nodes, and a cloud among the inputs of the coordinator."""

    POINTS = "150k"

    def setUp(self):
        super().setUp()
        (self.folder / "inputs").mkdir()
        self.tessera("certs", "init", "certs")
        self.tessera("certs", "node", "certs", "a", "b", "c", "d", "e")
        self.port, self.http = free_port(), free_port()
        self.tessera("generate", "uniform", "-n", self.POINTS, "-o", "inputs/cloud.npy", "--quiet")
        self.coordinator = self.start_coordinator()
        self.nodes = {name: self.join(name) for name in "bcd"}
        self.wait_for_members(4)

    def start_coordinator(self):
        (self.folder / "inputs").mkdir(exist_ok=True)
        return self.start("--cluster", f"127.0.0.1:{self.port}", "--certs", str(self.folder / "certs"), "--node-name",
                          "a", "--lease", LEASE, "--memory", "512M", listen=f"127.0.0.1:{self.http}",
                          inputs=self.folder / "inputs")

    def join(self, name, *more, **options):
        return Node(self, name, self.port, *more, **options)

    def wait_until(self, holds, what):
        """Until it does. The time is for what never will."""
        end = time.monotonic() + 300
        while not holds():
            self.assertLess(time.monotonic(), end, what() + "\n" + self.coordinator.messages())
            time.sleep(0.05)

    def joined(self):
        """The names of those who are members now."""
        names = set()
        for name, what in re.findall(r"node (\w+) \(\S+\) (has joined|is lost)", self.coordinator.messages()):
            names.add(name) if what == "has joined" else names.discard(name)
        return names

    def wait_for_members(self, count):
        self.wait_until(lambda: len(self.joined()) == count, lambda: f"{self.joined()} instead of {count} members")

    def submit(self, name):
        self.submitted = getattr(self, "submitted", 0) + 1  # both kinds of tiles in turn
        status, _, job = self.coordinator.request(
            "POST", "/v1/processes/triangulate/execution",
            {"inputs": {"inputs": [str(self.folder / "inputs/cloud.npy")], "output": name, "tiles": 16,
                        "store": "points" if self.submitted % 2 == 1 else "cells"}})
        self.assertEqual(status, 201, job)
        return job["jobID"]

    def status(self, job):
        return self.coordinator.request("GET", f"/v1/jobs/{job}")[2]

    def wait_for_phase(self, job, *phases):
        self.wait_until(lambda: self.status(job).get("phase") in phases or self.status(job)["status"] != "running" and
                        self.status(job)["status"] != "accepted", lambda: json.dumps(self.status(job)))

    def nodes_of(self, job):
        return {node["name"]: node for node in self.status(job).get("figures", {}).get("nodes", [])}

    def run_job(self, name):
        job = self.submit(name)
        self.wait_until(lambda: self.status(job)["status"] not in ("accepted", "running"),
                        lambda: json.dumps(self.status(job)))
        return job

    def result(self, job):
        self.wait_until(lambda: self.status(job)["status"] not in ("accepted", "running"),
                        lambda: json.dumps(self.status(job)))
        self.assertEqual(self.status(job)["status"], "successful", self.status(job))
        name = self.status(job)["triangulation"]
        return self.coordinator.request("GET", f"/v1/triangulations/{name}")[2]["digest"]
