"""Grids as HDF5 and FITS: read by h5py and astropy they are those of .npy; failures leave nothing."""
import resource
import signal
import struct
import subprocess
import time
import unittest

import h5py
import numpy as np
from astropy.io import fits
from cli import INTERRUPTED, IO, TESSERA, USAGE
from gridded import DensityTest, lattice

SHEAR = ["shear_xx", "shear_xy", "shear_xz", "shear_yy", "shear_yz"]


class Formats(DensityTest):
    def made(self, d, periodic=True, n=200, tiles=3):
        rng = np.random.default_rng(d)
        points = np.round(rng.random((n, d)) * 2**20) / 2**20
        self.names = ["u", "v", "w"][:d]
        options = ["--periodic", ",".join(["1.0", "2.0", "1.0"][:d])] if periodic else []
        self.triangulate(np.column_stack([points, rng.normal(size=(n, d))]), "--tiles", tiles, *options, names=self.names)

    def kinds(self, d):
        vector = ",".join(self.names)
        curl = ["curl"] if d == 2 else ["curl_x", "curl_y", "curl_z"]
        return (([], ["density"], "density"), (["--mass", "u"], ["density"], "density of u"), (["--field", "v"], ["v"], "v"),
                (["--divergence", vector], ["divergence"], "divergence of " + vector), (["--curl", vector], curl, "curl of " + vector),
                (["--shear", vector], SHEAR[:2] if d == 2 else SHEAR, "shear of " + vector))

    def test_hdf5_and_fits_have_the_values_of_npy(self):
        for d in 2, 3:
            self.made(d)
            for options, names, about in self.kinds(d):
                with self.subTest(d=d, options=options):
                    voxels = ["7", "5", "4"][:d]
                    self.ok("density", self.out, "--grid", ",".join(voxels), "-o", "a.npy", "--overwrite", "--quiet", *options)
                    array = np.load(self.folder / "a.npy")
                    array = array if array.ndim > d else array[..., None]
                    widths, period = [1 / 7, 2 / 5, 1 / 4][:d], [1.0, 2.0, 1.0][:d]
                    self.ok("density", self.out, "--grid", ",".join(voxels), "-o", "a.h5", "--overwrite", "--quiet", *options)
                    with h5py.File(self.folder / "a.h5") as file:
                        self.assertEqual(sorted(file), sorted(names))
                        self.assertEqual(file.attrs["origin"].tolist(), [0.0] * d)
                        self.assertEqual(file.attrs["res"].tolist(), widths)
                        self.assertEqual(file.attrs["period"].tolist(), period)
                        self.assertEqual(file.attrs["size"].tolist(), [int(n) for n in voxels])
                        self.assertEqual((file.attrs["made_by"], file.attrs["version"]), ("tessera density", 1))
                        for c, name in enumerate(names):
                            self.assertEqual(file[name].attrs["description"], about)
                            self.assertEqual(file[name].dtype, "<f8")
                            np.testing.assert_array_equal(file[name][:], array[..., c])
                    self.ok("density", self.out, "--grid", ",".join(voxels), "-o", "a.fits", "--overwrite", "--quiet", *options)
                    self.assertEqual((self.folder / "a.fits").stat().st_size % 2880, 0)
                    with fits.open(self.folder / "a.fits") as file:
                        file.verify("exception")
                        images = [file[0]] if len(names) == 1 else [file[name.upper()] for name in names]
                        self.assertEqual(len(file), 1 if len(names) == 1 else 1 + len(names))
                        for c, image in enumerate(images):
                            self.assertEqual(image.data.dtype, ">f8")
                            np.testing.assert_array_equal(image.data, array[..., c])
                            self.assertEqual(image.header["OBJECT"], about)
                            for axis in range(d):
                                values = [image.header[f"{key}{axis + 1}"] for key in ("CTYPE", "CRPIX", "CRVAL", "CDELT", "PERIOD")]
                                self.assertEqual(values, ["XYZ"[axis], 0.5, 0.0, widths[axis], period[axis]])

    def test_a_fits_file_has_a_linear_coordinate_system(self):
        from astropy.wcs import WCS
        self.made(3, periodic=False)
        self.ok("density", self.out, "--res", "0.125", "--bbox", "0.25,0.5,-1,1,1,1", "-o", "a.fits", "--quiet")
        with fits.open(self.folder / "a.fits") as file:
            place = WCS(file[0].header).wcs_pix2world([[0, 0, 0], [1, 2, 3]], 0)  # the centres of two voxels
            np.testing.assert_allclose(place, [[0.3125, 0.5625, -0.9375], [0.4375, 0.8125, -0.5625]], atol=1e-15)
            self.assertNotIn("BUNIT", file[0].header)

    def test_units_come_from_the_coordinate_system(self):
        np.save(self.folder / "cloud.npy", np.random.default_rng(1).random((50, 2)))
        self.ok("triangulate", "cloud.npy", "-o", self.out, "--quiet", "--crs", "EPSG:2154")
        self.ok("density", self.out, "--grid", "3", "-o", "a.h5", "--quiet")
        self.ok("density", self.out, "--grid", "3", "-o", "a.fits", "--quiet")
        unit = h5py.File(self.folder / "a.h5")["density"].attrs["unit"]
        self.assertIn(unit, ("1/m^2", "1/metre^2"))
        header = fits.getheader(self.folder / "a.fits")
        self.assertEqual((header["BUNIT"], header["CUNIT1"]), (unit, unit[2:-2]))

    def test_a_grid_by_number_covers_the_bounds(self):
        rng = np.random.default_rng(3)
        points = rng.random((300, 3)) * [1, 10, 0.1] + [5, -3, 0]
        self.triangulate(points)
        values, said = self.grid("--grid", "9,8,7")
        self.assertEqual((said["size"], said["res"]), ([9, 8, 7], None))
        self.assertEqual(said["origin"], points.min(0).tolist())
        np.testing.assert_allclose(said["widths"], np.ptp(points, axis=0) / [9, 8, 7], rtol=1e-15)
        self.assertAlmostEqual(values.sum() * np.prod(said["widths"]) / 300, 1, delta=1e-12)
        self.refused(USAGE, "density", self.out, "-o", "a.npy", says="add --res 0.5, or --grid 256")

    def test_images_have_square_pixels(self):
        self.made(2)
        self.ok("density", self.out, "--grid", "4,8", "-o", "a.tif", "--quiet")
        self.refused(USAGE, "density", self.out, "--grid", "4", "-o", "b.tif", says="the pixels of a GeoTIFF are squares")
        self.refused(USAGE, "density", self.out, "--grid", "4,8", "--shear", "u,v", "-o", "b.tif", says="room for one number a pixel")
        self.assertFalse((self.folder / "b.tif").exists())

    def test_bytes_are_the_same_for_all_tiles(self):
        for ending in "h5", "fits":
            first = None
            for tiles, threads, memory in (1, 1, "4G"), (9, 2, "64M"), (60, 3, "1G"):
                self.made(3, tiles=tiles)
                self.ok("density", self.out, "--grid", "19", "--curl", "u,v,w", "-o", "a." + ending, "--overwrite", "--quiet",
                        "--threads", threads, "--memory", memory)
                found = (self.folder / ("a." + ending)).read_bytes()
                first = first or found
                self.assertEqual(found, first, (ending, tiles))

    def test_a_fits_file_is_read_by_the_standard_alone(self):
        self.triangulate(lattice(4, 2))
        self.ok("density", self.out, "--res", "1", "-o", "a.fits", "--quiet")
        data = (self.folder / "a.fits").read_bytes()
        cards = [data[i:i + 80].decode("ascii") for i in range(0, 2880, 80)]
        self.assertEqual([card[:30] for card in cards[:5]],
                         ["SIMPLE  =                    T", "BITPIX  =                  -64", "NAXIS   =                    2",
                          "NAXIS1  =                    3", "NAXIS2  =                    3"])
        self.assertIn("END" + " " * 77, cards)
        self.assertEqual(len(data), 5760)
        values = struct.unpack(">9d", data[2880:2880 + 72])
        np.testing.assert_array_equal(values, np.ravel(self.grid("--res", "1")[0].T))

    def test_existing_files_and_full_disks(self):
        self.made(3)
        before = self.files()

        def small_files():
            signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
            resource.setrlimit(resource.RLIMIT_FSIZE, (100_000, 100_000))

        for ending in "npy", "h5", "hdf5", "fits":
            name = "a." + ending
            for grid in "24", "4":  # the numbers, the sums
                done = self.refused(IO, "density", self.out, "--grid", grid, "-o", name, says="cannot write", preexec_fn=small_files)
                self.assertEqual(len(done.stderr.splitlines()), 1, done.stderr)
                self.assertEqual(self.files(), before)
            self.refused(IO, "density", self.out, "--grid", "4", "-o", "no/" + name, says="no/" + name)
            there = self.write(name, "mine")
            self.refused(USAGE, "density", self.out, "--grid", "4", "-o", name, says="exists already; --overwrite replaces it")
            self.assertEqual(there.read_text(), "mine")
            self.ok("density", self.out, "--grid", "4", "-o", name, "--overwrite", "--quiet")
            there.unlink()
        self.refused(USAGE, "density", self.out, "--grid", "4", "-o", "a.vtk",
                     says="'.vtk' is not a format of grids; the formats are .npy, .h5, .fits, and for images .tif")
        self.assertEqual(self.files(), before)

    def test_ctrl_c_leaves_nothing(self):
        self.made(3, n=20_000)
        before = self.files()
        for ending in "h5", "fits":
            process = subprocess.Popen([TESSERA, "density", self.out, "--grid", "200", "-o", "a." + ending], cwd=self.folder,
                                       stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
            while self.files() == before and process.poll() is None:
                time.sleep(0.002)
            process.send_signal(signal.SIGINT)
            _, text = process.communicate(timeout=120)
            self.assertEqual(process.returncode, INTERRUPTED, text)
            self.assertEqual(self.files(), before)


if __name__ == "__main__":
    unittest.main()
