"""What `tessera voronoi` has written, and clouds for it."""
import collections
import csv
import json
from fractions import Fraction

import numpy as np
from cli import CliTest
from osgeo import ogr

ogr.UseExceptions()
csv.field_size_limit(1 << 30)


def clouds():
    rng = np.random.default_rng(4)
    turn = np.linspace(0, 2 * np.pi, 64, endpoint=False)
    grid = np.stack(np.meshgrid(np.arange(12.0), np.arange(9.0)), -1).reshape(-1, 2)
    return {
        "uniform": rng.random((600, 2)),
        "lattice": grid,
        "map": np.round(rng.random((500, 2)) * 1000, 2) + [885000, 6290000],
        "circle": np.round(np.stack([np.cos(turn), np.sin(turn)], 1), 3),
        "circle and centre": np.concatenate([np.stack([np.cos(turn), np.sin(turn)], 1), [[0, 0]]]),
        "collinear hull": np.concatenate([[[x, 0.0] for x in range(40)], rng.random((80, 2)) * [39, 5]]),
        "duplicates": np.repeat(rng.random((150, 2)), 3, axis=0),
        "far": np.concatenate([rng.random((200, 2)), [[1e9, 3], [-1e9, 7], [5, 1e9], [2, -1e9]]]),
        "thin": np.concatenate([rng.random((200, 2)) * [1000, 1e-6], [[0, 0], [1000, 1]]]),
        # Four places of the Blue Mountains, almost on one circle: rounding puts a corner on a side of a cell.
        "blue mountains": np.array([(150.58333, -33.7), (150.55, -33.7), (150.61213, -33.67847), (150.6, -33.75),
                                    (150.6, -33.71667), (150.3, -34), (150.9, -34), (150.3, -33.4), (150.9, -33.4)]),
        "cocircular": np.array([[3, 4], [4, 3], [5, 0], [4, -3], [3, -4], [0, -5], [-3, -4], [-4, -3], [-5, 0], [-4, 3],
                                [-3, 4], [0, 5]], float),
    }


def rings_of(geometry):
    """The rings of a polygon or multipolygon, as lists of points, the last of which is the first."""
    if geometry is None or geometry.IsEmpty():
        return []
    if geometry.GetGeometryType() in (ogr.wkbMultiPolygon, ogr.wkbMultiPolygon25D):
        return [ring for i in range(geometry.GetGeometryCount()) for ring in rings_of(geometry.GetGeometryRef(i))]
    return [geometry.GetGeometryRef(i).GetPoints() for i in range(geometry.GetGeometryCount())]


def hull_area(points):
    """Of exact corners, as a fraction."""
    corners = sorted(set(map(tuple, points.tolist())))
    chain = []
    for run in corners, corners[::-1]:
        side = []
        for p in run:
            while len(side) > 1 and turn(side[-2], side[-1], p) <= 0:
                side.pop()
            side.append(p)
        chain += side[:-1]
    return ring_area(chain)


def turn(a, b, c):
    (ax, ay), (bx, by), (cx, cy) = [[Fraction(v) for v in p] for p in (a, b, c)]
    return (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)


def ring_area(ring):
    exact = [[Fraction(v) for v in p[:2]] for p in ring]
    return sum(a[0] * b[1] - a[1] * b[0] for a, b in zip(exact, exact[1:] + exact[:1])) / 2


class VoronoiTest(CliTest):
    def triangulate(self, points, *options, name="out"):
        np.save(self.folder / "cloud.npy", points)
        out = self.folder / name
        self.ok("triangulate", self.folder / "cloud.npy", "-o", out, "--overwrite", "--quiet", "--dim", points.shape[1],
                *options)
        return out

    def write_cells(self, out, *options, name="cells.csv"):
        """Returns what the command says of the file."""
        said = self.ok("voronoi", out, "-o", self.folder / name, "--overwrite", "--json", *options)
        return json.loads(said.splitlines()[-1])

    def rows(self, name="cells.csv"):
        with open(self.folder / name, newline="") as file:
            return list(csv.DictReader(file))

    def cells(self, name="cells.csv"):
        """{id: (geometry, row)}"""
        return {int(row["id"]): (ogr.CreateGeometryFromWkt(row["geom"]), row) for row in self.rows(name)}

    def assert_covers(self, cells, area, allowed=0):
        """Polygons are valid; each side is shared with one other polygon, in the other direction, or is on the border.
        Together they have this area. Returns the sides on the border."""
        sides, total, bad = collections.Counter(), Fraction(0), 0
        for vertex, (geometry, row) in cells.items():
            rings = rings_of(geometry)
            if not rings:
                bad += 1
                continue
            self.assertTrue(geometry.IsValid(), (vertex, row["geom"]))
            own = sum(ring_area(ring[:-1]) for ring in rings)  # holes run clockwise
            self.assertGreater(own, 0)
            self.assertAlmostEqual(float(row["area"]) / float(own), 1, delta=1e-12)
            total += own
            for ring in rings:
                for a, b in zip(ring, ring[1:]):
                    sides[a[:2], b[:2]] += 1
        self.assertLessEqual(bad, allowed)
        self.assertEqual(max(sides.values()), 1, "no side twice in one direction")
        if bad == 0:
            self.assertLess(abs(total / Fraction(area) - 1), Fraction(1, 10**9))
        return [side for side in sides if side[::-1] not in sides]
