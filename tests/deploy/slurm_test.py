"""The job script for Slurm, with a Slurm and a daemon of a few lines: what it asks for, where scratch is, and how it ends."""
import os
import pathlib
import re
import stat
import subprocess
import tempfile
import unittest

SCRIPT = pathlib.Path(os.environ["SOURCE"]) / "deploy/slurm-cluster.sh"
# Runs the command after its options here; told to end, it ends all that the command has begun.
SRUN = """#!/usr/bin/python3
import os, signal, subprocess, sys
signal.pthread_sigmask(signal.SIG_BLOCK, [signal.SIGTERM])
words = sys.argv[1:]
with open(os.environ["RECORD"] + "/srun", "a") as record:
    record.write(words[0] + "\\n")
while words[0].startswith("-"):
    del words[:2 if words[0] in ("--nodes", "--ntasks", "--nodelist") else 1]
run = subprocess.Popen(words, start_new_session=True)
signal.signal(signal.SIGTERM, lambda *_: os.killpg(run.pid, signal.SIGKILL))
signal.pthread_sigmask(signal.SIG_UNBLOCK, [signal.SIGTERM])
sys.exit(abs(run.wait()))
"""
# A daemon that dies once (status 9) and then ends as the test says; a node that has no end of its own waits for its signal.
DAEMON = """#!/bin/bash
role=node; [[ " $* " == *" --roles coordinator "* ]] && role=coordinator
printf '%s\\n' "$*" >> "$RECORD/$role"
for ((i = 1; i <= $#; ++i)); do [[ ${!i} == --scratch ]] && { j=$((i + 1)); stat -c '%a %n' "${!j}" >> "$RECORD/scratch"; }; done
mkdir "$RECORD/died-$role" 2>/dev/null && exit 9
ends=ENDS_$role
[[ ${!ends} != never ]] || exec sleep 300
exit "${!ends}"
"""


class Slurm(unittest.TestCase):
    def run_script(self, coordinator, node):
        with tempfile.TemporaryDirectory(prefix="tessera-slurm-") as name:
            folder = pathlib.Path(name)
            programs = {"srun": SRUN, "scontrol": "#!/bin/bash\nprintf 'alpha\\nbeta\\n'\n", "tesserad": DAEMON,
                        "sleep": '#!/bin/bash\n[[ $1 == 2 ]] || exec /bin/sleep "$@"\n'}
            for program, text in programs.items():
                (folder / program).write_text(text)
                (folder / program).chmod(0o755)
            for below in ("shared", "inputs", "certs", "record", "tmp"):
                (folder / below).mkdir()
            (folder / "tmp/tesserad").mkdir(mode=0o777)  # of somebody who was there first
            done = subprocess.run(["bash", str(SCRIPT), *(str(folder / arg) for arg in ("shared", "inputs", "certs"))],
                                  env={"PATH": f"{folder}:/usr/bin:/bin", "SLURM_JOB_NODELIST": "x", "TMPDIR": str(folder / "tmp"),
                                       "RECORD": str(folder / "record"), "ENDS_coordinator": coordinator, "ENDS_node": node},
                                  capture_output=True, text=True)
            record = {file.name: file.read_text() for file in (folder / "record").iterdir() if file.is_file()}
            left = sorted(file.name for file in (folder / "tmp").iterdir())
            return done, record, left

    def test_what_died_begins_again_and_what_ended_by_itself_does_not(self):
        done, record, left = self.run_script("0", "0")
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        self.assertEqual(len(record["coordinator"].splitlines()), 2)
        self.assertEqual(len(record["node"].splitlines()), 2)
        self.assertEqual(left, ["tesserad"])  # the other's

    def test_scratch_is_a_new_folder_that_nobody_else_can_read(self):
        _, record, _ = self.run_script("0", "0")
        lines = set(record["scratch"].splitlines())
        self.assertEqual(len(lines), 1)  # the same for the node that begins again
        mode, path = lines.pop().split(" ", 1)
        self.assertEqual(int(mode, 8) & (stat.S_IRWXG | stat.S_IRWXO), 0)
        self.assertRegex(path, r"/tmp/tesserad-\w{6}$")

    def test_who_cannot_begin_ends_the_job_with_its_status(self):
        for coordinator, node in (("2", "never"), ("never", "2")):
            done, record, _ = self.run_script(coordinator, node)
            self.assertEqual(done.returncode, 2, done.stderr)
            self.assertEqual(len(record["coordinator" if coordinator == "2" else "node"].splitlines()), 2)

    def test_it_asks_for_all_memory(self):
        _, record, _ = self.run_script("0", "0")
        self.assertRegex(SCRIPT.read_text(), r"(?m)^#SBATCH .*--mem=0\b")
        self.assertEqual(record["srun"].splitlines(), ["--mem=0", "--mem=0"])
        self.assertIsNone(re.search(r"\$\{TMPDIR:-/tmp\}/tesserad\"", SCRIPT.read_text()))


if __name__ == "__main__":
    unittest.main()
