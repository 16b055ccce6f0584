"""Nothing that strangers wrote reaches a terminal as more than a text: no colours, titles, cleared screens, turned writing."""
import json
import signal
import subprocess

from cli import CORRUPT, TESSERA, CliTest

EVIL = "x\x1b]0;title\x07\x1b[2J\x9b2J\x85\u2028\u202e\u2066\r\n\x7fy"


class Terminal(CliTest):
    def shown(self, *args):
        """What a command prints, on both, is UTF-8 and only shows something."""
        done = subprocess.run([TESSERA, *map(str, args)], cwd=self.folder, capture_output=True)
        for said in (done.stdout, done.stderr):
            text = said.decode("utf-8", "strict")
            bad = [c for c in text.replace("\n", "") if ord(c) < 0x20 or 0x7f <= ord(c) < 0xa0 or c in "\u2028\u2029\u202e\u2066"]
            self.assertEqual(bad, [], f"{args}: {text!r}")
        return done

    def change(self, **fields):
        path = self.out / "manifest.json"
        manifest = json.loads(path.read_text())
        path.write_text(json.dumps(manifest | fields))

    def test_of_a_manifest(self):
        self.ok("triangulate", self.xyz(), "-o", self.out, "--dim", "2", "--quiet")
        wkt = f'LOCAL_CS["{EVIL}",UNIT["metre",1]]'
        for crs in (EVIL, wkt, f"EPSG:{EVIL}"):
            self.change(crs=crs, software_version=EVIL)
            told = self.shown("info", self.out)
            self.assertEqual(told.returncode, 0, told.stderr)
            self.assertNotIn(b"\ny", told.stdout, "it makes no line of its own")
            for target in ("a.geojson", "a.gpkg", "a.csv", "a.xml", "a.ply"):
                self.shown("export", self.out, "-o", target, "--overwrite")
            self.shown("dem", self.out, "--res", "0.5", "-o", "a.tif", "--overwrite")
            self.shown("contours", self.out, "--interval", "0.5", "-o", "b.geojson", "--overwrite")
            self.shown("verify", self.out)

    def test_of_names_of_files_columns_and_values(self):
        name = EVIL.replace("\n", "").replace("\r", "") + ".xyz"
        for content in ("1 2 3\n4 5 6\n7 8 1\n2 2 9\n", "1 2 x\x1b[2J\xc2\x9b\n", f"x y z {EVIL.split(chr(13))[0]}\n1 2 3 4\n"):
            self.write(name, content)
            self.shown("info", name)
            self.shown("triangulate", name, "-o", "result", "--attributes", "all", "--overwrite")
        self.shown("triangulate", "none" + EVIL.replace("\n", ""), "-o", "x" + EVIL)
        self.shown("info", "none\udcff")
        self.shown("--" + EVIL)
        self.shown("triangulate", name, "-o", "y", "--crs", EVIL)

    def test_of_an_interrupted_run(self):
        many = self.xyz("many.xyz", n=200000)
        process = subprocess.Popen([TESSERA, "triangulate", str(many), "-o", str(self.out), "--tiles", "12", "--threads", "1"],
                                   stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        plan = self.out / ".run/plan.json"
        while not plan.exists() and process.poll() is None:
            pass
        process.send_signal(signal.SIGINT)
        process.wait()
        self.assertTrue(plan.exists(), "it ended before it could be stopped")
        whole = plan.read_bytes()
        for damage in (b"\xb6", b"\x1b", b"\x9b"):
            plan.write_bytes(whole[:12] + damage * 4 + whole[16:])
            done = self.shown("triangulate", many, "-o", self.out, "--tiles", "12", "--threads", "1", "--resume")
            self.assertEqual(done.returncode, CORRUPT, done.stderr)
