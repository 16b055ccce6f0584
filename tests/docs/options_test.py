"""Commands that documents name, in blocks, tables and sentences, have the options that the documents give them."""
import os
import pathlib
import re
import subprocess
import unittest

SOURCE = pathlib.Path(os.environ["SOURCE"])
PROGRAMS = {"tessera": os.environ["TESSERA"], "tesserad": os.environ["TESSERAD"]}
OPTION = re.compile(r"(?<![\w-])--[a-z][a-z0-9-]*")


def pages():
    return [SOURCE / "README.md", *sorted((SOURCE / "docs").glob("*.md"))]


def commands_of(text):
    """The commands of a page: (program, words behind it), once for each place. A backslash continues a line of a block."""
    text = re.sub(r"\\\n\s*", " ", text)
    blocks = re.findall(r"^ {4,}((?:\S+/)?tesserad? .*)$", text, re.MULTILINE)
    fenced = [line for block in re.findall(r"^```(?:sh|bash|console)\n(.*?)^```", text, re.MULTILINE | re.DOTALL) for line in block.splitlines()]
    spans = [span.replace("\n", " ") for span in re.findall(r"`([^`]+)`", text)]
    found = []
    for line in blocks + fenced + spans:
        for part in re.split(r"[|;]| && ", re.split(r" {3,}|\s#", line)[0]):
            if called := re.match(r"\s*(?:sudo )?(?:\S+/)?(tesserad?)\s+(.*)", part):
                found.append((called[1], called[2]))
    return found


class Options(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        def output(program, *arguments):
            return subprocess.run([PROGRAMS[program], *arguments, "--help"], capture_output=True, text=True, check=True).stdout
        cls.help = {"tesserad": output("tesserad")}
        overview = output("tessera")
        cls.commands = {word for word in re.findall(r"^  ([a-z]+) ", overview, re.MULTILINE)} | {"help"}
        for command in cls.commands:
            cls.help[command] = output("tessera", command) if command != "help" else overview

    def options(self, name):
        return set(OPTION.findall(self.help[name])) | {"--help", "--version"}

    def test_commands_are_seen_in_blocks_tables_and_sentences(self):
        text = "a `tessera dem r --res\n1` b\n\n    tessera info a | tessera query b --json     it says --no\n\n```sh\nbin/tesserad \\\n  --x 1  # --y\n```\n"
        self.assertEqual(commands_of(text), [("tessera", "info a "), ("tessera", "query b --json"), ("tesserad", "--x 1 "), ("tessera", "dem r --res 1")])

    def test_commands_have_the_options_that_documents_give_them(self):
        seen = 0
        for page in pages():
            for program, words in commands_of(page.read_text()):
                command = words.split()[0]
                if program == "tessera" and not re.fullmatch(r"[a-z]+", command):
                    continue
                name = command if program == "tessera" else "tesserad"
                with self.subTest(page=page.name, command=f"{program} {words}"):
                    self.assertIn(name, self.help)
                    self.assertLessEqual(set(OPTION.findall(words)), self.options(name))
                seen += 1
        self.assertGreater(seen, 300)


if __name__ == "__main__":
    unittest.main()
