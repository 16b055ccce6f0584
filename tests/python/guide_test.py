"""Every example of the guide and of the docstrings gives what it says, and everything public is documented."""
import doctest
import inspect
import os
import pathlib
import pydoc
import tempfile
import unittest

import numpy as np
import tessera

IGN = pathlib.Path(os.environ["IGN"])
GUIDE = pathlib.Path(__file__).parents[2] / "docs" / "python.md"


class Guide(unittest.TestCase):
    def test_examples_give_what_they_say(self):
        with tempfile.TemporaryDirectory() as folder:
            self.addCleanup(os.chdir, os.getcwd())
            os.chdir(folder)
            os.symlink(IGN, "block")
            given = {"np": np, "tessera": tessera}
            self.assertEqual(doctest.testfile(str(GUIDE), module_relative=False, globs=given).failed, 0)
            for public in (tessera.triangulate, tessera.Delaunay, tessera.LinearNDInterpolator):
                for test in doctest.DocTestFinder().find(public, globs=given):
                    runner = doctest.DocTestRunner()
                    self.assertEqual(runner.run(test).failed, 0)
            os.chdir("/")

    def test_everything_public_has_a_docstring(self):
        for name in tessera.__all__:
            thing = getattr(tessera, name)
            self.assertTrue(inspect.getdoc(thing), name)
            self.assertEqual(thing.__module__, "tessera")
            if inspect.isclass(thing) and not issubclass(thing, (Exception, tuple)):
                for member, value in vars(thing).items():
                    if not member.startswith("_") and member != "furthest_site":
                        self.assertTrue(inspect.getdoc(value), f"{name}.{member}")

    def test_help_shows_the_package_and_hides_its_inside(self):
        text = pydoc.plain(pydoc.render_doc(tessera))
        for word in ("triangulate(", "class Delaunay", "class Triangulation", "find_simplex", "max_points_per_tile"):
            self.assertIn(word, text)

    def test_the_version_is_the_librarys(self):
        self.assertRegex(tessera.__version__, r"^\d+\.\d+\.\d+$")


if __name__ == "__main__":
    unittest.main()
