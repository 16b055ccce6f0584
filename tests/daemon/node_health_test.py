"""What supervisors and Prometheus ask of a process that only works for a cluster, from its first moment to its last."""
import http.client
import re
import signal
import subprocess
import unittest

import local_cluster
from daemon import TESSERAD, DaemonTest
from local_cluster import Node, free_port


class Health(DaemonTest):
    def setUp(self):
        super().setUp()
        self.tessera("certs", "init", "certs")
        self.tessera("certs", "node", "certs", "a", "b", "c")
        (self.folder / "inputs").mkdir(exist_ok=True)
        self.tessera("generate", "uniform", "-n", "100k", "-o", "inputs/cloud.npy", "--quiet")
        self.port, self.http = free_port(), free_port()
        self.operations = {name: free_port() for name in "bc"}

    start_coordinator = local_cluster.ClusterTest.start_coordinator
    wait_until = local_cluster.ClusterTest.wait_until
    submit = local_cluster.ClusterTest.submit
    status = local_cluster.ClusterTest.status

    def node(self, name):
        return Node(self, name, self.port, "certs", "--metrics", f"127.0.0.1:{self.operations[name]}")

    def ask(self, name, path):
        """Status and text; 0 while nobody listens."""
        connection = http.client.HTTPConnection("127.0.0.1", self.operations[name], timeout=60)
        try:
            connection.request("GET", path)
            answer = connection.getresponse()
            return answer.status, answer.read().decode()
        except ConnectionError:
            return 0, ""
        finally:
            connection.close()

    def figures(self, name):
        status, text = self.ask(name, "/metrics")
        self.assertEqual(status, 200)
        return {key: float(value) for key, value in re.findall(r"^(tessera_\S+) (\S+)$", text, re.M)}

    def healthy(self, name):
        return subprocess.run([TESSERAD, "health", "--metrics", f"127.0.0.1:{self.operations[name]}"],
                              stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, timeout=60)

    def test_a_node_tells_how_it_is(self):
        nodes = {name: self.node(name) for name in "bc"}
        # Alive, but nobody to work for.
        while not all(self.ask(name, "/livez") == (200, "live\n") for name in "bc"):
            self.assertEqual([node.process.poll() for node in nodes.values()], [None, None])
        status, said = self.ask("b", "/readyz?verbose")
        self.assertEqual(status, 503)
        self.assertIn("[-] node: looks for the cluster's coordinator", said)
        self.assertEqual(self.figures("b")["tessera_member"], 0)
        refused = self.healthy("b")
        self.assertEqual(refused.returncode, 4)
        self.assertIn("looks for the cluster's coordinator", refused.stderr)

        self.coordinator = self.start_coordinator()
        self.wait_until(lambda: all(self.ask(name, "/readyz")[0] == 200 for name in "bc"), lambda: "not ready")
        self.assertEqual(self.ask("b", "/readyz?verbose"), (200, "[+] node\n[+] http\nready\n"))
        self.assertEqual(self.healthy("b").returncode, 0)
        self.wait_until(lambda: all(self.figures(name)["tessera_members_reached"] >= 1 for name in "bc"), lambda: "alone")
        self.wait_until(lambda: self.coordinator.messages().count("has joined") == 3, lambda: "not joined")

        job = self.submit("done")
        self.wait_until(lambda: self.status(job)["status"] not in ("accepted", "running"), lambda: "no end")
        self.assertEqual(self.status(job)["status"], "successful")
        self.wait_until(lambda: all(self.figures(name)["tessera_node_jobs"] == 0 for name in "bc"), lambda: "works on")
        for name in "bc":
            told = self.figures(name)
            self.assertEqual(told["tessera_member"], 1)
            self.assertEqual(told["tessera_lease_seconds"], 10)
            self.assertEqual(told["tessera_memory_budget_bytes"], 512 << 20)
            self.assertEqual(told["tessera_memory_used_bytes"], 0)
            self.assertGreater(told["tessera_scratch_free_bytes"], 0)
            self.assertGreater(told["tessera_tiles_begun_total"], 0)
            self.assertEqual(told["tessera_tiles_begun_total"], told["tessera_tiles_stored_total"])
            self.assertGreater(told["tessera_points_total"], 0)
            self.assertGreater(told["tessera_node_bytes_total"], 0)
            self.assertEqual(told["tessera_credit_waiting_bytes"], 0)
            self.assertNotIn("tessera_jobs", told, "what only a coordinator has")
        self.assertEqual(self.ask("b", "/v1/jobs")[0], 404)

        # Its tiles go on, so it is alive, but it is no member.
        self.coordinator.end(signal.SIGKILL)
        self.wait_until(lambda: self.ask("b", "/readyz")[0] == 503, lambda: "still ready")
        self.assertEqual(self.ask("b", "/livez"), (200, "live\n"))
        self.coordinator = self.start_coordinator()
        self.wait_until(lambda: all(self.ask(name, "/readyz")[0] == 200 for name in "bc"), lambda: "not ready again")
        self.wait_until(lambda: self.coordinator.messages().count("has joined") == 3, lambda: "not joined again")

        # Begun anew in the same process, at the same address.
        nodes["c"].process.send_signal(signal.SIGSTOP)
        self.wait_until(lambda: "node c (" in self.coordinator.messages() and "is lost" in self.coordinator.messages(),
                        lambda: "not lost")
        nodes["c"].process.send_signal(signal.SIGCONT)
        self.wait_until(lambda: "is not a member of the cluster any more" in nodes["c"].said() and
                        self.ask("c", "/readyz")[0] == 200, lambda: nodes["c"].said())
        self.assertEqual(self.figures("c")["tessera_tiles_begun_total"], 0)
        self.assertEqual(nodes["c"].end(signal.SIGTERM), 0)
        self.assertEqual(self.ask("c", "/livez")[0], 0)

    def test_an_address_that_is_taken_is_said(self):
        self.coordinator = self.start_coordinator()
        taken = self.operations["b"] = self.http
        node = self.node("b")
        self.assertEqual(node.process.wait(timeout=120), 4)
        self.assertIn(f"cannot listen on 127.0.0.1, port {taken}", node.said())


if __name__ == "__main__":
    unittest.main()
