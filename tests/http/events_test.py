"""Events as a watcher reads them."""

import json
import socket
import unittest

import serving


class Stream:
    """Server-sent events over a socket."""

    def __init__(self, test, path, **headers):
        self.socket = socket.create_connection(("127.0.0.1", test.server.port), 30)
        test.addCleanup(self.close)
        more = "".join(f"{name.replace('_', '-')}: {value}\r\n" for name, value in headers.items())
        self.socket.sendall(test.head("GET", path, more))
        self.file = self.socket.makefile("rb")
        self.status = int(self.file.readline().split()[1])
        self.headers = {}
        while (line := self.file.readline().strip()):
            name, value = line.decode().split(": ", 1)
            self.headers[name] = value

    def close(self):
        self.file.close()
        self.socket.close()

    def line(self):
        return self.file.readline().decode()

    def event(self):
        """(id, what it says), or None at the end."""
        number = None
        while line := self.line():
            if line.startswith("id: "):
                number = int(line[4:])
            if line.startswith("data: "):
                return number, json.loads(line[6:])
        return None


class Events(serving.ServerTest):
    options = {"comment_ms": 200}

    def test_who_follows_a_live_result_hears_of_each_version(self):
        path = "/v1/triangulations/block/"
        versions = [self.ask("POST", path + "points", {"points": [[1, 2, 3]]}).json()["version"] for _ in range(3)]
        late = Stream(self, path + "events", Last_Event_ID=versions[0])
        now = Stream(self, path + "events")
        self.assertEqual((now.status, now.headers["Content-Type"]), (200, "text/event-stream"))
        versions.append(self.ask("DELETE", path + "points", {"ids": [1]}).json()["version"])
        self.assertEqual([late.event()[0] for _ in range(3)], versions[1:])
        number, heard = now.event()
        self.assertEqual(number, versions[3])
        self.validate(heard, {"$ref": "#/components/schemas/Event"})
        self.assertEqual((heard["kind"], heard["made"]["removed"], heard["made"]["changed"]),
                         ("version", 1, [{"bounds": [0, 0.5, 1, 2, 2.5, 3]}]))
        missed = Stream(self, path + "events", Last_Event_ID=10**9)
        self.assertTrue(missed.event()[1]["made"]["everything"])
        self.assertEqual(Stream(self, path + "events", Last_Event_ID="x").status, 400)
        self.assertEqual(Stream(self, "/v1/triangulations/none/events").status, 404)

    def test_a_watcher_hears_of_its_job_until_it_ends(self):
        job, other = self.submit(), self.submit()
        stream = Stream(self, f"/v1/jobs/{job}/events")
        self.assertEqual((stream.status, stream.headers["Content-Type"]), (200, "text/event-stream"))
        self.assertEqual(stream.headers["X-Accel-Buffering"], "no")
        number, now = stream.event()
        self.assertEqual((number, now["status"]["status"]), (None, "accepted"))
        self.server.tell(f"state {other} running")
        self.server.tell(f"state {job} running")
        self.server.tell(f"state {job} successful")
        heard = [stream.event() for _ in range(2)]
        self.assertEqual([event["status"]["status"] for _, event in heard], ["running", "successful"])
        self.assertIsNone(stream.event())
        self.validate(heard[0][1], {"$ref": "#/components/schemas/Event"})

    def test_what_was_missed_is_told_again(self):
        job = self.submit()
        stream = Stream(self, f"/v1/jobs/{job}/events")
        stream.event()
        for state in ("running", "failed", "accepted", "running", "successful"):
            self.server.tell(f"state {job} {state}")
        first, _ = stream.event()
        again = Stream(self, f"/v1/jobs/{job}/events", Last_Event_ID=first)
        self.assertEqual(again.event()[1]["status"]["status"], "failed")
        self.assertEqual(Stream(self, f"/v1/jobs/{job}/events", Last_Event_ID="x").status, 400)

    def test_one_that_ended_is_told_at_once(self):
        job = self.submit()
        self.server.tell(f"state {job} successful")
        stream = Stream(self, f"/v1/jobs/{job}/events")
        self.assertEqual(stream.event()[1]["status"]["status"], "successful")
        self.assertIsNone(stream.event())

    def test_comments_keep_a_quiet_stream_open(self):
        stream = Stream(self, "/v1/events")
        self.assertTrue(stream.line().startswith(":"))

    def test_watchers_that_go_are_forgotten(self):
        streams = [Stream(self, "/v1/events") for _ in range(30)]
        for stream in streams:
            self.assertEqual(stream.status, 200)
            stream.close()
        keep = Stream(self, "/v1/events")
        # The server notices when it reads the end of each; a comment of a later stream comes after that.
        for _ in range(3):
            keep.line()
            keep.line()
        text = self.ask("GET", "/metrics", token=None, port=self.server.operations).body.decode()
        watchers = [line for line in text.splitlines() if line.startswith("tessera_event_watchers")]
        self.assertLess(float(watchers[0].split()[1]), 10)

    def test_one_that_does_not_read_is_dropped_and_harms_nobody(self):
        slow = socket.socket()
        self.addCleanup(slow.close)
        slow.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
        slow.connect(("127.0.0.1", self.server.port))
        slow.sendall(self.head("GET", "/v1/events"))
        fast = Stream(self, "/v1/events")
        self.assertEqual(slow.recv(12), b"HTTP/1.1 200")
        count = 200
        for _ in range(150):
            self.assertTrue(self.server.tell(f"tell {count}"))
            last = [fast.event()[0] for _ in range(count)]
            self.assertEqual(last, list(range(last[0], last[0] + count)))
        slow.settimeout(30)
        got = 0
        while piece := slow.recv(1 << 20):
            got += len(piece)
        self.assertLess(got, 150 * count * 200)


if __name__ == "__main__":
    unittest.main()
