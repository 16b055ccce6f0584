"""Fetches the packages that the viewer is made of, exactly those of package-lock.json, into a folder of the build:

    packages.py NPM SOURCES FOLDER [--omit=dev]

With the last one without those that only tests need. Their scripts are not run. What npm has fetched before it has kept, so that only the first build needs a network.
"""

import pathlib
import subprocess
import sys

LISTS = ("package.json", "package-lock.json")


def main(npm, sources, folder, *options):
    sources, folder = pathlib.Path(sources), pathlib.Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    for name in LISTS:
        (folder / name).write_bytes((sources / name).read_bytes())
    done = subprocess.run([npm, "ci", "--ignore-scripts", "--legacy-peer-deps", "--prefer-offline", "--no-audit", "--no-fund", "--loglevel=error",
                           *options],
                          cwd=folder, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
    if done.returncode != 0:
        sys.exit(f"{done.stderr}\nThe packages of the viewer (web/package-lock.json) could not be fetched: the first build needs a network, "
                 "or npm's cache of an earlier one.")


if __name__ == "__main__":
    main(*sys.argv[1:])
