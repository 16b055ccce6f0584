"""EPT, an octree of tiles in files: its clouds are those of other files with the same points in the same order."""
import collections
import ctypes
import json
import pathlib
import shutil
import signal
import subprocess
import threading
import unittest

import numpy as np

from cli import BAD_INPUT, INTERRUPTED, IO, TESSERA, USAGE, CliTest
from object_server import ObjectServer

DATA = pathlib.Path(__file__).resolve().parents[1] / "data"
COLOURS = DATA / "ept" / "colours"
BLOCK = [DATA / "clouds" / f"ign_{x}_{y}.laz" for x in (77050, 77055) for y in (627755, 627760)]

SIDE, OFFSET = 12800, (100, -50, 7)  # a cube of 128 units in steps of 0.01
FIELDS = [("X", "<i4"), ("Y", "<i4"), ("Z", "<i4"), ("Intensity", "<u2"), ("GpsTime", "<f8"), ("ScanAngleRank", "<i2")]
KINDS = {"i": "signed", "u": "unsigned", "f": "float"}


def zstd(content):
    library = ctypes.CDLL("libzstd.so.1")
    library.ZSTD_compressBound.restype = library.ZSTD_compress.restype = ctypes.c_size_t
    library.ZSTD_compressBound.argtypes = [ctypes.c_size_t]
    library.ZSTD_compress.argtypes = [ctypes.c_char_p, ctypes.c_size_t, ctypes.c_char_p, ctypes.c_size_t, ctypes.c_int]
    packed = ctypes.create_string_buffer(library.ZSTD_compressBound(len(content)))
    size = library.ZSTD_compress(packed, len(packed), content, len(content), 3)
    return packed.raw[:size]


def schema():
    fields = []
    for name, kind in FIELDS:
        field = {"name": name, "type": KINDS[kind[1]], "size": int(kind[2])}
        if name in "XYZ":
            field |= {"scale": 0.01, "offset": OFFSET["XYZ".index(name)]}
        if name == "ScanAngleRank":
            field |= {"scale": 0.006}
        fields.append(field)
    return fields


def records(count, seed=1):
    rng = np.random.default_rng(seed)
    made = np.zeros(count, FIELDS)
    for name, kind in FIELDS:
        made[name] = rng.integers(0, SIDE if name in "XYZ" else 900, count) if kind[1] != "f" else rng.random(count)
    return made


class EptTest(CliTest):
    def ept(self, name, points, kind="binary", **changes):
        """Writes records as EPT, and returns the file's path, and the records and their levels in the order of the cloud."""
        rng = np.random.default_rng(2)
        level = rng.integers(0, 4, len(points))
        cubes = np.stack([points[axis] * (1 << level) // SIDE for axis in "XYZ"], axis=1)
        keys = np.column_stack([level, cubes])
        folder = self.folder / name
        for sub in ("ept-data", "ept-hierarchy"):
            (folder / sub).mkdir(parents=True)
        order, pages = [], {"0-0-0-0": {}}
        for key in np.unique(keys, axis=0):
            chosen = np.flatnonzero((keys == key).all(axis=1))
            order.append(chosen)
            text = "-".join(map(str, key))
            tile = points[chosen].tobytes()
            ending = "bin" if kind == "binary" else "zst"
            (folder / "ept-data" / f"{text}.{ending}").write_bytes(tile if kind == "binary" else zstd(tile))
            page = "0-0-0-0"
            if key[0] >= 2:  # files of the hierarchy below its root
                page = "-".join(map(str, [2, *(key[1:] >> (key[0] - 2))]))
                pages["0-0-0-0"][page] = -1
                pages.setdefault(page, {}).setdefault(page, 0)
            pages[page][text] = len(chosen)
        pages["0-0-0-0"]["1-1-1-1"] = pages["0-0-0-0"].get("1-1-1-1", 0)
        for page, nodes in pages.items():
            (folder / "ept-hierarchy" / f"{page}.json").write_text(json.dumps(nodes))
        low = list(OFFSET)
        box = [*low, *(x + SIDE / 100 for x in low)]
        described = {"bounds": box, "boundsConforming": box, "dataType": kind, "hierarchyType": "json", "points": len(points),
                     "schema": schema(), "span": 128, "srs": {"authority": "EPSG", "horizontal": "2154"}, "version": "1.1.0"}
        (folder / "ept.json").write_text(json.dumps(described | changes))
        order = np.concatenate(order)
        return folder / "ept.json", points[order], level[order]

    def npy(self, name, points):
        """The same points as NumPy: coordinates are the doubles nearest to the decimals."""
        rows = np.zeros(len(points), [("x", "<f8"), ("y", "<f8"), ("z", "<f8"), ("intensity", "<u2"), ("gps_time", "<f8"), ("scan_angle", "<f8")])
        for axis, shift in zip("XYZ", OFFSET):
            rows[axis.lower()] = (points[axis].astype(np.int64) + 100 * shift) / 100
        rows["intensity"], rows["gps_time"] = points["Intensity"], points["GpsTime"]
        rows["scan_angle"] = points["ScanAngleRank"] * 0.006
        np.save(self.folder / name, rows)
        return self.folder / name

    def digest(self, name, *inputs):
        self.ok("triangulate", *inputs, "-o", name, "--quiet")
        return json.loads((self.folder / name / "manifest.json").read_text())["digest2"]

    def rows(self, name):
        self.ok("export", name, "-o", name + "-arrays", "--format", "npy", "--quiet")
        folder = self.folder / (name + "-arrays")
        return {file.stem: np.load(file) for file in folder.iterdir() if file.suffix == ".npy"}

    def test_binary_and_packed_tiles_are_the_cloud_of_the_same_points(self):
        for kind in ("binary", "zstandard"):
            path, points, _ = self.ept(kind, records(5000), kind)
            npy = self.npy(kind + ".npy", points)
            carried = ("--attributes", "intensity,gps_time,scan_angle")
            told = json.loads(self.ok("info", path, "--json"))["files"][0]
            self.assertEqual((told["format"], told["points"], told["dimension"]), ("ept", 5000, 3))
            expected = self.digest(kind + "-a", npy, *carried)
            self.assertEqual(self.digest(kind + "-b", path, *carried, "--tiles", "7", "--threads", "3"), expected)
            self.assertEqual(self.digest(kind + "-c", path.parent), expected)  # its folder
            found, wanted = self.rows(kind + "-b"), self.rows(kind + "-a")
            self.assertEqual(found.keys(), wanted.keys())
            orders = [np.argsort(rows["ids"]) for rows in (found, wanted)]
            for name in ("points", "intensity", "gps_time", "scan_angle"):
                self.assertTrue((found[name][orders[0]] == wanted[name][orders[1]]).all(), name)

    def test_levels_and_boxes_choose_nodes_and_keep_ids(self):
        path, points, level = self.ept("cloud", records(5000))
        npy = self.npy("all.npy", points)
        for resolution, levels in (("1", 1), ("0.5", 2), ("0.3", 3), ("0.01", 4)):
            few = self.npy(f"{levels}.npy", points[level < levels])
            self.assertEqual(self.digest(f"r{levels}", path, "--resolution", resolution), self.digest(f"e{levels}", few))
        crop = ("--crop", "110,-40,8,130,-10,60")
        self.assertEqual(self.digest("cropped", path, *crop), self.digest("expected", npy, *crop))
        self.refused(USAGE, "triangulate", npy, "-o", "no", "--resolution", "1", says=("neither COPC nor EPT",))

    def test_regions_read_the_nodes_that_they_need(self):
        path, points, _ = self.ept("cloud", records(40000))
        npy = self.npy("all.npy", points)
        found = []
        for name, cloud in (("a", path), ("b", npy)):
            done = json.loads(self.ok("region", cloud, "--bbox", "130,0,40,134,4,44", "-o", name, "--format", "npy", "--json"))
            self.assertTrue(done["complete"])
            ids, cells = np.load(self.folder / name / "ids.npy"), np.load(self.folder / name / "cells.npy")
            found.append((done, {tuple(cell) for cell in np.sort(ids[cells], axis=1).tolist()}))
        self.assertEqual(found[0][1], found[1][1])
        self.assertGreater(len(found[0][1]), 10)
        self.assertLess(found[0][0]["points_read"], found[1][0]["points_read"] / 2)

    def test_laz_tiles_of_a_real_block(self):
        folder = self.folder / "block"
        for sub in ("ept-data", "ept-hierarchy"):
            (folder / sub).mkdir(parents=True)
        nodes = {}
        for i, file in enumerate(BLOCK):
            told = json.loads(self.ok("info", file, "--json"))["files"][0]
            nodes[f"1-{i // 2}-{i % 2}-0"] = told["points"]
            shutil.copy(file, folder / "ept-data" / f"1-{i // 2}-{i % 2}-0.laz")
        (folder / "ept-hierarchy" / "0-0-0-0.json").write_text(json.dumps({"0-0-0-0": 0, **nodes}))
        described = json.loads((COLOURS / "ept.json").read_text())
        described |= {"bounds": [770500, 6277500, 10, 770600, 6277600, 110], "points": sum(nodes.values())}
        del described["boundsConforming"], described["srs"]
        (folder / "ept.json").write_text(json.dumps(described))
        options = ("--dim", "2", "--class", "2", "--attributes", "intensity,gps_time")
        self.assertEqual(self.digest("ept", folder / "ept.json", *options), self.digest("files", *BLOCK, *options))
        self.ok("region", folder, "--bbox", "770540,6277540,770560,6277560", "--dim", "2", "-o", "part", "--quiet")
        self.ok("verify", "ept", "--quiet")

    def test_a_cloud_that_entwine_made(self):
        told = json.loads(self.ok("info", COLOURS, "--json"))["files"][0]
        self.assertEqual((told["points"], told["detail"]), (1065, "EPT, tiles in LAZ"))
        self.assertIn("NAD", told["crs"])
        laz = COLOURS / "ept-data" / "0-0-0-0.laz"
        colours = ("--attributes", "red,green,blue,classification")
        self.assertEqual(self.digest("a", COLOURS / "ept.json", *colours), self.digest("b", laz, *colours))

    def test_a_cloud_behind_http(self):
        path, points, _ = self.ept("cloud", records(20000), "zstandard")
        files = {file.relative_to(path.parent).as_posix(): file.read_bytes() for file in path.parent.rglob("*") if file.is_file()}
        with ObjectServer(files) as server:
            self.assertEqual(self.digest("far", server.url("ept.json")), self.digest("near", path))
            first = len(server.requests)
            box = ("--bbox", "130,0,40,134,4,44", "--json")
            cells = [json.loads(self.ok("region", cloud, *box, "-o", name))["cells"] for cloud, name in ((server.url("ept.json"), "a"), (path, "b"))]
            self.assertEqual(cells[0], cells[1])
            tiles = {request.name for request in server.requests[first:] if "ept-data" in request.name}
            self.assertLess(len(tiles), sum("ept-data" in name for name in files) / 2)

    def far(self, path, **more):
        files = {file.relative_to(path.parent).as_posix(): file.read_bytes() for file in path.parent.rglob("*") if file.is_file()}
        return self.enterContext(ObjectServer(files, **more))

    def test_behind_http_each_file_is_asked_for_once_and_many_at_once(self):
        for kind in ("binary", "zstandard"):
            path, *_ = self.ept(kind, records(20000), kind)
            server = self.far(path, delay_s=0.02)
            for command in (["triangulate", server.url("ept.json"), "--tiles", "5"],  # reads all points several times
                            ["region", server.url("ept.json"), "--bbox", "110,-40,20,150,0,60"]):
                first = len(server.requests)
                server.most_at_once = 0
                self.ok(*command, "-o", "out", "--overwrite", "--quiet")
                asked = collections.Counter(request.name for request in server.requests[first:])
                self.assertEqual({name for name in server.objects if name.startswith("ept-hierarchy")} - asked.keys(), set())
                self.assertEqual({name: times for name, times in asked.items() if times > 1}, {})
                self.assertGreater(len(asked), 40)
                self.assertGreaterEqual(server.most_at_once, 8)
                self.assertLessEqual(server.most_at_once, 16)

    def test_info_of_a_cloud_behind_http_reads_no_binary_tile(self):
        path, *_ = self.ept("cloud", records(5000))
        server = self.far(path)
        self.ok("info", server.url("ept.json"))
        self.assertEqual([request.name for request in server.requests if "ept-data" in request.name], [])

    def test_ctrl_c_ends_a_command_that_waits_for_a_tile(self):
        path, *_ = self.ept("cloud", records(5000))
        server, asked, over = self.far(path), threading.Event(), threading.Event()
        self.addCleanup(over.set)

        def silent(request, answer):
            if "ept-data" in request.name:
                asked.set()
                over.wait()
            return answer

        server.fault = silent
        process = subprocess.Popen([TESSERA, "triangulate", server.url("ept.json"), "-o", self.out], stderr=subprocess.PIPE, stdout=subprocess.DEVNULL)
        self.assertTrue(asked.wait(60))
        process.send_signal(signal.SIGINT)
        said = process.communicate(timeout=60)[1].decode()
        over.set()
        self.assertEqual(process.returncode, INTERRUPTED, said)
        self.assertFalse((self.out / "manifest.json").exists())

    def test_a_tile_that_is_missing_on_a_server_is_named(self):
        path, *_ = self.ept("cloud", records(5000))
        server = self.far(path)
        missing = sorted(name for name in server.objects if "ept-data/3-" in name)[7]
        del server.objects[missing]
        self.refused(IO, "triangulate", server.url("ept.json"), "-o", "out", says=(missing, "404"))
        self.assertFalse((self.folder / "out" / "manifest.json").exists())

    def test_sums_of_points_do_not_wrap_around(self):
        path, *_ = self.ept("cloud", records(300))
        described = json.loads(path.read_text()) | {"points": 1 << 48}
        path.write_text(json.dumps(described))
        nodes = {"0-0-0-0": 1 << 48} | {f"{level}-{x}-0-0": 1 << 48 for level in range(1, 17) for x in range(1 << level)}
        (path.parent / "ept-hierarchy" / "0-0-0-0.json").write_text(json.dumps(nodes))
        self.refused(BAD_INPUT, "info", path, says="or more")

    def test_what_is_wrong_is_said(self):
        path, *_ = self.ept("good", records(300))
        root = "ept-hierarchy/0-0-0-0.json"
        described = json.loads(path.read_text())
        pages = json.loads((path.parent / root).read_text())
        page = next(name for name, points in pages.items() if points == -1)
        tile = next((path.parent / "ept-data").glob("0-*"))

        def changed(**new):
            return json.dumps(described | new)

        bare = [field for field in schema() if field["name"] != "Z"]
        wide = [dict(field, size=8) if field["name"] == "X" else field for field in schema()]
        for name, text, says in (
                ("ept.json", "{", "not a JSON object"), ("ept.json", "[" * 100000, "not a JSON object"),
                ("ept.json", changed(version="2.0"), "only 1.x"), ("ept.json", changed(dataType="draco"), "none of laszip"),
                ("ept.json", changed(hierarchyType="gzip"), "only json"), ("ept.json", changed(bounds=[0, 0, 0, 1, 1]), "six numbers"),
                ("ept.json", changed(bounds=[0, 0, 0, -1, 1, 1]), "six numbers"), ("ept.json", changed(bounds=[0, 0, 0, 0, 1, 1]), "no width"),
                ("ept.json", changed(points=-3), '"points"'), ("ept.json", changed(points=1 << 60), "impossibly large"),
                ("ept.json", changed(span=0), '"span"'), ("ept.json", changed(schema=[]), "list of 1 to"),
                ("ept.json", changed(schema=bare), "has no Z"), ("ept.json", changed(schema=wide), "64 bits"),
                ("ept.json", changed(schema=[*schema(), schema()[0]]), "twice"), ("ept.json", changed(schema=[{"name": "X", "type": "text", "size": 4}]), "unknown"),
                ("ept.json", changed(points=301), "hierarchy have 300"), (root, "7", "not a JSON object"),
                (root, json.dumps(pages | {"1-2-0-0": 3}), "no node of an octree"), (root, json.dumps(pages | {"1--1-0-0": 3}), "no node of an octree"),
                (root, json.dumps(pages | {"31-0-0-0": 3}), "no node of an octree"), (root, json.dumps(pages | {"1-0-0": 3}), "no node of an octree"),
                (root, json.dumps(pages | {"1-0-0-0": "3"}), "no number of points"), (root, json.dumps(pages | {"1-0-0-0": 400}), "whole cloud"),
                (root, json.dumps(pages | {"0-0-0-0": -1}), "this file itself"),
                (f"ept-hierarchy/{page}.json", json.dumps({"0-0-0-0": 3}), "twice"),
                (f"ept-hierarchy/{page}.json", json.dumps({page: 1, "0-0-0-0": -1}), "twice"),
                (f"ept-hierarchy/{page}.json", "{}", "its own node"),
                (f"ept-data/{tile.name}", tile.read_bytes()[:-24], "hierarchy says"), (f"ept-data/{tile.name}", tile.read_bytes()[:-1], "a record has")):
            with self.subTest(name=name, says=says):
                shutil.rmtree(self.folder / "bad", ignore_errors=True)
                shutil.copytree(path.parent, self.folder / "bad")
                (self.folder / "bad" / name).write_bytes(text if isinstance(text, bytes) else text.encode())
                self.refused(BAD_INPUT, "triangulate", "bad/ept.json", "-o", "out", says=("bad/", says))
                self.assertFalse(self.out.exists())
        tile.unlink()
        self.refused(IO, "triangulate", path, "-o", "out", says=(tile.name,))

    def test_packed_tiles_that_are_damaged_or_too_long(self):
        path, *_ = self.ept("packed", records(300), "zstandard")
        tile = next((path.parent / "ept-data").glob("0-*"))
        whole = tile.read_bytes()
        for content, says in ((whole[:-9], "cut off"), (zstd(bytes(10_000_000)), "more points than the hierarchy says"),
                              (zstd(bytes(3)), "a record has"), (b"none", tile.name)):
            tile.write_bytes(content)
            with self.subTest(says=says):
                self.refused(BAD_INPUT, "triangulate", path, "-o", "out", says=(tile.name, says))


if __name__ == "__main__":
    unittest.main()
