"""Makes wheels. `pip install .` (PEP 517, see pyproject.toml) and the CMake target `wheel` use this module.

A wheel contains the package and the C++ library. The other libraries that it links are Debian's, which pip cannot
install; the wheel's metadata names them (Requires-External).
"""
from __future__ import annotations

import base64
import hashlib
import io
import os
import pathlib
import re
import subprocess
import sys
import sysconfig
import tarfile
import tempfile
import zipfile

SOURCE = pathlib.Path(__file__).resolve().parents[2]


def build_wheel(wheel_directory, config_settings=None, metadata_directory=None):
    """Hook of PEP 517: configures and builds in build/wheel, and returns the name of the wheel."""
    build = SOURCE / "build" / "wheel"
    run("cmake", "-S", SOURCE, "-B", build, "-G", "Ninja", "-DCMAKE_BUILD_TYPE=Release", "-DTESSERA_TESTS=OFF",
        "-DTESSERA_BENCH=OFF", "-DTESSERA_PYTHON=ON", f"-DPython3_EXECUTABLE={sys.executable}")
    run("cmake", "--build", build, "--target", "tessera_python")
    return pack(build, pathlib.Path(wheel_directory))


def build_sdist(sdist_directory, config_settings=None):
    """Hook of PEP 517: packs the files that git tracks, and returns the name of the archive."""
    name = f"tessera-{version()}"
    target = pathlib.Path(sdist_directory) / f"{name}.tar.gz"
    files = subprocess.run(["git", "-C", SOURCE, "ls-files", "-z"], check=True, capture_output=True).stdout.decode()
    with tarfile.open(target, "w:gz") as archive:
        for file in filter(None, files.split("\0")):
            archive.add(SOURCE / file, f"{name}/{file}")
        information = metadata([]).encode()
        header = tarfile.TarInfo(f"{name}/PKG-INFO")
        header.size = len(information)
        archive.addfile(header, io.BytesIO(information))
    return target.name


def pack(build, directory, cmake="cmake"):
    """Writes a wheel of the finished build in the folder `build` to `directory`. Returns the name of the wheel."""
    with tempfile.TemporaryDirectory() as held:
        stage = pathlib.Path(held)
        for component in ("library", "python"):  # installing strips them, and removes the paths of the build folder
            run(cmake, "--install", build, "--component", component, "--prefix", stage, "--strip")
        (module,) = stage.rglob("_tessera*.so")
        library = next(stage.rglob("libtessera.so.*")).resolve()
        (soname,) = dynamic(library, "SONAME")
        files = {f"tessera/{path.name}": path.read_bytes() for path in module.parent.iterdir() if path.is_file()}
        files[f"tessera/{soname}"] = library.read_bytes()
        external = {name for path in (module, library) for name in dynamic(path, "NEEDED")} - {soname}

    python = f"cp{sys.version_info.major}{sys.version_info.minor}"
    tag = f"{python}-{python}-{re.sub('[-.]', '_', sysconfig.get_platform())}"
    information = f"tessera-{version()}.dist-info"
    files[f"{information}/METADATA"] = metadata(sorted(external)).encode()
    files[f"{information}/WHEEL"] = f"Wheel-Version: 1.0\nGenerator: tessera\nRoot-Is-Purelib: false\nTag: {tag}\n".encode()
    files[f"{information}/LICENSE"] = (SOURCE / "LICENSE").read_bytes()
    record = "".join(f"{name},sha256={checksum(content)},{len(content)}\n" for name, content in sorted(files.items()))
    files[f"{information}/RECORD"] = f"{record}{information}/RECORD,,\n".encode()

    target = directory / f"tessera-{version()}-{tag}.whl"
    unfinished = target.with_suffix(".new")
    with zipfile.ZipFile(unfinished, "w", zipfile.ZIP_DEFLATED) as wheel:
        for name, content in files.items():
            entry = zipfile.ZipInfo(name)  # its time is in 1980, so equal contents give equal wheels
            entry.compress_type = zipfile.ZIP_DEFLATED
            entry.external_attr = (0o755 if ".so" in name else 0o644) << 16
            wheel.writestr(entry, content)
    os.replace(unfinished, target)
    return target.name


def version():
    return re.search(r"project\(tessera VERSION ([0-9.]+)", (SOURCE / "CMakeLists.txt").read_text())[1]


def metadata(external):
    major, minor = sys.version_info[:2]
    return "".join(["Metadata-Version: 2.1\nName: tessera\n", f"Version: {version()}\n",
                    "Summary: Exact Delaunay triangulations in 2D and 3D, of any size\nLicense: GPL-3.0-or-later\n",
                    f"Requires-Python: =={major}.{minor}.*\nRequires-Dist: numpy\n",
                    *(f"Requires-External: {name}\n" for name in external),
                    "Description-Content-Type: text/markdown\n\n", (SOURCE / "docs" / "python.md").read_text()])


def dynamic(file, kind):
    """Returns the values of all entries of this kind in the dynamic section of a shared library."""
    text = subprocess.run(["readelf", "-dW", file], check=True, capture_output=True, text=True).stdout
    return re.findall(rf"\({kind}\).*\[(.*)\]", text)


def checksum(content):
    return base64.urlsafe_b64encode(hashlib.sha256(content).digest()).rstrip(b"=").decode()


def run(*command):
    subprocess.run([*map(str, command)], check=True, stdout=sys.stderr)


if __name__ == "__main__":
    build_folder, output, cmake_program = sys.argv[1:]
    print(pathlib.Path(output) / pack(pathlib.Path(build_folder), pathlib.Path(output), cmake_program))
