"""What a user gets: results, summaries, machine-readable lines, and the other commands on a result."""
import json
import pathlib
import subprocess
import unittest

from cli import IGN, IO, MEMORY, TESSERA, USAGE, CliTest


class Triangulate(CliTest):
    def test_a_block_of_lidar_becomes_a_verified_result(self):
        text = self.ok("triangulate", f"{IGN}/*.las", "-o", self.out, "--tiles", "5", "--attributes", "intensity")
        for word in ["points", "262 813", "vertices", "tetrahedra", "tiles", "messages", "time", "memory"]:
            self.assertIn(word, text)
        names = self.files(self.out)
        for name in ["manifest.json", "triangulation.pvtu", "report.html", "duplicates.bin", "tiles/000000.vtu"]:
            self.assertIn(name, names)
        self.assertFalse([name for name in names if ".run" in name or ".tmp" in name or ".done" in name])
        self.assertIn("is the Delaunay triangulation", self.ok("verify", self.out))

        manifest = json.loads((self.out / "manifest.json").read_text())
        told = self.json_lines(self.ok("info", self.out, "--json"))[0]
        self.assertEqual(told["points"], 262813)
        self.assertEqual(told["points"], told["vertices"] + told["duplicates"] + told["invalid"] + told["filtered"])
        self.assertEqual(len(told["tiles"]), 5)
        self.assertIn("triangulate", told["command"])
        self.assertTrue(manifest)
        self.assertIn("tetrahedra", self.ok("info", self.out))

    def test_flat_clouds_are_triangulated_in_2d(self):
        cloud = self.xyz(columns=2, n=3000)
        self.ok("triangulate", cloud, "-o", self.out, "--tiles", "4", "--quiet")
        self.assertEqual(self.json_lines(self.ok("info", self.out, "--json"))[0]["dimension"], 2)
        self.ok("verify", self.out, "--against-cgal", "--quiet")
        self.ok("export", self.out, "-o", "mesh.geojson", "--quiet")
        self.assertEqual(json.loads((self.folder / "mesh.geojson").read_text())["type"], "FeatureCollection")

    def test_partitions_and_threads_change_no_cell(self):
        cloud = self.xyz(n=3000)
        counts = set()
        for i, options in enumerate([["--tiles", "1"], ["--partition", "grid", "--tiles", "8", "--threads", "2"],
                                     ["--partition", "octree", "--max-points-per-tile", "500"],
                                     ["--partition", "random", "--tiles", "3", "--threads", "4"]]):
            self.ok("triangulate", cloud, "-o", f"out{i}", "--quiet", *options)
            self.ok("verify", f"out{i}", "--against-cgal", "--quiet")
            counts.add(self.json_lines(self.ok("info", f"out{i}", "--json"))[0]["cells"])
        self.assertEqual(len(counts), 1)

    def test_filters_are_counted(self):
        cloud = self.xyz(n=4000)
        self.ok("triangulate", cloud, "-o", self.out, "--crop", "0,0,0.5,1", "--quiet")
        told = self.json_lines(self.ok("info", self.out, "--json"))[0]
        self.assertGreater(told["filtered"], 1500)
        self.assertEqual(told["points"], told["vertices"] + told["filtered"])

    def test_compressed_files_are_read_by_region_and_resolution(self):
        copc = pathlib.Path(__file__).resolve().parents[1] / "fuzz" / "corpus" / "laz" / "small.copc.laz"
        self.assertIn("COPC, LAZ 1.4, point format 6", self.ok("info", copc))
        self.ok("triangulate", copc, "-o", self.out, "--resolution", "1", "--attributes", "intensity", "--quiet")
        self.ok("verify", self.out, "--against-cgal", "--quiet")
        self.assertEqual(self.json_lines(self.ok("info", self.out, "--json"))[0]["points"], 256)
        self.refused(USAGE, "triangulate", f"{IGN}/*.las", "-o", "other", "--resolution", "1", says="is neither COPC nor EPT")
        self.refused(USAGE, "triangulate", copc, "-o", "other", "--resolution", "0", says="is not a distance")

    def test_points_that_are_not_finite_are_skipped_when_asked_for(self):
        cloud = self.write("bad.xyz", self.xyz(n=100).read_text() + "nan 1 2\n1 inf 2\n")
        self.ok("triangulate", cloud, "-o", self.out, "--skip-invalid", "--quiet")
        told = self.json_lines(self.ok("info", self.out, "--json"))[0]
        self.assertEqual((told["points"], told["invalid"], told["vertices"]), (102, 2, 100))

    def test_without_neighbours_the_files_are_smaller(self):
        cloud = self.xyz(n=3000)
        self.ok("triangulate", cloud, "-o", "with", "--quiet", "--tiles", "2")
        self.ok("triangulate", cloud, "-o", "without", "--quiet", "--tiles", "2", "--no-neighbors")
        size = lambda name: sum(p.stat().st_size for p in (self.folder / name / "tiles").iterdir())
        self.assertLess(size("without"), 0.75 * size("with"))
        self.ok("verify", "without", "--quiet")


class Output(CliTest):
    def test_quiet_is_quiet(self):
        done = self.run_tessera("triangulate", self.xyz(), "-o", self.out, "--quiet")
        self.assertEqual((done.returncode, done.stdout, done.stderr), (0, "", ""))
        done = self.run_tessera("verify", self.out, "--quiet")
        self.assertEqual((done.returncode, done.stdout, done.stderr), (0, "", ""))

    def test_json_is_one_object_a_line_and_ends_with_the_summary(self):
        done = self.run_tessera("triangulate", f"{IGN}/ign_77050_627760.las", "-o", self.out, "--json")
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        lines = self.json_lines(done.stdout)
        self.assertEqual({line["event"] for line in lines[:-1]} - {"progress"}, set())
        summary = lines[-1]
        self.assertEqual(summary["event"], "summary")
        self.assertEqual(summary["points"], 56035)
        self.assertEqual(summary["points"], summary["vertices"] + summary["duplicates"])
        self.assertGreater(summary["peak_memory_bytes"], 1 << 20)
        for phase in ["routing", "triangulating", "splaying", "collecting", "finishing"]:
            self.assertIn(phase, summary["seconds"])
        self.assertEqual(self.json_lines(self.ok("verify", self.out, "--json"))[0]["event"], "verified")

    def test_the_digest_is_that_of_the_triangulation_whatever_the_tiles(self):
        cloud = self.xyz(n=2000)
        told = {}
        for name, *options in (("one", "--tiles", "1"), ("nine", "--tiles", "9", "--threads", "1"),
                               ("grid", "--tiles", "5", "--partition", "grid", "--no-neighbors")):
            summary = self.json_lines(self.ok("triangulate", cloud, "-o", name, "--json", *options))[-1]
            told[name] = summary["digest"]
            self.assertRegex(told[name], "^[0-9a-f]{32}$")
            self.assertEqual(self.json_lines(self.ok("info", name, "--json"))[0]["digest"], told[name])
            self.assertIn(f"  digest              {told[name]}\n", self.ok("info", name))
            self.assertIn(f"digest {told[name]}", "".join(self.json_lines(self.ok("verify", name, "--json"))[0]["passed"]))
        self.assertEqual(len(set(told.values())), 1)
        self.assertIn(told["one"], self.ok("triangulate", cloud, "-o", "text", "--tiles", "4"))
        other = self.write("other.xyz", cloud.read_text() + "0.123 0.456 0.789\n")
        summary = self.json_lines(self.ok("triangulate", other, "-o", "other", "--json"))[-1]
        self.assertNotEqual(summary["digest"], told["one"])

    def test_json_tells_errors_too(self):
        done = self.refused(IO, "triangulate", "missing.las", "-o", self.out, "--json", says="missing.las")
        error = self.json_lines(done.stdout)[-1]
        self.assertEqual((error["event"], error["status"]), ("error", IO))
        self.assertIn("missing.las", error["message"])
        self.assertEqual(error["options"], [])

    def test_errors_name_options_as_flags_and_json_by_their_keys(self):
        cloud = self.xyz(n=30_000)
        args = ["triangulate", cloud, "-o", self.out, "--threads", "2"]
        done = self.refused(MEMORY, *args, "--memory", "1M", "--json", says=["--memory is too small", "or fewer --threads"])
        error = self.json_lines(done.stdout)[-1]
        self.assertEqual(error["options"], ["memory", "threads"])
        self.assertIn(error["message"], done.stderr)
        self.ok(*args, "--quiet")
        self.refused(USAGE, *args, says="out: holds a finished result; --overwrite replaces it")
        self.refused(USAGE, "export", self.out, "-o", "tiles.ply", "--format", "npy", says="an ending, and --format npy")
        self.refused(IO, "info", self.folder / "out" / "tiles", says="holds no point files")
        (self.folder / "block" / "sub").mkdir(parents=True)
        self.refused(IO, "info", self.folder / "block", says="; --recursive looks into its subfolders, too")
        self.refused(USAGE, "info", cloud, "--resolution", "1", says="no levels for --resolution to choose from")

    def test_no_name_of_a_file_is_taken_for_an_option(self):
        self.refused(IO, "info", "--", "a --memory \x01memory\x02.las", says="a --memory ?memory?.las: cannot be opened")

    def test_progress_and_logs_stay_off_standard_output(self):
        done = self.run_tessera("triangulate", self.xyz(), "-o", self.out, "-v")
        self.assertEqual(done.returncode, 0)
        self.assertTrue(done.stdout.startswith("points"))
        self.assertIn("routed", done.stderr)
        for name in ("manifest.json", "report.html"):
            self.assertNotRegex((self.out / name).read_text(), r"[\x00-\x08]|\\u000[0-8]")

    def test_a_full_standard_output_is_an_error(self):
        cloud = self.xyz()
        with open("/dev/full", "w") as full:
            done = subprocess.run([TESSERA, "info", str(cloud)], stdout=full, stderr=subprocess.PIPE, text=True)
        self.assertEqual(done.returncode, IO)
        self.assertIn("standard output", done.stderr)

    def test_the_report_is_one_file_without_network(self):
        self.ok("triangulate", self.xyz(), "-o", self.out, "--tiles", "3", "--quiet")
        html = (self.out / "report.html").read_text()
        self.assertIn("<svg", html)
        self.assertNotIn("http", html)


class Others(CliTest):
    def test_info_tells_what_triangulating_would_take(self):
        cloud = self.xyz(n=5000)
        told = self.json_lines(self.ok("info", cloud, "--json", "--max-points-per-tile", "1k"))[0]
        self.assertEqual(told["files"][0]["format"], "xyz")
        self.assertGreaterEqual(told["tiles"], 5)
        self.assertGreater(told["estimate"]["result_bytes"], 5000 * 33)
        text = self.ok("info", f"{IGN}/ign_77050_627755.las")
        for part in ["73 355", "RGF93", "intensity", "770500", "tiles", "memory", "disk", "time"]:
            self.assertIn(part, text)

    def test_every_export_format_can_be_written(self):
        self.ok("triangulate", self.xyz(n=500), "-o", self.out, "--tiles", "2", "--quiet")
        for name in ["mesh.ply", "mesh.off", "mesh.vtu", "mesh.mesh", "mesh.msh"]:
            self.ok("export", self.out, "-o", name)
            self.assertGreater((self.folder / name).stat().st_size, 10_000)
        self.refused(USAGE, "export", self.out, "-o", "mesh.ply", says=["mesh.ply", "--overwrite"])
        self.ok("export", self.out, "-o", "mesh.ply", "--overwrite")
        self.refused(USAGE, "export", self.out, "-o", "mesh.geojson", says=["geojson", "3D"])
        self.refused(IO, "export", self.folder / "nothing", "-o", "x.ply", says="nothing")

    def test_generated_clouds_depend_on_kind_and_seed_alone(self):
        for kind in ["uniform", "normal", "sphere", "grid", "terrain"]:
            self.ok("generate", kind, "-n", "1k", "--seed", "7", "-o", f"{kind}.npy")
        self.ok("generate", "uniform", "-n", "1k", "--seed", "7", "-o", "again.npy")
        self.ok("generate", "uniform", "-n", "1k", "--seed", "8", "-o", "other.npy")
        read = lambda name: (self.folder / name).read_bytes()
        self.assertEqual(read("uniform.npy"), read("again.npy"))
        self.assertNotEqual(read("uniform.npy"), read("other.npy"))

    def test_generated_files_are_read_back(self):
        for ending in ["las", "ply", "npy", "xyz"]:
            self.ok("generate", "uniform", "-n", "1.5k", "-o", f"cloud.{ending}")
            told = self.json_lines(self.ok("info", f"cloud.{ending}", "--json"))[0]
            if ending != "xyz":
                self.assertEqual(told["points"], 1500)
        self.refused(USAGE, "generate", "uniform", "-n", "10", "-o", "cloud.ply", says="--overwrite")
        self.refused(USAGE, "generate", "fractal", "-n", "10", "-o", "f.ply", says="fractal")
        self.refused(USAGE, "generate", "uniform", "-n", "many", "-o", "f.ply", says="many")


if __name__ == "__main__":
    unittest.main()
