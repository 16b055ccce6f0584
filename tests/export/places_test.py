"""Where maps put a result: coordinate systems of GeoJSON, GeoPackage and VRT, as GDAL and ogrinfo read them."""
import json
import os
import sqlite3
import subprocess
import unittest
from xml.etree import ElementTree

import readers
from cli import IGN
from stored import ExportTest

LAMBERT = ('PROJCS["RGF93 v1 / Lambert-93",GEOGCS["RGF93 v1",DATUM["Reseau_Geodesique_Francais_1993_v1",'
           'SPHEROID["GRS 1980",6378137,298.257222101]],PRIMEM["Greenwich",0],UNIT["degree",0.0174532925199433]],'
           'PROJECTION["Lambert_Conformal_Conic_2SP"],PARAMETER["latitude_of_origin",46.5],'
           'PARAMETER["central_meridian",3],PARAMETER["standard_parallel_1",49],PARAMETER["standard_parallel_2",44],'
           'PARAMETER["false_easting",700000],PARAMETER["false_northing",6600000],UNIT["metre",1],'
           'AXIS["Easting",EAST],AXIS["Northing",NORTH]{code}]')
OWN = LAMBERT.replace('"central_meridian",3]', '"central_meridian",4.25]').replace("RGF93 v1 / Lambert-93", "My & <own>")
COMPOUND = 'COMPD_CS["both",{flat},VERT_CS["h",VERT_DATUM["d",2005],UNIT["metre",1],AXIS["Up",UP]]]'


class Places(ExportTest):
    def layers(self, crs):
        self.stored(self.xyz(n=50), "--dim", "2", "--overwrite")
        path = self.out / "manifest.json"
        path.write_text(json.dumps(json.loads(path.read_text()) | {"crs": crs}))
        return {ending: readers.Layer(self.export(f"place.{ending}")) for ending in ("geojson", "gpkg", "vrt")}

    def test_codes_and_wkt_with_codes_are_found_again(self):
        for crs in ["EPSG:2154", LAMBERT.format(code=',AUTHORITY["EPSG","2154"]')]:
            for ending, layer in self.layers(crs).items():
                self.assertEqual(layer.epsg, "2154", (ending, crs))

    def test_wkt_without_a_code_is_recognised_or_kept_as_it_is(self):
        layers = self.layers(LAMBERT.format(code=""))
        self.assertEqual(layers["geojson"].epsg, "2154", "PROJ is sure")
        for ending, layer in layers.items():
            self.assertIn("Lambert", layer.crs, ending)
        for ending, layer in self.layers(OWN.format(code="")).items():
            self.assertIn("4.25", layer.crs, ending)
            self.assertIn("My & <own>", layer.crs, ending)

    def test_compound_systems_keep_at_least_their_horizontal_part(self):
        for flat in (LAMBERT.format(code=',AUTHORITY["EPSG","2154"]'), OWN.format(code="")):
            for ending, layer in self.layers(COMPOUND.format(flat=flat)).items():
                self.assertIn("4.25" if "4.25" in flat else "2154", layer.crs, ending)
                self.assertEqual("COMPD" in layer.crs.upper() or "COMPOUND" in layer.crs.upper(), ending != "geojson")

    def test_without_a_system_no_map_is_claimed(self):
        done = self.layers("")
        for ending, layer in done.items():
            self.assertIn("Undefined Cartesian SRS", layer.crs, ending)
            self.assertIsNone(layer.epsg, ending)
        base = sqlite3.connect(self.folder / "place.gpkg")
        self.assertEqual(base.execute("select srs_id from gpkg_geometry_columns").fetchall(), [(-1,)])
        base.close()
        told = self.run_tessera("export", self.out, "-o", "again.gpkg")
        self.assertIn("no coordinate system", told.stderr)

    def test_ogrinfo_shows_lidar_where_it_was_flown(self):
        self.stored(IGN / "ign_77050_627760.las", "--dim", "2", "--crop", "770500,6277550,770505,6277555")
        for target in ("place.gpkg", "place.vrt", "place.geojson"):
            self.export(target)
            text = subprocess.run(["ogrinfo", "-so", "-al", target], cwd=self.folder, text=True, check=True,
                                  capture_output=True).stdout
            for word in ["3D Polygon", "Lambert-93", "2154", "(770500.", "v2: Integer"]:
                self.assertIn(word, text, target)

    def test_a_geopackage_has_its_spatial_index_and_leaves_nothing_else(self):
        self.stored(self.xyz(n=50), "--dim", "2")
        path = self.export("a.gpkg")
        base = sqlite3.connect(path)
        tables = {row[0] for row in base.execute("select name from sqlite_master")}
        self.assertIn("rtree_triangulation_geom", tables)
        self.assertEqual(base.execute("pragma integrity_check").fetchall(), [("ok",)])
        base.close()
        self.assertEqual([name for name in self.files() if name.startswith("a.")], ["a.gpkg"])

    def test_a_spatial_index_can_be_left_out(self):
        self.stored(self.xyz(n=50), "--dim", "2")
        base = sqlite3.connect(self.export("a.gpkg", "--no-index"))
        self.assertEqual(base.execute("select name from sqlite_master where name like 'rtree%'").fetchall(), [])
        base.close()

    def test_columns_of_the_table_are_those_of_the_authors(self):
        self.stored(self.xyz(n=50), "--dim", "2")
        path = self.export("a.csv")
        self.assertEqual(path.read_text().splitlines()[0], "geom,tid,local,main,v0,v1,v2")
        self.assertEqual([name for name in self.files() if name.startswith("a.")], ["a.csv", "a.vrt"])

    def test_the_index_of_a_table_is_xml_whatever_its_file_is_called(self):
        self.stored(self.xyz(n=50), "--dim", "2")
        for name in ("café & Söhne".encode(), "café".encode("latin-1"), b"mixed \xc3\xa9 \xe9"):
            self.export(os.fsdecode(name + b".csv"))
            vrt = os.fsencode(self.folder) + b"/" + name + b".vrt"
            with open(vrt, "rb") as file:
                source = ElementTree.parse(file).find("OGRVRTLayer/SrcDataSource").text
            self.assertIn(name + b".csv", (source.encode(), source.encode("latin-1", "replace")))
            done = subprocess.run([b"ogrinfo", b"-so", b"-al", vrt], capture_output=True)
            self.assertEqual(done.returncode, 0, name)
            self.assertRegex(done.stdout, rb"Feature Count: [1-9]", name)


if __name__ == "__main__":
    unittest.main()
