"""Draws the pictures of docs/paraview.md with ParaView itself. Run it with pvpython of ParaView 5.10 or newer:

    pvpython --force-offscreen-rendering scripts/paraview_pictures.py RESULT_3D RESULT_2D FOLDER

RESULT_3D with the attribute classification, RESULT_2D with heights: docs/tutorial.md makes both of the bundled block.
"""
import colorsys
import pathlib
import sys

from paraview.simple import (Clip, ColorBy, CreateView, Delete, GetColorTransferFunction, ResetCamera, SaveScreenshot, Show,
                             Threshold, WarpByScalar, XMLPartitionedUnstructuredGridReader)

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
from paraview_longest_edge import add_longest_edge, without_long_cells  # noqa: E402

SIZE = [520, 290]


def open_result(folder):
    reader = XMLPartitionedUnstructuredGridReader(FileName=[str(pathlib.Path(folder) / "triangulation.pvtu")])
    reader.UpdatePipeline()
    return reader


def distinct_colours(array, values):
    """One colour a value, neighbours in number far apart."""
    colours = GetColorTransferFunction(array)
    colours.InterpretValuesAsCategories = 1
    colours.AnnotationsInitialized = 1
    colours.Annotations = [text for value in values for text in (str(value), str(value))]
    colours.IndexedColors = [part for value in values
                             for part in colorsys.hsv_to_rgb((0.58 + value * 0.61803) % 1, 0.45, 0.95)]


def picture(source, path, colour_by, edges=False, direction=(-0.5, -1.0, 0.7), zoom=1.6):
    view = CreateView("RenderView")
    view.ViewSize = SIZE
    view.UseColorPaletteForBackground = 0
    view.Background = [1, 1, 1]
    view.OrientationAxesVisibility = 0
    shown = Show(source, view)
    shown.Representation = "Surface With Edges" if edges else "Surface"
    shown.EdgeColor = [0.35, 0.35, 0.4]
    shown.LineWidth = 0.4
    shown.Ambient = 0.25
    ColorBy(shown, colour_by)
    view.CameraPosition = direction
    view.CameraFocalPoint = [0, 0, 0]
    view.CameraViewUp = [0, 0, 1]
    ResetCamera(view)
    view.CameraParallelProjection = 1
    view.CameraParallelScale /= zoom
    SaveScreenshot(str(path), view, ImageResolution=SIZE, CompressionLevel="9")
    Delete(view)


def main():
    if len(sys.argv) != 4:
        sys.exit(__doc__)
    solid, terrain = open_result(sys.argv[1]), open_result(sys.argv[2])
    folder = pathlib.Path(sys.argv[3])
    folder.mkdir(parents=True, exist_ok=True)
    low, high = solid.CellData["tile"].GetRange()
    distinct_colours("tile", range(int(low), int(high) + 1))
    tile = ("CELLS", "tile")
    picture(solid, folder / "whole.png", tile)

    cut = Clip(Input=solid, ClipType="Plane", Invert=0)
    x0, x1, y0, y1, z0, z1 = solid.GetDataInformation().GetBounds()
    cut.ClipType.Origin = [(x0 + x1) / 2, (y0 + y1) / 2, (z0 + z1) / 2]
    cut.ClipType.Normal = [0, 1, 0]
    picture(cut, folder / "clip.png", tile, edges=True, direction=(-0.1, -1.0, 0.3), zoom=2)

    scene = without_long_cells(add_longest_edge(solid), 1.5)
    scene.UpdatePipeline()
    lowest, highest = scene.PointData["classification"].GetRange()
    distinct_colours("classification", range(int(lowest), int(highest) + 1))
    picture(scene, folder / "short-cells.png", ("POINTS", "classification"), zoom=1.75)

    some = Threshold(Input=scene, Scalars=["CELLS", "tile"])
    some.ThresholdMethod = "Between"
    some.LowerThreshold, some.UpperThreshold = 3, 7
    picture(some, folder / "tiles.png", tile)

    raised = WarpByScalar(Input=terrain, Scalars=["POINTS", "z"], ScaleFactor=4, Normal=[0, 0, 1])
    picture(raised, folder / "terrain.png", ("POINTS", "z"))


if __name__ == "__main__":
    main()
