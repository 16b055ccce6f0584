"""Makes the page of the viewer that notebooks embed, in one file without links:

    embedded.py ESBUILD SOURCES PACKAGES OUT.html

In place of the word GIVEN stands the surface (python/tessera/_view.py).
"""
import os
import pathlib
import subprocess
import sys


def built(esbuild, packages, source, *options):
    return subprocess.run([esbuild, str(source), "--bundle", "--minify", "--target=es2022", "--log-level=warning", *options],
                          env=os.environ | {"NODE_PATH": str(packages)}, check=True, capture_output=True).stdout.decode()


def main(esbuild, sources, packages, out):
    sources = pathlib.Path(sources)
    style = built(esbuild, packages, sources / "colours.css") + built(esbuild, packages, sources / "view.css")
    script = built(esbuild, packages, sources / "embedded.ts", "--format=iife")
    rights = (pathlib.Path(packages) / "three" / "LICENSE").read_text().replace("--", "- -")
    page = ('<!doctype html>\n<html lang="en"><head><meta charset="utf-8"><title>Tessera</title>\n'
            f"<!-- The page contains three.js:\n{rights}-->\n"
            f"<style>{style} body {{ margin: 0; background: var(--ground); color: var(--text); font: 1rem system-ui, sans-serif }} "
            ".stage { height: 100vh; min-height: 0; box-sizing: border-box }</style></head>\n"
            '<body><div class="stage"><canvas tabindex="0"></canvas></div>\n'
            f'<script type="application/json" id="given">GIVEN</script>\n<script>{script}</script></body></html>\n')
    pathlib.Path(out).write_text(page)


if __name__ == "__main__":
    main(*sys.argv[1:])
