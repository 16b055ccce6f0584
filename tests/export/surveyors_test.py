"""What surveyors' programs read: DXF as GDAL reads it and by its grammar, LandXML by its grammar."""
import json
import unittest
from xml.etree import ElementTree

import numpy as np
from osgeo import ogr

from cli import IGN, USAGE
from max_edge_test import shorten
from stored import ExportTest

SPACE = "{http://www.landxml.org/schema/LandXML-1.2}"
FLAT = ('PROJCS["grid",GEOGCS["NAD83",DATUM["North_American_Datum_1983",SPHEROID["GRS 1980",6378137,298.257222101]],'
        'PRIMEM["Greenwich",0],UNIT["degree",0.0174532925199433]],PROJECTION["Transverse_Mercator"],'
        'PARAMETER["latitude_of_origin",0],PARAMETER["central_meridian",-99],PARAMETER["scale_factor",0.9996],'
        'PARAMETER["false_easting",500000],PARAMETER["false_northing",0],UNIT["a unit",{unit}]]')
BOTH = 'COMPD_CS["both",' + FLAT + ',VERT_CS["h",VERT_DATUM["d",2005],UNIT["another",{high}],AXIS["Up",UP]]]'
FOOT, SURVEY_FOOT = 0.3048, 1200 / 3937


def pairs_of(path):
    lines = path.read_text().split("\n")
    assert lines.pop() == "" and len(lines) % 2 == 0
    return [(int(code), value) for code, value in zip(lines[::2], lines[1::2])]


def dxf_faces(path):
    """The 3DFACE entities of a DXF file as (layer, corners), by its grammar."""
    pairs = pairs_of(path)
    assert pairs[-1] == (0, "EOF")
    assert pairs[:4] == [(0, "SECTION"), (2, "HEADER"), (9, "$ACADVER"), (1, "AC1009")]
    start = pairs.index((2, "ENTITIES"))
    assert {value for code, value in pairs[:start] if code == 2} >= {"HEADER", "TABLES", "LTYPE", "LAYER", "TIN"}
    faces, rest = [], pairs[start + 1:]
    while rest[0] == (0, "3DFACE"):
        layer, corners, rest = rest[1], rest[2:14], rest[14:]
        assert layer[0] == 8
        assert [code for code, _ in corners] == [10, 20, 30, 11, 21, 31, 12, 22, 32, 13, 23, 33]
        assert all("." in value or "e" in value for _, value in corners)
        numbers = [float(value) for _, value in corners]
        assert numbers[6:9] == numbers[9:]
        faces.append((layer[1], [tuple(numbers[k:k + 3]) for k in (0, 3, 6)]))
    assert rest == [(0, "ENDSEC"), (0, "EOF")]
    return faces


class LandXml:
    def __init__(self, path):
        root = ElementTree.parse(path).getroot()
        assert root.tag == SPACE + "LandXML" and root.get("version") == "1.2"
        assert {"date", "time"} <= set(root.keys())
        surface, = root.findall(f"{SPACE}Surfaces/{SPACE}Surface")
        definition, = surface.findall(SPACE + "Definition")
        assert definition.get("surfType") == "TIN" and [e.tag for e in definition] == [SPACE + "Pnts", SPACE + "Faces"]
        self.points, number = [], {}
        for p in definition[0]:
            assert p.tag == SPACE + "P"
            number[p.get("id")] = len(number)
            north, east, elevation = map(float, p.text.split())
            self.points.append((east, north, elevation))
        assert len(number) == len(self.points)
        self.cells = np.array([[number[word] for word in f.text.split()] for f in definition[1]])
        self.unit, = root.find(SPACE + "Units")
        self.system = root.find(SPACE + "CoordinateSystem")


class Surveyors(ExportTest):
    def clouds(self):
        lidar = IGN / "ign_77050_627760.las"
        yield self.stored(lidar, "--dim", "2", "--crop", "770500,6277550,770512,6277562", "--tiles", "4")
        yield self.stored(self.xyz(n=300), "--dim", "2", "--overwrite")
        odd = "".join(f"{x * 1e-7!r} {y * 1e18!r} {-x * y}\n" for x in range(9) for y in range(9))
        yield self.stored(self.write("odd.xyz", odd), "--dim", "2", "--overwrite")

    def ids_of(self, stored, corners):
        by_place = {p: i for i, p in stored.points.items()}
        return sorted(tuple(by_place[p] for p in cell) for cell in corners)

    def test_dxf_holds_the_triangles_with_their_heights(self):
        for stored in self.clouds():
            faces = dxf_faces(self.export("mesh.dxf"))
            self.assertEqual({layer for layer, _ in faces}, {"TIN"})
            self.assertEqual(self.ids_of(stored, [corners for _, corners in faces]), stored.cells)
        parts = self.export("parts", "--format", "dxf")
        faces = [face for path in parts.iterdir() for face in dxf_faces(path)]
        self.assertEqual(self.ids_of(stored, [corners for _, corners in faces]), stored.cells)

    def test_gdal_reads_the_faces_of_dxf(self):
        stored = next(self.clouds())
        source = ogr.Open(str(self.export("mesh.dxf")))
        layer = source.GetLayer(0)
        self.assertEqual(layer.GetFeatureCount(), len(stored.cells))
        corners = []
        for feature in layer:
            self.assertEqual(feature.GetField("Layer"), "TIN")
            ring = feature.GetGeometryRef().GetGeometryRef(0).GetPoints()
            self.assertEqual(ring[0], ring[-1])
            corners.append(ring[:3])
        self.assertEqual(self.ids_of(stored, corners), stored.cells)

    def test_landxml_holds_points_and_faces(self):
        for stored in self.clouds():
            surface = LandXml(self.export("mesh.xml"))
            self.check_mesh(stored, surface.points, surface.cells)
        pieces = [LandXml(path) for path in self.export("parts", "--format", "landxml").iterdir()]
        corners = [[piece.points[v] for v in cell] for piece in pieces for cell in piece.cells]
        self.assertEqual(self.ids_of(stored, corners), stored.cells)

    def test_both_heed_the_other_options(self):
        stored = self.stored(self.xyz(n=600), "--dim", "2", "--tiles", "3")
        self.assertGreater(shorten(stored, 0.05), 0)
        stored.points = {i: p[:2] + (0.0,) for i, p in stored.points.items()}
        surface = LandXml(self.export("mesh.xml", "--max-edge", "0.05", "--no-z"))
        self.check_mesh(stored, surface.points, surface.cells)
        faces = dxf_faces(self.export("mesh.dxf", "--max-edge", "0.05", "--no-z"))
        self.assertEqual(self.ids_of(stored, [corners for _, corners in faces]), stored.cells)

    def with_crs(self, crs):
        path = self.out / "manifest.json"
        path.write_text(json.dumps(json.loads(path.read_text()) | {"crs": crs}))

    def test_units_are_those_of_the_coordinate_system(self):
        self.stored(self.xyz(n=50), "--dim", "2")
        for crs, unit, heights in [("EPSG:2154", "meter", "meter"), ("EPSG:2263", "USSurveyFoot", "feet"),
                                   ("EPSG:2222", "foot", "feet"),
                                   (BOTH.format(unit=1, high=SURVEY_FOOT), "meter", "feet"),
                                   (BOTH.format(unit=FOOT, high=1), "foot", "meter"), ("", "meter", "meter")]:
            self.with_crs(crs)
            surface = LandXml(self.export("mesh.xml"))
            kind = "Metric" if unit == "meter" else "Imperial"
            self.assertEqual(surface.unit.tag, SPACE + kind, crs)
            self.assertEqual((surface.unit.get("linearUnit"), surface.unit.get("elevationUnit")), (unit, heights), crs)
            required = {"areaUnit", "linearUnit", "volumeUnit", "temperatureUnit", "pressureUnit"}
            self.assertLessEqual(required, set(surface.unit.keys()))
            if crs.startswith("EPSG"):
                self.assertEqual(surface.system.get("epsgCode"), crs[5:])
            if crs:
                self.assertRegex(surface.system.get("ogcWktCode"), "^(PROJCS|COMPD_CS)")
            else:
                self.assertIsNone(surface.system)

    def test_without_a_system_a_note_says_so(self):
        self.stored(self.xyz(n=50), "--dim", "2")
        self.assertIn("no coordinate system", self.run_tessera("export", self.out, "-o", "a.xml").stderr)
        self.assertEqual(self.run_tessera("export", self.out, "-o", "a.dxf").stderr, "")

    def test_units_that_landxml_does_not_know_are_refused(self):
        self.stored(self.xyz(n=50), "--dim", "2")
        before = self.files()
        for crs, says in [("EPSG:4326", "degrees"), (FLAT.format(unit=20.1168), "a unit"),
                          (BOTH.format(unit=1, high=0.01), "another")]:
            self.with_crs(crs)
            self.refused(USAGE, "export", self.out, "-o", "a.xml", says=[says, "metres, feet and US survey feet"])
            self.ok("export", self.out, "-o", "a.dxf", "--overwrite", "--quiet")
            (self.folder / "a.dxf").unlink()
        self.assertEqual(self.files(), before)

    def test_solids_are_refused(self):
        self.stored(self.xyz(n=50), "--dim", "3")
        before = self.files()
        for target, name in (("a.dxf", "dxf"), ("a.xml", "landxml"), ("a.landxml", "landxml")):
            self.refused(USAGE, "export", self.out, "-o", target, says=["is a 3D result", name + " has no tetrahedra",
                                                                            "vtu, msh, mesh and npy have them"])
        self.assertEqual(self.files(), before)


if __name__ == "__main__":
    unittest.main()
