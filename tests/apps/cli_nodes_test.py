"""The nodes that work on a daemon's jobs: listed, and drained."""
import unittest

from cli import USAGE
from cli_server import ServerTest


class Nodes(ServerTest):
    def setUp(self):
        super().setUp()
        self.server.nodes = [
            {"name": "a", "id": "0a", "address": "10.0.0.1:7072", "threads": 8, "memoryBytes": 2 << 30, "memoryUsedBytes": 1 << 20,
             "scratchFreeBytes": 5 << 30, "certificateWarning": "ends on 2028-11-21 13:18 UTC, in 12 days: mend it", "tiles": 12,
             "state": "free", "seconds": 7384, "silentMs": 1200, "coordinator": True},
            {"name": "b c", "id": "0b", "address": "10.0.0.2:7072", "threads": 4, "memoryBytes": 1 << 30, "state": "joining",
             "lastWords": "was killed (SIGKILL), while splaying"}]

    def test_they_are_listed(self):
        head, a, b, warning, words = self.ok("nodes").splitlines()
        self.assertRegex(head, "^NODE +ADDRESS +STATE +THREADS +MEMORY +USED +SCRATCH +TILES +SINCE +HEARD$")
        self.assertRegex(a, r"^a +10\.0\.0\.1:7072 +free, coordinator +8 +2\.00 GiB +1\.00 MiB +5\.00 GiB free +12 +2 h 03 min +1\.20 s ago$")
        self.assertRegex(b, r"^b c +10\.0\.0\.2:7072 +joining +4 ")
        self.assertEqual(warning, "a: its certificate ends on 2028-11-21 13:18 UTC, in 12 days: mend it")
        self.assertEqual(words, "b c: the process before this one was killed (SIGKILL), while splaying")
        told = self.json_lines(self.ok("nodes", "--json"))
        self.assertEqual([(node["event"], node["name"], node["coordinator"]) for node in told], [("node", "a", True), ("node", "b c", False)])
        self.assertEqual((told[0]["memory_used_bytes"], told[0]["tiles"], told[0]["seconds"]), (1 << 20, 12, 7384))
        self.assertEqual([node["last_words"] for node in told], ["", "was killed (SIGKILL), while splaying"])
        self.server.nodes = []
        self.assertEqual(self.ok("nodes"), "there are no nodes\n")

    def test_one_is_drained(self):
        self.assertEqual(self.ok("drain", "b c"), "node b c takes no more work, and its tiles go to other nodes; its process ends\n")
        self.assertIn("its process goes on as the coordinator", self.ok("drain", "a"))
        self.assertEqual([node["state"] for node in self.json_lines(self.ok("drain", "a", "--json"))], ["draining"])
        self.assertEqual(self.ok("drain", "a", "--quiet"), "")
        self.refused(USAGE, "drain", says="tessera nodes")
        self.refused(USAGE, "drain", "x", says="there is no node 'x'")
        self.assertEqual(len(self.server.asked("POST", "^/v1/nodes/b%20c/drain$")), 1)


if __name__ == "__main__":
    unittest.main()
