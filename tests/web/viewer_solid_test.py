"""The viewer of 3D results in Chromium: hull, a cut that moves, shrunk cells; what a click tells is what the service says."""
import re
import unittest

import numpy as np
from selenium.webdriver import ActionChains, Keys
from selenium.webdriver.common.by import By

import looking
import picking

POINTS = 4000


class SolidViewer(looking.LookingTest):
    def make(self):
        self.tessera("generate", "uniform", "-n", POINTS, "-o", self.folder / "inputs" / "cloud.npy", "--quiet")
        self.serve()
        inputs = {"inputs": ["cloud.npy"], "dim": 3, "tiles": 5, "output": "cloud"}
        job = self.daemon.request("POST", "/v1/processes/triangulate/execution", {"inputs": inputs})[2]
        self.assertEqual(self.daemon.wait(job["jobID"])["status"], "successful")

    def open(self, role="admin"):
        self.make()
        self.enter(role)
        self.browser.go("#/view/cloud")
        self.browser.until("return document.querySelector('.stage canvas')?.dataset.loaded === 'true'")

    def choose(self, mode, told):
        self.browser.script("document.getElementById(arguments[0]).click()", f"show-{mode}")
        self.browser.until_text(told, ".view-side [role=status]")
        self.rest()

    def rest(self):
        """Until nothing more is drawn."""
        self.browser.until("""const d = document.querySelector('.stage canvas').dataset, before = d.frames;
            return new Promise(done => setTimeout(() => done(d.frames === before), 300))""")

    def triangles(self):
        return int(self.browser.script("return document.querySelector('.stage canvas').dataset.triangles"))

    def ask(self, what):
        status, _, found = self.daemon.request("GET", f"/v1/triangulations/cloud/locate?{what}")
        self.assertEqual(status, 200, found)
        return found

    def check_clicks(self, places):
        """Of places where a body is: the panel tells a cell that is there, with the service's numbers. Returns the answers."""
        b, answers = self.browser, []
        for x, y in places:
            asked = picking.click(b, x, y)
            tile, cell = map(int, re.search(r"cell=(\d+),(\d+)", asked).groups())
            b.until_text(f"Cell {cell} of tile {tile}", ".cell")
            found = self.ask(f"cell={tile},{cell}")
            corners = picking.on_canvas(b, [corner["point"] for corner in found["vertices"]])
            self.assertTrue(picking.is_inside(np.array([x, y]), corners, 1.5), (x, y, corners))
            # The mean of a cell is in it, and nowhere else.
            at = self.ask(f"point={','.join(map(repr, found['point']))}")
            self.assertEqual((at["tile"], at["cell"]), (tile, cell))
            text = b.text(".cell")
            for corner in found["vertices"]:
                shown = re.search(rf"^{corner['id']}\n(.+) · tile {corner['tile']}$", text, re.M)[1]  # digits of another program
                self.assertEqual(list(map(float, shown.split(", "))), corner["point"])
            for neighbor in found["neighbors"]:
                self.assertIn(f"cell {neighbor['cell']} of tile {neighbor['tile']}: {', '.join(map(str, neighbor['vertices']))}"
                              if neighbor else "none: on the hull", text)
            radius = float(re.search(r"radius ([\d.e-]+)", text)[1])
            centre = np.array(list(map(float, re.search(r"centre ([-\d.e]+), ([-\d.e]+), ([-\d.e]+)", text).groups())))
            for corner in found["vertices"]:  # told with nine digits
                self.assertAlmostEqual(np.linalg.norm(centre - corner["point"]) / radius, 1, delta=1e-5)
            answers.append(found)
        return answers

    def test_hull_cut_and_cells_are_drawn_and_picked(self):
        self.open()
        b = self.browser
        hull = self.triangles()
        self.assertGreater(hull, 50)
        for found in self.check_clicks([(0, 0), (-120, 30), (100, 60)]):
            self.assertIn(None, found["neighbors"])
        b.look(self, "solid-hull")
        self.choose("cut", "The plane cuts")
        middle = b.text(".view-side [role=status]")
        self.assertGreater(self.triangles(), 300)
        self.check_clicks([(0, 10), (-100, 20), (120, -10)])
        b.look(self, "solid-cut")
        # The mouse moves the cut: by its slider, and on the canvas with Shift.
        slider = b.driver.find_element(By.ID, "cut-place")
        place = b.text(".slider:has(#cut-place) .number")
        slider.send_keys(Keys.ARROW_RIGHT * 200)
        b.until("return document.querySelector('.view-side [role=status]').innerText !== arguments[0]", middle)
        self.rest()
        moved = b.text(".slider:has(#cut-place) .number")
        self.assertGreater(float(moved), float(place))
        canvas = b.driver.find_element(By.CSS_SELECTOR, ".stage canvas")
        b.script("performance.clearResourceTimings()")
        pull = ActionChains(b.driver, duration=20).move_to_element(canvas).key_down(Keys.SHIFT).click_and_hold()
        for _ in range(30):
            pull.move_by_offset(0, 4)
        pull.release().key_up(Keys.SHIFT).perform()
        self.rest()
        self.assertLess(float(b.text(".slider:has(#cut-place) .number")), float(moved))
        # The last place is the one that is shown, and not every place on the way was asked for.
        asked = b.script("return performance.getEntriesByType('resource').map(r => r.name).filter(n => n.includes('/section?'))")
        self.assertLessEqual(len(asked), 31)
        # The slider's words are rounded; what it asked is not.
        status, _, data = self.daemon.request("GET", "/v1" + asked[-1].split("/v1")[1])
        self.assertEqual(status, 200)
        b.until_text(f"The plane cuts {int(re.search(rb'.cells.:([0-9]+)', data)[1]):,} cells.", ".view-side [role=status]")
        for axis in "xz":
            before = b.text(".view-side [role=status]")
            b.script("document.getElementById(arguments[0]).click()", f"cut-{axis}")
            b.until("return document.querySelector('.view-side [role=status]').innerText !== arguments[0]", before)
        self.choose("cells", "cells meet the box")
        whole = self.triangles()
        self.assertGreater(whole, 2000)
        self.check_clicks([(0, 0), (20, 10), (-20, -8)])
        b.look(self, "solid-cells")
        before = self.colours()
        b.driver.find_element(By.ID, "cells-shrink").send_keys(Keys.HOME)
        self.rest()
        self.assertEqual(self.triangles(), whole)
        self.assertNotEqual(self.colours(), before)
        b.script("document.getElementById('by-tile').click()")
        b.until_text("5 tiles, each of one colour", ".legend-box")
        b.press("Around the cell")
        self.rest()

    def test_a_hull_with_too_many_facets_is_left_out(self):
        self.forgive = ("status of 422",)
        self.make()
        self.enter("read")
        b = self.browser
        b.script("""const fetch_ = window.fetch;  // as if the result had another hull
            window.fetch = (url, options) => fetch_(String(url).includes('/shapes/hull') ? `${url}?limit=5` : url, options)""")
        b.go("#/view/cloud")
        b.until_text("the hull has more than 5 cells", ".view-side [role=status]")
        self.choose("cut", "The plane cuts")
        self.assertGreater(self.triangles(), 300)
        b.driver.find_element(By.ID, "cut-place").send_keys(Keys.END)  # where there is hardly anything
        b.until("return document.querySelector('.stage canvas').dataset.triangles < 100")
        self.rest()

    def test_a_box_with_too_many_cells_is_a_sentence(self):
        self.forgive = ("status of 422",)
        self.open("read")
        b = self.browser
        self.choose("cells", "cells meet the box")
        b.script("""const fetch_ = window.fetch;  // as if the result were a larger one
            window.fetch = (url, options) => fetch_(String(url).includes('/shapes/cells') ? `${url}&limit=3000` : url, options)""")
        b.driver.find_element(By.ID, "cells-side").send_keys(Keys.END)
        b.until_text("the area has more than 3000 cells", ".notice")
        b.driver.find_element(By.ID, "cells-side").send_keys(Keys.HOME)
        b.until("return document.querySelector('.notice').hidden")

    def colours(self):
        import viewer_test
        return viewer_test.Viewer.colours(self)


if __name__ == "__main__":
    unittest.main()
