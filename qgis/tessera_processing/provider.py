"""All algorithms, under the name Tessera."""
from qgis.core import QgsProcessingProvider

from . import settings
from .algorithm import ICON
from .daemon import DAEMON
from .products import PRODUCTS


class TesseraProvider(QgsProcessingProvider):
    def id(self):
        return "tessera"

    def name(self):
        return "Tessera"

    def longName(self):
        return "Tessera (exact Delaunay triangulations of point clouds)"

    def icon(self):
        return ICON

    def load(self):
        settings.add(self.name(), ICON)
        self.refreshAlgorithms()
        return True

    def unload(self):
        settings.remove()

    def loadAlgorithms(self):
        for algorithm in (*PRODUCTS, *DAEMON):
            self.addAlgorithm(algorithm())

    def supportedOutputRasterLayerExtensions(self):
        return ["tif"]

    def supportedOutputVectorLayerExtensions(self):
        return ["gpkg", "geojson", "fgb", "csv"]

    def defaultRasterFileExtension(self):
        return "tif"

    def defaultVectorFileExtension(self, hasGeometry=True):
        return "gpkg"
