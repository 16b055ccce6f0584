"""Alpha shapes of periodic clouds equal those of the middle one of 3 copies along each axis that has a period."""
import itertools
import pathlib
import tempfile
import unittest

import numpy as np
import tessera


def canonical(corners, even=False):
    """A face as (id, offset) pairs, shifted such that its least vertex has the offset 0; with `even`, turned, not sorted."""
    least = min(corners)[1]
    moved = [(i, tuple(int(a - b) for a, b in zip(o, least))) for i, o in corners]
    if not even:
        return tuple(sorted(moved))
    first = moved.index(min(moved))
    return tuple(moved[first:] + moved[:first])


def faces_of(shape, offsets, ids, oriented):
    """By kind: the set of faces; each must be there once."""
    found = {}
    for kind in "facets", "singular_facets", "singular_edges", "singular_vertices":
        found[kind] = [canonical([(int(ids[v]), tuple(int(n) for n in offsets[v])) for v in np.atleast_1d(row)],
                                 oriented and kind == "facets") for row in getattr(shape, kind)]
    return found


def copied(points, periods):
    """The points with offsets -1, 0 and 1 along the axes that have a period, and the offsets."""
    offsets = np.array(list(itertools.product(*[(-1, 0, 1) if length else (0,) for length in periods])))
    return np.concatenate([points + offset * periods for offset in offsets]), np.repeat(offsets, len(points), axis=0)


def clouds(d):
    rng = np.random.default_rng(4)
    side = 6 if d == 2 else 3
    lattice = np.stack(np.meshgrid(*[np.arange(side, dtype=float)] * d), -1).reshape(-1, d)
    uniform = rng.integers(0, 2**16, (40, d)) * side / 2**16
    for periods in ([side] * d, [side] + [0] * (d - 1), [0] * (d - 1) + [side]):
        yield "uniform", uniform, np.array(periods, float)
        yield "lattice with gaps", lattice[rng.random(len(lattice)) < 0.8], np.array(periods, float)
    yield "few", uniform[:3], np.array([side] * d, float)
    yield "one", uniform[:1], np.array([side] * d, float)


class PeriodicAlpha(unittest.TestCase):
    def test_shapes_are_those_of_copies(self):
        self.found = dict.fromkeys(("facets", "singular_facets", "singular_edges", "singular_vertices"), 0)
        for d in 2, 3:
            for name, points, periods in clouds(d):
                copies, offsets = copied(points, periods)
                with tessera.triangulate(copies) as big:
                    for tiles in 1, 7:
                        with tessera.triangulate(points, periodic=tuple(periods), tiles=tiles) as t:
                            auto = t.alpha_shape().radius
                            for radius in auto, np.nextafter(auto, 0), 0.6, 0.9:
                                with self.subTest(dimension=d, cloud=name, periods=list(periods), tiles=tiles, radius=radius):
                                    self.compare(t, big, len(points), periods, offsets, radius)
        self.assertGreater(min(self.found.values()), 10, self.found)

    def compare(self, t, big, n, periods, offsets, radius):
        shape = t.alpha_shape(alpha=radius, general=True)
        by = np.zeros_like(shape.points, int)
        for axis in np.flatnonzero(periods):
            by[:, axis] = np.floor(shape.points[:, axis] / periods[axis])
        got = faces_of(shape, by, shape.ids, True)
        expected = big.alpha_shape(alpha=radius, general=True)
        of = offsets[expected.ids]
        ids = expected.ids % n
        for kind, faces in got.items():
            self.assertEqual(len(faces), len(set(faces)), kind)
            self.found[kind] += len(faces)
            rows = [np.atleast_1d(row) for row in getattr(expected, kind)]
            # The copy whose least vertex is in the middle.
            middle = {canonical([(int(ids[v]), tuple(int(x) for x in of[v])) for v in row], kind == "facets") for row in rows
                      if min((int(ids[v]), tuple(of[v])) for v in row)[1] == (0,) * len(periods)}
            self.assertEqual(set(faces), middle, kind)

    def test_auto_is_the_least_radius_of_one_piece(self):
        for d in 2, 3:
            for name, points, periods in clouds(d):
                radii = set()
                for tiles in 1, 7:
                    with self.subTest(dimension=d, cloud=name, periods=list(periods), tiles=tiles), \
                            tessera.triangulate(points, periodic=tuple(periods), tiles=tiles) as t:
                        radii.add(t.alpha_shape().radius)
                        self.assertEqual(len(radii), 1)
                        cells = {}
                        for tile in t:
                            by = tile.offsets if tile.offsets is not None else np.zeros_like(tile.points, int)
                            for cell in tile.cells[~tile.ghost]:
                                corners = tile.points[cell]
                                edges = corners[1:] - corners[0]
                                centre = np.linalg.solve(edges, (edges**2).sum(1) / 2)
                                cells[canonical([(int(tile.ids[v]), tuple(int(x) for x in by[v])) for v in cell])] = np.linalg.norm(centre)
                        self.assertAlmostEqual(radii.copy().pop(), least(cells, set(range(len(points)))), places=9)

    def test_a_file_of_images_and_what_it_refuses(self):
        points = np.random.default_rng(5).integers(0, 2**16, (50, 2)) / 2**14
        with tempfile.TemporaryDirectory() as folder, tessera.triangulate(points, periodic=4) as t:
            path = pathlib.Path(folder) / "shape.ply"
            radius = t.alpha_shape(path)
            data = path.read_bytes()
            end = data.index(b"end_header\n") + 11
            head = data[:end].decode()
            count = int(head.split("element vertex ")[1].split()[0])
            vertices = np.frombuffer(data, [("at", "<f8", 3), ("id", "<u4"), ("by", "i1", 3)], count, end)
            np.testing.assert_array_equal(vertices["at"][:, :2], points[vertices["id"]] + 4 * vertices["by"][:, :2])
            self.assertEqual(count, len(t.alpha_shape(alpha=radius).ids))
            with self.assertRaisesRegex(tessera.UsageError, "the shape of a periodic cloud need not have"):
                t.alpha_shape(pathlib.Path(folder) / "shape.geojson", alpha=1)


def least(cells, points):
    """The least radius at which the cells up to it are one piece that has all points, by trying all."""
    ordered = sorted(cells, key=cells.get)
    facets = {}
    parent = {}

    def find(cell):
        while parent[cell] != cell:
            cell = parent[cell]
        return cell
    pieces, seen = 0, set()
    for k, cell in enumerate(ordered):
        parent[cell] = cell
        pieces += 1
        seen |= {i for i, _ in cell}
        for drop in range(len(cell)):
            facet = canonical(cell[:drop] + cell[drop + 1:])
            for other in facets.setdefault(facet, []):
                a, b = find(cell), find(other)
                if a != b:
                    parent[a] = b
                    pieces -= 1
            facets[facet].append(cell)
        last = k + 1 == len(ordered) or cells[ordered[k + 1]] > cells[cell] * (1 + 1e-12)
        if last and pieces == 1 and seen == points:
            return cells[cell]
    raise AssertionError("never one piece")


if __name__ == "__main__":
    unittest.main()
