"""The documents: their links lead somewhere, the index has them all, and they stay small."""
import os
import pathlib
import re
import unittest

import tree

SOURCE = pathlib.Path(os.environ["SOURCE"])
PICTURE_BYTES_MAX = 150 * 1024
README_LINES_MAX = 89


def links(text):
    """What a page links or shows, without addresses on the net and places in the page itself."""
    found = re.findall(r"\]\(([^)\s]+)\)", text)
    return [link.split("#")[0] for link in found if not re.match(r"\w+:|#", link)]


class Documents(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.pages = {path: (SOURCE / path).read_text() for path in tree.files(SOURCE) if path.endswith(".md")}

    def test_links_are_seen(self):
        self.assertEqual(links("[a](b.md) ![c](d/e.png) [f](https://g) [h](i.md#j) [k](#l)"), ["b.md", "d/e.png", "i.md"])

    def test_every_link_leads_to_a_file(self):
        self.assertGreater(sum(len(links(text)) for text in self.pages.values()), 40)
        dead = [f"{path}: {link}" for path, text in self.pages.items() for link in links(text)
                if not (SOURCE / path).parent.joinpath(link).exists()]
        self.assertEqual(dead, [])

    def test_the_index_has_every_document(self):
        listed = {os.path.normpath(f"docs/{link}") for link in links(self.pages["docs/README.md"])}
        pages = {path for path in self.pages if path.startswith("docs/")} - {"docs/README.md"}
        self.assertEqual(pages - listed, set())

    def test_every_picture_is_shown_and_those_of_pages_are_small(self):
        shown = {os.path.normpath(str(pathlib.Path(path).parent / link)) for path, text in self.pages.items()
                 for link in links(text)}
        pictures = [path for path in tree.files(SOURCE) if path.startswith("docs/") and path.endswith((".png", ".svg"))]
        self.assertEqual([path for path in pictures if path not in shown], [])
        large = [path for path in pictures if "/pictures/" in path and (SOURCE / path).stat().st_size > PICTURE_BYTES_MAX]
        self.assertEqual(large, [])

    def test_every_name_of_a_column_that_text_may_have_is_told(self):
        source = (SOURCE / "src/io/text/text_columns.cc").read_text()
        names = re.findall(r'"([a-z]+)"', re.search(r"families\{.*?heights\{.*?\}", source, re.DOTALL)[0])
        self.assertGreater(len(names), 20)
        told = re.search(r"^### Text: .*?^### ", self.pages["docs/formats.md"], re.MULTILINE | re.DOTALL)[0]
        self.assertEqual([name for name in names if f"`{name}`" not in told], [])

    def test_the_readme_stays_short(self):
        self.assertLessEqual(len(self.pages["README.md"].splitlines()), README_LINES_MAX)


if __name__ == "__main__":
    unittest.main()
