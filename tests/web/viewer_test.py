"""The viewer of 2D results in Chromium, drawn by software: it prepares, loads, draws and colours, and says what a cell is."""
import unittest

import numpy as np
from osgeo import gdal
from selenium.webdriver import ActionChains, Keys

import looking
import picking

gdal.UseExceptions()
VIEWER = "view_page"  # in the name of the file that only the viewer needs


class Viewer(looking.LookingTest):
    def setUp(self):
        super().setUp()
        # What 3d-tiles-renderer says of every tileset of version 1.1; ours has nothing that it does not know.
        self.forgive = ("tiles versions at 1.1 or higher have limited support",)

    def make(self, name="hills", dimension=2, tiles=5):
        inputs = {"inputs": ["*.las"], "dim": dimension, "tiles": tiles, "output": name, "attributes": ["intensity", "classification"]}
        status, _, job = self.daemon.request("POST", "/v1/processes/triangulate/execution", {"inputs": inputs})
        self.assertEqual(status, 201)
        self.assertEqual(self.daemon.wait(job["jobID"])["status"], "successful")

    def see(self):
        """Until all that is to be seen is there, and drawn."""
        self.browser.until("return document.querySelector('.stage canvas')?.dataset.loaded === 'true'")
        self.browser.until("""const d = document.querySelector('.stage canvas').dataset, before = d.frames;
            return new Promise(done => setTimeout(() => done(d.frames === before), 300))""")

    def colours(self):
        """Of a grid of places on the canvas, as it is seen."""
        self.browser.picture("viewer-now")
        box = self.browser.script("const b = document.querySelector('.stage canvas').getBoundingClientRect(); return [b.left, b.top, b.width, b.height]")
        pixels = gdal.Open(str(looking.browser.SCREENSHOTS / "viewer-now.png")).ReadAsArray()[:3]
        return [tuple(pixels[:, int(box[1] + box[3] * j / 21), int(box[0] + box[2] * i / 21)]) for j in range(1, 21) for i in range(1, 21)]

    def check_colourings(self):
        """Each of the four shows something else."""
        seen = {}
        for colouring in ("height", "class", "intensity", "tile"):
            self.browser.script("document.getElementById(arguments[0]).click()", "by-" + colouring)
            self.see()
            seen[colouring] = self.colours()
            self.assertGreater(len(set(seen[colouring])), 20, colouring)
        self.assertEqual(len(set(map(tuple, seen.values()))), 4)

    def loaded_scripts(self):
        return self.browser.script("return performance.getEntriesByType('resource').map(r => r.name).filter(n => n.endsWith('.js'))")

    def test_a_surface_is_prepared_once_and_drawn(self):
        self.serve()
        self.make()
        self.enter()
        b = self.browser
        b.go("#/results/hills")
        b.button("View")
        self.assertFalse([name for name in self.loaded_scripts() if VIEWER in name], "the dashboard loads the viewer")
        b.press("View")
        self.see()
        self.assertTrue([name for name in self.loaded_scripts() if VIEWER in name])
        jobs = self.daemon.request("GET", "/v1/jobs")[2]
        self.assertEqual(sorted(job["processID"] for job in jobs["jobs"]), ["export", "triangulate"])
        status, headers, tileset = self.daemon.request("GET", "/v1/triangulations/hills/3dtiles/tileset.json")
        self.assertEqual((status, tileset["asset"]["version"]), (200, "1.1"))
        status, headers, _ = self.daemon.request("GET", "/v1/triangulations/hills/3dtiles/" + tileset["root"]["content"]["uri"])
        self.assertEqual((status, headers["Content-Type"]), (200, "model/gltf-binary"))
        self.assertGreater(int(b.script("return document.querySelector('.stage canvas').dataset.triangles")), 5000)
        self.check_colourings()
        b.until_text("5 tiles, each of one colour", ".legend-box")
        b.script("document.getElementById('by-height').click()")
        low, high = tileset["extras"]["heights"]
        b.until_text(b.script("return arguments[0].toLocaleString('en', {maximumFractionDigits: 2})", high), ".legend-box")
        self.assertLess(low, high)
        b.look(self, "viewer")
        # Once more, without another job.
        b.go("#/results")
        b.go("#/view/hills")
        self.see()
        self.assertEqual(self.daemon.request("GET", "/v1/jobs")[2]["numberMatched"], 2)
        # With its result it is gone.
        b.go("#/results")
        self.assertEqual(self.daemon.request("DELETE", "/v1/triangulations/hills")[0], 204)
        self.assertEqual(self.daemon.request("GET", "/v1/triangulations/hills/3dtiles/tileset.json")[0], 404)

    def test_it_is_turned_and_moved_by_mouse_and_keys(self):
        self.serve()
        self.make()
        self.enter()
        b = self.browser
        b.go("#/view/hills")
        self.see()
        before = self.colours()
        canvas = b.script("return document.querySelector('.stage canvas')")
        ActionChains(b.driver).drag_and_drop_by_offset(canvas, 150, 40).perform()
        self.see()
        turned = self.colours()
        self.assertNotEqual(turned, before)
        b.script("arguments[0].focus()", canvas)
        for keys in (Keys.ARROW_LEFT * 5, "++++"):
            was = self.colours()
            ActionChains(b.driver).send_keys(keys).perform()
            self.see()
            self.assertNotEqual(self.colours(), was)

    def test_a_click_tells_the_cell_of_the_service_that_is_under_the_pointer(self):
        self.serve()
        self.make()
        self.enter()
        b = self.browser
        b.go("#/view/hills")
        self.see()
        for x, y in ((0, 20), (-150, 40), (170, 60), (40, -80)):
            asked = picking.click(b, x, y)
            found = self.daemon.request("GET", "/v1" + asked.split("/v1")[1])[2]
            b.until_text(f"Cell {found['cell']} of tile {found['tile']}", ".cell")
            for corner in found["vertices"]:
                self.assertIn(f"{corner['id']}\n{picking.digits(corner['point'])} · tile {corner['tile']}", b.text(".cell"))
            # The point is where the pointer was, at some height of the surface.
            low, high = self.daemon.request("GET", "/v1/triangulations/hills/3dtiles/tileset.json")[2]["extras"]["heights"]
            ends = picking.on_canvas(b, [[*found["point"], z] for z in (low, high)])
            self.assertTrue(picking.is_inside(np.array([x, y]), ends, 1.5), (x, y, ends))

    def test_the_closed_surface_of_a_3d_result_is_made_once_and_drawn(self):
        self.serve()
        self.make("trees", 3)
        self.enter()
        b = self.browser
        b.go("#/results/trees")
        b.press("Surface")
        b.until_text("The closed surface and its levels of detail are made once", "main")
        self.see()
        jobs = self.daemon.request("GET", "/v1/jobs")[2]
        self.assertEqual(sorted(job["processID"] for job in jobs["jobs"]), ["surface", "triangulate"])
        tileset = self.daemon.request("GET", "/v1/triangulations/trees/3dtiles/tileset.json")[2]
        self.assertGreater(tileset["extras"]["cells"], 20_000)
        self.assertEqual(b.script("return document.title"), "Surface of trees · Tessera")
        self.check_colourings()
        # A place may have many triangles: nothing is asked for.
        self.assertNotIn("click", b.text("#view-help"))
        self.assertFalse(b.script("return document.querySelector('.cell')"))
        canvas = b.script("return document.querySelector('.stage canvas')")
        ActionChains(b.driver).move_to_element(canvas).click().perform()
        b.script("arguments[0].focus()", canvas)
        ActionChains(b.driver).send_keys(Keys.ENTER).perform()
        self.see()
        b.script("document.getElementById('by-height').click()")
        b.look(self, "viewer-surface")
        # Once more, without another job; its cells are seen as before.
        b.go("#/results")
        b.go("#/surface/trees")
        self.see()
        b.go("#/view/trees")
        b.until("return document.getElementById('show-hull')")
        self.assertEqual(self.daemon.request("GET", "/v1/jobs")[2]["numberMatched"], 2)

    def test_who_may_only_read_is_told(self):
        self.serve()
        self.make()
        self.enter("read")
        self.browser.go("#/view/hills")
        self.browser.until_text("Not prepared for viewing yet")
        self.assertEqual(self.daemon.request("GET", "/v1/jobs")[2]["numberMatched"], 1)
        self.browser.look(self, "viewer-none")


if __name__ == "__main__":
    unittest.main()
