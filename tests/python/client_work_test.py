"""verify, measure, update, export, hag, voronoi, density, alpha, volume, info and upload of a daemon: what is sent, what comes back, and what is raised."""
import os
import pathlib
import unittest

import numpy as np

import tessera

from client_test import ClientTest, xxh3

PROVED = {"event": "verified", "cells": 12, "facets": 30, "hull_facets": 6, "vertices": 7, "passed": ["hull"]}


class Work(ClientTest):
    def end(self, outcome):
        def work(job):
            job.outcome = outcome
            job.tell("successful", triangulation="block")
        self.server.on_submit = work

    def test_a_proof_is_the_same_object(self):
        self.end(PROVED)
        proof = self.client.verify("block", memory="2G", against_cgal=True)
        self.assertEqual(proof, tessera.Proof(12, 30, 6, 7, ("hull",)))
        self.assertEqual(self.server.jobs["j1"].inputs, {"triangulation": "block", "memory": "2G", "against_cgal": True})
        self.server.on_submit = lambda job: job.tell("failed", problem={"detail": "tile 3: not empty", "cause": 6})
        with self.assertRaisesRegex(tessera.NotDelaunayError, "tile 3"):
            self.client.verify("block")

    def export(self, spoil=lambda content: content):
        """A daemon that exports with the library here."""
        t = self.make_result()
        exports = pathlib.Path(t.folder) / "exports"
        def work(job):
            exports.mkdir(exist_ok=True)
            output = exports / job.inputs["output"]
            t.export(output, job.inputs.get("format"), overwrite=True)
            files = [output] if output.is_file() else sorted(output.iterdir())
            job.outcome = {"note": "so it is", "written": [
                {"path": str(file.relative_to(t.folder)), "bytes": file.stat().st_size, "xxh3": xxh3(spoil(file.read_bytes()))}
                for file in files]}
            job.tell("successful", triangulation="block")
        self.server.on_submit = work
        return t, exports

    def test_an_export_arrives_and_is_gone_there(self):
        t, exports = self.export()
        here, there = self.folder / "mesh.off", self.folder / "same.off"
        with self.assertWarnsRegex(UserWarning, "so it is"):
            self.client.export("block", here)
        t.export(there)
        self.assertEqual(here.read_bytes(), there.read_bytes())
        self.assertEqual(list(exports.iterdir()), [])
        with self.assertRaisesRegex(tessera.UsageError, "exists already"):
            self.client.export("block", here)
        with self.assertWarns(UserWarning):
            self.client.export("block", here, overwrite=True)

    def test_damage_of_an_export_is_found(self):
        self.export(spoil=lambda content: content + b"?")
        with self.assertRaisesRegex(tessera.CorruptError, "its checksum is"):
            self.client.export("block", self.folder / "mesh.off")
        self.assertFalse((self.folder / "mesh.off").exists())
        self.end({"written": [{"path": "exports/../../x", "bytes": 1, "xxh3": "0"}]})
        with self.assertRaises(tessera.CorruptError):
            self.client.export("block", self.folder / "mesh.off")

    def test_measures_are_the_same_object(self):
        self.end({"event": "measured", "total": 2.5, "unit": "metre^3", "made": True, "note": "so it is"})
        with self.assertWarnsRegex(UserWarning, "so it is"):
            measures = self.client.measure("block", volume=True, memory="2G")
        self.assertEqual(measures, tessera.Measures(2.5, "metre^3", True))
        self.assertEqual(self.server.jobs["j1"].inputs,
                         {"triangulation": "block", "volume": True, "quality": False, "voronoi": False, "density": False, "memory": "2G"})
        self.end({"event": "measured"})
        with self.assertRaises(tessera.Error):
            self.client.measure("block", quality=True)
        self.end({"event": "measured", "total": None, "unit": "", "made": True})
        self.client.measure("block", density=True, mass="weight")
        sent = self.server.jobs["j3"].inputs
        self.assertEqual((sent["density"], sent["mass"]), (True, "weight"))

    def test_changes_send_what_is_given_and_tell_what_has_changed(self):
        told = {"event": "updated", "output": "block", "version": 2, "removed": 3}
        self.end(told)
        (self.folder / "area.geojson").write_text('{"type": "Polygon", "coordinates": []}')
        made = self.client.update("block", ["a.laz", pathlib.Path("b.laz")], remove_ids=np.array([1, 2], np.uint64), remove_class=[7],
                                  remove_box=(0, 0, 1, 1), remove_polygon=self.folder / "area.geojson", remove_time=(1, 2.5),
                                  remove_input="old.laz", replace=True, keep_versions=3, memory="2G")
        self.assertEqual(made, told)
        self.assertEqual(self.server.jobs["j1"].inputs, {
            "triangulation": "block", "inputs": ["a.laz", "b.laz"], "remove_input": ["old.laz"], "remove_ids": [1, 2],
            "remove_class": [7], "remove_box": [0, 0, 1, 1], "remove_polygon": '{"type": "Polygon", "coordinates": []}',
            "remove_time": [1, 2.5], "replace": True, "overwrite": False, "keep_versions": 3, "dry_run": False,
            "recursive": False, "memory": "2G"})
        self.client.update("block", remove_ids="upload:mine/ids.npy", output="next", overwrite=True)
        sent = self.server.jobs["j2"].inputs
        self.assertEqual((sent["remove_ids_file"], sent["output"], sent["overwrite"]), ("upload:mine/ids.npy", "next", True))
        self.assertNotIn("remove_ids", sent)

    def test_copies_with_heights_arrive_and_are_gone_there(self):
        cloud = pathlib.Path(__file__).resolve().parents[1] / "data" / "clouds" / "pdal_mvk_thin.las"
        ground = tessera.triangulate(cloud, 2, classes=[2], folder=self.folder / "ground")
        exports = ground.folder / "exports"
        self.server.results["block"] = ground.folder

        def work(job):
            made = tessera.hag(cloud, exports / job.inputs["output"], ground=ground)
            job.outcome = {
                "files": [{"input": "mvk.las", "output": file.output.name, "points": file.points, "outside": file.outside} for file in made],
                "written": [{"path": str(file.output.relative_to(ground.folder)), "bytes": file.output.stat().st_size,
                             "xxh3": xxh3(file.output.read_bytes())} for file in made]}
            job.tell("successful", triangulation="block")
        self.server.on_submit = work
        (file,) = self.client.hag("mvk.las", "block", self.folder / "out", outside=-1, memory="1G")
        self.assertEqual((file.input, file.output, file.points), (pathlib.Path("mvk.las"), self.folder / "out" / cloud.name, 6280))
        inputs = self.server.jobs["j1"].inputs
        self.assertRegex(inputs.pop("output"), "^[0-9a-f]{32}$")
        self.assertEqual(inputs, {"inputs": ["mvk.las"], "triangulation": "block", "outside": -1, "replace": False, "memory": "1G"})
        (here,) = tessera.hag([cloud], self.folder / "here", ground=ground.folder)
        self.assertEqual(file.output.read_bytes(), here.output.read_bytes())
        self.assertEqual(list(exports.iterdir()), [])
        with self.assertRaisesRegex(tessera.UsageError, "exists already; overwrite=True"):
            self.client.hag("mvk.las", "block", self.folder / "out")
        self.client.hag("mvk.las", "block", self.folder / "out", overwrite=True)
        self.assertEqual(list(exports.iterdir()), [])

    def products(self):
        """A daemon that makes products with the library here."""
        t = self.make_result()
        exports = pathlib.Path(t.folder) / "exports"

        def work(job):
            exports.mkdir(exist_ok=True)
            file = exports / job.inputs["output"]
            file.write_text("cells")
            job.outcome = {**self.told, "written": [{"path": f"exports/{file.name}", "bytes": 5, "xxh3": xxh3(b"cells")}]}
            job.tell("successful", triangulation="block")
        self.server.on_submit = work
        return exports

    def sent(self):
        inputs = list(self.server.jobs.values())[-1].inputs
        self.assertRegex(inputs.pop("output"), "^[0-9a-f]{32}[.][a-z0-9]+$")
        return inputs

    def test_products_arrive_and_are_gone_there(self):
        exports = self.products()
        here = self.folder / "cells.gpkg"
        self.told = {"dimension": 2, "area": 4.5, "cells": 7, "unbounded": 1, "outside": 2, "note": "so it is"}
        with self.assertWarnsRegex(UserWarning, "so it is"):
            told = self.client.voronoi("block", here, (0, 0.5, 1, 2), memory="1G")
        self.assertEqual(told, tessera.VoronoiFile(7, 1, 2, 4.5))
        self.assertEqual(self.sent(), {"triangulation": "block", "clip": "0.0,0.5,1.0,2.0", "memory": "1G"})
        self.assertEqual(here.read_text(), "cells")
        self.assertEqual(list(exports.iterdir()), [])
        with self.assertRaisesRegex(tessera.UsageError, "exists already; overwrite=True"):
            self.client.voronoi("block", here)
        self.told.pop("note")
        (self.folder / "square.geojson").write_text('{"type": "Polygon"}')
        self.client.voronoi("block", here, self.folder / "square.geojson", overwrite=True)
        self.assertEqual(self.sent(), {"triangulation": "block", "clip": '{"type": "Polygon"}'})
        with self.assertRaisesRegex(tessera.UsageError, "clip: a daemon takes polygons as GeoJSON"):
            self.client.voronoi("block", here, "square.gpkg", overwrite=True)
        self.told = {}
        self.client.density("block", self.folder / "grid.npy", res=2, curl=("vx", "vy"), bbox=(0, 0, 1, 1))
        self.assertEqual(self.sent(), {"triangulation": "block", "res": 2.0, "curl": ["vx", "vy"], "sample": False, "bbox": [0, 0, 1, 1]})
        self.client.density("block", self.folder / "grid.h5", grid=64, shear=("vx", "vy"))
        self.assertEqual(self.sent(), {"triangulation": "block", "grid": [64], "shear": ["vx", "vy"], "sample": False})
        self.client.density("block", self.folder / "grid.fits", grid=(64, 32))
        self.assertEqual(self.sent(), {"triangulation": "block", "grid": [64, 32], "sample": False})
        with self.assertRaises(tessera.Error):
            self.client.alpha("block", self.folder / "none.ply")
        self.told = {"radius": 2.5}
        self.assertEqual(self.client.alpha("block", self.folder / "shape.ply", alpha=2.5), 2.5)
        self.assertEqual(self.sent(), {"triangulation": "block", "alpha": 2.5, "general": False})
        self.assertEqual(list(exports.iterdir()), [])

    def test_volumes_are_the_same_table(self):
        self.products()
        row = dict.fromkeys(tessera.VolumeTable._fields[:9], 1.5)
        self.told = {"rows": [{"polygon": 3, "name": "field", **row, "mean": None}], "area_unit": "metre^2", "volume_unit": "metre^3"}
        table = self.client.volume("block", self.folder / "volumes.csv", "after", max_edge=5)
        self.assertEqual(self.sent(), {"triangulation": "block", "second": "after", "max_edge": 5})
        self.assertEqual((table.cut[0], table.polygons[0], table.names, table.volume_unit), (1.5, 3, ["field"], "metre^3"))
        self.assertNotEqual(table.mean[0], table.mean[0])
        self.told = {"rows": [{"cut": 1}]}
        with self.assertRaises(tessera.Error):
            self.client.volume("block", self.folder / "volumes.json", plane=1.0)

    def test_info_is_told_at_once_or_by_a_job(self):
        self.server.described = {"points": 3}
        self.assertEqual(self.client.info("a.las", dim=2, stats=True), {"points": 3})
        self.assertIn(b'{"inputs": {"inputs": ["a.las"], "dim": 2, "stats": true}}', self.server.asked("POST", "")[0][3])
        self.server.described = None
        self.end({"points": 4})
        self.assertEqual(self.client.info(["a.las.gz"]), {"points": 4})
        self.make_result()
        self.assertEqual(self.client.info("block"), {"points": 4})
        self.assertEqual(self.server.jobs["j2"].inputs, {"triangulation": "block"})
        self.server.refusals["POST", "/v1/processes/info/execution"] = (422, {"detail": "inputs: x: is not a file", "cause": 4})
        with self.assertRaisesRegex(tessera.IoError, "inputs: x"):
            self.client.info("x")

    def test_uploads_go_on_where_the_connection_ended(self):
        content = os.urandom(3_000_000)
        (self.folder / "a.las").write_bytes(content)
        self.server.cut_uploads_after = [1_000_000, 500_000]
        self.assertEqual(self.client.upload(self.folder / "a.las", "mine"), ["upload:mine/a.las"])
        self.assertEqual(self.server.uploads, {"mine/a.las": content})
        self.assertEqual([put[2].get("Upload-Offset") for put in self.server.asked("PUT", "")], [None, "1000000", "1500000"])

    def test_uploads_that_are_refused(self):
        (self.folder / "a.las").write_bytes(b"x" * 10_000_000)
        with self.assertRaisesRegex(tessera.IoError, "missing.las"):
            self.client.upload(self.folder / "missing.las", "mine")
        self.server.uploads = None
        with self.assertRaisesRegex(tessera.UsageError, "takes no uploads"):
            self.client.upload(self.folder / "a.las", "mine")
        self.server.stop()
        with self.assertRaisesRegex(tessera.IoError, "cannot be reached"):
            self.client.upload(self.folder / "a.las", "mine")
        self.server.start()


del ClientTest  # not again here

if __name__ == "__main__":
    unittest.main()
