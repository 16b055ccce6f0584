"""Inputs by their addresses: none unless the operator lists prefixes, and then nothing outside of them, whatever a name, a redirect, a list, a catalog or
a listing leads to."""
import json
import pathlib
import shutil
import sys
import unittest

import h5py
import numpy as np
from daemon import IGN, DaemonTest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "apps"))
from object_server import Answer, ObjectServer  # noqa: E402
from s3_server import S3Server  # noqa: E402

FILES = sorted(IGN.glob("*.las"))[:2]
KEYS = {"AKIDEXAMPLE": "wJalrXUtnFEMI/K7MDENG+bPxRfiCYEXAMPLEKEY"}
ME = {"AWS_ACCESS_KEY_ID": "AKIDEXAMPLE", "AWS_SECRET_ACCESS_KEY": KEYS["AKIDEXAMPLE"], "AWS_EC2_METADATA_DISABLED": "true"}
EPT = pathlib.Path(__file__).resolve().parents[1] / "data" / "ept" / "colours"


class Hdf5(DaemonTest):
    def test_hdf5_is_read_only_where_the_operator_says_so(self):
        inputs = self.folder / "inputs"
        inputs.mkdir()
        with h5py.File(inputs / "snap.hdf5", "w") as file:
            file.create_group("Header").attrs["NumPart_ThisFile"] = np.array([0, 20], "u4")
            file["PartType1/Coordinates"] = np.random.default_rng(1).random((20, 3))
        for options, status in (((), 422), (("--hdf5",), 201)):
            daemon = self.start(*options, inputs=inputs)
            code, _, told = daemon.request("POST", "/v1/processes/triangulate/execution", {"inputs": {"inputs": ["snap.hdf5"], "output": "out"}})
            self.assertEqual(code, status, told)
            if status == 201:
                self.assertEqual(daemon.wait(told["jobID"])["status"], "successful")
            else:
                self.assertIn("HDF5 is not read here", told["detail"])
            daemon.end()


class RemoteInputs(DaemonTest):
    def setUp(self):
        super().setUp()
        objects = {f"{folder}/{file.name}": file.read_bytes() for folder in ("open", "opened", "closed") for file in FILES}
        objects |= {f"open/ept/{path.relative_to(EPT).as_posix()}": path.read_bytes() for path in EPT.rglob("*") if path.is_file()}
        self.server = self.enterContext(ObjectServer(objects))
        self.inner = self.enterContext(ObjectServer(objects))  # what the daemon must never ask

    def begin(self, *prefixes, env=None):
        more = [word for prefix in prefixes for word in ("--remote-prefix", prefix)]
        return self.start(*more, env=env)

    def url(self, name):
        return self.server.url(name)

    def ask(self, daemon, process, *inputs, **more):
        return daemon.request("POST", f"/v1/processes/{process}/execution", {"inputs": {"inputs": list(inputs), **more}})

    def outcome(self, daemon, process, *inputs, **more):
        status, _, job = self.ask(daemon, process, *inputs, **more)
        self.assertEqual(status, 201, job)
        job = daemon.wait(job["jobID"])
        self.assertEqual(job["status"], "successful", job)
        if process == "triangulate":
            return daemon.request("GET", "/v1/triangulations/" + more["output"])[2]
        return daemon.request("GET", f"/v1/jobs/{job['jobID']}/results")[2]["outcome"]["value"]

    def refused(self, daemon, *inputs, says, process="triangulate", **more):
        """At once, or when the job runs. Nothing but the listed server was asked."""
        status, _, told = self.ask(daemon, process, *inputs, **({"output": "bad"} if process == "triangulate" else {}) | more)
        if status == 201:
            job = daemon.wait(told["jobID"])
            self.assertEqual(job["status"], "failed", job)
            said = json.dumps(job)
        else:
            self.assertGreaterEqual(status, 400, told)
            said = told["detail"]
        for part in (says,) if isinstance(says, str) else says:
            self.assertIn(part, said)
        self.assertEqual([request.name for request in self.inner.requests], [])
        return said

    def test_without_prefixes_no_address_is_read(self):
        daemon = self.begin()
        for name in (self.url("open/" + FILES[0].name), "s3://bucket/a.las", "file:///etc/passwd", "gopher://h/a"):
            self.refused(daemon, name, says="the service fetches none")
        self.assertEqual(self.server.requests, [])

    def test_what_is_below_a_prefix_is_read_as_files_are(self):
        daemon = self.begin(self.url("open/"))
        names = [self.url("open/" + file.name) for file in FILES]
        far = self.outcome(daemon, "triangulate", *names, output="far", dim=2)
        near = self.outcome(daemon, "triangulate", *(file.name for file in FILES), output="near", dim=2)
        self.assertEqual(far["digest"], near["digest"])
        x, y = 770530, 6277530
        cells = [self.outcome(daemon, "region", name, bbox=[x, y, x + 10, y + 10], dim=2, output=output)["cells"]
                 for name, output in ((names[0], "a"), (FILES[0].name, "b"))]
        self.assertEqual(*cells)
        told = daemon.request("POST", "/v1/processes/info/execution", {"inputs": {"inputs": [self.url("open/ept/ept.json")]}})
        self.assertEqual((told[0], told[2]["points"]), (200, 1065), told)
        # A cloud of objects is not kept: the next region sees what has become of them.
        self.server.objects["open/" + FILES[0].name] = FILES[1].read_bytes()
        changed = [self.outcome(daemon, "region", name, bbox=[x - 5, y - 5, x + 25, y + 25], dim=2, output=output)["cells"]
                   for name, output in ((names[0], "c"), (FILES[1].name, "d"))]
        self.assertEqual(*changed)

    def test_a_catalog_may_name_what_is_below(self):
        daemon = self.begin(self.url("open/"))
        item = {"type": "Feature", "links": [], "assets": {file.name: {"href": file.name} for file in FILES}}
        self.server.objects["open/item.json"] = json.dumps(item).encode()
        status, _, told = daemon.request("POST", "/v1/processes/info/execution", {"inputs": {"inputs": [self.url("open/item.json")]}})
        self.assertEqual((status, len(told["files"])), (200, 2), told)

    def test_names_outside_of_the_prefixes_are_refused(self):
        daemon = self.begin(self.url("open/"))
        port = self.server.server.server_address[1]
        name = FILES[0].name
        for wrong in (self.url("closed/" + name), self.url("opened/" + name), self.url("open/../closed/" + name), self.url("open/%2e%2e/closed/" + name),
                      self.url("open/..%2fclosed/" + name), self.url("open/%252e%252e/closed/" + name), self.url("open/..;/closed/" + name),
                      self.inner.url("open/" + name), f"http://localhost:{port}/open/{name}", f"http://0.0.0.0:{port}/open/{name}",
                      f"http://[::ffff:127.0.0.1]:{port}/open/{name}", f"https://127.0.0.1:{port}/open/{name}", f"http://127.0.0.1:{port}@127.0.0.1:1/open/{name}",
                      "http://169.254.169.254/latest/meta-data/a.las", "s3://open/" + name, f"ftp://127.0.0.1:{port}/open/{name}", "file:///etc/a.las",
                      "gs://open/" + name, "az://open/" + name):
            with self.subTest(name=wrong):
                self.refused(daemon, wrong, says="inputs:")
                self.refused(daemon, wrong, process="info", says="inputs:")
        self.refused(daemon, self.url("open/" + name) + "?token=SECRET", says="more behind its path")
        self.assertNotIn("SECRET", daemon.messages())
        self.assertEqual(self.server.requests, [])

    def test_a_name_that_leads_to_this_machine_is_not_connected_to(self):
        """As after a change of what the name means (DNS rebinding): the prefix fits, the address of the connection does not."""
        port = self.inner.server.server_address[1]
        daemon = self.begin(f"http://localhost:{port}/open/", self.inner.url("closed/"))
        self.refused(daemon, f"http://localhost:{port}/open/{FILES[0].name}", says="its name leads to ")

    def test_a_proxy_is_not_asked(self):
        daemon = self.begin(self.url("open/"), env={"http_proxy": self.inner.address, "HTTP_PROXY": self.inner.address, "ALL_PROXY": self.inner.address})
        self.outcome(daemon, "triangulate", self.url("open/" + FILES[0].name), output="far", dim=2)
        self.assertEqual(self.inner.requests, [])

    def test_each_redirect_is_checked(self):
        daemon = self.begin(self.url("open/"))
        name = FILES[0].name
        for hops in ([self.inner.url("open/" + name)], [self.url("closed/" + name)], [self.url("open/2"), self.url("open/3"), self.inner.url("open/" + name)],
                     ["http://169.254.169.254/latest/"], ["//127.0.0.1:1/open/a"], ["/open/%2e%2e/closed/" + name], ["file:///etc/passwd"]):
            way = dict(zip(["open/1", "open/2", "open/3"], hops))
            self.server.fault = lambda request, answer: Answer(302, {"Location": way[request.name]}, b"") if request.name in way else answer
            before = len(self.server.requests)
            with self.subTest(hops=hops):
                said = self.refused(daemon, self.url("open/1"), says="the server leads to ")
                self.assertNotIn("tries", said)
                self.assertEqual({request.name for request in self.server.requests[before:]}, set(way))
        self.server.fault = lambda request, answer: Answer(302, {"Location": "/open/" + name}, b"") if request.name == "open/1" else answer
        self.outcome(daemon, "triangulate", self.url("open/1"), output="far", dim=2)

    def test_catalogs_lead_nowhere_else(self):
        daemon = self.begin(self.url("open/"))

        def item(*assets, links=()):
            return json.dumps({"type": "Feature", "assets": {str(i): {"href": asset} for i, asset in enumerate(assets)},
                               "links": [{"rel": rel, "href": href} for rel, href in links]}).encode()
        name = FILES[0].name
        for document in (item(name, self.inner.url("open/" + name)), item("../closed/" + name), item(name, "s3://bucket/a.las"), item(name, "http://169.254.169.254/a.las"),
                         item(name, links=[("item", self.inner.url("open/item.json"))]), item(name, links=[("next", "../closed/item.json")]),
                         item(name, links=[("child", self.inner.url("open/item.json"))])):
            self.server.objects["open/item.json"] = document
            with self.subTest(document=document):
                self.refused(daemon, self.url("open/item.json"), recursive=True, says=("open/item.json: names ", "is not below"))
        for local in ("/etc/passwd.las", "file:///etc/a.las"):
            self.server.objects["open/item.json"] = item(local)
            with self.subTest(local=local):
                self.refused(daemon, self.url("open/item.json"), says="open/item.json")
        self.assertFalse([request.name for request in self.server.requests if not request.name.startswith("open/")])

    def test_tiles_of_ept_obey_the_prefixes(self):
        daemon = self.begin(self.url("open/ept/ept.json"), self.url("open/ept/ept-hierarchy/"))
        self.refused(daemon, self.url("open/ept/ept.json"), says=("ept-data/0-0-0-0.laz", "is not below"))
        self.server.fault = lambda request, answer: Answer(302, {"Location": self.inner.url(request.name)}, b"") if "hierarchy" in request.name else answer
        self.refused(daemon, self.url("open/ept/ept.json"), says="the server leads to ")

    def s3(self, **more):
        objects = {f"bucket/{key}": FILES[i % 2].read_bytes() for i, key in enumerate(("block/a.las", "block/b.las", "blocks/c.las", "d.las"))}
        return self.enterContext(S3Server(objects, KEYS, **more))

    def test_buckets(self):
        server = self.s3()
        daemon = self.begin("s3://bucket/block/", env=ME | {"AWS_ENDPOINT_URL": server.address, "HOME": str(self.folder)})
        status, _, told = daemon.request("POST", "/v1/processes/info/execution", {"inputs": {"inputs": ["s3://bucket/block/"]}})
        self.assertEqual((status, len(told["files"])), (200, 2), told)
        before = len(server.requests)
        for wrong in ("s3://bucket/", "s3://bucket", "s3://bucket/blocks/c.las", "s3://bucket/block/../d.las", "s3://other/block/a.las", "s3://bucket/bloc",
                      server.url("bucket/block/a.las")):
            with self.subTest(name=wrong):
                self.refused(daemon, wrong, says="inputs:")
        self.assertEqual(len(server.requests), before)
        # A listing that names what was not asked for.
        server.listing = lambda bucket, query: Answer(200, {}, b"<ListBucketResult><IsTruncated>false</IsTruncated><Contents><Key>d.las</Key></Contents></ListBucketResult>")
        self.refused(daemon, "s3://bucket/block/", says=("s3://bucket/d.las", "is not below"))

    def test_credentials_go_to_their_server_alone(self):
        server = self.s3()
        daemon = self.begin("s3://bucket/block/", self.url("open/"), self.inner.url("open/"), env=ME | {"AWS_ENDPOINT_URL": server.address, "HOME": str(self.folder)})
        server.fault = lambda request, answer: Answer(307, {"Location": self.inner.url("open/" + FILES[0].name)}, b"")
        self.refused(daemon, "s3://bucket/block/a.las", says="must not get what is meant for this one")
        self.outcome(daemon, "triangulate", self.url("open/" + FILES[0].name), output="far", dim=2)
        for request in self.server.requests:
            self.assertFalse({name.lower() for name in request.headers} & {"authorization", "cookie", "x-amz-date", "x-amz-security-token"}, request)

    def test_wrong_prefixes_are_refused_at_the_start(self):
        shutil.rmtree(self.folder / "data", ignore_errors=True)
        for prefix, says in (("127.0.0.1/open/", "not by"), ("ftp://host/", "not by ftp"), ("http://me:secret@host/", "user name"), ("https://host/?a=b", "behind its path")):
            with self.subTest(prefix=prefix), self.assertRaisesRegex(AssertionError, "status 2.*remote-prefix.*" + says) as told:
                self.begin(prefix)
            self.assertNotIn("secret", str(told.exception))


if __name__ == "__main__":
    unittest.main()
