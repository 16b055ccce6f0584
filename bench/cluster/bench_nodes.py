"""What a network costs: nodes of one thread on this machine beside one process with as many threads, in turns, on the same points; and
what the loss of one of the nodes half-way costs.

    bench_nodes.py BUILD [--kind uniform] [-n 10M] [--nodes 4] [--tiles 64] [--memory 3G] [--rounds 3] [--folder DIR]

--memory is that of a node; the process has that of all nodes. Digests are compared. Seconds are those on the wall from the submission
to the result; seed 7.
"""
import argparse
import json
import os
import pathlib
import shutil
import statistics
import subprocess
import tempfile
import threading
import time


def last_line(command, **more):
    done = subprocess.run(list(map(str, command)), text=True, stdout=subprocess.PIPE, check=True, **more)
    return json.loads(done.stdout.splitlines()[-1])


class Bench:
    def __init__(self, args, folder):
        self.args, self.folder = args, folder
        self.tessera = args.build / "src/front/apps/tessera"
        self.cloud, self.cluster = folder / "inputs" / "cloud.npy", folder / "cluster"
        self.cloud.parent.mkdir()
        subprocess.run([self.tessera, "generate", args.kind, "-n", args.n, "--seed", "7", "-o", self.cloud, "--quiet"], check=True)
        # The command looks for the daemon there.
        os.environ["PATH"] = f"{(args.build / 'src/front/daemon').resolve()}:{os.environ['PATH']}"
        self.up()

    def up(self):
        told = last_line([self.tessera, "cluster", "up", "-n", self.args.nodes, "--threads", 1, "--memory", self.args.memory,
                          "--inputs", self.cloud.parent, self.cluster, "--json"])
        token = pathlib.Path(told["token_file"]).read_text().split()[-1]
        self.server = {**os.environ, "TESSERA_SERVER": told["url"], "TESSERA_TOKEN": token}

    def down(self):
        subprocess.run([self.tessera, "cluster", "down", self.cluster, "--quiet"], check=True)

    def triangulate(self, out, *options, **more):
        begin = time.monotonic()
        summary = last_line([self.tessera, "triangulate", self.cloud, "-o", out, "--tiles", self.args.tiles, *options, "--json"],
                            stderr=subprocess.DEVNULL, **more)
        return time.monotonic() - begin, summary

    def alone(self):
        total = int(self.args.memory[:-1]) * self.args.nodes
        figures = self.triangulate(self.folder / "out", "--threads", self.args.nodes, "--memory", f"{total}{self.args.memory[-1]}")
        shutil.rmtree(self.folder / "out")
        return figures

    def together(self, name, kill_after=None):
        killer = threading.Timer(kill_after or 0, lambda: subprocess.run(
            [self.tessera, "cluster", "kill", self.cluster, "3", "--quiet"], check=True))
        if kill_after:
            killer.start()
        figures = self.triangulate(name, "--server", self.server["TESSERA_SERVER"], env=self.server)
        if kill_after:
            killer.join()
            self.up()  # starts it again
        shutil.rmtree(next(self.cluster.glob(f"**/results/{name}")))
        return figures


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("build", type=pathlib.Path)
    parser.add_argument("--kind", default="uniform")
    parser.add_argument("-n", default="10M")
    parser.add_argument("--nodes", type=int, default=4)
    parser.add_argument("--tiles", default="64")
    parser.add_argument("--memory", default="3G")
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--folder")
    args = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix="bench-nodes-", dir=args.folder) as folder:
        bench = Bench(args, pathlib.Path(folder))
        ratios, costs = [], []
        try:
            for i in range(args.rounds):
                one, alone = bench.alone()
                os.sync()
                many, together = bench.together(f"whole-{i}")
                os.sync()
                fewer, lost = bench.together(f"fewer-{i}", kill_after=many / 2)
                os.sync()
                if not alone["digest"] == together["digest"] == lost["digest"]:
                    raise SystemExit("the results differ")
                ratios.append(one / many)
                costs.append(fewer / many - 1)
                print(f"one process {one:6.2f} s   {args.nodes} nodes {many:6.2f} s, {together['bytes_between'] / together['points']:.2f} bytes a point "
                      f"between them   one killed half-way {fewer:6.2f} s, {lost['nodes_lost']} lost, {lost['tiles_again']} tiles again", flush=True)
        finally:
            bench.down()
        print(f"{args.kind} {args.n}, {args.tiles} tiles: throughput of {args.nodes} nodes to one process, median {statistics.median(ratios):.3f}; "
              f"a loss costs {100 * statistics.median(costs):.0f} % in the median")


if __name__ == "__main__":
    main()
