"""A result opens in VTK as it is: read_result.py WRITER DIMENSION."""
import json
import os
import subprocess
import sys
import tempfile

import numpy as np
import vtk
from tile_arrays import read_tile
from vtk.util.numpy_support import vtk_to_numpy

ODD_NAME = '50 % of "<it>"'


def read_grid(path):
    reader = vtk.vtkXMLPUnstructuredGridReader() if path.endswith("pvtu") else vtk.vtkXMLUnstructuredGridReader()
    assert reader.CanReadFile(path), path
    failures = []
    reader.AddObserver("ErrorEvent", lambda *_: failures.append(path))
    reader.SetFileName(path)
    reader.Update()
    assert not failures, failures
    return reader.GetOutput()


def array(data, name):
    return vtk_to_numpy(data.GetArray(name))


def volumes(points, cells):
    corner = points[cells]
    edges = corner[:, 1:, :] - corner[:, :1, :]
    if cells.shape[1] == 3:
        return (edges[:, 0, 0] * edges[:, 1, 1] - edges[:, 0, 1] * edges[:, 1, 0]) / 2
    return np.linalg.det(edges) / 6


def check_tile(path, entry, dimension):
    """Its points, which are its own, and the volume of its main cells."""
    corners = dimension + 1
    arrays = read_tile(path)
    kinds = {name: values.dtype.name for name, values in arrays.items()}
    assert kinds == {
        "Points": "float64", "PointData/id": "uint64", "PointData/owner": "uint32", "PointData/vtkGhostType": "uint8",
        "PointData/intensity": "uint16", "PointData/gps_time": "float64", "PointData/" + ODD_NAME: "uint8",
        "Cells/connectivity": "int32", "Cells/offsets": "int32", "Cells/types": "uint8", "CellData/vtkGhostType": "uint8",
        "CellData/tile": "uint32", "CellData/neighbors": "int32"}, kinds
    points = arrays["Points"]
    cells = arrays["Cells/connectivity"].reshape(-1, corners)
    n, m = entry["points"], entry["cells"]
    assert points.shape == (n, 3) and len(cells) == m
    assert (arrays["Cells/types"] == (5 if dimension == 2 else 10)).all()
    assert (arrays["Cells/offsets"] == np.arange(1, m + 1) * corners).all()
    assert (arrays["CellData/tile"] == entry["tile"]).all() and len(arrays["CellData/tile"]) == m
    assert arrays["CellData/neighbors"].shape == (m, corners)
    own = arrays["PointData/vtkGhostType"] == 0
    assert own.sum() == entry["own_points"]
    assert ((arrays["PointData/owner"] == entry["tile"]) == own).all()
    main = arrays["CellData/vtkGhostType"] == 0
    assert main.sum() == entry["main_cells"]
    volume = volumes(points, cells)
    assert (volume > 0).all(), "cells are positively oriented"

    grid = read_grid(path)
    assert (grid.GetNumberOfPoints(), grid.GetNumberOfCells()) == (n, m)
    assert (vtk_to_numpy(grid.GetPoints().GetData()) == points).all()
    assert (vtk_to_numpy(grid.GetCells().GetConnectivityArray()).reshape(-1, corners) == cells).all()
    for name, values in arrays.items():
        section, _, name = name.partition("/")
        if section in ("PointData", "CellData"):
            seen = array(grid.GetPointData() if section == "PointData" else grid.GetCellData(), name)
            assert seen.dtype == values.dtype and seen.tobytes() == values.tobytes(), name
    return points, own, volume[main].sum()


def check_result(folder, dimension):
    corners = dimension + 1
    with open(os.path.join(folder, "manifest.json")) as file:
        manifest = json.load(file)
    own_points, main_volume = [], 0.0
    owner_of = {}
    for entry in manifest["tiles"]:
        points, own, volume = check_tile(os.path.join(folder, "tiles", "%06d.vtu" % entry["tile"]), entry, dimension)
        owner_of.update((tuple(point), entry["tile"]) for point in points[own].tolist())
        own_points.append(points[own])
        main_volume += volume
    own_points = np.concatenate(own_points)
    assert len(own_points) == manifest["counts"]["vertices"]
    hull = 1.0  # the corners of the unit box are among the points
    assert own_points[:, :dimension].min() == 0 and own_points[:, :dimension].max() == 1
    assert abs(main_volume / hull - 1) < 1e-6, (main_volume, hull)

    grid = read_grid(os.path.join(folder, "triangulation.pvtu"))
    assert grid.GetNumberOfPoints() == sum(entry["points"] for entry in manifest["tiles"])
    assert grid.GetNumberOfCells() == sum(entry["cells"] for entry in manifest["tiles"])
    ghosts = array(grid.GetCellData(), "vtkGhostType")
    assert (ghosts == 0).sum() == manifest["counts"]["cells"]
    points = vtk_to_numpy(grid.GetPoints().GetData())
    cells = vtk_to_numpy(grid.GetCells().GetConnectivityArray()).reshape(-1, corners)
    assert abs(volumes(points, cells)[ghosts == 0].sum() / hull - 1) < 1e-6
    owners = array(grid.GetPointData(), "owner")
    assert all(owner_of[tuple(point)] == owner for point, owner in zip(points.tolist(), owners.tolist()))
    own = array(grid.GetPointData(), "vtkGhostType") == 0
    assert sorted(array(grid.GetPointData(), "id")[own]) == list(range(len(own_points)))
    assert grid.GetCellData().GetArray("neighbors") is None, "they are indices into one tile"
    assert array(grid.GetPointData(), "gps_time").any() and array(grid.GetPointData(), ODD_NAME).any()
    tile = array(grid.GetCellData(), "tile")
    for entry in manifest["tiles"]:
        assert ((tile == entry["tile"]) & (ghosts == 0)).sum() == entry["main_cells"]


def main():
    writer, dimension = sys.argv[1], int(sys.argv[2])
    with tempfile.TemporaryDirectory() as base:
        folder = os.path.join(base, "out")
        subprocess.run([writer, folder, str(dimension)], check=True)
        check_result(folder, dimension)
        moved = os.path.join(base, "moved")
        os.rename(folder, moved)
        check_result(moved, dimension)


main()
