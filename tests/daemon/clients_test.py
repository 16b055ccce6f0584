"""The command and the Python package with the real daemon: what is done there is what is done here."""
import json
import os
import shutil
import signal
import subprocess
import unittest

from daemon import IGN, TESSERA, DaemonTest

try:
    import tessera
except ImportError:  # built without it
    tessera = None

IO, USAGE = 4, 2


class ClientsTest(DaemonTest):
    def setUp(self):
        super().setUp()
        self.daemon = self.start("--uploads")

    def ask(self, *args, status=0, token=None):
        env = {k: v for k, v in os.environ.items() if not k.startswith("TESSERA")}
        env |= {"TESSERA_SERVER": self.daemon.url, "TESSERA_TOKEN": token or self.daemon.token}
        done = subprocess.run([TESSERA, *map(str, args)], cwd=self.folder, text=True, stdout=subprocess.PIPE,
                              stderr=subprocess.PIPE, env=env)
        self.assertEqual(done.returncode, status, done.stderr)
        if status == 0:
            return done.stdout
        self.assertTrue(done.stderr.splitlines()[-1].startswith("tessera: "), done.stderr)
        return done.stderr.splitlines()[-1]

    def both(self):
        """A result of the daemon, and the same made here."""
        self.ask("triangulate", "*.las", "-o", "block", "--tiles", "5", "--dim", "2", "--class", "2,9")
        self.tessera("triangulate", *sorted(IGN.glob("*.las")), "-o", "here", "--tiles", "5", "--dim", "2", "--class", "2,9")


class Command(ClientsTest):
    def test_verify_export_and_info_tell_and_make_what_they_do_here(self):
        self.both()
        self.assertEqual(self.ask("verify", "block"), self.tessera("verify", "here").replace("here is", "block is"))
        for name, more in (("mesh.ply", []), ("mesh.csv", []), ("tin.gpkg", ["--max-edge", "5"]), ("tiles/", ["--format", "vtu"])):
            there = self.ask("export", "block", "-o", name, *more)
            self.assertEqual(there, self.tessera("export", "here", "-o", f"local/{name}", *more).replace("local/", "")
                             if (self.folder / "local").is_dir() or (self.folder / "local").mkdir() is None else "")
            made = sorted((self.folder / "local").rglob("*.*"))
            for path in made:
                here = self.folder / path.relative_to(self.folder / "local")
                self.assertEqual(here.stat().st_size, path.stat().st_size, path)
                if path.suffix != ".gpkg":  # has the time in it
                    self.assertEqual(here.read_bytes(), path.read_bytes(), path)
        self.assertEqual(list((self.folder / "data/results/block/exports").iterdir()), [])
        there, here = json.loads(self.ask("info", "block", "--json")), json.loads(self.tessera("info", "here", "--json"))
        for key in ("vertices", "cells", "digest", "bounds", "attributes", "crs"):
            self.assertEqual(there[key], here[key])
        self.assertIn(here["digest"], self.ask("info", "block/"))
        options = ["--memory", "500M", "--threads", "1", "--stats"]
        self.assertEqual(self.ask("info", "*.las", *options).replace(str(IGN.resolve()), str(IGN)),
                         self.tessera("info", *sorted(IGN.glob("*.las")), *options))

    def test_files_from_here_are_sent_and_triangulated(self):
        names = sorted(IGN.glob("*.las"))[:2]
        shutil.copy(names[0], self.folder / "mine.las")
        said = self.ask("triangulate", "mine.las", "-o", "mine", status=IO)
        self.assertIn("'tessera upload' sends", said)
        self.assertIn("upload:mine/mine.las: ", self.ask("upload", "mine.las", "-o", "mine"))
        self.ask("triangulate", "upload:mine", "-o", "mine")
        self.tessera("triangulate", "mine.las", "-o", "here")
        self.assertEqual(json.loads(self.ask("info", "mine", "--json"))["digest"],
                         json.loads(self.tessera("info", "here", "--json"))["digest"])
        self.tessera("generate", "uniform", "-n", "1000", "-o", "cloud.xyz")
        subprocess.run(["gzip", "cloud.xyz"], cwd=self.folder, check=True)
        self.ask("upload", "cloud.xyz.gz", "-o", "mine")
        self.assertIn("gzip", self.ask("info", "upload:mine/cloud.xyz.gz"))  # by a job

    def test_what_was_left_there_is_fetched(self):
        self.both()
        job = self.ask("export", "block", "-o", "mesh.ply", "--detach", "--quiet").strip()
        self.ask("watch", job)
        self.ask("fetch", job, "-o", "fetched.ply")
        self.ask("fetch", "block", "-o", "copy")
        self.tessera("export", "copy", "-o", "local.ply")
        self.assertEqual((self.folder / "fetched.ply").read_bytes(), (self.folder / "local.ply").read_bytes())
        self.assertIn("already", self.ask("export", "block", "-o", "mesh.ply", status=USAGE))
        self.ask("export", "block", "-o", "mesh.ply", "--overwrite")

    def test_a_result_that_is_kept_as_points_answers_like_any_other(self):
        self.both()
        self.ask("triangulate", "*.las", "-o", "kept", "--tiles", "5", "--dim", "2", "--class", "2,9", "--store", "points")
        self.assertTrue(list((self.folder / "data/results/kept/tiles").glob("*.pts")))
        self.assertIn("kept is the Delaunay triangulation", self.ask("verify", "kept"))
        for name in ("block", "kept"):
            self.ask("export", name, "-o", f"{name}.ply")
            self.ask("dem", name, "--res", "2", "-o", f"{name}.tif")
        for ending in ("ply", "tif"):
            self.assertEqual((self.folder / f"block.{ending}").read_bytes(), (self.folder / f"kept.{ending}").read_bytes())
        bounds = json.loads(self.ask("info", "kept", "--json"))["bounds"]
        x, y = ((bounds["min"][i] + bounds["max"][i]) / 2 for i in (0, 1))
        self.ask("fetch", "kept", "-o", "copy")
        self.assertEqual(self.tessera("query", "copy", "locate", f"{x},{y}"), self.tessera("query", "here", "locate", f"{x},{y}"))

    def test_a_daemon_that_is_killed_is_waited_for(self):
        port = self.daemon.port
        watching = subprocess.Popen(
            [TESSERA, "triangulate", "*.las", "-o", "block", "--tiles", "30", "--server",
             f"{self.daemon.url}#token={self.daemon.token}"],
            stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        self.addCleanup(watching.stdout.close)
        self.addCleanup(watching.stderr.close)
        for _, _, data in self.daemon.events("/v1/events", 1):  # from the first on
            if (data or {}).get("status", {}).get("status") == "running":
                break
        self.daemon.end(signal.SIGKILL)
        said = ""
        while "waiting until the daemon answers" not in said:
            line = watching.stderr.readline()
            self.assertNotEqual(line, "", said)
            said += line
        self.daemon = self.start("--uploads", listen=f"127.0.0.1:{port}")
        told, errors = watching.communicate()
        self.assertEqual(watching.returncode, 0, said + errors)
        self.assertIn("tetrahedra", told)


@unittest.skipIf(tessera is None, "the Python package is not built")
class Python(ClientsTest):
    def test_all_that_the_command_can(self):
        client = tessera.connect(f"{self.daemon.url}#token={self.daemon.token}")
        job = client.submit("*.las", "block", dim=2, classes=[2, 9], tiles=5)
        t = job.result(self.folder / "copy")
        self.assertEqual(client.verify("block"), t.verify())
        client.export("block", self.folder / "there.ply")
        t.export(self.folder / "here.ply")
        self.assertEqual((self.folder / "there.ply").read_bytes(), (self.folder / "here.ply").read_bytes())
        client.export("block", self.folder / "tiles", format="vtu")
        self.assertEqual(len(list((self.folder / "tiles").iterdir())), len(t) + 1)
        self.assertEqual(client.info("block")["digest"], t.digest)
        (name,) = client.upload(sorted(IGN.glob("*.las"))[0], "mine")
        there, here = client.info(name), tessera.info(sorted(IGN.glob("*.las"))[0])
        self.assertEqual((there["points"], there["files"][0]["bounds"]), (here["points"], here["files"][0]["bounds"]))
        for call, kind in ((lambda: client.verify("none"), tessera.UsageError), (lambda: client.info("none.las"), tessera.IoError),
                           (lambda: client.export("block", self.folder / "x.3ds"), tessera.UsageError),
                           (lambda: client.submit("*.las", memory="1M").wait(), tessera.MemoryLimitError)):
            with self.assertRaises(kind):
                call()


if __name__ == "__main__":
    unittest.main()
