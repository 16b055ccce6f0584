"""Nodes leave in order while a job runs, drained or told to end, and others come: nothing of it begins again, and its result is the
command's."""
import json
import os
import re
import signal
import time
import unittest

import local_cluster
from daemon import DaemonTest
from local_cluster import Node, free_port

POINTS, TILES = os.environ.get("ROLLING_POINTS", "1M"), 48


class Rolling(DaemonTest):
    def setUp(self):
        super().setUp()
        (self.folder / "inputs").mkdir()
        self.tessera("certs", "init", "certs")
        self.tessera("certs", "node", "certs", *"abcd")
        self.port, self.http = free_port(), free_port()
        self.tessera("generate", "uniform", "-n", POINTS, "-o", "inputs/cloud.npy", "--quiet")
        self.coordinator = self.start_coordinator()
        self.nodes = {name: self.join(name) for name in "bcd"}
        self.wait_for_members(set("abcd"))

    start_coordinator = local_cluster.ClusterTest.start_coordinator
    wait_until = local_cluster.ClusterTest.wait_until
    status = local_cluster.ClusterTest.status
    wait_for_phase = local_cluster.ClusterTest.wait_for_phase
    result = local_cluster.ClusterTest.result

    def join(self, name, drain_timeout="5m"):
        return Node(self, name, self.port, "certs", "--drain-timeout", drain_timeout)

    def free(self):
        return {node["name"] for node in self.coordinator.request("GET", "/v1/nodes")[2]["nodes"] if node["state"] == "free"}

    def wait_for_members(self, names):
        self.wait_until(lambda: self.free() == names, lambda: f"{self.free()} instead of {names}")

    def drain(self, name):
        status, _, info = self.coordinator.request("POST", f"/v1/nodes/{name}/drain")
        self.assertEqual((status, info.get("state")), (200, "draining"), info)

    def log(self, job):
        return self.coordinator.request("GET", f"/v1/jobs/{job}/log")[2].decode()

    def alone(self):
        told = self.tessera("triangulate", "inputs/cloud.npy", "-o", "alone", "--tiles", str(TILES), "--json")
        return json.loads(told.splitlines()[-1])["digest"]

    def running(self, output, *names):
        """A job that is not settled yet, and in which these nodes have begun tiles."""
        status, _, job = self.coordinator.request(
            "POST", "/v1/processes/triangulate/execution",
            {"inputs": {"inputs": [str(self.folder / "inputs/cloud.npy")], "output": output, "tiles": TILES}})
        self.assertEqual(status, 201, job)
        job = job["jobID"]
        self.wait_for_phase(job, "triangulating", "splaying")
        begun = lambda: {node["name"] for node in self.status(job).get("figures", {}).get("nodes", []) if node.get("tilesTriangulated", 0) > 0}
        self.wait_until(lambda: set(names) <= begun(), lambda: json.dumps(self.status(job)))
        return job

    def assert_nothing_began_again(self, output, job):
        figures = json.loads((self.folder / "data" / "results" / output / "manifest.json").read_text())["figures"]
        self.assertEqual((figures["tiles_again"], figures["nodes_lost"]), (0, 0), self.log(job))

    def handed(self, job):
        return sum(int(tiles) for tiles in re.findall(r"leaves: other nodes continue (\d+) tiles", self.log(job)))

    def test_all_nodes_are_replaced_under_a_running_job(self):
        alone, job = self.alone(), self.running("rolled")
        for name in "bcd":
            self.drain(name)
            self.assertEqual(self.nodes[name].process.wait(timeout=300), 0, self.nodes[name].said())
            self.nodes[name] = self.join(name)
            self.wait_for_members(set("abcd"))
        self.drain("a")  # its process goes on as the coordinator
        self.assertEqual(self.result(job), alone, self.log(job))
        self.assert_nothing_began_again("rolled", job)
        self.assertGreater(self.handed(job), 0, self.log(job))
        self.wait_for_members(set("bcd"))

    def test_nodes_that_are_told_to_end_leave_in_order(self):
        alone, job = self.alone(), self.running("told", "b", "c", "d")
        self.nodes["b"].process.send_signal(signal.SIGTERM)
        self.nodes["c"].process.send_signal(signal.SIGINT)
        for name in "bc":
            self.assertEqual(self.nodes[name].process.wait(timeout=300), 0, self.nodes[name].said())
            self.assertIn("it is drained", self.nodes[name].said())
            self.nodes[name] = self.join(name)
        self.assertEqual(self.result(job), alone, self.log(job))
        self.assert_nothing_began_again("told", job)
        self.assertGreater(self.handed(job), 0, self.log(job))
        self.assertNotIn("is lost", self.coordinator.messages())
        self.wait_for_members(set("abcd"))
        nodes = self.coordinator.request("GET", "/v1/nodes")[2]["nodes"]
        self.assertEqual({node.get("lastWords", "") for node in nodes}, {""})

    def test_the_last_nodes_leave_and_another_goes_on(self):
        alone = self.alone()
        self.drain("a")
        self.wait_for_members(set("bcd"))
        job = self.running("handed", "b", "c", "d")
        for name in "bcd":
            self.nodes[name].process.send_signal(signal.SIGTERM)
        for name in "bcd":
            self.assertEqual(self.nodes[name].process.wait(timeout=300), 0, self.nodes[name].said())
        self.wait_until(lambda: "no node is left: the job waits" in self.log(job), lambda: self.log(job))
        self.nodes["b"] = self.join("b")
        self.assertEqual(self.result(job), alone, self.log(job))
        self.assert_nothing_began_again("handed", job)
        self.assertGreater(self.handed(job), 0, self.log(job))

    def test_that_a_node_leaves_is_known_to_the_next_coordinator(self):
        alone, job = self.alone(), self.running("remembered", "b", "c", "d")
        self.drain("c")
        told = lambda name: self.wait_until(lambda: "leaves the cluster: its tiles go to other nodes" in self.nodes[name].said(), self.nodes[name].said)
        told("c")
        self.coordinator.process.send_signal(signal.SIGSTOP)  # so that it never hears of d
        self.nodes["d"].process.send_signal(signal.SIGTERM)
        told("d")
        self.coordinator.end(signal.SIGKILL)
        self.coordinator = self.start_coordinator()
        for name in "cd":
            self.assertEqual(self.nodes[name].process.wait(timeout=300), 0, self.nodes[name].said())
        self.assertIn("it is drained", self.nodes["d"].said())
        # It may have handed over all it had before the coordinator was lost.
        self.assertRegex(self.nodes["c"].said(), "it is drained|it had no tiles that other nodes would continue")
        heard = self.coordinator.messages()
        self.assertRegex(heard, r"node d \(\S+\) leaves: its tiles go to other nodes")
        for name in "cd":
            self.assertNotRegex(heard, rf"node {name} \(\S+\) has joined")
        self.assertEqual(self.result(job), alone, self.log(job))
        self.assert_nothing_began_again("remembered", job)
        self.assertNotIn("is lost", self.coordinator.messages())

    def test_without_a_coordinator_a_node_that_is_told_to_end_has_its_time_and_no_more(self):
        self.nodes["c"].end(signal.SIGTERM)
        self.nodes["c"] = self.join("c", "2s")
        self.wait_for_members(set("abcd"))
        alone, job = self.alone(), self.running("orphaned", "b", "c", "d")
        self.coordinator.end(signal.SIGKILL)
        began = time.monotonic()
        self.nodes["c"].process.send_signal(signal.SIGTERM)
        self.assertEqual(self.nodes["c"].process.wait(timeout=300), 0)
        self.assertGreaterEqual(time.monotonic() - began, 2)
        self.assertIn("after 2 s, other nodes do not have all tiles of this node: it ends all the same, and is lost", self.nodes["c"].said())
        self.nodes["d"].process.send_signal(signal.SIGTERM)
        self.wait_until(lambda: "leaves the cluster" in self.nodes["d"].said(), self.nodes["d"].said)
        self.assertEqual(self.nodes["d"].end(signal.SIGTERM), -signal.SIGTERM)  # a second one
        self.coordinator = self.start_coordinator()
        self.nodes |= {name: self.join(name) for name in "cd"}
        self.assertEqual(self.result(job), alone, self.log(job))
        self.wait_for_members(set("abcd"))
        words = {node["name"]: node.get("lastWords", "") for node in self.coordinator.request("GET", "/v1/nodes")[2]["nodes"]}
        self.assertIn("was told to end, and did not hand over its tiles within 2 s", words["c"])
        self.assertIn("was ended by signal SIGTERM", words["d"])
        # A node without tiles that other nodes would continue ends at once.
        self.coordinator.end(signal.SIGKILL)
        for name in "bcd":
            self.assertEqual(self.nodes[name].end(signal.SIGTERM), 0, self.nodes[name].said())
            self.assertIn("it had no tiles that other nodes would continue", self.nodes[name].said())

    def test_how_a_node_ended_stands_in_the_log_of_its_job(self):
        status, _, job = self.coordinator.request(
            "POST", "/v1/processes/triangulate/execution",
            {"inputs": {"inputs": [str(self.folder / "inputs/cloud.npy")], "output": "killed", "tiles": TILES}})
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
