"""The wheel that the build makes: what is in it, what it links, and that pip installs it."""
import base64
import csv
import hashlib
import io
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest
import zipfile

BUILD = pathlib.Path(os.environ["BUILD"])
SOURCE = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(SOURCE / "python" / "backend"))
import tessera_build  # noqa: E402

# Of Debian 12; docs/python.md names their packages.
SYSTEM = {"libcaf_core.so.0.17.6", "libexpat.so.1", "libgmp.so.10", "libmeshoptimizer.so.2d", "libprotobuf.so.32",
          "libxxhash.so.0", "libz.so.1", "libzstd.so.1", "libstdc++.so.6", "libgcc_s.so.1", "libm.so.6", "libc.so.6", "ld-linux-x86-64.so.2"}


def output_of(*command, **options):
    done = subprocess.run([str(word) for word in command], capture_output=True, text=True, **options)
    if done.returncode != 0:
        raise AssertionError(f"{' '.join(map(str, command))}\n{done.stdout}{done.stderr}")
    return done.stdout


class Wheel(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        held = tempfile.TemporaryDirectory(prefix="tessera-wheel-")
        cls.addClassCleanup(held.cleanup)
        cls.folder = pathlib.Path(held.name)
        cls.wheel = cls.folder / tessera_build.pack(BUILD, cls.folder, os.environ["CMAKE"])
        cls.unpacked = cls.folder / "unpacked"
        with zipfile.ZipFile(cls.wheel) as archive:
            archive.extractall(cls.unpacked)
        cls.libraries = sorted(cls.unpacked.rglob("*.so*"))

    def test_its_name_and_its_metadata_agree(self):
        name = re.fullmatch(r"tessera-(\d+\.\d+\.\d+)-(cp3\d+-cp3\d+-linux_\w+)\.whl", self.wheel.name)
        information = self.unpacked / f"tessera-{name[1]}.dist-info"
        self.assertIn(f"\nTag: {name[2]}\n", (information / "WHEEL").read_text())
        metadata = (information / "METADATA").read_text()
        self.assertIn(f"\nVersion: {name[1]}\n", metadata)
        self.assertEqual({*re.findall(r"^Requires-External: (.*)$", metadata, re.MULTILINE)}, SYSTEM)
        self.assertEqual((information / "LICENSE").read_text(), (SOURCE / "LICENSE").read_text())

    def test_its_record_is_of_its_files(self):
        recorded = {}
        for name, checksum, size in csv.reader(io.StringIO(next(self.unpacked.glob("*/RECORD")).read_text())):
            recorded[name] = (checksum, size)
        with zipfile.ZipFile(self.wheel) as archive:
            self.assertEqual(sorted(archive.namelist()), sorted(recorded))
            for name, (checksum, size) in recorded.items():
                if checksum:
                    content = archive.read(name)
                    digest = base64.urlsafe_b64encode(hashlib.sha256(content).digest()).rstrip(b"=").decode()
                    self.assertEqual((checksum, size), (f"sha256={digest}", str(len(content))))
        self.assertEqual([name for name, (checksum, _) in recorded.items() if not checksum], [name for name in recorded if name.endswith("RECORD")])

    def test_the_same_files_make_the_same_wheel(self):
        again = self.folder / "again"
        again.mkdir()
        tessera_build.pack(BUILD, again, os.environ["CMAKE"])
        self.assertEqual((again / self.wheel.name).read_bytes(), self.wheel.read_bytes())

    def test_it_links_itself_and_libraries_of_the_system(self):
        self.assertEqual([re.sub(r"\..*", "", path.name) for path in self.libraries], ["_tessera", "libtessera"])
        inside = {path.name for path in self.libraries}
        for path in self.libraries:
            needed = set(tessera_build.dynamic(path, "NEEDED"))
            self.assertLessEqual(needed, SYSTEM | inside)
            for place in ":".join(tessera_build.dynamic(path, "RUNPATH") + tessera_build.dynamic(path, "RPATH")).split(":"):
                self.assertTrue(place in ("", "$ORIGIN") or place.startswith("$ORIGIN/"), place)
        self.assertIn("libtessera.so.0.1", {name for path in self.libraries for name in tessera_build.dynamic(path, "NEEDED")})

    def test_pip_installs_it_into_a_virtual_environment(self):
        venv = self.folder / "venv"
        output_of(sys.executable, "-m", "venv", "--system-site-packages", "--without-pip", venv)
        python = venv / "bin" / "python"
        clean = {name: value for name, value in os.environ.items() if name not in ("PYTHONPATH", "LD_LIBRARY_PATH")}
        output_of(python, "-m", "pip", "install", "--no-index", "--no-deps", "--disable-pip-version-check", self.wheel, env=clean)
        said = output_of(python, "-c", "import tessera; t = tessera.triangulate([[0, 0], [1, 0], [0, 1]]); "
                                       "print(t.n_cells, tessera.__file__, open('/proc/self/maps').read())", env=clean, cwd="/")
        cells, file = said.split()[:2]
        self.assertEqual((cells, pathlib.Path(file).is_relative_to(venv)), ("1", True))
        loaded = {path for path in said.split() if "libtessera.so" in path}
        self.assertEqual(loaded, {str(pathlib.Path(file).parent / "libtessera.so.0.1")})
        self.assertNotIn("not found", output_of("ldd", pathlib.Path(file).parent / "libtessera.so.0.1", env=clean))
        self.assertIn("tessera", output_of(python, "-m", "pip", "list", "--format=freeze", "--disable-pip-version-check", env=clean))
        output_of(python, "-m", "pip", "uninstall", "--yes", "tessera", "--disable-pip-version-check", env=clean)
        self.assertFalse(pathlib.Path(file).exists())


class Backend(unittest.TestCase):
    def test_pyproject_names_it(self):
        text = (SOURCE / "pyproject.toml").read_text()
        self.assertIn('build-backend = "tessera_build"\nbackend-path = ["python/backend"]', text)
        for hook in ("build_wheel", "build_sdist"):
            self.assertTrue(callable(getattr(tessera_build, hook)))


if __name__ == "__main__":
    unittest.main()
