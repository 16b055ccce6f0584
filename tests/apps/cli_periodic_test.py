"""tessera triangulate --periodic: what is made, told and refused."""
import json
import random
import shutil
import signal
import subprocess
import time
import unittest

import numpy as np

from cli import BAD_INPUT, TESSERA, USAGE, CliTest


class Periodic(CliTest):
    def npy(self, points, name="cloud.npy"):
        np.save(self.folder / name, np.asarray(points, float))
        return name

    def uniform(self, n, dim=3, seed=1, side=1.0):
        return self.npy(np.random.default_rng(seed).random((n, dim)) * side)

    def manifest(self, out=None):
        return json.loads(((out or self.out) / "manifest.json").read_text())

    def made(self, cloud, *args, out=None):
        summary = json.loads(self.ok("triangulate", cloud, "-o", out or self.out, "--json", *args).splitlines()[-1])
        self.ok("verify", out or self.out)
        return summary

    def test_a_lattice_of_any_size_is_proved_and_counted(self):
        """A lattice of n points in a periodic box has 6 n tetrahedra (by the tie rule), or 2 n triangles."""
        for dim, side in ((2, 1), (2, 4), (3, 1), (3, 2), (3, 6)):
            grid = np.stack(np.meshgrid(*[np.arange(side)] * dim), -1).reshape(-1, dim)
            summary = self.made(self.npy(grid), "--dim", dim, "--periodic", side, "--overwrite")
            self.assertEqual(summary["vertices"], side**dim)
            if dim == 2:
                self.assertEqual(summary["cells"], 2 * side**2)
            self.ok("verify", self.out, "--against-cgal")

    def test_the_digest_is_the_same_for_any_tiles_and_kinds(self):
        cloud = self.uniform(4000)
        digests = set()
        for args in (["--tiles", "1"], ["--tiles", "8"], ["--tiles", "1000"], ["--partition", "octree", "--tiles", "20"],
                     ["--tiles", "8", "--store", "points"], ["--tiles", "40", "--memory", "60M", "--no-neighbors"],
                     ["--tiles", "8", "--kernel", "cgal"]):
            digests.add(self.made(cloud, "--periodic", "1", "--overwrite", *args)["digest"])
        self.assertEqual(len(digests), 1)
        shutil.rmtree(self.out)
        self.assertNotIn(self.made(cloud)["digest"], digests)

    def test_periods_along_some_axes(self):
        cloud = self.uniform(1500)
        for period in ("1,0,0", "0,1,0", "0,0,2", "1,1,0", "1,0,3", "4,2,1"):
            self.made(cloud, "--periodic", period, "--tiles", "5", "--overwrite")
            self.ok("verify", self.out, "--against-cgal")
            told = json.loads(self.ok("info", self.out, "--json"))
            self.assertEqual(told["period"], [float(length) for length in period.split(",")])
            self.assertIn("period", self.ok("info", self.out))
        self.assertEqual(self.manifest()["format_version"], 6)
        self.made(self.uniform(500, 2), "--dim", "2", "--periodic", "1,0", "--tiles", "3", "--overwrite")
        self.assertEqual(self.manifest()["partition"]["period"], [1.0, 0.0, 0.0])

    def test_points_are_moved_into_the_box_and_told(self):
        points = np.random.default_rng(3).integers(0, 2**20, (300, 3)) / 2**20
        inside = self.made(self.npy(points), "--periodic", "1")
        self.assertEqual(inside["warnings"], [])
        moved = points + np.random.default_rng(4).integers(-3, 4, points.shape)
        outside = self.made(self.npy(moved), "--periodic", "1", "--overwrite")
        self.assertEqual(outside["digest"], inside["digest"])
        self.assertRegex(outside["warnings"][0], "^[0-9]+ points were moved by whole periods into the box that begins at 0$")
        twice = self.made(self.npy(np.vstack([points, moved])), "--periodic", "1", "--overwrite")
        self.assertEqual((twice["vertices"], twice["duplicates"]), (300, 300))

    def test_coordinates_are_snapped_or_refused(self):
        cloud = self.npy([[0.1, 0.2, 0.3], [1e-30, 0.7, 0.4], [0.5, 0.5, 0.5]])
        warnings = self.made(cloud, "--periodic", "1")["warnings"]
        self.assertRegex(warnings[0], "^coordinates were rounded to multiples of the period's step, .* by [0-9.e-]+ at most$")
        self.refused(BAD_INPUT, "triangulate", cloud, "-o", "b", "--periodic", "1", "--periodic-snap", "no",
                     says=["cloud.npy", "row 0", "x has too many binary digits", "--periodic-snap yes rounds it"])
        warnings = self.made(cloud, "--periodic", "0.1", "--overwrite")["warnings"]
        self.assertIn("the period 0.1 along x has more than 51 binary digits; it was rounded to", warnings[0])
        self.refused(USAGE, "triangulate", cloud, "-o", "b", "--periodic", "0.1", "--periodic-snap", "no",
                     says=["the period 0.1 along x has more than 51 binary digits", "--periodic-snap yes takes it"])
        self.assertFalse((self.folder / "b").exists())

    def test_periods_that_are_none_are_refused(self):
        cloud = self.uniform(10)
        for period, says in (("-1", "is negative"), ("nan", "is not a number"), ("inf", "is infinite"), ("1e300", "is not between"),
                             ("1e-300", "is not between"), ("0", "all periods are 0"), ("0,0,0", "all periods are 0"), ("1,2", "2 periods are given"),
                             ("1,1,1,1", "is not a period like"), ("a", "is not a period like")):
            self.refused(USAGE, "triangulate", cloud, "-o", self.out, "--periodic=" + period, says=["--periodic", says])
        self.refused(USAGE, "triangulate", cloud, "-o", self.out, "--dim", "2", "--periodic", "1,1,1", says="3 periods are given")
        self.refused(BAD_INPUT, "triangulate", cloud, "-o", self.out, "--periodic", "1e-20", says=["cloud.npy", "more than 10^12 periods"])
        self.refused(BAD_INPUT, "triangulate", cloud, "-o", self.out, "--periodic", "1e18", says=["too large for points", "along x"])
        self.assertFalse(self.out.exists())

    def test_flat_clouds(self):
        one = self.npy([[0.25, 0.5, 0.75]], "one.npy")
        self.assertEqual(self.made(one, "--periodic", "1")["vertices"], 1)
        self.refused(BAD_INPUT, "triangulate", one, "-o", "b", "--periodic", "1,1,0", says="a single point does not span z")
        plane = self.npy([[0.25, 0.5, 0], [0.5, 0.25, 0]], "plane.npy")
        self.refused(BAD_INPUT, "triangulate", plane, "-o", "b", "--periodic", "1,1,0", says="the 2 points have the same z")
        self.made(plane, "--periodic", "1", "--overwrite")
        line = self.npy([[0.25, 0, 0], [0.5, 1, 1], [0.1, 2, 2]], "line.npy")
        self.refused(BAD_INPUT, "triangulate", line, "-o", "b", "--periodic", "1,0,0", says="lie on one line of y and z")

    def test_attributes_go_with_images(self):
        points = np.random.default_rng(6).integers(0, 64, (200, 3)) / 64
        rows = np.zeros(len(points), [("x", "f8"), ("y", "f8"), ("z", "f8"), ("mass", "f4")])
        rows["x"], rows["y"], rows["z"] = points.T
        rows["mass"] = np.arange(len(points))
        np.save(self.folder / "rows.npy", rows)
        for store in ("cells", "points"):
            self.made("rows.npy", "--periodic", "1", "--tiles", "4", "--attributes", "mass", "--store", store, "--overwrite")

    def test_points_are_materialised(self):
        cloud = self.uniform(3000)
        self.made(cloud, "--periodic", "1,1,0", "--tiles", "6", out=self.folder / "cells")
        self.made(cloud, "--periodic", "1,1,0", "--tiles", "6", "--store", "points", out=self.folder / "points")
        self.ok("materialise", "points", "-o", "made")
        self.ok("materialise", "points")
        self.ok("verify", "made")
        self.ok("verify", "points")
        for path in sorted((self.folder / "cells" / "tiles").iterdir()):
            self.assertEqual(path.read_bytes(), (self.folder / "made" / "tiles" / path.name).read_bytes(), path.name)

    def test_what_cannot_read_periodic_results_says_so(self):
        self.made(self.uniform(300, 2), "--dim", "2", "--periodic", "1", "--tiles", "2")
        self.made(self.uniform(300), "--periodic", "1", "--tiles", "2", out=self.folder / "space")
        says = "holds the triangulation of a periodic cloud"
        for command in (["dem", "out", "--res", "0.1", "-o", "a.tif"], ["contours", "out", "--interval", "1", "-o", "a.geojson"],
                        ["surface", "space", "-o", "a.ply"], ["update", "out", "--add", "cloud.npy"]):
            done = self.run_tessera(*command)
            self.assertNotEqual(done.returncode, 0, command)
            self.assertIn(says, done.stderr, command)

    def test_a_killed_run_is_resumed_to_the_same_files(self):
        cloud = self.uniform(60000)
        options = ["--periodic", "1", "--tiles", "20", "--threads", "2", "--memory", "150M"]
        began = time.monotonic()
        self.ok("triangulate", cloud, "-o", "straight", *options)
        seconds = time.monotonic() - began
        expected = {p.name: p.read_bytes() for p in (self.folder / "straight" / "tiles").iterdir()}
        rng = random.Random(2)
        for _ in range(6):
            process = subprocess.Popen([TESSERA, "triangulate", cloud, "-o", "out", "--quiet", *options], cwd=self.folder)
            try:
                process.wait(rng.uniform(0.1, 1) * seconds)
            except subprocess.TimeoutExpired:
                process.send_signal(signal.SIGKILL)
                process.wait()
            self.ok("triangulate", cloud, "-o", "out", "--quiet", "--resume", *options)
            self.assertEqual({p.name: p.read_bytes() for p in (self.out / "tiles").iterdir()}, expected)
            shutil.rmtree(self.out)
        self.ok("verify", "straight")


if __name__ == "__main__":
    unittest.main()
