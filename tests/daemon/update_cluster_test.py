"""Changes as jobs of a cluster: nodes die, and so does the coordinator, and the digest is that of the command."""
import json
import shutil
import signal
import unittest

import numpy as np

from local_cluster import ClusterTest

RUNNING = ("accepted", "running")


class Updates(ClusterTest):
    POINTS = "60k"

    def setUp(self):
        super().setUp()
        np.save(self.folder / "inputs/more.npy", np.random.default_rng(1).random((3000, 3)) * 0.5)
        _, _, job = self.coordinator.request(
            "POST", "/v1/processes/triangulate/execution",
            {"inputs": {"inputs": [str(self.folder / "inputs/cloud.npy")], "output": "cloud", "dim": 3, "tiles": 16}})
        self.result(job["jobID"])
        shutil.copytree(self.folder / "data/results/cloud", self.folder / "here")

    def update(self, **inputs):
        status, _, job = self.coordinator.request("POST", "/v1/processes/update/execution",
                                                  {"inputs": {"triangulation": "cloud", **inputs}})
        self.assertEqual(status, 201, job)
        return job["jobID"]

    def made(self, job, *args):
        """The job ends, and has made what the command makes."""
        self.wait_until(lambda: self.status(job)["status"] not in RUNNING, lambda: json.dumps(self.status(job)))
        self.assertEqual(self.status(job)["status"], "successful", self.status(job))
        here = json.loads(self.tessera("update", "here", *args, "--json").splitlines()[-1])
        there = self.coordinator.request("GET", "/v1/triangulations/cloud")[2]
        self.assertEqual({key: there[key] for key in ("version", "digest", "vertices", "cells")},
                         {key: here[key] for key in ("version", "digest", "vertices", "cells")})
        left = [path.name for path in (self.folder / "data/results").iterdir() if path.name.startswith(".unfinished")]
        self.assertEqual(left, [])

    def wait_for_work(self, job):
        """Until nodes have told something of their work, or the job has ended."""
        self.wait_until(lambda: list((self.folder / "data/results").glob(f".unfinished-{job}.update/plan.json"))
                        or self.status(job)["status"] not in RUNNING, lambda: json.dumps(self.status(job)))

    def test_nodes_and_the_coordinator_die_in_the_middle(self):
        self.made(self.update(remove_ids=[1, 2, 3]), "--remove-ids", self.save([1, 2, 3]))
        job = self.update(inputs=["more.npy"], remove_box=[0.3, 0.3, 0.3, 0.5, 0.5, 0.5])
        self.wait_for_work(job)
        self.nodes["b"].end(signal.SIGKILL)
        self.made(job, "--add", self.folder / "inputs/more.npy", "--remove-box", "0.3,0.3,0.3,0.5,0.5,0.5")
        job = self.update(remove_box=[0.6, 0.6, 0.6, 0.8, 0.8, 0.8])
        self.wait_for_work(job)
        self.coordinator.end(signal.SIGKILL)
        for node in self.nodes.values():
            node.end()
        self.coordinator = self.start_coordinator()
        self.nodes = {name: self.join(name) for name in "bcd"}
        self.made(job, "--remove-box", "0.6,0.6,0.6,0.8,0.8,0.8")
        # Most tiles: all are triangulated anew.
        job = self.update(remove_box=[0, 0, 0, 1, 1, 0.5], output="next")
        self.wait_for_work(job)
        self.nodes["c"].end(signal.SIGKILL)
        self.wait_until(lambda: self.status(job)["status"] not in RUNNING, lambda: json.dumps(self.status(job)))
        self.assertEqual(self.status(job)["status"], "successful", self.status(job))
        here = json.loads(self.tessera("update", "here", "--remove-box", "0,0,0,1,1,0.5", "-o", "next", "--json").splitlines()[-1])
        self.assertEqual(self.coordinator.request("GET", "/v1/triangulations/next")[2]["digest"], here["digest"])
        self.tessera("verify", "data/results/cloud")

    def save(self, ids):
        np.save(self.folder / "ids.npy", np.array(ids))
        return "ids.npy"


if __name__ == "__main__":
    unittest.main()
