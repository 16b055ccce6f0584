"""tessera.triangulate(): tiles, files, options and failures."""
import gc
import os
import pathlib
import resource
import shutil
import struct
import subprocess
import sys
import tempfile
import unittest

import numpy as np
import tessera

import clouds

IGN = pathlib.Path(os.environ["IGN"])
FORMAT_2 = pathlib.Path(__file__).parents[1] / "data" / "format-2"


class FolderTest(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="tessera-python-"))
        self.addCleanup(shutil.rmtree, self.folder, True)
        # Temporary results go here too, so that a test can see them go.
        self.addCleanup(os.environ.__setitem__, "TMPDIR", os.environ.get("TMPDIR", "/tmp"))
        os.environ["TMPDIR"] = str(self.folder)

    def left(self):
        gc.collect()
        return sorted(path.name for path in self.folder.iterdir())


class Tiles(FolderTest):
    def test_many_tiles_are_the_triangulation_in_one_piece(self):
        for points in (clouds.random(4000, 2), clouds.random(4000, 3), clouds.lattice(15, 3), clouds.lattice(60, 2)):
            whole = tessera.Delaunay(points)
            t = tessera.triangulate(points, max_points_per_tile=600)
            self.assertGreater(len(t), 5)
            self.assertEqual(clouds.simplex_set(t.simplices()), clouds.simplex_set(whole.simplices))
            self.assertEqual((t.n_points, t.n_vertices, t.n_duplicates, t.n_cells, t.dim),
                             (len(points), len(points), 0, whole.nsimplex, points.shape[1]))
            np.testing.assert_array_equal(t.points(), points)
            self.assertRegex(t.digest, "^[0-9a-f]{32}$")
            self.assertEqual(t.digest, tessera.triangulate(points, max_points_per_tile=1500).digest)
            self.assertNotEqual(t.digest, tessera.triangulate(points[::-1], max_points_per_tile=600).digest)

    def test_arrays_of_a_tile_have_the_documented_shapes_and_types(self):
        for dim in (2, 3):
            points = clouds.random(2000, dim)
            t = tessera.triangulate(points, max_points_per_tile=400)
            for tile in t:
                n, m = len(tile.points), len(tile.cells)
                self.assertEqual(tile.dim, dim)
                for array, shape, dtype in ((tile.points, (n, dim), float), (tile.ids, (n,), np.int64),
                                            (tile.foreign, (n,), bool), (tile.cells, (m, dim + 1), np.int32),
                                            (tile.ghost, (m,), bool), (tile.neighbors, (m, dim + 1), np.int32)):
                    self.assertEqual((array.shape, array.dtype), (shape, np.dtype(dtype)))
                    self.assertFalse(array.flags.writeable or array.flags.owndata)
                np.testing.assert_array_equal(tile.points, points[tile.ids])
                self.assertEqual(tile.attributes, {})
                self.assertTrue((~tile.foreign[tile.cells]).any(axis=1).all(), "a cell has a vertex of its tile's own")
            self.assertEqual(sum((~tile.foreign).sum() for tile in t), 2000)
            self.assertEqual(len({tile.id for tile in t}), len(t))

    def test_neighbors_share_the_facet_opposite_the_vertex(self):
        for tile in tessera.triangulate(clouds.random(2000, 3), max_points_per_tile=500):
            cells = tile.cells.tolist()
            for i, across in enumerate(tile.neighbors.tolist()):
                for k, j in enumerate(across):
                    if j >= 0:
                        self.assertLess(set(cells[i]) - {cells[i][k]}, set(cells[j]))

    def test_neighbors_may_be_left_out(self):
        t = tessera.triangulate(clouds.random(500, 2), neighbors=False)
        self.assertIsNone(t[0].neighbors)

    def test_it_is_a_sequence_of_tiles(self):
        t = tessera.triangulate(clouds.random(2000, 2), max_points_per_tile=300)
        ids = [tile.id for tile in t]
        self.assertEqual([t[i].id for i in range(-len(t), 0)], ids)
        for index in (len(t), -len(t) - 1):
            with self.assertRaises(IndexError):
                t[index]
        self.assertIn("2000 points", repr(t))
        self.assertIn("triangles", repr(t[0]))

    def test_arrays_outlive_tile_triangulation_and_folder(self):
        points = clouds.random(5000, 3)
        t = tessera.triangulate(points, max_points_per_tile=1000)
        tile = t[2]
        arrays = tile.points, tile.ids, tile.cells, tile.neighbors, tile.foreign, tile.ghost
        copies = [array.copy() for array in arrays]
        del t, tile
        self.assertEqual(self.left(), [], "the temporary folder is gone")
        filler = [np.full(100000, 7) for _ in range(50)]
        for array, copy in zip(arrays, copies):
            np.testing.assert_array_equal(array, copy)
        del filler

    def test_duplicates_are_counted_and_have_no_row_in_points(self):
        points = clouds.random(1000, 3)
        points[[5, 999]] = points[0]
        t = tessera.triangulate(points, max_points_per_tile=200)
        self.assertEqual((t.n_points, t.n_vertices, t.n_duplicates), (1000, 998, 2))
        self.assertEqual(np.flatnonzero(np.isnan(t.points()).any(axis=1)).tolist(), [5, 999])
        self.assertEqual(clouds.simplex_set(t.simplices()), clouds.simplex_set(tessera.Delaunay(points).simplices))

    def test_points_that_are_not_finite_can_be_left_out(self):
        points = clouds.random(300, 2)
        points[17, 1] = np.nan
        t = tessera.triangulate(points, skip_invalid=True)
        kept = np.delete(np.arange(300), 17)
        self.assertEqual(clouds.simplex_set(t.simplices()), clouds.simplex_set(kept[tessera.Delaunay(points[kept]).simplices]))


class Leaks(FolderTest):
    def held(self):
        gc.collect()
        return len(os.listdir("/proc/self/fd")), len(os.listdir("/proc/self/task"))

    def test_nothing_leaks(self):
        points = clouds.random(20_000, 3)

        def refuse(figures):
            raise StopIteration

        def work():
            t = tessera.triangulate(points, max_points_per_tile=8000)
            for tile in t:
                tile.points[0], tile.cells[0], tile.neighbors[0], tile.attributes
            with self.assertRaises(StopIteration):
                tessera.triangulate(points, progress=refuse)

        for _ in range(5):
            work()
        before, references = self.held(), sys.getrefcount(points)
        peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
        for _ in range(30):
            work()
        self.assertEqual((self.held(), sys.getrefcount(points), self.left()), (before, references, []))
        # The tiles of one triangulation are some 8 MB; 30 of them would be 240.
        self.assertLess(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - peak, 80_000)


class Folders(FolderTest):
    def test_a_folder_stays_and_is_opened_again(self):
        out = self.folder / "out"
        t = tessera.triangulate(clouds.random(1000, 3), folder=out, max_points_per_tile=300)
        self.assertEqual(t.folder, out)
        simplices = t.simplices()
        del t
        for path in (out, str(out)):
            again = tessera.open(path)
            np.testing.assert_array_equal(again.simplices(), simplices)

    def test_an_older_version_is_opened_by_its_number(self):
        out = self.folder / "out"
        t = tessera.triangulate(clouds.random(400, 2), folder=out, max_points_per_tile=100)
        t.measure(volume=True)
        old, new = tessera.open(out, version=1), tessera.open(out, version=2)
        self.assertEqual((list(old.columns), list(new.columns)), ([], ["area", "star_area"]))
        self.assertEqual((old.digest, new.digest), (t.digest, t.digest))
        old.verify()  # reads the files of its own version
        np.testing.assert_array_equal(old.simplices(), new.simplices())
        with self.assertRaisesRegex(tessera.UsageError, "version 3 does not exist; the versions 1 and 2 can be read"):
            tessera.open(out, version=3)
        with self.assertRaisesRegex(tessera.UsageError, "only the newest version can be changed"):
            old.measure(quality=True)

    def test_a_result_of_format_2_is_read_like_any_other(self):
        t = tessera.open(FORMAT_2)
        rows = np.loadtxt(FORMAT_2 / "points.csv", delimiter=",", skiprows=1)
        self.assertEqual((t.dim, t.n_points, t.n_vertices, t.n_duplicates, len(t)), (3, 63, 60, 3, 3))
        self.assertEqual((t.digest, t.crs), ("2c1eac041169f8f623275175d287a87b", ""))  # as its manifest says
        for tile in t:
            np.testing.assert_array_equal(tile.points, rows[tile.ids, :3])
            np.testing.assert_array_equal(tile.attributes["intensity"], rows[tile.ids, 3])
            self.assertEqual(tile.neighbors.shape, tile.cells.shape)
            self.assertTrue((~tile.foreign[tile.cells]).any(axis=1).all())
        self.assertEqual(sum((~tile.foreign).sum() for tile in t), 60)
        vertices = ~np.isnan(t.points()).any(axis=1)
        np.testing.assert_array_equal(t.points()[vertices], rows[vertices, :3])
        whole = tessera.Delaunay(rows[:, :3])
        self.assertEqual(len(t.simplices()), t.n_cells)
        self.assertEqual(clouds.simplex_set(t.simplices()), clouds.simplex_set(whole.simplices))
        t.export(self.folder / "mesh.ply")
        self.assertTrue((self.folder / "mesh.ply").exists())

    def test_a_result_is_only_replaced_when_asked(self):
        out = self.folder / "out"
        tessera.triangulate(clouds.random(100, 2), folder=out)
        with self.assertRaises(tessera.UsageError):
            tessera.triangulate(clouds.random(200, 2), folder=out)
        self.assertEqual(tessera.open(out).n_points, 100)
        tessera.triangulate(clouds.random(200, 2), folder=out, overwrite=True)
        self.assertEqual(tessera.open(out).n_points, 200)

    def test_temporary_results_go_with_their_last_reference(self):
        t = tessera.triangulate(clouds.random(100, 2))
        self.assertEqual([str(t.folder.relative_to(self.folder))], self.left())
        self.assertTrue(t.folder.is_dir())
        del t
        self.assertEqual(self.left(), [])

    def test_temporary_results_go_at_exit_too(self):
        code = "import tessera; t = tessera.triangulate([[0, 0], [1, 0], [0, 1]]); print(t.n_cells)"
        done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=120)
        self.assertEqual((done.stdout, done.stderr), ("1\n", ""))
        self.assertEqual(self.left(), [])

    def test_failures_are_typed_and_leave_nothing(self):
        (self.folder / "bad.las").write_bytes(b"LASF" + bytes(300))
        (self.folder / "broken").mkdir()
        (self.folder / "broken" / "manifest.json").write_text("{")
        before = self.left()
        grid = clouds.lattice(9, 3)
        for kind, builtin, cause, call in (
                (tessera.IoError, OSError, "io", lambda: tessera.triangulate(self.folder / "none.las")),
                (tessera.IoError, OSError, "io", lambda: tessera.open(self.folder / "none")),
                (tessera.BadInputError, ValueError, "bad_input", lambda: tessera.triangulate(self.folder / "bad.las")),
                (tessera.BadInputError, ValueError, "bad_input", lambda: tessera.triangulate([[0, 0, 0]] * 9)),
                (tessera.CorruptError, Exception, "corrupt", lambda: tessera.open(self.folder / "broken")),
                (tessera.MemoryLimitError, MemoryError, "memory", lambda: tessera.triangulate(grid, memory="1M"))):
            with self.assertRaises(kind) as caught:
                call()
            self.assertIsInstance(caught.exception, tessera.Error)
            self.assertIsInstance(caught.exception, builtin)
            self.assertEqual(caught.exception.cause, cause)
            self.assertGreater(len(str(caught.exception).split()), 3, "a sentence")
            self.assertEqual(self.left(), before)

    def test_arguments_that_make_no_sense_are_refused(self):
        points = clouds.random(10, 3)
        for wrong in ({"dim": 4}, {"max_points_per_tile": 0}, {"max_points_per_tile": 1.5}, {"threads": -1},
                      {"threads": 100000}, {"memory": "4X"}, {"memory": 0}, {"attributes": ["intensity"]}, {"folder": ""},
                      {"progress": 3}):
            with self.subTest(wrong), self.assertRaises(tessera.UsageError):
                tessera.triangulate(points, **wrong)
        self.assertEqual(self.left(), [])

    def test_memory_is_given_in_bytes_or_like_4g(self):
        for memory in (2**30, "1073741824", "1024M", "1G", "1.5G", np.int64(2**30)):
            self.assertEqual(tessera.triangulate(clouds.random(50, 3), memory=memory, threads=1).n_points, 50)


class Files(FolderTest):
    def test_a_las_file_with_attributes(self):
        path = IGN / "ign_77050_627755.las"
        data = path.read_bytes()
        offset, = struct.unpack_from("<I", data, 96)
        size, count = struct.unpack_from("<HI", data, 105)
        records = np.frombuffer(data, f"V{size}", count=count, offset=offset)
        raw = np.frombuffer(records.tobytes(), np.uint8).reshape(count, size)
        scale, shift = np.array(struct.unpack_from("<6d", data, 131)).reshape(2, 3)
        xyz = raw[:, :12].copy().view(np.int32) * scale + shift
        intensity = raw[:, 12:14].copy().view(np.uint16)[:, 0]

        for source in (path, str(path), [path], (str(path),)):
            t = tessera.triangulate(source, dim=2, attributes=["intensity", "classification"], max_points_per_tile=5000)
            self.assertEqual((t.dim, t.n_points), (2, count))
            self.assertGreater(len(t), 2)
            for tile in t:
                self.assertEqual(set(tile.attributes) & {"intensity", "classification"}, {"intensity", "classification"})
                np.testing.assert_array_equal(tile.attributes["intensity"], intensity[tile.ids])
                self.assertEqual(tile.attributes["intensity"].dtype, np.uint16)
                np.testing.assert_allclose(tile.points, xyz[tile.ids, :2], rtol=0, atol=1e-6)
        values = tile.attributes["intensity"]
        copied = values.copy()
        del tile, t
        gc.collect()
        np.testing.assert_array_equal(values, copied)

    def test_several_files_and_patterns_make_one_cloud(self):
        paths = sorted(IGN.glob("*.las"))
        one = tessera.triangulate(paths[:2], dim=2)
        self.assertEqual(one.n_points, sum(tessera.triangulate(path, dim=2).n_points for path in paths[:2]))
        every = tessera.triangulate(str(IGN / "*.las"), dim=2)
        self.assertEqual(every.n_points, tessera.triangulate(paths, dim=2).n_points)

    def test_files_decide_their_dimension(self):
        for dim in (2, 3):
            points = clouds.random(200, dim)
            path = self.folder / f"cloud{dim}.xyz"
            np.savetxt(path, points, fmt="%.17g")
            t = tessera.triangulate(path)
            self.assertEqual(t.dim, dim)
            np.testing.assert_array_equal(t.points(), points)

    def test_names_need_not_be_utf_8(self):
        path = os.fsdecode(os.path.join(os.fsencode(self.folder), b"caf\xe9.xyz"))
        np.savetxt(path, clouds.random(50, 3))
        self.assertEqual(tessera.triangulate(path).n_points, 50)
        os.remove(path)
        with self.assertRaises(tessera.IoError) as caught:
            tessera.triangulate(path)
        self.assertIn("caf\udce9.xyz", str(caught.exception))

    def test_export_writes_what_numpy_and_others_read(self):
        t = tessera.triangulate(clouds.random(900, 3), max_points_per_tile=200)
        t.export(self.folder / "mesh.ply")
        self.assertTrue((self.folder / "mesh.ply").read_bytes().startswith(b"ply\nformat binary_little_endian"))
        t.export(self.folder / "arrays", format="npy")
        cells = np.load(self.folder / "arrays" / "cells.npy")
        ids = np.load(self.folder / "arrays" / "ids.npy")
        self.assertEqual(clouds.simplex_set(ids[cells]), clouds.simplex_set(t.simplices()))
        with self.assertRaisesRegex(tessera.UsageError, "mesh.ply: exists already; overwrite=True replaces it"):
            t.export(self.folder / "mesh.ply")
        t.export(self.folder / "mesh.ply", overwrite=True)
        with self.assertRaisesRegex(tessera.UsageError, "obj has no tetrahedra"):
            t.export(self.folder / "mesh.obj")

    def test_export_leaves_long_cells_out(self):
        points = clouds.random(900, 2)
        t = tessera.triangulate(points, max_points_per_tile=200)
        t.export(self.folder / "arrays", format="npy", max_edge=0.05)
        cells = np.load(self.folder / "arrays" / "ids.npy")[np.load(self.folder / "arrays" / "cells.npy")]
        corners = points[t.simplices()]
        longest = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max(axis=1)
        self.assertEqual(clouds.simplex_set(cells), clouds.simplex_set(t.simplices()[longest <= 0.05]))
        self.assertLess(len(cells), t.n_cells)
        for wrong in (0, -1.5, float("nan"), float("inf")):
            with self.assertRaisesRegex(tessera.UsageError, "^max_edge: must be a length, finite and above 0"):
                t.export(self.folder / "mesh.ply", max_edge=wrong)
        with self.assertRaisesRegex(tessera.UsageError, "no cell is left.*; give at least .* as max_edge"):
            t.export(self.folder / "mesh.ply", max_edge=1e-9)

    def test_export_warns_of_what_the_format_could_not_keep(self):
        t = tessera.triangulate(clouds.random(50, 2))
        with self.assertWarnsRegex(UserWarning, "coordinate system"):
            t.export(self.folder / "map.csv")

    def test_the_crs_is_the_files(self):
        self.assertIsInstance(tessera.triangulate(IGN / "ign_77050_627755.las", dim=2).crs, str)
        self.assertEqual(tessera.triangulate(clouds.random(10, 2)).crs, "")


if __name__ == "__main__":
    unittest.main()
