"""The curl lines of docs/service.md, typed along."""
import json
import os
import pathlib
import re
import subprocess
import unittest

from daemon import DaemonTest

GUIDE = pathlib.Path(os.environ["SERVICE_GUIDE"]).read_text()


class Guide(DaemonTest):
    def test_every_line_of_the_guide_works(self):
        daemon = self.start()
        lines = [line for block in re.findall(r"```sh\n(.*?)```", GUIDE, re.S) for line in block.splitlines()]
        self.assertGreater(len(lines), 15)
        environment = os.environ | {"URL": daemon.url.rstrip("/"), "TOKEN": daemon.token}
        curl = 'curl() { command curl -sS --fail-with-body --max-time 120 -H "Authorization: Bearer $TOKEN" "$@"; }\n'
        for line in lines:
            self.assertTrue(line.startswith("curl "), line)
            if line.startswith("curl -X DELETE $URL/v1/jobs/"):
                # Verifying goes before: it is forgotten once it has ended.
                self.assertEqual(daemon.wait(environment["JOB"])["status"], "successful")
            done = subprocess.run(["bash", "-c", curl + line], env=environment, stdout=subprocess.PIPE,
                                  stderr=subprocess.PIPE, timeout=150)
            said = done.stdout.decode()
            self.assertEqual(done.returncode, 0, f"{line}\n{said}\n{done.stderr.decode()}")
            if "Idempotency-Key" in line:
                self.assertIn("201", said.splitlines()[0])
                environment["JOB"] = json.loads(said.split("\r\n\r\n", 1)[1])["jobID"]
            if "/events" in line:
                self.assertIn("successful", said)
        self.assertEqual(daemon.end(), 0, daemon.messages())

    def test_every_route_is_in_the_guide(self):
        daemon = self.start()
        paths = daemon.request("GET", "/v1/api")[2]["paths"]
        self.assertEqual(daemon.end(), 0)
        self.assertGreater(len(paths), 15)
        # Names in the guide stand for what the documents have in braces.
        words = set(re.findall(r"(?:\$URL|`)(/[\w$./*-]*)", GUIDE))
        places = [word.rstrip("/").split("/") for word in words]

        def fits(path):
            parts = path.rstrip("/").split("/")
            return any(len(place) == len(parts) and all(a == b or b.startswith("{") for a, b in zip(place, parts))
                       for place in places)
        self.assertEqual([path for path in paths if path != "/" and not fits(path)], [])


if __name__ == "__main__":
    unittest.main()
