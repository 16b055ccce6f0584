"""Results on maps: OGC API - Features as GDAL's own driver reads it, pages, boxes, places on the earth; tiles of pictures."""
import json
import math
import subprocess
import unittest
import urllib.parse

import numpy as np

from daemon import DaemonTest

INPUTS = {"inputs": ["ign_77050_627755.las"], "crs": "EPSG:2154", "class": [2]}


def run(*args, text=None):
    done = subprocess.run(list(map(str, args)), input=text, text=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    assert done.returncode == 0, (args, done.stderr)
    return done.stdout


def points_of(feature):
    coordinates = feature["geometry"]["coordinates"]
    return np.array(coordinates[0] if feature["geometry"]["type"] == "Polygon" else coordinates)[:, :2]


def meets(points, box):
    """Whether the line through the points and the box have a point in common, by its sides and corners."""
    west, south, east, north = box
    inside = (points[:, 0] >= west) & (points[:, 0] <= east) & (points[:, 1] >= south) & (points[:, 1] <= north)
    if inside.any():
        return True
    corners = [(west, south), (east, south), (east, north), (west, north)]

    def side(a, b, p):
        return np.sign((b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0]))
    return any(side(a, b, c) * side(a, b, d) < 0 and side(c, d, a) * side(c, d, b) < 0
               for a, b in zip(points, points[1:]) for c, d in zip(corners, corners[1:] + corners[:1]))


class Maps(DaemonTest):
    def setUp(self):
        super().setUp()
        self.daemon = self.start()
        self.execute("triangulate", **INPUTS, dim=2, output="ground", tiles=6)

    def execute(self, process, **inputs):
        status, _, job = self.daemon.request("POST", f"/v1/processes/{process}/execution", {"inputs": inputs})
        self.assertEqual(status, 201, job)
        self.assertEqual(self.daemon.wait(job["jobID"])["status"], "successful")

    def get(self, path, status=200, **headers):
        answer = self.daemon.request("GET", path, None, headers)
        self.assertEqual(answer[0], status, answer[2])
        return answer[2]

    def all_items(self, path):
        found = []
        while path:
            page = self.get(path)
            self.assertEqual(page["numberReturned"], len(page["features"]))
            found += page["features"]
            following = [link["href"] for link in page["links"] if link["rel"] == "next"]
            path = following[0].removeprefix(self.daemon.url.rstrip("/")) if following else None
        return found

    def lon_lat(self, points):
        """By GDAL's program."""
        text = "\n".join(f"{x!r} {y!r}" for x, y in points)
        lines = run("gdaltransform", "-s_srs", "EPSG:2154", "-t_srs", "OGC:CRS84", text=text).splitlines()
        return np.array([list(map(float, line.split()[:2])) for line in lines])

    def test_features_are_where_gdal_says_and_come_in_pages(self):
        self.execute("contours", triangulation="ground", interval=0.25)
        links = {link["rel"]: urllib.parse.urljoin("/v1", link["href"]) for link in self.get("/v1")["links"]}
        self.assertEqual(links["data"], self.daemon.url + "v1/collections")  # GDAL resolves no relative ones
        self.assertIn("http://www.opengis.net/spec/ogcapi-features-1/1.0/conf/core", self.get("/v1/conformance")["conformsTo"])
        listed = self.get("/v1/collections")["collections"]
        self.assertEqual([one["id"] for one in listed], ["ground.tiles", "ground.hull", "ground.contours"])
        for one in listed:
            self.assertEqual(self.get(f"/v1/collections/{one['id']}"), one | {"links": self.get(f"/v1/collections/{one['id']}")["links"]})
            west, south, east, north = one["extent"]["spatial"]["bbox"][0]
            for feature in self.all_items(f"/v1/collections/{one['id']}/items?limit=1000"):
                points = points_of(feature)
                self.assertTrue((points >= (west, south)).all() and (points <= (east, north)).all())
                self.assertEqual(self.get(f"/v1/collections/{one['id']}/items/{feature['id']}")["geometry"], feature["geometry"])
                if feature["id"] > 40:
                    break

        # The hull: that of all points, each of whose corners is one.
        (hull,) = self.all_items("/v1/collections/ground.hull/items")
        box = self.get("/v1/triangulations/ground")["bounds"]
        self.assertEqual(hull["properties"]["vertices"], self.get("/v1/triangulations/ground")["vertices"])
        ring = self.lon_lat([(box[0], box[1]), (box[2], box[3])])
        corners = points_of(hull)
        self.assertLess(abs(corners - ring[0]).min(axis=0).max(), 2e-4)
        self.assertEqual(len(self.all_items("/v1/collections/ground.tiles/items?limit=4")), 6)

        # The lines: those of the file, by GDAL's own reprojection.
        file = self.folder / "data/results/ground/exports/contours.gpkg"
        run("ogr2ogr", "-f", "GeoJSON", "-t_srs", "OGC:CRS84", "-lco", "COORDINATE_PRECISION=12", self.folder / "right.geojson", file)
        right = json.loads((self.folder / "right.geojson").read_text())["features"]
        lines = self.all_items("/v1/collections/ground.contours/items?limit=37")
        self.assertGreater(len(lines), 50)
        self.assertEqual([line["id"] for line in lines], list(range(1, len(right) + 1)))
        for line, other in zip(lines, right):
            self.assertEqual(line["properties"], other["properties"])
            self.assertLess(abs(points_of(line) - points_of(other)).max(), 1e-9)
            self.assertTrue(all(z == line["properties"]["elevation"] for _, _, z in line["geometry"]["coordinates"]))

        # Boxes: exactly the features that meet them.
        west, south, east, north = listed[2]["extent"]["spatial"]["bbox"][0]
        rng = np.random.default_rng(3)
        for _ in range(6):
            xs, ys = sorted(rng.uniform(west, east, 2)), sorted(rng.uniform(south, north, 2))
            box = [xs[0], ys[0], xs[0] + (xs[1] - xs[0]) / 3, ys[0] + (ys[1] - ys[0]) / 3]
            found = self.all_items(f"/v1/collections/ground.contours/items?limit=500&bbox={','.join(map(repr, box))}")
            self.assertEqual([line["id"] for line in found], [line["id"] for line in lines if meets(points_of(line), box)])
        self.assertEqual(self.all_items("/v1/collections/ground.contours/items?bbox=100,10,101,11"), [])
        self.assertEqual(len(self.all_items("/v1/collections/ground.hull/items?bbox=-180,-90,180,90")), 1)
        middle = [(west + east) / 2, (south + north) / 2]
        tiny = ",".join(map(repr, middle + [at + 1e-9 for at in middle]))
        self.assertEqual(len(self.all_items(f"/v1/collections/ground.hull/items?bbox={tiny}")), 1)  # all inside
        for wrong in ("bbox=1,2,3", "bbox=a", "limit=0", "limit=x", "after=-1", "colour=red"):
            self.get(f"/v1/collections/ground.contours/items?{wrong}", 400)
        self.get("/v1/collections/ground.contours/items/999999", 404)
        self.get("/v1/collections/ground.contours/items/0", 404)
        self.get("/v1/collections/ground.contours/items/x", 404)
        self.assertEqual(self.daemon.end(), 0, self.daemon.messages())

    def test_they_are_told_as_the_result_has_them(self):
        """OGC API - Features, part 2."""
        self.execute("contours", triangulation="ground", interval=0.25)
        crs84, lambert = "http://www.opengis.net/def/crs/OGC/1.3/CRS84", "http://www.opengis.net/def/crs/EPSG/0/2154"
        for one in self.get("/v1/collections")["collections"]:
            self.assertEqual((one["crs"], one["storageCrs"]), ([crs84, lambert], lambert))
        items = "/v1/collections/ground.contours/items"
        file = self.folder / "data/results/ground/exports/contours.gpkg"
        run("ogr2ogr", "-f", "GeoJSON", "-lco", "COORDINATE_PRECISION=15", self.folder / "right.geojson", file)
        right = json.loads((self.folder / "right.geojson").read_text())["features"]
        lines = self.all_items(f"{items}?limit=100&crs={lambert}")  # the pages go on in it
        self.assertEqual(len(lines), len(right))
        for line, other in zip(lines, right):
            self.assertLess(abs(points_of(line) - points_of(other)).max(), 1e-8)
        self.assertEqual(self.get(f"{items}/7?crs={lambert}")["geometry"], lines[6]["geometry"])
        bounds = np.array(self.get("/v1/triangulations/ground")["bounds"])
        (hull,) = self.all_items(f"/v1/collections/ground.hull/items?crs={lambert}")
        corners = points_of(hull)
        low, high = bounds[:2], bounds[len(bounds) // 2:][:2]
        self.assertEqual([corners.min(axis=0).tolist(), corners.max(axis=0).tolist()], [low.tolist(), high.tolist()])

        # Boxes of each system, told in each.
        rng = np.random.default_rng(5)
        for _ in range(5):
            start = rng.uniform(low, high)
            end = start + rng.uniform(0, 20, 2)
            box = ",".join(repr(float(at)) for at in (*start, *end))
            wanted = [line["id"] for line in lines if meets(points_of(line), (*start, *end))]
            for told in (crs84, lambert):
                found = self.all_items(f"{items}?limit=1000&bbox={box}&bbox-crs={lambert}&crs={told}")
                self.assertEqual([line["id"] for line in found], wanted)
            degrees = ",".join(repr(float(at)) for at in self.lon_lat([start, end]).ravel())
            right = self.all_items(f"{items}?limit=1000&bbox={degrees}")
            again = self.all_items(f"{items}?limit=1000&bbox={degrees}&bbox-crs={crs84}&crs={lambert}")
            self.assertEqual([line["id"] for line in again], [line["id"] for line in right])
            for line in again:
                self.assertEqual(line, lines[line["id"] - 1])
        for wrong in ("crs=EPSG:2154", "crs=http://www.opengis.net/def/crs/EPSG/0/4326", "bbox-crs=x&bbox=1,2,3,4", "crs="):
            self.get(f"{items}?{wrong}", 400)
        self.get(f"{items}/7?crs=x", 400)
        self.assertEqual(self.daemon.end(), 0, self.daemon.messages())

    def test_where_latitude_comes_first_it_does_so_in_features(self):
        (self.folder / "inputs").mkdir()
        points = np.random.default_rng(2).uniform((2, 48, 0), (3, 49, 10), (50, 3))
        np.savetxt(self.folder / "inputs/a.xyz", points, fmt="%.6f")
        self.assertEqual(self.daemon.end(), 0)
        self.daemon = self.start(inputs=self.folder / "inputs")
        self.execute("triangulate", inputs=["a.xyz"], dim=2, crs="EPSG:4326", output="degrees")
        uri = "http://www.opengis.net/def/crs/EPSG/0/4326"
        self.assertEqual(self.get("/v1/collections/degrees.hull")["storageCrs"], uri)
        items = "/v1/collections/degrees.hull/items"
        (hull,), (swapped,) = self.all_items(items), self.all_items(f"{items}?crs={uri}")
        self.assertLess(abs(points_of(hull) - points_of(swapped)[:, ::-1]).max(), 1e-8)
        self.assertGreater(points_of(swapped)[:, 0].min(), 40)
        self.assertEqual(len(self.all_items(f"{items}?bbox-crs={uri}&bbox=48,2,49,3")), 1)
        self.assertEqual(self.all_items(f"{items}?bbox-crs={uri}&bbox=2,48,3,49"), [])
        self.assertEqual(self.daemon.end(), 0, self.daemon.messages())

    def test_gdal_reads_them_with_the_token_as_its_password(self):
        self.execute("contours", triangulation="ground", interval=0.25)
        place = f"OAPIF:{self.daemon.url}v1"
        login = ("-oo", f"USERPWD=gdal:{self.daemon.token}", "-oo", "PAGE_SIZE=50")
        layers = run("ogrinfo", "-ro", *login, place)
        for name in ("ground.tiles", "ground.hull", "ground.contours"):
            self.assertIn(name, layers)
        told = run("ogrinfo", "-ro", "-so", *login, place, "ground.tiles")
        self.assertIn("Feature Count: 6", told)
        self.assertIn("WGS 84", told)
        file = self.folder / "data/results/ground/exports/contours.gpkg"
        run("ogr2ogr", "-f", "GeoJSON", self.folder / "right.geojson", file)
        run("ogr2ogr", "-f", "GeoJSON", self.folder / "got.geojson", *login, place, "ground.contours")
        right, got = (json.loads((self.folder / name).read_text())["features"] for name in ("right.geojson", "got.geojson"))
        self.assertEqual([line["properties"]["elevation"] for line in got], [line["properties"]["elevation"] for line in right])
        wrong = subprocess.run(["ogrinfo", "-ro", "-oo", "USERPWD=gdal:wrong", place], stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        self.assertNotEqual(wrong.returncode, 0)
        self.assertEqual(self.daemon.end(), 0, self.daemon.messages())

    def picture(self, place, bands, style):
        """The bytes of a tile, and its pixels by GDAL's program."""
        file = self.folder / f"{style}.png"
        file.write_bytes(self.get(f"/v1/triangulations/ground/map/tiles/WebMercatorQuad/{place}?style={style}"))
        run("gdal_translate", "-q", "-of", "ENVI", "-co", "INTERLEAVE=BIP", file, self.folder / "raw")
        return np.frombuffer((self.folder / "raw").read_bytes(), np.uint8).reshape(256, 256, bands).astype(int)

    def test_tiles_show_the_heights_where_they_are(self):
        maps = "/v1/triangulations/ground/map/tiles/WebMercatorQuad"
        self.assertIn("dem.tif", self.get(maps, 404)["detail"])
        self.execute("dem", triangulation="ground", res=0.5)
        tileset = self.get(maps)
        (template,) = [link["href"] for link in tileset["links"] if link["rel"] == "item"]
        self.assertTrue(template.endswith("/{tileMatrix}/{tileRow}/{tileCol}"), template)
        self.assertEqual(self.get("/v1/triangulations/ground/map/tiles")["tilesets"][0]["crs"], tileset["crs"])
        box = self.get("/v1/triangulations/ground")["bounds"]
        lon, lat = self.lon_lat([((box[0] + box[2]) / 2, (box[1] + box[3]) / 2)])[0]
        level = 21
        x = (lon + 180) / 360 * 2 ** level
        y = (1 - math.asinh(math.tan(math.radians(lat))) / math.pi) / 2 * 2 ** level
        column, row = int(x), int(y)
        rgb = self.picture(f"{level}/{row}/{column}", 4, "terrain-rgb")
        self.assertTrue((rgb[:, :, 3] == 255).all())
        heights = -10000 + (rgb[:, :, 0] * 65536 + rgb[:, :, 1] * 256 + rgb[:, :, 2]) / 10
        rng = np.random.default_rng(1)
        pixels = rng.integers(0, 256, (300, 2))
        lons = (column + (pixels[:, 1] + 0.5) / 256) / 2 ** level * 360 - 180
        lats = np.degrees(np.arctan(np.sinh(math.pi * (1 - 2 * (row + (pixels[:, 0] + 0.5) / 256) / 2 ** level))))
        text = "\n".join(f"{a!r} {b!r}" for a, b in zip(lons, lats))
        lines = run("gdaltransform", "-s_srs", "OGC:CRS84", "-t_srs", "EPSG:2154", text=text).splitlines()
        places = [list(map(float, line.split()[:2])) for line in lines]
        surface = self.daemon.request("POST", "/v1/triangulations/ground/interpolate", {"points": places})[2]["answers"]
        away = np.abs([heights[r, c] - one["value"] for (r, c), one in zip(pixels, surface)])
        self.assertLess(np.median(away), 0.1)  # metres; pixels of half a metre between two others
        shade = self.picture(f"{level}/{row}/{column}", 2, "hillshade")
        self.assertTrue((shade[:, :, 1] == 255).all())
        self.assertGreater(shade[:, :, 0].std(), 5)
        # From where there is nothing, and the whole earth.
        self.assertEqual(self.picture("1/1/0", 2, "hillshade").max(), 0)
        self.picture("0/0/0", 2, "hillshade")
        for place in ("1/2/0", "1/0/2", "25/0/0", "x/0/0", "1/-1/0"):
            self.get(f"{maps}/{place}", 404)
        self.get(f"{maps}/1/0/0?style=red", 400)
        self.assertEqual(self.daemon.end(), 0, self.daemon.messages())

    def test_what_only_has_such_a_name_is_not_found(self):
        for name in ("ground", "ground.contours", "none.tiles", "ground.dem", ".tiles", "ground."):
            for path in ("", "/items", "/items/1"):
                self.get(f"/v1/collections/{name}{path}", 404)
        # Without a coordinate system nobody knows where it is; and a raster of light has no heights.
        (self.folder / "inputs").mkdir()
        np.savetxt(self.folder / "inputs/a.xyz", np.random.default_rng(2).random((50, 3)))
        self.execute("dem", triangulation="ground", res=2, hillshade=True)
        self.get("/v1/triangulations/ground/map/tiles/WebMercatorQuad/1/0/0", 404)
        self.execute("export", triangulation="ground", output="contours.gpkg")
        self.get("/v1/collections/ground.contours/items", 404)
        self.assertEqual([one["id"] for one in self.get("/v1/collections")["collections"]], ["ground.tiles", "ground.hull"])
        (self.folder / "data/results/ground/exports/contours.gpkg").write_bytes(b"SQLite format 3\0" + bytes(5000))
        self.get("/v1/collections/ground.contours", 404)
        (self.folder / "data/results/ground/exports/dem.tif").write_bytes(b"II*\0" + bytes(100))
        self.get("/v1/triangulations/ground/map/tiles", 404)
        self.get("/v1/triangulations/none/map/tiles", 404)
        self.assertEqual(self.daemon.end(), 0)
        self.daemon = self.start(inputs=self.folder / "inputs")
        self.execute("triangulate", inputs=["a.xyz"], dim=2, output="nowhere.tiles")
        self.get("/v1/collections/nowhere.tiles", 404)
        self.get("/v1/collections/nowhere.tiles.tiles", 404)
        self.assertEqual(len(self.get("/v1/collections")["collections"]), 2)
        self.assertEqual(self.daemon.end(), 0, self.daemon.messages())


if __name__ == "__main__":
    unittest.main()
