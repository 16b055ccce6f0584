"""The test server, and connections to it."""

import http.client
import json
import os
import pathlib
import shutil
import socket
import subprocess
import tempfile
import unittest

import jsonschema


class Server:
    """A server of its own, with tokens of every role; options as of server_main.cc."""

    def __init__(self, environment=None, **options):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="tessera-http-"))
        self.tokens = {role: role[0] * 40 for role in ("read", "submit", "admin")}
        file = self.folder / "tokens"
        file.touch(0o600)
        file.write_text("".join(f"{role}er {role} {token}\n" for role, token in self.tokens.items()))
        self.command = [os.environ["SERVER"], str(self.folder), *(f"{name}={value}" for name, value in options.items())]
        self.environment = os.environ | (environment or {})
        self.begin()

    def begin(self):
        with open(self.folder / "log", "a") as log:
            self.process = subprocess.Popen(self.command, env=self.environment, stdin=subprocess.PIPE,
                                            stdout=subprocess.PIPE, stderr=log, text=True)
        self.started = json.loads(self.process.stdout.readline())
        self.port, self.operations = self.started.get("ports", (0, 0))

    def tell(self, command):
        self.process.stdin.write(command + "\n")
        self.process.stdin.flush()
        return self.process.stdout.readline() == "ok\n"

    def log(self):
        return (self.folder / "log").read_text()

    def memory(self):
        """Resident, in bytes."""
        return int(pathlib.Path(f"/proc/{self.process.pid}/statm").read_text().split()[1]) * 4096

    def descriptors(self):
        return len(os.listdir(f"/proc/{self.process.pid}/fd"))

    def end(self):
        self.process.stdin.close()
        self.process.stdout.close()
        return self.process.wait(60)

    def restart(self):
        status = self.end()
        self.begin()
        return status

    def close(self):
        status = self.end()
        shutil.rmtree(self.folder)
        return status


def of_draft_4(schema):
    """OpenAPI's word for what may be null, as JSON schema says it."""
    if isinstance(schema, list):
        return [of_draft_4(part) for part in schema]
    if not isinstance(schema, dict):
        return schema
    told = {key: of_draft_4(part) for key, part in schema.items()}
    return told | {"type": [told["type"], "null"]} if told.get("nullable") is True else told


class Answer:
    def __init__(self, response):
        self.status = response.status
        self.headers = response.headers
        self.body = response.read()

    def json(self):
        return json.loads(self.body)


class ServerTest(unittest.TestCase):
    options = {}
    environment = {}

    @classmethod
    def setUpClass(cls):
        cls.server = Server(cls.environment, **cls.options)
        cls.addClassCleanup(cls.stop)
        cls.document = None

    @classmethod
    def stop(cls):
        status = cls.server.close()
        if status != 0:
            raise AssertionError(f"the server ended with {status}")

    def connect(self):
        connection = http.client.HTTPConnection("127.0.0.1", self.server.port, timeout=30)
        self.addCleanup(connection.close)
        return connection

    def ask(self, method, path, body=None, token="admin", port=None, headers=()):
        connection = http.client.HTTPConnection("127.0.0.1", port or self.server.port, timeout=30)
        sent = dict(headers)
        if token:
            sent["Authorization"] = "Bearer " + self.server.tokens.get(token, token)
        if body is not None and not isinstance(body, (str, bytes)):
            body = json.dumps(body)
            sent.setdefault("Content-Type", "application/json")
        connection.request(method, path, body, sent)
        answer = Answer(connection.getresponse())
        connection.close()
        return answer

    def raw(self, data, timeout=30):
        """What comes back for these bytes until the server closes."""
        with socket.create_connection(("127.0.0.1", self.server.port), timeout) as connection:
            try:
                connection.sendall(data)
                got = b""
                while piece := connection.recv(65536):
                    got += piece
            except ConnectionError:
                pass
            return got

    def head(self, method, target, more="", token="admin"):
        return (f"{method} {target} HTTP/1.1\r\nHost: localhost\r\n"
                f"Authorization: Bearer {self.server.tokens[token]}\r\n{more}\r\n").encode()

    def submit(self, **inputs):
        answer = self.ask("POST", "/v1/processes/triangulate/execution", {"inputs": {"inputs": ["a.las"], **inputs}})
        self.assertEqual(answer.status, 201, answer.body)
        return answer.json()["jobID"]

    def api(self):
        if type(self).document is None:
            type(self).document = self.ask("GET", "/v1/api").json()
        return self.document

    def check(self, answer, path, method):
        """The answer is what the document says of that route."""
        operation = self.api()["paths"][path][method.lower()]
        told = operation["responses"].get(str(answer.status))
        kind = (answer.headers["Content-Type"] or "").split(";")[0]
        if answer.status >= 400 and not told:
            self.assertEqual(kind, "application/problem+json")
            return self.validate(answer.json(), {"$ref": "#/components/schemas/Problem"})
        self.assertIsNotNone(told, f"{method} {path}: {answer.status}")
        content = {name.split(";")[0]: value for name, value in told.get("content", {}).items()}
        if not content:
            return self.assertEqual(answer.body, b"")
        if "$ref" in content.get(kind, {}).get("schema", {}):
            self.validate(answer.json(), content[kind]["schema"])

    def validate(self, value, schema):
        jsonschema.Draft4Validator(of_draft_4({**schema, "components": self.api()["components"]})).validate(value)
