"""yt opens a table in HDF5 as a snapshot, and as particles; only where yt is installed."""
import importlib.util
import unittest

import h5py
import numpy as np

from stored import ExportTest


@unittest.skipUnless(importlib.util.find_spec("yt"), "yt is not installed")
class Yt(ExportTest):
    def setUp(self):
        super().setUp()
        rng = np.random.default_rng(1)
        self.cloud = np.zeros(3000, [(axis, "<f8") for axis in "xyz"] + [("mass", "<f4")])
        for axis in "xyz":
            self.cloud[axis] = np.round(rng.random(3000) * 2**30) / 2**30 * 64
        self.cloud["mass"] = rng.random(3000)
        np.save(self.folder / "cloud.npy", self.cloud)
        self.ok("triangulate", "cloud.npy", "-o", self.out, "--quiet", "--periodic", 64, "--tiles", 4, "--attributes", "mass")
        self.ok("measure", self.out, "--density")
        self.table = self.export("values.h5")

    def test_as_a_snapshot(self):
        import yt
        yt.set_log_level(40)
        units = {"length": (1, "kpc"), "mass": (1e10, "Msun"), "velocity": (1, "km/s")}
        snapshot = yt.load(str(self.table), unit_base=units)
        self.assertEqual(snapshot.domain_width.to("code_length").tolist(), [64] * 3)
        self.assertEqual(tuple(snapshot.periodicity), (True,) * 3)
        data = snapshot.all_data()
        ids = data["PartType1", "ParticleIDs"].astype(int)
        self.assertEqual(sorted(ids.tolist()), list(range(3000)))
        for axis in "xyz":
            np.testing.assert_array_equal(data["PartType1", "particle_position_" + axis].to("code_length"), self.cloud[axis][ids])
        np.testing.assert_array_equal(data["PartType1", "Masses"].to("code_mass"), self.cloud["mass"][ids])
        with h5py.File(self.table) as file:
            np.testing.assert_array_equal(data["PartType1", "density"], file["PartType1/density"][:][ids])
        x, y, density = (("PartType1", name) for name in ("particle_position_x", "particle_position_y", "density"))
        picture = yt.ParticlePlot(snapshot, x, y, density).save(str(self.folder / "picture.png"))
        self.assertGreater((self.folder / picture[0]).stat().st_size, 1000)

    def test_as_particles(self):
        import yt
        yt.set_log_level(40)
        with h5py.File(self.table) as file:
            places, masses = file["PartType1/Coordinates"][:], file["PartType1/Masses"][:]
        data = {"particle_position_" + axis: places[:, i] for i, axis in enumerate("xyz")} | {"particle_mass": masses}
        box = np.array([places.min(axis=0), np.nextafter(places.max(axis=0), np.inf)]).T
        points = yt.load_particles(data, bbox=box).all_data()
        self.assertAlmostEqual(float(points["all", "particle_mass"].to("code_mass").sum()), float(masses.astype(float).sum()), places=3)
        self.assertEqual(len(points["all", "particle_mass"]), 3000)


if __name__ == "__main__":
    unittest.main()
