"""The unit of systemd: systemd understands every line, and finds it as little exposed as docs/security.md says."""
import json
import os
import pathlib
import re
import subprocess
import tempfile
import unittest

SOURCE = pathlib.Path(os.environ["SOURCE"])
UNIT = pathlib.Path(os.environ["UNIT"])
EXPOSURE_MAX = 0.9  # of 10; what is left of it is in LEFT
# Directives that systemd would have stricter, and why they are not: sockets, the network, memory's size in /proc.
LEFT = {"RootDirectoryOrRootImage", "RestrictAddressFamilies_AF_UNIX", "RestrictAddressFamilies_AF_INET_INET6", "ProcSubset",
        "PrivateNetwork", "DeviceAllow", "IPAddressDeny"}


def analyze(*words):
    return subprocess.run(["systemd-analyze", *words], capture_output=True, text=True)


class Unit(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        held = tempfile.TemporaryDirectory(prefix="tessera-unit-")
        cls.addClassCleanup(held.cleanup)
        cls.text = UNIT.read_text()
        cls.unit = pathlib.Path(held.name) / "tesserad.service"
        # systemd looks for the program, which need not be installed.
        cls.unit.write_text(re.sub(r"^ExecStart=\S+", "ExecStart=/bin/true", cls.text, flags=re.MULTILINE))

    def verify(self, text):
        path = self.unit.with_name("changed.service")
        path.write_text(text)
        done = analyze("verify", "--man=no", str(path))
        return done.returncode, [line for line in done.stderr.splitlines() if path.name in line]

    def test_systemd_understands_every_line(self):
        self.assertEqual(self.verify(self.unit.read_text()), (0, []))

    def node(self):
        text = (SOURCE / "deploy/tesserad-node.service").read_text()
        return re.sub(r"^ExecStart=/usr/bin/tesserad", "ExecStart=/bin/true", text, flags=re.MULTILINE)

    def test_the_one_of_a_node_is_understood_and_comes_back(self):
        self.assertEqual(self.verify(self.node()), (0, []))
        self.assertIn("\nRestart=always\n", self.node())

    def test_the_one_of_a_node_is_as_strict(self):
        path = self.unit.with_name("tesserad-node.service")
        path.write_text(self.node())
        done = analyze("security", "--offline=yes", "--json=short", str(path))
        left = {entry["json_field"] for entry in json.loads(done.stdout) if entry["set"] is False and entry["exposure"]}
        self.assertEqual(left, LEFT)
        # What differs is where a node reads and writes, and whom it hears.
        section = r"(?ms)^\[Service\]$(.*?)^\["
        rules = [{line for line in re.search(section, text)[1].splitlines() if "=" in line and line[0] != "#"}
                 for text in (self.text, self.node())]
        looser = {line.split("=")[0] for line in rules[0] - rules[1]}
        self.assertEqual(looser, {"ExecStart", "ExecReload", "Environment", "Restart", "TimeoutStopSec", "KillMode", "DynamicUser",
                                  "StateDirectory", "StateDirectoryMode", "CacheDirectory", "IPAddressAllow"})

    def test_what_a_daemon_prints_reaches_no_journal(self):
        for text in (self.text, self.node()):
            self.assertRegex(text, r"(?m)^StandardOutput=null$")
            self.assertRegex(text, r"(?m)^StandardError=journal$")

    def test_a_node_has_the_time_to_hand_its_tiles_over(self):
        stop = re.search(r"(?m)^TimeoutStopSec=(\d+)s$", (SOURCE / "deploy/tesserad-node.service").read_text())
        drain = re.search(r'(?m)^# drain-timeout = "(\d+)s"$', (SOURCE / "config/tesserad.toml").read_text())
        self.assertGreater(int(stop[1]), int(drain[1]))

    def test_a_line_that_it_does_not_understand_is_told(self):
        _, told = self.verify(self.unit.read_text().replace("ProtectSystem=strict", "ProtectSystem=strictly"))
        self.assertEqual(len(told), 1)
        self.assertIn("strictly", told[0])

    def test_it_is_no_more_exposed_than_said(self):
        arguments = ("security", "--offline=yes", f"--threshold={round(10 * EXPOSURE_MAX)}", "--no-pager")
        done = analyze(*arguments, str(self.unit))
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        figure = float(re.search(r"Overall exposure level for \S+: ([0-9.]+)", done.stdout)[1])
        self.assertEqual(figure, EXPOSURE_MAX)
        self.assertIn(f"exposure {EXPOSURE_MAX} of 10", (SOURCE / "docs/security.md").read_text())

    def test_what_is_left_open_is_known(self):
        done = analyze("security", "--offline=yes", "--json=short", str(self.unit))
        left = {entry["json_field"] for entry in json.loads(done.stdout) if entry["set"] is False and entry["exposure"]}
        self.assertEqual(left, LEFT)

    def test_a_looser_unit_is_more_exposed(self):
        path = self.unit.with_name("loose.service")
        path.write_text(self.unit.read_text().replace("DynamicUser=yes\n", ""))
        done = analyze("security", "--offline=yes", f"--threshold={round(10 * EXPOSURE_MAX)}", "--no-pager", str(path))
        self.assertNotEqual(done.returncode, 0)

    def test_nothing_is_left_to_be_filled_in(self):
        self.assertNotIn("@", re.sub(r"^(SystemCallFilter=.*|\s*#.*)$", "", self.text, flags=re.MULTILINE))
        self.assertRegex(self.text, r"(?m)^ExecStart=/\S+/tesserad --data ")


if __name__ == "__main__":
    unittest.main()
