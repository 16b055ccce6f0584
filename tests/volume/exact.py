"""Volumes between surfaces, by fractions and brute force: every triangle of A against every triangle of B."""
import json
import pathlib
from fractions import Fraction

import numpy as np
from tile_arrays import read_tile


def surface_of(folder):
    """The main cells of a 2D result of files of cells, as arrays of (x, y, z): read by the specification alone."""
    folder = pathlib.Path(folder)
    manifest = json.loads((folder / "manifest.json").read_text())
    cells = []
    for entry in manifest["tiles"]:
        arrays = read_tile(folder / entry.get("file", "tiles/%06d.vtu" % entry["tile"]))
        points = np.column_stack([arrays["Points"][:, :2], arrays["PointData/z"]])
        corners = arrays["Cells/connectivity"].reshape(-1, 3)
        cells.extend(points[corners[arrays["CellData/vtkGhostType"] == 0]].tolist())
    return [[tuple(map(Fraction, p)) for p in cell] for cell in cells]


def side(a, b, p):
    return (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0])


def cut_off(polygon, value):
    """The part of a convex polygon where an affine function is not below zero."""
    kept = []
    for i, p in enumerate(polygon):
        q = polygon[(i + 1) % len(polygon)]
        at_p, at_q = value(p), value(q)
        if at_p >= 0:
            kept.append(p)
        if at_p * at_q < 0:
            t = at_p / (at_p - at_q)
            kept.append((p[0] + t * (q[0] - p[0]), p[1] + t * (q[1] - p[1])))
    return kept


def common(polygon, convex):
    for i, a in enumerate(convex):
        if not polygon:
            break
        polygon = cut_off(polygon, lambda p, a=a, b=convex[(i + 1) % len(convex)]: side(a, b, p))
    return polygon


def integral(polygon, value):
    """The area of a convex polygon, and the integral of an affine function over it."""
    area = total = Fraction(0)
    for i in range(1, len(polygon) - 1):
        part = side(polygon[0], polygon[i], polygon[i + 1]) / 2
        area += part
        total += part * (value(polygon[0]) + value(polygon[i]) + value(polygon[i + 1])) / 3
    return area, total


def height_on(cell):
    (x0, y0, z0), (x1, y1, z1), (x2, y2, z2) = cell
    whole = side(cell[0], cell[1], cell[2])
    gx = ((z1 - z0) * (y2 - y0) - (z2 - z0) * (y1 - y0)) / whole
    gy = ((z2 - z0) * (x1 - x0) - (z1 - z0) * (x2 - x0)) / whole
    return lambda p: z0 + gx * (p[0] - x0) + gy * (p[1] - y0)


def trapezoids(rings):
    """The inside of rings by the even-odd rule, as convex polygons between the heights of their vertices."""
    rings = [[tuple(map(Fraction, p[:2])) for p in (ring[:-1] if ring[0] == ring[-1] else ring)] for ring in rings]
    edges = [(ring[i], ring[(i + 1) % len(ring)]) for ring in rings for i in range(len(ring))]
    levels = sorted({p[1] for ring in rings for p in ring})
    parts = []
    for low, high in zip(levels, levels[1:]):
        across = []
        for a, b in edges:
            if a[1] > b[1]:
                a, b = b, a
            if a[1] <= low and high <= b[1]:
                at = [a[0] + (y - a[1]) / (b[1] - a[1]) * (b[0] - a[0]) for y in (low, high)]
                across.append(at)
        across.sort(key=sum)
        for left, right in zip(across[::2], across[1::2]):
            parts.append([(left[0], low), (right[0], low), (right[1], high), (left[1], high)])
    return parts


def box(polygon):
    return (min(p[0] for p in polygon), min(p[1] for p in polygon), max(p[0] for p in polygon), max(p[1] for p in polygon))


def apart(a, b):
    return a[2] <= b[0] or b[2] <= a[0] or a[3] <= b[1] or b[3] <= a[1]


def overlap(polygons, others):
    """Pairs of a polygon and another whose boxes meet, with their common part."""
    boxes = [box(other) for other in others]
    for polygon in polygons:
        around = box(polygon)
        for other, its in zip(others, boxes):
            if not apart(around, its):
                part = common([p[:2] for p in polygon], [p[:2] for p in other])
                if len(part) > 2:
                    yield polygon, other, part


def volumes(a, b, rings=None):
    """The columns of the table, as fractions. `b`: triangles, or the height of a plane."""
    parts = None if rings is None else trapezoids(rings)
    area_of = lambda polygons: sum(integral(p, lambda _: Fraction(0))[0] for p in polygons)
    if isinstance(b, list):
        pieces = [(part, height_on(x), height_on(y)) for x, y, part in overlap(a, b)]
    else:
        level = Fraction(b)
        pieces = [([p[:2] for p in x], height_on(x), lambda _: level) for x in a]
    if parts is not None:
        pieces = [(part, upper, lower) for piece, upper, lower in pieces
                  for _, _, part in overlap([piece], parts)]
    cut = fill = covered = Fraction(0)
    for part, upper, lower in pieces:
        value = lambda p: upper(p) - lower(p)
        covered += area_of([part])
        cut += integral(cut_off(part, value), value)[1]
        fill -= integral(cut_off(part, lambda p: -value(p)), value)[1]
    limited = lambda polygons: area_of(polygons) if parts is None else area_of(p for _, _, p in overlap(polygons, parts))
    by_a = limited(a)
    by_b = limited(b) if isinstance(b, list) else area_of(parts) if parts is not None else by_a
    whole = area_of(parts) if parts is not None else by_a + by_b - covered
    return {"cut": cut, "fill": fill, "net": cut - fill, "area": whole, "covered": covered, "uncovered": whole - covered,
            "uncovered_by_a": whole - by_a, "uncovered_by_b": whole - by_b}
