"""Requests that are none, too large, or made to be read two ways."""

import random
import re
import socket
import unittest

import serving


class Abuse(serving.ServerTest):
    def statuses(self, data):
        return [int(status) for status in re.findall(rb"HTTP/1\.1 (\d{3}) ", self.raw(data))]

    def post(self, more, body=b"", path="/v1/processes/triangulate/execution"):
        return self.head("POST", path, "Content-Type: application/json\r\n" + more) + body

    def test_large_headers_are_refused(self):
        self.assertEqual(self.statuses(self.head("GET", "/v1", "X-A: " + "a" * 9000 + "\r\n")), [431])
        self.assertEqual(self.statuses(self.head("GET", "/v1", "".join(f"X-{n}: a\r\n" for n in range(2000)))), [431])
        self.assertIn(self.statuses(self.head("GET", "/" + "a" * 9000)), ([431], [400]))
        self.assertEqual(self.statuses(self.head("GET", "/v1", "X-A: " + "a" * 6000 + "\r\nConnection: close\r\n")), [200])

    def test_large_bodies_are_refused(self):
        self.assertEqual(self.statuses(self.post(f"Content-Length: {2 << 20}\r\n", b"a" * (2 << 20))), [413])
        self.assertEqual(self.statuses(self.post("Content-Length: 99999999999999999999999\r\n")), [400])
        self.assertEqual(self.statuses(self.post(f"Content-Length: {2 ** 64 - 1}\r\n")), [413])
        chunk = b"10000\r\n" + b"a" * 65536 + b"\r\n"
        self.assertEqual(self.statuses(self.post("Transfer-Encoding: chunked\r\n", chunk * 40)), [413])
        self.assertEqual(self.statuses(self.post("Transfer-Encoding: chunked\r\n", b"1;" + b"x" * (1 << 20))), [400])
        self.assertEqual(self.statuses(self.post("Transfer-Encoding: chunked\r\nConnection: close\r\n",
                                                 b"FFFFFFFFFFFFFFFF\r\n")), [413])

    def test_deep_json_is_refused(self):
        for body in (b'{"inputs":' + b"[" * 500_000, b'{"a":' * 100_000, b"[" * (1 << 20)):
            self.assertEqual(self.statuses(self.post(f"Content-Length: {len(body)}\r\nConnection: close\r\n", body)), [400])

    def test_what_could_be_read_two_ways_is_refused(self):
        body = b"0\r\n\r\nGET /v1/smuggled HTTP/1.1\r\n\r\n"
        for more in (f"Content-Length: {len(body)}\r\nTransfer-Encoding: chunked\r\n",
                     f"Transfer-Encoding: chunked\r\nContent-Length: {len(body)}\r\n",
                     "Content-Length: 5\r\nContent-Length: 6\r\n", "Content-Length: +5\r\n", "Content-Length: -1\r\n",
                     "Content-Length: 0x5\r\n", "Content-Length : 5\r\n", "Content-Length: 5, 6\r\n",
                     "Transfer-Encoding: chunked, identity\r\n", "Transfer-Encoding: xchunked\r\n",
                     "Transfer-Encoding: chunked\r\nTransfer-Encoding: chunked\r\n"):
            with self.subTest(more):
                statuses = self.statuses(self.post(more, body))
                self.assertEqual(len(statuses), 1, statuses)
                self.assertIn(statuses[0], (400, 501, 413))
        for data in (b"GET /v1\r\n\r\n", b"GET /v1 HTTP/2.0\r\nHost: localhost\r\n\r\n", b"\x16\x03\x01\x02\x00\x01\x00",
                     b"G\x00T /v1 HTTP/1.1\r\n\r\n", b"GET /v1 HTTP/1.1\nHost: localhost\n\n", b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n",
                     b"GET /v1 HTTP/1.1\r\nHost: localhost\r\nX: a\x00b\r\n\r\n", b"GET /v1\x01 HTTP/1.1\r\n\r\n"):
            with self.subTest(data):
                self.assertEqual(self.statuses(data), [400])

    def test_a_header_that_goes_on_in_the_next_line_is_refused(self):
        # What stands before this service may take the second line for a header of its own.
        for more in ("X-A: b\r\n Transfer-Encoding: chunked\r\n", "X-A: b\r\n\tc\r\n", "X-A:\r\n b\r\nX-C: d\r\n"):
            with self.subTest(more):
                self.assertEqual(self.statuses(self.head("GET", "/v1", more) * 2), [400])
        self.assertEqual(self.statuses(b"GET /v1 HTTP/1.1\r\n Host: localhost\r\n\r\n"), [400])
        self.assertEqual(self.statuses(self.head("GET", "/v1", "X-A: \t b \r\nConnection: close\r\n")), [200])

    def test_ten_thousand_mutated_requests(self):
        choose = random.Random(20)
        body = b'{"inputs":{"inputs":["a.las"],"tiles":5,"crop":[0,0,0,1,1,1]}}'
        seeds = [self.head("GET", "/v1/jobs?limit=5&status=running", "Accept: application/json\r\n"),
                 self.head("GET", "/v1/triangulations/block/files/deep/tile.vtu", 'Range: bytes=3-\r\nIf-Range: "xxh3-0123"\r\n'),
                 self.post(f"Content-Length: {len(body)}\r\n", body),
                 self.post("Transfer-Encoding: chunked\r\n", b"%x\r\n%s\r\n0\r\n\r\n" % (len(body), body)),
                 self.head("PUT", "/v1/uploads/m/a.las", "Content-Length: 4\r\n") + b"abcd",
                 self.head("DELETE", "/v1/jobs/j1"), self.head("OPTIONS", "/v1/jobs")]
        pieces = [b"\r\n", b"\r\n\r\n", b"\x00", b"%2e%2e/", b"\xff\xfe", b": ", b" ", b"HTTP/1.1", b"Content-Length: 9\r\n",
                  b"chunked", b"-1", b"99999999999999999999", b"{", b'"', b"/"]
        seen = {}
        for _ in range(10_000):
            data = bytearray(choose.choice(seeds))
            for _ in range(choose.randint(0, 4)):
                at = choose.randrange(len(data))
                kind = choose.randrange(4)
                if kind == 0:
                    data[at] = choose.randrange(256)
                elif kind == 1:
                    del data[at:at + choose.randint(1, 20)]
                elif kind == 2:
                    data[at:at] = choose.choice(pieces)
                else:
                    data[at:at] = data[at // 2:at // 2 + choose.randint(1, 40)]
                if not data:
                    break
            with socket.create_connection(("127.0.0.1", self.server.port), 30) as connection:
                try:
                    connection.sendall(data)
                    connection.shutdown(socket.SHUT_WR)
                    got = b""
                    while piece := connection.recv(65536):
                        got += piece
                except ConnectionError:
                    pass
            if got:
                match = re.match(rb"HTTP/1\.1 (\d{3}) ", got)
                self.assertTrue(match, (bytes(data), got[:100]))
                status = int(match[1])
                self.assertNotIn(status, (500,), bytes(data))
                seen[status] = seen.get(status, 0) + 1
        for status in (200, 201, 206, 400, 401, 404):
            self.assertGreater(seen.get(status, 0), 20, seen)
        self.assertEqual(self.ask("GET", "/v1").status, 200)
        self.assertLess(self.server.descriptors(), 60)


if __name__ == "__main__":
    unittest.main()
