"""The watershed of ZOBOV by its definition, for small clouds, and what `tessera voids` has written."""
import csv
import itertools
import json
import pathlib
from fractions import Fraction

import numpy as np
from tile_arrays import read_tile

NONE = -1  # the zone of a vertex that is in none


class Stored:
    """A result as its files have it: columns {name: {id: value}}, places {id: point}, edges {(id, id)}."""

    def __init__(self, folder):
        folder = pathlib.Path(folder)
        manifest = json.loads((folder / "manifest.json").read_text())
        self.dimension = manifest["dimension"]
        self.columns, self.places, self.edges = {}, {}, set()
        for entry in manifest["tiles"]:
            arrays = read_tile(folder / entry.get("file", "tiles/%06d.vtu" % entry["tile"]))
            ids = arrays["PointData/id"]
            own = arrays["PointData/vtkGhostType"] == 0
            self.places.update(zip(ids[own].tolist(), arrays["Points"][own].tolist()))
            corners = ids[arrays["Cells/connectivity"].reshape(-1, self.dimension + 1)]
            for i, j in itertools.combinations(range(self.dimension + 1), 2):
                pairs = np.sort(corners[:, [i, j]].astype(np.int64), axis=1)
                self.edges.update(map(tuple, np.unique(pairs[pairs[:, 0] != pairs[:, 1]], axis=0).tolist()))
            for name in arrays:
                if not name.startswith("PointData/"):
                    continue
                column = self.columns.setdefault(name[len("PointData/"):], {})
                for vertex, value in zip(ids.tolist(), arrays[name].tolist()):
                    if isinstance(value, list) or name.endswith(("vtkGhostType", "tile", "owner")):
                        continue
                    if column.setdefault(vertex, value) != value and value == value:
                        raise AssertionError(f"vertex {vertex} has two values of {name}")


class Watershed:
    """zone: {id: core}; voids: {core: dict with the columns of the table}. `levels`: {id: value}, lower is less dense;
    `volumes`: {id: volume}; `density(level)`; `points`: {id: number of points}; None as level: in no zone."""

    def __init__(self, levels, volumes, edges, points, density, contrast):
        level = {v: (value, v) for v, value in levels.items() if value is not None}
        near = {v: [] for v in level}
        for a, b in edges:
            if a in level and b in level:
                near[a].append(b)
                near[b].append(a)
        down = {v: min(near[v] + [v], key=level.get) for v in level}
        self.zone = {v: NONE for v in levels}
        for v in level:
            at = v
            while down[at] != at:
                at = down[at]
            self.zone[v] = at
        cores = sorted(v for v in level if down[v] == v)
        self.saddles = {core: {} for core in cores}
        for a, b in edges:
            if a in level and b in level and self.zone[a] != self.zone[b]:
                high = max(level[a], level[b])
                for x, y in (self.zone[a], self.zone[b]), (self.zone[b], self.zone[a]):
                    self.saddles[x][y] = min(self.saddles[x].get(y, high), high)
        members = {core: [v for v in level if self.zone[v] == core] for core in cores}
        self.voids = {}
        highest = max(level.values(), default=None)
        for core in cores:
            zones, saddle, parent = self.flood(core, level)
            inside = [v for zone in zones for v in members[zone]]
            self.voids[core] = {
                "core_density": density(level[core][0]), "zones": zones,
                "zone_points": sum(points[v] for v in members[core]), "zone_volume": total(volumes, members[core]),
                "saddle_vertex": saddle and saddle[1], "saddle_density": density((saddle or highest)[0]), "parent": parent,
                "void_zones": len(zones), "void_points": sum(points[v] for v in inside), "void_volume": total(volumes, inside),
                "contrast": contrast(level[core][0], (saddle or highest)[0])}

    def flood(self, core, level):
        """The zones that water covers that rises over a core, until it would flow into a lower zone."""
        zones = {core}
        while True:
            ways = [high for zone in zones for other, high in self.saddles[zone].items() if other not in zones]
            if not ways:
                return zones, None, None
            height = min(ways)
            reached, new = set(zones), list(zones)
            while new:
                for other, high in self.saddles[new.pop()].items():
                    if high <= height and other not in reached:
                        reached.add(other)
                        new.append(other)
            deepest = min(reached, key=level.get)
            if level[deepest] < level[core]:
                return zones, height, deepest
            zones = reached


def total(volumes, vertices):
    return float(sum((Fraction(volumes[v]) for v in vertices), Fraction(0)))


def expected(stored, by="voronoi", points=None):
    volume = stored.columns["voronoi_area" if stored.dimension == 2 else "voronoi_volume"]
    outside = {v for v, size in volume.items() if size == float("inf")}
    if by == "voronoi":
        levels = {v: None if v in outside else -size for v, size in volume.items()}
        density, contrast = (lambda level: -1 / level), (lambda core, out: core / out)
    else:
        levels = {v: None if v in outside else value for v, value in stored.columns[by].items()}
        density, contrast = (lambda level: level), (lambda core, out: 1 if core == out else out / core)
    return Watershed(levels, volume, stored.edges, points or dict.fromkeys(volume, 1), density, contrast)


def table(path):
    """The rows of a .csv of voids, by core; numbers as numbers, empty ones as None."""
    with open(path, newline="") as file:
        rows = [{key: None if not value else float(value) if not value.lstrip("-").isdigit() else int(value)
                 for key, value in row.items()} for row in csv.DictReader(file)]
    return {row["zone"]: row for row in rows}


class Zobov:
    """The three files as jozov writes them."""

    def __init__(self, path):
        path = pathlib.Path(path)
        lines = path.read_text().splitlines()
        self.head, names = lines[0], lines[1].split()
        self.rows = [dict(zip(names, map(float, line.split()))) for line in lines[2:]]
        lines = path.with_suffix(".zone").read_text().split("\n")
        self.counts = tuple(map(int, lines[0].split()))
        self.zone = list(map(int, lines[1:-1]))
        lines = path.with_suffix(".void").read_text().splitlines()
        self.voids = []  # (steps [(ratio, zones)], contrast), by zone
        for number, line in enumerate(lines[1:]):
            words = line.split()
            assert int(words[0]) == number
            at, steps = 1, []
            while int(words[at]) > 0:
                n = int(words[at])
                steps.append((float(words[at + 1]), set(map(int, words[at + 2:at + 2 + n]))))
                at += 2 + n
            assert len(words) == at + 2
            self.voids.append((steps, float(words[at + 1])))
        assert int(lines[0]) == len(self.voids)
