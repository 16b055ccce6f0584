"""Help, arguments, and where options come from: everything that is settled before any file is touched."""
import unittest

from cli import IO, OK, USAGE, CliTest

DAEMON = ["jobs", "job", "watch", "cancel", "resume", "inputs", "results", "fetch", "upload", "nodes", "drain"]  # ask one
COMMANDS = ["triangulate", "verify", "info", "export", "region", "query", "dem", "contours", "profile", "hag", "volume", "alpha", "surface", "track", "tileset", "materialise", "update", "log", "measure", "columns", "voronoi", "density", "voids", "certs", "cluster", *DAEMON, "generate"]


class Help(CliTest):
    def test_the_version_is_told(self):
        self.assertRegex(self.ok("--version"), r"^tessera \d+\.\d+\.\d+\n$")

    def test_every_command_has_help_with_examples(self):
        overview = self.ok("--help")
        for command in COMMANDS:
            self.assertIn(command, overview)
            text = self.ok(command, "--help")
            self.assertIn("Examples:", text)
            self.assertIn(f"tessera {command} ", text)

    def test_the_overview_lists_commands_for_tests_apart(self):
        users, rest = self.ok("--help").split("Asking a daemon (--server):")
        daemon, tests = rest.split("For tests:")
        for command in COMMANDS:
            place = tests if command == "generate" else daemon if command in DAEMON else users
            self.assertIn(f"\n  {command} ", place)

    def test_help_is_a_command_too(self):
        self.assertEqual(self.ok("help"), self.ok("--help"))
        for command in COMMANDS:
            self.assertEqual(self.ok("help", command), self.ok(command, "--help"))

    def test_help_shows_no_inner_matters_of_the_parser(self):
        for command in COMMANDS:
            text = self.ok(command, "--help")
            self.assertNotIn("Excludes", text)
            self.assertRegex(text, r"--json +one JSON object")
        self.assertIn("--memory SIZE ", self.ok("triangulate", "--help"))
        self.assertIn("inputs FILE ...", self.ok("triangulate", "--help"))

    def test_a_misspelt_command_is_answered_with_the_nearest(self):
        self.refused(USAGE, "triangualte", "a.las", says="'triangualte' is not a command; perhaps you mean 'triangulate'")
        self.refused(USAGE, "help", "verfy", says="perhaps you mean 'verify'")
        self.refused(USAGE, "scan.las", says=["the commands are triangulate, verify, info, export", "tessera --help"])

    def test_nothing_and_nonsense_are_refused(self):
        self.refused(USAGE, says="--help")
        self.refused(USAGE, "fly", says="--help")
        self.refused(USAGE, "triangulate", "a.las", "-o", "out", "--no-such-option", says="--no-such-option")

    def test_wrong_options_are_named_in_a_sentence(self):
        self.refused(USAGE, "dem", "result", "--resolution", "0.5",
                     says="'--resolution' is not an option of 'tessera dem'; perhaps you mean '--res'; see 'tessera dem --help'")
        self.refused(USAGE, "triangulate", "a.las", "--tilse=3", says="'--tilse' is not an option of 'tessera triangulate'; perhaps you mean '--tiles'")
        self.refused(USAGE, "measure", "a", "b", "c", says="'b' is one argument too many for 'tessera measure'")
        self.refused(USAGE, "triangulate", "a.las", "--tiles", "3", "--tiles", "4", says="--tiles is given more than once; see")
        self.refused(USAGE, "triangulate", "a.las", "--class", "2", "--class", "9",
                     says="--class is given more than once: give all values at once, with commas between them")
        self.refused(USAGE, "triangulate", "a.las", "--tiles", says="--tiles needs a value: N")


class Arguments(CliTest):
    def refuse(self, *args, says):
        # Nothing exists: had it looked for the input, the status would be another.
        self.refused(USAGE, "triangulate", "missing.las", "-o", "out", *args, says=says)
        self.assertEqual(self.files(), [])

    def test_each_wrong_value_is_named_before_any_file_is_touched(self):
        for option, value in [("--threads", "0"), ("--threads", "two"), ("--threads", "1025"), ("--memory", "4GB"),
                              ("--memory", "-1"), ("--tiles", "0"), ("--tiles", "2M"), ("--dim", "4"),
                              ("--max-points-per-tile", "1.5"), ("--partition", "voronoi"), ("--crop", "1,2,3"),
                              ("--crop", "5,0,1,1"), ("--class", "2,x"), ("--attributes", "a,,b"), ("--kernel", "magic")]:
            with self.subTest(option=option, value=value):
                self.refuse(option, value, says=option)

    def test_contradictions_are_refused(self):
        self.refuse("--tiles", "4", "--max-points-per-tile", "10k", says=["--tiles", "--max-points-per-tile"])
        self.refuse("--resume", "--overwrite", says=["--resume", "--overwrite"])
        self.refuse("--quiet", "-v", says=["--quiet", "--verbose"])
        self.refuse("--dim", "2", "--crop", "0,0,0,1,1,1", says="--crop")

    def test_what_is_required_must_be_there(self):
        self.refused(USAGE, "triangulate", "a.las", says="-o")
        self.refused(USAGE, "triangulate", "-o", "out", says="input")
        self.refused(USAGE, "verify", says="result folder")
        self.refused(USAGE, "info", says="given")
        self.refused(USAGE, "export", "out", says="-o")
        self.refused(USAGE, "export", "out", "-o", "x.3ds", says="3ds")
        self.refused(USAGE, "generate", says="--help")

    def test_a_negative_crop_is_no_option(self):
        cloud = self.xyz(n=200)
        self.ok("triangulate", cloud, "-o", self.out, "--crop", "-1,-1,2,2", "--quiet")


class Sources(CliTest):
    """Precedence: flag > environment > file."""

    def tiles(self, *args, env=None):
        text = self.ok("info", self.cloud, "--json", *args, env=env)
        return self.json_lines(text)[0]["tiles"]

    def setUp(self):
        super().setUp()
        self.cloud = self.xyz()
        self.config = self.write("my.toml", "[info]\ntiles = 5\n")

    def test_the_file_counts_when_nothing_else_is_said(self):
        self.assertEqual(self.tiles("--config", self.config), 5)
        self.assertEqual(self.tiles(env={"TESSERA_CONFIG": str(self.config)}), 5)

    def test_the_environment_beats_the_file(self):
        self.assertEqual(self.tiles("--config", self.config, env={"TESSERA_TILES": "6"}), 6)

    def test_the_flag_beats_both(self):
        self.assertEqual(self.tiles("--config", self.config, "--tiles", "7", env={"TESSERA_TILES": "6"}), 7)

    def test_a_switch_of_the_environment_is_undone_by_its_negation(self):
        env = {"TESSERA_QUIET": "yes"}
        self.assertEqual(self.ok("triangulate", self.cloud, "-o", "a", env=env), "")
        self.assertNotEqual(self.ok("triangulate", self.cloud, "-o", "b", "--no-quiet", env=env), "")

    def test_a_wrong_variable_is_named(self):
        self.refused(USAGE, "info", self.cloud, env={"TESSERA_THREADS": "many"}, says=["TESSERA_THREADS", "many"])

    def test_unknown_keys_are_errors_with_file_and_line(self):
        for content, says in [("[info]\ntile = 5\n", "line 2"), ("\n\n[infos]\n", "line 3"), ("[info]\ntiles = \n", "line 2")]:
            config = self.write("wrong.toml", content)
            self.refused(USAGE, "info", self.cloud, "--config", config, says=["wrong.toml", says])

    def test_a_missing_file_is_an_error(self):
        self.refused(IO, "info", self.cloud, "--config", "nowhere.toml", says="nowhere.toml")

    def test_the_shipped_file_is_valid_and_says_only_defaults(self):
        import pathlib
        shipped = pathlib.Path(__file__).resolve().parents[2] / "config" / "tessera.toml"
        self.assertEqual(self.tiles("--config", shipped), self.tiles())
        # Each commented default is a key that exists, with a value that is accepted.
        lines = []
        for line in shipped.read_text().splitlines():
            key = line.removeprefix("# ").split(" =")[0]
            shown = line.startswith("# ") and " = " in line.split("#")[1] and "-" + key in KEYS
            lines.append(line[2:] if shown and key not in ("crop", "class", "scan", "particles", "columns", "hdu", "cosmology", "crs", "without", "attributes", "scratch", "format", "status") else line)
        self.ok("info", self.cloud, "--config", self.write("uncommented.toml", "\n".join(lines)))


KEYS = {"-" + key for key in ["dim", "max-points-per-tile", "tiles", "partition", "threads", "memory", "crop", "resolution", "class", "scan", "particles", "columns", "hdu", "cosmology", "keep", "crs", "returns", "without",
                              "attributes", "z", "skip-invalid", "neighbors", "recursive", "endpoint", "profile", "anonymous", "requester-pays", "kernel", "quiet", "verbose", "json",
                              "against-cgal", "scratch", "stats", "format", "index", "max-edge", "seed", "server", "token-file", "token", "ca",
                              "patience", "status", "limit", "max-points", "max-seconds", "partial", "scan-files", "method", "weights", "res", "type", "interval", "base", "smooth", "min-length", "index-every", "digits", "hillshade", "azimuth", "altitude"]}

if __name__ == "__main__":
    unittest.main()
