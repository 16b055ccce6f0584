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

    def test_few_points_are_few_a_unit(self):
        self.ok("triangulate", self.write("few.csv", "0 0 1\n7 0 1\n0 7 1\n7 7 1\n3 2 1\n"), "-o", self.out, "--dim", "2", "--quiet")
        self.assertRegex(self.ok("info", self.out), r"density +0\.102 vertices a square unit of the box\n")

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
        self.refused(USAGE, "info", f"{IGN}/*.las", "--returns", "second", says="not one of all, first, last and single")
        self.refused(USAGE, "info", f"{IGN}/*.las", "--without", "hidden", says="'hidden' is not one of")


class Columns(CloudTest):
    SURVEY = "".join(f"{i},{6000084 + i * i % 17},{500013 + i * i * i % 23},{7 + i % 3},{'GND' if i % 2 else 'EP, EDGE'}\n"
                     for i in range(100, 160)).replace("EP, EDGE", '"EP, EDGE"')

    def test_a_file_of_surveyors_is_read_by_the_names_of_its_columns(self):
        self.write("survey.txt", self.SURVEY)
        done = self.run_tessera("triangulate", "survey.txt", "-o", "wrong", "--dim", "2")
        self.assertRegex(done.stdout, "warning +survey.txt has no header that names x and y, .* by the option columns, as p,y,x,z")
        self.assertIn("counts up by one", (self.folder / "wrong" / "report.html").read_text())
        told = self.ok("info", "survey.txt")
        self.assertRegex(told, r"columns +x is column 1, y 2, z 3, by their places, as no header names them\n")
        self.assertIn("warning: survey.txt has no header", told)
        told = self.ok("info", "survey.txt", "--columns", "p,y,x,z")
        self.assertRegex(told, r"columns +x is column 3, y 2, z 4, as asked for\n +attributes +p\n")
        self.assertNotIn("warning", told)
        columns = self.info("survey.txt", "--columns", "p,y,x,z")["files"][0]["columns"]
        self.assertEqual(columns, {"x": 3, "y": 2, "z": 4, "by": "option"})
        self.write("named.csv", "number,northing,easting,height,code\n" + self.SURVEY)
        self.assertIn("by the header", self.ok("info", "named.csv"))
        with_names = ("triangulate", "survey.txt", "--dim", "2", "--columns", "p,y,x,z", "--attributes", "p")
        self.assertNotIn("warning", self.ok(*with_names, "-o", self.out))
        self.ok("triangulate", "named.csv", "--dim", "2", "-o", "named", "--quiet")
        self.assertEqual(self.info(self.out)["digest"], self.info("named")["digest"])
        self.assertEqual(self.info(self.out)["bounds"]["min"][:2], [500013, 6000084])
        # A region reads it so, too.
        self.ok("region", *with_names[1:], "--bbox", "0,0,1e9,1e9", "-o", "region.csv")
        rows = (self.folder / "region.csv").read_text().splitlines()
        self.assertEqual(len(rows) - 1, self.info(self.out)["cells"])

    def test_names_that_make_no_points_are_sentences(self):
        self.write("survey.txt", self.SURVEY)
        for names, says in (("p,n,e,z", "--columns: no column is called x"), ("x,y,x", "--columns: 'x' is there twice"),
                            ("x,,y", "--columns: "), ("p,y,x,z,_,_,q", "survey.txt, line 1: has 5 columns, but --columns names 7")):
            with self.subTest(names=names):
                self.refused(BAD_INPUT if "line" in says else USAGE, "triangulate", "survey.txt", "-o", self.out, "--columns", names, says=says)
        self.las()
        self.refused(USAGE, "info", "cloud.las", "--columns", "x,y,z", says="--columns: none of the input files is text or NumPy")
        self.assertFalse(self.out.exists())

    def test_a_run_is_resumed_with_the_same_names_alone(self):
        self.write("survey.txt", self.SURVEY)
        self.ok("triangulate", "survey.txt", "-o", self.out, "--dim", "2", "--columns", "p,y,x,z", "--quiet")
        digest = self.info(self.out)["digest"]
        self.ok("triangulate", "survey.txt", "-o", "other", "--dim", "2", "--columns", "_,x,y,z", "--quiet", env={"TESSERA_COLUMNS": "x,y"})
        self.assertNotEqual(self.info("other")["digest"], digest)
        self.ok("triangulate", "survey.txt", "-o", "third", "--dim", "2", "--quiet", env={"TESSERA_COLUMNS": "p,y,x,z"})
        self.assertEqual(self.info("third")["digest"], digest)


class EqualPoints(CloudTest):
    def test_in_2d_the_summary_tells_of_other_heights_and_any_can_be_kept(self):
        self.write("scan.csv", "x,y,z,i\n" + "".join(f"{x},{y},{z},{i}\n" for i, (x, y, z) in enumerate(
            (x, y, (7 * x + 3 * y + k) % 5) for k in (2, 0, 0, 4) for x in range(12) for y in range(12))))
        kept = {}
        for keep in ("first", "last", "lowest", "highest"):
            for tiles in (1, 6):
                out = f"{keep}{tiles}"
                done = self.ok("triangulate", "scan.csv", "-o", out, "--dim", "2", "--keep", keep, "--tiles", tiles, "--attributes", "i")
                others = self.info(out)["duplicates_at_other_heights"]
                self.assertRegex(done, rf"points +576, 432 duplicates, {others} of them at other heights \(the {keep} is kept\)\n")
                self.assertIn(f"{others} of them at other heights (the {keep} is kept)", self.ok("info", out))
                self.assertIn("at other heights", (self.folder / out / "report.html").read_text())
                self.assertEqual(self.info(out)["keep"], keep)
                self.ok("verify", out, "--against-cgal")
            self.assertEqual(self.info(f"{keep}1")["digest"], self.info(f"{keep}6")["digest"])
            self.ok("export", f"{keep}6", "-o", f"{keep}.csv")
            kept[keep] = self.ok("query", f"{keep}6", "star", "0", "--json")
        self.assertEqual(len({self.info(f"{keep}1")["digest"] for keep in kept}), 4)
        # Source index 0 is x 0, y 0, z 2; the others there have 0, 0 and 4.
        self.assertEqual([json.loads(star)["vertex"]["id"] for star in kept.values()], [0, 432, 144, 432])
        self.assertRegex(self.ok("info", "highest6"), r"heights +z from 3 to 4\n")
        self.assertRegex(self.ok("info", "lowest6"), r"heights +z from 0 to 1\n")
        self.assertIn("heights", (self.folder / "lowest6" / "report.html").read_text())

    def test_a_region_keeps_the_same_points_as_the_whole(self):
        rows = [(x, y, (7 * x + 3 * y + k) % 5) for k in (2, 0, 0, 4) for x in range(12) for y in range(12)]
        random.Random(3).shuffle(rows)
        files = [self.write(f"{part}.csv", "x,y,z\n" + "".join(f"{x},{y},{z}\n" for x, y, z in rows[part::4])) for part in range(4)]
        for keep in ("first", "last", "lowest", "highest"):
            self.ok("triangulate", *files, "-o", keep, "--dim", "2", "--keep", keep, "--quiet")
            self.ok("region", *files, "--bbox", "0,0,11,11", "-o", f"all-{keep}", "--dim", "2", "--keep", keep)
            self.assertEqual(self.info(f"all-{keep}")["digest"], self.info(keep)["digest"])
            self.assertEqual(self.info(f"all-{keep}")["heights"], self.info(keep)["heights"])

    def test_where_there_is_no_choice_it_is_a_sentence(self):
        self.xyz(columns=2)
        self.refused(USAGE, "triangulate", "cloud.xyz", "-o", self.out, "--keep", "lowest", says="--keep lowest: needs heights, and no input file has any")
        self.xyz("solid.xyz")
        self.refused(USAGE, "triangulate", "solid.xyz", "-o", self.out, "--keep", "last", says="--keep last: chooses among points of equal x and y")
        self.refused(USAGE, "info", "solid.xyz", "--dim", "2", "--keep", "highest", "--no-z", says="--keep highest: needs the heights, which --no-z leaves out")
        self.refused(USAGE, "info", "solid.xyz", "--keep", "middle", says="--keep: 'middle' is not one of first, last, lowest and highest")
        self.assertFalse(self.out.exists())


if __name__ == "__main__":
    unittest.main()
