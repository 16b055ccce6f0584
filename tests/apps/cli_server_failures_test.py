"""A daemon that refuses, is not there, is not trusted, or is none."""
import socket
import subprocess
import threading
import unittest

from cli import BAD_INPUT, INTERNAL, IO, MEMORY, USAGE
from cli_server import ServerTest
from fake_server import FakeServer


class Failures(ServerTest):
    def test_the_cause_of_the_problem_is_the_exit_status(self):
        for cause in (USAGE, BAD_INPUT, IO, MEMORY, INTERNAL):
            problem = {"detail": f"memory: too small for {cause}", "cause": cause, "status": 422}
            self.server.on_submit = lambda job: (job.tell("running"), job.tell("failed", problem=problem))
            self.refused(cause, "triangulate", "a", "-o", "x", says=f"tessera: memory: too small for {cause}")

    def test_options_in_a_sentence_are_called_as_in_the_command(self):
        problem = {"detail": "two systems: say with crs what all are in, or overwrite: true", "cause": BAD_INPUT, "status": 422,
                   "marked": "two systems: say with \0crs\x01 what all are in, or \0overwrite=true\x01"}
        says = "two systems: say with --crs what all are in, or --overwrite"
        self.server.on_submit = lambda job: (job.tell("running"), job.tell("failed", problem=problem))
        self.refused(BAD_INPUT, "triangulate", "a", "-o", "x", says=says)
        self.server.refusals["POST", "/v1/processes/triangulate/execution"] = (422, problem)
        self.refused(BAD_INPUT, "triangulate", "a", "-o", "x", says=says)

    def test_a_refused_job_says_why(self):
        path = "/v1/processes/triangulate/execution"
        self.server.refusals["POST", path] = (422, {"detail": "memory: 1 GiB is too little, 5 GiB are needed", "cause": MEMORY})
        self.refused(MEMORY, "triangulate", "a", "-o", "x", says="memory: 1 GiB is too little, 5 GiB are needed")
        self.server.refusals["POST", path] = (429, {"detail": "10000 jobs wait already"})
        self.refused(IO, "triangulate", "a", "-o", "x", says="10000 jobs wait already")

    def test_nobody_is_there(self):
        with socket.socket() as nobody:
            nobody.bind(("127.0.0.1", 0))
            url = f"http://127.0.0.1:{nobody.getsockname()[1]}"
            self.refused(IO, "jobs", "--server", url, says=[url, "no server can be reached there: Connection refused"])

    def test_a_wrong_token_and_none(self):
        self.refused(USAGE, "jobs", env={"TESSERA_TOKEN": "wrong"}, says=["does not know this token", "--token-file"])
        self.refused(USAGE, "jobs", env={"TESSERA_TOKEN": ""}, says=["needs a token", "TESSERA_TOKEN"])
        self.refused(USAGE, "jobs", env={"TESSERA_TOKEN": "a\nb: c"}, says="token")
        self.assertTrue(all("\n" not in request[2].get("Authorization", "") for request in self.server.requests))

    def test_the_token_comes_from_a_file_or_the_address_too(self):
        token = self.write("token", "secret-token\n")
        self.ok("jobs", "--token-file", token, env={"TESSERA_TOKEN": "wrong"})
        self.ok("jobs", "--server", self.server.url + "/?token=secret-token", env={"TESSERA_TOKEN": ""})
        self.refused(IO, "jobs", "--token-file", "nowhere", says="nowhere")
        self.refused(USAGE, "jobs", "--token-file", self.write("empty", "\n"), says="holds no token")

    def test_an_address_that_is_none(self):
        for url in ("localhost:7070", "ftp://x/", "http://host:0"):
            self.refused(USAGE, "jobs", "--server", url, says="--server: ")
        self.refused(USAGE, "jobs", env={"TESSERA_SERVER": ""}, says=["no daemon is named", "TESSERA_SERVER"])

    def test_something_else_answers(self):
        for foreign in ((200, "text/html", b"<html>"), (404, "text/html", b"no"), (200, "application/json", b"[1, 2]"),
                        (200, "application/json", b"{"), (500, "application/json", b"\xff")):
            self.server.foreign = foreign
            self.refused(USAGE, "jobs", says=[self.server.url, "not a Tessera server"])
            self.refused(USAGE, "watch", "j1", says="not a Tessera server")

    def test_what_answers_speaks_no_http(self):
        with socket.create_server(("127.0.0.1", 0)) as listener:
            def greet():
                connection, _ = listener.accept()
                with connection:
                    connection.sendall(b"SSH-2.0-OpenSSH_9.2\r\n")
                    connection.recv(10000)
            thread = threading.Thread(target=greet)
            thread.start()
            url = f"http://127.0.0.1:{listener.getsockname()[1]}"
            self.refused(USAGE, "jobs", "--server", url, says="the server does not speak HTTP")
            thread.join()

    def test_a_field_that_no_message_has_is_passed_over(self):
        self.server.add_job("j1")
        self.assertIn("j1", self.ok("jobs"))


class Tls(ServerTest):
    def setUp(self):
        super().setUp()
        for name, subject in (("good", "IP:127.0.0.1"), ("other", "DNS:other.example")):
            subprocess.run(["openssl", "req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:P-256", "-nodes", "-days",
                            "2", "-subj", "/CN=x", "-addext", f"subjectAltName={subject}", "-keyout", self.folder / f"{name}.key",
                            "-out", self.folder / f"{name}.crt"], check=True, capture_output=True)
            self.write(f"{name}.pem", (self.folder / f"{name}.crt").read_bytes() + (self.folder / f"{name}.key").read_bytes())

    def serve(self, name):
        server = FakeServer(certificate=self.folder / f"{name}.pem")
        self.addCleanup(server.stop)
        return server

    def test_a_trusted_certificate_is_taken_and_others_are_not(self):
        server = self.serve("good")
        server.add_job("j1")
        self.assertIn("j1", self.ok("jobs", "--server", server.url, "--ca", self.folder / "good.crt"))
        count = len(server.requests)
        self.refused(USAGE, "jobs", "--server", server.url, says=["certificate", "not trusted", "--ca"])
        self.refused(USAGE, "jobs", "--server", server.url, "--ca", self.folder / "other.crt", says="not trusted")
        self.refused(IO, "jobs", "--server", server.url, "--ca", self.write("no.pem", "x"), says="no.pem")
        other = self.serve("other")
        self.refused(USAGE, "jobs", "--server", other.url, "--ca", self.folder / "other.crt", says="not trusted")
        self.assertEqual((len(server.requests), len(other.requests)), (count, 0), "no token was sent there")

    def test_tls_and_none_are_told_apart(self):
        self.refused(USAGE, "jobs", "--server", self.server.url.replace("http", "https"), says="the server does not speak TLS")


if __name__ == "__main__":
    unittest.main()
