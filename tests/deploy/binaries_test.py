"""What the build makes for users: it loads libraries from no folder that others fill."""
import os
import pathlib
import re
import subprocess
import unittest

BINARIES = [pathlib.Path(name) for name in os.environ["BINARIES"].split(":") if name]


def readelf(*words):
    return subprocess.run(["readelf", "--wide", *map(str, words)], capture_output=True, text=True, check=True).stdout


def untrusted(folders):
    """The entries of a RUNPATH, as in "/usr/lib/x:", that a stranger may fill: empty ones and relative ones mean the
    folder in which the program is started."""
    return [entry for entry in folders.split(":") if not entry.startswith(("/", "$ORIGIN"))]


class Binaries(unittest.TestCase):
    def test_entries_that_mean_the_current_folder_are_seen(self):
        self.assertEqual(untrusted("/usr/lib/x86_64-linux-gnu/hdf5/serial:"), [""])
        self.assertEqual(untrusted("/a:$ORIGIN/../lib"), [])
        self.assertEqual(untrusted(":/a:lib:."), ["", "lib", "."])

    def test_no_library_is_loaded_from_the_current_folder(self):
        self.assertGreaterEqual(len(BINARIES), 3)
        for binary in BINARIES:
            for folders in re.findall(r"\((?:RUNPATH|RPATH)\)[^\[]*\[([^\]]*)\]", readelf("--dynamic", binary)):
                self.assertEqual(untrusted(folders), [], f"{binary}: {folders}")

    def test_tables_of_addresses_are_read_only_once_it_runs(self):
        for binary in BINARIES:
            self.assertRegex(readelf("--dynamic", binary), r"BIND_NOW|Flags:.*\bNOW\b", binary)
            self.assertIn("GNU_RELRO", readelf("--program-headers", binary), binary)

    @unittest.skipIf("SANITIZED" in os.environ, "sanitizers have checks of their own")
    def test_the_compiler_has_put_its_checks_in(self):
        for binary in BINARIES:
            imported = readelf("--dyn-syms", binary)
            self.assertIn("__stack_chk_fail", imported, binary)
            if binary.name.startswith("_tessera"):
                continue  # so thin that nothing in it copies into arrays
            self.assertRegex(imported, r"UND __\w+_chk", binary)
            # What std::vector says at an index that it does not have.
            self.assertIn(b"__n < this->size()", binary.read_bytes(), binary)


if __name__ == "__main__":
    unittest.main()
