"""Inputs by their addresses in Python: https:// and s3://, with the options of the command."""
import json
import os
import pathlib
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import unittest
from unittest import mock

import numpy as np
import tessera

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "apps"))
from object_server import ObjectServer  # noqa: E402
from s3_server import S3Server  # noqa: E402

CLOUDS = pathlib.Path(__file__).resolve().parents[1] / "data" / "clouds"
FILES = sorted(CLOUDS.glob("ign_770*_6277*.laz"))[:2]
COPC = CLOUDS / "lone_star_part.copc.laz"
KEYS = {"AKIDEXAMPLE": "wJalrXUtnFEMI/K7MDENG+bPxRfiCYEXAMPLEKEY"}
ME = {"AWS_ACCESS_KEY_ID": "AKIDEXAMPLE", "AWS_SECRET_ACCESS_KEY": KEYS["AKIDEXAMPLE"], "AWS_EC2_METADATA_DISABLED": "true"}


class Remote(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="tessera-python-"))
        self.addCleanup(shutil.rmtree, self.folder)
        clean = {name: value for name, value in os.environ.items() if not name.startswith("AWS_")} | {"HOME": str(self.folder)}
        self.enterContext(mock.patch.dict(os.environ, clean, clear=True))

    def serve(self, *files):
        return self.enterContext(ObjectServer({file.name: file.read_bytes() for file in files}))

    def bucket(self, **more):
        return self.enterContext(S3Server({f"clouds/block/{file.name}": file.read_bytes() for file in FILES}, KEYS, **more))

    def test_addresses_are_the_files(self):
        server = self.serve(*FILES, COPC)
        near = tessera.triangulate(FILES, dim=2, classes=[2])
        far = tessera.triangulate([server.url(file.name) for file in FILES], dim=2, classes=[2])
        self.assertEqual(far.digest, near.digest)
        self.assertEqual(tessera.info(server.url(COPC.name))["points"], tessera.info(COPC)["points"])
        (x0, y0), (x1, y1) = (tessera.info(COPC)["files"][0]["bounds"][end][:2] for end in ("min", "max"))
        x, y = (x0 + x1) / 2, (y0 + y1) / 2
        regions = [tessera.region(cloud, [x, y, x + 1, y + 1], dim=2) for cloud in (COPC, server.url(COPC.name))]
        self.assertEqual(regions[0].n_cells, regions[1].n_cells)
        (self.folder / "list.txt").write_text("".join(server.url(file.name) + "\n" for file in FILES))
        self.assertEqual(tessera.triangulate(input_list=self.folder / "list.txt", dim=2, classes=[2]).digest, near.digest)

    def test_functions_without_such_options_read_addresses_too(self):
        server = self.serve(*FILES)
        near = tessera.hag(FILES[0], self.folder / "near")
        far = tessera.hag(server.url(FILES[0].name), self.folder / "far")
        self.assertEqual(far[0].output.read_bytes(), near[0].output.read_bytes())

    def test_s3_has_the_options_of_the_command(self):
        server = self.bucket(public={"clouds"})
        near = tessera.triangulate(FILES, dim=2)
        self.assertEqual(tessera.triangulate("s3://clouds/block/", dim=2, endpoint=server.address, anonymous=True).digest, near.digest)
        self.assertEqual(set(server.payers), {None})
        server.payers.clear()
        tessera.info("s3://clouds/block/" + FILES[0].name, endpoint=server.address, anonymous=True, requester_pays=True)
        self.assertEqual(set(server.payers), {"requester"})
        with self.assertRaisesRegex(tessera.UsageError, "no credentials.*anonymous=True"):
            tessera.info("s3://clouds/block/", endpoint=server.address)
        with self.assertRaisesRegex(tessera.UsageError, "profile: neither .* has a profile 'nobody'"):
            tessera.info("s3://clouds/block/", endpoint=server.address, profile="nobody")
        (self.folder / ".aws").mkdir()
        (self.folder / ".aws" / "credentials").write_text(
            f"[work]\naws_access_key_id={ME['AWS_ACCESS_KEY_ID']}\naws_secret_access_key={ME['AWS_SECRET_ACCESS_KEY']}\n")
        server.public.clear()
        self.assertEqual(tessera.triangulate("s3://clouds/block/", dim=2, endpoint=server.address, profile="work").digest, near.digest)

    def test_the_environment_counts_as_it_is_when_called(self):
        server = self.bucket()
        with self.assertRaises(tessera.UsageError):
            tessera.info("s3://clouds/block/", endpoint=server.address)
        os.environ |= ME | {"AWS_ENDPOINT_URL": server.address}
        self.assertGreater(tessera.info("s3://clouds/block/")["points"], 0)
        os.environ["AWS_SECRET_ACCESS_KEY"] = "other"
        with self.assertRaisesRegex(tessera.IoError, "SignatureDoesNotMatch"):
            tessera.info("s3://clouds/block/")

    def test_calls_with_different_options_at_once_do_not_mix(self):
        servers = [self.bucket(public={"clouds"}) for _ in range(4)]
        for server in servers:
            server.delay_s = 0.01
        failed = []

        def read(server):
            try:
                for _ in range(5):
                    tessera.info("s3://clouds/block/", endpoint=server.address, anonymous=True)
            except tessera.Error as error:
                failed.append(error)

        threads = [threading.Thread(target=read, args=(server,)) for server in servers]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        self.assertEqual(failed, [])
        self.assertEqual(len({len(server.requests) for server in servers}), 1)

    def test_what_is_wrong_is_a_sentence(self):
        server = self.serve(FILES[0])
        for name, error, says in ((server.url("none.laz"), tessera.IoError, "404"), ("ftp://host/a.las", tessera.UsageError, "not by ftp://"),
                                  ("https://me:secret@host/a.las", tessera.UsageError, "user name")):
            with self.assertRaisesRegex(error, says) as told:
                tessera.triangulate(name)
            self.assertNotIn("secret", str(told.exception))

    def test_results_in_stores_are_read_and_not_changed(self):
        out = pathlib.Path(self.enterContext(tempfile.TemporaryDirectory())) / "out"
        here = tessera.triangulate(np.random.default_rng(1).random((3000, 3)), folder=out, max_points_per_tile=1000)
        server = self.enterContext(ObjectServer({f"maps/r/{path.relative_to(out).as_posix()}": path.read_bytes() for path in out.rglob("*") if path.is_file()}))
        far = tessera.open(server.url("maps/r"))
        self.assertEqual((far.n_cells, len(far), far.verify().cells), (here.n_cells, len(here), here.n_cells))
        self.assertTrue(np.array_equal(far[0].points, here[0].points))
        self.assertEqual(far.locate([[.5, .5, .5]]).vertices.tolist(), here.locate([[.5, .5, .5]]).vertices.tolist())
        with self.assertRaisesRegex(tessera.UsageError, "a result in an object store cannot be changed there"):
            far.measure(volume=True)

    def test_a_forked_child_reads_for_itself(self):
        server = self.serve(*FILES)
        expected = tessera.info(server.url(FILES[0].name))["points"]
        child = os.fork()
        if child == 0:
            os._exit(0 if tessera.info(server.url(FILES[0].name))["points"] == expected else 1)
        self.assertEqual(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]), 0)
        self.assertEqual(tessera.info(server.url(FILES[0].name))["points"], expected)

    def test_ctrl_c_ends_a_call_that_waits_for_a_server(self):
        server, asked, over = self.serve(COPC), threading.Event(), threading.Event()
        self.addCleanup(over.set)

        def silent(request, answer):
            asked.set()
            over.wait()

        server.fault = silent
        process = subprocess.Popen([sys.executable, "-c", f"import tessera; tessera.triangulate({server.url(COPC.name)!r})"], stderr=subprocess.PIPE)
        self.assertTrue(asked.wait(60))
        process.send_signal(signal.SIGINT)
        said = process.communicate(timeout=60)[1].decode()
        over.set()
        self.assertIn("KeyboardInterrupt", said)

    def test_a_program_that_only_imports_loads_no_libcurl(self):
        said = subprocess.run([sys.executable, "-c", "import json, tessera; t = tessera.triangulate([[0, 0], [1, 0], [0, 1]]); "
                                                     "print(json.dumps('libcurl' in open('/proc/self/maps').read()))"], check=True, capture_output=True, text=True)
        self.assertFalse(json.loads(said.stdout))


if __name__ == "__main__":
    unittest.main()
