"""No text that says where points are makes GDAL or PROJ open anything but PROJ's own files."""
import os
import pathlib
import re
import shutil
import subprocess
import tempfile
import unittest

import opens
import texts

PROBE = os.environ["CRS_PROBE"]


class CrsOpens(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        opens.need_strace()

    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="tessera-opens-"))
        self.addCleanup(shutil.rmtree, self.folder, True)
        # The working folder of a user: nothing in it, and nothing in the home, is PROJ's.
        self.here, self.home = self.folder / "here", self.folder / "home"
        for folder in (self.here, self.home / ".local/share/proj"):
            folder.mkdir(parents=True)

    def environment(self, **more):
        clean = {key: value for key, value in os.environ.items() if not key.startswith(("PROJ_", "GDAL_", "OSR_", "XDG_"))}
        return clean | {"HOME": str(self.home)} | more

    def probe(self, named, environment=None, cwd=None):
        """What each of the texts had opened, and whether it was taken; and what came before the first."""
        file = self.folder / "texts"
        file.write_bytes(b"".join(text.encode() + b"\0" for text in named.values()))
        done, seen = opens.watched([PROBE, file], self.folder / "trace", cwd=cwd or self.here,
                                   env=environment or self.environment())
        self.assertEqual(done.returncode, 0, done.stderr)
        parts = [[]]
        for call in seen:
            if re.fullmatch(r"/text/\d+", call[1]):
                parts.append([])
            else:
                parts[-1].append(call)
        answers = done.stdout.split()
        self.assertEqual((len(parts), len(answers)), (len(named) + 1, len(named)))
        return parts[0], {name: (part, answer) for name, part, answer in zip(named, parts[1:], answers)}

    def check(self, named, expected, **more):
        _, of = self.probe(named, **more)
        for name, (seen, answer) in of.items():
            with self.subTest(name):
                self.assertEqual(opens.opened(seen), [])
                self.assertEqual([path for _, path in seen if str(self.folder) in path and
                                  path != str(self.home) and not opens.is_system(path)], [])
                self.assertEqual(answer, expected)

    def test_what_surveys_write_is_taken_and_opens_files_of_projs_alone(self):
        self.check(texts.TAKEN, "taken")

    def test_the_probe_sees_what_is_opened(self):
        """Or a test that sees nothing would pass."""
        _, of = self.probe({"code": "EPSG:2154"})
        self.assertIn("/usr/share/proj/proj.db", [path for name, path in of["code"][0] if name in opens.OPENING])

    def test_texts_that_name_a_file_are_refused_and_open_nothing(self):
        canary = self.here / "canary.txt"
        canary.write_text("<foo> +proj=longlat +ellps=GRS80 <>\n")
        self.check(texts.refused(str(canary)), "refused")

    def test_texts_that_name_a_pipe_wait_for_nobody(self):
        pipe = self.here / "pipe"
        os.mkfifo(pipe)
        self.check(texts.refused(str(pipe)), "refused")
        self.check(texts.inert(str(pipe)), "taken")
        self.check(texts.refused("/proc/self/fd/2"), "refused")

    def test_names_without_a_folder_are_sought_among_projs_own_files(self):
        """Not here, where there is a pipe of that name, nor in the home or in /tmp/proj, whoever made that."""
        for name in ("canary.gsb", "canary:x"):
            for folder in (self.here, self.home / ".local/share/proj"):
                os.mkfifo(folder / name)
        self.check(texts.by_name("canary.gsb"), "taken")
        self.check(texts.by_name("canary"), "taken")
        nobody = self.folder / "none"
        _, of = self.probe({"code": "EPSG:2154"} | texts.by_name("canary.gsb"), environment=self.environment(HOME=str(nobody)))
        seen = [path for part, _ in of.values() for _, path in part]
        self.assertEqual([path for path in seen if path.startswith("/tmp/proj")], [])

    def test_projs_own_grids_are_found(self):
        _, of = self.probe({"own": texts.bound("ntf_r93.gsb"), "own, of heights": texts.by_name("egm96_15.gtx")["heights by name"]})
        opened = {name: {path for call, path in seen if call in opens.OPENING} for name, (seen, _) in of.items()}
        self.assertIn("/usr/share/proj/ntf_r93.gsb", opened["own"])

    def test_the_net_is_asked_for_nothing_whatever_the_environment_says(self):
        named = texts.refused("/x.tif") | texts.by_name("us_nga_egm08_25.tif") | texts.TAKEN
        environment = self.environment(PROJ_NETWORK="ON", PROJ_NETWORK_ENDPOINT="http://127.0.0.1:9")
        before, of = self.probe(named, environment=environment)
        for name, seen in [("start", before)] + [(name, seen) for name, (seen, _) in of.items()]:
            with self.subTest(name):
                self.assertEqual([address for call, address in seen if call == "connect"], [])

    def test_no_other_driver_of_gdals_is_loaded(self):
        before, of = self.probe({"geotiff": "EPSG:2154"})
        plugins = [path for seen in (before, of["geotiff"][0]) for _, path in seen if "gdalplugins" in path]
        self.assertEqual(plugins, [])


if __name__ == "__main__":
    unittest.main()
