"""Whatever is exchanged, copied or put back among the files of a killed run: it is noticed, and what it belonged to is
built again. The result is the same, or the run is refused with a sentence; no process is aborted."""
import filecmp
import json
import os
import pathlib
import random
import shutil
import signal
import subprocess
import time
import unittest

import numpy

from cli import TESSERA, CliTest

TILES = 16
KINDS = ("state", "finals", "duplicates")
# Of frames, before the payload: magic, kind, length, run, item, checksum.
HEADER = 40


class Scratch(CliTest):
    def cloud(self, name, seed):
        rng = numpy.random.default_rng(seed)
        points = rng.random((50_000, 3))
        points[40_000:] = points[:10_000]  # every tile has duplicates
        numpy.save(self.folder / name, points)

    def args(self, cloud):
        return ["triangulate", cloud, "-o", str(self.out), "--tiles", str(TILES), "--memory", "30M", "--threads", "1", "--quiet"]

    def killed(self, cloud, snapshot, enough):
        """A run that was killed when `enough` of its folder was there, as a folder of that name."""
        process = subprocess.Popen([TESSERA, *self.args(cloud)], cwd=self.folder, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)
        end = time.monotonic() + 120
        while not enough(self.out / ".run"):
            self.assertIsNone(process.poll(), "it ended before it could be killed")
            self.assertLess(time.monotonic(), end)
            time.sleep(0.001)
        process.send_signal(signal.SIGKILL)
        process.communicate()
        shutil.rmtree(self.out / ".lock", ignore_errors=True)  # of a process that is no more
        os.rename(self.out, self.folder / snapshot)

    def resumed(self, snapshot, change, cloud="cloud.npy"):
        shutil.rmtree(self.out, ignore_errors=True)
        shutil.copytree(self.folder / snapshot, self.out)
        change(self.out / ".run")
        done = self.run_tessera(*self.args(cloud), "--resume")
        self.assertEqual(done.returncode, 0, done.stderr)
        manifest = json.loads((self.out / "manifest.json").read_bytes())
        return manifest["digest2"], manifest["counts"]

    @staticmethod
    def files(run: pathlib.Path, kind):
        return sorted((run / kind).glob("*.bin"))

    def rotate(self, run, kind):
        files = self.files(run, kind)
        self.assertGreater(len(files), 2, f"the run was killed before it had {kind}")
        contents = [file.read_bytes() for file in files]
        for file, content in zip(files, contents[1:] + contents[:1]):
            file.write_bytes(content)

    def copy_one(self, run, kind):
        first, *others = self.files(run, kind)
        for file in others:
            shutil.copyfile(first, file)

    def put_in(self, run, kind, other):
        """Those of another run with as many tiles, of which the checksums are right, too."""
        for file in self.files(run, kind):
            if (other / ".run" / kind / file.name).exists():
                shutil.copyfile(other / ".run" / kind / file.name, file)

    def setUp(self):
        super().setUp()
        self.cloud("cloud.npy", 1)
        self.cloud("other.npy", 2)
        self.ok(*self.args("cloud.npy"))
        manifest = json.loads((self.out / "manifest.json").read_bytes())
        self.expected = manifest["digest2"], manifest["counts"]
        shutil.rmtree(self.out)

    def test_of_tiles_that_sleep(self):
        def asleep(run):
            return all(len(self.files(run, kind)) > TILES // 2 for kind in KINDS)

        self.killed("cloud.npy", "killed", asleep)
        self.killed("other.npy", "other", asleep)
        self.assertEqual(self.resumed("killed", lambda run: None), self.expected)
        for kind in KINDS:
            with self.subTest(f"{kind} in turn"):
                self.assertEqual(self.resumed("killed", lambda run: self.rotate(run, kind)), self.expected)
            with self.subTest(f"one of {kind} for all"):
                self.assertEqual(self.resumed("killed", lambda run: self.copy_one(run, kind)), self.expected)
            with self.subTest(f"{kind} of another run"):
                self.assertEqual(self.resumed("killed", lambda run: self.put_in(run, kind, self.folder / "other")), self.expected)
        rng = random.Random(3)
        for _ in range(int(os.environ.get("EXCHANGES", "6"))):
            kinds = rng.choice((("finals",), ("state", "finals"), ("state",), KINDS))
            number = rng.sample(range(TILES), 2)
            with self.subTest(f"{kinds} of tiles {number}"):
                def exchange(run):
                    for kind in kinds:
                        one, two = (run / kind / f"{n:06}.bin" for n in number)
                        if one.exists() and two.exists():
                            content = one.read_bytes()
                            shutil.copyfile(two, one)
                            two.write_bytes(content)
                self.assertEqual(self.resumed("killed", exchange), self.expected)

    def test_of_a_settled_run(self):
        def settled(run):
            return (run / "settled.done").exists()

        self.killed("cloud.npy", "killed", settled)
        self.killed("other.npy", "other", settled)
        self.assertEqual(self.resumed("killed", lambda run: None), self.expected)

        def other_list(run):
            shutil.copyfile(self.folder / "other" / ".run" / "settled" / "node-000000.bin", run / "settled" / "node-000000.bin")

        def payloads_in_turn(run):
            """The list of each tile under the name of another, checksums as they were."""
            path = run / "settled" / "node-000000.bin"
            content, frames = path.read_bytes(), []
            while content:
                length = HEADER + int.from_bytes(content[8:16], "little")
                frames.append(content[:length])
                content = content[length:]
            self.assertGreater(len(frames), 1)
            items = [frame[24:32] for frame in frames]
            path.write_bytes(b"".join(f[:24] + i + f[32:] for f, i in zip(frames, items[1:] + items[:1])))

        for change in (other_list, payloads_in_turn, lambda run: self.rotate(run, "state"), lambda run: self.rotate(run, "finals")):
            with self.subTest(change.__name__):
                self.assertEqual(self.resumed("killed", change), self.expected)

    def test_of_another_plan(self):
        """A plan is whole by its own checksum: what the segments and points have tells that it is another run's."""
        def asleep(run):
            return len(self.files(run, "state")) > TILES // 2

        self.killed("cloud.npy", "killed", asleep)
        self.killed("other.npy", "other", asleep)
        shutil.copytree(self.folder / "killed", self.out)
        shutil.copyfile(self.folder / "other" / ".run" / "plan.json", self.out / ".run" / "plan.json")
        self.assertFalse(filecmp.cmp(self.folder / "killed" / ".run" / "plan.json", self.out / ".run" / "plan.json", shallow=False))
        done = self.run_tessera(*self.args("cloud.npy"), "--resume")
        self.assertGreater(done.returncode, 0, done.stderr)
        self.assertEqual(len(done.stderr.splitlines()), 1, done.stderr)


if __name__ == "__main__":
    unittest.main()
