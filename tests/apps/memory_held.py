#!/usr/bin/python3
"""Runs the command with small budgets and watches its resident memory. A run holds its budget within 5 %, or it is
refused at the start with status 7 and a figure, with which it then runs and holds that.

    memory_held.py --tessera build/release/src/front/apps/tessera                       what is tried by default, in seconds
    memory_held.py --tessera ... --random 50 --seed 3                             so many drawn at random as well
    memory_held.py --tessera ... --cloud scan.laz --memory 200M --threads 8 [--extra=--tiles=64]
    memory_held.py --tessera ... --cloud uniform:10M --memory 200M --threads 2    made by 'tessera generate'
"""
import argparse
import os
import pathlib
import random
import re
import shutil
import subprocess
import sys
import tempfile
import time

MIB = 1 << 20
REFUSED = 7  # docs/exit-status.md: the job cannot be done within --memory


def bytes_of(size):
    return float(size[:-1]) * {"M": MIB, "G": MIB << 10}[size[-1]]


def run(tessera, args):
    """Exit status, highest resident memory in bytes and stderr of one fresh process."""
    clean = {k: v for k, v in os.environ.items() if not k.startswith("TESSERA")}
    process = subprocess.Popen([str(tessera), *map(str, args)], stderr=subprocess.PIPE, env=clean)
    words = process.stderr.read().decode()
    process.stderr.close()
    _, status, usage = os.wait4(process.pid, 0)  # of this child alone; getrusage() tells the highest of all children
    process.returncode = os.waitstatus_to_exitcode(status)
    return process.returncode, usage.ru_maxrss * 1024, words.strip()


class Held:
    def __init__(self, tessera, folder):
        self.tessera, self.folder, self.made, self.failures = tessera, folder, {}, 0
        print(f"{'cloud':36} {'threads':>7} {'memory':>7} {'peak':>10} {'ratio':>6} {'time':>7}")

    def cloud(self, name):
        """KIND:N[:FORMAT], or `duplicates:N`, or a file."""
        if ":" not in name:
            return name
        if name not in self.made:
            kind, n, *form = name.split(":")
            path = self.folder / f"{kind}-{n}.{form[0] if form else 'npy'}"
            if kind == "duplicates":  # nine of ten points are equal to one of the rest
                rng = random.Random(5)
                few = [" ".join(f"{rng.random():.9f}" for _ in range(3)) for _ in range(int(n) // 10)]
                path = path.with_suffix(".xyz")
                path.write_text("\n".join(few + [rng.choice(few) for _ in range(int(n) - len(few))]) + "\n")
            else:
                status, _, words = run(self.tessera, ["generate", kind, "-n", n, "-o", path, "--quiet"])
                assert status == 0, words
            self.made[name] = path
        return self.made[name]

    def fail(self, why):
        self.failures += 1
        print(f"    FAILED: {why}")

    def holds(self, cloud, memory, threads, extra=(), after_refusal=False):
        out = self.folder / "out"
        began = time.time()
        status, peak, words = run(self.tessera, ["triangulate", self.cloud(cloud), "-o", out, "--memory", memory,
                                                 "--threads", threads, "--quiet", *extra])
        shutil.rmtree(out, ignore_errors=True)
        ratio = peak / bytes_of(memory)
        name = " ".join([pathlib.Path(cloud).name, *extra])
        print(f"{name:36} {threads:7} {memory:>7} {peak / MIB:6.1f} MiB {ratio:6.2f} {time.time() - began:5.1f} s"
              f"{'' if status == 0 else '  ' + words}", flush=True)
        if status == 0:
            if ratio > 1.05:
                self.fail("more than 5 % above the budget")
            return
        figure = re.search(r"at least (\d+M)", words)
        if status != REFUSED or not figure or words.count("\n") > 0:
            return self.fail(f"status {status} without a figure that would do")
        if after_refusal:
            return self.fail("refused with the figure that was said to do")
        self.holds(cloud, figure[1], threads, extra, after_refusal=True)


def by_default(held):
    for cloud, memory, threads, *extra in [
            ("terrain:60k:las", "24M", 1), ("terrain:60k:las", "64M", 4), ("terrain:60k:las", "64M", 1, "--dim=2"),
            ("terrain:60k:las", "64M", 2, "--attributes=intensity,classification", "--max-points-per-tile=5000"),
            ("uniform:60k:xyz", "64M", 2), ("uniform:60k:xyz", "40M", 8, "--dim=2"),
            ("uniform:60k:ply", "100M", 4, "--tiles=30"), ("uniform:60k:ply", "20M", 1, "--tiles=2"),
            ("sphere:40k", "64M", 2), ("uniform:60k:ply", "64M", 1, "--kernel=cgal"), ("duplicates:80000", "48M", 1),
            ("uniform:200:xyz", "1M", 1), ("uniform:200:xyz", "1M", 8)]:
        held.holds(cloud, memory, threads, extra)


def at_random(held, runs, rng):
    for _ in range(runs):
        kind = rng.choice(["uniform", "normal", "sphere", "grid", "terrain"])
        n = rng.choice(["2k", "20k", "100k", "300k", "700k"])
        extra = rng.choice([[], [], ["--dim=2"], [f"--tiles={rng.choice([2, 9, 30])}"], ["--kernel=cgal"],
                            [f"--max-points-per-tile={rng.choice([5000, 40000])}"], ["--partition=octree"],
                            ["--partition=grid"]])
        held.holds(f"{kind}:{n}:{rng.choice(['las', 'ply', 'xyz', 'npy'])}",
                   f"{rng.choice([30, 40, 50, 64, 80, 100, 150, 200, 300, 600])}M", rng.choice([1, 2, 4, 8]), extra)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--tessera", required=True, type=pathlib.Path)
    parser.add_argument("--cloud")
    parser.add_argument("--memory", default="200M")
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--extra", action="append", default=[])
    parser.add_argument("--random", type=int, default=0)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--folder", help="where clouds and results are written")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix="tessera-memory-", dir=options.folder) as folder:
        held = Held(options.tessera, pathlib.Path(folder))
        if options.cloud:
            held.holds(options.cloud, options.memory, options.threads, options.extra)
        else:
            by_default(held)
            at_random(held, options.random, random.Random(options.seed))
    sys.exit(1 if held.failures else 0)


if __name__ == "__main__":
    main()
