"""A cluster on this machine, as a user tries one: up, a node killed, up again, down; and a node that is drained."""
import json
import os
import pathlib
import re
import shutil
import subprocess
import tempfile
import unittest

TESSERAD, TESSERA = os.environ["TESSERAD"], os.environ["TESSERA"]
IGN = os.environ["IGN"]


class Cluster(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        # One for all: most of the time goes into starting it.
        cls.folder = pathlib.Path(tempfile.mkdtemp(prefix="tessera-cluster-"))
        cls.addClassCleanup(shutil.rmtree, cls.folder, True)
        cls.dir = cls.folder / "cluster"
        cls.addClassCleanup(lambda: cls.run_tessera("cluster", "down", cls.dir))
        cls.environment = {k: v for k, v in os.environ.items() if not k.startswith("TESSERA")}
        cls.environment["PATH"] = f"{pathlib.Path(TESSERAD).parent}:{cls.environment['PATH']}"

    @classmethod
    def run_tessera(cls, *args):
        return subprocess.run([TESSERA, *map(str, args)], env=cls.environment, cwd=cls.folder, text=True, stdout=subprocess.PIPE,
                              stderr=subprocess.PIPE, timeout=120)

    def ok(self, *args):
        done = self.run_tessera(*args)
        self.assertEqual(done.returncode, 0, f"{args}\n{done.stdout}\n{done.stderr}")
        return done.stdout

    def refused(self, *args, says):
        done = self.run_tessera(*args)
        self.assertEqual(done.returncode, 2, done.stdout + done.stderr)
        self.assertIn(says, done.stderr)

    def status(self):
        return {node["name"]: node for node in map(json.loads, self.ok("cluster", "status", self.dir, "--json").splitlines())}

    def pids(self):
        return [node["pid"] for node in self.status().values()]

    def triangulated(self, name):
        self.ok("triangulate", "*.las", "-o", name, "--tiles", "12", "--quiet")
        found = [json.loads(line) for line in self.ok("results", "--json").splitlines()]
        return next(result["digest"] for result in found if result["name"] == name)

    def process_of(self, name):
        """A handle of the node's process, and its number."""
        pid = self.status()[name]["pid"]
        return os.pidfd_open(pid), pid

    def ends(self, handle):
        import select
        try:
            return bool(select.select([handle], [], [], 30)[0])
        finally:
            os.close(handle)

    def test_a_cluster_lives_as_long_as_it_should(self):
        said = self.ok("cluster", "up", "-n", 3, self.dir, "--memory", "300M", "--threads", 1, "--inputs", IGN)
        self.assertIn("3 nodes are ready", said)
        server, token_file = re.search(r"export TESSERA_SERVER=(\S+) TESSERA_TOKEN_FILE='(\S+)'", said).groups()
        self.assertEqual(os.stat(token_file).st_mode & 0o777, 0o600)
        type(self).environment |= {"TESSERA_SERVER": server, "TESSERA_TOKEN_FILE": token_file}
        self.assertEqual({name: node["state"] for name, node in self.status().items()}, {f"node-{i}": "free" for i in (1, 2, 3)})
        digest = self.triangulated("first")

        before = self.pids()
        handle, pid = self.process_of("node-2")
        self.assertIn(f"node-2, process {pid}, was killed", self.ok("cluster", "kill", self.dir, 2))
        self.assertTrue(self.ends(handle))
        self.assertEqual(self.status()["node-2"]["pid"], 0)
        self.assertIn("ended", self.ok("cluster", "status", self.dir))
        self.assertEqual(self.triangulated("second"), digest)
        self.refused("cluster", "kill", self.dir, 2, says="node-2 does not run")

        self.ok("cluster", "up", self.dir, "--quiet")
        after = self.pids()
        self.assertEqual([a == b for a, b in zip(before, after)], [True, False, True])
        self.refused("cluster", "up", self.dir, "-n", 4, says="3 nodes")

        # Drained: it ends by itself, well, and its place is taken by the one that is started for it.
        handle, _ = self.process_of("node-3")
        self.ok("drain", "node-3")
        self.assertTrue(self.ends(handle))
        log = (self.dir / "logs" / "node-3.log").read_text()
        self.assertRegex(log, r"it is drained\n(.*\n)*.*ended\n$")
        self.assertEqual([node["name"] for node in map(json.loads, self.ok("nodes", "--json").splitlines())], ["node-1", "node-2"])
        # The coordinator's own: its process goes on, and then the other is the only node.
        self.assertIn("goes on as the coordinator", self.ok("drain", "node-1"))
        self.assertNotEqual(self.status()["node-1"]["pid"], 0)
        self.refused("drain", "node-2", says="it is the only node")
        self.refused("drain", "node-9", says="there is no node 'node-9'")
        self.assertEqual(self.triangulated("third"), digest)

        pids = [pid for pid in self.pids() if pid]
        handles = [os.pidfd_open(pid) for pid in pids]
        self.assertEqual(len(pids), 2)
        self.assertIn("2 processes have ended", self.ok("cluster", "down", self.dir))
        self.assertEqual([self.ends(handle) for handle in handles], [True, True])
        self.assertEqual(self.pids(), [0, 0, 0])
        self.assertIn("0 processes have ended", self.ok("cluster", "down", self.dir))
        self.ok("cluster", "up", self.dir, "--quiet")
        self.assertEqual([node["state"] for node in self.status().values()], ["free"] * 3)
        self.assertIn("third", self.ok("results"))

    def test_what_is_no_cluster_is_said(self):
        for args, says in [((), "--help"), (("fly", "x"), "'fly'"), (("up",), "no folder"), (("status", "x"), "there is no cluster in this folder"),
                           (("kill", "x"), "no node is given; add its number"), (("up", "x", "2"), "only kill takes the number"), (("down", "x", "-n", "2"), "--nodes"),
                           (("up", "x", "-n", "0"), "--nodes"), (("up", "x", "--memory", "1M"), "64M")]:
            with self.subTest(args=args):
                self.refused("cluster", *args, says=says)

    def test_a_daemon_that_cannot_begin_is_told_of(self):
        folder = self.folder / "wrong"
        done = self.run_tessera("cluster", "up", folder, "-n", "1", "--inputs", "nowhere")
        self.addCleanup(self.run_tessera, "cluster", "down", folder)
        self.assertEqual(done.returncode, 4, done.stderr)
        self.assertIn("node-1 has ended: tesserad: ", done.stderr)
        self.assertIn("nowhere", done.stderr)


if __name__ == "__main__":
    unittest.main()
