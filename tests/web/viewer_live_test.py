"""The viewer of a live result in Chromium: it says which version is in memory, and draws a version when it is stored."""
import io
import unittest

import numpy as np

import looking

PLACE = "/v1/triangulations/cloud"


class LiveViewer(looking.LookingTest):
    def setUp(self):
        super().setUp()
        results = self.folder / "data" / "results"
        results.mkdir(mode=0o700)
        np.save(self.folder / "cloud.npy", np.random.default_rng(1).random((1500, 3)))
        self.tessera("triangulate", "cloud.npy", "-o", results / "cloud", "--tiles", "5")
        self.daemon = self.start("--live", "cloud", inputs=self.folder / "inputs", env={"TESSERAD_LIMITS_LIVE_LOG": "4K"})
        self.enter()
        self.browser.go("#/view/cloud")
        self.browser.until("return document.querySelector('.stage canvas')?.dataset.loaded === 'true'")

    def add(self, points):
        body = io.BytesIO()
        np.save(body, points)
        status, _, told = self.daemon.request("POST", f"{PLACE}/points", body.getvalue(), {"Content-Type": "application/x-npy"})
        self.assertEqual(status, 200, told)
        return told["version"]

    def test_the_view_follows_the_versions(self):
        b = self.browser
        b.until_text("version 0 is in memory and is shown", "#live-version")
        before = b.script("return document.querySelector('.stage canvas').dataset.triangles")
        version = self.add(np.array([[0.5, 0.5, 0.5]]))
        b.until_text(f"version {version} is in memory, version 0 is shown", "#live-version")
        b.look(self, "live-before")
        # Points outside, so that the hull changes. The log is then so long that the version is stored.
        version = self.add(np.random.default_rng(2).random((300, 3)) * 1.4 - 0.2)
        b.until_text(f"version {version} is in memory and is shown", "#live-version")
        b.until("return document.querySelector('.stage canvas').dataset.triangles !== arguments[0]", before)
        self.assertEqual(self.daemon.request("GET", PLACE)[2]["live"]["storedVersion"], version)
        b.look(self, "live-after")


if __name__ == "__main__":
    unittest.main()
