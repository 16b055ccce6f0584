#!/usr/bin/python3
"""Draws what the plugin gives in QGIS: its algorithms in the toolbox, a dialog, and a map of results with their styles.

    QT_QPA_PLATFORM=offscreen scripts/draw_qgis.py PLUGIN_ZIP POINT_FILES... PICTURE.png

It needs QGIS (./tessera.sh deps qgis), and the program tessera on the PATH. Beside results QGIS finds their styles: no colour is
chosen here.
"""
import pathlib
import sys
import tempfile
import zipfile

from qgis.core import QgsApplication, QgsMapRendererCustomPainterJob, QgsMapSettings, QgsRasterLayer, QgsVectorLayer
from qgis.gui import QgsProcessingToolboxProxyModel, QgsProcessingToolboxTreeView
from qgis.PyQt.QtCore import QSize, Qt
from qgis.PyQt.QtGui import QColor, QImage, QPainter

HEIGHT, MAP, WIDTH = 560, 480, 1000


def load_plugin(archive, folder):
    with zipfile.ZipFile(archive) as zipped:
        zipped.extractall(folder)
    sys.path += [folder, "/usr/share/qgis/python/plugins"]
    from processing.core.Processing import Processing
    Processing.initialize()
    import tessera_processing
    plugin = tessera_processing.classFactory(None)
    plugin.initProcessing()
    return plugin


def toolbox():
    """The tree of algorithms, with those of the plugin."""
    tree = QgsProcessingToolboxTreeView(None, QgsApplication.processingRegistry())
    tree.setToolboxProxyModel(QgsProcessingToolboxProxyModel(tree, QgsApplication.processingRegistry()))
    tree.setFilterString("tessera")
    tree.expandAll()
    tree.resize(330, HEIGHT)
    return tree.grab().toImage()


def dialog(name):
    from processing.gui.AlgorithmDialog import AlgorithmDialog
    shown = AlgorithmDialog(QgsApplication.processingRegistry().createAlgorithmById(name))
    shown.resize(690, HEIGHT)
    return shown.grab().toImage()


def map_of(files, folder):
    import processing
    ground = processing.run("tessera:triangulate", {"FILES": files, "DIM": "2", "CLASS": "2,9", "OUTPUT": f"{folder}/ground"})["OUTPUT"]
    for name, more in (("dem", {"RES": 0.25, "MAX_EDGE": 5}), ("contours", {"INTERVAL": 0.25, "MAX_EDGE": 5, "SMOOTH": 1, "MIN_LENGTH": 10})):
        processing.run(f"tessera:{name}", {"RESULT": ground, **more, "OUTPUT": f"{folder}/{name}.{'tif' if name == 'dem' else 'gpkg'}"})
    layers = [QgsVectorLayer(f"{folder}/contours.gpkg", "contours"), QgsRasterLayer(f"{folder}/dem.tif", "dem")]
    settings = QgsMapSettings()
    settings.setLayers(layers)
    settings.setDestinationCrs(layers[1].crs())
    settings.setExtent(layers[1].extent())
    settings.setOutputSize(QSize(MAP, HEIGHT))
    settings.setBackgroundColor(QColor("white"))
    image = QImage(QSize(MAP, HEIGHT), QImage.Format_ARGB32)
    image.fill(QColor("white"))
    painter = QPainter(image)
    job = QgsMapRendererCustomPainterJob(settings, painter)
    job.start()
    job.waitForFinished()
    painter.end()
    return image


def main(archive, *files, picture):
    QgsApplication.setPrefixPath("/usr", True)
    application = QgsApplication([], True)
    application.initQgis()
    with tempfile.TemporaryDirectory() as folder:
        plugin = load_plugin(archive, folder)
        parts = [toolbox(), dialog("tessera:contours"), map_of([str(pathlib.Path(file).resolve()) for file in files], folder)]
        whole = QImage(sum(part.width() for part in parts), HEIGHT, QImage.Format_RGB32)
        whole.fill(QColor("white"))
        painter, x = QPainter(whole), 0
        for part in parts:
            painter.drawImage(x, 0, part)
            x += part.width()
        painter.end()
        whole.scaledToWidth(WIDTH, Qt.SmoothTransformation).convertToFormat(QImage.Format_Indexed8).save(picture)
        plugin.unload()


if __name__ == "__main__":
    if len(sys.argv) < 4:
        sys.exit(__doc__)
    main(*sys.argv[1:-1], picture=sys.argv[-1])
