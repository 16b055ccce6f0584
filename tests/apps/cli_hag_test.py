"""tessera hag: heights above the ground, in copies of LAS and LAZ files that are otherwise as they were."""
import gzip
import json
import pathlib
import struct
import unittest

import numpy as np
import scipy.interpolate
from cli import BAD_INPUT, USAGE, CliTest

CLOUDS = pathlib.Path(__file__).resolve().parent.parent / "data" / "clouds"


class Las:
    """A LAS file, by the specification alone."""

    def __init__(self, path):
        b = pathlib.Path(path).read_bytes()
        self.offset, self.vlrs = struct.unpack_from("<II", b, 96)
        self.format, self.length = b[104] & 63, struct.unpack_from("<H", b, 105)[0]
        count = struct.unpack_from("<Q", b, 247)[0] if b[25] == 4 else struct.unpack_from("<I", b, 107)[0]
        self.compressed = b[104] >= 64
        scale, shift = struct.unpack_from("<3d", b, 131), struct.unpack_from("<3d", b, 155)
        self.head = b[:struct.unpack_from("<H", b, 94)[0]]
        self.records = None
        if not self.compressed:
            body = np.frombuffer(b, np.uint8, count * self.length, self.offset)
            self.records = body.reshape(count, self.length)
            xyz = self.records[:, :12].copy().view("<i4").astype(np.float64)
            self.points = np.array([xyz[:, k] * scale[k] + shift[k] for k in range(3)]).T
            self.classes = self.records[:, 16] if self.format >= 6 else self.records[:, 15] & 31
        self.extra = []
        at = len(self.head)
        for _ in range(self.vlrs):
            user, record, size = b[at + 2:at + 18].rstrip(b"\0"), *struct.unpack_from("<HH", b, at + 18)
            if (user, record) == (b"LASF_Spec", 4):
                for i in range(at + 54, at + 54 + size, 192):
                    self.extra.append((b[i + 4:i + 36].rstrip(b"\0").decode(), b[i + 2]))
                    self.range = b[i + 3], *struct.unpack_from("<d16xd", b, i + 64)
            at += 54 + size


class Hag(CliTest):
    def heights(self, source, copy):
        """The heights in a copy of an uncompressed file, in which nothing else may have changed."""
        self.assertEqual(copy.length, source.length + 4)
        np.testing.assert_array_equal(copy.records[:, :source.length], source.records)
        self.assertEqual(copy.extra, [*source.extra, ("HeightAboveGround", 9)])
        for begin, end in (0, 96), (107, 235):  # all but the places of records, and their length
            self.assertEqual(copy.head[begin:end], source.head[begin:end])
        return copy.records[:, source.length:].copy().view("<f4").ravel()

    def expected(self, clouds, source):
        ground = np.concatenate([cloud.points[cloud.classes == 2] for cloud in clouds])
        origin = ground.mean(axis=0)
        surface = scipy.interpolate.LinearNDInterpolator(ground[:, :2] - origin[:2], ground[:, 2])
        return source.points[:, 2] - surface(source.points[:, :2] - origin[:2])

    def test_heights_are_those_above_the_triangles_of_ground_points(self):
        name = CLOUDS / "pdal_mvk_thin.las"
        source = Las(name)
        said = self.ok("hag", name, "-o", "out")
        self.assertIn("6 280 points of 1 file have the dimension HeightAboveGround", said)
        found = self.heights(source, Las(self.folder / "out" / name.name))
        right = self.expected([source], source)
        self.assertIn("points are outside of the hull of the ground points; their height is NaN", said)
        # Between four points on a circle there are two right answers.
        same = np.isclose(found, right, atol=2e-3) | (np.isnan(found) & np.isnan(right))
        self.assertGreater(same.mean(), .99)
        self.assertEqual(Las(self.folder / "out" / name.name).range, (6, np.nanmin(found), np.nanmax(found)))
        ground = found[source.classes == 2]
        self.assertLess(np.nanmax(np.abs(ground)), 1e-3)
        self.assertEqual(list((self.folder / "out").iterdir()), [self.folder / "out" / name.name])

    def test_files_of_a_block_share_the_ground_and_stay_apart(self):
        names = sorted((CLOUDS.parent.parent.parent / "data" / "ign").glob("*.las"))
        sources = [Las(name) for name in names]
        told = json.loads(self.ok("hag", *names, "-o", "out", "--json").splitlines()[-1])
        self.assertEqual([pathlib.Path(f["output"]).name for f in told["files"]], [name.name for name in names])
        self.assertEqual(told["points"], sum(len(s.records) for s in sources))
        whole = [self.heights(s, Las(self.folder / "out" / name.name)) for s, name in zip(sources, names)]
        self.assertEqual(sum(int(np.isnan(h).sum()) for h in whole), told["outside"])
        # The same heights above a result, for any tiles and threads, compressed or not.
        self.ok("triangulate", *names, "-o", "ground", "--dim", "2", "--class", "2", "--tiles", "7", "--quiet")
        self.ok("hag", *names, "-o", "other", "--ground", "ground", "--threads", "1", "--quiet")
        self.ok("hag", *names, "-o", "packed", "--ground", "ground", "--format", "laz", "--outside", "-1", "--quiet")
        for name, first in zip(names, whole):
            again = Las(self.folder / "other" / name.name)
            np.testing.assert_allclose(again.records[:, -4:].copy().view("<f4").ravel(), first, atol=1e-6)
            packed = self.folder / "packed" / (name.stem + ".laz")
            self.assertTrue(Las(packed).compressed)
            self.ok("hag", packed, "-o", "twice", "--ground", "ground", "--format", "las", "--replace", "--overwrite", "--quiet")
            unpacked = Las(self.folder / "twice" / name.name)
            np.testing.assert_array_equal(unpacked.records, again.records)

    def test_points_of_copc_keep_their_heights(self):
        """Its points are sorted by level of detail: each must get its own height."""
        cloud = CLOUDS / "lion_takanawa_part.copc.laz"
        self.ok("triangulate", cloud, "-o", "top", "--dim", "2", "--quiet")
        vertices = json.loads(self.ok("info", "top", "--json"))["vertices"]
        self.ok("hag", cloud, "-o", "out", "--ground", "top", "--format", "las", "--quiet")
        found = Las(self.folder / "out" / "lion_takanawa_part.copc.las").records[:, -4:].copy().view("<f4").ravel()
        # Each vertex is on the surface, and so may be a point of the same x and y.
        self.assertGreaterEqual((np.abs(found) < 1e-6).sum(), vertices)
        self.assertLess((np.abs(found) < 1e-6).mean(), .9)

    def test_what_reads_attributes_reads_the_heights(self):
        name = CLOUDS / "pdal_mvk_thin.las"
        self.ok("hag", name, "-o", "out", "--outside", "0", "--format", "laz", "--quiet")
        self.ok("triangulate", "out/pdal_mvk_thin.laz", "-o", "result", "--dim", "2", "--attributes", "HeightAboveGround", "--quiet")
        self.ok("dem", "result", "--res", "5", "--value", "HeightAboveGround", "-o", "canopy.tif", "--quiet")
        self.assertIn("HeightAboveGround", self.ok("info", "out/pdal_mvk_thin.laz"))

    def test_wrong_input_is_refused_and_leaves_nothing(self):
        name = CLOUDS / "pdal_mvk_thin.las"
        self.write("points.xyz", "1 2 3\n4 5 6\n7 8 10\n")
        self.refused(BAD_INPUT, "hag", "points.xyz", "-o", "out", says="points.xyz: is not LAS or LAZ (it is xyz)")
        self.refused(USAGE, "hag", name, says="add -o FOLDER")
        self.refused(USAGE, "hag", "-o", "out", says="no LAS or LAZ file is given")
        self.refused(USAGE, "hag", name, "-o", "out", "--format", "copc", says="'copc' is not a format of the copies")
        self.assertNotEqual(self.run_tessera("hag", name, "-o", "none", "--ground-class", "77").returncode, 0)
        self.assertEqual(list((self.folder / "none").iterdir()), [])
        self.ok("hag", name, "-o", "out", "--quiet")
        self.refused(USAGE, "hag", name, "-o", "out", says="exists already; --overwrite replaces it")
        self.refused(BAD_INPUT, "hag", "out/pdal_mvk_thin.las", "-o", "again", "--ground-class", "2", says="HeightAboveGround")
        self.ok("hag", "out/pdal_mvk_thin.las", "-o", "again", "--replace", "--quiet")
        self.assertEqual((self.folder / "again" / name.name).read_bytes(), (self.folder / "out" / name.name).read_bytes())
        self.ok("triangulate", name, "-o", "solid", "--quiet")
        self.refused(USAGE, "hag", name, "-o", "third", "--ground", "solid", says="heights are measured above a 2D result")
        self.refused(USAGE, "hag", name, "-o", "third", "--ground", "solid", "--ground-class", "2", says="--ground gives the ground")
        self.assertFalse((self.folder / "third").exists() and list((self.folder / "third").iterdir()))

    def test_what_gzip_has_compressed_is_refused(self):
        (self.folder / "tile.las.gz").write_bytes(gzip.compress((CLOUDS / "pdal_mvk_thin.las").read_bytes()))
        self.refused(BAD_INPUT, "hag", "tile.las.gz", "-o", "out", says="tile.las.gz: is compressed (gzip)")

    def test_files_of_one_name_are_not_mixed(self):
        for folder in "a", "b":
            (self.folder / folder).mkdir()
            (self.folder / folder / "tile.las").write_bytes((CLOUDS / "pdal_mvk_thin.las").read_bytes())
        self.refused(USAGE, "hag", "a/tile.las", "b/tile.las", "-o", "out", says="has the same name as")


if __name__ == "__main__":
    unittest.main()
