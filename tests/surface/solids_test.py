"""Surfaces of scanned solids whose truth is known: how much of their volume agrees, and how far they are."""

import json
import os
import subprocess
import tempfile
import unittest

import numpy as np
import solids
import vtk
from vtk.util import numpy_support

TESSERA = os.environ["TESSERA"]
NOISE = 0.01


def surface(folder, cloud, *options):
    mesh = os.path.join(folder, "mesh.ply")
    command = [TESSERA, "surface", cloud, "-o", mesh, "--json", "--overwrite", "--attributes", "all", *options]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr + done.stdout
    return mesh, json.loads(done.stdout.splitlines()[-1])


def polydata(vertices, triangles):
    data = vtk.vtkPolyData()
    points = vtk.vtkPoints()
    points.SetData(numpy_support.numpy_to_vtk(np.ascontiguousarray(vertices), deep=1))
    cells = vtk.vtkCellArray()
    rows = np.column_stack([np.full(len(triangles), 3), triangles]).astype(np.int64).ravel()
    cells.SetCells(len(triangles), numpy_support.numpy_to_vtkIdTypeArray(rows, deep=1))
    data.SetPoints(points)
    data.SetPolys(cells)
    return data


def inside(vertices, triangles, queries):
    """Whether points are inside, by the parity of what a line from each meets."""
    locator = vtk.vtkOBBTree()
    locator.SetDataSet(polydata(vertices, triangles))
    locator.BuildLocator()
    points, ids = vtk.vtkPoints(), vtk.vtkIdList()
    answers = []
    far = np.linalg.norm(vertices.max(axis=0) - vertices.min(axis=0)) * 2
    for q in queries:
        end = q + far * np.array([0.0123, 0.0456, 1.0])
        locator.IntersectWithLine(q, end, points, ids)
        answers.append(points.GetNumberOfPoints() % 2 == 1)
    return np.array(answers)


def parity(triangles):
    edges = np.vstack([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    sign = np.where(edges[:, 0] < edges[:, 1], 1, -1)
    low, high = edges.min(axis=1), edges.max(axis=1)
    _, where = np.unique(low * (high.max() + 1) + high, return_inverse=True)
    return np.abs(np.bincount(where, weights=sign)).max()


class Solids(unittest.TestCase):
    def measure(self, solid, cloud, least_overlap, *options):
        points, sensors = cloud
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "cloud.ply")
            solids.write_ply(path, points, sensors)
            mesh, told = surface(folder, path, *options)
            vertices, triangles = solids.read_mesh(mesh)
        self.assertIn("x_origin", told["sensors"])
        self.assertEqual(parity(triangles), 0)
        random = np.random.default_rng(1)
        lo, hi = solid.bounds
        queries = random.uniform(lo, hi, (20000, 3))
        here, true = inside(vertices, triangles, queries), solid.distance(queries) < 0
        overlap = (here & true).sum() / (here | true).sum()
        centres = vertices[triangles].mean(axis=1)
        a, b, c = (vertices[triangles[:, i]] for i in range(3))
        areas = np.linalg.norm(np.cross(b - a, c - a), axis=1)
        within = ((centres > lo) & (centres < hi)).all(axis=1)
        if hasattr(solid, "seen"):
            within &= solid.seen(centres)
        far = np.average(np.abs(solid.distance(centres[within])), weights=areas[within])
        print(f"{type(solid).__name__}: {len(points)} points, {len(triangles)} triangles, overlap {overlap:.4f}, "
              f"mean distance {far / NOISE:.2f} of the noise", flush=True)
        self.assertGreaterEqual(overlap, least_overlap)
        return far

    def test_sphere(self):
        self.assertLess(self.measure(solids.Sphere(), solids.around(solids.Sphere(), 60000, NOISE, 1), 0.97,
                                     "--bottom", "free"), NOISE)

    def test_torus(self):
        self.assertLess(self.measure(solids.Torus(), solids.around(solids.Torus(), 60000, NOISE, 2), 0.97,
                                     "--bottom", "free"), NOISE)

    def test_wall(self):
        self.assertLess(self.measure(solids.Wall(), solids.around(solids.Wall(), 60000, NOISE, 3), 0.97,
                                     "--bottom", "free"), NOISE)

    def test_city(self):
        self.assertLess(self.measure(solids.City(), solids.flown(solids.City(), 120000, NOISE, 4), 0.97), NOISE)


if __name__ == "__main__":
    unittest.main()
