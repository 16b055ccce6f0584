"""A server of objects by HTTP, with ranges and versions, that can answer wrongly."""
import dataclasses
import email.utils
import hashlib
import http.server
import re
import socket
import ssl
import threading
import time
import urllib.parse


@dataclasses.dataclass
class Answer:
    status: int
    headers: dict
    body: bytes
    promised: int = None  # the Content-Length, if it is not that of the body


@dataclasses.dataclass
class Request:
    number: int  # among all requests, from 0
    name: str
    begin: int
    end: int  # behind the last byte
    headers: dict
    peer: tuple
    method: str = "GET"
    query: str = ""
    sent: bytes = b""


class ObjectServer:
    """Objects by name in `objects`. `fault(request, answer)` may change an answer; None closes the connection instead.
    `delay_s` is how far away the server is. `certificate`: a file with a certificate and its key, for https."""

    def __init__(self, objects=None, delay_s=0, certificate=None):
        self.objects, self.delay_s = dict(objects or {}), delay_s
        self.requests, self.most_at_once, self.fault = [], 0, lambda request, answer: answer
        self.lock, self.under_way = threading.Lock(), 0
        outer = self

        class Handler(http.server.BaseHTTPRequestHandler):
            protocol_version = "HTTP/1.1"
            disable_nagle_algorithm = True

            def do_GET(self):
                outer.answer(self)

            do_PUT = do_POST = do_DELETE = do_GET

            def log_message(self, *_):
                pass

        class Server(http.server.ThreadingHTTPServer):
            daemon_threads = True
            request_queue_size = 64

            def handle_error(self, *_):  # a client that hangs up is no news
                pass

        self.server = Server(("127.0.0.1", 0), Handler)
        if certificate:
            context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
            context.load_cert_chain(certificate)
            self.server.socket = context.wrap_socket(self.server.socket, server_side=True, do_handshake_on_connect=False)
        self.address = f"{'https' if certificate else 'http'}://127.0.0.1:{self.server.server_address[1]}"
        self.thread = threading.Thread(target=self.server.serve_forever, kwargs={"poll_interval": 0.05}, daemon=True)

    def __enter__(self):
        self.thread.start()
        return self

    def __exit__(self, *_):
        self.server.shutdown()
        self.server.server_close()
        self.thread.join()

    def url(self, name):
        return f"{self.address}/{name}"

    def bytes_asked(self):
        return sum(min(request.end, len(self.objects[request.name])) - request.begin for request in self.requests)

    def gate(self, handler, request):
        """An answer for who may not ask, or for what is no object."""

    def change(self, request):
        """The answer to a request that is not for reading."""
        return Answer(405, {}, b"read only")

    def honest(self, name, begin, end, if_match):
        body = self.objects.get(name)
        if body is None:
            return Answer(404, {}, b"no such object")
        etag = f'"{hashlib.sha256(body).hexdigest()[:16]}"'
        headers = {"ETag": etag, "Last-Modified": email.utils.formatdate(1_700_000_000, usegmt=True), "Accept-Ranges": "bytes"}
        if if_match is not None and if_match != etag:
            return Answer(412, {}, b"")
        if begin is None:
            return Answer(200, headers, body)
        if begin >= len(body):
            return Answer(416, {"Content-Range": f"bytes */{len(body)}"}, b"")
        end = min(end, len(body))
        return Answer(206, headers | {"Content-Range": f"bytes {begin}-{end - 1}/{len(body)}"}, body[begin:end])

    def answer(self, handler):
        name = urllib.parse.unquote(handler.path.split("?")[0].lstrip("/"))
        asked = re.fullmatch(r"bytes=(\d+)-(\d+)", handler.headers.get("Range", ""))
        begin, end = (int(asked[1]), int(asked[2]) + 1) if asked else (None, None)
        sent = handler.rfile.read(int(handler.headers.get("Content-Length") or 0))
        with self.lock:
            request = Request(len(self.requests), name, begin, end, dict(handler.headers), handler.client_address,
                              handler.command, handler.path.partition("?")[2], sent)
            self.requests.append(request)
            self.under_way += 1
            self.most_at_once = max(self.most_at_once, self.under_way)
        try:
            if self.delay_s:
                time.sleep(self.delay_s)
            answer = self.gate(handler, request)
            if answer is None and request.method != "GET":
                answer = self.change(request)
            answer = answer or self.honest(name, begin, end, handler.headers.get("If-Match"))
            answer = self.fault(request, answer)
        finally:
            with self.lock:
                self.under_way -= 1
        if answer is None:
            handler.close_connection = True
            handler.connection.shutdown(socket.SHUT_RDWR)
            return
        handler.send_response(answer.status)
        for key, value in answer.headers.items():
            handler.send_header(key, value)
        handler.send_header("Content-Length", str(len(answer.body) if answer.promised is None else answer.promised))
        handler.end_headers()
        handler.wfile.write(answer.body)
        if answer.promised is not None:
            handler.close_connection = True
