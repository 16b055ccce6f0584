"""Runs the real daemon, as a user does, on 127.0.0.1 at free ports. Nothing here has a time limit: what hangs, ctest ends."""
import http.client
import json
import os
import pathlib
import re
import shutil
import signal
import subprocess
import tempfile
import unittest
import urllib.parse

TESSERAD, TESSERA = os.environ["TESSERAD"], os.environ["TESSERA"]
IGN = pathlib.Path(os.environ["IGN"])
ENDED = ("successful", "failed", "dismissed")


class Daemon:
    """One process. `url` and `token` are what it prints. `prefix`: of the command, which it must become."""

    def __init__(self, data, *options, env=None, listen="127.0.0.1:0", inputs=IGN, prefix=()):
        clean = {k: v for k, v in os.environ.items() if not k.startswith("TESSERA")}
        self.log = tempfile.TemporaryFile()
        self.process = subprocess.Popen(
            [*prefix, TESSERAD, "--data", str(data), "--listen", listen, "--metrics", "none", "--inputs", str(inputs),
             "--print-token",
             *(() if "--memory" in options else ("--memory", "1G")), "--threads", "2", *map(str, options)],
            env=clean | (env or {}), text=True, stdout=subprocess.PIPE, stderr=self.log)
        line = self.process.stdout.readline()
        found = re.fullmatch(r"(http://127\.0\.0\.1:\d+/)#token=(\S+)\n", line)
        if not found:
            status = self.process.wait()
            self.process.stdout.close()
            said = self.messages()
            self.log.close()
            raise AssertionError(f"{line!r} status {status} {said}")
        self.url, self.token = found[1], found[2]
        self.port = urllib.parse.urlsplit(self.url).port

    def messages(self):
        self.log.seek(0)
        return self.log.read().decode()

    def request(self, method, path, body=None, headers=None, token=True):
        """Status, headers, body (JSON is read)."""
        connection = http.client.HTTPConnection("127.0.0.1", self.port)
        try:
            head = {"Authorization": f"Bearer {self.token}"} if token else {}
            if body is not None and not isinstance(body, bytes):
                body = json.dumps(body).encode()
                head["Content-Type"] = "application/json"
            connection.request(method, path, body, head | (headers or {}))
            answer = connection.getresponse()
            content = answer.read()
            if "json" in (answer.getheader("Content-Type") or ""):
                content = json.loads(content)
            return answer.status, answer.headers, content
        finally:
            connection.close()

    def events(self, path, last=None):
        """The events of a stream, as (id, kind, data), until it ends."""
        connection = http.client.HTTPConnection("127.0.0.1", self.port)
        head = {"Authorization": f"Bearer {self.token}"} | ({"Last-Event-ID": str(last)} if last is not None else {})
        connection.request("GET", path, headers=head)
        answer = connection.getresponse()
        assert answer.status == 200, answer.read()
        event = {}
        for line in answer:
            line = line.decode().rstrip("\n")
            if line.startswith(":"):
                continue
            if line:
                key, _, value = line.partition(": ")
                event[key] = value
            elif event:
                yield event.get("id"), event.get("event"), json.loads(event["data"]) if "data" in event else None
                event = {}
        connection.close()

    def wait(self, job):
        """Until it has ended, by its events: its last status. A stream may end before, of a watcher that is too slow."""
        while True:
            for _ in self.events(f"/v1/jobs/{job}/events"):
                pass
            status = self.request("GET", f"/v1/jobs/{job}")[2]
            if status["status"] in ENDED:
                return status

    def end(self, how=signal.SIGTERM):
        if self.process.poll() is None:
            self.process.send_signal(how)
        self.process.stdout.close()
        return self.process.wait()


class DaemonTest(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="tesserad-"))
        self.addCleanup(shutil.rmtree, self.folder, True)

    def start(self, *options, **more):
        daemon = Daemon(self.folder / "data", *options, **more)
        self.addCleanup(daemon.log.close)
        self.addCleanup(lambda: daemon.end(signal.SIGKILL) if daemon.process.poll() is None else None)
        return daemon

    def tessera(self, *args):
        done = subprocess.run([TESSERA, *map(str, args)], cwd=self.folder, text=True, stdout=subprocess.PIPE,
                              stderr=subprocess.PIPE)
        self.assertEqual(done.returncode, 0, done.stderr)
        return done.stdout
