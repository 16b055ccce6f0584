"""The types of the package: the guide's examples pass mypy --strict."""
import doctest
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

GUIDE = pathlib.Path(__file__).parents[2] / "docs" / "python.md"

# What is wrong, and what mypy must say of it.
WRONG = """
import tessera
t = tessera.triangulate("a.las", dim="2")
cells: str = t.n_cells
t.dem(res=1.0).value
tessera.nothing
for tile in t:
    tile.points.nothing
"""


def judge(text):
    """Returns the lines that mypy --strict says of a program."""
    with tempfile.TemporaryDirectory(prefix="tessera-types-") as folder:
        program = pathlib.Path(folder) / "program.py"
        program.write_text(text)
        # The package lies where its users have it: mypy then judges the program alone.
        done = subprocess.run([sys.executable, "-m", "mypy", "--strict", "--follow-imports=silent", "--cache-dir", f"{folder}/cache",
                               "--no-error-summary", program], capture_output=True, text=True,
                              env={**os.environ, "MYPYPATH": os.environ["PYTHONPATH"].split(":")[0]})
        if done.returncode not in (0, 1) or done.stderr:
            raise AssertionError(done.stdout + done.stderr)
        return done.stdout.replace(str(program), "program.py").splitlines()


class Types(unittest.TestCase):
    def test_the_examples_of_the_guide_pass(self):
        examples = doctest.DocTestParser().get_examples(GUIDE.read_text())
        self.assertGreater(len(examples), 60)
        text = "import numpy as np\nimport tessera\n" + "".join(example.source for example in examples)
        self.assertEqual(judge(text), [])

    def test_what_is_wrong_is_found(self):
        said = judge(WRONG)
        lines = [int(line.split(":")[1]) for line in said if ": error:" in line]
        self.assertEqual(lines, [3, 4, 5, 6, 8], said)


if __name__ == "__main__":
    unittest.main()
