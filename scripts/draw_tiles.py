#!/usr/bin/python3
"""Draws a 3D result of Tessera: its tiles in distinct colours, moved apart, cut open by a plane.

    draw_tiles.py OUT_FOLDER PICTURE.png [--size 1400x840] [--apart 0.12] [--longest METRES]

Cells with an edge above --longest are left out: they span the air between the last echoes and the convex hull, and would
hide everything. Default: 2 % of the cloud's diagonal; 0 keeps all.
Needs Debian's python3-vtk9 and python3-numpy; without a display, run it under xvfb-run.
"""
import argparse
import colorsys
import pathlib

import numpy as np
import vtk
from vtk.util.numpy_support import numpy_to_vtk, numpy_to_vtkIdTypeArray, vtk_to_numpy


def read_result(folder):
    """points (n x 3), cells (m x 4), tile of each cell: main cells only."""
    reader = vtk.vtkXMLPUnstructuredGridReader()
    reader.SetFileName(str(folder / "triangulation.pvtu"))
    reader.Update()
    grid = reader.GetOutput()
    points = vtk_to_numpy(grid.GetPoints().GetData())
    cells = vtk_to_numpy(grid.GetCells().GetConnectivityArray())
    if grid.GetCellType(0) != vtk.VTK_TETRA:
        raise SystemExit(f"{folder}: is not a 3D result")
    tiles = vtk_to_numpy(grid.GetCellData().GetArray("tile"))
    main = vtk_to_numpy(grid.GetCellData().GetArray("vtkGhostType")) == 0
    return points, cells.reshape(-1, 4)[main], tiles[main]


def longest_edges(points, cells):
    longest = np.zeros(len(cells))
    for i in range(4):
        for j in range(i):
            edge = points[cells[:, i]] - points[cells[:, j]]
            longest = np.maximum(longest, np.sqrt((edge * edge).sum(axis=1)))
    return longest


def surface(points, cells):
    """The facets of these cells that bound them, as a vtkPolyData."""
    grid = vtk.vtkUnstructuredGrid()
    used, corners = np.unique(cells, return_inverse=True)
    vtk_points = vtk.vtkPoints()
    vtk_points.SetData(numpy_to_vtk(np.ascontiguousarray(points[used]), deep=True))
    grid.SetPoints(vtk_points)
    offsets = np.arange(0, 4 * len(cells) + 1, 4, dtype=np.int64)
    array = vtk.vtkCellArray()
    array.SetData(numpy_to_vtkIdTypeArray(offsets, deep=True),
                  numpy_to_vtkIdTypeArray(corners.astype(np.int64).reshape(-1), deep=True))
    grid.SetCells(vtk.VTK_TETRA, array)
    facets = vtk.vtkDataSetSurfaceFilter()
    facets.SetInputData(grid)
    facets.Update()
    return facets.GetOutput()


def colour(tile, tiles):
    """Hues in steps of the golden ratio: neighbours in number differ most."""
    return colorsys.hsv_to_rgb((0.58 + tile * 0.61803) % 1, 0.42 + 0.10 * (tile % 3), 0.98 - 0.08 * (tile % 2))


def draw(folder, picture, size, apart, longest):
    points, cells, tiles = read_result(folder)
    low, high = points.min(axis=0), points.max(axis=0)
    points = points - (low + high) / 2
    diagonal = np.linalg.norm(high - low)
    if longest is None:
        longest = 0.02 * diagonal
    if longest > 0:
        keep = longest_edges(points, cells) <= longest
        cells, tiles = cells[keep], tiles[keep]

    renderer = vtk.vtkRenderer()
    renderer.SetBackground(1, 1, 1)
    numbers = np.unique(tiles)
    for tile in numbers:
        own = cells[tiles == tile]
        mapper = vtk.vtkPolyDataMapper()
        mapper.SetInputData(surface(points, own))
        actor = vtk.vtkActor()
        actor.SetMapper(mapper)
        looks = actor.GetProperty()
        looks.SetColor(colour(int(tile), len(numbers)))
        looks.SetInterpolationToFlat()
        looks.SetAmbient(0.42)
        looks.SetDiffuse(0.68)
        looks.EdgeVisibilityOn()
        looks.SetEdgeColor(*[0.72 * c for c in looks.GetColor()])
        looks.SetLineWidth(0.4)
        actor.SetPosition(*(apart * points[own].mean(axis=(0, 1)) * (1, 1, 0)))
        renderer.AddActor(actor)

    camera = renderer.GetActiveCamera()
    camera.SetPosition(-0.5, -1.0, 0.85)
    camera.SetFocalPoint(0, 0, 0)
    camera.SetViewUp(0, 0, 1)
    renderer.ResetCamera()
    camera.SetViewAngle(18)
    renderer.ResetCamera()
    camera.Zoom(1.42)
    camera.SetWindowCenter(-0.03, -0.12)
    renderer.ResetCameraClippingRange()
    window = vtk.vtkRenderWindow()
    window.SetOffScreenRendering(1)
    window.SetMultiSamples(8)
    window.SetSize(*size)
    window.AddRenderer(renderer)
    window.Render()
    grab = vtk.vtkWindowToImageFilter()
    grab.SetInput(window)
    grab.ReadFrontBufferOff()
    grab.Update()
    writer = vtk.vtkPNGWriter()
    writer.SetFileName(str(picture))
    writer.SetInputConnection(grab.GetOutputPort())
    writer.SetCompressionLevel(9)
    writer.Write()


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=pathlib.Path, help="a 3D result folder")
    parser.add_argument("picture", type=pathlib.Path, help="the PNG file to write")
    parser.add_argument("--size", default="1400x840", help="width and height in pixels; default: 1400x840")
    parser.add_argument("--apart", type=float, default=0.12, help="how far tiles are moved apart; default: 0.12; 0: not at all")
    parser.add_argument("--longest", type=float,
                        help="leave out cells with a longer edge; default: 2 %% of the cloud's diagonal; 0 keeps all")
    options = parser.parse_args()
    width, height = map(int, options.size.split("x"))
    draw(options.folder, options.picture, (width, height), options.apart, options.longest)


if __name__ == "__main__":
    main()
