"""Results in object stores and behind HTTP: the answers are those of the folder, few files are fetched for a question, and
there is a sentence for every way in which a store can be wrong."""
import hashlib
import json
import os
import pathlib
import signal
import subprocess
import threading
import unittest

from cli import CORRUPT, INTERRUPTED, IO, TESSERA, USAGE, CliTest
from object_server import Answer, ObjectServer
from s3_server import S3Server, refusal

KEYS = {"AKIDEXAMPLE": "wJalrXUtnFEMI/K7MDENG+bPxRfiCYEXAMPLEKEY"}


class FarTest(CliTest):
    def setUp(self):
        super().setUp()
        self.scratch = self.folder / "scratch"
        self.scratch.mkdir()
        self.near = self.folder / "near"

    def make(self, *more, n=4000, cloud="cloud.xyz", to=None, tiles=4):
        rows = self.xyz(cloud, n).read_text().splitlines()
        self.write(cloud, "\n".join(rows + rows[:50]) + "\n")  # with duplicates
        self.ok("triangulate", cloud, "-o", to or self.near, "--tiles", tiles, "--dim", 2, "--quiet", *more)

    def serve(self, objects=None, **more):
        self.server = self.enterContext(S3Server(objects or {}, KEYS, buckets={"maps"}, **more))
        return self.server

    def serve_near(self, **more):
        return self.serve(self.objects_of(self.near), **more)

    def objects_of(self, folder, name="maps/block"):
        return {f"{name}/{path.relative_to(folder)}": path.read_bytes() for path in folder.rglob("*") if path.is_file()}

    def environment(self):
        return {"HOME": str(self.folder), "TMPDIR": str(self.scratch), "AWS_ENDPOINT_URL": self.server.address,
                "AWS_ACCESS_KEY_ID": "AKIDEXAMPLE", "AWS_SECRET_ACCESS_KEY": KEYS["AKIDEXAMPLE"]}

    def far(self, *args):
        return self.ok(*args, env=self.environment())

    def far_refused(self, status, *args, says=()):
        return self.refused(status, *args, says=says, env=self.environment())

    def asked(self):
        return [request.name.removeprefix("maps/block/") for request in self.server.requests]

    def start(self, *args):
        clean = {key: value for key, value in os.environ.items() if not key.startswith("TESSERA")}
        process = subprocess.Popen([TESSERA, *map(str, args)], cwd=self.folder, env=clean | self.environment(), text=True,
                                   stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        self.addCleanup(process.stdout.close)
        self.addCleanup(process.stderr.close)
        self.addCleanup(process.kill)
        return process


class Reading(FarTest):
    def questions(self):
        vertex = json.loads(self.ok("query", self.near, "locate", "0.5,0.5", "--json"))["vertices"][0]["id"]
        self.write("where.csv", "x,y\n0.2,0.3\n0.7,0.8\n0.4,0.6\n")
        return (("query", "R", "locate", "0.31,0.62"), ("query", "R", "locate", "--points", "where.csv"),
                ("query", "R", "star", vertex), ("query", "R", "neighbours", 4010),  # the second is a duplicate
                ("query", "R", "interpolate", "where.csv", "--value", "z", "--method", "natural"))

    def test_answers_are_those_of_the_folder(self):
        for store in "cells", "points":
            self.make("--store", store, "--overwrite")
            server = self.serve_near()
            for question in self.questions():
                with self.subTest(store=store, question=question):
                    near, far = ([place if word == "R" else word for word in question] for place in (self.near, "s3://maps/block"))
                    self.assertEqual(self.far(*far), self.ok(*near))
            for made in (("query", "R", "cells", "--bbox", "0.4,0.4,0.5,0.5", "-o", "O.geojson"), ("export", "R", "-o", "O.ply"), ("export", "R", "-o", "O.gpkg"), ("dem", "R", "--res", 0.05, "-o", "O.tif"),
                         ("contours", "R", "--interval", 0.25, "-o", "O.geojson"), ("voronoi", "R", "-o", "O.geojson"),
                         ("alpha", "R", "--alpha", 0.1, "-o", "O.geojson")):
                with self.subTest(store=store, made=made):
                    files = []
                    for place, name in ((self.near, "near"), ("s3://maps/block/", "far")):
                        target = made[-1].replace("O", name)
                        self.far(*[place if word == "R" else word for word in made[:-1]], target, "--overwrite", "--quiet")
                        files.append((self.folder / target).read_bytes())
                    if not made[-1].endswith((".gpkg", ".tif")):  # these hold the time and the name
                        self.assertEqual(files[0], files[1])
                    self.assertGreater(len(files[1]), 300)
            self.assertEqual(list(self.scratch.iterdir()), [])

    def test_info_and_verify_are_those_of_the_folder(self):
        self.make()
        server = self.serve_near()
        near, far = (json.loads(self.far("info", place, "--json")) for place in (self.near, "s3://maps/block"))
        self.assertEqual(far.pop("result"), "s3://maps/block")
        near.pop("result")
        self.assertEqual(far, near)
        self.assertEqual(set(self.asked()), {"manifest.json"})
        near, far = (json.loads(self.far("verify", place, "--json")) for place in (self.near, "s3://maps/block"))
        self.assertEqual(far.pop("result"), "s3://maps/block")
        near.pop("result")
        self.assertEqual(far, near)

    def test_a_question_fetches_the_manifest_and_the_tiles_that_it_needs(self):
        self.make()
        server = self.serve_near()
        self.far("query", "s3://maps/block", "locate", "0.31,0.62")
        names = self.asked()
        self.assertEqual(names[0], "manifest.json")
        self.assertEqual(len(names), len(set(names)))
        self.assertEqual([name.startswith("tiles/") for name in names[1:]], [True])
        fetched = sum(len(server.objects["maps/block/" + name]) for name in names)
        self.assertLess(fetched, sum(map(len, server.objects.values())) / 2)

    def test_a_list_of_ids_is_read_by_ranges(self):
        self.make("--attributes", "all", n=40_000)
        server = self.serve_near()
        vertex = next(v["id"] for x in (0.95, 0.9, 0.85) for v in
                      json.loads(self.ok("query", self.near, "locate", f"{x},{x}", "--json"))["vertices"])
        self.far("query", "s3://maps/block", "star", vertex)
        whole = sum(size for name, size in ((name, len(body)) for name, body in server.objects.items()) if "/tiles/" in name)
        asked = sum(min(request.end, len(server.objects[request.name])) - request.begin for request in server.requests)
        self.assertLess(asked, whole * 0.7)

    def test_a_result_behind_http(self):
        self.make()
        files = {path.relative_to(self.near): path.read_bytes() for path in self.near.rglob("*") if path.is_file()}
        server = self.enterContext(ObjectServer({f"a b/block/{name}": body for name, body in files.items()}))
        for place in (server.url("a b/block/"), server.url("a%20b/block")):
            self.assertEqual(self.ok("query", place, "locate", "0.31,0.62"), self.ok("query", self.near, "locate", "0.31,0.62"))
            self.ok("dem", place, "--res", 0.1, "-o", "a.tif", "--overwrite")
        self.refused(USAGE, "query", server.url("block?key=secret"), "locate", "0.5,0.5", says="parameters")

    def test_a_result_that_is_replaced_while_it_is_read_is_an_error(self):
        self.make()
        self.make("--overwrite", n=4001, cloud="other.xyz", to=self.folder / "other")
        other = self.objects_of(self.folder / "other")
        server = self.serve_near()

        def replaced(request):
            if "/tiles/" in request.name:
                server.objects.update(other)
        server.refuse = replaced
        self.far_refused(CORRUPT, "query", "s3://maps/block", "locate", "0.31,0.62", says=("s3://maps/block/tiles/", "replaced"))
        # The same number of bytes, and counts that are the same: only the checksum tells.
        server = self.serve_near()
        for name in [name for name in server.objects if "/tiles/" in name]:
            body = server.objects[name]
            server.objects[name] = body[:-1] + bytes([body[-1] ^ 1])
        self.far_refused(CORRUPT, "query", "s3://maps/block", "locate", "0.31,0.62", says=("checksum", "replaced while it was read"))
        self.assertEqual(list(self.scratch.iterdir()), [])

    def test_an_object_that_changes_between_two_ranges_is_an_error(self):
        self.make(tiles=1, n=60_000)
        server = self.serve_near()
        (name,) = (name for name in server.objects if "/tiles/" in name)
        self.assertGreater(len(server.objects[name]), 2 << 20)

        def changed(request):
            if request.name == name and request.begin > 0:
                server.objects[name] = server.objects[name][:-1] + b"?"
        server.refuse = changed
        self.far_refused(3, "query", "s3://maps/block", "locate", "0.31,0.62", says="was changed on the server while it was read")

    def test_what_is_no_result_is_a_sentence(self):
        self.make()
        server = self.serve_near()
        self.far_refused(IO, "query", "s3://maps/nothing", "locate", "0.5,0.5", says=("s3://maps/nothing/manifest.json", "404"))
        server.objects["maps/block/manifest.json"] = b"<html>sign in</html>"
        self.far_refused(CORRUPT, "query", "s3://maps/block", "locate", "0.5,0.5", says=("s3://maps/block/manifest.json", "damaged"))
        self.far_refused(CORRUPT, "info", "s3://maps/block", says="damaged")
        server.fault = lambda request, answer: Answer(206, answer.headers | {"Content-Range": f"bytes 0-0/{1 << 40}"}, b"{")
        self.far_refused(3, "query", "s3://maps/block", "locate", "0.5,0.5", says="1099511627776")
        server.fault = lambda request, answer: refusal(403, "AccessDenied")
        self.far_refused(IO, "verify", "s3://maps/block", says=("403", "AccessDenied", "does not allow"))
        server.fault = lambda request, answer: refusal(503, "SlowDown")
        self.far_refused(IO, "query", "s3://maps/block", "locate", "0.5,0.5", says=("503", "5 tries"))
        server.fault = lambda request, answer: None
        self.far_refused(IO, "query", "s3://maps/block", "locate", "0.5,0.5", says="5 tries")

    def test_what_passes_is_asked_again(self):
        self.make()
        server = self.serve_near()
        failed = set()

        def once(request, answer):
            if request.name in failed:
                return answer
            failed.add(request.name)
            return refusal(503, "SlowDown") if len(failed) % 2 else None
        server.fault = once
        self.assertEqual(self.far("query", "s3://maps/block", "locate", "0.31,0.62"), self.ok("query", self.near, "locate", "0.31,0.62"))

    def test_it_cannot_be_changed_where_it_is(self):
        self.make()
        self.serve_near()
        more = self.xyz("more.xyz", 10)
        for command in (("update", "s3://maps/block", "--add", more), ("measure", "s3://maps/block", "--volume"),
                        ("materialise", "s3://maps/block"), ("materialise", "s3://maps/block", "-o", "cells"),
                        ("update", "s3://maps/block", "--add", more, "-o", "there")):
            with self.subTest(command=command):
                self.far_refused(USAGE, *command, says=("s3://maps/block", "cannot be changed", "into a folder"))
        self.far_refused(USAGE, "query", "s3://maps/block", "locate", "0.5,0.5", "--version", 3, says="only the newest version")
        self.assertEqual(self.far("query", "s3://maps/block", "locate", "0.5,0.5", "--version", 1), self.ok("query", self.near, "locate", "0.5,0.5"))
        self.far_refused(USAGE, "log", "s3://maps/block", says="only the newest version")

    def test_ctrl_c_ends_the_wait_for_a_server(self):
        self.make()
        server = self.serve_near()
        asked, never = threading.Event(), threading.Event()
        self.addCleanup(never.set)

        def silent(request):
            asked.set()
            never.wait(60)
        for name in "manifest.json", "tiles":
            asked.clear()
            server.refuse = lambda request: silent(request) if name in request.name else None
            process = self.start("query", "s3://maps/block", "locate", "0.31,0.62")
            self.assertTrue(asked.wait(60))
            process.send_signal(signal.SIGINT)
            _, errors = process.communicate(timeout=10)
            self.assertEqual((process.returncode, "interrupted" in errors), (INTERRUPTED, True), errors)


class Fetching(FarTest):
    def test_the_copy_is_the_result(self):
        self.make()
        server = self.serve_near()
        told = json.loads(self.far("fetch", "s3://maps/block/", "-o", "copy", "--json").splitlines()[-1])
        copy = self.objects_of(self.folder / "copy")
        self.assertEqual(copy, {name: body for name, body in server.objects.items() if not name.endswith("report.html")})
        self.assertEqual((told["event"], told["files"], told["bytes"]), ("fetched", len(copy), sum(map(len, copy.values()))))
        self.ok("verify", "copy")
        self.far_refused(USAGE, "fetch", "s3://maps/block", "-o", "copy", says="not empty")

    def test_what_is_damaged_leaves_nothing(self):
        self.make()
        server = self.serve_near()
        name = max(name for name in server.objects if "/tiles/" in name)
        body = server.objects[name]
        server.objects[name] = body[:-1] + bytes([body[-1] ^ 1])
        self.far_refused(CORRUPT, "fetch", "s3://maps/block", "-o", "copy", says=(f"s3://{name}", "checksum"))
        server.objects[name] = body + b"x"
        self.far_refused(CORRUPT, "fetch", "s3://maps/block", "-o", "copy", says=(f"s3://{name}", "bytes"))
        self.assertFalse((self.folder / "copy").exists())


class Writing(FarTest):
    def triangulate(self, *more, to="s3://maps/block", tiles=4):
        return ("triangulate", "cloud.xyz", "-o", to, "--tiles", tiles, "--dim", 2, *more)

    def written(self):
        return [(request.method, request.name.removeprefix("maps/block/")) for request in self.server.requests if request.method == "PUT"]

    def assert_whole(self):
        """The store has the files of the folder, but for the report and what the manifest says of the run."""
        near = self.objects_of(self.near)
        varying = {"maps/block/manifest.json", "maps/block/report.html"}
        self.assertEqual(set(self.server.objects), set(near))
        self.assertEqual({name: body for name, body in self.server.objects.items() if name not in varying},
                         {name: body for name, body in near.items() if name not in varying})
        self.assertEqual(self.server.uploads, {})
        self.assertEqual(list(self.scratch.iterdir()), [])

    def test_a_result_is_written_with_the_manifest_last(self):
        self.make()
        server = self.serve()
        said = self.far(*self.triangulate())
        self.assertIn("s3://maps/block", said)
        self.assert_whole()
        self.assertEqual(self.written()[-1][1], "manifest.json")
        self.assertEqual(len(self.written()), len(server.objects))
        self.assertNotIn(str(self.scratch), server.objects["maps/block/manifest.json"].decode())
        self.assertNotIn(str(self.scratch), server.objects["maps/block/report.html"].decode())
        near, far = (json.loads(self.far("verify", place, "--json")) for place in (self.near, "s3://maps/block"))
        self.assertEqual({**far, "result": ""}, {**near, "result": ""})

    def test_a_result_that_stands_is_replaced_only_when_told_so(self):
        self.make()
        server = self.serve()
        self.far(*self.triangulate("--store", "points", "--quiet", tiles=9))
        before = dict(server.objects)
        self.far_refused(USAGE, *self.triangulate(), says=("s3://maps/block", "holds a finished result", "--overwrite"))
        self.assertEqual(server.objects, before)
        server.objects["maps/block/mine.txt"] = b"mine"
        self.far(*self.triangulate("--overwrite", "--quiet"))
        self.assertEqual(server.objects.pop("maps/block/mine.txt"), b"mine")
        self.assert_whole()
        server.objects["maps/block/manifest.json"] = b"of another program"
        self.far_refused(CORRUPT, *self.triangulate("--overwrite"), says="manifest.json")
        self.assertEqual(server.objects["maps/block/manifest.json"], b"of another program")

    def test_while_it_is_replaced_there_is_no_result(self):
        self.make()
        server = self.serve_near()
        there = set()
        server.refuse = lambda request: there.add("maps/block/manifest.json" in server.objects) if request.method == "PUT" else None
        self.far(*self.triangulate("--overwrite", "--quiet"))
        self.assertEqual(there, {False})

    def test_large_files_are_sent_in_parts(self):
        self.make(tiles=1, n=200_000)
        server = self.serve()
        self.far("upload", self.near, "-o", "s3://maps/block")
        (tile,) = (name for name in server.objects if "/tiles/" in name)
        self.assertGreater(len(server.objects[tile]), 16 << 20)
        parts = [request for request in server.requests if "partNumber" in request.query]
        self.assertEqual(len(parts), -(-len(server.objects[tile]) // (8 << 20)))
        self.assert_whole()
        self.assertLessEqual(server.most_at_once, 16)
        # The answer to what puts the parts together is lost, and one part is asked for again.
        server.objects.clear()
        lost = set()

        def lose(request, answer):
            kind = (request.method, request.query.partition("=")[0])
            if request.query and request.method != "DELETE" and request.name == tile and kind not in lost:
                lost.add(kind)
                return None
            return answer
        server.fault = lose
        self.far("upload", self.near, "-o", "s3://maps/block")
        self.assertEqual(lost, {("POST", "uploads"), ("PUT", "partNumber"), ("POST", "uploadId")})
        self.assertEqual(server.objects, self.objects_of(self.near))

    def test_a_store_that_changes_its_mind_after_it_has_said_200(self):
        self.make(tiles=1, n=200_000)
        server = self.serve()
        late = Answer(200, {}, b" <?xml version='1.0'?><Error><Code>InternalError</Code></Error>")
        server.fault = lambda request, answer: late if request.method == "POST" and b"<Complete" in request.sent else answer
        self.far_refused(IO, "upload", self.near, "-o", "s3://maps/block", says=("s3://maps/block/tiles/", "InternalError"))
        self.assertNotIn("maps/block/manifest.json", server.objects)

    def test_what_passes_is_sent_again(self):
        self.make()
        for kind in (lambda: refusal(500, "InternalError"), lambda: refusal(503, "SlowDown", {"Retry-After": "1"}), lambda: None):
            server = self.serve()
            failed = set()

            def once(request, answer):
                if request.method == "GET" or "uploads=" in request.query or request.name in failed:
                    return answer
                failed.add(request.name)
                return kind()
            server.fault = once
            self.far(*self.triangulate("--quiet"))
            self.assert_whole()
            self.assertIn("maps/block/manifest.json", failed)

    def test_what_does_not_pass_is_a_sentence_and_leaves_no_result(self):
        self.make()
        for answer, says in ((refusal(503, "SlowDown"), ("503", "5 tries")), (refusal(403, "QuotaExceeded"), ("403", "full")),
                             (refusal(507, "Full"), ("507", "full")), (refusal(403, "AccessDenied"), ("403", "to be written")),
                             (Answer(200, {}, b"", 10), ("cut off", "5 tries"))):
            server = self.serve()
            server.refuse = lambda request: answer if request.method == "PUT" and "/tiles/" in request.name else None
            with self.subTest(says=says):
                done = self.far_refused(IO, *self.triangulate("--quiet"), says=("s3://maps/block/tiles/", "the result is in ", *says))
                self.assertNotIn("maps/block/manifest.json", server.objects)
                kept = pathlib.Path(done.stderr.partition("the result is in ")[2].partition(", and")[0])
                self.assertEqual(kept.parent.parent, self.scratch)
                server.refuse = lambda request: None
                self.far("upload", kept, "-o", "s3://maps/block", "--quiet")
                self.far("verify", "s3://maps/block")
                self.ok("verify", kept)

    def test_a_store_that_cannot_be_written_is_found_before_the_work(self):
        self.make()
        server = self.serve()
        server.refuse = lambda request: refusal(403, "AccessDenied") if request.method != "GET" else None
        self.far_refused(IO, *self.triangulate(), says=("s3://maps/block", "403", "does not allow this object to be written"))
        server.refuse = lambda request: None
        self.far_refused(IO, *self.triangulate(to="s3://nowhere/block"), says=("404", "NoSuchBucket", "no such bucket"))
        self.assertEqual(self.written(), [])
        self.assertEqual(list(self.scratch.iterdir()), [])
        for place, says in (("https://127.0.0.1/block", "folders and to s3://"), ("s3://maps", "no folder in the bucket"),
                            ("s3://maps/", "no folder in the bucket"), ("s3://UPPER/x", "no bucket"), ("s3://maps/a?b", "folders and to s3://")):
            self.far_refused(USAGE, *self.triangulate(to=place), says=says)
        self.far_refused(USAGE, *self.triangulate("--resume"), says=("--resume", "tessera upload"))
        self.far_refused(USAGE, *self.triangulate("--server", "http://127.0.0.1:1"), says=("s3://maps/block", "daemon", "tessera fetch"))
        self.assertEqual(list(self.scratch.iterdir()), [])

    def test_another_program_that_is_faster_wins(self):
        self.make()
        server = self.serve()

        def faster(request):
            if request.method == "PUT" and request.name.endswith("manifest.json"):
                server.objects[request.name] = b"of another program"
        server.refuse = faster
        self.far_refused(USAGE, *self.triangulate("--quiet"), says=("manifest.json", "another program", "--overwrite"))
        self.assertEqual(server.objects["maps/block/manifest.json"], b"of another program")

    def test_a_store_without_conditions_is_written_too(self):
        self.make()
        self.serve(conditions=False)
        self.far(*self.triangulate("--quiet"))
        self.assert_whole()

    def stop_in_mid_upload(self, number):
        """Ends the command by a signal while a part of a tile is under way."""
        self.make(tiles=1, n=200_000)
        server = self.serve()
        arrived, go_on = threading.Event(), threading.Event()
        self.addCleanup(go_on.set)

        def hold(request):
            if "partNumber=2" in request.query:
                arrived.set()
                go_on.wait(60)
        server.refuse = hold
        process = self.start("upload", self.near, "-o", "s3://maps/block")
        self.assertTrue(arrived.wait(60))
        process.send_signal(number)
        said, errors = process.communicate(timeout=30)
        go_on.set()
        self.assertNotIn("maps/block/manifest.json", server.objects)
        self.assertFalse(any("/tiles/" in name for name in server.objects))
        return process.returncode, errors

    def test_after_kill_there_is_no_result_and_the_next_try_makes_one(self):
        status, _ = self.stop_in_mid_upload(signal.SIGKILL)
        self.assertEqual(status, -signal.SIGKILL)
        self.far_refused(IO, "query", "s3://maps/block", "locate", "0.5,0.5", says="404")
        self.server.refuse = lambda request: None
        self.far("upload", self.near, "-o", "s3://maps/block")
        self.assertEqual(self.server.objects, self.objects_of(self.near))
        self.far("verify", "s3://maps/block")

    def test_after_ctrl_c_the_parts_are_given_up(self):
        status, errors = self.stop_in_mid_upload(signal.SIGINT)
        self.assertEqual(status, INTERRUPTED, errors)
        self.assertIn("s3://maps/block holds no whole result", errors)
        self.assertEqual(self.server.uploads, {})

    def test_upload_sends_the_newest_version_of_a_folder(self):
        self.make()
        self.ok("measure", self.near, "--volume")
        self.serve()
        told = json.loads(self.far("upload", self.near, "-o", "s3://maps/block/", "--json").splitlines()[-1])
        self.assertEqual((told["event"], told["output"], told["files"]), ("uploaded", "s3://maps/block", len(self.server.objects)))
        self.assertEqual(len(json.loads(self.far("info", "s3://maps/block", "--json"))["columns"]), 2)
        near, far = (json.loads(self.far("verify", place, "--json")) for place in (self.near, "s3://maps/block"))
        self.assertEqual({**far, "result": ""}, {**near, "result": ""})
        self.far_refused(USAGE, "upload", self.near, "-o", "s3://maps/block", says="--overwrite")
        self.far("upload", self.near, "-o", "s3://maps/block", "--overwrite")
        self.far_refused(USAGE, "upload", self.near, self.near, "-o", "s3://maps/more", says="one result folder")
        self.far_refused(IO, "upload", self.scratch, "-o", "s3://maps/more", says="manifest")
        tile = next((self.near / "tiles").glob("*-2.*"))
        tile.write_bytes(tile.read_bytes()[:-1] + b"?")
        self.far_refused(CORRUPT, "upload", self.near, "-o", "s3://maps/more", says=(tile.name, "checksum"))


if __name__ == "__main__":
    unittest.main()
