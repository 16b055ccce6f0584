#!/usr/bin/python3
"""Draws a map of an exported TIN, as a GIS shows it: triangles by height, lit from the north-west, or by their tile.

    draw_map.py TIN.gpkg PICTURE.png [--box xmin,ymin,xmax,ymax] [--by height|tile] [--edges] [--size 540x540]

Needs Debian's python3-gdal, python3-vtk9 and python3-numpy; without a display, run it under xvfb-run.
"""
import argparse
import colorsys
import pathlib

import numpy as np
import vtk
from osgeo import ogr
from vtk.util.numpy_support import numpy_to_vtk, numpy_to_vtkIdTypeArray

# Height to colour, as on maps: green below, over yellow and brown, to white.
PALETTE = [(0.0, (0.36, 0.58, 0.38)), (0.35, (0.80, 0.83, 0.56)), (0.7, (0.74, 0.58, 0.41)), (1.0, (0.97, 0.96, 0.94))]


def read_triangles(path, box):
    """Corners (n x 3 x 3) and tile (n) of the triangles in the box."""
    dataset = ogr.Open(str(path))
    layer = dataset.GetLayer(0)
    if box:
        layer.SetSpatialFilterRect(*box)
    corners, tiles = [], []
    for feature in layer:
        ring = feature.GetGeometryRef().GetGeometryRef(0)
        corners.append([ring.GetPoint(i) for i in range(3)])
        tiles.append(feature.GetField("tile"))
    if not corners:
        raise SystemExit(f"{path}: has no triangles")
    return np.array(corners), np.array(tiles)


def colours(corners, tiles, by):
    """One colour a triangle, 0..255."""
    if by == "tile":
        table = np.array([colorsys.hsv_to_rgb((0.58 + t * 0.61803) % 1, 0.45, 0.95) for t in range(int(tiles.max()) + 1)])
        return (255 * table[tiles]).astype(np.uint8)
    height = corners[:, :, 2].mean(axis=1)
    low, high = np.percentile(height, [1, 99])
    part = np.clip((height - low) / max(high - low, 1e-9), 0, 1)
    stops = [at for at, _ in PALETTE]
    rgb = np.column_stack([np.interp(part, stops, [colour[i] for _, colour in PALETTE]) for i in range(3)])
    sides = corners[:, 1:] - corners[:, :1]
    normal = np.cross(sides[:, 0], sides[:, 1])
    normal /= np.maximum(np.linalg.norm(normal, axis=1), 1e-300)[:, None]
    light = np.array([-1, 1, 1.6]) / np.linalg.norm([-1, 1, 1.6])
    shade = 0.45 + 0.65 * np.clip(normal @ light, 0, 1)
    return (255 * np.clip(rgb * shade[:, None], 0, 1)).astype(np.uint8)


def draw(path, picture, box, by, edges, size):
    corners, tiles = read_triangles(path, box)
    rgb = colours(corners, tiles, by)
    low, high = corners[:, :, :2].min(axis=(0, 1)), corners[:, :, :2].max(axis=(0, 1))
    if box:
        low, high = np.array(box[:2]), np.array(box[2:])
    flat = np.zeros((3 * len(corners), 3))
    flat[:, :2] = corners[:, :, :2].reshape(-1, 2) - (low + high) / 2

    points = vtk.vtkPoints()
    points.SetData(numpy_to_vtk(flat, deep=True))
    cells = vtk.vtkCellArray()
    cells.SetData(numpy_to_vtkIdTypeArray(np.arange(0, len(flat) + 1, 3), deep=True),
                  numpy_to_vtkIdTypeArray(np.arange(len(flat)), deep=True))
    mesh = vtk.vtkPolyData()
    mesh.SetPoints(points)
    mesh.SetPolys(cells)
    mesh.GetCellData().SetScalars(numpy_to_vtk(rgb, deep=True))
    mapper = vtk.vtkPolyDataMapper()
    mapper.SetInputData(mesh)
    actor = vtk.vtkActor()
    actor.SetMapper(mapper)
    actor.GetProperty().LightingOff()
    if edges:
        actor.GetProperty().EdgeVisibilityOn()
        actor.GetProperty().SetEdgeColor(0.25, 0.25, 0.3)
    renderer = vtk.vtkRenderer()
    renderer.SetBackground(1, 1, 1)
    renderer.AddActor(actor)
    camera = renderer.GetActiveCamera()
    camera.ParallelProjectionOn()
    camera.SetPosition(0, 0, 10)
    camera.SetParallelScale(max((high - low)[1], (high - low)[0] * size[1] / size[0]) / 2)
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
    writer = vtk.vtkPNGWriter()
    writer.SetFileName(str(picture))
    writer.SetInputConnection(grab.GetOutputPort())
    writer.SetCompressionLevel(9)
    writer.Write()


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("tin", type=pathlib.Path, help="the triangles: a .gpkg file of tessera export")
    parser.add_argument("picture", type=pathlib.Path, help="the PNG file to write")
    parser.add_argument("--box", type=lambda text: [float(part) for part in text.split(",")], metavar="xmin,ymin,xmax,ymax",
                        help="the part to draw; default: all")
    parser.add_argument("--by", choices=["height", "tile"], default="height", help="what the colours show; default: height")
    parser.add_argument("--edges", action="store_true", help="also draw the edges of triangles")
    parser.add_argument("--size", type=lambda text: tuple(map(int, text.split("x"))), default=(540, 540),
                        metavar="WIDTHxHEIGHT", help="in pixels; default: 540x540")
    options = parser.parse_args()
    draw(options.tin, options.picture, options.box, options.by, options.edges, options.size)


if __name__ == "__main__":
    main()
