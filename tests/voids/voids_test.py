"""Zones, saddles and voids, as ZOBOV defines them, whatever the tiles."""
import itertools
import json
import unittest

import numpy as np
from brute import NONE, Stored, Zobov, expected, table
from cli import CliTest
from scipy.spatial import Delaunay


def lattice(*sides):
    return np.stack(np.meshgrid(*[np.arange(float(side)) for side in sides]), -1).reshape(-1, len(sides))


def rounded(points):
    """To steps that a period keeps."""
    return np.round(points * 2.0 ** 30) / 2.0 ** 30 % 1


def clouds():
    """Points and periods; None: no period."""
    rng = np.random.default_rng(8)
    halos = rounded(np.concatenate([rng.normal(rng.random(3), 0.01, (60, 3)) for _ in range(5)] + [rng.random((200, 3))]))
    return {
        "2D": (rng.random((300, 2)), None),
        "3D": (rng.random((400, 3)), None),
        "clustered": (halos, None),
        "2D lattice": (lattice(9, 8), None),
        "3D lattice": (lattice(5, 5, 4), None),
        "duplicates": (np.repeat(rng.random((120, 3)), 3, axis=0)[rng.permutation(360)], None),
        "few": (rng.random((7, 2)), None),
        "2D period": (rounded(rng.random((200, 2))), "1"),
        "3D period": (rounded(rng.random((250, 3))), "1"),
        "clustered period": (halos, "1"),
        "period along one axis": (rounded(rng.random((250, 3))), "1,0,0"),
        "periods along two axes": (rounded(rng.random((250, 3))), "0,1,1"),
        "2D lattice period": (lattice(6, 7), "6,7"),
        "3D lattice period": (lattice(4, 4, 4), "4"),
        "2D stripe": (lattice(5, 6), "5,0"),
        "one point": (np.array([[0.25, 0.5, 0.5]]), "1"),
        "two points": (np.array([[0.25, 0.5], [0.5, 0.25]]), "1"),
    }


class VoidsTest(CliTest):
    def triangulate(self, points, period=None, *options, name="out"):
        np.save(self.folder / "cloud.npy", points)
        out = self.folder / name
        periodic = ["--periodic", period] if period else []
        self.ok("triangulate", self.folder / "cloud.npy", "-o", out, "--overwrite", "--quiet", "--dim", points.shape[1],
                *periodic, *options)
        return out

    def voids(self, out, *options):
        return json.loads(self.ok("voids", out, *options, "--json").splitlines()[-1])

    def points_of(self, points, stored):
        """How many points each vertex stands for."""
        at = {tuple(place[:stored.dimension]): vertex for vertex, place in stored.places.items()}
        counts = dict.fromkeys(stored.places, 0)
        for place in points.tolist():
            counts[at[tuple(place)]] += 1
        return counts

    def check_table(self, rows, wanted, dimension):
        self.assertEqual(set(rows), set(wanted.voids))
        size = "area" if dimension == 2 else "volume"
        for core, found in rows.items():
            void = wanted.voids[core]
            for key in ("core_density", "zone_points", "saddle_vertex", "saddle_density", "parent", "void_zones",
                        "void_points", "contrast"):
                self.assertEqual(found[key], void[key], (core, key))
            self.assertEqual(found["zone_" + size], void["zone_volume"])
            self.assertEqual(found["void_" + size], void["void_volume"])
            r = void["contrast"] - 1
            probability = np.exp(-2.6 * r) if dimension == 2 else np.exp(-5.12 * r - 0.8 * r ** 2.8)
            self.assertAlmostEqual(found["probability"], probability, delta=1e-12)
        contrasts = [row["contrast"] for row in rows.values()]
        self.assertEqual(contrasts, sorted(contrasts, reverse=True))


class ByBruteForce(VoidsTest):
    def test_zones_and_voids_are_those_of_the_definition_in_any_tiles(self):
        for name, (points, period) in clouds().items():
            whole, files = None, set()
            for tiles, threads, store in (1, 1, "cells"), (8, 2, "cells"), (40, 2, "points"), (3, 1, "points"):
                with self.subTest(cloud=name, tiles=tiles, store=store):
                    out = self.triangulate(points, period, "--tiles", tiles, "--store", store)
                    told = self.voids(out, "-o", self.folder / "voids.csv", "--overwrite", "--threads", threads)
                    self.voids(out, "-o", self.folder / "voids.txt", "--overwrite")
                    files.add(tuple((self.folder / ("voids" + ending)).read_bytes()
                                    for ending in (".csv", ".txt", ".zone", ".void")))
                    if store == "points":
                        self.ok("materialise", out, "--quiet")
                    stored = Stored(out)
                    if whole is None:
                        whole = expected(stored, points=self.points_of(points, stored))
                        self.check_table(table(self.folder / "voids.csv"), whole, stored.dimension)
                    self.assertEqual(stored.columns["zone"], whole.zone)
                    self.assertEqual((told["zones"], told["column"], told["made"]), (len(whole.voids), "zone", True))
                    self.assertEqual(told["outside"], sum(zone == NONE for zone in whole.zone.values()))
            self.assertEqual(len(files), 1, f"{name}: the files depend on the tiles")

    def test_the_edges_are_those_of_scipy(self):
        """So the brute force does not depend on Tessera's cells."""
        rng = np.random.default_rng(3)
        for dimension in 2, 3:
            points = rng.random((200, dimension))
            out = self.triangulate(points)
            edges = {tuple(sorted(pair)) for cell in Delaunay(points).simplices.tolist()
                     for pair in itertools.combinations(cell, 2)}
            self.assertEqual(Stored(out).edges, edges)

    def test_other_densities(self):
        rng = np.random.default_rng(4)
        cloud = self.folder / "cloud.csv"
        points = rng.random((300, 3))
        np.savetxt(cloud, np.column_stack([points, rng.integers(1, 9, 300)]), delimiter=",", header="x,y,z,weight",
                   comments="", fmt="%.17g")
        for tiles in 1, 6:
            self.ok("triangulate", cloud, "-o", self.out, "--attributes", "weight", "--overwrite", "--quiet", "--tiles", tiles)
            for by in "density", "density_weight":
                told = self.voids(self.out, "--by", by, "-o", self.folder / "voids.csv", "--overwrite")
                self.assertEqual(told["column"], "zone_" + by)
                stored = Stored(self.out)
                wanted = expected(stored, by)
                self.assertEqual(stored.columns["zone_" + by], wanted.zone)
                self.check_table(table(self.folder / "voids.csv"), wanted, 3)


class ZobovFiles(VoidsTest):
    def test_they_say_what_the_table_says(self):
        rng = np.random.default_rng(5)
        points = np.repeat(rounded(rng.random((200, 3))), 2, axis=0)[rng.permutation(400)]
        out = self.triangulate(points, "1", "--tiles", 5)
        self.voids(out, "-o", self.folder / "voids.csv")
        told = self.voids(out, "-o", self.folder / "voids.txt")
        self.assertEqual(told["files"], [str(self.folder / ("voids" + ending)) for ending in (".zone", ".void", ".txt")])
        rows, files, stored = table(self.folder / "voids.csv"), Zobov(self.folder / "voids.txt"), Stored(out)
        cores = sorted(rows)
        self.assertEqual(files.head, f"400 particles, {len(rows)} voids")
        self.assertEqual(files.counts, (400, len(rows)))
        at = {tuple(place): stored.columns["zone"][vertex] for vertex, place in stored.places.items()}
        self.assertEqual([cores[zone] for zone in files.zone], [at[tuple(place)] for place in points.tolist()])
        self.assertEqual([int(row["CoreParticle"]) for row in files.rows], list(rows))  # both by contrast
        mean = 1 / 400  # the volume of the box, by particles
        wanted = expected(stored, points=self.points_of(points, stored))
        for rank, row in enumerate(files.rows, 1):
            core = int(row["CoreParticle"])
            void, zone = rows[core], int(row["FileVoid#"])
            self.assertEqual((int(row["Void#"]), cores[zone]), (rank, core))
            for name, value in (("CoreDens", void["core_density"] * mean), ("ZoneVol", void["zone_volume"] / mean),
                                ("VoidVol", void["void_volume"] / mean), ("VoidDensContrast", void["contrast"])):
                self.assertAlmostEqual(row[name] / value, 1, delta=2e-6, msg=name)
            self.assertEqual([int(row[name]) for name in ("Zone#Part", "Void#Zones", "Void#Part")],
                             [void["zone_points"], void["void_zones"], void["void_points"]])
            steps, contrast = files.voids[zone]
            self.assertEqual(contrast, void["contrast"])
            self.assertEqual({core}.union(*({cores[i] for i in more} for _, more in steps)), wanted.voids[core]["zones"])
            self.assertEqual(1 + sum(len(more) for _, more in steps), void["void_zones"])
            ratios = [ratio for ratio, _ in steps]
            self.assertEqual(ratios, sorted(ratios))
            self.assertTrue(all(ratio <= contrast for ratio in ratios))

    def test_points_that_are_left_out_have_no_zone(self):
        rng = np.random.default_rng(6)
        points = rng.random((100, 2))
        out = self.triangulate(points, None, "--crop", "0,0,1,0.5")
        self.voids(out, "-o", self.folder / "voids.txt")
        files, zone = Zobov(self.folder / "voids.txt"), Stored(out).columns["zone"]
        cores = sorted(set(zone.values()) - {NONE})
        self.assertEqual(files.zone, [cores.index(zone[i]) if zone.get(i, NONE) != NONE else -1 for i in range(100)])


if __name__ == "__main__":
    unittest.main()
