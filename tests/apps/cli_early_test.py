"""Clouds large enough that tiles write their first cells before the others are known."""
import hashlib
import pathlib
import shutil
import signal
import subprocess
import time
import unittest

from cli import TESSERA, CliTest


class Early(CliTest):
    def setUp(self):
        super().setUp()
        self.cloud = self.folder / "cloud.npy"
        self.ok("generate", "uniform", "-n", "4300k", "--seed", "3", "-o", self.cloud)
        # In 2D, where that many points take a few seconds.
        self.args = ["triangulate", str(self.cloud), "-o", str(self.out), "--dim", "2", "--tiles", "12", "--threads", "2", "--quiet"]

    def early_files(self):
        return sorted((self.out / "tiles").glob("*-early-*"))

    def stop(self, number, *more):
        """Once several tiles have written early."""
        process = subprocess.Popen([TESSERA, *self.args, *more], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        end = time.monotonic() + 120
        while len(self.early_files()) < 5:
            self.assertIsNone(process.poll(), "it ended before it could be stopped")
            self.assertLess(time.monotonic(), end)
            time.sleep(0.005)
        process.send_signal(number)
        process.communicate(timeout=120)
        self.assertNotEqual(process.returncode, 0)
        self.assertTrue(self.early_files())

    def hashes(self):
        return {p.name: hashlib.sha256(p.read_bytes()).hexdigest() for p in (self.out / "tiles").iterdir()}

    def test_they_are_the_same_however_the_run_ends_and_goes_on(self):
        self.ok(*self.args)
        expected = self.hashes()
        self.assertEqual(len(expected), 12)
        for tile in (self.out / "tiles").iterdir():
            with tile.open("rb") as file:
                self.assertIn(b" <AppendedData", file.read(1 << 14), f"{tile} was not written early")
        self.ok("verify", self.out)
        short = ("--memory", "400M")  # tiles sleep and leave images
        for what, number, more, damaged in (("kill", signal.SIGKILL, (), False), ("Ctrl-C", signal.SIGINT, (), False),
                                            ("kill, short memory", signal.SIGKILL, short, False),
                                            ("Ctrl-C, short memory", signal.SIGINT, short, False),
                                            ("damage", signal.SIGINT, short, True)):
            with self.subTest(what):
                shutil.rmtree(self.out)
                self.stop(number, *more)
                if damaged:
                    for file in self.early_files():
                        self.spoil(file)
                self.ok(*self.args, *more, "--resume")
                self.assertEqual(self.hashes(), expected)

    def spoil(self, file: pathlib.Path):
        with file.open("r+b") as opened:
            opened.seek(file.stat().st_size // 2)
            byte = opened.read(1)
            opened.seek(-1, 1)
            opened.write(bytes([byte[0] ^ 1]))


if __name__ == "__main__":
    unittest.main()
