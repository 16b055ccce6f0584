"""The dashboard on the real daemon: submit, watch, stop, resume, look; wrong input; a daemon that goes away; a token that only reads."""
import signal
import unittest

from selenium.webdriver import ActionChains, Keys

import looking


class Dashboard(looking.LookingTest):
    def submit(self, **fields):
        b = self.browser
        b.go("#/submit")
        for name, value in fields.items():
            b.fill(name, value)
        b.press("Submit")
        return b.until("return /^#\\/jobs\\/(.+)$/.exec(location.hash)?.[1]")

    def make_cloud(self, points):
        self.tessera("generate", "uniform", "-n", points, "-o", self.folder / "inputs" / "cloud.npy", "--quiet")

    def test_a_job_from_its_form_to_its_files(self):
        self.serve()
        self.enter()
        b = self.browser
        b.until_text("No jobs yet")
        b.look(self, "jobs-empty")
        b.press("New job")
        b.until("return document.getElementById('field-inputs')")
        # Every input of the process has a field.
        described = self.daemon.request("GET", "/v1/processes/triangulate")[2]["inputs"]
        fields = b.script("return [...document.querySelectorAll('.fields [name]')].map(e => e.name)")
        self.assertEqual(sorted(fields), sorted(described))
        b.fill("inputs", "*.las")
        b.until_text("This daemon would accept the job.", ".costs")
        estimate = self.daemon.request("POST", "/v1/processes/triangulate/estimate", {"inputs": {"inputs": ["*.las"]}})[2]
        self.assertIn(f"{estimate['points']:,}", b.text(".costs"))
        b.look(self, "submit")
        b.fill("output", "block")
        b.fill("tiles", "12")
        b.fill("dim", "3")
        b.fill("neighbors", "true")
        b.press("Submit")
        b.until_text("Done", ".status-line")
        b.until("return document.querySelector('.map .number') && [...document.querySelectorAll('.legend li')].at(-1).innerText.endsWith('12')")
        b.until("return /Z successful$/.test(document.querySelector('.log').textContent)")
        self.assertEqual(b.script("return document.title"), "block · Tessera")
        # The phases have the words of the command's summary, and a figure that says nothing any more is not there.
        self.assertEqual(b.text(".steps").split("\n"), ["planning", "reading", "triangulating", "joining tiles", "writing", "finishing"])
        self.assertNotIn("Memory", b.text(".figures"))
        self.assertNotIn("at rest", b.text(".figures"))
        self.assertIn("submitted today", b.text("main"))
        # The tiles are drawn in the colour that the legend gives to what is stored.
        self.assertTrue(b.script("""
            const canvas = document.querySelector('.map canvas'), pen = canvas.getContext('2d');
            const [r, g, b] = pen.getImageData(canvas.width / 2 | 0, canvas.height / 3 | 0, 1, 1).data;
            return getComputedStyle(document.querySelector('.tile-d')).backgroundColor === `rgb(${r}, ${g}, ${b})`"""))
        b.look(self, "job-done")
        b.press("Open the result")
        made = self.daemon.request("GET", "/v1/triangulations/block")[2]
        b.until_text(f"{made['cells']:,}")
        b.until_text(made["digest"])
        b.look(self, "result")
        link = b.script("return [...document.querySelectorAll('.files a')].find(a => a.innerText === 'manifest.json').href")
        self.assertEqual(b.script("return fetch(arguments[0]).then(a => a.json()).then(m => m.digest2)", link), made["digest"])
        b.press("Verify")
        b.until_text("Done", ".status-line")
        b.until_text("Outcome")
        b.look(self, "job-verify")
        b.go("#/results")
        b.until("return document.querySelectorAll('.results .row .name').length === 1")
        b.look(self, "results")
        b.go("#/jobs")
        b.until("return document.querySelectorAll('.jobs .row .name').length === 2")
        b.look(self, "jobs")
        b.go("#/nodes")
        b.until_text("this daemon")
        b.look(self, "nodes")

    def test_inputs_are_chosen_from_a_list(self):
        folder = self.folder / "inputs" / "more" / "deep"
        folder.mkdir(parents=True)
        (folder / "few.xyz").write_text("0 0 0\n1 0 0\n0 1 0\n0 0 1\n")
        (folder / "bad.ply").write_text("ply\nno header\n")
        self.serve()
        self.enter()
        b = self.browser
        b.go("#/submit")
        b.until("return document.querySelector('.chooser summary')")
        field = b.driver.find_element("id", "field-inputs")
        b.driver.find_element("css selector", ".chooser summary").send_keys(Keys.ENTER)
        first = self.daemon.request("GET", "/v1/inputs")[2]["inputs"]
        b.until_text(first[0]["name"], ".inputs")
        for each in first:
            self.assertIn(each["name"], b.text(".inputs"))
            if not each["folder"]:
                self.assertIn(f"{each['points']:,} points", b.text(".inputs"))
        self.assertIn("Lambert-93", b.text(".inputs"))
        b.look(self, "submit-inputs")
        # By keys, as all is: what is chosen is what is typed, and the reverse.
        boxes = b.driver.find_elements("css selector", ".inputs input")
        boxes[0].send_keys(Keys.SPACE)
        boxes[1].send_keys(Keys.SPACE)
        self.assertEqual(field.get_attribute("value"), "ign_77050_627755.las\nign_77050_627760.las")
        b.until_text("This daemon would accept the job.", ".costs")
        estimate = self.daemon.request("POST", "/v1/processes/triangulate/estimate",
                                       {"inputs": {"inputs": ["ign_77050_627755.las", "ign_77050_627760.las"]}})[2]
        self.assertIn(f"{estimate['points']:,}", b.text(".costs"))
        boxes[0].send_keys(Keys.SPACE)
        self.assertEqual(field.get_attribute("value"), "ign_77050_627760.las")
        field.clear()
        field.send_keys("ign_77055_627760.las")
        self.assertEqual(b.script("return [...document.querySelectorAll('.inputs input')].filter(e => e.checked).map(e => e.value)"),
                         ["ign_77055_627760.las"])
        b.press("more/", ".inputs")
        b.press("deep/", ".inputs")
        b.until_text("few.xyz", ".inputs")
        self.assertIn("more/deep/bad.ply, line 2:", b.text(".inputs .wrong"))
        self.assertEqual(b.text(".where").split("\n")[:3], ["All folders", "more", "deep"])
        b.driver.find_element("css selector", ".where .whole input").send_keys(Keys.SPACE)
        self.assertEqual(field.get_attribute("value"), "ign_77055_627760.las\nmore/deep")
        b.press("All folders", ".where")
        b.until_text("more/", ".inputs")
        # After an error nothing is left of what was told before, for who does not see it either.
        self.forgive = ("status of 422", "status of 400")
        b.fill("inputs", "nothing-*.las")
        b.until("return document.querySelector('.costs [data-state=failed]')")
        self.assertNotRegex(b.script("return document.querySelector('.costs dl').textContent"), r"\d")

    def test_what_was_made_stands_with_its_result(self):
        self.serve()
        for process, inputs in (("triangulate", {"inputs": ["*.las"], "output": "ground", "dim": 2, "class": [2]}),
                                ("dem", {"triangulation": "ground", "res": 0.5, "max_edge": 5}),
                                ("contours", {"triangulation": "ground", "interval": 0.5}),
                                ("export", {"triangulation": "ground", "output": "mesh.ply"})):
            job = self.daemon.request("POST", f"/v1/processes/{process}/execution", {"inputs": inputs})[2]
            self.assertEqual(self.daemon.wait(job["jobID"])["status"], "successful")
        self.enter()
        b = self.browser
        b.go("#/jobs")
        b.until_text("Raster of ground")
        self.assertIn("Contour lines of ground", b.text("main"))
        b.go("#/results/ground")
        b.until("return document.querySelectorAll('[aria-labelledby=made-title] li').length === 3")
        rows = b.script("return [...document.querySelectorAll('[aria-labelledby=made-title] li')].map(e => e.innerText.split('\\n').join(' '))")
        for row, name, kind in zip(rows, ("contours.gpkg", "dem.tif", "mesh.ply"), ("Contour lines", "Raster", "Export, ply")):
            self.assertTrue(row.startswith(f"{name} {kind} · "), row)
        link = b.script("return [...document.querySelectorAll('.files a')].find(a => a.innerText === 'mesh.ply').href")
        self.assertEqual(b.script("return fetch(arguments[0]).then(a => a.text()).then(t => t.slice(0, 3))", link), "ply")
        # The map that the service draws, and the lines over it.
        b.until("const all = [...document.querySelectorAll('.map-picture img')]; return all.length > 0 && all.every(e => e.complete && e.naturalWidth === 256)")
        matched = self.daemon.request("GET", "/v1/collections/ground.contours/items?limit=1")[2]["numberMatched"]
        self.assertEqual(b.script("return document.querySelector('.map-picture path').getAttribute('d').split('M').length - 1"), matched)
        self.assertEqual(b.text(".map-figure"), "On the map, north up: the hillshade of dem.tif and the lines of contours.gpkg.")
        self.assertEqual(b.script("return [...document.querySelectorAll('.heading .primary')].map(e => e.innerText)"), ["View"])
        b.look(self, "result-made")
        b.script("document.querySelector('[aria-label=\"Remove mesh.ply\"]').click()")
        b.press("Remove the export", "dialog")
        b.until("return document.querySelectorAll('[aria-labelledby=made-title] li').length === 2")
        self.assertEqual([each["name"] for each in self.daemon.request("GET", "/v1/triangulations/ground/exports")[2]["exports"]], ["contours.gpkg", "dem.tif"])

    def test_a_wrong_input_is_a_sentence_at_its_field(self):
        self.forgive = ("status of 422", "status of 400")
        self.serve()
        self.enter()
        b = self.browser
        b.go("#/submit")
        b.fill("inputs", "nothing-*.las")
        b.until("return document.querySelector('.costs [data-state=failed]')")
        b.press("Submit")
        b.until("return document.activeElement.id === 'field-inputs' && document.activeElement.ariaInvalid === 'true'")
        told = self.daemon.request("POST", "/v1/processes/triangulate/execution", {"inputs": {"inputs": ["nothing-*.las"]}})[2]["detail"]
        self.assertEqual("inputs: " + b.text("#field-inputs-wrong").rstrip(".").lower(), told.rstrip(".").lower())
        b.look(self, "submit-wrong")
        b.fill("inputs", "*.las")
        b.fill("tiles", "many")
        b.press("Submit")
        b.until("return document.activeElement.id === 'field-tiles'")
        self.assertIn("not a whole number", b.text("#field-tiles-wrong"))
        self.assertEqual(self.daemon.request("GET", "/v1/jobs")[2]["numberMatched"], 0)
        # What only the job finds out stands at the job.
        b.fill("tiles", "12")
        b.fill("crop", "1, 2, 3, 4, 5, 6")
        b.press("Submit")
        b.until_text("no points are left of 262813", "section .notice")
        b.until_text("Failed", ".status-line")
        self.assertFalse(b.driver.find_element("css selector", ".graphs").is_displayed())
        b.look(self, "job-failed")

    def test_a_job_is_stopped_and_resumed(self):
        self.make_cloud(4_000_000)  # a quarter of a minute's work for one thread: far longer than it takes to stop it
        self.serve()
        self.enter()
        b = self.browser
        job = self.submit(inputs="cloud.npy", output="cloud", tiles="60", threads="1")
        b.until("return document.querySelector('.map canvas')?.getAttribute('aria-label').includes('triangulated')")
        b.picture("job-running")
        b.press("Stop")
        b.until("return document.querySelector('dialog[open]')")
        b.picture("dialog")
        self.assertEqual(b.unnamed(), [])
        b.press("Stop the job", "dialog")
        b.until_text("Stopped", ".status-line")
        self.assertEqual(self.daemon.request("GET", f"/v1/jobs/{job}")[2]["status"], "dismissed")
        b.until_text("dismissed", ".log")
        b.press("Resume")
        b.until_text("Done", ".status-line")
        self.assertIn("2 times", b.text(".figures"))
        self.assertEqual(b.script("return [...document.querySelectorAll('.legend li')].at(-1).innerText.trim().split(/\\s+/).at(-1)"), "60")
        log = self.daemon.request("GET", f"/v1/jobs/{job}/log")[2].decode()
        b.until_text("successful", ".log")
        shown = b.script("return document.querySelector('.log').textContent")
        self.assertEqual(shown.split("\n")[-1][24:], log.rstrip("\n").split("\n")[-1][24:])
        b.press("Forget")
        b.press("Forget the job", "dialog")
        b.until_text("No jobs yet")
        self.assertEqual(self.daemon.request("GET", f"/v1/jobs/{job}")[0], 410)

    def test_a_job_that_ends_before_it_is_stopped_is_not_forgotten(self):
        self.make_cloud(300_000)
        self.serve()
        self.enter()
        b = self.browser
        job = self.submit(inputs="cloud.npy", output="cloud", threads="1")
        b.press("Stop")
        b.until("return document.querySelector('dialog[open]')")
        b.until_text("Done", ".status-line")
        b.press("Stop the job", "dialog")
        b.until("return !document.querySelector('dialog[open]')")
        b.until_text("successful", ".log")
        self.assertEqual(self.daemon.request("GET", f"/v1/jobs/{job}")[2]["status"], "successful")

    def test_mail_between_tiles_is_seen_while_a_job_runs_and_not_at_its_end(self):
        self.make_cloud(2_000_000)
        self.serve()
        self.enter()
        b = self.browser
        self.submit(inputs="cloud.npy", output="cloud", tiles="60", threads="1")
        b.until("return document.querySelectorAll('.arcs .arc').length > 10")
        said = b.until("return /Points have lately gone \\d+ ways between tiles; most from tile \\d+ to tile \\d+: [\\d,]+ points\\./"
                       ".exec(document.querySelector('.map canvas').getAttribute('aria-label'))?.[0]")
        self.assertTrue(said)
        b.picture("job-mail-real")
        b.until_text("Done", ".status-line")
        b.until("return [...document.querySelectorAll('.legend li')].at(-1).innerText.endsWith('60')")
        b.until("return document.querySelectorAll('.arcs *').length === 0 && document.querySelector('.mail').innerText === ''")

    def test_a_daemon_that_goes_away_is_missed_and_found_again(self):
        self.forgive = ("ERR_CONNECTION_REFUSED", "ERR_INCOMPLETE_CHUNKED_ENCODING", "ERR_CONNECTION_RESET", "ERR_EMPTY_RESPONSE")
        daemon_ = self.serve()
        self.enter()
        b = self.browser
        b.until_text("No jobs yet")
        self.assertEqual(daemon_.end(signal.SIGKILL), -signal.SIGKILL)
        b.until_text("cannot be reached", ".lost")
        b.until_text("Not connected", ".connection")
        b.look(self, "lost")
        again = self.serve(f"127.0.0.1:{daemon_.port}")
        job = again.request("POST", "/v1/processes/info/execution", {"inputs": {"inputs": ["*.las"]}},
                            {"Prefer": "respond-async"})[2]["jobID"]
        b.until_text("Live", ".connection")
        self.assertFalse(b.driver.find_element("css selector", ".lost").is_displayed())
        b.until("return document.querySelector('.row .name')?.getAttribute('href') === `#/jobs/${arguments[0]}`", job)
        b.until_text("Done", ".row")

    def test_a_token_that_reads_sees_and_changes_nothing(self):
        daemon_ = self.serve()
        daemon_.wait(daemon_.request("POST", "/v1/processes/triangulate/execution",
                                     {"inputs": {"inputs": ["*.las"], "output": "block"}})[2]["jobID"])
        self.enter("read")
        b = self.browser
        for page, wanted in (("#/jobs", "block"), ("#/results/block", "Tetrahedra"), ("#/nodes", "this daemon"), ("#/jobs", "block")):
            b.go(page)
            b.until_text(wanted)
            for name in ("New job", "Stop", "Resume", "Forget", "Verify", "Export", "Remove", "Drain"):
                self.assertFalse(b.has_button(name), (page, name))
        b.script("document.querySelector('.row .name').click()")
        b.until_text("Done", ".status-line")
        self.assertTrue(b.has_button("Report"))
        b.until_text("successful", ".log")
        self.assertFalse(b.has_button("Forget"))
        b.go("#/submit")
        b.until_text("There is no such page")

    def test_who_has_no_cookie_is_asked_for_a_token(self):
        self.forgive = ("status of 401",)
        self.serve()
        b = self.browser
        b.open(self.daemon.url + "ui")
        b.until_text("Sign in")
        b.look(self, "sign-in")
        token = b.driver.find_element("id", "token")
        token.send_keys("w" * 64)
        b.press("Enter")
        b.until_text("does not know this token")
        token.clear()
        token.send_keys(looking.TOKENS["admin"] + "\n")
        b.until_text("No jobs yet")
        self.assertNotIn(looking.TOKENS["admin"], b.script("return JSON.stringify({...localStorage, ...sessionStorage}) + document.cookie"))

    def test_who_signs_out_is_asked_for_a_token_again(self):
        self.forgive = ("status of 401",)
        self.serve()
        self.enter()
        b = self.browser
        b.until_text("No jobs yet")
        of_this_daemon = lambda: [c for c in b.driver.get_cookies() if str(self.daemon.port) in c["name"]]  # others had theirs
        (cookie,) = of_this_daemon()
        b.press("Sign out", "header")
        b.until_text("Sign in")
        self.assertEqual(of_this_daemon(), [])
        # Nor is it of use to whoever has got hold of it.
        shown = {"Cookie": f"{cookie['name']}={cookie['value']}"}
        self.assertEqual(self.daemon.request("GET", "/v1/caller", headers=shown, token=False)[0], 401)
        b.open(self.daemon.url)
        b.until_text("Sign in")
        self.assertNotIn(looking.TOKENS["admin"], self.daemon.messages())

    def test_all_of_it_is_reached_by_keys(self):
        self.serve()
        self.enter()
        b = self.browser
        b.until_text("No jobs yet")
        reached = []
        for _ in range(20):
            ActionChains(b.driver).send_keys(Keys.TAB).perform()
            name = b.script("const e = document.activeElement; return e === document.body ? '' : e.innerText.trim()")
            if name in reached or not name:
                break
            reached.append(name)
            # What has the focus is seen to have it.
            self.assertNotEqual(b.script("return getComputedStyle(document.activeElement).outlineStyle"), "none", name)
        for name in ("Skip to the content", "Tessera", "Jobs", "Results", "Nodes", "New job", "All", "Failed", "Submit the first one"):
            self.assertIn(name, reached)
        theme = b.driver.find_element("css selector", ".theme")
        for expected in ("light", "dark", None):
            theme.send_keys(Keys.ENTER)
            self.assertEqual(b.script("return document.documentElement.dataset.theme ?? null"), expected)


if __name__ == "__main__":
    unittest.main()
