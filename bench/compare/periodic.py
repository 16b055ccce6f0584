#!/usr/bin/python3
"""Times periodic triangulations, densities and Voronoi volumes, beside the same cloud without a period, CGAL and Voro++.

    bench/compare/periodic.py BUILD [--points 1M] [--kind halos] [--seed 7] [--memory 6G] [--threads 2] [--peers] [--dtfe PROGRAM]

Prints seconds, points/s and peak memory of each command, and its speed without a period / with one. With --peers also
CGAL's Periodic_3_Delaunay_triangulation_3 (compiled here) and voro++ (of Debian), and how far the volumes of Voro++ are
from those of Tessera. With --dtfe also the program DTFE, built elsewhere in double precision, and its densities. The
scratch folder needs some 150 bytes a point.
"""
import argparse
import os
import pathlib
import re
import subprocess
import sys
import tempfile

CGAL_PROGRAM = r"""
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Periodic_3_Delaunay_triangulation_3.h>
#include <CGAL/Periodic_3_Delaunay_triangulation_traits_3.h>
#include <chrono>
#include <cstdio>
#include <vector>
using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Traits = CGAL::Periodic_3_Delaunay_triangulation_traits_3<Kernel>;
int main() {
  std::vector<Kernel::Point_3> points;
  double p[3];
  std::FILE* file = std::fopen("points.bin", "rb");
  while (std::fread(p, sizeof p, 1, file) == 1) points.emplace_back(p[0], p[1], p[2]);
  const auto begin = std::chrono::steady_clock::now();
  CGAL::Periodic_3_Delaunay_triangulation_3<Traits> t(Traits::Iso_cuboid_3(0, 0, 0, 1, 1, 1));
  t.insert(points.begin(), points.end(), true);
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  std::printf("%g %zu\n", seconds, t.number_of_cells());
}
"""


class Bench:
    def __init__(self, options, folder):
        self.options, self.folder = options, folder
        self.build = options.build.resolve()
        self.tessera = self.build / "src/front/apps/tessera"

    def run(self, name, *command, inside=True):
        """Runs a command under time; returns its seconds, and prints what it took."""
        report = self.folder / "time.txt"
        done = subprocess.run(["/usr/bin/time", "-f", "%e %U %S %M", "-o", report, *map(str, command)], cwd=self.folder,
                              text=True, capture_output=True)
        if done.returncode:
            raise SystemExit(f"{command}\n{done.stdout}{done.stderr}")
        wall, user, system, peak = map(float, report.read_text().split())
        if inside:
            self.tell(name, wall, user + system, peak)
        return wall, done.stdout

    def tell(self, name, wall, processor, peak):
        print(f"{name:44} {wall:9.2f} s {processor:9.2f} processor s {self.count / wall:12,.0f} points/s {peak / 1024:8.0f} MiB", flush=True)

    def tessera_alone(self):
        o = self.options
        limits = ["--memory", o.memory, "--threads", o.threads, "--quiet"]
        self.run("", self.tessera, "generate", o.kind, "-n", o.points, "--seed", o.seed, "-o", "points.npy", "--quiet", inside=False)
        self.count = ((self.folder / "points.npy").stat().st_size - 128) // 24  # without the header
        print(f"{self.count:,} points, {o.kind}, seed {o.seed}, --memory {o.memory} --threads {o.threads}", flush=True)
        plain, _ = self.run("triangulate", self.tessera, "triangulate", "points.npy", "-o", "plain", *limits)
        self.run("", "rm", "-r", "plain", inside=False)
        periodic, _ = self.run("triangulate --periodic 1", self.tessera, "triangulate", "points.npy", "-o", "out", "--periodic", 1, *limits)
        print(f"{'speed with a period / without':44} {plain / periodic:9.3f}", flush=True)
        for what in o.measure.split(","):
            self.run(f"measure --{what}", self.tessera, "measure", "out", f"--{what}", *limits)

    def peers(self):
        import numpy as np
        points = np.load(self.folder / "points.npy")
        # As Tessera rounds them: multiples of 2^-51.
        points = np.rint(points * 2.0**51) / 2.0**51
        points.tofile(self.folder / "points.bin")
        (self.folder / "periodic.cc").write_text(CGAL_PROGRAM)
        self.run("", "g++", "-std=c++17", "-O3", "-DNDEBUG", "-DCGAL_NDEBUG", "-frounding-math", "-o", "periodic", "periodic.cc", "-lgmp", "-lmpfr", inside=False)
        took, told = self.run("CGAL Periodic_3, whole program", "./periodic")
        print(f"  CGAL: {told.split()[0]} s without reading, {told.split()[1]} cells", flush=True)
        with open(self.folder / "voro.txt", "w") as text:
            for i, (x, y, z) in enumerate(points):
                text.write(f"{i} {x!r} {y!r} {z!r}\n")
        self.run("voro++ -p -o -c '%i %v'", "voro++", "-p", "-o", "-c", "%i %v", 0, 1, 0, 1, 0, 1, "voro.txt")
        volumes = np.zeros(len(points))
        rows = np.loadtxt(self.folder / "voro.txt.vol")
        volumes[rows[:, 0].astype(int)] = rows[:, 1]
        self.compare("voro++", volumes, "voronoi_volume")

    def dtfe(self):
        import numpy as np
        points = np.load(self.folder / "points.npy")
        with open(self.folder / "dtfe.txt", "w") as text:
            text.write(f"{len(points)}\n0 1 0 1 0 1\n")
            np.savetxt(text, points, "%.17g")
        self.run("DTFE, densities on 128^3", self.options.dtfe, "dtfe.txt", "dtfe", "--grid", 128, "--periodic", "--field", "density", "--input", 111)

    def compare(self, name, found, column):
        import numpy as np
        sys.path.insert(0, str(self.build / "python"))
        import tessera
        with tessera.open(self.folder / "out") as t:
            ours = np.zeros(len(found))
            for tile in t:
                own = ~tile.foreign
                ours[tile.ids[own]] = tile.attributes[column][own]
        error = np.abs(found / ours - 1)
        print(f"  {name}: relative difference of {column}: median {np.median(error):.1e}, most {error.max():.1e}; "
              f"sum of Tessera's {ours.sum():.15g}, of {name} {found.sum():.15g}", flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("build", type=pathlib.Path)
    parser.add_argument("--points", default="1M")
    parser.add_argument("--kind", default="halos")
    parser.add_argument("--seed", default="7")
    parser.add_argument("--memory", default="6G")
    parser.add_argument("--threads", default="2")
    parser.add_argument("--measure", default="density,voronoi")
    parser.add_argument("--peers", action="store_true")
    parser.add_argument("--dtfe", type=pathlib.Path)
    parser.add_argument("--scratch", type=pathlib.Path)
    options = parser.parse_args()
    with tempfile.TemporaryDirectory(dir=options.scratch) as folder:
        bench = Bench(options, pathlib.Path(folder))
        bench.tessera_alone()
        if options.peers:
            bench.peers()
        if options.dtfe:
            bench.dtfe()


if __name__ == "__main__":
    main()
