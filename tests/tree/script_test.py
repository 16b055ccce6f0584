"""What ./tessera.sh builds; its last line tells how many tests were skipped, and why."""
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

SOURCE = pathlib.Path(os.environ["SOURCE"])
SCRIPT = SOURCE / "scripts" / "skipped_tests.py"

LOG = """test_a (m.C.test_a) ... ok
test_b (m.C.test_b) ... skipped 'only root may mount'
test_c (m.C.test_c)
What it says. ... skipped "no tmpfs: it's refused"
test_d (m.C.test_d) ... skipped 'only root may mount'
OK (skipped=3)
[ RUN      ] Disk.IsFull
tests/store/tile_store_test.cc:290: Skipped
mounting needs root

[  SKIPPED ] Disk.IsFull (0 ms)
"""


class Skips(unittest.TestCase):
    def told(self, log):
        with tempfile.NamedTemporaryFile("w") as file:
            file.write(log)
            file.flush()
            return subprocess.run([sys.executable, SCRIPT, file.name], text=True, capture_output=True, check=True).stdout

    def test_are_counted_by_reason(self):
        self.assertEqual(self.told(LOG), "skipped tests: 4 (2 x only root may mount; 1 x no tmpfs: it's refused; "
                                         "1 x mounting needs root)\n")

    def test_may_be_none(self):
        self.assertEqual(self.told("test_a (m.C.test_a) ... ok\n"), "no test was skipped\n")

    def test_of_unittest_are_found(self):
        """As unittest itself writes it."""
        module = "import unittest\nclass C(unittest.TestCase):\n    @unittest.skip('here')\n    def test(self): pass\n"
        with tempfile.TemporaryDirectory() as folder:
            pathlib.Path(folder, "m.py").write_text(module)
            ran = subprocess.run([sys.executable, "-m", "unittest", "-v", "m"], cwd=folder, text=True, capture_output=True)
        self.assertEqual(self.told(ran.stderr), "skipped tests: 1 (1 x here)\n")


class TheScript(unittest.TestCase):
    """In a folder of its own, where programs only write down how they are called."""

    def setUp(self):
        self.folder = pathlib.Path(self.enterContext(tempfile.TemporaryDirectory()))
        shutil.copy(SOURCE / "tessera.sh", self.folder)
        for name in ("deploy/install-deps.sh", "programs/cmake", "programs/ctest"):
            program = self.folder / name
            program.parent.mkdir(exist_ok=True)
            program.write_text(f'#!/bin/sh\necho "{program.name} $*" >> "{self.folder}/calls"\n[ {program.name} != ctest ]\n')
            program.chmod(0o755)
        (self.folder / "scripts").mkdir()
        shutil.copy(SCRIPT, self.folder / "scripts")
        log = self.folder / "build" / "release" / "Testing" / "Temporary" / "LastTest.log"
        log.parent.mkdir(parents=True)
        log.write_text(LOG)

    def run_it(self, *words):
        done = subprocess.run(["bash", self.folder / "tessera.sh", *words], text=True, capture_output=True,
                              env=os.environ | {"PATH": f"{self.folder / 'programs'}:{os.environ['PATH']}"})
        return done, (self.folder / "calls").read_text() if (self.folder / "calls").exists() else ""

    def test_builds_the_programs_or_everything(self):
        self.assertRegex(self.run_it("build")[1], "cmake --build .* --target tessera_command tesserad\n$")
        self.assertRegex(self.run_it("all")[1], "cmake --build .* --target all\n$")

    def test_ends_with_what_was_skipped_and_with_the_status_of_the_tests(self):
        done, calls = self.run_it("test", "-R", "splay")
        self.assertRegex(calls, "ctest .* -R splay\n$")
        self.assertRegex(done.stdout, "skipped tests: 4 .*\n$")
        self.assertEqual(done.returncode, 1)

    def test_leaves_the_long_tests_to_the_night(self):
        (self.folder / "tests").mkdir()
        (self.folder / "tests" / "nightly_tests.txt").write_text("# why\n^one$\n^Two/\n")
        self.assertRegex(self.run_it("test")[1], r"ctest .* -E \^one\$\|\^Two/\n$")
        self.assertRegex(self.run_it("nightly")[1], r"ctest .* -R \^one\$\|\^Two/\n")

    def test_knows_each_long_test(self):
        """A pattern that matches nothing would be forgotten."""
        patterns = [line for line in (SOURCE / "tests" / "nightly_tests.txt").read_text().splitlines() if not line.startswith("#")]
        self.assertLessEqual("".join(patterns).count("("), 9, "CTest takes no notice of an expression with more")
        self.assertGreater(len(patterns), 10)
        listed = subprocess.run(["ctest", "--test-dir", pathlib.Path(os.environ["LINKS"]).parent, "-N"], text=True, capture_output=True,
                                check=True).stdout
        names = re.findall(r"^ *Test *#\d+: (\S+)$", listed, re.MULTILINE)
        for pattern in patterns:
            self.assertTrue(any(re.search(pattern, name) for name in names), pattern)
        self.assertGreater(sum(not any(re.search(p, name) for p in patterns) for name in names), len(names) * .95)

    def test_tells_of_every_word_that_it_knows(self):
        known = re.findall(r"^  ([a-z]+)\) ", (SOURCE / "tessera.sh").read_text(), re.MULTILINE)
        told = re.findall(r"^\./tessera\.sh (\w+)", self.run_it("help")[0].stdout, re.MULTILINE)
        self.assertEqual(told, known)


if __name__ == "__main__":
    unittest.main()
