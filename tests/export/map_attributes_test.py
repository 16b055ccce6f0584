"""Attributes of vertices on maps, as GDAL reads them: a layer of points in GeoPackage, corners' properties in GeoJSON."""
import json
import math
import random
import sqlite3
import unittest

from osgeo import ogr

import readers
from cli import IGN
from max_edge_test import shorten
from stored import ExportTest

KINDS = ["float weight", "double exact", "uchar class", "char low", "ushort wide", "short depth", "uint count", "int Depth",
         "int fid", "float geom", "int id", "uchar a'b\"c", "int tile"]


def points_of(path):
    """The layer "vertices" of a GeoPackage: by id the place and the attributes; and what kind its geometries are."""
    source = ogr.Open(str(path))
    layer = source.GetLayerByName("vertices")
    names = [field.GetName() for field in layer.schema]
    assert names[0] == "id"
    found = {}
    for feature in layer:
        values = [feature.GetField(name) for name in names]
        assert values[0] not in found
        found[values[0]] = (feature.GetGeometryRef().GetPoints()[0], dict(zip(names[1:], values[1:])))
    return ogr.GeometryTypeToName(layer.GetGeomType()), found


class MapAttributes(ExportTest):
    def cloud(self, n=200):
        rng = random.Random(8)
        def value(kind):
            if kind in ("float", "double"):
                return rng.choice([rng.randrange(-99, 99) / 8, rng.randrange(1 << 20) / 1024])
            low, high = {"uchar": (0, 255), "char": (-128, 127), "ushort": (0, 65535), "short": (-32768, 32767),
                         "uint": (0, 2 ** 32 - 1), "int": (-2 ** 31, 2 ** 31 - 1)}[kind]
            return rng.choice([low, high, rng.randint(low, high)])
        head = f"ply\nformat ascii 1.0\nelement vertex {n}\nproperty double x\nproperty double y\nproperty double z\n"
        head += "".join(f"property {kind}\n" for kind in KINDS) + "end_header\n"
        rows = "".join(" ".join(str(v) for v in [rng.random(), rng.random(), rng.random(),
                                                 *(value(kind.split()[0]) for kind in KINDS)]) + "\n" for _ in range(n))
        return self.write("cloud.ply", head + rows)

    def carried(self, *options):
        stored = self.stored(self.cloud(), "--dim", "2", "--attributes", "all", "--tiles", "3", "--overwrite", *options)
        self.assertEqual(len(stored.attributes), len(KINDS) + 1, "z, too")
        return stored

    def attributes_of(self, stored, i):
        return {name: values[i] for name, values in stored.attributes.items() if name != "z"}

    def test_a_geopackage_has_each_vertex_once_with_all_attributes(self):
        stored = self.carried()
        path = self.export("a.gpkg")
        self.assertEqual(sorted(readers.Layer(path).ids), stored.cells)
        kind, points = points_of(path)
        self.assertEqual(kind, "3D Point")
        self.assertEqual(set(points), set(stored.points))
        renamed = {"Depth": "Depth_", "fid": "fid_", "geom": "geom_", "id": "id_"}
        for i, (place, values) in points.items():
            self.assertEqual(place, stored.points[i])
            self.assertEqual(values, {renamed.get(n, n): v for n, v in self.attributes_of(stored, i).items()})

    def test_both_layers_have_their_indices_and_join(self):
        stored = self.carried()
        base = sqlite3.connect(self.export("a.gpkg"))
        names = {row[0] for row in base.execute("select name from sqlite_master")}
        self.assertLessEqual({"rtree_triangulation_geom", "rtree_vertices_geom", "vertices_id"}, names)
        rows = base.execute("select t.v0, p.exact from triangulation t join vertices p on p.id = t.v0").fetchall()
        self.assertEqual(len(rows), len(stored.cells))
        self.assertTrue(all(value == stored.attributes["exact"][i] for i, value in rows))
        self.assertEqual(base.execute("pragma integrity_check").fetchall(), [("ok",)])
        self.assertEqual(base.execute("select count(*) from gpkg_contents").fetchall(), [(2,)])
        base.close()
        base = sqlite3.connect(self.export("a.gpkg", "--no-index"))
        self.assertEqual(base.execute("select name from sqlite_master where name like 'rtree%'").fetchall(), [])
        base.close()

    def test_geojson_has_the_attributes_of_the_corners(self):
        stored = self.carried()
        path = self.export("a.geojson")
        for feature in json.loads(path.read_text())["features"]:
            properties = feature["properties"]
            self.assertEqual(len(properties), 4 + 3 * len(KINDS))
            for k in range(3):
                for name, value in self.attributes_of(stored, properties[f"v{k}"]).items():
                    self.assertEqual(properties[f"{name}_{k}"], value)
        source = ogr.Open(str(path))
        types = {field.GetName(): field.GetTypeName() for field in source.GetLayer(0).schema}
        self.assertEqual({types[f"{n}_{k}"] for n in ("class", "depth", "wide", "low", "tile") for k in range(3)}, {"Integer"})
        self.assertEqual({types["exact_0"], types["weight_2"]}, {"Real"})

    def test_without_long_cells_only_their_vertices_are_there(self):
        stored = self.carried()
        everything = set(stored.points)
        self.assertGreater(shorten(stored, 0.08), 0)
        self.assertLess(len(stored.points), len(everything))
        path = self.export("a.gpkg", "--max-edge", "0.08", "--no-z")
        kind, points = points_of(path)
        self.assertEqual(kind, "Point")
        self.assertEqual({i: place for i, (place, _) in points.items()}, {i: p[:2] for i, p in stored.points.items()})
        self.assertEqual(sorted(readers.Layer(path).ids), stored.cells)

    def test_each_tile_has_the_vertices_of_its_triangles(self):
        stored = self.carried()
        for path in self.export("parts", "--format", "gpkg").iterdir():
            used = {i for cell in readers.Layer(path).ids for i in cell}
            self.assertEqual(set(points_of(path)[1]), used)
        self.export("parts", "--format", "geojson")

    def test_without_attributes_there_is_one_layer(self):
        self.stored(self.xyz(n=50), "--dim", "2")
        source = ogr.Open(str(self.export("a.gpkg")))
        self.assertEqual([source.GetLayer(i).GetName() for i in range(source.GetLayerCount())], ["triangulation"])
        properties = json.loads(self.export("a.geojson").read_text())["features"][0]["properties"]
        self.assertEqual(list(properties), ["tile", "v0", "v1", "v2"])

    def test_what_is_no_number_is_null(self):
        cloud = self.write("nan.csv", "x,y,z,a\n0,0,0,1.5\n1,0,0,nan\n0,1,0,inf\n1,1,0,-2\n")
        stored = self.stored(cloud, "--attributes", "a", "--dim", "2")
        self.assertTrue(math.isnan(stored.attributes["a"][1]))
        expected = {0: 1.5, 1: None, 2: None, 3: -2}
        for feature in json.loads(self.export("a.geojson").read_text())["features"]:
            properties = feature["properties"]
            self.assertEqual([properties[f"a_{k}"] for k in range(3)], [expected[properties[f"v{k}"]] for k in range(3)])
        values = {i: values["a"] for i, (_, values) in points_of(self.export("a.gpkg"))[1].items()}
        self.assertEqual(values, expected | {2: math.inf})

    def test_lidar_can_be_styled_by_class(self):
        self.stored(IGN / "ign_77050_627760.las", "--dim", "2", "--crop", "770500,6277550,770510,6277560",
                    "--attributes", "intensity,classification")
        _, points = points_of(self.export("a.gpkg"))
        classes = {values["classification"] for _, values in points.values()}
        self.assertTrue(classes)
        self.assertTrue(all(isinstance(c, int) for c in classes))


if __name__ == "__main__":
    unittest.main()
