"""Certificates of a cluster, as whoever runs one makes them."""
import subprocess
import unittest

from cli import IO, USAGE, CliTest


class Certs(CliTest):
    def setUp(self):
        super().setUp()
        self.certs = self.folder / "certs"

    def verified(self, node):
        return subprocess.run(["openssl", "verify", "-CAfile", self.certs / "ca.pem", self.certs / f"{node}.pem"],
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT).returncode == 0

    def test_an_authority_and_its_nodes_are_made_and_what_to_copy_is_said(self):
        said = self.ok("certs", "init", self.certs, "--name", "lyon")
        for part in (f"{self.certs}/ca.pem: the authority of the cluster lyon, valid until ", f"{self.certs}/ca.key: the key of the authority",
                     f"tessera certs node {self.certs} NAME"):
            self.assertIn(part, said)
        said = self.ok("certs", "node", self.certs, "alpha", "10.0.0.7")
        for node in ("alpha", "10.0.0.7"):
            self.assertIn(f"{self.certs}/{node}.pem, {self.certs}/{node}.key: the node {node}, valid until ", said)
            self.assertTrue(self.verified(node))
        self.assertIn(f"copy {self.certs}/ca.pem and the two files of each node", said)
        self.assertIn(f"{self.certs}/ca.key stays", said)
        self.assertEqual(self.files(self.certs),
                         ["10.0.0.7.key", "10.0.0.7.pem", "alpha.key", "alpha.pem", "ca.key", "ca.pem"])
        self.assertEqual([path.name for path in self.certs.iterdir() if path.suffix == ".key" and path.stat().st_mode & 0o77], [])

    def test_json_says_the_same_and_quiet_nothing(self):
        authority, = self.json_lines(self.ok("certs", "init", self.certs, "--json"))
        self.assertEqual({key: authority[key] for key in ("event", "cluster", "authority", "key")},
                         {"event": "authority", "cluster": "tessera", "authority": f"{self.certs}/ca.pem", "key": f"{self.certs}/ca.key"})
        nodes = self.json_lines(self.ok("certs", "node", self.certs, "a", "b", "--days", "36500", "--json"))
        self.assertEqual([(node["event"], node["node"], node["certificate"]) for node in nodes],
                         [("node", name, f"{self.certs}/{name}.pem") for name in "ab"])
        # No node outlives its authority.
        self.assertEqual([node["valid_until"] for node in nodes], [authority["valid_until"]] * 2)
        self.assertEqual(self.ok("certs", "node", self.certs, "c", "--quiet"), "")

    def test_nothing_is_replaced(self):
        self.ok("certs", "init", self.certs)
        self.ok("certs", "node", self.certs, "a")
        before = {path.name: path.read_bytes() for path in self.certs.iterdir()}
        self.refused(USAGE, "certs", "init", self.certs, says=["ca.pem", "exists already"])
        self.refused(USAGE, "certs", "node", self.certs, "a", says=["a.pem", "exists already"])
        self.assertEqual({path.name: path.read_bytes() for path in self.certs.iterdir()}, before)

    def test_wrong_arguments_are_named_before_any_file_is_touched(self):
        for args, says in [((), "--help"), (("make", "x"), "'make'"), (("init",), "no folder"), (("node", "x"), "no name of a node"),
                           (("init", "x", "a"), "init makes no certificates of nodes"), (("node", "x", "a", "--name", "y"), "--name"),
                           (("init", "x", "--days", "0"), "--days"), (("init", "x", "--days", "36501"), "--days"),
                           (("init", "x", "--name", "two words"), "two words"), (("node", "x", "a", "a"), "'a' is given twice"),
                           (("init", "x", "--quiet", "--json"), "--quiet")]:
            with self.subTest(args=args):
                self.refused(USAGE, "certs", *args, says=says)
        self.assertEqual(self.files(), [])

    def test_one_wrong_name_among_many_makes_none(self):
        self.ok("certs", "init", self.certs)
        for name in ("../x", "ca", ".hidden", "a/b"):
            self.refused(USAGE, "certs", "node", self.certs, "good", name, says=f"'{name}' cannot be the name of a node")
        self.assertEqual(self.files(), ["certs", "certs/ca.key", "certs/ca.pem"])

    def test_nodes_need_an_authority(self):
        self.refused(IO, "certs", "node", self.certs, "a", says=str(self.certs))
        self.certs.mkdir()
        self.refused(USAGE, "certs", "node", self.certs, "a", says="no authority")
        self.assertEqual(self.files(), ["certs"])


if __name__ == "__main__":
    unittest.main()
