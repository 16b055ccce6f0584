"""Meshes as other people's programs read them: (points, cells as rows of indices, point data)."""
import gmsh
import numpy as np
import vtk
from osgeo import ogr
from vtk.util.numpy_support import vtk_to_numpy

ogr.UseExceptions()


def by_vtk(reader, path, corners):
    reader.SetFileName(str(path))
    reader.Update()
    grid = reader.GetOutput()
    connectivity = (grid.GetPolys() if grid.IsA("vtkPolyData") else grid.GetCells()).GetConnectivityArray()
    data = grid.GetPointData()
    arrays = {data.GetArrayName(i): vtk_to_numpy(data.GetArray(i)) for i in range(data.GetNumberOfArrays())}
    return vtk_to_numpy(grid.GetPoints().GetData()), vtk_to_numpy(connectivity).reshape(-1, corners), arrays


def vtu(path, corners):
    return by_vtk(vtk.vtkXMLUnstructuredGridReader(), path, corners)


def pvtu(path, corners):
    return by_vtk(vtk.vtkXMLPUnstructuredGridReader(), path, corners)


def ply(path, corners):
    return by_vtk(vtk.vtkPLYReader(), path, corners)


def obj(path, corners):
    return by_vtk(vtk.vtkOBJReader(), path, corners)


def cell_data(path):
    """The arrays of the cells of a .vtu or .pvtu."""
    reader = vtk.vtkXMLPUnstructuredGridReader() if path.suffix == ".pvtu" else vtk.vtkXMLUnstructuredGridReader()
    reader.SetFileName(str(path))
    reader.Update()
    data = reader.GetOutput().GetCellData()
    return {data.GetArrayName(i): vtk_to_numpy(data.GetArray(i)) for i in range(data.GetNumberOfArrays())}


def off(path):
    words = " ".join(line for line in path.read_text().splitlines() if not line.startswith("#")).split()
    assert words[0] == "OFF"
    points, cells = int(words[1]), int(words[2])
    places = np.array(words[4:4 + 3 * points], float).reshape(-1, 3)
    rows = np.array(words[4 + 3 * points:], int).reshape(cells, -1)
    assert (rows[:, 0] == rows.shape[1] - 1).all()
    return places, rows[:, 1:], {}


def neighbors_of(cells):
    """Across the facet opposite each vertex, -1 where there is none: from the cells alone."""
    facets = {}
    for c, cell in enumerate(cells.tolist()):
        for k in range(len(cell)):
            facets.setdefault(frozenset(cell[:k] + cell[k + 1:]), []).append((c, k))
    neighbors = np.full(cells.shape, -1)
    for sides in facets.values():
        if len(sides) == 2:
            neighbors[sides[0]], neighbors[sides[1]] = sides[1][0], sides[0][0]
    return neighbors


def by_gmsh(path, corners):
    gmsh.initialize()
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.open(str(path))
        tags, places, _ = gmsh.model.mesh.getNodes()
        kinds, _, nodes = gmsh.model.mesh.getElements(corners - 1)
        assert list(kinds) == [2 if corners == 3 else 4], kinds
        number = np.empty(int(tags.max()) + 1, int)
        number[tags] = np.arange(len(tags))
        return places.reshape(-1, 3), number[nodes[0]].reshape(-1, corners), {}
    finally:
        gmsh.finalize()


def groups_of(path):
    """The names of the physical groups that Gmsh finds."""
    gmsh.initialize()
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.open(str(path))
        return [gmsh.model.getPhysicalName(*group) for group in gmsh.model.getPhysicalGroups()]
    finally:
        gmsh.finalize()


def ply_with_cells(path):
    """VTK and CGAL read the points of a PLY file with cells, but not the cells: NumPy, by the file's own header."""
    kinds = {"uchar": "u1", "char": "i1", "ushort": "<u2", "short": "<i2", "uint": "<u4", "int": "<i4", "float": "<f4",
             "double": "<f8"}
    head, body = path.read_bytes().split(b"end_header\n", 1)
    lines = [line.split() for line in head.decode().splitlines()]
    counts = {line[1]: int(line[2]) for line in lines if line[0] == "element"}
    vertex = np.dtype([(line[2], kinds[line[1]]) for line in lines if line[0] == "property" and line[1] != "list"])
    cell = np.dtype([("n", "u1"), ("v", "<u4", 4)])
    assert len(body) == counts["vertex"] * vertex.itemsize + counts["cell"] * cell.itemsize
    vertices = np.frombuffer(body, vertex, counts["vertex"])
    cells = np.frombuffer(body, cell, offset=counts["vertex"] * vertex.itemsize)
    assert (cells["n"] == 4).all()
    data = {name: vertices[name] for name in vertex.names[3:]}
    return np.stack([vertices["x"], vertices["y"], vertices["z"]], axis=1), cells["v"], data


class Layer:
    """A layer of triangles, as GDAL reads it."""

    def __init__(self, path):
        source = ogr.Open(str(path))
        layer = source.GetLayer(0)
        self.name = layer.GetName()
        self.kind = ogr.GeometryTypeToName(layer.GetGeomType())
        srs = layer.GetSpatialRef()
        self.crs = srs.ExportToWkt() if srs else None
        self.epsg = srs.GetAuthorityCode(None) if srs else None
        self.rings, self.ids, self.tiles = [], [], []
        tile = "tid" if layer.GetLayerDefn().GetFieldIndex("tid") >= 0 else "tile"
        for feature in layer:
            ring = feature.GetGeometryRef().GetGeometryRef(0)
            assert feature.GetGeometryRef().GetGeometryCount() == 1 and ring.GetPointCount() == 4
            self.rings.append(ring.GetPoints())
            self.ids.append(tuple(feature.GetField(name) for name in ("v0", "v1", "v2")))
            self.tiles.append(feature.GetField(tile))
        assert all(ring[0] == ring[3] for ring in self.rings)
