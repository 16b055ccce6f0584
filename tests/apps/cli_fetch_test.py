"""Results of a daemon, as files here: all of them, checked, or none under its name."""
import shutil
import unittest

from cli import CORRUPT, IO, OK, USAGE
from cli_server import ServerTest


class Results(ServerTest):
    def test_they_are_listed(self):
        self.assertEqual(self.ok("results"), "there are no results\n")
        self.make_result()
        self.make_result("other", n=300)
        self.server.page = 1
        lines = self.ok("results").splitlines()
        self.assertEqual([line.split()[:2] for line in lines], [["RESULT", "DIM"], ["block", "3"], ["other", "3"]])
        results = self.json_lines(self.ok("results", "--json"))
        self.assertEqual([(result["name"], result["vertices"]) for result in results], [("block", 2000), ("other", 300)])


class Fetch(ServerTest):
    def setUp(self):
        super().setUp()
        self.make_result()
        self.source = self.server.results["block"]
        self.out = self.folder / "here" / "out"

    def content(self, folder):
        return {path.relative_to(folder): path.read_bytes() for path in folder.rglob("*") if path.is_file()}

    def test_of_a_result_that_was_changed_the_newest_version_comes(self):
        (self.folder / "equal.xyz").write_text("0.5 0.5 0.5\n0.5 0.5 0.5\n0.25 0.5 0.5\n")
        changed = self.local("update", self.source, "--add", self.folder / "equal.xyz")
        self.assertEqual(changed.returncode, OK, changed.stderr)
        self.ok("fetch", "block", "-o", self.out)
        files = {str(path) for path in self.content(self.out)}
        self.assertEqual(len([name for name in files if name.startswith("duplicates-")]), 1)
        self.assertTrue(any(name.endswith(("-2.vtu", "-2.pts")) for name in files))
        self.assertEqual(self.local("verify", self.out).returncode, OK)
        self.assertIn("\n2 ", self.local("log", self.out).stdout)
        self.assertEqual(self.local("verify", self.out, "--version", "1").returncode, USAGE)

    def tile_requests(self):
        return self.server.asked("GET", "/files/tiles/")

    def test_a_result_is_the_same_here(self):
        said = self.ok("fetch", "block", "-o", self.out)
        self.assertRegex(said, f"^{self.out}: 2 000 vertices, .* 4 tiles, ")
        self.assertEqual(self.content(self.out), self.content(self.source))
        self.assertEqual(self.local("verify", self.out).returncode, OK)
        self.assertEqual({request[2]["Authorization"] for request in self.server.requests}, {"Bearer secret-token"})

    def test_a_second_time_nothing_is_sent_and_what_is_damaged_is(self):
        self.ok("fetch", "block", "-o", self.out)
        count = len(self.tile_requests())
        (line,) = self.json_lines(self.ok("fetch", "block", "-o", self.out, "--json"))
        self.assertEqual((line["event"], line["tiles"], len(self.tile_requests())), ("fetched", 4, count))
        damaged = next((self.out / "tiles").iterdir())
        damaged.write_bytes(damaged.read_bytes()[:-1] + b"?")
        self.ok("fetch", "block", "-o", self.out)
        self.assertEqual(len(self.tile_requests()), count + 1)
        self.assertEqual(self.content(self.out), self.content(self.source))

    def test_connections_that_end_are_made_again_where_they_were(self):
        self.server.cut_files_after = [1000, 0, 2000, 50]
        self.ok("fetch", "block", "-o", self.out)
        self.assertEqual(self.content(self.out), self.content(self.source))
        ranges = [request[2].get("Range") for request in self.tile_requests()]
        self.assertEqual(ranges[:4], [None, "bytes=1000-", "bytes=1000-", "bytes=3000-"])
        self.assertTrue(all(request[2]["If-Range"].startswith('"xxh3-') for request in self.tile_requests() if "Range" in request[2]))

    def test_what_was_cut_short_is_gone_on_with(self):
        self.server.cut_files_after = [5000]
        self.refused(IO, "fetch", "block", "-o", self.out, "--patience", 0, says=self.server.url)
        self.assertFalse((self.out / "manifest.json").exists())
        self.assertEqual([path.suffix for path in (self.out / "tiles").iterdir()], [".tmp"])
        self.assertNotEqual(self.local("verify", self.out).returncode, OK)
        self.server.cut_files_after = []
        self.server.requests.clear()
        self.ok("fetch", "block", "-o", self.out)
        self.assertEqual(self.tile_requests()[0][2].get("Range"), "bytes=5000-")
        self.assertEqual(self.content(self.out), self.content(self.source))

    def test_the_beginning_of_another_file_is_not_gone_on_with(self):
        self.server.cut_files_after = [5000]
        self.refused(IO, "fetch", "block", "-o", self.out, "--patience", 0)
        self.server.cut_files_after = []
        (partial,) = (self.out / "tiles").iterdir()
        partial.write_bytes(b"x" * 5000)
        self.ok("fetch", "block", "-o", self.out)
        self.assertEqual(self.content(self.out), self.content(self.source))

    def test_damage_on_the_way_is_found(self):
        name = sorted(path.name for path in (self.source / "tiles").iterdir())[1]
        self.server.spoil[f"tiles/{name}"] = lambda content: content[:-100] + b"!" + content[-99:]
        self.refused(CORRUPT, "fetch", "block", "-o", self.out, says=[f"block/tiles/{name}", "checksum"])
        self.server.spoil[f"tiles/{name}"] = lambda content: content[:-1]
        self.refused(CORRUPT, "fetch", "block", "-o", self.out, says=[name, "bytes on the server"])
        self.assertFalse((self.out / "manifest.json").exists())
        self.assertFalse((self.out / "tiles" / name).exists())
        self.server.spoil["manifest.json"] = lambda content: b"{}"
        self.refused(CORRUPT, "fetch", "block", "-o", self.out, says=[self.server.url, "the manifest of block"])
        self.server.spoil.clear()
        self.ok("fetch", "block", "-o", self.out)
        self.assertEqual(self.content(self.out), self.content(self.source))

    def test_what_is_something_else_is_not_touched(self):
        self.ok("fetch", "block", "-o", self.out)
        self.make_result("other", n=300)
        before = self.content(self.out)
        self.refused(USAGE, "fetch", "other", "-o", self.out, says=[self.out, "holds another result"])
        self.assertEqual(self.content(self.out), before)
        self.write("file", "x")
        self.refused(USAGE, "fetch", "block", "-o", self.folder, says="is not empty")
        self.refused(USAGE, "fetch", "block", "-o", self.folder / "file", says="is no folder")
        self.refused(USAGE, "fetch", "nothing", "-o", self.folder / "new", says="nothing")
        self.refused(USAGE, "fetch", "block", says="-o FOLDER")
        self.assertFalse((self.folder / "new").exists())

    def test_the_report_is_not_needed(self):
        bare = self.folder / "bare"
        shutil.copytree(self.source, bare)
        (bare / "report.html").unlink()
        self.server.results["bare"] = bare
        self.ok("fetch", "bare", "-o", self.out)
        self.assertEqual(self.content(self.out), self.content(bare))


if __name__ == "__main__":
    unittest.main()
