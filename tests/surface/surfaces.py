"""Surfaces of a bundled block, made and read by tests."""
import pathlib

import numpy as np
from cli import CliTest

CLOUD = pathlib.Path(__file__).parent.parent / "data" / "clouds" / "ign_77050_627760.laz"


def read_ply(path):
    """Where vertices are, and the faces' records."""
    data = path.read_bytes()
    head, body = data.split(b"end_header\n", 1)
    types = {"double": "f8", "uint": "u4", "ushort": "u2", "uchar": "u1", "float": "f4", "char": "i1", "short": "i2", "int": "i4"}
    fields = {"vertex": [], "face": []}
    counts = {}
    for line in head.decode().splitlines():
        words = line.split()
        if words[0] == "element":
            element = words[1]
            counts[element] = int(words[2])
        elif words[0] == "property" and words[1] == "list":
            fields[element] += [("three", "u1"), ("corners", "u4", 3)]
        elif words[0] == "property":
            fields[element].append((words[2], types[words[1]]))
    vertices = np.frombuffer(body, np.dtype(fields["vertex"]), counts["vertex"])
    faces = np.frombuffer(body, np.dtype(fields["face"]), counts["face"], vertices.nbytes)
    assert len(body) == vertices.nbytes + faces.nbytes
    return np.stack([vertices[axis] for axis in "xyz"], 1), faces, vertices["id"]


class SurfaceTest(CliTest):
    def result(self, name, *how):
        self.ok("triangulate", CLOUD, "--dim", "3", "-o", name, "--attributes", "all", "--quiet", *how)
        return name

    def told(self, *args):
        return self.json_lines(self.ok("surface", *args, "--json"))[-1]
