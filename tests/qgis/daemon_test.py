"""A daemon's jobs in QGIS: lists, a triangulation by the daemon, waiting, cancelling, resuming, fetching."""
import os
import pathlib
import tempfile

import algorithms_test
from algorithms_test import setUpModule  # noqa: F401 unittest calls it
from daemon import IGN, DaemonTest


class Daemon(DaemonTest):
    def run_one(self, name, context=None, **parameters):
        return algorithms_test.InQgis.run_one(name, context=context, SERVER=f"{self.daemon.url}#token={self.daemon.token}", **parameters)

    def rows(self, name, **parameters):
        import processing
        told = processing.run(f"tessera:{name}", parameters | {"SERVER": f"{self.daemon.url}#token={self.daemon.token}", "OUTPUT": "memory:"})
        found = [{field.name(): row[field.name()] for field in told["OUTPUT"].fields()} for row in told["OUTPUT"].getFeatures()]
        self.assertEqual(len(found), told["COUNT"])
        return found

    def test_a_daemon_works_for_qgis(self):
        self.daemon = self.start("--uploads")
        self.assertEqual(self.rows("jobs"), [])
        self.assertEqual({row["name"] for row in self.rows("inputs")}, {path.name for path in IGN.iterdir() if path.suffix == ".las"})
        self.assertEqual(self.run_one("triangulate", NAMES="*.las", NAME="ground", DIM="2", CLASS="2", OUTPUT="TEMPORARY_OUTPUT")["OUTPUT"], "ground")
        self.assertEqual([row["name"] for row in self.rows("results")], ["ground"])
        (job,) = self.rows("jobs", STATUS="successful")
        self.assertEqual((job["process"], job["result"]), ("triangulate", "ground"))
        self.assertEqual(self.run_one("watch", JOB=job["id"])["STATUS"], "successful")
        folder = pathlib.Path(self.enterContext(tempfile.TemporaryDirectory()))
        self.run_one("dem", RESULT="ground", RES=1, OUTPUT=str(folder / "dem.tif"))
        self.assertEqual(sorted(path.name for path in folder.iterdir()), ["dem.qml", "dem.tif"])
        self.run_one("fetch", RESULT="ground", OUTPUT=str(folder / "ground"))
        self.tessera("verify", folder / "ground")
        self.assertEqual(self.daemon.end(), 0, self.daemon.messages())

    def test_files_are_sent_and_jobs_are_cancelled_and_resumed(self):
        self.daemon = self.start("--uploads")
        names = self.run_one("upload", FILES=[str(IGN / "ign_77050_627755.las")], NAME="mine")["NAMES"]
        self.assertEqual(names, "upload:mine")
        # The last of several waits for the others.
        jobs = [self.run_one("triangulate", NAMES=names, NAME=f"r{i}", DETACH=True, OUTPUT="TEMPORARY_OUTPUT")["JOB"] for i in range(4)]
        self.run_one("cancel", JOB=jobs[-1])
        self.assertEqual({row["id"]: row["status"] for row in self.rows("jobs")}[jobs[-1]], "dismissed")
        self.assertEqual(self.run_one("resume", JOB=jobs[-1])["STATUS"], "successful")
        self.assertEqual(self.run_one("watch", JOB=jobs[0])["STATUS"], "successful")
        self.assertEqual({row["name"] for row in self.rows("results")}, {"r0", "r1", "r2", "r3"})
        self.assertEqual(self.daemon.end(), 0, self.daemon.messages())
