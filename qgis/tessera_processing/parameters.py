"""Parameters of QGIS for options of the program, and the words of a command line for their values."""
import pathlib

from qgis.core import (QgsCoordinateTransform, QgsProcessing, QgsProcessingException, QgsProcessingParameterBoolean,
                       QgsProcessingParameterDefinition, QgsProcessingParameterEnum, QgsProcessingParameterExtent,
                       QgsProcessingParameterFeatureSource, QgsProcessingParameterFile, QgsProcessingParameterFolderDestination,
                       QgsProcessingParameterNumber, QgsProcessingParameterString, QgsProcessingParameterVectorLayer,
                       QgsProcessingUtils, QgsVectorFileWriter)

from .commands import kind_of


def key_of(option):
    """The name of the parameter: MAX_EDGE for max-edge."""
    return option.name.replace("-", "_").upper()


def number(key, title, kind):
    return QgsProcessingParameterNumber(key, title, kind, optional=True)


def parameter_of(option, is_needed=False, is_advanced=False):
    """The parameter for an option. Without a value, the default is the program's."""
    key, title, kind = key_of(option), option.title, kind_of(option)
    if kind == "switch":
        parameter = QgsProcessingParameterBoolean(key, title, False)
    elif kind == "choice":
        parameter = QgsProcessingParameterEnum(key, title, list(option.choices), usesStaticStrings=True, optional=True)
    elif kind == "box":
        parameter = QgsProcessingParameterExtent(key, title)
    elif kind == "file":
        parameter = QgsProcessingParameterFile(key, title)
    elif kind == "folder":
        parameter = QgsProcessingParameterFolderDestination(key, title, optional=True, createByDefault=False)
    elif kind == "polygons":
        parameter = QgsProcessingParameterVectorLayer(key, title, [QgsProcessing.TypeVectorPolygon])
    elif kind == "line":
        parameter = QgsProcessingParameterFeatureSource(key, title, [QgsProcessing.TypeVectorLine])
    elif kind == "number":
        parameter = number(key, title, QgsProcessingParameterNumber.Double)
    elif kind == "count":
        parameter = number(key, title, QgsProcessingParameterNumber.Integer)
    else:
        parameter = QgsProcessingParameterString(key, title)
    return dressed(parameter, option.help, is_needed, is_advanced)


def dressed(parameter, help_text, is_needed=False, is_advanced=False):
    parameter.setHelp(help_text)
    flags = parameter.flags() & ~QgsProcessingParameterDefinition.FlagOptional
    if not is_needed and not isinstance(parameter, QgsProcessingParameterBoolean):
        flags |= QgsProcessingParameterDefinition.FlagOptional
    if is_advanced:
        flags |= QgsProcessingParameterDefinition.FlagAdvanced
    parameter.setFlags(flags)
    return parameter


class Values:
    """The values of one run, as words of a command line."""

    def __init__(self, algorithm, parameters, context, feedback, system):
        self.algorithm, self.parameters, self.context, self.feedback = algorithm, parameters, context, feedback
        self.system = system  # () -> the coordinate system of the points, which may be invalid

    def is_given(self, key):
        return self.parameters.get(key) not in (None, "", [])

    def words(self, option):
        key, kind = key_of(option), kind_of(option)
        if kind == "switch":
            return [f"--{option.name}"] if self.algorithm.parameterAsBoolean(self.parameters, key, self.context) else []
        if not self.is_given(key):
            return []
        value = getattr(self, kind)(key)
        return [] if value == "" else [f"--{option.name}", value]

    def text(self, key):
        return self.algorithm.parameterAsString(self.parameters, key, self.context)

    file = text

    def choice(self, key):
        return self.algorithm.parameterAsEnumString(self.parameters, key, self.context)

    def number(self, key):
        return repr(self.algorithm.parameterAsDouble(self.parameters, key, self.context))

    def count(self, key):
        return str(self.algorithm.parameterAsInt(self.parameters, key, self.context))

    def folder(self, key):
        return self.algorithm.parameterAsString(self.parameters, key, self.context)

    def box(self, key):
        """In the coordinate system of the points, where both systems are known."""
        box = self.algorithm.parameterAsExtent(self.parameters, key, self.context, self.system())
        return ",".join(map(repr, (box.xMinimum(), box.yMinimum(), box.xMaximum(), box.yMaximum())))

    def line(self, key):
        """A GeoJSON file with the one line of a layer."""
        source = self.algorithm.parameterAsSource(self.parameters, key, self.context)
        title = self.algorithm.parameterDefinition(key).description()
        count = 0 if source is None else source.featureCount()
        if count != 1:
            raise QgsProcessingException(f"{title}: the layer has {count} lines, but one is needed. Select one line, and "
                                         "choose 'Selected features only'")
        (feature,) = source.getFeatures()
        geometry = feature.geometry()
        geometry.transform(self.transform(source.sourceCrs()))
        parts = geometry.asGeometryCollection() if geometry.isMultipart() else [geometry]
        if len(parts) != 1:
            raise QgsProcessingException(f"{title}: the line has {len(parts)} parts, but one is needed")
        path = pathlib.Path(QgsProcessingUtils.generateTempFilename("line.geojson"))
        path.write_text(parts[0].asJson(17), encoding="utf-8")
        return str(path)

    def polygons(self, key):
        """A GeoJSON file with the polygons of a layer."""
        layer = self.algorithm.parameterAsVectorLayer(self.parameters, key, self.context)
        if layer is None:
            raise QgsProcessingException(self.algorithm.invalidSourceError(self.parameters, key))
        options = QgsVectorFileWriter.SaveVectorOptions()
        options.driverName, options.layerOptions = "GeoJSON", ["RFC7946=NO", "COORDINATE_PRECISION=15"]
        options.ct = self.transform(layer.crs())
        path = QgsProcessingUtils.generateTempFilename("polygons.geojson")
        status, message, *_ = QgsVectorFileWriter.writeAsVectorFormatV3(layer, path, self.context.transformContext(), options)
        if status != QgsVectorFileWriter.NoError:
            raise QgsProcessingException(f"{layer.name()}: cannot be written for the program: {message}")
        return path

    def transform(self, system):
        """From this coordinate system to that of the points; none where one of them is unknown."""
        to = self.system()
        return QgsCoordinateTransform(system, to, self.context.transformContext()) if system.isValid() and to.isValid() \
            else QgsCoordinateTransform()
