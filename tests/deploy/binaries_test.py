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

    def test_they_are_hardened(self):
        for binary in BINARIES:
            symbols = set(re.findall(r"\b(__\w+_(?:chk|fail))\b", readelf("--dyn-syms", binary)))
            self.assertIn("__stack_chk_fail", symbols, binary)
            if "SANITIZED" not in os.environ:
                self.assertTrue([name for name in symbols if name.endswith("_chk")], binary)
            self.assertIn("GNU_RELRO", readelf("--program-headers", binary), binary)
            self.assertRegex(readelf("--dynamic", binary), r"BIND_NOW|Flags: .*NOW", binary)

    def test_what_is_asserted_of_vectors_is_so_in_the_program(self):
        for binary in BINARIES[:2]:
            self.assertIn("__glibcxx_assert", readelf("--dyn-syms", binary) + readelf("--symbols", binary), binary)


if __name__ == "__main__":
    unittest.main()
