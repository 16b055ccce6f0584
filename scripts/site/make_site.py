#!/usr/bin/python3
"""Makes the site of documents: the pages of the project in four parts, and the reference from programs and sources.

    scripts/site/make_site.py BUILD SITE

It needs mkdocs and mkdocs-material of Debian (./tessera.sh deps site), and the programs in BUILD. Nothing comes from the network,
and pages ask nothing of it: the script fails otherwise, and for links that lead nowhere.
"""
import html.parser
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import urllib.request

import reference
import yaml

SOURCE = pathlib.Path(__file__).resolve().parents[2]
SETTINGS = pathlib.Path(__file__).with_name("mkdocs.yml")
LINK = re.compile(r"(\]\()([^)\s]+)(\))")


def pages_of_project():
    """Path -> text of each page that the site shows as it stands; the README is its first page."""
    paths = [*SOURCE.glob("docs/*.md"), *(SOURCE / name for name in ("CHANGELOG.md", "CONTRIBUTING.md", "data/README.md", "src/result/store/FORMAT.md",
                                                                 "tests/data/clouds/README.md"))]
    return {str(path.relative_to(SOURCE)): path.read_text() for path in paths} | {"index.md": (SOURCE / "README.md").read_text()}


def relinked(page, text, pages, files):
    """The text, with links that lead to the place of each page in the site. Other files of the project that are linked or shown are
    added to `files`."""
    here = pathlib.PurePosixPath("README.md" if page == "index.md" else page).parent

    def replaced(match):
        link, hash_sign, part = match[2].partition("#")
        if not link or re.match(r"\w+:", link):
            return match[0]
        target = os.path.normpath(here / link)
        if target == "README.md":
            target = "index.md"
        if target not in pages:
            if (SOURCE / target).is_dir():  # a folder of the project, which the first page tells of
                target = "index.md"
            else:
                files.add(target)
        return match[1] + os.path.relpath(target, pathlib.PurePosixPath(page).parent) + hash_sign + part + match[3]
    return LINK.sub(replaced, text)


def asked_of_daemon(tesserad):
    """The OpenAPI document and the processes, as a daemon tells them."""
    with tempfile.TemporaryDirectory() as folder:
        daemon = subprocess.Popen([tesserad, "--data", f"{folder}/data", "--listen", "127.0.0.1:0", "--metrics", "none", "--uploads",
                                   "--print-token", "--memory", "500M", "--threads", "1"], text=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        try:
            address, _, token = daemon.stdout.readline().strip().partition("#token=")

            def get(path):
                asked = urllib.request.Request(address.rstrip("/") + path, headers={"Authorization": f"Bearer {token}"})
                return json.load(urllib.request.build_opener(urllib.request.ProxyHandler({})).open(asked))
            if not token:
                raise SystemExit(f"make_site: {tesserad} does not start: {daemon.stderr.read()}")
            return get("/v1/api"), [get(f"/v1/processes/{one['id']}") for one in get("/v1/processes")["processes"]]
        finally:
            daemon.terminate()
            daemon.communicate()


def write_sources(build, folder):
    """Writes all pages and what they show, and returns the settings."""
    pages = pages_of_project()
    files = set()
    made = {page: relinked(page, text, pages, files) for page, text in pages.items()}
    commands = reference.command_pages((build / "src/front/apps/manual/commands.json").read_text())
    headers = reference.header_pages(SOURCE / "include/tessera")
    made |= {path: page for _, path, page in commands + headers}
    made["reference/http.md"] = reference.http_page(*asked_of_daemon(build / "src/front/daemon/tesserad"))
    made["reference/python.md"] = reference.python_page(SOURCE / "python/tessera")
    made["reference/defaults.md"] = reference.defaults_page(SOURCE)
    for path, text in made.items():
        (folder / path).parent.mkdir(parents=True, exist_ok=True)
        (folder / path).write_text(text)
    for path in files:
        (folder / path).parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(SOURCE / path, folder / path)
    settings = yaml.safe_load(SETTINGS.read_text())
    part = next(part["Reference"] for part in settings["nav"] if "Reference" in part)
    part[0]["Commands"] = [{title: path} for title, path, _ in commands]
    part[3]["C++"] = [{title: path} for title, path, _ in headers]
    return settings


class Asked(html.parser.HTMLParser):
    """What a page makes a browser fetch."""

    def __init__(self):
        super().__init__()
        self.addresses = []

    def handle_starttag(self, tag, attributes):
        attributes = dict(attributes)
        if tag in ("script", "img", "iframe", "source"):
            self.addresses.append(attributes.get("src") or "")
        elif tag == "link" and attributes.get("rel") != "canonical":
            self.addresses.append(attributes.get("href") or "")


def check_that_nothing_is_asked_of_the_network(site):
    found = []
    for path in site.rglob("*.html"):
        asked = Asked()
        asked.feed(path.read_text())
        found += [f"{path.relative_to(site)}: {address}" for address in asked.addresses if re.match(r"(https?:)?//", address)]
    for path in site.rglob("*.css"):
        found += [f"{path.relative_to(site)}: {address}" for address in re.findall(r"url\(['\"]?((?:https?:)?//[^)]+)\)", path.read_text())]
    if found:
        raise SystemExit("make_site: pages ask the network:\n" + "\n".join(found))


def main(build, site):
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        settings = write_sources(build, folder / "pages") | {"docs_dir": str(folder / "pages"), "site_dir": str(site.resolve())}
        (folder / "mkdocs.yml").write_text(yaml.safe_dump(settings, sort_keys=False))
        done = subprocess.run(["mkdocs", "build", "--strict", "--clean", "--config-file", folder / "mkdocs.yml"], text=True, capture_output=True)
    if done.returncode:
        raise SystemExit("make_site: mkdocs says:\n" + done.stdout + done.stderr)
    check_that_nothing_is_asked_of_the_network(site)
    print(f"{site}/index.html: {sum(1 for _ in site.rglob('*.html'))} pages. Search needs a server: python3 -m http.server -d {site}")


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    main(*map(pathlib.Path, sys.argv[1:]))
