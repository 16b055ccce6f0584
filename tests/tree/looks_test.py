"""That no code takes an error of the system for "nothing is there": src/base/files/there.h is asked, std::filesystem is not."""

import os
import pathlib
import re
import unittest

import tree

DOOR = "src/base/files/there.cc"  # where the system is asked
QUESTIONS = ("exists|is_empty|is_directory|is_regular_file|is_symlink|is_other|is_fifo|is_socket|is_block_file"
             "|is_character_file|file_size|status|symlink_status|last_write_time|hard_link_count|equivalent")
COMMENT = re.compile(r'"(?:\\.|[^"\\\n])*"|//[^\n]*|/\*.*?\*/', re.DOTALL)
# What stat() could not tell may be handed on, and nothing else.
STAT = re.compile(r"\bl?stat(?:at)?(?:64)?\((?:[^()]|\([^()]*\))*\)(?!\s*\{)")
HANDED_ON = re.compile(r"\s*!= 0\)\s*(?:\{\s*if \(errno != ENOENT\)\s*)?return io_error\(")


def without_comments(text):
    """The same with as many lines; texts are empty, too."""
    return COMMENT.sub(lambda found: ('""' if found[0][0] == '"' else "") + "\n" * found[0].count("\n"), text)


def bare_looks(text):
    """The lines that ask the system what is there and could take its error for an answer."""
    text = without_comments(text)
    names = "|".join(["filesystem", *re.findall(r"\bnamespace (\w+) = (?:::)?std::filesystem\b", text)])
    asked = re.compile(rf"\b(?:{names})::(?:(?:{QUESTIONS})\b|(?:recursive_)?directory_\w+)"
                       rf"|using (?:namespace )?(?:::)?std::filesystem\b|[.>](?:is_empty|is_directory|is_regular_file|is_symlink|file_size)\(\w+\)")
    found = [match.start() for match in asked.finditer(text)]
    for match in re.finditer(r"(?<![\w.>])(?:::)?" + STAT.pattern, text):
        call = "," in match[0]  # else something else of that name
        if call and not HANDED_ON.match(text, match.end()):
            found.append(match.start())
    return sorted(text.count("\n", 0, place) + 1 for place in found)


class Looks(unittest.TestCase):
    def test_breaches_are_seen(self):
        for line in ("if (std::filesystem::exists(path, code)) return;",
                     "namespace fs = std::filesystem; bool f() { return fs::is_directory(\n path, code); }",
                     "namespace files = std::filesystem; auto n = files::file_size(path, code);",
                     "if (fs::is_regular_file(fs::symlink_status(file, failed))) {}".replace("fs::", "std::filesystem::"),
                     "for (const auto& entry : std::filesystem::directory_iterator(folder, code)) {}",
                     "using std::filesystem::exists;", "using namespace std::filesystem;",
                     "return entry.is_directory(code);",
                     "return ::stat(path.c_str(), &status) == 0;", "if (lstat(path.c_str(), &to) != 0) return false;",
                     "if (::stat((folder / name).c_str(), &status) != 0) return nothing;"):
            self.assertEqual(len(bare_looks(line)), 2 if "symlink_status" in line else 1, line)

    def test_what_hands_errors_on_is_none(self):
        for line in ("BOOST_OUTCOME_TRY(there, is_there(path));", "// std::filesystem::exists(path, code) is false",
                     'const char* text = "std::filesystem::exists(path)";', "if (results.exists(name)) return;",
                     'if (::stat(file.c_str(), &status) != 0) return io_error(file, "cannot open", errno);',
                     'if (::stat(plan.c_str(), &found) != 0)\n    return io_error(plan, "cannot be examined", errno);',
                     "struct stat status {};", "std::ifstream stat(file);", "if (::fstat(file.get(), &status) != 0) return false;"):
            self.assertEqual(bare_looks(line), [], line)

    def test_there_are_none_in_the_code(self):
        source = pathlib.Path(os.environ["SOURCE"])
        code = [path for path in tree.files(source)
                if path.startswith(("src/", "actors/", "python/", "include/")) and path.endswith(tree.CODE)]
        self.assertGreater(len(code), 300)
        self.assertTrue(bare_looks((source / DOOR).read_text()), "the one place that may ask is not seen")
        found = [f"{path}:{line}" for path in code if path != DOOR for line in bare_looks((source / path).read_text())]
        self.assertEqual(found, [], "ask src/base/files/there.h")


if __name__ == "__main__":
    unittest.main()
