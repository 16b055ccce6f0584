"""A cluster of daemons in network namespaces of their own, joined by a bridge: links that go down and come back, lost packets, a long
way between them, two clusters on one network, full disks, and what is open to the network. Needs root. POINTS, SEED as in losses_test."""
import json
import os
import pathlib
import random
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import unittest

TESSERAD, TESSERA = os.environ["TESSERAD"], os.environ["TESSERA"]
POINTS = os.environ.get("POINTS", "300k")
SEED = int(os.environ.get("SEED", "1"))
LEASE_S, CLUSTER_PORT, HTTP_PORT = 6, 7601, 7070
ENVIRONMENT = {k: v for k, v in os.environ.items() if not k.startswith("TESSERA")}


def run(*command, check=True, **more):
    done = subprocess.run(list(map(str, command)), text=True, capture_output=True, env=ENVIRONMENT, **more)
    if check and done.returncode != 0:
        raise AssertionError(f"{' '.join(map(str, command))}: {done.returncode}\n{done.stdout}{done.stderr}")
    return done


class Network:
    """Namespaces on one bridge, which is in one of its own: nothing of the machine's network is touched."""

    def __init__(self, test):
        self.prefix = f"tessera-{os.getpid()}-{id(self) % 9973}"
        self.hub = f"{self.prefix}-hub"
        self.names = []
        run("ip", "netns", "add", self.hub)
        test.addCleanup(self.remove)
        self.at_hub("ip", "link", "add", "bridge", "type", "bridge")
        self.at_hub("ip", "link", "set", "bridge", "up")

    def remove(self):
        for name in [*self.names, self.hub]:
            run("ip", "netns", "del", name if name == self.hub else self.space(name))

    def space(self, name):
        return f"{self.prefix}-{name}"

    def at_hub(self, *command):
        return run("ip", "netns", "exec", self.hub, *command)

    def at(self, name, *command, **more):
        return run("ip", "netns", "exec", self.space(name), *command, **more)

    def add(self, name):
        """A namespace with an address on the bridge, which it returns."""
        self.names.append(name)
        address = f"10.77.0.{len(self.names)}"
        run("ip", "netns", "add", self.space(name))
        self.connect(name)
        self.at(name, "ip", "link", "set", "lo", "up")
        self.at(name, "ip", "address", "add", f"{address}/24", "dev", "eth0")
        self.at(name, "ip", "link", "set", "eth0", "up")
        return address

    def connect(self, name):
        self.at_hub("ip", "link", "add", f"to-{name}", "type", "veth", "peer", "name", "eth0", "netns", self.space(name))
        self.at_hub("ip", "link", "set", f"to-{name}", "master", "bridge", "up")

    def link(self, name, state):
        self.at_hub("ip", "link", "set", f"to-{name}", state)

    def lose(self, name, share):
        """That share of all packets that come in there."""
        self.at(name, "iptables", "-A", "INPUT", "-i", "eth0", "-m", "statistic", "--mode", "random", "--probability",
                share, "-j", "DROP")


class SlowNetwork(Network):
    """Every frame takes its time, and some are lost."""
    delay_ms, lost = 50, 0.05

    def __init__(self, test):
        super().__init__(test)
        switch = pathlib.Path(__file__).with_name("slow_switch.py")
        self.switch = subprocess.Popen([sys.executable, switch, str(self.delay_ms), str(self.lost)], text=True,
                                       stdin=subprocess.PIPE, stdout=subprocess.PIPE)
        test.addCleanup(self.switch.communicate)  # its input ends, and so does it

    def connect(self, name):
        self.switch.stdin.write(self.space(name) + "\n")
        self.switch.stdin.flush()
        if self.switch.stdout.readline().strip() != self.space(name):
            raise AssertionError("the switch has ended")


class Process:
    def __init__(self, test, network, name, folder, certs, *options, wrap=()):
        self.network, self.name = network, name
        self.log = tempfile.TemporaryFile()
        test.addCleanup(self.log.close)
        self.process = subprocess.Popen(
            ["ip", "netns", "exec", network.space(name), *wrap, TESSERAD, "--data", str(folder), "--certs", str(certs),
             "--node-name", name, "--lease", f"{LEASE_S}s", "--threads", "1",
             *(() if "--memory" in options else ("--memory", "512M")), *map(str, options)], env=ENVIRONMENT, stdout=subprocess.DEVNULL, stderr=self.log)
        test.addCleanup(self.end)

    def said(self):
        self.log.seek(0)
        return self.log.read().decode()

    def end(self, how=signal.SIGKILL):
        if self.process.poll() is None:
            self.process.send_signal(how)
        return self.process.wait()


class ClusterTest(unittest.TestCase):
    points = POINTS
    network_of = Network

    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="tessera-network-"))
        self.addCleanup(shutil.rmtree, self.folder, True)
        self.network = self.network_of(self)
        self.certs = self.folder / "certs"
        run(TESSERA, "certs", "init", self.certs)
        run(TESSERA, "certs", "node", self.certs, "a", "b", "c", "d", "e")
        self.cloud = self.folder / "cloud.npy"
        run(TESSERA, "generate", "uniform", "-n", self.points, "-o", self.cloud, "--quiet")
        alone = run(TESSERA, "triangulate", self.cloud, "-o", self.folder / "alone", "--json", "--tiles", "16")
        self.digest = json.loads(alone.stdout.splitlines()[-1])["digest"]
        self.data = self.folder / "data"
        self.addresses = {}

    def coordinator(self, name="a", *options, data=None, certs=None):
        self.addresses[name] = self.network.add(name)
        return Process(self, self.network, name, data or self.data, certs or self.certs, "--cluster",
                       f"{self.addresses[name]}:{CLUSTER_PORT}", "--listen", f"127.0.0.1:{HTTP_PORT}", "--inputs",
                       self.folder, *options)

    def node(self, name, *options, join="a", data=None, certs=None, wrap=()):
        if name not in self.addresses:
            self.addresses[name] = self.network.add(name)
        return Process(self, self.network, name, data or self.data, certs or self.certs, "--cluster",
                       f"{self.addresses[name]}:{CLUSTER_PORT}", "--join", f"{self.addresses[join]}:{CLUSTER_PORT}",
                       *options, wrap=wrap)

    def tessera(self, *args, at="a", data=None, check=True):
        """The command beside the coordinator."""
        tokens = (data or self.data) / "tokens"
        self.wait_until(lambda: tokens.exists() and tokens.read_text().endswith("\n"), "no tokens")
        token = next(line.split()[2] for line in tokens.read_text().splitlines() if line.split()[1] == "admin")
        return self.network.at(at, "env", f"TESSERA_TOKEN={token}", TESSERA, *args, "--server",
                               f"http://127.0.0.1:{HTTP_PORT}", check=check)

    def json(self, *args, **more):
        return [json.loads(line) for line in self.tessera(*args, "--json", **more).stdout.splitlines()]

    def wait_until(self, holds, what):
        end = time.monotonic() + 300  # for what never will
        while not (found := holds()):
            self.assertLess(time.monotonic(), end, what() if callable(what) else what)
            time.sleep(0.1)
        return found

    def wait_for_members(self, count, **more):
        def members():
            told = self.tessera("nodes", "--json", check=False, **more)
            nodes = [json.loads(line) for line in told.stdout.splitlines()]
            return told.returncode == 0 and sum(node["state"] == "free" for node in nodes) == count
        self.wait_until(members, lambda: f"not {count} members\n{self.first.said()}")

    def submit(self, name, *options, **more):
        told = self.json("triangulate", self.cloud, "-o", name, "--tiles", "16", "--detach", *options, **more)
        return next(line["id"] for line in told if "id" in line)

    def job(self, job, **more):
        return self.json("job", job, **more)[-1]

    def running(self, name, *phases, **more):
        """A job of which node c has tiles, in one of these phases."""
        job = self.submit(name, **more)
        self.wait_until(lambda: self.job(job, **more).get("phase") in phases or self.job(job, **more)["status"] not in
                        ("accepted", "running"), lambda: self.job(job, **more))
        return job

    def ended(self, job, **more):
        self.wait_until(lambda: self.job(job, **more)["status"] not in ("accepted", "running"),
                        lambda: self.job(job, **more))
        return self.job(job, **more)

    def assert_right(self, job, **more):
        end = self.ended(job, **more)
        self.assertEqual(end["status"], "successful", end)
        digests = {result["name"]: result["digest"] for result in self.json("results", **more)}
        self.assertEqual(digests[end["result"]], self.digest)


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
        self.assertIn("no member of the cluster any more", self.others["c"].said())
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


@unittest.skipUnless(pathlib.Path("/dev/net/tun").exists(), "no network can be made in user space: no /dev/net/tun")
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
        self.wait_until(lambda: "nobody of the cluster is reached" in stranger.said(), stranger.said)
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
        run("mount", "-t", "tmpfs", "-o", f"size={size}", "tessera-test", folder)
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
        job = self.running("full", "triangulating", "splaying")
        pids = self.first.process.pid, second.process.pid
        run("kill", "-STOP", *pids)  # or the job may be over before the disk is full
        filler = self.fill(self.folder / "shared")
        run("kill", "-CONT", *pids)
        end = self.ended(job)
        self.assertEqual(end["status"], "failed", end)
        self.assertIn("No space left on device", json.dumps(end))
        filler.unlink()
        self.tessera("resume", job, "--detach")
        self.assert_right(job)

    def test_the_scratch_of_one_node(self):
        self.mount(self.folder / "scratch", "1m")
        self.first = self.coordinator("a", "--memory", "96M")
        self.node("b", "--memory", "96M", "--scratch", self.folder / "scratch" / "b")
        self.wait_for_members(2)
        filler = self.fill(self.folder / "scratch")
        job = self.submit("no-scratch", "--memory", "96M")
        end = self.ended(job)
        if end["status"] == "failed":
            self.assertIn("No space left on device", json.dumps(end))
            filler.unlink()
            run("mount", "-o", "remount,size=1g", self.folder / "scratch")
            self.tessera("resume", job, "--detach")
        self.assert_right(job)


if __name__ == "__main__":
    unittest.main()
