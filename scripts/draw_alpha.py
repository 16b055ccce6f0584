#!/usr/bin/python3
"""Draws docs/pictures/alpha.svg: the polygons of `tessera alpha` for a cloud of three radii.

    draw_alpha.py TESSERA OUT.svg

TESSERA: the command. The cloud is made here: points of a ring with a gap, and of a small disc.
"""
import json
import math
import pathlib
import random
import subprocess
import sys
import tempfile

SIZE, GAP = 260, 20


def cloud():
    rng = random.Random(4)
    points = []
    while len(points) < 420:
        x, y = rng.uniform(-1, 1), rng.uniform(-1, 1)
        r = math.hypot(x, y)
        in_ring = 0.5 < r < 0.95 and not (x > 0 and abs(y) < 0.14)
        if in_ring or math.hypot(x - 0.05, y) < 0.2:
            points.append((round(x, 4), round(y, 4)))
    return points


def main():
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    tessera, out = sys.argv[1:3]
    points, parts = cloud(), []
    with tempfile.TemporaryDirectory() as folder:
        here = pathlib.Path(folder)
        (here / "cloud.xyz").write_text("".join(f"{x} {y}\n" for x, y in points))
        subprocess.run([tessera, "triangulate", here / "cloud.xyz", "-o", here / "out", "--dim", "2", "--columns", "x,y", "--quiet"], check=True)
        for panel, radius in enumerate(("0.07", "0.1", "auto")):
            told = json.loads(subprocess.run([tessera, "alpha", here / "out", "--alpha", radius, "-o", here / f"{panel}.geojson", "--json"],
                                             check=True, stdout=subprocess.PIPE).stdout)
            left = panel * (SIZE + GAP) + SIZE / 2
            place = lambda p: f"{left + p[0] * SIZE / 2:.1f} {SIZE / 2 - p[1] * SIZE / 2:.1f}"
            path = "".join("M" + "L".join(map(place, ring)) + "Z"
                           for feature in json.loads((here / f"{panel}.geojson").read_text())["features"]
                           for ring in feature["geometry"]["coordinates"])
            parts.append(f'<path d="{path}" fill="#9ecae1" stroke="#08519c" fill-rule="evenodd"/>')
            dots = "".join(f"M{place(p)}h0" for p in points)
            parts.append(f'<path d="{dots}" stroke="#333" stroke-width="2.2" stroke-linecap="round"/>')
            label = f"R = {told['radius']:.3g}" + (" (auto)" if radius == "auto" else "")
            parts.append(f'<text x="{left}" y="{SIZE + 18}" text-anchor="middle">{label}</text>')
    width, height = 3 * SIZE + 2 * GAP, SIZE + 30
    pathlib.Path(out).write_text(f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" font-family="sans-serif" '
                                 f'font-size="14"><rect width="{width}" height="{height}" fill="#fff"/>{"".join(parts)}</svg>\n')


if __name__ == "__main__":
    main()
