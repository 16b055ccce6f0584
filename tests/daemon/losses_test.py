"""Daemons as one cluster, over TLS on 127.0.0.1: nodes and the coordinator are stopped, killed and cut off while a job
runs, and its result is the one of the command; kills at any moment are in kills_test."""
import contextlib
import json
import os
import pathlib
import re
import signal
import socket
import ssl
import subprocess
import tempfile
import time
import unittest

from daemon import TESSERA, TESSERAD, DaemonTest

POINTS = os.environ.get("POINTS", "150k")
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


class Node:
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

    def said(self):
        self.log.seek(0)
        return self.log.read().decode()

    def end(self, how=signal.SIGKILL):
        if self.process.poll() is None:
            self.process.send_signal(how)
        return self.process.wait(timeout=60)


class Cluster(DaemonTest):
    def setUp(self):
        super().setUp()
        (self.folder / "inputs").mkdir()
        self.tessera("certs", "init", "certs")
        self.tessera("certs", "node", "certs", "a", "b", "c", "d", "e")
        self.port, self.http = free_port(), free_port()
        self.tessera("generate", "uniform", "-n", POINTS, "-o", "inputs/cloud.npy", "--quiet")
        self.coordinator = self.start_coordinator()
        self.nodes = {name: self.join(name) for name in "bcd"}
        self.wait_for_members(4)
        self.digest = self.result(self.run_job("whole"))

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

    def test_the_result_is_the_one_of_the_command(self):
        alone = self.tessera("triangulate", "inputs/cloud.npy", "-o", "alone", "--tiles", "16", "--json")
        self.assertEqual(json.loads(alone.splitlines()[-1])["digest"], self.digest)

    def test_a_node_that_was_stopped_for_longer_than_its_lease_begins_anew(self):
        job = self.submit("stopped")
        self.wait_for_phase(job, "triangulating", "splaying", "collecting")
        self.wait_until(lambda: "c" in self.nodes_of(job) or self.status(job)["status"] == "successful", lambda: "no c")
        node = self.nodes["c"]
        node.process.send_signal(signal.SIGSTOP)
        needed = self.status(job).get("phase") == "triangulating"
        self.wait_until(lambda: "node c (" in self.coordinator.messages() and "c" not in self.joined(), lambda: "not lost")
        node.process.send_signal(signal.SIGCONT)
        self.assertEqual(self.result(job), self.digest)
        if needed:  # what it had done was done again
            self.assertEqual(self.status(job)["nodesLost"], 1)
        self.wait_for_members(4)
        self.assertIn("no member of the cluster any more", node.said())

    def test_strangers_are_refused_and_harm_nobody(self):
        self.tessera("certs", "init", "others")
        self.tessera("certs", "node", "others", "e")
        spy = self.join("e", "others")
        self.wait_until(lambda: "nobody of the cluster is reached" in spy.said(), spy.said)
        for sent in (b"GET / HTTP/1.1\r\n\r\n", b"\x16\x03\x01\xff\xff" + b"\xff" * 70000, os.urandom(4096)):
            with socket.create_connection(("127.0.0.1", self.port)) as stranger:
                stranger.settimeout(20)
                try:
                    stranger.sendall(sent)
                    while stranger.recv(4096):
                        pass
                except ConnectionError:
                    pass
        self.assertEqual(self.result(self.run_job("undisturbed")), self.digest)

    def peak_memory(self):
        status = pathlib.Path(f"/proc/{self.coordinator.process.pid}/status").read_text()
        return int(re.search(r"VmHWM:\s+(\d+) kB", status)[1]) << 10

    def test_who_sends_without_end_is_cut_off_and_takes_no_memory(self):
        before, piece = self.peak_memory(), bytes(1 << 20)
        self.tessera("certs", "init", "others")
        self.tessera("certs", "node", "others", "e")
        for header, certs in ((b"", None), (b"\x16\x03\x01\xff\xff", None), (b"GET / HTTP/1.1\r\nX: ", None),
                              (b"", "others/e"), (b"", "certs/e")):
            sent = 0
            with contextlib.ExitStack() as open_ones, self.assertRaises(OSError):
                stranger = open_ones.enter_context(socket.create_connection(("127.0.0.1", self.port)))
                if certs:
                    context = ssl.create_default_context()
                    context.check_hostname, context.verify_mode = False, ssl.CERT_NONE
                    context.load_cert_chain(self.folder / f"{certs}.pem", self.folder / f"{certs}.key")
                    stranger = open_ones.enter_context(context.wrap_socket(stranger))
                stranger.sendall(header)
                while sent < 1 << 30:
                    stranger.sendall(piece)
                    sent += len(piece)
            self.assertLess(sent, 64 << 20, header)  # what the sockets hold
        self.assertLess(self.peak_memory() - before, 16 << 20)
        self.assertEqual(self.result(self.run_job("undisturbed")), self.digest)
        self.assertEqual(self.joined(), set("abcd"))

    def test_who_says_nothing_is_cut_off(self):
        context = ssl.create_default_context()
        context.check_hostname, context.verify_mode = False, ssl.CERT_NONE
        context.load_cert_chain(self.folder / "certs/e.pem", self.folder / "certs/e.key")
        ports = (self.port, self.nodes["b"].port)

        def left(strangers):
            """Those whose end has not come."""
            still = []
            for stranger in strangers:
                stranger.settimeout(0)
                try:
                    while stranger.recv(1 << 16):
                        pass
                except (BlockingIOError, ssl.SSLWantReadError):
                    still.append(stranger)
                except OSError:
                    pass
            return still

        with contextlib.ExitStack() as opened:
            dumb = [opened.enter_context(socket.create_connection(("127.0.0.1", port))) for port in ports]
            # A handshake with a certificate of the cluster, and no word after it.
            dumb += [opened.enter_context(context.wrap_socket(opened.enter_context(
                socket.create_connection(("127.0.0.1", port))))) for port in ports]
            self.assertEqual(len(left(dumb)), 4)
            self.wait_until(lambda: not left(dumb), lambda: "they stay open")
            for log in (self.coordinator.messages(), self.nodes["b"].said()):
                self.assertRegex(log, r"[12] connections were closed, over which nothing was said")
        with contextlib.ExitStack() as opened:  # many at once: the oldest go before their time
            many = [opened.enter_context(socket.create_connection(("127.0.0.1", self.port))) for _ in range(300)]
            self.wait_until(lambda: len(left(many)) <= 128, lambda: str(len(left(many))))
            self.assertEqual(self.result(self.run_job("undisturbed")), self.digest)
        self.assertEqual(self.joined(), set("abcd"))

    def test_a_node_that_ends_in_order_is_done_without(self):
        job = self.submit("fewer")
        self.wait_for_phase(job, "triangulating", "splaying", "collecting")
        self.assertEqual(self.nodes["d"].end(signal.SIGTERM), 0, self.nodes["d"].said())
        self.assertEqual(self.result(job), self.digest)

    def test_all_are_killed_and_come_back(self):
        job = self.submit("all")
        self.wait_for_phase(job, "splaying", "collecting")
        self.coordinator.end(signal.SIGKILL)
        for node in self.nodes.values():
            node.end()
        self.coordinator = self.start_coordinator()
        for name in "bcd":
            self.nodes[name] = self.join(name)
        self.assertEqual(self.result(job), self.digest)


class Options(unittest.TestCase):
    def test_wrong_ones_get_a_sentence(self):
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder)
            subprocess.run([TESSERA, "certs", "init", str(path / "certs"), "--quiet"], check=True)
            subprocess.run([TESSERA, "certs", "node", str(path / "certs"), "x", "--quiet"], check=True)
            certs = str(path / "certs")
            for options, sentence in (
                    (["--join", "127.0.0.1:1"], "--cluster HOST:PORT is needed"),
                    (["--cluster", "127.0.0.1:1"], "--certs DIR is needed"),
                    (["--cluster", "7070", "--certs", certs], "'7070' is not HOST:PORT"),
                    (["--cluster", "127.0.0.1:1", "--certs", certs, "--roles", "boss"], "neither coordinator nor node"),
                    (["--cluster", "127.0.0.1:1", "--certs", certs, "--roles", "node"], "--join HOST:PORT is needed"),
                    (["--cluster", "127.0.0.1:1", "--certs", certs, "--node-name", "nobody"], "nobody")):
                done = subprocess.run([TESSERAD, "--data", str(path / "data"), *options], text=True,
                                      stdout=subprocess.PIPE, stderr=subprocess.PIPE, timeout=60)
                self.assertEqual(done.returncode, 2, done.stderr)
                self.assertIn(sentence, done.stderr)


if __name__ == "__main__":
    unittest.main()
