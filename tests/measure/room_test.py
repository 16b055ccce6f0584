"""A change of a result on a disk without room for it."""
import hashlib
import os
import re
import shutil
import subprocess
import unittest

from cli import IO, CliTest


@unittest.skipIf(os.geteuid() != 0, "only root may mount")
class Room(CliTest):
    def contents(self):
        return {str(p.relative_to(self.out)): p.is_dir() or hashlib.sha256(p.read_bytes()).hexdigest()
                for p in self.out.rglob("*")}

    def disk(self, size):
        """A file system of that many bytes, with the result on it."""
        if subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={size}", "tmpfs", self.mount]).returncode != 0:
            self.skipTest("tmpfs cannot be mounted here")
        self.addCleanup(subprocess.run, ["umount", self.mount], check=True)
        shutil.copytree(self.base, self.out)

    def test_that_is_too_little_is_told_before_anything_is_written(self):
        self.base, self.mount = self.folder / "base", self.folder / "disk"
        self.out = self.mount / "out"
        self.mount.mkdir()
        self.ok("triangulate", self.xyz(n=20_000), "-o", self.base, "--tiles", "4", "--quiet")
        taken = sum(p.stat().st_size for p in self.base.rglob("*") if p.is_file())
        self.disk(taken * 3 // 2)
        before = self.contents()
        done = self.refused(IO, "measure", self.out, "--volume", says=f"{self.out}: a new version, ")
        told = re.search(r"stands, needs up to (\d+) MiB, and the disk has (\d+) MiB left$", done.stderr.strip())
        needed, free = map(int, told.groups())
        self.assertLess(free, needed)
        self.assertGreater(needed << 20, taken)
        self.assertLess(needed << 20, 2 * taken + (1 << 20))
        self.assertEqual(self.contents(), before)
        self.ok("verify", self.out)

        # As much as it says is enough.
        room = taken + (needed << 20)
        subprocess.run(["mount", "-o", f"remount,size={room + (room >> 6)}", self.mount], check=True)
        self.ok("measure", self.out, "--volume", "--quiet")
        self.ok("verify", self.out)
        # Once the older version is gone, there is room for this again.
        self.ok("measure", self.out, "--volume", "--quiet")
        self.assertEqual(len([*(self.out / "tiles").iterdir()]), 4)


if __name__ == "__main__":
    unittest.main()
