"""Nobody gets in who does not belong: every route of the document, and every way around."""

import base64
import http.client
import re
import unittest
import urllib.parse

import serving

RANK = {"none": 0, "read": 1, "submit": 2, "admin": 3}


class Security(serving.ServerTest):
    def routes(self):
        for path, operations in self.api()["paths"].items():
            for method, operation in operations.items():
                yield method.upper(), re.sub(r"\{\w+\}", "x", path), operation["x-role"]

    def test_every_route_without_with_a_wrong_and_with_a_weak_token(self):
        seen = 0
        for method, path, role in self.routes():
            if role == "none":
                self.assertIn(path, ("/livez", "/readyz", "/metrics", "/ui", "/ui/x"))
                continue
            seen += 1
            body = b"{}" if method in ("PUT", "POST") else None
            with self.subTest(f"{method} {path}"):
                answer = self.ask(method, path, body, token=None)
                self.assertEqual(answer.status, 401)
                self.assertTrue(answer.headers["WWW-Authenticate"].startswith("Bearer"))
                # Too many of them, and the address has to wait.
                self.assertIn(self.ask(method, path, body, token="x" * 40).status, (401, 429))
                for weak, rank in RANK.items():
                    if 0 < rank < RANK[role]:
                        self.assertEqual(self.ask(method, path, body, token=weak).status, 403)
                if not path.endswith("events"):
                    self.assertNotIn(self.ask(method, path, body, token=role).status, (401, 403))
        self.assertGreater(seen, 20)

    def test_the_dashboard_is_the_same_for_everybody_and_runs_only_what_is_its_own(self):
        for path in ("/ui/", "/ui/app.js", "/ui/style.css", "/ui/icon.svg"):
            stranger, admin = self.ask("GET", path, token=None), self.ask("GET", path)
            self.assertEqual((stranger.status, stranger.body, stranger.headers["ETag"]), (200, admin.body, admin.headers["ETag"]))
            policy = stranger.headers["Content-Security-Policy"]
            self.assertEqual(stranger.headers.get_all("Content-Security-Policy"), [policy])
            self.assertIn("default-src 'self'", policy)
            self.assertNotIn("unsafe", policy)
            self.assertNotIn("http", policy)
            again = self.ask("GET", path, token=None, headers={"If-None-Match": stranger.headers["ETag"]})
            self.assertEqual((again.status, again.body), (304, b""))
        page = self.ask("GET", "/ui/", token=None).body.decode()
        self.assertNotRegex(page, r"<script(?![^>]* src=)|<style| style=| on\w+=")
        moved = self.ask("GET", "/ui", token=None)
        self.assertEqual((moved.status, moved.headers["Location"]), (303, "ui/"))
        self.assertEqual(self.ask("GET", "/ui/none", token=None).status, 404)
        for token in (None, "read", "x" * 40):
            answer = self.ask("GET", "/", token=token, headers={"Accept": "text/html"})
            self.assertEqual((answer.status, answer.headers["Location"]), (303, "ui/"))

    def test_a_token_as_password_reads_and_no_more(self):
        def ask(method, path, pair, body=None):
            code = base64.b64encode(pair.encode()).decode()
            return self.ask(method, path, body, token=None, headers={"Authorization": f"Basic {code}"})
        for role in ("read", "submit", "admin"):
            token = self.server.tokens[role]
            for name in ("", "anybody", "tessera"):
                self.assertEqual(ask("GET", "/v1/caller", f"{name}:{token}").json(), {"name": role + "er", "role": "read"})
            submitted = ask("POST", "/v1/processes/triangulate/execution", f"x:{token}", {"inputs": {"inputs": ["a.las"]}})
            self.assertEqual(submitted.status, 403)
            self.assertEqual(ask("DELETE", "/v1/triangulations/block", f"x:{token}").status, 403)
            self.assertIn(ask("GET", "/v1/caller", f"{token}:x").status, (401, 429))
        for value in ("Basic", "Basic ", "Basic !!!", "Basic " + "A" * 101, "Basic OnQ=", "Basic eA=="):
            answer = self.ask("GET", "/v1/caller", token=None, headers={"Authorization": value})
            self.assertIn(answer.status, (401, 429), value)
            # Nobody is asked for a password: browsers would show a window of their own.
            self.assertTrue(answer.headers.get("WWW-Authenticate", "Bearer").startswith("Bearer"))

    def test_who_asks_is_told_their_name_and_role(self):
        for role in ("read", "submit", "admin"):
            self.assertEqual(self.ask("GET", "/v1/caller", token=role).json(), {"name": role + "er", "role": role})

    def test_a_refused_submission_makes_no_job(self):
        before = len(self.ask("GET", "/v1/jobs").json()["jobs"])
        path, body = "/v1/processes/triangulate/execution", {"inputs": {"inputs": ["a.las"]}}
        for token, status in ((None, 401), ("read", 403), ("submit", 201)):
            self.assertEqual(self.ask("POST", path, body, token=token).status, status)
        self.assertEqual(len(self.ask("GET", "/v1/jobs").json()["jobs"]), before + 1)

    def test_authorization_is_bearer_with_the_whole_token(self):
        token = self.server.tokens["admin"]
        for value in (token, "Basic " + token, "Bearer", "Bearer ", "Bearer " + token[:-1], f"Bearer {token}a",
                      f"Bearer {token} {token}", "Bearer  " + token):
            self.assertIn(self.ask("GET", "/v1", token=None, headers={"Authorization": value}).status, (401, 429), value)
        self.assertEqual(self.ask("GET", "/v1", token=None, headers={"Authorization": "bearer " + token}).status, 200)
        self.assertEqual(self.ask("GET", "/v1?token=" + token, token=None).status, 401)

    def cookie(self, token="submit"):
        answer = self.ask("POST", "/v1/session", token=token)
        self.assertEqual((answer.status, answer.body), (204, b""))
        cookie, *attributes = answer.headers["Set-Cookie"].split("; ")
        self.assertEqual(set(attributes), {"HttpOnly", "SameSite=Strict", "Path=/", "Max-Age=604800"})
        self.assertNotIn(self.server.tokens[token], cookie)
        return cookie

    def caller(self, cookie):
        answer = self.ask("GET", "/v1/caller", token=None, headers={"Cookie": cookie})
        return answer.json()["name"] if answer.status == 200 else answer.status

    def test_a_token_is_exchanged_for_a_cookie(self):
        cookie = self.cookie()
        page = self.ask("GET", "/v1", token=None, headers={"Cookie": "a=b; " + cookie, "Accept": "text/html"})
        self.assertEqual(page.status, 200)
        self.assertIn("text/html", page.headers["Content-Type"])
        self.assertEqual(self.caller(cookie), "submiter")
        self.assertIn(self.caller(cookie + "0"), (401, 429))
        # The cookie's value is no token.
        value = cookie.split("=")[1]
        self.assertIn(self.ask("GET", "/v1", token=None, headers={"Authorization": "Bearer " + value}).status, (401, 429))

    def test_no_token_stands_in_an_address(self):
        # What is in one is in the log of every proxy before it.
        self.assertIn(self.ask("GET", "/?token=" + self.server.tokens["submit"], token=None).status, (401, 429))
        self.assertEqual(self.ask("GET", "/?token=" + self.server.tokens["submit"]).status, 400)

    def test_sessions_differ_and_are_no_function_of_the_token(self):
        self.assertEqual(len({self.cookie() for _ in range(5)}), 5)

    def test_a_session_ends_when_it_is_ended_and_no_other_does(self):
        cookie, other = self.cookie(), self.cookie()
        own = {"Cookie": cookie, "Sec-Fetch-Site": "same-origin"}
        self.assertEqual(self.ask("DELETE", "/v1/session", token=None, headers={"Cookie": cookie}).status, 403)
        answer = self.ask("DELETE", "/v1/session", token=None, headers=own)
        self.assertEqual(answer.status, 204)
        self.assertIn("Max-Age=0", answer.headers["Set-Cookie"])
        self.assertIn(self.caller(cookie), (401, 429))
        self.assertEqual(self.caller(other), "submiter")

    def test_a_session_is_begun_with_a_token_alone(self):
        own = {"Cookie": self.cookie(), "Sec-Fetch-Site": "same-origin"}
        self.assertEqual(self.ask("POST", "/v1/session", token=None, headers=own).status, 400)
        password = base64.b64encode(b"x:" + self.server.tokens["admin"].encode()).decode()
        answer = self.ask("POST", "/v1/session", token=None, headers={"Authorization": "Basic " + password})
        self.assertEqual((answer.status, answer.headers["Set-Cookie"]), (400, None))

    def test_what_is_kept_of_sessions_is_of_no_use(self):
        cookie = self.cookie()
        file = self.server.folder / "sessions"
        self.assertEqual(file.stat().st_mode & 0o777, 0o600)
        text = file.read_text()
        for secret in (cookie.split("=")[1], *self.server.tokens.values()):
            self.assertNotIn(secret, text)

    def test_a_page_of_another_origin_changes_nothing(self):
        cookie = self.cookie()
        path, body = "/v1/processes/triangulate/execution", {"inputs": {"inputs": ["a.las"]}}
        own = f"http://127.0.0.1:{self.server.port}"
        for headers, status in (
                ({}, 403), ({"Origin": own}, 201), ({"Sec-Fetch-Site": "same-origin"}, 201),
                ({"Origin": "https://evil.example"}, 403), ({"Origin": "null"}, 403),
                ({"Origin": own, "Sec-Fetch-Site": "cross-site"}, 403), ({"Sec-Fetch-Site": "same-site"}, 403),
                ({"Origin": f"http://127.0.0.1:{self.server.port + 1}"}, 403)):
            self.assertEqual(self.ask("POST", path, body, token=None, headers={"Cookie": cookie, **headers}).status,
                             status, headers)
        # Who shows a token is no browser that was led astray.
        self.assertEqual(self.ask("POST", path, body, headers={"Origin": "https://evil.example"}).status, 201)

    def test_only_names_of_this_service_are_answered(self):
        for host in ("evil.example", "127.0.0.1.evil.example", "10.0.0.1", "localhost@evil.example", "localhost:80:80", ""):
            got = self.raw(f"GET /v1 HTTP/1.1\r\nHost: {host}\r\nAuthorization: Bearer {self.server.tokens['admin']}\r\n"
                           "Connection: close\r\n\r\n".encode())
            self.assertRegex(got, rb"^HTTP/1.1 4(21|00) ", host)
        for hosts in ("", "Host: localhost\r\nHost: localhost\r\n"):
            got = self.raw(f"GET /v1 HTTP/1.1\r\n{hosts}Connection: close\r\n\r\n".encode())
            self.assertTrue(got.startswith(b"HTTP/1.1 400 "), got)
        for host in ("localhost", "LOCALHOST:1", "[::1]:7070"):
            self.assertEqual(self.ask("GET", "/v1", headers={"Host": host}).status, 200)
        # Supervisors ask by address.
        ask = lambda host: self.ask("GET", "/livez", token=None, port=self.server.operations, headers={"Host": host})
        self.assertEqual(ask("10.1.2.3:80").status, 200)
        self.assertEqual(ask("evil.example").status, 421)

    def test_there_is_no_way_around_a_path(self):
        token = self.server.tokens["admin"]
        for target in ("/v1/../v1", "/v1/triangulations/block/files/../../x", "/%2e%2e/etc/passwd", "/v1/%2E%2e/x",
                       "/v1/triangulations/block/files/..%2f..%2fetc", "/v1/jobs/a%00b", "/v1/jobs/%252e%252e",
                       "//v1", "/v1//jobs", "http://localhost/v1", "http://evil.example/v1", "/v1/jobs/a%5c..%5cb",
                       "/v1/jobs/%c0%ae%c0%ae", "*", "localhost:80", "/v1#x", "/v1/jobs/"):
            got = self.raw(f"GET {target} HTTP/1.1\r\nHost: localhost\r\nAuthorization: Bearer {token}\r\n"
                           "Connection: close\r\n\r\n".encode())
            self.assertRegex(got, rb"^HTTP/1.1 400 ", target)
            self.assertIn(b"application/problem+json", got)

    def test_no_answer_allows_what_a_browser_should_not_do(self):
        for path, token in (("/v1", "read"), ("/v1/none", "read"), ("/v1/jobs", None)):
            answer = self.ask("GET", path, token=token, headers={"Origin": "https://evil.example"})
            self.assertFalse([name for name in answer.headers if name.lower().startswith("access-control")])
            self.assertEqual(answer.headers["X-Content-Type-Options"], "nosniff")
            self.assertIn("default-src 'none'", answer.headers["Content-Security-Policy"])
            self.assertEqual(answer.headers["Cache-Control"], "no-store")

    def test_changes_are_told_in_the_log(self):
        job = self.submit()
        self.ask("DELETE", f"/v1/jobs/{job}", token="submit")
        self.assertIn(f"audit: submiter (submit) from 127.0.0.1: DELETE /v1/jobs/{job}: 200", self.server.log())


class Tokens(serving.ServerTest):
    def setUp(self):
        self.file = self.server.folder / "tokens"
        self.text = self.file.read_text()

    def tearDown(self):
        self.file.write_text(self.text)
        self.assertTrue(self.server.tell("reload"))

    caller = Security.caller
    cookie = Security.cookie

    def test_the_last_one_that_is_taken_out_is_refused(self):
        cookie = self.cookie()
        self.file.write_text("# nobody\n")
        self.assertTrue(self.server.tell("reload"))
        self.assertIn(self.ask("GET", "/v1/caller").status, (401, 429))
        self.assertIn(self.caller(cookie), (401, 429))
        self.file.write_text(self.text)
        self.assertTrue(self.server.tell("reload"))
        self.assertEqual(self.ask("GET", "/v1/caller").status, 200)
        self.assertIn(self.caller(cookie), (401, 429), "a session that has ended does not begin again")

    def test_what_is_no_file_of_tokens_changes_nothing(self):
        self.file.write_text("ana read short\n")
        self.assertFalse(self.server.tell("reload"))
        self.assertEqual(self.ask("GET", "/v1/caller").status, 200)

    def test_a_bad_certificate_does_not_keep_one_that_is_taken_back(self):
        self.file.write_text(self.text.replace("a" * 40, "b" * 40))
        self.assertTrue(self.server.tell("reload"))
        self.assertIn(self.ask("GET", "/v1/caller", token="a" * 40).status, (401, 429))
        self.assertEqual(self.ask("GET", "/v1/caller", token="b" * 40).json()["role"], "admin")


class Restarted(unittest.TestCase):
    def test_sessions_go_on_and_those_of_tokens_that_are_gone_do_not(self):
        server = serving.Server()
        self.addCleanup(server.close)
        def ask(method, path, headers):
            connection = http.client.HTTPConnection("127.0.0.1", server.port, timeout=30)
            connection.request(method, path, headers=headers)
            answer = serving.Answer(connection.getresponse())
            connection.close()
            return answer
        cookies = {}
        for role in ("read", "submit"):
            answer = ask("POST", "/v1/session", {"Authorization": f"Bearer {server.tokens[role]}"})
            cookies[role] = answer.headers["Set-Cookie"].split("; ")[0].split("=")[1]
        text = (server.folder / "tokens").read_text()
        (server.folder / "tokens").write_text(text.replace("s" * 40, "t" * 40))
        server.restart()
        def status(role):
            return ask("GET", "/v1/caller", {"Cookie": f"tessera-{server.port}={cookies[role]}"}).status
        self.assertEqual((status("read"), status("submit")), (200, 401))


class FailedAuthentications(serving.ServerTest):
    def test_are_bounded_and_lock_nobody_out(self):
        statuses = [self.ask("GET", "/v1", token="z" * 40).status for _ in range(40)]
        self.assertEqual(statuses[0], 401)
        self.assertEqual(statuses[-1], 429)
        self.assertEqual(self.ask("GET", "/v1").status, 200)
        text = self.ask("GET", "/metrics", token=None, port=self.server.operations).body.decode()
        self.assertIn("tessera_http_authentications_failed_total 40", text)


class ManyFailures(serving.ServerTest):
    def test_fill_no_log_and_end_their_connection(self):
        wrong = b"GET /v1 HTTP/1.1\r\nHost: localhost\r\nAuthorization: Bearer " + b"w" * 40 + b"\r\n\r\n"
        answers = 0
        while answers < 100:
            got = self.raw(wrong * 1000)
            statuses = re.findall(rb"HTTP/1.1 (\d+) ", got)
            self.assertEqual(set(statuses[:-1]) - {b"401"}, set())
            self.assertEqual(statuses[-1], b"429", "the last of its connection")
            answers += len(statuses)
        self.assertEqual(self.server.end(), 0)  # tells what it has not told
        log = self.server.log()
        lines = log.count("audit: nobody (none) from 127.0.0.1: GET /v1: ")
        more = sum(int(count) for count in re.findall(r"and (\d+) more refusals?", log))
        self.assertEqual(lines + more, answers)
        self.assertGreater(more, 0)


class Beyond(unittest.TestCase):
    def test_the_loopback_is_not_left_without_tls(self):
        server = serving.Server(address="0.0.0.0")
        self.assertIn("certificate", server.started["error"])
        self.assertEqual(server.close(), 2)
        server = serving.Server(address="0.0.0.0", insecure=1)
        self.assertNotIn("error", server.started)
        self.assertEqual(server.close(), 0)


if __name__ == "__main__":
    unittest.main()
