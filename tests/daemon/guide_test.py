"""The lines of docs/service.md, and of the tutorial where it asks a daemon, typed along: curl, the command, Python."""
import json
import os
import pathlib
import re
import shlex
import subprocess
import unittest

from daemon import IGN, TESSERA, DaemonTest

try:
    import tessera
except ImportError:  # built without it
    tessera = None

GUIDE = pathlib.Path(os.environ["SERVICE_GUIDE"]).read_text()


class Guide(DaemonTest):
    def test_every_line_of_the_guide_works(self):
        daemon = self.start("--uploads")
        self.tessera("generate", "uniform", "-n", "1000", "-o", "cloud.xyz")
        lines = [line for block in re.findall(r"```sh\n(.*?)```", GUIDE, re.S) for line in block.splitlines()]
        self.assertGreater(len(lines), 15)
        environment = os.environ | {"URL": daemon.url.rstrip("/"), "TOKEN": daemon.token}
        curl = 'curl() { command curl -sS --fail-with-body -H "Authorization: Bearer $TOKEN" "$@"; }\n'
        for line in lines:
            self.assertTrue(line.startswith("curl "), line)
            if line.startswith("curl -X DELETE $URL/v1/jobs/"):
                # Verifying goes before: it is forgotten once it has ended.
                self.assertEqual(daemon.wait(environment["JOB"])["status"], "successful")
            done = subprocess.run(["bash", "-c", curl + line], env=environment, cwd=self.folder, stdout=subprocess.PIPE,
                                  stderr=subprocess.PIPE)
            said = done.stdout.decode()
            self.assertEqual(done.returncode, 0, f"{line}\n{said}\n{done.stderr.decode()}")
            if "Idempotency-Key" in line:
                self.assertIn("201", said.splitlines()[0])
                environment["JOB"] = json.loads(said.split("\r\n\r\n", 1)[1])["jobID"]
            if re.search("processes/(export|triangulate|region|dem|contours)/execution", line) and "Idempotency-Key" not in line:
                self.assertEqual(daemon.wait(json.loads(said)["jobID"])["status"], "successful")
            if "/events" in line:
                self.assertIn("successful", said)
        self.assertEqual(daemon.end(), 0, daemon.messages())

    def test_the_lines_are_right_for_what_is_started_with_one_command(self):
        root = pathlib.Path(os.environ["SERVICE_GUIDE"]).parents[1]
        (inputs,) = re.findall(r"src/front/daemon/tesserad .*--inputs (\S+)", (root / "tessera.sh").read_text())
        self.assertEqual((root / inputs).resolve(), IGN.resolve())  # which the other tests serve

    def section(self, title):
        return re.search(f"^## {title}\n(.*?)^## ", GUIDE, re.S | re.M)[1]

    def test_every_command_of_the_guide_works(self):
        daemon = self.start("--uploads")
        self.tessera("generate", "uniform", "-n", "1000", "-o", "cloud.xyz")
        programs = self.folder / "programs"
        programs.mkdir()
        (programs / "tessera").symlink_to(TESSERA)
        environment = {k: v for k, v in os.environ.items() if not k.startswith("TESSERA")}
        environment |= {"TESSERA_SERVER": daemon.url, "TESSERA_TOKEN": daemon.token,
                        "PATH": f"{programs}:{os.environ['PATH']}"}
        def type_in(line):
            done = subprocess.run(["bash", "-c", line], env=environment, cwd=self.folder, text=True, stdout=subprocess.PIPE,
                                  stderr=subprocess.PIPE)
            self.assertEqual(done.returncode, 0, f"{line}\n{done.stderr}")
            return done.stdout
        lines = re.findall(r"^    (tessera \S.*?)(?:   .*)?$", self.section("From the command line"), re.M)
        self.assertGreater(len(lines), 12)
        submit = "tessera triangulate '*.las' -o {} --detach --quiet"
        job = type_in(submit.format("again")).strip()
        for line in lines:
            if "cancel" in line:
                # The last of several waits for the others.
                job = [type_in(submit.format(f"r{i}")).strip() for i in range(4)][-1]
            type_in(line.replace("ID", job))
        self.assertEqual((self.folder / "mesh.ply").read_bytes()[:4], b"ply\n")
        self.tessera("verify", "out")
        self.assertEqual(daemon.end(), 0, daemon.messages())

    def test_the_maps_of_the_tutorial_are_there(self):
        page = pathlib.Path(os.environ["SERVICE_GUIDE"]).with_name("tutorial.md").read_text()
        section = re.search(r"^## \d+\. Maps from a daemon\n(.*?)^## ", page, re.S | re.M)[1]
        daemon = self.start()
        (self.folder / "dem.tif").touch()  # as the steps before have made here
        commands = re.findall(r"^    tessera (.*)$", section, re.M)
        self.assertGreater(len(commands), 2)
        for command in commands:
            self.tessera(*shlex.split(command), "--server", f"{daemon.url}#token={daemon.token}")
        for job in daemon.request("GET", "/v1/jobs")[2]["jobs"]:
            self.assertEqual(daemon.wait(job["jobID"])["status"], "successful")
        found = [one["id"] for one in daemon.request("GET", "/v1/collections")[2]["collections"]]
        self.assertEqual(found, ["ground.tiles", "ground.hull", "ground.contours"])
        (tiles,) = re.findall(r"http://127.0.0.1:7070(/v1\S*/\{z\}/\{y\}/\{x\}\S*)`", section)
        for place in "zyx":
            tiles = tiles.replace(f"{{{place}}}", "0")
        self.assertEqual(daemon.request("GET", tiles)[0], 200)
        self.assertEqual(daemon.end(), 0, daemon.messages())

    @unittest.skipIf(tessera is None, "the Python package is not built")
    def test_the_lines_of_python_work(self):
        daemon = self.start()
        text = "\n".join(re.findall(r"^    (.*)$", self.section("From Python"), re.M))
        text = text.replace("http://127.0.0.1:7070", daemon.url).replace("block/*.laz", "*.las").replace('"4G"', '"500M"')
        for name in ("block-here/", "mesh.ply", "heights/", "cells.gpkg", "density.npy", "shape.ply", "volumes.csv"):
            text = text.replace(f'"{name}"', repr(str(self.folder / name)))
        names = {"tessera": tessera, "token": daemon.token, "print": lambda _: None}
        exec(compile(text, "docs/service.md", "exec"), names)
        self.assertEqual(names["t"].n_points, 262813)
        self.assertTrue((self.folder / "mesh.ply").is_file())
        self.assertEqual(daemon.end(), 0, daemon.messages())

    def test_every_route_is_in_the_guide(self):
        daemon = self.start()
        paths = daemon.request("GET", "/v1/api")[2]["paths"]
        self.assertEqual(daemon.end(), 0)
        self.assertGreater(len(paths), 15)
        # Names in the guide stand for what the documents have in braces.
        words = set(re.findall(r"(?:\$URL|`)(/[\w$./*-]*)", GUIDE))
        places = [word.rstrip("/").split("/") for word in words]

        def fits(path):
            parts = path.rstrip("/").split("/")
            return any(len(place) == len(parts) and all(a == b or b.startswith("{") for a, b in zip(place, parts))
                       for place in places)
        self.assertEqual([path for path in paths if path != "/" and not fits(path)], [])


if __name__ == "__main__":
    unittest.main()
