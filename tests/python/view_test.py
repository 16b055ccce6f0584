"""The viewer that notebooks embed: what is in its page, and that Chromium draws it in a sandboxed frame without network."""
import base64
import html
import json
import pathlib
import re
import tempfile
import unittest

import numpy as np
import tessera
from selenium import webdriver
from selenium.webdriver.chrome.service import Service
from selenium.webdriver.support.ui import WebDriverWait

import clouds


def given(view):
    """The surface in a page: corners of the box, places, rows."""
    (frame,) = re.findall(r'srcdoc="([^"]*)"', view._repr_html_())
    (text,) = re.findall(r'<script type="application/json" id="given">(.*?)</script>', html.unescape(frame))
    held = json.loads(text)
    return (np.array([held["low"], held["high"]]), np.frombuffer(base64.b64decode(held["places"]), "<f4").reshape(-1, 3),
            np.frombuffer(base64.b64decode(held["rows"]), "<u4").reshape(-1, 3))


class Pages(unittest.TestCase):
    def test_terrain_is_all_its_triangles_at_their_heights(self):
        xyz = clouds.random(700, 3) + [700_000, 6_600_000, 50]
        t = tessera.triangulate(xyz, dim=2, max_points_per_tile=200)
        box, places, rows = given(t.view())
        self.assertEqual((len(places), len(rows)), (700, t.n_cells))
        middle = (xyz.min(axis=0) + xyz.max(axis=0)) / 2
        np.testing.assert_allclose(box + middle, [xyz.min(axis=0), xyz.max(axis=0)])
        seen = {tuple(sorted(map(tuple, corners))) for corners in places[rows].tolist()}
        wanted = {tuple(sorted(map(tuple, corners))) for corners in (xyz - middle).astype(np.float32)[t.simplices()].tolist()}
        self.assertEqual(seen, wanted)

    def test_what_is_solid_is_its_hull(self):
        points = clouds.random(700, 3)
        _, places, rows = given(tessera.triangulate(points, max_points_per_tile=200).view())
        hull = tessera.Delaunay(points).convex_hull
        self.assertEqual(len(rows), len(hull))
        self.assertEqual(len(places), len(np.unique(hull)))
        lattice = np.stack(np.meshgrid(*[np.arange(4.0)] * 3), axis=-1).reshape(-1, 3)
        self.assertEqual(len(given(tessera.triangulate(lattice).view())[2]), 6 * 9 * 2)

    def test_too_many_triangles_are_refused(self):
        for dimension, count in ((2, "[0-9]+"), (3, "[0-9]+")):
            with self.assertRaisesRegex(tessera.UsageError, f"^the surface has {count} triangles, and view\\(\\) draws at most 10: give a larger"):
                tessera.triangulate(clouds.random(500, dimension)).view(max_triangles=10)

    def test_the_page_names_the_rights_of_what_is_in_it_and_no_other_host(self):
        page = tessera.triangulate(clouds.random(50, 2)).view()._page
        self.assertIn("three.js authors", page)
        self.assertIn("Permission is hereby granted", page)
        self.assertNotRegex(page, r"(src|href)=.?https?:")


class Drawn(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        options = webdriver.ChromeOptions()
        options.binary_location = "/usr/bin/chromium"
        for argument in ("--headless=new", "--no-sandbox", "--disable-dev-shm-usage", "--use-gl=angle", "--use-angle=swiftshader",
                         "--enable-unsafe-swiftshader", "--window-size=900,700", "--disable-background-networking", "--no-first-run"):
            options.add_argument(argument)
        options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
        cls.driver = webdriver.Chrome(service=Service("/usr/bin/chromedriver"), options=options)
        cls.addClassCleanup(cls.driver.quit)

    def test_a_notebook_draws_it_in_its_frame(self):
        for dimension in (2, 3):
            t = tessera.triangulate(clouds.random(1000, 3), dim=dimension, max_points_per_tile=300)
            view = t.view(height=400)
            with tempfile.TemporaryDirectory(prefix="tessera-view-") as folder:
                page = pathlib.Path(folder) / "notebook.html"
                page.write_text(f"<h1>Notebook</h1>{view._repr_html_()}")
                self.driver.get(page.as_uri())
                self.driver.switch_to.frame(0)
                WebDriverWait(self.driver, 900, poll_frequency=0.05).until(
                    lambda driver: driver.execute_script("return document.querySelector('canvas').dataset.loaded") == "true")
                drawn = int(self.driver.execute_script("return document.querySelector('canvas').dataset.triangles"))
                self.assertEqual(drawn, len(given(view)[2]))
                self.driver.switch_to.default_content()
                self.assertEqual([line["message"] for line in self.driver.get_log("browser")], [])
                alone = pathlib.Path(folder) / "alone.html"
                view.save(alone)
                self.driver.get(alone.as_uri())
                WebDriverWait(self.driver, 900, poll_frequency=0.05).until(
                    lambda driver: driver.execute_script("return document.querySelector('canvas').dataset.loaded") == "true")


if __name__ == "__main__":
    unittest.main()
