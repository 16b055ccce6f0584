"""Solids that are known exactly, and a scanner that sees them: points with noise along the ray, and their sensors."""

import numpy as np


class Sphere:
    bounds = (np.array([-1.3] * 3), np.array([1.3] * 3))

    def distance(self, p):  # signed: negative inside
        return np.linalg.norm(p, axis=1) - 1


class Torus:
    bounds = (np.array([-1.6, -1.6, -0.6]), np.array([1.6, 1.6, 0.6]))

    def distance(self, p):
        ring = np.hypot(p[:, 0], p[:, 1]) - 1
        return np.hypot(ring, p[:, 2]) - 0.4


def box(p, lo, hi):
    lo, hi = np.asarray(lo, float), np.asarray(hi, float)
    q = np.abs(p - (lo + hi) / 2) - (hi - lo) / 2
    return np.linalg.norm(np.maximum(q, 0), axis=1) + np.minimum(q.max(axis=1), 0)


class Wall:
    """An L of two walls that stand on nothing."""

    bounds = (np.array([-0.5, -0.5, -0.5]), np.array([3.5, 2.5, 2.0]))

    def distance(self, p):
        return np.minimum(box(p, (0, 0, 0), (3, 0.5, 1.5)), box(p, (0, 0, 0), (0.5, 2, 1.5)))


class City:
    """Houses with eaves on flat ground."""

    bounds = (np.array([1.0, 1.0, 0.1]), np.array([29.0, 29.0, 9.0]))
    houses = [((4, 4), (12, 10), 5), ((16, 5), (25, 13), 7), ((6, 16), (14, 26), 4), ((18, 18), (26, 25), 6)]

    def seen(self, p):
        """From above: not below eaves, where no pulse comes."""
        hidden = np.zeros(len(p), bool)
        for (x0, y0), (x1, y1), h in self.houses:
            over = (p[:, :2] > np.array([x0 - 0.5, y0 - 0.5])) & (p[:, :2] < np.array([x1 + 0.5, y1 + 0.5]))
            hidden |= over.all(axis=1) & (p[:, 2] < h + 0.05)
        return ~hidden

    def distance(self, p):
        d = p[:, 2].copy()
        for (x0, y0), (x1, y1), h in self.houses:
            d = np.minimum(d, box(p, (x0, y0, -1), (x1, y1, h)))
            d = np.minimum(d, box(p, (x0 - 0.4, y0 - 0.4, h), (x1 + 0.4, y1 + 0.4, h + 0.5)))
        return d


def scan(solid, origins, directions, noise, random, reach=200.0):
    """By sphere tracing: (points, sensors) of the rays that meet the solid."""
    directions = directions / np.linalg.norm(directions, axis=1)[:, None]
    along = np.zeros(len(origins))
    open_ = np.ones(len(origins), bool)
    for _ in range(400):
        d = solid.distance(origins[open_] + along[open_, None] * directions[open_])
        along[open_] += d
        done = (d < 1e-6) | (along[open_] > reach)
        open_[np.flatnonzero(open_)[done]] = False
        if not open_.any():
            break
    hit = along < reach
    at = origins[hit] + (along[hit] + random.normal(0, noise, hit.sum()))[:, None] * directions[hit]
    return at, origins[hit]


def around(solid, n, noise, seed):
    """From positions all around, at the solid."""
    random = np.random.default_rng(seed)
    lo, hi = solid.bounds
    middle, size = (lo + hi) / 2, np.linalg.norm(hi - lo)
    stations = random.normal(size=(40, 3))
    stations = middle + size * stations / np.linalg.norm(stations, axis=1)[:, None]
    origins = stations[random.integers(0, len(stations), n)]
    targets = random.uniform(lo, hi, (n, 3))
    return scan(solid, origins, targets - origins, noise, random)


def flown(solid, n, noise, seed):
    """From lines flown across at a height of 60, looking down and to all sides, 45 degrees at most."""
    random = np.random.default_rng(seed)
    lo, hi = np.array([0, 0, 0]), np.array([30, 30, 0])
    targets = random.uniform(lo, hi, (n, 3))
    height = 60
    offset = random.uniform(-1, 1, (n, 2)) * height
    origins = np.column_stack([targets[:, :2] + offset, np.full(n, height)])
    at, sensors = scan(solid, origins, targets - origins, noise, random)
    inside = (at[:, 0] > 0) & (at[:, 0] < 30) & (at[:, 1] > 0) & (at[:, 1] < 30)
    return at[inside], sensors[inside]


def write_ply(path, points, sensors):
    names = ["x", "y", "z", "x_origin", "y_origin", "z_origin"]
    with open(path, "wb") as file:
        head = ["ply", "format binary_little_endian 1.0", f"element vertex {len(points)}"]
        head += [f"property double {name}" for name in names] + ["end_header"]
        file.write(("\n".join(head) + "\n").encode())
        file.write(np.column_stack([points, sensors]).astype("<f8").tobytes())


def read_mesh(path):
    """Of a binary PLY: (vertices, triangles)."""
    with open(path, "rb") as file:
        types = {"double": "<f8", "float": "<f4", "int": "<i4", "uint": "<u4", "uchar": "u1", "char": "i1",
                 "short": "<i2", "ushort": "<u2"}
        fields, vertices, faces, of_vertex = [], 0, 0, False
        of_face = []
        for line in iter(file.readline, b"end_header\n"):
            words = line.decode().split()
            if words[:2] == ["element", "vertex"]:
                vertices, of_vertex = int(words[2]), True
            elif words[:2] == ["element", "face"]:
                faces, of_vertex = int(words[2]), False
            elif words[0] == "property" and words[1] == "list":
                of_face += [("n", "u1"), ("v", types[words[3]], 3)]
            elif words[0] == "property":
                (fields if of_vertex else of_face).append((words[2], types[words[1]]))
        table = np.frombuffer(file.read(vertices * np.dtype(fields).itemsize), fields)
        rows = np.frombuffer(file.read(), of_face, faces)
    return np.column_stack([table[c] for c in "xyz"]), rows["v"].astype(np.int64)
