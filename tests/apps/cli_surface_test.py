"""Closed surfaces and tracks by the command: in one step and in two, of any tiles, refused and interrupted."""
import collections
import pathlib
import re
import resource
import signal
import subprocess
import unittest

from cli import BAD_INPUT, CORRUPT, IGN, INTERRUPTED, IO, TESSERA, USAGE, CliTest

CLOUDS = pathlib.Path(__file__).parent.parent / "data" / "clouds"


def triangles_of_obj(data):
    """Numbers of vertices."""
    lines = data.decode().splitlines()
    return [tuple(int(number.split("/")[0]) for number in line.split()[1:]) for line in lines if line.startswith("f ")]


class Surface(CliTest):
    def told(self, *args):
        return self.json_lines(self.ok("surface", *args, "--json"))[-1]

    def test_it_is_the_same_in_one_step_and_in_any_tiles_memory_and_threads(self):
        cloud = CLOUDS / "ign_77050_627760.laz"
        one = self.told(cloud, "-o", "one.ply", "--threads", "1")
        self.assertIn("where pulses with several returns come together", one["sensors"])
        self.assertEqual([p.name for p in self.folder.iterdir()], ["one.ply"])
        for number, how in enumerate((["--tiles", "7", "--store", "points"], ["--tiles", "3", "--partition", "random"])):
            self.ok("triangulate", cloud, "--dim", "3", "-o", f"out{number}", "--attributes", "all", "--quiet", *how)
            two = self.told(f"out{number}", "-o", f"two{number}.obj", "--memory", "1M", "--threads", "2")
            self.assertEqual(two["digest"], one["digest"])
            self.assertGreater(two["rays_handed_over"], 0)
            sums = collections.Counter()
            for a, b, c in triangles_of_obj((self.folder / f"two{number}.obj").read_bytes()):
                for p, q in ((a, b), (b, c), (c, a)):
                    sums[min(p, q), max(p, q)] += 1 if p < q else -1
            self.assertEqual([edge for edge, total in sums.items() if total], [])
        self.ok("track", cloud, "-o", "track.csv", "--quiet")
        by_track = [self.told(f"out{number}", "-o", f"by{number}.ply", "--sensor", "track:track.csv") for number in (0, 1)]
        self.assertEqual(by_track[0]["digest"], by_track[1]["digest"])
        self.assertIn("by the track", by_track[0]["sensors"])
        self.assertNotEqual(self.told("out0", "-o", "above.ply", "--sensor", "vertical")["digest"], one["digest"])

    def test_its_files_for_vtk_name_each_array_once(self):
        self.ok("triangulate", f"{IGN}/ign_77050_627755.las", "-o", "block", "--crop", "770500,6277500,770515,6277515", "--attributes", "all", "--quiet")
        self.ok("surface", "block", "-o", "tiles/", "--format", "vtu", "--quiet")
        for file in (self.folder / "tiles").glob("*.vtu"):
            names = re.findall(rb'Name="([^"]+)"', file.read_bytes().split(b"<AppendedData")[0])
            self.assertIn(b"longest_edge", names)
            self.assertEqual(len(names), len(set(names)))

    def test_scan_angles_tell_where_the_sensor_was(self):
        cloud = CLOUDS / "autzen_trim.laz"
        by_angles = self.told(cloud, "-o", "angles.ply", "--sensor", "scan-angle")
        self.assertIn("where scan angles say, 27", by_angles["sensors"])
        self.assertNotEqual(by_angles["digest"], self.told(cloud, "-o", "above.ply", "--sensor", "vertical")["digest"])
        self.ok("triangulate", cloud, "--dim", "3", "-o", "out", "--attributes", "all", "--quiet")
        self.assertEqual(self.told("out", "-o", "two.ply", "--sensor", "scan-angle")["digest"], by_angles["digest"])
        self.ok("verify", "angles.ply", "--of", "out", "--quiet")
        few = self.run_tessera("surface", CLOUDS / "ign_77055_627755.laz", "-o", "few.ply", "--sensor", "scan-angle")
        self.assertEqual(few.returncode, USAGE)
        self.assertIn("scan angles span too little", few.stderr)

    def test_wrong_input_gets_a_sentence_and_leaves_nothing(self):
        cloud = self.xyz(n=300)
        self.ok("triangulate", cloud, "-o", "cells", "--quiet")
        self.ok("triangulate", cloud, "-o", "flat", "--dim", "2", "--quiet")
        (self.folder / "bad.csv").write_text("time,x,y,z\n1,2,3\n")
        (self.folder / "there.ply").write_text("kept")
        before = sorted(self.files(self.folder))
        for status, args, says in (
                (USAGE, [], "no result folder"),
                (USAGE, ["cells"], "no file to write"),
                (USAGE, ["flat", "-o", "x.ply"], "2D triangulation"),
                (USAGE, ["cells", "-o", "x.tif"], "'tif' is not a format"),
                (USAGE, ["cells", "-o", "there.ply"], "there.ply"),
                (USAGE, ["cells", "-o", "x.ply", "--sensor", "here"], "give auto, vertical"),
                (USAGE, ["cells", "-o", "x.ply", "--sensor", "point:1,2"], "'1,2' has 2 coordinates"),
                (USAGE, ["cells", "-o", "x.ply", "--sensor", "fields"], "x_origin"),
                (USAGE, ["cells", "-o", "x.ply", "--sensor", "scan-angle"], "no scan_angle"),
                (BAD_INPUT, ["cells", "-o", "x.ply", "--sensor", "track:bad.csv"], "bad.csv, line 2"),
                (IO, ["cells", "-o", "x.ply", "--sensor", "track:none.csv"], "none.csv"),
                (USAGE, ["cells", "-o", "x.ply", "--lambda", "-1"], "--lambda"),
                (USAGE, ["cells", "-o", "x.ply", "--alpha", "0"], "--alpha"),
                (USAGE, ["cells", "-o", "x.ply", "--sigma", "0"], "--sigma"),
                (USAGE, ["cells", "-o", "x.ply", "--trim", "-2"], "--trim"),
                (USAGE, ["cells", "-o", "x.ply", "--smooth", "1001"], "--smooth is more than 1000 rounds"),
                (USAGE, ["cells", "-o", "x.ply", "--smooth", "two"], "--smooth"),
                (USAGE, ["cells", "-o", "x.vtu", "--local"], "--local"),
                (USAGE, ["cells", "-o", "x.ply", "--trim", "1e-9"], "no surface"),
                (USAGE, ["cells", "-o", "x.ply", "--bottom", "flat"], "--bottom"),
                (USAGE, ["cells", "-o", "x.ply", "--unknown", "maybe"], "--unknown"),
                (IO, ["cells", "-o", "none/x.ply"], "none"),
                (IO, ["none", "-o", "x.ply"], "none")):
            with self.subTest(" ".join(args)):
                self.refused(status, "surface", *args, says=says)
                self.assertEqual(sorted(self.files(self.folder)), before)
        for status, args, says in ((USAGE, [], "no point files"), (USAGE, [cloud], "no file to write"),
                                   (USAGE, [cloud, "-o", "x.csv"], "gps_time"), (USAGE, [cloud, "-o", "bad.csv"], "bad.csv: exists"),
                                   (IO, ["none.las", "-o", "x.csv"], "none.las")):
            with self.subTest("track " + " ".join(map(str, args))):
                self.refused(status, "track", *args, says=says)
                self.assertEqual(sorted(self.files(self.folder)), before)

    def test_a_damaged_tile_is_told_of(self):
        self.ok("triangulate", self.xyz(n=2000), "-o", "cells", "--tiles", "3", "--quiet")
        tile = self.folder / "cells/tiles/000001.vtu"
        data = bytearray(tile.read_bytes())
        data[len(data) // 2] ^= 0x55
        tile.write_bytes(data)
        self.refused(CORRUPT, "surface", "cells", "-o", "x.ply", says="000001.vtu")
        self.assertEqual({p.name for p in self.folder.iterdir()} & {"x.ply"}, set())
        self.assertEqual([p.name for p in self.folder.iterdir() if ".surface" in p.name], [])

    def test_ctrl_c_leaves_nothing(self):
        self.ok("generate", "terrain", "--points", "300000", "-o", "t.las", "--quiet")
        self.ok("triangulate", "t.las", "--dim", "3", "-o", "cells", "--tiles", "4", "--quiet")
        for seconds in (0.2, 1.5, 3, 4.5):
            process = subprocess.Popen([TESSERA, "surface", "cells", "-o", "x.ply", "--manifold", "--smooth", "100"], cwd=self.folder, stdout=subprocess.PIPE,
                                       stderr=subprocess.PIPE, text=True)
            try:
                process.wait(seconds)
                break  # it was faster
            except subprocess.TimeoutExpired:
                process.send_signal(signal.SIGINT)
                _, errors = process.communicate(timeout=120)
                self.assertEqual(process.returncode, INTERRUPTED, errors)
                self.assertEqual({p.name for p in self.folder.iterdir()}, {"t.las", "cells"})

    def test_a_full_disk_gets_a_sentence_and_leaves_nothing(self):
        self.ok("triangulate", self.xyz(n=20000), "-o", "cells", "--tiles", "3", "--quiet")

        def limit():
            signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
            resource.setrlimit(resource.RLIMIT_FSIZE, (300_000, 300_000))

        for memory, how in (("1G", []), ("1M", []), ("1M", ["--manifold", "--smooth", "2"])):
            done = self.refused(IO, "surface", "cells", "-o", "x.ply", "--memory", memory, *how, preexec_fn=limit)
            self.assertIn("File too large", done.stderr)
            self.assertEqual({p.name for p in self.folder.iterdir() if "x.ply" in p.name}, set())


if __name__ == "__main__":
    unittest.main()
