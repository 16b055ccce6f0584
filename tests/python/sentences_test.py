"""Sentences name options as Python users write them."""
import inspect
import os
import pathlib
import re
import tempfile
import unittest

import numpy as np
import tessera
from tessera._errors import argument

import clouds

ROOT = pathlib.Path(__file__).resolve().parents[2]


class Sentences(unittest.TestCase):
    def setUp(self):
        held = tempfile.TemporaryDirectory(prefix="tessera-python-")
        self.addCleanup(held.cleanup)
        self.folder = pathlib.Path(held.name)

    def refused(self, kind, sentence, call):
        """`call` raises `kind`, with `sentence` (a regular expression) at the end, and no word of the command in it."""
        with self.assertRaisesRegex(kind, sentence + "$") as caught:
            call()
        said = str(caught.exception)
        self.assertNotRegex(said, r"(^|[^\w-])--[a-z]|_bytes|[\x00-\x1f]")
        return said

    def test_memory_and_threads_are_called_so(self):
        points = clouds.random(20_000, 3)
        self.refused(tessera.MemoryLimitError,
                     "^memory is too small for 2 threads .*; give at least .*, or fewer threads",
                     lambda: tessera.triangulate(points, memory="1M", threads=2))

    def test_advice_can_be_typed_as_it_stands(self):
        points = clouds.random(100, 3)
        points[17, 1] = np.nan
        self.refused(tessera.BadInputError, r"row 17: y is nan \(skip_invalid=True drops such points and counts them\)",
                     lambda: tessera.triangulate(points))
        t = tessera.triangulate(points, skip_invalid=True, folder=self.folder / "out")
        self.refused(tessera.UsageError, "out: holds a finished result; overwrite=True replaces it",
                     lambda: tessera.triangulate(points, folder=self.folder / "out"))
        self.refused(tessera.UsageError, "or has no ending, so give format: ply, .*",
                     lambda: t.export(self.folder / "tiles"))
        self.refused(tessera.UsageError, "give a name without an ending, and format='npy'",
                     lambda: t.export(self.folder / "tiles.ply", format="npy"))

    def test_what_is_no_array_is_told_so(self):
        self.refused(tessera.UsageError, "^points is None: it must be an array of numbers", lambda: tessera.Delaunay(None))
        self.refused(tessera.UsageError, r"^points\[1, 0\] is None: it must be a number", lambda: tessera.Delaunay([[0, 0], [None, 1]]))
        self.refused(tessera.UsageError, "^dim is 3, but points have 2 columns: x and y alone are triangulated in 2D",
                     lambda: tessera.triangulate(clouds.random(50, 2), dim=3))

    def test_a_star_is_of_one_vertex(self):
        t = tessera.triangulate(clouds.random(50, 2))
        for wrong in ([1, 2], np.array([1, 2]), 1.5, None, -1, "3"):
            self.refused(tessera.UsageError, "^vertex is .*: it must be one integer from 0 to [0-9]+", lambda: t.star(wrong))
        self.refused(tessera.UsageError, r"^tile is \[0\]: it must be one integer from 0 to 999999", lambda: t.star(1, tile=[0]))
        self.assertEqual(t.star(np.int64(7)).vertex, 7)

    def test_what_is_shown_is_in_plain_words(self):
        t = tessera.triangulate(clouds.random(50, 2))
        self.assertRegex(repr(t), "triangles in 1 tile, ")
        self.assertEqual(repr(tessera.LinearNDInterpolator(clouds.random(50, 3), np.arange(50))),
                         "<tessera.LinearNDInterpolator of 50 points in 3D>")
        self.assertEqual(inspect.signature(tessera.Client), inspect.signature(tessera.connect).replace(
            return_annotation=inspect.Signature.empty))

    def test_subfolders_are_read_when_asked_for(self):
        (self.folder / "block" / "sub").mkdir(parents=True)
        np.savetxt(self.folder / "block" / "sub" / "a.xyz", clouds.random(50, 3))
        self.refused(tessera.IoError, "; recursive=True looks into its subfolders, too",
                     lambda: tessera.triangulate(self.folder / "block"))
        self.assertEqual(tessera.triangulate(self.folder / "block", recursive=True).n_points, 50)

    def test_flat_clouds_and_heights_name_the_argument(self):
        flat = np.column_stack([clouds.random(60, 2), np.zeros(60)])
        np.savetxt(self.folder / "flat.xyz", flat)
        self.refused(tessera.BadInputError, r"lie in one plane; .* \(try dim=2\)",
                     lambda: tessera.triangulate(self.folder / "flat.xyz"))
        self.assertEqual(tessera.triangulate(self.folder / "flat.xyz", dim=2).n_points, 60)
        self.refused(tessera.BadInputError, "a 3D triangulation needs points off it", lambda: tessera.Delaunay(flat))
        self.assertEqual(argument("z", "false"), "heights=False")

    def test_every_option_that_a_sentence_can_name_is_an_argument(self):
        elsewhere = {ROOT / "src/job/region_job.cc", ROOT / "src/input/cloud/cloud_units.cc"}  # which Python does not ask for
        for folder in ("input/remote", "result/region", "service", "surface"):
            elsewhere |= {*(ROOT / "src" / folder).rglob("*.cc")}
        keys = {key for folder in ("src", "actors") for path in {*(ROOT / folder).rglob("*.cc")} - elsewhere
                for key in re.findall(r'\boption\("([^"]*)"', path.read_text())}
        self.assertIn("memory", keys)
        arguments = {*inspect.signature(tessera.triangulate).parameters,
                     *inspect.signature(tessera.Triangulation.export).parameters,
                     *inspect.signature(tessera.Triangulation.verify).parameters,
                     *inspect.signature(tessera.Triangulation.measure).parameters,
                     *(name for drawn in (tessera.Triangulation.dem, tessera.Triangulation.contours, tessera.Triangulation.profile,
                                       tessera.Triangulation.alpha_shape, tessera.Triangulation.density, tessera.Triangulation.volume,
                                       tessera.Triangulation.voronoi, tessera.Triangulation.voids, tessera.hag)
                       for name in inspect.signature(drawn).parameters),
                     *inspect.signature(tessera.region).parameters}
        for key in keys:
            self.assertIn(argument(key, ""), arguments)

    def test_names_of_files_are_left_as_they_are(self):
        path = os.fsdecode(os.fsencode(self.folder) + b"/--memory \x01 caf\xe9.xyz")
        with self.assertRaises(tessera.IoError) as caught:
            tessera.triangulate(path)
        self.assertTrue(str(caught.exception).startswith(path + ": "), str(caught.exception))


if __name__ == "__main__":
    unittest.main()
