"""Transfers of files from and to a daemon, continued on new connections when one ends."""
from __future__ import annotations

import os
import pathlib
import time
import typing

from . import _tessera
from ._errors import CorruptError, Error, IoError
from ._http import ConnectionLost, Transport

PATIENCE_S = 600.0


class Patience:
    """Waits for a daemon that does not answer any more, up to a given time."""

    def __init__(self, seconds: float):
        self._seconds = seconds
        self.restart()

    def restart(self) -> None:
        """Starts the time again, because the daemon has answered."""
        self._heard, self._pause = time.monotonic(), 0.25

    def wait(self, why: Error | None = None) -> None:
        """Pauses, longer each time. Raises `why` if the time is over; without `why` never raises."""
        if why is not None and time.monotonic() - self._heard > self._seconds:
            raise why
        time.sleep(self._pause)
        self._pause = min(2 * self._pause, 5.0)


class File(typing.NamedTuple):
    """A file of a daemon."""

    path: str
    """The path for Transport.open()."""
    checksum: str | None
    """The XXH3 checksum; None if it is not known. Then a download begins anew instead of continuing a partial file."""
    size: int | None = None
    etag: str | None = None
    in_pieces: bool = False
    """Whether the checksum is that of the file's pieces, as for tiles and duplicates from format 3 on."""


def download(http: Transport, file: File, to: pathlib.Path, patience_s: float) -> None:
    """Downloads a file to `to`, which appears when the file is whole and has the right checksum.

    The bytes wait in a partial file with the ending .tmp. A download continues a partial file that exists already, and
    leaves it when the daemon does not answer any more.
    """
    partial = to.with_name(to.name + ".tmp")
    while True:
        from_before = file.checksum is not None and partial.exists()
        try:
            _receive(http, file, partial, patience_s)
            if wrong := _difference(file, partial):
                raise CorruptError(f"{file.path}: {wrong}: the file was damaged on the server, or on the way")
            partial.replace(to)
            return
        except CorruptError:
            partial.unlink()
            if not from_before:  # a partial file from before may belong to another file: then try once more
                raise


def _receive(http: Transport, file: File, partial: pathlib.Path, patience_s: float) -> None:
    patience = Patience(patience_s)
    while True:
        have = partial.stat().st_size if file.checksum is not None and partial.exists() else 0
        if have and have == file.size:
            return
        headers = {"Range": f"bytes={have}-", **({"If-Range": file.etag} if file.etag else {})} if have else {}
        try:
            with http.open("GET", file.path, headers) as answer:
                goes_on = answer.status == 206 and (answer.headers.get("Content-Range") or "").startswith(f"bytes {have}-")
                if answer.status == 206 and not goes_on:
                    raise IoError(f"{http.url}: the server has sent another part of the file than it was asked for")
                with partial.open("ab" if goes_on else "wb") as out:
                    while content := http.read(answer, 1 << 20):
                        out.write(content)
            return
        except ConnectionLost as lost:
            if file.checksum is not None and partial.exists() and partial.stat().st_size != have:
                patience.restart()
            patience.wait(lost)
        except Error as refused:
            if refused._http_status == 416:
                raise CorruptError(f"{file.path}: is shorter on the server than the part of it that is here") from None
            raise


def _difference(file: File, partial: pathlib.Path) -> str | None:
    has = partial.stat().st_size
    if file.size is not None and has != file.size:
        return f"has {has} bytes on the server, not {file.size} as it says itself"
    if file.checksum is not None and (found := _tessera.file_checksum(partial, file.in_pieces)) != file.checksum:
        return f"its checksum is {found}, the server says {file.checksum}"
    return None


def upload(http: Transport, file: pathlib.Path, path: str, patience_s: float) -> None:
    """Uploads a file to a daemon. If the connection ends, the upload continues on a new one."""
    patience, again, have = Patience(patience_s), False, 0
    with file.open("rb") as source:
        size = os.fstat(source.fileno()).st_size
        while True:
            source.seek(have)
            headers = {"Content-Type": "application/octet-stream", "Content-Length": str(size - have)}
            if have:
                headers["Upload-Offset"] = str(have)
            try:
                with http.open("PUT", path, headers, source):
                    return
            except ConnectionLost as lost:
                if not again and source.tell() == have:
                    raise  # the daemon has never taken a byte: it is not there
                failed: Error = lost
            except Error as refused:
                # 409 also means that the daemon has not noticed yet that the connection has ended.
                if not again or refused._http_status != 409:
                    raise
                failed = refused
            again = True
            patience.wait(failed)
            have = _uploaded(http, path, have, size, patience)


def _uploaded(http: Transport, path: str, before: int, size: int, patience: Patience) -> int:
    """Returns how many bytes the daemon has; `before` if the daemon cannot be reached at the moment."""
    try:
        with http.open("HEAD", path) as answer:
            have = int(answer.headers.get("Upload-Offset", 0))
    except ConnectionLost:
        return before
    except Error as refused:
        if refused._http_status != 404:
            raise
        have = 0
    if have != before:
        patience.restart()
    return have if have <= size else 0  # more bytes than the file has: they are of another file
