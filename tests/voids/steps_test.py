"""A search that is killed before any of its steps on the disk: what is left is a whole version, and whole files."""
import hashlib
import json
import os
import shutil
import signal
import unittest

from cli import CliTest

FILES = "voids.zone", "voids.void", "voids.txt"


class Steps(CliTest):
    def setUp(self):
        super().setUp()
        self.base = self.folder / "base"
        self.ok("triangulate", self.xyz(n=60), "-o", self.base, "--tiles", "2", "--threads", "1", "--quiet")
        self.ok("measure", self.base, "--voronoi", "--quiet")

    def begin(self):
        shutil.rmtree(self.out, ignore_errors=True)
        shutil.copytree(self.base, self.out)
        for name in FILES:
            (self.folder / name).unlink(missing_ok=True)

    def search(self, **more):
        return self.run_tessera("voids", "out", "-o", "voids.txt", "--overwrite", "--threads", "1", "--quiet", **more)

    def written(self):
        return {name: (self.folder / name).read_bytes() for name in FILES if (self.folder / name).exists()}

    def contents(self):
        return {str(p.relative_to(self.out)): p.is_dir() or hashlib.sha256(p.read_bytes()).hexdigest()
                for p in self.out.rglob("*") if p.name != "log.json"}  # which has the time

    def test_of_each_write_rename_and_sync(self):
        self.begin()
        self.assertEqual(self.search().returncode, 0)
        files, after_one = self.written(), self.contents()
        self.assertEqual(set(files), set(FILES))
        self.assertEqual(self.search().returncode, 0)
        after_two = self.contents()
        seen, step = set(), 0
        while True:
            step += 1
            self.begin()
            done = self.search(env={"LD_PRELOAD": os.environ["KILL_AT_CALL"], "KILL_AT": str(step), "KILL_AT_WRITES": "1"})
            if done.returncode == 0:
                break
            self.assertEqual(done.returncode, -signal.SIGKILL, done.stderr)
            with self.subTest(step=step):
                version = json.loads((self.out / "manifest.json").read_text())["version"]
                left = self.written()
                self.assertEqual(left, {name: files[name] for name in left}, "files are whole or not there")
                self.assertTrue(version == 3 or not left, "files come after the version")
                seen.add((version, len(left)))
                self.assertEqual(self.search().returncode, 0)
                self.assertEqual(self.contents(), after_one if version == 2 else after_two)
                self.assertEqual(self.written(), files)
        self.assertGreaterEqual(seen, {(2, 0), (3, 0), (3, 1), (3, 2), (3, 3)})
        self.assertGreater(step, 40)


if __name__ == "__main__":
    unittest.main()
