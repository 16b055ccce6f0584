"""Macro for ParaView 5.10 and newer: hides the long cells of the selected result.

Macros > Import new macro... takes this file. It adds two filters to the selected source: "longest edge", which gives every
cell the array longest_edge (in units of the points), and a Threshold that keeps the cells up to 2 % of the cloud's
diagonal: change its Upper Threshold to taste.

Also a module, for pvpython: from paraview_longest_edge import add_longest_edge, without_long_cells
"""
from paraview.simple import GetActiveSource, GetActiveViewOrCreate, Hide, ProgrammableFilter, Show, Threshold

# What ParaView runs: `inputs` and `output` are its names. All cells of a result are of one kind: tetrahedra or triangles.
SCRIPT = """
import numpy as np
from vtk.util.numpy_support import vtk_to_numpy

grid = inputs[0].VTKObject
corners = 0
longest = np.zeros(grid.GetNumberOfCells())
if len(longest) > 0:
    corners = grid.GetCell(0).GetNumberOfPoints()
    points = vtk_to_numpy(grid.GetPoints().GetData())
    cells = vtk_to_numpy(grid.GetCells().GetConnectivityArray()).reshape(-1, corners)
for i in range(corners):
    for j in range(i):
        edge = points[cells[:, i]] - points[cells[:, j]]
        np.maximum(longest, np.einsum("ij,ij->i", edge, edge), out=longest)
output.CellData.append(np.sqrt(longest), "longest_edge")
"""


def add_longest_edge(source):
    """`source` with the cell array longest_edge."""
    added = ProgrammableFilter(registrationName="longest edge", Input=source, Script=SCRIPT)
    added.CopyArrays = 1
    return added


def without_long_cells(source, longest):
    """The cells of `source`, which has longest_edge, whose edges are at most that long."""
    kept = Threshold(Input=source)
    kept.Scalars = ["CELLS", "longest_edge"]
    kept.ThresholdMethod = "Between"
    kept.LowerThreshold, kept.UpperThreshold = 0, longest
    return kept


def diagonal(source):
    x0, x1, y0, y1, z0, z1 = source.GetDataInformation().GetBounds()
    return ((x1 - x0) ** 2 + (y1 - y0) ** 2 + (z1 - z0) ** 2) ** 0.5


def main():
    source = GetActiveSource()
    if source is None:
        raise RuntimeError("open a result first: File > Open, triangulation.pvtu, Apply")
    view = GetActiveViewOrCreate("RenderView")
    source.UpdatePipeline()
    Show(without_long_cells(add_longest_edge(source), 0.02 * diagonal(source)), view)
    Hide(source, view)


if __name__ == "__main__":
    main()
