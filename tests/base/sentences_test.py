"""Sentences below the edges name options by keys, never as one edge calls them."""
import pathlib
import re
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
COMMAND = ROOT / "src/front/apps"
PROGRAMS = {COMMAND, ROOT / "src/front/daemon", ROOT / "src/front/harness"}  # what users type stands there
LITERAL = re.compile(r'"(?:[^"\\\n]|\\.)*"')


def sources(*folders):
    return sorted(p for f in folders for p in (ROOT / f).rglob("*") if p.suffix in (".h", ".cc") and PROGRAMS.isdisjoint(p.parents))


def literals(path):
    """(line, text) of each string literal; comments, which may speak of the command, are left out."""
    for number, line in enumerate(path.read_text().splitlines(), 1):
        for found in LITERAL.finditer(line):
            if "//" not in LITERAL.sub("", line[: found.start()]):
                yield number, found.group()[1:-1]


def marked(paths):
    return {key for path in paths for key in re.findall(r'\boption\("([^"]*)"', path.read_text())}


class Sentences(unittest.TestCase):
    def test_no_flag_is_named_below_the_command(self):
        named = []
        for path in sources("src", "actors", "include", "python"):
            for number, text in literals(path):
                text = re.sub(r"var\(--\w+\)|--\w+:", "", text)  # CSS
                if re.search(r"(^|[^\w-])--[a-z]|'tessera [a-z]", text) and "the command's --" not in text:
                    named.append(f"{path.relative_to(ROOT)}:{number}: {text}")
        self.assertEqual(named, [])

    def test_no_sentence_ends_at_its_first_mark(self):
        cut = [str(path) for path in sources("src", "actors", "bench", "examples", "tests") + sorted(f for p in PROGRAMS for f in p.glob("*.cc"))
               if ".where.c_str()" in path.read_text()]
        self.assertEqual(cut, [])

    def test_the_search_finds_what_it_is_for(self):
        found = [text for path in COMMAND.glob("*.cc") for _, text in literals(path) if "--resume" in text]
        self.assertGreater(len(found), 2)

    def test_every_marked_option_is_one_of_the_command(self):
        marks = marked(sources("src", "actors"))
        self.assertIn("memory", marks)
        declared = {key for path in COMMAND.glob("*.cc")
                    for key in re.findall(r'add_(?:value|switch)\(\s*command, "([a-z0-9-]+)"', path.read_text())}
        self.assertEqual(marks - declared, set())


if __name__ == "__main__":
    unittest.main()
