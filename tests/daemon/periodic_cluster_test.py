"""Periodic jobs on clusters: the digest is that of one process, also when a node is lost while the job runs."""
import json
import os
import pathlib
import re
import shutil
import subprocess
import tempfile
import time
import unittest

TESSERAD, TESSERA = os.environ["TESSERAD"], os.environ["TESSERA"]


class PeriodicCluster(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="tessera-periodic-"))
        self.addCleanup(shutil.rmtree, self.folder, True)
        self.dir = self.folder / "cluster"
        self.addCleanup(lambda: self.run_tessera("cluster", "down", self.dir))
        self.environment = {k: v for k, v in os.environ.items() if not k.startswith("TESSERA")}
        self.environment["PATH"] = f"{pathlib.Path(TESSERAD).parent}:{self.environment['PATH']}"
        self.inputs = self.folder / "inputs"
        self.inputs.mkdir()

    def run_tessera(self, *args):
        return subprocess.run([TESSERA, *map(str, args)], env=self.environment, cwd=self.folder, text=True, stdout=subprocess.PIPE,
                              stderr=subprocess.PIPE, timeout=300)

    def ok(self, *args):
        done = self.run_tessera(*args)
        self.assertEqual(done.returncode, 0, f"{args}\n{done.stdout}\n{done.stderr}")
        return done.stdout

    def digest(self, name):
        found = [json.loads(line) for line in self.ok("results", "--json").splitlines()]
        return next(result["digest"] for result in found if result["name"] == name)

    def test_nodes_share_a_periodic_job_and_may_be_lost(self):
        self.ok("generate", "uniform", "-n", "200k", "-o", self.inputs / "cloud.npy", "--seed", 3)
        told = json.loads(self.ok("triangulate", self.inputs / "cloud.npy", "-o", "here", "--periodic", "100", "--tiles", "9", "--json").splitlines()[-1])
        up = self.ok("cluster", "up", "-n", 3, self.dir, "--memory", "300M", "--threads", 1, "--inputs", self.inputs)
        server, token_file = re.search(r"export TESSERA_SERVER=(\S+) TESSERA_TOKEN_FILE='(\S+)'", up).groups()
        self.environment |= {"TESSERA_SERVER": server, "TESSERA_TOKEN_FILE": token_file}
        options = ["--periodic", "100", "--tiles", "30", "--quiet"]
        began = time.monotonic()
        self.ok("triangulate", "cloud.npy", "-o", "first", *options)
        seconds = time.monotonic() - began
        self.assertEqual(self.digest("first"), told["digest"])
        self.ok("verify", "first", "--quiet")
        job = subprocess.Popen([TESSERA, "triangulate", "cloud.npy", "-o", "second", *options], env=self.environment, cwd=self.folder,
                               text=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        time.sleep(0.5 * seconds)  # somewhere in the job: the digest is the same wherever
        self.ok("cluster", "kill", self.dir, 2)
        _, errors = job.communicate(timeout=300)
        self.assertEqual(job.returncode, 0, errors)
        self.assertEqual(self.digest("second"), told["digest"])
        refused = self.run_tessera("triangulate", "cloud.npy", "-o", "third", "--periodic", "0.1", "--periodic-snap", "no")
        self.assertNotEqual(refused.returncode, 0)
        self.assertIn("more than 51 binary digits", refused.stderr)


if __name__ == "__main__":
    unittest.main()
