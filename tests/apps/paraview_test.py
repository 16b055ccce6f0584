"""The scripts for ParaView: what they compute, by VTK, on which ParaView stands; and themselves, where there is pvpython."""
import shutil
import subprocess
import types
import unittest

import numpy as np
import vtk
from vtk.numpy_interface import dataset_adapter
from vtk.util.numpy_support import vtk_to_numpy

from cli import IGN, CliTest

SCRIPTS = IGN.parents[1] / "scripts"


def constant(script, name):
    """The value of a text that the script sets, without running its imports of ParaView."""
    text = (SCRIPTS / script).read_text()
    return text.split(f'{name} = """', 1)[1].split('"""', 1)[0]


def read(folder):
    reader = vtk.vtkXMLPUnstructuredGridReader()
    reader.SetFileName(str(folder / "triangulation.pvtu"))
    reader.Update()
    return reader.GetOutput()


def run_filter(grid):
    """What ParaView's programmable filter with "Copy Arrays" makes of the grid."""
    copy = vtk.vtkUnstructuredGrid()
    copy.ShallowCopy(grid)
    names = {"inputs": [dataset_adapter.WrapDataObject(grid)], "output": dataset_adapter.WrapDataObject(copy)}
    exec(compile(constant("paraview_longest_edge.py", "SCRIPT"), "SCRIPT", "exec"), names)
    return copy


class LongestEdge(CliTest):
    def check(self, *options):
        self.ok("triangulate", self.xyz(n=400), "-o", self.out, "--tiles", "4", "--quiet", *options)
        grid = read(self.out)
        found = vtk_to_numpy(run_filter(grid).GetCellData().GetArray("longest_edge"))
        self.assertEqual(len(found), grid.GetNumberOfCells())
        for cell in range(0, len(found), 37):
            shape = grid.GetCell(cell)
            lengths = []
            for i in range(shape.GetNumberOfEdges()):
                ends = shape.GetEdge(i).GetPoints()  # one object for all edges
                lengths.append(np.linalg.norm(np.subtract(ends.GetPoint(0), ends.GetPoint(1))))
            self.assertAlmostEqual(found[cell], max(lengths))

    def test_is_that_of_vtk_in_3d(self):
        self.check()

    def test_is_that_of_vtk_in_2d(self):
        self.check("--dim", "2")

    def test_of_nothing_is_nothing(self):
        self.assertEqual(run_filter(vtk.vtkUnstructuredGrid()).GetCellData().GetArray("longest_edge").GetNumberOfTuples(), 0)


class Scripts(CliTest):
    def test_they_compile(self):
        for path in sorted(SCRIPTS.glob("*.py")):
            self.assertIsInstance(compile(path.read_text(), path.name, "exec"), types.CodeType)

    @unittest.skipUnless(shutil.which("pvpython") and shutil.which("xvfb-run"), "no pvpython")
    def test_paraview_draws_the_pictures(self):
        block = IGN / "*.las"
        flat = self.folder / "flat"
        self.ok("triangulate", block, "-o", self.out, "--tiles", "12", "--attributes", "classification", "--quiet")
        self.ok("triangulate", block, "-o", flat, "--dim", "2", "--class", "2,9", "--quiet")
        subprocess.run(["xvfb-run", "-a", "pvpython", "--force-offscreen-rendering", SCRIPTS / "paraview_pictures.py",
                        self.out, flat, self.folder / "pictures"], check=True, timeout=300)
        self.assertEqual(sorted(path.name for path in (self.folder / "pictures").iterdir()),
                         ["clip.png", "short-cells.png", "terrain.png", "tiles.png", "whole.png"])


if __name__ == "__main__":
    unittest.main()
