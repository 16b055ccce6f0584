"""What there is to take: inputs to choose from, by HTTP, command and Python alike; what results were made into, and their units."""
import json
import os
import shutil
import subprocess
import unittest

from daemon import IGN, TESSERA, DaemonTest


class Listings(DaemonTest):
    def setUp(self):
        super().setUp()
        self.inputs = self.folder / "inputs"
        (self.inputs / "block").mkdir(parents=True)
        for file in IGN.glob("*.las"):
            shutil.copy(file, self.inputs / "block")
        (self.inputs / "few.xyz").write_text("0 0 0\n1 0 0\n0 1 0\n0 0 1\n")
        os.mkfifo(self.inputs / "pipe.las")
        self.daemon = self.start(inputs=self.inputs)

    def ask(self, path, status=200):
        found = self.daemon.request("GET", f"/v1/{path}")
        self.assertEqual(found[0], status, found)
        return found[2]

    def do(self, process, **inputs):
        status, _, job = self.daemon.request("POST", f"/v1/processes/{process}/execution", {"inputs": inputs})
        self.assertEqual(status, 201, job)
        ended = self.daemon.wait(job["jobID"])
        self.assertEqual(ended["status"], "successful", ended)
        return job["jobID"]

    def command(self, *words):
        address = f"{self.daemon.url}#token={self.daemon.token}"
        return subprocess.run([TESSERA, *words], capture_output=True, text=True, env=os.environ | {"TESSERA_SERVER": address})

    def test_inputs_are_listed_alike_by_http_command_and_python(self):
        top = self.ask("inputs")
        self.assertEqual([(each["name"], each.get("folder", False)) for each in top["inputs"]], [("block", True), ("few.xyz", False)])
        inside = self.ask("inputs?folder=block")["inputs"]
        self.assertEqual([each["name"] for each in inside], sorted(f"block/{file.name}" for file in IGN.glob("*.las")))
        for each in inside:
            told = self.daemon.request("POST", "/v1/processes/info/execution", {"inputs": {"inputs": [each["name"]]}})[2]
            self.assertIn(str(each["points"]), json.dumps(told))
            self.assertEqual(each["bytes"], (self.inputs / each["name"]).stat().st_size)
            self.assertEqual(len(each["bounds"]), 6)
            self.assertIn("Lambert-93", each["crs"])
        # In pages, as the command and Python ask for all of them.
        page = self.ask("inputs?folder=block&limit=3")
        self.assertEqual(len(page["inputs"]), 3)
        following = next(link["href"] for link in page["links"] if link["rel"] == "next")
        self.assertEqual(self.ask(following.split("v1/")[-1] if "v1/" in following else following)["inputs"], inside[3:])
        done = self.command("inputs", "block", "--json")
        self.assertEqual(done.returncode, 0, done.stderr)
        lines = [json.loads(line) for line in done.stdout.splitlines()]
        self.assertEqual([(line["name"], line["points"], line["bounds"], line["crs"]) for line in lines],
                         [(each["name"], each["points"], each["bounds"], each["crs"]) for each in inside])
        text = self.command("inputs").stdout
        self.assertRegex(text, r"(?m)^INPUT +SIZE +POINTS +SYSTEM$")
        self.assertRegex(text, r"(?m)^block/$")
        self.assertRegex(text, r"(?m)^few.xyz +\d+ B ")
        refused = self.command("inputs", "../..")
        self.assertEqual((refused.returncode, refused.stdout), (2, ""))
        self.assertIn("folder: '../..' must not contain '..'", refused.stderr)
        if "PYTHONPATH" in os.environ:
            import tessera
            client = tessera.connect(self.daemon.url, self.daemon.token)
            self.assertEqual(client.inputs("block"), inside)
            self.assertEqual(client.inputs(), top["inputs"])

    def test_what_was_made_is_linked_from_the_result(self):
        self.do("triangulate", inputs=["block"], output="ground", dim=2, **{"class": [2]})
        result = self.ask("triangulations/ground")
        self.assertEqual((result["unit"], result["heightUnit"]), ("metre", "metre"))
        self.assertEqual(result["heights"], [20.25, 21.92])
        self.assertIn("exports", [link["rel"] for link in result["links"]])
        self.assertEqual(self.ask("triangulations/ground/exports")["exports"], [])
        jobs = {"dem.tif": self.do("dem", triangulation="ground", res=0.5),
                "contours.gpkg": self.do("contours", triangulation="ground", interval=1),
                "mesh.ply": self.do("export", triangulation="ground", output="mesh.ply"),
                "3dtiles": self.do("export", triangulation="ground", output="3dtiles", format="3dtiles")}
        made = {each["name"]: each for each in self.ask("triangulations/ground/exports")["exports"]}
        self.assertEqual({name: each["jobID"] for name, each in made.items()}, jobs)
        self.assertEqual({name: each["processID"] for name, each in made.items()},
                         {"dem.tif": "dem", "contours.gpkg": "contours", "mesh.ply": "export", "3dtiles": "export"})
        self.assertGreater(made["3dtiles"]["files"], 1)
        rels = {name: {link["rel"] for link in each["links"]} for name, each in made.items()}
        self.assertEqual(rels["mesh.ply"], {"item"})
        self.assertEqual(rels["dem.tif"], {"item", "http://www.opengis.net/def/rel/ogc/1.0/tilesets-map"})
        self.assertEqual(rels["contours.gpkg"], {"item", "collection"})
        # Each leads somewhere.
        for name, each in made.items():
            for link in each["links"]:
                path = "/v1/triangulations/ground/" + link["href"]
                self.assertEqual(self.daemon.request("GET", os.path.normpath(path))[0], 200, path)
        on_disk = self.folder / "data/results/ground/exports/mesh.ply"
        self.assertEqual(made["mesh.ply"]["bytes"], on_disk.stat().st_size)
        self.assertEqual(self.daemon.request("DELETE", "/v1/triangulations/ground/files/exports/mesh.ply")[0], 204)
        self.assertNotIn("mesh.ply", [each["name"] for each in self.ask("triangulations/ground/exports")["exports"]])
        self.ask("triangulations/nothing/exports", 404)

    def test_both_are_described(self):
        paths = self.ask("api")["paths"]
        self.assertEqual(paths["/v1/inputs"]["get"]["x-role"], "submit")
        self.assertEqual({each["name"] for each in paths["/v1/inputs"]["get"]["parameters"]}, {"folder", "limit", "after"})
        self.assertEqual(paths["/v1/triangulations/{triangulation}/exports"]["get"]["x-role"], "read")
        self.assertIn("inputs", [link["rel"] for link in self.daemon.request("GET", "/v1")[2]["links"]])


if __name__ == "__main__":
    unittest.main()
