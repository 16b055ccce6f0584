"""A click in the viewer tells the numbers of `tessera query`: on a service that is played, whose cells the command finds."""
import json
import os
import pathlib
import re
import shutil
import subprocess
import tempfile
import unittest
import urllib.parse

from selenium.webdriver import ActionChains, Keys

import browser
import picking
import played_service
import scale_test

TESSERA = os.environ["TESSERA"]


class PlayedResult(played_service.PlayedService):
    """With one triangulation, its tileset, and `tessera query` behind locate and interpolate."""

    def __init__(self, files, folder):
        self.folder, self.located, self.heights = folder, [], []
        super().__init__(files)

    def answer(self, request):
        url = urllib.parse.urlsplit(request.path)
        if (at := url.path.find("/3dtiles/")) > 0:
            file = self.folder / "tiles" / url.path[at + len("/3dtiles/"):]
            return self.send(request, 200, "application/json" if file.suffix == ".json" else "model/gltf-binary", file.read_bytes())
        if url.path.endswith("/locate"):
            point = urllib.parse.parse_qs(url.query)["point"][0]
            done = subprocess.run([TESSERA, "query", self.folder / "out", "locate", point, "--json"], capture_output=True, check=True)
            with self.changed:
                self.located.append(json.loads(done.stdout))
                self.changed.notify_all()
            return self.send(request, 200, "application/json", done.stdout)
        if url.path.endswith("/interpolate"):
            points = json.loads(request.rfile.read(int(request.headers["Content-Length"])))["points"]
            file = self.folder / "asked.csv"
            file.write_text("x,y\n" + "".join(f"{x!r},{y!r}\n" for x, y in points))
            done = subprocess.run([TESSERA, "query", self.folder / "out", "interpolate", file, "--value", "z", "--format", "json"], capture_output=True, check=True)
            self.heights = [json.loads(line)["value"] for line in done.stdout.splitlines() if b'"value"' in line]
            return self.send(request, 200, "application/json", json.dumps({"answers": [{"value": height} for height in self.heights]}).encode())
        return super().answer(request)

    def find(self, path, query):
        if path == "/v1/triangulations/hills":
            return {"name": "hills", "dimension": 2, "vertices": 1, "cells": 1, "tiles": 1, "bytes": 1, "bounds": [], "links": [], "tileset": True}
        return super().find(path, query)


class Pick(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = pathlib.Path(tempfile.mkdtemp(prefix="tessera-viewer-"))
        cls.addClassCleanup(shutil.rmtree, cls.folder, True)
        for words in (("generate", "terrain", "-n", "40000", "-o", "hills.las"), ("triangulate", "hills.las", "--dim", "2", "--tiles", "3", "-o", "out"),
                      ("tileset", "out", "-o", "tiles")):
            subprocess.run([TESSERA, *words, "--quiet"], cwd=cls.folder, check=True)
        cls.service = PlayedResult(scale_test.files_of_the_dashboard(), cls.folder)
        cls.addClassCleanup(cls.service.close)
        cls.browser = browser.Browser()
        cls.addClassCleanup(cls.browser.quit)

    def setUp(self):
        b = self.browser
        b.open("about:blank")
        b.open(f"http://127.0.0.1:{self.service.port}/ui/#/view/hills")
        self.canvas = b.until("const c = document.querySelector('.stage canvas'); return c?.dataset.loaded === 'true' ? c : null")
        self.service.located.clear()

    def tearDown(self):
        known = "tiles versions at 1.1 or higher have limited support"  # viewer_test.py
        self.assertEqual([text for text in self.browser.complaints() if known not in text], [])
        self.assertEqual(self.browser.hosts(), {f"127.0.0.1:{self.service.port}"})

    def told(self, located):
        """Until the panel tells of this cell."""
        self.browser.until_text(f"Cell {located['cell']} of tile {located['tile']}", ".cell")
        return self.browser.text(".cell")

    def click(self, x, y):
        before = len(self.service.located)
        ActionChains(self.browser.driver).move_to_element_with_offset(self.canvas, x, y).click().perform()
        return self.asked(before)

    def asked(self, before):
        """What was asked after so many others."""
        with self.service.changed:
            self.service.changed.wait_for(lambda: len(self.service.located) > before)
        return self.service.located[-1]

    def test_the_panel_tells_what_the_command_tells(self):
        located = self.click(0, 40)
        text = self.told(located)
        corners = [vertex["point"] for vertex in located["vertices"]]
        for vertex in located["vertices"]:
            self.assertIn(f"{vertex['id']}\n{picking.digits(vertex['point'])} · tile {vertex['tile']}", text)
        for neighbor in located["neighbors"]:
            self.assertIn(f"cell {neighbor['cell']} of tile {neighbor['tile']}: {', '.join(map(str, neighbor['vertices']))}"
                          if neighbor else "none: on the hull", text)
        told = list(map(float, re.findall(r"Height ([-\d.]+)", text)))
        self.assertEqual(len(told), 4)
        self.assertEqual(told[1:], self.service.heights[1:])
        self.assertAlmostEqual(told[0], self.service.heights[0], delta=0.0006)
        radius = float(re.search(r"radius ([\d.]+)", text)[1])
        x, y = map(float, re.search(r"centre ([-\d.]+), ([-\d.]+)", text).groups())
        for corner in corners:  # told with nine digits
            self.assertAlmostEqual(((corner[0] - x) ** 2 + (corner[1] - y) ** 2) ** 0.5, radius, delta=0.02 + radius * 1e-6)

    def test_the_place_is_the_one_under_the_pointer(self):
        left, right = self.click(-120, 60)["point"], self.click(120, 60)["point"]
        self.assertGreater((right[0] - left[0]) * 1.2 - (right[1] - left[1]) * 0.5, 0)  # the camera looks along (0.5, 1.2)
        ActionChains(self.browser.driver).move_to_element_with_offset(self.canvas, 0, 0).perform()
        middle = self.click(0, 0)["point"]
        self.browser.script("arguments[0].focus()", self.canvas)
        before = len(self.service.located)
        ActionChains(self.browser.driver).send_keys(Keys.ENTER).perform()
        for axis, place in enumerate(self.asked(before)["point"]):
            self.assertAlmostEqual(place, middle[axis], delta=5)  # a pixel further may be behind a tree

    def test_beside_the_surface_nothing_is_asked(self):
        box = self.browser.script("return [arguments[0].clientWidth, arguments[0].clientHeight]", self.canvas)
        ActionChains(self.browser.driver).move_to_element_with_offset(self.canvas, -box[0] // 2 + 5, -box[1] // 2 + 5).click().perform()
        self.click(0, 40)
        self.assertEqual(len(self.service.located), 1)


if __name__ == "__main__":
    unittest.main()
