"""Unpacks what EXT_meshopt_compression packs, from its specification: vertices (codec 0) and triangles (codec 1)."""
import numpy as np


def vertices(data, count, stride):
    """As `count` rows of `stride` bytes."""
    assert data[0] == 0xA0, data[0]
    at, rows = 1, np.zeros((count, stride), np.uint8)
    last = np.frombuffer(data[len(data) - stride:], np.uint8).astype(int)
    block = min((8192 // stride) & ~15, 256)
    for first in range(0, count, block):
        n = min(block, count - first)
        groups = (n + 15) // 16
        for k in range(stride):
            header = data[at:at + (groups + 3) // 4]
            at += len(header)
            deltas = []
            for group in range(groups):
                mode = header[group // 4] >> (group % 4 * 2) & 3
                if mode == 0:
                    deltas += [0] * 16
                elif mode == 3:
                    deltas += data[at:at + 16]
                    at += 16
                else:
                    bits = 2 if mode == 1 else 4
                    packed = data[at:at + 2 * bits]
                    at += 2 * bits
                    for byte in packed:
                        for shift in range(8 - bits, -1, -bits):
                            value = byte >> shift & ((1 << bits) - 1)
                            if value == (1 << bits) - 1:
                                value = data[at]
                                at += 1
                            deltas.append(value)
            packed = np.array(deltas[:n])
            values = (np.cumsum((packed >> 1) ^ -(packed & 1)) + last[k]) & 255
            rows[first:first + n, k] = values
            last[k] = values[-1]
    assert at == len(data) - max(stride, 32), "bytes are left over"
    return rows


class Triangles:
    def __init__(self, data, count):
        assert data[0] == 0xE1 and count % 3 == 0
        self.data, self.at, self.end = data, 1 + count // 3, len(data) - 16
        self.table, self.next, self.last = data[-16:], 0, 0
        self.edges, self.recent = [(0, 0)] * 16, [0] * 16  # the latest last
        self.out = []
        for code in data[1:1 + count // 3]:
            self.one(code)
        assert self.at == self.end, "bytes are left over"

    def byte(self):
        self.at += 1
        return self.data[self.at - 1]

    def free(self):
        value = shift = 0
        while True:
            byte = self.byte()
            value |= (byte & 127) << shift
            shift += 7
            if byte < 128:
                break
        self.last = (self.last + ((value >> 1) ^ -(value & 1))) & 0xFFFFFFFF
        return self.last

    def new(self):
        self.next += 1
        return self.next - 1

    def push(self, vertex):
        self.recent = self.recent[1:] + [vertex]

    def emit(self, a, b, c, edges):
        self.out += [a, b, c]
        self.edges = (self.edges + edges)[-16:]

    def one(self, code):
        if code < 0xF0:
            a, b = self.edges[15 - (code >> 4)]
            third = code & 15
            if third < 13:
                c = self.new() if third == 0 else self.recent[15 - third]
                if third == 0:
                    self.push(c)
            else:
                if third == 15:
                    c = self.free()
                else:
                    self.last += -1 if third == 13 else 1
                    c = self.last
                self.push(c)
            return self.emit(a, b, c, [(c, b), (a, c)])
        packed = self.table[code & 15] if code < 0xFE else self.byte()
        kinds = [0 if code < 0xFF else 15, packed >> 4, packed & 15]
        if code >= 0xFE and packed == 0:
            self.next = 0
        corner = [0, 0, 0]
        for k, kind in enumerate(kinds):  # of all three, before any is pushed
            corner[k] = self.new() if kind == 0 else None if kind == 15 else self.recent[16 - kind]
        for k, kind in enumerate(kinds):
            if kind == 15:
                corner[k] = self.free()
        for k, kind in enumerate(kinds):
            if kind in (0, 15):
                self.push(corner[k])
        a, b, c = corner
        return self.emit(a, b, c, [(b, a), (c, b), (a, c)])


def triangles(data, count):
    return np.array(Triangles(data, count).out).reshape(-1, 3)
