"""The phases of a job stand in one table, src/base/phases.h: nobody else spells them, or asks whether a phase is a certain one."""
import json
import os
import pathlib
import re
import subprocess
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
TABLE = json.loads(subprocess.run([os.environ["PHASES"]], check=True, capture_output=True, text=True).stdout)
NAMES = "|".join(row["name"] for row in TABLE)
# "done" is a word for many things, too.
OWN = "|".join(row["name"] for row in TABLE if not row["over"])
SPELLED = re.compile(rf"(?<![A-Za-z ])(?:{OWN})(?![A-Za-z .])")  # in a literal; what a name is a part of is a sentence or a file
MEMBER = re.compile(rf"(?:\.|->)(?:{OWN})\b|(?<![:\w])(?:{OWN}):(?!:)")  # of a struct, and a key of TypeScript
ENUMERATOR = re.compile(rf"(?<!:)\bPhase::(?:{NAMES})\b")  # not Other::Phase::collecting
ASKED = re.compile(rf"(?:[=!<>]=|[<>]|\bcase\b)\s*{ENUMERATOR.pattern}|{ENUMERATOR.pattern}\s*(?:[=!<>]=|[<>])")
# Strings, with those of Python that begin and end with three quotes, and comments, of which only C++'s and TypeScript's are told apart.
TOKEN = re.compile(r'R"\((?P<raw>.*?)\)"|"""(?P<long>.*?)"""|"(?P<text>(?:\\.|[^"\\\n])*)"|\'(?P<small>(?:\\.|[^\'\\\n])*)\''
                   r"|`(?P<template>[^`]*)`|//[^\n]*|/\*.*?\*/", re.DOTALL)

SPELLS = {
    "src/base/phases.h",            # the table
    "src/job/job.cc",               # goes from phase to phase
    "src/tiling/budget/budget.cc",         # what reading takes
    "python/tessera/_progress.py",  # tells users which there are
}


def text_of(path):
    """Without the phases of a class that has an enumeration of that name."""
    text, header = path.read_text(), path.with_suffix(".h")
    own = header.exists() and "  enum class Phase" in header.read_text()
    return text.replace("Phase::", "Own::") if own else text


def sources():
    for folder, endings in (("src", (".h", ".cc")), ("actors", (".h", ".cc")), ("web/src", (".ts",)), ("python", (".h", ".cc", ".py"))):
        for path in sorted((ROOT / folder).rglob("*")):
            if path.suffix in endings:
                yield str(path.relative_to(ROOT)), text_of(path)


def literals(text):
    text = re.sub(r"^#include.*$", "", text, flags=re.MULTILINE)
    return [next(part for part in token.groups() if part is not None) for token in TOKEN.finditer(text)
            if token.lastgroup]


def without_literals(text):
    return TOKEN.sub('""', text)


def spells(text):
    code = without_literals(text)
    return any(SPELLED.search(literal) for literal in literals(text)) or ENUMERATOR.search(code) or MEMBER.search(code)


def listed(text):
    """The longest list of words in quotes."""
    return max(re.findall(r'"\w+"(?:,\s+"\w+")+', text), key=len)


class Phases(unittest.TestCase):
    def test_who_spells_a_phase(self):
        self.assertEqual({name for name, text in sources() if spells(text)}, SPELLS)

    def test_nobody_asks_for_a_certain_phase(self):
        asking = {name for name, text in sources() if ASKED.search(without_literals(text))}
        self.assertEqual(asking - {"src/base/phases.h"}, set())

    def test_lists_for_users_are_those_of_the_table(self):
        told = ", ".join(f'"{row["name"]}"' for row in TABLE)
        for name in ("include/tessera/options.h", "python/tessera/_progress.py"):
            self.assertEqual(listed((ROOT / name).read_text()), told, name)

    def test_the_search_finds_what_it_is_for(self):
        for text in ('x == "routing"', '{"splaying_cpu_s", 1}', 'R"(--line:#1; --collecting:#2;)"', "['finishing']",
                     "`p-planning`", "a = Phase::done;",
                     "phases.routing = 1;", "const words = {splaying: 'x'};"):
            self.assertTrue(spells(text), text)
        for text in ('return "routing points";', '"routing.bin"', '#include "src/delaunay/run/routing.h"', "// the splaying phase",
                     "State::finishing", '"done"', "case State::finishing:", "Other::Phase::collecting", "read_routing(routing.path)"):
            self.assertFalse(spells(text), text)
        for text in ("if (phase >= Phase::collecting)", "while (Phase::done != phase) {", "case Phase::routing:",
                     "phase == Phase::splaying ? 1 : 2", "phase<Phase::done"):
            self.assertTrue(ASKED.search(text), text)
        for text in ("progress.phase = Phase::routing;", "spans.push_back({Phase::routing, {}, 0})"):
            self.assertFalse(ASKED.search(text), text)


if __name__ == "__main__":
    unittest.main()
