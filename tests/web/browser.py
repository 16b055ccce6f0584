"""Chromium without a screen, and what is asked of every page: no errors, no other host, names, contrast."""
import base64
import json
import os
import pathlib
import urllib.parse

from selenium import webdriver
from selenium.webdriver.chrome.service import Service
from selenium.webdriver.common.by import By
from selenium.webdriver.support.ui import WebDriverWait

SCREENSHOTS = pathlib.Path(os.environ["SCREENSHOTS"])
CHECKS = (pathlib.Path(__file__).parent / "checks.js").read_text()
AXE = (pathlib.Path(os.environ["WEB_PACKAGES"]) / "axe-core/axe.min.js").read_text() if "WEB_PACKAGES" in os.environ else ""
NAMED = {"button", "link", "textbox", "combobox", "img", "image", "table", "progressbar", "meter", "checkbox", "region",
         "navigation", "ProgressIndicator", "dialog"}
WIDTHS = {400: 800, 1280: 800, 3840: 2160}
HANGS_S = 900  # far beyond what anything takes; ctest ends what hangs longer


class Browser:
    def __init__(self):
        options = webdriver.ChromeOptions()
        options.binary_location = "/usr/bin/chromium"
        for argument in ("--headless=new", "--no-sandbox", "--disable-dev-shm-usage", "--use-gl=angle", "--use-angle=swiftshader",
                         "--enable-unsafe-swiftshader", "--window-size=1280,800",
                         "--disable-background-networking", "--disable-component-update", "--no-first-run",
                         "--force-device-scale-factor=1", "--disable-sync", "--disable-default-apps"):
            options.add_argument(argument)
        options.set_capability("goog:loggingPrefs", {"browser": "ALL", "performance": "ALL"})
        self.driver = webdriver.Chrome(service=Service("/usr/bin/chromedriver"), options=options)
        self.driver.set_script_timeout(HANGS_S)
        self.driver.execute_cdp_cmd("Page.addScriptToEvaluateOnNewDocument", {"source": CHECKS})

    def quit(self):
        self.driver.quit()

    # ---- Looking and doing

    def open(self, url):
        self.driver.get(url)

    def go(self, page):
        """To a page of the dashboard, without loading it again."""
        self.script("location.hash = arguments[0]", page)

    def script(self, text, *arguments):
        return self.driver.execute_script(text, *arguments)

    def until(self, text, *arguments):
        """Waits until the script says what is true, and returns it."""
        return WebDriverWait(self.driver, HANGS_S, poll_frequency=0.05).until(
            lambda driver: driver.execute_script(text, *arguments), f"never true: {text} {arguments}")

    def text(self, selector="body"):
        return self.driver.find_element(By.CSS_SELECTOR, selector).text

    def until_text(self, wanted, selector="main"):
        self.until("const e = document.querySelector(arguments[1]); return !!e && e.innerText.includes(arguments[0])", wanted, selector)

    def button(self, name, within="main"):
        """By its text, once it is there and can be pressed."""
        return self.until("""return [...document.querySelectorAll(arguments[1] + ' button, ' + arguments[1] + ' a.button')]
            .find(e => e.innerText.trim() === arguments[0] && e.offsetParent !== null && e.getAttribute('aria-disabled') !== 'true')""",
                          name, within)

    def press(self, name, within="main"):
        self.button(name, within).click()

    def has_button(self, name):
        return self.script("return [...document.querySelectorAll('button, a.button')].some(e => e.innerText.trim() === arguments[0])", name)

    def fill(self, field, value):
        element = self.until("return document.getElementById(arguments[0])", f"field-{field}")
        self.script("const folded = arguments[0].closest('details'); if (folded) folded.open = true", element)
        if element.tag_name == "select":
            self.script("arguments[0].value = arguments[1]; arguments[0].dispatchEvent(new Event('input', {bubbles: true}))", element, value)
            return
        element.clear()
        element.send_keys(value)

    def size(self, width):
        self.driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", {
            "width": width, "height": WIDTHS[width], "deviceScaleFactor": 1, "mobile": False})

    def theme(self, name, motion="no-preference"):
        self.driver.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": [
            {"name": "prefers-color-scheme", "value": name}, {"name": "prefers-reduced-motion", "value": motion}]})

    # ---- Judging

    def picture(self, name):
        SCREENSHOTS.mkdir(parents=True, exist_ok=True)
        shot = self.driver.execute_cdp_cmd("Page.captureScreenshot", {"format": "png", "optimizeForSpeed": True})  # of coding, not of looks
        (SCREENSHOTS / f"{name}.png").write_bytes(base64.b64decode(shot["data"]))

    def look(self, test, name):
        """Pictures of the page in both themes and all widths, and what is wrong with it in any of them."""
        for theme in ("light", "dark"):
            for width in WIDTHS:
                # What moves is drawn again and again, and without a graphics card that takes seconds at the largest size.
                self.theme(theme, "no-preference" if width < 3840 else "reduce")
                self.size(width)
                self.script("return new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))")
                self.picture(f"{name}-{theme}-{width}")
                where = f"{name}, {theme}, {width} px"
                test.assertEqual(self.script("return checks.contrast()"), [], where)
                test.assertEqual(self.script("return checks.beyond()"), [], where)
                test.assertEqual(self.script("return checks.overlaps()"), [], where)
                if width < 3840:
                    test.assertEqual(self.axe(), [], where)
        self.size(1280)
        self.theme("light")
        test.assertEqual(self.unnamed(), [], name)
        test.assertEqual(self.script("return checks.structure()"), [], name)

    def axe(self):
        """What axe-core finds against WCAG 2.1 AA and good practice, rule by rule."""
        if not self.script("return 'axe' in window"):
            # Not as a script of the page, whose policy would not allow it. It asks for nothing, and tells the console nothing.
            self.driver.execute_script(AXE)
        return self.driver.execute_async_script("""
            const done = arguments[arguments.length - 1];
            axe.run(document, {resultTypes: ['violations']}).then(found => done(found.violations.map(rule =>
              `${rule.id}: ${rule.help}: ${rule.nodes.slice(0, 3).map(node => node.target.join(' ')).join(', ')}`)), error => done([String(error)]))""")

    def unnamed(self):
        """What can be used or is a landmark, and has no name for those who do not see it: as Chromium computes names."""
        tree = self.driver.execute_cdp_cmd("Accessibility.getFullAXTree", {})["nodes"]
        return [f"{node['role']['value']} {json.dumps(node.get('properties', []))[:200]}" for node in tree
                if not node.get("ignored") and node.get("role", {}).get("value") in NAMED
                and not node.get("name", {}).get("value", "").strip()]

    def complaints(self):
        """What the console was told since the last call; a request that fails is told there, too."""
        return [entry["message"] for entry in self.driver.get_log("browser") if entry["level"] in ("SEVERE", "WARNING")]

    def hosts(self):
        """Of all requests since the last call."""
        asked = set()
        for entry in self.driver.get_log("performance"):
            message = json.loads(entry["message"])["message"]
            if message["method"] == "Network.requestWillBeSent":
                url = urllib.parse.urlsplit(message["params"]["request"]["url"])
                if url.scheme in ("http", "https", "ws", "wss"):
                    asked.add(url.netloc)
        return asked
