"""What README.md says of the folders, what CMake links, and what is included agree; and functions are short."""

import os
import pathlib
import unittest

import tree

SOURCE = pathlib.Path(os.environ["SOURCE"])
LINKS = pathlib.Path(os.environ["LINKS"])
FUNCTION_LINES_MAX = 70
# Tables of routes, handlers and schemas; and two loops of the kernel whose state must stay in registers.
LONG_FUNCTIONS = {"ShareActor::make_behavior", "add_documents", "add_job_routes", "add_question_routes", "add_result_routes",
                  "Mesh::find_zone", "collect"}
CLASS_SOURCES_MAX = 2


class Folders(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.files = tree.files(SOURCE)
        cls.rooms = tree.rooms((SOURCE / "README.md").read_text())
        cls.texts = {path: (SOURCE / path).read_text() for path in cls.files if path.endswith(tree.CODE)}
        cls.walls = tree.Walls(tree.targets(LINKS.read_text()), cls.texts)

    maxDiff = None

    def test_every_folder_that_the_readme_lists_exists(self):
        self.assertGreater(len(self.rooms), 20)
        gone = [room for room in self.rooms if not any(path.startswith(room + "/") for path in self.files)]
        self.assertEqual(gone, [])
        self.assertEqual(len(set(self.rooms)), len(self.rooms))

    def test_the_readme_lists_every_folder(self):
        without = [path for path in self.files if "/" in path and tree.room_of(path, self.rooms) is None]
        without.remove("src/CMakeLists.txt")
        self.assertEqual(without, [])

    def test_a_folder_knows_only_what_stands_above_it(self):
        order = {room: place for place, room in enumerate(self.rooms)}
        wrong = []
        for path, text in self.texts.items():
            room = tree.room_of(path, self.rooms)
            for name in tree.includes(text):
                other = tree.room_of(tree.place_of(name), self.rooms)
                if not name.endswith(".pb.h") and (other is None or order[other] > order[room]):
                    wrong.append(f"{path} includes {name}")
        self.assertEqual(wrong, [])

    def test_tiles_are_read_through_one_door(self):
        """src/result reads tile files, and looks what the manifest says of them; nobody else does."""
        readers = {path for path, text in self.texts.items() if "src/result/store/tile_reader.h" in tree.includes(text)
                   and not path.startswith("tests/")}
        self.assertEqual(readers, {"src/result/tile_source.h", "src/result/store/tile_reader.cc"})

    def test_headers_are_named_from_the_project_folder(self):
        wrong = [f"{path} includes {name}" for path, text in self.texts.items() for name in tree.includes(text)
                 if tree.place_of(name) not in self.texts and not name.endswith(".pb.h")]
        self.assertEqual(wrong, [])

    def test_every_source_belongs_to_a_target(self):
        # The example is a project of its own; fuzz targets, benchmarks and the Python package are not in every build.
        built = {target.folder.split("/")[0] for target in self.walls.targets.values()}
        without = [path for path in self.texts if path.endswith(".cc") and path not in self.walls.source_of]
        self.assertEqual([path for path in without if path.split("/")[0] in built
                          and not path.startswith("tests/fuzz/fuzz_")], [])

    def test_what_is_included_is_linked_by_the_target_itself(self):
        wrong = []
        for target in self.walls.targets.values():
            public, private = self.walls.needs(target)
            for needed, links, how in ((public, target.public, "PUBLIC"), (private, target.links, "itself")):
                wrong += [f"{why}, but {target.name} does not link {name or 'any such target'} {how}"
                          for name, why in needed.items() if name not in links]
        self.assertEqual(wrong, [])

    def test_what_is_linked_is_included(self):
        wrong = []
        for target in self.walls.targets.values():
            public, private = self.walls.needs(target)
            wrong += [f"{target.name} links {name} for nothing" for name in target.links - {*public, *private}]
            if target.shows_its_headers:
                wrong += [f"{target.name} links {name} PUBLIC, but only sources include it"
                          for name in target.public & {*private}]
        self.assertEqual(wrong, [])

    def test_a_type_has_one_definition(self):
        # Two of one name in one program: which of them a function meant by it gets is the linker's choice.
        where = {}
        for path, text in self.texts.items():
            if path.split("/")[0] in ("src", "actors", "include", "python"):
                for name in tree.types_in(text):
                    where.setdefault(name, []).append(path)
        self.assertGreater(len(where), 300)
        self.assertEqual({name: paths for name, paths in where.items() if len(paths) > 1}, {})

    def test_a_class_is_in_two_sources_at_most(self):
        # A class of more sources has more than one purpose. Two classes may have one name, in two folders or namespaces.
        where = {}
        for path, text in self.texts.items():
            if path.endswith(".cc") and path.split("/")[0] in ("src", "actors", "python"):
                for key in tree.classes_in(text):
                    where.setdefault((os.path.dirname(path), *key), []).append(path)
        self.assertGreater(len(where), 200)
        self.assertEqual({key: paths for key, paths in where.items()
                          if len(paths) > CLASS_SOURCES_MAX}, {})

    def test_no_function_is_longer_than_a_page(self):
        lengths = [(path, name, lines) for path, text in self.texts.items() if path.startswith(("src/", "actors/", "python/"))
                   for name, lines in tree.functions_in(text)]
        self.assertGreater(len(lengths), 4000)
        long_ones = [length for length in lengths if length[2] > FUNCTION_LINES_MAX]
        self.assertEqual([length for length in long_ones if length[1] not in LONG_FUNCTIONS], [])
        self.assertEqual(LONG_FUNCTIONS - {name for _, name, _ in long_ones}, set(), "these are short now")


if __name__ == "__main__":
    unittest.main()
