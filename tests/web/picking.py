"""Where a click was, and what the service says of the cell that is told for it."""
import json

import numpy as np
from selenium.webdriver import ActionChains


def digits(point):
    """As a page writes it: whole numbers without a point."""
    return ", ".join(repr(value).removesuffix(".0") for value in point)


def on_canvas(browser, points):
    """Where points of the result were at the last click, in pixels from the canvas' middle."""
    canvas = browser.script("const c = document.querySelector('.stage canvas'); return [c.dataset.seen, c.clientWidth, c.clientHeight]")
    seen = json.loads(canvas[0])
    rows = np.hstack([np.array(points) - seen["origin"], np.ones((len(points), 1))]) @ np.array(seen["matrix"]).reshape(4, 4)
    return rows[:, :2] / rows[:, 3:] * [canvas[1] / 2, -canvas[2] / 2]


def is_inside(place, corners, slack):
    """Of the convex hull of corners in the plane, or at most so far from it: no line through it and along two of them separates."""
    for i, a in enumerate(corners):
        for b in corners[i + 1:]:
            normal = np.array([b[1] - a[1], a[0] - b[0]])
            if not normal.any():
                continue
            normal /= np.linalg.norm(normal)
            heights = (corners - a) @ normal
            if not heights.min() - slack <= (place - a) @ normal <= heights.max() + slack:
                return False
    return True


def click(browser, x, y):
    """At so many pixels from the canvas' middle. Returns the address that was asked for it, once it is told."""
    before = browser.text(".cell")
    canvas = browser.script("return document.querySelector('.stage canvas')")
    browser.script("performance.clearResourceTimings()")
    ActionChains(browser.driver).move_to_element_with_offset(canvas, x, y).click().perform()
    asked = browser.until("return performance.getEntriesByType('resource').map(r => r.name).find(n => n.includes('/locate?'))")
    browser.until("""const told = document.querySelector('.cell').innerText;
        return told !== arguments[0] || performance.getEntriesByType('resource').some(r => r.name.includes('/locate?') && r.responseEnd > 0)""", before)
    return asked
