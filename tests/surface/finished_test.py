"""What is done to a surface when its triangles are known: made manifold, smoothed, written as STL and glTF, proved."""
import collections
import json
import struct
import unittest

import numpy as np
from cli import BAD_INPUT, IO, NOT_DELAUNAY, USAGE
from surfaces import SurfaceTest, read_ply


def edges_of(triangles):
    """How often each edge is used from its lesser vertex to the other, and back."""
    uses = collections.defaultdict(lambda: [0, 0])
    for a, b, c in triangles:
        for p, q in ((a, b), (b, c), (c, a)):
            uses[min(p, q), max(p, q)][p > q] += 1
    return uses


class Finished(SurfaceTest):
    def passed(self, *args):
        return self.json_lines(self.ok("verify", *args, "--json"))[-1]

    def test_a_manifold_surface_has_two_triangles_at_each_edge_also_by_coordinates(self):
        out = self.result("out", "--tiles", "5")
        plain = self.told(out, "-o", "plain.ply")
        self.assertEqual(plain["vertices_added"], 0)
        _, faces, _ = read_ply(self.folder / "plain.ply")
        self.assertGreater(sum(sum(uses) > 2 for uses in edges_of(faces["corners"].tolist()).values()), 0)
        made = self.told(out, "-o", "manifold.ply", "--manifold")
        self.assertEqual(made["vertices"], plain["vertices"] + made["vertices_added"])
        _, faces, _ = read_ply(self.folder / "manifold.ply")
        self.assertEqual({tuple(uses) for uses in edges_of(faces["corners"].tolist()).values()}, {(1, 1)})
        # Programs that read STL know vertices by their places.
        self.ok("surface", out, "-o", "manifold.stl", "--manifold", "--local", "--quiet")
        data = (self.folder / "manifold.stl").read_bytes()
        self.assertIn(b"coordinates count from 770500", data[:80])
        count, = struct.unpack_from("<I", data, 80)
        self.assertEqual((count, len(data)), (made["triangles"], 84 + 50 * count))
        facets = np.frombuffer(data, np.dtype([("normal", "f4", 3), ("at", "f4", (3, 3)), ("unused", "u2")]), count, 84)
        corners = np.unique(facets["at"].reshape(-1, 3), axis=0, return_inverse=True)[1].reshape(-1, 3)
        self.assertEqual({tuple(uses) for uses in edges_of(corners.tolist()).values()}, {(1, 1)})
        at = facets["at"].astype(float)
        normals = np.cross(at[:, 1] - at[:, 0], at[:, 2] - at[:, 0])
        length = np.linalg.norm(normals, axis=1)
        np.testing.assert_allclose(facets["normal"][length > 0], normals[length > 0] / length[length > 0, None], atol=1e-6)

    def test_faces_tell_their_tiles_and_longest_edges(self):
        self.told(self.result("out", "--tiles", "3"), "-o", "a.ply")
        at, faces, _ = read_ply(self.folder / "a.ply")
        self.assertEqual(set(faces["tile"]), {0, 1, 2})
        corners = at[faces["corners"]]
        longest = np.linalg.norm(corners - np.roll(corners, 1, 1), axis=2).max(1)
        np.testing.assert_allclose(faces["longest_edge"], longest, rtol=1e-12)

    def test_smoothing_is_the_same_to_the_bit_in_any_tiles_and_takes_noise_out(self):
        one, many = self.result("one", "--tiles", "1"), self.result("many", "--tiles", "9", "--partition", "random")
        self.told(one, "-o", "rough.ply")
        self.told(one, "-o", "smooth.ply", "--smooth", "5", "--manifold", "--threads", "1")
        for memory, threads in (("1G", 2), ("1M", 1)):
            name = f"many{memory}"
            self.told(many, "-o", f"{name}.ply", "--smooth", "5", "--manifold", "--threads", threads, "--memory", memory)
            self.assertEqual(*[sorted(zip(ids.tolist(), map(tuple, at.tolist()))) for at, _, ids in
                               (read_ply(self.folder / f"{which}.ply") for which in (name, "smooth"))])
        self.passed("smooth.ply", "--of", many)

        def roughness(name):
            """The mean angle between triangles that share an edge."""
            at, faces, _ = read_ply(self.folder / name)
            corners = at[faces["corners"]] - at.mean(0)
            normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
            normals /= np.maximum(np.linalg.norm(normals, axis=1), 1e-300)[:, None]
            sides = {(a, b): i for i, t in enumerate(faces["corners"].tolist()) for a, b in zip(t, t[1:] + t[:1])}
            pairs = np.array([(i, sides[b, a]) for (a, b), i in sides.items() if (b, a) in sides])
            return np.arccos(np.clip((normals[pairs[:, 0]] * normals[pairs[:, 1]]).sum(1), -1, 1)).mean()
        self.assertLess(roughness("smooth.ply"), 0.7 * roughness("rough.ply"))

    def test_glb_holds_the_mesh_with_its_colours(self):
        made = self.told(self.result("out"), "-o", "a.glb")
        self.told("out", "-o", "a.ply")
        at, faces, _ = read_ply(self.folder / "a.ply")
        data = (self.folder / "a.glb").read_bytes()
        magic, version, length, text_bytes, kind = struct.unpack_from("<4sIII4s", data)
        self.assertEqual((magic, version, length, kind), (b"glTF", 2, len(data), b"JSON"))
        about = json.loads(data[20:20 + text_bytes])
        chunk = data[28 + text_bytes:]
        self.assertEqual(len(chunk), about["buffers"][0]["byteLength"])

        def array(accessor, type_, width):
            accessor = about["accessors"][accessor]
            view = about["bufferViews"][accessor["bufferView"]]
            count = accessor["count"] * (width if accessor["type"] != "SCALAR" else 1)
            return np.frombuffer(chunk, type_, count, view["byteOffset"]).reshape(-1, width)
        primitive = about["meshes"][0]["primitives"][0]
        position = array(primitive["attributes"]["POSITION"], "f4", 3)
        place = about["accessors"][primitive["attributes"]["POSITION"]]
        np.testing.assert_array_equal(position.min(0), np.float32(place["min"]))
        np.testing.assert_array_equal(position.max(0), np.float32(place["max"]))
        east, up, south = (position + np.array(about["nodes"][0]["translation"])).T
        np.testing.assert_allclose(np.stack([east, -south, up], 1), at, atol=1e-4)
        np.testing.assert_array_equal(array(primitive["indices"], "u4", 3), faces["corners"])
        self.assertEqual(len(faces), made["triangles"])
        self.assertEqual(len(array(primitive["attributes"]["COLOR_0"], "u2", 4)), len(at))

    def test_verify_proves_a_surface_and_finds_what_was_changed(self):
        self.result("out", "--tiles", "4")
        self.told("out", "-o", "mesh.ply", "--lambda", "2")
        report = self.passed("mesh.ply", "--of", "out")
        self.assertIn("proved by its flow", " ".join(report["passed"]))
        self.assertEqual(report["note"], "")
        self.assertIn("because it needs the triangulation", self.passed("mesh.ply")["note"])
        good = (self.folder / "mesh.ply").read_bytes()
        body = good.index(b"end_header\n") + len(b"end_header\n")
        at, faces, _ = read_ply(self.folder / "mesh.ply")
        faces_at = len(good) - faces.nbytes
        vertex_bytes = (faces_at - body) // len(at)
        record = faces.dtype.itemsize

        def changed(change):
            data = bytearray(good)
            (self.folder / "bad.ply").write_bytes(change(data) or data)

        def swap(data):
            data[faces_at + 1:faces_at + 9] = data[faces_at + 5:faces_at + 9] + data[faces_at + 1:faces_at + 5]

        def flat(data):
            data[faces_at + 1:faces_at + 5] = data[faces_at + 5:faces_at + 9]

        def move(data):
            struct.pack_into("<d", data, body, at[0, 0] + 1e-9)

        def cut(data):
            return data[:faces_at + record * 5]

        def leave_out(data):
            return data[:-record].replace(b"element face %d" % len(faces), b"element face %d" % (len(faces) - 1), 1)

        def again(data):
            """One more pair of triangles, back to back: still closed."""
            pair = bytearray(data[faces_at:faces_at + record]) * 2
            pair[record + 1:record + 9] = pair[record + 5:record + 9] + pair[record + 1:record + 5]
            return (data + pair).replace(b"element face %d" % len(faces), b"element face %d" % (len(faces) + 2), 1)

        def far(data):
            struct.pack_into("<I", data, faces_at + 1, len(at))

        def other(data):
            return data.replace(b'"lambda":2.0', b'"lambda":0.1', 1)

        def garbled(data):
            return data.replace(b'"lambda":2.0', b'"lambda":[2]', 1)
        for change, status, says in (
                (swap, NOT_DELAUNAY, "is not closed: at edge"), (flat, BAD_INPUT, "has a vertex twice"), (move, NOT_DELAUNAY, "is not where it should be"),
                (cut, BAD_INPUT, "another length than its head says"), (leave_out, NOT_DELAUNAY, "is not closed"),
                (again, NOT_DELAUNAY, "more than once|no part of the surface"), (far, BAD_INPUT, "which the file does not have"),
                (other, NOT_DELAUNAY, "no part of the surface|lacks triangle"), (garbled, BAD_INPUT, "cannot be understood")):
            with self.subTest(change.__name__):
                changed(change)
                self.assertRegex(self.refused(status, "verify", "bad.ply", "--of", "out", says="bad.ply").stderr, says)
        self.assertEqual(vertex_bytes * len(at), faces_at - body)
        self.result("twice", "--max-points-per-tile", "10000")
        self.passed("mesh.ply", "--of", "twice")  # other tiles
        self.ok("triangulate", self.xyz(n=500), "-o", "else", "--quiet")
        self.refused(USAGE, "verify", "mesh.ply", "--of", "else", says="another triangulation")
        self.refused(USAGE, "verify", "out", "--of", "out", says="--of is for surfaces")
        self.refused(IO, "verify", "mesh.ply", "--of", "nowhere", says="nowhere")

    def test_verify_reads_a_file_a_tile_and_what_ends(self):
        self.result("out", "--tiles", "4")
        self.ok("surface", "out", "-o", "tiles", "--format", "ply", "--bottom", "open", "--local", "--quiet")
        report = self.passed("tiles", "--of", "out")
        self.assertGreater(report["ends"], 0)
        self.assertIn("as its options let it", " ".join(report["passed"]))


if __name__ == "__main__":
    unittest.main()
