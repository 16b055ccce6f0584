"""hag(): the same copies as those of the command."""
import os
import pathlib
import subprocess
import tempfile
import unittest

import tessera

CLOUD = pathlib.Path(__file__).resolve().parents[1] / "data" / "clouds" / "pdal_mvk_thin.las"


class Heights(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def test_copies_are_those_of_the_command(self):
        (made,) = tessera.hag(CLOUD, self.folder / "out", outside=0, memory="1G", threads=2)
        self.assertEqual((made.input, made.output, made.points), (CLOUD, self.folder / "out" / CLOUD.name, 6280))
        self.assertGreater(made.outside, 0)
        self.assertEqual([file.name for file in (self.folder / "out").iterdir()], [CLOUD.name])
        subprocess.run([os.environ["TESSERA"], "hag", CLOUD, "-o", self.folder / "same", "--outside", "0", "--quiet"], check=True)
        self.assertEqual(made.output.read_bytes(), (self.folder / "same" / CLOUD.name).read_bytes())

    def test_the_ground_is_an_object_or_a_folder(self):
        ground = tessera.triangulate(CLOUD, 2, classes=[2], folder=self.folder / "ground")
        (one,) = tessera.hag(str(CLOUD), self.folder / "one", ground=ground, format="laz")
        (other,) = tessera.hag([CLOUD], self.folder / "other", ground=self.folder / "ground", format="laz")
        self.assertEqual(one.output, self.folder / "one" / "pdal_mvk_thin.laz")
        self.assertEqual(one.output.read_bytes(), other.output.read_bytes())
        again = tessera.triangulate(one.output, 2, attributes=["HeightAboveGround"])
        self.assertIn("HeightAboveGround", again[0].attributes)

    def test_wrong_arguments_are_named_in_pythons_words(self):
        out = self.folder / "out"
        for wrong, says in (({"format": "copc"}, "^format: 'copc' is not a format"), ({"outside": float("nan")}, "^outside: must be finite"),
                            ({"ground_class": 256}, "ground_class is 256"), ({"ground": out, "ground_class": 3}, "^ground_class: says of which"),
                            ({"threads": 0}, "threads is 0")):
            with self.assertRaisesRegex(tessera.UsageError, says):
                tessera.hag(CLOUD, out, **wrong)
        with self.assertRaisesRegex(tessera.UsageError, "takes a path"):
            tessera.hag(7, out)
        self.assertFalse(out.exists())
        tessera.hag(CLOUD, out)
        with self.assertRaisesRegex(tessera.UsageError, "exists already; overwrite=True replaces it"):
            tessera.hag(CLOUD, out)
        with self.assertRaisesRegex(tessera.BadInputError, "already have a dimension 'HeightAboveGround'"):
            tessera.hag(out / CLOUD.name, self.folder / "twice")
        tessera.hag(CLOUD, out, overwrite=True)
        with self.assertRaises(tessera.Error):
            tessera.hag(CLOUD, self.folder / "none", ground_class=77)
        self.assertEqual(list((self.folder / "none").iterdir()), [])


if __name__ == "__main__":
    unittest.main()
