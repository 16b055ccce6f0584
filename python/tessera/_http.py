"""HTTP requests to a daemon, with the standard library."""
from __future__ import annotations

import contextlib
import http.client
import json
import ssl
import typing
import urllib.parse

from ._errors import BY_CAUSE, Error, IoError, UsageError

TIMEOUT_S = 60.0
SILENCE_OF_EVENTS_S = 45.0  # the daemon sends something every 15 s


class ConnectionLost(IoError):
    """The connection failed. The daemon did not refuse the request."""


class Transport:
    """One daemon: its address, the token, and the certificates to trust.

    Every request has a connection of its own, so all methods may be called from any thread.
    """

    def __init__(self, url: str, token: str | None, ca: str | None):
        parts = urllib.parse.urlsplit(url)
        if parts.scheme not in ("http", "https") or not parts.hostname or parts.username is not None:
            raise UsageError("url is not an address like http://127.0.0.1:7070")
        try:
            self._port = parts.port
        except ValueError:
            raise UsageError("url has no port from 1 to 65535") from None
        self._host, self._base = parts.hostname, parts.path.rstrip("/")
        # The daemon prints its address with the token in the fragment; earlier versions had it in the query.
        given = urllib.parse.parse_qs(parts.fragment or parts.query).get("token", [None])[0]
        self._token = token if token is not None else given
        if self._token is not None and not (self._token.isascii() and self._token.isprintable() and " " not in self._token):
            raise UsageError("token has spaces or other characters that no token has")
        self.heard = False  # whether the daemon has ever answered
        self._tls = None
        if parts.scheme == "https":
            try:
                self._tls = ssl.create_default_context(cafile=ca)
            except (OSError, ssl.SSLError) as error:
                raise IoError(f"ca: {ca} holds no certificates that can be read: {error}") from None
        self.url = urllib.parse.urlunsplit((parts.scheme, parts.netloc, self._base, "", ""))

    def _connection(self, timeout: float) -> http.client.HTTPConnection:
        if self._tls is not None:
            return http.client.HTTPSConnection(self._host, self._port, timeout=timeout, context=self._tls)
        return http.client.HTTPConnection(self._host, self._port, timeout=timeout)

    @contextlib.contextmanager
    def open(self, method: str, path: str, headers: dict[str, str] | None = None, body: bytes | typing.BinaryIO | None = None,
             timeout: float = TIMEOUT_S) -> typing.Iterator[http.client.HTTPResponse]:
        """Sends a request for /v1 + path, and yields the answer. Raises an Error if the status is not 2xx."""
        connection = self._connection(timeout)
        sent = {"Accept": "application/json", **(headers or {})}
        if self._token is not None:
            sent["Authorization"] = f"Bearer {self._token}"
        try:
            with self._as_ours():
                try:
                    connection.request(method, f"{self._base}/v1{path}", body, sent)
                except (BrokenPipeError, ConnectionResetError):
                    if body is None:
                        raise
                    # A daemon that refuses a body may answer, and close the connection, before it has read all of it.
                answer = connection.getresponse()
                self.heard = True
            if not 200 <= answer.status < 300:
                raise self._refusal(answer, method)
            yield answer
        finally:
            connection.close()

    @contextlib.contextmanager
    def _as_ours(self) -> typing.Iterator[None]:
        """What the connection raises, as Error."""
        try:
            yield
        except ssl.SSLCertVerificationError as error:
            raise UsageError(f"{self.url}: the certificate of the server is not trusted: {error.verify_message}; "
                             "give a file with the certificate of its authority as ca") from None
        except ssl.SSLError as error:
            raise UsageError(f"{self.url}: the server does not speak TLS: {error.reason or error}") from None
        except TimeoutError:
            raise ConnectionLost(f"{self.url}: the server does not answer in time") from None
        except OSError as error:
            raise ConnectionLost(f"{self.url}: the server cannot be reached: {error.strerror or error}") from None
        except http.client.BadStatusLine:
            raise UsageError(f"{self.url}: the server does not speak HTTP") from None
        except http.client.HTTPException as error:
            raise ConnectionLost(f"{self.url}: the server has ended the connection: {error!r}") from None

    def read(self, answer: http.client.HTTPResponse, amount: int | None = None) -> bytes:
        """Returns bytes of an answer. Raises ConnectionLost if the connection ends before the answer does."""
        with self._as_ours():
            content = answer.read(amount)
        if not content and answer.length:  # bytes are missing, which http.client does not report
            raise ConnectionLost(f"{self.url}: the server has ended the connection within its answer")
        return content

    def line(self, answer: http.client.HTTPResponse) -> bytes:
        """Returns a line of an answer; b"" at the end of the answer."""
        with self._as_ours():
            return answer.readline(1 << 20)

    def no_tessera(self) -> Error:
        return UsageError(f"{self.url}: the server that answers is not a Tessera server")

    def _refusal(self, answer: http.client.HTTPResponse, method: str) -> Error:
        if "json" not in answer.headers.get("Content-Type", ""):
            return self.no_tessera()
        problem = {} if method == "HEAD" else self.document(answer)
        refused = self._problem(answer, problem)
        refused._http_status, refused._problem_type = answer.status, problem.get("type", "")
        return refused

    def _problem(self, answer: http.client.HTTPResponse, problem: dict[str, typing.Any]) -> Error:
        if answer.status == 401:
            return UsageError(f"{self.url}: " + ("the server does not know this token" if self._token else
                                                 "the server needs a token"))
        said = problem.get("detail") or problem.get("title") or f"{self.url}: status {answer.status}"
        default = IoError if answer.status == 429 or answer.status >= 500 else UsageError
        return BY_CAUSE.get(problem.get("cause", 0), default)(said)

    def document(self, answer: http.client.HTTPResponse) -> dict[str, typing.Any]:
        """Returns the JSON object in an answer."""
        content = self.read(answer)
        try:
            found = json.loads(content)
        except ValueError:
            found = None
        if not isinstance(found, dict):
            raise self.no_tessera()
        return found

    def ask(self, method: str, path: str, document: object = None, headers: dict[str, str] | None = None) -> dict[str, typing.Any]:
        """Sends a request for /v1 + path, and returns the JSON object that the server answers."""
        sent = dict(headers or {})
        body = None
        if document is not None:
            sent["Content-Type"] = "application/json"
            body = json.dumps(document, allow_nan=False).encode()
        with self.open(method, path, sent, body) as answer:
            if "json" not in answer.headers.get("Content-Type", ""):
                raise self.no_tessera()
            return self.document(answer)

    def ask_for_all(self, path: str, member: str) -> list[dict[str, typing.Any]]:
        """Returns a list with the items of all its pages."""
        found: list[dict[str, typing.Any]] = []
        here = f"{self._base}/v1{path}"
        while True:
            page = self.ask("GET", here[len(self._base) + 3:])
            found += page.get(member, [])
            following = [link["href"] for link in page.get("links", []) if link.get("rel") == "next"]
            if not following or not page.get(member):
                return found
            there = urllib.parse.urlsplit(urllib.parse.urljoin(f"{self.url[:len(self.url) - len(self._base)]}{here}", following[0]))
            here = there.path + (f"?{there.query}" if there.query else "")
            if there.netloc != urllib.parse.urlsplit(self.url).netloc or not here.startswith(f"{self._base}/v1/"):
                raise IoError(f"{self.url}: the answer of the server links to another server")
