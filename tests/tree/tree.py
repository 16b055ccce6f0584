"""The project as a tree of files and as CMake sees it: the folders of the README, targets, includes.

A *room* is a folder that README.md lists. Paths are relative to the project's folder, with slashes.
"""

import dataclasses
import os
import pathlib
import re

CODE = (".cc", ".h")
SOURCES = (*CODE, ".py", ".sh", ".cmake", "CMakeLists.txt", ".ts", ".css", ".js")
NOT_OURS = ("build", "demo-out", "out")  # beside names that begin with a dot; `build` also as the begin of a name
INCLUDE = re.compile(r'^#include (?:"([^"]+)"|<(tessera/[^>]+)>)', re.MULTILINE)


def files(source):
    """All files that belong to the project, in order."""
    found = []
    for folder, below, names in os.walk(source):
        at_the_top = pathlib.Path(folder) == source
        below[:] = [name for name in below if not name.startswith(".") and name != "__pycache__"
                    and not (at_the_top and (name in NOT_OURS or name.startswith("build")))]
        found += [str((pathlib.Path(folder) / name).relative_to(source)) for name in names if not name.startswith(".")]
    return sorted(found)


def rooms(readme):
    """The folders of "The way of the data", in order: all that stands at the begin of a line and ends with a slash."""
    section = readme.split("## The way of the data", 1)[1].split("\n## ", 1)[0]
    found = []
    for line in re.findall(r"^    (\S.*)$", section, re.MULTILINE):
        for word in line.split():
            if not re.fullmatch(r"[\w/]+/", word):
                break
            found.append(word.rstrip("/"))
    return found


def types_in(text):
    """The types that a file defines in namespaces, with these: not those of nameless ones, nor templates' others."""
    text = re.sub(r"(?<=\w)'(?=\w)", "", text)  # 1'000
    text = re.sub(r'"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n])*\'|//[^\n]*|/\*.*?\*/', "0", text, flags=re.DOTALL)
    text = re.sub(r"^[ \t]*#(?:[^\n]*\\\n)*[^\n]*$", "", text, flags=re.MULTILINE)
    found, open_ones, begin = [], [], 0
    for brace in re.finditer(r"[{};]", text):
        head, begin = text[begin:brace.start()].strip(), brace.end()
        if brace[0] == "}":
            open_ones.pop()
            continue
        if brace[0] == ";":
            continue
        namespace = re.search(r"\bnamespace\b\s*([\w:]*)$", head)
        defined = re.search(r"\b(?:class|struct|union|enum(?:\s+class)?)\s+(\w+)\s*(?:final\b\s*)?(?::[^:].*)?$", head,
                            re.DOTALL)
        if defined and None not in open_ones:
            found.append("::".join([*open_ones, defined[1]]))
        # What is within a type, a function or a nameless namespace has names of its own.
        open_ones.append(namespace[1] if namespace and namespace[1] else None)
    return found


def functions_in(text):
    """(name, number of lines) of each function of a C++ file; what stands inside of functions is part of them."""
    blank = lambda found: re.sub(r"[^\n]", " ", found[0])
    text = re.sub(r"(?<=\w)'(?=\w)", " ", text)  # 1'000
    text = re.sub(r'R"\((?:.|\n)*?\)"|"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n])+\'|//[^\n]*|/\*.*?\*/', blank, text, flags=re.DOTALL)
    text = re.sub(r"^[ \t]*#(?:[^\n]*\\\n)*[^\n]*$", blank, text, flags=re.MULTILINE)
    found, open_ones, begin = [], [], 0
    for brace in re.finditer(r"[{};]", text):
        head = text[begin:brace.start()].strip()
        initial = brace[0] == "{" and re.match(r"[\w>]", text[brace.start() - 1])  # x_{1}
        if initial or (brace[0] == "}" and open_ones[-1][0] == "initial"):
            open_ones.append(("initial", "", 0)) if initial else open_ones.pop()
            continue
        begin = brace.end()
        if brace[0] == "{":
            scope = (re.search(r"\bnamespace\b[^()]*$|\b(?:class|struct|union|enum)\b[^()=]*$", head) or head.startswith("extern"))
            outermost = all(kind == "scope" for kind, _, _ in open_ones)
            kind = "scope" if scope else "function" if outermost and ")" in head and "=" not in head.split("(")[0] else "block"
            name = re.search(r"([~\w:]+)\s*\(", head)
            open_ones.append((kind, name[1] if name else "", text.count("\n", 0, brace.start()) - head.count("\n")))
        elif brace[0] == "}":
            kind, name, first = open_ones.pop()
            if kind == "function":
                found.append((name, text.count("\n", 0, brace.start()) - first + 1))
    return found


def classes_in(text):
    """(namespace, class) of each class of which a file defines members outside of the class."""
    namespace = re.search(r"^namespace ([\w:]+) \{", text, re.MULTILINE)
    owners = [re.match(r"(?:[a-z]\w*::)*([A-Z]\w*)::", name) for name, _ in functions_in(text)]
    return {(namespace[1] if namespace else "", owner[1]) for owner in owners if owner}


def room_of(path, all_rooms):
    """The innermost room that holds the file, or None."""
    inside = [room for room in all_rooms if path.startswith(room + "/")]
    return max(inside, key=len, default=None)


def includes(text):
    """The project's headers that a file includes, as it names them."""
    return [quoted or public for quoted, public in INCLUDE.findall(text)]


def place_of(name):
    """Where the header of that name stands: the public ones are found below include/, generated ones below proto/."""
    if name.startswith("tessera/"):
        return f"include/{name}"
    return f"proto/{name}" if name.endswith(".pb.h") else name


@dataclasses.dataclass
class Target:
    name: str
    type: str
    folder: str
    sources: list = dataclasses.field(default_factory=list)
    public: set = dataclasses.field(default_factory=set)
    private: set = dataclasses.field(default_factory=set)

    @property
    def links(self):
        return self.public | self.private

    @property
    def shows_its_headers(self):
        return self.type in ("STATIC_LIBRARY", "INTERFACE_LIBRARY")


def targets(text):
    """What tessera_build_walls of cmake/TesseraWalls.cmake wrote, by name."""
    found = {}
    target = None
    for line in text.splitlines():
        kind, *words = line.split(" ")
        if kind == "target":
            target = found[words[0]] = Target(*words)
        elif kind == "source":
            target.sources.append(os.path.normpath(os.path.join(target.folder, words[0])))
        else:
            getattr(target, kind).add(words[0])
    return found


class Walls:
    """Which target needs which, by what is included. `texts`: the content of every .cc and .h, by path."""

    def __init__(self, all_targets, texts):
        self.targets = all_targets
        self.texts = texts
        self.source_of = {}  # path of a source -> its target
        for target in all_targets.values():
            for path in target.sources:
                self.source_of[path] = target
        self.libraries = {}  # folder -> the library whose headers stand there
        for target in all_targets.values():
            if target.shows_its_headers:
                self.libraries[target.folder] = target
        for target in all_targets.values():
            if target.name == "tessera_shared":
                self.libraries["include/tessera"] = target

    def owner(self, header, user):
        """The target to link for that header. One without a .cc of its own in its folder is the library's there; where
        there is none, or the header is one of a test's, whoever includes it."""
        beside = self.source_of.get(header.removesuffix(".h") + ".cc")
        if beside:
            return beside
        folder = room_of(header, self.libraries)
        if folder:
            return self.libraries[folder]
        return user if room_of(header, [user.folder]) else None

    def needs(self, target):
        """(public, private): {name of a target: the include that needs it}, for headers and for sources."""
        public, private = {}, {}
        waiting = [path for path in target.sources if path in self.texts]
        if target.shows_its_headers:
            waiting += [path for path in self.texts if path.endswith(".h") and self.owner(path, target) is target
                        and room_of(path, [target.folder])]
        seen = set(waiting)
        while waiting:
            path = waiting.pop()
            for name in includes(self.texts[path]):
                header = place_of(name)
                owner = self.owner(header, target)
                if owner is target:
                    if header not in seen and header in self.texts:
                        seen.add(header)
                        waiting.append(header)
                    continue
                kind = public if path.endswith(".h") and target.shows_its_headers else private
                kind.setdefault(owner.name if owner else None, f"{path} includes {name}")
        return public, {name: why for name, why in private.items() if name not in public}
