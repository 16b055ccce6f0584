"""A service that is played: the dashboard's own files, as the daemon sends them, over an API with more than any test makes."""
import http.server
import json
import queue
import re
import threading
import urllib.parse

STATES = ("successful", "successful", "successful", "failed", "dismissed")
CSP = "Content-Security-Policy"


def job(number, state=None, **more):
    at = f"2026-01-{number // 1440 % 28 + 1:02}T{number // 60 % 24:02}:{number % 60:02}:00.000Z"
    told = {"jobID": f"{number:012x}", "processID": "triangulate", "type": "process",
            "status": state or STATES[number % len(STATES)], "progress": 0, "created": at, "started": at, "finished": at,
            "submitter": f"user{number % 7}", "points": number * 1000, "nodesLost": 0, "starts": 1, "resumable": False,
            "triangulation": f"block-{number}", "memoryBytes": 0, "links": []}
    if told["status"] == "failed":
        told["problem"] = {"type": "about:blank", "title": "Unprocessable Content", "status": 422,
                           "detail": f"inputs: block-{number}.laz: this file ends in the middle of a chunk of points", "cause": 3}
    return told | more


def split_tree(tiles):
    """A layout that cuts space in halves by turns, now and then by height."""
    rows = {"axis": [], "place": [], "below": [], "above": []}

    def cut(first, count, lo, hi, depth):
        if count == 1:
            return -1 - first
        row, axis = len(rows["axis"]), 2 if depth % 5 == 4 else depth % 5 % 2
        half = count // 2
        place = lo[axis] + (hi[axis] - lo[axis]) * half / count
        for name, value in (("axis", axis), ("place", place), ("below", 0), ("above", 0)):
            rows[name].append(value)
        moved = [place if a == axis else v for a, v in enumerate(hi)], [place if a == axis else v for a, v in enumerate(lo)]
        rows["below"][row] = cut(first, half, lo, moved[0], depth + 1)
        rows["above"][row] = cut(first + half, count - half, moved[1], hi, depth + 1)
        return row

    cut(0, tiles, [0, 0, 0], [2000, 1000, 50], 0)
    return {"dimension": 3, "bounds": [0, 0, 0, 2000, 1000, 50], **rows}


def far_apart(tiles):
    """The same of two squares of 1 km, 900 km from each other: half of the tiles in each."""
    half = tiles // 2
    rows = {name: [value] for name, value in (("axis", 0), ("place", 450_000), ("below", 0), ("above", 0))}

    def cut(first, count, lo, hi, depth):
        if count == 1:
            return -1 - first
        row, axis, part = len(rows["axis"]), depth % 2, count // 2
        place = lo[axis] + (hi[axis] - lo[axis]) * part / count
        for name, value in (("axis", axis), ("place", place), ("below", 0), ("above", 0)):
            rows[name].append(value)
        rows["below"][row] = cut(first, part, lo, [place if a == axis else v for a, v in enumerate(hi)], depth + 1)
        rows["above"][row] = cut(first + part, count - part, [place if a == axis else v for a, v in enumerate(lo)], hi, depth + 1)
        return row

    rows["below"][0] = cut(0, half, [0, 0], [1000, 1000], 0)
    rows["above"][0] = cut(half, tiles - half, [900_000, 500_000], [901_000, 501_000], 0)
    return {"dimension": 3, "bounds": [0, 0, 0, 901_000, 501_000, 50], **rows}


class PlayedService:
    def __init__(self, files, jobs=0, results=0, nodes=1, tiles=0, layout=None):
        """`files`: name -> (type, policy, bytes) of the dashboard."""
        self.files = files
        self.jobs = [job(number) for number in range(jobs, 0, -1)]  # the newest first
        self.results = [{"name": f"r{number:05}", "dimension": 3, "vertices": number, "cells": 6 * number, "tiles": 1, "bytes": 99,
                         "created": "2026-01-01T00:00:00Z", "bounds": [], "links": []} for number in range(results)]
        self.nodes = [{"name": f"node{n}", "id": f"id{n}", "address": f"10.0.0.{n}:7075", "threads": 8, "memoryBytes": 1 << 34,
                       "memoryUsedBytes": n << 28, "state": "free", "seconds": 99 * n, "silentMs": 40 * n, "coordinator": n == 0, "tiles": 7 * n}
                      for n in range(nodes)]
        self.layout = layout or (split_tree(tiles) if tiles else None)
        self.stages = "w" * tiles
        self.mail = None  # between tiles, as the service tells it
        self.streams = []  # of (Last-Event-ID, queue), one a connection
        self.changed = threading.Condition()
        self.released = threading.Event()  # lists of jobs are sent once it is set; they are made before
        self.released.set()
        self.lists = 0     # that were made
        self.asked = []    # of each request, its path and query
        service = self

        class Handler(http.server.BaseHTTPRequestHandler):
            protocol_version = "HTTP/1.1"

            def do_GET(self):
                service.answer(self)

            do_POST = do_GET

            def log_message(self, *_):
                pass

        self.server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), Handler)
        self.server.daemon_threads = True
        self.port = self.server.server_port
        threading.Thread(target=self.server.serve_forever, daemon=True).start()

    def close(self):
        self.released.set()
        for _, events in self.streams:
            events.put(None)
        self.server.shutdown()
        self.server.server_close()

    def tell(self, number, kind, **content):
        """To the newest stream."""
        event = {"id": number, "kind": kind, **content}
        self.streams[-1][1].put(f"id: {number}\nevent: {kind}\ndata: {json.dumps(event)}\n\n".encode())

    def wait_for_streams(self, count):
        """Until so many were opened, the ended ones too."""
        with self.changed:
            self.changed.wait_for(lambda: len(self.streams) >= count)

    def wait_for_lists(self, count):
        with self.changed:
            self.changed.wait_for(lambda: self.lists >= count)

    def end_stream(self):
        self.streams[-1][1].put(None)

    def answer(self, request):
        url = urllib.parse.urlsplit(request.path)
        query = {name: values[0] for name, values in urllib.parse.parse_qs(url.query).items()}
        self.asked.append(request.path)
        if url.path == "/v1/events":
            return self.stream(request)
        if url.path.startswith("/ui/"):
            kind, policy, body = self.files[url.path.removeprefix("/ui/") or "index.html"]
            return self.send(request, 200, kind, body, {CSP: policy})
        found = self.find(url.path, query)
        if url.path == "/v1/jobs":
            found = json.loads(json.dumps(found))
            with self.changed:
                self.lists += 1
                self.changed.notify_all()
            self.released.wait()
        if isinstance(found, str):
            return self.send(request, 200, "text/plain", found.encode())
        self.send(request, 200 if found is not None else 404, "application/json", json.dumps(found or {"status": 404}).encode())

    def send(self, request, status, kind, body, headers=()):
        request.send_response(status)
        for name, value in {"Content-Type": kind, "Content-Length": str(len(body)), **dict(headers)}.items():
            request.send_header(name, value)
        request.end_headers()
        request.wfile.write(body)

    def stream(self, request):
        events = queue.Queue()
        request.send_response(200)
        request.send_header("Content-Type", "text/event-stream")
        request.send_header("Connection", "close")
        request.end_headers()
        request.close_connection = True
        with self.changed:
            self.streams.append((request.headers.get("Last-Event-ID"), events))
            self.changed.notify_all()
        while (text := events.get()) is not None:
            request.wfile.write(text)
            request.wfile.flush()

    def page_of(self, name, path, everything, key, query):
        limit, after = int(query.get("limit", 100)), query.get("after")
        states = query.get("status")
        wanted = [one for one in everything if not states or one["status"] in states.split(",")]
        start = next(i for i, one in enumerate(wanted) if one[key] == after) + 1 if after else 0
        page = wanted[start:start + limit]
        links = [{"href": path, "rel": "self"}]
        if len(page) == limit:
            more = f"&status={states}" if states else ""
            links.append({"href": f"{path}?limit={limit}{more}&after={page[-1][key]}", "rel": "next"})
        return {name: page, "links": links, "numberMatched": len(wanted)}

    def find(self, path, query):
        if path == "/v1/caller":
            return {"name": "played", "role": "admin"}
        if path == "/v1/jobs":
            return self.page_of("jobs", path, self.jobs, "jobID", query)
        if path == "/v1/triangulations":
            return self.page_of("triangulations", path, self.results, "name", query)
        if path == "/v1/nodes":
            return {"nodes": self.nodes, "links": []}
        found = re.fullmatch(r"/v1/jobs/(\w+)(/\w+)?", path)
        one = next((each for each in self.jobs if found and each["jobID"] == found[1]), None)
        if not one or not found[2]:
            return one
        if found[2] == "/log":
            return "2026-01-01T00:00:00.000Z accepted\n"
        if found[2] == "/tiles":
            told = {"jobID": one["jobID"], "stages": self.stages, "begunAgain": 3, "elapsed": 10, "busyThreads": [1, 2, 2], "busy": 9}
            if self.mail:
                told["mail"] = self.mail
            return told | ({"layout": self.layout} if query.get("layout") == "true" else {})
        return None
