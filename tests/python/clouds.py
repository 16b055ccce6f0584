"""Points to triangulate, and what a Delaunay triangulation is, checked in integers: nothing here is rounded."""
import fractions
import math

import numpy as np


def random(n, dim, seed=1):
    """In general position, as good as surely."""
    return np.random.default_rng(seed).random((n, dim))


def lattice(side, dim):
    """All points of a side^dim grid, shuffled: many cospherical, many on one plane. Its hull has the volume (side-1)^dim."""
    axes = np.meshgrid(*[np.arange(float(side))] * dim)
    points = np.stack(axes, axis=-1).reshape(-1, dim)
    return np.random.default_rng(3).permutation(points)


def simplex_set(simplices):
    return {tuple(sorted(row)) for row in np.asarray(simplices).tolist()}


def integers(points):
    """The points times one power of two that makes them integers, and that power."""
    exact = [[fractions.Fraction(x) for x in row] for row in np.asarray(points).tolist()]
    scale = max(x.denominator for row in exact for x in row)
    return [[int(x * scale) for x in row] for row in exact], scale


def determinant(rows):
    if len(rows) == 1:
        return rows[0][0]
    return sum((-1) ** k * rows[0][k] * determinant([row[:k] + row[k + 1 :] for row in rows[1:]])
               for k in range(len(rows)) if rows[0][k])


def edges_from(points, simplex):
    first = points[simplex[0]]
    return [[a - b for a, b in zip(points[corner], first)] for corner in simplex[1:]]


def volumes(points, simplices):
    """dim! times the signed volumes, in the unit of integers(points)^dim."""
    return [determinant(edges_from(points, simplex)) for simplex in np.asarray(simplices).tolist()]


def lift(vector):
    return vector + [sum(x * x for x in vector)]


def points_inside_spheres(points, simplices):
    """(simplex, point) for each point strictly inside the circumsphere of a simplex. `points` from integers()."""
    inside = []
    for simplex in np.asarray(simplices).tolist():
        first = points[simplex[0]]
        rows = [lift(edge) for edge in edges_from(points, simplex)]
        size = len(rows[0])
        normal = [(-1) ** k * determinant([row[:k] + row[k + 1 :] for row in rows]) for k in range(size)]
        up = 1 if normal[-1] > 0 else -1
        for index, point in enumerate(points):
            lifted = lift([a - b for a, b in zip(point, first)])
            if up * sum(a * b for a, b in zip(normal, lifted)) < 0:
                inside.append((tuple(simplex), index))
    return inside


def assert_delaunay(test, points, simplices, volume):
    """All simplices positive, their spheres empty, their volumes adding up to `volume`, that of the hull."""
    exact, scale = integers(points)
    dim = len(exact[0])
    each = volumes(exact, simplices)
    test.assertGreater(min(each), 0)
    test.assertEqual(fractions.Fraction(sum(each), scale**dim * math.factorial(dim)), volume)
    test.assertEqual(points_inside_spheres(exact, simplices), [])
