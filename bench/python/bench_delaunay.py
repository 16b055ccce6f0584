#!/usr/bin/env python3
"""tessera.Delaunay against scipy.spatial.Delaunay on the same points in the same run.

    PYTHONPATH=build/release/python /usr/bin/python3 bench/python/bench_delaunay.py [--points 10 1000 100000 1000000] [--seed 7]

Uniform random points. The best of several runs: as many as fit into two seconds, at most 2000, at least one for SciPy and
two for tessera. Seconds are processor time, all threads together, which other work on the machine disturbs less.
find_simplex: as many uniform queries as points, at most 10,000, in random order.
"""
import argparse
import time

import numpy as np
import scipy.spatial
import tessera


def best_seconds(work, least):
    times = []
    while len(times) < least or (sum(times) < 2 and len(times) < 2000):
        start = time.process_time()
        work()
        times.append(time.process_time() - start)
    return min(times)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--points", type=int, nargs="+", default=[10, 1000, 100_000, 1_000_000])
    parser.add_argument("--dims", type=int, nargs="+", default=[2, 3])
    parser.add_argument("--seed", type=int, default=7)
    args = parser.parse_args()

    print("| dim | points | triangulate: SciPy s | tessera s | times SciPy | find_simplex: SciPy s | tessera s | times SciPy |")
    print("|--:|--:|--:|--:|--:|--:|--:|--:|")
    for dim in args.dims:
        for n in args.points:
            rng = np.random.default_rng(args.seed)
            points, queries = rng.random((n, dim)), rng.random((min(n, 10_000), dim))
            cells = []
            for module, least in ((scipy.spatial, 1), (tessera, 2)):
                made = best_seconds(lambda: module.Delaunay(points), least)
                tri = module.Delaunay(points)
                tri.find_simplex(queries[:1])  # SciPy prepares its transform at the first call
                cells.append((made, best_seconds(lambda: tri.find_simplex(queries), 1)))
            (made, found), (our_made, our_found) = cells
            print(f"| {dim} | {n} | {made:.3g} | {our_made:.3g} | **{made / our_made:.1f}** | {found:.3g} | {our_found:.3g} | "
                  f"{found / our_found:.1f} |", flush=True)


if __name__ == "__main__":
    main()
