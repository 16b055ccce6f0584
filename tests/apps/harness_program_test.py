"""The program that runs the actors in random schedules: its options, and what it tells."""
import json
import os
import subprocess
import unittest

HARNESS = os.environ["HARNESS"]


class Harness(unittest.TestCase):
    def run_it(self, *arguments):
        return subprocess.run([HARNESS, *arguments], text=True, capture_output=True, timeout=280)

    def test_seeds_that_pass_are_counted(self):
        done = self.run_it("--kind", "lattice", "--dim", "2", "-n", "30", "--tiles", "5", "--seeds", "1..4", "--json")
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        told = json.loads(done.stdout)
        self.assertEqual((told["event"], told["seeds"]), ("harness", 4))
        self.assertGreater(told["messages"], 0)

    def test_a_seed_is_replayed_step_by_step(self):
        first, second = (self.run_it("--dim", "2", "-n", "20", "--tiles", "3", "--seed", "7", "--faults", "kill", "--trace")
                         for _ in range(2))
        self.assertEqual(first.returncode, 0)
        self.assertGreater(len(first.stdout.splitlines()), 20)
        self.assertEqual(first.stdout, second.stdout)

    def test_what_makes_no_sense_is_refused_in_a_sentence(self):
        for says, arguments in ((("'crumpled' is not a kind of cloud"), ["--kind", "crumpled"]),
                                ("is not a fault; the faults are storage", ["--faults", "boredom"]),
                                ("is not a range of seeds like 1..1000", ["--seeds", "9..1"]),
                                ("give --seed or --seeds, not both", ["--seed", "1", "--seeds", "1..2"]),
                                ("--tiles: 0 is not from 1 to 4096", ["--tiles", "0"]),
                                ("--dim: 4 is not from 2 to 3", ["--dim", "4"])):
            with self.subTest(says=says):
                done = self.run_it(*arguments)
                self.assertEqual(done.returncode, 2)
                self.assertIn(says, done.stderr)


if __name__ == "__main__":
    unittest.main()
