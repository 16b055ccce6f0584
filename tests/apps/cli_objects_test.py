"""Points from objects behind HTTP: the same results as of files, few bytes of what is not needed, and a sentence for
every way in which a server can be wrong."""
import gzip
import hashlib
import json
import pathlib
import signal
import struct
import subprocess
import threading
import unittest

import numpy as np

from cli import BAD_INPUT, INTERRUPTED, IO, TESSERA, USAGE, CliTest
from object_server import Answer, ObjectServer

CLOUDS = pathlib.Path(__file__).resolve().parent.parent / "data" / "clouds"
COPC = CLOUDS / "lone_star_part.copc.laz"


class Objects(CliTest):
    def serve(self, *files, **more):
        server = ObjectServer({pathlib.Path(file).name: pathlib.Path(file).read_bytes() for file in files}, **more)
        self.enterContext(server)
        return server

    def tiles(self, *inputs, more=()):
        self.ok("triangulate", *inputs, "-o", self.out, "--overwrite", "--quiet", *more)
        return {path.name: hashlib.sha256(path.read_bytes()).hexdigest() for path in (self.out / "tiles").iterdir()}

    def info(self, *inputs):
        told = json.loads(self.ok("info", *inputs, "--json"))
        for file in told["files"]:
            file["path"] = file["path"].rsplit("/", 1)[-1]
            file.pop("modified", None)
            file.pop("modified_ns", None)
        # Of objects no sample is taken, and what is free differs from moment to moment.
        for key in ("estimate", "memory_budget_bytes", "max_points_per_tile", "tiles", "sampled", "sampled_bounds"):
            told.pop(key)
        return told

    def test_every_format_is_read_as_from_a_file(self):
        clouds = ["autzen_trim.laz", "cities_begin.csv", "csf_sample_begin.ply", "ellipsoid.copc.laz", "ign_77050_627755_begin.las",
                  "pdal_mesh.ply", "velodyne_400_begin.xyz"]
        made = [self.write("a.xyz.gz", gzip.compress(b"".join(b"%d %d %d\n" % (i % 17, i % 23, i % 29) for i in range(5000)))),
                self.write("b.obj", "".join(f"v {i % 7} {i % 11} {i % 13}\n" for i in range(3000)))]
        files = [CLOUDS / name for name in clouds] + made
        server = self.serve(*files)
        for file in files:
            with self.subTest(file=file.name):
                self.assertEqual(self.info(server.url(file.name)), self.info(file))
                if file.name != "pdal_mesh.ply":
                    self.assertEqual(self.tiles(server.url(file.name), more=("--dim", "2")), self.tiles(file, more=("--dim", "2")))

    def test_info_reads_some_kilobytes(self):
        server = self.serve(COPC)
        self.ok("info", server.url(COPC.name))
        self.assertLess(server.bytes_asked(), 100_000)
        self.assertGreater(len(server.objects[COPC.name]), 1_000_000)

    def test_a_region_is_that_of_the_file_and_reads_what_it_needs(self):
        server = self.serve(COPC)
        box = json.loads(self.ok("info", COPC, "--json"))["files"][0]["bounds"]
        (x0, y0), (x1, y1) = box["min"][:2], box["max"][:2]
        x, y = (x0 + x1) / 2, (y0 + y1) / 2
        bbox = f"{x},{y},{x + 1},{y + 1}"
        told = []
        for input, out in ((COPC, "near"), (server.url(COPC.name), "far")):
            told.append(json.loads(self.ok("region", input, "--dim", "2", "--bbox", bbox, "-o", self.folder / out, "--json")))
        near, far = ({path.name: path.read_bytes() for path in (self.folder / out / "tiles").iterdir()} for out in ("near", "far"))
        self.assertEqual(near, far)
        self.assertEqual(told[0]["read_bytes"], told[1]["read_bytes"])
        # Of the nodes only the layers that hold x, y, z: less than the nodes have, with all that leads to them.
        self.assertLess(server.bytes_asked(), told[1]["read_bytes"])
        self.assertLessEqual(server.most_at_once, 16)
        self.assertLessEqual(len({request.peer for request in server.requests}), 16)  # connections are kept

    def test_every_request_after_the_first_is_for_the_same_version(self):
        server = self.serve(COPC)
        self.ok("info", server.url(COPC.name), "--stats")
        etags = [request.headers.get("If-Match") for request in server.requests]
        self.assertIsNone(etags[0])
        self.assertEqual(etags.count(None), 2)  # once for what the header says, once for all points
        self.assertEqual(len(set(etags)), 2)

    def test_lists_may_name_objects(self):
        files = sorted(CLOUDS.glob("ign_770*_6277*.laz"))
        server = self.serve(*files)
        listed = self.write("list.txt", "".join(server.url(file.name) + "\n" for file in files))
        self.assertEqual(self.tiles("--input-list", listed, more=("--dim", "2")), self.tiles(*files, more=("--dim", "2")))

    def test_a_list_may_be_an_object(self):
        files = sorted(CLOUDS.glob("ign_770*_6277*.laz"))
        server = self.serve(*files)
        server.objects = {"block/" + name: body for name, body in server.objects.items()}
        server.objects["block/list.txt"] = "".join(f"{file.name}\n" for file in files[:2]).encode() + server.url("block/" + files[2].name).encode()
        self.assertEqual(self.points("--input-list", server.url("block/list.txt")), self.points(*files[:3]))
        server.objects["block/list.txt"] = f"{files[0].name}\n{files[0]}\n".encode()
        self.refused(BAD_INPUT, "info", "--input-list", server.url("block/list.txt"), says=("line 2", "file of this machine"))

    def points(self, *inputs):
        return json.loads(self.ok("info", *inputs, "--json"))["points"]

    def test_a_stac_document_stands_for_its_point_files(self):
        files = sorted(CLOUDS.glob("ign_770*_6277*.laz"))[:3]
        server = self.serve(*files)

        def item(file, **more):
            return {"type": "Feature", "stac_version": "1.0.0", "links": [{"rel": "self", "href": "self.json"}, {"rel": "collection", "href": "../all.json"}],
                    "assets": {"data": {"href": file, "roles": ["data"]}, "thumbnail": {"href": "a.png", "type": "image/png"}} | more}

        def put(name, document):
            server.objects[name] = (document if isinstance(document, str) else json.dumps(document)).encode()

        names = [file.name for file in files]
        server.objects["plain"] = files[2].read_bytes()
        put("items/0.json", item("../" + names[0]))
        put("items/1.json", item(server.url(names[1])))
        put("items/2.json", item("x.txt", points={"href": "/plain", "type": "application/vnd.laszip+copc"}) | {"assets": {"p": {"href": "/plain", "type": "application/vnd.laszip+copc"}}})
        put("all.json", {"type": "Collection", "links": [{"rel": "item", "href": f"items/{i}.json"} for i in range(3)] + [{"rel": "root", "href": "all.json"}]})
        put("found.json", {"type": "FeatureCollection", "features": [item(names[0]), item(names[1])], "links": [{"rel": "next", "href": "more.json?token=2"}]})
        put("more.json", {"type": "FeatureCollection", "features": [item(names[1]), item(names[2])], "links": [{"rel": "next", "href": "found.json"}]})
        put("top.json", {"type": "Catalog", "links": [{"rel": "child", "href": "all.json"}, {"rel": "child", "href": "top.json"}]})
        self.assertEqual(self.points(server.url("items/0.json")), self.points(files[0]))
        for name, *more in (("all.json",), ("found.json",), ("top.json", "--recursive")):
            with self.subTest(name=name):
                self.assertEqual(self.points(server.url(name), *more), self.points(*files))
        self.refused(BAD_INPUT, "info", server.url("top.json"), says=("top.json", "no point files", "--recursive"))
        for wrong in ("", "[1]", "{", '{"type": "Point"}', '{"type": 5, "assets": []}', '{"type": "Feature", "assets": [7], "links": {"a": 1}}', '{"a":' * 100_000,
                      '{"type": "Feature", "assets": {"a": {"href": "file:///etc/a.las"}, "b": {"href": 7}}}'):
            put("wrong.json", wrong)
            with self.subTest(wrong=wrong[:40]):
                self.assertIn(self.run_tessera("info", server.url("wrong.json")).returncode, (BAD_INPUT, USAGE))

    def test_what_passes_is_tried_again(self):
        server = self.serve(COPC)
        expected = self.info(COPC)
        for name, wrong in {"500": lambda answer: Answer(500, {}, b""), "429": lambda answer: Answer(429, {"Retry-After": "0"}, b""),
                            "hangs up": lambda answer: None,
                            "cut off": lambda answer: Answer(answer.status, answer.headers, answer.body[:-100], len(answer.body))}.items():
            tried = set()

            def once(request, answer):
                first = request.begin not in tried
                tried.add(request.begin)
                return wrong(answer) if first else answer

            server.fault = once
            with self.subTest(fault=name):
                self.assertEqual(self.info(server.url(COPC.name)), expected)
                self.assertGreater(len(tried), 1)

    def refusal(self, status, says, fault, names="cloud.copc.laz", parallel=False):
        server = self.serve(COPC)
        server.objects = {"cloud.copc.laz": COPC.read_bytes(), "empty.las": b""}
        server.fault = fault
        self.refused(status, "triangulate", server.url(names) + "?signature=SECRET", "-o", self.out, "--quiet", says=(server.url(names) + ":", *says))
        self.assertEqual(self.files(), [])
        return server

    def test_what_does_not_pass_is_a_sentence(self):
        def always(status, headers=None):
            return lambda request, answer: Answer(status, headers or {}, b"")

        def headers(**changed):
            return lambda request, answer: Answer(answer.status, {key: value for key, value in (answer.headers | changed).items() if value}, answer.body)

        whole = lambda request, answer: Answer(200, {}, COPC.read_bytes())
        for status, says, fault in (
                (IO, ("403", "does not allow"), always(403)), (IO, ("404", "no such object"), always(404)),
                (IO, ("401",), always(401)), (BAD_INPUT, ("only the whole object",), whole),
                (BAD_INPUT, ("does not tell how long",), headers(**{"Content-Range": "bytes 0-16383/*"})),
                (BAD_INPUT, ("does not say which bytes",), headers(**{"Content-Range": None})),
                (BAD_INPUT, ("'bytes 5-16388/9999999'",), headers(**{"Content-Range": "bytes 5-16388/9999999"})),
                (BAD_INPUT, ("9223372036854775808",), headers(**{"Content-Range": "bytes 0-16383/9223372036854775808"})),
                (BAD_INPUT, ("compresses",), headers(**{"Content-Encoding": "gzip"})),
                (IO, ("longer than what was asked for",), lambda request, answer: Answer(206, answer.headers, answer.body * 2)),
                (IO, ("without end",), always(302, {"Location": "/cloud.copc.laz"})),
                (IO, ("does not say to which",), always(302)),
                (IO, ("refused", "file://"), always(302, {"Location": "file:///etc/passwd"}))):
            with self.subTest(says=says):
                self.refusal(status, says, fault)
        with self.subTest("empty"):
            self.refusal(BAD_INPUT, ("is empty",), lambda request, answer: answer, "empty.las")

    def test_what_goes_on_failing_is_a_sentence_after_five_tries(self):
        for says, fault in ((("503", "5 tries"), lambda request, answer: Answer(503, {}, b"")),
                            (("no answer", "5 tries"), lambda request, answer: None)):
            with self.subTest(says=says):
                server = self.refusal(IO, says, fault)
                self.assertEqual(len(server.requests), 5)

    def test_an_object_that_changes_is_an_error(self):
        changed = bytearray(COPC.read_bytes())
        changed[-1] ^= 1
        for deaf in (False, True):  # a server that knows If-Match, and one that does not
            def fault(request, answer):
                if request.number == 0:
                    return answer
                server = servers[-1]
                server.objects["cloud.copc.laz"] = bytes(changed)
                return server.honest(request.name, request.begin, request.end, None if deaf else request.headers.get("If-Match"))

            servers = []
            server = self.serve(COPC)
            servers.append(server)
            server.objects = {"cloud.copc.laz": COPC.read_bytes()}
            server.fault = fault
            with self.subTest(deaf=deaf):
                self.refused(BAD_INPUT, "triangulate", server.url("cloud.copc.laz"), "-o", self.out, "--quiet", says="was changed on the server")

    def test_a_lie_about_the_length_is_found(self):
        def longer(request, answer):
            size = len(COPC.read_bytes())
            answer.headers["Content-Range"] = answer.headers.get("Content-Range", "").replace(f"/{size}", f"/{10**15}")
            return answer

        server = self.serve(COPC)
        server.fault = longer
        done = self.run_tessera("info", server.url(COPC.name), "--stats")
        self.assertIn(done.returncode, (0, BAD_INPUT, IO), done.stderr)

    def test_a_sample_of_a_large_file_is_read_with_many_requests_at_once(self):
        count = 200_000
        xyz = np.random.default_rng(1).integers(0, 10**6, (count, 3), dtype="<i4")
        header = bytearray(227)
        struct.pack_into("<4s", header, 0, b"LASF")
        struct.pack_into("<BB", header, 24, 1, 2)
        struct.pack_into("<HIIBHI5I", header, 94, 227, 227, 0, 0, 20, count, count, 0, 0, 0, 0)
        struct.pack_into("<12d", header, 131, .01, .01, .01, 0, 0, 0, 1e4, 0, 1e4, 0, 1e4, 0)
        records = np.zeros(count, [("xyz", "<i4", 3), ("rest", "V8")])
        records["xyz"] = xyz
        file = self.write("large.las", bytes(header) + records.tobytes())
        server = self.serve(file, delay_s=0.01)
        options = ("--dim", "2", "--tiles", "30")
        self.assertEqual(self.tiles(server.url("large.las"), more=options), self.tiles(file, more=options))
        # Reading in order asks for pieces of 1 MiB, of which the file has four.
        self.assertGreaterEqual(server.most_at_once, 10)
        self.assertLessEqual(server.most_at_once, 16)

    def test_commands_that_triangulate_first_take_objects(self):
        file = CLOUDS / "ign_77050_627755.laz"
        server = self.serve(file)
        for command, *options in (("dem", "--res", "2", "-o", "a.tif"), ("export", "--dim", "2", "-o", "a.ply")):
            made = []
            for source in (file, server.url(file.name)):
                self.ok(command, source, *options, "--quiet", "--overwrite")
                made.append((self.folder / options[-1]).read_bytes())
            with self.subTest(command=command):
                self.assertEqual(made[0], made[1])

    def test_ctrl_c_ends_a_command_that_waits_for_a_server(self):
        for first in (0, 1):  # while the object is opened, and while its points are read
            server, asked, over = self.serve(COPC), threading.Event(), threading.Event()
            self.addCleanup(over.set)

            def silent(request, answer):
                if request.number < first:
                    return answer
                asked.set()
                over.wait()

            server.fault = silent
            with self.subTest(first=first):
                process = subprocess.Popen([TESSERA, "triangulate", server.url(COPC.name), "-o", self.out], stderr=subprocess.PIPE, stdout=subprocess.DEVNULL)
                self.assertTrue(asked.wait(60))
                process.send_signal(signal.SIGINT)
                said = process.communicate(timeout=60)[1].decode()
                over.set()
                self.assertEqual(process.returncode, INTERRUPTED, said)
                self.assertFalse((self.out / "manifest.json").exists())

    def test_a_redirect_is_followed_for_the_object(self):
        server = self.serve(COPC)
        server.fault = lambda request, answer: Answer(307, {"Location": f"/{COPC.name}"}, b"") if request.name == "moved" else answer
        server.objects["moved"] = COPC.read_bytes()
        self.assertEqual(self.info(server.url("moved"))["points"], self.info(COPC)["points"])
        self.assertEqual([request.name for request in server.requests].count("moved"), 1)

    def test_https_trusts_certificates_of_the_system_or_of_a_file(self):
        certificate = self.folder / "both.pem"
        subprocess.run(["openssl", "req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:prime256v1", "-nodes", "-days", "1", "-subj", "/CN=test",
                        "-addext", "subjectAltName=IP:127.0.0.1", "-keyout", self.folder / "key.pem", "-out", self.folder / "cert.pem"], check=True, capture_output=True)
        certificate.write_bytes((self.folder / "key.pem").read_bytes() + (self.folder / "cert.pem").read_bytes())
        server, plain = self.serve(COPC, certificate=certificate), self.serve(COPC)
        trusting = {"CURL_CA_BUNDLE": str(self.folder / "cert.pem")}
        self.ok("info", server.url(COPC.name), env=trusting)
        done = self.refused(IO, "info", server.url(COPC.name), says=(server.url(COPC.name), "certificate"))
        self.assertNotIn("tries", done.stderr)
        plain.fault = lambda request, answer: Answer(302, {"Location": server.url(COPC.name)}, b"")
        self.ok("info", plain.url(COPC.name), env=trusting)
        plain.fault, server.fault = lambda request, answer: answer, lambda request, answer: Answer(302, {"Location": plain.url(COPC.name)}, b"")
        self.refused(IO, "info", server.url(COPC.name), env=trusting, says=("from https:// to http://", "not encrypted"))

    def test_names_that_cannot_be_read(self):
        for name, says in (("ftp://host/a.las", "not by ftp://"), ("https://me:secret@host/a.las", "user name"), ("https://", "no address"),
                           ("http://127.0.0.1:99999/a.las", "no address")):
            done = self.refused(USAGE, "info", name, says=says)
            self.assertNotIn("secret", done.stderr)

    def test_secrets_in_addresses_stay_out_of_results(self):
        server = self.serve(COPC)
        self.tiles(server.url(COPC.name) + "?signature=SECRET", more=("--dim", "2"))
        for path in self.out.rglob("*"):
            if path.is_file():
                self.assertNotIn(b"SECRET", path.read_bytes(), path)


if __name__ == "__main__":
    unittest.main()
