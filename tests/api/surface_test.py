"""What a program sees of libtessera: its names, its headers, its installation."""

import os
import pathlib
import re
import subprocess
import tempfile
import unittest

BUILD = pathlib.Path(os.environ["BUILD"])
SOURCE = pathlib.Path(os.environ["SOURCE"])
LIBRARY = pathlib.Path(os.environ["LIBRARY"])
COMPILER = os.environ["CXX_COMPILER"]
CMAKE = os.environ["CMAKE"]
FLAGS = os.environ["SANITIZER"].split()
HEADERS = sorted((SOURCE / "include/tessera").glob("*.h"))

# What a user can name, and the type of what is thrown, which the program compares with its own.
PUBLIC = re.compile(
    r"tessera::(Delaunay|Triangulation|Tile|Proof|TriangulationOptions|ExportRequest|VerifyRequest|MeasureRequest|DensityRequest|RasterRequest|ContourRequest|ProfileRequest|RegionRequest|HeightsRequest|VolumeRequest|AlphaRequest|VoronoiRequest|UpdateRequest|VoidsRequest|Questions|Failure)::"
    r"|tessera::SurfaceRequest<tessera::(Raster|Contour|Profile|Volume)Request>::"
    r"|tessera::(triangulate|triangulate_region|draw_raster|write_raster|draw_density|density_widths|write_density|draw_contours|write_contours|draw_profile|write_profile|write_heights|compute_volumes|write_difference_raster|make_alpha_shape|write_alpha_shape|write_voronoi|update|describe|file_checksum|library_version)\("
    r"|(typeinfo|typeinfo name|vtable) for tessera::Failure$"
)


def output_of(*command, **options):
    done = subprocess.run([str(word) for word in command], capture_output=True, text=True, **options)
    if done.returncode != 0:
        raise AssertionError(f"{' '.join(map(str, command))}\n{done.stdout}{done.stderr}")
    return done.stdout


class Names(unittest.TestCase):
    def symbols(self):
        return [line.split(maxsplit=2)[2] for line in output_of("nm", "-D", "--defined-only", "-C", LIBRARY).splitlines()]

    @unittest.skipIf(FLAGS, "sanitizers add names of their own")
    def test_nothing_is_exported_but_what_the_headers_promise(self):
        self.assertEqual([name for name in self.symbols() if not PUBLIC.match(name)], [])

    def test_what_the_headers_promise_is_exported(self):
        text = "\n".join(self.symbols())
        for name in ("tessera::Delaunay::find_simplex", "tessera::triangulate(", "tessera::Triangulation::tile",
                     "tessera::Tile::points", "tessera::library_version", "typeinfo for tessera::Failure"):
            self.assertIn(name, text)

    def test_the_file_is_named_by_its_semantic_version(self):
        version = re.search(r"project\(tessera VERSION (\d+\.\d+)\.(\d+)", (SOURCE / "CMakeLists.txt").read_text())
        dynamic = output_of("readelf", "-d", LIBRARY)
        self.assertIn(f"[libtessera.so.{version[1]}]", dynamic)
        self.assertEqual(LIBRARY.resolve().name, f"libtessera.so.{version[1]}.{version[2]}")


class Headers(unittest.TestCase):
    """Each alone, all in either order, and without the libraries behind."""

    def compile(self, names, *options):
        with tempfile.TemporaryDirectory() as folder:
            source = pathlib.Path(folder) / "headers.cc"
            source.write_text("".join(f'#include "tessera/{name}"\n' for name in names))
            return output_of(COMPILER, "-std=c++20", "-Wall", "-Wextra", "-Wpedantic", "-Werror", "-I",
                             SOURCE / "include", *options, source)

    def test_each_compiles_alone_and_twice(self):
        for header in HEADERS:
            with self.subTest(header.name):
                self.compile([header.name, header.name], "-fsyntax-only")

    def test_all_compile_in_either_order(self):
        names = [header.name for header in HEADERS]
        self.compile(names, "-fsyntax-only")
        self.compile(names[::-1], "-fsyntax-only")

    def test_an_older_language_is_refused_first_and_by_name(self):
        for header in HEADERS:
            with tempfile.TemporaryDirectory() as folder:
                source = pathlib.Path(folder) / "old.cc"
                source.write_text(f'#include "tessera/{header.name}"\n')
                done = subprocess.run([COMPILER, "-std=c++17", "-fsyntax-only", "-I", SOURCE / "include", source],
                                      capture_output=True, text=True)
                first = next(line for line in done.stderr.splitlines() if "error" in line)
                self.assertRegex(first, "#error .*need C\\+\\+20: compile with -std=c\\+\\+20", header.name)

    def test_the_preprocessor_knows_the_version(self):
        project = re.search(r"project\(tessera VERSION (\d+)\.(\d+)\.(\d+)", (SOURCE / "CMakeLists.txt").read_text())
        text = (SOURCE / "include/tessera/version.h").read_text()
        self.assertEqual(re.findall(r"define TESSERA_VERSION_(?:MAJOR|MINOR|PATCH) (\d+)", text), [*project.groups()])
        with tempfile.TemporaryDirectory() as folder:
            source = pathlib.Path(folder) / "version.cc"
            source.write_text('#include "tessera/version.h"\n#if TESSERA_VERSION < TESSERA_VERSION_NUMBER(0, 1, 0) || '
                              'TESSERA_VERSION >= TESSERA_VERSION_NUMBER(1000, 0, 0)\n#error\n#endif\n')
            output_of(COMPILER, "-std=c++20", "-fsyntax-only", "-I", SOURCE / "include", source)

    def test_they_need_no_other_library(self):
        used = self.compile(["tessera.h"], "-M").replace("\\\n", " ").split()[2:]
        system = [path for path in used if not path.startswith(f"{SOURCE}/")]
        self.assertGreater(len(system), 10)
        foreign = [path for path in system if re.search(r"boost|caf/|CGAL|nlohmann", path, re.IGNORECASE)]
        foreign += [path for path in set(used) - set(system) if not path.startswith(f"{SOURCE}/include/")]
        self.assertEqual(foreign, [])


class Installation(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory(dir=BUILD)
        cls.root = pathlib.Path(cls.folder.name)
        output_of(CMAKE, "--install", BUILD, "--prefix", cls.root / "prefix")
        cls.documents = cls.root / "prefix/share/doc/tessera"
        cls.example = cls.root / "volume"
        flags = " ".join(["-Wall -Wextra -Wpedantic -Werror", *FLAGS])
        for name in ("volume", "ground"):
            output_of(CMAKE, "-S", cls.documents / "examples" / name, "-B", cls.root / name, "-DCMAKE_BUILD_TYPE=Release",
                      f"-DCMAKE_CXX_COMPILER={COMPILER}", f"-DCMAKE_CXX_FLAGS={flags}",
                      f"-DCMAKE_PREFIX_PATH={cls.root / 'prefix'}")
            output_of(CMAKE, "--build", cls.root / name)

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    def test_the_example_sums_the_volume_of_a_file(self):
        corners = [f"{x} {y} {z}\n" for x in (0, 2) for y in (0, 3) for z in (0, 5)]
        file = self.root / "box.xyz"
        file.write_text("".join(corners) + "1 1 1\n")
        said = output_of(self.example / "volume", file)
        self.assertRegex(said, r"^9 points, \d+ cells in 1 tiles, volume 30\n$")

    def test_the_example_sums_the_volume_of_points_of_its_own(self):
        said = output_of(self.example / "volume")
        self.assertRegex(said, r"^1000000 points, 67\d{5} cells in \d+ tiles, volume 0\.99\d+\n$")

    def test_the_example_tells_what_is_wrong(self):
        done = subprocess.run([self.example / "volume", "/nowhere.las"], capture_output=True, text=True)
        self.assertEqual(done.returncode, 4)
        self.assertIn("volume: /nowhere.las: cannot be opened", done.stderr)

    def test_the_other_example_proves_and_exports_the_ground(self):
        said = output_of(self.root / "ground/ground", SOURCE / "data/ign/ign_77050_627755.las", self.root / "ground.ply")
        self.assertRegex(said, r"^\d+ of \d+ points, \d+ triangles, \d+ checks passed\n$")
        self.assertTrue((self.root / "ground.ply").read_bytes().startswith(b"ply\n"))
        done = subprocess.run([self.root / "ground/ground", "/nowhere.las", "x.ply"], capture_output=True, text=True)
        self.assertEqual(done.returncode, 4)

    def test_documents_licence_and_a_sample_configuration_are_installed_with_their_links(self):
        for name in ("LICENSE", "CHANGELOG.md", "config/tessera.toml", "docs/library.md"):
            self.assertEqual((self.documents / name).read_bytes(), (SOURCE / name).read_bytes())
        links = re.findall(r"\]\(([^)#:]+)\)", (self.documents / "README.md").read_text())
        self.assertGreater(len(links), 5)
        self.assertEqual([link for link in links if not (self.documents / link).exists()], [])
        said = output_of(self.root / "prefix/bin/tessera", "triangulate", "--help", "--config", self.documents / "config/tessera.toml")
        self.assertIn("--output", said)

    def test_what_was_installed_is_uninstalled(self):
        prefix = self.root / "gone"
        (prefix / "lib").mkdir(parents=True)
        (prefix / "lib/of_another").write_text("stays")
        manifest = BUILD / "install_manifest.txt"
        before = manifest.read_bytes()
        output_of(CMAKE, "--install", BUILD, "--prefix", prefix)
        kept = self.root / "manifest.txt"
        kept.write_bytes(manifest.read_bytes())
        manifest.write_bytes(before)  # what the target `uninstall` would remove is none of this test's business
        output_of(CMAKE, "-D", f"MANIFEST={kept}", "-P", SOURCE / "cmake/uninstall.cmake")
        self.assertEqual([path for path in prefix.rglob("*") if path.is_file() or path.name == "tessera"],
                         [prefix / "lib/of_another"])
        done = subprocess.run([CMAKE, "-D", f"MANIFEST={self.root / 'none'}", "-P", SOURCE / "cmake/uninstall.cmake"],
                              capture_output=True, text=True)
        self.assertIn("nothing has been installed from here", done.stderr)

    def test_a_version_with_another_minor_number_is_not_found(self):
        folder = self.root / "other"
        folder.mkdir()
        (folder / "CMakeLists.txt").write_text(
            "cmake_minimum_required(VERSION 3.25)\nproject(other LANGUAGES NONE)\nfind_package(tessera 0.0)\n"
            'message(STATUS "found=${tessera_FOUND} considered=${tessera_CONSIDERED_VERSIONS}")\n')
        said = output_of(CMAKE, "-S", folder, "-B", folder / "build", f"-DCMAKE_PREFIX_PATH={self.root / 'prefix'}")
        self.assertRegex(said, r"found=0 considered=\d+\.\d+\.\d+")

    def test_pkg_config_knows_it(self):
        descriptions = list((self.root / "prefix").rglob("tessera.pc"))
        self.assertEqual(len(descriptions), 1)
        environment = dict(os.environ, PKG_CONFIG_PATH=str(descriptions[0].parent))
        flags = output_of("pkg-config", "--cflags", "--libs", "tessera", env=environment).split()
        program = self.root / "by_pkg_config"
        source = self.root / "program.cc"
        source.write_text('#include <tessera/tessera.h>\n#include <cstdio>\n'
                          'int main() { std::puts(tessera::library_version()); }\n')
        output_of(COMPILER, source, "-o", program, *flags, *FLAGS)
        library = next((self.root / "prefix").rglob("libtessera.so"))
        said = output_of(program, env=dict(os.environ, LD_LIBRARY_PATH=str(library.parent)))
        self.assertRegex(said, r"^\d+\.\d+\.\d+\n$")

    def test_the_command_is_installed_beside(self):
        said = output_of(self.root / "prefix/bin/tessera", "--version")
        self.assertRegex(said, r"^tessera \d+\.\d+\.\d+\n$")


if __name__ == "__main__":
    unittest.main()
