"""Connections: kept, bounded, timed, drained."""

import http.client
import os
import re
import socket
import threading
import time
import unittest

import serving


def closed(connection, timeout=30):
    """Whether the server ends the connection; what it sent before."""
    connection.settimeout(timeout)
    got = b""
    try:
        while piece := connection.recv(65536):
            got += piece
    except ConnectionError:
        pass
    return got


class Questions(serving.ServerTest):
    # The star of vertex 13 is found when nobody waits for it any more.
    waiting = "/v1/triangulations/block/vertices/13/star"

    def test_a_caller_that_goes_ends_the_work(self):
        for gone in range(1, 4):
            with socket.create_connection(("127.0.0.1", self.server.port), 30) as connection:
                connection.sendall(self.head("GET", self.waiting))
            self.assertTrue(self.server.tell(f"given_up {gone}"))

    def test_they_do_not_hold_up_others(self):
        waiting = [socket.create_connection(("127.0.0.1", self.server.port), 30) for _ in range(8)]
        for connection in waiting:
            connection.sendall(self.head("GET", self.waiting))
        for _ in range(20):
            self.assertEqual(self.ask("GET", "/v1/triangulations").status, 200)
        for connection in waiting:
            connection.close()

    def test_a_request_that_follows_is_no_farewell(self):
        with socket.create_connection(("127.0.0.1", self.server.port), 30) as connection:
            connection.sendall(self.head("GET", self.waiting) + self.head("GET", "/v1"))
            connection.settimeout(1)
            self.assertRaises(TimeoutError, connection.recv, 1)

    def test_a_server_that_ends_does_not_wait_for_them(self):
        server = serving.Server()
        with socket.create_connection(("127.0.0.1", server.port), 30) as connection:
            connection.sendall(self.head("GET", self.waiting))
            with socket.create_connection(("127.0.0.1", server.port), 30) as other:
                other.sendall(self.head("GET", "/v1", "Connection: close\r\n"))
                self.assertIn(b"200 OK", closed(other))
            self.assertEqual(server.close(), 0)

    def test_an_answer_is_known_by_its_etag(self):
        place = "/v1/triangulations/block/locate?point="
        answer = self.ask("GET", place + "1,2")
        self.assertEqual((answer.status, answer.headers["Tessera-Final"]), (200, "true"))
        again = self.ask("GET", place + "1,2", headers={"If-None-Match": answer.headers["ETag"]})
        self.assertEqual((again.status, again.body, again.headers["ETag"]), (304, b"", answer.headers["ETag"]))
        other = self.ask("GET", place + "1,3", headers={"If-None-Match": answer.headers["ETag"]})
        self.assertEqual(other.status, 200)
        self.assertNotEqual(other.headers["ETag"], answer.headers["ETag"])

    def test_what_is_sent_is_of_a_known_type(self):
        place = "/v1/triangulations/block/interpolate"
        for kind, status in (("text/csv; charset=utf-8", 200), ("application/x-npy", 200), ("application/x-www-form-urlencoded", 415)):
            self.assertEqual(self.ask("POST", place, b"1,2", headers={"Content-Type": kind}).status, status, kind)


class Connections(serving.ServerTest):
    def test_are_kept(self):
        connection = self.connect()
        connection.connect()
        before = connection.sock
        for _ in range(20):
            connection.request("GET", "/v1/jobs", headers={"Authorization": "Bearer " + self.server.tokens["read"]})
            self.assertEqual(connection.getresponse().read()[:1], b"{")
            self.assertIs(connection.sock, before)
        connection.request("GET", "/v1", headers={"Connection": "close"})
        self.assertEqual(connection.getresponse().headers["Connection"], "close")

    def test_requests_may_follow_each_other_before_their_answers(self):
        many = self.head("GET", "/v1/conformance") * 50 + self.head("GET", "/v1/none") + \
            self.head("GET", "/v1", "Connection: close\r\n")
        got = self.raw(many)
        statuses = re.findall(rb"HTTP/1.1 (\d+) ", got)
        self.assertEqual(statuses, [b"200"] * 50 + [b"404", b"200"])

    def test_a_body_is_followed_by_the_next_request(self):
        body = b'{"inputs":{"inputs":["a.las"]}}'
        one = self.head("POST", "/v1/processes/triangulate/execution",
                        f"Content-Type: application/json\r\nContent-Length: {len(body)}\r\n") + body
        chunks = b"%x\r\n%s\r\n%x;a=b\r\n%s\r\n0\r\n\r\n" % (5, body[:5], len(body) - 5, body[5:])
        two = self.head("POST", "/v1/processes/triangulate/execution",
                        "Content-Type: application/json\r\nTransfer-Encoding: chunked\r\n") + chunks
        got = self.raw(one + two + self.head("GET", "/v1", "Connection: close\r\n"))
        self.assertEqual(re.findall(rb"HTTP/1.1 (\d+) ", got), [b"201", b"201", b"200"])

    def test_a_body_can_wait_for_100(self):
        body = b'{"inputs":{"inputs":["a.las"]}}'
        with socket.create_connection(("127.0.0.1", self.server.port), 30) as connection:
            connection.sendall(self.head("POST", "/v1/processes/triangulate/execution",
                                         f"Content-Type: application/json\r\nContent-Length: {len(body)}\r\n"
                                         "Expect: 100-continue\r\nConnection: close\r\n"))
            self.assertEqual(connection.recv(100), b"HTTP/1.1 100 Continue\r\n\r\n")
            connection.sendall(body)
            self.assertTrue(closed(connection).startswith(b"HTTP/1.1 201 "))
        self.assertIn(b" 417 ", self.raw(self.head("GET", "/v1", "Expect: cake\r\nConnection: close\r\n")))
        got = self.raw(self.head("POST", "/v1/processes/triangulate/execution",
                                 "Content-Length: 9\r\nExpect: 100-continue\r\n", token="read"))
        self.assertTrue(got.startswith(b"HTTP/1.1 403 "), got)

    def test_http_1_0_is_answered_and_closed(self):
        got = self.raw(self.head("GET", "/v1").replace(b"HTTP/1.1", b"HTTP/1.0", 1))
        self.assertTrue(got.startswith(b"HTTP/1.1 200 "))

    def test_a_thousand_idle_ones_cost_little(self):
        for _ in range(3):
            self.ask("GET", "/v1")
        memory, descriptors = self.server.memory(), self.server.descriptors()
        idle = []
        for _ in range(1000):
            connection = socket.create_connection(("127.0.0.1", self.server.port), 30)
            idle.append(connection)
            connection.sendall(self.head("GET", "/v1/jobs"))
            self.assertTrue(connection.recv(65536).startswith(b"HTTP/1.1 200 "))
        self.assertEqual(self.ask("GET", "/v1").status, 200)
        if "SANITIZED" not in os.environ:  # a sanitizer's shadow says nothing of it
            self.assertLess(self.server.memory() - memory, 32 << 20)
        for connection in idle:
            connection.sendall(self.head("GET", "/v1", "Connection: close\r\n"))
            closed(connection)
            connection.close()
        self.ask("GET", "/v1")
        self.assertLessEqual(self.server.descriptors(), descriptors + 2)


class Slow(serving.ServerTest):
    options = {"header_ms": 500, "idle_ms": 700}

    def test_headers_that_drip_are_cut_off(self):
        with socket.create_connection(("127.0.0.1", self.server.port), 30) as connection:
            connection.sendall(b"GET /v1 HTTP/1.1\r\nHost: localhost\r\n")
            stop = threading.Event()

            def drip():
                try:
                    while not stop.wait(0.05):
                        connection.sendall(b"X-A: b\r\n")
                except OSError:
                    pass  # that is what is waited for
            thread = threading.Thread(target=drip)
            thread.start()
            self.assertEqual(closed(connection), b"")
            stop.set()
            thread.join()

    def test_silent_ones_are_cut_off(self):
        for begin in (b"", b"GET"):
            with socket.create_connection(("127.0.0.1", self.server.port), 30) as connection:
                connection.sendall(begin)
                self.assertEqual(closed(connection), b"")
        with socket.create_connection(("127.0.0.1", self.server.port), 30) as connection:
            connection.sendall(self.head("GET", "/v1"))
            self.assertTrue(closed(connection).startswith(b"HTTP/1.1 200 "))

    def test_others_are_served_meanwhile(self):
        slow = [socket.create_connection(("127.0.0.1", self.server.port), 30) for _ in range(100)]
        for connection in slow:
            connection.sendall(b"GET /v1 HTTP/1.1\r\n")
        self.assertEqual(self.ask("GET", "/v1").status, 200)
        for connection in slow:
            self.assertEqual(closed(connection), b"")
            connection.close()


class SlowReader(serving.ServerTest):
    options = {"write_ms": 2000, "profile_bytes": 24_000_000}
    profile = "/v1/triangulations/block/profile?line=0,0%201,1"

    def test_who_reads_on_gets_all_of_an_answer(self):
        # More slowly than would do for the whole of it at once.
        with socket.create_connection(("127.0.0.1", self.server.port), 30) as connection:
            connection.sendall(self.head("GET", self.profile, "Connection: close\r\n"))
            began, got = time.monotonic(), bytearray()
            while piece := connection.recv(1 << 18):
                got += piece
                while time.monotonic() - began < 5 * len(got) / 24e6:
                    time.sleep(0.01)  # the pace is what is tried
        head, body = bytes(got).split(b"\r\n\r\n", 1)
        self.assertIn(b"Content-Length: 24000000", head)
        self.assertEqual(len(body), 24_000_000)

    def test_who_reads_no_more_is_cut_off(self):
        with socket.create_connection(("127.0.0.1", self.server.port), 30) as connection:
            connection.sendall(self.head("GET", self.profile, "Connection: close\r\n"))
            self.assertTrue(connection.recv(1000).startswith(b"HTTP/1.1 200 "))
            # Until the one that asks is the only one left.
            while "tessera_http_connections 1\n" not in self.ask(
                    "GET", "/metrics", token=None, port=self.server.operations).body.decode():
                pass
            self.assertLess(len(closed(connection)), 24_000_000)


class FewDescriptors(serving.ServerTest):
    """Of 100 open files 25 connections, half of them from one address; the rest is for jobs."""
    options = {"open_files": 100}

    def test_are_left_to_jobs_and_to_others(self):
        held = []
        for _ in range(60):
            connection = socket.create_connection(("127.0.0.1", self.server.port), 30)
            self.addCleanup(connection.close)
            connection.sendall(self.head("GET", "/v1/jobs"))
            if connection.recv(65536).startswith(b"HTTP/1.1 200 "):
                held.append(connection)
        self.assertEqual(len(held), 12)
        self.assertLess(self.server.descriptors(), 50)
        with socket.create_connection(("127.0.0.1", self.server.port), 30, ("127.0.0.2", 0)) as other:
            other.sendall(self.head("GET", "/v1/jobs"))
            self.assertTrue(other.recv(65536).startswith(b"HTTP/1.1 200 "))
        self.assertIn("the limit of open files", self.server.log())


class Operations(serving.ServerTest):
    def test_connections_to_it_are_bounded_and_keep_nobody_from_the_api(self):
        held = []
        for number in range(80):
            connection = socket.create_connection(("127.0.0.1", self.server.operations), 30, (f"127.0.0.{2 + number % 4}", 0))
            self.addCleanup(connection.close)
            connection.sendall(b"GET /livez HTTP/1.1\r\nHost: localhost\r\n\r\n")
            if connection.recv(65536).startswith(b"HTTP/1.1 200 "):
                held.append(connection)
        self.assertEqual(len(held), 64)
        self.assertEqual(self.ask("GET", "/v1").status, 200)


class Bounded(serving.ServerTest):
    options = {"connections": 5}

    def test_more_are_told_to_come_back(self):
        held = []
        for _ in range(5):
            connection = socket.create_connection(("127.0.0.1", self.server.port), 30)
            connection.sendall(self.head("GET", "/v1"))
            self.assertTrue(connection.recv(65536).startswith(b"HTTP/1.1 200 "))
            held.append(connection)
        with socket.create_connection(("127.0.0.1", self.server.port), 30) as more:
            head, body = closed(more).split(b"\r\n\r\n")
        self.assertTrue(head.startswith(b"HTTP/1.1 503 "))
        self.assertIn(b"Retry-After: ", head)
        self.assertIn(f"Content-Length: {len(body)}".encode(), head)
        # Health is told all the same.
        self.assertEqual(self.ask("GET", "/livez", token=None, port=self.server.operations).status, 200)
        held[0].sendall(self.head("GET", "/v1", "Connection: close\r\n"))
        closed(held[0])
        for connection in held:
            connection.close()
        text = self.ask("GET", "/metrics", token=None, port=self.server.operations).body.decode()
        self.assertIn("tessera_http_connections_refused_total 1", text)


class Drained(serving.ServerTest):
    options = {"file_bytes": 20_000_000}

    def test_what_is_asked_is_answered_and_no_more_is_taken(self):
        idle = socket.create_connection(("127.0.0.1", self.server.port), 30)
        idle.sendall(self.head("GET", "/v1"))
        self.assertTrue(idle.recv(65536).startswith(b"HTTP/1.1 200 "))
        watcher = socket.create_connection(("127.0.0.1", self.server.port), 30)
        watcher.sendall(self.head("GET", "/v1/events"))
        self.assertTrue(watcher.recv(65536).startswith(b"HTTP/1.1 200 "))
        busy = http.client.HTTPConnection("127.0.0.1", self.server.port, timeout=30)
        busy.request("GET", "/v1/triangulations/block/files/deep/tile.vtu",
                     headers={"Authorization": "Bearer " + self.server.tokens["read"]})
        answer = busy.getresponse()
        got = []
        reader = threading.Thread(target=lambda: got.append(len(answer.read())))
        reader.start()
        self.assertTrue(self.server.tell("drain"))
        reader.join()
        self.assertEqual(got, [20_000_000])
        self.assertEqual((closed(idle), closed(watcher)[-4:]), (b"", b""))
        with self.assertRaises(ConnectionError):
            socket.create_connection(("127.0.0.1", self.server.port), 30)
        for connection in (idle, watcher, busy):
            connection.close()


if __name__ == "__main__":
    unittest.main()
