"""The algorithms that ask a daemon: its jobs, results and inputs, and what is done with a job."""
from qgis.core import (QgsFeature, QgsFeatureSink, QgsField, QgsFields, QgsProcessing, QgsProcessingException,
                       QgsProcessingOutputNumber, QgsProcessingOutputString, QgsProcessingParameterFeatureSink,
                       QgsProcessingParameterFolderDestination, QgsProcessingParameterMultipleLayers,
                       QgsProcessingParameterString, QgsWkbTypes)
from qgis.PyQt.QtCore import QVariant

from . import settings
from .algorithm import CommandAlgorithm
from .parameters import dressed

KINDS = {bool: QVariant.Bool, int: QVariant.LongLong, float: QVariant.Double, str: QVariant.String}


class OfDaemon(CommandAlgorithm):
    GROUP = "Jobs of a daemon"
    MAIN = ("server",)

    def inputs(self, values):
        """The arguments, and the daemon of the settings where the parameters name none."""
        server = [] if values.is_given("SERVER") or not settings.server() else ["--server", settings.server()]
        return [*self.arguments(values), *server]

    def arguments(self, values):
        return []


class Listing(OfDaemon):
    """A table with a row for each thing that the daemon tells of."""

    def add_outputs(self):
        self.addParameter(dressed(QgsProcessingParameterFeatureSink("OUTPUT", "Table", QgsProcessing.TypeVector), self.command.about,
                                  is_needed=True))
        self.addOutput(QgsProcessingOutputNumber("COUNT", "Rows"))

    def results(self, values, events):
        rows = [{key: value for key, value in event.items() if key != "event" and type(value) in KINDS} for event in events]
        kinds = {}
        for row in rows:
            for key, value in row.items():
                kinds.setdefault(key, KINDS[type(value)])
        fields = QgsFields()
        for key, kind in kinds.items():
            fields.append(QgsField(key, kind))
        sink, target = self.parameterAsSink(values.parameters, "OUTPUT", values.context, fields, QgsWkbTypes.NoGeometry)
        if sink is None:
            raise QgsProcessingException(self.invalidSinkError(values.parameters, "OUTPUT"))
        for row in rows:
            feature = QgsFeature(fields)
            feature.setAttributes([row.get(key) for key in kinds])
            if not sink.addFeature(feature, QgsFeatureSink.FastInsert):
                raise QgsProcessingException(self.writeFeatureError(sink, values.parameters, "OUTPUT"))
        return {"OUTPUT": target, "COUNT": len(rows)}


class Jobs(Listing):
    COMMAND, TITLE = "jobs", "List jobs"
    MAIN = ("server", "status", "limit")


class Results(Listing):
    COMMAND, TITLE = "results", "List results"


class Inputs(Listing):
    COMMAND, TITLE = "inputs", "List point files"

    def add_inputs(self):
        for argument in self.command.arguments:
            self.addParameter(dressed(QgsProcessingParameterString(argument.name.upper(), argument.title), argument.help))

    def arguments(self, values):
        return [values.text(one.name.upper()) for one in self.command.arguments if values.is_given(one.name.upper())]


class OfJob(OfDaemon):
    """What is done with one job."""

    def add_inputs(self):
        argument = self.command.arguments[0]
        self.addParameter(dressed(QgsProcessingParameterString("JOB", argument.title), argument.help, is_needed=True))

    def add_outputs(self):
        self.addOutput(QgsProcessingOutputString("JOB", "Job"))
        self.addOutput(QgsProcessingOutputString("STATUS", "Status"))

    def arguments(self, values):
        return [values.text("JOB")]

    def results(self, values, events):
        told = [event["status"] for event in events if event.get("event") == "job"]
        return {"JOB": values.text("JOB"), "STATUS": told[-1] if told else ""}


class Watch(OfJob):
    COMMAND, TITLE = "watch", "Wait for a job"


class Cancel(OfJob):
    COMMAND, TITLE = "cancel", "Cancel a job"


class Resume(OfJob):
    COMMAND, TITLE = "resume", "Resume a job"


class Fetch(OfDaemon):
    COMMAND, TITLE = "fetch", "Fetch a result, or the files of a job"

    def add_inputs(self):
        argument = self.command.arguments[0]
        self.addParameter(dressed(QgsProcessingParameterString("RESULT", argument.title), argument.help, is_needed=True))

    def add_outputs(self):
        self.addParameter(dressed(QgsProcessingParameterFolderDestination("OUTPUT", "Folder or file"), self.command.option("output").help,
                                  is_needed=True))

    def arguments(self, values):
        return [values.text("RESULT")]

    def targets(self, values):
        return ["--output", values.text("OUTPUT")]

    def results(self, values, events):
        return {"OUTPUT": values.text("OUTPUT")}


class Upload(OfDaemon):
    COMMAND, TITLE = "upload", "Send point files"

    def add_inputs(self):
        self.addParameter(dressed(QgsProcessingParameterMultipleLayers("FILES", "Files", QgsProcessing.TypeFile),
                                  self.command.arguments[0].help, is_needed=True))

        self.addParameter(dressed(QgsProcessingParameterString("NAME", "Name of the folder"), self.command.option("output").help, is_needed=True))

    def add_outputs(self):
        self.addOutput(QgsProcessingOutputString("NAMES", "What jobs call the files"))

    def arguments(self, values):
        return self.parameterAsFileList(values.parameters, "FILES", values.context)

    def targets(self, values):
        return ["--output", values.text("NAME")]

    def results(self, values, events):
        return {"NAMES": f"upload:{values.text('NAME')}"}


DAEMON = (Jobs, Results, Inputs, Watch, Cancel, Resume, Fetch, Upload)
