"""The site of documents: it is made without the network, has all parts, and what is made of programs and sources is complete."""
import functools
import http.server
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import threading
import unittest

SOURCE, BUILD = pathlib.Path(os.environ["SOURCE"]), pathlib.Path(os.environ["BUILD"])
sys.path.append(str(SOURCE / "scripts/site"))
import reference  # noqa: E402

try:
    from selenium import webdriver
    from selenium.webdriver.common.by import By
    from selenium.webdriver.support.ui import WebDriverWait
except ImportError:
    webdriver = None


class Silent(http.server.SimpleHTTPRequestHandler):
    def log_message(self, *_):
        pass


class Reference(unittest.TestCase):
    def test_of_commands_has_each_option_and_example(self):
        described = (BUILD / "src/front/apps/manual/commands.json").read_text()
        pages = {title: page for title, _, page in reference.command_pages(described)}
        for command in json.loads(described):
            for option in command["options"]:
                self.assertIn(f"`--{option['name']}`", pages[command["name"]])
            for line in command["footer"].splitlines():
                self.assertIn(line.strip().removesuffix(":"), pages[command["name"]])

    def test_of_python_has_what_the_package_exports(self):
        page = reference.python_page(SOURCE / "python/tessera")
        exported = re.search(r"__all__ = \[(.*?)\]", (SOURCE / "python/tessera/_public.py").read_text(), re.DOTALL)[1]
        for name in re.findall(r'"(\w+)"', exported):
            self.assertRegex(page, rf"(?m)^##+ {name}$")

    def test_of_cpp_has_each_header(self):
        pages = reference.header_pages(SOURCE / "include/tessera")
        self.assertEqual({title for title, _, _ in pages}, {path.name for path in (SOURCE / "include/tessera").glob("*.h")})
        self.assertIn("class TESSERA_PUBLIC HeightsRequest", dict((title, page) for title, _, page in pages)["heights.h"])

    def test_docstrings_become_lists(self):
        page = reference.docstring_page("Does it.\n\nParameters\n----------\na, b\n    What they are.\nc\n    Another.\n\nThe rest.")
        self.assertIn("**Parameters**", page)
        self.assertIn("- `a, b`:\n    What they are.", page)
        self.assertTrue(page.endswith("The rest.\n\n"))


@unittest.skipIf(shutil.which("mkdocs") is None, "no mkdocs: ./tessera.sh deps site")
class Site(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.site = pathlib.Path(cls.enterClassContext(tempfile.TemporaryDirectory()), "site")
        cls.done = subprocess.run([SOURCE / "scripts/site/make_site.py", BUILD, cls.site], text=True, capture_output=True)

    def test_has_all_parts_and_pages(self):
        self.assertEqual(self.done.returncode, 0, self.done.stderr)
        first = (self.site / "index.html").read_text()
        for part in ("Tutorials", "How-to", "Reference", "Explanations"):
            self.assertIn(part, first)
        pages = {str(path.relative_to(self.site)) for path in self.site.rglob("*.html")}
        names = {path.stem for path in (SOURCE / "docs").glob("*.md")} - {"README"}
        self.assertEqual({f"docs/{name}.html" for name in names | {"index"}} - pages, set())
        self.assertIn("/v1/processes/{process}/execution", (self.site / "reference/http.html").read_text())
        self.assertTrue((self.site / "docs/pictures/qgis.png").exists())

    @unittest.skipIf(webdriver is None or shutil.which("chromium") is None, "no Chromium")
    def test_is_searched_and_copied_in_a_browser_without_the_network(self):
        server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), functools.partial(Silent, directory=self.site))
        self.addCleanup(server.server_close)
        self.addCleanup(server.shutdown)
        threading.Thread(target=server.serve_forever, daemon=True).start()
        options = webdriver.ChromeOptions()
        for word in ("--headless=new", "--no-sandbox", "--disable-gpu", "--window-size=1300,900"):
            options.add_argument(word)
        options.set_capability("goog:loggingPrefs", {"performance": "ALL"})
        browser = webdriver.Chrome(options=options)
        self.addCleanup(browser.quit)
        browser.get(f"http://127.0.0.1:{server.server_port}/reference/commands/dem.html")
        box = browser.find_element(By.CSS_SELECTOR, ".md-search__input")
        box.click()
        box.send_keys("hillshade")
        found = WebDriverWait(browser, 600).until(lambda _: browser.find_elements(By.CSS_SELECTOR, ".md-search-result__link"))
        self.assertTrue(any("dem" in one.get_attribute("href") for one in found))
        self.assertTrue(browser.find_elements(By.CSS_SELECTOR, ".md-clipboard"))
        asked = [json.loads(entry["message"])["message"] for entry in browser.get_log("performance")]
        addresses = [one["params"]["request"]["url"] for one in asked if one["method"] == "Network.requestWillBeSent"]
        self.assertEqual([one for one in addresses if not one.startswith((f"http://127.0.0.1:{server.server_port}/", "data:"))], [])


if __name__ == "__main__":
    unittest.main()
