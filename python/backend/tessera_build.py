"""Makes wheels. `pip install .` (PEP 517, see pyproject.toml) and the CMake target `wheel` use this module.

A wheel contains the package and the C++ library. `pip install .` makes one for this machine: it links Debian's libraries,
which pip cannot install, and its metadata names them (Requires-External). The target `wheel` makes a self-contained one,
for any Linux that is not older than its tag says: see self_contained.py.
"""
from __future__ import annotations

import argparse
import base64
import hashlib
import io
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tarfile
import tempfile
import zipfile

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import self_contained  # noqa: E402

SOURCE = pathlib.Path(__file__).resolve().parents[2]
BYTES_MAX = 25_000_000


def build_wheel(wheel_directory, config_settings=None, metadata_directory=None):
    """Hook of PEP 517: configures and builds in build/wheel, and returns the name of the wheel."""
    build = SOURCE / "build" / "wheel"
    run("cmake", "-S", SOURCE, "-B", build, "-G", "Ninja", "-DCMAKE_BUILD_TYPE=Release", "-DTESSERA_TESTS=OFF",
        "-DTESSERA_BENCH=OFF", "-DTESSERA_PYTHON=ON", f"-DPython3_EXECUTABLE={sys.executable}")
    run("cmake", "--build", build, "--target", "tessera_python")
    return pack(build, pathlib.Path(wheel_directory), alone=False)


def build_sdist(sdist_directory, config_settings=None):
    """Hook of PEP 517: packs the files that git tracks, and returns the name of the archive."""
    name = f"tessera-{version()}"
    target = pathlib.Path(sdist_directory) / f"{name}.tar.gz"
    files = subprocess.run(["git", "-C", SOURCE, "ls-files", "-z"], check=True, capture_output=True).stdout.decode()
    with tarfile.open(target, "w:gz") as archive:
        for file in filter(None, files.split("\0")):
            archive.add(SOURCE / file, f"{name}/{file}")
        information = metadata([], about(sys.executable)["version"]).encode()
        header = tarfile.TarInfo(f"{name}/PKG-INFO")
        header.size = len(information)
        archive.addfile(header, io.BytesIO(information))
    return target.name


def build_package(build, python, cmake="cmake"):
    """Builds the Python package for another Python, with the C++ library of the finished build in the folder `build`, in
    a folder beside it. Returns the folder."""
    build = build.resolve()
    target = build.parent / f"{build.name}-python{about(python)['version']}"
    library = target / "tessera-library"
    for component in ("library", "development"):
        run(cmake, "--install", build, "--component", component, "--prefix", library)
    run(cmake, "-S", SOURCE / "python", "-B", target, "-G", "Ninja", "-DCMAKE_BUILD_TYPE=Release", f"-DPython3_EXECUTABLE={python}",
        f"-DCMAKE_PREFIX_PATH={library}")
    run(cmake, "--build", target, "--target", "tessera_python")
    return target


def pack(build, directory, cmake="cmake", alone=True, package=None, python=sys.executable):
    """Writes a wheel of the finished build in the folder `build` to `directory`. Returns the name of the wheel.

    alone: makes a self-contained wheel. package: the folder in which build_package() has built the package for `python`;
    None: `build`.
    """
    this = about(python)
    with tempfile.TemporaryDirectory() as held:
        stage = pathlib.Path(held)
        # Installing strips them, and removes the paths of the build folder.
        for component, folder in (("library", build), ("python", package or build)):
            run(cmake, "--install", folder, "--component", component, "--prefix", stage / "installed", "--strip")
        (module,) = stage.rglob("_tessera*.so")
        library = next(stage.rglob("libtessera.so.*")).resolve()
        (soname,) = self_contained.dynamic(library, "SONAME")
        library = library.replace(module.parent / soname)
        viewer = build / "python" / "tessera" / "viewer.html"  # the same for all Pythons
        if viewer.is_file():
            shutil.copy(viewer, module.parent)
        external, licences, tag = [], {}, re.sub("[-.]", "_", this["platform"])
        if alone:
            bundled = self_contained.bundle([module, library], module.parents[1] / "tessera.libs")
            licences = self_contained.licences(bundled)
            tag = self_contained.platform_tag([*module.parents[1].rglob("*.so*")])
        else:
            external = {name for path in (module, library) for name in self_contained.dynamic(path, "NEEDED")} - {soname}
        files = {str(path.relative_to(module.parents[1])): path.read_bytes()
                 for path in sorted(module.parents[1].rglob("*")) if path.is_file()}
    tag = f"{this['tag']}-{this['tag']}-{tag}"
    return write(directory / f"tessera-{version()}-{tag}.whl", files, tag, metadata(sorted(external), this["version"]), licences)


def write(target, files, tag, described, licences):
    """Writes the wheel `target` of these files, with what describes them. Returns its name."""
    information = f"tessera-{version()}.dist-info"
    files[f"{information}/METADATA"] = described.encode()
    files[f"{information}/WHEEL"] = f"Wheel-Version: 1.0\nGenerator: tessera\nRoot-Is-Purelib: false\nTag: {tag}\n".encode()
    files[f"{information}/LICENSE"] = (SOURCE / "LICENSE").read_bytes()
    files.update({f"{information}/licenses/{name}": text for name, text in licences.items()})
    record = "".join(f"{name},sha256={checksum(content)},{len(content)}\n" for name, content in sorted(files.items()))
    files[f"{information}/RECORD"] = f"{record}{information}/RECORD,,\n".encode()

    unfinished = target.with_suffix(".new")
    with zipfile.ZipFile(unfinished, "w", zipfile.ZIP_DEFLATED, compresslevel=9) as wheel:
        for name, content in files.items():
            entry = zipfile.ZipInfo(name)  # its time is in 1980, so equal contents give equal wheels
            entry.compress_type = zipfile.ZIP_DEFLATED
            entry.external_attr = (0o755 if ".so" in name else 0o644) << 16
            wheel.writestr(entry, content)
    size = unfinished.stat().st_size
    if size > BYTES_MAX:
        unfinished.unlink()
        raise ValueError(f"the wheel {target.name} would have {size} bytes, and {BYTES_MAX} are the most")
    os.replace(unfinished, target)
    return target.name


def about(python):
    """Returns the version, the tag and the platform of a Python."""
    asked = ("import json, sys, sysconfig; major, minor = sys.version_info[:2]; print(json.dumps({'version': f'{major}.{minor}', "
             "'tag': f'cp{major}{minor}', 'platform': sysconfig.get_platform()}))")
    return json.loads(subprocess.run([python, "-c", asked], check=True, capture_output=True, text=True).stdout)


def version():
    return re.search(r"project\(tessera VERSION ([0-9.]+)", (SOURCE / "CMakeLists.txt").read_text())[1]


def metadata(external, python):
    return "".join(["Metadata-Version: 2.1\nName: tessera\n", f"Version: {version()}\n",
                    "Summary: Exact Delaunay triangulations in 2D and 3D, of any size\nLicense: GPL-3.0-or-later\n",
                    f"Requires-Python: =={python}.*\nRequires-Dist: numpy>=1.20\n",
                    *(f"Requires-External: {name}\n" for name in external),
                    "Description-Content-Type: text/markdown\n\n", (SOURCE / "docs" / "python.md").read_text()])


def checksum(content):
    return base64.urlsafe_b64encode(hashlib.sha256(content).digest()).rstrip(b"=").decode()


def run(*command):
    subprocess.run([*map(str, command)], check=True, stdout=sys.stderr)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description="Makes self-contained wheels of a finished build.")
    parser.add_argument("build", type=pathlib.Path, help="the build folder")
    parser.add_argument("output", type=pathlib.Path, help="the folder for the wheels")
    parser.add_argument("pythons", nargs="*", help="also for these Pythons; they need their headers")
    parser.add_argument("--cmake", default="cmake", help="the program CMake")
    words = parser.parse_args()
    print(words.output / pack(words.build, words.output, words.cmake))
    for one in words.pythons:
        print(words.output / pack(words.build, words.output, words.cmake, True, build_package(words.build, one, words.cmake), one))
