"""How a node has ended: told by the process that takes its place, in its own log and in the coordinator's."""
import os
import pathlib
import re
import signal
import subprocess
import unittest

import local_cluster
from daemon import DaemonTest
from local_cluster import Node, free_port

GROUPS = pathlib.Path("/sys/fs/cgroup/memory")  # of cgroup v1; where there is v2 alone, a service's group is not ours to make


class LastWords(DaemonTest):
    def setUp(self):
        super().setUp()
        self.tessera("certs", "init", "certs")
        self.tessera("certs", "node", "certs", "a", "b", "c")
        self.port, self.http = free_port(), free_port()
        self.coordinator = self.start_coordinator()

    start_coordinator = local_cluster.ClusterTest.start_coordinator
    wait_until = local_cluster.ClusterTest.wait_until
    submit = local_cluster.ClusterTest.submit
    status = local_cluster.ClusterTest.status

    def count(self, name, what):
        return len(re.findall(rf"node {name} \(\S+\) {what}", self.coordinator.messages()))

    def join(self, name, group=None):
        before = self.count(name, "has joined")
        # In its control group from the start: it notes which one that is.
        node = Node(self, name, self.port, enter=lambda: (group / "cgroup.procs").write_text(str(os.getpid())) if group else None)
        self.wait_until(lambda: self.count(name, "has joined") > before, node.said)
        return node

    def told(self, name):
        """What the coordinator was told last of how a process of that name ended; nothing when the last one did in order."""
        ends = re.findall(rf"node {name} \(\S+\) (has joined|is back; the process before it (.*))\n", self.coordinator.messages())
        return ends[-2][1] if len(ends) > 1 else ""

    def test_each_end_is_told_as_it_was(self):
        node = self.join("b")
        self.assertEqual(self.told("b"), "")
        for how, words in ((signal.SIGKILL, "was killed (SIGKILL)"), (signal.SIGSEGV, "was ended by signal SIGSEGV"),
                           (signal.SIGABRT, "was ended by signal SIGABRT"), (signal.SIGHUP, "was ended by signal SIGHUP")):
            with self.subTest(how=how):
                self.assertEqual(node.end(how), -how)
                node = self.join("b")
                self.assertIn(words, self.told("b"))
                self.assertIn("while without tiles", self.told("b"))
                self.assertIn(f"is back; the process before it {words}", self.coordinator.messages())
                self.assertIn(f"the process before this one {words}", node.said())
        self.assertEqual(node.end(signal.SIGTERM), 0)
        node = self.join("b")
        self.assertEqual(self.told("b"), "", "it had ended in order")

        taken = Node(self, "c", self.port, "certs", "--metrics", f"127.0.0.1:{self.http}")
        self.assertEqual(taken.process.wait(timeout=120), 4)
        self.join("c")
        self.assertRegex(self.told("c"), r"^ended with status 4 \(cannot listen on 127\.0\.0\.1, port \d+: .*\)$")

        came, lost = self.count("b", "has joined"), self.count("b", "is lost")
        node.process.send_signal(signal.SIGSTOP)
        self.wait_until(lambda: self.count("b", "is lost") > lost, lambda: "not lost")
        node.process.send_signal(signal.SIGCONT)
        self.wait_until(lambda: self.count("b", "has joined") > came, node.said)
        self.assertRegex(self.told("b"), "^was not a member of the cluster any more .*, and began anew, while without tiles$")

    def test_want_of_memory_is_told(self):
        group = GROUPS / f"tessera-test-{os.getpid()}"
        try:
            group.mkdir()
        except OSError as problem:
            self.skipTest(f"no control group can be made: {problem}")
        self.addCleanup(lambda: subprocess.run(["rmdir", group], check=False))
        self.tessera("generate", "uniform", "-n", "1M", "-o", "inputs/cloud.npy", "--quiet", "--overwrite")
        node = self.join("b", group=group)
        taken = int((group / "memory.usage_in_bytes").read_text())
        (group / "memory.limit_in_bytes").write_text(str(taken + (8 << 20)))
        job = self.submit("large")
        self.assertEqual(node.process.wait(timeout=300), -signal.SIGKILL)
        self.join("b")
        words = self.told("b")
        self.assertIn("was killed (SIGKILL), and the kernel has killed processes for lack of memory in its control group", words)
        self.wait_until(lambda: self.status(job)["status"] not in ("accepted", "running"), lambda: "no end")
        self.assertEqual(self.status(job)["status"], "successful")


if __name__ == "__main__":
    unittest.main()
