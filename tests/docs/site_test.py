"""The site of documents: it is made without the network, has all parts, and what is made of programs and sources is complete."""
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

SOURCE, BUILD = pathlib.Path(os.environ["SOURCE"]), pathlib.Path(os.environ["BUILD"])
sys.path.append(str(SOURCE / "scripts/site"))
import reference  # noqa: E402


class Reference(unittest.TestCase):
    def test_of_commands_has_each_option_and_example(self):
        described = (BUILD / "src/front/apps/manual/commands.json").read_text()
        pages = {title: page for title, _, page in reference.command_pages(described)}
        for command in json.loads(described):
            for option in command["options"]:
                self.assertIn(f"`--{option['name']}`", pages[command["name"]])
            for line in command["footer"].splitlines():
                self.assertIn(line.strip(), pages[command["name"]])

    def test_of_python_has_what_the_package_exports(self):
        page = reference.python_page(SOURCE / "python/tessera")
        exported = re.search(r"__all__ = \[(.*?)\]", (SOURCE / "python/tessera/__init__.py").read_text(), re.DOTALL)[1]
        for name in re.findall(r'"(\w+)"', exported):
            self.assertRegex(page, rf"(?m)^##+ {name}$")

    def test_of_cpp_has_each_header(self):
        pages = reference.header_pages(SOURCE / "include/tessera")
        self.assertEqual({title for title, _, _ in pages}, {path.name for path in (SOURCE / "include/tessera").glob("*.h")})
        self.assertIn("class TESSERA_PUBLIC HeightsRequest", dict((title, page) for title, _, page in pages)["heights.h"])

    def test_docstrings_become_lists(self):
        page = reference.docstring_page("Does it.\n\nParameters\n----------\na, b\n    What they are.\nc\n    Another.\n\nThe rest.")
        self.assertIn("**Parameters**", page)
        self.assertIn("- `a, b`:\n    What they are.", page)
        self.assertTrue(page.endswith("The rest.\n\n"))


@unittest.skipIf(shutil.which("mkdocs") is None, "no mkdocs: ./tessera.sh deps site")
class Site(unittest.TestCase):
    def test_is_made_and_has_all_parts(self):
        with tempfile.TemporaryDirectory() as folder:
            site = pathlib.Path(folder, "site")
            done = subprocess.run([SOURCE / "scripts/site/make_site.py", BUILD, site], text=True, capture_output=True)
            self.assertEqual(done.returncode, 0, done.stderr)
            first = (site / "index.html").read_text()
            for part in ("Tutorials", "How-to", "Reference", "Explanations"):
                self.assertIn(part, first)
            pages = {str(path.relative_to(site)) for path in site.rglob("*.html")}
            self.assertLessEqual({f"docs/{path.stem}.html" for path in (SOURCE / "docs").glob("*.md")}, pages)
            self.assertIn("/v1/processes/{process}/execution", (site / "reference/http.html").read_text())
            self.assertIn("docs/pictures/qgis.png", {str(path.relative_to(site)) for path in site.rglob("*.png")})
            found = json.loads((site / "search/search_index.json").read_text())["docs"]
            self.assertTrue(any("contour lines" in one["text"] for one in found))


if __name__ == "__main__":
    unittest.main()
