"""The documents: their links lead somewhere, the index has them all, and they stay small."""
import os
import pathlib
import re
import unittest

import tree

SOURCE = pathlib.Path(os.environ["SOURCE"])
PICTURE_BYTES_MAX = 150 * 1024
LINKS = pathlib.Path(os.environ["LINKS"])
OURS = ("src", "actors", "include", "proto", "python", "web", "tests", "bench", "deploy", "docs", "scripts", "config", "cmake",
        "data", "examples")
CLOUDS, CLOUDS_BYTES_MAX = "tests/data/clouds/", 8_000_000


def links(text):
    """What a page links or shows, without addresses on the net and places in the page itself."""
    found = re.findall(r"\]\(([^)\s]+)\)", text)
    return [link.split("#")[0] for link in found if not re.match(r"\w+:|#", link)]


def named_files(text):
    """The paths of files, folders and programs of the project that stand in backticks, also as the first word of a command."""
    for code in re.findall(r"`([^`\n]+)`", text):
        word = next((word for word in code.split() if "=" not in word), "").split("#")[0].rstrip("/:,")
        word = re.sub(r"^build/\w+/", "", word)
        if word.split("/")[0] in OURS and "/" in word and re.fullmatch(r"[\w./-]+", word):
            yield word


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
        source = (SOURCE / "src/input/text/text_columns.cc").read_text()
        names = re.findall(r'"([a-z]+)"', re.search(r"families\{.*?heights\{.*?\}", source, re.DOTALL)[0])
        self.assertGreater(len(names), 20)
        told = re.search(r"^### Text: .*?^### ", self.pages["docs/formats.md"], re.MULTILINE | re.DOTALL)[0]
        self.assertEqual([name for name in names if f"`{name}`" not in told], [])

    def test_every_real_point_cloud_has_a_source_and_a_licence_and_all_are_small(self):
        files = {path.removeprefix(CLOUDS) for path in tree.files(SOURCE) if path.startswith(CLOUDS)}
        rows = [[cell.strip() for cell in line.split("|")[1:-1]] for line in self.pages[CLOUDS + "README.md"].splitlines() if line.startswith("| `")]
        told = set()
        for names, _, _, source, licence in rows:
            self.assertTrue(source and licence, names)
            listed = re.findall(r"`([^`]+)`", names)
            told |= {listed[0].rpartition(".")[0] + name if name.startswith(".") else name for name in listed}
        clouds = {path for path in files if not path.startswith("licences/")} - {"README.md", "manifest.json"}
        self.assertEqual({path for path in clouds if path not in told and path.split("/")[0] + "/" not in told}, set())
        self.assertEqual({name for name in told if not (SOURCE / CLOUDS / name).exists()}, set())
        licences = set(re.findall(r"`(licences/[^`]+)`", self.pages[CLOUDS + "README.md"]))
        self.assertEqual(licences, {path for path in files if path.startswith("licences/")})
        self.assertLess(sum((SOURCE / CLOUDS / path).stat().st_size for path in files), CLOUDS_BYTES_MAX)

    def test_every_file_that_a_page_names_exists(self):
        programs = {target.folder + "/" + name for name, target in tree.targets(LINKS.read_text()).items()}
        programs |= {"src/front/apps/tessera", "src/front/daemon/tesserad"}
        named = [(path, name) for path, text in self.pages.items() if path not in ("CHANGELOG.md", CLOUDS + "README.md")
                 for name in named_files(text)]
        self.assertGreater(len(named), 60)
        gone = [f"{path}: {name}" for path, name in named if name not in programs
                and not any((SOURCE / (name + ending)).exists() for ending in ("", ".cc", ".py", ".h"))]
        self.assertEqual(gone, [])


if __name__ == "__main__":
    unittest.main()
