"""Processes of a cluster stand still while a job runs, and go on. ROLLING_POINTS and PAUSES_S make it longer."""
import os
import re
import signal
import time
import unittest

import local_cluster
import rolling_test
from daemon import DaemonTest
from local_cluster import free_port

PAUSES_S = [float(pause) for pause in os.environ.get("PAUSES_S", "15").split(",")]  # the lease is 10 s


class Pauses(DaemonTest):
    def setUp(self):
        super().setUp()
        (self.folder / "inputs").mkdir()
        self.tessera("certs", "init", "certs")
        self.tessera("certs", "node", "certs", *"abcd")
        self.port, self.http = free_port(), free_port()
        self.tessera("generate", "uniform", "-n", rolling_test.POINTS, "-o", "inputs/cloud.npy", "--quiet")
        self.coordinator = self.start_coordinator()
        self.nodes = {name: self.join(name) for name in "bcd"}
        self.wait_for_members(set("abcd"))

    start_coordinator = local_cluster.ClusterTest.start_coordinator
    wait_until = local_cluster.ClusterTest.wait_until
    status = local_cluster.ClusterTest.status
    wait_for_phase = local_cluster.ClusterTest.wait_for_phase
    result = local_cluster.ClusterTest.result
    join = rolling_test.Rolling.join
    free = rolling_test.Rolling.free
    wait_for_members = rolling_test.Rolling.wait_for_members
    log = rolling_test.Rolling.log
    alone = rolling_test.Rolling.alone
    running = rolling_test.Rolling.running
    assert_nothing_began_again = rolling_test.Rolling.assert_nothing_began_again

    def stand_still(self, process, pause_s):
        """For longer than the lease; that the others have noticed is waited for, too."""
        process.send_signal(signal.SIGSTOP)
        time.sleep(pause_s)
        for name, node in self.nodes.items():
            if node.process is not process:
                self.wait_until(lambda: "has been silent for longer than the lease" in node.said(), node.said)
        process.send_signal(signal.SIGCONT)

    def test_a_coordinator_that_stands_still_finds_its_nodes_again(self):
        alone = self.alone()
        for turn, pause_s in enumerate(PAUSES_S):
            output = f"paused-{turn}"
            job = self.running(output, "b", "c", "d")
            self.stand_still(self.coordinator.process, pause_s)
            self.assertEqual(self.result(job), alone, self.log(job))
            self.assert_nothing_began_again(output, job)
            self.wait_for_members(set("abcd"))
        self.assertNotIn("is lost", self.coordinator.messages())
        for node in self.nodes.values():
            self.assertNotIn("is not a member of the cluster any more", node.said())
            # It was welcomed a second time, by the same process.
            self.assertGreaterEqual(node.said().count("member of the cluster tessera"), 1 + len(PAUSES_S), node.said())

    def test_a_node_that_is_lost_while_the_coordinator_stands_still_is_missed_when_it_goes_on(self):
        alone, job = self.alone(), self.running("fewer", "b", "c", "d")
        self.coordinator.process.send_signal(signal.SIGSTOP)
        self.nodes["c"].end()
        for name in "bd":
            node = self.nodes[name]
            self.wait_until(lambda: "has been silent for longer than the lease" in node.said(), node.said)
        self.coordinator.process.send_signal(signal.SIGCONT)
        self.assertEqual(self.result(job), alone, self.log(job))
        self.wait_for_members(set("abd"))
        self.assertEqual(re.findall(r"node (\w) \(\S+\) is lost", self.coordinator.messages()), ["c"])


if __name__ == "__main__":
    unittest.main()
