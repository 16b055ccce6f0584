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
import older_glibc  # noqa: E402
import self_contained  # noqa: E402
import tessera_build  # noqa: E402

# Of Debian 12; docs/python.md names their packages. What `pip install .` makes links them.
OF_DEBIAN = {"libcaf_core.so.0.17.6", "libexpat.so.1", "libgmp.so.10", "libmeshoptimizer.so.2d", "libprotobuf.so.32",
          "libxxhash.so.0", "libz.so.1", "libzstd.so.1", "libstdc++.so.6", "libgcc_s.so.1", "libm.so.6", "libc.so.6", "ld-linux-x86-64.so.2"}

# What each Linux of the age that the tag says has.
SYSTEM = {"libstdc++.so.6", "libgcc_s.so.1", "libm.so.6", "libc.so.6", "libpthread.so.0", "ld-linux-x86-64.so.2"}
BYTES_MAX = 25_000_000
GLIBC = re.compile(r"\bGLIBC_2\.(\d+)")


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
        name = re.fullmatch(r"tessera-(\d+\.\d+\.\d+)-(cp3\d+-cp3\d+-manylinux_2_\d+_\w+)\.whl", self.wheel.name)
        information = self.unpacked / f"tessera-{name[1]}.dist-info"
        self.assertIn(f"\nTag: {name[2]}\n", (information / "WHEEL").read_text())
        metadata = (information / "METADATA").read_text()
        self.assertIn(f"\nVersion: {name[1]}\n", metadata)
        self.assertIn(f"\nRequires-Python: =={sys.version_info.major}.{sys.version_info.minor}.*\n", metadata)
        self.assertNotIn("\nRequires-External:", metadata)
        self.assertEqual((information / "LICENSE").read_text(), (SOURCE / "LICENSE").read_text())

    def test_the_tag_is_of_the_newest_symbols_that_are_used(self):
        glibc = int(re.search(r"manylinux_2_(\d+)_", self.wheel.name)[1])
        used = {int(minor) for path in self.libraries for minor in GLIBC.findall(output_of("objdump", "-T", path))}
        self.assertLessEqual(max(used), glibc)
        self.assertEqual(glibc, older_glibc.GLIBC)

    def test_symbols_without_a_version_are_of_the_wheel_or_older_than_the_tag(self):
        names = {"--undefined-only": {}, "--defined-only": {}}
        for kind, of_library in names.items():
            for path in self.libraries:
                listed = re.findall(r"^ *[0-9a-f]* +([A-Za-z]) (\S+)$", output_of("nm", "-D", kind, path), re.MULTILINE)
                of_library[path.name] = {re.sub("@@.*", "", name) for letter, name in listed if letter not in "wv"}
        inside = set().union(*names["--defined-only"].values())
        for library, wanted in names["--undefined-only"].items():
            missing = {name for name in wanted if "@" not in name and not re.match("_?Py", name)} - inside
            self.assertLessEqual(missing, older_glibc.OLDER, library)
        self.assertLessEqual(older_glibc.SUPPLIED, inside)

    def test_what_older_systems_lack_does_its_work(self):
        (supplied,) = self.unpacked.glob("tessera.libs/libtessera_older-*")
        said = output_of(sys.executable, "-c", f"""import ctypes
library = ctypes.CDLL({str(supplied)!r})
got = [ctypes.create_string_buffer(1000) for _ in range(2)]
for each in got:
    library.arc4random_buf(each, 999)
print(got[0].raw != got[1].raw, len(set(got[0].raw)) > 200, got[0].raw[999])""")
        self.assertEqual(said, "True True 0\n")
        done = subprocess.run([sys.executable, "-c", f"import ctypes; ctypes.CDLL({str(supplied)!r})"
                               "._ZSt21__glibcxx_assert_failPKciS0_S0_(b'a.h', 7, b'f()', b'i < n')"], capture_output=True, text=True)
        self.assertEqual((done.returncode, done.stderr), (-6, "a.h:7: f(): Assertion 'i < n' failed.\n"))

    def test_a_new_symbol_that_nobody_has_judged_is_refused(self):
        source, library = self.folder / "new.c", self.folder / "new.so"
        source.write_text("unsigned arc4random_uniform(unsigned); unsigned number(void) { return arc4random_uniform(7); }")
        output_of("cc", "-shared", "-fPIC", source, "-o", library)
        with self.assertRaisesRegex(ValueError, "^new.so needs arc4random_uniform, which glibc 2.34 and GCC 11 do not have$"):
            older_glibc.lower(library)

    def test_it_is_small(self):
        self.assertLess(self.wheel.stat().st_size, BYTES_MAX)

    def test_the_rights_of_each_copied_library_are_inside(self):
        texts = {path.name: path.read_text(errors="replace") for path in self.unpacked.glob("*.dist-info/licenses/*")}
        self.assertEqual(len(texts), len(list((self.unpacked / "tessera.libs").iterdir())) - 1)  # one is the project's own
        for name, text in texts.items():
            self.assertRegex(text, "(?i)copyright", name)

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

    def test_it_links_itself_and_what_each_linux_has(self):
        inside = {path.name for path in self.libraries}
        copies = {path.name for path in (self.unpacked / "tessera.libs").iterdir()}
        self.assertEqual(len(inside - copies), 2)
        for path in self.libraries:
            needed = set(self_contained.dynamic(path, "NEEDED"))
            self.assertLessEqual(needed, SYSTEM | inside)
            entries = self_contained.dynamic(path, "RUNPATH") + self_contained.dynamic(path, "RPATH")
            for place in [place for entry in entries for place in entry.split(":")]:
                self.assertIn(place, ("$ORIGIN", "$ORIGIN/../tessera.libs"))
        for copy in copies:  # no other library has such a name
            self.assertRegex(copy, r"-[0-9a-f]{8}\.so")
            self.assertEqual(self_contained.dynamic(self.unpacked / "tessera.libs" / copy, "SONAME"), [copy])
        self.assertIn("libtessera.so.0.1", {name for path in self.libraries for name in self_contained.dynamic(path, "NEEDED")})

    def test_what_pip_makes_of_the_sources_names_debians_libraries(self):
        plain = self.folder / "plain"
        plain.mkdir()
        with zipfile.ZipFile(plain / tessera_build.pack(BUILD, plain, os.environ["CMAKE"], alone=False)) as archive:
            self.assertRegex(archive.filename, r"-linux_\w+\.whl$")
            (metadata,) = (archive.read(name).decode() for name in archive.namelist() if name.endswith("/METADATA"))
            self.assertFalse(any(name.startswith("tessera.libs/") for name in archive.namelist()))
        self.assertEqual({*re.findall(r"^Requires-External: (.*)$", metadata, re.MULTILINE)}, OF_DEBIAN)

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
        # Debian's copies are installed here, too: none is loaded.
        site = pathlib.Path(file).parents[1]
        loaded = {pathlib.Path(path) for path in said.split() if ".so" in path}
        own = {path for path in loaded if path.is_relative_to(site)}
        self.assertEqual({path.name for path in own}, {path.name for path in self.libraries})
        copied = [re.sub(r"-[0-9a-f]{8}\.so.*", "", path.name) for path in (site / "tessera.libs").iterdir()]
        of_numpy_and_python = ("libz", "libexpat")
        for path in loaded - own:
            stem = path.name.split(".so")[0]
            self.assertFalse(stem in copied and stem not in of_numpy_and_python, path)
        self.assertIn("tessera", output_of(python, "-m", "pip", "list", "--format=freeze", "--disable-pip-version-check", env=clean))
        output_of(python, "-m", "pip", "uninstall", "--yes", "tessera", "--disable-pip-version-check", env=clean)
        self.assertFalse(pathlib.Path(file).exists())

    def test_importing_it_loads_nothing_else(self):
        # numpy, the C++ library, http and ssl take most of a second on a busy machine.
        said = output_of(sys.executable, "-S", "-c", f"import sys; sys.path.insert(0, {str(self.unpacked)!r}); before = set(sys.modules); "
                                                     "import tessera; print(*sorted(set(sys.modules) - before))")
        self.assertNotIn("numpy", said.split())
        self.assertEqual([name for name in said.split() if name.startswith("tessera")], ["tessera"])


class Backend(unittest.TestCase):
    def test_pyproject_names_it(self):
        text = (SOURCE / "pyproject.toml").read_text()
        self.assertIn('build-backend = "tessera_build"\nbackend-path = ["python/backend"]', text)
        for hook in ("build_wheel", "build_sdist"):
            self.assertTrue(callable(getattr(tessera_build, hook)))


if __name__ == "__main__":
    unittest.main()
