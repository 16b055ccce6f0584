"""A surface as the job of a cluster: nodes come, end and die, and so does the coordinator, in each step; the surface is
the one of the command."""
import json
import signal
import unittest

from local_cluster import ClusterTest

RUNNING = ("accepted", "running")


class Surfaces(ClusterTest):
    POINTS = "40k"

    def setUp(self):
        super().setUp()
        _, _, job = self.coordinator.request(
            "POST", "/v1/processes/triangulate/execution",
            {"inputs": {"inputs": [str(self.folder / "inputs/cloud.npy")], "output": "cloud", "dim": 3, "tiles": 12}})
        self.result(job["jobID"])
        self.tessera("surface", "data/results/cloud", "-o", "alone.ply")
        self.alone = (self.folder / "alone.ply").read_bytes()

    def surface(self, output):
        status, _, job = self.coordinator.request(
            "POST", "/v1/processes/surface/execution", {"inputs": {"triangulation": "cloud", "output": output}})
        self.assertEqual(status, 201, job)
        return job["jobID"]

    def exports(self):
        return self.folder / "data/results/cloud/exports"

    def made(self, job, output):
        self.wait_until(lambda: self.status(job)["status"] not in RUNNING, lambda: json.dumps(self.status(job)))
        self.assertEqual(self.status(job)["status"], "successful", self.status(job))
        self.assertEqual((self.exports() / output).read_bytes(), self.alone)
        self.assertEqual([path for path in self.exports().iterdir() if path.name.startswith(".unfinished")], [])

    def kept(self, job):
        """How many steps have left something."""
        return len({path.parent.name for path in self.exports().glob(f".*{job}*/*.surface/kept/*/*.bin")})

    def wait_for_step(self, job, step):
        """Until it has begun, or the job has ended before it was seen to. Whether it has begun."""
        self.wait_until(lambda: self.kept(job) > step or self.status(job)["status"] not in RUNNING,
                        lambda: json.dumps(self.status(job)))
        return self.status(job)["status"] in RUNNING

    def test_nodes_that_die_in_any_step_change_nothing(self):
        killed = 0
        for step in range(8):
            job = self.surface(f"killed-{step}.ply")
            if self.wait_for_step(job, step):
                name = "bcd"[step % 3]
                self.nodes[name].end()
                killed += 1
            self.made(job, f"killed-{step}.ply")
            for each in "bcd":
                if self.nodes[each].process.poll() is not None:
                    self.nodes[each] = self.join(each)
            self.wait_for_members(4)
        self.assertGreater(killed, 2)

    def test_all_are_killed_and_go_on(self):
        went_on = 0
        for step in (0, 2, 4):
            job = self.surface(f"all-{step}.ply")
            self.wait_for_step(job, step)
            self.coordinator.end(signal.SIGKILL)
            for node in self.nodes.values():
                node.end()
            self.coordinator = self.start_coordinator()
            self.nodes = {name: self.join(name) for name in "bcd"}
            self.made(job, f"all-{step}.ply")
            log = self.coordinator.request("GET", f"/v1/jobs/{job}/log")[2]
            went_on += "continues the work of an earlier start" in str(log)
        self.assertGreater(went_on, 0)

    def test_a_dismissed_one_goes_on(self):
        job = self.surface("dismissed.ply")
        running = self.wait_for_step(job, 1)
        self.coordinator.request("DELETE", f"/v1/jobs/{job}")
        if running and self.status(job)["status"] == "dismissed":
            self.assertEqual(self.coordinator.request("POST", f"/v1/jobs/{job}/resume")[0], 200)
        self.made(job, "dismissed.ply")


if __name__ == "__main__":
    unittest.main()
