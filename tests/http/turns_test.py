"""Who waits for whom: callers take turns, and health waits for nobody."""

import os
import select
import socket
import unittest

import serving


class InTurn(serving.ServerTest):
    """Two questions at once, or more when others ask. A server each: what one leaves behind would be counted by the next."""
    # Found when nobody waits for it any more.
    waiting = "/v1/triangulations/block/vertices/13/star"

    @classmethod
    def setUpClass(cls):
        cls.document = None

    def setUp(self):
        self.server = serving.Server()
        self.addCleanup(self.server.close)

    def held(self, token, count):
        connections = [socket.create_connection(("127.0.0.1", self.server.port), 30) for _ in range(count)]
        for connection in connections:
            self.addCleanup(connection.close)
            connection.sendall(self.head("GET", self.waiting, token=token))
        return connections

    def test_one_token_does_not_keep_the_questions_of_others(self):
        self.held("read", 8)
        self.assertTrue(self.server.tell("asked 2"))
        for token in ("submit", "admin"):
            for _ in range(3):
                self.assertEqual(self.ask("GET", "/v1/triangulations/block/locate?point=1,2", token=token).status, 200)

    def test_more_than_wait_are_told_to_come_back(self):
        held = self.held("read", 65)
        refused, _, _ = select.select(held, [], [])
        self.assertEqual(len(refused), 1)
        got = refused[0].recv(65536)
        self.assertTrue(got.startswith(b"HTTP/1.1 503 "), got)
        self.assertIn(b"\r\nRetry-After: 5\r\n", got)
        self.assertEqual(self.ask("GET", "/v1/triangulations/block/locate?point=1,2", token="submit").status, 200)

    def test_bodies_that_wait_are_bounded(self):
        body = b"1,2\n" * (1 << 18)
        before = self.server.memory()
        self.held("read", 2)
        self.assertTrue(self.server.tell("asked 2"))
        answers = []
        for _ in range(60):
            connection = socket.create_connection(("127.0.0.1", self.server.port), 30)
            self.addCleanup(connection.close)
            connection.sendall(self.head("POST", "/v1/triangulations/block/interpolate",
                                         f"Content-Type: text/csv\r\nContent-Length: {len(body)}\r\nExpect: 100-continue\r\n",
                                         token="read"))
            answers.append(connection.recv(12).decode())
            if answers[-1].endswith("100"):
                connection.recv(100)
                connection.sendall(body)
        self.assertEqual(answers.count("HTTP/1.1 100"), 32)
        self.assertEqual(answers.count("HTTP/1.1 503"), 28)
        if "SANITIZED" not in os.environ:
            self.assertLess(self.server.memory() - before, 64 << 20)


class Waiting(serving.ServerTest):
    options = {"threads": 1, "workers": 2}

    def test_who_changes_much_holds_up_neither_readers_nor_supervisors(self):
        self.assertTrue(self.server.tell("hold 1"))
        changes = [self.connect() for _ in range(12)]
        token = {"Authorization": "Bearer " + self.server.tokens["submit"], "Content-Type": "application/json"}
        for connection in changes:
            connection.request("POST", "/v1/processes/triangulate/estimate", '{"inputs":{"inputs":["a.las"]}}', headers=token)
        self.assertTrue(self.server.tell("held 4"))
        for path in ("/livez", "/readyz", "/metrics"):
            self.assertEqual(self.ask("GET", path, token=None, port=self.server.operations).status, 200, path)
        self.assertEqual(self.ask("GET", "/v1/triangulations/block").status, 200)
        # Nor does it hold up the changes of others.
        self.assertEqual(self.submit() and 201, 201)
        self.assertTrue(self.server.tell("hold 0"))
        self.assertEqual([connection.getresponse().status for connection in changes], [200] * 12)

    def test_supervisors_are_answered_while_readers_wait(self):
        self.assertTrue(self.server.tell("hold 1"))
        token = {"Authorization": "Bearer " + self.server.tokens["read"]}
        waiting = [self.connect() for _ in range(6)]
        for connection in waiting:
            connection.request("GET", "/v1/triangulations", headers=token)
        self.assertTrue(self.server.tell("held 2"))
        for path in ("/livez", "/readyz", "/metrics"):
            self.assertEqual(self.ask("GET", path, token=None, port=self.server.operations).status, 200, path)
        self.assertTrue(self.server.tell("hold 0"))
        self.assertEqual([connection.getresponse().status for connection in waiting], [200] * 6)

    def test_who_goes_away_ends_what_is_done_for_them(self):
        with socket.create_connection(("127.0.0.1", self.server.port), 30) as connection:
            body = b'{"inputs":{"inputs":["until.gone"]}}'
            connection.sendall(self.head("POST", "/v1/processes/triangulate/estimate",
                                         f"Content-Type: application/json\r\nContent-Length: {len(body)}\r\n") + body)
            self.assertTrue(self.server.tell("asked 1"))
        self.assertTrue(self.server.tell("given_up 1"))

    def test_who_waits_for_a_disk_holds_up_nobody_else(self):
        self.assertTrue(self.server.tell("hold 1"))
        token = {"Authorization": "Bearer " + self.server.tokens["read"]}
        waiting = [self.connect() for _ in range(6)]
        for connection in waiting:
            connection.request("GET", "/v1/triangulations", headers=token)
        self.assertTrue(self.server.tell("held 2"))  # all workers there are
        self.assertEqual(self.ask("GET", "/livez", port=self.server.operations).body, b"live\n")
        self.assertEqual(self.ask("GET", "/v1/jobs").status, 200)
        self.assertEqual(self.ask("GET", "/v1").status, 200)
        self.assertTrue(self.server.tell("hold 0"))
        self.assertEqual([connection.getresponse().status for connection in waiting], [200] * 6)


if __name__ == "__main__":
    unittest.main()
