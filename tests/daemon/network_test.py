"""A cluster of daemons in network namespaces: links that go down and come back, lost packets, a long way between them, two clusters on
one network, full disks, and what is open to the network."""
import json
import os
import random
import re
import signal
import time
import unittest

from namespaces import CLUSTER_PORT, LEASE_S, SEED, TESSERA, ClusterTest, SlowNetwork, run


class Links(ClusterTest):
    def setUp(self):
        super().setUp()
        self.first = self.coordinator()
        self.others = {name: self.node(name) for name in "bcd"}
        self.wait_for_members(4)

    def joined(self, name):
        return len(re.findall(rf"node {name} \(\S+\) has joined", self.first.said()))

    def test_one_that_goes_down_loses_its_node_which_comes_back_as_another(self):
        job = self.running("cut", "triangulating", "splaying")
        self.network.link("c", "down")
        self.wait_until(lambda: re.search(r"node c \(\S+\) is lost", self.first.said()), self.first.said)
        self.assert_right(job)
        self.network.link("c", "up")
        self.wait_until(lambda: self.joined("c") == 2, self.first.said)
        self.assertIn("is not a member of the cluster any more", self.others["c"].said())
        self.wait_for_members(4)
        self.assert_right(self.submit("whole-again"))

    def test_that_of_the_coordinator_leaves_it_alone_with_its_own_node(self):
        job = self.running("alone-here", "triangulating", "splaying")
        self.network.link("a", "down")
        self.wait_until(lambda: all(re.search(rf"node {name} \(\S+\) is lost", self.first.said()) for name in "bcd"),
                        self.first.said)
        self.assert_right(job)
        self.network.link("a", "up")
        self.wait_for_members(4)
        self.assert_right(self.submit("whole-again"))

    def test_of_two_who_do_not_hear_each_other_one_begins_anew(self):
        job = self.running("deaf", "triangulating", "splaying")
        for name, other in ("bc", "cb"):
            self.network.drop(name, "-s", self.addresses[other])
        # The one who came later: it is lost as often as it comes, for the other cannot be reached.
        self.wait_until(lambda: re.search(r"node [bc] \(\S+\) is lost: it cannot be reached by other nodes", self.first.said()),
                        self.first.said)
        self.assert_right(job)
        for name in "bc":
            self.network.at(name, "iptables", "-F", "INPUT")
        self.wait_for_members(4)
        self.assert_right(self.submit("whole-again"))

    def test_one_that_is_down_for_less_than_a_lease_costs_time_at_most(self):
        chance = random.Random(SEED)
        job = self.running("flapping", "routing", "triangulating", "splaying")
        for _ in range(3):
            name = chance.choice("abcd")
            self.network.link(name, "down")
            time.sleep(LEASE_S / 6)
            self.network.link(name, "up")
            time.sleep(chance.random())
        self.assert_right(job)

    def test_packets_may_be_lost(self):
        for name in "abcd":
            self.network.lose(name, 0.05)
        self.assert_right(self.submit("lossy"))

    def test_only_the_cluster_is_open_to_the_network(self):
        for name in "abcd":
            listening = [line.split()[3] for line in self.network.at(name, "ss", "-Hltn").stdout.splitlines()]
            beyond = [at for at in listening if not at.startswith(("127.", "[::1]"))]
            self.assertEqual(beyond, [f"{self.addresses[name]}:{CLUSTER_PORT}"], listening)
            self.assertEqual(self.network.at(name, "ss", "-Hlun").stdout, "")


@unittest.skipUnless(os.access("/dev/net/tun", os.R_OK | os.W_OK), "no network can be made in user space: /dev/net/tun cannot be opened")
class LongLinks(ClusterTest):
    points = "100k"
    network_of = SlowNetwork

    def test_frames_may_be_late_and_lost(self):
        self.first = self.coordinator()
        for name in "bcd":
            self.node(name)
        self.wait_for_members(4)
        self.assert_right(self.submit("far"))
        told = self.network.at("b", "ss", "-Htin", "dport", f":{CLUSTER_PORT}", "or", "sport", f":{CLUSTER_PORT}").stdout
        there_and_back = [float(ms) for ms in re.findall(r"minrtt:([0-9.]+)", told)]
        self.assertGreaterEqual(len(there_and_back), 3, told)
        self.assertGreaterEqual(min(there_and_back), 2 * SlowNetwork.delay_ms)


class TwoClusters(ClusterTest):
    def test_share_a_network_and_know_nothing_of_each_other(self):
        theirs, data = self.folder / "their-certs", self.folder / "their-data"
        run(TESSERA, "certs", "init", theirs)
        run(TESSERA, "certs", "node", theirs, "e", "f", "g")
        self.first = self.coordinator()
        self.node("b")
        self.wait_for_members(2)
        second = self.coordinator("e", data=data, certs=theirs)
        self.node("f", join="e", data=data, certs=theirs)
        self.wait_for_members(2, at="e", data=data)
        # Another authority's certificate; and ours, of another cluster.
        stranger = self.node("g", join="a", data=data, certs=theirs)
        other = self.node("c", "--cluster-name", "another")
        self.wait_until(lambda: "no node of the cluster can be reached" in stranger.said(), stranger.said)
        self.wait_until(lambda: "it belongs to the cluster 'another'" in other.said(), other.said)
        ours, their = self.submit("both"), self.submit("both", at="e", data=data)
        self.assert_right(ours)
        self.assert_right(their, at="e", data=data)
        self.assertEqual(len(self.json("nodes")), 2)
        self.assertNotIn("node f", self.first.said())
        self.assertNotIn("node b", second.said())


class FullDisks(ClusterTest):
    points = "1M"  # so that a job takes a while

    def mount(self, folder, size):
        folder.mkdir()
        mounted = run("mount", "-t", "tmpfs", "-o", f"size={size}", "tessera-test", folder, check=False)
        if mounted.returncode != 0:
            self.skipTest(f"no tmpfs can be mounted here: {mounted.stderr.strip()}")
        self.addCleanup(run, "umount", "-l", folder)

    def fill(self, folder):
        """Until nothing more can be written there. The file that takes the room."""
        filler = folder / "filler"
        with filler.open("wb", buffering=0) as out:
            while (free := os.statvfs(folder)).f_bavail > 0:
                try:
                    os.posix_fallocate(out.fileno(), out.tell(), free.f_bavail * free.f_frsize)
                except OSError:  # somebody else has taken some of it meanwhile
                    continue
                out.seek(0, os.SEEK_END)
        return filler

    def test_the_shared_folder(self):
        self.mount(self.folder / "shared", "1g")
        self.data = self.folder / "shared" / "data"
        self.first, second = self.coordinator(), self.node("b")
        self.wait_for_members(2)
        for turn in range(20):  # until a job is stopped before it is over: it takes a second on a fast machine
            job = self.running(f"full-{turn}", "triangulating", "splaying")
            for process in (self.first.process, second.process):
                process.send_signal(signal.SIGSTOP)
            filler = self.fill(self.folder / "shared")
            for process in (self.first.process, second.process):
                process.send_signal(signal.SIGCONT)
            end = self.ended(job)
            filler.unlink()
            if end["status"] == "failed":
                break
            self.remove(f"full-{turn}")
        self.assertEqual(end["status"], "failed", end)
        self.assertIn("No space left on device", json.dumps(end))
        self.tessera("resume", job, "--detach")
        self.assert_right(job)

    def test_the_scratch_of_one_node(self):
        """It is named, and the others do without it; what is full from the start gets no tile."""
        self.mount(self.folder / "scratch", "6m")
        self.first = self.coordinator("a", "--memory", "96M")
        self.node("b", "--memory", "96M", "--scratch", self.folder / "scratch" / "b")
        self.node("c", "--memory", "96M")
        self.wait_for_members(3)
        job = self.submit("little-scratch", "--memory", "96M")
        self.assert_right(job)
        log = (self.data / "jobs" / job / "log.txt").read_text()
        self.assertRegex(log, r"node b is lost: it cannot use its scratch folder \(node b: .*/scratch/b/.*No space left on device\)")
        self.assertEqual(self.job(job)["nodes_lost"], 1)
        self.fill(self.folder / "scratch")
        job = self.submit("no-scratch", "--memory", "96M")
        self.assert_right(job)
        log = (self.data / "jobs" / job / "log.txt").read_text()
        self.assertRegex(log, r"node b cannot work on the job: .*/scratch/b: only \d+ KiB are free for tiles that are not in memory")
        self.assertEqual({node["name"]: node["scratch_free_bytes"] for node in self.json("nodes")}["b"], 0)


if __name__ == "__main__":
    unittest.main()
