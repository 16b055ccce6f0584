#!/usr/bin/python3
"""Draws what cut and fill are: a section through two surfaces.

    draw_volumes.py OUT.svg
"""
import pathlib
import sys

WIDTH, HEIGHT = 920, 300
BEFORE = [(40, 190), (140, 120), (230, 90), (330, 130), (430, 200), (540, 220), (650, 180), (880, 150)]
AFTER = [(150, 170), (260, 160), (360, 170), (450, 150), (560, 110), (660, 150), (760, 175)]
HOLE = (560, 660)  # where B has no cells


def at(line, x):
    for (x0, y0), (x1, y1) in zip(line, line[1:]):
        if x0 <= x <= x1:
            return y0 + (y1 - y0) * (x - x0) / (x1 - x0)
    raise ValueError(f"{x} is beside the line")


def between(parts, first, last):
    """Fills the area between the surfaces: cut where B is lower on the page, which is below A."""
    step = 1
    for colour, sign in (("#e39b8b", 1), ("#9cc3e6", -1)):
        for x in range(first, last, step):
            a, b = at(BEFORE, x + .5), at(AFTER, x + .5)
            if (b - a) * sign > 0:
                parts.append(f'<rect x="{x}" y="{min(a, b):.1f}" width="{step + .3}" height="{abs(a - b):.1f}" fill="{colour}"/>')


def line(parts, points, colour):
    text = " ".join(f"{x},{y:.1f}" for x, y in points)
    parts.append(f'<polyline points="{text}" fill="none" stroke="{colour}" stroke-width="2.5"/>')
    for x, y in points:
        parts.append(f'<circle cx="{x}" cy="{y:.1f}" r="3" fill="{colour}"/>')


def word(parts, x, y, text, size=14, colour="#222"):
    parts.append(f'<text x="{x}" y="{y}" font-size="{size}" fill="{colour}" text-anchor="middle">{text}</text>')


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    parts = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {HEIGHT}" font-family="sans-serif">',
             f'<rect width="{WIDTH}" height="{HEIGHT}" fill="#fff"/>']
    between(parts, AFTER[0][0], HOLE[0])
    between(parts, HOLE[1], AFTER[-1][0])
    line(parts, BEFORE, "#7a3b2e")
    line(parts, [p for p in AFTER if p[0] <= HOLE[0]], "#1f5f99")
    line(parts, [p for p in AFTER if p[0] >= HOLE[1]], "#1f5f99")
    word(parts, 235, 138, "cut")
    word(parts, 500, 180, "fill")
    word(parts, 90, 120, "A, before", colour="#7a3b2e")
    word(parts, 500, 118, "B, after", colour="#1f5f99")
    for first, last, text in ((40, 150, "not covered by B"), (150, 560, "covered"), (560, 660, "a hole in B"),
                              (660, 760, "covered"), (760, 880, "not covered by B")):
        parts.append(f'<path d="M{first + 2},250 L{last - 2},250" stroke="#555" stroke-width="1.5"/>')
        for x in (first, last):
            parts.append(f'<path d="M{x},243 L{x},257" stroke="#555"/>')
        word(parts, (first + last) / 2, 273, text, 11, "#444")
    parts.append("</svg>\n")
    pathlib.Path(sys.argv[1]).write_text("\n".join(parts))


if __name__ == "__main__":
    main()
