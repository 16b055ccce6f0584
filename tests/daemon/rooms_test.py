"""Nodes of a cluster with little memory beside others with much: no tile goes where there is no room for it, and who asks for one that
fits nowhere is told at once."""
import json
import os
import pathlib
import re
import unittest

import local_cluster
from daemon import DaemonTest
from local_cluster import Node, free_port

POINTS = os.environ.get("ROOM_POINTS", "400k")


class Rooms(DaemonTest):
    def setUp(self):
        super().setUp()
        self.tessera("certs", "init", "certs")
        self.tessera("certs", "node", "certs", *"abc")
        (self.folder / "inputs").mkdir()
        self.port, self.http = free_port(), free_port()
        self.tessera("generate", "uniform", "-n", POINTS, "-o", "inputs/cloud.npy", "--quiet")

    wait_until = local_cluster.ClusterTest.wait_until
    status = local_cluster.ClusterTest.status
    result = local_cluster.ClusterTest.result

    def start_cluster(self, roles, **memory):
        self.coordinator = self.start(
            "--cluster", f"127.0.0.1:{self.port}", "--certs", str(self.folder / "certs"), "--node-name", "a", "--roles", roles,
            "--memory", memory.pop("a"), listen=f"127.0.0.1:{self.http}", inputs=self.folder / "inputs")
        self.nodes = {name: Node(self, name, self.port, "certs", "--memory", bytes) for name, bytes in memory.items()}
        names = {*memory, *("a" if "node" in roles else "")}
        self.wait_until(lambda: {node["name"] for node in self.coordinator.request("GET", "/v1/nodes")[2]["nodes"]
                                 if node["state"] == "free"} == names, lambda: "not all have come")

    def submit(self, output, tiles):
        return self.coordinator.request(
            "POST", "/v1/processes/triangulate/execution",
            {"inputs": {"inputs": [str(self.folder / "inputs/cloud.npy")], "output": output, **({"tiles": tiles} if tiles else {})}})

    def peak_mib(self, name):
        status = pathlib.Path(f"/proc/{self.nodes[name].process.pid}/status").read_text()
        return int(re.search(r"VmHWM:\s+(\d+) kB", status)[1]) >> 10

    def test_a_small_node_gets_no_tile_that_is_too_large(self):
        self.start_cluster("coordinator,node", a="1G", b="100M", c="1G")
        alone = json.loads(self.tessera("triangulate", "inputs/cloud.npy", "-o", "alone", "--tiles", 4, "--json").splitlines()[-1])
        status, _, job = self.submit("large-tiles", 4)
        self.assertEqual(status, 201, job)
        self.assertEqual(self.result(job["jobID"]), alone["digest"])
        by_node = {node["name"]: node for node in self.status(job["jobID"]).get("figures", {}).get("nodes", [])}
        self.assertEqual(by_node.get("b", {}).get("tilesStored", 0), 0, by_node)
        self.assertLess(self.peak_mib("b"), 100)
        # Of smaller ones it has some, within its memory.
        status, _, job = self.submit("small-tiles", 32)
        self.assertEqual(self.result(job["jobID"]), alone["digest"])
        self.assertLess(self.peak_mib("b"), 105)

    def test_what_no_node_has_room_for_is_refused_when_it_is_submitted(self):
        self.start_cluster("coordinator", a="2G", b="100M", c="110M")
        status, _, problem = self.submit("too-large", 2)
        self.assertEqual(status, 422, problem)
        self.assertRegex(problem["detail"], r"^a tile of 200001 points needs about 12[0-9]M of memory beside what a node needs itself, and no "
                                            r"node has so much: of 2 node c gives a job most, 110M; ask for smaller tiles, or give nodes more memory")
        # Left to choose, the coordinator takes as small ones as they need, though it has more itself.
        status, _, job = self.submit("chosen", None)
        self.assertEqual(status, 201, job)
        self.result(job["jobID"])
        for name in "bc":
            self.assertLess(self.peak_mib(name), 116)


if __name__ == "__main__":
    unittest.main()
