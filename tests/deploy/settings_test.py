"""The sample configuration: every key of the daemon once, with a default that is TOML, and nothing set; and the manual page."""
import os
import pathlib
import re
import subprocess
import tomllib
import unittest

SOURCE = pathlib.Path(os.environ["SOURCE"])
TEXT = (SOURCE / "config/tesserad.toml").read_text()
KEYS = {"listen", "metrics", "data", "inputs", "memory", "threads", "jobs", "uploads", "retention", "tls-certificate",
        "tls-key", "public-url", "hosts", "insecure", "log", "print-token", "live", "live-memory", "remote-prefix", "s3-anonymous", "hdf5",
        "cluster", "advertise", "join", "certs", "roles", "node-name", "cluster-name", "scratch", "lease", "grace",
        "drain-timeout"}
LIMITS = {"queued", "jobs", "ended", "points", "disk", "reserve", "uploads", "data-lease", "live-log"}


class Settings(unittest.TestCase):
    def test_as_it_is_it_sets_nothing(self):
        self.assertEqual(tomllib.loads(TEXT), {"limits": {}})

    def test_with_its_keys_set_it_is_toml_and_has_every_key(self):
        shown = tomllib.loads(re.sub(r"(?m)^# (?=[a-z0-9-]+ = )", "", TEXT))
        self.assertEqual(set(shown.pop("limits")), LIMITS)
        self.assertEqual(set(shown), KEYS)

    def test_the_manual_page_has_every_key(self):
        page = (SOURCE / "deploy/tesserad.8").read_text()
        shown = {found.replace("\\-", "-") for found in re.findall(r"(?m)^\.BR \\-\\-(\S+)(?: ,)?$", page)}
        self.assertEqual(shown, KEYS | {"config", "help", "version"})

    def test_the_shell_completes_every_key(self):
        def completed(*words):
            script = ('. "$1"; shift; COMP_WORDS=("$@") COMP_CWORD=$(($# - 1)); _tesserad; printf "%s\\n" "${COMPREPLY[@]}"')
            done = subprocess.run(["bash", "-c", script, "bash", SOURCE / "deploy/tesserad.bash-completion", "tesserad", *words],
                                  text=True, stdout=subprocess.PIPE, check=True)
            return set(done.stdout.split())
        options = {"--" + key for key in KEYS | {"config", "help", "version"}}
        self.assertEqual(completed(""), options | {"health"})
        self.assertEqual(completed("--data", "/srv", "--tls"), {"--tls-certificate", "--tls-key"})
        self.assertEqual(completed("--log", "j"), {"json"})
        self.assertEqual(completed("health", ""), {"--metrics", "--help"})

    def test_it_is_the_one_that_unit_and_manifest_use(self):
        self.assertIn("/tessera/tesserad.toml", (SOURCE / "deploy/tesserad.service.in").read_text())
        self.assertIn("/etc/tessera/tesserad.toml\n", (SOURCE / "deploy/debian/conffiles").read_text())


if __name__ == "__main__":
    unittest.main()
