#!/usr/bin/python3
"""Cuts the beginning off a file of points, and leaves what it keeps byte for byte as it was.

    cut_cloud.py IN OUT COUNT [TWIN]

IN: LAS, binary PLY (of fixed records), CSV with a line of names, .bin, .bin2 (doubles): COUNT points are kept.
    LAZ in chunks of equal size: COUNT chunks are kept. COPC: the largest nodes that have no children are dropped until COUNT bytes of
    points are left. Both need TWIN, the same file as LAS: counts and boxes of the header are made anew from its records."""
import re
import struct
import sys

import numpy as np

import laz_table


class Las:
    """A LAS or LAZ file: where things stand in it, and its records if they are not compressed."""

    def __init__(self, data):
        self.data, self.minor, self.format, self.compressed = data, data[25], data[104] & 0x3F, data[104] >= 0x80
        self.header_bytes, self.points_at, self.record_count = struct.unpack_from("<HII", data, 94)
        (self.record_bytes,) = struct.unpack_from("<H", data, 105)
        (self.points,) = struct.unpack_from("<Q", data, 247) if self.minor >= 4 else struct.unpack_from("<I", data, 107)
        self.scale, self.offset = (np.frombuffer(data, "<f8", 3, at) for at in (131, 155))

    def records(self, begin=0, end=None):
        """Bytes, one row for each record."""
        count = (self.points if end is None else end) - begin
        at = self.points_at + begin * self.record_bytes
        return np.frombuffer(self.data, np.uint8, count * self.record_bytes, at).reshape(count, self.record_bytes)

    def coordinates(self, records):
        """X * scale + offset, rounded twice."""
        return np.ascontiguousarray(records[:, :12]).view("<i4") * self.scale + self.offset

    def record(self, number):
        """The place of the content of the variable-length record of this number, or None."""
        at = self.header_bytes
        for _ in range(self.record_count):
            found, size = struct.unpack_from("<HH", self.data, at + 18)
            if found == number:
                return at + 54
            at += 54 + size
        return None


def head_of(las, records):
    """All before the points, for these records; records behind the points are dropped."""
    head = bytearray(las.data[: las.points_at])
    returns = records[:, 14] & (7 if las.format < 6 else 15)
    by_return = np.bincount(returns, minlength=16)[1:]
    legacy = las.format < 6
    struct.pack_into("<6I", head, 107, *([len(records), *by_return[:5]] if legacy else [0] * 6))
    if las.minor >= 4:
        struct.pack_into("<QIQ15Q", head, 235, 0, 0, len(records), *by_return)
    xyz = las.coordinates(records)
    struct.pack_into("<6d", head, 179, *np.column_stack([xyz.max(0), xyz.min(0)]).ravel())
    return head


def cut_las(las, count):
    records = las.records(0, count)
    return bytes(head_of(las, records)) + records.tobytes()


def with_table(head, chunks, data, variable):
    """Head, chunks and their table; `chunks`: pairs (points, bytes)."""
    table_at = len(head) + 8 + len(data)
    return head + struct.pack("<q", table_at) + data + struct.pack("<II", 0, len(chunks)) + laz_table.encode(chunks, variable)


def chunks_of(las):
    (table_at,) = struct.unpack_from("<q", las.data, las.points_at)
    (count,) = struct.unpack_from("<I", las.data, table_at + 4)
    (each,) = struct.unpack_from("<I", las.data, las.record(22204) + 12)
    variable = each == 0xFFFFFFFF
    return laz_table.decode(las.data[table_at + 8 :], [0 if variable else each] * count, variable), variable


def cut_laz(las, twin, count):
    chunks, variable = chunks_of(las)
    kept, begin = chunks[:count], las.points_at + 8
    points, size = (sum(column) for column in zip(*kept))
    return bytes(with_table(head_of(las, twin.records(0, points)), kept, las.data[begin : begin + size], variable))


class Node:
    def __init__(self, entry):
        *self.key, self.at, self.size, self.points = entry

    def parent(self):
        return [self.key[0] - 1, *(k >> 1 for k in self.key[1:])]


def nodes_of(las):
    """In the order in which their chunks stand in the file. All are in the first page of the hierarchy."""
    at, size = struct.unpack_from("<QQ", las.data, las.header_bytes + 54 + 40)
    nodes = [Node(entry) for entry in struct.iter_unpack("<4iQii", las.data[at : at + size])]
    assert all(node.points > 0 for node in nodes)
    return sorted(nodes, key=lambda node: node.at)


def copc_nodes(las, most_bytes):
    """Which nodes stay: a list as long as there are nodes."""
    nodes = nodes_of(las)
    kept = list(nodes)
    while sum(node.size for node in kept) > most_bytes:
        parents = [node.parent() for node in kept]
        kept.remove(max((node for node in kept if node.key not in parents), key=lambda node: node.size))
    return [node in kept for node in nodes]


def copc_records(las, twin, most_bytes):
    stays = copc_nodes(las, most_bytes)
    return twin.records()[np.repeat(stays, [node.points for node in nodes_of(las)])]


def cut_copc(las, twin, most_bytes):
    kept = [node for node, stays in zip(nodes_of(las), copc_nodes(las, most_bytes)) if stays]
    head, data, entries = head_of(las, copc_records(las, twin, most_bytes)), b"", []
    for node in kept:
        entries.append((*node.key, las.points_at + 8 + len(data), node.size, node.points))
        data += las.data[node.at : node.at + node.size]
    hierarchy = b"".join(struct.pack("<4iQii", *entry) for entry in sorted(entries))  # the root first
    out = bytearray(with_table(head, [(node.points, node.size) for node in kept], data, True))
    struct.pack_into("<QI", out, 235, len(out), 1)
    struct.pack_into("<QQ", out, las.header_bytes + 54 + 40, len(out) + 60, len(hierarchy))
    return bytes(out) + struct.pack("<H16sHQ32s", 0, b"copc", 1000, len(hierarchy), b"") + hierarchy


def cut_ply(data, count):
    head_bytes = data.index(b"end_header\n") + 11
    sizes = {b"float": 4, b"double": 8, b"uchar": 1}
    record_bytes = sum(sizes[kind] for kind in re.findall(rb"^property (\w+) ", data[:head_bytes], re.MULTILINE))
    head = re.sub(rb"element vertex \d+", b"element vertex %d" % count, data[:head_bytes])
    return head + data[head_bytes : head_bytes + count * record_bytes]


def cut(source, count, twin=None):
    with open(source, "rb") as file:
        data = file.read()
    if source.endswith(".ply"):
        return cut_ply(data, count)
    if source.endswith(".csv"):
        return b"".join(data.splitlines(True)[: count + 1])
    if source.endswith((".bin", ".bin2")):
        return data[: count * (24 if source.endswith(".bin") else 16)]
    las = Las(data)
    if not las.compressed:
        return cut_las(las, count)
    with open(twin, "rb") as file:
        records = Las(file.read())
    return cut_copc(las, records, count) if las.record(1) == las.header_bytes + 54 else cut_laz(las, records, count)


if __name__ == "__main__":
    if len(sys.argv) not in (4, 5):
        sys.exit(__doc__)
    result = cut(sys.argv[1], int(sys.argv[3]), *sys.argv[4:])
    with open(sys.argv[2], "wb") as out:
        out.write(result)
