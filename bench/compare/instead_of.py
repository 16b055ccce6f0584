#!/usr/bin/python3
"""Times what the pages docs/instead-of-*.md compare, on the bundled block: other programs, and what replaces them.

    bench/compare/instead_of.py BUILD [NAMES...]      names: scipy, cgal, gmsh, gdal-grid; default: all

Each is run ROUNDS times (3), one after the other; the least seconds and the least processor seconds are printed. Python's lines
are timed by themselves, commands whole. The cloud in 3D is one file of the block, as SciPy takes minutes for all four. It needs SciPy, CGAL, python3-gmsh and gdal-bin of Debian 12.
"""
import json
import os
import pathlib
import resource
import subprocess
import sys
import tempfile
import textwrap

SOURCE = pathlib.Path(__file__).resolve().parents[2]
ROUNDS = int(os.environ.get("ROUNDS", "3"))
TIMED = """
import json, time
begin, used = time.perf_counter(), time.process_time()
{lines}
print(json.dumps([time.perf_counter() - begin, time.process_time() - used]))
"""
POINTS = "import numpy as np\nground, block = np.load('ground.npy'), np.load('block.npy')"

CGAL_PROGRAM = r"""
#include <CGAL/Delaunay_triangulation_3.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <cstdio>
#include <vector>
using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
int main() {
  std::vector<Kernel::Point_3> points;
  double p[3];
  std::FILE* file = std::fopen("block.bin", "rb");
  while (std::fread(p, sizeof p, 1, file) == 1) points.emplace_back(p[0], p[1], p[2]);
  CGAL::Delaunay_triangulation_3<Kernel> triangulation(points.begin(), points.end());
  std::printf("%zu\n", triangulation.number_of_finite_cells());
}
"""


class Here:
    """A folder with the points as the programs want them."""

    def __init__(self, build, folder):
        self.build, self.folder = build.resolve(), folder
        self.tessera = self.build / "src/front/apps/tessera"
        self.environment = os.environ | {"PYTHONPATH": str(self.build / "python"), "PATH": f"{self.tessera.parent}:{os.environ['PATH']}"}
        (folder / "data").symlink_to(SOURCE / "data")

    def make_points(self):
        self.run("tessera triangulate data/ign/*.las --dim 2 --class 2 -o ground/ --quiet")
        self.run("tessera export ground/ -o arrays/ --format npy --quiet")
        self.run("tessera triangulate data/ign/ign_77050_627755.las -o block/ --quiet && tessera export block/ -o solids/ --format npy --quiet")
        import numpy as np
        ground, heights = np.load(self.folder / "arrays/points.npy"), np.load(self.folder / "arrays/z.npy")
        block = np.load(self.folder / "solids/points.npy")
        np.save(self.folder / "ground.npy", ground[:, :2])
        np.save(self.folder / "block.npy", block)
        np.savetxt(self.folder / "ground.csv", np.column_stack([ground[:, :2], heights]), "%.2f", ",", header="x,y,z", comments="")
        block.astype("<f8").tofile(self.folder / "block.bin")

    def run(self, command):
        done = subprocess.run(["bash", "-c", command], cwd=self.folder, env=self.environment, text=True, capture_output=True)
        if done.returncode:
            raise SystemExit(f"{command}\n{done.stdout}{done.stderr}")
        return done.stdout

    def command(self, name, command):
        took = []
        for _ in range(ROUNDS):
            begin, used = resource.getrusage(resource.RUSAGE_CHILDREN), os.times().elapsed
            self.run(command)
            end = resource.getrusage(resource.RUSAGE_CHILDREN)
            took.append((os.times().elapsed - used, end.ru_utime + end.ru_stime - begin.ru_utime - begin.ru_stime))
        self.tell(name, took)

    def lines(self, name, prepare, lines):
        script = self.folder / "lines.py"
        script.write_text(f"{POINTS}\n{textwrap.dedent(prepare)}\n{TIMED.format(lines=textwrap.dedent(lines))}")
        took = [json.loads(self.run(f"/usr/bin/python3 {script}").splitlines()[-1]) for _ in range(ROUNDS)]
        self.tell(name, took)

    @staticmethod
    def tell(name, took):
        print(f"{name:60} {min(wall for wall, _ in took):8.2f} s  {min(used for _, used in took):8.2f} processor s", flush=True)


def scipy(here):
    for name, points in (("2D, 109 183 points", "ground"), ("3D, 73 k points", "block")):
        here.lines(f"scipy.spatial.Delaunay, {name}", "import scipy.spatial", f"scipy.spatial.Delaunay({points})")
        here.lines(f"tessera.Delaunay, {name}", "import tessera", f"tessera.Delaunay({points})")
    grid = "x, y = np.meshgrid(np.arange(770500.25, 770600, .5), np.arange(6277500.25, 6277600, .5))\nvalues = np.arange(float(len(ground)))"
    for module, package in (("scipy.interpolate", "scipy.interpolate"), ("tessera", "tessera")):
        here.lines(f"{module}.LinearNDInterpolator, 40 000 places", f"import {package}\n{grid}", f"{module}.LinearNDInterpolator(ground, values)(x, y)")


def gmsh(here):
    here.lines("gmsh tetrahedralize, 73 k points", "import gmsh\ngmsh.initialize()\ngmsh.option.setNumber('General.Terminal', 0)",
               "gmsh.model.mesh.tetrahedralize(block.ravel())")
    here.lines("tessera.Delaunay, 3D, 73 k points", "import tessera", "tessera.Delaunay(block)")


def cgal(here):
    (here.folder / "program.cc").write_text(CGAL_PROGRAM)
    here.run("g++ -O3 -std=c++17 program.cc -o program -lgmp -lmpfr")
    here.command("CGAL::Delaunay_triangulation_3, 73 k points", "./program")
    here.command("tessera triangulate, 73 k points, 1 thread", "tessera triangulate data/ign/ign_77050_627755.las -o out/ --threads 1 --overwrite --quiet")
    here.command("tessera triangulate, 73 k points, 2 threads", "tessera triangulate data/ign/ign_77050_627755.las -o out/ --threads 2 --overwrite --quiet")


def gdal_grid(here):
    here.run("ogr2ogr -oo X_POSSIBLE_NAMES=x -oo Y_POSSIBLE_NAMES=y -oo AUTODETECT_TYPE=YES ground.gpkg ground.csv")
    here.command("gdal_grid -a linear, 200 x 200 pixels",
                 "gdal_grid -q -a linear:radius=0 -txe 770500 770600 -tye 6277600 6277500 -tr 0.5 0.5 -zfield z ground.gpkg grid.tif")
    here.command("tessera dem of a result, 200 x 200 pixels", "tessera dem ground/ --res 0.5 -o dem.tif --overwrite --quiet")
    here.command("tessera dem of point files, 200 x 200 pixels", "tessera dem data/ign/*.las --class 2 --res 0.5 -o dem.tif --overwrite --quiet")


ALL = {"scipy": scipy, "cgal": cgal, "gmsh": gmsh, "gdal-grid": gdal_grid}

if __name__ == "__main__":
    if len(sys.argv) < 2 or any(name not in ALL for name in sys.argv[2:]):
        sys.exit(__doc__)
    with tempfile.TemporaryDirectory() as scratch:
        place = Here(pathlib.Path(sys.argv[1]), pathlib.Path(scratch))
        place.make_points()
        for chosen in sys.argv[2:] or ALL:
            ALL[chosen](place)
