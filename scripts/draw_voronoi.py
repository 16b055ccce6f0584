#!/usr/bin/env python3
"""Draws docs/voronoi.svg: Voronoi cells within a polygon with a hole, as `tessera voronoi` writes them.

    scripts/draw_voronoi.py build/release/src/front/apps/tessera docs/voronoi.svg
"""
import csv
import json
import pathlib
import random
import re
import subprocess
import sys
import tempfile

AREA = [[[40, 60], [300, 20], [560, 80], [600, 240], [470, 370], [330, 300], [180, 380], [60, 300], [40, 60]],
        [[250, 130], [230, 200], [300, 240], [390, 210], [370, 140], [250, 130]]]


def rings(wkt):
    return re.findall(r"\(([^()]+)\)", wkt)


def main(tessera, target):
    draw = random.Random(20)
    points = [(round(draw.uniform(30, 610), 1), round(draw.uniform(20, 380), 1)) for _ in range(160)]
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        (folder / "points.xyz").write_text("".join("%r %r\n" % p for p in points))
        (folder / "area.geojson").write_text(json.dumps({"type": "Polygon", "coordinates": AREA}))
        subprocess.run([tessera, "voronoi", folder / "points.xyz", "-o", folder / "cells.csv", "--clip",
                        folder / "area.geojson", "--quiet"], check=True)
        with open(folder / "cells.csv", newline="") as file:
            cells = list(csv.DictReader(file))
    most = max(float(cell["area"]) for cell in cells)
    lines = ['<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 640 400" width="640" height="400">',
             '<rect width="640" height="400" fill="#ffffff"/>']
    for cell in cells:
        path = ""
        for ring in rings(cell["geom"]):
            corners = [tuple(map(float, corner.split())) for corner in ring.split(",")]
            path += "M" + "L".join("%.1f %.1f" % (x, 400 - y) for x, y in corners[:-1]) + "Z"
        light = 92 - round(45 * (float(cell["area"]) / most) ** 0.5)
        lines.append(f'<path d="{path}" fill="hsl(205,60%,{light}%)" fill-rule="evenodd" stroke="#1f3b57" '
                     'stroke-width="0.8" stroke-linejoin="round"/>')
    for x, y in points:
        lines.append('<circle cx="%.1f" cy="%.1f" r="1.6" fill="#c0392b"/>' % (x, 400 - y))
    lines.append("</svg>")
    pathlib.Path(target).write_text("\n".join(lines) + "\n")


if __name__ == "__main__":
    main(*sys.argv[1:])
