"""tessera voronoi in 3D: polyhedra for VTK, against SciPy; boxes are filled; the same bytes for any tiling."""
import re
import struct
import unittest

import numpy as np
import scipy.spatial
from cells import VoronoiTest
from cli import USAGE

TYPES = {"UInt8": "u1", "UInt32": "<u4", "UInt64": "<u8", "Int64": "<i8", "Float64": "<f8"}


def read_arrays(path):
    """{"Points": array, "CellData/id": array, ...} of a file of VTK with raw appended arrays."""
    data = path.read_bytes()
    mark = b'<AppendedData encoding="raw">\n_'
    begin = data.index(mark) + len(mark)
    arrays, section = {}, ""
    for tag in re.findall(rb"<(\w+)([^<>]*)>", data[:begin]):
        if tag[0] != b"DataArray":
            section = tag[0].decode()
            continue
        told = {key: value.decode() for key, value in re.findall(rb'(\w+)="([^"]*)"', tag[1])}
        told = {key.decode() if isinstance(key, bytes) else key: value for key, value in told.items()}
        at = begin + int(told["offset"])
        size, = struct.unpack_from("<Q", data, at)
        array = np.frombuffer(data, TYPES[told["type"]], size // np.dtype(TYPES[told["type"]]).itemsize, at + 8)
        components = int(told["NumberOfComponents"])
        array = array.reshape(-1, components) if components > 1 else array
        arrays["Points" if section == "Points" else section + "/" + told["Name"]] = array
    return arrays


class Polyhedra:
    def __init__(self, path):
        arrays = read_arrays(path)
        self.points = arrays["Points"]
        self.data = {name.split("/")[1]: value for name, value in arrays.items() if name.startswith("CellData/")}
        faces, ends = arrays["Cells/faces"].tolist(), arrays["Cells/faceoffsets"].tolist()
        corners, offsets = arrays["Cells/connectivity"].tolist(), arrays["Cells/offsets"].tolist()
        assert set(arrays["Cells/types"].tolist()) <= {42}
        self.cells = []
        for cell, (begin, end) in enumerate(zip([0] + ends, ends)):
            own, at = [], begin + 1
            for _ in range(faces[begin]):
                own.append(faces[at + 1:at + 1 + faces[at]])
                at += 1 + faces[at]
            assert at == end
            assert sorted({c for face in own for c in face}) == sorted(corners[offsets[cell - 1] if cell else 0:offsets[cell]])
            self.cells.append(own)


def clouds():
    rng = np.random.default_rng(9)
    return {"uniform": rng.random((250, 3)), "lattice": np.stack(np.meshgrid(*[np.arange(5.0)] * 3), -1).reshape(-1, 3),
            "map": np.round(rng.random((200, 3)) * [100, 100, 20], 2) + [885000, 6290000, 100],
            "sphere": np.round(np.concatenate([(v / np.linalg.norm(v, axis=1)[:, None]) for v in
                                               [rng.normal(size=(120, 3))]] + [[[0, 0, 0]]]), 2),
            "far": np.concatenate([rng.random((60, 3)), [[1e9, 0, 0], [0, -1e9, 1], [3, 2, 1e9]]])}


class Space(VoronoiTest):
    def assert_closed(self, shapes):
        """Faces of a cell share their sides. Faces of two cells are the same corners in the other direction."""
        seen = {}
        for number, faces in enumerate(shapes.cells):
            sides = [(a, b) for face in faces for a, b in zip(face, face[1:] + face[:1])]
            self.assertEqual(len(set(sides)), len(sides))
            self.assertEqual({(b, a) for a, b in sides}, set(sides))
            for face in faces:
                seen.setdefault(tuple(sorted(face)), []).append((number, face))
        for (_, first), *others in seen.values():
            self.assertLessEqual(len(others), 1)
            for _, second in others:
                at = second.index(first[0])
                self.assertEqual((second[at:] + second[:at])[:1] + (second[at:] + second[:at])[:0:-1], first)

    def test_bounded_cells_are_those_of_scipy(self):
        for name in "uniform", "map":
            points = clouds()[name]
            with self.subTest(cloud=name):
                said = self.write_cells(self.triangulate(points, "--tiles", "4"), name="cells.vtu")
                shapes = Polyhedra(self.folder / "cells.vtu")
                self.assert_closed(shapes)
                self.assertEqual(len({tuple(p) for p in shapes.points.tolist()}), len(shapes.points))
                origin, width = points.min(axis=0), np.ptp(points)
                diagram = scipy.spatial.Voronoi((points - origin) / width)
                bounded = [i for i, region in enumerate(diagram.point_region) if -1 not in diagram.regions[region]]
                self.assertEqual(shapes.data["id"].tolist(), bounded)
                self.assertEqual(said["unbounded"], len(points) - len(bounded))
                for i, vertex in enumerate(bounded):
                    region = diagram.vertices[diagram.regions[diagram.point_region[vertex]]]
                    shape = scipy.spatial.ConvexHull(region)
                    np.testing.assert_allclose(shapes.data["volume"][i] / width**3, shape.volume, rtol=1e-6)
                    np.testing.assert_allclose(shapes.data["surface"][i] / width**2, shape.area, rtol=1e-6)

    def test_measures_are_those_of_columns(self):
        out = self.triangulate(clouds()["uniform"], "--tiles", "3")
        self.ok("measure", out, "--voronoi", "--quiet")
        self.write_cells(out, name="cells.vtu")
        data = Polyhedra(self.folder / "cells.vtu").data
        np.testing.assert_allclose(data["volume"], data["voronoi_volume"], rtol=1e-9)
        np.testing.assert_allclose(data["surface"], data["voronoi_surface"], rtol=1e-9)
        np.testing.assert_array_equal(data["neighbours"], data["voronoi_neighbours"])
        for axis, name in enumerate("xyz"):
            np.testing.assert_allclose(data["centroid"][:, axis], data["voronoi_" + name], rtol=1e-9, atol=1e-12)

    def test_a_box_is_filled(self):
        for name, points in clouds().items():
            low, high = points.min(axis=0), points.max(axis=0)
            size = high - low
            if name == "far":
                low, high = np.zeros(3), np.ones(3)
                size = high - low
            out = self.triangulate(points, "--tiles", "5")
            for a, b in (low + size * 0.21, low + size * 0.78), (low - size / 2, high + size / 3), (low, high):
                with self.subTest(cloud=name, low=a, high=b):
                    clip = ",".join(repr(v) for v in [*a.tolist(), *b.tolist()])
                    said = self.write_cells(out, "--clip", clip, name="cells.vtu")
                    shapes = Polyhedra(self.folder / "cells.vtu")
                    self.assert_closed(shapes)
                    self.assertTrue((shapes.points >= a).all() and (shapes.points <= b).all())
                    self.assertAlmostEqual(said["volume"] / np.prod(b - a), 1, delta=1e-9)
                    self.assertEqual(said["thin"], 0)
                    np.testing.assert_array_less(0, shapes.data["volume"])

    def test_cells_of_a_lattice_are_its_boxes(self):
        out = self.triangulate(clouds()["lattice"])
        self.write_cells(out, "--clip=-0.5,-0.5,-0.5,4.5,4.5,4.5", name="cells.vtu")
        shapes = Polyhedra(self.folder / "cells.vtu")
        self.assertEqual(len(shapes.points), 6**3)
        self.assertEqual(set(shapes.data["volume"].tolist()), {1.0})
        self.assertEqual(set(map(len, shapes.cells)), {6})

    def test_the_same_bytes_for_any_tiles_and_threads(self):
        for name in "uniform", "lattice", "far":
            for clip in ("none",), ("0.1,0.2,0.3,3.3,3.6,3.9",):
                texts = set()
                for options in ((), ("--tiles", "7", "--store", "points"), ("--tiles", "60")):
                    self.write_cells(self.triangulate(clouds()[name], *options), "--clip", *clip, "--threads",
                                     1 + len(options), name="cells.vtu")
                    texts.add((self.folder / "cells.vtu").read_bytes())
                self.assertEqual(len(texts), 1, (name, clip))

    def test_vtk_reads_the_file(self):
        try:
            from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridReader
        except ImportError:
            self.skipTest("VTK is not installed")
        self.write_cells(self.triangulate(clouds()["uniform"]), name="cells.vtu")
        reader = vtkXMLUnstructuredGridReader()
        reader.SetFileName(str(self.folder / "cells.vtu"))
        reader.Update()
        grid, shapes = reader.GetOutput(), Polyhedra(self.folder / "cells.vtu")
        self.assertEqual(grid.GetNumberOfCells(), len(shapes.cells))
        for i in range(grid.GetNumberOfCells()):
            self.assertEqual(grid.GetCell(i).GetNumberOfFaces(), len(shapes.cells[i]))

    def test_wrong_input_is_refused(self):
        out = self.triangulate(clouds()["uniform"])
        target = self.folder / "cells.vtu"
        self.refused(USAGE, "voronoi", out, "-o", self.folder / "cells.gpkg", says=".vtu")
        self.refused(USAGE, "voronoi", out, "-o", target, "--clip", "hull", says="3D result")
        self.refused(USAGE, "voronoi", out, "-o", target, "--clip", "0,0,1,1", says="zmin")
        self.assertFalse(target.exists())
        few = self.triangulate(np.eye(4)[:, :3], name="few")
        self.refused(USAGE, "voronoi", few, "-o", target, says="no bounded cell")


if __name__ == "__main__":
    unittest.main()
