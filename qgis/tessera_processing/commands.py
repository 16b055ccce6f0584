"""The commands of the program as data. The build makes commands.json from their declarations, so that what an option
means is written once. Knows nothing of QGIS."""
import dataclasses
import functools
import html
import json
import pathlib
import re

FILE = pathlib.Path(__file__).with_name("commands.json")


@dataclasses.dataclass(frozen=True)
class Option:
    name: str
    value: str  # what stands for the value in the help, as LENGTH; "" for a switch
    many: bool
    choices: tuple
    help: str

    @property
    def is_switch(self):
        return self.value == ""

    @property
    def title(self):
        return self.name.replace("-", " ").capitalize()


@dataclasses.dataclass(frozen=True)
class Command:
    name: str
    about: str
    arguments: tuple
    options: tuple
    footer: str

    def option(self, name):
        return next(option for option in (*self.options, *self.arguments) if option.name == name)

    def has(self, name):
        return any(option.name == name for option in self.options)

    @property
    def help(self):
        """The help of the command as HTML, for the panel beside the parameters."""
        rows = "".join(f"<p><b>{html.escape(one.title)}</b>: {html.escape(one.help)}</p>"
                       for one in (*self.arguments, *self.options) if one.name not in HIDDEN - {"output"})
        return f"<p>{html.escape(self.about)}.</p>{rows}<pre>{html.escape(self.footer.strip())}</pre>"


@functools.lru_cache
def commands():
    def options(described):
        return tuple(Option(one["name"], one["value"], one["many"], tuple(one["choices"]), one["help"]) for one in described)
    return {one["name"]: Command(one["name"], one["about"], options(one["arguments"]), options(one["options"]), one["footer"])
            for one in json.loads(FILE.read_text(encoding="utf-8"))}


# Options that the plugin gives by itself, or that have no use without a terminal.
HIDDEN = {"config", "detach", "input-list", "json", "output", "overwrite", "quiet", "resume", "verbose", "version"}
# Values that may be words, or numbers with a letter as 500k, although most of their kind are numbers.
WORDS_TOO = re.compile(r"\b(auto|full|all|for example \d+[kMG])\b")
NUMBERS = {"LENGTH", "NUMBER", "R", "HEIGHT", "DEGREES", "Z", "S", "SECONDS"}


def kind_of(option):
    """What sort of parameter QGIS shows for an option: switch, choice, box, file, folder, number, count, polygons, line or text."""
    if option.is_switch:
        return "switch"
    if option.choices and option.value != "LIST":
        return "choice"
    if option.name in ("within", "base", "polygon") and option.value == "FILE":
        return "polygons"
    if option.value == "LINE":
        return "line"
    if option.value in ("BOX", "FILE", "FOLDER"):
        return option.value.lower()
    if option.value in NUMBERS | {"N"}:
        told = option.help.split("; default")[0]
        if not WORDS_TOO.search(told):
            return "count" if option.value == "N" else "number"
    return "text"
