"""The compiler finds headers of what a target links, and no others."""

import json
import os
import pathlib
import re
import shlex
import subprocess
import unittest

SOURCE = pathlib.Path(os.environ["SOURCE"])
COMMANDS = json.loads((pathlib.Path(os.environ["LINKS"]).parent / "compile_commands.json").read_text())


def command_for(path):
    source = str(SOURCE / path)

    def compiles_it(entry):
        if "/Unity/unity_" not in entry["file"]:
            return entry["file"] == source
        return f'"{source}"' in pathlib.Path(entry["file"]).read_text()

    found = [entry for entry in COMMANDS if compiles_it(entry)]
    if len(found) != 1:
        raise AssertionError(f"{path} is compiled {len(found)} times")
    return found[0]


def words_of(entry):
    return shlex.split(entry["command"])


def include_roots(entry):
    words = words_of(entry)
    return [word[2:] for word in words if word.startswith("-I")] + [
        after for word, after in zip(words, words[1:]) if word == "-isystem"]


class Walls(unittest.TestCase):
    def compiles(self, as_if, header):
        entry = command_for(as_if)
        words = words_of(entry)
        words = words[: words.index("-o")]
        done = subprocess.run([*words, "-fsyntax-only", "-x", "c++", "-"], cwd=entry["directory"], text=True,
                              input=f'#include "{header}"\n', capture_output=True)
        if done.returncode != 0:
            self.assertRegex(done.stderr, re.escape(header) + "(: No such file|' file not found)")
        return done.returncode == 0

    def test_a_header_of_a_linked_library_is_found(self):
        self.assertTrue(self.compiles("src/result/store/manifest.cc", "src/geometry/mesh/tile_mesh.h"))
        self.assertTrue(self.compiles("src/result/store/manifest.cc", "src/result/store/tile_store.h"))

    def test_a_header_of_what_is_linked_publicly_by_a_linked_library_is_found(self):
        self.assertTrue(self.compiles("src/result/export/export.cc", "src/geometry/mesh/tile_mesh.h"))

    def test_a_header_of_a_library_that_is_not_linked_is_not_found(self):
        self.assertFalse(self.compiles("src/result/store/manifest.cc", "src/tiling/tile/collect.h"))
        self.assertFalse(self.compiles("src/tiling/tile/collect.cc", "src/input/reader.h"))
        self.assertFalse(self.compiles("src/geometry/kernel/kernel.cc", "tests/kernel/kernel_testing.h"))

    def test_a_header_of_what_a_linked_library_links_privately_is_not_found(self):
        self.assertFalse(self.compiles("src/job/estimate.cc", "src/geometry/reference/clouds.h"))

    # What the machine carries, only programs know.
    def test_exchange_and_actors_name_nothing_of_what_programs_compute(self):
        files = [path for folder in ("src/exchange", "actors") for path in sorted((SOURCE / folder).glob("*.*"))
                 if path.suffix in (".h", ".cc")]
        self.assertGreater(len(files), 50)
        wrong = [f"{path.relative_to(SOURCE)}:{number}: {line.strip()}" for path in files
                 for number, line in enumerate(path.read_text().splitlines(), 1)
                 if re.search(r"points?\b|points?_|_points?|cells?\b|cells?_|kernel|delaunay|triangul|mesh", line, re.IGNORECASE)
                 and not re.search(r"time_point|^#include", line)]
        self.assertEqual(wrong, [])
        for header in ("src/geometry/kernel/kernel.h", "src/tiling/tile/tile_triangulation.h", "src/geometry/mesh/tile_mesh.h",
                       "src/delaunay/delaunay_program.h", "src/result/store/tile_store.h", "src/tiling/routed_cloud.h"):
            self.assertFalse(self.compiles("src/exchange/tile_life.cc", header))

    def test_no_source_sees_the_folder_of_the_project(self):
        wrong = [f"{entry['file']}: {root}" for entry in COMMANDS for root in include_roots(entry)
                 if pathlib.Path(root) in (SOURCE, SOURCE / "src", SOURCE / "tests")]
        self.assertEqual(wrong, [])


if __name__ == "__main__":
    unittest.main()
