"""Meshes for PyVista. Debian has VTK without PyVista, so a stand-in with PyVista's constructor makes a grid of VTK's."""
import sys
import types
import unittest
from unittest import mock

import numpy as np
import tessera
from vtkmodules.util.numpy_support import numpy_to_vtk, numpy_to_vtkIdTypeArray, vtk_to_numpy
from vtkmodules.vtkCommonCore import vtkPoints
from vtkmodules.vtkCommonDataModel import vtkCellArray, vtkUnstructuredGrid
from vtkmodules.vtkFiltersVerdict import vtkCellSizeFilter

import clouds


class UnstructuredGrid:
    """pyvista.UnstructuredGrid(cells, celltypes, points): cells are their sizes and rows, one after the other."""

    def __init__(self, cells, types_of_cells, points):
        self.points, self.celltypes, self.point_data, self.cell_data = points, types_of_cells, {}, {}
        size = cells[0] + 1
        array = vtkCellArray()
        array.ImportLegacyFormat(numpy_to_vtkIdTypeArray(np.ascontiguousarray(cells, np.int64), deep=True))
        self.rows = cells.reshape(-1, size)[:, 1:]
        held = vtkPoints()
        held.SetData(numpy_to_vtk(points, deep=True))
        self.grid = vtkUnstructuredGrid()
        self.grid.SetPoints(held)
        self.grid.SetCells(int(types_of_cells[0]), array)

    def sizes(self, name):
        made = vtkCellSizeFilter()
        made.SetInputData(self.grid)
        made.Update()
        return vtk_to_numpy(made.GetOutput().GetCellData().GetArray(name))


@mock.patch.dict(sys.modules, {"pyvista": types.SimpleNamespace(UnstructuredGrid=UnstructuredGrid)})
class Meshes(unittest.TestCase):
    def test_tetrahedra_fill_the_hull_and_carry_what_they_have(self):
        points = np.vstack([clouds.random(800, 3), [[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], clouds.random(800, 3)[:5]])
        t = tessera.triangulate(points, max_points_per_tile=200, attributes={"row": np.arange(len(points))})
        t.measure(volume=True)
        grid = tessera.to_pyvista(t)
        self.assertEqual((len(grid.points), len(grid.rows)), (t.n_vertices, t.n_cells))
        volumes = grid.sizes("Volume")
        self.assertAlmostEqual(volumes.sum(), 1)
        self.assertTrue((volumes > -1e-15).all())
        np.testing.assert_allclose(volumes, grid.cell_data["volume"], atol=1e-12)
        np.testing.assert_array_equal(grid.points, points[grid.point_data["id"]])
        np.testing.assert_array_equal(grid.point_data["row"], grid.point_data["id"])
        np.testing.assert_array_equal(grid.point_data["id"][grid.rows], t.simplices())

    def test_a_tile_is_its_own_cells(self):
        t = tessera.triangulate(clouds.random(800, 3), max_points_per_tile=200)
        for tile in t:
            grid = tessera.to_pyvista(tile)
            np.testing.assert_array_equal(grid.point_data["id"][grid.rows], tile.ids[tile.cells[~tile.ghost]])

    def test_terrain_has_its_heights(self):
        xyz = clouds.random(500, 3)
        t = tessera.triangulate(xyz, dim=2, max_points_per_tile=100)
        grid = tessera.to_pyvista(t)
        np.testing.assert_array_equal(grid.points, xyz[grid.point_data["id"]])
        self.assertEqual(set(grid.celltypes), {5})
        flat = tessera.to_pyvista(t, heights=False)
        self.assertFalse(flat.points[:, 2].any())
        np.testing.assert_array_equal(flat.point_data["z"], xyz[flat.point_data["id"], 2])
        self.assertAlmostEqual(flat.sizes("Area").sum(), t.measure(volume=True).total)


class Missing(unittest.TestCase):
    def test_a_sentence_says_what_to_install(self):
        with mock.patch.dict(sys.modules, {"pyvista": None}):
            with self.assertRaisesRegex(ImportError, r"^to_pyvista\(\) needs the package pyvista, which is not installed: pip install pyvista$"):
                tessera.to_pyvista(tessera.triangulate(clouds.random(10, 2)))


if __name__ == "__main__":
    unittest.main()
