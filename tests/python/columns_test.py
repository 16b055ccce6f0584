"""tessera.triangulate() of arrays with heights and further columns, and of the .npy files that they would be."""
import subprocess
import os

import numpy as np
import tessera

import clouds
from triangulation_test import FolderTest


def values_of(t, name, n):
    """The attribute `name` by rank in the input, n values."""
    values = {}
    for tile in t:
        values.update(zip(tile.ids.tolist(), tile.attributes[name].tolist()))
    return [values[i] for i in range(n)]


class Heights(FolderTest):
    def test_an_array_of_three_columns_makes_the_terrain_that_its_file_makes(self):
        points = clouds.random(3000, 3)
        np.save(self.folder / "points.npy", points)
        t = tessera.triangulate(points, dim=2, max_points_per_tile=500)
        of_file = tessera.triangulate(self.folder / "points.npy", dim=2, max_points_per_tile=500)
        self.assertEqual((t.dim, t.digest), (2, of_file.digest))
        self.assertEqual(values_of(t, "z", 3000), points[:, 2].tolist())
        np.testing.assert_array_equal(t.dem(res=0.1).values, of_file.dem(res=0.1).values)
        np.testing.assert_array_equal(t.interpolate(points[:, :2]), points[:, 2])
        flat = tessera.triangulate(points, dim=2, heights=False)
        self.assertEqual((flat.digest, flat[0].attributes), (tessera.triangulate(points[:, :2]).digest, {}))

    def test_heights_beside_two_columns_are_the_same(self):
        points = clouds.random(500, 3)
        t = tessera.triangulate(points[:, :2], attributes={"z": points[:, 2]})
        self.assertEqual((t.dim, t.digest), (2, tessera.triangulate(points, dim=2).digest))
        np.testing.assert_array_equal(t.interpolate(points[:, :2]), points[:, 2])

    def test_what_files_refuse_is_refused(self):
        points = clouds.random(500, 3)
        points[17, 1] = np.nan
        with self.assertRaisesRegex(tessera.BadInputError, "^the array, row 17: y is nan"):
            tessera.triangulate(points, dim=2)
        self.assertEqual(tessera.triangulate(points, dim=2, skip_invalid=True).n_vertices, 499)
        with self.assertRaises(tessera.BadInputError):
            tessera.triangulate(np.empty((0, 3)), dim=2)
        with self.assertRaisesRegex(tessera.UsageError, "^dim is 3, but points have 2 columns: x and y alone are triangulated in 2D$"):
            tessera.triangulate(points[:, :2], dim=3)


class Attributes(FolderTest):
    def test_columns_keep_their_types_and_bits(self):
        random = np.random.default_rng(3)
        for dim in (2, 3):
            points = random.random((2000, dim))
            columns = {kind: random.integers(0, 100, 2000).astype(kind)
                       for kind in ("uint8", "int8", "uint16", "int16", "uint32", "int32", "uint64", "int64", "float32", "float64")}
            columns["big endian"] = random.random(2000).astype(">f8")
            columns["every second"] = random.random(4000)[::2]
            columns["ρ"] = random.random(2000)
            columns["hit"] = random.random(2000) > 0.5
            columns["list"] = list(range(2000))
            columns["int64"][5] = 2**60 + 1
            t = tessera.triangulate(points, attributes=columns, max_points_per_tile=500)
            self.assertEqual(t.digest, tessera.triangulate(points).digest)
            for name, values in columns.items():
                with self.subTest(name):
                    self.assertEqual(values_of(t, name, 2000), np.asarray(values).tolist())
                    kept = {"hit": np.uint8, "list": np.int64}.get(name, np.asarray(values).dtype.newbyteorder("="))
                    self.assertEqual(t[0].attributes[name].dtype, kept)
            np.testing.assert_array_equal(t.interpolate(points, value="ρ"), columns["ρ"])

    def test_a_data_frame_is_as_good(self):
        try:
            import pandas
        except ImportError:
            self.skipTest("python3-pandas is not there")
        points = clouds.random(300, 2)
        frame = pandas.DataFrame({"mass": np.arange(300.0), "kind": np.arange(300, dtype=np.int16)}, index=range(7, 307))
        t = tessera.triangulate(points, attributes=frame)
        self.assertEqual(values_of(t, "mass", 300), list(range(300)))
        self.assertEqual(t[0].attributes["kind"].dtype, np.int16)

    def test_what_cannot_be_kept_is_refused_by_its_name(self):
        points = clouds.random(50, 3)
        for attributes, sentence in (({"m": np.zeros(49)}, r"^attributes\['m'\] has the shape \(49,\): it must be \(50,\)"),
                                     ({"m": np.zeros((50, 2))}, r"^attributes\['m'\] has the shape \(50, 2\)"),
                                     ({"m": 1}, r"^attributes\['m'\] has the shape \(\)"),
                                     ({"m": np.zeros(50, complex)}, r"^attributes\['m'\] has the type complex128: it must be bool"),
                                     ({"m": np.zeros(50, np.float16)}, "has the type float16"),
                                     ({"m": ["a"] * 50}, "has the type <U1"),
                                     ({"m": np.ma.masked_equal(np.arange(50), 3)}, r"^attributes\['m'\] has masked entries"),
                                     ({"z": np.zeros(50)}, "^attributes: 'z' means something else"),
                                     ({"id": np.zeros(50)}, "^attributes: 'id' means something else"),
                                     ({"a/b": np.zeros(50)}, "^attributes: 'a/b' is no name"),
                                     ({"": np.zeros(50)}, "^attributes: '' is no name"),
                                     ({7: np.zeros(50)}, "^attributes: 7 is no name"),
                                     ({"é" * 33: np.zeros(50)}, "at most 64 bytes"),
                                     (["m"], "^attributes of an array must be columns"),
                                     ("all", "^attributes of an array must be columns")):
            with self.subTest(sentence), self.assertRaisesRegex(tessera.UsageError, sentence):
                tessera.triangulate(points, attributes=attributes)
        np.save(self.folder / "points.npy", points)
        with self.assertRaisesRegex(tessera.UsageError, "^attributes of files must be names"):
            tessera.triangulate(self.folder / "points.npy", attributes={"m": np.zeros(50)})
        self.assertEqual(self.left(), ["points.npy"])


class NpyFiles(FolderTest):
    def test_structured_arrays_are_points_with_attributes(self):
        rows = np.zeros(1000, np.dtype({"names": ["mass", "z", "y", "x"], "formats": ["<u2", ">f4", "<f8", "<f8"],
                                        "offsets": [0, 4, 8, 16], "itemsize": 28}))
        for i, name in enumerate(rows.dtype.names):
            rows[name] = np.random.default_rng(i).random(1000) * 1000
        np.save(self.folder / "rows.npy", rows)
        t = tessera.triangulate(self.folder / "rows.npy", attributes="all")
        points = np.column_stack([rows["x"], rows["y"], rows["z"]]).astype(float)
        self.assertEqual(t.digest, tessera.triangulate(points).digest)
        self.assertEqual(values_of(t, "mass", 1000), rows["mass"].tolist())
        self.assertEqual(t[0].attributes["mass"].dtype, np.uint16)
        said = subprocess.run([os.environ["TESSERA"], "info", self.folder / "rows.npy"], capture_output=True, text=True)
        self.assertRegex(said.stdout, r"NumPy, 4 named columns")
        self.assertRegex(said.stdout, r"attributes +mass")

    def test_further_columns_are_attributes(self):
        rows = np.random.default_rng(1).random((800, 5))
        np.save(self.folder / "rows.npy", rows)
        t = tessera.triangulate(self.folder / "rows.npy", dim=2, attributes=["column_5"])
        self.assertEqual(t.digest, tessera.triangulate(rows[:, :3], dim=2).digest)
        self.assertEqual(values_of(t, "column_5", 800), rows[:, 4].tolist())
        self.assertEqual(set(t[0].attributes), {"z", "column_5"})
