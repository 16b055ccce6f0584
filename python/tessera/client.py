"""The client of a daemon: submits jobs and fetches results over HTTP."""
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
from ._heights import HeightsFile
from ._http import Transport
from ._job import Event, Job, quoted
from ._live import Live
from ._options import Path
from ._transfer import PATIENCE_S, File, download, upload
from ._triangulation import Measures, Proof, Triangulation, open as open_folder
from ._volumes import VolumeTable, table_of
from ._voronoi import VoronoiFile
from ._viewer import ViewerLink

# The options of triangulate() that have another name in the service.
FIELDS = {"max_points_per_tile": "tile_points", "classes": "class", "scans": "scan", "index": "spatial_index"}
# Exports of two files: the ending of the other file, by the ending of the file that was asked for.
BESIDE = {".vol": (".adj",), ".adj": (".vol",), ".csv": (".vrt",), ".vrt": (".csv",)}

class Client:
    """A client of a daemon, from connect(), which has the same arguments. All methods may be called from any thread."""

    def __init__(self, url: str, token: str | None = None, ca: Path | None = None):
        self._http = Transport(url, token, None if ca is None else os.fspath(ca))

    def submit(self, inputs: Path | typing.Iterable[Path], output: str = "", *, key: str | None = None,
               **options: typing.Any) -> Job:
        """Submits a job to the daemon: to triangulate files.

        Parameters
        ----------
        inputs
            Files, folders or patterns, by the names that the daemon has for them, below the folders that it may read.
        output
            The name of the result. "": the daemon chooses a name.
        key
            A job that is submitted again with the same key and options is the same job, also if the answer was lost.
        options
            As for tessera.triangulate(): dim, memory, crop, classes, ... Options that are None or not given have the
            daemon's defaults.
        """
        return self._execute("triangulate", {"inputs": _names(inputs), "output": output, **_fields(options)}, key)

    def _execute(self, process: str, inputs: dict[str, typing.Any], key: str | None = None) -> Job:
        status = self._http.ask("POST", f"/processes/{process}/execution", {"inputs": inputs},
                                {"Idempotency-Key": key or uuid.uuid4().hex, "Prefer": "respond-async"})
        return Job(self, status["jobID"])

    def verify(self, name: str, memory: int | str | None = None, against_cgal: bool = False,
               progress: typing.Callable[[Event], object] | None = None) -> Proof:
        """Lets the daemon prove a result, as Triangulation.verify() does here. Raises the same errors."""
        job = self._execute("verify", {"triangulation": name, **_fields({"memory": memory, "against_cgal": against_cgal})})
        job.wait(progress)
        found = job.outcome()
        try:
            return Proof(found["cells"], found["facets"], found["hull_facets"], found["vertices"], tuple(found["passed"]))
        except (KeyError, TypeError):
            raise self._http.no_tessera() from None

    def export(self, name: str, target: Path, format: str | None = None, heights: bool = True, overwrite: bool = False,
               index: bool = True, max_edge: float | None = None, progress: typing.Callable[[Event], object] | None = None,
               patience: float = PATIENCE_S, max_radius: float | None = None, names: typing.Sequence[str] = ()) -> None:
        """Lets the daemon write a result for other programs, and downloads the files. They do not stay at the daemon.

        Arguments, errors and warnings are those of Triangulation.export(). `progress` is called with each event of the
        job. `patience` is how many seconds to wait for a daemon that does not answer any more.
        """
        path = pathlib.Path(target)
        # For the daemon a name without an ending is a folder.
        into = path.is_dir() or os.fspath(target).endswith(os.sep) or not path.suffix
        if path.exists() and not overwrite and (not into or not path.is_dir() or any(path.iterdir())):
            raise UsageError(f"{path}: exists already; overwrite=True replaces it")
        output = path.resolve().with_suffix("").name if into else path.name
        options = {"format": format, "heights": heights, "overwrite": overwrite, "spatial_index": index, "max_edge": max_edge, "max_radius": max_radius,
                   "names": list(names) or None}
        job = self._execute("export", {"triangulation": name, "output": output, **_fields(options)})
        job.wait(progress)
        found = job.outcome()
        files = f"/triangulations/{quoted(name)}/files"
        with _disk(path):
            for file, inside in _written(found, self._http.url, output, None if into else ".csv" if format == "csv" else path.suffix):
                to = path / inside if into else path.with_suffix(inside.suffix)
                to.parent.mkdir(parents=True, exist_ok=True)
                download(self._http, file._replace(path=f"{files}/{file.path}"), to, patience)
        self._remove(f"{files}/exports/{quoted(output)}")
        if found.get("note"):
            warnings.warn(found["note"], stacklevel=2)

    def measure(self, name: str, volume: bool = False, quality: bool = False, voronoi: bool = False,
                memory: int | str | None = None, progress: typing.Callable[[Event], object] | None = None, *,
                density: bool = False, mass: str | None = None) -> Measures:
        """Lets the daemon compute columns of a result, as Triangulation.measure() does here.

        They become a new version of the result. Only the owner of the result or an admin may do this.
        """
        options = {"volume": volume, "quality": quality, "voronoi": voronoi, "density": density, "mass": mass, "memory": memory}
        job = self._execute("measure", {"triangulation": name, **_fields(options)})
        job.wait(progress)
        found = job.outcome()
        try:
            measures = Measures(float(found["total"] or 0), str(found["unit"]), bool(found["made"]))
        except (KeyError, TypeError, ValueError):
            raise self._http.no_tessera() from None
        if found.get("note"):
            warnings.warn(found["note"], stacklevel=2)
        return measures

    def update(self, name: str, add: Path | typing.Iterable[Path] = (), *, remove_ids: typing.Iterable[int] | str | None = None,
               remove_class: typing.Iterable[int] | None = None, remove_box: typing.Iterable[float] | None = None,
               remove_polygon: Path | None = None, remove_time: tuple[float, float] | None = None,
               remove_input: Path | typing.Iterable[Path] = (), replace: bool = False, output: str | None = None,
               overwrite: bool = False, keep_versions: int | None = None, dry_run: bool = False, recursive: bool = False,
               memory: int | str | None = None, progress: typing.Callable[[Event], object] | None = None) -> dict[str, typing.Any]:
        """Lets the daemon remove points of a result and add others, and returns what has changed.

        Until the change is made, everybody reads the version before it. Only the owner of the result or an admin may
        change it.

        Parameters
        ----------
        add
            Files, folders or patterns of the daemon, as for submit(), whose points are added.
        remove_class, remove_box, remove_time, remove_input
            Points that are removed: by LAS class, in a box of 4 or 6 numbers, from the first to the
            second gps_time, and those that came from these files.
        remove_ids
            Source indices, or the name of a NumPy file of the daemon with many of them.
        remove_polygon
            A GeoJSON file here: the points in its polygons are removed.
        replace
            New points take the places of all points with the same coordinates.
        output
            The name of a new result; `overwrite` replaces one of that name. None: the result gets a new version.
        keep_versions
            How many of the newest versions stay readable, also after later changes. None: as before, at first 1.
        dry_run
            Change nothing, and tell what would change.
        recursive
            Also add the files in subfolders.

        Returns a dict of "version", "removed", "added", "first_new_id", "tiles_changed", "vertices", "cells", "digest",
        ...: those that `tessera update --json` prints.
        """
        polygon = None if remove_polygon is None else _polygons("remove_polygon", remove_polygon)
        named = isinstance(remove_ids, str)
        options = {"remove_ids_file" if named else "remove_ids": remove_ids, "remove_class": remove_class, "remove_box": remove_box,
                   "remove_polygon": polygon, "remove_time": remove_time, "replace": replace, "output": output,
                   "overwrite": overwrite, "keep_versions": keep_versions, "dry_run": dry_run, "recursive": recursive,
                   "memory": memory}
        inputs = {"triangulation": name, "inputs": _names(add), "remove_input": _names(remove_input), **_fields(options)}
        job = self._execute("update", inputs)
        job.wait(progress)
        return job.outcome()

    def versions(self, name: str) -> list[dict[str, typing.Any]]:
        """Returns the versions of a result, the oldest first, each a dict of "version", "time", "readable", "added",
        "removed", "vertices", "cells", "digest", ..."""
        try:
            return list(self._http.ask("GET", f"/triangulations/{quoted(name)}/versions")["versions"])
        except (KeyError, TypeError):
            raise self._http.no_tessera() from None

    def hag(self, inputs: Path | typing.Iterable[Path], ground: str, folder: Path, *, format: str | None = None,
            outside: float | None = None, replace: bool = False, overwrite: bool = False,
            memory: int | str | None = None, progress: typing.Callable[[Event], object] | None = None,
            patience: float = PATIENCE_S) -> list[HeightsFile]:
        """Lets the daemon copy LAS and LAZ files with heights above the ground, and downloads the copies.

        They do not stay at the daemon. `inputs` are files of the daemon, as for submit(); `ground` is the name of a 2D
        result of the daemon. Other arguments are those of tessera.hag(). `progress` is called with each event of the
        job. `patience` is how many seconds to wait for a daemon that does not answer any more.
        """
        out, output = pathlib.Path(folder), uuid.uuid4().hex
        options = {"format": format, "outside": outside, "replace": replace, "memory": memory}
        job = self._execute("hag", {"inputs": _names(inputs), "triangulation": ground, "output": output, **_fields(options)})
        job.wait(progress)
        found = job.outcome()
        written = _written(found, self._http.url, output, None)
        try:
            made = [HeightsFile(pathlib.Path(each["input"]), out / pathlib.PurePosixPath(each["output"]).name,
                                int(each["points"]), int(each["outside"])) for each in found["files"]]
        except (KeyError, TypeError, ValueError):
            raise self._http.no_tessera() from None
        files = f"/triangulations/{quoted(ground)}/files"
        try:
            with _disk(out):
                for _, inside in written:
                    if (out / inside).exists() and not overwrite:
                        raise UsageError(f"{out / inside}: exists already; overwrite=True replaces it")
                for file, inside in written:
                    (out / inside).parent.mkdir(parents=True, exist_ok=True)
                    download(self._http, file._replace(path=f"{files}/{file.path}"), out / inside, patience)
        finally:
            self._remove(f"{files}/exports/{quoted(output)}")
        return made

    def voronoi(self, name: str, target: Path, clip: str | Path | typing.Sequence[float] | None = None, *,
                overwrite: bool = False, memory: int | str | None = None,
                progress: typing.Callable[[Event], object] | None = None, patience: float = PATIENCE_S) -> VoronoiFile:
        """Lets the daemon write the Voronoi cells of a result, and downloads the file, as Triangulation.voronoi() does
        here.

        The file does not stay at the daemon. A file of polygons for `clip` is a GeoJSON file here. `progress` is called
        with each event of the job. `patience` is how many seconds to wait for a daemon that does not answer any more.
        """
        if clip is not None and not (isinstance(clip, str) and clip in ("hull", "none")):
            box = not isinstance(clip, (str, os.PathLike))
            clip = ",".join(repr(float(x)) for x in clip) if box else _polygons("clip", clip)
        found = self._make("voronoi", name, target, overwrite, {"clip": clip, "memory": memory}, progress, patience)
        try:
            size = found["area"] if found["dimension"] == 2 else found["volume"]
            return VoronoiFile(int(found["cells"]), int(found["unbounded"]), int(found["outside"]), float(size))
        except (KeyError, TypeError, ValueError):
            raise self._http.no_tessera() from None

    def density(self, name: str, target: Path, *, res: float, mass: str | None = None, field: str | None = None,
                divergence: typing.Iterable[str] | None = None, curl: typing.Iterable[str] | None = None,
                sample: bool = False, bbox: typing.Iterable[float] | None = None, overwrite: bool = False,
                memory: int | str | None = None, progress: typing.Callable[[Event], object] | None = None,
                patience: float = PATIENCE_S) -> None:
        """Lets the daemon put the density of the points of a result, or a field, on a grid, and downloads the file.

        Arguments and warnings are those of Triangulation.density() with a path; others as for voronoi().
        """
        options = {"res": float(res), "mass": mass, "field": field, "divergence": divergence, "curl": curl, "sample": sample,
                   "bbox": bbox, "memory": memory}
        self._make("density", name, target, overwrite, options, progress, patience)

    def alpha(self, name: str, target: Path, *, alpha: float | typing.Literal["auto"] = "auto", general: bool = False,
              overwrite: bool = False, memory: int | str | None = None,
              progress: typing.Callable[[Event], object] | None = None, patience: float = PATIENCE_S) -> float:
        """Lets the daemon write the alpha shape of a result, and downloads the file. Returns the radius.

        Arguments are those of Triangulation.alpha_shape() with a path; others as for voronoi().
        """
        if isinstance(alpha, str) and alpha != "auto":
            raise UsageError(f"alpha: must be a radius or 'auto', not {alpha!r}")
        options = {"alpha": None if isinstance(alpha, str) else float(alpha), "general": general, "memory": memory}
        found = self._make("alpha", name, target, overwrite, options, progress, patience)
        try:
            return float(found["radius"])
        except (KeyError, TypeError, ValueError):
            raise self._http.no_tessera() from None

    def volume(self, name: str, target: Path, other: str | None = None, *, plane: float | None = None,
               base: Path | None = None, within: Path | None = None, polygon_name: str | None = None,
               max_edge: float | None = None, max_radius: float | None = None, value: str | None = None,
               overwrite: bool = False, memory: int | str | None = None,
               progress: typing.Callable[[Event], object] | None = None, patience: float = PATIENCE_S) -> VolumeTable:
        """Lets the daemon compute the volumes from the surface of a result to another one, downloads the table, a .csv,
        .json or .gpkg, and returns it as Triangulation.volume() does.

        `name` and `other` are results of the daemon. `base` and `within` are GeoJSON files here. `polygon_name` is the
        argument `name` of Triangulation.volume(). Other arguments are those of it, or as for voronoi().
        """
        options = {"second": other, "plane": plane, "base": base and _polygons("base", base),
                   "within": within and _polygons("within", within), "name": polygon_name, "max_edge": max_edge,
                   "max_radius": max_radius, "value": value, "memory": memory}
        found = self._make("volume", name, target, overwrite, options, progress, patience)
        try:
            return table_of(found["rows"], str(found["area_unit"]), str(found["volume_unit"]))
        except (KeyError, TypeError, ValueError):
            raise self._http.no_tessera() from None

    def _make(self, process: str, name: str, target: Path, overwrite: bool, options: dict[str, typing.Any],
              progress: typing.Callable[[Event], object] | None, patience: float) -> dict[str, typing.Any]:
        """Lets the daemon make a file of a result, downloads the file, and returns the outcome of the job.

        At the daemon the file has a unique name, so that it replaces no file of another user.
        """
        path = pathlib.Path(target)
        if path.is_dir():
            raise UsageError(f"{path}: is a folder")
        if path.exists() and not overwrite:
            raise UsageError(f"{path}: exists already; overwrite=True replaces it")
        output = uuid.uuid4().hex + path.suffix
        job = self._execute(process, {"triangulation": name, "output": output, **_fields(options)})
        job.wait(progress)
        found = job.outcome()
        written = _written(found, self._http.url, output, path.suffix)
        if len(written) != 1:
            raise CorruptError(f"{self._http.url}: the server does not say which file the job has written")
        files = f"/triangulations/{quoted(name)}/files"
        try:
            with _disk(path):
                file = written[0][0]
                download(self._http, file._replace(path=f"{files}/{file.path}"), path, patience)
        finally:
            self._remove(f"{files}/exports/{quoted(output)}")
        if found.get("note"):
            warnings.warn(found["note"], stacklevel=3)
        return found

    def _remove(self, path: str) -> None:
        try:
            with self._http.open("DELETE", path):
                pass
        except Error as stays:
            warnings.warn(f"the daemon could not remove its copy of the export: {stays}", stacklevel=3)

    def info(self, source: Path | typing.Iterable[Path], dim: int | None = None, **options: typing.Any) -> dict[str, typing.Any]:
        """Returns what tessera.info() does, for files that the daemon can read, or for one of its results.

        Parameters
        ----------
        source
            Files, folders, patterns, or the name of a result. A name that both a result and a file have is the result.
        dim, options
            As for submit(). stats=True reads all points, for their classes, returns, box and density.
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
        """Uploads files to a folder of the daemon. They replace files of the same names there.

        If the connection ends, the upload continues on a new one. Returns the names of the files for submit() and
        info(): "upload:FOLDER/FILE". Raises UsageError if the daemon takes no uploads.
        """
        sent = []
        for name in _names(files):
            path = pathlib.Path(name)
            with _disk(path):
                upload(self._http, path, f"/uploads/{quoted(folder)}/{quoted(path.name)}", patience)
            sent.append(f"upload:{folder}/{path.name}")
        return sent

    def job(self, id: str) -> Job:
        """Returns the job with this id. If there is no such job, the job's methods raise UsageError."""
        return Job(self, id)

    def jobs(self, status: typing.Iterable[str] = ()) -> list[dict[str, typing.Any]]:
        """Returns the status of all jobs, as Job.status() does, or only of jobs with one of these states."""
        states = [status] if isinstance(status, str) else list(status)
        query = f"&status={quoted(','.join(states))}" if states else ""
        return self._http.ask_for_all(f"/jobs?limit=1000{query}", "jobs")

    def results(self) -> list[dict[str, typing.Any]]:
        """Returns the results of the daemon, each a dict of "name", "dimension", "vertices", "cells", "tiles", "bytes",
        "digest", ..."""
        return self._http.ask_for_all("/triangulations", "triangulations")

    def view(self, name: str) -> ViewerLink:
        """Returns a link to the daemon's viewer of a result (docs/viewer.md), which notebooks show. The viewer opens in a
        page of its own, because the daemon lets no other page embed it."""
        return ViewerLink(name, f"{self._http.url}/ui/#/view/{quoted(name)}")

    def inputs(self, folder: str = "") -> list[dict[str, typing.Any]]:
        """Returns the point files and folders that jobs may read, each a dict of "name", "folder", "bytes", "points",
        "bounds", "crs", ...

        Parameters
        ----------
        folder
            The "name" of a folder from an earlier list, or "upload:NAME" for a folder of uploads. "": all folders that
            the daemon may read.
        """
        return self._http.ask_for_all(f"/inputs?folder={quoted(folder)}", "inputs")

    def live(self, name: str) -> Live:
        """Returns a result that the daemon keeps in memory, so that points can be added and removed. Sends nothing."""
        return Live(self, name)

    def nodes(self) -> list[dict[str, typing.Any]]:
        """Returns the nodes that work on jobs, each a dict of "name", "address", "state", "threads", "memoryBytes",
        "memoryUsedBytes", ..."""
        try:
            return list(self._http.ask("GET", "/nodes")["nodes"])
        except (KeyError, TypeError):
            raise self._http.no_tessera() from None

    def drain(self, node: str) -> dict[str, typing.Any]:
        """Takes all work from a node of the cluster, and lets its process end, for a rolling restart.

        `node` is the name or id of the node. Returns its state, as from nodes(). Raises UsageError if it is the only
        node, or if the daemon is no cluster.
        """
        return self._http.ask("POST", f"/nodes/{quoted(node)}/drain")

    def fetch(self, name: str, folder: Path, patience: float = PATIENCE_S) -> Triangulation:
        """Copies a result into a folder here, and returns it as tessera.open() does.

        The folder must be new, empty, or left by an earlier fetch of the same result, which fetch() then continues.
        Each file is compared with the length and the checksum in the manifest, and the manifest appears last. If the
        connection ends, fetch() continues on a new one. If the daemon does not answer, fetch() waits for it, `patience`
        seconds at most.
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
            wanted += [(file, sums[file], None, pieces and file.startswith("duplicate")) for file in sums if file == os.path.basename(file)]
        except (ValueError, KeyError, TypeError):
            raise CorruptError(f"{self._http.url}: the manifest of {name} is damaged, or is not a manifest") from None
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
        """Downloads the report, if there is one. A result is complete without it."""
        try:
            download(self._http, File(f"{path}/report.html", None), out / "report.html", patience)
        except UsageError:
            pass  # there is none

    def __repr__(self) -> str:
        return f"<tessera.Client of {self._http.url}>"


def _tile_file(tile: dict[str, typing.Any]) -> str:
    """Returns the name of a tile's file, relative to the result folder. Raises ValueError for an impossible name."""
    name = tile.get("file") or f"tiles/{int(tile['tile']):06}.{'pts' if tile.get('kind') == 'points' else 'vtu'}"
    if not re.fullmatch(r"tiles/[0-9]{6,10}(-[0-9]{1,10})?[.](vtu|pts)", name):
        raise ValueError(name)
    return name


def _names(inputs: Path | typing.Iterable[Path]) -> list[str]:
    return [os.fspath(file) for file in ([inputs] if isinstance(inputs, (str, os.PathLike)) else inputs)]


def _fields(options: dict[str, typing.Any]) -> dict[str, typing.Any]:
    """Returns the options with the names and types of the service."""
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


def _polygons(option: str, file: Path) -> str:
    """Returns the text of a GeoJSON file, which a daemon takes in a request."""
    path = pathlib.Path(file)
    if path.suffix not in (".geojson", ".json"):
        raise UsageError(f"{option}: a daemon takes polygons as GeoJSON, and {path} does not end in .geojson")
    with _disk(path):
        try:
            return path.read_text(encoding="utf-8")
        except UnicodeDecodeError:
            raise UsageError(f"{option}: {path} is not GeoJSON, because it is not UTF-8") from None


def _written(outcome: dict[str, typing.Any], url: str, output: str,
             suffix: str | None) -> list[tuple[File, pathlib.PurePosixPath]]:
    """Returns the files of an export, with their names here.

    With a suffix these are `output` itself and files beside it, else files below the folder `output`. A server cannot
    name a file outside of that: other paths raise CorruptError.
    """
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
    """Turns an OSError of the disk into an IoError."""
    try:
        yield
    except IoError:
        raise
    except OSError as error:
        raise IoError(f"{error.filename or place}: {error.strerror or error}") from None


def _holds(out: pathlib.Path, manifest: bytes) -> bool:
    """Returns whether the folder holds this result already. Raises UsageError if it holds anything but a part of it."""
    for name, finished in (("manifest.json", True), ("manifest.json.tmp", False)):
        if (out / name).exists():
            if (out / name).read_bytes() == manifest:
                return finished
            raise UsageError(f"{out}: holds another result; name a new or empty folder")
    if out.exists() and (not out.is_dir() or any(out.iterdir())):
        raise UsageError(f"{out}: is not empty; name a new or empty folder")
    return False


def connect(url: str, token: str | None = None, ca: Path | None = None) -> Client:
    """Returns a client of a daemon.

    Parameters
    ----------
    url
        The address of the daemon, "http://127.0.0.1:7070", or the address with its token, as the daemon prints it.
    token
        None: the token in the url, or else the environment variable TESSERA_TOKEN.
    ca
        For https: a PEM file with the certificates to trust. None: those of the system.

    connect() itself sends nothing. Methods of the client raise IoError if the daemon cannot be reached, UsageError if
    it refuses the token or is no Tessera daemon, and otherwise an Error of the cause that the daemon answers.
    """
    if token is None and "#token=" not in url and "?token=" not in url:
        token = os.environ.get("TESSERA_TOKEN") or None
    return Client(url, token, ca)
