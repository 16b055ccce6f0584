"""tessera voronoi --clip: boxes, polygons with holes and parts, edges along cells; against GEOS."""
import json
import unittest
from fractions import Fraction

import numpy as np
from cells import VoronoiTest, clouds, ring_area
from cli import BAD_INPUT, USAGE
from osgeo import ogr, osr


def area_of(polygons):
    return sum(sum(abs(ring_area(ring)) * (1 if i == 0 else -1) for i, ring in enumerate(rings)) for rings in polygons)


class Clip(VoronoiTest):
    def save(self, polygons, name="area.geojson", epsg=None):
        """Polygons are lists of rings; the first is the outer one."""
        path = self.folder / name
        if name.endswith("json"):
            path.write_text(json.dumps({"type": "MultiPolygon", "coordinates": [[[*ring, ring[0]] for ring in rings]
                                                                               for rings in polygons]}))
            return path
        path.unlink(missing_ok=True)
        data = ogr.GetDriverByName("GPKG" if name.endswith("gpkg") else "FlatGeobuf").CreateDataSource(str(path))
        reference = osr.SpatialReference()
        if epsg:
            reference.ImportFromEPSG(epsg)
        layer = data.CreateLayer("area", reference if epsg else None, ogr.wkbPolygon)
        for rings in polygons:
            text = ",".join("(" + ",".join("%r %r" % tuple(p) for p in [*ring, ring[0]]) + ")" for ring in rings)
            feature = ogr.Feature(layer.GetLayerDefn())
            feature.SetGeometry(ogr.CreateGeometryFromWkt("POLYGON (" + text + ")"))
            layer.CreateFeature(feature)
        return path

    def test_a_box_is_filled(self):
        for name, points in clouds().items():
            low, high = points.min(axis=0), points.max(axis=0)
            size = high - low
            boxes = [(low + size * 0.21, low + size * 0.83), (low - size, high + size / 2), (low, high)]
            if name == "lattice":
                boxes += [(np.array([0.5, 1.5]), np.array([7.5, 4.5])), (np.array([1, 2.0]), np.array([6, 5.0]))]
            out = self.triangulate(points, "--tiles", "4")
            for a, b in boxes:
                with self.subTest(cloud=name, box=(a, b)):
                    self.write_cells(out, "--clip", "%r,%r,%r,%r" % (*a.tolist(), *b.tolist()))
                    exact = [Fraction(v) for v in (*a, *b)]
                    border = self.assert_covers(self.cells(), (exact[2] - exact[0]) * (exact[3] - exact[1]))
                    for (px, py), (qx, qy) in border:
                        self.assertTrue(px == qx in (a[0], b[0]) or py == qy in (a[1], b[1]))

    def test_a_box_beyond_the_points_has_the_cells_that_reach_there(self):
        said = self.write_cells(self.triangulate(clouds()["uniform"]), "--clip", "5,5,6,6")
        self.assertEqual(said["area"], 1)
        self.assertEqual(said["cells"] + said["outside"], 600)
        self.assertEqual({row["unbounded"] for row in self.rows()}, {"1"})

    def shapes(self):
        turn = np.linspace(0, 2 * np.pi, 90, endpoint=False)
        star = np.stack([np.cos(turn), np.sin(turn)], 1) * (0.3 + 0.15 * (np.arange(90) % 2))[:, None] + 0.5
        return {
            "star": [[star.tolist()]],
            "hole": [[[[0.1, 0.1], [0.9, 0.15], [0.8, 0.9], [0.2, 0.8]], [[0.4, 0.4], [0.5, 0.6], [0.6, 0.4]]]],
            "parts": [[[[-1, -1], [0.4, 0.2], [0.1, 0.9]]], [[[0.5, 0.1], [2, 0.3], [0.6, 0.8]]]],
            "lake with island": [[[[0, 0], [1, 0], [1, 1], [0, 1]], [[0.2, 0.2], [0.2, 0.8], [0.8, 0.8], [0.8, 0.2]]],
                                 [[[0.3, 0.3], [0.7, 0.3], [0.5, 0.7]]]],
            "touching": [[[[0, 0], [0.5, 0.5], [0, 1]]], [[[1, 0], [1, 1], [0.5, 0.5]]]],
            "hole at the border": [[[[0, 0], [1, 0], [1, 1], [0, 1]], [[0, 0], [0.5, 0.25], [0.25, 0.5]]]],
            "comb": [[[[0, 0], [1, 0], [1, 1], *[[x / 40, 1 if x % 2 == 0 else 0.05] for x in range(39, 0, -1)], [0, 1]]]],
        }

    def test_polygons_are_filled_and_cells_are_those_of_geos(self):
        for cloud in "uniform", "few", "lattice":
            points = {"few": np.random.default_rng(1).random((7, 2)),
                      "lattice": np.stack(np.meshgrid(*[np.arange(9) / 8] * 2), -1).reshape(-1, 2)}.get(cloud)
            points = clouds()["uniform"] if points is None else points
            out = self.triangulate(points, "--tiles", "3")
            self.write_cells(out, "--clip", "-3,-3,4,4", name="whole.csv")
            whole = self.cells("whole.csv")
            for name, polygons in self.shapes().items():
                with self.subTest(cloud=cloud, shape=name):
                    self.write_cells(out, "--clip", self.save(polygons))
                    cells = self.cells()
                    self.assert_covers(cells, area_of(polygons))
                    shape = ogr.CreateGeometryFromJson((self.folder / "area.geojson").read_text())
                    for vertex, (geometry, _) in whole.items():
                        right = geometry.Intersection(shape).GetArea()
                        found = cells[vertex][0].GetArea() if vertex in cells else 0
                        self.assertAlmostEqual(found, right, delta=1e-12)

    def test_edges_along_cells_leave_whole_cells(self):
        points = np.stack(np.meshgrid(np.arange(10.0), np.arange(10.0)), -1).reshape(-1, 2)
        ring = [[0.5, 0.5], [4.5, 0.5], [4.5, 3.5], [7.5, 3.5], [7.5, 8.5], [0.5, 8.5]]
        said = self.write_cells(self.triangulate(points), "--clip", self.save([[ring]]))
        self.assertEqual((said["cells"], said["area"]), (47, 47))
        self.assertEqual({row["area"] for row in self.rows()}, {"1"})

    def test_overlapping_and_adjacent_polygons_are_one_area(self):
        points = clouds()["uniform"]
        out = self.triangulate(points)
        union = [[[[0.1, 0.1], [0.7, 0.1], [0.7, 0.3], [0.9, 0.3], [0.9, 0.9], [0.3, 0.9], [0.3, 0.7], [0.1, 0.7]]]]
        overlap = [[[[0.1, 0.1], [0.7, 0.1], [0.7, 0.7], [0.1, 0.7]]], [[[0.3, 0.3], [0.9, 0.3], [0.9, 0.9], [0.3, 0.9]]]]
        adjacent = [[[[0.1, 0.1], [0.7, 0.1], [0.7, 0.3], [0.1, 0.3]]], [[[0.1, 0.3], [0.9, 0.3], [0.9, 0.7], [0.1, 0.7]]],
                    [[[0.9, 0.7], [0.9, 0.9], [0.3, 0.9], [0.3, 0.7]]]]
        said = [self.write_cells(out, "--clip", self.save(polygons, name))["area"]
                for polygons, name in ((union, "a.geojson"), (overlap, "b.gpkg"), (adjacent, "c.fgb"), (overlap, "d.json"))]
        for area in said:
            self.assertAlmostEqual(area, float(area_of(union)), delta=1e-12)

    def test_the_same_bytes_for_any_tiles(self):
        clip = self.save(self.shapes()["lake with island"])
        texts = set()
        for options in ((), ("--tiles", "7"), ("--tiles", "60", "--store", "points")):
            self.write_cells(self.triangulate(clouds()["uniform"], *options), "--clip", clip, "--threads", 3)
            texts.add((self.folder / "cells.csv").read_bytes())
        self.assertEqual(len(texts), 1)

    def test_wrong_polygons_are_refused(self):
        out = self.triangulate(clouds()["map"], "--crs", "EPSG:2154")
        target = self.folder / "cells.csv"
        far = [[[[885000, 6290000], [886000, 6290000], [886000, 6291000]]]]
        self.refused(BAD_INPUT, "voronoi", out, "-o", target, "--clip", self.save(far, "other.gpkg", 3857),
                     says=("other.gpkg", "ogr2ogr"))
        self.ok("voronoi", out, "-o", target, "--clip", self.save(far, "same.gpkg", 2154))
        target.unlink()
        self.refused(BAD_INPUT, "voronoi", out, "-o", target, "--clip", self.save([[[[0, 0], [1, 0], [1, 1]]]]),
                     says="degrees")
        self.write("text.gpkg", "no database")
        self.refused(BAD_INPUT, "voronoi", out, "-o", target, "--clip", "text.gpkg", says="text.gpkg")
        self.write("line.geojson", '{"type":"LineString","coordinates":[[0,0],[1,1]]}')
        self.refused(BAD_INPUT, "voronoi", out, "-o", target, "--clip", "line.geojson", says="Polygon")
        self.refused(USAGE, "voronoi", out, "-o", target, "--clip", "land.txt", says="land.txt")
        self.assertFalse(target.exists())


if __name__ == "__main__":
    unittest.main()
