"""A daemon that does what the test says: its endpoints, without any work behind them.

    server = FakeServer(token="secret")
    server.results["block"] = pathlib.Path("out")           # a result folder of the command
    server.on_submit = lambda job: job.tell("running", phase="routing") or job.tell("successful", triangulation="block")
"""
import ctypes
import http.server
import json
import pathlib
import re
import shutil
import sys
import threading
import urllib.parse


class Job:
    def __init__(self, server, identity, process="triangulate", **fields):
        self.server, self.events, self.forgotten = server, [], False
        self.fields = {"jobID": identity, "id": identity, "processID": process, "type": "process", "status": "accepted",
                       "message": "", "progress": 0, "created": "2026-01-02T03:04:05Z", "updated": "2026-01-02T03:04:05Z",
                       "phase": "", "points": 0, "tiles": {"total": 0, "triangulated": 0, "asleep": 0, "stored": 0},
                       "resumable": False, "starts": 1, "links": [], "a_field_of_tomorrow": {"x": [1]}, **fields}

    def tell(self, status=None, kind="status", text="", **fields):
        """Changes the job, and sends an event of it."""
        with self.server.changed:
            self.fields.update(fields, **({"status": status} if status else {}))
            self.server.last_event += 1
            event = {"id": self.server.last_event, "jobID": self.fields["id"], "kind": kind, "text": text,
                     "time": "2026-01-02T03:04:06Z"}
            if kind != "log":
                event["status"] = dict(self.fields)
            self.events.append(event)
            self.server.changed.notify_all()


class FakeServer:
    def __init__(self, token=None, port=0, certificate=None):
        self.token, self.certificate = token, certificate
        self.changed = threading.Condition()
        self.jobs, self.results, self.last_event = {}, {}, 0
        self.requests = []          # (method, path with query, headers, body)
        self.on_submit = lambda job: None
        self.on_events = lambda job, asked: None  # a client begins to listen
        self.refusals = {}          # (method, path) -> (status, problem)
        self.foreign = None         # (status, type, body): what something that is no Tessera server answers
        self.cut_files_after = []   # so many bytes of each of the next answers with a file, then the connection ends
        self.spoil = {}             # path of a file -> function of its bytes
        self.nodes = []             # as the answers have them
        self.uploads = {}           # "FOLDER/FILE" -> bytes; None when none are taken
        self.cut_uploads_after = [] # so many bytes of each of the next uploads, then the connection ends
        self.described = None       # what info tells; None: it takes a job
        self.page = 1000
        self.last_sent = 0          # the id of the last event that was written to some client
        self.start(port)

    def start(self, port=None):
        server = self

        class Handler(_Handler):
            fake = server

        self.stopping = False
        self.http = _Listener(("127.0.0.1", self.port if port is None else port), Handler)
        if self.certificate:
            import ssl
            context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
            context.load_cert_chain(self.certificate)
            self.http.socket = context.wrap_socket(self.http.socket, server_side=True, do_handshake_on_connect=False)
        self.port = self.http.server_address[1]
        self.connections = set()
        self.thread = threading.Thread(target=self.http.serve_forever, args=(0.02,))
        self.thread.start()

    def stop(self):
        """As a daemon that ends: its port is closed, and every connection."""
        with self.changed:
            self.stopping = True
            self.changed.notify_all()
        self.http.shutdown()
        self.http.server_close()
        self.thread.join()
        for connection in list(self.connections):
            try:
                connection.shutdown(2)
            except OSError:
                pass  # gone already

    @property
    def url(self):
        return f"{'https' if self.certificate else 'http'}://127.0.0.1:{self.port}"

    def add_job(self, identity, **fields):
        self.jobs[identity] = Job(self, identity, **fields)
        return self.jobs[identity]

    def asked(self, method, pattern):
        """The requests of that method whose path, with its query, has the pattern."""
        return [request for request in self.requests if request[0] == method and re.search(pattern, request[1])]


class _Listener(http.server.ThreadingHTTPServer):
    daemon_threads = True

    def handle_error(self, request, client_address):
        if not isinstance(sys.exc_info()[1], OSError):  # a client that has gone
            super().handle_error(request, client_address)


class _Handler(http.server.BaseHTTPRequestHandler):
    protocol_version = "HTTP/1.1"
    fake: FakeServer

    def log_message(self, *_):
        pass

    def setup(self):
        super().setup()
        self.fake.connections.add(self.connection)

    def finish(self):
        self.fake.connections.discard(self.connection)
        super().finish()

    def answer(self, status, body, kind="application/json", **headers):
        content = body if isinstance(body, bytes) else json.dumps(body).encode()
        self.send_response(status)
        self.send_header("Content-Type", kind)
        self.send_header("Content-Length", str(len(content)))
        for name, value in headers.items():
            self.send_header(name.replace("_", "-"), value)
        self.end_headers()
        if self.command != "HEAD":
            self.wfile.write(content)

    def problem(self, status, detail, cause=0):
        self.answer(status, {"type": "about:blank", "title": "no", "status": status, "detail": detail, "cause": cause},
                    "application/problem+json")

    def do(self):
        fake = self.fake
        if self.command == "PUT" and fake.cut_uploads_after:
            return self.cut_upload()
        body = self.rfile.read(int(self.headers.get("Content-Length", 0)))
        fake.requests.append((self.command, self.path, dict(self.headers), body))
        path, _, query = self.path.partition("?")
        if fake.foreign:
            return self.answer(fake.foreign[0], fake.foreign[2], fake.foreign[1])
        if fake.token and self.headers.get("Authorization") != f"Bearer {fake.token}":
            return self.problem(401, "a token is needed")
        refused = fake.refusals.get((self.command, path))
        if refused:
            return self.answer(refused[0], refused[1], "application/problem+json")
        parts = [urllib.parse.unquote(part) for part in path.split("/")][1:]
        if parts[0] != "v1":
            return self.problem(404, "there is nothing of this name")
        asked = dict(urllib.parse.parse_qsl(query))
        return self.route(parts[1:], asked, body)

    do_GET = do_POST = do_DELETE = do_PUT = do_HEAD = do

    def cut_upload(self):
        self.fake.requests.append((self.command, self.path, dict(self.headers), b""))
        self.take_upload(self.path.removeprefix("/v1/uploads/"), self.rfile.read(self.fake.cut_uploads_after.pop(0)))
        self.connection.shutdown(2)
        self.close_connection = True

    def take_upload(self, name, body):
        first = int(self.headers.get("Upload-Offset", 0))
        self.fake.uploads[name] = self.fake.uploads.get(name, b"")[:first] + body

    def of_upload(self, name, body):
        if self.fake.uploads is None:
            return self.problem(403, "this service takes no uploads", 2)
        if self.command == "PUT":
            self.take_upload(name, body)
            return self.answer(204, b"")
        if name not in self.fake.uploads:
            return self.answer(404, b"", "application/problem+json")
        return self.answer(204, b"", Upload_Offset=str(len(self.fake.uploads[name])))

    def of_nodes(self, parts):
        if not parts:
            return self.answer(200, {"nodes": self.fake.nodes, "links": []})
        for node in self.fake.nodes:
            if self.command == "POST" and parts == [node["name"], "drain"]:
                return self.answer(200, node | {"state": "draining"})
        return self.problem(404, f"there is no node '{parts[0]}'", 2)

    def route(self, parts, asked, body):
        fake = self.fake
        if parts[0] == "uploads":
            return self.of_upload("/".join(parts[1:]), body)
        if parts[:2] == ["processes", "info"] and "respond-async" not in self.headers.get("Prefer", ""):
            if fake.described is not None:
                return self.answer(200, fake.described)
            return self.answer(400, {"type": "urn:tessera:needs-a-job", "detail": "send it again with the header Prefer: respond-async", "cause": 2},
                               "application/problem+json")
        if self.command == "POST" and parts[0] == "processes" and parts[2] == "execution":
            job = fake.add_job(f"j{len(fake.jobs) + 1}", process=parts[1])
            job.inputs = json.loads(body)["inputs"]
            self.answer(201, job.fields, Location=f"jobs/{job.fields['id']}")
            return fake.on_submit(job)
        if parts == ["jobs"]:
            states = asked["status"].split(",") if "status" in asked else None
            found = [job.fields for job in fake.jobs.values() if not states or job.fields["status"] in states]
            return self.listed("jobs", found, asked)
        if parts[0] == "nodes":
            return self.of_nodes(parts[1:])
        if parts == ["triangulations"]:
            return self.listed("triangulations", [about(name, folder) for name, folder in fake.results.items()], asked)
        if parts[0] == "jobs":
            job = fake.jobs.get(parts[1])
            if not job or job.forgotten:
                return self.problem(410 if job else 404, f"there is no job {parts[1]}")
            return self.of_job(job, parts[2:])
        if parts[0] == "triangulations" and parts[1] in fake.results:
            folder = pathlib.Path(fake.results[parts[1]])
            if len(parts) == 2:
                return self.answer(200, about(parts[1], folder))
            if self.command == "DELETE":
                gone = folder.joinpath(*parts[3:])
                if gone.is_dir():
                    shutil.rmtree(gone)
                else:
                    gone.unlink()
                return self.answer(204, b"")
            return self.file(folder, "/".join(parts[3:]))
        return self.problem(404, f"there is no triangulation {parts[1]}")

    def listed(self, member, found, asked):
        first, size = int(asked.get("after", 0)), min(int(asked.get("limit", 100)), self.fake.page)
        end = first + size
        again = {**asked, "limit": size, "after": end}
        links = [{"href": f"{member}?{urllib.parse.urlencode(again)}", "rel": "next"}] if end < len(found) else []
        self.answer(200, {member: found[first:end], "links": links, "numberMatched": len(found)})

    def of_job(self, job, parts):
        ended = job.fields["status"] not in ("accepted", "running")
        if parts == [] and self.command == "DELETE":
            if ended:
                job.forgotten = True
            else:
                job.tell("dismissed", resumable=True)
            return self.answer(200, job.fields)
        if parts == []:
            return self.answer(200, job.fields)
        if parts == ["resume"]:
            if not job.fields["resumable"]:
                return self.problem(409, f"job {job.fields['id']} cannot be resumed", 2)
            job.tell("running", starts=job.fields["starts"] + 1, resumable=False)
            self.answer(200, job.fields)
            return self.fake.on_submit(job)
        if parts == ["results"]:
            return self.answer(200, {"outcome": {"value": getattr(job, "outcome", {})}})
        if parts == ["events"]:
            return self.send_events(job)
        return self.problem(404, "there is nothing of this name")

    def send_events(self, job):
        fake = self.fake
        last = self.headers.get("Last-Event-ID")
        with fake.changed:
            last = fake.last_event if last is None else int(last)
        self.send_response(200)
        self.send_header("Content-Type", "text/event-stream")
        self.send_header("Transfer-Encoding", "chunked")
        self.end_headers()
        self.chunk(": hello\n\n")
        fake.on_events(job, self)
        while True:
            with fake.changed:
                fake.changed.wait_for(lambda: fake.stopping or any(e["id"] > last for e in job.events))
                if fake.stopping:
                    self.close_connection = True
                    return
                new = [event for event in job.events if event["id"] > last]
            for event in new:
                last = event["id"]
                try:
                    self.chunk(f"id: {last}\nevent: {event['kind']}\ndata: {json.dumps(event)}\n\n")
                except OSError:
                    self.close_connection = True
                    return
                with fake.changed:
                    fake.last_sent = last
                    fake.changed.notify_all()

    def chunk(self, text):
        content = text.encode()
        self.wfile.write(b"%x\r\n%s\r\n" % (len(content), content))
        self.wfile.flush()

    def file(self, folder, name):
        path = folder / name
        if not path.is_file():
            return self.problem(404, f"there is no file {name}")
        content = path.read_bytes()
        content = self.fake.spoil.get(name, lambda same: same)(content)
        etag = etag_of(folder, name)
        headers = {"Accept_Ranges": "bytes", **({"ETag": etag} if etag else {})}
        wanted = re.fullmatch(r"bytes=(\d+)-", self.headers.get("Range", ""))
        condition = self.headers.get("If-Range")
        status, part = 200, content
        if wanted and (condition is None or condition == etag):
            first = int(wanted[1])
            if first >= len(content):
                return self.answer(416, b"", "text/plain", Content_Range=f"bytes */{len(content)}")
            status, part = 206, content[first:]
            headers["Content_Range"] = f"bytes {first}-{len(content) - 1}/{len(content)}"
        if name.startswith("tiles/") and self.fake.cut_files_after:
            self.send_response(status)
            for key, value in {**headers, "Content_Length": len(part)}.items():
                self.send_header(key.replace("_", "-"), str(value))
            self.end_headers()
            self.wfile.write(part[:self.fake.cut_files_after.pop(0)])
            self.wfile.flush()
            self.connection.shutdown(2)
            self.close_connection = True
            return
        self.answer(status, part, "application/octet-stream", **headers)


def about(name, folder):
    manifest = json.loads((folder / "manifest.json").read_text())
    counts = manifest["counts"]
    return {"name": name, "dimension": manifest["dimension"], "vertices": counts["vertices"], "cells": counts["cells"],
            "tiles": len(manifest["tiles"]), "bytes": sum(tile["bytes"] for tile in manifest["tiles"]),
            "digest": manifest["digest2"], "created": "2026-01-02T03:04:05Z", "crs": manifest["crs"], "bounds": [],
            "links": []}


def etag_of(folder, name):
    manifest = json.loads((folder / "manifest.json").read_text())
    for tile in manifest["tiles"]:
        if name == f"tiles/{tile['tile']:06}.vtu":
            return f'"xxh3-{tile["xxh3"]}"'
    sum_of = manifest["checksums"].get(name)
    return f'"xxh3-{sum_of}"' if sum_of else None


def xxh3(content):
    library = ctypes.CDLL("libxxhash.so.0")
    library.XXH3_64bits.restype, library.XXH3_64bits.argtypes = ctypes.c_uint64, [ctypes.c_char_p, ctypes.c_size_t]
    return f"{library.XXH3_64bits(content, len(content)):016x}"
