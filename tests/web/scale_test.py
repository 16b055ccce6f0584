"""The dashboard with 10,000 jobs and 100,000 tiles, and a stream of events that breaks: on a service that is played."""
import pathlib
import re
import tempfile
import unittest
import urllib.request

import browser
import daemon
import played_service

JOBS, TILES, RESULTS = 10_000, 100_000, 2_000
ELEMENTS_MAX = 1_000  # of a page, however long its list is
SHIFT_MAX = 0.02      # of 0.1, above which a page counts as one that jumps


def files_of_the_dashboard():
    with tempfile.TemporaryDirectory() as folder:
        running = daemon.Daemon(pathlib.Path(folder) / "data")
        files = {}
        names = ["", "app.js", "style.css", "icon.svg"]
        for name in names:
            with urllib.request.urlopen(f"{running.url}ui/{name}") as answer:
                files[name or "index.html"] = (answer.headers["Content-Type"], answer.headers["Content-Security-Policy"], answer.read())
            if name.endswith(".js"):  # and what it is made of
                found = re.findall(r'"\./([\w-]+\.js)"', files[name][2].decode())
                names += [part for part in dict.fromkeys(found) if part not in names]
        running.end()
        running.log.close()
        return files


class Scale(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.files = files_of_the_dashboard()
        cls.browser = browser.Browser()
        cls.addClassCleanup(cls.browser.quit)

    def play(self, page, job=None, **sizes):
        """`job`: instead of the newest one."""
        self.service = played_service.PlayedService(self.files, **sizes)
        self.addCleanup(self.service.close)
        if job:
            self.service.jobs[0] = job
        self.browser.open(f"http://127.0.0.1:{self.service.port}/ui/{page}")
        self.browser.until_text("Live", ".connection")

    def tearDown(self):
        complaints, hosts = self.browser.complaints(), self.browser.hosts()
        self.browser.open("about:blank")
        self.assertEqual([text for text in complaints if "INCOMPLETE_CHUNKED" not in text], [])
        self.assertEqual(hosts, {f"127.0.0.1:{self.service.port}"})

    def stands_still(self, first=0):
        """`first`: how many shifts do not count, for they came of something else."""
        shifts = self.browser.script("return checks.shifts()")[first:]
        self.assertLess(sum(value for value, *_ in shifts), SHIFT_MAX, shifts)

    def elements(self):
        return self.browser.script("return document.querySelectorAll('*').length")

    def names(self):
        """Of the rows in sight, from above."""
        return self.browser.script("""return [...document.querySelectorAll('.row')].filter(row => {
            const {top, bottom} = row.getBoundingClientRect();
            return top >= 92 && bottom <= innerHeight;
        }).sort((a, b) => a.getBoundingClientRect().top - b.getBoundingClientRect().top).map(row => row.querySelector('.name').innerText)""")

    def scroll(self, share):
        """To that share of the page; then until all rows in sight are known."""
        self.browser.script("scrollTo(0, arguments[0] * (document.documentElement.scrollHeight - innerHeight))", share)
        self.browser.until("""return new Promise(done => requestAnimationFrame(() => requestAnimationFrame(() => {
            const rows = [...document.querySelectorAll('.row')];
            const seen = rows.filter(r => r.getBoundingClientRect().bottom > 0 && r.getBoundingClientRect().top < innerHeight);
            done(seen.length > 0 && seen.every(r => !r.classList.contains('unknown')));
        })))""")

    def test_ten_thousand_jobs(self):
        b = self.browser
        self.play("", jobs=JOBS)
        b.until_text("10,000 jobs")
        b.until("return document.querySelectorAll('.row .name').length > 5")
        self.assertEqual(self.names()[0], f"block-{JOBS}")
        self.assertLess(len(self.service.asked), 20)  # no more is asked for than is looked at
        height = b.script("return document.querySelector('.rows').offsetHeight")
        for share in (0.01, 0.02, 0.1, 0.5, 0.9, 1, 0.3):
            self.scroll(share)
            self.assertLess(self.elements(), ELEMENTS_MAX)
            self.assertEqual(b.script("return document.querySelector('.rows').offsetHeight"), height)
            numbers = [int(name.removeprefix("block-")) for name in self.names()]
            self.assertEqual(numbers, list(range(numbers[0], numbers[0] - len(numbers), -1)))
            rows = b.script("return document.querySelector('.table').getAttribute('aria-rowcount')")
            self.assertEqual(rows, str(JOBS + 1))
        self.scroll(1)
        self.assertEqual(self.names()[-1], "block-1")
        # Jobs that come do not move what somebody reads further down.
        self.scroll(0.5)
        before = self.names()
        for number in range(JOBS + 1, JOBS + 201):
            self.service.tell(number, "status", jobID=f"{number:012x}", status=played_service.job(number, "accepted"))
        b.until_text("10,200 jobs")
        self.scroll_settles()
        self.assertEqual(self.names(), before)
        self.scroll(0)
        self.assertEqual(self.names()[0], f"block-{JOBS + 200}")
        # What happens to one is seen at its row, and moves no other.
        top = self.names()
        self.service.tell(JOBS + 300, "progress", jobID=f"{JOBS + 200:012x}", status=played_service.job(
            JOBS + 200, "running", progress=42, phase="splaying", eta=7))
        b.until_text("joining tiles, 42 %, about 7.0 s left", ".row")
        self.assertEqual(self.names(), top)
        self.stands_still()
        b.look(self, "jobs-many")
        b.go("#/jobs?show=failed")
        b.until_text("2,000 jobs")
        b.until_text("this file ends in the middle", ".row")

    def scroll_settles(self):
        self.browser.script("return new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))")

    def test_a_hundred_thousand_tiles(self):
        b = self.browser
        now = played_service.job(1, "running", phase="triangulating", progress=10, figures=dict.fromkeys(
            ("elapsed", "pointsTotal", "pointsRouted", "pointsTriangulated", "tilesTotal", "tilesTriangulated", "tilesStored",
             "tilesAsleep", "updatesSent", "updatesProcessed", "pointsSent", "memoryBytes"), 1) | {"tilesTotal": TILES, "nodes": [
                 {"name": name, "tiles": TILES // 4, "tilesTriangulated": 100 * i, "tilesStored": i, "memoryBytes": i << 20,
                  "lost": name == "c"} for i, name in enumerate("abc")]})
        self.play("#/jobs/000000000001", jobs=1, tiles=TILES, job=now)
        b.until("return document.querySelector('.map canvas')?.getAttribute('aria-label').includes('100,000 waiting')")
        b.until_text("3 tiles were begun again", ".tiles")
        self.assertEqual(b.script("return [...document.querySelectorAll('.nodes tbody tr')].map(row => row.innerText.split(/\\s+/).join(' '))"),
                         ["a at work 0 of 25,000 triangulated 0 B", "b at work 100 of 25,000 triangulated 1.00 MiB", "c lost 2 stored –"])
        self.assertEqual(b.text(".chart:last-child figcaption").split("\n"), ["Nodes at work", "2"])
        order = "wtsqd"
        for step in range(1, 9):
            self.service.stages = "".join(order[(tile * 7 // TILES + step) // 3 % 5] for tile in range(TILES))
            self.service.tell(1 + step, "progress", jobID="000000000001", status=now | {"progress": 10 + step})
            b.until("""const wanted = arguments[0];
                return [...document.querySelectorAll('.legend .number')].map(e => e.innerText.replaceAll(',', '')).join() === wanted""",
                    ",".join(str(self.service.stages.count(letter)) for letter in order))
            self.assertLess(self.elements(), ELEMENTS_MAX)
        # Mail between parts of the map: the layout cuts it into 128 after 7 cuts.
        self.rows_have_arcs(now)
        # Every tile in the colour of its stage, though only those were drawn that changed: as pointing at it tells.
        wrong = b.script("""
            const canvas = document.querySelector('.map canvas'), pen = canvas.getContext('2d'), hint = document.querySelector('.hint');
            const colours = Object.fromEntries(['waiting', 'triangulated', 'joined', 'settled', 'stored'].map((word, i) =>
              [word, getComputedStyle(document.querySelector('.tile-' + 'wtsqd'[i])).backgroundColor]));
            const pixels = pen.getImageData(0, 0, canvas.width, canvas.height).data;
            const box = canvas.getBoundingClientRect(), wrong = [], seen = new Set();
            for (let i = 0; i < 400; ++i) {
              const x = (i % 20 + 0.5) / 20 * box.width, y = (Math.floor(i / 20) + 0.5) / 20 * box.height;
              canvas.dispatchEvent(new PointerEvent('pointermove', {clientX: box.left + x, clientY: box.top + y}));
              const [, tile, word] = /^Tile (\\d+): (.+)$/.exec(hint.textContent) ?? [];
              const at = 4 * (Math.floor(y * canvas.height / box.height) * canvas.width + Math.floor(x * canvas.width / box.width));
              const [r, g, b] = pixels.slice(at, at + 3);
              if (word !== {w: 'waiting', t: 'triangulated', s: 'joined', q: 'settled', d: 'stored'}[arguments[0][tile]]) wrong.push(['stage', tile, word]);
              if (colours[word] !== `rgb(${r}, ${g}, ${b})`) wrong.push(['colour', tile, word, r, g, b]);
              seen.add(tile);
            }
            if (seen.size < 390) wrong.push(['tiles', seen.size]);
            return wrong""", self.service.stages)
        self.assertLess(len(wrong), 20, wrong[:10])  # a tile is about one pixel: some points are at its border
        self.assertEqual([each for each in wrong if each[0] != "colour"], [])
        self.stands_still()
        b.look(self, "job-many-tiles")
        self.assertEqual(sum("layout=true" in path for path in self.service.asked), 1)

    def rows_have_arcs(self, now):
        b = self.browser
        layout = self.service.layout
        parts = [0]
        for _ in range(7):
            parts = [child for row in parts for child in (layout["below"][row], layout["above"][row])]
        self.service.mail = {"from": parts, "to": parts[1:] + parts[:1], "points": list(range(256, 128, -1))}
        self.service.tell(50, "progress", jobID="000000000001", status=now | {"progress": 50})
        b.until("return document.querySelectorAll('.arcs .arc').length === 128")
        tiles = sum(1 for _ in self.tiles_below(parts[0])), sum(1 for _ in self.tiles_below(parts[1]))
        self.assertEqual(b.text(".mail"), f"Points have lately gone 128 ways between tiles; most from a part of {tiles[0]} tiles to a part of {tiles[1]} tiles: 256 points.")
        self.assertLess(self.elements(), ELEMENTS_MAX)
        b.picture("job-many-tiles-mail")
        self.service.mail = None
        self.service.tell(51, "progress", jobID="000000000001", status=now | {"progress": 51})
        b.until("return document.querySelectorAll('.arcs *').length === 0")

    def tiles_below(self, part):
        if part < 0:
            yield -1 - part
        else:
            yield from self.tiles_below(self.service.layout["below"][part])
            yield from self.tiles_below(self.service.layout["above"][part])

    def test_mail_between_tiles(self):
        b = self.browser
        now = played_service.job(1, "running", phase="splaying", progress=60)
        self.play("#/jobs/000000000001", jobs=1, tiles=60, job=now)
        b.until("return document.querySelector('.map canvas')?.getAttribute('aria-label').includes('60 waiting')")
        self.assertEqual(self.arcs(), {})
        self.told = 1

        def tell(mail, stages="s" * 60, **status):
            self.service.mail, self.service.stages = mail, stages
            self.told += 1
            self.service.tell(self.told, "progress", jobID="000000000001", status=now | {"progress": 60 + self.told} | status)
            b.until("return document.querySelectorAll('.arcs .arc').length === arguments[0]", len(mail["points"]) if mail else 0)

        # An arc each way, wider where there is more, from the middle of one tile to that of the other.
        tell({"from": [-1, -2, -18], "to": [-2, -1, -60], "points": [4000, 1000, 10]})
        arcs = self.arcs()
        self.assertGreater(arcs[0]["width"], arcs[1]["width"])
        self.assertGreater(arcs[1]["width"], arcs[2]["width"])
        self.assertEqual([arc["ends"] for arc in arcs.values()], [["0", "1"], ["1", "0"], ["17", "59"]])
        said = "Points have lately gone 3 ways between tiles; most from tile 0 to tile 1: 4,000 points."
        self.assertEqual(b.text(".mail"), said)
        self.assertEqual(b.script("return document.querySelector('.map canvas').getAttribute('aria-label')"), f"Map of the tiles: 60 joined. {said}")
        for motion, name in (("no-preference", "mail"), ("reduce", "none")):
            b.theme("light", motion)
            self.assertEqual(b.script("return getComputedStyle(document.querySelector('.arcs .arc')).animationName"), name)
        # All neighbours at once, then half of them.
        ways = [(a, c) for a in range(60) for c in (a + 1, a - 1, a ^ 2) if 0 <= c < 60][:128]
        tell({"from": [-1 - a for a, _ in ways], "to": [-1 - c for _, c in ways], "points": [9000 // (1 + i) + 1 for i in range(len(ways))]},
             "t" * 20 + "s" * 30 + "w" * 10)
        self.assertLess(self.elements(), ELEMENTS_MAX)
        self.stands_still()
        b.look(self, "job-mail")
        for theme in ("light", "dark"):
            for width in (400, 1280):
                b.theme(theme)
                b.size(width)
                b.script("document.querySelector('.map').scrollIntoView({behavior: 'instant'}); scrollBy(0, -80)")
                b.script("return new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))")
                b.picture(f"map-mail-{theme}-{width}")
        b.size(1280)
        b.theme("light")
        tell({"from": [-1], "to": [-2], "points": [7]}, "q" * 60)
        self.assertEqual(b.text(".mail"), "Points have lately gone one way between tiles; most from tile 0 to tile 1: 7 points.")
        # What happens at the end, and when it is stopped: no arc is left of it.
        tell(None, "q" * 60, phase="collecting")
        self.assertEqual(b.text(".mail"), "")
        tell({"from": [-1], "to": [-2], "points": [7]}, "q" * 60)
        self.service.tell(99, "status", jobID="000000000001", status=now | {"status": "dismissed"})
        b.until("return document.querySelectorAll('.arcs *').length === 0")
        self.assertNotIn("Mail", b.script("return document.querySelector('.map canvas').getAttribute('aria-label')"))

    def arcs(self):
        """Of each its width, and the numbers of the tiles at whose middle it ends: as pointing there tells."""
        told = self.browser.script("""
            const canvas = document.querySelector('.map canvas'), box = canvas.getBoundingClientRect(), hint = document.querySelector('.hint');
            const tileAt = (x, y) => {
              canvas.dispatchEvent(new PointerEvent('pointermove', {clientX: box.left + x * box.width / 1000, clientY: box.top + y * box.width / 1000}));
              return /^Tile (\\d+):/.exec(hint.textContent)?.[1];
            };
            return [...document.querySelectorAll('.arcs .arc')].map(arc => {
              const [x, y, , , x1, y1] = arc.getAttribute('d').match(/[\\d.-]+/g).map(Number);
              return {width: parseFloat(getComputedStyle(arc).strokeWidth), ends: [tileAt(x, y), tileAt(x1, y1)]};
            })""")
        return dict(enumerate(told))

    def test_results_and_nodes_of_a_large_installation(self):
        b = self.browser
        self.play("#/results", results=RESULTS, nodes=64)
        b.until_text("2,000 results")
        for share in (0.2, 1):
            self.scroll(share)
            self.assertLess(self.elements(), ELEMENTS_MAX)
        self.assertEqual(self.names()[-1], f"r{RESULTS - 1:05}")
        b.go("#/nodes")
        b.until_text("64 nodes, 512 threads")
        self.assertEqual(len(b.driver.find_elements("css selector", ".nodes tbody tr")), 64)
        lost = self.service.nodes.pop(7)
        b.until_text("63 nodes")
        b.until_text("gone, lost or ended", ".nodes .gone")
        self.assertIn(lost["name"], b.text(".nodes .gone"))
        b.look(self, "nodes-many")

    def test_a_stream_goes_on_after_the_last_event_that_was_heard(self):
        b = self.browser
        self.play("", jobs=3)
        service = self.service
        b.until_text("3 jobs")
        self.assertEqual([last for last, _ in service.streams], [None])
        service.tell(41, "status", jobID="000000000004", status=played_service.job(4, "accepted"))
        b.until_text("4 jobs")
        service.jobs.insert(0, played_service.job(4, "accepted"))
        service.end_stream()
        self.until_streams(2)
        self.assertEqual(service.streams[1][0], "41")
        # Nothing of what was missed is kept any more, and the stream ends at once: from now on, and the list anew.
        service.end_stream()
        self.until_streams(3)
        self.assertIsNone(service.streams[2][0])
        service.jobs.insert(0, played_service.job(5))
        service.end_stream()
        self.until_streams(4)
        b.until_text("5 jobs")
        self.assertEqual(sum(path == "/v1/events" for path in service.asked), 4)

    def test_what_happens_while_a_list_is_on_its_way_is_not_lost(self):
        b = self.browser
        self.play("", job=played_service.job(3, "running"), jobs=3)
        b.until_text("3 jobs")
        service = self.service
        service.released.clear()
        lists = service.lists
        b.go("#/jobs?show=all")  # anew
        service.wait_for_lists(lists + 1)
        service.tell(7, "status", jobID="000000000003", status=played_service.job(3, "successful"))
        service.tell(8, "status", jobID="000000000004", status=played_service.job(4, "accepted"))
        b.until("return checks.events() === 2")
        service.released.set()
        b.until_text("4 jobs")
        b.until("return document.querySelectorAll('.row .name').length === 4")
        self.assertEqual(self.names(), ["block-4", "block-3", "block-2", "block-1"])
        states = b.script("return [...document.querySelectorAll('.row .state')].map(e => e.innerText)")
        self.assertEqual(states[:2], ["Waiting", "Done"])

    def until_streams(self, count):
        self.service.wait_for_streams(count)
        self.browser.until_text("Live", ".connection")


if __name__ == "__main__":
    unittest.main()
