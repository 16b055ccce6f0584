"""Every format, read back by other people's programs: coordinates bit for bit, the cells of the store, attributes."""
import math
import random
import unittest

import numpy as np
from scipy.spatial import ConvexHull

import readers
from cli import IGN
from stored import ExportTest, Stored, volumes

LIDAR = IGN / "ign_77050_627760.las"
MESH_READERS = {"vtu": readers.vtu, "msh": readers.by_gmsh, "mesh": readers.by_gmsh}
FLAT_READERS = MESH_READERS | {"ply": readers.ply, "obj": readers.obj}
SINGLE = {"ply", "obj"}  # VTK keeps the points of these as floats


class Case(ExportTest):
    def clouds(self):
        """Name, file, options: small ones of every kind that breaks writers."""
        rng = random.Random(3)
        yield "lidar", LIDAR, ["--crop", "770500,6277550,770512,6277562", "--tiles", "4"]
        yield "one tile", self.xyz("one.xyz", n=300), ["--tiles", "1"]
        side = range(8)
        lattice = "".join(f"{x} {y} {z}\n" for x in side for y in side for z in side)
        yield "lattice", self.write("lattice.xyz", lattice), ["--tiles", "5"]
        huge = "".join(f"{rng.uniform(-1, 1) * 1e150!r} {rng.random() / 3!r} {-rng.random() * 1e-7!r}\n" for _ in range(300))
        yield "huge", self.write("huge.xyz", "-0.0 0 1e-300\n" + huge), ["--tiles", "3"]


class Solid(Case):
    def test_every_format_holds_the_tetrahedra_of_the_store(self):
        for name, cloud, options in self.clouds():
            with self.subTest(cloud=name):
                stored = self.stored(cloud, "--overwrite", *options)
                for ending, read in MESH_READERS.items():
                    points, cells, _ = read(self.export(f"mesh.{ending}"), 4)
                    self.check_mesh(stored, points, cells)
                points, cells, _ = readers.ply_with_cells(self.export("mesh.ply"))
                self.check_mesh(stored, points, cells)
                points, cells, _ = readers.pvtu(self.export("parts", "--format", "vtu") / "triangulation.pvtu", 4)
                self.check_mesh(stored, points, cells, whole=False)
                self.check_arrays(stored)

    def check_arrays(self, stored):
        folder = self.export("arrays", "--format", "npy")
        load = lambda name: np.load(folder / f"{name}.npy", mmap_mode="r")
        points, ids, cells, tile = (load(name) for name in ("points", "ids", "cells", "tile"))
        kinds = [(a.dtype.str, a.ndim) for a in (points, ids, cells, tile, load("neighbors"))]
        self.assertEqual(kinds, [("<f8", 2), ("<u8", 1), ("<i8", 2), ("<u4", 1), ("<i8", 2)])
        lifted = np.column_stack([points, load("z")]) if stored.dimension == 2 else points
        self.assertTrue((self.check_mesh(stored, lifted, cells) == ids).all())
        self.assertEqual(np.bincount(tile).tolist(), [t["main_cells"] for t in stored.manifest["tiles"]])
        self.assertTrue((load("neighbors") == readers.neighbors_of(cells)).all())

    def test_the_volume_is_that_of_the_hull(self):
        stored = self.stored(LIDAR, "--crop", "770500,6277550,770520,6277570", "--tiles", "6")
        hull = ConvexHull(np.array(list(stored.points.values())) - [770500, 6277550, 0]).volume
        for ending, read in MESH_READERS.items():
            points, cells, _ = read(self.export(f"mesh.{ending}"), 4)
            each = volumes((points - [770500, 6277550, 0])[cells])
            self.assertAlmostEqual(each.sum() / hull, 1, places=9, msg=ending)
            self.assertGreater(each.min(), -1e-9, ending)


class Flat(Case):
    def test_every_format_holds_the_triangles_of_the_store_with_their_heights(self):
        for name, cloud, options in self.clouds():
            if name == "lattice":  # of a column of points the lowest remains
                options = [*options, "--crop", "0,0,0,8,8,0"]
            with self.subTest(cloud=name):
                if name == "lattice":
                    cloud = self.write("flat.xyz", "".join(f"{x} {y} {x * y}\n" for x in range(20) for y in range(20)))
                    options = ["--tiles", "5"]
                self.check_all(self.stored(cloud, "--dim", "2", "--overwrite", *options))

    def check_all(self, stored):
        huge = max(abs(x) for p in stored.points.values() for x in p) > 1e30
        for ending, read in FLAT_READERS.items():
            path = self.export(f"mesh.{ending}")
            if ending in SINGLE:
                if not huge:  # more than a float holds
                    points, cells, _ = read(path, 3)
                    self.assertEqual((len(points), len(cells)), (len(stored.points), len(stored.cells)))
                continue  # CGAL reads the doubles of these
            points, cells, _ = read(path, 3)
            self.check_mesh(stored, points, cells)
        points, cells, _ = readers.pvtu(self.export("parts", "--format", "vtu") / "triangulation.pvtu", 3)
        self.check_mesh(stored, points, cells, whole=False)
        Solid.check_arrays(self, stored)
        for ending in ("geojson", "gpkg", "vrt"):
            layer = readers.Layer(self.export(f"mesh.{ending}"))
            self.check_layer(stored, layer, ending)
        union = readers.Layer(self.export("tables", "--format", "csv") / "triangulation.vrt")
        self.check_layer(stored, union, "union")

    def check_layer(self, stored, layer, ending):
        self.assertEqual(layer.kind, "3D Polygon" if "z" in stored.attributes else "Polygon", ending)
        self.assertEqual(sorted(layer.ids), stored.cells, ending)
        heights = "z" in stored.attributes
        for ids, ring in zip(layer.ids, layer.rings):
            for i, point in zip(ids, ring):
                self.assertEqual(point, stored.points[i] if heights else stored.points[i][:2], ending)

    def test_clouds_without_heights_stay_flat(self):
        stored = self.stored(self.xyz(columns=2, n=400), "--tiles", "3")
        self.assertNotIn("z", stored.attributes)
        for ending, read in MESH_READERS.items():
            points, cells, _ = read(self.export(f"mesh.{ending}"), 3)
            self.check_mesh(stored, points, cells)
        for ending in ("geojson", "gpkg", "csv"):
            self.check_layer(stored, readers.Layer(self.export(f"mesh.{ending}").with_suffix(
                ".vrt" if ending == "csv" else "." + ending)), ending)
        self.assertFalse((self.export("arrays", "--format", "npy") / "z.npy").exists())

    def test_heights_can_be_left_out_of_the_export_and_of_the_result(self):
        stored = self.stored(self.xyz(n=300), "--dim", "2", "--tiles", "2")
        points, cells, data = readers.vtu(self.export("mesh.vtu", "--no-z"), 3)
        self.check_mesh(stored, points, cells, flat=True)
        self.assertNotIn("z", data)
        self.assertEqual(readers.Layer(self.export("mesh.gpkg", "--no-z")).kind, "Polygon")
        self.assertNotIn("z", self.stored("cloud.xyz", "--dim", "2", "--no-z", "--overwrite").attributes)

    def test_of_equal_places_the_lowest_id_keeps_its_height(self):
        cloud = self.write("dup.xyz", "0 0 5\n1 0 6\n0 1 7\n1 1 8\n0 0 9\n1 1 -1\n")
        stored = self.stored(cloud, "--dim", "2")
        self.assertEqual([stored.points[i][2] for i in range(4)], [5, 6, 7, 8])
        points, _, _ = readers.vtu(self.export("mesh.vtu"), 3)
        self.assertEqual(sorted(points[:, 2]), [5, 6, 7, 8])

    def test_a_height_that_is_not_finite_is_named(self):
        cloud = self.write("nan.xyz", "0 0 5\n1 0 nan\n0 1 7\n1 1 8\n")
        self.ok("triangulate", cloud, "-o", self.out, "--dim", "2", "--quiet")
        self.refused(2, "export", self.out, "-o", "a.geojson", says=["vertex 1", "--no-z"])
        self.refused(2, "export", self.out, "-o", "a.off", says=["vertex 1", "--no-z"])
        self.assertEqual(len(readers.Layer(self.export("a.geojson", "--no-z")).ids), 2)
        heights = np.load(self.export("arrays", "--format", "npy") / "z.npy")
        self.assertEqual(sum(map(math.isnan, heights)), 1)

    def test_the_area_is_that_of_the_hull(self):
        stored = self.stored(LIDAR, "--dim", "2", "--crop", "770500,6277550,770530,6277580", "--tiles", "6")
        hull = ConvexHull(np.array(list(stored.points.values()))[:, :2] - [770500, 6277550]).volume
        for ending in ("geojson", "gpkg", "vrt"):
            rings = np.array(readers.Layer(self.export(f"mesh.{ending}")).rings)[:, :3, :2] - [770500, 6277550]
            self.assertAlmostEqual(volumes(rings).sum() / hull, 1, places=9, msg=ending)
            self.assertGreater(volumes(rings).min(), 0, ending)


class Attributes(ExportTest):
    def cloud(self):
        rng = random.Random(5)
        head = ("ply\nformat ascii 1.0\nelement vertex 200\nproperty double x\nproperty double y\nproperty double z\n"
                "property float weight\nproperty uchar a\"quoted\"<b>&c\nproperty short points\nproperty int tile\nend_header\n")
        rows = "".join(f"{rng.random()} {rng.random()} {rng.random()} {rng.randrange(64) / 8} {rng.randrange(256)} "
                       f"{rng.randrange(-999, 999)} {rng.randrange(10 ** 6)}\n" for _ in range(200))
        return self.write("cloud.ply", head + rows)

    def check_data(self, stored, ids, data):
        for name, values in stored.attributes.items():
            if name == "z":
                continue
            self.assertEqual([values[i] for i in ids.tolist()], data[name].tolist(), name)

    def test_vtk_and_numpy_find_every_attribute_at_its_point(self):
        for dimension in (2, 3):
            stored = self.stored(self.cloud(), "--dim", dimension, "--attributes", "all", "--tiles", "3", "--overwrite")
            self.assertIn('a"quoted"<b>&c', stored.attributes)
            for path, read in [(self.export("mesh.vtu"), readers.vtu),
                               (self.export("parts", "--format", "vtu") / "triangulation.pvtu", readers.pvtu)]:
                points, cells, data = read(path, dimension + 1)
                ids = self.check_mesh(stored, points, cells, whole=path.suffix == ".vtu")
                self.assertEqual(ids.tolist(), data["id"].tolist())
                self.check_data(stored, ids, data)
            folder = self.export("arrays", "--format", "npy")
            data = {path.stem: np.load(path) for path in folder.iterdir()}
            self.assertIn("points_", data, "what would be overwritten gets another name")
            data |= {"points": data["points_"], "tile": data["tile_"]}
            self.check_data(stored, data["ids"], data)
        points, cells, data = readers.ply_with_cells(self.export("mesh.ply"))
        self.check_data(stored, self.check_mesh(stored, points, cells), data)
        self.assertEqual(data["id"].tolist(), self.check_mesh(stored, points, cells).tolist())

    def test_any_name_is_found_again(self):
        names = ["two words", "it's <50> % & \"more\"", "é", "tile", "a/b"]
        rng = random.Random(6)
        rows = "".join(",".join(repr(rng.random()) for _ in range(8)) + "\n" for _ in range(100))
        cloud = self.write("cloud.csv", ",".join(["x", "y", "z", *names]) + "\n" + rows)
        for dimension in (2, 3):
            stored = self.stored(cloud, "--dim", dimension, "--attributes", "all", "--tiles", "2", "--overwrite")
            kept = names[:-1] + ["a_b"] + ["z"] * (dimension == 2)
            self.assertEqual(list(stored.attributes), kept)
            points, cells, data = readers.vtu(self.export("mesh.vtu"), dimension + 1)
            self.check_data(stored, self.check_mesh(stored, points, cells), data)
            folder = self.export("arrays", "--format", "npy")
            data = {path.stem: np.load(path) for path in folder.iterdir()}
            self.check_data(stored, data["ids"], data | {"tile": data["tile_"]})
        points, cells, data = readers.ply_with_cells(self.export("mesh.ply"))
        data = {name.replace("_", " ") if "a_b" != name else name: values for name, values in data.items()}
        self.check_data(stored, self.check_mesh(stored, points, cells), data)


class Stages(ExportTest):
    def test_many_tiles_and_one_give_the_same_cells(self):
        cloud = self.xyz(n=1500)
        one = self.stored(cloud, "--dim", "2", "--tiles", "1")
        many = self.stored(cloud, "--dim", "2", "--tiles", "40", "--overwrite")
        rotate = lambda cell: min(cell[k:] + cell[:k] for k in range(3))
        self.assertEqual(sorted(map(rotate, one.cells)), sorted(map(rotate, many.cells)))
        self.check_mesh(many, *readers.vtu(self.export("mesh.vtu"), 3)[:2])
        self.assertEqual(len(list(self.export("parts", "--format", "ply").iterdir())), 40)


if __name__ == "__main__":
    unittest.main()
