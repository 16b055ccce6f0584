"""A surface that is killed before any of its steps on the disk, goes on with what is there, and is the same; and what is
said of a folder that cannot be gone on with."""
import os
import shutil
import signal
import unittest

from cli import CORRUPT, USAGE, CliTest

EVERY = int(os.environ.get("RESUME_EVERY", "3"))  # of the steps
OPTIONS = ("--manifold", "--smooth", "2", "--threads", "1", "--memory", "200K")  # tiles on disk, which decide alone


class Resumed(CliTest):
    def setUp(self):
        super().setUp()
        self.ok("generate", "uniform", "-n", "150", "-o", "cloud.ply", "--quiet")
        self.ok("triangulate", "cloud.ply", "-o", "out", "--tiles", "3", "--quiet")
        self.run_folder = self.folder / "mesh.ply.surface"

    def surface(self, *more, **how):
        return self.run_tessera("surface", "out", "-o", "mesh.ply", *OPTIONS, "--quiet", *more, **how)

    def killed_at(self, step, *more):
        """Whether it was, before so many steps."""
        done = self.surface(*more, env={"LD_PRELOAD": os.environ["KILL_AT_CALL"], "KILL_AT": str(step)})
        self.assertIn(done.returncode, (0, -signal.SIGKILL), done.stderr)
        return done.returncode != 0

    def kept(self):
        return {str(file.relative_to(self.run_folder)): file.stat().st_mtime_ns
                for file in self.run_folder.glob("kept/*/*.bin")}

    def test_it_is_killed_at_each_step_and_goes_on(self):
        self.ok("surface", "out", "-o", "whole.ply", *OPTIONS, "--quiet")
        whole = (self.folder / "whole.ply").read_bytes()
        mesh = self.folder / "mesh.ply"
        step, kinds, went_on = 1 - EVERY, set(), 0
        while True:
            step += EVERY
            mesh.unlink(missing_ok=True)
            if not self.killed_at(step, "--resume"):
                break
            if mesh.exists():
                self.assertEqual(mesh.read_bytes(), whole, step)
            before = self.kept()
            kinds.add(len({name.split("/")[1] for name in before}))
            # Killed once more, soon after it has gone on.
            self.killed_at(5, "--resume", "--overwrite")
            after = self.kept()
            same = {name for name, time in before.items() if after.get(name) == time}
            went_on += len(same) > 0
            done = self.surface("--resume", "--overwrite")
            self.assertEqual(done.returncode, 0, f"after step {step}: {done.stderr}")
            self.assertEqual(mesh.read_bytes(), whole, step)
            self.assertFalse(self.run_folder.exists(), step)
        self.assertGreater(step, 100)
        self.assertGreaterEqual(kinds, set(range(1, 9)))  # each step of the eight was gone on from
        self.assertGreater(went_on, step / EVERY / 2)

    def begun(self):
        """A run that was killed after some of its steps."""
        step = 40
        while len({name.split("/")[1] for name in self.kept()}) < 4:
            step += 10
            shutil.rmtree(self.run_folder, ignore_errors=True)
            self.assertTrue(self.killed_at(step, "--resume"))

    def test_without_resume_it_begins_anew_and_leaves_nothing(self):
        self.begun()
        self.assertEqual(self.surface().returncode, 0)
        self.assertEqual(sorted(path.name for path in self.folder.iterdir()), ["cloud.ply", "mesh.ply", "out"])

    def test_what_was_begun_otherwise_is_refused_and_stays(self):
        self.begun()
        before = self.kept()
        self.refused(USAGE, "surface", "out", "-o", "mesh.ply", *OPTIONS, "--lambda", "2", "--resume", says="with other options")
        self.ok("generate", "uniform", "-n", "151", "-o", "cloud.ply", "--overwrite", "--quiet")
        self.ok("triangulate", "cloud.ply", "-o", "out", "--tiles", "3", "--overwrite", "--quiet")
        self.refused(USAGE, "surface", "out", "-o", "mesh.ply", *OPTIONS, "--resume", says="with another triangulation")
        self.ok("generate", "uniform", "-n", "150", "-o", "cloud.ply", "--overwrite", "--quiet")
        self.ok("triangulate", "cloud.ply", "-o", "out", "--tiles", "4", "--overwrite", "--quiet")
        self.refused(USAGE, "surface", "out", "-o", "mesh.ply", *OPTIONS, "--resume", says="with other tiles")
        self.assertEqual(self.kept(), before)
        self.assertFalse((self.folder / "mesh.ply").exists())

    def test_damage_to_what_was_kept_is_found(self):
        self.begun()
        state = shutil.copytree(self.run_folder, self.folder / "state")
        files = sorted(file.relative_to(state) for file in state.glob("kept/*/*.bin")) + [(state / "plan.json").relative_to(state)]
        self.ok("surface", "out", "-o", "whole.ply", *OPTIONS, "--quiet")
        whole = (self.folder / "whole.ply").read_bytes()
        for file in files:
            data = (state / file).read_bytes()
            for damage, changed in (("turned", data[:len(data) // 2] + bytes([data[len(data) // 2] ^ 1]) + data[len(data) // 2 + 1:]),
                                    ("cut", data[:-1]), ("empty", b"")):
                with self.subTest(file=str(file), damage=damage):
                    shutil.rmtree(self.run_folder)
                    shutil.copytree(state, self.run_folder)
                    (self.run_folder / file).write_bytes(changed)
                    (self.folder / "mesh.ply").unlink(missing_ok=True)
                    done = self.surface("--resume")
                    if done.returncode == 0:  # what is damaged was not needed, or was made again
                        self.assertEqual((self.folder / "mesh.ply").read_bytes(), whole)
                        shutil.copytree(state, self.run_folder)
                    else:
                        self.assertIn(done.returncode, (CORRUPT, USAGE), done.stderr)
                        self.assertEqual(len(done.stderr.strip().splitlines()), 1, done.stderr)
                        self.assertFalse((self.folder / "mesh.ply").exists())

    def test_something_else_in_its_place_is_left_alone(self):
        self.run_folder.mkdir()
        (self.run_folder / "mine").write_text("mine")
        self.refused(USAGE, "surface", "out", "-o", "mesh.ply", says="is in the way")
        self.assertEqual((self.run_folder / "mine").read_text(), "mine")
        shutil.rmtree(self.run_folder)
        self.run_folder.write_text("mine")
        self.refused(USAGE, "surface", "out", "-o", "mesh.ply", "--resume", says="is in the way")
        self.assertEqual(self.run_folder.read_text(), "mine")


if __name__ == "__main__":
    unittest.main()
