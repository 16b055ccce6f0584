"""verify, measure, export, hag, products of results, info and upload with a daemon: what is sent, what arrives, and what is said when it does not."""
import os
import pathlib
import signal
import subprocess
import unittest

from cli import BAD_INPUT, CORRUPT, INTERRUPTED, IO, NOT_DELAUNAY, OK, TESSERA, USAGE
from cli_server import ServerTest
from fake_server import xxh3

PROVED = {"event": "verified", "result": "block", "cells": 12, "facets": 30, "hull_facets": 6, "vertices": 7, "passed": ["hull"]}


class Verify(ServerTest):
    def test_a_proof_is_told_as_here(self):
        def work(job):
            job.outcome = PROVED
            job.tell("successful", triangulation="block")
        self.server.on_submit = work
        said = self.ok("verify", "block/", "--memory", "2G", "--against-cgal")
        self.assertEqual(said, "ok  hull\nblock is the Delaunay triangulation of its 7 vertices: 12 cells, 30 facets, 6 of them "
                               "on the hull\n")
        self.assertEqual(self.server.jobs["j1"].inputs, {"triangulation": "block", "memory": "2G", "against_cgal": True})
        self.assertEqual(self.json_lines(self.ok("verify", "block", "--json"))[-1], PROVED)
        self.assertEqual(self.ok("verify", "block", "--quiet"), "")

    def test_what_is_wrong_is_the_exit_status(self):
        problem = {"detail": "tile 3, cell 5: not empty", "cause": NOT_DELAUNAY}
        self.server.on_submit = lambda job: job.tell("failed", problem=problem)
        self.refused(NOT_DELAUNAY, "verify", "block", says="tile 3, cell 5: not empty")

    def test_detached_it_says_how_to_look_again(self):
        self.assertIn("'tessera watch j1' shows it", self.ok("verify", "block", "--detach"))
        self.refused(USAGE, "verify", "block", "--server", "", "--detach", says="--detach")
        self.refused(USAGE, "verify", "block", "--scratch", "/tmp", says="--scratch")

    def test_a_folder_here_is_no_result_there(self):
        self.make_result()
        self.server.refusals["POST", "/v1/processes/verify/execution"] = (
            422, {"detail": "triangulation: there is none called 'made-block'", "cause": USAGE})
        self.refused(USAGE, "verify", "made-block", says=["there is none called", "made-block is a folder here", "--server ''"])
        self.assertEqual(self.run_tessera("verify", "made-block", "--server", "").returncode, OK)


class Measure(ServerTest):
    def test_columns_are_told_as_here(self):
        self.make_result()
        here = self.local("measure", self.server.results["block"], "--volume", "--json")
        (told,) = self.json_lines(here.stdout)
        told["output"] = "block"

        def work(job):
            job.outcome = told
            job.tell("successful", triangulation="block")
        self.server.on_submit = work
        said = self.ok("measure", "block/", "--volume", "--memory", "2G", "--threads", 3)
        self.assertRegex(said, "^block: version 2 has the columns volume of cells, star_volume of vertices\nvolume of all cells: ")
        self.assertEqual(self.server.jobs["j1"].inputs, {"triangulation": "block", "volume": True, "memory": "2G", "threads": 3})
        self.assertEqual(self.json_lines(self.ok("measure", "block", "--volume", "--json"))[-1], told)
        self.assertIn("'tessera watch j3' shows it", self.ok("measure", "block", "--volume", "--detach"))
        self.refused(USAGE, "measure", "block", "--server", "", "--volume", "--detach", says="--detach")
        for nonsense in {}, {"event": 7}, told | {"columns": [3]}, told | {"made": "yes"}:
            job = self.server.jobs["j3"]
            job.outcome = nonsense
            self.assertIn("successful", self.ok("watch", "j3"))


class Hag(ServerTest):
    def setUp(self):
        super().setUp()
        self.cloud = pathlib.Path(__file__).resolve().parents[1] / "data" / "clouds" / "pdal_mvk_thin.las"
        self.ground = self.folder / "made-ground"
        done = self.local("triangulate", self.cloud, "-o", self.ground, "--dim", 2, "--class", 2)
        self.assertEqual(done.returncode, OK, done.stderr)
        self.server.results["ground"] = self.ground
        self.server.on_submit = self.work

    def work(self, job):
        """What the daemon does: the local command writes it."""
        output = job.inputs["output"]
        to = self.ground / "exports" / output
        more = ["--format", job.inputs["format"]] if "format" in job.inputs else []
        done = self.local("hag", self.cloud, "--ground", self.ground, "-o", to, "--json", *more)
        self.assertEqual(done.returncode, OK, done.stderr)
        told = self.json_lines(done.stdout)[-1]
        for file in told["files"]:
            file["input"], file["output"] = "mvk.las", pathlib.Path(file["output"]).name
        written = [{"path": f"exports/{output}/{path.name}", "bytes": path.stat().st_size, "xxh3": xxh3(path.read_bytes())}
                   for path in sorted(to.iterdir())]
        job.outcome = told | {"output": output, "written": written}
        job.tell("successful", triangulation="ground")

    def test_the_copies_arrive_and_are_gone_there(self):
        said = self.ok("hag", "mvk.las", "-o", "out", "--ground", "ground/", "--outside", "-1", "--replace", "--memory", "2G")
        self.assertIn("out: 6 280 points of 1 file have the dimension HeightAboveGround", said)
        inputs = self.server.jobs["j1"].inputs
        self.assertRegex(inputs.pop("output"), "^[0-9a-f]{32}$")
        self.assertEqual(inputs, {"inputs": ["mvk.las"], "triangulation": "ground", "outside": -1, "replace": True, "memory": "2G"})
        self.assertEqual(list((self.ground / "exports").iterdir()), [])
        self.local("hag", self.cloud, "--ground", self.ground, "-o", "here")
        self.assertEqual((self.folder / "out" / self.cloud.name).read_bytes(), (self.folder / "here" / self.cloud.name).read_bytes())
        self.refused(USAGE, "hag", "mvk.las", "-o", "out", "--ground", "ground", says=["exists already; --overwrite", "fetches what"])
        self.ok("hag", "mvk.las", "-o", "out", "--ground", "ground", "--overwrite")
        self.assertEqual(self.json_lines(self.ok("hag", "mvk.las", "-o", "more", "--ground", "ground", "--json"))[-1]["points"], 6280)

    def test_what_is_wrong_is_found_before_the_daemon_is_asked(self):
        self.refused(USAGE, "hag", "mvk.las", "-o", "out", says="a daemon needs the ground as one of its results")
        self.refused(USAGE, "hag", "-", "-o", "out", "--ground", "ground", says="standard input")
        self.refused(USAGE, "hag", "mvk.las", "-o", "out", "--ground", "ground", "--ground-class", "2", says="--ground-class")
        self.refused(USAGE, "hag", "mvk.las", "-o", "out", "--ground", "ground", "--format", "copc", says="copc")
        self.assertEqual(self.server.requests, [])

    def test_left_there_they_are_fetched_by_their_job(self):
        self.assertIn("'tessera watch j1' shows it", self.ok("hag", "mvk.las", "-o", "out", "--ground", "ground", "--detach"))
        self.assertEqual(self.server.jobs["j1"].inputs["output"], "out")
        self.assertRegex(self.ok("watch", "j1"), "ground: 6 280 points of 1 file have")
        self.ok("fetch", "j1", "-o", "here")
        self.assertEqual((self.folder / "here" / self.cloud.name).read_bytes(),
                         (self.ground / "exports" / "out" / self.cloud.name).read_bytes())
        self.refused(USAGE, "fetch", "j1", "-o", "here", says="exists already")
        for path in "exports/out/../../x.las", "exports/x.las", "exports/out/":
            self.server.jobs["j1"].outcome["written"][0]["path"] = path
            self.refused(CORRUPT, "fetch", "j1", "-o", "there", says="the server")
        self.assertFalse((self.folder / "there").exists())


class Products(ServerTest):
    def setUp(self):
        super().setUp()
        self.make_result()
        self.made = self.server.results["block"] / "exports"

    def work(self, job):
        """What the daemon does: the local command writes it."""
        output = self.made / job.inputs["output"]
        self.made.mkdir(exist_ok=True)
        done = self.local("alpha", self.server.results["block"], "--alpha", job.inputs.get("alpha", "auto"), "-o", output, "--json")
        self.assertEqual(done.returncode, OK, done.stderr)
        job.outcome = {**self.json_lines(done.stdout)[-1], "output": output.name, "written": [
            {"path": f"exports/{output.name}", "bytes": output.stat().st_size, "xxh3": xxh3(output.read_bytes())}]}
        job.tell("successful", triangulation="block")

    def test_a_shape_arrives_and_is_gone_there(self):
        self.server.on_submit = self.work
        said = self.ok("alpha", "block/", "--alpha", "auto", "-o", "shape.ply", "--memory", "2G")
        inputs = self.server.jobs["j1"].inputs
        self.assertRegex(inputs.pop("output"), "[.]ply$")
        self.assertEqual(inputs, {"triangulation": "block", "memory": "2G"})
        self.assertEqual(list(self.made.iterdir()), [])
        here = self.local("alpha", self.server.results["block"], "--alpha", "auto", "-o", "here.ply")
        self.assertEqual(said.replace("shape.ply", "here.ply").splitlines()[-1], here.stdout.splitlines()[-1])
        self.assertEqual((self.folder / "shape.ply").read_bytes(), (self.folder / "here.ply").read_bytes())
        told = self.json_lines(self.ok("alpha", "block", "--alpha", "100000", "-o", "more.ply", "--json"))[-1]
        self.assertEqual((told["event"], told["output"], told["radius"]), ("alpha", "more.ply", 100000))
        self.assertNotIn("written", told)
        self.refused(USAGE, "alpha", "block", "--alpha", "auto", "-o", "shape.ply", says="exists already; --overwrite")

    def test_left_there_it_is_fetched_by_its_job(self):
        self.server.on_submit = self.work
        self.assertIn("'tessera watch j1' shows it", self.ok("alpha", "block", "--alpha", "auto", "-o", "shape.ply", "--detach"))
        self.assertEqual(self.server.jobs["j1"].inputs["output"], "shape.ply")
        self.assertIn("shape.ply: ", self.ok("watch", "j1"))
        self.ok("fetch", "j1", "-o", "here.ply")
        self.assertEqual((self.folder / "here.ply").read_bytes(), (self.made / "shape.ply").read_bytes())

    def test_polygons_are_sent_as_text(self):
        square = '{"type": "Polygon", "coordinates": [[[0, 0], [1, 0], [1, 1], [0, 0]]]}'
        (self.folder / "square.geojson").write_text(square)
        self.ok("voronoi", "block", "-o", "cells.gpkg", "--clip", "square.geojson", "--detach")
        self.assertEqual(self.server.jobs["j1"].inputs, {"triangulation": "block", "output": "cells.gpkg", "clip": square})
        self.ok("voronoi", "block", "-o", "cells.gpkg", "--clip", "0,0,1,1", "--detach")
        self.assertEqual(self.server.jobs["j2"].inputs["clip"], "0,0,1,1")
        self.ok("volume", "block", "after/", "-o", "v.csv", "--within", "square.geojson", "--detach")
        self.assertEqual(self.server.jobs["j3"].inputs, {"triangulation": "block", "output": "v.csv", "second": "after", "within": square})
        self.ok("density", "block", "-o", "d.npy", "--res", "2", "--curl", "vx,vy", "--detach")
        self.assertEqual(self.server.jobs["j4"].inputs, {"triangulation": "block", "output": "d.npy", "res": 2, "curl": ["vx", "vy"]})
        self.ok("density", "block", "-o", "d.h5", "--grid", "64,32", "--shear", "vx,vy", "--detach")
        self.assertEqual(self.server.jobs["j5"].inputs, {"triangulation": "block", "output": "d.h5", "grid": [64, 32], "shear": ["vx", "vy"]})

    def test_what_is_wrong_is_found_before_the_daemon_is_asked(self):
        self.refused(USAGE, "voronoi", "block", "-o", "cells.gpkg", "--clip", "square.gpkg", says="GeoJSON")
        self.refused(USAGE, "volume", "block", "after", says="-o FILE.csv")
        self.refused(USAGE, "volume", "block", "after", "-o", "v.csv", "--difference", "d.tif", "--res", "1", says="is not for a job of a daemon")
        self.refused(USAGE, "alpha", self.server.results["block"], "--alpha", "auto", "-o", "a.ply", "--server", "", "--detach", says="--detach")
        self.assertEqual(self.server.requests, [])


class Export(ServerTest):
    def setUp(self):
        super().setUp()
        self.make_result()
        self.made = self.server.results["block"] / "exports"

    def work(self, job):
        """What the daemon does: the local command writes it."""
        output = job.inputs["output"]
        self.made.mkdir(exist_ok=True)
        more = ["--format", job.inputs["format"]] if "format" in job.inputs else []
        done = self.local("export", self.server.results["block"], "-o", self.made / output, "--json", "--overwrite", *more)
        self.assertEqual(done.returncode, OK, done.stderr)
        (told,) = self.json_lines(done.stdout)
        self.bytes = {path.relative_to(self.made): path.read_bytes() for path in self.made.rglob("*") if path.is_file()}
        written = [{"path": f"exports/{path}", "bytes": len(content), "xxh3": xxh3(content)}
                   for path, content in self.bytes.items()]
        job.outcome = told | {"output": output, "written": written}
        job.tell("successful", triangulation="block")

    def test_the_file_arrives_and_is_gone_there(self):
        self.server.on_submit = self.work
        said = self.ok("export", "block", "-o", "mesh.off", "--max-edge", "2", "--no-z")
        self.assertRegex(said, "^mesh.off: 2 000 vertices, .* cells, .*\n0 cells with longer edges than 2 are left out\n$")
        self.assertEqual(self.server.jobs["j1"].inputs,
                         {"triangulation": "block", "output": "mesh.off", "max_edge": 2.0, "heights": False})
        (content,) = self.bytes.values()
        self.assertEqual((self.folder / "mesh.off").read_bytes(), content)
        self.assertEqual(list(self.made.iterdir()), [])

    def test_a_folder_of_tiles_arrives_too(self):
        self.server.on_submit = self.work
        (line,) = self.json_lines(self.ok("export", "block", "-o", "tiles/", "--format", "vtu", "--json"))[-1:]
        self.assertEqual((line["event"], line["output"], line["files"]), ("exported", "tiles", 5))
        here = {path.relative_to(self.folder): path.read_bytes() for path in (self.folder / "tiles").iterdir()}
        self.assertEqual(here, self.bytes)

    def test_what_a_server_says_leads_nowhere_else(self):
        (self.folder / "out/arr").mkdir(parents=True)
        (self.folder / "out/arr.py").write_text("mine")
        (self.folder / "x.py").write_text("mine")

        def here():  # beside what the server has
            return sorted(path for path in self.folder.rglob("*") if not path.is_relative_to(self.server.results["block"]))
        before = here()

        def hostile(output, *written):
            def work(job):
                self.work(job)
                for path in written:
                    file = self.server.results["block"] / path
                    if not file.exists() and file.resolve().is_relative_to(self.server.results["block"].resolve()):
                        file.parent.mkdir(parents=True, exist_ok=True)
                        file.write_bytes(b"PWNED")
                job.outcome |= {"output": output, "written": [{"path": path, "bytes": 5, "xxh3": xxh3(b"PWNED")} for path in written]}
            return work

        folder, file = ("-o", "out/arr/", "--format", "npy"), ("-o", "x.off")
        for target, output, path in ((folder, "a/b", "exports/PWNED"), (folder, "a/b/c/d", "exports/a/PWNED"),
                                     (folder, "arr", "exports/PWNED"), (folder, "..", "exports/PWNED"),
                                     (folder, "arr", "exports/arr/../../../PWNED"), (file, "x.off", "exports/x.py"),
                                     (file, "x.py", "exports/x.py"), (file, "../x.off", "exports/x.off"),
                                     (file, "x.off", "exports/y/x.off")):
            self.server.on_submit = hostile(output, path)
            done = self.run_tessera("export", "block", *target, "--overwrite")
            self.assertIn(done.returncode, (IO, CORRUPT), (output, path, done.stdout, done.stderr))
            self.assertEqual(here(), before, (output, path))
            self.assertEqual((self.folder / "x.py").read_text(), "mine")
        # By its job, when nobody here knows what was asked for.
        self.server.on_submit = hostile("a/b", "exports/PWNED")
        self.ok("export", "block", "-o", "arr", "--format", "npy", "--detach")
        job = max(self.server.jobs, key=lambda name: int(name[1:]))
        self.run_tessera("watch", job)
        self.refused(CORRUPT, "fetch", job, "-o", "out/arr", says="exports/PWNED")
        self.assertEqual(here(), before)

    def test_a_connection_that_ends_is_gone_on_with_and_damage_is_found(self):
        self.server.on_submit = self.work
        self.server.spoil["exports/mesh.off"] = lambda content: content[:-1] + b"?"
        self.refused(CORRUPT, "export", "block", "-o", "mesh.off", says=["block/exports/mesh.off", "checksum"])
        self.assertFalse((self.folder / "mesh.off").exists())

    def test_what_stands_here_is_looked_at_first(self):
        self.write("mesh.off", "mine")
        self.refused(USAGE, "export", "block", "-o", "mesh.off", says=["mesh.off", "--overwrite"])
        self.refused(USAGE, "export", "block", "-o", "mesh.3ds", says="3ds")
        self.refused(IO, "export", "block", "-o", "nowhere/mesh.off", says=["nowhere", "no such folder"])
        self.assertEqual(self.server.requests, [])
        self.server.on_submit = self.work
        self.ok("export", "block", "-o", "mesh.off", "--overwrite")
        self.assertGreater((self.folder / "mesh.off").stat().st_size, 1000)

    def test_left_there_it_is_fetched_by_its_job(self):
        self.server.on_submit = self.work
        self.assertIn("'tessera watch j1' shows it", self.ok("export", "block", "-o", "mesh.off", "--detach"))
        self.assertRegex(self.ok("watch", "j1"), "^mesh.off: 2 000 vertices")
        self.assertRegex(self.ok("fetch", "j1", "-o", "here.off"), "^here.off: 2 000 vertices")
        self.assertEqual((self.folder / "here.off").read_bytes(), (self.made / "mesh.off").read_bytes())
        self.refused(USAGE, "fetch", "j1", "-o", "here.off", says="exists already")

    def test_ctrl_c_says_how_to_fetch_it(self):
        process = subprocess.Popen([TESSERA, "export", "block", "-o", "mesh.off"], cwd=self.folder, text=True,
                                   stderr=subprocess.PIPE, env=os.environ | self.asking)
        self.addCleanup(process.stderr.close)
        self.assertEqual(process.stderr.readline(), "job j1 is accepted\n")
        process.send_signal(signal.SIGINT)
        _, errors = process.communicate(timeout=60)
        self.assertEqual(process.returncode, INTERRUPTED)
        for part in ("the job continues", "'tessera watch j1' shows it", "'tessera cancel j1' stops", "'tessera fetch j1 -o mesh.off'"):
            self.assertIn(part, errors)


class Info(ServerTest):
    def test_inputs_are_described_as_here(self):
        cloud = self.xyz()
        self.server.described = self.json_lines(self.local("info", cloud, "--json", "--stats", "--memory", "2G").stdout)[0]
        here = self.local("info", cloud, "--stats", "--memory", "2G").stdout
        self.assertEqual(self.ok("info", "cloud.xyz", "--stats", "--dim", 3), here)
        (line,) = self.json_lines(self.ok("info", "cloud.xyz", "--json"))
        self.assertEqual(line, self.server.described)
        self.server.described = {"files": [{"no": 1}]}
        self.refused(IO, "info", "cloud.xyz", says="not what was asked for")

    def test_what_takes_long_is_a_job(self):
        cloud = self.xyz()
        given = ("--memory", "1G")  # else it is told what is free, which changes
        told = self.json_lines(self.local("info", cloud, *given, "--json").stdout)[0]
        def work(job):
            job.outcome = told
            job.tell("successful")
        self.server.on_submit = work
        self.assertEqual(self.ok("info", "cloud.xyz.gz", *given), self.local("info", cloud, *given).stdout)
        self.server.on_submit = lambda job: job.tell("failed", problem={"detail": "inputs: bad", "cause": BAD_INPUT})
        self.refused(BAD_INPUT, "info", "cloud.xyz.gz", says="inputs: bad")

    def test_a_result_goes_first(self):
        self.make_result()
        folder = self.server.results["block"]
        told = self.json_lines(self.local("info", folder, "--json").stdout)[0]
        self.server.described = told
        said = self.ok("info", "block")
        self.assertEqual(said.splitlines()[1:], self.local("info", folder).stdout.splitlines()[1:])
        self.assertEqual(said.splitlines()[0], "block")
        self.assertIn(b'"triangulation":"block"', self.server.asked("POST", "info")[0][3])

    def test_what_is_here_alone_can_be_sent(self):
        self.xyz()
        self.server.refusals["POST", "/v1/processes/info/execution"] = (422, {"detail": "inputs: cloud.xyz: is not there", "cause": IO})
        self.refused(IO, "info", "cloud.xyz", says=["is not there", "'tessera upload' sends"])
        self.refused(USAGE, "info", "-", says="standard input")


class Upload(ServerTest):
    def test_files_arrive_and_their_names_are_told(self):
        a, b = self.xyz("a.xyz"), self.write("b.las", b"x" * 3_000_000)
        self.assertEqual(self.ok("upload", a, b, "-o", "mine/").splitlines()[1], "upload:mine/b.las: 2.86 MiB")
        self.assertEqual(self.server.uploads, {"mine/a.xyz": a.read_bytes(), "mine/b.las": b.read_bytes()})
        (line,) = self.json_lines(self.ok("upload", b, "-o", "mine", "--json"))
        self.assertEqual(line, {"event": "uploaded", "input": "upload:mine/b.las", "bytes": 3_000_000})
        self.ok("upload", self.write("empty", ""), "-o", "mine")
        self.assertEqual(self.server.uploads["mine/empty"], b"")

    def test_a_connection_that_ends_is_gone_on_with(self):
        content = os.urandom(3_000_000)
        self.server.cut_uploads_after = [1_000_000, 500_000]
        self.ok("upload", self.write("a.las", content), "-o", "mine")
        self.assertEqual(self.server.uploads, {"mine/a.las": content})
        self.assertEqual([put[2].get("Upload-Offset") for put in self.server.asked("PUT", "")], [None, "1000000", "1500000"])

    def test_what_cannot_be_sent_is_told_first(self):
        a = self.xyz("a.xyz")
        self.refused(USAGE, "upload", a, says="-o NAME")
        self.refused(USAGE, "upload", "-o", "mine", says="no file")
        self.refused(USAGE, "upload", self.folder, "-o", "mine", says="is a folder")
        self.refused(IO, "upload", a, "missing.las", "-o", "mine", says="missing.las")
        self.refused(USAGE, "upload", a, "./a.xyz", "-o", "mine", says="same name")
        self.assertEqual(self.server.requests, [])

    def test_a_daemon_that_takes_none_says_so(self):
        self.server.uploads = None
        self.refused(USAGE, "upload", self.write("a.las", b"x" * 10_000_000), "-o", "mine", says="takes no uploads")


if __name__ == "__main__":
    unittest.main()
