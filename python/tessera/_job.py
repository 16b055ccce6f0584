"""Jobs of a daemon, and their events."""
from __future__ import annotations

import json
import typing
import urllib.parse

from ._errors import BY_CAUSE, Error, InternalError, InterruptedJobError, IoError, UsageError
from ._html import bar, table
from ._http import SILENCE_OF_EVENTS_S, Transport
from ._options import Path
from ._transfer import PATIENCE_S, Patience
from ._triangulation import Triangulation

if typing.TYPE_CHECKING:
    from .client import Client

ENDED = ("successful", "failed", "dismissed")


class Event(typing.NamedTuple):
    """An event in the life of a job."""

    id: int
    """Ascending numbers; 0 for the status at the beginning of Job.watch()."""
    kind: str
    """"status", "progress" or "log"."""
    status: dict[str, typing.Any]
    """The status of the job, as from Job.status(); empty for a line of the log."""
    text: str
    time: str
    """The time of the event, as in RFC 3339, in UTC."""


def quoted(name: str) -> str:
    return urllib.parse.quote(name, safe="")


def share_of_status(status: dict[str, typing.Any]) -> float:
    """Returns how much of a job is done, from 0 to 1."""
    percent = status.get("progress")
    return 1.0 if status.get("status") == "successful" else float(percent) / 100 if isinstance(percent, (int, float)) else 0.0


def sent_events(http: Transport, stream: typing.Any) -> typing.Iterator[tuple[str, dict[str, typing.Any]]]:
    """Yields (id as text, data) for each event of a stream."""
    last, data = "", b""
    while line := http.line(stream):
        name, _, value = line.rstrip(b"\r\n").partition(b":")
        value = value.removeprefix(b" ")
        if name == b"data":
            data += value + b"\n"
        elif name == b"id":
            last = value.decode()
        elif not name and not value and data:
            try:
                sent = json.loads(data)
            except ValueError:
                sent = None
            if not isinstance(sent, dict):
                raise http.no_tessera()
            yield last, sent
            data = b""


class Job:
    """A job of a daemon, from Client.submit() or Client.job()."""

    def __init__(self, client: Client, id: str):
        self._client, self._http, self._path = client, client._http, f"/jobs/{quoted(id)}"
        self._id = id

    @property
    def id(self) -> str:
        """The id of the job. Client.job() takes it as long as the daemon knows the job."""
        return self._id

    def status(self) -> dict[str, typing.Any]:
        """Returns the status of the job as a dict; docs/service.md lists all its members.

        Among them are "status" ("accepted", "running", "successful", "failed" or "dismissed"), "phase", "progress" (in
        percent), "triangulation" (the name of the result) and "problem".
        """
        return self._http.ask("GET", self._path)

    def watch(self, patience: float = PATIENCE_S) -> typing.Iterator[Event]:
        """Yields the present status, and then events as they come, until the job has ended.

        If the daemon does not answer any more, watch() waits for it, `patience` seconds at most, and then raises
        IoError. The job goes on when you leave the loop.
        """
        last: str | None = None
        waiting = Patience(patience)
        while True:
            try:
                headers = {"Accept": "text/event-stream", **({"Last-Event-ID": last} if last else {})}
                with self._http.open("GET", f"{self._path}/events", headers, timeout=SILENCE_OF_EVENTS_S) as stream:
                    if not stream.headers.get("Content-Type", "").startswith("text/event-stream"):
                        raise self._http.no_tessera()
                    waiting.restart()
                    # The stream has only events from now on. The status has what happened before.
                    now = self.status()
                    yield Event(0, "status", now, "", now.get("updated", ""))
                    if now.get("status") in ENDED:
                        return
                    for last, sent in self._events(stream):
                        yield sent
                        if sent.status.get("status") in ENDED:
                            return
            except IoError as gone:
                if not self._http.heard:
                    raise
                waiting.wait(gone)
            else:
                waiting.wait()

    def _events(self, stream: typing.Any) -> typing.Iterator[tuple[str, Event]]:
        """Yields (id as text, event) for each event of the stream."""
        for last, sent in sent_events(self._http, stream):
            try:
                event = Event(int(sent.get("id", 0)), sent.get("kind", ""), sent.get("status", {}), sent.get("text", ""),
                              sent.get("time", ""))
            except (ValueError, TypeError):
                raise self._http.no_tessera() from None
            yield last, event

    def wait(self, progress: typing.Callable[[Event], object] | None = None, patience: float = PATIENCE_S) -> dict[str, typing.Any]:
        """Waits until the job is successful, and returns its last status. Calls `progress` with each event.

        If the job fails, raises an Error of the same cause: BadInputError, MemoryLimitError, ... Raises
        InterruptedJobError if the job was cancelled.
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

    def outcome(self) -> dict[str, typing.Any]:
        """Returns the outcome of a successful verify, export or info job."""
        found = self._http.ask("GET", f"{self._path}/results").get("outcome", {})
        value = found.get("value") if isinstance(found, dict) else None
        if not isinstance(value, dict):
            raise self._http.no_tessera()
        return value

    def cancel(self) -> None:
        """Stops the job. resume() can continue it later. Raises UsageError if the job has ended."""
        status = self.status()["status"]
        if status in ENDED:  # a DELETE would make the daemon forget a job that has ended
            raise UsageError(f"job {self._id} has ended already: {status}")
        self._http.ask("DELETE", self._path)

    def resume(self) -> None:
        """Continues a job that has failed or was cancelled."""
        self._http.ask("POST", f"{self._path}/resume")

    def result(self, folder: Path, progress: typing.Callable[[Event], object] | None = None) -> Triangulation:
        """Waits for the job as wait() does, then copies its result into `folder`, as Client.fetch() does."""
        return self._client.fetch(self.wait(progress)["triangulation"], folder)

    def _repr_html_(self) -> str:
        """What notebooks show: the present status, or why the daemon does not tell it."""
        try:
            status = self.status()
        except Error as error:
            return table(f"Job {self._id}", {"daemon": self._http.url, "status": f"not known: {error}"})
        shown = {"daemon": self._http.url, "process": status.get("processID"), "status": status.get("status"), "phase": status.get("phase"),
                 "result": status.get("triangulation"), "message": status.get("message")}
        running = status.get("status") not in ENDED
        return table(f"Job {self._id}", shown) + (bar(share_of_status(status), "") if running else "")

    def __repr__(self) -> str:
        return f"<tessera.Job {self._id} of {self._http.url}>"
