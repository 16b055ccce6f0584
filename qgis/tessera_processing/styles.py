"""How results look: each style is written beside its file as .qml, where QGIS finds it whenever it loads the file."""
import pathlib

from qgis.core import (QgsBilinearRasterResampler, QgsColorRampShader, QgsFillSymbol, QgsLineSymbol, QgsMapLayer,
                       QgsMarkerSymbol, QgsMeshLayer, QgsPalLayerSettings, QgsRasterBandStats, QgsRasterLayer, QgsRasterShader,
                       QgsRuleBasedRenderer, QgsSingleBandGrayRenderer,
                       QgsContrastEnhancement, QgsSingleBandPseudoColorRenderer, QgsSingleSymbolRenderer,
                       QgsTextBufferSettings, QgsTextFormat, QgsVectorLayer, QgsVectorLayerSimpleLabeling)
from qgis.PyQt.QtGui import QColor

HEIGHTS = [(0.0, "#2c7a58"), (0.25, "#9dbf7a"), (0.5, "#f0e2a8"), (0.75, "#c38d5b"), (1.0, "#f7f4f0")]
CHANGE = [(0.0, "#b2182b"), (0.5, "#f7f7f7"), (1.0, "#2166ac")]


def ramp_of(low, high, colours):
    ramp = QgsColorRampShader(low, high)
    ramp.setColorRampType(QgsColorRampShader.Interpolated)
    ramp.setColorRampItemList([QgsColorRampShader.ColorRampItem(low + (high - low) * share, QColor(colour),
                                                                f"{low + (high - low) * share:.6g}") for share, colour in colours])
    return ramp


def shader_of(low, high, colours):
    shader = QgsRasterShader(low, high)
    shader.setRasterShaderFunction(ramp_of(low, high, colours))
    return shader


def range_of(layer):
    found = layer.dataProvider().bandStatistics(1, QgsRasterBandStats.Min | QgsRasterBandStats.Max)
    return found.minimumValue, max(found.maximumValue, found.minimumValue + 1e-9)


def smooth(layer):
    layer.resampleFilter().setZoomedInResampler(QgsBilinearRasterResampler())


def heights(layer):
    layer.setRenderer(QgsSingleBandPseudoColorRenderer(layer.dataProvider(), 1, shader_of(*range_of(layer), HEIGHTS)))
    smooth(layer)


def change(layer):
    """Of A - B: red where A lies lower, blue where A lies higher, white where they are equal."""
    most = max(map(abs, range_of(layer)))
    layer.setRenderer(QgsSingleBandPseudoColorRenderer(layer.dataProvider(), 1, shader_of(-most, most, CHANGE)))


def hillshade(layer):
    renderer = QgsSingleBandGrayRenderer(layer.dataProvider(), 1)
    stretch = QgsContrastEnhancement(layer.dataProvider().dataType(1))
    stretch.setMinimumValue(0)
    stretch.setMaximumValue(255)
    stretch.setContrastEnhancementAlgorithm(QgsContrastEnhancement.StretchToMinimumMaximum)
    renderer.setContrastEnhancement(stretch)
    layer.setRenderer(renderer)
    smooth(layer)


def contours(layer):
    root = QgsRuleBasedRenderer.Rule(None)
    for label, rule, width in (("index line", '"index"', "0.5"), ("line", 'ELSE', "0.2")):
        symbol = QgsLineSymbol.createSimple({"color": "#8a5a2b", "width": width, "joinstyle": "round", "capstyle": "round"})
        child = QgsRuleBasedRenderer.Rule(symbol, 0, 0, rule, label)
        root.appendChild(child)
    layer.setRenderer(QgsRuleBasedRenderer(root))
    settings = QgsPalLayerSettings()
    settings.fieldName = 'if("index", "elevation", null)'
    settings.isExpression = True
    settings.placement = QgsPalLayerSettings.Line
    settings.placementFlags = QgsPalLayerSettings.OnLine
    settings.setFormat(text_format("#6b431d"))
    layer.setLabeling(QgsVectorLayerSimpleLabeling(settings))
    layer.setLabelsEnabled(True)


def text_format(colour):
    text, halo = QgsTextFormat(), QgsTextBufferSettings()
    text.setColor(QColor(colour))
    text.setSize(7)
    halo.setEnabled(True)
    halo.setSize(0.7)
    text.setBuffer(halo)
    return text


def polygons(layer):
    layer.setRenderer(QgsSingleSymbolRenderer(QgsFillSymbol.createSimple(
        {"color": "31,111,139,50", "outline_color": "#1f6f8b", "outline_width": "0.4"})))


def cells(layer):
    layer.setRenderer(QgsSingleSymbolRenderer(QgsFillSymbol.createSimple(
        {"color": "255,255,255,0", "outline_color": "#44617b", "outline_width": "0.1"})))


def profile(layer):
    layer.setRenderer(QgsSingleSymbolRenderer(QgsMarkerSymbol.createSimple(
        {"name": "circle", "color": "#c0392b", "size": "1.2", "outline_style": "no"})))


def mesh(layer):
    """The surface by height, without the edges of its triangles."""
    settings = layer.rendererSettings()
    edges = settings.nativeMeshSettings()
    edges.setEnabled(False)
    settings.setNativeMeshSettings(edges)
    groups = layer.dataProvider().datasetGroupCount()
    if groups:
        found = layer.dataProvider().datasetGroupMetadata(0)
        low, high = found.minimum(), max(found.maximum(), found.minimum() + 1e-9)
        scalar = settings.scalarSettings(0)
        scalar.setClassificationMinimumMaximum(low, high)
        scalar.setColorRampShader(ramp_of(low, high, HEIGHTS))
        settings.setScalarSettings(0, scalar)
        settings.setActiveScalarDatasetGroup(0)
    layer.setRendererSettings(settings)


def layer_of(path, style):
    if style in (heights, hillshade, change):
        return QgsRasterLayer(path, "result")
    if style is mesh:
        return QgsMeshLayer(path, "result", "mdal")
    return QgsVectorLayer(path, "result", "ogr")


def write_beside(path, style):
    """Writes the style beside the file. Returns what is wrong, or "" when nothing is."""
    layer = layer_of(path, style)
    if not layer.isValid():
        return f"{path}: QGIS cannot load it, so that it gets no style"
    style(layer)
    target = str(path).rsplit(".", 1)[0] + ".qml"
    message, is_written = layer.saveNamedStyle(target, QgsMapLayer.Symbology | QgsMapLayer.Labeling | QgsMapLayer.Rendering)
    del layer  # closes the file
    # QGIS has left statistics beside a raster, or did so for the raster that this one replaces. They would go stale.
    pathlib.Path(f"{path}.aux.xml").unlink(missing_ok=True)
    return "" if is_written else f"{target}: cannot be written: {message}"
