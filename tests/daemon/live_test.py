"""Results that the daemon keeps in memory: points are added and removed over HTTP. LIVE_KILLS: how often the daemon is killed."""
import concurrent.futures
import io
import json
import os
import signal
import subprocess
import threading
import unittest

import numpy as np

from daemon import TESSERA, DaemonTest

BLOCK = "/v1/triangulations/block"
KILLS = int(os.environ.get("LIVE_KILLS", "10"))
NPY, PROTOBUF = {"Content-Type": "application/x-npy"}, {"Content-Type": "application/x-protobuf"}


def npy(array):
    out = io.BytesIO()
    np.save(out, array)
    return out.getvalue()


class LiveTest(DaemonTest):
    def make(self, name="block", points=None, *options):
        """A result of a lattice, so that many points are cocircular."""
        if points is None:
            points = np.stack(np.meshgrid(np.arange(12.0), np.arange(10.0)), -1).reshape(-1, 2)
        results = self.folder / "data/results"
        results.mkdir(parents=True, exist_ok=True, mode=0o700)
        np.save(self.folder / "points.npy", points)
        self.tessera("triangulate", "points.npy", "-o", results / name, "--tiles", "6", *options)
        return points

    def add(self, daemon, points, name="block", **more):
        return daemon.request("POST", f"/v1/triangulations/{name}/points", {"points": points, **more})

    def remove(self, daemon, ids, name="block"):
        return daemon.request("DELETE", f"/v1/triangulations/{name}/points", {"ids": ids})

    def proved(self, name="block"):
        """The number of vertices of the stored result, which is proved."""
        self.tessera("verify", self.folder / "data/results" / name)
        return json.loads((self.folder / "data/results" / name / "manifest.json").read_text())["counts"]["vertices"]


class Points(LiveTest):
    def test_memory_answers_what_the_stored_result_answers_later(self):
        self.make()
        daemon = self.start("--live", "block")
        self.assertEqual(self.add(daemon, [[3.5, 4.5], [3, 4], [20, -7.25]])[2],
                         {"version": 1, "firstID": 120, "added": 3, "equal": 1, "removed": 0})
        self.assertEqual(daemon.request("POST", f"{BLOCK}/points", npy(np.array([[0.5, 0.5], [7.25, 7.5]])), NPY)[2]["firstID"], 123)
        self.assertEqual(self.remove(daemon, [0, 17, 40])[2], {"version": 3, "firstID": 125, "added": 0, "equal": 0, "removed": 3})
        self.assertEqual(daemon.request("DELETE", f"{BLOCK}/points", npy(np.array([55, 56], "<i8")), NPY)[2]["removed"], 2)
        self.assertEqual(daemon.request("DELETE", f"{BLOCK}/points", b"\x0a\x02\x02\x03", PROTOBUF)[2]["version"], 5)
        live = daemon.request("GET", BLOCK)[2]["live"]
        self.assertEqual((live["version"], live["storedVersion"], live["vertices"], live["pointsAdded"], live["pointsRemoved"]),
                         (5, 0, 120 + 4 - 7, 5, 7))
        left = sorted({*range(120), 120, 122, 123, 124} - {0, 17, 40, 55, 56, 2, 3})
        questions = [f"vertices/{vertex}/{what}" for vertex in left for what in ("star", "neighbours")]
        places = np.random.default_rng(1).uniform(-2, 13, (60, 2))
        places = np.concatenate([places, np.round(places), np.round(places * 2) / 2])
        questions += [f"locate?point={x},{y}" for x, y in places]
        before = [daemon.request("GET", f"{BLOCK}/{question}") for question in questions]
        self.assertEqual({(status, head["Tessera-Version"], head["ETag"]) for status, head, _ in before}, {(200, "5", None)})
        self.assertEqual(daemon.request("GET", f"{BLOCK}/vertices/17/star")[0], 400)
        self.assertEqual(daemon.request("GET", f"{BLOCK}/cells?bbox=0,0,1,1")[1]["Tessera-Version"], "0")
        self.assertEqual(daemon.end(), 0, daemon.messages())
        self.assertEqual(self.proved(), len(left))
        stored = self.start()
        for question, (_, _, answer) in zip(questions, before):
            self.assertEqual(self.without_places(stored.request("GET", f"{BLOCK}/{question}")[2]), self.without_places(answer), question)
        again = self.start_beside(stored, "--live", "block")
        self.assertEqual(again.request("GET", BLOCK)[2]["live"]["version"], 5)
        self.assertEqual(self.add(again, [[1, 1.5]])[2]["version"], 6)

    def start_beside(self, other, *options):
        self.assertEqual(other.end(), 0)
        return self.start(*options)

    def without_places(self, answer):
        """Without the numbers of cells, and with cells and corners in the order of source indices."""
        if isinstance(answer, list):
            return sorted((self.without_places(part) for part in answer), key=repr)
        if not isinstance(answer, dict):
            return answer
        is_cell = "vertices" in answer
        return {key: self.without_places(value) for key, value in answer.items() if not (is_cell and key in ("tile", "cell"))}

    def test_what_cannot_be_is_refused_and_changes_nothing(self):
        self.make()
        self.make("other")
        daemon = self.start("--live", "block", "--live", "missing,other")
        self.assertIn("'missing' is not live: there is no triangulation 'missing'", daemon.messages())
        for body, status, why in (({"points": []}, 422, "no points"), ({"points": [[1, 2, 3]]}, 422, "values of z"),
                                  ({"points": [[1, 2], [1]]}, 422, "points[1]"), ({"points": [[1, 1e999]]}, 422, ""),
                                  ({"points": [[1, 2]], "attributes": {"no": [1]}}, 400, "no attribute 'no'"),
                                  ({"point": [[1, 2]]}, 422, "'point' is not known"), ([1], 422, "JSON object")):
            found = daemon.request("POST", f"{BLOCK}/points", body)
            self.assertEqual(found[0], status, found)
            self.assertIn(why, found[2]["detail"])
        for ids, status, why in (([5, 120], 400, "there is no point 120"), ([-1], 422, "ids"), (list(range(120)), 400, "no points would be left"),
                                 ([], 422, "no source indices")):
            found = self.remove(daemon, ids)
            self.assertEqual(found[0], status, found)
            self.assertIn(why, found[2]["detail"])
        for body, headers in ((npy(np.array([[1, np.nan]])), NPY), (b"x,y\n1,2\n", NPY), (npy(np.zeros((0, 2))), NPY), (b"\xff", PROTOBUF)):
            self.assertIn(daemon.request("POST", f"{BLOCK}/points", body, headers)[0], (400, 422))
        self.assertEqual(daemon.request("GET", BLOCK)[2]["live"]["version"], 0)
        self.assertEqual(daemon.request("DELETE", BLOCK)[0], 409)
        self.assertEqual(daemon.request("POST", "/v1/processes/measure/execution", {"inputs": {"triangulation": "block", "volume": True}})[0], 409)
        self.assertEqual(daemon.request("POST", "/v1/triangulations/none/points", {"points": [[1, 2]]})[0], 404)
        self.make("cold")
        found = self.add(daemon, [[1, 2]], "cold")
        self.assertEqual((found[0], "not live" in found[2]["detail"]), (409, True))
        self.assertNotIn("live", daemon.request("GET", "/v1/triangulations/cold")[2])
        self.assertEqual(self.add(daemon, [[1.5, 2.5]], "other")[2]["version"], 1)

    def test_one_clients_mistake_does_not_touch_the_others(self):
        self.make()
        daemon = self.start("--live", "block")

        def client(k):
            answers = []
            for i in range(12):
                if k == 0:
                    answers.append(self.remove(daemon, [10_000 + i]))
                else:
                    answers.append(self.add(daemon, [[k + 0.25 + i / 100, i + 0.125]]))
                    if i % 3 == 2:
                        answers.append(self.remove(daemon, [answers[-1][2]["firstID"]]))
            return answers

        with concurrent.futures.ThreadPoolExecutor(8) as pool:
            found = list(pool.map(client, range(8)))
        self.assertEqual({status for status, _, _ in found[0]}, {400})
        good = [answer for answers in found[1:] for answer in answers]
        self.assertEqual({status for status, _, _ in good}, {200})
        ids = [body["firstID"] for _, _, body in good if body["added"]]
        self.assertEqual(sorted(ids), list(range(120, 120 + 7 * 12)))
        self.assertLessEqual(max(body["version"] for _, _, body in good), len(good))
        self.assertEqual(daemon.request("GET", BLOCK)[2]["live"]["vertices"], 120 + 7 * 8)
        self.assertEqual(daemon.end(), 0)
        self.assertEqual(self.proved(), 120 + 7 * 8)

    def test_two_clients_that_remove_a_point_remove_it_once(self):
        self.make()
        daemon = self.start("--live", "block")
        for vertex in range(20, 40):
            with concurrent.futures.ThreadPoolExecutor(4) as pool:
                found = list(pool.map(lambda _: self.remove(daemon, [vertex])[0], range(4)))
            self.assertEqual(sorted(found), [200, 400, 400, 400])

    def test_questions_beside_writes_are_of_one_version(self):
        self.make()
        daemon = self.start("--live", "block")
        ended = threading.Event()

        def reader():
            version = 0
            while not ended.is_set():
                status, head, star = daemon.request("GET", f"{BLOCK}/vertices/66/star")
                now = int(head["Tessera-Version"])
                self.assertEqual((status, now >= version), (200, True))
                version = now
                # The point of each odd version is a neighbour; the next version has removed it.
                self.assertEqual(any(near["id"] >= 120 for near in star["neighbors"]), version % 2 == 1)
            return version

        with concurrent.futures.ThreadPoolExecutor(3) as pool:
            readers = [pool.submit(reader) for _ in range(3)]
            try:
                for _ in range(40):
                    added = self.add(daemon, [[6.25, 5.125]])[2]
                    self.remove(daemon, [added["firstID"]])
            finally:
                ended.set()
            for one in readers:
                one.result()

    def test_who_follows_hears_of_each_version_and_its_boxes(self):
        self.make()
        daemon = self.start("--live", "block")
        self.add(daemon, [[3.5, 4.5]])
        self.add(daemon, [[8.5, 8.5], [1.5, 1.5]])
        self.remove(daemon, [120])
        events = daemon.events(f"{BLOCK}/events", last=1)
        heard = [next(events) for _ in range(2)]
        self.assertEqual([(number, kind) for number, kind, _ in heard], [("2", "version"), ("3", "version")])
        self.assertEqual([(event["made"]["added"], event["made"]["removed"]) for _, _, event in heard], [(2, 0), (0, 1)])
        for x, y in ((8.5, 8.5), (1.5, 1.5)):
            self.assertTrue(any(b[0] <= x <= b[2] and b[1] <= y <= b[3] for b in (box["bounds"] for box in heard[0][2]["made"]["changed"])))
        self.assertTrue(next(daemon.events(f"{BLOCK}/events", last=77))[2]["made"]["everything"])

    def test_a_long_log_is_stored_while_the_daemon_runs(self):
        self.make()
        daemon = self.start("--live", "block", env={"TESSERAD_LIMITS_LIVE_LOG": "4K"})
        events = daemon.events(f"{BLOCK}/events")
        versions = [self.add(daemon, [[(k % 11) + 0.25, k / 50]])[2]["version"] for k in range(100)]
        self.assertEqual(versions, list(range(1, 101)))
        live = daemon.request("GET", BLOCK)[2]["live"]
        self.assertGreater(live["storedVersion"], 0)
        status, head, _ = daemon.request("GET", f"{BLOCK}/cells?bbox=0,0,1,1")
        self.assertEqual((status, int(head["Tessera-Version"]) > 0), (200, True))
        self.assertEqual(daemon.end(signal.SIGKILL), -signal.SIGKILL)
        again = self.start("--live", "block")
        self.assertEqual(again.request("GET", BLOCK)[2]["live"]["version"], 100)
        self.assertEqual(again.end(), 0)
        self.assertEqual(self.proved(), 220)

    def test_attributes_are_stored_and_those_of_an_heir_are_its_own(self):
        rows = np.zeros(30, dtype=[("x", "<f8"), ("y", "<f8"), ("z", "<f8"), ("class", "u1"), ("time", "<f8")])
        rng = np.random.default_rng(3)
        for name in "xyz":
            rows[name] = rng.random(30)
        rows["class"], rows["time"] = np.arange(30), np.arange(30) / 3
        self.make("block", rows, "--dim", "3", "--attributes", "class,time")
        daemon = self.start("--live", "block")
        place = [float(rows[name][4]) for name in "xyz"]
        self.assertEqual(self.add(daemon, [place])[0], 400)
        self.assertEqual(self.add(daemon, [place], attributes={"class": [300], "time": [1]})[0], 422)
        self.assertEqual(self.add(daemon, [place], attributes={"class": [77], "time": [0.1]})[2]["equal"], 1)
        self.assertEqual(self.add(daemon, [place], attributes={"class": [78], "time": [0.2]})[2]["equal"], 1)
        more = np.array([(0.5, 0.25, 0.125, 90, 7.5)], rows.dtype)
        found = daemon.request("POST", f"{BLOCK}/points", npy(more), NPY)
        self.assertEqual((found[0], found[2]["firstID"]), (200, 32), found)
        self.assertEqual(self.remove(daemon, [4])[0], 200)
        daemon = self.start_beside(daemon, "--live", "block")
        self.assertEqual(self.remove(daemon, [30])[0], 200)  # the next heir, whose attributes are stored now
        self.assertEqual(daemon.end(), 0)
        self.assertEqual(self.proved(), 31)
        import tessera  # here, because the other tests need no package
        block = tessera.open(self.folder / "data/results/block")
        classes, times = self.columns(block)
        self.assertEqual((classes[31], times[31], classes[32], times[32], classes[5]), (78, 0.2, 90, 7.5, 5))

    def test_which_of_equal_points_is_the_vertex_follows_the_rule_of_the_result(self):
        heights = np.array([[x, y, 10 + x] for x in range(8) for y in range(8)], float)
        for keep in ("last", "lowest", "highest"):
            self.make(keep, heights, "--dim", "2", "--keep", keep)
        daemon = self.start("--live", "last,lowest,highest")
        for keep, vertex in (("last", 66), ("lowest", 65), ("highest", 64)):
            for height in (20.0, -3.0, 12.5):
                added = self.add(daemon, [[3, 4, height]], keep)[2]
            self.assertEqual((added["firstID"], added["equal"], added["removed"]), (66, 1, 0))
            path = f"/v1/triangulations/{keep}"
            self.assertEqual(daemon.request("GET", f"{path}/vertices/{vertex}/star")[0], 200)
            self.assertEqual(daemon.request("GET", f"{path}/vertices/28/star")[0], 400)
            self.assertEqual(self.remove(daemon, [vertex], keep)[2]["removed"], 1)
            heir = {"last": 65, "lowest": 66, "highest": 28}[keep]
            self.assertEqual(daemon.request("GET", f"{path}/vertices/{heir}/star")[0], 200)
        self.assertEqual(daemon.end(), 0, daemon.messages())
        for keep in ("last", "lowest", "highest"):
            self.assertEqual(self.proved(keep), 64)

    def test_new_points_replace_those_that_are_equal_to_them(self):
        self.make()
        daemon = self.start("--live", "block")
        self.assertEqual(self.add(daemon, [[3, 4]])[2]["equal"], 1)
        found = daemon.request("POST", f"{BLOCK}/points?replace=true", {"points": [[3, 4], [2.5, 2.5]]})[2]
        self.assertEqual((found["firstID"], found["added"], found["equal"], found["removed"]), (121, 2, 0, 2))
        self.assertEqual(daemon.request("GET", f"{BLOCK}/vertices/121/star")[0], 200)
        import tessera
        block = tessera.connect(daemon.url, daemon.token).live("block")
        self.assertEqual(block.add([[3, 4]], replace=True)[1:], (range(123, 124), 0, 1))
        with concurrent.futures.ThreadPoolExecutor(6) as pool:
            answers = list(pool.map(lambda _: block.add([[3, 4]], replace=True), range(30)))
        self.assertEqual({(one.equal, one.removed) for one in answers}, {(0, 1)})
        self.assertEqual(daemon.request("GET", BLOCK)[2]["live"]["vertices"], 121)
        self.assertEqual(daemon.end(signal.SIGKILL), -signal.SIGKILL)
        again = self.start("--live", "block")
        self.assertEqual(again.request("GET", f"{BLOCK}/vertices/{max(one.ids[0] for one in answers)}/star")[0], 200)
        self.assertEqual(again.end(), 0)
        self.assertEqual(self.proved(), 121)

    def test_a_result_with_changes_that_are_not_stored_is_not_changed_otherwise(self):
        self.make()
        daemon = self.start("--live", "block")
        self.add(daemon, [[3.5, 4.5]])
        block = self.folder / "data/results/block"
        np.save(self.folder / "ids.npy", np.array([5]))
        self.assertIn("another process has this log", self.refused_update(block))
        self.assertEqual(daemon.end(signal.SIGKILL), -signal.SIGKILL)
        self.assertIn("has changes that are not stored", self.refused_update(block))
        daemon = self.start("--live", "block")
        self.assertEqual(daemon.end(), 0)
        self.tessera("update", block, "--remove-ids", "ids.npy")
        self.assertEqual(self.proved(), 120)

    def refused_update(self, result):
        done = subprocess.run([TESSERA, "update", result, "--remove-ids", "ids.npy"], cwd=self.folder, text=True, capture_output=True)
        self.assertNotEqual(done.returncode, 0)
        return done.stderr

    def columns(self, block):
        classes, times = {}, {}
        for tile in block:
            own = ~tile.foreign
            for vertex, kind, time in zip(tile.ids[own], tile.attributes["class"][own], tile.attributes["time"][own]):
                classes[int(vertex)], times[int(vertex)] = int(kind), float(time)
        return classes, times

    def test_the_python_client_adds_removes_and_follows(self):
        import tessera
        self.make()
        daemon = self.start("--live", "block")
        block = tessera.connect(daemon.url, daemon.token).live("block")
        added = block.add([[2.5, 3.5], [2, 3]])
        self.assertEqual((added.version, list(added.ids), added.equal), (1, [120, 121], 1))
        self.assertEqual(block.remove([120, 7]).removed, 2)
        self.assertEqual(block.status()["version"], 2)
        made = next(block.events(last=1))
        self.assertEqual((made.version, made.removed, made.everything, len(made.changed) > 0), (2, 2, False, True))
        with self.assertRaisesRegex(tessera.UsageError, "there is no point 7 to remove"):
            block.remove(7)
        with self.assertRaises(tessera.UsageError):
            block.remove([0.5])
        with self.assertRaisesRegex(tessera.UsageError, "there is no triangulation 'none'"):
            tessera.connect(daemon.url, daemon.token).live("none").add([[1, 2]])

    def test_only_the_owner_or_an_admin_may_change(self):
        data = self.folder / "data"
        data.mkdir(mode=0o700)
        (data / "tokens").touch(0o600)
        (data / "tokens").write_text("".join(f"{role}er {role} {role[0] * 64}\n" for role in ("admin", "submit", "read")))
        self.make()
        daemon = self.start("--live", "block")
        for token, status in (("s", 403), ("r", 403), ("x", 401), ("a", 200)):
            head = {"Authorization": f"Bearer {token * 64}"}
            self.assertEqual(daemon.request("POST", f"{BLOCK}/points", {"points": [[1.5, 2]]}, head)[0], status)
        self.assertEqual(daemon.request("GET", BLOCK, headers={"Authorization": f"Bearer {'r' * 64}"})[2]["live"]["version"], 1)

    def test_too_little_memory_refuses_points_and_the_daemon_goes_on(self):
        self.make()
        daemon = self.start("--live", "block", "--live-memory", "200K")
        refused = None
        rng = np.random.default_rng(5)
        for _ in range(40):
            status, _, body = daemon.request("POST", f"{BLOCK}/points", npy(rng.random((400, 2)) * 10), NPY)
            if status != 200:
                refused = status, body["detail"]
                break
        self.assertEqual((refused[0], "in memory" in refused[1]), (422, True), refused)
        before = daemon.request("GET", BLOCK)[2]["live"]
        self.assertEqual(self.remove(daemon, [5])[0], 200)
        self.assertEqual(daemon.request("GET", BLOCK)[2]["live"]["vertices"], before["vertices"] - 1)


class Killed(LiveTest):
    def test_nothing_that_was_answered_is_lost(self):
        """Each time the points that are there are those that were answered for, and perhaps the last that was asked for."""
        self.make()
        rng = np.random.default_rng(11)
        there, answered = 120, 0
        for kill in range(KILLS):
            daemon = self.start("--live", "block", env={"TESSERAD_LIMITS_LIVE_LOG": "4K"})
            live = daemon.request("GET", BLOCK)[2]["live"]
            self.assertIn((live["vertices"], live["version"]), ((there, answered), (there + 2, answered + 1)), daemon.messages())
            there, answered = live["vertices"], live["version"]
            for _ in range(int(rng.integers(1, 6))):
                points = (rng.random((2, 2)) * 12).tolist()
                status, _, body = self.add(daemon, points)
                self.assertEqual((status, body["version"]), (200, answered + 1))
                there, answered = there + 2, answered + 1
            if kill % 2:  # in the middle of a request
                sender = threading.Thread(target=self.add_or_not, args=(daemon, (rng.random((2, 2)) * 12).tolist()))
                sender.start()
                daemon.process.kill()
                sender.join()
            self.assertEqual(daemon.end(signal.SIGKILL), -signal.SIGKILL)
        daemon = self.start("--live", "block")
        live = daemon.request("GET", BLOCK)[2]["live"]
        self.assertEqual(daemon.end(), 0)
        self.assertEqual(self.proved(), live["vertices"])

    def add_or_not(self, daemon, points):
        try:
            self.add(daemon, points)
        except OSError:
            pass
        except Exception as ended:  # http.client's own
            self.assertIn("HTTP", type(ended).__mro__[1].__name__ + type(ended).__name__)


if __name__ == "__main__":
    unittest.main()
