#!/usr/bin/python3
"""Draws the rooms of the project and which room uses which, from what CMake links.

    draw_house.py BUILD OUT.svg

BUILD: a build folder, whose links.txt lists all targets. An arrow from a room to a room above it means "uses". Arrows that
follow from others are left out.
"""
import html
import pathlib
import re
import sys

SOURCE = pathlib.Path(__file__).resolve().parents[1]
sys.path.insert(0, str(SOURCE / "tests/tree"))
import tree  # noqa: E402

WIDTH, ROW, LEFT, BOX = 1160, 62, 110, 580


def rooms_with_words():
    """(room, what README says of it), from top to bottom."""
    section = (SOURCE / "README.md").read_text().split("## The way of the data", 1)[1].split("\n## ", 1)[0]
    for line in re.findall(r"^    (\S.*)$", section, re.MULTILINE):
        name, words = re.split(r"\s{2,}", line, maxsplit=1) if re.search(r"\s{2,}", line) else (line, "")
        if name.startswith(("src/", "actors/")) or " src/" in name:
            room = next(word for word in name.split() if word.startswith(("src/", "actors/"))).rstrip("/")
            yield room, words


def uses(rooms, targets):
    """{room: rooms that its targets link}, without those that follow from others."""
    found = {room: set() for room in rooms}
    for target in targets.values():
        room = tree.room_of(target.folder + "/", rooms)
        for link in target.links if room else ():
            other = tree.room_of(targets[link].folder + "/", rooms) if link in targets else None
            if other and other != room:
                found[room].add(other)

    def reach(room):
        return set().union(*({other} | reach(other) for other in found[room])) if found[room] else set()

    return {room: {other for other in others if not any(other in reach(third) for third in others - {other})}
            for room, others in found.items()}


def main():
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    build, out = map(pathlib.Path, sys.argv[1:3])
    words = dict(rooms_with_words())
    rooms = list(words)
    targets = tree.targets((build / "links.txt").read_text())
    links = uses(rooms, targets)
    height = ROW * len(rooms) + 20
    middle = {room: 20 + ROW * place + ROW * 0.4 for place, room in enumerate(rooms)}
    parts = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {height}" font-family="sans-serif" font-size="13">',
             '<defs><marker id="a" viewBox="0 0 8 8" refX="7" refY="4" markerWidth="7" markerHeight="7" orient="auto">'
             '<path d="M0 0L8 4L0 8z" fill="#555"/></marker></defs>',
             f'<rect width="{WIDTH}" height="{height}" fill="#fff"/>']
    for place, room in enumerate(rooms):
        y = middle[room] - ROW * 0.4
        below = sorted({target.folder[len(room) + 1:] for target in targets.values()
                        if target.folder.startswith(room + "/") and target.type != "EXECUTABLE"})
        parts.append(f'<rect x="{LEFT}" y="{y}" width="{BOX}" height="{ROW * 0.8}" rx="5" fill="hsl({place * 27 % 360},45%,93%)" stroke="#777"/>')
        parts.append(f'<text x="{LEFT + 10}" y="{y + 20}" font-weight="bold">{html.escape(room)}</text>')
        parts.append(f'<text x="{LEFT + 10}" y="{y + 39}" font-size="11" fill="#333">{html.escape(", ".join(below))}</text>')
        parts.append(f'<text x="{LEFT + BOX + 12}" y="{y + 29}" font-size="11" fill="#333">{html.escape(words[room].split(";")[0])}</text>')
    lane = 0
    for room in rooms:
        for other in sorted(links[room], key=lambda name: -middle[name]):
            gap = abs(middle[room] - middle[other]) / ROW
            lane += 1
            x = LEFT - 18 - 14 * gap - 3 * (lane % 4)
            y, to = middle[room] - 6, middle[other] + 6
            parts.append(f'<path d="M{LEFT} {y:.0f}C{x:.0f} {y:.0f} {x:.0f} {to:.0f} {LEFT} {to:.0f}" fill="none" stroke="#555" '
                         'marker-end="url(#a)"/>')
    out.write_text("\n".join(parts) + "\n</svg>\n")


main()
