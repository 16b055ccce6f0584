"""What QGIS loads and unloads: the provider of algorithms is all that there is."""
from qgis.core import QgsApplication

from .provider import TesseraProvider


class TesseraPlugin:
    def __init__(self):
        self.provider = None

    def initProcessing(self):  # also called by qgis_process
        self.provider = TesseraProvider()
        QgsApplication.processingRegistry().addProvider(self.provider)

    def initGui(self):
        self.initProcessing()

    def unload(self):
        QgsApplication.processingRegistry().removeProvider(self.provider)
