"""The jobs of a daemon: listed, told, stopped, gone on with."""
import unittest

from cli import IO, USAGE
from cli_server import ServerTest


class Jobs(ServerTest):
    def test_they_are_listed_over_all_pages(self):
        self.assertEqual(self.ok("jobs"), "there are no jobs\n")
        for i in range(7):
            self.server.add_job(f"j{i}", status="running" if i % 2 else "accepted", phase="splaying")
        self.server.page = 3
        lines = self.ok("jobs").splitlines()
        self.assertRegex(lines[0], "^JOB +STATUS")
        self.assertEqual([line.split()[0] for line in lines[1:]], [f"j{i}" for i in range(7)])
        self.assertIn("joining tiles", lines[2])
        self.assertEqual([job["id"] for job in self.json_lines(self.ok("jobs", "--json", "--limit", 5))],
                         [f"j{i}" for i in range(5)])
        self.assertEqual([job["status"] for job in self.json_lines(self.ok("jobs", "--json", "--status", "running"))],
                         ["running"] * 3)
        self.refused(USAGE, "jobs", "--limit", 0, says="--limit")

    def test_one_is_told(self):
        self.server.add_job("a b/c", status="failed", problem={"detail": "no space", "cause": IO}, resumable=True, starts=2,
                            started="2026-01-02T03:04:06Z")
        text = self.ok("job", "a b/c")
        for part in ("failed, 0 %, can be resumed", "problem       no space", "start number 2"):
            self.assertIn(part, text)
        (line,) = self.json_lines(self.ok("job", "a b/c", "--json"))
        self.assertEqual((line["problem"], line["starts"]), ({"detail": "no space", "cause": IO}, 2))
        self.assertTrue(self.server.asked("GET", "^/v1/jobs/a%20b%2Fc$"))
        self.refused(USAGE, "job", says="tessera jobs")
        self.refused(USAGE, "job", "x", says="there is no job x")

    def test_cancel_stops_what_runs_and_forgets_nothing(self):
        job = self.server.add_job("j1", status="running")
        self.assertEqual(self.ok("cancel", "j1"), "job j1 is cancelled; 'tessera resume j1' continues it\n")
        self.assertEqual(job.fields["status"], "dismissed")
        self.refused(USAGE, "cancel", "j1", says="has ended already: dismissed")
        self.assertEqual(len(self.server.asked("DELETE", "")), 1)

    def test_resume_goes_on_and_watches(self):
        self.make_result()
        self.server.on_submit = self.succeed
        self.server.add_job("j1", status="failed", resumable=True)
        self.assertIn("tetrahedra", self.ok("resume", "j1"))
        self.refused(USAGE, "resume", "j1", says="cannot be resumed")
        self.server.add_job("j2", status="dismissed", resumable=True)
        self.server.on_submit = lambda job: None
        self.assertIn("job j2 is running", self.ok("resume", "j2", "--detach"))


if __name__ == "__main__":
    unittest.main()
