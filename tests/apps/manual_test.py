"""The man pages and the completion of the shell know every command and every option that --help shows, and no other."""
import os
import pathlib
import re
import shutil
import subprocess
import unittest

from cli import CliTest
from cli_usage_test import COMMANDS

MANUAL = pathlib.Path(os.environ["MANUAL"])
COMPLETION = MANUAL / "completions" / "tessera"


def options(help_text):
    """The options of a help text, short and long."""
    lines = re.findall(r"^  (-\S+)", help_text, re.MULTILINE)
    return {name for line in lines for name in line.split(",")}


def page(command=None):
    name = f"tessera-{command}.1" if command else "tessera.1"
    return (MANUAL / "man1" / name).read_text()


def complete(*words):
    """What bash offers for the last of these words."""
    script = (f'source "{COMPLETION}"; COMP_WORDS=("$@"); COMP_CWORD=$(($# - 1)); _tessera; '
              'printf "%s\\n" "${COMPREPLY[@]}"')
    done = subprocess.run(["bash", "-c", script, "bash", "tessera", *words], text=True, check=True,
                          stdout=subprocess.PIPE)
    return set(done.stdout.split())


class Manual(CliTest):
    def test_the_help_is_read_as_it_is_meant(self):
        self.assertLessEqual({"-o", "--output", "--memory", "--no-z", "-v"}, options(self.ok("triangulate", "--help")))

    def test_every_command_has_a_page_and_the_overview_names_it(self):
        pages = {path.name for path in (MANUAL / "man1").iterdir()}
        self.assertEqual(pages, {"tessera.1", *(f"tessera-{command}.1" for command in COMMANDS)})
        for command in COMMANDS:
            self.assertIn(f"\\fBtessera\\-{command}\\fR(1)", page())

    def test_a_page_has_every_option_and_no_other(self):
        for command in COMMANDS:
            text = page(command).split(".SH OPTIONS")[1].split(".SH")[0].replace("\\-", "-")
            listed = set(re.findall(r"\\fB(-[^\\]+)\\fR", text))
            self.assertEqual(listed, options(self.ok(command, "--help")), command)

    def test_a_page_has_arguments_examples_variables_and_exit_statuses(self):
        text = page("triangulate").replace("\\-", "-")
        for part in ("\\fIinputs\\fR", ".SH EXAMPLES", "tessera triangulate block/*.las -o out/", "TESSERA_MEMORY",
                     ".SH EXIT STATUS"):
            self.assertIn(part, text)
        self.assertNotIn("TESSERA_RESUME", text)
        self.assertIn(".SH FORMATS\n", page("export"))

    @unittest.skipUnless(shutil.which("groff"), "no groff")
    def test_pages_are_roff_without_warnings(self):
        for path in sorted((MANUAL / "man1").iterdir()):
            done = subprocess.run(["groff", "-man", "-Tutf8", "-ww", "-z", path], text=True, stderr=subprocess.PIPE)
            self.assertEqual(done.stderr, "", path.name)


class Completion(CliTest):
    def test_commands_are_completed(self):
        self.assertEqual(complete("tri"), {"triangulate"})
        self.assertEqual(complete(""), {*COMMANDS, "help", "--help", "--version"})
        self.assertEqual(complete("help", "ve"), {"verify"})

    def test_every_option_of_a_command_is_completed_and_no_other(self):
        for command in COMMANDS:
            self.assertEqual(complete(command, "-"), options(self.ok(command, "--help")), command)
            self.assertEqual(complete(command, "--quiet", "--verb"), set() if command in ("certs", "cluster", "log", "jobs", "job", "inputs", "results", "nodes") else {"--verbose"})

    def test_values_of_which_there_are_few_are_completed(self):
        self.assertEqual(complete("triangulate", "--partition", ""), {"kdtree", "grid", "octree", "random"})
        self.assertEqual(complete("triangulate", "a.las", "--dim", ""), {"2", "3"})
        self.assertEqual(complete("generate", "ter"), {"terrain"})
        self.assertEqual(complete("certs", ""), {"init", "node"})
        self.assertEqual(complete("certs", "init", ""), set())
        formats = set(re.findall(r"^  (\w+)  ", self.ok("export", "--help").split("Formats:")[1], re.MULTILINE))
        self.assertEqual(complete("export", "out", "--format", ""), formats)

    def test_each_value_that_is_offered_is_taken(self):
        cloud = self.xyz(n=50)
        for key in ("--partition", "--kernel", "--dim"):
            for value in complete("triangulate", key, ""):
                self.ok("triangulate", cloud, "-o", self.out, "--overwrite", key, value)
        for kind in complete("generate", ""):
            self.ok("generate", kind, "-n", "10", "-o", self.folder / f"{kind}.las")

    def test_where_anything_can_stand_the_shell_offers_files(self):
        for words in (("triangulate", ""), ("triangulate", "--config", ""), ("triangulate", "--crop", "-"),
                      ("verify", "out")):
            self.assertEqual(complete(*words), set(), words)
        self.assertIn("complete -o default ", COMPLETION.read_text())


if __name__ == "__main__":
    unittest.main()
