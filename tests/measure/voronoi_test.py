"""tessera measure --voronoi: against SciPy, against the 512 bits of `query star`, and known shapes; for all tiles alike."""
import json
import math
import unittest

import numpy as np
import scipy.spatial
from cli import USAGE, CliTest
from tile_arrays import read_tile

from volumes_test import clouds


class Voronoi(CliTest):
    def measured(self, points, *options, threads=2):
        """{id: values} of all vertices, by the names of the columns without voronoi_."""
        d = points.shape[1]
        np.save(self.folder / "cloud.npy", points)
        self.ok("triangulate", self.folder / "cloud.npy", "-o", self.out, "--overwrite", "--quiet", "--dim", d, *options)
        self.said = self.ok("measure", self.out, "--voronoi", "--threads", threads)
        names = ["area" if d == 2 else "volume", "boundary" if d == 2 else "surface", "neighbours", "x", "y", "z"][:d + 3]
        manifest, found = json.loads((self.out / "manifest.json").read_text()), {}
        for entry in manifest["tiles"]:
            arrays = read_tile(self.out / entry.get("file", "tiles/%06d.vtu" % entry["tile"]))
            columns = [arrays["PointData/voronoi_" + name].tolist() for name in names]
            for vertex, values in zip(arrays["PointData/id"].tolist(), zip(*columns)):
                one = found.setdefault(vertex, values)
                np.testing.assert_array_equal(one, values)  # in every tile that has the vertex
        return found

    def test_cells_are_those_of_scipy(self):
        for d in 2, 3:
            for name in "uniform", "far":
                points = clouds(d)[name][:500]
                origin = points.min(axis=0)
                width = np.ptp(points)
                with self.subTest(dimension=d, cloud=name):
                    diagram = scipy.spatial.Voronoi((points - origin) / width)
                    hull = set(scipy.spatial.ConvexHull(points - origin).vertices.tolist())
                    degree = np.diff(scipy.spatial.Delaunay((points - origin) / width).vertex_neighbor_vertices[0])
                    for vertex, (volume, surface, neighbours, *centroid) in self.measured(points, "--tiles", "4").items():
                        region = diagram.regions[diagram.point_region[vertex]]
                        self.assertEqual(neighbours, degree[vertex])
                        if vertex in hull:
                            self.assertEqual((volume, surface), (math.inf, math.inf))
                            self.assertTrue(all(map(math.isnan, centroid)))
                            continue
                        self.assertNotIn(-1, region)
                        shape = scipy.spatial.ConvexHull(diagram.vertices[region])
                        middle = scipy.spatial.Delaunay(diagram.vertices[region])
                        corners = middle.points[middle.simplices]
                        weights = np.abs(np.linalg.det(corners[:, 1:] - corners[:, :1]))
                        right = (corners.mean(axis=1) * weights[:, None]).sum(axis=0) / weights.sum()
                        # Qhull's own numbers are rounded: its cells may be longer than they are wide.
                        np.testing.assert_allclose(volume / width ** d, shape.volume, rtol=1e-6)
                        np.testing.assert_allclose(surface / width ** (d - 1), shape.area, rtol=1e-6)
                        np.testing.assert_allclose((np.array(centroid) - origin) / width, right, rtol=1e-6, atol=1e-7)

    def test_volumes_are_those_of_512_bits(self):
        for d in 2, 3:
            for name in "grid", "sphere", "far", "mixed":
                points = clouds(d)[name][:250]
                found = self.measured(points, "--tiles", "3")
                for vertex in range(0, 250, 7):
                    star = json.loads(self.ok("query", self.out, "star", vertex, "--json"))
                    volume, _, neighbours, *_ = found[vertex]
                    self.assertEqual(neighbours, len(star["neighbors"]))
                    with self.subTest(dimension=d, cloud=name, vertex=vertex):
                        if star["on_hull"]:
                            self.assertEqual(volume, math.inf)
                        else:
                            self.assertAlmostEqual(volume / star["voronoi_volume"], 1, delta=1e-14)

    def test_cells_of_a_lattice_are_its_boxes(self):
        for d, side in (2, 9), (3, 6):
            points = np.stack(np.meshgrid(*[np.arange(float(side))] * d, indexing="ij"), -1).reshape(-1, d)
            for vertex, (volume, surface, _, *centroid) in self.measured(points, "--tiles", "5").items():
                at = points[vertex]
                if (at == 0).any() or (at == side - 1).any():
                    self.assertEqual(volume, math.inf)
                    continue
                self.assertAlmostEqual(volume, 1, delta=1e-14)
                self.assertAlmostEqual(surface, 2 * d, delta=1e-13)
                np.testing.assert_allclose(centroid, at, atol=1e-13)

    def test_bits_are_the_same_for_all_tiles_and_threads(self):
        for d in 2, 3:
            for name in "uniform", "grid", "mixed":
                first = None
                for options, threads in ((["--tiles", "1"], 1), (["--tiles", "7", "--no-neighbors"], 2),
                                         (["--tiles", "40", "--partition", "random"], 3)):
                    found = self.measured(clouds(d)[name], *options, threads=threads)
                    first = first or found
                    self.assertEqual({v: repr(x) for v, x in found.items()}, {v: repr(x) for v, x in first.items()})

    def test_they_are_attributes_and_told(self):
        points = clouds(2)["uniform"][:300]
        self.measured(points, "--tiles", "3")
        self.assertIn("voronoi_area of vertices", self.said)
        self.ok("export", self.out, "-o", self.folder / "arrays", "--format", "npy", "--quiet")
        areas = np.load(self.folder / "arrays" / "voronoi_area.npy")
        self.assertEqual(np.load(self.folder / "arrays" / "voronoi_neighbours.npy").dtype, np.uint32)
        self.assertTrue(np.isinf(areas).sum() > 5 and (areas > 0).all())
        self.ok("verify", self.out)

    def test_a_region_is_refused(self):
        np.save(self.folder / "cloud.npy", clouds(2)["uniform"])
        self.ok("region", self.folder / "cloud.npy", "--bbox", "0.2,0.2,0.5,0.5", "-o", self.out, "--dim", "2", "--quiet")
        self.refused(USAGE, "measure", self.out, "--voronoi", says="Voronoi cells need a whole triangulation")


if __name__ == "__main__":
    unittest.main()
