"""The wheel in fresh systems without any library of Tessera's: Debian 12, and Debian 13 with another Python and glibc."""
import os
import pathlib
import shutil
import subprocess
import unittest

SOURCE = pathlib.Path(__file__).resolve().parents[2]


def other_python():
    """A Python 3.13 here, with its headers: of the PATH, or of pyenv."""
    found = shutil.which("python3.13")
    return found or next((str(path) for path in pathlib.Path.home().glob(".pyenv/versions/3.13.*/bin/python3")), None)


@unittest.skipUnless(os.geteuid() == 0 and shutil.which("debootstrap"), "only root can make other systems, and with debootstrap")
class Elsewhere(unittest.TestCase):
    def use_it(self, suite, python):
        done = subprocess.run([SOURCE / "deploy" / "try-wheel.sh", suite, python], capture_output=True, text=True,
                              env={**os.environ, "TESSERA_BUILD": os.environ["BUILD"]})
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        return done.stdout

    def test_it_runs_in_a_bare_debian_12(self):
        self.assertRegex(self.use_it("bookworm", "/usr/bin/python3"), r"^Python 3\.11\.\d+, glibc 2\.36, ")

    @unittest.skipUnless(other_python(), "there is no Python 3.13 to make a wheel for")
    def test_it_runs_in_debian_13_with_python_3_13_and_numpy_2(self):
        self.assertRegex(self.use_it("trixie", other_python()), r"^Python 3\.13\.\d+, glibc 2\.41, NumPy 2\.")


if __name__ == "__main__":
    unittest.main()
