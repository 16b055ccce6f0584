"""Nodes are drained and begin anew, one after the other, while a job runs: nothing of it begins again, and its result is the command's."""
import json
import os
import re
import unittest

import losses_test
from daemon import DaemonTest
from losses_test import Node, free_port

POINTS, TILES = os.environ.get("ROLLING_POINTS", "600k"), 48


class Rolling(DaemonTest):
    def setUp(self):
        super().setUp()
        self.tessera("certs", "init", "certs")
        self.tessera("certs", "node", "certs", *"abcd")
        self.port, self.http = free_port(), free_port()
        self.tessera("generate", "uniform", "-n", POINTS, "-o", "cloud.npy", "--quiet")
        self.coordinator = self.start_coordinator()
        self.nodes = {name: self.join(name) for name in "bcd"}
        self.wait_for_members(set("abcd"))

    start_coordinator = losses_test.Cluster.start_coordinator
    wait_until = losses_test.Cluster.wait_until
    status = losses_test.Cluster.status
    wait_for_phase = losses_test.Cluster.wait_for_phase
    result = losses_test.Cluster.result

    def join(self, name):
        return Node(self, name, self.port)

    def free(self):
        return {node["name"] for node in self.coordinator.request("GET", "/v1/nodes")[2]["nodes"] if node["state"] == "free"}

    def wait_for_members(self, names):
        self.wait_until(lambda: self.free() == names, lambda: f"{self.free()} instead of {names}")

    def drain(self, name):
        status, _, info = self.coordinator.request("POST", f"/v1/nodes/{name}/drain")
        self.assertEqual((status, info.get("state")), (200, "draining"), info)

    def log(self, job):
        return self.coordinator.request("GET", f"/v1/jobs/{job}/log")[2].decode()

    def test_all_nodes_are_replaced_under_a_running_job(self):
        alone = json.loads(self.tessera("triangulate", "cloud.npy", "-o", "alone", "--tiles", str(TILES), "--json").splitlines()[-1])
        status, _, job = self.coordinator.request(
            "POST", "/v1/processes/triangulate/execution",
            {"inputs": {"inputs": [str(self.folder / "cloud.npy")], "output": "rolled", "tiles": TILES}})
        self.assertEqual(status, 201, job)
        job = job["jobID"]
        self.wait_for_phase(job, "triangulating", "splaying")
        for name in "bcd":
            self.drain(name)
            self.assertEqual(self.nodes[name].process.wait(timeout=300), 0, self.nodes[name].said())
            self.nodes[name] = self.join(name)
            self.wait_for_members(set("abcd"))
        self.drain("a")  # its process goes on as the coordinator
        self.assertEqual(self.result(job), alone["digest"], self.log(job))
        figures = json.loads((self.folder / "data" / "results" / "rolled" / "manifest.json").read_text())["figures"]
        self.assertEqual((figures["tiles_again"], figures["nodes_lost"]), (0, 0), self.log(job))
        handed = [int(tiles) for tiles in re.findall(r"leaves: others go on with (\d+) tiles", self.log(job))]
        self.assertGreater(sum(handed), 0, self.log(job))
        self.wait_for_members(set("bcd"))

    def test_how_a_node_ended_stands_in_the_log_of_its_job(self):
        status, _, job = self.coordinator.request(
            "POST", "/v1/processes/triangulate/execution",
            {"inputs": {"inputs": [str(self.folder / "cloud.npy")], "output": "killed", "tiles": TILES}})
        self.assertEqual(status, 201, job)
        job = job["jobID"]
        self.wait_for_phase(job, "triangulating")
        self.wait_until(lambda: "b" in {node["name"] for node in self.status(job).get("figures", {}).get("nodes", [])}, lambda: self.log(job))
        self.nodes["b"].end()
        self.nodes["b"] = self.join("b")
        self.result(job)
        self.wait_until(lambda: self.free() == set("abcd"), lambda: str(self.free()))
        words = {node["name"]: node.get("lastWords", "") for node in self.coordinator.request("GET", "/v1/nodes")[2]["nodes"]}
        self.assertIn("was killed (SIGKILL)", words["b"])
        self.assertEqual({words[name] for name in "acd"}, {""})
        self.assertRegex(self.log(job), r"node b: the process before this one was killed \(SIGKILL\), while \w+")


if __name__ == "__main__":
    unittest.main()
