"""Checks the models with Spin, and that each mutant of them fails: run.py [--quick | --full]. Prints states and what failed.

Exit status 1 when a model fails, a mutant survives, or a search does not end within its memory and time.
"""

import pathlib
import re
import subprocess
import sys
import tempfile

HERE = pathlib.Path(__file__).resolve().parent
MEMORY_MIB = 2000
DEPTH = 100000
# (model, flags): no error in any state.
RIGHT = [("detector", ["FRESH=1", "BATCHES=2", "WINDOW=1"]),
         ("detector", ["FRESH=3", "BATCHES=1"]),
         ("epochs", ["CRASHES=0", "BATCHES=2"]),
         ("epochs", ["CRASHES=1", "BATCHES=1"]),
         ("loss", ["CRASHES=0"]),
         ("loss", ["CRASHES=1", "ANNOUNCED=1"]),
         ("loss", ["CRASHES=2", "ANNOUNCED=1"]),
         ("detector", ["CHANGE", "FRESH=1", "BATCHES=2", "WINDOW=1"]),
         ("detector", ["CHANGE", "FRESH=2", "BATCHES=1", "WINDOW=1"]),
         ("changed", ["CRASHES=0", "FRESH=2"]),
         ("changed", ["CRASHES=1", "FRESH=1"])]
FULL = [("detector", ["FRESH=1", "BATCHES=4"]),
        ("detector", ["FRESH=3", "BATCHES=2"]),
        ("epochs", ["CRASHES=1", "BATCHES=2"]),
        ("loss", ["CRASHES=1", "ANNOUNCED=2"])]
# The last flag is what is wrong.
WRONG = [("detector", ["FRESH=3", "BATCHES=3", "WINDOW=1", "BUSY_IGNORED"]),
         ("detector", ["FRESH=3", "BATCHES=3", "WINDOW=1", "COUNT_AT_GATE"]),
         ("detector", ["FRESH=3", "BATCHES=3", "WINDOW=1", "NOTICE_FORGOTTEN"]),
         ("detector", ["FRESH=3", "BATCHES=3", "WINDOW=1", "SILENT_AFTER_ANSWER"]),
         ("detector", ["FRESH=3", "BATCHES=3", "WINDOW=1", "ONE_WAVE"]),
         ("epochs", ["BATCHES=1", "KEEP_DEAD_MAIL"]),
         ("epochs", ["BATCHES=1", "COUNTERS_NOT_BY_INCARNATION"]),
         ("epochs", ["BATCHES=1", "TALLY_WITHOUT_EPOCH"]),
         ("epochs", ["BATCHES=1", "TABLE_NOT_AWAITED"]),
         ("epochs", ["BATCHES=1", "SETTLED_TOO_EARLY"]),
         ("epochs", ["BATCHES=1", "NO_INCARNATION_CHECK"]),
         ("epochs", ["BATCHES=1", "SILENT_AFTER_ANSWER"]),
         ("loss", ["CRASHES=1", "NO_REPLAY"]),
         ("loss", ["CRASHES=1", "NODES=2", "KEEP_DEAD_MAIL"]),
         ("loss", ["CRASHES=1", "KEEP_WORDS"]),
         ("loss", ["CRASHES=1", "NO_RETELL"]),
         ("detector", ["CHANGE", "FRESH=2", "BATCHES=2", "WINDOW=1", "CALL_NOT_COUNTED"]),
         ("detector", ["CHANGE", "FRESH=1", "BATCHES=2", "WINDOW=1", "WAKES_AFTER_REPORT"]),
         ("detector", ["CHANGE", "FRESH=1", "BATCHES=2", "WINDOW=1", "BEGINS_UNSEEN"]),
         ("changed", ["CRASHES=1", "FRESH=1", "QUOTES_NOT_REPLAYED"]),
         ("changed", ["CRASHES=1", "FRESH=1", "BIT_NOT_REPLAYED"]),
         ("changed", ["CRASHES=1", "FRESH=1", "KNOWN_IS_NO_NEWS"]),
         ("changed", ["CRASHES=1", "FRESH=1", "REFUSED_NOT_INTRODUCED"]),
         ("changed", ["CRASHES=1", "FRESH=1", "NO_REPLAY"]),
         ("changed", ["CRASHES=1", "FRESH=1", "NO_RETELL"]),
         ("changed", ["CRASHES=0", "FRESH=2", "QUOTES_NOTED"])]


QUICK = [("detector", ["FRESH=1", "BATCHES=2", "WINDOW=1"]),
         ("epochs", ["CRASHES=0", "BATCHES=2"]),
         ("epochs", ["CRASHES=1", "BATCHES=1"]),
         ("loss", ["CRASHES=1", "ANNOUNCED=1"]),
         ("detector", ["CHANGE", "FRESH=1", "BATCHES=1", "WINDOW=1"]),
         ("changed", ["CRASHES=0", "FRESH=1"])]
QUICK_WRONG = [("epochs", ["BATCHES=1", "NO_INCARNATION_CHECK"]),
               ("epochs", ["BATCHES=1", "SILENT_AFTER_ANSWER"]),
               ("loss", ["CRASHES=1", "NO_REPLAY"]),
               ("detector", ["CHANGE", "FRESH=2", "BATCHES=2", "WINDOW=1", "CALL_NOT_COUNTED"]),
               ("changed", ["CRASHES=1", "FRESH=1", "QUOTES_NOT_REPLAYED"])]


def search(model, flags):
    """(ended, states, what failed or "")"""
    with tempfile.TemporaryDirectory() as folder:
        defines = [f"-D{flag}" for flag in flags]
        subprocess.run(["spin", "-a", *defines, str(HERE / f"{model}.pml")], cwd=folder, check=True,
                       stdout=subprocess.DEVNULL)
        subprocess.run(["gcc", "-O1", "-w", "-DSAFETY", "-DCOLLAPSE", f"-DMEMLIM={MEMORY_MIB}", "-DVECTORSZ=2048",
                        "-o", "pan", "pan.c"], cwd=folder, check=True)
        said = subprocess.run(["./pan", f"-m{DEPTH}", "-n"], cwd=folder, check=True, capture_output=True, text=True).stdout
    states = re.search(r"(\d+) states, stored", said)
    failed = re.search(r"pan:\d+: (.*)", said)
    whole = re.search(r"errors: 0\b", said) is not None and "max search depth too small" not in said \
        and "reached -DMEMLIM" not in said
    return (whole or failed is not None) and states is not None, int(states[1]) if states else 0, failed[1] if failed else ""


def main():
    bad = 0
    quick = "--quick" in sys.argv[1:]
    right = QUICK if quick else RIGHT + (FULL if "--full" in sys.argv[1:] else [])
    wrong = QUICK_WRONG if quick else WRONG
    for (model, flags), mutant in [*((r, False) for r in right), *((w, True) for w in wrong)]:
        ended, states, failed = search(model, flags)
        as_expected = ended and mutant == (failed != "")
        bad += not as_expected
        print(f"{'ok  ' if as_expected else 'BAD '} {'mutant' if mutant else 'model '} {model} {' '.join(flags)}: "
              f"{states} states{': ' + failed if failed else ''}", flush=True)
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
