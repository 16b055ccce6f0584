"""What operators find in the daemon's log: jobs from their begin to their end, readiness, certificates that end soon; as text and as JSON."""
import json
import re
import signal
import subprocess
import tempfile
import time
import unittest

import local_cluster
import node_health_test
from daemon import IGN, TESSERAD, DaemonTest
from local_cluster import Node, free_port


class Log(DaemonTest):
    def run_jobs(self, *options):
        daemon = self.start(*options)
        (self.folder / "data" / "uploads").mkdir(exist_ok=True)
        good = {"inputs": [str(next(IGN.glob("*.las")))], "output": "good", "tiles": 4}
        ids = []
        for inputs in (good, good | {"output": "bad", "dim": 3, "crop": [0, 0, 0, 1, 1, 1]}):
            status, _, job = daemon.request("POST", "/v1/processes/triangulate/execution", {"inputs": inputs})
            self.assertEqual(status, 201, job)
            ids.append(job["jobID"])
        self.assertEqual([daemon.wait(job)["status"] for job in ids], ["successful", "failed"])
        return daemon, ids

    def test_jobs_are_lines(self):
        daemon, (good, bad) = self.run_jobs()
        log = daemon.messages()
        self.assertRegex(log, rf"Z info job {good} \(triangulate\) of \S+: running")
        self.assertRegex(log, rf"Z info job {good} \(triangulate\) of \S+: successful")
        self.assertRegex(log, rf"Z warning job {bad} \(triangulate\) of \S+: failed: .+")

    def test_jobs_are_objects(self):
        daemon, (good, bad) = self.run_jobs("--log", "json")
        lines = [json.loads(line) for line in daemon.messages().splitlines()]
        told = {(line["level"], line["message"].split(": ")[1]) for line in lines if line["message"].startswith(f"job {good} ")}
        self.assertEqual(told, {("info", "running"), ("info", "successful")})
        self.assertEqual([line["level"] for line in lines if re.match(rf"job {bad} .*: failed: ", line["message"])], ["warning"])

    def test_errors_at_the_start_are_as_all_lines(self):
        with tempfile.NamedTemporaryFile() as file:
            for options in (["--data", file.name], ["--data", self.folder, "--jobs", "none"], ["--unknown"]):
                done = subprocess.run([TESSERAD, "--log", "json", *map(str, options)], text=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
                self.assertNotEqual(done.returncode, 0)
                lines = [json.loads(line) for line in done.stderr.splitlines()]
                self.assertEqual(lines[-1]["level"], "error", done.stderr)
        done = subprocess.run([TESSERAD, "--unknown"], text=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        self.assertRegex(done.stderr, "^tesserad: ")


class ClusterLog(DaemonTest):
    start_coordinator = local_cluster.ClusterTest.start_coordinator
    wait_until = local_cluster.ClusterTest.wait_until
    ask = node_health_test.Health.ask
    figures = node_health_test.Health.figures

    def setUp(self):
        super().setUp()
        self.tessera("certs", "init", "certs")
        self.tessera("certs", "node", "certs", "a")
        self.tessera("certs", "node", "certs", "b", "--days", 6)
        self.port, self.http = free_port(), free_port()
        self.operations = {"b": free_port()}

    def test_a_certificate_that_ends_soon_and_a_node_that_is_not_ready(self):
        node = Node(self, "b", self.port, "certs", "--metrics", f"127.0.0.1:{self.operations['b']}")
        self.wait_until_of(node, "not ready any more: looks for the cluster's coordinator")
        self.wait_until_of(node, r"certs/b\.pem: ends on \d{4}-\d\d-\d\d \d\d:\d\d UTC, in 5 days: have the authority of the cluster make another one")
        self.coordinator = self.start_coordinator()
        self.wait_until_of(node, "ready again")
        self.assertNotIn("ends on", self.coordinator.messages())
        told = self.figures("b")
        self.assertAlmostEqual(told["tessera_certificate_not_after_seconds"], time.time() + 6 * 86400, delta=7200)
        self.assertEqual(told["tessera_ready"], 1)
        text = self.ask("b", "/metrics")[1]
        of_process = {name: float(value) for name, value in re.findall(r"^(process_\S+) (\S+)$", text, re.M)}
        self.assertAlmostEqual(of_process["process_start_time_seconds"], time.time(), delta=600)
        self.assertGreater(of_process["process_resident_memory_bytes"], 1 << 20)
        self.assertGreater(of_process["process_open_fds"], 3)
        self.assertRegex(text, r'tessera_build_info\{version="\d+\.\d+\.\d+"\} 1')
        self.assertNotRegex(text, r'tessera_http_requests_total\{.*\} 0$')
        nodes = lambda: {one["name"]: one for one in self.coordinator.request("GET", "/v1/nodes")[2]["nodes"]}
        self.wait_until(lambda: nodes().get("b", {}).get("state") == "free", lambda: json.dumps(nodes()))
        self.assertIn("in 5 days", nodes()["b"]["certificateWarning"])
        self.assertNotIn("certificateWarning", nodes()["a"])
        self.assertGreater(nodes()["b"]["scratchFreeBytes"], 0)
        # What CAF calls things is in no log.
        node.end(signal.SIGKILL)
        self.wait_until(lambda: "node b (" in self.coordinator.messages() and "is lost" in self.coordinator.messages(), lambda: "not lost")
        for log in (self.coordinator.messages(), node.said()):
            self.assertNotRegex(log, r"exit_reason|system_error|remote_link|disconnect_during")

    def wait_until_of(self, node, pattern):
        end = time.monotonic() + 300
        while not re.search(pattern, node.said()):
            self.assertLess(time.monotonic(), end, node.said())
            time.sleep(0.05)


if __name__ == "__main__":
    unittest.main()
