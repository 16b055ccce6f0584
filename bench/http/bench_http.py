#!/usr/bin/env python3
"""The HTTP front end by itself, before a service that does nothing: what a request, a file and a watcher cost.

    SERVER=build/release/tests/http/http_test_server /usr/bin/python3 bench/http/bench_http.py [--seconds 5]

The server has one thread. Rates are also given per second of its processor time, which other work on the machine disturbs
less. Needs wrk.
"""
import argparse
import os
import pathlib
import re
import socket
import subprocess
import sys
import time

sys.path.insert(0, str(pathlib.Path(__file__).parents[2] / "tests/http"))
import serving

FILE_BYTES = 200_000_000
FILE = "/v1/triangulations/block/files/deep/tile.vtu"


def processor_seconds(server):
    fields = pathlib.Path(f"/proc/{server.process.pid}/stat").read_text().rsplit(")", 1)[1].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def request(server, method, path, more="", body=b""):
    return (f"{method} {path} HTTP/1.1\r\nHost: localhost\r\nAuthorization: Bearer {server.tokens['admin']}\r\n"
            f"Content-Length: {len(body)}\r\n{more}\r\n").encode() + body


def connect(server, *sent):
    connection = socket.create_connection(("127.0.0.1", server.port))
    connection.sendall(b"".join(sent))
    return connection


def read_all(connection):
    buffer, count = bytearray(1 << 20), 0
    while got := connection.recv_into(buffer):
        count += got
    connection.close()
    return count


def requests(server, path, seconds):
    before = processor_seconds(server)
    told = subprocess.run(["wrk", "-t1", "-c32", f"-d{seconds}s", "-H", "Authorization: Bearer " + server.tokens["read"],
                           f"http://127.0.0.1:{server.port}{path}"], check=True, capture_output=True, text=True).stdout
    if "Non-2xx" in told:
        raise RuntimeError(told)
    count, rate = int(re.search(r"(\d+) requests in", told)[1]), float(re.search(r"Requests/sec: *([\d.]+)", told)[1])
    print(f"GET {path}: {rate:.0f} requests/s, {count / (processor_seconds(server) - before):.0f} a processor second")


def files(server):
    before, start = processor_seconds(server), time.monotonic()
    count = sum(read_all(connect(server, request(server, "GET", FILE, "Connection: close\r\n"))) for _ in range(5))
    print(f"files: {count / 1e9 / (time.monotonic() - start):.2f} GB/s, "
          f"{count / 1e9 / (processor_seconds(server) - before):.2f} GB a processor second")


def pages(server):
    body = b'{"inputs":{"triangulation":"block"}}'
    one = request(server, "POST", "/v1/processes/verify/execution", "Content-Type: application/json\r\n", body)
    last = request(server, "GET", "/v1", "Connection: close\r\n")
    for _ in range(100):
        read_all(connect(server, one * 100, last))
    for limit in (100, 1000):
        start = time.monotonic()
        count = read_all(connect(server, request(server, "GET", f"/v1/jobs?limit={limit}", "Connection: close\r\n")))
        print(f"{limit} of 10,000 jobs: {(time.monotonic() - start) * 1e3:.1f} ms, {count} bytes")


def watchers(server, count, events=20):
    connections = [connect(server, request(server, "GET", "/v1/events")) for _ in range(count)]
    for connection in connections:
        connection.recv(65536)
    before = processor_seconds(server)
    for _ in range(events):
        server.tell("tell 1")
        for connection in connections:
            while not connection.recv(65536).endswith(b"\n\n"):
                pass
    spent = (processor_seconds(server) - before) / events
    print(f"{count} watchers: {spent * 1e3:.1f} ms of processor time an event; {server.memory() / 1e6:.0f} MB resident")
    for connection in connections:
        connection.close()


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seconds", type=int, default=5)
    args = parser.parse_args()
    server = serving.Server(threads=1, file_bytes=FILE_BYTES)
    read_all(connect(server, request(server, "POST", "/v1/processes/verify/execution",
                                     "Content-Type: application/json\r\nConnection: close\r\n",
                                     b'{"inputs":{"triangulation":"block"}}')))
    requests(server, "/v1/jobs/j1", args.seconds)
    requests(server, "/v1/conformance", args.seconds)
    files(server)
    pages(server)
    watchers(server, 500)
    server.close()


if __name__ == "__main__":
    main()
