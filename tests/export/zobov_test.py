"""ZOBOV's files and DisPerSE's NDnet, against brute force with copies of the cloud, and read as their programs read."""
import itertools
import json
import struct
import unittest

import numpy as np
from scipy.spatial import Delaunay

from cli import USAGE
from stored import ExportTest


def exact(points):
    return np.round(np.asarray(points, float) * 2**30) / 2**30


def read_vol(path, kind="<f4"):
    count, = struct.unpack("<i", path.read_bytes()[:4])
    volumes = np.frombuffer(path.read_bytes(), kind, offset=4)
    assert len(volumes) == count
    return volumes


def read_adj(path):
    """The neighbours of each point, by the rules by which jozov reads the file."""
    numbers = np.frombuffer(path.read_bytes(), "<i4").tolist()
    count, told, at = numbers[0], numbers[1:1 + numbers[0]], 1 + numbers[0]
    neighbours = [[] for _ in range(count)]
    for i in range(count):
        higher = numbers[at + 1:at + 1 + numbers[at]]
        at += 1 + numbers[at]
        for j in higher:
            assert j > i
            neighbours[i].append(j)
            neighbours[j].append(i)
    assert at == len(numbers)
    assert [len(those) for those in neighbours] == told
    return neighbours


def brute_force(points, period):
    """Cells as lists of (point, offset) by SciPy, of 3 copies along each axis; those with a vertex in the box."""
    d = points.shape[1]
    offsets = np.array(list(itertools.product((0, -1, 1), repeat=d)))
    copies = (points[None] + offsets[:, None] * period).reshape(-1, d)
    n = len(points)
    return [[(int(v) % n, tuple(offsets[v // n])) for v in cell] for cell in Delaunay(copies).simplices if (cell < n).any()]


def watershed(volumes, neighbours):
    """The number of zones: each point flows to its neighbour of least density, if that is less dense than itself."""
    density = 1 / volumes.astype(float)
    return sum(all(density[j] >= density[i] for j in those) for i, those in enumerate(neighbours))


class Zobov(ExportTest):
    def made(self, points, period, *options):
        np.save(self.folder / "cloud.npy", points)
        self.ok("triangulate", "cloud.npy", "-o", self.out, "--overwrite", "--quiet", "--dim", points.shape[1], "--periodic",
                ",".join(map(str, np.broadcast_to(period, points.shape[1]))), *options)
        self.ok("measure", self.out, "--voronoi", "--density")

    def columns(self, *names):
        table = np.load(self.export("table.npy", "--names", ",".join(names)))
        return [table[name] for name in names]

    def test_neighbours_and_volumes_are_those_of_copies(self):
        rng = np.random.default_rng(1)
        for points, period in ((exact(rng.random((300, 3))), 1), (exact(rng.random((200, 3)) * [1, 2, 4]), [1, 2, 4]),
                               (exact(rng.random((300, 2))), 1)):
            self.made(points, period, "--tiles", 5)
            volumes, neighbours = read_vol(self.export("box.vol")), read_adj(self.folder / "box.adj")
            expected = [set() for _ in points]
            for cell in brute_force(points, period):
                for (a, _), (b, _) in itertools.permutations([corner for corner in cell], 2):
                    if a != b and any(corner[0] == a and not any(corner[1]) for corner in cell):
                        expected[a].add(b)
            self.assertEqual([sorted(those) for those in neighbours], [sorted(those) for those in expected])
            self.assertAlmostEqual(volumes.astype(float).mean(), 1, places=6)
            name = "voronoi_volume" if points.shape[1] == 3 else "voronoi_area"
            of_box = np.prod(np.broadcast_to(period, points.shape[1]))
            np.testing.assert_array_equal(volumes, (self.columns(name)[0] / (of_box / len(points))).astype("f4"))
            doubles = read_vol(self.export("big.vol", "--format", "zobov64"), "<f8")
            np.testing.assert_array_equal(doubles.astype("f4"), volumes)
            self.assertEqual((self.folder / "big.adj").read_bytes(), (self.folder / "box.adj").read_bytes())

    def test_points_at_one_place_share_its_volume_and_are_neighbours(self):
        points = exact(np.random.default_rng(2).random((200, 3)))
        points[150] = points[10]
        points[[60, 61]] = points[20] + [1, 0, -1]  # the same place, a period away
        self.made(points, 1, "--tiles", 3)
        volumes, neighbours = read_vol(self.export("box.vol")), read_adj(self.folder / "box.adj")
        self.assertAlmostEqual(volumes.astype(float).mean(), 1, places=6)
        for place in ([10, 150], [20, 60, 61]):
            self.assertEqual(len(set(volumes[place])), 1)
            around = [set(neighbours[i]) | {i} for i in place]
            self.assertTrue(all(those == around[0] for those in around))
            self.assertTrue(set(place) < around[0])
        one, = self.columns("voronoi_volume")
        self.assertEqual(volumes[20], np.float32(one[20] * len(points) / 3))

    def test_an_image_is_no_neighbour_of_its_point(self):
        self.made(np.array([[0.25, 0.5, 0.75]]), 1)
        self.assertEqual(read_adj(self.export("box.vol").with_suffix(".adj")), [[]])
        self.assertEqual(read_vol(self.folder / "box.vol").tolist(), [1])
        self.made(exact(np.random.default_rng(3).random((2, 3))), 1)
        self.export("box.vol")
        self.assertEqual(read_adj(self.folder / "box.adj"), [[1], [0]])

    def test_rows_are_those_of_points_that_were_kept(self):
        points = exact(np.random.default_rng(4).random((300, 3)))
        self.made(points, 1, "--crop", "0,0,0,1,1,0.6", "--tiles", 4)
        self.export("box.vol")
        kept = np.flatnonzero(points[:, 2] <= 0.6)
        made = read_vol(self.folder / "box.vol"), read_adj(self.folder / "box.adj")
        self.made(points[kept], 1)
        self.export("box.vol")
        np.testing.assert_array_equal(read_vol(self.folder / "box.vol"), made[0])
        self.assertEqual(read_adj(self.folder / "box.adj"), made[1])

    def test_refusals_name_the_command_that_helps(self):
        points = exact(np.random.default_rng(5).random((50, 3)))
        np.save(self.folder / "cloud.npy", points)
        self.ok("triangulate", "cloud.npy", "-o", self.out, "--quiet", "--periodic", 1)
        self.refused(USAGE, "export", self.out, "-o", "box.vol", says=["has no volumes of Voronoi cells", "measuring it with --voronoi computes them"])
        self.ok("triangulate", "cloud.npy", "-o", "open", "--quiet", "--periodic", "1,1,0")
        self.refused(USAGE, "export", "open", "-o", "box.vol", says="is not periodic along all axes")
        self.assertFalse((self.folder / "box.vol").exists() or (self.folder / "box.adj").exists())
        self.write("box.adj", "mine")
        self.refused(USAGE, "export", self.out, "-o", "box.vol", says="box.adj: exists already")
        points[:] = points[0]
        np.save(self.folder / "cloud.npy", np.tile(points, (21, 1)))
        self.ok("triangulate", "cloud.npy", "-o", "heap", "--quiet", "--periodic", 1)
        self.ok("measure", "heap", "--voronoi")
        self.refused(USAGE, "export", "heap", "-o", "heap.vol", says="has more than 1000 points at the place of point 0")


class Net:
    """An NDnet, by the rules by which DisPerSE reads the file."""

    def __init__(self, path):
        self.bytes, self.at = path.read_bytes(), 0
        assert self.block(16).rstrip(b"\0") == b"NDNETWORK"
        self.dimension, of_net = struct.unpack("<2i", self.block(8))
        d = self.dimension
        assert of_net == d
        head = self.block(252 + 16 * d)
        self.comment = head[:80].rstrip(b"\0").decode()
        self.periodicity, simplices = struct.unpack_from("<2i", head, 80)
        self.x0, self.delta = np.frombuffer(head, "<f8", 2 * d, 88).reshape(2, d).tolist()
        assert (simplices, *struct.unpack_from("<2i", head, 88 + 16 * d)) == (1, 4, 8)
        vertices, = struct.unpack_from("<I", head, 248 + 16 * d)
        self.points = np.frombuffer(self.block(4 * d * vertices, told=d * vertices), "<f4").reshape(-1, d)
        faces = np.frombuffer(self.block(4 * (d + 1)), "<u4")
        assert (faces[:d] == 0).all() and self.numbers(d + 1) == [0] * d + [1]
        self.cells = np.frombuffer(self.block(4 * (d + 1) * int(faces[d])), "<u4").reshape(-1, d + 1)
        assert self.numbers(d + 1) == [0] * (d + 1) and self.numbers((d + 1) ** 2) == [0] * (d + 1) ** 2
        assert self.numbers(1) == [1] and not any(self.block(vertices))
        assert self.numbers(d + 1) == [0] * d + [1]
        self.flags = np.frombuffer(self.block(int(faces[d])), "u1")
        self.fields = {}
        for _ in range(self.numbers(1)[0]):
            head = self.block(259)
            assert head[:4] == bytes(4)
            self.fields[head[4:].rstrip(b"\0").decode()] = np.frombuffer(self.block(8 * vertices), "<f8")
        assert self.numbers(1) == [0] and self.at == len(self.bytes)

    def block(self, size, told=None):
        begin, = struct.unpack_from("<I", self.bytes, self.at)
        end, = struct.unpack_from("<I", self.bytes, self.at + 4 + size)
        assert begin == end == (size if told is None else told), (begin, end, size)
        self.at += size + 8
        return self.bytes[self.at - size - 4:self.at - 4]

    def numbers(self, count):
        return list(struct.unpack(f"<{count}i", self.block(4 * count)))


class Networks(ExportTest):
    made, columns = Zobov.made, Zobov.columns

    def test_cells_and_fields_are_those_of_the_result(self):
        for d in (2, 3):
            points = exact(np.random.default_rng(d).random((400, d)))
            for tiles in (1, 6):
                self.made(points, 1, "--tiles", tiles)
                net = Net(self.export("box.NDnet"))
                self.assertEqual((net.comment, net.periodicity, net.x0, net.delta), ("delaunay_tesselation", -1, [0] * d, [1] * d))
                np.testing.assert_array_equal(net.points, points.astype("f4"))
                density, = self.columns("density")
                np.testing.assert_array_equal(net.fields["field_value"], density)
                np.testing.assert_allclose(net.fields["log_field_value"], np.log(density), rtol=1e-15)
                expected = {tuple(sorted(i for i, _ in cell)) for cell in brute_force(points, 1)}
                found = [tuple(sorted(cell)) for cell in net.cells.tolist()]
                self.assertEqual(len(found), len(set(found)))
                self.assertEqual(set(found), expected)
                self.assertEqual(found, sorted(found))
                # A cell that is cut by the border has vertices more than half of the box apart.
                corners = points[net.cells]
                far = (np.ptp(corners, axis=1) > 0.5).any(axis=1)
                np.testing.assert_array_equal(net.flags, np.where(far, 2, 0))
                self.assertTrue((np.linalg.det((corners[:, 1:] - corners[:, :1])[~far]) > 0).all())

    def test_other_fields_and_open_axes(self):
        side = np.arange(8) / 8
        hull = np.stack(np.meshgrid(side, [0, 1], side, indexing="ij"), -1).reshape(-1, 3)  # without slivers
        points = exact(np.vstack([np.random.default_rng(7).random((300, 3)), hull]))
        np.save(self.folder / "cloud.npy", points)
        self.ok("triangulate", "cloud.npy", "-o", self.out, "--quiet", "--periodic", "1,0,1", "--tiles", 3)
        self.ok("measure", self.out, "--voronoi", "--density")
        net = Net(self.export("strip.NDnet", "--names", "density,voronoi_neighbours"))
        self.assertEqual(net.periodicity, 0b101)
        self.assertEqual(net.x0, [0, points[:, 1].min(), 0])
        self.assertEqual(net.delta, [1, np.ptp(points[:, 1]), 1])
        self.assertEqual(list(net.fields), ["field_value", "log_field_value", "voronoi_neighbours"])
        np.testing.assert_array_equal(net.fields["voronoi_neighbours"], self.columns("voronoi_neighbours")[0])

    def test_coordinates_stay_below_the_period(self):
        points = exact(np.random.default_rng(8).random((60, 3)))
        points[0] = 1 - 2.0**-40
        self.made(points, 1)
        net = Net(self.export("box.NDnet"))
        self.assertEqual(net.points[0].tolist(), [1 - 2.0**-24] * 3)

    def test_duplicates_are_no_vertices(self):
        points = exact(np.random.default_rng(9).random((200, 3)))
        points[100] = points[5]
        self.made(points, 1, "--tiles", 2)
        net = Net(self.export("box.NDnet"))
        np.testing.assert_array_equal(net.points, np.delete(points, 100, axis=0).astype("f4"))

    def test_clouds_of_too_few_points_are_refused(self):
        for n, says in ((1, "has a cell with two images of one point"), (5, "")):
            self.made(exact(np.random.default_rng(n).random((n, 3))), 1)
            self.refused(USAGE, "export", self.out, "-o", "few.ndnet", says=[says, "more points make cells shorter than a period"])
            self.assertFalse((self.folder / "few.ndnet").exists())


if __name__ == "__main__":
    unittest.main()
