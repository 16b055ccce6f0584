"""A browser and a daemon with inputs and tokens; after each test, no complaints in the console, no other host asked."""
import shutil

import browser
import daemon

TOKENS = {"admin": "a" * 64, "read": "r" * 64}


class LookingTest(daemon.DaemonTest):
    @classmethod
    def setUpClass(cls):
        cls.browser = browser.Browser()
        cls.addClassCleanup(cls.browser.quit)

    def setUp(self):
        super().setUp()
        data = self.folder / "data"
        data.mkdir()
        (data / "tokens").touch(0o600)
        (data / "tokens").write_text("".join(f"{role}er {role} {token}\n" for role, token in TOKENS.items()))
        inputs = self.folder / "inputs"
        inputs.mkdir()
        for file in daemon.IGN.glob("*.las"):
            shutil.copy(file, inputs)
        self.browser.driver.delete_all_cookies()
        self.forgive = ()  # what the console may be told in this test

    def serve(self, listen="127.0.0.1:0"):
        self.daemon = self.start(inputs=self.folder / "inputs", listen=listen)
        return self.daemon

    def enter(self, role="admin"):
        self.browser.open(f"{self.daemon.url}#token={TOKENS[role]}")
        self.assertEqual(self.browser.driver.current_url, self.daemon.url + "ui/")
        self.browser.until_text("Live", ".connection")

    def tearDown(self):
        complaints = self.browser.complaints()
        self.browser.open("about:blank")  # before the daemon ends, which would be complained of in the next test
        hosts = self.browser.hosts()  # of all that this page has asked, so that the next test hears of none of it
        self.assertEqual([text for text in complaints if not any(known in text for known in self.forgive)], [])
        self.assertLessEqual(hosts, {f"127.0.0.1:{self.daemon.port}"})
