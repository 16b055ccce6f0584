"""Surfaces as 3D Tiles: the leaves are the surface, and whatever levels are shown side by side, it is closed."""
import collections
import random
import unittest

import numpy as np
import tiles3d
from cli import USAGE
from surfaces import SurfaceTest, read_ply


class Places:
    """Vertices of a surface, by which those of nodes are known again. Where two are nearer than nodes round, they are one
    here: what is closed stays so when vertices become one."""

    def __init__(self, points, rounded):
        self.points, self.rounded, self.size = points, rounded, 8 * rounded
        self.cells = collections.defaultdict(list)
        for i, cell in enumerate(np.floor(points / self.size).astype(int).tolist()):
            self.cells[tuple(cell)].append(i)
        self.first = list(range(len(points)))
        for i, point in enumerate(points):
            for j in self.near(point, 2 * rounded):
                self.first[self.find(j)] = self.find(i)

    def find(self, i):
        while self.first[i] != i:
            self.first[i] = i = self.first[self.first[i]]
        return i

    def near(self, point, within):
        x, y, z = np.floor(point / self.size).astype(int).tolist()
        around = [i for a in (x - 1, x, x + 1) for b in (y - 1, y, y + 1) for c in (z - 1, z, z + 1)
                  for i in self.cells.get((a, b, c), ())]
        return [i for i in around if np.linalg.norm(self.points[i] - point) <= within]

    def known(self, surface):
        """The triangles, by the numbers of places."""
        numbers = []
        for point in surface.positions:
            near = self.near(point, self.rounded)
            assert near, point
            numbers.append(self.find(near[0]))
        return np.array(numbers)[surface.triangles]


def turned(triangles):
    """With the least vertex first; those that have become flat are left out."""
    return [tuple(np.roll(t, -int(np.argmin(t))).tolist()) for t in np.asarray(triangles) if len(set(t.tolist())) == 3]


def open_edges(triangles):
    sums = collections.Counter()
    for a, b, c in triangles:
        for p, q in ((a, b), (b, c), (c, a)):
            sums[min(p, q), max(p, q)] += 1 if p < q else -1
    return [edge for edge, total in sums.items() if total != 0]


def cut(node, dice, refined):
    """Nodes that show all of it together."""
    if node.children and dice.random() < refined:
        return [below for child in node.children for below in cut(child, dice, refined)]
    return [node]


class Levels(SurfaceTest):
    def test_it_is_closed_whatever_levels_are_shown(self):
        digests = set()
        for tiles in (("--tiles", "1"), ("--tiles", "9"), ("--tiles", "6", "--partition", "octree")):
            with self.subTest(tiles=tiles):
                out = self.result("out", "--overwrite", *tiles)
                self.told(out, "-o", "mesh.ply", "--manifold", "--overwrite")
                told = self.told(out, "-o", "levels", "--format", "3dtiles", "--overwrite")
                digests.add(told["digest"])
                document, root = tiles3d.read(self.folder / "levels")
                points, faces, _ = read_ply(self.folder / "mesh.ply")
                nodes = root.all()
                rounded = max(np.linalg.norm(node.surface.step) for node in nodes)
                places = Places(points, rounded)
                names = [places.find(i) for i in range(len(points))]
                self.assertGreater(len(set(names)), 0.97 * len(points))
                known = {node.path: places.known(node.surface) for node in nodes}
                whole = collections.Counter(turned(np.array(names)[faces["corners"]]))
                leaves = collections.Counter(t for leaf in root.leaves() for t in turned(known[leaf.path]))
                self.assertEqual(leaves, whole)
                self.assertEqual(told["triangles"], len(faces))
                self.assertEqual(open_edges(whole.elements()), [])
                self.assertGreater(len(root.children), 1)
                self.assertLess(len(root.surface.triangles), 0.7 * len(faces))
                dice = random.Random(7)
                for trial in range(30):
                    shown = cut(root, dice, trial / 30)
                    self.assertEqual(open_edges(t for node in shown for t in known[node.path].tolist()), [], trial)
                for node in nodes:
                    if node.children:
                        self.assertGreater(node.error, max(child.error for child in node.children))
                    else:
                        self.assertEqual(node.error, 0)
                self.assertLess(root.error, 1)  # metres, of a block of 50
                self.assertEqual(document["extras"]["cells"], len(faces))
        self.assertEqual(len(digests), 1)

    def test_it_is_the_same_whenever_it_is_made(self):
        out = self.result("out", "--tiles", "5")
        for name, *options in (("a", "--threads", "1"), ("b", "--threads", "2", "--memory", "64M")):
            self.told(out, "-o", name, "--format", "3dtiles", *options)
        self.assertEqual(*(sorted((p.name, p.read_bytes()) for p in (self.folder / name).rglob("*.*") if p.is_file()) for name in "ab"))

    def test_what_cannot_be_is_refused(self):
        out = self.result("out", "--tiles", "3")
        self.refused(USAGE, "surface", out, "-o", "levels", "--format", "3dtiles", "--local", says="--local")
        self.write("stands", "here")
        self.refused(USAGE, "surface", out, "-o", "stands", "--format", "3dtiles", says="exists already")
        self.refused(USAGE, "surface", out, "-o", "stands", "--format", "3dtiles", "--overwrite", says="is not a tileset")
        self.assertEqual((self.folder / "stands").read_text(), "here")
        scattered = self.result("scattered", "--tiles", "3", "--partition", "random")
        self.refused(USAGE, "surface", scattered, "-o", "levels", "--format", "3dtiles", says="do not lie side by side")
        self.assertEqual(sorted(path.name for path in self.folder.glob("levels*")), [])


if __name__ == "__main__":
    unittest.main()
