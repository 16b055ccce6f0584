"""A client of OGC API - Processes that knows nothing of ours: OWSLib, and what it finds by following links."""
import time
import unittest
import urllib.parse

import requests
from owslib.ogcapi.features import Features
from owslib.ogcapi.processes import Processes

from daemon import DaemonTest


class Standard(DaemonTest):
    def test_owslib_asks_for_features_in_the_system_of_the_result(self):
        daemon = self.start()
        job = daemon.request("POST", "/v1/processes/triangulate/execution", {"inputs": {
            "inputs": ["ign_77050_627755.las"], "crs": "EPSG:2154", "dim": 2, "tiles": 6, "output": "ground"}})[2]["jobID"]
        self.assertEqual(daemon.wait(job)["status"], "successful")
        service = Features(daemon.url + "v1/", headers={"Authorization": f"Bearer {daemon.token}"})
        self.assertIn("http://www.opengis.net/spec/ogcapi-features-2/1.0/conf/crs", service.conformance()["conformsTo"])
        self.assertEqual(service.feature_collections(), ["ground.tiles", "ground.hull"])
        storage = service.collection("ground.tiles")["storageCrs"]
        self.assertEqual(storage, "http://www.opengis.net/def/crs/EPSG/0/2154")
        items = service.api()["paths"]["/v1/collections/{collection}/items"]["get"]["parameters"]
        self.assertLessEqual({"crs", "bbox-crs"}, {parameter["name"] for parameter in items})
        bounds = daemon.request("GET", "/v1/triangulations/ground")[2]["bounds"]
        everything = service.collection_items("ground.tiles", limit=100, crs=storage)
        self.assertEqual(everything["numberReturned"], 6)
        xs = [x for feature in everything["features"] for x, _ in feature["geometry"]["coordinates"][0]]
        self.assertEqual(min(xs), bounds[0])
        place = [bounds[0], bounds[1], bounds[0] + 0.001, bounds[1] + 0.001]
        found = service.collection_items("ground.tiles", bbox=place, **{"bbox-crs": storage})
        self.assertEqual(found["numberReturned"], 1)
        self.assertLess(found["features"][0]["geometry"]["coordinates"][0][0][0], 180)  # in degrees, as nobody has asked otherwise
        self.assertEqual(service.collection_item("ground.tiles", "3")["id"], 3)
        self.assertEqual(daemon.end(), 0, daemon.messages())

    def test_owslib_drives_a_job_from_its_submission_to_its_results(self):
        daemon = self.start()
        head = {"Authorization": f"Bearer {daemon.token}"}
        root = daemon.url + "v1/"
        service = Processes(root, headers=head)
        self.assertIn("http://www.opengis.net/spec/ogcapi-processes-1/1.0/conf/core", service.conformance()["conformsTo"])
        names = [process["id"] for process in service.processes()["processes"]]
        self.assertIn("triangulate", names)
        process = service.process("triangulate")
        self.assertIn("inputs", process["inputs"])

        # OWSLib 0.27 describes processes and leaves executing them to its user: from here on by links alone.
        def follow(document, rel, base):
            found = [link["href"] for link in document["links"] if link["rel"] == rel]
            self.assertTrue(found, (rel, document["links"]))
            return urllib.parse.urljoin(base, found[0])

        execute = follow(process, "http://www.opengis.net/def/rel/ogc/1.0/execute", service.request)
        accepted = requests.post(execute, headers=head, json={"inputs": {"inputs": ["*.las"], "output": "block"}})
        self.assertEqual(accepted.status_code, 201, accepted.text)
        job = urllib.parse.urljoin(execute, accepted.headers["Location"])
        while (status := requests.get(job, headers=head).json())["status"] in ("accepted", "running"):
            time.sleep(0.05)  # the standard knows only asking again
        self.assertEqual(status["status"], "successful", status)
        results = follow(status, "http://www.opengis.net/def/rel/ogc/1.0/results", job)
        made = requests.get(results, headers=head).json()
        where = urllib.parse.urljoin(results, made["triangulation"]["href"])
        self.assertEqual(requests.get(where, headers=head).json()["name"], "block")

        jobs = follow({"links": service.links}, "http://www.opengis.net/def/rel/ogc/1.0/job-list", root)
        self.assertEqual([j["jobID"] for j in requests.get(jobs, headers=head).json()["jobs"]], [status["jobID"]])
        self.assertEqual(requests.delete(job, headers=head).status_code, 200)
        self.assertEqual(requests.get(job, headers=head).status_code, 410)
        self.assertEqual(daemon.end(), 0)

    def test_what_a_schema_lists_is_taken_and_nothing_else(self):
        daemon = self.start()

        def refusal(name, value):
            # Which of equal points is kept is asked in the plane alone.
            body = {"inputs": {"inputs": ["*.las"], name: value} | ({"dim": 2} if name == "keep" else {})}
            status, _, told = daemon.request("POST", "/v1/processes/triangulate/estimate", body)
            # Of the values themselves; these files have no such flag.
            return None if status == 200 or "has no attribute 'overlap'" in told["detail"] else status

        listed = 0
        for name, described in daemon.request("GET", "/v1/processes/triangulate")[2]["inputs"].items():
            schema = described["schema"]
            of_one = schema.get("items", schema)
            for value in of_one.get("enum", ()):
                listed += 1
                self.assertIsNone(refusal(name, [value] if schema is not of_one else value), (name, value))
            if "enum" in of_one:
                other = 4 if of_one["type"] == "integer" else "none"
                self.assertEqual(refusal(name, [other] if schema is not of_one else other), 400, name)
        self.assertGreaterEqual(listed, 16)
        self.assertEqual(daemon.end(), 0)


if __name__ == "__main__":
    unittest.main()
