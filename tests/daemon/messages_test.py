"""Questions to results, asked and answered as messages of proto/query.proto: by protoc, against the answers in JSON."""
import json
import pathlib
import re
import subprocess
import unittest

import numpy as np

from daemon import DaemonTest

PROTO = pathlib.Path(__file__).parents[2] / "proto"
KIND = "application/x-protobuf"
# Of messages, protoc leaves these out when they are 0 or false; all others are there when they are known.
WITHOUT_PRESENCE = {"asked", "id", "tile", "on_hull", "distance", "x", "y", "part"}
LISTS = {"point", "vertices", "neighbors", "cells", "answers", "points", "weights"}


def protoc(how, message, data):
    done = subprocess.run(["protoc", f"--{how}=tessera.proto.{message}", "-I", PROTO, PROTO / "query.proto"], input=data,
                          stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    assert done.returncode == 0, done.stderr
    return done.stdout


def decoded(message, data):
    """What protoc prints, as lists and dictionaries: the names of fields are those of JSON."""
    open_ones = [{}]
    for line in protoc("decode", message, data).decode().splitlines():
        line = line.strip()
        if line == "}":
            open_ones.pop()
            continue
        name, value = re.fullmatch(r"(\w+)(?:: (\S+)| \{)", line).groups()
        value = {} if value is None else json.loads(value)
        if name in LISTS:
            open_ones[-1].setdefault(name, []).append(value)
        else:
            open_ones[-1][name] = value
        if isinstance(value, dict):
            open_ones.append(value)
    return open_ones[0]


def plain(value):
    """An answer in JSON or from protoc, without what either leaves out. A neighbour that is none: no members."""
    if isinstance(value, list):
        return [{} if one is None else plain(one) for one in value]
    if not isinstance(value, dict):
        return value
    return {name: plain(one) for name, one in value.items()
            if one is not None and one != [] and not (name in WITHOUT_PRESENCE and one == 0)}


class Messages(DaemonTest):
    def setUp(self):
        super().setUp()
        self.daemon = self.start()
        self.execute("triangulate", output="flat", dim=2, tiles=6)
        self.execute("triangulate", output="solid", dim=3, tiles=3)
        box = self.daemon.request("GET", "/v1/triangulations/solid")[2]["bounds"]
        self.low, self.high = np.array(box[:3]), np.array(box[3:])
        self.points = np.random.default_rng(8).random((300, 3)) * (self.high - self.low) * 1.2 + self.low - (self.high - self.low) * 0.1

    def execute(self, process, **inputs):
        status, _, job = self.daemon.request("POST", f"/v1/processes/{process}/execution", {"inputs": {"inputs": ["ign_77050_627755.las"]} | inputs})
        self.assertEqual(status, 201, job)
        self.assertEqual(self.daemon.wait(job["jobID"])["status"], "successful")

    def ask(self, method, question, body=None, **headers):
        return self.daemon.request(method, f"/v1/triangulations/{question}", body, {k.replace("_", "-"): v for k, v in headers.items()})

    def same(self, question, message):
        """The answer in JSON, after it was found to be that of the message."""
        status, headers, text = self.ask("GET", question, Accept="application/json")
        self.assertEqual((status, headers["Content-Type"]), (200, "application/json"))
        status, others, data = self.ask("GET", question, Accept=KIND)
        self.assertEqual((status, others["Content-Type"], others["Tessera-Final"]), (200, KIND, headers["Tessera-Final"]))
        self.assertEqual((headers["Vary"], others["Vary"]), ("Accept", "Accept"))
        self.assertNotEqual(headers["ETag"], others["ETag"])
        self.assertEqual(self.ask("GET", question, Accept=KIND, If_None_Match=others["ETag"])[0], 304)
        self.assertEqual(self.ask("GET", question, Accept=KIND, If_None_Match=headers["ETag"])[0], 200)
        self.assertEqual(plain(decoded(message, data)), plain(text))
        return text

    def message_of(self, points):
        return protoc("encode", "Points", "".join(f"{name}: {value!r}\n" for name, column in zip("xyz", points.T)
                                                  for value in column.tolist()).encode())

    def test_one_answer_says_what_it_says_in_json(self):
        outside = 0
        for name, dim in (("flat", 2), ("solid", 3)):
            for point in self.points[:25, :dim]:
                found = self.same(f"{name}/locate?point={','.join(map(repr, point.tolist()))}", "Location")
                outside += found["cell"] is None
                for corner in found.get("vertices", [])[:1]:
                    self.same(f"{name}/vertices/{corner['id']}/star", "Star")
                    self.same(f"{name}/locate?cell={found['tile']},{found['cell']}", "Location")
        self.assertIn(outside, range(1, 50))
        a, b = (",".join(map(repr, at[:2].tolist())) for at in (self.low, self.high))
        heights = self.ask("GET", f"flat/profile?f=json&line={a}%20{b}")[2]["points"]
        status, headers, data = self.ask("GET", f"flat/profile?line={a}%20{b}", Accept=KIND)
        self.assertEqual((status, headers["Content-Type"]), (200, KIND))
        told = [{("value" if name == "z" else name): value for name, value in point.items()} for point in heights]
        self.assertGreater(len(told), 100)
        self.assertEqual(decoded("Profile", data)["points"], plain(told))

    def test_many_answers_say_what_they_say_in_json(self):
        for name, dim in (("flat", 2), ("solid", 3)):
            points = self.points[:, :dim]
            questions = ("locate", "interpolate", "interpolate?method=natural&weights=true") if dim == 2 else ("locate",)
            for question in questions:
                right = self.ask("POST", f"{name}/{question}", {"points": points.tolist()})[2]
                self.assertEqual(len(right["answers"]), 300)
                body = self.message_of(points)
                status, headers, data = self.ask("POST", f"{name}/{question}", body, Content_Type=KIND)
                self.assertEqual((status, headers["Content-Type"], headers["Vary"]), (200, KIND, "Accept"))
                self.assertEqual(plain(decoded("Answers", data)), plain(right))
                # Either may be without the other.
                self.assertEqual(self.ask("POST", f"{name}/{question}", body, Content_Type=KIND, Accept="application/json")[2], right)
                self.assertEqual(self.ask("POST", f"{name}/{question}", {"points": points.tolist()}, Accept=KIND)[2], data)

    def test_a_region_says_what_is_final(self):
        middle = (self.low + self.high) / 2
        box = [*(middle[:2] - 6).tolist(), *(middle[:2] + 6).tolist()]
        self.execute("region", output="part", dim=2, bbox=box)
        points = np.random.default_rng(9).uniform(middle[:2] - 12, middle[:2] + 12, (200, 2))
        for point in points[:30]:
            self.same(f"part/locate?point={','.join(map(repr, point.tolist()))}", "Location")
        for question in ("locate", "interpolate?method=natural"):
            right = self.ask("POST", f"part/{question}", {"points": points.tolist()})[2]
            self.assertEqual({answer["final"] for answer in right["answers"]}, {False, True})
            data = self.ask("POST", f"part/{question}", self.message_of(points), Content_Type=KIND)[2]
            self.assertEqual(plain(decoded("Answers", data)), plain(right))

    def test_what_is_no_message_of_points_is_refused_with_a_sentence(self):
        flat = self.points[:3, :2]
        for name, body, status, says in (
                ("flat", b"", 422, "the body: has no points"),
                ("flat", b'{"points": [[1, 2]]}', 422, "the body: "),
                ("flat", b"\xff\xff", 422, "the body: is not a protobuf message tessera.proto.Points"),
                ("flat", self.message_of(flat)[:-1], 422, "the body: is not a protobuf message tessera.proto.Points"),
                ("flat", self.message_of(flat[:, :1]), 422, "the body: has 3 values of x, but 0 of y"),
                ("solid", self.message_of(flat), 422, "the body: has 3 values of x, but 0 of z"),
                ("flat", protoc("encode", "Points", b"x: 1 x: 2 y: 1 y: inf"), 422, "the body: point 1 has a coordinate that is not finite"),
                ("flat", bytes(2 << 20), 413, "1048576")):
            with self.subTest(says):
                answer = self.ask("POST", f"{name}/locate", body, Content_Type=KIND, Accept=KIND)
                self.assertEqual((answer[0], answer[1]["Content-Type"]), (status, "application/problem+json"), answer[2])
                self.assertIn(says, answer[2]["detail"])
        self.assertEqual(self.daemon.end(), 0, self.daemon.messages())


if __name__ == "__main__":
    unittest.main()
