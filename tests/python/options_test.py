"""What the command can be asked for, asked for in Python: options, info(), verify()."""
import json
import os
import pathlib
import shutil
import subprocess
import tempfile
import unittest
import warnings

import numpy as np
import tessera

import clouds

ROOT = pathlib.Path(__file__).resolve().parents[2]
IGN = pathlib.Path(os.environ["IGN"])
COMMAND = os.environ["TESSERA"]


def told(*arguments):
    done = subprocess.run([COMMAND, *map(str, arguments)], capture_output=True, text=True, check=True)
    return json.loads(done.stdout)


class Options(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="tessera-python-"))
        self.addCleanup(shutil.rmtree, self.folder)

    def test_the_same_options_give_the_digest_of_the_command(self):
        for number, (arguments, flags) in enumerate((
                (dict(dim=2, classes=[2], attributes=["intensity"]), "--dim 2 --class 2 --attributes intensity"),
                (dict(crop=[770550, 6277550, 770570, 6277570], tiles=3, partition="grid"),
                 "--crop 770550,6277550,770570,6277570 --tiles 3 --partition grid"),
                (dict(dim=2, heights=False, crs="EPSG:2154"), "--dim 2 --no-z --crs EPSG:2154"))):
            out = self.folder / str(number)
            subprocess.run([COMMAND, "triangulate", IGN, "-o", out, *flags.split(), "--quiet"], check=True)
            t = tessera.triangulate(IGN, **arguments)
            theirs = told("info", out, "--json")
            self.assertGreater(t.n_vertices, 100)
            mine = t.info()
            for key in ("digest", "vertices", "filtered", "crs", "attributes", "partition"):
                self.assertEqual(mine[key], theirs[key], key)

    def test_info_is_that_of_the_command(self):
        files = sorted(map(str, IGN.glob("*.las")))
        mine = tessera.info(files, dim=2, threads=2, memory="1G", classes=[2, 9])
        theirs = told("info", *files, "--dim", 2, "--threads", 2, "--memory", "1G", "--class", "2,9", "--json")
        self.assertEqual(mine, theirs)
        self.assertEqual(len(mine["files"]), 4)
        t = tessera.triangulate(clouds.random(100, 2), folder=self.folder / "out")
        self.assertEqual(tessera.info(self.folder / "out"), t.info())
        with self.assertRaises(tessera.UsageError):
            tessera.info(np.zeros((3, 2)))
        with self.assertRaises(tessera.IoError):
            tessera.info("/nowhere.las")

    def test_verify_proves_a_result_or_tells_what_is_wrong(self):
        t = tessera.triangulate(clouds.lattice(9, 3), max_points_per_tile=100, folder=self.folder / "out")
        proof = t.verify(memory="100M", scratch=self.folder, against_cgal=True)
        self.assertEqual((proof.cells, proof.vertices), (t.n_cells, t.n_vertices))
        self.assertTrue(any("CGAL" in line for line in proof.checks), proof.checks)
        # Two tiles of another triangulation, of the same shape.
        other = tessera.triangulate(clouds.lattice(9, 3) * 2, max_points_per_tile=100, folder=self.folder / "other")
        shutil.copytree(other.folder / "tiles", t.folder / "tiles", dirs_exist_ok=True)
        with self.assertRaises((tessera.CorruptError, tessera.NotDelaunayError)):
            t.verify()

    def test_an_interrupted_run_of_files_is_resumed(self):
        np.save(self.folder / "cloud.npy", clouds.random(400_000, 3))  # longer at work than two looks at it are apart
        out, job = self.folder / "out", dict(max_points_per_tile=20_000, threads=2)

        def interrupt(progress):
            if progress.tiles_triangulated > 0:
                raise KeyboardInterrupt

        with self.assertRaises(KeyboardInterrupt):
            tessera.triangulate(self.folder / "cloud.npy", folder=out, resume=True, progress=interrupt, **job)
        with self.assertRaisesRegex(tessera.UsageError, "resume=True"):
            tessera.triangulate(self.folder / "cloud.npy", folder=out, **job)
        t = tessera.triangulate(self.folder / "cloud.npy", folder=out, resume=True, **job)
        self.assertEqual(t.digest, tessera.triangulate(self.folder / "cloud.npy", **job).digest)

    def test_inputs_come_from_lists_and_arrays_of_names(self):
        np.savetxt(self.folder / "a.xyz", clouds.random(40, 3))
        np.savetxt(self.folder / "b.xyz", clouds.random(30, 3, 2))
        (self.folder / "list.txt").write_text("a.xyz\nb.xyz\n")
        names = [str(self.folder / name) for name in ("a.xyz", "b.xyz")]
        digest = tessera.triangulate(names).digest
        self.assertEqual(tessera.triangulate(input_list=self.folder / "list.txt").digest, digest)
        self.assertEqual(tessera.triangulate(np.array(names)).digest, digest)
        self.assertEqual(tessera.triangulate(np.array(names, object)).digest, digest)

    def test_what_is_doubtful_in_files_is_a_warning_where_it_was_asked(self):
        (self.folder / "plain.xyz").write_text("770560 6277560 1\n")
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            tessera.triangulate([IGN, self.folder / "plain.xyz"], dim=2)
        self.assertEqual(len(caught), 1)
        self.assertIn("plain.xyz", str(caught[0].message))
        self.assertEqual(caught[0].filename, __file__)

    def test_columns_of_text_have_the_names_that_are_given(self):
        (self.folder / "survey.txt").write_text("".join(f"{i},{600 + i * i % 17},{500 + i ** 3 % 23},{i % 3},GND\n" for i in range(40)))
        with self.assertWarnsRegex(UserWarning, "counts up by one .* by the option columns"):
            tessera.triangulate(self.folder / "survey.txt", dim=2)
        for columns in ("p,y,x,z", ["p", "y", "x", "z"]):
            t = tessera.triangulate(self.folder / "survey.txt", dim=2, columns=columns, attributes=["p"])
            self.assertEqual(t.info()["bounds"]["min"][:2], [500, 600])
            tile = t[0]
            np.testing.assert_array_equal(tile.attributes["p"], tile.ids)
        self.assertEqual(tessera.info(self.folder / "survey.txt", columns="_,y,x")["files"][0]["columns"], {"x": 3, "y": 2, "by": "option"})
        with self.assertRaisesRegex(tessera.UsageError, "^columns: no column is called x"):
            tessera.triangulate(self.folder / "survey.txt", columns="p,y,z")

    def test_of_equal_points_in_2d_the_one_that_is_asked_for_is_kept(self):
        rng = np.random.default_rng(1)
        points = np.column_stack([rng.integers(0, 12, (2000, 2)), rng.integers(0, 9, 2000)]).astype(float)
        place = {}
        for i, (x, y, z) in enumerate(points):
            place.setdefault((x, y), []).append((z, i))
        right = {"first": lambda of: min(i for _, i in of), "last": lambda of: max(i for _, i in of),
                 "lowest": lambda of: min(of)[1], "highest": lambda of: min((-z, i) for z, i in of)[1]}
        for keep, choose in right.items():
            expected = sorted(choose(of) for of in place.values())
            others = sum(points[i, 2] != points[choose(of), 2] for of in place.values() for _, i in of)
            for tiles in (1, 5):
                t = tessera.triangulate(points, dim=2, keep=keep, tiles=tiles)
                self.assertEqual(sorted(np.concatenate([tile.ids[~tile.foreign] for tile in t])), expected)
                self.assertEqual((t.n_duplicates, t.n_duplicates_at_other_heights), (2000 - len(expected), others))
                heights = points[expected, 2]
                self.assertEqual(t.info()["heights"], {"min": heights.min(), "max": heights.max()})
                t.verify()
        self.assertIsNone(tessera.triangulate(points[:, :2]).n_duplicates_at_other_heights)

    def test_that_make_no_sense_are_refused_by_their_names(self):
        points = clouds.random(50, 3)
        for arguments, sentence in ((dict(crop=[1, 0, 0, 1]), "^crop: is an empty box"),
                                    (dict(crop=[1, 0]), "^crop: is not xmin"),
                                    (dict(classes=[2]), "^classes are for files: choose rows"),
                                    (dict(tiles=2, max_points_per_tile=9), "^tiles and max_points_per_tile contradict"),
                                    (dict(tiles=0), "^tiles is 0"),
                                    (dict(partition="hexagons"), "^partition: "),
                                    (dict(crs="nonsense"), "^crs: 'nonsense' is no file: the coordinate system is neither"),
                                    (dict(resolution=-1), "^resolution is -1"),
                                    (dict(columns="x,y"), "^columns are for files: choose and order"),
                                    (dict(keep="lowest"), "^keep='lowest': chooses among points of equal x and y"),
                                    (dict(dim=2, keep="both"), "^keep: 'both' is not one of"),
                                    (dict(resume=True), "^resume: ")):
            with self.subTest(**arguments), self.assertRaisesRegex(tessera.UsageError, sentence):
                tessera.triangulate(points, **arguments)
        with self.assertRaisesRegex(tessera.UsageError, "classes"):
            tessera.triangulate(IGN, classes=[256])


if __name__ == "__main__":
    unittest.main()
