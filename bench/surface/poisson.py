#!/usr/bin/python3
"""A closed surface of airborne-like points, from their file to that of the mesh: tessera surface beside Open3D's screened
Poisson reconstruction (python3-open3d), one after the other on this machine. The depth of Poisson's tree is the one that
gives the nearest number of vertices.

    poisson.py BUILD [--points 3000000] [--seed 7] [--depths 9,10,11] [--file CLOUD.ply] [--memory 1G]
"""
import argparse
import json
import math
import pathlib
import subprocess
import sys
import tempfile
import time

POISSON = """
import sys, open3d
cloud = open3d.io.read_point_cloud(sys.argv[1])
cloud.estimate_normals(open3d.geometry.KDTreeSearchParamKNN(16))
cloud.orient_normals_to_align_with_direction([0.0, 0.0, 1.0])
mesh, _ = open3d.geometry.TriangleMesh.create_from_point_cloud_poisson(cloud, depth=int(sys.argv[3]))
open3d.io.write_triangle_mesh(sys.argv[2], mesh)
print(len(mesh.vertices))
"""


def run(*command):
    """Seconds, peak memory in bytes, and what it printed last."""
    begun = time.monotonic()
    done = subprocess.run(["/usr/bin/time", "-f", "peak %M", *map(str, command)], text=True, capture_output=True)
    seconds = time.monotonic() - begun
    if done.returncode != 0:
        sys.exit(done.stderr)
    peak = int([line for line in done.stderr.splitlines() if line.startswith("peak ")][-1].split()[1]) * 1024
    return seconds, peak, done.stdout.strip().splitlines()[-1]


def told(name, points, seconds, peak, vertices):
    print(f"{name}: {vertices:,} vertices, {seconds:.1f} s, {points / seconds:,.0f} points/s, {peak / 2**30:.2f} GiB", flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("build", type=pathlib.Path)
    parser.add_argument("--points", type=int, default=3_000_000)
    parser.add_argument("--seed", type=int, default=7)
    parser.add_argument("--depths", default="9,10,11")
    parser.add_argument("--file", type=pathlib.Path)
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--memory")
    options = parser.parse_args()
    tessera = options.build / "src/front/apps/tessera"
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        cloud = options.file or folder / "cloud.ply"
        if not options.file:
            run(tessera, "generate", "terrain", "--points", options.points, "--seed", options.seed, "-o", cloud, "--json")
        points = json.loads(subprocess.run([tessera, "info", cloud, "--json"], text=True, capture_output=True, check=True).stdout)["points"]
        print(f"{points:,} points, seed {options.seed}")
        seconds, peak, printed = run(tessera, "surface", cloud, "-o", folder / "mesh.ply", "--threads", options.threads, "--json",
                                     *(["--memory", options.memory] if options.memory else []))
        vertices = json.loads(printed)["vertices"]
        told("tessera surface", points, seconds, peak, vertices)
        others = []
        for depth in options.depths.split(","):
            other = run("/usr/bin/python3", "-c", POISSON, cloud, folder / "other.ply", depth)
            others.append((abs(math.log(int(other[2]) / vertices)), other))
            told(f"Open3D, Poisson, depth {depth}", points, other[0], other[1], int(other[2]))
        other = min(others)[1]
        print(f"tessera / Open3D at {int(other[2]):,} vertices: time {seconds / other[0]:.2f}, memory {peak / other[1]:.2f}")


if __name__ == "__main__":
    main()
