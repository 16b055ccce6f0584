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
import unittest

from daemon import TESSERA, TESSERAD
from local_cluster import ClusterTest


class Cluster(ClusterTest):
    POINTS = os.environ.get("POINTS", "150k")

    def setUp(self):
        super().setUp()
        self.digest = self.result(self.run_job("whole"))

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
        self.assertIn("is not a member of the cluster any more", node.said())

    def test_strangers_are_refused_and_harm_nobody(self):
        self.tessera("certs", "init", "others")
        self.tessera("certs", "node", "others", "e")
        spy = self.join("e", "others")
        self.wait_until(lambda: "no node of the cluster can be reached" in spy.said(), spy.said)
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

    def test_nodes_speak_tls_1_3_and_nothing_older(self):
        for version, spoken in (ssl.TLSVersion.TLSv1_2, None), (ssl.TLSVersion.TLSv1_3, "TLSv1.3"):
            context = ssl.create_default_context()
            context.check_hostname, context.verify_mode = False, ssl.CERT_NONE
            context.load_cert_chain(self.folder / "certs/e.pem", self.folder / "certs/e.key")
            context.minimum_version = context.maximum_version = version
            for port in (self.port, self.nodes["b"].port):
                with socket.create_connection(("127.0.0.1", port)) as plain:
                    if spoken is None:
                        with self.assertRaises(OSError):
                            context.wrap_socket(plain)
                        continue
                    with context.wrap_socket(plain) as stranger:
                        self.assertEqual(stranger.version(), spoken)

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
                self.assertRegex(log, r"[12] connections were closed because no message came over them")
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
