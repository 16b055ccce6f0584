"""Arrow tables through the C data interface: tables of GDAL's, of tessera's own, and such as break the rules."""
import ctypes
import gc
import pathlib
import tempfile
import unittest

import numpy as np
import tessera
from osgeo import gdal
from tessera import _arrow_c

import clouds

gdal.UseExceptions()


class Table:
    """What hands over a stream, as tables of all packages do."""

    def __init__(self, capsule):
        self.capsule = capsule

    def __arrow_c_stream__(self, requested_schema=None):
        return self.capsule


class Given:
    """Columns, as a table of batches. `spoil` changes each batch's structures before they are handed over."""

    def __init__(self, *batches, spoil=None, fails=None):
        self.batches, self.spoil, self.fails = batches, spoil, fails

    def __arrow_c_stream__(self, requested_schema=None):
        def made():
            for batch in self.batches:
                yield {name: np.array(values) for name, values in batch.items()}
            if self.fails:
                raise RuntimeError(self.fails)
        return _arrow_c.stream_of({name: np.array(values)[:0] for name, values in self.batches[0].items()}, made())


def spoiled(table, change):
    """`table`, whose batches `change` has changed: it is called with the structure of each."""
    capsule = table.__arrow_c_stream__()
    stream = _arrow_c.Stream.from_address(_arrow_c._in_capsule(capsule, b"arrow_array_stream"))
    real = _arrow_c._GET(stream.get_next)

    @_arrow_c._GET
    def get_next(address, target):
        status = real(address, target)
        batch = _arrow_c.Array.from_address(target)
        if batch.release:
            change(batch)
        return status

    stream.get_next = ctypes.cast(get_next, ctypes.c_void_p)
    held = Table(capsule)
    held.function = get_next
    return held


def gdal_stream(path):
    """The table of a file, from GDAL, which is another producer, in C."""
    library = ctypes.CDLL("libgdal.so.32")
    for name, result, arguments in (("GDALAllRegister", None, []), ("GDALOpenEx", ctypes.c_void_p, [ctypes.c_char_p, ctypes.c_uint] + [ctypes.c_void_p] * 3),
                                    ("GDALDatasetGetLayer", ctypes.c_void_p, [ctypes.c_void_p, ctypes.c_int]),
                                    ("OGR_L_GetArrowStream", ctypes.c_bool, [ctypes.c_void_p] * 3)):
        getattr(library, name).restype, getattr(library, name).argtypes = result, arguments
    library.GDALAllRegister()
    options = (ctypes.c_char_p * 2)(b"AUTODETECT_TYPE=YES", None)
    dataset = library.GDALOpenEx(str(path).encode(), 4, None, options, None)
    layer = library.GDALDatasetGetLayer(dataset, 0)
    stream = _arrow_c.Stream()
    without_fid = (ctypes.c_char_p * 3)(b"INCLUDE_FID=NO", b"MAX_FEATURES_IN_BATCH=300", None)
    assert library.OGR_L_GetArrowStream(layer, ctypes.addressof(stream), without_fid)
    table = Table(_arrow_c._new_capsule(ctypes.addressof(stream), b"arrow_array_stream", None))
    table.stream = stream
    return table


def vertices(t):
    """The coordinates by id, and the attributes."""
    return t.points(), {name: np.concatenate([tile.attributes[name][~tile.foreign] for tile in t])[
        np.argsort(np.concatenate([tile.ids[~tile.foreign] for tile in t]))] for name in t[0].attributes}


class Arrow(unittest.TestCase):
    def tearDown(self):
        gc.collect()
        self.assertEqual((_arrow_c._kept, _arrow_c._streams), ({}, {}), "something was not released")

    def refused(self, sentence, table, **options):
        with self.assertRaisesRegex(tessera.UsageError, sentence):
            tessera.from_arrow(table, **options)

    def test_structures_have_the_sizes_that_arrow_says(self):
        self.assertEqual([ctypes.sizeof(each) for each in (_arrow_c.Schema, _arrow_c.Array, _arrow_c.Stream)], [72, 80, 40])

    def test_a_table_of_gdal_becomes_points_and_attributes(self):
        points = clouds.random(1000, 3)
        with tempfile.TemporaryDirectory(prefix="tessera-arrow-") as folder:
            path = pathlib.Path(folder) / "points.csv"
            path.write_text("x,y,z,kind\n" + "".join(f"{x!r},{y!r},{z!r},{i % 7}\n" for i, (x, y, z) in enumerate(points.tolist())))
            t = tessera.from_arrow(gdal_stream(path))
        self.assertEqual(t.digest, tessera.triangulate(points).digest)
        read, attributes = vertices(t)
        np.testing.assert_array_equal(read, points)
        np.testing.assert_array_equal(attributes["kind"], np.arange(1000) % 7)

    def test_a_triangulation_is_a_table_of_its_vertices(self):
        for dimension in (2, 3):
            points = clouds.random(2000, dimension)
            given = {"mass": np.arange(2000, dtype=np.float32), "kind": (np.arange(2000) % 200).astype(np.uint8)}
            t = tessera.triangulate(points, max_points_per_tile=300, attributes=given)
            self.assertGreater(len(t), 3)
            batches = list(_arrow_c.batches(t))
            self.assertEqual(len(batches), len(t))
            joined = {name: np.concatenate([batch[name] for batch in batches]) for name in batches[0]}
            self.assertEqual([*joined][:dimension] + [[*joined][-1]], [*"xyz"[:dimension], "id"])
            order = np.argsort(joined["id"])
            for i, axis in enumerate("xyz"[:dimension]):
                np.testing.assert_array_equal(joined[axis][order], points[:, i])
            for name, values in given.items():
                self.assertEqual(joined[name].dtype, values.dtype)
                np.testing.assert_array_equal(joined[name][order], values)

    def test_a_stream_that_nobody_reads_or_that_is_read_in_part_is_released(self):
        t = tessera.triangulate(clouds.random(500, 3), max_points_per_tile=100)
        t.__arrow_c_stream__()
        reading = _arrow_c.batches(t)
        next(reading)
        self.assertTrue(_arrow_c._kept)
        reading.close()

    def test_a_column_that_was_taken_out_outlives_its_batch(self):
        capsule = tessera.triangulate([[0, 0], [1, 0], [0, 1]]).__arrow_c_stream__()
        address = _arrow_c._in_capsule(capsule, b"arrow_array_stream")
        batch, column = _arrow_c.Array(), _arrow_c.Array()
        _arrow_c._ask(_arrow_c.Stream.from_address(address), address, _arrow_c.Stream.from_address(address).get_next, batch)
        first = batch.children[0].contents
        ctypes.memmove(ctypes.addressof(column), ctypes.addressof(first), ctypes.sizeof(column))
        first.release = None
        _arrow_c.release(batch)
        gc.collect()
        values = np.frombuffer((ctypes.c_char * 24).from_address(column.buffers[1])).copy()
        self.assertEqual(sorted(values), [0, 0, 1])
        _arrow_c.release(column)

    def test_types_and_rows_are_kept_in_all_batches(self):
        types = ["i1", "u1", "i2", "u2", "i4", "u4", "i8", "u8", "f4", "f8"]
        rows = clouds.random(40, 2)
        parts = [{"x": rows[a:b, 0], "y": rows[a:b, 1], **{kind: np.arange(a, b).astype(kind) for kind in types}} for a, b in ((0, 7), (7, 7), (7, 40))]
        read, attributes = vertices(tessera.from_arrow(Given(*parts)))
        np.testing.assert_array_equal(read, rows)
        for kind in types:
            self.assertEqual(attributes[kind].dtype, np.dtype(kind))
            np.testing.assert_array_equal(attributes[kind], np.arange(40))

    def test_offsets_choose_rows(self):
        def from_the_third_row(batch):
            batch.offset, batch.length = 1, batch.length - 2
            for i in range(batch.n_children):
                batch.children[i].contents.offset, batch.children[i].contents.length = 1, batch.children[i].contents.length - 1

        rows = clouds.random(50, 2)
        t = tessera.from_arrow(spoiled(Given({"x": rows[:, 0], "y": rows[:, 1]}), from_the_third_row))
        np.testing.assert_array_equal(t.points(), rows[2:])

    def test_z_is_the_third_coordinate_or_the_height(self):
        rows = clouds.random(60, 3)
        table = Given({"z": rows[:, 2], "y": rows[:, 1], "x": rows[:, 0], "id": np.arange(60)})
        self.assertEqual(tessera.from_arrow(table).digest, tessera.triangulate(rows).digest)
        np.testing.assert_array_equal(vertices(tessera.from_arrow(table, dim=2))[1]["z"], rows[:, 2])

    def test_bits_are_bool(self):
        def as_bits(batch):
            bits = (ctypes.c_uint8 * 2)(0b01100101, 0b10)
            keep.append(bits)
            batch.children[2].contents.buffers[1] = ctypes.addressof(bits)

        keep = []
        rows = clouds.random(10, 2)
        table = spoiled(Given({"x": rows[:, 0], "y": rows[:, 1], "flag": np.zeros(10, np.uint8)}), as_bits)
        stream = _arrow_c.Stream.from_address(_arrow_c._in_capsule(table.capsule, b"arrow_array_stream"))
        real = _arrow_c._GET(stream.get_schema)

        @_arrow_c._GET
        def get_schema(address, target):
            status = real(address, target)
            _arrow_c.Schema.from_address(target).children[2].contents.format = b"b"
            return status

        stream.get_schema = ctypes.cast(get_schema, ctypes.c_void_p)
        self.assertEqual(vertices(tessera.from_arrow(table))[1]["flag"].tolist(), [1, 0, 1, 0, 0, 1, 1, 0, 0, 1])

    def test_nulls_are_refused_with_their_row(self):
        def null_in_y(batch):
            bits = (ctypes.c_uint8 * 2)(0xff, 0b01)
            keep.append(bits)
            batch.children[1].contents.buffers[0], batch.children[1].contents.null_count = ctypes.addressof(bits), -1

        keep = []
        rows = clouds.random(10, 2)
        self.refused("^column 'y' is null \\(row 9 of a batch, and 0 others\\): leave those rows out$",
                     spoiled(Given({"x": rows[:, 0], "y": rows[:, 1]}), null_in_y))

    def test_what_breaks_the_rules_is_refused(self):
        rows = {"x": [0.0, 1, 0], "y": [0.0, 0, 1]}
        self.refused("^table is of the type dict: it must be an Arrow table", rows)
        self.refused("^the Arrow table has the columns x, w: it must have x and y", Given({"x": [1.0], "w": [1.0]}))
        self.refused("^the Arrow stream cannot be read: the disk is gone$", Given(rows, fails="the disk is gone"))
        self.refused("^attributes of an Arrow table are its columns", Given(rows), attributes=["kind"])
        self.refused("which no float64 equals exactly", Given({"x": np.array([2**53 + 1, 0, 1]), "y": np.array([0, 1, 1])}))

        def short(batch):
            batch.children[1].contents.length = 2

        def one_column(batch):
            batch.n_children = 1

        def empty(batch):
            batch.children[0].contents.buffers[1] = None

        self.refused("^column 'y' of the Arrow stream has 2 values in 2 buffers, for 3 rows", spoiled(Given(rows), short))
        self.refused("^column 'x' of the Arrow stream has no values$", spoiled(Given(rows), empty))
        # A producer that has lost a column does not release it.
        self.refused("^a batch of the Arrow stream has 1 columns: its schema has 2$", spoiled(Given(rows), one_column))
        for number in [number for number, kept in _arrow_c._kept.items()]:
            del _arrow_c._kept[number]


class Interface(unittest.TestCase):
    def test_numpy_takes_grids_as_their_values_and_points_from_anything_with_the_interface(self):
        points = clouds.random(300, 2)
        given = type("Given", (), {"__array_interface__": points.__array_interface__})()
        t = tessera.triangulate(given, attributes={"z": points[:, 0]})
        self.assertEqual(t.digest, tessera.triangulate(points).digest)
        raster, density = t.dem(res=0.1), t.density(res=0.1)
        np.testing.assert_array_equal(np.asarray(raster), raster.values)
        np.testing.assert_array_equal(np.asarray(density), density.values)


if __name__ == "__main__":
    unittest.main()
