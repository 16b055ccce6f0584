"""What is told of clouds, and which of their points are taken: coordinate systems, statistics, returns, flags."""
import json
import random
import struct
import unittest

from cli import BAD_INPUT, IGN, USAGE, CliTest


class CloudTest(CliTest):
    def info(self, *args):
        return self.json_lines(self.ok("info", *args, "--json"))[0]


class CoordinateSystems(CloudTest):
    def las(self, name, epsg):
        """A LAS file of a hundred points, whose GeoTIFF key says EPSG:`epsg`; 0: nothing."""
        keys = struct.pack("<8H", 1, 1, 0, 1, 3072, 0, 1, epsg) if epsg else b""
        record = struct.pack("<H16sHH32s", 0, b"LASF_Projection", 34735, len(keys), b"") + keys if epsg else b""
        rng = random.Random(epsg)
        points = b"".join(struct.pack("<iiiHBBBBH", *(rng.randrange(10**6) for _ in range(3)), 0, 9, 2, 0, 0, 0)
                          for _ in range(100))
        head = struct.pack("<4sHHIHH8sBB32s32sHHHIIBHI5I", b"LASF", 0, 0, 0, 0, 0, b"", 1, 2, b"", b"", 1, 2020, 227,
                           227 + len(record), bool(epsg), 0, 20, 100, *[0] * 5)
        head += struct.pack("<12d", *[0.001] * 3, *[0.0] * 3, *[1000.0, 0.0] * 3)
        (self.folder / name).write_bytes(head + record + points)
        return self.folder / name

    def test_different_systems_in_one_cloud_are_refused(self):
        north, south = self.las("north.las", 2154), self.las("south.las", 32740)
        self.refused(BAD_INPUT, "triangulate", north, south, "-o", self.out, says="Lambert-93 (EPSG:2154) and WGS 84 / UTM zone 40S")
        self.assertFalse(self.out.exists())
        self.refused(BAD_INPUT, "info", north, south, says="--crs")

    def test_the_system_that_is_given_holds(self):
        wkt = self.write("some.prj", "EPSG:3857\n")
        for crs in ("EPSG:3857", wkt):
            self.ok("triangulate", self.las("north.las", 2154), self.las("south.las", 32740), "-o", self.out, "--quiet",
                    "--crs", crs, "--overwrite")
            self.assertEqual(self.info(self.out)["crs"], "EPSG:3857")
            self.assertIn("Pseudo-Mercator", self.info(self.out)["crs_name"])

    def test_what_is_no_system_is_refused(self):
        cloud, text = self.las("a.las", 2154), self.write("notes.txt", "hello\n")
        self.refused(USAGE, "triangulate", cloud, "-o", self.out, "--crs", "EPSG:99999", says="--crs")
        self.refused(USAGE, "triangulate", cloud, "-o", self.out, "--crs", "Lambert", says="'Lambert' is no file: the coordinate system is neither EPSG:n nor WKT")
        self.refused(USAGE, "triangulate", cloud, "-o", self.out, "--crs", text, says="a file: the coordinate system is neither EPSG:n nor WKT")

    def test_files_without_a_system_beside_others_are_a_warning(self):
        done = self.ok("triangulate", self.las("a.las", 2154), self.las("b.las", 0), "-o", self.out)
        self.assertRegex(done, r"warning +1 of 2 files, .*b\.las the first")
        self.assertEqual(self.info(self.out)["crs_name"], "RGF93 v1 / Lambert-93 (EPSG:2154)")

    def test_keys_that_name_no_system_are_said_to_be_so(self):
        info = self.info(self.las("vague.las", 65000))
        self.assertEqual(info["crs"], "")
        self.assertIn("not understood", info["files"][0]["crs_note"])


class Descriptions(CloudTest):
    def test_all_points_are_counted_on_request(self):
        info = self.info(f"{IGN}/*.las", "--stats")["statistics"]
        files = self.info(f"{IGN}/*.las")
        self.assertEqual(files["statistics"], None)
        self.assertEqual(info["points"], files["points"])
        self.assertEqual(sum(info["classification"].values()), info["points"])
        self.assertEqual(sum(info["return_number"].values()), info["points"])
        self.assertGreater(info["density"], 0)
        ground = self.info(f"{IGN}/*.las", "--stats", "--class", "2")["statistics"]
        self.assertEqual(list(ground["classification"]), ["2"])
        self.assertEqual(ground["classification"]["2"], info["classification"]["2"])
        self.assertIn("2 ground: ", self.ok("info", f"{IGN}/*.las", "--stats"))

    def test_what_was_counted_is_not_guessed(self):
        cloud = self.write("long.csv", "".join(f"{i % 37}.1234567890123456 {i % 41}.12345678901234 {i}.123456789012345\n" for i in range(3000)))
        self.assertNotEqual(self.info(cloud)["points"], 3000)  # text leaves it open
        counted = self.info(cloud, "--stats")
        self.assertEqual((counted["points"], counted["statistics"]["points"]), (3000, 3000))
        said = self.ok("info", cloud, "--stats")
        self.assertEqual(said.count("3 000"), 2)
        ground = self.info(f"{IGN}/*.las", "--stats", "--class", "2", "--dim", "2")
        self.assertLess(ground["estimate"]["cells"], 2 * ground["statistics"]["classification"]["2"] + 1)

    def test_a_result_is_told_in_words_of_its_users(self):
        self.ok("triangulate", f"{IGN}/*.las", "-o", self.out, "--dim", "2", "--quiet")
        told = self.ok("info", self.out)
        self.assertRegex(told, r"density +\d\d\.\d vertices a square unit of the box\n")
        self.assertRegex(told, r"time +.* \(reading .*, triangulating .*, joining tiles .*, writing .*\)\n +memory +.* at most\n")
        for counter in ("credit_waits", "splaying", "tiles_again"):
            self.assertNotIn(counter, told)
        self.assertIn("credit_waits", self.ok("info", self.out, "--verbose"))

    def test_an_odd_file_does_not_hide_the_others(self):
        folder = self.folder / "block"
        folder.mkdir()
        for name, text in {"a.xyz": "1 2 3\n", "b.las": "no cloud", "c.xyz": "4 5 6\n"}.items():
            (folder / name).write_text(text)
        done = self.run_tessera("info", folder)
        self.assertEqual(done.returncode, BAD_INPUT)
        for part in ("a.xyz", "b.las: does not begin with LASF", "c.xyz"):
            self.assertIn(part, done.stdout)
        self.assertIn("1 of 3 files cannot be triangulated", done.stderr)
        self.assertEqual([("error" in f) for f in json.loads(self.run_tessera("info", folder, "--json").stdout.splitlines()[0])["files"]],
                         [False, True, False])

    def test_whoever_asks_for_what_is_not_there_hears_what_is(self):
        self.refused(BAD_INPUT, "triangulate", f"{IGN}/*.las", "-o", self.out, "--class", "77", says="there are the classes ")
        self.refused(BAD_INPUT, "triangulate", f"{IGN}/*.las", "-o", self.out, "--crop", "0,0,1,1", says="points lie at x from 77")

    def test_returns_and_flags_choose_points(self):
        counts = {which: self.info(f"{IGN}/*.las", "--stats", "--returns", which)["statistics"] for which in
                  ("all", "first", "last", "single")}
        kept = {which: c["points"] - c["filtered"] for which, c in counts.items()}
        self.assertEqual(kept["first"], counts["all"]["return_number"]["1"])
        self.assertEqual(kept["single"], counts["all"]["number_of_returns"]["1"])
        self.assertLess(kept["single"], kept["last"])
        self.ok("triangulate", f"{IGN}/*.las", "-o", self.out, "--returns", "last", "--without", "withheld,synthetic", "--quiet")
        self.assertEqual(self.info(self.out)["filtered"], kept["all"] - kept["last"])
        self.refused(USAGE, "info", f"{IGN}/*.las", "--returns", "second", says="none of all, first, last and single")
        self.refused(USAGE, "info", f"{IGN}/*.las", "--without", "hidden", says="'hidden' is none of")


if __name__ == "__main__":
    unittest.main()
