"""The last line of `./tessera.sh test` tells how many tests were skipped, and why."""
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

SCRIPT = pathlib.Path(os.environ["SOURCE"]) / "scripts" / "skipped_tests.py"

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


if __name__ == "__main__":
    unittest.main()
