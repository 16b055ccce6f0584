"""A cluster of daemons in network namespaces of their own, joined by a bridge, for root or in a user namespace. POINTS, SEED as in kills_test."""
import json
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import time
import unittest

import local_cluster

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


NEW = ["unshare", "--net", "--propagation", "unchanged"]  # where / is no mount, its propagation cannot be changed


def become_able():
    """Why no networks can be made here, or nothing. Who may not is root of a user namespace of its own, in which the program begins again."""
    if (refused := run(*NEW, "true", check=False)).returncode == 0:
        return None
    as_root = ["unshare", "--map-root-user", "--mount", "--propagation", "unchanged"]
    if "IN_USER_NAMESPACE" in os.environ or run(*as_root, *NEW, "true", check=False).returncode != 0:
        return f"no network namespaces can be made here: {refused.stderr.strip()}"
    os.environ["IN_USER_NAMESPACE"] = "1"
    os.execvp("unshare", [*as_root, *sys.orig_argv])


REFUSED = become_able()


class Namespace:
    """A network that lasts as long as its process. It has a number instead of a name, which would be a mount."""

    def __init__(self):
        self.process = subprocess.Popen([*NEW, "sh", "-c", "echo; exec cat"], text=True, stdin=subprocess.PIPE, stdout=subprocess.PIPE)
        self.process.stdout.readline()
        self.number = self.process.pid
        self.entered = ["nsenter", f"--net=/proc/{self.number}/ns/net"]

    def __call__(self, *command, **more):
        return run(*self.entered, *command, **more)

    def remove(self):
        self.process.communicate()  # its input ends, and so does it


class Network:
    """Namespaces on one bridge, which is in one of its own: nothing of the machine's network is touched."""

    def __init__(self, test):
        self.spaces = {}
        self.hub = Namespace()
        test.addCleanup(self.remove)
        done = self.hub("ip", "link", "add", "bridge", "type", "bridge", check=False)
        if done.returncode != 0:
            raise unittest.SkipTest(f"no bridge can be made here: {done.stderr.strip()}")
        self.hub("ip", "link", "set", "bridge", "up")

    def remove(self):
        for space in [*self.spaces.values(), self.hub]:
            space.remove()

    def at(self, name, *command, **more):
        return self.spaces[name](*command, **more)

    def add(self, name):
        """A namespace with an address on the bridge, which it returns."""
        self.spaces[name] = Namespace()
        address = f"10.77.0.{len(self.spaces)}"
        self.connect(name)
        self.at(name, "ip", "link", "set", "lo", "up")
        self.at(name, "ip", "address", "add", f"{address}/24", "dev", "eth0")
        self.at(name, "ip", "link", "set", "eth0", "up")
        return address

    def connect(self, name):
        self.hub("ip", "link", "add", f"to-{name}", "type", "veth", "peer", "name", "eth0", "netns", self.spaces[name].number)
        self.hub("ip", "link", "set", f"to-{name}", "master", "bridge", "up")

    def link(self, name, state):
        self.hub("ip", "link", "set", f"to-{name}", state)

    def drop(self, name, *packets):
        """All such packets that come in there."""
        done = self.at(name, "iptables", "-A", "INPUT", *packets, "-j", "DROP", check=False)
        if done.returncode != 0:
            raise unittest.SkipTest(f"no packets can be dropped here: {done.stderr.strip()}")

    def lose(self, name, share):
        """That share of all packets that come in there."""
        self.drop(name, "-i", "eth0", "-m", "statistic", "--mode", "random", "--probability", share)


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
        number = str(self.spaces[name].number)
        self.switch.stdin.write(number + "\n")
        self.switch.stdin.flush()
        if self.switch.stdout.readline().strip() != number:
            raise AssertionError("the switch has ended")


class Process(local_cluster.Logged):
    def __init__(self, test, network, name, folder, certs, *options, wrap=()):
        self.network, self.name = network, name
        self.log = tempfile.TemporaryFile()
        test.addCleanup(self.log.close)
        self.process = subprocess.Popen(
            [*network.spaces[name].entered, *wrap, TESSERAD, "--data", str(folder), "--certs", str(certs),
             "--node-name", name, "--lease", f"{LEASE_S}s", "--threads", "1",
             *(() if "--memory" in options else ("--memory", "512M")), *map(str, options)], env=ENVIRONMENT, stdout=subprocess.DEVNULL, stderr=self.log)
        test.addCleanup(self.end)


@unittest.skipIf(REFUSED, REFUSED)
class ClusterTest(unittest.TestCase):
    points, tiles = POINTS, "16"
    network_of = Network

    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="tessera-network-"))
        self.addCleanup(shutil.rmtree, self.folder, True)
        self.network = self.network_of(self)
        self.certs = self.folder / "certs"
        run(TESSERA, "certs", "init", self.certs)
        run(TESSERA, "certs", "node", self.certs, "a", "b", "c", "d", "e")
        self.cloud = self.make_cloud()
        alone = run(TESSERA, "triangulate", self.cloud, "-o", self.folder / "alone", "--json", "--tiles", self.tiles)
        self.digest = json.loads(alone.stdout.splitlines()[-1])["digest"]
        shutil.rmtree(self.folder / "alone")
        self.data = self.folder / "data"
        self.addresses = {}

    def make_cloud(self):
        cloud = self.folder / "inputs" / "cloud.npy"
        cloud.parent.mkdir(exist_ok=True)
        run(TESSERA, "generate", "uniform", "-n", self.points, "-o", cloud, "--quiet")
        return cloud

    def coordinator(self, name="a", *options, data=None, certs=None):
        if name not in self.addresses:
            self.addresses[name] = self.network.add(name)
        return Process(self, self.network, name, data or self.data, certs or self.certs, "--cluster",
                       f"{self.addresses[name]}:{CLUSTER_PORT}", "--listen", f"127.0.0.1:{HTTP_PORT}", "--inputs",
                       self.folder / "inputs", *options)

    def node(self, name, *options, join="a", data=None, certs=None, wrap=()):
        if name not in self.addresses:
            self.addresses[name] = self.network.add(name)
        return Process(self, self.network, name, data or self.data, certs or self.certs, "--cluster",
                       f"{self.addresses[name]}:{CLUSTER_PORT}", "--join", f"{self.addresses[join]}:{CLUSTER_PORT}",
                       *options, wrap=wrap)

    def token(self, data=None):
        tokens = (data or self.data) / "tokens"
        self.wait_until(lambda: tokens.exists() and tokens.read_text().endswith("\n"), "no tokens")
        return next(line.split()[2] for line in tokens.read_text().splitlines() if line.split()[1] == "admin")

    def tessera(self, *args, at="a", data=None, check=True):
        """The command beside the coordinator."""
        return self.network.at(at, "env", f"TESSERA_TOKEN={self.token(data)}", TESSERA, *args, "--server",
                               f"http://127.0.0.1:{HTTP_PORT}", check=check)

    def remove(self, result):
        self.network.at("a", "curl", "-sf", "-X", "DELETE", "-H", f"Authorization: Bearer {self.token()}",
                        f"http://127.0.0.1:{HTTP_PORT}/v1/triangulations/{result}")

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
        told = self.json("triangulate", self.cloud, "-o", name, "--tiles", self.tiles, "--detach", *options, **more)
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
