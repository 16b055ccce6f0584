"""Means of linear functions over pixels and voxels with fractions: simplices are cut into simplices, without rounding."""
import fractions
import math

Q = fractions.Fraction


def determinant(rows):
    if len(rows) == 2:
        return rows[0][0] * rows[1][1] - rows[0][1] * rows[1][0]
    (a, b, c), (d, e, f), (g, h, i) = rows
    return a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g)


def volume(simplex, d):
    return abs(determinant([[x - y for x, y in zip(p[:d], simplex[0][:d])] for p in simplex[1:]])) / math.factorial(d)


def cut(simplices, axis, bound, sign):
    """What of the simplices has sign * (x[axis] - bound) >= 0. Points have further numbers, which are cut along."""
    kept = []
    for simplex in simplices:
        side = [sign * (p[axis] - bound) for p in simplex]
        inside = [i for i, s in enumerate(side) if s >= 0]
        outside = [i for i, s in enumerate(side) if s < 0]

        def at(i, j):
            t = side[i] / (side[i] - side[j])
            return tuple(x + t * (y - x) for x, y in zip(simplex[i], simplex[j]))

        if not outside:
            kept.append(simplex)
        elif len(inside) == 1:
            kept.append([simplex[inside[0]]] + [at(inside[0], j) for j in outside])
        elif len(outside) == 1:  # a prism: the kept corners, and the cuts on the edges to the lost one
            below, above = [simplex[i] for i in inside], [at(i, outside[0]) for i in inside]
            kept.extend(below[k:] + above[:k + 1] for k in range(len(below)))
        elif len(inside) == 2:  # a tetrahedron with two corners on each side
            below, above = ([simplex[i]] + [at(i, j) for j in outside] for i in inside)
            kept.extend(below[k:] + above[:k + 1] for k in range(3))
    return kept


def voxel_range(values, res):
    return range(math.floor(min(values) / res), math.ceil(max(values) / res))


def integrals(points, cells, values, res):
    """{voxel: (integral of the function, volume)} over all voxels that cells meet. `values` has a number a vertex."""
    d, res, sums = len(points[0]), Q(res), {}
    for cell in cells:
        corners = [tuple(map(Q, map(float, points[v]))) + (Q(values[v]),) for v in cell]
        parts = {(): [corners]}
        for axis in range(d):
            cuts = {}
            for at, simplices in parts.items():
                for i in voxel_range([p[axis] for s in simplices for p in s], res):
                    part = cut(cut(simplices, axis, i * res, 1), axis, (i + 1) * res, -1)
                    part = [s for s in part if volume(s, d) > 0]
                    if part:
                        cuts[at + (i,)] = part
            parts = cuts
        for at, simplices in parts.items():
            integral, whole = sums.get(at, (0, 0))
            for simplex in simplices:
                size = volume(simplex, d)
                integral += size * sum(p[d] for p in simplex) / (d + 1)
                whole += size
            sums[at] = integral, whole
    return sums


def densities(points, cells, masses):
    """By vertex: (d + 1) times the mass, divided by the volume of the star."""
    d, stars = len(points[0]), [Q(0)] * len(points)
    for cell in cells:
        size = volume([tuple(map(Q, map(float, points[v]))) for v in cell], d)
        for v in cell:
            stars[v] += size
    return [(d + 1) * Q(float(m)) / s for m, s in zip(masses, stars)]
