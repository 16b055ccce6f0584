"""tessera alpha: meshes and polygons against all cells, by exact fractions and GEOS; for any tiling the same bytes."""
import collections
import json
import math
import unittest
from fractions import Fraction

import numpy as np
from cli import CORRUPT, USAGE, CliTest
from osgeo import gdal, ogr
from stored import Stored

gdal.UseExceptions()
TILINGS = (("1",), ("60",), ("9", "--partition", "random"), ("7", "--store", "points"))


def clouds(d):
    rng = np.random.default_rng(3)
    side = 9 if d == 2 else 4
    lattice = np.stack(np.meshgrid(*[np.arange(side, dtype=float)] * d), -1).reshape(-1, d)
    uniform = rng.random((150, d))
    angle = np.arange(24) * (math.pi / 12)
    circles = np.concatenate([np.c_[np.cos(angle), np.sin(angle)] + at for at in ((0, 0), (2.5, 0), (0, 2.5))])
    yield "lattice", lattice
    yield "uniform", uniform
    yield "gaps", lattice[rng.random(len(lattice)) < 0.7]
    yield "duplicates", np.concatenate([lattice, lattice[::3]])
    yield "far", np.concatenate([uniform, [[1e9] * d, [-1e9] + [0] * (d - 1)]])
    if d == 2:
        yield "circles", circles
        yield "frame", lattice[(lattice % 4 < 1).any(axis=1)]


def squared_radius(corners):
    """N and D such that the squared circumradius is N / (4 D), for a cell of Fractions."""
    a, *rest = [[Fraction(x) for x in corner] for corner in corners]
    s = [[x - y for x, y in zip(corner, a)] for corner in rest]
    dot = lambda p, q: sum(x * y for x, y in zip(p, q))
    if len(s) == 2:
        third = [x - y for x, y in zip(*s)]
        return dot(s[0], s[0]) * dot(s[1], s[1]) * dot(third, third), (s[0][0] * s[1][1] - s[0][1] * s[1][0])**2
    cross = lambda p, q: [p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0]]
    normals = cross(s[1], s[2]), cross(s[2], s[0]), cross(s[0], s[1])
    centre = [sum(dot(e, e) * n[i] for e, n in zip(s, normals)) for i in range(3)]
    return dot(centre, centre), dot(s[0], normals[0])**2


def read_ply(path):
    """ids of vertices, {element: list of (ids of vertices, singular or None)}"""
    data = path.read_bytes()
    end = data.index(b"end_header\n") + 11
    head = data[:end].decode().split("\n")
    elements = [(line.split()[1], int(line.split()[2])) for line in head if line.startswith("element")]
    singular = "property uchar singular" in head
    vertices = np.frombuffer(data, [("at", "<f8", 3), ("id", "<u4")], elements[0][1], end)
    at, found = end + vertices.nbytes, {}
    more = [("singular", "u1")] if singular else []
    for name, count in elements[1:]:
        row = np.dtype([("n", "u1"), ("v", "<u4", 3), *more] if name == "face" else [("v", "<u4", 2), *more])
        rows = np.frombuffer(data, row, count, at)
        at += rows.nbytes
        found[name] = [(tuple(vertices["id"][v].tolist()), bool(s)) for v, s in
                       zip(rows["v"], rows["singular"] if singular else np.zeros(count))]
    assert at == len(data)
    return dict(zip(vertices["id"].tolist(), map(tuple, vertices["at"].tolist()))), found


class Command(CliTest):
    def triangulate(self, points, *tiling):
        np.save(self.folder / "cloud.npy", points)
        self.ok("triangulate", self.folder / "cloud.npy", "-o", self.out, "--overwrite", "--quiet", "--dim", points.shape[1],
                "--tiles", *tiling)

    def alpha(self, name, *options):
        told = self.ok("alpha", self.out, "-o", name, "--overwrite", "--json", *options)
        return json.loads(told.splitlines()[-1]), self.folder / name

    def boundary(self, stored, radius):
        """The cells of the shape, and the boundary: sorted ids of facets."""
        d = stored.dimension
        cells = []
        for cell in stored.cells:
            n, q = squared_radius([stored.points[v][:d] for v in cell])
            if n <= 4 * Fraction(radius)**2 * q:
                cells.append(cell)
        facets = collections.Counter(tuple(sorted(cell[:k] + cell[k + 1:])) for cell in cells for k in range(d + 1))
        return cells, sorted(facet for facet, n in facets.items() if n == 1)

    def test_meshes_are_the_boundary_of_the_cells(self):
        for d in 2, 3:
            element = "edge" if d == 2 else "face"
            for name, points in clouds(d):
                self.triangulate(points, "1")
                stored = Stored(self.out)
                told, _ = self.alpha("auto.ply", "--alpha", "auto")
                auto = told["radius"]
                radii = {auto, math.nextafter(auto, 0), math.sqrt(d) / 2, math.nextafter(math.sqrt(d) / 2, 0), 0.08}
                expected = {radius: self.boundary(stored, radius) for radius in radii}
                bytes_of = {}
                for tiling in TILINGS:
                    self.triangulate(points, *tiling)
                    for radius, (cells, facets) in expected.items():
                        with self.subTest(dimension=d, cloud=name, tiling=tiling, radius=radius):
                            if not cells:
                                self.refused(USAGE, "alpha", self.out, "--alpha", repr(radius), "-o", "no.ply",
                                             says=["no cell", "--alpha"])
                                continue
                            told, path = self.alpha("a.ply", "--alpha", repr(radius), "--threads", len(tiling))
                            self.assertEqual(told["cells"], len(cells))
                            vertices, found = read_ply(path)
                            self.assertEqual(sorted(tuple(sorted(f)) for f, _ in found[element]), facets)
                            self.assertEqual(set(vertices), {v for f in facets for v in f})
                            self.assertEqual([f for f, _ in found[element]], sorted(f for f, _ in found[element]))
                            self.assertEqual(bytes_of.setdefault(radius, path.read_bytes()), path.read_bytes())
                            self.closed(found[element])
                    told, path = self.alpha("auto.ply", "--alpha", "auto", "--threads", len(tiling))
                    self.assertEqual(told["radius"], auto)
                    self.assertEqual(bytes_of[auto], path.read_bytes())

    def closed(self, facets):
        balance = collections.Counter()
        for facet, _ in facets:
            if len(facet) == 2:
                balance[facet[0]] += 1
                balance[facet[1]] -= 1
                continue
            for a, b in zip(facet, facet[1:] + facet[:1]):
                balance[min(a, b), max(a, b)] += 1 if a < b else -1
        self.assertFalse(any(balance.values()))

    def test_auto_is_the_least_radius_of_one_piece_with_all_points(self):
        for d in 2, 3:
            for name, points in clouds(d):
                with self.subTest(dimension=d, cloud=name):
                    self.triangulate(points, "5")
                    stored = Stored(self.out)
                    told, _ = self.alpha("a.ply", "--alpha", "auto")
                    self.assertTrue(told["searched"])
                    radii = sorted((rounded_up(*squared_radius([stored.points[v][:d] for v in cell])), cell)
                                   for cell in stored.cells)
                    self.assertEqual(told["radius"], least(radii, set(stored.points)))

    def test_polygons_are_valid_and_cover_the_cells(self):
        for name, points in clouds(2):
            self.triangulate(points, "1")
            stored = Stored(self.out)
            auto = self.alpha("auto.ply", "--alpha", "auto")[0]["radius"]
            texts = {}
            expected = {radius: self.boundary(stored, radius) for radius in (auto, math.nextafter(auto, 0), 0.08, math.sqrt(0.5), 1.2)}
            for tiling in TILINGS:
                self.triangulate(points, *tiling)
                for radius, (cells, facets) in expected.items():
                    if not cells:
                        continue
                    area = sum(abs(Fraction(1, 2) * doubled([stored.points[v] for v in cell])) for cell in cells)
                    with self.subTest(cloud=name, tiling=tiling, radius=radius):
                        told, path = self.alpha("a.geojson", "--alpha", repr(radius), "--threads", len(tiling))
                        self.assertEqual(texts.setdefault(radius, path.read_bytes()), path.read_bytes())
                        self.assertEqual(told["cells"], len(cells))
                        polygons = self.polygons(path)
                        self.assertEqual(len(polygons), pieces(cells))
                        edges = sorted(tuple(sorted(edge)) for rings in polygons for ring in rings for edge in zip(ring, ring[1:]))
                        at = stored.points
                        self.assertEqual(edges, sorted(tuple(sorted((at[u][:2], at[v][:2]))) for u, v in facets))
                        self.assertEqual(sum(doubled_ring(ring) for rings in polygons for ring in rings), 2 * area)
                        for rings in polygons:
                            self.assertTrue(doubled_ring(rings[0]) > 0 and all(doubled_ring(ring) < 0 for ring in rings[1:]))

    def polygons(self, path):
        """The rings, after GEOS has found the polygons valid, one by one and all together."""
        source = gdal.OpenEx(str(path))
        together, found = ogr.Geometry(ogr.wkbMultiPolygon), []
        for feature in source.GetLayer(0):
            polygon = feature.GetGeometryRef()
            self.assertTrue(polygon.IsValid())
            self.assertEqual(feature["holes"], polygon.GetGeometryCount() - 1)
            together.AddGeometry(polygon)
            found.append([polygon.GetGeometryRef(i).GetPoints() for i in range(polygon.GetGeometryCount())])
        self.assertTrue(together.IsValid())
        return found

    def test_map_files_have_the_same_polygons(self):
        self.triangulate(np.delete(dict(clouds(2))["lattice"], [20, 40, 60], axis=0), "7")
        expected = self.polygons(self.alpha("a.geojson", "--alpha", "0.8")[1])
        self.assertGreater(sum(map(len, expected)), len(expected))  # there are holes
        for name in "a.gpkg", "a.fgb", "a.json":
            self.assertEqual(sorted(map(normal, self.polygons(self.alpha(name, "--alpha", "0.8")[1]))), sorted(map(normal, expected)))
        told, path = self.alpha("a.gpkg", "--alpha", "0.6", "--general")
        source = gdal.OpenEx(str(path))
        self.assertEqual([source.GetLayer(i).GetName() for i in range(3)], ["alpha_shape", "singular_edges", "singular_vertices"])
        self.assertEqual([source.GetLayer(i).GetFeatureCount() for i in (1, 2)], [told["singular_facets"], told["singular_vertices"]])
        self.assertGreater(told["singular_facets"], 0)
        mesh = read_ply(self.alpha("a.ply", "--alpha", "0.6", "--general")[1])[1]["edge"]
        self.assertEqual(sum(singular for _, singular in mesh), told["singular_facets"])

    def test_wrong_input_is_refused(self):
        self.triangulate(np.random.default_rng(1).random((100, 3)), "2")
        for wrong in "0", "-1", "nan", "inf", "1e999", "x":
            self.refused(USAGE, "alpha", self.out, "--alpha=" + wrong, "-o", "a.ply", says="--alpha")
        self.refused(USAGE, "alpha", self.out, "-o", "a.ply", says="--alpha")
        self.refused(USAGE, "alpha", self.out, "--alpha", "1", says="-o")
        self.refused(USAGE, "alpha", self.out, "--alpha", "1", "-o", "a.obj", says=["a.obj", ".ply"])
        self.refused(USAGE, "alpha", self.out, "--alpha", "1", "-o", "a.gpkg", says=["3D", ".ply"])
        self.refused(USAGE, "alpha", self.out, "--alpha", "1", "-o", "a.fgb", "--general", says=["--general", ".gpkg"])
        self.refused(USAGE, "alpha", self.out, "--alpha", "1e-9", "-o", "a.ply", says=["no cell", "--alpha"])
        self.ok("alpha", self.out, "--alpha", "1", "-o", "a.ply")
        self.refused(USAGE, "alpha", self.out, "--alpha", "1", "-o", "a.ply", says=["exists", "--overwrite"])
        (self.folder / "a.ply").unlink()
        tile = next((self.out / "tiles").glob("*.vtu"))
        tile.write_bytes(tile.read_bytes()[:-1000])
        self.refused(CORRUPT, "alpha", self.out, "--alpha", "1", "-o", "a.ply", says=tile.name)
        self.assertEqual([path.name for path in self.folder.iterdir() if "a.ply" in path.name], [])


def doubled(corners):
    (a, b), (c, d), (e, f) = [[Fraction(x) for x in corner[:2]] for corner in corners]
    return (c - a) * (f - b) - (d - b) * (e - a)


def doubled_ring(ring):
    at = [(Fraction(p[0]), Fraction(p[1])) for p in ring]
    return sum(a[0] * b[1] - a[1] * b[0] for a, b in zip(at, at[1:]))


def normal(rings):
    """Rings in any order, from any vertex on, in any direction."""
    return sorted(tuple(sorted(ring[1:])) for ring in rings)


def rounded_up(n, q):
    square = n / (4 * q)
    root = math.sqrt(square)
    while Fraction(root)**2 < square:
        root = math.nextafter(root, math.inf)
    while Fraction(math.nextafter(root, 0))**2 >= square:
        root = math.nextafter(root, 0)
    return root


def pieces(cells):
    parent = list(range(len(cells)))

    def find(i):
        while parent[i] != i:
            parent[i] = i = parent[parent[i]]
        return i

    by_facet = {}
    for i, cell in enumerate(cells):
        for k in range(len(cell)):
            other = by_facet.setdefault(tuple(sorted(cell[:k] + cell[k + 1:])), i)
            parent[find(i)] = find(other)
    return sum(find(i) == i for i in range(len(cells)))


def least(radii, vertices):
    """The least radius for which all vertices are in one piece."""
    for radius in sorted({radius for radius, _ in radii}):
        cells = [cell for r, cell in radii if r <= radius]
        if len({v for cell in cells for v in cell}) == len(vertices) and pieces(cells) == 1:
            return radius
    return None


if __name__ == "__main__":
    unittest.main()
