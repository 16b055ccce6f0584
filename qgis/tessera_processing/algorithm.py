"""What all algorithms have in common: a command of the program, with parameters for its options."""
import pathlib
import re

from qgis.core import (QgsCoordinateReferenceSystem, QgsProcessing, QgsProcessingAlgorithm, QgsProcessingException,
                       QgsProcessingParameterFile, QgsProcessingParameterMultipleLayers, QgsProcessingParameterString)
from qgis.PyQt.QtGui import QIcon

from . import settings, styles
from .commands import HIDDEN, commands
from .parameters import Values, dressed, key_of, parameter_of
from .run import Canceled, Failed, Listener, find_program, run

ICON = QIcon(str(pathlib.Path(__file__).with_name("icon.svg")))


class Told(Listener):
    """Tells QGIS of a run."""

    def __init__(self, feedback):
        self.feedback, self.phase = feedback, None

    def progress(self, fraction, phase):
        if phase != self.phase:
            self.phase = phase
            self.feedback.setProgressText(phase)
        self.feedback.setProgress(100 * fraction)

    def said(self, line):
        self.feedback.pushWarning(line)

    def canceled(self):
        return self.feedback.isCanceled()


class CommandAlgorithm(QgsProcessingAlgorithm):
    """Subclasses say which command, and what is special about it."""

    COMMAND = ""
    TITLE = ""
    GROUP = ""
    MAIN = ()  # the options that are shown first; the others are advanced
    NEEDED = ()  # of these, those without which the command does nothing
    LEFT_OUT = ()  # options that have no use here
    SHOWN = ()  # options that are hidden elsewhere
    NUMBERS = ()  # members of the program's summary that become outputs

    @property
    def command(self):
        return commands()[self.COMMAND]

    def createInstance(self):
        return type(self)()

    def name(self):
        return self.COMMAND

    def displayName(self):
        return self.TITLE

    def group(self):
        return self.GROUP

    def groupId(self):
        return re.sub(r"\W+", "_", self.GROUP.lower())

    def icon(self):
        return ICON

    def shortDescription(self):
        return self.command.about

    def shortHelpString(self):
        return self.command.help

    def tags(self):
        return ["tessera", "delaunay", "lidar", "tin", self.COMMAND]

    def options(self):
        """The options with a parameter: first the main ones."""
        hidden = (HIDDEN | set(self.LEFT_OUT)) - set(self.SHOWN)
        offered = [one for one in self.command.options if one.name not in hidden]
        return [self.command.option(name) for name in self.MAIN] + [one for one in offered if one.name not in self.MAIN]

    def initAlgorithm(self, configuration=None):
        self.add_inputs()
        for option in self.options():
            self.addParameter(parameter_of(option, option.name in self.NEEDED, option.name not in self.MAIN))
        self.add_outputs()

    def add_inputs(self):
        pass

    def add_outputs(self):
        pass

    # The parts of the command line, and what is done before and after it.

    def inputs(self, values):
        return []

    def targets(self, values):
        """The options that name what is written."""
        return []

    def results(self, values, events):
        """The outputs by name. `events`: what the program has told."""
        return {}

    def processAlgorithm(self, parameters, context, feedback):
        self.known_system = None
        values = Values(self, parameters, context, feedback, lambda: self.system_of(values, feedback))
        words = [self.COMMAND, *self.inputs(values), *self.targets(values), "--json"]
        if self.command.has("overwrite") and not self.parameterAsBoolean(parameters, "RESUME", context):
            words.append("--overwrite")  # QGIS asks before
        for option in self.options():
            words += values.words(option)
        return self.results(values, self.tell(words, feedback))

    def tell(self, words, feedback):
        """Runs the program and returns what it has told; its notes are shown."""
        feedback.pushCommandInfo(" ".join(["tessera", *(without_token(str(word)) for word in words)]))
        events = self.ask(words, feedback)
        for event in events:
            for note in [event.get("note"), *(event.get("warnings") or [])]:
                if note:
                    feedback.pushWarning(note)
            feedback.pushInfo(summary_of(event))
        return events

    def system_of(self, values, feedback):
        """The coordinate system of the points. The program tells it."""
        if self.known_system is None:
            told = values.text("CRS") if self.command.has("crs") and values.is_given("CRS") else self.asked_system(values, feedback)
            self.known_system = QgsCoordinateReferenceSystem(told) if told else QgsCoordinateReferenceSystem()
        return self.known_system

    def asked_system(self, values, feedback):
        words = self.inputs(values)[:1]  # all files have the same
        for name in ("server", "token-file", "ca"):
            if self.command.has(name):
                words += values.words(self.command.option(name))
        told = self.ask(["info", *words, "--json"], feedback)[-1]
        return told["crs"] if "crs" in told else told["files"][0]["crs"]

    def ask(self, words, feedback):
        try:
            return run([find_program(settings.program()), *words], Told(feedback))
        except Failed as failure:
            raise QgsProcessingException(str(failure)) from failure
        except Canceled as canceled:
            raise QgsProcessingException("canceled") from canceled

    def style(self, path, style, feedback):
        wrong = styles.write_beside(path, style)
        if wrong:
            feedback.pushWarning(wrong)


def without_token(word):
    """A word without a token that it may have."""
    return re.sub(r"#token=\S+", "#token=...", word)


def summary_of(event):
    """The event as lines for people."""
    lines = [f"{key.replace('_', ' ')}: {value}" for key, value in event.items()
             if key != "event" and not isinstance(value, (dict, list)) and value not in ("", None)]
    return "\n".join(lines)


class OfPoints(CommandAlgorithm):
    """A command that reads point files."""

    def add_inputs(self):
        about = self.command.arguments[0].help
        self.addParameter(dressed(QgsProcessingParameterMultipleLayers("FILES", "Point files", QgsProcessing.TypeFile), about))
        self.addParameter(dressed(QgsProcessingParameterString("NAMES", "Names of point files"),
                                  f"{about}; one a line. With a server, the names that the daemon has for them", is_advanced=True))

    def inputs(self, values):
        files = values.algorithm.parameterAsFileList(values.parameters, "FILES", values.context) if values.is_given("FILES") else []
        names = values.text("NAMES").splitlines() if values.is_given("NAMES") else []
        found = [*files, *(name.strip() for name in names if name.strip())]
        if not found:
            raise QgsProcessingException("no point files are given")
        return found


class OfResult(OfPoints):
    """A command that reads a result folder, or point files."""

    def add_inputs(self):
        about = self.command.arguments[0].help
        self.addParameter(dressed(QgsProcessingParameterFile("RESULT", "Result folder", QgsProcessingParameterFile.Folder), about))
        super().add_inputs()

    def inputs(self, values):
        if not values.is_given("RESULT"):
            if not (values.is_given("FILES") or values.is_given("NAMES")):
                raise QgsProcessingException("neither a result folder nor point files are given")
            return super().inputs(values)
        if values.is_given("FILES") or values.is_given("NAMES"):
            raise QgsProcessingException("give a result folder or point files, not both")
        return [values.text("RESULT")]
