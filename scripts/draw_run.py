#!/usr/bin/python3
"""Draws the way of a job: from points to a result, and from there to a surface.

    draw_run.py OUT.svg
"""
import html
import sys

STEPS = [
    ("points", "input files, read in splits", "src/input"),
    ("routed points", "each point goes to its tile; duplicates end", "src/tiling"),
    ("tiles", "each triangulates its points; final cells are taken out", "src/tiling/tile"),
    ("exchange", "tiles send points to each other until all is quiet", "src/exchange, actors"),
    ("settled tiles", "each has written what it needs to be finished alone", "src/delaunay"),
    ("result", "tile files, then the manifest, last", "src/result"),
]
SURFACE = [
    ("rays", "from each point to its sensor, from tile to tile", "src/surface"),
    ("cut", "tiles decide, then groups of tiles, then all", "src/surface/cut"),
    ("triangles", "facets between inside and outside", "src/surface"),
]
WIDTH, BOX, GAP, HEIGHT = 1080, 340, 20, 74


def box(parts, x, y, step, colour):
    name, words, where = step
    parts.append(f'<rect x="{x}" y="{y}" width="{BOX}" height="{HEIGHT}" rx="5" fill="{colour}" stroke="#777"/>')
    for dy, size, weight, text in ((22, 14, "bold", name), (43, 12, "normal", words), (62, 11, "normal", where)):
        parts.append(f'<text x="{x + 12}" y="{y + dy}" font-size="{size}" font-weight="{weight}" '
                     f'fill="{"#555" if size == 11 else "#000"}">{html.escape(text)}</text>')


def arrow(parts, path, words="", at=(0, 0)):
    parts.append(f'<path d="{path}" fill="none" stroke="#444" marker-end="url(#a)"/>')
    if words:
        parts.append(f'<text x="{at[0]}" y="{at[1]}" font-size="11" fill="#333">{html.escape(words)}</text>')


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    height = 20 + len(STEPS) * (HEIGHT + GAP)
    parts = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {height}" font-family="sans-serif">',
             '<defs><marker id="a" viewBox="0 0 8 8" refX="7" refY="4" markerWidth="8" markerHeight="8" orient="auto">'
             '<path d="M0 0L8 4L0 8z" fill="#444"/></marker></defs>',
             f'<rect width="{WIDTH}" height="{height}" fill="#fff"/>']
    left, right = 60, 640
    for place, step in enumerate(STEPS):
        y = 14 + place * (HEIGHT + GAP)
        box(parts, left, y, step, "#e8f0fa")
        if place + 1 < len(STEPS):
            arrow(parts, f"M{left + BOX / 2} {y + HEIGHT}V{y + HEIGHT + GAP - 2}")
    tiles, exchange = (14 + place * (HEIGHT + GAP) for place in (2, 3))
    x = left + BOX
    arrow(parts, f"M{x} {exchange + 22}C{x + 70} {exchange + 10} {x + 70} {tiles + 64} {x + 3} {tiles + 56}",
          "points arrive: a tile splays again", (x + 62, exchange - 2))
    first = len(STEPS) - len(SURFACE)
    for place, step in enumerate(SURFACE):
        y = 14 + (first + place) * (HEIGHT + GAP)
        box(parts, right, y, step, "#eaf6ea")
        if place + 1 < len(SURFACE):
            arrow(parts, f"M{right + BOX / 2} {y + HEIGHT}V{y + HEIGHT + GAP - 2}")
    y = 14 + (len(STEPS) - 1) * (HEIGHT + GAP) + HEIGHT / 2
    top = 14 + first * (HEIGHT + GAP) + HEIGHT / 2
    arrow(parts, f"M{x} {y}C{x + 130} {y} {right - 110} {top} {right - 3} {top}",
          "tessera surface", (x + 136, (y + top) / 2 + 30))
    with open(sys.argv[1], "w") as out:
        out.write("\n".join(parts) + "\n</svg>\n")


main()
