#!/usr/bin/env python3
"""The daemon with real jobs: what dismissing, submitting, many jobs, and watchers cost.

    TESSERAD=build/release/src/front/daemon/tesserad TESSERA=build/release/src/front/apps/tessera \
        /usr/bin/python3 bench/http/bench_service.py dismiss|submissions|memory|watchers [--points 2M] [--tiles 16] ...

Data go below --folder, which is made and removed.
"""
import argparse
import http.client
import json
import os
import pathlib
import resource
import shutil
import statistics
import subprocess
import sys
import tempfile
import threading
import time


def arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("what", choices=["dismiss", "submissions", "memory", "watchers"])
    parser.add_argument("--points", default="2M", help="of the cloud that is triangulated")
    parser.add_argument("--tiles", type=int, default=0, help="0: as many as fit")
    parser.add_argument("--count", type=int, default=0, help="of moments, submissions, jobs, or pairs of runs")
    parser.add_argument("--connections", type=int, default=8)
    parser.add_argument("--watchers", type=int, default=500)
    parser.add_argument("--folder", type=pathlib.Path, default=pathlib.Path(tempfile.gettempdir()))
    return parser.parse_args()


def processor_seconds(daemon):
    fields = pathlib.Path(f"/proc/{daemon.process.pid}/stat").read_text().rsplit(")", 1)[1].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def answering_seconds(daemon):
    """Processor time of the threads that tell and answer, not of those that triangulate."""
    nanoseconds = 0
    for task in pathlib.Path(f"/proc/{daemon.process.pid}/task").iterdir():
        if (task / "comm").read_text().strip() in ("http", "events"):
            nanoseconds += int((task / "schedstat").read_text().split()[0])
    return nanoseconds / 1e9


def resident(daemon):
    return int(pathlib.Path(f"/proc/{daemon.process.pid}/statm").read_text().split()[1]) * 4096


def descriptors(daemon):
    return len(os.listdir(f"/proc/{daemon.process.pid}/fd"))


def execute(daemon, process="triangulate", **inputs):
    status, _, job = daemon.request("POST", f"/v1/processes/{process}/execution", {"inputs": inputs},
                                    {"Prefer": "respond-async"})
    assert status == 201, job
    return job["jobID"]


def options(args, output):
    return {"inputs": ["cloud.las"], "output": output, "overwrite": True} | ({"tiles": args.tiles} if args.tiles else {})


def running(daemon, job):
    """Waits until it runs: what is dismissed before never says that it was interrupted."""
    for _, _, data in daemon.events(f"/v1/jobs/{job}/events"):
        if (data or {}).get("status", {}).get("status") != "accepted":
            return


def stopped_after(daemon, job):
    """Seconds until nothing of the job works any more: its log says so. REQUIRES: it ran when it was dismissed."""
    begin = time.monotonic()
    while True:
        log = daemon.request("GET", f"/v1/jobs/{job}/log")[2].decode()
        if "interrupted" in log.rsplit("dismissed", 1)[-1]:
            return time.monotonic() - begin
        time.sleep(0.005)


def dismiss(daemon, args):
    begin = time.monotonic()
    job = execute(daemon, **options(args, "whole"))
    assert daemon.wait(job)["status"] == "successful"
    whole = time.monotonic() - begin
    digest = daemon.request("GET", "/v1/triangulations/whole")[2]["digest"]
    print(f"undisturbed: {whole:.1f} s")
    waits = []
    count = args.count or 12
    for moment in range(count):
        at = whole * (moment + 0.5) / count
        job = execute(daemon, **options(args, f"part{moment}"))
        time.sleep(at)
        status = daemon.request("GET", f"/v1/jobs/{job}")[2]
        if status["status"] != "running":
            continue
        begin = time.monotonic()
        assert daemon.request("DELETE", f"/v1/jobs/{job}")[0] == 200
        answered = time.monotonic() - begin
        waits.append(stopped_after(daemon, job) + answered)
        assert daemon.request("POST", f"/v1/jobs/{job}/resume")[0] == 200
        ended = daemon.wait(job)
        assert ended["status"] == "successful", ended
        assert daemon.request("GET", f"/v1/triangulations/part{moment}")[2]["digest"] == digest
        daemon.request("DELETE", f"/v1/triangulations/part{moment}")
        print(f"{status.get('phase', '')} at {at:.1f} s: stopped after {waits[-1]:.2f} s; resumed to the same digest")
    print(f"median {statistics.median(waits):.2f} s, most {max(waits):.2f} s of {len(waits)}")


def page(daemon, limit):
    connection = http.client.HTTPConnection("127.0.0.1", daemon.port)
    head = {"Authorization": f"Bearer {daemon.token}"}
    times = []
    for _ in range(11):
        begin = time.monotonic()
        connection.request("GET", f"/v1/jobs?limit={limit}", headers=head)
        size = len(connection.getresponse().read())
        times.append(time.monotonic() - begin)
    print(f"the newest {limit} jobs: {statistics.median(times) * 1e3:.1f} ms, {size} bytes")


def all_pages(daemon, limit=100):
    """Of the whole list, by its links."""
    connection = http.client.HTTPConnection("127.0.0.1", daemon.port)
    head = {"Authorization": f"Bearer {daemon.token}"}
    times, count, after = [], 0, ""
    while after is not None:
        begin = time.monotonic()
        connection.request("GET", f"/v1/jobs?limit={limit}{after}", headers=head)
        body = connection.getresponse().read()
        times.append(time.monotonic() - begin)
        listed = json.loads(body)
        count += len(listed["jobs"])
        after = f"&after={listed['jobs'][-1]['jobID']}" if any(x["rel"] == "next" for x in listed["links"]) else None
    print(f"all {count} jobs in {len(times)} pages: median {statistics.median(times) * 1e3:.1f} ms, most {max(times) * 1e3:.1f} ms")


def submissions(daemon, args):
    count = args.count or 3000
    blocker = execute(daemon, **options(args, "blocker"))  # all others wait
    body = json.dumps({"inputs": {"inputs": ["cloud.las"]}})
    head = {"Authorization": f"Bearer {daemon.token}", "Content-Type": "application/json", "Prefer": "respond-async"}
    refused = []

    def submit(these):
        connection = http.client.HTTPConnection("127.0.0.1", daemon.port, timeout=600)
        for _ in these:
            connection.request("POST", "/v1/processes/info/execution", body, head)
            answer = connection.getresponse()
            answer.read()
            if answer.status != 201:
                refused.append(answer.status)

    threads = [threading.Thread(target=submit, args=(range(at, count, args.connections),))
               for at in range(args.connections)]
    begin = time.monotonic()
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    seconds = time.monotonic() - begin
    assert not refused, refused[:3]
    print(f"{count} submissions from {args.connections} connections: {seconds:.1f} s, {count / seconds:.0f} a second")
    for limit in (100, 1000):
        page(daemon, limit)
        all_pages(daemon, limit)
    daemon.request("DELETE", f"/v1/jobs/{blocker}")


def memory(daemon, args):
    count = args.count or 1000
    for done in range(1, count + 1):
        job = execute(daemon, **options(args, "block"))
        ended = daemon.wait(job)
        assert ended["status"] == "successful", ended
        if done in (10, 100, count // 2, count):
            print(f"after {done} jobs: {resident(daemon) / 1e6:.1f} MB resident, {descriptors(daemon)} descriptors")


def job_costs(daemon, args, watchers):
    """Of a job that so many watch: processor and wall seconds, those of the threads that tell and answer, bytes told."""
    first = execute(daemon, **options(args, "first"))  # the job waits behind it until all watch
    job = execute(daemon, **options(args, "block"))
    connections = []
    for _ in range(watchers):
        connection = http.client.HTTPConnection("127.0.0.1", daemon.port)
        connection.request("GET", f"/v1/jobs/{job}/events", headers={"Authorization": f"Bearer {daemon.token}"})
        connections.append(connection)
    sink = subprocess.Popen([sys.executable, __file__, "--drain", *(str(c.sock.fileno()) for c in connections)],
                            pass_fds=[c.sock.fileno() for c in connections], stdout=subprocess.PIPE, text=True)
    running(daemon, first)
    daemon.request("DELETE", f"/v1/jobs/{first}")
    stopped_after(daemon, first)
    before, answering, begin = processor_seconds(daemon), answering_seconds(daemon), time.monotonic()
    while daemon.request("GET", f"/v1/jobs/{job}")[2]["status"] in ("accepted", "running"):
        time.sleep(0.1)
    wall, answering = time.monotonic() - begin, answering_seconds(daemon) - answering
    told = int(sink.communicate()[0])
    for connection in connections:
        connection.close()
    return processor_seconds(daemon) - before, wall, answering, told


def drain(descriptors_given):
    """Reads what comes until all have ended: in a process of its own, for the daemon shall not wait for this one."""
    import select
    import socket
    poll, sockets, told = select.epoll(), {}, 0
    for descriptor in descriptors_given:
        sockets[descriptor] = socket.socket(fileno=descriptor)
        poll.register(descriptor, select.EPOLLIN)
    while sockets:
        for descriptor, _ in poll.poll():
            piece = sockets[descriptor].recv(65536)
            told += len(piece)
            if not piece:
                poll.unregister(descriptor)
                sockets.pop(descriptor).close()
    print(told)


def watch(daemon, args):
    alone, watched = [], []
    job_costs(daemon, args, 0)  # warm
    for _ in range(args.count or 5):
        alone.append(job_costs(daemon, args, 0))
        watched.append(job_costs(daemon, args, args.watchers))
        print(f"alone {alone[-1][0]:.2f} s of processor time, {alone[-1][1]:.2f} s; "
              f"watched {watched[-1][0]:.2f} s, {watched[-1][1]:.2f} s; telling and answering "
              f"{alone[-1][2]:.3f} s, {watched[-1][2]:.3f} s, {watched[-1][3] / 1e6:.1f} MB told", flush=True)
    for name, at in (("processor time", 0), ("wall time", 1)):
        one, other = (statistics.median(run[at] for run in runs) for runs in (alone, watched))
        print(f"{name}: {one:.2f} s alone, {other:.2f} s with {args.watchers} watchers: {(other / one - 1) * 100:+.2f} %")
    job = statistics.median(run[0] for run in alone)
    telling = statistics.median(run[2] for run in watched) - statistics.median(run[2] for run in alone)
    print(f"telling {args.watchers} watchers: {telling:.3f} s of processor time, {telling / job * 100:.2f} % of the job's")


def main():
    if sys.argv[1:2] == ["--drain"]:
        return drain(map(int, sys.argv[2:]))
    args = arguments()
    resource.setrlimit(resource.RLIMIT_NOFILE, (8192, resource.getrlimit(resource.RLIMIT_NOFILE)[1]))
    folder = pathlib.Path(tempfile.mkdtemp(prefix="bench-service-", dir=args.folder))
    try:
        os.environ["IGN"] = str(folder / "in")
        (folder / "in").mkdir()
        subprocess.run([os.environ["TESSERA"], "generate", "uniform", "-n", args.points, "-o", folder / "in/cloud.las",
                        "--quiet"], check=True)
        sys.path.insert(0, str(pathlib.Path(__file__).parents[2] / "tests/daemon"))
        from daemon import Daemon
        server = Daemon(folder / "data", "--memory", "8G", env={"TESSERAD_LIMITS_JOBS": "20000"})
        {"dismiss": dismiss, "submissions": submissions, "memory": memory, "watchers": watch}[args.what](server, args)
        server.end()
    finally:
        shutil.rmtree(folder)


if __name__ == "__main__":
    main()
