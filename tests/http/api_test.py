"""The API as a client sees it: every route's answer is what the document says."""

import unittest
import urllib.parse

import serving


class Api(serving.ServerTest):
    def test_every_answer_fits_the_document(self):
        job = self.submit()
        done = self.submit()
        self.server.tell(f"state {done} successful")
        files = "/v1/triangulations/{triangulation}/files/{path}"
        maps = "/v1/triangulations/{triangulation}/map/tiles"
        execution = {"inputs": {"inputs": ["a.las"]}}
        asked = {
            ("GET", "/"): ["/"], ("GET", "/v1"): ["/v1"], ("GET", "/v1/api"): ["/v1/api"],
            ("GET", "/v1/conformance"): ["/v1/conformance"], ("GET", "/v1/processes"): ["/v1/processes"],
            ("GET", "/v1/processes/{process}"): [f"/v1/processes/{name}" for name in
                                                 ("triangulate", "region", "verify", "export", "dem", "contours", "surface", "alpha", "voronoi", "density", "volume", "measure", "update",
                                                  "hag", "info", "none")],
            ("POST", "/v1/processes/{process}/execution"): ["/v1/processes/triangulate/execution",
                                                            "/v1/processes/info/execution"],
            ("POST", "/v1/processes/{process}/estimate"): ["/v1/processes/triangulate/estimate", "/v1/processes/info/estimate"],
            ("GET", "/v1/jobs"): ["/v1/jobs", "/v1/jobs?limit=1&status=accepted,running", "/v1/jobs?limit=0"],
            ("GET", "/v1/jobs/{job}"): [f"/v1/jobs/{job}", "/v1/jobs/none"],
            ("GET", "/v1/jobs/{job}/results"): [f"/v1/jobs/{job}/results", f"/v1/jobs/{done}/results"],
            ("GET", "/v1/jobs/{job}/log"): [f"/v1/jobs/{job}/log"],
            ("GET", "/v1/jobs/{job}/report"): [f"/v1/jobs/{job}/report"],
            ("GET", "/v1/jobs/{job}/events"): [f"/v1/jobs/{done}/events", "/v1/jobs/none/events"],
            ("DELETE", "/v1/jobs/{job}"): [f"/v1/jobs/{job}"],
            ("POST", "/v1/jobs/{job}/resume"): [f"/v1/jobs/{job}/resume"],
            ("GET", "/v1/triangulations"): ["/v1/triangulations?limit=1"],
            ("GET", "/v1/inputs"): ["/v1/inputs", "/v1/inputs?folder=none&limit=1", "/v1/inputs?limit=x"],
            ("GET", "/v1/triangulations/{triangulation}"): ["/v1/triangulations/block", "/v1/triangulations/none"],
            ("GET", "/v1/triangulations/{triangulation}/versions"): ["/v1/triangulations/block/versions", "/v1/triangulations/none/versions"],
            ("GET", "/v1/triangulations/{triangulation}/exports"): ["/v1/triangulations/block/exports", "/v1/triangulations/none/exports"],
            ("DELETE", "/v1/triangulations/{triangulation}"): ["/v1/triangulations/block"],
            ("DELETE", files): ["/v1/triangulations/block/files/exports/mesh.ply",
                                "/v1/triangulations/block/files/exports/none", "/v1/triangulations/block/files/manifest.json"],
            ("GET", files): ["/v1/triangulations/block/files/deep/tile.vtu", "/v1/triangulations/block/files/none"],
            ("GET", "/v1/triangulations/{triangulation}/3dtiles/{path}"): ["/v1/triangulations/block/3dtiles/tileset.json"],
            ("GET", "/v1/triangulations/{triangulation}/locate"): ["/v1/triangulations/block/locate?point=1,2",
                                                                   "/v1/triangulations/none/locate?point=1,2"],
            ("POST", "/v1/triangulations/{triangulation}/locate"): ["/v1/triangulations/block/locate"],
            ("GET", "/v1/triangulations/{triangulation}/vertices/{vertex}/star"): ["/v1/triangulations/block/vertices/1/star"],
            ("GET", "/v1/triangulations/{triangulation}/vertices/{vertex}/neighbours"):
                ["/v1/triangulations/block/vertices/1/neighbours"],
            ("GET", "/v1/triangulations/{triangulation}/cells"): ["/v1/triangulations/block/cells?bbox=0,0,1,1"],
            ("POST", "/v1/triangulations/{triangulation}/cells"): ["/v1/triangulations/block/cells"],
            ("POST", "/v1/triangulations/{triangulation}/interpolate"): ["/v1/triangulations/block/interpolate?value=z"],
            ("GET", "/v1/triangulations/{triangulation}/dem"): ["/v1/triangulations/block/dem?res=1"],
            ("GET", "/v1/triangulations/{triangulation}/contours"): ["/v1/triangulations/block/contours?interval=1"],
            ("GET", "/v1/triangulations/{triangulation}/profile"): ["/v1/triangulations/block/profile?line=0,0%201,1"],
            ("POST", "/v1/triangulations/{triangulation}/profile"): ["/v1/triangulations/block/profile"],
            ("GET", "/v1/collections"): ["/v1/collections"],
            ("GET", "/v1/collections/{collection}"): ["/v1/collections/block.tiles", "/v1/collections/none"],
            ("GET", "/v1/collections/{collection}/items"): ["/v1/collections/block.tiles/items?limit=1&bbox=2,48,3,49",
                                                            "/v1/collections/none/items"],
            ("GET", "/v1/collections/{collection}/items/{item}"): ["/v1/collections/block.tiles/items/7",
                                                                   "/v1/collections/block.tiles/items/8"],
            ("GET", maps): ["/v1/triangulations/block/map/tiles", "/v1/triangulations/none/map/tiles"],
            ("GET", maps + "/WebMercatorQuad"): ["/v1/triangulations/block/map/tiles/WebMercatorQuad"],
            ("GET", maps + "/WebMercatorQuad/{tileMatrix}/{tileRow}/{tileCol}"): [
                f"/v1/triangulations/block/map/tiles/WebMercatorQuad/{place}" for place in ("1/0/1", "1/2/0", "x/0/0", "99/0/0")],
            ("GET", "/v1/triangulations/{triangulation}/shapes/hull"): ["/v1/triangulations/block/shapes/hull", "/v1/triangulations/none/shapes/hull"],
            ("GET", "/v1/triangulations/{triangulation}/shapes/section"): [
                "/v1/triangulations/block/shapes/section?through=0,0,0&normal=0,0,1"],
            ("GET", "/v1/triangulations/{triangulation}/shapes/cells"): ["/v1/triangulations/block/shapes/cells?bbox=0,0,0,1,1,1&shrink=0.5"],
            ("POST", "/v1/triangulations/{triangulation}/points"): ["/v1/triangulations/block/points", "/v1/triangulations/none/points"],
            ("DELETE", "/v1/triangulations/{triangulation}/points"): ["/v1/triangulations/block/points", "/v1/triangulations/none/points"],
            ("PUT", "/v1/uploads/{upload}/{file}"): ["/v1/uploads/mine/a.las"],
            ("HEAD", "/v1/uploads/{upload}/{file}"): ["/v1/uploads/mine/a.las"],
            ("DELETE", "/v1/uploads/{upload}/{file}"): ["/v1/uploads/mine/a.las"],
            ("GET", "/v1/jobs/{job}/tiles"): [f"/v1/jobs/{job}/tiles", f"/v1/jobs/{job}/tiles?layout=true",
                                              f"/v1/jobs/{job}/tiles?layout=2", "/v1/jobs/none/tiles"],
            ("POST", "/v1/session"): ["/v1/session"], ("DELETE", "/v1/session"): ["/v1/session"],
            ("GET", "/v1/caller"): ["/v1/caller"], ("GET", "/ui"): ["/ui", "/ui/"],
            ("GET", "/ui/{file}"): ["/ui/app.js", "/ui/none"],
            ("GET", "/v1/nodes"): ["/v1/nodes"],
            ("POST", "/v1/nodes/{node}/drain"): ["/v1/nodes/a/drain", "/v1/nodes/b/drain", "/v1/nodes/none/drain"],
        }
        routes = {(method.upper(), path) for path, operations in self.api()["paths"].items() for method in operations}
        operations = {("GET", "/livez"), ("GET", "/readyz"), ("GET", "/metrics")}
        self.assertEqual(routes - operations, set(asked) | {("GET", "/v1/events"), ("GET", "/v1/triangulations/{triangulation}/events")})
        for (method, path), targets in asked.items():
            for target in targets:
                with self.subTest(f"{method} {target}"):
                    body = b"abc" if method == "PUT" else execution if "execution" in path or "estimate" in path else None
                    if method == "POST" and path.rsplit("/", 1)[-1] in ("locate", "interpolate", "cells", "profile"):
                        body = {"points": [[1, 2]]}
                    if path.endswith("/points"):
                        body = {"ids": [1]} if method == "DELETE" else {"points": [[1, 2, 3]]}
                    self.check(self.ask(method, target, body), path, method)
        for method, path in operations:
            self.check(self.ask(method, path, token=None, port=self.server.operations), path, method)

    def test_the_document_is_openapi_3(self):
        document = self.api()
        self.assertEqual(document["openapi"][:4], "3.0.")
        for path, operations in document["paths"].items():
            for operation in operations.values():
                named = [p["name"] for p in operation["parameters"] if p["in"] == "path"]
                self.assertEqual(named, [part[1:-1] for part in path.split("/") if part.startswith("{")])

    def test_features_are_told_in_the_system_that_is_asked_for(self):
        crs84, lambert = "http://www.opengis.net/def/crs/OGC/1.3/CRS84", "http://www.opengis.net/def/crs/EPSG/0/2154"
        self.assertIn("http://www.opengis.net/spec/ogcapi-features-2/1.0/conf/crs", self.ask("GET", "/v1/conformance").json()["conformsTo"])
        collection = self.ask("GET", "/v1/collections/block.tiles").json()
        self.assertEqual((collection["crs"], collection["storageCrs"]), ([crs84, lambert], lambert))
        paths, items = self.api()["paths"], "/v1/collections/{collection}/items"
        self.assertLessEqual({"bbox", "bbox-crs", "crs"}, {p["name"] for p in paths[items]["get"]["parameters"]})
        self.assertIn("crs", {p["name"] for p in paths[items + "/{item}"]["get"]["parameters"]})
        for path in ("/v1/collections/block.tiles/items", "/v1/collections/block.tiles/items/7"):
            self.assertEqual(self.ask("GET", path).headers["Content-Crs"], f"<{crs84}>")
            answer = self.ask("GET", f"{path}?crs={urllib.parse.quote(lambert, '')}")
            self.assertEqual(answer.headers["Content-Crs"], f"<{lambert}>")
            links = {link["rel"]: urllib.parse.parse_qs(urllib.parse.urlsplit(link["href"]).query) for link in answer.json()["links"]}
            for rel in {"self", "next"} & set(links):  # goes on in it
                self.assertEqual(links[rel]["crs"], [lambert])

    def test_a_bare_submission_gives_a_job_that_is_found_by_its_links(self):
        path = "/v1/processes/triangulate/execution"
        answer = self.ask("POST", path, {"inputs": {"inputs": ["a.las"]}})
        self.assertEqual(answer.status, 201)
        place = urllib.parse.urljoin(path, answer.headers["Location"])
        self.assertEqual(place, "/v1/jobs/" + answer.json()["id"])
        job = self.ask("GET", place).json()
        self.assertEqual((job["jobID"], job["id"], job["type"]), (job["id"], job["jobID"], "process"))
        links = {link["rel"]: urllib.parse.urljoin(place, link["href"]) for link in job["links"]}
        self.assertEqual(links["self"], place)
        self.assertEqual(self.ask("GET", links["runlog"]).body, b"one\ntwo\n")
        page = self.ask("GET", "/v1").json()
        for link in page["links"]:
            if link["rel"] != "events":
                self.assertEqual(self.ask("GET", urllib.parse.urlsplit(urllib.parse.urljoin("/v1", link["href"])).path).status, 200)

    def test_one_key_is_one_job(self):
        path, key = "/v1/processes/triangulate/execution", {"Idempotency-Key": "once"}
        first = self.ask("POST", path, {"inputs": {"inputs": ["a.las"]}}, headers=key)
        again = self.ask("POST", path, {"inputs": {"inputs": ["a.las"]}}, headers=key)
        other = self.ask("POST", path, {"inputs": {"inputs": ["b.las"]}}, headers=key)
        self.assertEqual(first.json()["id"], again.json()["id"])
        self.assertEqual(other.status, 422)

    def test_info_is_told_at_once_or_by_a_job(self):
        path, body = "/v1/processes/info/execution", {"inputs": {"inputs": ["a.las"]}}
        at_once = self.ask("POST", path, body)
        self.assertEqual((at_once.status, at_once.json()), (200, {"points": 7}))
        job = self.ask("POST", path, body, headers={"Prefer": "respond-async"})
        self.assertEqual((job.status, job.headers["Preference-Applied"]), (201, "respond-async"))
        self.server.tell(f"state {job.json()['id']} successful")
        self.assertEqual(self.ask("GET", f"/v1/jobs/{job.json()['id']}/results").json()["outcome"]["value"], {"proved": True})

    def test_lists_are_read_in_pages(self):
        wanted = [self.submit() for _ in range(7)]
        place, found = "/v1/jobs?limit=3", []
        while place:
            page = self.ask("GET", place).json()
            found += [job["id"] for job in page["jobs"]]
            following = [link["href"] for link in page["links"] if link["rel"] == "next"]
            place = urllib.parse.urljoin(place, following[0]) if following else None
        self.assertEqual(found[-7:], wanted)
        self.assertEqual(len(set(found)), len(found))

    def test_64_bit_numbers_are_numbers(self):
        answer = self.ask("POST", "/v1/processes/triangulate/estimate", {"inputs": {"inputs": ["a"]}})
        self.assertIn(b"9007199254740993", answer.body)
        self.assertNotIn(b'"9007199254740993"', answer.body)

    def test_protobuf_goes_in_and_out(self):
        inputs = b"\x0a\x05a.las"                                   # TriangulateInputs.inputs
        body = b"\x0a" + bytes([len(inputs) + 2]) + b"\x0a" + bytes([len(inputs)]) + inputs
        kinds = {"Content-Type": "application/x-protobuf", "Accept": "application/x-protobuf"}
        answer = self.ask("POST", "/v1/processes/triangulate/execution", body, headers=kinds)
        self.assertEqual((answer.status, answer.headers["Content-Type"]), (201, "application/x-protobuf"))
        self.assertEqual(answer.body[:3], b"\x0a" + bytes([answer.body[1]]) + b"j")
        wrong = self.ask("POST", "/v1/processes/verify/execution", body, headers=kinds)
        self.assertEqual(wrong.status, 400)
        self.assertEqual(self.ask("POST", "/v1/processes/verify/execution", b"\xff\xff", headers=kinds).status, 400)

    def test_results_are_by_reference_and_not_there_before(self):
        job = self.submit()
        path = f"/v1/jobs/{job}/results"
        early = self.ask("GET", path)
        self.assertEqual(early.status, 404)
        self.assertTrue(early.json()["type"].endswith("/result-not-ready"))
        self.server.tell(f"state {job} successful")
        href = self.ask("GET", path).json()["triangulation"]["href"]
        self.assertEqual(self.ask("GET", urllib.parse.urljoin(path, href)).json()["name"], "block")
        self.server.tell(f"state {job} failed")
        self.assertEqual(self.ask("GET", path).status, 422)

    def test_head_is_get_without_its_body(self):
        for path in ("/v1", "/v1/jobs", "/v1/triangulations/block/files/deep/tile.vtu", "/v1/jobs/none"):
            get, head = self.ask("GET", path), self.ask("HEAD", path)
            self.assertEqual((head.status, head.headers["Content-Length"], head.body),
                             (get.status, get.headers["Content-Length"], b""))

    def test_wrong_types_and_parameters_are_refused(self):
        path = "/v1/processes/triangulate/execution"
        self.assertEqual(self.ask("POST", path, b"{}", headers={"Content-Type": "text/plain"}).status, 415)
        self.assertEqual(self.ask("GET", "/v1/jobs?limt=3").status, 400)
        self.assertEqual(self.ask("GET", "/v1/jobs?status=lost").status, 400)
        problem = self.ask("GET", "/v1/jobs?limit=x").json()
        self.assertIn("limit", problem["detail"])
        self.assertEqual((problem["instance"], problem["cause"]), ("/v1/jobs", 2))

    def test_points_are_added_and_removed_and_their_types_are_named(self):
        path = "/v1/triangulations/block/points"
        added = self.ask("POST", path, {"points": [[1, 2, 3]]}).json()
        self.assertEqual((added["added"], added["removed"], added["firstID"]), (1, 0, 100 + added["version"]))
        self.assertEqual(self.ask("POST", path + "?replace=true", {"points": [[1, 2, 3]]}).json()["removed"], 1)
        self.assertEqual(self.ask("POST", path + "?replace=false", {"points": [[1, 2, 3]]}).json()["removed"], 0)
        self.assertEqual(self.ask("POST", path + "?replace=yes", {"points": [[1, 2, 3]]}).status, 400)
        self.assertEqual(self.ask("DELETE", path + "?replace=true", {"ids": [1]}).status, 400)
        added["version"] += 2
        removed = self.ask("DELETE", path, b"\x0a\x01\x05", headers={"Content-Type": "application/x-protobuf"})
        self.assertEqual((removed.status, removed.json()["version"]), (200, added["version"] + 1))
        npy = self.ask("POST", path, b"\x93NUMPY", headers={"Content-Type": "application/x-npy; x=y",
                                                           "Accept": "application/x-protobuf"})
        self.assertEqual((npy.status, npy.headers["Content-Type"]), (200, "application/x-protobuf"))
        self.assertEqual(self.ask("POST", path, b"1,2,3", headers={"Content-Type": "text/csv"}).status, 415)
        self.assertEqual(self.ask("POST", path, b"refuse", headers={"Content-Type": "application/json"}).status, 400)
        self.assertEqual(self.ask("POST", path, b" " * 2_000_000, headers={"Content-Type": "application/json"}).status, 413)
        self.assertEqual(self.ask("POST", path, {"points": []}, token="read").status, 403)
        self.assertEqual(self.ask("DELETE", path, {"ids": []}, token=None).status, 401)
        told = self.ask("GET", "/v1/triangulations/block").json()
        self.assertEqual(told["live"]["version"], added["version"] + 2)
        self.assertIn("events", {link["rel"] for link in told["links"]})

    def test_uploads_say_how_far_they_are(self):
        path = "/v1/uploads/mine/b.las"
        self.assertEqual(self.ask("HEAD", path).status, 404)
        data = bytes(range(256)) * 8000
        self.assertEqual(self.ask("PUT", path, data).status, 204)
        self.assertEqual(self.ask("HEAD", path).headers["Upload-Offset"], str(len(data)))
        self.assertEqual(self.ask("PUT", path, b"more", headers={"Upload-Offset": str(len(data))}).status, 204)
        self.assertEqual(self.ask("PUT", path, b"more", headers={"Upload-Offset": "5"}).status, 409)
        self.assertIn(b" 411 ", self.raw(self.head("PUT", path, "Transfer-Encoding: chunked\r\nConnection: close\r\n")))

    def test_figures_are_those_of_prometheus(self):
        self.ask("GET", "/v1/jobs")
        text = self.ask("GET", "/metrics", token=None, port=self.server.operations).body.decode()
        self.assertRegex(text, r'tessera_http_requests_total\{route="listJobs",status="2xx"\} [1-9]')
        self.assertRegex(text, r'tessera_phase_seconds_total\{phase="triangulating"\} 1.5')
        self.assertRegex(text, r'tessera_nodes\{state="free"\} 2\n')
        self.assertRegex(text, r"\ntessera_nodes_lost_total 3\n")
        self.assertRegex(text, r"\ntessera_node_bytes_total 4096\n")
        self.assertRegex(text, r"\ntessera_credit_waits_total 5\n")
        self.assertIn("\nready\n", self.ask("GET", "/readyz?verbose", token=None, port=self.server.operations).body.decode())


class PublicUrl(serving.ServerTest):
    options = {"public_url": "https://tessera.example/x/"}

    def test_links_are_absolute(self):
        answer = self.ask("POST", "/v1/processes/verify/execution", {"inputs": {"triangulation": "block"}})
        self.assertEqual(answer.headers["Location"], "https://tessera.example/x/v1/jobs/j1")
        self.assertEqual(answer.json()["links"][0]["href"], "https://tessera.example/x/v1/jobs/j1")
        self.assertEqual(self.ask("GET", "/v1", headers={"Host": "tessera.example"}).status, 200)


if __name__ == "__main__":
    unittest.main()
