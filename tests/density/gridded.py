"""Runs `tessera density`, and reads what it has made of which cells."""
import json

import numpy as np
from cli import CliTest


class DensityTest(CliTest):
    def triangulate(self, points, *options, names=(), out=None):
        """`points` may have more columns than coordinates: attributes with these names."""
        out = out or self.out
        points = np.asarray(points, dtype=float)
        d = points.shape[1] - len(names)
        cloud = self.folder / "cloud.txt"
        rows = [" ".join(map(repr, row)) for row in points.tolist()]
        cloud.write_text("\n".join([" ".join([*"xyz"[:d], *names]), *rows]) + "\n")
        self.ok("triangulate", cloud, "-o", out, "--overwrite", "--quiet", "--dim", d,
                *(("--attributes", ",".join(names)) if names else ()), *options)
        return out

    def cells(self):
        """Points, cells and attributes of the result, by the export."""
        self.ok("export", self.out, "-o", self.folder / "arrays", "--format", "npy", "--overwrite", "--quiet")
        return {path.stem: np.load(path) for path in (self.folder / "arrays").iterdir()}

    def grid(self, *options, out=None, name="grid.npy"):
        """The array, with the same axes as a voxel's number: [x][y][z]; and what the command says."""
        said = json.loads(self.ok("density", out or self.out, "-o", self.folder / name, "--overwrite", "--json",
                                  *options).splitlines()[-1])
        values = np.load(self.folder / name)
        d = len(said["size"])
        return values.transpose(*range(d - 1, -1, -1), *range(d, values.ndim)), said

    def first(self, said):
        """The number of the first voxel."""
        return np.rint(np.array(said["origin"]) / said["res"]).astype(int)


def lattice(side, d, step=1.0):
    return np.stack(np.meshgrid(*[np.arange(float(side)) * step] * d, indexing="ij"), -1).reshape(-1, d)


def clouds(d):
    """Small ones, which fractions can take."""
    rng = np.random.default_rng(d)
    n = 30 if d == 2 else 9
    line = np.linspace(0, 1, 7)[:, None] * np.ones(d) + rng.normal(size=(7, d)) * 1e-9
    return {"lattice": (lattice(4 if d == 2 else 3, d), 1.0),
            "lattice, other voxels": (lattice(4 if d == 2 else 3, d, 0.1), 0.07),
            "random": (rng.random((n, d)), 0.3),
            "large cells": (rng.random((d + 2, d)) * 2, 0.25 if d == 2 else 0.4),
            "small cells": (rng.random((n, d)) * 0.1, 0.7),
            "far outlier": (np.vstack([rng.random((n - 1, d)), np.full((1, d), 40.0)]), 9.7),
            "slivers": (np.vstack([line, np.eye(d)]), 0.21 if d == 2 else 0.31),
            "far from the origin": (rng.random((n, d)) + 1e6, 0.3)}
