"""A change that is killed before any of its steps on the disk goes on with what is there, and gives the same result; and
what is said of a run that cannot be gone on with. With little memory, tiles are read and written one after the other."""
import hashlib
import json
import os
import shutil
import signal
import unittest

import numpy as np
from cli import USAGE, CliTest

EVERY = int(os.environ.get("RESUME_EVERY", "7"))  # of the steps
OPTIONS = ("--threads", "1", "--memory", "4M")


class Resumed(CliTest):
    def setUp(self):
        super().setUp()
        random = np.random.default_rng(3)
        points = random.random((2000, 2))
        np.save(self.folder / "cloud.npy", points)
        np.save(self.folder / "more.npy", random.random((40, 2)) * 0.3)
        hole = np.flatnonzero(np.hypot(points[:, 0] - 0.5, points[:, 1] - 0.5) < 0.1)
        np.save(self.folder / "hole.npy", hole)
        self.ok("triangulate", "cloud.npy", "-o", "out", "--tiles", "12", "--quiet")
        self.next, self.run_folder = self.folder / "next", self.folder / "next.update"

    def update(self, *more, change=("--add", "more.npy", "--remove-ids", "hole.npy"), **how):
        return self.run_tessera("update", "out", *change, "-o", "next", *OPTIONS, "--quiet", *more, **how)

    def killed_at(self, step, *more):
        """Whether it was, before so many steps."""
        done = self.update(*more, env={"LD_PRELOAD": os.environ["KILL_AT_CALL"], "KILL_AT": str(step)})
        self.assertIn(done.returncode, (0, -signal.SIGKILL), done.stderr)
        return done.returncode != 0

    def content(self, folder):
        """Of the tiles, the duplicates and what the manifest says of them."""
        files = {str(file.relative_to(folder)): hashlib.sha256(file.read_bytes()).hexdigest()
                 for file in folder.rglob("*") if file.is_file() and file.name != "manifest.json"}
        manifest = json.loads((folder / "manifest.json").read_text())
        return files, manifest["digest2"], manifest["bounds"], manifest["counts"], manifest["tiles"]

    def test_it_is_killed_at_each_step_and_goes_on(self):
        self.check_each(EVERY)

    def test_it_is_killed_while_tiles_are_split_and_goes_on(self):
        self.check_each(4 * EVERY, "--max-points-per-tile", "90")
        self.assertGreater(self.tiles, 12)

    def check_each(self, every, *more):
        self.assertEqual(self.update(*more).returncode, 0)
        whole, old = self.content(self.next), self.content(self.folder / "out")
        self.tiles = len(whole[-1])
        step, went_on = 1 - every, 0
        while True:
            step += every
            shutil.rmtree(self.next, ignore_errors=True)
            if not self.killed_at(step, "--resume", *more):
                break
            self.assertEqual(self.content(self.folder / "out"), old, step)
            if self.next.exists():  # killed while the run folder was removed
                self.assertEqual(self.content(self.next), whole, step)
                shutil.rmtree(self.next)
                shutil.rmtree(self.run_folder, ignore_errors=True)
                continue
            before = {file: file.stat().st_mtime_ns for file in self.run_folder.glob("ends/*.bin")}
            self.killed_at(9, "--resume", *more)  # once more, soon after it has gone on
            done = self.update("--resume", *more)
            self.assertEqual(done.returncode, 0, f"after step {step}: {done.stderr}")
            went_on += len(before) > 0
            self.assertEqual(self.content(self.next), whole, step)
            self.assertFalse(self.run_folder.exists(), step)
        self.assertGreater(step, 60)
        self.assertGreater(went_on, 1)

    def begun(self):
        step = 20
        while not (self.run_folder / "plan.json").exists():
            step += 10
            shutil.rmtree(self.run_folder, ignore_errors=True)
            self.assertTrue(self.killed_at(step, "--resume"))

    def test_without_resume_it_begins_anew_and_leaves_nothing(self):
        self.begun()
        self.assertEqual(self.update().returncode, 0)
        self.assertFalse(self.run_folder.exists())

    def test_what_was_begun_otherwise_is_refused_and_stays(self):
        self.begun()
        done = self.update("--resume", change=("--add", "more.npy"))
        self.assertEqual(done.returncode, USAGE)
        self.assertIn("with another change", done.stderr)
        self.ok("triangulate", "cloud.npy", "-o", "out", "--tiles", "5", "--overwrite", "--quiet")
        done = self.update("--resume")
        self.assertEqual(done.returncode, USAGE)
        self.assertIn("with another result", done.stderr)
        self.assertTrue((self.run_folder / "plan.json").exists())
        self.assertFalse(self.next.exists())

    def test_it_is_the_same_with_any_memory_and_threads(self):
        self.assertEqual(self.update().returncode, 0)
        whole = self.content(self.next)
        for memory, threads in (("1G", "3"), ("1M", "2"), ("3M", "1")):
            shutil.rmtree(self.next)
            self.ok("update", "out", "--add", "more.npy", "--remove-ids", "hole.npy", "-o", "next", "--quiet",
                    "--memory", memory, "--threads", threads)
            self.assertEqual(self.content(self.next), whole, (memory, threads))


if __name__ == "__main__":
    unittest.main()
