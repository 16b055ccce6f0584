"""The command blocks of the documents work as they stand, one after the other, in a folder that has what their names say."""
import os
import pathlib
import re
import shlex
import shutil
import subprocess
import tempfile
import unittest

import h5py
import numpy as np
from osgeo import ogr, osr

SOURCE = pathlib.Path(os.environ["SOURCE"])
TESSERA = pathlib.Path(os.environ["TESSERA"])
CLOUDS = SOURCE / "tests/data/clouds"
CORNER = (770500, 6277500)
BOX = "770500,6277500,770520,6277520"
ogr.UseExceptions()

# Pages whose commands other tests type along.
ELSEWHERE = {
    "tutorial.md": "tests/apps/tutorial_test.py", "paraview.md": "tests/apps/tutorial_test.py", "service.md": "tests/daemon/guide_test.py",
}
# Pages whose commands are not run, and why.
NOT_RUN = {
    "benchmarks.md": "they measure: hours, and clouds of up to a billion points", "cluster-trials.md": "they measure",
    "cluster.md": "they need several machines; tests/daemon/local_cluster.py starts the daemons of a cluster",
    "operations.md": "they install services; deploy/try-packages.sh and deploy/try-container.sh do so in clean systems",
    "qgis.md": "tests/qgis runs all algorithms",
    "remote.md": "they need servers; cli_objects_test, cli_s3_test, cli_far_test and cli_nginx_test in tests/apps have their own",
}
# Commands for a daemon, which tests/daemon/guide_test.py has, for other servers, and measurements.
LEFT_OUT = re.compile(r"--server|NAME |hills|\bURL\b|https://|s3://")


def commands_of(text):
    """The commands of a page: indented lines that begin with the program, and lines of blocks for a shell. What stands three spaces
    behind is a comment."""
    lines = re.findall(r"^    (tessera .*)$", text, re.MULTILINE)
    blocks = re.findall(r"^```sh\n(.*?)^```", text, re.MULTILINE | re.DOTALL)
    return [re.split(r" {3,}", line)[0] for line in lines + [line for block in blocks for line in block.splitlines()]]


class Folder:
    """What the pages take for granted, by name."""

    def __init__(self, folder):
        self.folder = folder
        (folder / "data").symlink_to(SOURCE / "data")
        programs = folder / "programs"
        programs.mkdir()
        (programs / "tessera").symlink_to(TESSERA)
        self.environment = {k: v for k, v in os.environ.items() if not k.startswith("TESSERA")} | {"PATH": f"{programs}:{os.environ['PATH']}"}

    def run(self, command):
        return subprocess.run(["bash", "-c", command], cwd=self.folder, env=self.environment, text=True, capture_output=True, timeout=300)

    def made(self, command):
        done = self.run(command)
        if done.returncode:
            raise AssertionError(f"{command}\n{done.stderr}")

    def cloud(self, name, cloud="ign_77050_627755.laz"):
        (self.folder / name).parent.mkdir(exist_ok=True)
        (self.folder / name).symlink_to(CLOUDS / cloud)

    def result(self, name, options, crop=f"--crop {BOX}"):
        self.made(f"tessera triangulate {CLOUDS}/ign_77050_627755.laz -o {name}/ {crop} --quiet {options}")

    def geojson(self, name, kind, places):
        ring = [[CORNER[0] + x, CORNER[1] + y] for x, y in places]
        coordinates = ring if kind == "LineString" else [ring + ring[:1]]
        (self.folder / name).write_text(f'{{"type": "{kind}", "coordinates": {coordinates}}}')

    def geopackage(self, name, places, heights=None):
        system = osr.SpatialReference()
        system.ImportFromEPSG(2154)
        source = ogr.GetDriverByName("GPKG").CreateDataSource(str(self.folder / name))
        layer = source.CreateLayer("areas", system, ogr.wkbPolygon if heights is None else ogr.wkbPolygon25D)
        ring = ogr.Geometry(ogr.wkbLinearRing)
        for x, y in [*places, places[0]]:
            ring.AddPoint(x, y, heights) if heights is not None else ring.AddPoint_2D(x, y)
        polygon = ogr.Geometry(ogr.wkbPolygon if heights is None else ogr.wkbPolygon25D)
        polygon.AddGeometry(ring)
        feature = ogr.Feature(layer.GetLayerDefn())
        feature.SetGeometry(polygon)
        layer.CreateFeature(feature)

    def table(self, name, head, rows):
        np.savetxt(self.folder / name, rows, "%.9g", ",", header=head, comments="")


SQUARE = [(2, 2), (12, 2), (12, 12), (2, 12)]


def ground_and_out(here):
    here.result("ground", "--dim 2 --class 2,9 --attributes intensity")
    here.result("out", "--attributes all")
    here.cloud("block/a.laz")


def gas(here):
    ground_and_out(here)
    chance = np.random.default_rng(1)
    here.table("galaxy.csv", "x,y,z", chance.normal(0, 8, (500, 3)))
    here.table("gas.csv", "x,y,z,mass,temperature,vx,vy,vz", np.hstack([chance.random((500, 3)) * 5000, chance.random((500, 5))]))
    here.made("tessera triangulate galaxy.csv -o galaxy/ --quiet && tessera triangulate gas.csv -o gas/ --attributes all --quiet"
              " && tessera triangulate galaxy.csv -o box/ --periodic 100 --quiet")


def inputs(here):
    here.cloud("block/a.laz")
    shutil.copy(SOURCE / "data/ign/ign_77050_627760.las", here.folder / "block/b.las")
    here.cloud("more.ply", "csf_sample_begin.ply")
    here.cloud("scan/a.ply", "csf_sample_begin.ply")
    (here.folder / "files.txt").write_text("block/a.laz\nblock/b.las\n")
    (here.folder / "scan.xyz").write_text("0 0 0\n1 0 0\n0 1 0\n0 0 1\n1 1 1\n")
    here.made("gzip -k scan.xyz")


def questions(here):
    here.result("ground", "--dim 2 --class 2,9")
    here.result("out", "", crop="")
    here.cloud("where.laz")
    here.geojson("area.geojson", "Polygon", SQUARE)
    here.table("points.csv", "x,y", np.array(SQUARE) + CORNER)


def surfaces(here):
    here.cloud("block/a.laz")
    here.cloud("scan.ply", "csf_sample_begin.ply")


def terrain(here):
    ground_and_out(here)
    here.cloud("forest/a.laz")
    here.cloud("tile.laz")
    here.geojson("road.geojson", "LineString", [(2, 2), (12, 12)])


def updates(here):
    here.cloud("old.laz")
    here.cloud("new.laz", "ign_77050_627760.laz")
    for name in ("new/a.laz", "plot.laz"):
        here.cloud(name, "ign_77055_627755.laz")
    here.cloud("corrected.laz", "ign_77055_627760.laz")
    here.made("tessera triangulate old.laz -o out/ --dim 2 --attributes all --quiet")
    np.save(here.folder / "ids.npy", np.arange(0, 1000, 7))
    here.geojson("site.geojson", "Polygon", SQUARE)


def volumes(here):
    ground_and_out(here)
    for name, options in (("before", "--class 2"), ("after", "--keep highest"), ("roof", "--returns first"), ("scan", "--class 2")):
        here.result(name, f"--dim 2 {options}")
    for name in ("2023.laz", "2024.laz"):
        here.cloud(name)
    here.geojson("fields.geojson", "Polygon", SQUARE)
    here.geopackage("piles.gpkg", [(x + CORNER[0], y + CORNER[1]) for x, y in SQUARE], 20.5)


def voronoi(here):
    chance = np.random.default_rng(2)
    here.table("stations.csv", "x,y", chance.random((200, 2)) * 20 + CORNER)
    here.table("grains.csv", "x,y,z", chance.random((200, 3)) * 10)
    here.geopackage("country.gpkg", [(x + CORNER[0], y + CORNER[1]) for x, y in SQUARE])
    here.made("tessera triangulate stations.csv -o stations/ --crs EPSG:2154 --quiet && tessera triangulate grains.csv -o grains/ --quiet")


def points_of_ground(here):
    here.made("tessera triangulate data/ign/*.las --dim 2 --class 2 -o made/ --quiet && tessera export made/ -o arrays/ --format npy --quiet")
    heights = np.load(here.folder / "arrays/z.npy")
    here.table("ground.csv", "x,y,z", np.column_stack([np.load(here.folder / "arrays/points.npy")[:, :2], heights]))


def one_file(here):
    here.cloud("block/a.copc.laz")


def places(here):
    here.table("places.csv", "x,y", np.array(SQUARE) + CORNER)


def particles(here):
    chance = np.random.default_rng(3)
    np.save(here.folder / "particles.npy", chance.random((400, 3)) * 100)
    here.table("world.csv", "lon,lat", chance.random((400, 2)) * (360, 170) - (180, 85))
    with h5py.File(here.folder / "snap_064.hdf5", "w") as file:
        header = file.create_group("Header").attrs
        header["NumPart_ThisFile"] = np.array([50, 100], "u4")
        header["BoxSize"] = 100.0
        for number, count in enumerate((50, 100)):
            file[f"PartType{number}/Coordinates"] = np.random.default_rng(number).random((count, 3)) * 100


def fits_table(path, name, columns):
    """A FITS file with one table of doubles; columns of several numbers have them in rows."""
    cards = lambda lines: b"".join(f"{line:80}".encode() for line in [*lines, "END"])
    padded = lambda data: data + bytes(-len(data) % 2880)
    header = lambda lines: cards(lines) + b" " * (-80 * (len(lines) + 1) % 2880)
    card = lambda key, value: f"{key:8}= {value:>20}"
    rows = np.column_stack([np.asarray(values).reshape(-1, 1) if np.ndim(values) == 1 else values for values in columns.values()])
    lines = [card("XTENSION", "'BINTABLE'"), card("BITPIX", 8), card("NAXIS", 2), card("NAXIS1", 8 * rows.shape[1]), card("NAXIS2", len(rows)),
             card("PCOUNT", 0), card("GCOUNT", 1), card("TFIELDS", len(columns)), card("EXTNAME", f"'{name}'")]
    for i, (column, values) in enumerate(columns.items(), 1):
        lines += [card(f"TTYPE{i}", f"'{column}'"), card(f"TFORM{i}", f"'{1 if np.ndim(values) == 1 else np.shape(values)[1]}D'")]
    primary = header([card("SIMPLE", "T"), card("BITPIX", 8), card("NAXIS", 0)])
    path.write_bytes(primary + header(lines) + padded(rows.astype(">f8").tobytes()))


def surveys(here):
    particles(here)
    chance = np.random.default_rng(5)
    ra, dec, z, distance = chance.random(60) * 360, chance.random(60) * 180 - 90, chance.random(60), chance.random(60) * 1000
    fits_table(here.folder / "galaxies.fits", "GALAXIES", {"RA": ra, "DEC": dec, "Z": z})
    fits_table(here.folder / "halos.fits", "HALOS", {"pos": chance.random((60, 3)) * 100, "mass": z})
    fits_table(here.folder / "catalogue.fits", "ALL", {"RA_DEG": ra, "DEC_DEG": dec, "ZSPEC": z, "DIST": distance, "XPOS": dec, "YPOS": z, "ZPOS": ra,
                                                       "CENTRE": chance.random((60, 3))})


def voids(here):
    particles(here)
    here.run("tessera triangulate particles.npy -o out --periodic 100 --quiet")


def snapshot(here):
    chance = np.random.default_rng(5)
    with h5py.File(here.folder / "snap.hdf5", "w") as file:
        header = file.create_group("Header").attrs
        header["NumPart_ThisFile"] = np.array([0, 500], "u4")
        header["BoxSize"] = 100.0
        file["PartType1/Coordinates"] = chance.random((500, 3)) * 100
        file["PartType1/Masses"] = chance.random(500)


def nothing(here):
    pass


PAGES = {
    "alpha.md": ground_and_out, "astronomy-outputs.md": snapshot, "columns.md": ground_and_out, "density.md": gas, "formats.md": inputs, "i-have.md": inputs, "periodic.md": particles, "snapshots.md": surveys, "queries.md": questions,
    "regions.md": one_file, "surfaces.md": surfaces, "terrain.md": terrain, "track.md": ground_and_out, "updates.md": updates,
    "tutorial-voids.md": nothing, "viewer.md": ground_and_out, "volumes.md": volumes, "voids.md": voids, "voronoi.md": voronoi, "instead-of-scipy.md": nothing, "instead-of-startinpy.md": places,
    "instead-of-pdal.md": nothing, "instead-of-lastools.md": nothing, "instead-of-cgal.md": nothing, "instead-of-gmsh.md": nothing,
    "instead-of-gdal-grid.md": points_of_ground,
}


def target_of(command):
    """What the command writes, where it names that."""
    words = shlex.split(command)
    return words[words.index("-o") + 1] if "-o" in words else None


class Commands(unittest.TestCase):
    def test_every_page_with_commands_is_run_here_or_elsewhere_or_says_why_not(self):
        pages = {path.name for path in (SOURCE / "docs").glob("*.md") if commands_of(path.read_text())}
        known = {*PAGES, *ELSEWHERE, *NOT_RUN}
        self.assertEqual(pages - known, set())
        for page, test in ELSEWHERE.items():
            self.assertIn(page, (SOURCE / test).read_text())

    def test_comments_are_no_part_of_a_command(self):
        self.assertEqual(commands_of("a\n\n    tessera info a.las      what is in it\n    ls\n\n```sh\nls -l\n```\n"), ["tessera info a.las", "ls -l"])


def test_of(page, prepare):
    def test(self):
        folder = pathlib.Path(self.enterContext(tempfile.TemporaryDirectory()))
        here = Folder(folder)
        prepare(here)
        for command in commands_of((SOURCE / "docs" / page).read_text()):
            if LEFT_OUT.search(command):
                continue
            target = target_of(command)
            if target and (folder / target).exists():  # of a command before, or of the same name
                shutil.rmtree(folder / target) if (folder / target).is_dir() else (folder / target).unlink()
            done = here.run(command)
            with self.subTest(command):
                self.assertEqual(done.returncode, 0, f"{page}: {command}\n{done.stderr}")
                self.assertTrue(target is None or (folder / target).exists(), f"{page}: {command} writes nothing")
    return test


for _page, _prepare in PAGES.items():
    setattr(Commands, "test_" + re.sub(r"\W", "_", _page.removesuffix(".md")), test_of(_page, _prepare))


class Python(unittest.TestCase):
    @unittest.skipIf(not os.environ.get("TESSERA_PYTHON"), "the Python package is not built")
    def test_the_lines_of_pages_work(self):
        for page in PAGES:
            for block in re.findall(r"^```python\n(.*?)^```", (SOURCE / "docs" / page).read_text(), re.MULTILINE | re.DOTALL):
                done = subprocess.run(["/usr/bin/python3", "-c", block], env=os.environ | {"PYTHONPATH": os.environ["TESSERA_PYTHON"]}, text=True, capture_output=True)
                self.assertEqual(done.returncode, 0, f"{page}\n{done.stderr}")


if __name__ == "__main__":
    unittest.main()
