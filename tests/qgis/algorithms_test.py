"""The plugin in QGIS itself, without a window: each algorithm, a model, cancelling, and how results look."""
import json
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest
import unittest.mock

from qgis_home import ENVIRONMENT, PLUGINS, PROCESS

os.environ |= ENVIRONMENT
try:
    from qgis.core import (QgsApplication, QgsCoordinateReferenceSystem, QgsMapRendererCustomPainterJob, QgsMapSettings,
                           QgsMeshLayer, QgsProcessing, QgsProcessingContext, QgsProcessingException, QgsProcessingFeedback,
                           QgsProcessingModelAlgorithm, QgsProcessingModelChildAlgorithm, QgsProcessingModelChildParameterSource,
                           QgsProcessingModelOutput, QgsProcessingModelParameter, QgsProcessingParameterMultipleLayers, QgsProcessingUtils, QgsProject,
                           QgsRasterLayer, QgsRectangle, QgsVectorLayer)
    from qgis.PyQt.QtCore import QSize
    from qgis.PyQt.QtGui import QColor, QImage, QPainter
except ImportError:
    QgsApplication = None

IGN = pathlib.Path(os.environ["IGN"])
FILES = [str(path) for path in sorted(IGN.glob("*.las"))]
PICTURES = os.environ.get("PICTURES")  # a folder for pictures to look at
LAMBERT = "EPSG:2154"


class Feedback(QgsProcessingFeedback if QgsApplication else object):
    """Keeps what is told."""

    def __init__(self):
        super().__init__()
        self.warnings, self.phases, self.shares = [], [], []
        self.progressChanged.connect(self.shares.append)

    def pushWarning(self, text):
        self.warnings.append(text)

    def setProgressText(self, text):
        self.phases.append(text)


def shown(name, *layers, extent=None, size=(600, 600)):
    """The layers as QGIS draws them: the colours of the pixels, by how many have them."""
    settings = QgsMapSettings()
    settings.setLayers(layers)
    settings.setDestinationCrs(layers[0].crs())
    settings.setExtent(extent or layers[-1].extent())
    settings.setOutputSize(QSize(*size))
    settings.setBackgroundColor(QColor("white"))
    image = QImage(QSize(*size), QImage.Format_ARGB32)
    image.fill(QColor("white"))
    painter = QPainter(image)
    job = QgsMapRendererCustomPainterJob(settings, painter)
    job.start()
    job.waitForFinished()
    painter.end()
    if PICTURES:
        image.save(f"{PICTURES}/{name}.png")
    counts = {}
    for y in range(0, size[1], 2):
        for x in range(0, size[0], 2):
            colour = image.pixel(x, y) & 0xFFFFFF
            counts[colour] = counts.get(colour, 0) + 1
    return counts


def setUpModule():
    """QGIS is started once: it cannot be started again in one process."""
    if QgsApplication is None:
        raise unittest.SkipTest("no QGIS")
    sys.path += [str(PLUGINS), "/usr/share/qgis/python/plugins"]
    QgsApplication.setPrefixPath("/usr", True)
    application = QgsApplication([], False)
    application.initQgis()
    unittest.addModuleCleanup(application.exitQgis)
    from processing.core.Processing import Processing
    Processing.initialize()
    import tessera_processing
    plugin = tessera_processing.classFactory(None)
    plugin.initProcessing()
    unittest.addModuleCleanup(plugin.unload)


@unittest.skipIf(QgsApplication is None, "no QGIS")
class InQgis(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        shared = cls.enterClassContext(tempfile.TemporaryDirectory())
        cls.ground = cls.run_one("triangulate", FILES=FILES, DIM="2", CLASS="2,9", OUTPUT=f"{shared}/ground")["OUTPUT"]

    def setUp(self):
        self.folder = pathlib.Path(self.enterContext(tempfile.TemporaryDirectory()))

    @staticmethod
    def run_one(name, feedback=None, context=None, **parameters):
        import processing
        return processing.run(f"tessera:{name}", parameters, feedback=feedback or Feedback(), context=context or QgsProcessingContext())

    @staticmethod
    def facts(*words):
        """What the program tells at the end."""
        done = subprocess.run([os.environ["TESSERA"], *words, "--json"], capture_output=True, text=True, check=True)
        return json.loads(done.stdout.splitlines()[-1])

    def assert_fails(self, sentence, name, **parameters):
        with self.assertRaisesRegex(QgsProcessingException, sentence):
            self.run_one(name, **parameters)


class Algorithms(InQgis):
    def test_there_is_one_for_each_task(self):
        found = {one.name() for one in QgsApplication.processingRegistry().providerById("tessera").algorithms()}
        self.assertLessEqual({"triangulate", "dem", "contours", "profile", "voronoi", "alpha", "volume", "surface", "region", "jobs", "watch",
                              "cancel", "resume", "fetch"}, found)

    def test_help_is_that_of_the_program(self):
        from tessera_processing.commands import HIDDEN
        for algorithm in QgsApplication.processingRegistry().providerById("tessera").algorithms():
            told = " ".join(subprocess.run([os.environ["TESSERA"], algorithm.name(), "--help"], capture_output=True, text=True).stdout.split())
            self.assertIn(algorithm.shortDescription(), told)
            options = [one for one in algorithm.command.options if one.name not in HIDDEN]
            self.assertGreater(len(options), 3, algorithm.name())
            for option in options:
                self.assertIn(option.help, told)
                parameter = algorithm.parameterDefinition(option.name.replace("-", "_").upper())
                if parameter is None:
                    self.assertIn(option.name, algorithm.LEFT_OUT, algorithm.name())
                else:
                    self.assertEqual(parameter.help(), option.help)

    def test_a_raster_of_heights_has_its_colours_and_its_system(self):
        path = str(self.folder / "dem.tif")
        self.run_one("dem", RESULT=self.ground, RES=0.5, MAX_EDGE=5, OUTPUT=path)
        layer = QgsRasterLayer(path, "dem")
        self.assertEqual(layer.crs().authid(), LAMBERT)
        self.assertEqual(layer.renderer().type(), "singlebandpseudocolor")
        colours = shown("dem", layer)
        self.assertGreater(len(colours), 1000)
        self.assertEqual(sorted(path.name for path in self.folder.iterdir()), ["dem.qml", "dem.tif"])

    def test_a_hillshade_is_grey(self):
        path = str(self.folder / "shade.tif")
        self.run_one("dem", RESULT=self.ground, RES=0.5, HILLSHADE=True, OUTPUT=path)
        colours = shown("hillshade", QgsRasterLayer(path, "shade"))
        self.assertGreater(len(colours), 50)
        self.assertTrue(all(colour & 255 == colour >> 8 & 255 == colour >> 16 for colour in colours))

    def test_contour_lines_are_drawn_with_index_lines_and_labels(self):
        path = str(self.folder / "lines.gpkg")
        self.run_one("contours", RESULT=self.ground, INTERVAL=0.25, SMOOTH=2, MIN_LENGTH=20, MAX_EDGE=5, OUTPUT=path)
        layer = QgsVectorLayer(path, "lines")
        self.assertGreater(layer.featureCount(), 10)
        self.assertEqual([rule.filterExpression() for rule in layer.renderer().rootRule().children()], ['"index"', "ELSE"])
        self.assertTrue(layer.labelsEnabled())
        self.assertGreater(len(shown("contours", layer)), 2)
        before = shown("contours-without-labels", layer)
        layer.setLabelsEnabled(False)
        self.assertNotEqual(shown("contours-without-labels", layer), before)

    def test_a_profile_has_the_rows_of_the_program_as_points(self):
        line = self.layer("LineString", "LineString(770530 6277510, 770570 6277545)")
        path = str(self.folder / "profile.gpkg")
        self.run_one("profile", RESULT=self.ground, LINE=line, OUTPUT=path)
        layer = QgsVectorLayer(path, "profile")
        table = str(self.folder / "profile.csv")
        self.run_one("profile", RESULT=self.ground, LINE=line, OUTPUT=table)
        rows = pathlib.Path(table).read_text().splitlines()
        self.assertEqual(layer.featureCount(), len(rows) - 1)
        first = next(layer.getFeatures())
        self.assertEqual([float(text) for text in rows[1].split(",")], [first[name] for name in rows[0].split(",")])
        self.assertEqual(first.geometry().constGet().z(), first["z"])
        self.assertEqual(layer.crs().authid(), LAMBERT)
        shown("profile", layer)

    def test_boxes_lines_and_polygons_of_other_systems_are_transformed(self):
        from qgis.core import QgsCoordinateTransform
        there = QgsCoordinateTransform(QgsCoordinateReferenceSystem(LAMBERT), QgsCoordinateReferenceSystem("EPSG:4326"), QgsProject.instance())
        begin, end = there.transform(770530, 6277510), there.transform(770570, 6277545)
        line = self.layer("LineString", f"LineString({begin.x():.12f} {begin.y():.12f}, {end.x():.12f} {end.y():.12f})", "EPSG:4326")
        path = str(self.folder / "profile.gpkg")
        self.run_one("profile", RESULT=self.ground, LINE=line, OUTPUT=path)
        extent = QgsVectorLayer(path, "profile").extent()
        for got, expected in zip((extent.xMinimum(), extent.yMinimum(), extent.xMaximum(), extent.yMaximum()), (770530, 6277510, 770570, 6277545)):
            self.assertAlmostEqual(got, expected, delta=0.01)
        raster = str(self.folder / "part.tif")
        self.run_one("dem", RESULT=self.ground, RES=1, BBOX=f"770520,770540,6277520,6277550 [{LAMBERT}]", OUTPUT=raster)
        extent = QgsRasterLayer(raster, "part").extent()
        self.assertEqual((extent.xMinimum(), extent.yMinimum(), extent.xMaximum(), extent.yMaximum()), (770520, 6277520, 770540, 6277550))

    def layer(self, kind, geometry, system=LAMBERT):
        from qgis.core import QgsFeature, QgsGeometry
        layer = QgsVectorLayer(f"{kind}?crs={system}&field=name:string", "drawn", "memory")
        feature = QgsFeature(layer.fields())
        feature.setAttributes(["one"])
        feature.setGeometry(QgsGeometry.fromWkt(geometry))
        layer.dataProvider().addFeatures([feature])
        layer.updateExtents()
        QgsProject.instance().addMapLayer(layer)
        self.addCleanup(QgsProject.instance().removeMapLayer, layer.id())
        return layer

    def test_voronoi_cells_and_alpha_shapes_are_polygons(self):
        places = self.folder / "places.xyz"
        places.write_text("".join(f"{x} {y}\n" for x in range(5) for y in range(4)))
        cells = str(self.folder / "cells.gpkg")
        self.run_one("voronoi", FILES=[str(places)], CRS=LAMBERT, OUTPUT=cells)
        layer = QgsVectorLayer(cells, "cells")
        self.assertEqual(layer.featureCount(), 20)
        self.assertAlmostEqual(sum(one.geometry().area() for one in layer.getFeatures()), 12)
        shown("voronoi", layer)
        area = str(self.folder / "area.gpkg")
        told = self.run_one("alpha", RESULT=self.ground, ALPHA="2.5", OUTPUT=area)
        layer = QgsVectorLayer(area, "area")
        self.assertEqual((told["RADIUS"], told["POLYGONS"]), (2.5, layer.featureCount()))
        self.assertEqual(layer.renderer().symbol().color().alpha(), 50)
        shown("alpha", layer)

    def test_volumes_are_numbers_a_table_and_a_raster(self):
        within = self.layer("Polygon", "Polygon((770510 6277510, 770550 6277510, 770550 6277550, 770510 6277550, 770510 6277510))")
        table, raster = str(self.folder / "volumes.gpkg"), str(self.folder / "difference.tif")
        told = self.run_one("volume", BEFORE=self.ground, PLANE=21, WITHIN=within, NAME="name", RES=1, OUTPUT=table, DIFFERENCE=raster)
        direct = self.facts("volume", self.ground, "--plane", "21", "--within", self.geojson(within))["rows"][0]
        for name in ("cut", "fill", "net"):
            self.assertAlmostEqual(told[name.upper()], direct[name], delta=1e-6)  # rings may begin elsewhere
        self.assertEqual(next(QgsVectorLayer(table, "volumes").getFeatures())["name"], "one")
        shown("difference", QgsRasterLayer(raster, "difference"))

    def geojson(self, layer):
        path = self.folder / "within.geojson"
        path.write_text(next(layer.getFeatures()).geometry().asJson(17))
        return path

    def test_a_surface_is_loaded_as_a_mesh(self):
        path = str(self.folder / "mesh.ply")
        context, project = QgsProcessingContext(), QgsProject.instance()
        context.setProject(project)
        self.run_one("surface", context=context, FILES=FILES[:1], OUTPUT=path)
        self.assertEqual([details.layerTypeHint for details in context.layersToLoadOnCompletion().values()],
                         [QgsProcessingUtils.LayerHint.Mesh])
        layer = QgsMeshLayer(path, "mesh", "mdal")
        self.assertTrue(layer.isValid())
        layer.setCrs(QgsCoordinateReferenceSystem(LAMBERT))
        self.assertGreater(len(shown("surface", layer)), 100)

    def test_a_region_and_its_triangles(self):
        part = self.run_one("region", FILES=FILES, BBOX=f"770520,770530,6277520,6277530 [{LAMBERT}]", DIM="2", CLASS="2",
                            OUTPUT=str(self.folder / "part"))["OUTPUT"]
        triangles = str(self.folder / "triangles.gpkg")
        self.run_one("export", RESULT=part, OUTPUT=triangles)
        layer = QgsVectorLayer(triangles, "triangles")
        self.assertEqual(layer.featureCount(), self.facts("info", part)["cells"])
        shown("triangles", layer, extent=QgsRectangle(770520, 6277520, 770530, 6277530))

    def test_what_is_wrong_is_the_sentence_of_the_program(self):
        path = str(self.folder / "dem.tif")
        self.assert_fails("Incorrect parameter value for RES", "dem", RESULT=self.ground, OUTPUT=path)
        self.assert_fails("--res: '-1.0' is not a distance, a number above 0", "dem", RESULT=self.ground, RES=-1, OUTPUT=path)
        self.assert_fails("nothing-here", "dem", RESULT="/nothing-here", RES=1, OUTPUT=path)
        self.assert_fails("neither a result folder nor point files", "dem", RES=1, OUTPUT=path)
        self.assert_fails("not both", "dem", RESULT=self.ground, FILES=FILES, RES=1, OUTPUT=path)
        self.assertEqual(list(self.folder.iterdir()), [])

    def test_a_program_that_is_not_there_is_told(self):
        with unittest.mock.patch.dict(os.environ, PATH="/nothing"):
            self.assert_fails("the program 'tessera' is not found. Install Tessera, or name the program in Settings", "dem",
                              RESULT=self.ground, RES=1, OUTPUT=str(self.folder / "dem.tif"))

    def cancel_at_once(self, name, **parameters):
        """Cancels when the program has told of its progress for the first time."""
        feedback = Feedback()
        feedback.progressChanged.connect(lambda share: feedback.cancel() if share > 0 else None)
        with self.assertRaisesRegex(QgsProcessingException, "canceled"):
            self.run_one(name, feedback=feedback, **parameters)
        self.assertTrue(feedback.phases)

    def test_progress_is_that_of_the_program_and_cancelling_leaves_nothing_that_looks_done(self):
        clouds = self.folder / "clouds"
        clouds.mkdir()
        subprocess.run([os.environ["TESSERA"], "generate", "terrain", "-n", "1M", "-o", clouds / "cloud.npy", "--quiet"], check=True)
        files = [str(clouds / "cloud.npy")]
        self.cancel_at_once("dem", FILES=files, RES=0.01, OUTPUT=str(self.folder / "dem.tif"))
        self.assertEqual([path.name for path in self.folder.iterdir()], ["clouds"])
        out = str(self.folder / "out")
        self.cancel_at_once("triangulate", FILES=files, OUTPUT=out)
        self.assertFalse((self.folder / "out/manifest.json").exists())
        # A triangulation that was cancelled can be continued.
        self.run_one("triangulate", FILES=files, RESUME=True, OUTPUT=out)
        self.assertEqual(self.facts("info", out)["points"], 1_000_000)


class Models(InQgis):
    def test_a_model_goes_from_points_to_a_raster_and_lines(self):
        model = QgsProcessingModelAlgorithm("points to maps", "tests")
        files = QgsProcessingModelParameter("files")
        model.addModelParameter(QgsProcessingParameterMultipleLayers("files", "Point files", QgsProcessing.TypeFile), files)
        source = QgsProcessingModelChildParameterSource
        ground = self.child("tessera:triangulate", "ground", FILES=[source.fromModelParameter("files")], DIM=[source.fromStaticValue("2")],
                            CLASS=[source.fromStaticValue("2")])
        model.addChildAlgorithm(ground)
        for name, option, value in (("dem", "RES", 1), ("contours", "INTERVAL", 0.5)):
            child = self.child(f"tessera:{name}", name, RESULT=[source.fromChildOutput("ground", "OUTPUT")], **{option: [source.fromStaticValue(value)]})
            output = QgsProcessingModelOutput(name)
            output.setChildId(name)
            output.setChildOutputName("OUTPUT")
            child.setModelOutputs({name: output})
            model.addChildAlgorithm(child)
        self.assertTrue(model.toFile(str(self.folder / "maps.model3")))
        again = QgsProcessingModelAlgorithm()
        self.assertTrue(again.fromFile(str(self.folder / "maps.model3")))
        import processing
        processing.run(again, {"files": FILES, "dem:dem": str(self.folder / "dem.tif"), "contours:contours": str(self.folder / "lines.gpkg")})
        raster = QgsRasterLayer(str(self.folder / "dem.tif"), "dem")  # its renderer lives as long
        self.assertEqual(raster.renderer().type(), "singlebandpseudocolor")
        self.assertGreater(QgsVectorLayer(str(self.folder / "lines.gpkg"), "lines").featureCount(), 0)

    @staticmethod
    def child(algorithm, name, **sources):
        child = QgsProcessingModelChildAlgorithm(algorithm)
        child.setChildId(name)
        child.setDescription(name)
        for key, value in sources.items():
            child.addParameterSources(key, value)
        return child


@unittest.skipIf(PROCESS is None, "no qgis_process")
class OnTheCommandLine(unittest.TestCase):
    def test_qgis_process_runs_it(self):
        with tempfile.TemporaryDirectory() as folder:
            def process(*words):
                return subprocess.run([PROCESS, *words], env=ENVIRONMENT, capture_output=True, text=True)
            self.assertEqual(process("plugins", "enable", "tessera_processing").returncode, 0)
            done = process("--json", "run", "tessera:dem", "--", f"FILES={FILES[0]}", "CLASS=2", "RES=1", f"OUTPUT={folder}/dem.tif")
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertEqual(json.loads(done.stdout)["results"]["OUTPUT"], f"{folder}/dem.tif")
            self.assertTrue(pathlib.Path(folder, "dem.qml").exists())
            done = process("run", "tessera:dem", "--", f"FILES={FILES[0]}", "RES=-1", f"OUTPUT={folder}/no.tif")
            self.assertEqual(done.returncode, 1)
            self.assertIn("'-1.0' is not a distance", done.stdout + done.stderr)


if __name__ == "__main__":
    unittest.main()
