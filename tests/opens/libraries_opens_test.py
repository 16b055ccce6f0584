"""The table of docs/security.md: each library that reads what strangers wrote is given what would make it open a file,
and opens none. One row is one command, with the files it is made for; any other file that is opened is a fault."""
import json
import os
import pathlib
import re
import shutil
import subprocess
import tempfile
import unittest

import files
import opens
import texts

TESSERA, TESSERAD, SOURCE = os.environ["TESSERA"], os.environ["TESSERAD"], pathlib.Path(os.environ["SOURCE"])
SQL = "v'); ATTACH DATABASE '{}' AS c; --"
XXE = '<?xml version="1.0"?>\n<!DOCTYPE x [<!ENTITY e SYSTEM "file://{0}"><!ENTITY % p SYSTEM "{0}">%p;]>\n'


class Libraries(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        opens.need_strace()

    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="tessera-opens-"))
        self.addCleanup(shutil.rmtree, self.folder, True)
        # A pipe: who opens it waits, so that also what the calls do not show is seen.
        self.canary = str(self.folder / "canary")
        os.mkfifo(self.canary)
        self.made = self.folder / "made"
        (self.made / "home").mkdir(parents=True)
        self.environment = {key: value for key, value in os.environ.items()
                            if not key.startswith(("TESSERA", "PROJ_", "GDAL_", "XDG_", "SSL_"))}
        self.environment |= {"HOME": str(self.made / "home"), "TMPDIR": str(self.made)}

    def write(self, name, content):
        path = self.made / name
        path.write_bytes(content if isinstance(content, bytes) else content.encode())
        return path

    def run_program(self, *command, wanted=None):
        """Nothing is opened but what is `made` and the system's; nobody looks at the canary; nobody is asked on the net."""
        done, seen = opens.watched(command, self.folder / "trace", cwd=self.made, env=self.environment)
        with self.subTest(" ".join(map(str, command))[:150]):
            self.assertGreaterEqual(done.returncode, 0, done.stderr)
            if wanted is not None:
                self.assertEqual(done.returncode == 0, wanted, done.stderr)
            here = f"{self.made}/"
            strange = [path for path in opens.opened(seen)
                       if path not in map(str, command) and not f"{os.path.normpath(self.made / path)}/".startswith(here)]
            self.assertEqual(strange, [])
            # Whole paths: a name of a file may hold the canary's.
            looked = [(call, path) for call, path in seen if os.path.normpath(path) == self.canary]
            self.assertEqual(looked, [])
            self.assertEqual([where for call, where in seen if call == "connect"], [])
        return done

    def run_command(self, *arguments, **more):
        return self.run_program(TESSERA, *arguments, **more)

    def result(self, source=None, *more):
        shutil.rmtree(self.made / "out", ignore_errors=True)
        source = source or self.write("plain.las", files.las())
        subprocess.run([TESSERA, "triangulate", str(source), "-o", str(self.made / "out"), "--dim", "2", "--quiet", *more], check=True)
        return self.made / "out"

    def change_manifest(self, out, **fields):
        manifest = json.loads((out / "manifest.json").read_text())
        (out / "manifest.json").write_text(json.dumps(manifest | fields))

    def use_everything(self, out, value="z"):
        """What a result is made into: by every library that writes."""
        self.run_command("info", out)
        for target in ("a.gpkg", "a.geojson", "a.csv", "a.xml", "a.ply", "a.vtu", "a.msh", "a.dxf"):
            self.run_command("export", out, "-o", target, "--overwrite")
        self.run_command("dem", out, "--res", "20", "-o", "a.tif", "--overwrite", "--value", value)
        self.run_command("dem", out, "--res", "20", "-o", "h.tif", "--overwrite", "--hillshade")
        for target in ("c.gpkg", "c.geojson"):
            self.run_command("contours", out, "--interval", "200", "-o", target, "--overwrite", "--value", value)
        self.run_command("tileset", out, "-o", "tiles")
        shutil.rmtree(self.made / "tiles", ignore_errors=True)
        self.run_command("verify", out)

    def test_gdal_and_proj_by_records_of_las(self):
        evil = texts.refused(self.canary)
        for name in ("no keyword, +init", "grids of a datum", "a PROJ string in a projected system", "a file of a transformation",
                     "an authority with +init", "a PROJ string in a remark of WKT 2", "a name that is a PROJ string"):
            with self.subTest(name):
                self.run_command("info", self.write("wkt.las", files.las(wkt=evil[name])), wanted=True)
                self.run_command("info", self.write("keys.las", files.las(citation="ESRI PE String = " + evil[name])), wanted=True)
        wkt = self.write("wkt.las", files.las(wkt=evil["grids of a datum"]))
        self.use_everything(self.result(wkt))

    def test_gdal_and_proj_by_manifests(self):
        out = self.result()
        for name, text in texts.refused(self.canary).items():
            if name in ("no keyword, +init", "a path", "a PROJ string", "grids of a datum", "a file of a transformation"):
                self.change_manifest(out, crs=text)
                self.use_everything(out)

    def test_gdal_and_proj_by_the_command_line(self):
        cloud = self.write("plain.las", files.las())
        for text in texts.refused(self.canary).values():
            if text != self.canary and "\0" not in text and len(text) < 5000:
                self.run_command("triangulate", cloud, "-o", self.made / "x", "--crs", text, wanted=False)

    def test_sqlite_and_gdal_by_names_of_attributes(self):
        names = [SQL.format(self.canary), f"{self.canary}", "a\"b`c'd", f"@{self.canary}", "=cmd", f"<file>{self.canary}</file>"]
        rows = "".join(f"{x},{y},{x * y % 7},{x}\n" for x in range(0, 100, 9) for y in range(0, 100, 7))
        for name in names:
            text = self.write("named.csv", 'x,y,z,"' + name.replace('"', '""') + '"\n' + rows)
            out = self.result(text, "--attributes", "all")
            kept = [array["name"] for array in json.loads((out / "manifest.json").read_text())["attributes"]]
            self.assertEqual(len([other for other in kept if other != "z"]), 1)
            self.use_everything(out, next(other for other in kept if other != "z"))

    def test_readers_by_names_in_files(self):
        canary = self.canary
        self.run_command("info", self.write("a.ply", files.ply(canary)), wanted=True)
        self.run_command("info", self.write("a.obj", files.obj(canary)), wanted=True)
        self.run_command("info", self.write("a.off", files.off(canary)), wanted=True)
        self.run_command("info", self.write("a.stl", files.stl(canary)), wanted=True)
        self.run_command("info", self.write("o.npy", files.npy_of_objects(canary)), wanted=False)
        self.run_command("info", self.write("a.npy", files.npy()), wanted=True)
        self.run_command("info", self.write("a.las", files.las(name=canary.encode()[:32], system=canary.encode()[:32])), wanted=True)
        self.run_command("info", self.write("a.csv", f"x,y,z\n=HYPERLINK({canary}),1,2\n"), wanted=False)

    def test_zlib_and_zstandard(self):
        self.run_command("info", self.write("a.xyz.gz", files.gz(self.canary)), wanted=True)
        self.run_command("info", self.write("b.xyz.zst", files.zstd_with_dictionary(0x63616e61)), wanted=False)

    def test_laz_decoder(self):
        real = next((SOURCE / "data/ign").glob("*.las"))
        self.run_command("info", real, wanted=True)
        packed = self.write("a.laz", files.las(wkt="", generator=self.canary.encode()[:32]).replace(
            b"\0\x14\0d\0\0\0", b"\x80\x14\0d\0\0\0"))
        self.run_command("triangulate", packed, "-o", "x", wanted=False)

    def test_json(self):
        out = self.result()
        self.change_manifest(out, **{"$ref": f"file://{self.canary}", "inputs": [{"path": self.canary}]})
        self.run_command("info", out)
        self.run_command("verify", out)
        (out / "manifest.json").write_text("[" * 200000)
        self.run_command("info", out, wanted=False)
        square = [[0, 0], [500, 0], [500, 500], [0, 500], [0, 0]]
        area = self.write("area.geojson", json.dumps({
            "type": "Polygon", "coordinates": [square], "$ref": self.canary,
            "crs": {"type": "link", "properties": {"href": self.canary, "type": "proj4"}}}))
        self.run_command("query", self.result(), "cells", "--polygon", area, "-o", "part.ply", wanted=True)

    def test_xml(self):
        out = self.result()
        for file in ("triangulation.pvtu", "tiles/000000.vtu"):
            whole = (out / file).read_bytes()
            (out / file).write_bytes(XXE.format(self.canary).encode() + whole)
            for command in (("verify", out), ("info", out), ("export", out, "-o", "a.ply", "--overwrite")):
                self.run_command(*command)
            (out / file).write_bytes(whole.replace(b"</VTKFile>", b"&e;</VTKFile>").replace(b'Source="', b'Source="' + self.canary.encode()))
            self.run_command("verify", out)
            (out / file).write_bytes(whole)

    def test_toml_and_command_lines(self):
        cloud = self.write("plain.las", files.las())
        for text in (f'include = "{self.canary}"\n', f'crs = "@{self.canary}"\n', f'[a]\n"{self.canary}" = 1\n', "a=" + "[" * 5000):
            config = self.write("config.toml", text)
            self.run_command("triangulate", cloud, "-o", "x", "--config", config, wanted=False)
            self.run_program(TESSERAD, "--data", self.made / "data", "--config", config, wanted=False)
        for word in (f"@{self.canary}", f"--inputs=@{self.canary}"):
            self.run_command("triangulate", word, "-o", "x", wanted=False)

    def test_protobuf(self):
        """Messages of files: a route of an interrupted run. Those of callers: daemon_opens_test.py."""
        out = self.result()
        (out / ".run").mkdir()
        for name in ("plan.json", "routing.bin"):
            (out / ".run" / name).write_bytes(b"\x0a\x7f" + self.canary.encode() * 3)
        self.run_command("triangulate", self.made / "plain.las", "-o", out, "--resume", wanted=False)

    def test_openssl(self):
        """Keys with a passphrase: OpenSSL would ask for it at the terminal, and wait."""
        subprocess.run(["openssl", "req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:P-256", "-days", "2", "-subj",
                        "/CN=localhost", "-passout", "pass:secret", "-keyout", "key.pem", "-out", "certificate.pem"],
                       cwd=self.made, check=True, capture_output=True)
        key = (self.made / "key.pem").read_text()
        traditional = re.sub("-----BEGIN.*?-----\n", "-----BEGIN EC PRIVATE KEY-----\nProc-Type: 4,ENCRYPTED\nDEK-Info: "
                             "AES-256-CBC,0123456789ABCDEF0123456789ABCDEF\n\n", key).replace("ENCRYPTED PRIVATE", "EC PRIVATE")
        self.write("traditional.pem", traditional)
        self.write("engine.pem", f"-----BEGIN ENGINE-----\n{self.canary}\n-----END ENGINE-----\n")
        for name in ("key.pem", "traditional.pem", "engine.pem"):
            (self.made / name).chmod(0o600)
            self.run_program(TESSERAD, "--data", self.made / "data", "--listen", "127.0.0.1:0", "--tls-certificate",
                             self.made / "certificate.pem", "--tls-key", self.made / name, wanted=False)
        self.run_command("jobs", "--server", "https://127.0.0.1:9", "--ca", self.made / "engine.pem", wanted=False)


if __name__ == "__main__":
    unittest.main()
