"""The plugin for QGIS as far as it goes without QGIS: the zip file, what it says of itself, and how it runs the program."""
import ast
import configparser
import importlib
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import textwrap
import unittest
import zipfile

ZIP = pathlib.Path(os.environ["QGIS_PLUGIN"])
SOURCE = pathlib.Path(os.environ["SOURCE"])
FOLDER = tempfile.TemporaryDirectory()
with zipfile.ZipFile(ZIP) as archive:
    NAMES = archive.namelist()
    archive.extractall(FOLDER.name)
PLUGIN = pathlib.Path(FOLDER.name, "tessera_processing")
sys.path.append(str(PLUGIN))  # the modules, not the package, which needs QGIS
commands = importlib.import_module("commands")
run = importlib.import_module("run")


class Zip(unittest.TestCase):
    def test_has_one_folder_with_all_sources_and_no_other_file(self):
        sources = {path.name for path in (SOURCE / "qgis/tessera_processing").iterdir() if path.suffix in (".py", ".svg")}
        self.assertEqual({f"tessera_processing/{name}" for name in sources | {"LICENSE", "commands.json", "metadata.txt"}}, set(NAMES))

    def test_says_what_qgis_asks_for(self):
        metadata = configparser.ConfigParser()
        metadata.read(PLUGIN / "metadata.txt")
        general = metadata["general"]
        for key in ("name", "description", "about", "author", "email", "license", "icon"):
            self.assertTrue(general[key], key)
        self.assertEqual((general["hasProcessingProvider"], general["qgisMinimumVersion"]), ("yes", "3.22"))
        (version,) = re.findall(r"^project\(tessera VERSION (\S+)", (SOURCE / "CMakeLists.txt").read_text(), re.MULTILINE)
        self.assertEqual(general["version"], version)
        self.assertTrue((PLUGIN / general["icon"]).exists())

    def test_is_python_that_the_oldest_qgis_reads(self):
        """QGIS 3.22 has Python 3.9 on some systems."""
        for path in PLUGIN.glob("*.py"):
            ast.parse(path.read_text(), str(path), feature_version=(3, 9))


class Commands(unittest.TestCase):
    def test_are_those_of_the_program_with_its_words(self):
        for name, command in commands.commands().items():
            told = " ".join(subprocess.run([os.environ["TESSERA"], name, "--help"], capture_output=True, text=True, check=True).stdout.split())
            self.assertIn(command.about, told)
            for option in (*command.options, *command.arguments):
                self.assertIn(" ".join(option.help.split()), told, f"{name} {option.name}")
            self.assertIn(" ".join(command.footer.split()), told)
        told = subprocess.run([os.environ["TESSERA"], "--help"], capture_output=True, text=True, check=True).stdout
        self.assertEqual(set(re.findall(r"^  ([a-z]+) {2,}[A-Z]", told, re.MULTILINE)), set(commands.commands()))

    def test_have_parameters_of_the_right_kind(self):
        def kind(command, option):
            return commands.kind_of(commands.commands()[command].option(option))
        for command, option, expected in (("dem", "res", "number"), ("dem", "hillshade", "switch"), ("dem", "method", "choice"), ("dem", "bbox", "box"),
                                          ("dem", "class", "text"), ("dem", "memory", "text"), ("dem", "threads", "count"),
                                          ("alpha", "alpha", "text"), ("surface", "ray-length", "text"), ("triangulate", "max-points-per-tile", "text"),
                                          ("triangulate", "dim", "choice"), ("profile", "line", "line"), ("profile", "digits", "text"),
                                          ("volume", "within", "polygons"), ("contours", "base", "number"), ("volume", "base", "polygons"),
                                          ("region", "polygon", "polygons"), ("jobs", "status", "text"), ("dem", "keep-result", "folder")):
            self.assertEqual(kind(command, option), expected, f"{command} {option}")

    def test_help_hides_what_qgis_does_by_itself(self):
        text = commands.commands()["dem"].help
        self.assertIn("<b>Res</b>: the width and height of a pixel", text)
        self.assertNotIn("<b>Json</b>", text)


class Heard(run.Listener):
    def __init__(self, cancel_at=None):
        self.told, self.lines, self.cancel_at = [], [], cancel_at

    def progress(self, fraction, phase):
        self.told.append((phase, fraction))

    def said(self, line):
        self.lines.append(line)

    def canceled(self):
        return self.cancel_at is not None and self.cancel_at in self.lines


class Run(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(self.enterContext(tempfile.TemporaryDirectory()))

    def program(self, text):
        path = self.folder / "program"
        path.write_text("#!/bin/sh\n" + textwrap.dedent(text))
        path.chmod(0o755)
        return path

    def test_tells_of_progress_and_returns_the_other_events(self):
        program = self.program("""\
            echo '{"event":"progress","phase":"routing","fraction":0.25}'
            echo 'note: it is late' >&2
            echo '{"event":"dem","output":"'$1'"}'
            """)
        heard = Heard()
        self.assertEqual(run.run([program, "a.tif"], heard), [{"event": "dem", "output": "a.tif"}])
        self.assertEqual((heard.told, heard.lines), ([("routing", 0.25)], ["note: it is late"]))

    def test_fails_with_the_sentence_of_the_program_once(self):
        heard = Heard()
        with self.assertRaisesRegex(run.Failed, "^a.tif: exists already$"):
            run.run([self.program("""echo '{"event":"error","status":2,"message":"a.tif: exists already"}'; echo 'tessera: a.tif: exists already' >&2; exit 2""")], heard)
        self.assertEqual(heard.lines, [])
        with self.assertRaisesRegex(run.Failed, "^there is no disk$"):
            run.run([self.program("echo 'tessera: there is no disk' >&2; exit 4")], heard)
        with self.assertRaisesRegex(run.Failed, "status 9, and said nothing"):
            run.run([self.program("exit 9")], heard)
        with self.assertRaisesRegex(run.Failed, "signal SIGKILL"):
            run.run([self.program("kill -KILL $$")], heard)

    def test_waits_for_the_program_to_clean_up_when_it_is_cancelled(self):
        program = self.program(f"""\
            trap 'rm {self.folder}/begun; exit 8' TERM
            touch {self.folder}/begun
            echo begun >&2
            while :; do read -r line < {self.folder}/nothing; done
            """)
        os.mkfifo(self.folder / "nothing")
        with self.assertRaises(run.Canceled):
            run.run([program], Heard(cancel_at="begun"))
        self.assertFalse((self.folder / "begun").exists())

    def test_much_output_does_not_stop_it(self):
        events = run.run([self.program("""i=0; while [ $i -lt 20000 ]; do echo '{"event":"job"}'; echo what >&2; i=$((i+1)); done""")], Heard())
        self.assertEqual(len(events), 20000)

    def test_of_a_raster_tells_of_its_progress(self):
        """Work of more than a second has events."""
        files = sorted(pathlib.Path(os.environ["IGN"]).glob("*.las"))
        heard, out = Heard(), self.folder / "out"
        subprocess.run([os.environ["TESSERA"], "triangulate", *files, "-o", out, "--dim", "2", "--tiles", "40", "--quiet"], check=True)
        (told,) = run.run([os.environ["TESSERA"], "dem", out, "--res", "0.025", "-o", self.folder / "dem.tif", "--json"], heard)
        self.assertEqual((told["event"], told["width"]), ("dem", 4000))
        shares = [fraction for phase, fraction in heard.told if phase == "drawing"]
        self.assertTrue(shares)
        self.assertEqual(shares, sorted(shares))
        self.assertTrue(all(0 <= share <= 1 for share in shares))

    def test_names_a_program_that_is_missing(self):
        with self.assertRaisesRegex(run.Failed, "^the program '/nothing/tessera' that the settings name is not found"):
            run.find_program("/nothing/tessera")


if __name__ == "__main__":
    unittest.main()
