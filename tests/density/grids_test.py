"""tessera density: files, grids and inputs of the command."""
import json
import unittest

import numpy as np
from cli import CORRUPT, IO, USAGE
from gridded import DensityTest, lattice
from osgeo import gdal

gdal.UseExceptions()


class Grids(DensityTest):
    def test_an_image_has_the_same_values(self):
        rng = np.random.default_rng(1)
        self.triangulate(rng.random((800, 2)) * [7, 3] + [100, -5], "--tiles", "5")
        values, said = self.grid("--res", "0.01")
        self.ok("density", self.out, "--res", "0.01", "-o", "grid.tif")
        image = gdal.Open(str(self.folder / "grid.tif"))
        band = image.GetRasterBand(1)
        np.testing.assert_array_equal(band.ReadAsArray(), values.T[::-1])
        left, width, _, top, _, height = image.GetGeoTransform()
        self.assertEqual((left, width, height), (said["origin"][0], 0.01, -0.01))
        self.assertAlmostEqual(top, said["origin"][1] + 0.01 * said["size"][1], delta=1e-12)
        self.assertEqual((gdal.GetDataTypeName(band.DataType), band.GetDescription()), ("Float64", "density"))
        self.ok("density", self.out, "--res", "0.3", "-o", "again.tif")
        self.ok("density", self.out, "--res", "0.3", "-o", "other.tif", "--threads", "3")
        self.assertEqual((self.folder / "again.tif").read_bytes(), (self.folder / "other.tif").read_bytes())

    def test_point_files_in_one_step(self):
        rng = np.random.default_rng(2)
        np.save(self.folder / "cloud.npy", rng.random((900, 3)))
        self.ok("triangulate", "cloud.npy", "-o", self.out, "--quiet", "--tiles", "4")
        self.ok("density", self.out, "--res", "0.2", "-o", "of_result.npy", "--quiet")
        self.ok("density", "cloud.npy", "--res", "0.2", "-o", "of_files.npy", "--quiet")
        self.assertEqual((self.folder / "of_result.npy").read_bytes(), (self.folder / "of_files.npy").read_bytes())
        self.assertEqual({p.name for p in self.folder.iterdir()}, {"cloud.npy", "out", "of_result.npy", "of_files.npy"})

    def test_a_grid_may_be_larger_than_memory(self):
        rng = np.random.default_rng(3)
        self.triangulate(rng.random((200, 2)), "--tiles", "2")
        few = json.loads(self.ok("density", self.out, "--res", "0.0007", "-o", "few.npy", "--json", "--memory", "16M").splitlines()[-1])
        self.ok("density", self.out, "--res", "0.0007", "-o", "much.npy", "--quiet", "--memory", "4G")
        self.assertEqual((self.folder / "few.npy").read_bytes(), (self.folder / "much.npy").read_bytes())
        self.assertGreater(np.prod(few["size"]), 1_900_000)
        self.assertAlmostEqual(few["grid_mass"] / 200, 1, delta=1e-13)

    def test_wrong_options_are_refused_before_anything_is_written(self):
        self.triangulate(lattice(3, 3))
        flat = self.triangulate(lattice(3, 2), out=self.folder / "flat")
        before = {p.name for p in self.folder.iterdir()}
        for options, says in ((["-o", "a.npy"], "the width of a pixel or voxel is not given; add --res 0.5, or --grid 256"),
                              (["-o", "a.npy", "--res", "0"], "is not a distance"),
                              (["-o", "a.npy", "--res", "-1"], "is not a distance"),
                              (["-o", "a.npy", "--res", "nan"], "is not a distance"),
                              (["-o", "a.npy", "--res", "1e200"], "--res: must be the width of a pixel or voxel"),
                              (["-o", "a.npy", "--res", "1e-9"], "voxels is too large: give a larger --res, or a smaller --bbox"),
                              (["-o", "a.npy", "--res", "1e-15"], "--res: is too small for coordinates as large as these"),
                              (["-o", "a.vtk", "--res", "1"], "'.vtk' is not a format of grids; the formats are .npy, .h5, .fits, and for images .tif"),
                              (["-o", "a", "--res", "1"], "'' is not a format of grids"),
                              (["-o", "a.tif", "--res", "1"], "a GeoTIFF holds an image, but"),
                              (["-o", "a.npy", "--res", "1", "--bbox", "0,0,1,1"], "--bbox"),
                              (["--res", "1"], "no file to write is given")):
            self.refused(USAGE, "density", self.out, *options, says=says)
        self.refused(USAGE, "density", flat, "-o", "a.npy", "--res", "1", "--bbox", "0,0,0,1,1,1", says="--bbox")
        self.refused(USAGE, "density", self.out, flat, "-o", "a.npy", "--res", "1", says="is a result folder, and holds no input")
        self.assertEqual({p.name for p in self.folder.iterdir()}, before)
        self.write("there.npy", "mine")
        self.refused(USAGE, "density", self.out, "-o", "there.npy", "--res", "1", says="there.npy: exists already; --overwrite replaces it")
        self.assertEqual((self.folder / "there.npy").read_text(), "mine")
        self.refused(IO, "density", self.out, "-o", "no/there.npy", "--res", "1", says="there.npy")

    def test_a_region_has_fields_but_no_densities(self):
        rng = np.random.default_rng(5)
        rows = "\n".join("%r %r %r" % (x, y, x) for x, y in rng.random((500, 2)).tolist())
        cloud = self.write("cloud.txt", "x y f\n" + rows + "\n")
        self.ok("region", cloud, "--bbox", "0.25,0.25,0.625,0.625", "-o", self.out, "--dim", "2", "--attributes", "f", "--quiet")
        self.refused(USAGE, "density", self.out, "--res", "0.1", "-o", "a.npy", says="densities need a whole triangulation")
        self.refused(USAGE, "measure", self.out, "--density", says="densities need a whole triangulation")
        values, said = self.grid("--res", "0.125", "--field", "f", "--bbox", "0.25,0.25,0.625,0.625")
        np.testing.assert_allclose(values, np.broadcast_to(np.array([[0.3125], [0.4375], [0.5625]]), (3, 3)), atol=1e-12)

    def test_a_damaged_tile_leaves_nothing(self):
        self.triangulate(lattice(9, 2), "--tiles", "3")
        tile = sorted((self.out / "tiles").iterdir())[1]
        data = bytearray(tile.read_bytes())
        for i in range(len(data) // 3, len(data) // 3 + 400):
            data[i] ^= 0x55
        tile.write_bytes(bytes(data))
        before = {p.name for p in self.folder.iterdir()}
        done = self.run_tessera("density", self.out, "--res", "1", "-o", "a.npy")
        self.assertEqual(done.returncode, CORRUPT, done.stderr)
        self.assertEqual({p.name for p in self.folder.iterdir()}, before)


if __name__ == "__main__":
    unittest.main()
