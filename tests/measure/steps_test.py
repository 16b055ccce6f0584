"""A change of a result that is killed before any of its steps on the disk: what is left is the old version or the new one."""
import hashlib
import json
import os
import shutil
import signal
import unittest

from cli import CliTest


class Steps(CliTest):
    store = "cells"

    def setUp(self):
        super().setUp()
        self.base = self.folder / "base"
        self.ok("triangulate", self.xyz(n=60), "-o", self.base, "--tiles", "2", "--threads", "1", "--quiet",
                "--store", self.store)

    def begin(self):
        shutil.rmtree(self.out, ignore_errors=True)
        shutil.copytree(self.base, self.out)

    def measure(self, **more):
        return self.run_tessera("measure", "out", "--volume", "--threads", "1", "--quiet", **more)

    def contents(self):
        return {str(p.relative_to(self.out)): p.is_dir() or hashlib.sha256(p.read_bytes()).hexdigest()
                for p in self.out.rglob("*") if p.name != "log.json"}  # which has the time

    def answers(self):
        """What users of either version see."""
        shutil.rmtree(self.folder / "arrays", ignore_errors=True)
        self.ok("export", self.out, "-o", self.folder / "arrays", "--format", "npy", "--quiet")
        return {p.name: hashlib.sha256(p.read_bytes()).hexdigest() for p in (self.folder / "arrays").iterdir()}

    def test_of_each_write_rename_and_sync(self):
        self.begin()
        old = self.answers()
        self.assertEqual(self.measure().returncode, 0)
        new, after_one = self.answers(), self.contents()
        self.assertEqual(self.measure().returncode, 0)
        after_two = self.contents()
        self.assertEqual({name for name in after_two if name.startswith(".versions")}, {".versions"})
        self.assertEqual(len([name for name in after_two if name.startswith("tiles/")]), 2)
        self.assertEqual({name for name in after_one if name.startswith(".versions")}, {".versions", ".versions/000001.json"})
        self.assertEqual({name: old[name] for name in old}, {name: new[name] for name in old}, "the cells are the same")
        seen, step = set(), 0
        while True:
            step += 1
            self.begin()
            done = self.measure(env={"LD_PRELOAD": os.environ["KILL_AT_CALL"], "KILL_AT": str(step), "KILL_AT_WRITES": "1"})
            if done.returncode == 0:
                break
            self.assertEqual(done.returncode, -signal.SIGKILL, done.stderr)
            with self.subTest(step=step):
                self.ok("verify", self.out)
                version = json.loads((self.out / "manifest.json").read_text()).get("version", 1)
                self.assertEqual(self.answers(), {1: old, 2: new}[version])
                seen.add(version)
                self.assertEqual(self.measure().returncode, 0)
                self.ok("verify", self.out)
                self.assertEqual(self.contents(), after_one if version == 1 else after_two)
                self.assertEqual(self.measure().returncode, 0)
                self.assertEqual(self.contents(), after_two)
        self.assertEqual(seen, {1, 2})
        self.assertGreater(step, 40)

    def test_a_replaced_result_has_no_older_versions(self):
        self.begin()
        self.assertEqual(self.measure().returncode, 0)
        self.ok("triangulate", self.xyz(n=50, seed=2), "-o", self.out, "--overwrite", "--quiet")
        self.assertFalse((self.out / ".versions").exists())
        self.assertEqual(len(list((self.out / "tiles").iterdir())), 1)


class StepsOfPoints(Steps):
    store = "points"


if __name__ == "__main__":
    unittest.main()
