#!/usr/bin/env python3
"""Clouds whose coordinates have extreme exponents: processor time of the flat kernel beside CGAL's, in one run.

    /usr/bin/python3 bench/kernel/bench_extremes.py build/release [--seed 1]
"""
import argparse
import pathlib
import re
import subprocess
import tempfile

import numpy


def clouds(seed):
    random = numpy.random.default_rng(seed)

    def signs(shape):
        return random.choice([-1, 1], shape)
    exponents = random.integers(-1063, 1023, (600, 3))
    lattice = numpy.stack(numpy.meshgrid(numpy.arange(50.0), numpy.arange(50.0)), -1).reshape(-1, 2)
    return {
        "any-exponent": (numpy.ldexp(random.random((600, 3)) + 0.5, exponents) * signs((600, 3)), (1, 7, 64)),
        "exponential": (numpy.exp(random.uniform(-300, 300, (3000, 3))) * signs((3000, 3)), (1, 7)),
        "lattice-and-point": (numpy.vstack([numpy.c_[lattice, numpy.zeros(2500)], [[3.3, 4.4, 1e-300]]]), (1,)),
    }


def measure(tessera, cloud, tiles, kernel, out):
    done = subprocess.run(["/usr/bin/time", "-f", "%U %M", tessera, "triangulate", cloud, "-o", out, "--tiles", str(tiles), "--threads", "1",
                           "--kernel", kernel, "--overwrite", "--quiet"], check=True, text=True, stderr=subprocess.PIPE)
    seconds, kibibytes = done.stderr.split()[-2:]
    info = subprocess.run([tessera, "info", out], check=True, text=True, stdout=subprocess.PIPE).stdout
    return float(seconds), int(kibibytes) / 1024, re.search(r"digest\s+(\w+)", info)[1]


def main():
    options = argparse.ArgumentParser()
    options.add_argument("build", type=pathlib.Path)
    options.add_argument("--seed", type=int, default=1)
    options = options.parse_args()
    tessera = options.build.resolve() / "src/front/apps/tessera"
    print(f"seed {options.seed}\n{'cloud':18} tiles  flat, s  CGAL, s  flat / CGAL  points/s  peak, MiB")
    with tempfile.TemporaryDirectory() as folder:
        for name, (points, counts) in clouds(options.seed).items():
            cloud = pathlib.Path(folder, f"{name}.npy")
            numpy.save(cloud, points)
            for tiles in counts:
                flat, peak, digest = measure(tessera, cloud, tiles, "flat", pathlib.Path(folder, "flat"))
                cgal, _, other = measure(tessera, cloud, tiles, "cgal", pathlib.Path(folder, "cgal"))
                if digest != other:
                    raise SystemExit(f"{name}, {tiles} tiles: the kernels differ")
                print(f"{name:18} {tiles:5} {flat:8.2f} {cgal:8.2f} {flat / cgal:12.2f} {len(points) / flat:9.0f} {peak:10.0f}")


if __name__ == "__main__":
    main()
