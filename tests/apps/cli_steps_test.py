"""A command that is killed before any of its steps on the disk: the same command goes on from there, or starts again."""
import hashlib
import json
import os
import shutil
import signal
import unittest

import numpy as np
from cli import USAGE, CliTest


class Steps(CliTest):
    def setUp(self):
        super().setUp()
        points = self.xyz(n=60).read_text()
        self.store = "cells"
        self.cloud = self.write("cloud.xyz", points + points[:points.index("\n") + 1])  # with a duplicate

    def command(self, *more, tiles=2):
        return ["triangulate", self.cloud, "-o", self.out, "--tiles", tiles, "--threads", "1", "--quiet", "--store", self.store, *more]

    def contents(self):
        """What must be the same for equal results; of what differs from run to run, that it is there."""
        return {str(p.relative_to(self.out)): p.name in ("manifest.json", "report.html") or p.is_dir() or
                hashlib.sha256(p.read_bytes()).hexdigest() for p in self.out.rglob("*")}

    def killed_at(self, step, *more):
        done = self.run_tessera(*self.command(*more), env={"LD_PRELOAD": os.environ["KILL_AT_CALL"],
                                                           "KILL_AT": str(step)})
        self.assertIn(done.returncode, (0, -signal.SIGKILL), done.stderr)
        return done.returncode != 0

    def check_each_step(self, begin, *first, least):
        """From what begin() leaves in the result folder, the command with the options `first` is killed."""
        self.ok(*self.command())
        expected = self.contents()
        shutil.rmtree(self.out)
        begin()
        before = self.contents() if self.out.exists() else None
        step = 0
        while True:
            step += 1
            shutil.rmtree(self.out, ignore_errors=True)
            begin()
            if not self.killed_at(step, *first):
                break
            left = self.folder / "left"
            if self.out.exists():
                shutil.copytree(self.out, left)
            for option in ("--resume", "--overwrite"):
                done = self.run_tessera(*self.command(option))
                self.assertEqual(done.returncode, 0, f"{option} after step {step}: {done.stderr}")
                old = option == "--resume" and self.contents() == before  # the old result still stood
                if not old:
                    self.assertEqual(self.contents(), expected, f"{option} after step {step}")
                shutil.rmtree(self.out)
                if left.exists():
                    shutil.copytree(left, self.out)
            shutil.rmtree(left, ignore_errors=True)
        self.assertGreater(step, least)

    def test_of_a_new_run(self):
        self.check_each_step(lambda: None, least=50)

    def test_of_a_new_run_that_keeps_points(self):
        self.store = "points"
        self.check_each_step(lambda: None, least=50)

    def test_of_a_run_that_replaces_a_result(self):
        self.ok(*self.command(tiles=3))
        result = shutil.copytree(self.out, self.folder / "result")
        shutil.rmtree(self.out)
        self.check_each_step(lambda: shutil.copytree(result, self.out), "--overwrite", least=60)

    def unfinished(self):
        """A run that has been killed when all but one tile were stored."""
        for step in range(1, 1000):
            shutil.rmtree(self.out, ignore_errors=True)
            self.assertTrue(self.killed_at(step), "it ended before a tile was stored")
            if any(done.stat().st_size > 0 for done in self.out.glob("tiles/*.done")):
                return shutil.copytree(self.out, self.folder / "unfinished")

    def test_of_a_run_that_is_resumed_or_replaced(self):
        run = self.unfinished()
        for option in ("--resume", "--overwrite"):
            shutil.rmtree(self.out)
            self.check_each_step(lambda: shutil.copytree(run, self.out), option, least=30)
            shutil.copytree(run, self.out, dirs_exist_ok=True)


class Materialise(CliTest):
    """Cells of a result that is kept as points: killed before any step, it is the old version or the new one."""

    def materialise(self, **more):
        return self.run_tessera("materialise", "out", "--threads", "1", "--quiet", **more)

    def begin(self):
        shutil.rmtree(self.out, ignore_errors=True)
        shutil.copytree(self.folder / "base", self.out)

    def contents(self):
        return {str(p.relative_to(self.out)): p.is_dir() or hashlib.sha256(p.read_bytes()).hexdigest()
                for p in self.out.rglob("*") if p.name != "log.json"}  # which has the time

    def test_of_each_write_rename_and_sync(self):
        self.ok("triangulate", self.xyz(n=60), "-o", "base", "--tiles", "2", "--threads", "1", "--store", "points", "--quiet")
        self.begin()
        for _ in range(2):  # the second time removes what only the first version needs
            self.assertEqual(self.materialise().returncode, 0)
        expected = self.contents()
        self.assertEqual({name for name in expected if name.startswith("tiles/")}, {"tiles/000000-2.vtu", "tiles/000001-2.vtu"})
        kinds, step = set(), 0
        while True:
            step += 1
            self.begin()
            done = self.materialise(env={"LD_PRELOAD": os.environ["KILL_AT_CALL"], "KILL_AT": str(step), "KILL_AT_WRITES": "1"})
            if done.returncode == 0:
                break
            self.assertEqual(done.returncode, -signal.SIGKILL, done.stderr)
            with self.subTest(step=step):
                self.ok("verify", "out", "--quiet")
                kinds.add('"kind":"points"' in (self.out / "manifest.json").read_text())
                for _ in range(2):
                    self.assertEqual(self.materialise().returncode, 0)
                self.ok("verify", "out", "--quiet")
                self.assertEqual(self.contents(), expected)
        self.assertEqual(kinds, {True, False})
        self.assertGreater(step, 40)


class UpdateSteps(CliTest):
    """Kills a change of points in the result itself at every call that writes: the old version is left, or the new one."""

    def manifest(self, result="out"):
        return json.loads((self.folder / result / "manifest.json").read_text())

    def save(self, name, points):
        np.save(self.folder / name, points)
        return name

    def contents(self):
        return {str(p.relative_to(self.out)): p.is_dir() or hashlib.sha256(p.read_bytes()).hexdigest()
                for p in self.out.rglob("*") if p.name != "log.json"}  # which has the time

    def test_of_each_write_rename_and_sync(self):
        self.check_each_step(1)

    def test_of_each_step_with_tiles_that_are_split(self):
        self.assertGreater(self.check_each_step(3, "--max-points-per-tile", "10"), len(self.manifest("base")["tiles"]))

    def check_each_step(self, every, *more):
        """Kills before every such step. Returns the number of tiles afterwards."""
        grid = np.array([[x, y] for x in range(8) for y in range(8)], float)
        points = np.concatenate([grid, grid[:5]])  # with duplicates
        self.ok("triangulate", self.save("points.npy", points), "-o", "base", "--dim", "2", "--tiles", "4", "--threads", "1", "--quiet")
        base = self.folder / "base"

        def begin():
            shutil.rmtree(self.out, ignore_errors=True)
            shutil.copytree(base, self.out)

        # Changes duplicates, empties a tile, and adds points.
        gone = [0, 64, *[8 * x + y for x in range(4, 8) for y in range(4, 8)]]
        arguments = ("update", "out", "--remove-ids", self.save("gone.npy", np.array(gone)), "--add", self.save("more.npy", grid[:3] + 0.5), "--threads", "1", "--quiet", *more)
        begin()
        self.ok(*arguments)
        old, new = self.manifest("base")["digest2"], self.manifest()["digest2"]
        expected = self.contents()
        tiles = len(self.manifest()["tiles"])
        seen, step, old_masters = set(), 1 - every, 0
        while True:
            step += every
            begin()
            done = self.run_tessera(*arguments, env={"LD_PRELOAD": os.environ["KILL_AT_CALL"], "KILL_AT": str(step), "KILL_AT_WRITES": "1"})
            if done.returncode == 0:
                break
            self.assertEqual(done.returncode, -signal.SIGKILL, done.stderr)
            with self.subTest(step=step):
                self.ok("verify", "out", "--quiet")
                manifest = self.manifest()
                version = manifest.get("version", 1)
                self.assertEqual(manifest["digest2"], {1: old, 2: new}[version])
                self.assertEqual([v["version"] for v in json.loads(self.ok("log", "out", "--json"))["versions"]], list(range(1, version + 1)))
                seen.add(version)
                master = self.contents().get("triangulation.pvtu")
                old_masters += version == 2 and master != expected["triangulation.pvtu"]
                run = self.folder / "out.update"
                kept = self.folder / "kept"
                shutil.rmtree(kept, ignore_errors=True)
                for folder in (self.out, run):
                    if folder.exists():
                        shutil.copytree(folder, kept / folder.name)
                if version == 1 or (run / "outcome.json").exists():
                    told = json.loads(self.ok(*arguments[:-1 - len(more)], *more, "--json", "--resume"))
                    self.assertEqual((told["version"], told["digest"], told.get("made_earlier", False)), (2, new, version == 2))
                    self.assertEqual(self.manifest()["version"], 2)
                    self.ok("verify", "out", "--quiet")
                    self.assertEqual(self.contents()["triangulation.pvtu"], expected["triangulation.pvtu"])
                    if version == 1:  # the manifest has the command
                        self.assertEqual(self.contents() | {"manifest.json": ""}, expected | {"manifest.json": ""})
                    self.assertFalse(run.exists())
                else:  # there is nothing left but perhaps the lock
                    self.assertEqual(master, expected["triangulation.pvtu"])
                    self.assertLessEqual({p.relative_to(run).parts[0] for p in run.rglob("*")}, {".lock"})
                for folder in (self.out, run):
                    shutil.rmtree(folder, ignore_errors=True)
                    if (kept / folder.name).exists():
                        shutil.copytree(kept / folder.name, folder)
                shutil.rmtree(kept)
                if version == 1:
                    self.ok(*arguments)
                    self.assertEqual(self.contents(), expected)
                else:
                    self.ok("update", "out", "--remove-ids", self.save("one.npy", np.array([20])), "--quiet")
                    self.ok("verify", "out", "--quiet")
        self.assertEqual(seen, {1, 2})
        self.assertGreater(step, 40)
        if every == 1:
            self.assertGreater(old_masters, 0, "it was never killed between the manifest and the master file")
        return tiles

    def test_of_each_step_of_a_change_into_a_new_folder(self):
        grid = np.array([[x, y] for x in range(6) for y in range(6)], float)
        self.ok("triangulate", self.save("points.npy", grid), "-o", "out", "--dim", "2", "--tiles", "4", "--threads", "1", "--quiet")
        change = ("update", "out", "--remove-ids", self.save("gone.npy", np.array([0, 7])), "-o", "next")
        self.ok(*change, "--quiet")
        new = self.manifest("next")["digest2"]
        step, seen = 0, set()
        while True:
            step += 1
            shutil.rmtree(self.folder / "next")
            done = self.run_tessera(*change, "--threads", "1", "--quiet",
                                    env={"LD_PRELOAD": os.environ["KILL_AT_CALL"], "KILL_AT": str(step), "KILL_AT_WRITES": "1"})
            if done.returncode == 0:
                break
            with self.subTest(step=step):
                there = (self.folder / "next").exists()
                seen.add(there)
                if there and not (self.folder / "next.update" / "outcome.json").exists():
                    shutil.rmtree(self.folder / "next.update", ignore_errors=True)
                    continue
                if there:
                    self.refused(USAGE, *change, says="next: exists already")
                    other = [self.save("other.npy", np.array([3])) if word == "gone.npy" else word for word in change]
                    self.refused(USAGE, *other, "--resume", says=("is left of another command", "gone.npy"))
                told = json.loads(self.ok(*change, "--resume", "--json", "--threads", "2"))
                self.assertEqual(told.get("made_earlier", False), there)
                self.assertEqual(told["digest"], new)
                self.ok("verify", "next", "--quiet")
                self.assertFalse((self.folder / "next.update").exists())
        self.assertEqual(seen, {False, True})


if __name__ == "__main__":
    unittest.main()
