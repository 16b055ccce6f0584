"""What notebooks show: triangulations and jobs as HTML, and bars of progress."""
import html.parser
import io
import sys
import types
import unittest
from unittest import mock

import numpy as np
import tessera

import clouds


class Texts(html.parser.HTMLParser):
    """The tags of a page, each closed, and its texts."""

    def __init__(self, page):
        super().__init__()
        self.open, self.tags, self.texts, self.values = [], set(), [], []
        self.feed(page)
        assert not self.open, self.open

    def handle_starttag(self, tag, attributes):
        self.tags.add(tag)
        self.open.append(tag)
        self.values += [float(value) for name, value in attributes if name == "value"]

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, text):
        self.texts.append(text)


def job(answer):
    """A job whose daemon answers so."""
    made = tessera.Job.__new__(tessera.Job)
    made._id, made._path = "17<b>", "/jobs/17"
    made._http = types.SimpleNamespace(url="http://127.0.0.1:1", ask=answer)
    return made


class Pages(unittest.TestCase):
    def test_a_triangulation_is_a_table(self):
        t = tessera.triangulate(np.repeat(clouds.random(1000, 3), 2, axis=0), max_points_per_tile=300)
        page = Texts(t._repr_html_())
        shown = dict(zip(page.texts[1::2], page.texts[2::2]))
        self.assertEqual(page.texts[0], "Triangulation in 3D")
        self.assertEqual([shown[name] for name in ("points", "vertices", "duplicates", "tetrahedra", "tiles", "digest")],
                         ["2,000", "1,000", "1,000", f"{t.n_cells:,}", str(len(t)), t.digest])
        t.close()
        self.assertEqual(Texts(t._repr_html_()).texts, ["Triangulation, closed"])

    def test_a_coordinate_system_is_shown_by_its_name(self):
        local = 'ENGCRS["here &amp; <there>",EDATUM["x"],CS[Cartesian,2],AXIS["x",east],AXIS["y",north],LENGTHUNIT["metre",1]]'
        for system, shown in (("EPSG:2154", "EPSG:2154"), (local, "here &amp; <there>")):
            t = tessera.triangulate(clouds.random(10, 2), crs=system)
            self.assertIn(shown, Texts(t._repr_html_()).texts)

    def test_a_job_is_a_table_and_what_its_daemon_says_is_text(self):
        status = {"processID": "triangulate", "status": "running", "phase": "<script>alert(1)</script>", "progress": 40}
        page = Texts(job(lambda method, path: status)._repr_html_())
        self.assertEqual(page.tags, {"div", "strong", "table", "tr", "th", "td", "progress"})
        self.assertIn("<script>alert(1)</script>", page.texts)
        self.assertIn("Job 17<b>", page.texts)
        self.assertEqual(page.values, [0.4])
        ended = Texts(job(lambda method, path: {"status": "successful"})._repr_html_())
        self.assertNotIn("progress", ended.tags)

    def test_a_daemon_that_does_not_answer_is_told(self):
        def gone(method, path):
            raise tessera.IoError("http://127.0.0.1:1 cannot be reached")
        self.assertIn("not known: http://127.0.0.1:1 cannot be reached", Texts(job(gone)._repr_html_()).texts)


class Links(unittest.TestCase):
    def test_a_result_of_a_daemon_is_a_link_and_its_name_is_text(self):
        link = tessera.connect("http://127.0.0.1:7070/base/#token=secret").view('a "b"<i>')
        self.assertEqual(link.address, "http://127.0.0.1:7070/base/ui/#/view/a%20%22b%22%3Ci%3E")
        page = Texts(link._repr_html_())
        self.assertEqual((page.tags, page.texts), ({"a"}, ['View a "b"<i>']))
        self.assertNotIn("secret", link._repr_html_())


class Notebook:
    """Stands in for IPython, and for ipywidgets if `widgets`: what they show is in `shown`."""

    def __init__(self, widgets):
        self.shown = []
        handle = types.SimpleNamespace(update=self.shown.append)

        def display(thing, display_id=False):
            self.shown.append(thing)
            return handle if display_id else None

        shell = types.SimpleNamespace(kernel=object())
        self.modules = {"IPython": types.SimpleNamespace(get_ipython=lambda: shell), "ipywidgets": None,
                        "IPython.display": types.SimpleNamespace(display=display, HTML=str)}
        if widgets:
            self.modules["ipywidgets"] = types.SimpleNamespace(
                FloatProgress=types.SimpleNamespace, Label=types.SimpleNamespace, HBox=lambda children: types.SimpleNamespace(children=children))

    def __enter__(self):
        self.patch = mock.patch.dict(sys.modules, self.modules)
        self.patch.start()
        return self

    def __exit__(self, *_):
        self.patch.stop()


class Bars(unittest.TestCase):
    def test_shares_grow_from_0_to_1(self):
        seen = []
        bar = tessera.ProgressBar()
        bar._show = lambda share, phase: seen.append((share, phase))
        tessera.triangulate(clouds.random(50_000, 3), max_points_per_tile=5000, progress=bar)
        shares = [share for share, _ in seen]
        self.assertEqual(shares, sorted(shares))
        self.assertTrue(all(0 <= share <= 1 for share in shares))
        self.assertEqual(seen[-1], (1.0, "done"))

    def test_a_notebook_shows_a_line_of_html(self):
        with Notebook(widgets=False) as notebook:
            tessera.triangulate(clouds.random(500, 2), progress=tessera.ProgressBar())
        self.assertEqual(Texts(notebook.shown[0]).values, [0])
        last = Texts(notebook.shown[-1])
        self.assertEqual((last.values, last.texts[-1].strip()), ([1], "100% done"))

    def test_a_notebook_with_ipywidgets_shows_a_widget(self):
        with Notebook(widgets=True) as notebook:
            tessera.triangulate(clouds.random(500, 2), progress=tessera.ProgressBar())
        (box,) = notebook.shown
        filled, text = box.children
        self.assertEqual((filled.value, text.value), (1.0, "100% done"))

    def test_a_job_of_a_daemon_fills_it_too(self):
        with Notebook(widgets=True) as notebook:
            bar = tessera.ProgressBar()
            bar(tessera.Event(1, "progress", {"progress": 40, "phase": "splaying"}, "", ""))
            filled, text = notebook.shown[0].children
            self.assertEqual((filled.value, text.value), (0.4, "40% splaying"))
            bar(tessera.Event(2, "log", {}, "a line", ""))
            self.assertEqual(filled.value, 0.4)
            bar(tessera.Event(3, "status", {"status": "successful", "progress": 90}, "", ""))
            self.assertEqual(filled.value, 1.0)

    def test_a_terminal_shows_a_line_and_a_file_nothing(self):
        for terminal in (True, False):
            with mock.patch.object(sys, "stderr", io.StringIO()) as text:
                text.isatty = lambda: terminal
                tessera.triangulate(clouds.random(500, 2), progress=tessera.ProgressBar())
                said = text.getvalue()
            self.assertEqual(said.endswith("] 100% done           \n"), terminal)
            self.assertEqual(bool(said), terminal)


if __name__ == "__main__":
    unittest.main()
