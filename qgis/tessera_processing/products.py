"""The algorithms that make results of points, and layers of results."""
import csv
import pathlib

from qgis.core import (QgsFeature, QgsField, QgsFields, QgsGeometry, QgsPoint, QgsProcessing,
                       QgsProcessingContext, QgsProcessingOutputNumber, QgsProcessingOutputString, QgsProcessingParameterFileDestination,
                       QgsProcessingParameterFolderDestination, QgsProcessingParameterFile, QgsProcessingException,
                       QgsProcessingParameterRasterDestination, QgsProcessingParameterString,
                       QgsProcessingParameterVectorDestination, QgsProcessingUtils, QgsVectorFileWriter, QgsWkbTypes)
from qgis.PyQt.QtCore import QVariant

from . import styles
from .algorithm import CommandAlgorithm, OfPoints, OfResult
from .parameters import dressed

TRIANGULATIONS, SURFACES, SHAPES = "Triangulations", "Heights", "Shapes and volumes"


class IntoFolder(OfPoints):
    """A command that writes a result folder."""

    SHOWN = ("detach",)

    def add_outputs(self):
        about = self.command.option("output").help
        self.addParameter(dressed(QgsProcessingParameterFolderDestination("OUTPUT", "Result folder"), about, is_needed=True))
        self.addParameter(dressed(QgsProcessingParameterString("NAME", "Name of the result"), about, is_advanced=True))
        self.addOutput(QgsProcessingOutputString("JOB", "Job of the daemon"))

    def target(self, values):
        if not values.is_given("SERVER"):
            return values.text("OUTPUT")
        if not values.is_given("NAME"):
            raise QgsProcessingException("with a server, the name of the result is needed")
        return values.text("NAME")

    def targets(self, values):
        return ["--output", self.target(values)]

    def results(self, values, events):
        jobs = [event["id"] for event in events if event.get("event") == "job"]
        return {"OUTPUT": self.target(values), "JOB": jobs[-1] if jobs else ""}


class IntoLayer(OfResult):
    """A command that writes a file that is a layer."""

    GEOMETRY = None
    DESTINATION = ""

    def add_outputs(self):
        about = self.command.option("output").help
        if self.GEOMETRY is None:
            output = QgsProcessingParameterRasterDestination("OUTPUT", self.DESTINATION)
        else:
            output = QgsProcessingParameterVectorDestination("OUTPUT", self.DESTINATION, self.GEOMETRY)
        self.addParameter(dressed(output, about, is_needed=True))
        for name in self.NUMBERS:
            self.addOutput(QgsProcessingOutputNumber(name.upper(), name.capitalize()))

    def target(self, values):
        return self.parameterAsOutputLayer(values.parameters, "OUTPUT", values.context)

    def targets(self, values):
        self.path = self.target(values)  # asked once, as each question makes a new temporary name
        return ["--output", self.path]

    def style_of(self, values):
        return styles.polygons

    def results(self, values, events):
        self.style(self.path, self.style_of(values), values.feedback)
        return {"OUTPUT": self.path} | {name.upper(): events[-1].get(name) for name in self.NUMBERS}


class Triangulate(IntoFolder):
    COMMAND, TITLE, GROUP = "triangulate", "Triangulate", TRIANGULATIONS
    MAIN = ("dim", "class", "attributes")
    SHOWN = ("resume", "detach")


class Region(IntoFolder):
    COMMAND, TITLE, GROUP = "region", "Triangulate a region", TRIANGULATIONS
    MAIN = ("bbox", "polygon", "dim", "class")
    LEFT_OUT = ("format",)  # the algorithm 'export' does that


class Export(IntoLayer):
    COMMAND, TITLE, GROUP = "export", "Triangles as polygons", TRIANGULATIONS
    MAIN = ("max-edge",)
    LEFT_OUT = ("format",)
    GEOMETRY, DESTINATION = QgsProcessing.TypeVectorPolygon, "Triangles"

    def style_of(self, values):
        return styles.cells


class Dem(IntoLayer):
    COMMAND, TITLE, GROUP = "dem", "Raster of heights (DEM), hillshade", SURFACES
    MAIN = ("res", "max-edge", "method", "hillshade", "bbox", "class")
    NEEDED = ("res",)
    DESTINATION = "Raster"

    def style_of(self, values):
        is_shade = self.parameterAsBoolean(values.parameters, "HILLSHADE", values.context)
        return styles.hillshade if is_shade else styles.heights


class Contours(IntoLayer):
    COMMAND, TITLE, GROUP = "contours", "Contour lines", SURFACES
    MAIN = ("interval", "max-edge", "smooth", "min-length", "index-every", "bbox", "class")
    NEEDED = ("interval",)
    GEOMETRY, DESTINATION = QgsProcessing.TypeVectorLine, "Contour lines"

    def style_of(self, values):
        return styles.contours


class Profile(IntoLayer):
    """The program writes a table; the layer has its rows as points."""

    COMMAND, TITLE, GROUP = "profile", "Profile along a line", SURFACES
    MAIN = ("line", "max-edge", "class")
    NEEDED = ("line",)
    GEOMETRY, DESTINATION = QgsProcessing.TypeVectorPoint, "Profile"

    def targets(self, values):
        self.path = self.target(values)
        self.is_table = self.path.lower().endswith(".csv")
        self.table = self.path if self.is_table else QgsProcessingUtils.generateTempFilename("profile.csv")
        return ["--output", self.table]

    def style_of(self, values):
        return styles.profile

    def results(self, values, events):
        if self.is_table:
            return {"OUTPUT": self.path}
        self.write_points(values)
        return super().results(values, events)

    def write_points(self, values):
        options = QgsVectorFileWriter.SaveVectorOptions()
        options.driverName = QgsVectorFileWriter.driverForExtension(pathlib.Path(self.path).suffix)
        options.layerName = "profile"
        with open(self.table, newline="", encoding="utf-8") as file:
            rows = csv.DictReader(file)
            fields = QgsFields()
            for name in rows.fieldnames:
                fields.append(QgsField(name, QVariant.Int if name == "part" else QVariant.Double))
            writer = QgsVectorFileWriter.create(self.path, fields, QgsWkbTypes.PointZ, self.system_of(values, values.feedback),
                                                values.context.transformContext(), options)
            if writer.hasError() != QgsVectorFileWriter.NoError:
                raise QgsProcessingException(f"{self.path}: cannot be written: {writer.errorMessage()}")
            for row in rows:
                feature = QgsFeature(fields)
                feature.setAttributes([int(text) if name == "part" else float(text) for name, text in row.items()])
                feature.setGeometry(QgsGeometry(QgsPoint(*(float(row[name]) for name in rows.fieldnames[1:4]))))
                if not writer.addFeature(feature):
                    raise QgsProcessingException(f"{self.path}: cannot be written: {writer.errorMessage()}")
            del writer  # closes the file


class Flat(IntoLayer):
    """A command for 2D and 3D. Layers are flat, so that point files are triangulated in 2D."""

    LEFT_OUT = ("dim",)

    def targets(self, values):
        return super().targets(values) + ([] if values.is_given("RESULT") else ["--dim", "2"])


class Voronoi(Flat):
    COMMAND, TITLE, GROUP = "voronoi", "Voronoi cells (Thiessen polygons)", SHAPES
    MAIN = ("clip", "class")
    GEOMETRY, DESTINATION = QgsProcessing.TypeVectorPolygon, "Voronoi cells"

    def style_of(self, values):
        return styles.cells


class Alpha(Flat):
    COMMAND, TITLE, GROUP = "alpha", "Alpha shape (concave hull)", SHAPES
    MAIN = ("alpha", "class")
    NEEDED = ("alpha",)
    NUMBERS = ("radius", "polygons", "holes")
    GEOMETRY, DESTINATION = QgsProcessing.TypeVectorPolygon, "Alpha shape"


class Volume(CommandAlgorithm):
    COMMAND, TITLE, GROUP = "volume", "Volumes between two surfaces: cut and fill", SHAPES
    MAIN = ("plane", "base", "within", "name", "max-edge", "res", "class")
    LEFT_OUT = ("difference",)  # an output
    NUMBERS = ("cut", "fill", "net", "area")

    def add_inputs(self):
        for argument in self.command.arguments:
            key, about = argument.name.upper(), argument.help
            folder = QgsProcessingParameterFile(key, f"{argument.title}: result folder", QgsProcessingParameterFile.Folder)
            files = QgsProcessingParameterString(f"{key}_FILES", f"{argument.title}: point file or pattern")
            self.addParameter(dressed(folder, about))
            self.addParameter(dressed(files, about, is_advanced=True))

    def add_outputs(self):
        self.addParameter(dressed(QgsProcessingParameterVectorDestination("OUTPUT", "Volumes", QgsProcessing.TypeVector),
                                  self.command.option("output").help, is_needed=True))
        difference = QgsProcessingParameterRasterDestination("DIFFERENCE", "Difference of heights", optional=True, createByDefault=False)
        self.addParameter(dressed(difference, self.command.option("difference").help))
        for name in self.NUMBERS:
            self.addOutput(QgsProcessingOutputNumber(name.upper(), f"{name.capitalize()}, of all rows"))

    def inputs(self, values):
        found = []
        for key in ("BEFORE", "AFTER"):
            given = [values.text(one) for one in (key, f"{key}_FILES") if values.is_given(one)]
            if len(given) > 1:
                raise QgsProcessingException(f"{key.lower()}: give a result folder or point files, not both")
            found += given
        if not (values.is_given("BEFORE") or values.is_given("BEFORE_FILES")):
            raise QgsProcessingException("the surface before is not given")
        return found

    def targets(self, values):
        self.path = self.parameterAsOutputLayer(values.parameters, "OUTPUT", values.context)
        self.raster = self.parameterAsOutputLayer(values.parameters, "DIFFERENCE", values.context)
        return ["--output", self.path, *(["--difference", self.raster] if self.raster else [])]

    def results(self, values, events):
        found = {"OUTPUT": self.path}
        if values.is_given("WITHIN") or values.is_given("BASE"):
            self.style(self.path, styles.polygons, values.feedback)
        if self.raster:
            self.style(self.raster, styles.change, values.feedback)
            found["DIFFERENCE"] = self.raster
        rows = next(event["rows"] for event in events if event.get("event") == "volumes")
        return found | {name.upper(): sum(row[name] for row in rows) for name in self.NUMBERS}


class Surface(OfResult):
    COMMAND, TITLE, GROUP = "surface", "Closed surface", SHAPES
    MAIN = ("sensor", "lambda", "bottom", "trim", "class")
    LEFT_OUT = ("format",)

    def add_outputs(self):
        filters = ";;".join(f"{name} (*.{ending})" for name, ending in (("Mesh", "ply"), ("Wavefront", "obj"), ("STL", "stl"), ("VTK", "vtu")))
        self.addParameter(dressed(QgsProcessingParameterFileDestination("OUTPUT", "Surface", filters),
                                  self.command.option("output").help, is_needed=True))

    def targets(self, values):
        self.path = self.parameterAsFileOutput(values.parameters, "OUTPUT", values.context)
        return ["--output", self.path]

    def results(self, values, events):
        if self.path.endswith(".ply"):
            self.load_mesh(values)
        return {"OUTPUT": self.path}

    def load_mesh(self, values):
        """QGIS loads files that are no rasters or vectors when it is told to."""
        self.style(self.path, styles.mesh, values.feedback)
        project = values.context.project()
        if project is None:
            return
        details = QgsProcessingContext.LayerDetails("Surface", project, "OUTPUT", QgsProcessingUtils.LayerHint.Mesh)
        values.context.addLayerToLoadOnCompletion(self.path, details)


PRODUCTS = (Triangulate, Region, Export, Dem, Contours, Profile, Voronoi, Alpha, Volume, Surface)
