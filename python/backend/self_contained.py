"""Makes the libraries of a wheel self-contained, as auditwheel does (Debian 12 has no auditwheel).

The libraries that the wheel's own ones link are copied into the wheel, each with a hash in its name, so that no process
can mistake a copy for another library of the same name. What each Linux has is not copied: SYSTEM. The wheel's tag says
which glibc it needs.
"""
from __future__ import annotations

import hashlib
import pathlib
import platform
import re
import shutil
import subprocess

import older_glibc

# Of auditwheel's list of what each Linux has, that which C++ programs link. The two of GCC are not copied: GDAL, which is
# loaded when it is there, links those of the system, and a process does not stand two copies of libstdc++ well.
SYSTEM = {"libstdc++.so.6", "libgcc_s.so.1", "libm.so.6", "libc.so.6", "libdl.so.2", "librt.so.1", "libpthread.so.0"}

# The first glibc of a distribution whose libstdc++ has the symbols GLIBCXX_3.4.N (PEP 600, the policies of auditwheel).
GLIBC_OF_GLIBCXX = {25: 28, 28: 31, 29: 34, 30: 35}


def bundle(own: list[pathlib.Path], folder: pathlib.Path) -> list[pathlib.Path]:
    """Copies all that `own` link, but for SYSTEM, into `folder`, which is beside the folder of `own`. Returns what was
    copied."""
    libraries = {name: path for path in own for name, path in linked(path).items()
                 if name not in SYSTEM and not name.startswith("ld-linux") and name not in {file.name for file in own}}
    folder.mkdir()
    copies = {}
    for name, path in sorted(libraries.items()):
        content = path.read_bytes()
        stem, ending = name.split(".so", 1)
        copies[name] = folder / f"{stem}-{hashlib.sha256(content).hexdigest()[:8]}.so{ending}"
        copies[name].write_bytes(content)
        copies[name].chmod(0o755)
    for copy in copies.values():
        run("strip", "--strip-unneeded", copy)  # before patchelf, whose work strip would undo
    supplied = supply(folder)
    for name, copy in copies.items():
        needed = ("--add-needed", supplied.name) if older_glibc.lower(copy) else ()
        edit(copy, copies, "$ORIGIN", ("--set-soname", copy.name), needed)
    for path in own:
        needed = ("--add-needed", supplied.name) if older_glibc.lower(path) else ()
        edit(path, copies, f"$ORIGIN:$ORIGIN/../{folder.name}", needed)
    return [libraries[name] for name in sorted(libraries)]


def supply(folder: pathlib.Path) -> pathlib.Path:
    """Makes the library of what older systems lack. Returns it."""
    source = pathlib.Path(older_glibc.__file__).with_suffix(".c")
    name = f"libtessera_older-{hashlib.sha256(source.read_bytes()).hexdigest()[:8]}.so"
    run("cc", "-shared", "-fPIC", "-O2", "-s", f"-Wl,-soname,{name}", "-o", folder / name, source)
    return folder / name


def edit(path: pathlib.Path, copies: dict[str, pathlib.Path], runpath: str, *more: tuple[str, ...]) -> None:
    """Lets a library link copies in place of what they were copied of, and look for them in `runpath`."""
    needed = [word for name in dynamic(path, "NEEDED") if name in copies
              for word in ("--replace-needed", name, copies[name].name)]
    # One thing at a time: patchelf 0.14 forgets names when it is to do several in one run.
    for words in (needed, *more, ("--set-rpath", runpath)):
        if words:
            run("patchelf", *words, path)


def linked(path: pathlib.Path) -> dict[str, pathlib.Path]:
    """Returns the file of each library that this one links, directly or not."""
    text = subprocess.run(["ldd", path], check=True, capture_output=True, text=True).stdout
    missing = re.findall(r"(\S+) => not found", text)
    if missing:
        raise FileNotFoundError(f"{path} links {', '.join(missing)}, which this system has not installed")
    return {name: pathlib.Path(file) for name, file in re.findall(r"(\S+) => (/\S+)", text)}


def platform_tag(files: list[pathlib.Path]) -> str:
    """Returns "manylinux_2_N_MACHINE" with the least N such that Linux of that glibc has all symbols that files need."""
    text = "".join(subprocess.run(["objdump", "-p", file], check=True, capture_output=True, text=True).stdout
                   for file in files)
    glibc = {int(minor) for minor in re.findall(r"\bGLIBC_2\.(\d+)", text)}
    for minor in {int(minor) for minor in re.findall(r"\bGLIBCXX_3\.4\.(\d+)", text)}:
        known = [needed for version, needed in sorted(GLIBC_OF_GLIBCXX.items()) if minor <= version]
        if not known:
            raise ValueError(f"the libraries need GLIBCXX_3.4.{minor}: add to GLIBC_OF_GLIBCXX which glibc comes with it")
        glibc.add(known[0])
    return f"manylinux_2_{max(glibc)}_{platform.machine()}"


def licences(libraries: list[pathlib.Path]) -> dict[str, bytes]:
    """Returns for each of Debian's packages that these libraries are of the text of its rights."""
    texts = {}
    for library in libraries:
        file = library.resolve()  # packages name it with or without /usr
        said = subprocess.run(["dpkg-query", "-S", f"*/{file.parent.name}/{file.name}"], capture_output=True, text=True)
        package = said.stdout.split(":")[0]
        text = pathlib.Path("/usr/share/doc") / package / "copyright"
        if said.returncode != 0 or not text.is_file():
            raise FileNotFoundError(f"{library} is of no package of Debian with a copyright file, so its licence cannot be "
                                    "put into the wheel")
        texts[f"{package}.txt"] = text.read_bytes()
    return texts


def dynamic(file: pathlib.Path, kind: str) -> list[str]:
    """Returns the values of all entries of this kind in the dynamic section of a shared library."""
    text = subprocess.run(["readelf", "-dW", file], check=True, capture_output=True, text=True).stdout
    return re.findall(rf"\({kind}\).*\[(.*)\]", text)


def run(*command: str | pathlib.Path) -> None:
    if shutil.which(command[0]) is None:
        raise FileNotFoundError(f"self-contained wheels need {command[0]}: deploy/install-deps.sh build installs it")
    done = subprocess.run([*map(str, command)], capture_output=True, text=True)
    if done.returncode != 0:
        raise RuntimeError(f"{' '.join(map(str, command))} failed: {done.stderr.strip()}")
