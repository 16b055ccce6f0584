"""A command that asks a daemon, which does what the test says."""
import pathlib
import sys

from cli import OK, CliTest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "client"))
from fake_server import FakeServer  # noqa: E402


class ServerTest(CliTest):
    def setUp(self):
        super().setUp()
        self.server = FakeServer(token="secret-token")
        self.addCleanup(lambda: self.server.stop())
        self.asking = {"TESSERA_SERVER": self.server.url, "TESSERA_TOKEN": "secret-token"}

    def run_tessera(self, *args, env=None, **more):
        return super().run_tessera(*args, env=getattr(self, "asking", {}) | (env or {}), **more)

    def local(self, *args):
        return super().run_tessera(*args)

    def make_result(self, name="block", **more):
        out = self.folder / f"made-{name}"
        done = CliTest.run_tessera(self, "triangulate", self.xyz(f"{name}.xyz", **more), "-o", out, "--tiles", 4)
        self.assertEqual(done.returncode, OK, done.stderr)
        self.server.results[name] = out
        return done.stdout

    def succeed(self, job):
        job.tell("running", phase="triangulating", points=2000, started="2026-01-02T03:04:05Z",
                 tiles={"total": 4, "triangulated": 2, "asleep": 0, "stored": 0})
        job.tell(kind="log", text="half of it is done")
        job.tell("successful", triangulation="block", progress=100)
