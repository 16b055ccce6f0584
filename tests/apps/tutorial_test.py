"""The commands of the pages that are to be typed along work as they stand, one after the other."""
import os
import re
import subprocess
import unittest

from cli import IGN, TESSERA, CliTest

DOCS = IGN.parents[1] / "docs"


class Pages(CliTest):
    def type_along(self, page, without="^$"):
        """All but what begins with a heading `without`, which goes to the next one."""
        (self.folder / "data").symlink_to(IGN.parent)
        programs = self.folder / "programs"
        programs.mkdir()
        (programs / "tessera").symlink_to(TESSERA)
        text = re.sub(rf"^## {without}\n.*?(?=^## )", "", (DOCS / page).read_text(), flags=re.MULTILINE | re.DOTALL)
        commands = re.findall(r"^    (tessera .*)$", text, re.MULTILINE)
        said = []
        for command in commands:
            done = subprocess.run(["bash", "-c", command], cwd=self.folder, text=True, timeout=300,
                                  env=os.environ | {"PATH": f"{programs}:{os.environ['PATH']}"},
                                  stdout=subprocess.PIPE, stderr=subprocess.PIPE)
            self.assertEqual(done.returncode, 0, f"{page}: {command}\n{done.stderr}")
            said.append(done.stdout)
        return said

    def test_the_tutorial(self):
        said = self.type_along("tutorial.md", without=r"\d+\. Maps from a daemon")  # tests/daemon/guide_test.py
        self.assertGreater(len(said), 10)
        for made in ("dem.tif", "hillshade.tif", "contours.gpkg", "profile.csv"):
            self.assertGreater((self.folder / made).stat().st_size, 1000, made)
        self.assertIn("Lambert-93", said[0])
        self.assertEqual(sum("is the Delaunay triangulation" in text for text in said), 2)
        digests = {folder: self.ok("info", folder).split("digest")[1].split()[0] for folder in ("block", "large")}
        self.assertEqual(digests["block"], digests["large"])

    def test_the_page_about_paraview(self):
        said = self.type_along("paraview.md")
        self.assertEqual(len(said), 4)
        for told in said[2:]:
            self.assertIn("1 283 298 cells", told)
            self.assertIn("378 719 cells with longer edges than 1.5 are left out", told)


if __name__ == "__main__":
    unittest.main()
