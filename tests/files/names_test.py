"""No file but src/base/files/names.cc spells a name of a result or run folder. Argument: the project's folder."""
import pathlib
import re
import sys

FOLDERS = "tiles|points|attributes|state|finals|mail|duplicates|settled"
FORBIDDEN = re.compile(
    r'"(manifest\.json|triangulation\.(pvtu|vtkhdf)|duplicates\.bin|report\.html|plan\.json|segments\.bin|routing\.bin|settled\.done'
    r'|\.run(\.new[^\"]*)?|\.lock|\.done|\.tmp[^"]*|%06u[^"]*|(ca)?\.(pem|key))"'  # a name alone, or how it is made
    rf'|/\s*"({FOLDERS})"|"({FOLDERS})/'                      # a folder in a path
)


def spelled(text):
    """The numbers of the lines, comments aside, that spell a name."""
    lines = (line.split("//")[0] if '"' not in line.split("//")[0] else line for line in text.splitlines())
    return [number for number, line in enumerate(lines, 1) if not line.startswith("#include") and FORBIDDEN.search(line)]


def main():
    root = pathlib.Path(sys.argv[1])
    names = root / "src/base/files/names.cc"
    assert len(spelled(names.read_text())) > 15, "the pattern does not see the names where they are made"
    files = [file for folder in ("src", "actors") for file in sorted((root / folder).rglob("*")) if
             file.suffix in (".h", ".cc") and file != names]
    assert len(files) > 150, "the sources are not where they were"
    found = [f"{file.relative_to(root)}:{number}" for file in files for number in spelled(file.read_text())]
    if found:
        sys.exit("names that src/base/files/names.h should make: " + ", ".join(found))


main()
