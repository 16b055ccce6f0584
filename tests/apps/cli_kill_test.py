"""A run that is killed at any moment, also while it is resumed or while its mail is on disk, ends in the same files.

By hand, many more: KILLS=300 SEED=2 ctest -R cli_kill, with the environment that ctest gives."""
import hashlib
import os
import pathlib
import random
import shutil
import signal
import subprocess
import time
import unittest

from cli import TESSERA, CliTest

KILLS = int(os.environ.get("KILLS", "12"))
SEED = int(os.environ.get("SEED", "1"))
# Plenty of memory, and so little that tiles sleep and their mail goes to disk.
CIRCUMSTANCES = (["--tiles", "20", "--threads", "2", "--memory", "2G"],
                 ["--tiles", "24", "--threads", "2", "--memory", "150M"],
                 ["--tiles", "24", "--threads", "2", "--memory", "120M", "--store", "points"])


class Kill(CliTest):
    def command(self, out, options, *more):
        return [TESSERA, "triangulate", "cloud.npy", "-o", str(out), "--quiet", *options, *more]

    def hashes(self, folder):
        return {p.name: hashlib.sha256(p.read_bytes()).hexdigest() for p in pathlib.Path(folder, "tiles").iterdir()}

    def killed(self, command, seconds):
        """Whether it had to be killed after so long."""
        process = subprocess.Popen(command, cwd=self.folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        try:
            _, errors = process.communicate(timeout=seconds)
        except subprocess.TimeoutExpired:
            process.send_signal(signal.SIGKILL)
            process.communicate()
            return True
        self.assertEqual(process.returncode, 0, errors)
        return False

    def test_a_killed_run_is_resumed_to_the_same_files(self):
        self.ok("generate", "uniform", "-n", "120k", "-o", "cloud.npy", "--seed", SEED)
        rng = random.Random(SEED)
        expected, seconds = [], []
        for i, options in enumerate(CIRCUMSTANCES):
            began = time.monotonic()
            self.ok(*self.command(self.folder / f"straight{i}", options)[1:])
            seconds.append(time.monotonic() - began)
            expected.append(self.hashes(self.folder / f"straight{i}"))
        kills = turn = 0
        while kills < KILLS:
            which = turn % len(CIRCUMSTANCES)
            turn += 1
            options = CIRCUMSTANCES[which]
            resume = []
            for _ in range(rng.choice((1, 1, 2))):  # a third is killed again while it is resumed
                kills += self.killed(self.command(self.out, options, *resume), rng.uniform(0, 1.1) * seconds[which])
                resume = ["--resume"]
            done = self.run_tessera(*self.command(self.out, options, "--resume")[1:])
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertEqual(self.hashes(self.out), expected[which])
            left = set(os.listdir(self.out)) - set(os.listdir(self.folder / f"straight{which}"))
            self.assertEqual(left, set())
            shutil.rmtree(self.out)


if __name__ == "__main__":
    unittest.main()
