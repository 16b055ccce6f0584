#!/usr/bin/python3
"""Draws docs/voids.png: a slice of a periodic snapshot. Each place has the colour of the zone of the nearest particle;
darker places have a lower density, and white lines are the borders of the voids that stand out.

    scripts/draw_voids.py TESSERA SNAPSHOT PERIOD docs/voids.png
"""
import csv
import json
import pathlib
import subprocess
import sys
import tempfile

import numpy as np
from osgeo import gdal
from scipy.spatial import cKDTree

SIDE = 900  # pixels


def particles(tessera, snapshot, period, folder):
    """Of each particle: place, Voronoi volume, zone; the rows of the voids."""
    out = folder / "box"
    subprocess.run([tessera, "triangulate", snapshot, "-o", out, "--periodic", period, "--tiles", "1", "--quiet"], check=True)
    subprocess.run([tessera, "voids", out, "-o", folder / "voids.csv", "--quiet"], check=True)
    sys.path.append(str(pathlib.Path(__file__).parent.parent / "tests/store"))
    from tile_arrays import read_tile
    manifest = json.loads((out / "manifest.json").read_text())
    tile = read_tile(out / manifest["tiles"][0]["file"])
    own = tile["PointData/vtkGhostType"] == 0
    names = "PointData/id", "PointData/voronoi_volume", "PointData/zone"
    ids, volume, zone = (tile[name][own] for name in names)
    with open(folder / "voids.csv", newline="") as file:
        rows = {int(row["zone"]): row for row in csv.DictReader(file)}
    return tile["Points"][own], volume, zone, rows


def colours(zones):
    """A colour for each zone, far from those of the zones with near numbers: steps of the golden ratio around the wheel."""
    hue = (np.arange(len(zones)) * 0.61803398875) % 1
    return np.stack([0.55 + 0.45 * np.cos(2 * np.pi * (hue + shift)) for shift in (0, 1 / 3, 2 / 3)], -1)


def stands_out(rows, core):
    """The void of which the zone is a part: up the hierarchy while voids are likely to be there by chance."""
    while float(rows[core]["probability"]) > 0.05 and rows[core]["parent"]:
        core = int(rows[core]["parent"])
    return core


def main(tessera, snapshot, period, target):
    gdal.UseExceptions()
    with tempfile.TemporaryDirectory() as folder:
        places, volume, zone, rows = particles(tessera, snapshot, period, pathlib.Path(folder))
    side = float(period)
    tree = cKDTree(places % side, boxsize=side * (1 + 1e-12))
    steps = (np.arange(SIDE) + 0.5) / SIDE * side
    x, y = np.meshgrid(steps, steps[::-1])
    _, nearest = tree.query(np.stack([x, y, np.full_like(x, side / 2)], -1))
    cores, number = np.unique(zone, return_inverse=True)
    shade = np.argsort(np.argsort(volume)) / len(volume)  # 0: the densest
    image = colours(cores)[number[nearest]] * (1 - 0.75 * shade[nearest])[..., None]
    voids = np.array([stands_out(rows, core) for core in cores.tolist()])[number[nearest]]
    edge = (voids != np.roll(voids, 1, 0)) | (voids != np.roll(voids, 1, 1))
    image[edge] = 1
    memory = gdal.GetDriverByName("MEM").Create("", SIDE, SIDE, 3, gdal.GDT_Byte)
    for band in range(3):
        memory.GetRasterBand(band + 1).WriteArray((image[..., band] * 255).astype(np.uint8) // 8 * 8 + 4)
    gdal.GetDriverByName("PNG").CreateCopy(target, memory, options=["ZLEVEL=9"])
    pathlib.Path(target + ".aux.xml").unlink(missing_ok=True)


if __name__ == "__main__":
    main(*sys.argv[1:5])
