"""Every C++ file is as clang-format has it: ./tessera.sh format makes it so."""
import os
import pathlib
import subprocess
import unittest

import tree

SOURCE = pathlib.Path(os.environ["SOURCE"])


class Format(unittest.TestCase):
    def test_every_file_is_formatted(self):
        files = [path for path in tree.files(SOURCE) if path.endswith(tree.CODE)]
        self.assertGreater(len(files), 500)
        wrong = []
        for first in range(0, len(files), 100):
            done = subprocess.run(["clang-format", "--dry-run", "-Werror", "--ferror-limit=1", *files[first:first + 100]],
                                  cwd=SOURCE, text=True, capture_output=True)
            wrong += [line.split(":")[0] for line in done.stderr.splitlines() if "clang-format-violations" in line]
            self.assertEqual(done.returncode != 0, "clang-format-violations" in done.stderr, done.stderr)
        self.assertEqual(wrong, [])


if __name__ == "__main__":
    unittest.main()
