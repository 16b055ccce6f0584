"""A tileset as it is read back, without any code of ours: its tree, and the surface of each node."""
import json
import struct

import meshopt
import numpy as np

KINDS = {5121: np.uint8, 5123: np.uint16, 5125: np.uint32, 5126: np.float32}


class Glb:
    """positions: in x, y, z of the result, relative to nothing; triangles; attributes by name."""

    def __init__(self, data, transform):
        magic, version, length, json_bytes, kind = struct.unpack_from("<IIIII", data)
        assert (magic, version, length, kind) == (0x46546C67, 2, len(data), 0x4E4F534A)
        self.document = json.loads(data[20:20 + json_bytes])
        bin_bytes, kind = struct.unpack_from("<II", data, 20 + json_bytes)
        assert kind == 0x004E4942 and 28 + json_bytes + bin_bytes == len(data)
        self.bin = data[28 + json_bytes:]
        (primitive,) = self.document["meshes"][0]["primitives"]
        arrays = {name: self.array(i) for name, i in primitive["attributes"].items()}
        packed = arrays.pop("POSITION").astype(float)
        accessor = self.document["accessors"][primitive["attributes"]["POSITION"]]
        assert packed.min(0).tolist() == accessor["min"] and packed.max(0).tolist() == accessor["max"]
        node = self.document["nodes"][0]
        self.step = np.array(node["scale"])[[0, 2, 1]]
        x, y, z = (packed * node["scale"] + node["translation"]).T
        matrix = np.array(transform).reshape(4, 4).T
        self.positions = np.stack([x, -z, y], 1) @ matrix[:3, :3].T + matrix[:3, 3]
        self.triangles = self.array(primitive["indices"]).reshape(-1, 3)
        self.attributes = {name: values[:, 0] if values.shape[1] == 1 else values for name, values in arrays.items()}

    def array(self, number):
        accessor = self.document["accessors"][number]
        packed = self.document["bufferViews"][accessor["bufferView"]]["extensions"]["EXT_meshopt_compression"]
        data = self.bin[packed["byteOffset"]:packed["byteOffset"] + packed["byteLength"]]
        assert packed["count"] == accessor["count"]
        if packed["mode"] == "TRIANGLES":
            return meshopt.triangles(data, packed["count"])
        kind = np.dtype(KINDS[accessor["componentType"]])
        width = {"SCALAR": 1, "VEC2": 2, "VEC3": 3}[accessor["type"]]
        rows = meshopt.vertices(data, packed["count"], packed["byteStride"])
        return np.ascontiguousarray(rows[:, :width * kind.itemsize]).view(kind)


class Node:
    def __init__(self, folder, tile, transform):
        self.tile, self.error = tile, tile["geometricError"]
        self.path = folder / tile["content"]["uri"]
        self.data = self.path.read_bytes()
        self.surface = Glb(self.data, transform)
        self.box = np.array(tile["boundingVolume"]["box"][:3]) + transform[12:15], np.array(tile["boundingVolume"]["box"])[[3, 7, 11]]
        self.children = [Node(folder, child, transform) for child in tile.get("children", [])]

    def all(self):
        return [self] + [node for child in self.children for node in child.all()]

    def leaves(self):
        return [node for node in self.all() if not node.children]


def read(folder):
    document = json.loads((folder / "tileset.json").read_text())
    return document, Node(folder, document["root"], document["root"]["transform"])
