#!/usr/bin/python3
"""Draws a surface of Tessera that was written as a folder of .vtu files, its tiles in distinct colours.

    draw_surface.py FOLDER PICTURE.png [--size 1400x840] [--from AZIMUTH,ELEVATION] [--zoom 1.5]

Needs Debian's python3-vtk9 and python3-numpy; without a display, run it under xvfb-run.
"""
import argparse
import colorsys
import pathlib

import numpy as np
import vtk


def read_tile(path):
    reader = vtk.vtkXMLUnstructuredGridReader()
    reader.SetFileName(str(path))
    reader.Update()
    return reader.GetOutput()


def actor_of(grid, corner, colour):
    """Around the corner: graphics hardware keeps 32 bits of coordinates."""
    shift = vtk.vtkTransform()
    shift.Translate(*(-c for c in corner))
    moved = vtk.vtkTransformFilter()
    moved.SetTransform(shift)
    moved.SetInputData(grid)
    facets = vtk.vtkDataSetSurfaceFilter()
    facets.SetInputConnection(moved.GetOutputPort())
    mapper = vtk.vtkPolyDataMapper()
    mapper.SetInputConnection(facets.GetOutputPort())
    mapper.ScalarVisibilityOff()
    actor = vtk.vtkActor()
    actor.SetMapper(mapper)
    look = actor.GetProperty()
    look.SetColor(*colour)
    look.SetInterpolationToFlat()
    look.SetAmbient(0.25)
    look.SetDiffuse(0.8)
    return actor


def colours(n):
    return [colorsys.hsv_to_rgb((0.61803 * i) % 1, 0.35 + 0.15 * (i % 2), 0.95 - 0.15 * (i % 3 == 2)) for i in range(n)]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=pathlib.Path, help="a folder of .vtu files, from tessera surface --format vtu")
    parser.add_argument("picture", type=pathlib.Path, help="the PNG file to write")
    parser.add_argument("--size", default="1400x840", help="width and height in pixels; default: 1400x840")
    parser.add_argument("--from", dest="view", default="25,35", metavar="AZIMUTH,ELEVATION",
                        help="where the camera stands, in degrees; default: 25,35")
    parser.add_argument("--zoom", type=float, default=1.5, help="a larger number shows the surface larger; default: 1.5")
    arguments = parser.parse_args()
    grids = [read_tile(path) for path in sorted(arguments.folder.glob("*.vtu"))]
    if not grids:
        raise SystemExit(f"{arguments.folder}: has no .vtu files")
    bounds = np.array([grid.GetBounds() for grid in grids])
    corner = bounds[:, 0::2].min(axis=0)
    renderer = vtk.vtkRenderer()
    renderer.SetBackground(1, 1, 1)
    for grid, colour in zip(grids, colours(len(grids))):
        renderer.AddActor(actor_of(grid, corner, colour))
    window = vtk.vtkRenderWindow()
    window.SetOffScreenRendering(1)
    window.SetSize(*map(int, arguments.size.split("x")))
    window.AddRenderer(renderer)
    azimuth, elevation = map(float, arguments.view.split(","))
    camera = renderer.GetActiveCamera()
    camera.SetPosition(0, -1, 0)
    camera.SetFocalPoint(0, 0, 0)
    camera.SetViewUp(0, 0, 1)
    camera.Azimuth(azimuth)
    camera.Elevation(elevation)
    renderer.ResetCamera()
    camera.Zoom(arguments.zoom)
    renderer.ResetCameraClippingRange()
    window.Render()
    image = vtk.vtkWindowToImageFilter()
    image.SetInput(window)
    image.Update()
    writer = vtk.vtkPNGWriter()
    writer.SetFileName(str(arguments.picture))
    writer.SetInputConnection(image.GetOutputPort())
    writer.Write()


if __name__ == "__main__":
    main()
