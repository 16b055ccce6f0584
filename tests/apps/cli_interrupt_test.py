"""Ctrl-C, kill -9, and going on afterwards."""
import hashlib
import os
import pathlib
import shutil
import signal
import subprocess
import time
import unittest

from cli import CORRUPT, IGN, INTERRUPTED, IO, TESSERA, USAGE, CliTest


class Interrupt(CliTest):
    def setUp(self):
        super().setUp()
        self.args = ["triangulate", f"{IGN}/*.las", "-o", str(self.out), "--tiles", "12", "--threads", "1"]

    def start(self, *more):
        return subprocess.Popen([TESSERA, *self.args, *more], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)

    def wait_until(self, process, condition):
        end = time.monotonic() + 120
        while not condition():
            self.assertIsNone(process.poll(), "it ended before it could be stopped")
            self.assertLess(time.monotonic(), end)
            time.sleep(0.005)

    def is_routed(self):
        return (self.out / ".run" / "plan.json").exists()

    def stop(self, number):
        process = self.start()
        self.wait_until(process, self.is_routed)
        process.send_signal(number)
        _, errors = process.communicate(timeout=120)
        return process.returncode, errors

    def hashes(self, folder):
        return {p.name: hashlib.sha256(p.read_bytes()).hexdigest() for p in pathlib.Path(folder, "tiles").iterdir()}

    def test_a_run_that_was_interrupted_goes_on_to_the_same_files(self):
        status, errors = self.stop(signal.SIGINT)
        self.assertEqual(status, INTERRUPTED, errors)
        self.assertIn("tessera: interrupted; the same command with --resume continues", errors)
        self.assertFalse((self.out / "manifest.json").exists())
        self.refused(USAGE, *self.args, says=["unfinished", "--resume"])

        # Another job in its place would mix two results.
        self.refused(USAGE, *self.args, "--resume", "--dim", "2", says="other options")
        self.refused(USAGE, "triangulate", f"{IGN}/ign_77050_627755.las", *self.args[2:], "--resume", says="other input files")

        self.ok(*self.args, "--resume", "--quiet")
        self.assertFalse((self.out / ".run").exists())
        self.ok("verify", self.out, "--quiet")
        self.ok(*self.args[:2], "-o", "straight", *self.args[4:], "--quiet")
        self.assertEqual(self.hashes(self.out), self.hashes(self.folder / "straight"))

    def test_sigterm_is_the_same(self):
        self.assertEqual(self.stop(signal.SIGTERM)[0], INTERRUPTED)
        self.ok(*self.args, "--resume", "--quiet")
        self.ok("verify", self.out, "--quiet")

    def test_a_killed_run_goes_on(self):
        self.assertEqual(self.stop(signal.SIGKILL)[0], -signal.SIGKILL)
        self.ok(*self.args, "--resume", "--quiet")
        self.ok("verify", self.out, "--quiet")

    def test_an_unfinished_run_can_be_thrown_away(self):
        self.stop(signal.SIGINT)
        self.ok(*self.args, "--overwrite", "--quiet")
        self.ok("verify", self.out, "--quiet")

    def test_an_interrupted_reading_leaves_nothing(self):
        process = self.start()
        self.wait_until(process, lambda: list(self.out.glob(".run.new*")) or self.is_routed())
        process.send_signal(signal.SIGINT)
        process.communicate(timeout=120)
        self.assertEqual(process.returncode, INTERRUPTED)
        self.assertEqual(self.out.exists(), self.is_routed())

    def test_resume_with_nothing_to_resume_starts(self):
        self.ok(*self.args, "--resume", "--quiet")
        self.ok("verify", self.out, "--quiet")

    def test_a_run_folder_that_was_half_removed_goes_when_the_finished_run_is_resumed(self):
        self.ok(*self.args, "--quiet")
        (self.out / ".run" / "points").mkdir(parents=True)
        (self.out / ".run" / "points" / "000003.bin").write_bytes(b"left")
        self.ok(*self.args, "--resume")
        self.assertFalse((self.out / ".run").exists())

    def test_two_do_not_work_in_one_folder(self):
        process = self.start()
        self.wait_until(process, lambda: self.out.exists() and os.listdir(self.out))
        done = self.run_tessera(*self.args, "--resume")
        process.send_signal(signal.SIGKILL)
        process.communicate(timeout=120)
        self.assertEqual(done.returncode, USAGE, done.stderr)
        self.assertIn(f"another tessera is at work in it: process {process.pid} on ", done.stderr)

    def test_a_run_that_loses_its_lock_ends_and_leaves_the_folder_to_the_other(self):
        for routed in (False, True):
            process = self.start()
            self.wait_until(process, self.is_routed if routed else lambda: list(self.out.glob(".run.new*")))
            process.send_signal(signal.SIGSTOP)
            owner, = (self.out / ".lock").iterdir()
            owner.rename(owner.with_name("another"))
            if not routed:  # what the other does first
                for run in self.out.glob(".run.new*"):
                    shutil.rmtree(run)
            before = self.files(self.out)
            process.send_signal(signal.SIGCONT)
            _, errors = process.communicate(timeout=120)
            self.assertEqual(process.returncode, IO, errors)
            self.assertEqual(errors.splitlines()[-1],
                             f"tessera: {self.out}: this process was silent for so long that another process has taken the lock of the folder")
            # Its one writer and its one thread may each have been in the middle of a tile's file.
            new = {name.split(".")[0] for name in set(self.files(self.out)) - set(before) if name[0] != "."}
            self.assertLessEqual(len(new), 1)
            new = {name for name in set(self.files(self.out)) - set(before) if name[0] == "."}
            self.assertLessEqual(len(new), 1)
            shutil.rmtree(self.out)

    def test_a_damaged_run_is_refused(self):
        self.stop(signal.SIGINT)
        points = sorted((self.out / ".run" / "points").iterdir())
        whole = bytearray(points[0].read_bytes())
        whole[100] ^= 1
        points[0].write_bytes(whole)
        self.refused(CORRUPT, *self.args, "--resume", says=[points[0], "--overwrite"])
        points[0].write_bytes(whole[:-5])
        done = self.run_tessera(*self.args, "--resume")
        self.assertEqual(done.returncode, CORRUPT, done.stderr)
        (self.out / ".run" / "plan.json").write_text("{}")
        self.refused(CORRUPT, *self.args, "--resume", says="plan.json")

    def test_an_input_that_changed_is_refused_on_resume(self):
        cloud = self.write("cloud.las", (IGN / "ign_77050_627755.las").read_bytes())
        self.args[1] = str(cloud)
        self.stop(signal.SIGINT)
        os.utime(cloud, ns=(1, 1))
        self.refused(USAGE, *self.args, "--resume", says=["cloud.las", "changed"])


if __name__ == "__main__":
    unittest.main()
