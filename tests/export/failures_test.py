"""Full disks and Ctrl-C while exporting: one sentence, the right status, and nothing half-written."""
import resource
import signal
import subprocess
import time
import unittest

from cli import INTERRUPTED, IO, TESSERA
from stored import ExportTest

FORMATS = ["ply", "vtu", "off", "obj", "mesh", "msh", "dxf", "xml", "geojson", "gpkg", "csv"]


class Failures(ExportTest):
    def test_a_full_disk_leaves_nothing_in_any_format(self):
        self.stored(self.xyz(n=5000), "--dim", "2", "--tiles", "3")
        before = self.files()

        def small_files():
            signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
            resource.setrlimit(resource.RLIMIT_FSIZE, (70_000, 70_000))

        targets = [(f"a.{ending}", ()) for ending in FORMATS]
        targets += [("tiles", ("--format", {"xml": "landxml"}.get(ending, ending))) for ending in FORMATS + ["npy", "mshb"]]
        for target, options in targets:
            with self.subTest(target=target, options=options):
                done = self.refused(IO, "export", self.out, "-o", target, *options, says="cannot",
                                    preexec_fn=small_files)
                self.assertEqual(len(done.stderr.splitlines()), 1, "no library speaks for itself")
                self.assertEqual(self.files(), before)

    def test_ctrl_c_leaves_nothing(self):
        self.ok("generate", "uniform", "-n", "300k", "--dim", "2", "-o", "cloud.npy", "--quiet")
        self.ok("triangulate", "cloud.npy", "-o", self.out, "--tiles", "1", "--quiet")
        before = self.files()
        for target, options in [("a.gpkg", ()), ("a.geojson", ()), ("tiles", ("--format", "off"))]:
            with self.subTest(target=target):
                process = subprocess.Popen([TESSERA, "export", self.out, "-o", target, *options], cwd=self.folder,
                                           stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
                while self.files() == before and process.poll() is None:
                    time.sleep(0.002)
                process.send_signal(signal.SIGINT)
                _, text = process.communicate(timeout=120)
                self.assertEqual(process.returncode, INTERRUPTED, text)
                self.assertEqual(len(text.splitlines()), 1, text)
                self.assertEqual(self.files(), before)

    def test_a_file_that_was_there_is_kept_when_its_replacement_fails(self):
        self.stored(self.xyz(n=500), "--dim", "2", "--tiles", "2")
        for ending in FORMATS:
            path = self.export(f"a.{ending}")
            old = path.read_bytes()
            tile = self.out / "tiles" / "000001.vtu"
            whole = tile.read_bytes()
            tile.write_bytes(whole[:3000])
            self.refused(5, "export", self.out, "-o", path.name, "--overwrite", says="000001")
            self.assertEqual(path.read_bytes(), old, ending)
            tile.write_bytes(whole)


if __name__ == "__main__":
    unittest.main()
