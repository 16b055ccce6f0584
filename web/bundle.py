"""Bundles the dashboard, and writes it as a C++ source:

    bundle.py ESBUILD SOURCES PACKAGES PHASES.json OUT.cc

Every entry point becomes a file of its own; what they share, and what is imported only when it is needed, others.
"""

import hashlib
import os
import pathlib
import subprocess
import sys
import tempfile

ENTRIES = ("app.ts", "style.css")
STATIC = ("index.html", "icon.svg")
TYPES = {".html": "text/html; charset=utf-8", ".js": "text/javascript; charset=utf-8",
         ".css": "text/css; charset=utf-8", ".svg": "image/svg+xml"}
PIECE = 4096  # bytes of a literal on one line


# Unpacks in plain JavaScript. The package's other one is WebAssembly, which the page's policy would have to allow.
DECODER = "meshoptimizer/meshopt_decoder_reference.js"


def bundle(esbuild, sources, packages, phases, folder):
    subprocess.run([esbuild, *(str(sources / entry) for entry in ENTRIES), "--bundle", "--splitting", "--format=esm",
                    "--target=es2022", "--minify", "--log-level=warning", f"--alias:meshopt-decoder={packages / DECODER}",
                    f"--alias:phases={phases}", f"--outdir={folder}"],
                   env=os.environ | {"NODE_PATH": str(packages)}, check=True)
    for name in STATIC:
        (folder / name).write_bytes((sources / name).read_bytes())
    return sorted(folder.iterdir())


def literal(data):
    """Octal, always of three digits: no digit that follows can belong to it."""
    plain = {byte: chr(byte) for byte in range(32, 127)} | {34: '\\"', 92: "\\\\", 63: "\\?"}
    lines = [data[at:at + PIECE] for at in range(0, len(data), PIECE)] or [b""]
    return "\n".join('    "' + "".join(plain.get(byte, f"\\{byte:03o}") for byte in line) + '"' for line in lines)


def source_of(files):
    yield '#include "web/web_files.h"\n\n#include <array>\n\nnamespace tessera {\nnamespace {\n'
    for place, file in enumerate(files):
        yield f"constexpr char bytes_{place}[] =\n{literal(file.read_bytes())};\n"
    yield f"constexpr std::array<WebFile, {len(files)}> files{{{{"
    for place, file in enumerate(files):
        etag = hashlib.sha256(file.read_bytes()).hexdigest()[:16]
        yield f'    {{"{file.name}", "{TYPES[file.suffix]}", "\\"{etag}\\"", {{bytes_{place}, sizeof(bytes_{place}) - 1}}}},'
    yield "}};\n\n}  // namespace\n\nstd::span<const WebFile> web_files() { return files; }\n\n}  // namespace tessera"


def main(esbuild, sources, packages, phases, out):
    with tempfile.TemporaryDirectory() as folder:
        files = bundle(esbuild, pathlib.Path(sources), pathlib.Path(packages), pathlib.Path(phases), pathlib.Path(folder))
        pathlib.Path(out).write_text("\n".join(source_of(files)) + "\n")


if __name__ == "__main__":
    main(*sys.argv[1:])
