"""TLS: the same answers, and a new certificate without a restart."""

import hashlib
import http.client
import pathlib
import socket
import ssl
import subprocess
import tempfile
import unittest
import warnings

import serving

SIZE = 3_000_001


def make_certificate(folder):
    subprocess.run(["openssl", "req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:prime256v1", "-nodes",
                    "-days", "2", "-subj", "/CN=localhost", "-addext", "subjectAltName=DNS:localhost,IP:127.0.0.1",
                    "-keyout", str(folder / "key.pem"), "-out", str(folder / "cert.pem")], check=True, capture_output=True)


class Tls(serving.ServerTest):
    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        cls.folder = pathlib.Path(folder.name)
        make_certificate(cls.folder)
        cls.options = {"certificate": cls.folder / "cert.pem", "key": cls.folder / "key.pem", "file_bytes": SIZE,
                       "address": "0.0.0.0"}
        super().setUpClass()

    def context(self):
        return ssl.create_default_context(cafile=str(self.folder / "cert.pem"))

    def get(self, path, **headers):
        connection = http.client.HTTPSConnection("127.0.0.1", self.server.port, timeout=30, context=self.context())
        headers = {"Authorization": "Bearer " + self.server.tokens["read"], **headers}
        connection.request("GET", path, headers=headers)
        answer = serving.Answer(connection.getresponse())
        connection.close()
        return answer

    def test_answers_and_files(self):
        self.assertEqual(self.get("/v1").json()["title"], "Tessera")
        answer = self.get("/v1/triangulations/block/files/deep/tile.vtu")
        content = (bytes(range(251)) * (SIZE // 251 + 1))[:SIZE]
        self.assertEqual(hashlib.sha256(answer.body).digest(), hashlib.sha256(content).digest())
        part = self.get("/v1/triangulations/block/files/deep/tile.vtu", Range="bytes=2000000-2999999")
        self.assertEqual(part.body, content[2_000_000:3_000_000])

    def test_the_cookie_is_for_tls_alone(self):
        connection = http.client.HTTPSConnection("127.0.0.1", self.server.port, timeout=30, context=self.context())
        connection.request("POST", "/v1/session", headers={"Authorization": "Bearer " + self.server.tokens["read"]})
        self.assertIn("; Secure", connection.getresponse().headers["Set-Cookie"])
        connection.close()

    def test_browsers_are_told_to_come_no_other_way(self):
        self.assertEqual(self.get("/v1").headers["Strict-Transport-Security"], "max-age=31536000")
        # That name is all programs' of the user's own machine.
        self.assertIsNone(self.get("/v1", Host="localhost").headers["Strict-Transport-Security"])

    def test_a_key_that_others_can_read_is_refused(self):
        for rights, status in ((0o644, 2), (0o604, 2), (0o640, 2), (0o400, 0), (0o600, 0)):
            (self.folder / "key.pem").chmod(rights)
            server = serving.Server(certificate=self.folder / "cert.pem", key=self.folder / "key.pem")
            self.assertEqual("others can read it" in server.started.get("error", ""), status == 2, rights)
            self.assertEqual(server.close(), status)

    def test_old_versions_and_plain_text_are_refused(self):
        with socket.create_connection(("127.0.0.1", self.server.port), 30) as plain:
            plain.sendall(b"GET /v1 HTTP/1.1\r\nHost: localhost\r\n\r\n")
            try:
                self.assertNotIn(b"HTTP/1.1", plain.recv(1000))
            except ConnectionError:
                pass
        context = self.context()
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", DeprecationWarning)
            context.minimum_version, context.maximum_version = ssl.TLSVersion.TLSv1, ssl.TLSVersion.TLSv1_1
        with socket.create_connection(("127.0.0.1", self.server.port), 30) as connection:
            with self.assertRaises((ssl.SSLError, ConnectionError)):
                context.wrap_socket(connection, server_hostname="localhost")

    def test_a_new_certificate_is_taken_and_a_broken_one_is_not(self):
        before = ssl.get_server_certificate(("127.0.0.1", self.server.port))
        make_certificate(self.folder)
        self.assertTrue(self.server.tell("reload"))
        after = ssl.get_server_certificate(("127.0.0.1", self.server.port))
        self.assertNotEqual(before, after)
        good = (self.folder / "cert.pem").read_text()
        (self.folder / "cert.pem").write_text("nothing")
        self.assertFalse(self.server.tell("reload"))
        (self.folder / "cert.pem").write_text(good)
        self.assertEqual(self.get("/v1").status, 200)


if __name__ == "__main__":
    unittest.main()
