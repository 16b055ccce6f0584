"""How the viewer shows results: all of it in the picture, to scale, in the units of its system; without long cells; and
the heights where somebody clicks."""
import re
import unittest

import numpy as np
from selenium.webdriver import Keys
from selenium.webdriver.common.by import By

import browser
import looking
import picking

browser.WIDTHS.setdefault(1400, 900)


class ViewerLook(looking.LookingTest):
    def make(self, dim):
        self.forgive = ("tiles versions at 1.1 or higher have limited support",)
        self.serve()
        jobs = [("triangulate", {"inputs": ["*.las"], "dim": dim, "tiles": 6, "output": "block"} | ({"class": [2, 9]} if dim == 2 else {}))]
        jobs += [("export", {"triangulation": "block", "output": "3dtiles", "format": "3dtiles"})] if dim == 2 else []
        for process, inputs in jobs:
            job = self.daemon.request("POST", f"/v1/processes/{process}/execution", {"inputs": inputs})[2]
            self.assertEqual(self.daemon.wait(job["jobID"])["status"], "successful")
        self.box = np.array(self.daemon.request("GET", "/v1/triangulations/block")[2]["bounds"]).reshape(2, dim)

    def see(self):
        self.rest("return document.querySelector('.stage canvas')?.dataset.loaded === 'true'")

    def rest(self, wanted="return true"):
        """Until it is so, and nothing more is drawn."""
        self.browser.until(wanted)
        self.browser.until("""const d = document.querySelector('.stage canvas').dataset, before = d.frames;
            return new Promise(done => setTimeout(() => done(d.frames === before && d.loaded === 'true'), 500))""")

    def on_canvas(self, points):
        """In pixels from the middle, as it is seen now."""
        b = self.browser
        b.script("document.querySelector('.stage canvas').dispatchEvent(new KeyboardEvent('keydown', {key: 'Enter'}))")
        size = b.script("const c = document.querySelector('.stage canvas'); return [c.clientWidth, c.clientHeight]")
        return picking.on_canvas(b, points), np.array(size)

    def check_fits(self, low, high):
        corners = [[(low, high)[i >> k & 1][k] for k in range(3)] for i in range(8)]
        seen, size = self.on_canvas(corners)
        part = np.abs(seen).max(0) / (size / 2)
        self.assertLessEqual(part.max(), 1, "nothing is cut off")
        self.assertGreater(part.max(), 0.8, "and it is as large as it can be")
        return seen

    def scale(self):
        words = self.browser.script("return document.querySelector('.scale').getAttribute('aria-label')")
        bar = self.browser.script("return document.querySelector('.scale-bar').getBoundingClientRect().width")
        return float(re.search(r"the bar is ([\d.,]+) m long", words)[1].replace(",", "")), bar

    def test_a_surface_is_seen_whole_to_scale_and_with_its_heights(self):
        self.make(2)
        b = self.browser
        self.enter("read")
        tileset = self.daemon.request("GET", "/v1/triangulations/block/3dtiles/tileset.json")[2]
        bottom, top = tileset["extras"]["heights"]
        low, high = [*self.box[0], bottom], [*self.box[1], top]
        for width in (1400, 400):
            b.size(width)
            b.go("#/results")
            b.go("#/view/block")
            self.see()
            self.check_fits(low, high)
        b.size(1400)
        self.rest()
        self.check_fits(low, high)  # nobody has turned it: it fills the other window, too
        b.until_text(" m", ".legend-box")
        # From above a metre is as long everywhere, and north is up.
        b.press("Top", ".view-buttons")
        self.rest()
        seen = self.check_fits(low, high)
        length, bar = self.scale()
        middle = (self.box[0] + self.box[1]) / 2
        (a, east, north), _ = self.on_canvas([[*middle, (bottom + top) / 2], [middle[0] + length, middle[1], (bottom + top) / 2],
                                              [middle[0], middle[1] + length, (bottom + top) / 2]])
        self.assertAlmostEqual(np.linalg.norm(east - a) / bar, 1, delta=0.03)
        self.assertGreater(east[0] - a[0], 0.9 * bar)
        self.assertLess(north[1] - a[1], -0.9 * bar)
        # Heights are drawn higher, not across.
        b.press("Fit", ".view-buttons")
        b.driver.find_element(By.ID, "heights").send_keys(Keys.END)
        self.rest()
        b.until_text("20 times as high", ".view-side")
        b.press("Fit", ".view-buttons")
        self.rest()
        self.check_fits(low, high)
        b.driver.find_element(By.ID, "heights").send_keys(Keys.HOME)
        b.press("Fit", ".view-buttons")
        self.rest()
        self.check_click()
        b.press("Look closer", ".cell")
        self.rest()
        self.assertGreater(self.outline_size(), 100)
        self.assertTrue(b.script("return document.querySelector('.chosen-ring').hasAttribute('hidden')"))
        b.look(self, "viewer-look")

    def outline(self):
        return np.array([list(map(float, at.split(","))) for at in self.browser.script("return document.querySelector('.chosen').getAttribute('points')").split()])

    def outline_size(self):
        return np.ptp(self.outline(), axis=0).max()

    def check_click(self):
        b = self.browser
        size = b.script("const c = document.querySelector('.stage canvas'); return [c.clientWidth, c.clientHeight]")
        for x, y in ((0, 10), (-60, 40), (90, -20)):
            asked = picking.click(b, x, y)
            found = self.daemon.request("GET", "/v1" + asked.split("/v1")[1])[2]
            points = [found["point"], *(corner["point"] for corner in found["vertices"])]
            heights = [each["value"] for each in self.daemon.request("POST", "/v1/triangulations/block/interpolate?value=z", {"points": points})[2]["answers"]]
            b.until_text(f"Cell {found['cell']} of tile {found['tile']}", ".cell")
            told = [float(each) for each in re.findall(r"Height ([\d.]+) m", b.text(".cell"))]
            self.assertEqual(len(told), 4)
            self.assertAlmostEqual(told[0], heights[0], delta=0.0006)
            self.assertEqual(told[1:], heights[1:])
            # Its outline is where it is: around the pointer.
            b.script("return new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))")
            self.assertTrue(picking.is_inside(np.array([x, y]) + np.array(size) / 2, self.outline(), 3), (x, y, self.outline()))

    def test_without_long_cells_what_was_scanned_is_seen(self):
        self.make(3)
        b = self.browser
        self.enter("read")
        b.size(1400)
        b.go("#/view/block")
        self.see()
        # Of a scan the large cells, which are air, are left out at first.
        b.until_text("on the border of the cells without longer edges", ".view-side [role=status]")
        self.rest()
        first = self.check_shown("hull")
        b.picture("solid-short-cells-light-1400")
        self.check_fits(*self.box)
        slider = b.driver.find_element(By.ID, "longest-edge")
        slider.send_keys(Keys.END)
        b.until_text("all cells", ".view-side")
        b.until_text("The outer facets: no other cell lies behind them.", ".view-side [role=status]")
        self.rest(f"return Number(document.querySelector('.stage canvas').dataset.triangles) < {first / 10}")
        slider.send_keys(Keys.PAGE_DOWN)
        b.until_text("on the border of the cells", ".view-side [role=status]")
        self.rest()
        self.check_shown("hull")
        slider.send_keys(Keys.END)
        b.script("document.getElementById('show-cut').click()")
        b.until_text("The plane cuts", ".view-side [role=status]")
        self.rest()
        every = int(re.search(r"cuts ([\d,]+) cells", b.text(".view-side [role=status]"))[1].replace(",", ""))
        slider.send_keys(Keys.HOME)
        b.until("return parseInt(/cuts ([0-9,]+) cells/.exec(document.querySelector('.view-side [role=status]').innerText)[1].replaceAll(',', '')) < arguments[0]", every)
        self.assertRegex(b.script("return document.getElementById('longest-edge').getAttribute('aria-valuetext')"), r"^[\d.]+ m: \d+ % of the cells$")

    def triangles(self):
        return int(self.browser.script("return document.querySelector('.stage canvas').dataset.triangles"))

    def check_shown(self, name):
        """What is drawn is what the service has of that length; returns how many triangles."""
        words = self.browser.script("return document.getElementById('longest-edge').getAttribute('aria-valuetext')")
        longest = re.match(r"([\d.]+) m: (\d+) % of the cells$", words)
        status, _, data = self.daemon.request("GET", f"/v1/triangulations/block/shapes/{name}?max-edge={longest[1]}&limit=1000000")
        self.assertEqual(status, 200)
        cells = int(re.search(rb'.cells.:([0-9]+)', data)[1])
        self.browser.until_text(f"{cells:,} cells on the border", ".view-side [role=status]")
        self.rest(f"return Number(document.querySelector('.stage canvas').dataset.triangles) >= {cells}")
        return self.triangles()


if __name__ == "__main__":
    unittest.main()
