"""The recipe for conda, which nobody has run here: it can be read, and says what the build needs."""
import pathlib
import re
import unittest

import yaml

SOURCE = pathlib.Path(__file__).parents[2]


class Recipe(unittest.TestCase):
    def setUp(self):
        text = (SOURCE / "deploy" / "conda" / "meta.yaml").read_text()
        self.version = re.search(r'{% set version = "(.*)" %}', text)[1]
        plain = re.sub(r"{%.*?%}", "", text).replace("{{ version }}", self.version).replace("{{ PYTHON }}", "python")
        self.recipe = yaml.safe_load(re.sub(r'{{ (\w+)\("(\w+)"\) }}', r"\1_\2", plain))

    def test_its_version_is_the_projects(self):
        self.assertEqual(self.version, re.search(r"project\(tessera VERSION ([0-9.]+)", (SOURCE / "CMakeLists.txt").read_text())[1])

    def test_it_names_what_cmake_looks_for(self):
        # Another name there, or a package that a listed one brings along.
        names = {"boost": "libboost-headers", "cgal": "cgal-cpp", "protobuf": "libprotobuf", "expat": "libexpat",
                 "tsl-robin-map": "robin-map", "gdal": "libgdal-core", "curl": "libcurl", "threads": None}
        wanted = {name.lower() for name in re.findall(r"find_package\((\S+)", (SOURCE / "CMakeLists.txt").read_text())}
        wanted -= {"gtest"}  # of the tests
        given = {line.split()[0] for line in self.recipe["requirements"]["host"]}
        self.assertGreater(len(wanted), 8)
        self.assertEqual({names.get(name, name) for name in wanted} - {None} - given, set())


if __name__ == "__main__":
    unittest.main()
