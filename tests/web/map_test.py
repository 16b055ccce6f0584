"""The map of a job's tiles, nearer and farther: on a service that is played."""
import unittest

from selenium.webdriver import ActionChains, Keys

import browser
import played_service
import scale_test


class Map(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.files = scale_test.files_of_the_dashboard()
        cls.browser = browser.Browser()
        cls.addClassCleanup(cls.browser.quit)

    play, tearDown, stands_still = scale_test.Scale.play, scale_test.Scale.tearDown, scale_test.Scale.stands_still

    def test_tiles_of_blocks_that_lie_far_apart_are_found(self):
        b = self.browser
        now = played_service.job(1, "running", phase="triangulating", progress=60)
        self.play("#/jobs/000000000001", jobs=1, tiles=150, job=now, layout=played_service.far_apart(150))
        b.until("return document.querySelector('.map canvas')?.getAttribute('aria-label').includes('150 waiting')")
        self.stands_still()
        # Nearly all are below a pixel: two buttons say where they are.
        self.assertLess(self.told_tiles(), 30)
        self.assertEqual(len(b.driver.find_elements("css selector", ".spots button")), 2)
        b.look(self, "map-far-apart")
        b.script("document.querySelector('.spots button').focus()")
        ActionChains(b.driver).send_keys(Keys.ENTER).perform()
        self.assertGreater(self.told_tiles(), 50)
        self.assertEqual(b.driver.find_elements("css selector", ".spots button"), [])
        b.look(self, "map-closer")
        # Pictures are taken in windows of several sizes, of which this one's is laid out by now.
        looked = b.script("return new Promise(done => requestAnimationFrame(() => requestAnimationFrame(() => done(checks.shifts().length))))")
        # The keys go on from there, and a drag; mail goes with the tiles.
        def seen():
            return b.script("return document.querySelector('.arcs').getAttribute('viewBox').split(' ').map(Number)")
        self.service.mail = {"from": [-1], "to": [-2], "points": [7]}
        self.service.tell(2, "progress", jobID="000000000001", status=now | {"progress": 61})
        b.until("return document.querySelectorAll('.arcs .arc').length === 1")
        close = seen()
        canvas = b.driver.find_element("css selector", ".map canvas")
        self.assertEqual(b.driver.switch_to.active_element, canvas)
        canvas.send_keys("+", Keys.ARROW_RIGHT)
        self.assertLess(seen()[2], close[2])
        right = seen()
        ActionChains(b.driver).drag_and_drop_by_offset(canvas, 40, 0).perform()
        self.assertLess(seen()[0], right[0])
        b.press("All", ".map-buttons")
        self.assertEqual(seen()[:3], [0, 0, 1000])
        self.assertEqual(b.text(".map-buttons"), "+\n−\nAll")
        self.stands_still(looked)

    def told_tiles(self):
        """How many tiles are told where a grid of places is pointed at."""
        return self.browser.script("""
            const canvas = document.querySelector('.map canvas'), box = canvas.getBoundingClientRect(), seen = new Set();
            for (let i = 0; i < 10000; ++i) {
              canvas.dispatchEvent(new PointerEvent('pointermove', {clientX: box.left + (i % 100 + 0.5) / 100 * box.width, clientY: box.top + (Math.floor(i / 100) + 0.5) / 100 * box.height}));
              seen.add(/^Tile (\\d+)/.exec(document.querySelector('.hint').textContent)?.[1]);
            }
            return seen.size""")


if __name__ == "__main__":
    unittest.main()
