"""The program whole beside CGAL's and HXT's triangulation alone, in turns, on the same points.

    compare.py BUILD [CLOUD...] [--hxt PROGRAM] [--rounds 3] [--threads 2] [--tiles N] [--store cells|points] [--folder DIR]

CLOUD is a file, or made up: uniform:10M, terrain:3M (default: these two). PROGRAM is hxt_points.c beside this file, built
with HXT's sources as docs/benchmarks.md tells; without it HXT is left out. Ours reads, cuts, triangulates, splays and writes
the result; the others have the points in memory and write nothing. Printed are seconds, peak memory, points a second and
seed, and the ratios of each round: least, median and most.
"""
import argparse
import json
import os
import pathlib
import re
import shutil
import statistics
import subprocess
import tempfile
import time

SEED = 7


def run(command, **more):
    """Standard output, seconds, processor seconds, peak bytes."""
    begin = time.monotonic()
    process = subprocess.Popen(list(map(str, command)), stdout=subprocess.PIPE, text=True, **more)
    told = process.stdout.read()
    _, status, usage = os.wait4(process.pid, 0)
    process.stdout.close()
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode != 0:
        raise SystemExit(f"{' '.join(map(str, command))}: status {process.returncode}")
    return told, time.monotonic() - begin, usage.ru_utime + usage.ru_stime, usage.ru_maxrss * 1024


class Cloud:
    """Its distinct points as doubles, in the order of the file."""

    def __init__(self, args, name, folder):
        self.name, self.tiles = name, args.tiles
        self.points = folder / "points.npy"
        if re.fullmatch(r"(uniform|normal|sphere|terrain):\w+", name):
            kind, count = name.split(":")
            run([args.tessera, "generate", kind, "-n", count, "--seed", SEED, "-o", self.points, "--quiet"])
        else:
            run([args.tessera, "triangulate", name, "-o", folder / "first", "--quiet"])
            run([args.tessera, "export", folder / "first", "-o", folder / "arrays", "--format", "npy", "--quiet"])
            (folder / "arrays/points.npy").rename(self.points)


def ours(args, cloud, folder, threads):
    out = folder / "out"
    tiles = ["--tiles", cloud.tiles] if cloud.tiles else []
    told, seconds, work, peak = run([args.tessera, "triangulate", cloud.points, "-o", out, "--threads", threads, *tiles, "--store", args.store, "--json"],
                                    stderr=subprocess.DEVNULL)
    summary = json.loads(told.splitlines()[-1])
    stored = sum(tile.stat().st_size for tile in (out / "tiles").iterdir())
    shutil.rmtree(out)
    return {"stored": stored, "seconds": seconds, "work": work, "peak": peak, "points": summary["vertices"], "cells": summary["cells"],
            "phases": summary["seconds"], "tiles": summary["tiles"]}


def kernel_and_cgal(args, cloud):
    told = run([args.build / "bench/kernel/bench_kernel", "--file", cloud.points, "--repeat", 1, "--kernel", "flat"])[0]

    def seconds(what):
        return float(re.search(rf"^{what} +([0-9.]+) s", told, re.M)[1])
    return {"cgal": seconds("CGAL"), "kernel": seconds("flat kernel") + seconds("Hilbert order"),
            "cells": int(re.search(r"(\d+) cells", told)[1])}


def one_round(args, cloud, folder):
    figures = kernel_and_cgal(args, cloud)
    for threads in dict.fromkeys((1, args.threads)):
        if args.hxt:
            figures["hxt", threads] = json.loads(run([args.hxt, cloud.points, threads])[0])
        os.sync()
        figures["ours", threads] = ours(args, cloud, folder, threads)
        if args.hxt and figures["hxt", threads]["cells"] != figures["ours", threads]["cells"]:
            print(f"{cloud.name}: HXT has {figures['hxt', threads]['cells']} cells, we {figures['ours', threads]['cells']}")
    return figures


def spread(values):
    return f"{min(values):.2f} {statistics.median(values):.2f} {max(values):.2f}"


def report(args, cloud, rounds):
    many = args.threads
    whole = rounds[0]["ours", many]
    print(f"\n{cloud.name}, {whole['points']} points, {whole['cells']} cells, {whole['tiles']} tiles, seed {SEED}, tiles of {args.store}, {len(rounds)} rounds: least, median, most")
    rows = {"CGAL, 1 thread, s": lambda r: r["cgal"], "kernel and its order, 1 thread, s": lambda r: r["kernel"]}
    for threads in dict.fromkeys((1, many)):
        if args.hxt:
            rows[f"HXT, {threads} threads, s"] = lambda r, t=threads: r["hxt", t]["seconds"]
            rows[f"HXT, {threads} threads, bytes a point"] = lambda r, t=threads: r["hxt", t]["peak_bytes"] / r["hxt", t]["points"]
        rows[f"tessera, {threads} threads, s"] = lambda r, t=threads: r["ours", t]["seconds"]
        rows[f"tessera, {threads} threads, M points/s"] = lambda r, t=threads: r["ours", t]["points"] / r["ours", t]["seconds"] / 1e6
        rows[f"tessera, {threads} threads, bytes a point"] = lambda r, t=threads: r["ours", t]["peak"] / r["ours", t]["points"]
    rows["the result's tiles, bytes a point"] = lambda r: r["ours", many]["stored"] / r["ours", many]["points"]
    for phase in whole["phases"]:
        rows[f"  {phase}, {many} threads, share of its phases"] = lambda r, p=phase: r["ours", many]["phases"][p] / sum(r["ours", many]["phases"].values())
    rows[f"CGAL / tessera with {many} threads"] = lambda r: r["cgal"] / r["ours", many]["seconds"]
    rows["CGAL / kernel and its order"] = lambda r: r["cgal"] / r["kernel"]
    if args.hxt:
        rows[f"HXT / tessera, {many} threads"] = lambda r: r["hxt", many]["seconds"] / r["ours", many]["seconds"]
        rows["HXT / tessera, 1 thread"] = lambda r: r["hxt", 1]["seconds"] / r["ours", 1]["seconds"]
    rows[f"processor time with {many} threads / kernel and its order"] = lambda r: r["ours", many]["work"] / r["kernel"]
    for name, of in rows.items():
        print(f"{name:58} {spread([of(r) for r in rounds])}")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("build", type=pathlib.Path)
    parser.add_argument("clouds", nargs="*", default=["uniform:10M", "terrain:3M"])
    parser.add_argument("--hxt", type=pathlib.Path)
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--tiles")
    parser.add_argument("--store", choices=("cells", "points"), default="cells")
    parser.add_argument("--folder", help="for clouds and results; default: a temporary one")
    args = parser.parse_args()
    args.tessera = args.build / "src/front/apps/tessera"
    for name in args.clouds:
        with tempfile.TemporaryDirectory(prefix="bench-compare-", dir=args.folder) as folder:
            cloud = Cloud(args, name, pathlib.Path(folder))
            report(args, cloud, [one_round(args, cloud, pathlib.Path(folder)) for _ in range(args.rounds)])


if __name__ == "__main__":
    main()
