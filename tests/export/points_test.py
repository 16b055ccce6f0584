"""Tables of points in the order of the input: HDF5, FITS and NumPy, read back by h5py, astropy and NumPy."""
import json
import unittest

import numpy as np

from cli import CORRUPT, IO, USAGE
from stored import ExportTest

TYPES = [("a_u8", "u1"), ("a_i8", "i1"), ("a_u16", "<u2"), ("a_i16", "<i2"), ("a_u32", "<u4"), ("a_i32", "<i4"),
         ("a_f32", "<f4"), ("a_f64", "<f8")]


def cloud_of(n, dimension=3, seed=1, duplicates=0):
    """Points with an attribute of each type that NumPy files can have; the last ones repeat others."""
    rng = np.random.default_rng(seed)
    cloud = np.zeros(n, [(axis, "<f8") for axis in "xyz"[:dimension]] + TYPES)
    for axis in "xyz"[:dimension]:
        cloud[axis] = rng.random(n)
    for name, kind in TYPES:
        if kind[-2] == "f":
            cloud[name] = rng.normal(size=n)
        else:
            about = np.iinfo(kind)
            cloud[name] = rng.integers(about.min, about.max, n, endpoint=True, dtype=kind.strip("<"))
            cloud[name][:2] = about.min, about.max
    for i in range(duplicates):
        for axis in "xyz"[:dimension]:
            cloud[axis][n - 1 - i] = cloud[axis][i // 2]
    return cloud[np.random.default_rng(seed + 1).permutation(n)]


def by_h5py(path):
    import h5py
    with h5py.File(path) as file:
        group = file["PartType1"]
        table = {name: group[name][()] for name in group}
        units = {name: group[name].attrs["unit"] for name in group if "unit" in group[name].attrs}
        header = dict(file["Header"].attrs)
    table["id"] = table.pop("ParticleIDs")
    places = table.pop("Coordinates")
    table |= {axis: places[:, i] for i, axis in enumerate("xyz") if i < 2 or places[:, 2].any()}
    return table, units, header


def by_astropy(path):
    from astropy.io import fits
    with fits.open(path) as file:
        file.verify("exception")
        data, header = file[1].data, file[1].header
        table = {name: np.array(data[name]) for name in data.names}
        units = {name: header[f"TUNIT{i + 1}"] for i, name in enumerate(data.names) if f"TUNIT{i + 1}" in header}
        return table, units, dict(header)


def by_numpy(path):
    table = np.load(path)
    return {name: table[name] for name in table.dtype.names}, {}, {}


READERS = {"h5": by_h5py, "fits": by_astropy, "npy": by_numpy}


def own_fits(path):
    """A FITS table by the rules of the standard alone."""
    bytes_ = path.read_bytes()
    assert len(bytes_) % 2880 == 0
    at, headers = 0, []
    for _ in range(2):
        cards = {}
        while True:
            card, at = bytes_[at:at + 80].decode("ascii"), at + 80
            if card.startswith("END "):
                break
            if card[8:10] == "= ":
                cards[card[:8].strip()] = card[10:].split("/")[0].strip()
        at = -(-at // 2880) * 2880
        headers.append(cards)
    table = headers[1]
    kinds = {"B": "u1", "I": ">i2", "J": ">i4", "K": ">i8", "E": ">f4", "D": ">f8"}
    fields = [(table[f"TTYPE{i}"].strip("' "), kinds[table[f"TFORM{i}"].strip("' ")[1:]])
              for i in range(1, int(table["TFIELDS"]) + 1)]
    kind = np.dtype(fields)
    assert kind.itemsize == int(table["NAXIS1"])
    rows = np.frombuffer(bytes_, kind, int(table["NAXIS2"]), at)
    return {name: [int(v) + int(table.get(f"TZERO{i + 1}", 0)) if kind_[1] == "i" or kind_ == "u1" else float(v) for v in rows[name]]
            for i, (name, kind_) in enumerate(fields)}


class Tables(ExportTest):
    def made(self, cloud, *options):
        np.save(self.folder / "cloud.npy", cloud)
        self.ok("triangulate", "cloud.npy", "-o", self.out, "--overwrite", "--quiet", "--attributes", "all", *options)

    def tables(self, *options):
        for ending, read in READERS.items():
            yield ending, *read(self.export(f"points.{ending}", *options))

    def test_rows_are_the_points_in_their_order(self):
        cloud = cloud_of(1000)
        for tiles in (1, 9):
            self.made(cloud, "--tiles", tiles)
            for ending, table, _, _ in self.tables():
                with self.subTest(ending=ending, tiles=tiles):
                    self.assertEqual(set(table), {"id", *cloud.dtype.names})
                    np.testing.assert_array_equal(table["id"], np.arange(1000))
                    for name in cloud.dtype.names:
                        np.testing.assert_array_equal(table[name], cloud[name])

    def test_types_and_bytes_of_fits_are_those_of_the_standard(self):
        cloud = cloud_of(300)
        self.made(cloud)
        table = own_fits(self.export("points.fits"))
        for name in cloud.dtype.names:
            self.assertEqual(table[name], cloud[name].tolist(), name)

    def test_a_duplicate_has_the_values_of_its_vertex(self):
        cloud = cloud_of(500, duplicates=60)
        self.made(cloud, "--tiles", 4)
        places = np.column_stack([cloud[axis] for axis in "xyz"])
        first = np.array([np.flatnonzero((places == place).all(axis=1))[0] for place in places])
        self.assertEqual((first != np.arange(500)).sum(), 60)
        for ending, table, _, _ in self.tables():
            np.testing.assert_array_equal(table["id"], np.arange(500), ending)
            np.testing.assert_array_equal(table["vertex"], first, ending)
            for name, _ in TYPES:
                np.testing.assert_array_equal(table[name], cloud[name][first], ending)

    def test_points_that_were_left_out_have_no_rows(self):
        cloud = cloud_of(600)
        self.made(cloud, "--crop", "0,0,0,1,1,0.5", "--tiles", 3)
        inside = np.flatnonzero(cloud["z"] <= 0.5)
        for ending, table, _, _ in self.tables():
            np.testing.assert_array_equal(table["id"], inside, ending)
            np.testing.assert_array_equal(table["a_f32"], cloud["a_f32"][inside], ending)

    def test_computed_columns_have_their_units_and_names_choose(self):
        self.made(cloud_of(400), "--tiles", 3)
        self.ok("measure", self.out, "--voronoi", "--density")
        manifest = json.loads((self.out / "manifest.json").read_text())
        units = {c["name"]: c["unit"] for c in manifest["columns"] if c["of"] == "vertices" and c["unit"]}
        stored = Stored2(self.out, manifest)
        for ending, table, told, _ in self.tables("--names", "density,a_i16,voronoi_volume"):
            self.assertEqual(set(table), {"id", "x", "y", "z", "density", "a_i16", "voronoi_volume"})
            for name in ("density", "voronoi_volume"):
                np.testing.assert_array_equal(table[name], stored[name])
                if ending != "npy":
                    self.assertEqual(told.get(name, ""), units.get(name, ""))
        names = np.load(self.export("points.npy", "--names", "density,a_i16")).dtype.names
        self.assertEqual(names, ("id", "x", "y", "z", "density", "a_i16"))

    def test_bytes_do_not_depend_on_tiles_threads_and_kinds(self):
        cloud = cloud_of(800, duplicates=10)
        first = {}
        for options in (["--tiles", "1"], ["--tiles", "13", "--threads", "3"], ["--tiles", "5", "--store", "points"]):
            self.made(cloud, "--periodic", "1", "--periodic-snap", "yes", *options)
            self.ok("measure", self.out, "--voronoi", "--density")
            for ending in (*READERS, "vol", "ndnet"):
                made = [self.export(f"points.{ending}").read_bytes()]
                if ending == "vol":
                    made.append((self.folder / "points.adj").read_bytes())
                self.assertTrue(first.setdefault(ending, made) == made, f"{ending} {options}")

    def test_a_periodic_snapshot_is_one_that_tessera_reads(self):
        points = np.round(np.random.default_rng(1).random((500, 3)) * 2**30) / 2**30
        np.save(self.folder / "cloud.npy", points)
        self.ok("triangulate", "cloud.npy", "-o", self.out, "--quiet", "--periodic", "1", "--tiles", 4)
        self.ok("measure", self.out, "--density")
        table, _, header = by_h5py(self.export("points.h5"))
        self.assertEqual(header["BoxSize"], 1)
        self.assertEqual(header["NumPart_ThisFile"].tolist(), [0, 500, 0, 0, 0, 0])
        self.assertEqual(header["MassTable"].tolist(), [0, 1, 0, 0, 0, 0])
        self.ok("triangulate", "points.h5", "-o", "again", "--quiet", "--periodic", "file", "--attributes", "all")
        digest = lambda out: json.loads((self.folder / out / "manifest.json").read_text())["digest2"]
        self.assertEqual(digest("again"), digest("out"))
        self.out = self.folder / "again"
        again, _, _ = by_h5py(self.export("again.h5", "--names", "density"))
        np.testing.assert_array_equal(again["density"], table["density"])

    def test_flat_results_have_their_heights_as_a_column(self):
        cloud = cloud_of(200)
        np.save(self.folder / "cloud.npy", cloud)
        self.ok("triangulate", "cloud.npy", "-o", self.out, "--dim", "2", "--quiet", "--tiles", 2)
        for ending, table, _, _ in self.tables():
            if ending != "h5":  # which has places in space, and z beside them
                np.testing.assert_array_equal(table["z"], cloud["z"], ending)
            np.testing.assert_array_equal(table["x"], cloud["x"], ending)

    def test_names_may_be_any_text(self):
        rng = np.random.default_rng(1)
        rows = "".join(f"{x!r},{y!r},{z!r},{i}\n" for i, (x, y, z) in enumerate(rng.random((50, 3)).tolist()))
        self.ok("triangulate", self.write("cloud.csv", "x,y,z,it's \\ é\n" + rows), "-o", self.out, "--quiet", "--attributes", "all")
        for ending, table, _, _ in self.tables():
            name = "it's \\ __" if ending == "fits" else "it's \\ é"
            self.assertIn(name, table, ending)
            np.testing.assert_array_equal(table[name], np.arange(50), ending)


class Stored2(dict):
    """Columns of vertices by id, as the tiles have them."""

    def __init__(self, folder, manifest):
        from tile_arrays import read_tile
        count = manifest["counts"]["vertices"]
        for column in manifest["columns"]:
            if column["of"] == "vertices":
                self[column["name"]] = np.zeros(count)
        for entry in manifest["tiles"]:
            arrays = read_tile(folder / entry.get("file", "tiles/%06d.vtu" % entry["tile"]))
            for name, values in self.items():
                values[arrays["PointData/id"]] = arrays["PointData/" + name]


class Refusals(ExportTest):
    def setUp(self):
        super().setUp()
        self.stored(self.xyz(n=100))

    def test_each_refusal_is_a_sentence_and_leaves_nothing(self):
        before = self.files()
        out = self.out
        for target, options, says in (
                ("a.h5", ["--names", "mass"], ["has no attribute or column 'mass'", "--names can name no attributes"]),
                ("a.fits", ["--max-edge", "1"], ["--max-edge: leaves out cells, and fits has what belongs to all of them"]),
                ("a.npy", ["--local"], ["--local: works only with"]),
                ("folder", ["--format", "h5"], ["h5 is one file: give a name that ends in .h5"]),
                ("a.vol", [], ["is not periodic along all axes", "--periodic"]),
                ("a.ndnet", [], ["has no column 'density'", "measuring it with --density computes it", "give --names"])):
            self.refused(USAGE, "export", out, "-o", target, *options, says=says)
            self.assertEqual(self.files(), before, target)
        self.refused(IO, "export", out, "-o", "nowhere/a.fits")
        self.write("taken.fits", "mine")
        self.refused(USAGE, "export", out, "-o", "taken.fits", says="exists already")
        self.assertEqual((self.folder / "taken.fits").read_text(), "mine")

    def test_damage_leaves_nothing(self):
        np.save(self.folder / "cloud.npy", np.round(np.random.default_rng(1).random((500, 3)) * 2**30) / 2**30)
        self.ok("triangulate", "cloud.npy", "-o", "box", "--periodic", 1, "--quiet", "--tiles", 4)
        self.ok("measure", "box", "--voronoi", "--density")
        tile = self.folder / "box/tiles/000003-2.vtu"
        tile.write_bytes(tile.read_bytes()[:3000])
        before = self.files()
        for ending in ("h5", "fits", "npy", "vol", "ndnet"):
            self.refused(CORRUPT, "export", "box", "-o", f"a.{ending}", says=tile.name)
            self.assertEqual(self.files(), before, ending)

    def test_a_name_may_not_come_twice(self):
        self.ok("measure", self.out, "--density")
        self.refused(USAGE, "export", self.out, "-o", "a.h5", "--names", "density,density", says="names 'density' twice")


if __name__ == "__main__":
    unittest.main()
