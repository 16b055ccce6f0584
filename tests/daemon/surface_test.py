"""Closed surfaces as jobs of the daemon: the file of the command, and what is refused."""
import unittest

from daemon import IGN
from regions_test import WithDaemon as _WithDaemon

INPUTS = {"inputs": ["ign_77050_627755.las"], "attributes": ["return_number", "number_of_returns"]}


class Surfaces(_WithDaemon):
    def test_a_surface_is_the_file_of_the_command(self):
        self.execute("triangulate", **INPUTS, dim=3, output="block", tiles=4)
        result = self.folder / "data/results/block"
        job, outcome = self.execute("surface", triangulation="block")
        self.tessera("surface", result, "-o", "mesh.ply")
        self.assertEqual((result / "exports/surface.ply").read_bytes(), (self.folder / "mesh.ply").read_bytes())
        self.assertEqual((outcome["output"], outcome["written"][0]["path"]), ("surface.ply", "exports/surface.ply"))
        self.assertIn("straight above", outcome["sensors"])
        self.assertGreater(outcome["triangles"], 50_000)
        self.execute("surface", triangulation="block", output="mesh.obj", bottom="free", sensor="point:770520,6277520,300",
                     trim=3, **{"lambda": 2}, ray_length="full", unknown="empty", sigma=0.1, manifold=True, smoothing=2)
        self.tessera("surface", result, "--bottom", "free", "--sensor", "point:770520,6277520,300", "--trim", 3, "--lambda", 2,
                     "--ray-length", "full", "--unknown", "empty", "--sigma", 0.1, "--manifold", "--smooth", 2, "-o", "mesh.obj")
        self.assertEqual((result / "exports/mesh.obj").read_bytes(), (self.folder / "mesh.obj").read_bytes())
        self.assertEqual(self.refused("surface", triangulation="block")[0], 409)
        self.execute("surface", triangulation="block", overwrite=True)
        self.execute("triangulate", inputs=INPUTS["inputs"], dim=2, output="ground")
        for inputs, status, says in (
                ({"triangulation": "none"}, 422, "none called"),
                ({}, 400, "triangulation"),
                ({"triangulation": "block", "output": "x.xyz"}, 400, "xyz"),
                ({"triangulation": "block", "output": "../x.ply"}, 400, "output"),
                ({"triangulation": "block", "sensor": "track:/etc/passwd"}, 400, "does not say where the sensors are"),
                ({"triangulation": "block", "sensor": "point:1,2"}, 400, "sensor"),
                ({"triangulation": "block", "bottom": "flat"}, 400, "bottom"),
                ({"triangulation": "block", "unknown": "maybe"}, 400, "solid nor empty"),
                ({"triangulation": "block", "ray_length": "0"}, 400, "ray_length"),
                ({"triangulation": "block", "sigma": -1}, 400, "sigma"),
                ({"triangulation": "block", "alpha": 0}, 400, "alpha"),
                ({"triangulation": "block", "smoothing": 1001}, 400, "smoothing"),
                ({"triangulation": "block", "lambda": -1}, 400, "lambda")):
            with self.subTest(f"{inputs}"):
                told = self.refused("surface", **inputs)
                self.assertEqual(told[0], status, told)
                self.assertIn(says, told[1])
        job = self.daemon.request("POST", "/v1/processes/surface/execution", {"inputs": {"triangulation": "ground"}})[2]
        job = self.daemon.wait(job["jobID"])
        self.assertEqual(job["status"], "failed")
        self.assertIn("2D triangulation", job["message"])
        self.assertEqual(sorted(file.name for file in (result / "exports").iterdir() if not file.name.endswith(".owner")),
                         ["mesh.obj", "surface.ply"])
        self.assertEqual(self.daemon.end(), 0, self.daemon.messages())


if __name__ == "__main__":
    unittest.main()
