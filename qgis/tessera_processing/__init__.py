"""Tessera in the toolbox of QGIS: exact Delaunay triangulations of point clouds, and what is made of them."""


def classFactory(iface):  # the name is QGIS's
    from .plugin import TesseraPlugin

    return TesseraPlugin()
