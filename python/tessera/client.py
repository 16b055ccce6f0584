"""Jobs and results of a daemon, asked for over HTTP."""
from __future__ import annotations

import contextlib
import json
import os
import pathlib
import re
import typing
import uuid
import warnings

from ._errors import CorruptError, Error, IoError, UsageError
from ._http import Transport
from ._job import Event, Job, quoted
from ._options import Path
from ._transfer import PATIENCE_S, File, download, upload
from ._triangulation import Proof, Triangulation, open as open_folder

# Where the service calls an option otherwise than triangulate().
FIELDS = {"max_points_per_tile": "tile_points", "classes": "class", "index": "spatial_index"}
# The other file of an export of two, by what was asked for.
BESIDE = {".csv": (".vrt",), ".vrt": (".csv",)}

class Client:
    """A daemon, from connect(), whose arguments these are. All may be called from any thread."""

    def __init__(self, url: str, token: str | None = None, ca: Path | None = None):
        self._http = Transport(url, token, None if ca is None else os.fspath(ca))

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
        return self._execute("triangulate", {"inputs": _names(inputs), "output": output, **_fields(options)}, key)

    def _execute(self, process: str, inputs: dict[str, typing.Any], key: str | None = None) -> Job:
        status = self._http.ask("POST", f"/processes/{process}/execution", {"inputs": inputs},
                                {"Idempotency-Key": key or uuid.uuid4().hex, "Prefer": "respond-async"})
        return Job(self, status["jobID"])

    def verify(self, name: str, memory: int | str | None = None, against_cgal: bool = False,
               progress: typing.Callable[[Event], object] | None = None) -> Proof:
        """Has the daemon prove a result, as Triangulation.verify() does here; raises what that raises."""
        job = self._execute("verify", {"triangulation": name, **_fields({"memory": memory, "against_cgal": against_cgal})})
        job.wait(progress)
        found = job.outcome()
        try:
            return Proof(found["cells"], found["facets"], found["hull_facets"], found["vertices"], tuple(found["passed"]))
        except (KeyError, TypeError):
            raise self._http.no_tessera() from None

    def export(self, name: str, target: Path, format: str | None = None, heights: bool = True, overwrite: bool = False,
               index: bool = True, max_edge: float | None = None, progress: typing.Callable[[Event], object] | None = None,
               patience: float = PATIENCE_S) -> None:
        """Has the daemon write a result for other programs, and brings the files here; as Triangulation.export(), also in
        its arguments and what it raises and warns of. They do not stay at the daemon."""
        path = pathlib.Path(target)
        # The daemon takes a name without an ending for a folder.
        into = path.is_dir() or os.fspath(target).endswith(os.sep) or not path.suffix
        if path.exists() and not overwrite and (not into or not path.is_dir() or any(path.iterdir())):
            raise UsageError(f"{path}: exists already; overwrite=True replaces it")
        output = path.resolve().with_suffix("").name if into else path.name
        options = {"format": format, "heights": heights, "overwrite": overwrite, "spatial_index": index, "max_edge": max_edge}
        job = self._execute("export", {"triangulation": name, "output": output, **_fields(options)})
        job.wait(progress)
        found = job.outcome()
        files = f"/triangulations/{quoted(name)}/files"
        with _disk(path):
            for file, inside in _written(found, self._http.url, output, None if into else ".csv" if format == "csv" else path.suffix):
                to = path / inside if into else path.with_suffix(inside.suffix)
                to.parent.mkdir(parents=True, exist_ok=True)
                download(self._http, file._replace(path=f"{files}/{file.path}"), to, patience)
        try:
            with self._http.open("DELETE", f"{files}/exports/{quoted(output)}"):
                pass
        except Error as stays:
            warnings.warn(f"the export stays at the daemon, too: {stays}", stacklevel=2)
        if found.get("note"):
            warnings.warn(found["note"], stacklevel=2)

    def info(self, source: Path | typing.Iterable[Path], dim: int | None = None, **options: typing.Any) -> dict[str, typing.Any]:
        """As tessera.info(), of inputs as the daemon sees them, or of one of its results.

        Parameters
        ----------
        source
            Files, folders, patterns, or the name of a result, which goes first.
        dim, options
            As of submit(); and stats=True: read all points, for their classes, returns, box and density.
        """
        names = _names(source)
        inputs: dict[str, typing.Any] = {"inputs": names, **_fields({"dim": dim, **options})}
        if len(names) == 1 and "/" not in names[0]:
            try:
                self._http.ask("GET", f"/triangulations/{quoted(names[0])}")
                inputs = {"triangulation": names[0]}
            except UsageError as refused:
                if refused._http_status != 404:
                    raise
        try:
            return self._http.ask("POST", "/processes/info/execution", {"inputs": inputs})
        except UsageError as refused:
            if refused._problem_type != "urn:tessera:needs-a-job":
                raise
        job = self._execute("info", inputs)
        job.wait()
        return job.outcome()

    def upload(self, files: Path | typing.Iterable[Path], folder: str, patience: float = PATIENCE_S) -> list[str]:
        """Sends files from here, in place of what has the same names there; a connection that ends is gone on with.

        Gives what submit() and info() call them: "upload:FOLDER/FILE". UsageError when the daemon takes no uploads.
        """
        sent = []
        for name in _names(files):
            path = pathlib.Path(name)
            with _disk(path):
                upload(self._http, path, f"/uploads/{quoted(folder)}/{quoted(path.name)}", patience)
            sent.append(f"upload:{folder}/{path.name}")
        return sent

    def job(self, id: str) -> Job:
        """The job of that id. Whether there is one is told when it is asked."""
        return Job(self, id)

    def jobs(self, status: typing.Iterable[str] = ()) -> list[dict[str, typing.Any]]:
        """All jobs, as of Job.status(), or those in these states."""
        states = [status] if isinstance(status, str) else list(status)
        query = f"&status={quoted(','.join(states))}" if states else ""
        return self._http.ask_for_all(f"/jobs?limit=1000{query}", "jobs")

    def results(self) -> list[dict[str, typing.Any]]:
        """What the daemon has made: "name", "dimension", "vertices", "cells", "tiles", "bytes", "digest", ... of each."""
        return self._http.ask_for_all("/triangulations", "triangulations")

    def inputs(self, folder: str = "") -> list[dict[str, typing.Any]]:
        """The point files and folders that jobs may read: "name", "folder", "bytes", "points", "bounds", "crs", ... of each.

        Parameters
        ----------
        folder
            As the "name" of one that was listed; "upload:NAME" for what was sent there. All that the daemon reads from by default.
        """
        return self._http.ask_for_all(f"/inputs?folder={quoted(folder)}", "inputs")

    def nodes(self) -> list[dict[str, typing.Any]]:
        """Who works on the jobs: "name", "address", "state", "threads", "memoryBytes", "memoryUsedBytes", ... of each node."""
        try:
            return list(self._http.ask("GET", "/nodes")["nodes"])
        except (KeyError, TypeError):
            raise self._http.no_tessera() from None

    def drain(self, node: str) -> dict[str, typing.Any]:
        """Takes all work from a node of the cluster, by its name or id, and lets its process end: for a rolling restart.

        Gives what it was. UsageError when it is the only one, or the daemon is no cluster.
        """
        return self._http.ask("POST", f"/nodes/{quoted(node)}/drain")

    def fetch(self, name: str, folder: Path, patience: float = PATIENCE_S) -> Triangulation:
        """Copies a result into a folder here: the same as tessera.open() gives.

        The folder is new, empty, or what an earlier fetch of the same result has left, which is gone on with. Each file has
        the length and the checksum that the manifest says, and the manifest is there when all are. A connection that ends is
        gone on with; a daemon that goes away is waited for, so many seconds.
        """
        out = pathlib.Path(folder)
        path = f"/triangulations/{quoted(name)}/files"
        with self._http.open("GET", f"{path}/manifest.json") as answer:
            text = self._http.read(answer)
        try:
            manifest = json.loads(text)
            sums = dict(manifest["checksums"])
            pieces = manifest["format_version"] > 2
            wanted = [(_tile_file(tile), tile["xxh3"], int(tile["bytes"]), pieces) for tile in manifest["tiles"]]
            wanted += [(file, sums[file], None, pieces and file == "duplicates.bin") for file in sums if file == os.path.basename(file)]
        except (ValueError, KeyError, TypeError):
            raise CorruptError(f"{self._http.url}: the manifest of {name} is damaged, or is none") from None
        if _holds(out, text):
            return open_folder(out)
        with _disk(out):
            (out / "tiles").mkdir(parents=True, exist_ok=True)
            (out / "manifest.json.tmp").write_bytes(text)
            for file, checksum, size, in_pieces in wanted:
                if not (out / file).exists():
                    remote = File(f"{path}/{file}", checksum, size, f'"xxh3-{checksum}"', in_pieces)
                    download(self._http, remote, out / file, patience)
            self._fetch_report(path, out, patience)
            (out / "manifest.json.tmp").replace(out / "manifest.json")
        return open_folder(out)

    def _fetch_report(self, path: str, out: pathlib.Path, patience: float) -> None:
        """For people: a result is whole without it."""
        try:
            download(self._http, File(f"{path}/report.html", None), out / "report.html", patience)
        except UsageError:
            pass  # there is none

    def __repr__(self) -> str:
        return f"<tessera.Client of {self._http.url}>"


def _tile_file(tile: dict[str, typing.Any]) -> str:
    """The name of a tile's file, from the result folder on. ValueError for a name that no tile has."""
    name = tile.get("file") or f"tiles/{int(tile['tile']):06}.{'pts' if tile.get('kind') == 'points' else 'vtu'}"
    if not re.fullmatch(r"tiles/[0-9]{6,10}(-[0-9]{1,10})?[.](vtu|pts)", name):
        raise ValueError(name)
    return name


def _names(inputs: Path | typing.Iterable[Path]) -> list[str]:
    return [os.fspath(file) for file in ([inputs] if isinstance(inputs, (str, os.PathLike)) else inputs)]


def _fields(options: dict[str, typing.Any]) -> dict[str, typing.Any]:
    """As the service has them."""
    sent = {}
    for name, value in options.items():
        if value is None:
            continue
        if isinstance(value, os.PathLike):
            value = os.fspath(value)
        elif name == "memory":
            value = str(value)
        elif name in ("attributes", "without") and isinstance(value, str):
            value = [value]
        elif name == "columns" and isinstance(value, str):
            value = value.split(",")
        elif not isinstance(value, (str, bool, int, float)):
            value = [item.item() if hasattr(item, "item") else item for item in value]
        sent[FIELDS.get(name, name)] = value
    return sent


def _written(outcome: dict[str, typing.Any], url: str, output: str,
             suffix: str | None) -> list[tuple[File, pathlib.PurePosixPath]]:
    """The files of an export, below the result's, and what they are called here: below the folder `output`, or, with a
    suffix, `output` itself and what stands beside it. Nothing that a server says leads out of that."""
    files = []
    try:
        for entry in outcome["written"]:
            below = pathlib.PurePosixPath(entry["path"]).relative_to("exports")
            if suffix is None:
                inside = below.relative_to(output)
                fits = bool(inside.parts)
            else:
                inside = below
                fits = len(below.parts) == 1 and below.stem == pathlib.PurePosixPath(output).stem and (
                    below.name == output or below.suffix in BESIDE.get(suffix, ()))
            if not fits or ".." in below.parts or "\0" in str(below):
                raise ValueError
            files.append((File("/".join(map(quoted, ("exports", *below.parts))), entry["xxh3"], int(entry["bytes"])), inside))
    except (KeyError, TypeError, ValueError):
        raise CorruptError(f"{url}: the server does not say which files the export has written") from None
    return files


@contextlib.contextmanager
def _disk(place: pathlib.Path) -> typing.Iterator[None]:
    """What the disk refuses, as IoError."""
    try:
        yield
    except IoError:
        raise
    except OSError as error:
        raise IoError(f"{error.filename or place}: {error.strerror or error}") from None


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
    if token is None and "#token=" not in url and "?token=" not in url:
        token = os.environ.get("TESSERA_TOKEN") or None
    return Client(url, token, ca)
