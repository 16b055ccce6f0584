"""Jobs and results of a daemon, asked for over HTTP."""
from __future__ import annotations

import json
import os
import pathlib
import time
import typing
import urllib.parse
import uuid

from ._errors import BY_CAUSE, CorruptError, InternalError, InterruptedJobError, IoError, UsageError
from ._http import SILENCE_OF_EVENTS_S, Transport
from ._options import Path
from ._triangulation import Triangulation, open as open_folder

# Where the service calls an option otherwise than triangulate().
FIELDS = {"max_points_per_tile": "tile_points", "classes": "class"}
ENDED = ("successful", "failed", "dismissed")


class Event(typing.NamedTuple):
    """What happened to a job."""

    id: int
    """Ascending; 0 of the status that there was when the watching began."""
    kind: str
    """"status", "progress" or "log"."""
    status: dict[str, typing.Any]
    """As of Job.status(); empty for a line of the log."""
    text: str
    time: str
    """RFC 3339, UTC."""


def _quoted(name: str) -> str:
    return urllib.parse.quote(name, safe="")


class Job:
    """A job of a daemon, from Client.submit() or Client.job()."""

    def __init__(self, client: Client, id: str):
        self._client, self._http, self._path = client, client._http, f"/jobs/{_quoted(id)}"
        self._id = id

    @property
    def id(self) -> str:
        """Its name, good for Client.job() as long as the daemon knows of it."""
        return self._id

    def status(self) -> dict[str, typing.Any]:
        """What the daemon knows of it: "status" ("accepted", "running", "successful", "failed", "dismissed"), "phase",
        "progress" (percent), "triangulation" (the name of its result), "problem", ... as docs/service.md lists."""
        return self._http.ask("GET", self._path)

    def watch(self, patience: float = 600.0) -> typing.Iterator[Event]:
        """The status there is, and then events as they come, until the job has ended.

        A daemon that goes away is waited for, so many seconds; then IoError is raised. Leaving the loop leaves the job
        alone.
        """
        last: str | None = None
        heard_at: float | None = None
        pause = 0.25
        while True:
            try:
                headers = {"Accept": "text/event-stream", **({"Last-Event-ID": last} if last else {})}
                with self._http.open("GET", f"{self._path}/events", headers, timeout=SILENCE_OF_EVENTS_S) as stream:
                    if not stream.headers.get("Content-Type", "").startswith("text/event-stream"):
                        raise self._http.no_tessera()
                    heard_at, pause = time.monotonic(), 0.25
                    # Events are told from now on: what was before is in the status.
                    now = self.status()
                    yield Event(0, "status", now, "", now.get("updated", ""))
                    if now.get("status") in ENDED:
                        return
                    for last, sent in self._events(stream):
                        yield sent
                        if sent.status.get("status") in ENDED:
                            return
            except IoError:
                if heard_at is None or time.monotonic() - heard_at > patience:
                    raise
            time.sleep(pause)
            pause = min(2 * pause, 5.0)

    def _events(self, stream: typing.Any) -> typing.Iterator[tuple[str, Event]]:
        """(its id as the stream has it, the event)."""
        last, data = "", b""
        while line := self._http.line(stream):
            name, _, value = line.rstrip(b"\r\n").partition(b":")
            value = value.removeprefix(b" ")
            if name == b"data":
                data += value + b"\n"
            elif name == b"id":
                last = value.decode()
            elif not name and not value and data:
                try:
                    sent = json.loads(data)
                    event = Event(int(sent.get("id", 0)), sent.get("kind", ""), sent.get("status", {}), sent.get("text", ""),
                                  sent.get("time", ""))
                except (ValueError, TypeError, AttributeError):
                    raise self._http.no_tessera() from None
                yield last, event
                data = b""

    def wait(self, progress: typing.Callable[[Event], object] | None = None, patience: float = 600.0) -> dict[str, typing.Any]:
        """Until it is successful; its last status. `progress` is called with each event.

        Raises what made it fail, by its cause: BadInputError, MemoryLimitError, ...; InterruptedJobError when it was
        cancelled.
        """
        status: dict[str, typing.Any] = {}
        for event in self.watch(patience):
            status = event.status or status
            if progress is not None:
                progress(event)
        if status["status"] == "dismissed":
            raise InterruptedJobError(f"job {self._id} was cancelled")
        if status["status"] == "failed":
            problem = status.get("problem", {})
            raise BY_CAUSE.get(problem.get("cause", 0), InternalError)(
                problem.get("detail") or status.get("message") or f"job {self._id} has failed")
        return status

    def cancel(self) -> None:
        """Stops it, so that resume() can go on with it. UsageError when it has ended."""
        status = self.status()["status"]
        if status in ENDED:  # of one that has ended the daemon would forget that it was
            raise UsageError(f"job {self._id} has ended already: {status}")
        self._http.ask("DELETE", self._path)

    def resume(self) -> None:
        """Goes on with it after it failed or was cancelled."""
        self._http.ask("POST", f"{self._path}/resume")

    def result(self, folder: Path, progress: typing.Callable[[Event], object] | None = None) -> Triangulation:
        """wait(), and then Client.fetch() of what it made."""
        return self._client.fetch(self.wait(progress)["triangulation"], folder)

    def __repr__(self) -> str:
        return f"<tessera.Job {self._id} of {self._http.url}>"


class Client:
    """A daemon, from connect(). All may be called from any thread."""

    def __init__(self, transport: Transport):
        self._http = transport

    def submit(self, inputs: Path | typing.Iterable[Path], output: str = "", *, key: str | None = None,
               **options: typing.Any) -> Job:
        """Gives the daemon a job: to triangulate files.

        Parameters
        ----------
        inputs
            Files, folders or patterns below the folders that the daemon may read, as it sees them.
        output
            The name of the result; "": the daemon chooses one.
        key
            Submitted again with the same key and options it is the same job, also when the answer was lost.
        options
            As of tessera.triangulate(): dim, memory, crop, classes, ...; what is None or not given has the daemon's default.
        """
        files = [inputs] if isinstance(inputs, (str, os.PathLike)) else list(inputs)
        sent: dict[str, typing.Any] = {"inputs": [os.fspath(file) for file in files], "output": output}
        for name, value in options.items():
            if value is None:
                continue
            if isinstance(value, os.PathLike):
                value = os.fspath(value)
            elif name == "memory":
                value = str(value)
            elif name in ("attributes", "without") and isinstance(value, str):
                value = [value]
            elif not isinstance(value, (str, bool, int, float)):
                value = [item.item() if hasattr(item, "item") else item for item in value]
            sent[FIELDS.get(name, name)] = value
        status = self._http.ask("POST", "/processes/triangulate/execution", {"inputs": sent},
                                {"Idempotency-Key": key or uuid.uuid4().hex})
        return Job(self, status["jobID"])

    def job(self, id: str) -> Job:
        """The job of that id. Whether there is one is told when it is asked."""
        return Job(self, id)

    def jobs(self, status: typing.Iterable[str] = ()) -> list[dict[str, typing.Any]]:
        """All jobs, as of Job.status(), or those in these states."""
        states = [status] if isinstance(status, str) else list(status)
        query = f"&status={_quoted(','.join(states))}" if states else ""
        return self._http.ask_for_all(f"/jobs?limit=1000{query}", "jobs")

    def results(self) -> list[dict[str, typing.Any]]:
        """What the daemon has made: "name", "dimension", "vertices", "cells", "tiles", "bytes", "digest", ... of each."""
        return self._http.ask_for_all("/triangulations", "triangulations")

    def fetch(self, name: str, folder: Path) -> Triangulation:
        """Copies a result into a folder here: the same as tessera.open() gives.

        The folder is new, empty, or what an earlier fetch of the same result has left, which is gone on with. The manifest
        is there when all files are. Each has the length and the name of its content (ETag) that the manifest says;
        Triangulation.verify() also reads them.
        """
        out = pathlib.Path(folder)
        path = f"/triangulations/{_quoted(name)}/files"
        with self._http.open("GET", f"{path}/manifest.json") as answer:
            text = self._http.read(answer)
        try:
            manifest = json.loads(text)
            sums = dict(manifest["checksums"])
            ending = ".vtkhdf" if manifest["format_version"] == 1 else ".vtu"
            wanted = [(f"tiles/{int(tile['tile']):06}{ending}", tile["xxh3"], int(tile["bytes"])) for tile in manifest["tiles"]]
            wanted += [(file, sums[file], None) for file in sums if file == os.path.basename(file)]
        except (ValueError, KeyError, TypeError):
            raise CorruptError(f"{self._http.url}: the manifest of {name} is damaged, or is none") from None
        if _holds(out, text):
            return open_folder(out)
        try:
            (out / "tiles").mkdir(parents=True, exist_ok=True)
            (out / "manifest.json.tmp").write_bytes(text)
            for file, checksum, size in wanted:
                if not (out / file).exists():
                    self._http.download(f"{path}/{file}", out / file, f'"xxh3-{checksum}"', size)
            self._fetch_report(path, out)
            (out / "manifest.json.tmp").replace(out / "manifest.json")
        except OSError as error:
            if isinstance(error, IoError):
                raise
            raise IoError(f"{error.filename or out}: {error.strerror}") from None
        return open_folder(out)

    def _fetch_report(self, path: str, out: pathlib.Path) -> None:
        """For people: a result is whole without it."""
        try:
            self._http.download(f"{path}/report.html", out / "report.html", None, None)
        except UsageError:
            pass  # there is none

    def __repr__(self) -> str:
        return f"<tessera.Client of {self._http.url}>"


def _holds(out: pathlib.Path, manifest: bytes) -> bool:
    """Whether the folder holds that result already. UsageError when it holds anything else but the beginning of it."""
    for name, finished in (("manifest.json", True), ("manifest.json.tmp", False)):
        if (out / name).exists():
            if (out / name).read_bytes() == manifest:
                return finished
            raise UsageError(f"{out}: holds another result; name a new or empty folder")
    if out.exists() and (not out.is_dir() or any(out.iterdir())):
        raise UsageError(f"{out}: is not empty; name a new or empty folder")
    return False


def connect(url: str, token: str | None = None, ca: Path | None = None) -> Client:
    """A daemon to ask.

    Parameters
    ----------
    url
        "http://127.0.0.1:7070", also as the daemon prints it, with its token.
    token
        None: that of the url, or of the environment variable TESSERA_TOKEN.
    ca
        For https: a PEM file with the certificates to trust. None: those of the system.

    Nothing is sent before something is asked. Errors are those of tessera.Error: IoError when the daemon cannot be reached,
    UsageError when it refuses the token or is none, and what it answers by its cause.
    """
    if token is None and "?token=" not in url:
        token = os.environ.get("TESSERA_TOKEN") or None
    return Client(Transport(url, token, None if ca is None else os.fspath(ca)))
