"""A result opens in VTK and h5py as it is: read_result.py WRITER DIMENSION."""
import json
import os
import subprocess
import sys
import tempfile

import h5py
import numpy as np
import vtk
from vtk.util.numpy_support import vtk_to_numpy


def read_vtkhdf(path):
    reader = vtk.vtkHDFReader()
    assert reader.CanReadFile(path), path
    reader.SetFileName(path)
    reader.Update()
    return reader.GetOutput()


def volumes(points, cells):
    corner = points[cells]
    edges = corner[:, 1:, :] - corner[:, :1, :]
    if cells.shape[1] == 3:
        return (edges[:, 0, 0] * edges[:, 1, 1] - edges[:, 0, 1] * edges[:, 1, 0]) / 2
    return np.linalg.det(edges) / 6


def check_vtkhdf(folder, dimension):
    corners = dimension + 1
    cell_type = 5 if dimension == 2 else 10
    with open(os.path.join(folder, "manifest.json")) as file:
        manifest = json.load(file)
    own_points, main_volume, total_points, total_cells = [], 0.0, 0, 0
    for entry in manifest["tiles"]:
        path = os.path.join(folder, "tiles", "%06d.vtkhdf" % entry["tile"])
        with h5py.File(path) as file:
            group = file["VTKHDF"]
            assert list(group.attrs["Version"]) == [1, 0]
            assert group.attrs["Type"] == b"UnstructuredGrid"
            kinds = {name: group[name].dtype for name in (
                "Points", "Connectivity", "Offsets", "Types", "PointData/id", "PointData/vtkGhostType",
                "CellData/vtkGhostType", "CellData/neighbors", "PointData/intensity", "PointData/gps_time")}
            assert [str(kind) for kind in kinds.values()] == [
                "float64", "int32", "int32", "uint8", "uint64", "uint8", "uint8", "int32", "uint16", "float64"], kinds
            n, m = len(group["Points"]), len(group["Types"])
            assert group["NumberOfPoints"][0] == n == entry["points"]
            assert group["NumberOfCells"][0] == m == entry["cells"]
            assert group["NumberOfConnectivityIds"][0] == m * corners
            assert (group["Types"][:] == cell_type).all()
            assert group["Types"].id.get_storage_size() == 0, "no chunk is written"
            assert (group["Offsets"][:] == np.arange(m + 1) * corners).all()
            assert group["CellData/neighbors"].shape == (m, corners)
            points = group["Points"][:]
            cells = group["Connectivity"][:].reshape(-1, corners)
            main = group["CellData/vtkGhostType"][:] == 0
            assert main.sum() == entry["main_cells"]
            own = group["PointData/vtkGhostType"][:] == 0
            assert own.sum() == entry["own_points"]
            own_points.append(points[own])
            volume = volumes(points, cells)
            assert (volume > 0).all(), "cells are positively oriented"
            main_volume += volume[main].sum()
        grid = read_vtkhdf(path)
        assert (grid.GetNumberOfPoints(), grid.GetNumberOfCells()) == (n, m)
        assert all(grid.GetCellType(i) == cell_type for i in range(m))
        ghosts = vtk_to_numpy(grid.GetCellData().GetArray("vtkGhostType"))
        assert (ghosts == 0).sum() == entry["main_cells"]
        total_points += n
        total_cells += m
    own_points = np.concatenate(own_points)
    assert len(own_points) == manifest["counts"]["vertices"]
    hull = 1.0  # the corners of the unit box are among the points
    assert own_points[:, :dimension].min() == 0 and own_points[:, :dimension].max() == 1
    assert abs(main_volume / hull - 1) < 1e-6, (main_volume, hull)

    grid = read_vtkhdf(os.path.join(folder, "triangulation.vtkhdf"))
    assert (grid.GetNumberOfPoints(), grid.GetNumberOfCells()) == (total_points, total_cells)
    assert all(grid.GetCellType(i) == cell_type for i in range(total_cells))
    ghosts = vtk_to_numpy(grid.GetCellData().GetArray("vtkGhostType"))
    assert (ghosts == 0).sum() == manifest["counts"]["cells"]
    points = vtk_to_numpy(grid.GetPoints().GetData())
    cells = vtk_to_numpy(grid.GetCells().GetConnectivityArray()).reshape(-1, corners)
    volume = volumes(points, cells)
    assert abs(volume[ghosts == 0].sum() / hull - 1) < 1e-6
    assert grid.GetCellData().GetArray("neighbors").GetNumberOfComponents() == corners
    assert grid.GetPointData().GetArray("gps_time").GetNumberOfTuples() == total_points
    odd = vtk_to_numpy(grid.GetPointData().GetArray('50 % of "<it>"'))
    with h5py.File(os.path.join(folder, "tiles", "%06d.vtkhdf" % manifest["tiles"][0]["tile"])) as file:
        first = file['VTKHDF/PointData/50 % of "<it>"'][:]
    assert first.any() and (odd[:len(first)] == first).all() and len(odd) == total_points
    owners = vtk_to_numpy(grid.GetPointData().GetArray("vtkGhostType"))
    ids = vtk_to_numpy(grid.GetPointData().GetArray("id"))
    assert sorted(ids[owners == 0]) == list(range(len(own_points)))
    with h5py.File(os.path.join(folder, "triangulation.vtkhdf")) as file:
        group = file["VTKHDF"]
        assert all(group[name].is_virtual for name in ("Points", "Connectivity", "Offsets", "Types"))
        assert len(group["NumberOfCells"]) == len(manifest["tiles"])
        assert (group["Types"][:] == cell_type).all()


def main():
    writer, dimension = sys.argv[1], int(sys.argv[2])
    with tempfile.TemporaryDirectory() as base:
        folder = os.path.join(base, "out")
        subprocess.run([writer, folder, str(dimension)], check=True)
        check_vtkhdf(folder, dimension)
        moved = os.path.join(base, "moved")
        os.rename(folder, moved)
        check_vtkhdf(moved, dimension)


main()
