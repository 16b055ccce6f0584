"""Snapshots of simulations as a user meets them: HDF5 files like those of Gadget, AREPO and SWIFT, written by h5py."""
import gzip
import pathlib
import shutil
import signal
import unittest

import h5py
import numpy as np

from cli import BAD_INPUT, USAGE, CliTest


class Snapshots(CliTest):
    def write(self, name, counts=(40, 60, 0, 0, 5, 0), box=1000.0, seed=1, total=None, files=1, time=0.5, **more):
        """A file with random particles; returns its positions."""
        chance = np.random.default_rng(seed)
        positions = []
        with h5py.File(self.folder / name, "w", libver=more.get("libver", "earliest")) as file:
            header = file.create_group("Header").attrs
            header["NumPart_ThisFile"] = np.array(counts, more.get("kind", "u4"))
            header["NumPart_Total"] = np.array(total or counts, "u4")
            header["NumPart_Total_HighWord"] = np.zeros(len(counts), "u4")
            header["MassTable"] = np.array([0, 0.25] + [0] * (len(counts) - 2))
            header["NumFilesPerSnapshot"] = np.int32(files)
            header["BoxSize"] = box
            header["Time"] = time
            for number, count in enumerate(counts):
                if count == 0:
                    continue
                group = file.create_group(f"PartType{number}")
                at = chance.random((count, 3)).astype(more.get("type", "f8")) * 1000
                positions.append(at.astype("f8"))
                options = more.get("options", {})
                group.create_dataset("Coordinates", data=at, **options)
                group.create_dataset("Velocities", data=at.astype("f4") / 2, **options)
                group.create_dataset("ParticleIDs", data=np.arange(count, dtype="u8") + 2**60, **options)
                if number != 1:
                    group.create_dataset("Masses", data=np.arange(count) + 1.0, **options)
                if number == 0:
                    group.create_dataset("Density", data=np.arange(count, dtype="f4") * 3, **options)
                    group.create_dataset("Metals", data=np.arange(2 * count, dtype="f4").reshape(-1, 2), **options)
        return np.concatenate(positions)

    def arrays(self, *files):
        """Points and attributes of the result, in the order of the particles."""
        shutil.rmtree(self.folder / "arrays", ignore_errors=True)
        self.ok("triangulate", *files, "-o", "made", "--attributes", "all", "--quiet", "--overwrite")
        self.ok("export", "made", "-o", "arrays", "--format", "npy", "--quiet", "--overwrite")
        load = {path.stem: np.load(path) for path in (self.folder / "arrays").glob("*.npy")}
        order = np.argsort(load["ids"])
        return {name: values[order] for name, values in load.items() if len(values) == len(order)}

    def test_positions_and_attributes_are_those_of_the_file(self):
        for more in ({}, {"type": "f4"}, {"libver": "latest"},
                     {"options": {"compression": "gzip", "shuffle": True, "fletcher32": True, "chunks": True}},
                     {"box": [1000.0, 1000.0, 1000.0]}, {"kind": "i8"}):
            with self.subTest(**more):
                positions = self.write("snap.hdf5", **more)
                read = self.arrays("snap.hdf5")
                self.assertTrue(np.array_equal(read["points"], positions))
                self.assertEqual(np.bincount(read["particle_type"]).tolist(), [40, 60, 0, 0, 5])
                self.assertTrue(np.array_equal(read["vy"], positions[:, 1].astype("f4") / 2))
                self.assertEqual(read["particle_id"][:3].tolist(), [2**60, 2**60 + 1, 2**60 + 2])
                self.assertEqual(read["mass"][[0, 39, 40, 99, 104]].tolist(), [1, 40, 0.25, 0.25, 5])
                self.assertEqual(read["Density"][[1, 39]].tolist(), [3, 117])
                self.assertTrue(np.isnan(read["Density"][40:]).all())
                self.assertEqual(read["Metals_2"][5], 11)

    def test_info_tells_of_the_snapshot(self):
        self.write("snap.hdf5")
        told = self.json_lines(self.ok("info", "snap.hdf5", "--json"))[-1]["files"][0]
        self.assertEqual(told["snapshot"], {"files": 1, "points": 105, "box": [1000, 1000, 1000]})
        self.assertEqual(told["points"], 105)
        self.assertRegex(self.ok("info", "snap.hdf5"), r"snapshot +105 particles in 1 file, a box of 1000 x 1000 x 1000")

    def test_the_box_of_the_snapshot_can_be_the_period(self):
        self.write("snap.hdf5", box=[1000.0, 2000.0, 1500.0])
        told = self.json_lines(self.ok("triangulate", "snap.hdf5", "-o", "a", "--periodic", "file", "--json"))[-1]
        given = self.json_lines(self.ok("triangulate", "snap.hdf5", "-o", "b", "--periodic", "1000,2000,1500", "--json"))[-1]
        self.assertEqual(told["digest"], given["digest"])
        self.write("none.hdf5", box=0.0)
        self.refused(USAGE, "triangulate", "none.hdf5", "-o", "c", "--periodic", "file", says="none.hdf5 states no box; give the periods as numbers")

    def test_integer_coordinates_are_scaled_by_the_box(self):
        self.write("snap.hdf5", counts=(0, 30, 0, 0, 0, 0))
        steps = np.random.default_rng(3).integers(0, 2**32, (30, 3), dtype="u4")
        with h5py.File(self.folder / "snap.hdf5", "r+") as file:
            del file["PartType1/Coordinates"]
            file["PartType1/IntegerCoordinates"] = steps
        self.assertTrue(np.array_equal(self.arrays("snap.hdf5")["points"], steps * (1000 / 2**32)))

    def test_a_snapshot_in_several_files_is_one_cloud(self):
        counts = [(10, 20, 0, 0, 0, 0), (5, 1, 0, 0, 0, 0), (0, 9, 0, 0, 0, 0)]
        total = (15, 30, 0, 0, 0, 0)
        positions = [self.write(f"snap.{i}.hdf5", counts=of, seed=i, total=total, files=3) for i, of in enumerate(counts)]
        self.assertTrue(np.array_equal(self.arrays("snap.0.hdf5", "snap.1.hdf5", "snap.2.hdf5")["points"], np.concatenate(positions)))
        self.refused(BAD_INPUT, "info", "snap.0.hdf5", "snap.2.hdf5", says="snap.0.hdf5: is one of 3 files of a snapshot, but 2 are given; snap.1.hdf5 is missing")
        self.write("snap.1.hdf5", counts=counts[1], total=total, files=3, time=0.75)
        self.refused(BAD_INPUT, "info", "snap.0.hdf5", "snap.1.hdf5", "snap.2.hdf5", says="snap.1.hdf5: is of another snapshot than snap.0.hdf5")
        whole = (self.folder / "snap.2.hdf5").read_bytes()
        (self.folder / "snap.2.hdf5").write_bytes(whole[:len(whole) // 2])
        self.refused(BAD_INPUT, "info", "snap.0.hdf5", "snap.1.hdf5", "snap.2.hdf5", says="snap.2.hdf5: is no HDF5 file that can be read, or is damaged")

    def test_particles_of_some_types_are_read_and_keep_their_numbers(self):
        positions = self.write("snap.hdf5")
        read = self.arrays("snap.hdf5", "--particles", "gas,stars")
        kept = np.concatenate([positions[:40], positions[100:]])
        self.assertTrue(np.array_equal(read["points"], kept))
        self.assertEqual(sorted(read["ids"].tolist()), [*range(40), *range(100, 105)])
        dark = self.arrays("snap.hdf5", "--particles", "1")
        self.assertTrue(np.array_equal(dark["points"], positions[40:100]))
        self.assertNotIn("Density", dark)
        one = self.json_lines(self.ok("triangulate", "snap.hdf5", "-o", "a", "--particles", "dark", "--periodic", "file", "--json"))[-1]
        np.save(self.folder / "dark.npy", positions[40:100])
        other = self.json_lines(self.ok("triangulate", "dark.npy", "-o", "b", "--periodic", "1000", "--json"))[-1]
        self.assertEqual([one[k] for k in ("vertices", "cells", "filtered")], [other["vertices"], other["cells"], 45])
        self.refused(USAGE, "info", "snap.hdf5", "--particles", "disk",
                     says="--particles: the input has no particles of type 2 (disk), but 40 of type 0 (gas), 60 of type 1 (dark-matter), 5 of type 4 (stars)")
        self.refused(USAGE, "info", "snap.hdf5", "--particles", "plasma", says=["--particles", "'plasma' is no type of particles"])

    def test_a_type_that_is_not_wanted_is_not_looked_at(self):
        self.write("snap.hdf5")
        with h5py.File(self.folder / "snap.hdf5", "r+") as file:
            del file["PartType0/Coordinates"]
        self.refused(BAD_INPUT, "info", "snap.hdf5", says="its group /PartType0 has neither Coordinates nor IntegerCoordinates")
        self.assertEqual(len(self.arrays("snap.hdf5", "--particles", "stars")["points"]), 5)

    def test_a_file_of_a_set_may_have_no_particles(self):
        counts = [(10, 20, 0, 0, 0, 0), (0, 0, 0, 0, 0, 0)]
        self.write("snap.0.hdf5", counts=counts[0], files=2)
        with h5py.File(self.folder / "snap.0.hdf5") as file, h5py.File(self.folder / "snap.1.hdf5", "w") as empty:
            file.copy("Header", empty)
            empty["Header"].attrs["NumPart_ThisFile"] = np.zeros(6, "u4")
        self.assertEqual(len(self.arrays("snap.0.hdf5", "snap.1.hdf5")["points"]), 30)

    def test_info_tells_types_units_and_the_cosmology(self):
        self.write("snap.hdf5")
        with h5py.File(self.folder / "snap.hdf5", "r+") as file:
            file["Header"].attrs["Redshift"] = 1.0
            file.create_group("Parameters").attrs.update({"HubbleParam": 0.6774, "Omega0": 0.3, "UnitLength_in_cm": 3.085678e21})
            for number in (0, 1, 4):
                for name, numbers in {"Coordinates": (1, -1, 1, 0, 0, 3.085678e21), "Velocities": (0.5, 0, 0, 0, 1, 1e5)}.items():
                    keys = ("a_scaling", "h_scaling", "length_scaling", "mass_scaling", "velocity_scaling", "to_cgs")
                    file[f"PartType{number}/{name}"].attrs.update(dict(zip(keys, map(np.float64, numbers))))
            swift = file["PartType0/Density"].attrs  # as SWIFT writes them
            swift["Conversion factor to CGS (not including cosmological corrections)"] = [6.8e-31]
            for key, value in {"a-scale exponent": -3, "h-scale exponent": 0, "U_L exponent": -3, "U_M exponent": 1, "U_t exponent": 0}.items():
                swift[key] = np.array([value], "f4")
        told = self.json_lines(self.ok("info", "snap.hdf5", "--json"))[-1]["files"][0]
        self.assertEqual(told["particles"], [{"type": 0, "name": "gas", "count": 40, "mass": None},
                                             {"type": 1, "name": "dark-matter", "count": 60, "mass": 0.25},
                                             {"type": 4, "name": "stars", "count": 5, "mass": None}])
        self.assertEqual(told["stated"], {"time": 0.5, "redshift": 1, "hubble": 0.6774, "omega_matter": 0.3, "unit_length_cgs": 3.085678e21})
        self.assertEqual(told["units"], {"coordinates": "3.08568e+21 a h^-1 cm", **{v: "100000 a^0.5 cm s^-1" for v in ("vx", "vy", "vz")},
                                         "Density": "6.8e-31 a^-3 cm^-3 g"})
        text = self.ok("info", "snap.hdf5")
        self.assertRegex(text, r"particles +40 gas \(type 0\), 60 dark-matter \(type 1\) of mass 0.25 each, 5 stars \(type 4\)")
        self.assertRegex(text, r"units +coordinates \[3.08568e\+21 a h\^-1 cm\], Density \[")
        self.ok("triangulate", "snap.hdf5", "-o", "out", "--attributes", "Density,vx", "--quiet")
        self.ok("measure", "out", "--volume", "--quiet")
        kept = self.json_lines(self.ok("info", "out", "--json"))[-1]["units"]
        self.assertEqual(kept, {"coordinates": told["units"]["coordinates"], "Density": "6.8e-31 a^-3 cm^-3 g", "vx": "100000 a^0.5 cm s^-1"})

    def test_a_file_may_name_no_other_files(self):
        secret = np.zeros((30, 3))
        secret.tofile(self.folder / "secret.bin")
        with h5py.File(self.folder / "other.hdf5", "w") as file:
            file["a"] = secret
        def changed(change):
            self.write("snap.hdf5", counts=(0, 30, 0, 0, 0, 0))
            with h5py.File(self.folder / "snap.hdf5", "r+") as file:
                del file["PartType1/Coordinates"]
                change(file["PartType1"])
        changed(lambda group: group.create_dataset("Coordinates", (30, 3), "f8", external=[(str(self.folder / "secret.bin"), 0, 720)]))
        self.refused(BAD_INPUT, "info", "snap.hdf5", says="its table '/PartType1/Coordinates' takes its numbers from other files")
        def virtual(group):
            layout = h5py.VirtualLayout((30, 3), "f8")
            layout[:] = h5py.VirtualSource(str(self.folder / "other.hdf5"), "a", (30, 3))
            group.create_virtual_dataset("Coordinates", layout)
        changed(virtual)
        self.refused(BAD_INPUT, "info", "snap.hdf5", says="takes its numbers from other files")
        for link in (h5py.ExternalLink("other.hdf5", "/a"), h5py.SoftLink("/a")):
            def linked(group, link=link):
                group["Coordinates"] = link
            changed(linked)
            self.refused(BAD_INPUT, "info", "snap.hdf5", says="its group /PartType1 has neither Coordinates nor IntegerCoordinates")

    def test_what_makes_no_sense_is_a_sentence(self):
        with h5py.File(self.folder / "a.hdf5", "w") as file:
            file["x"] = np.zeros(3)
        self.refused(BAD_INPUT, "info", "a.hdf5", says="a.hdf5: is HDF5, but no snapshot: it has no group Header with the attribute NumPart_ThisFile")
        self.write("b.hdf5", counts=(0, 30, 0, 0, 0, 0))
        with h5py.File(self.folder / "b.hdf5", "r+") as file:
            file["Header"].attrs["NumPart_ThisFile"] = np.array([0, 31, 0, 0, 0, 0], "u4")
        self.refused(BAD_INPUT, "info", "b.hdf5", says="has 30 x 3 Coordinates, but the header says 31 particles")
        with h5py.File(self.folder / "b.hdf5", "r+") as file:
            file["Header"].attrs["NumPart_ThisFile"] = np.array([7, 30, 0, 0, 0, 0], "u4")
        self.refused(BAD_INPUT, "info", "b.hdf5", says="says that it has 7 particles of type 0, but has no group /PartType0")
        (self.folder / "c.hdf5").write_bytes(b"\x89HDF\r\n\x1a\n" + bytes(5000))
        self.refused(BAD_INPUT, "info", "c.hdf5", says="c.hdf5: is no HDF5 file")

    def test_damage_ends_in_a_sentence_or_in_a_cloud(self):
        self.write("snap.hdf5", counts=(0, 30, 0, 0, 0, 0), options={"compression": "gzip"})
        whole = (self.folder / "snap.hdf5").read_bytes()
        chance = np.random.default_rng(5)
        crashes = 0
        for _ in range(60):
            bad = bytearray(whole)
            for at in chance.integers(0, len(whole), 20):
                bad[at] = chance.integers(256)
            (self.folder / "bad.hdf5").write_bytes(bad)
            done = self.run_tessera("triangulate", "bad.hdf5", "-o", "bad", "--quiet", "--overwrite", "--skip-invalid")
            # The library reads behind its memory where attributes of a group are damaged (H5Aexists of HDF5 1.10.8, as valgrind
            # shows). What lies there decides whether that ends the program, which is why a daemon reads no HDF5 of strangers.
            if done.returncode == -signal.SIGSEGV:
                crashes += 1
                continue
            self.assertIn(done.returncode, (0, BAD_INPUT), done.stderr)
        self.assertLessEqual(crashes, 3)


class Tables(CliTest):
    """Tables in FITS that CFITSIO wrote; tests/input/fits_reader_test.cc has more of them."""
    DATA = pathlib.Path(__file__).resolve().parents[1] / "data" / "fits"

    def test_a_survey_is_triangulated_in_a_stated_cosmology(self):
        catalogue = self.DATA / "catalogue.fits"
        told = self.json_lines(self.ok("info", catalogue, "--cosmology", "70,0.3", "--json"))[-1]["files"][0]
        self.assertEqual((told["points"], told["units"]["coordinates"], told["units"]["MAG"]), (7, "Mpc", "mag"))
        self.assertRegex(self.ok("info", catalogue, "--cosmology", "70,0.3"), r"format +FITS, HDU 1 'GALAXIES', coordinates from RA, DEC, Z; left out: NAME \(text\)")
        self.ok("triangulate", catalogue, "-o", "far", "--cosmology", "70,0.3", "--attributes", "ID", "--quiet")
        self.ok("triangulate", catalogue, "-o", "near", "--cosmology", "100,0.3", "--quiet")
        self.ok("verify", "far", "--quiet")
        for result in ("far", "near"):
            self.ok("export", result, "-o", result + "-npy", "--format", "npy", "--quiet")
        read = lambda result, name: np.load(self.folder / f"{result}-npy" / f"{name}.npy")
        far, near = (read(result, "points")[np.argsort(read(result, "ids"))] for result in ("far", "near"))
        self.assertLess(np.abs(far * 0.7 - near).max(), 1e-10)
        # The second galaxy is at the redshift 0.1f, as SciPy integrates it.
        self.assertAlmostEqual(np.linalg.norm(far[1]), 418.454494, delta=1e-6)
        self.refused(USAGE, "triangulate", catalogue, "-o", "none", says=["the redshift 'Z'", "--cosmology"])
        self.refused(USAGE, "triangulate", catalogue, "-o", "none", "--cosmology", "70", says=["--cosmology", "'70' is not H0"])
        self.refused(USAGE, "triangulate", catalogue, "-o", "none", "--cosmology", "70,3", says=["--cosmology", "a number from 0 to 1"])

    def test_a_table_its_columns_and_packed_files(self):
        several = self.DATA / "several.fits"
        packed = self.folder / "several.fits.gz"
        packed.write_bytes(gzip.compress(several.read_bytes()))
        options = ["--hdu", "PARTS", "--columns", "x=XPOS,y=YPOS", "--json"]
        told = [self.json_lines(self.ok("triangulate", file, "-o", out, *options))[-1] for file, out in ((several, "a"), (packed, "b"))]
        self.assertEqual(told[0]["digest"], told[1]["digest"])
        self.assertEqual((told[0]["dimension"], told[0]["vertices"]), (2, 7))
        self.refused(USAGE, "info", several, "--hdu", "9", says="has no HDU '9'; its tables are HDU 3 'HALOS', HDU 4 'PARTS'")
        self.refused(USAGE, "info", several, "--columns", "x=pos", says=["--columns", "the keys must be x,y or x,y,z"])


if __name__ == "__main__":
    unittest.main()
