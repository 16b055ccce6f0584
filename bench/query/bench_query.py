"""Questions to a result beside SciPy's, on the same points in the same run.

    bench_query.py BUILD [-n POINTS] [-q QUESTIONS] [--tiles N] [--threads N] [--skip-scipy]

Makes a cloud, its result and questions in a temporary folder. Prints a table of amounts a second, and how many times
SciPy's that is: SciPy is given the questions in random order, and once more row by row, where one answer is near the
next. Processor seconds are told beside those on the wall, for machines that do other things. SciPy's time to triangulate
does not count; all of its answers are compared with ours.
"""

import argparse
import json
import pathlib
import subprocess
import tempfile
import time

import numpy


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("build", type=pathlib.Path)
    parser.add_argument("-n", default="200k")
    parser.add_argument("-q", type=int, default=1_000_000)
    parser.add_argument("--tiles", default="8")
    parser.add_argument("--threads", default="2")
    parser.add_argument("--skip-scipy", action="store_true")
    args = parser.parse_args()
    tessera, bench = args.build / "src/front/apps/tessera", args.build / "bench/query/bench_query"
    with tempfile.TemporaryDirectory(prefix="bench-query-") as folder:
        folder = pathlib.Path(folder)
        subprocess.run([tessera, "generate", "terrain", "-n", args.n, "-o", folder / "cloud.las", "--quiet"], check=True)
        subprocess.run([tessera, "triangulate", folder / "cloud.las", "-o", folder / "out", "--dim", "2", "--tiles",
                        args.tiles, "--quiet"], check=True)
        subprocess.run([tessera, "export", folder / "out", "-o", folder / "all", "--format", "npy", "--quiet"], check=True)
        points = numpy.load(folder / "all/points.npy")
        rng = numpy.random.default_rng(1)
        asked = points.min(0) + (points.max(0) - points.min(0)) * rng.random((args.q, 2))
        asked.tofile(folder / "asked.bin")
        rows = [json.loads(line) for line in subprocess.run(
            [bench, folder / "out", folder / "asked.bin", "--threads", args.threads, "--value", "z"], check=True,
            capture_output=True, text=True).stdout.splitlines()]
        scipy = {} if args.skip_scipy else ask_scipy(points, numpy.load(folder / "all/z.npy"), asked, folder, tessera)
        print(f"{len(points)} points in 2D, {args.tiles} tiles, {args.q} questions, {args.threads} threads")
        for row in rows:
            # What all threads would do on processors of their own.
            alone = row["cpu_seconds"] / (1 if row["what"] == "cells" else int(args.threads))
            line = (f"{row['what']:8} {row['state']:5} {row['seconds']*1000:9.1f} ms {row['amount']/row['seconds']/1e6:6.2f} M/s; "
                    f"by processor time {alone*1000:9.1f} ms {row['amount']/alone/1e6:6.2f} M/s")
            for theirs in scipy.get(row["what"], ()):
                line += f"; SciPy {args.q/theirs/1e6:.3f} M/s, {theirs/alone:.0f} times"
            print(line)


def ask_scipy(points, values, asked, folder, tessera):
    from scipy.interpolate import LinearNDInterpolator
    from scipy.spatial import Delaunay

    # Near the origin: Qhull loses itself in coordinates of a map, and answers are then slow and wrong.
    near = asked - points.min(0)
    triangulation = Delaunay(points - points.min(0))
    assert triangulation.transform is not None  # it is made when first asked for
    rows = numpy.lexsort((near[:, 0], (near[:, 1] / near[:, 1].max() * 400).astype(int)))
    begin = time.process_time()
    triangulation.find_simplex(near[rows])
    in_rows = time.process_time() - begin
    begin = time.process_time()
    cells = triangulation.find_simplex(near)
    located = time.process_time() - begin
    interpolator = LinearNDInterpolator(triangulation, values)
    begin = time.process_time()
    theirs = numpy.empty(len(near))
    theirs[rows] = interpolator(near[rows])
    interpolated = time.process_time() - begin

    numpy.save(folder / "asked.npy", asked)
    subprocess.run([tessera, "query", folder / "out", "locate", "--points", folder / "asked.npy", "-o", folder / "cells.npy"], check=True)
    subprocess.run([tessera, "query", folder / "out", "interpolate", folder / "asked.npy", "--value", "z", "-o",
                    folder / "values.npy"], check=True)
    ours = numpy.load(folder / "cells.npy")
    number = dict(zip(numpy.load(folder / "all/ids.npy").tolist(), range(len(points))))
    inside = (ours[:, 1] >= 0) & (cells >= 0)
    mine = numpy.sort(numpy.vectorize(number.get)(ours[inside, 2:]), axis=1)
    same = (mine == numpy.sort(triangulation.simplices[cells[inside]], axis=1)).all(1)
    values = numpy.load(folder / "values.npy")
    both = ~numpy.isnan(values) & ~numpy.isnan(theirs)
    print(f"cells as SciPy's: {same.sum()} of {len(same)}, inside by one alone: {((ours[:, 1] >= 0) != (cells >= 0)).sum()}; "
          f"values: largest difference {numpy.abs(values[both] - theirs[both])[numpy.flatnonzero(inside[both])].max() if both.any() else 0:.3g}, "
          f"median {numpy.median(numpy.abs(values[both] - theirs[both])):.3g}")
    return {"locate": (in_rows, located), "linear": (interpolated,)}


if __name__ == "__main__":
    main()
