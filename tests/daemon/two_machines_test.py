"""Daemons on several "machines" share a data folder: each has another boot id, and flock() does not tell them of each
other. However they stand still, are taken over and go on, there is one truth. ROUNDS, SEED: of the random test."""
import os
import pathlib
import random
import re
import shutil
import signal
import subprocess
import tempfile
import time
import unittest

from daemon import ENDED, Daemon, DaemonTest

LEASE_S = 3
ROUNDS, SEED = int(os.environ.get("ROUNDS", "4")), int(os.environ.get("SEED", "1"))
LOST = "this process was silent for so long that another process has taken the lock of the folder"


def can_play_machines():
    """Why not, or nothing: a mount namespace is needed, as root or in a user namespace."""
    done = subprocess.run([*UNSHARE, "bash", "-c", "mount --make-rprivate / && mount --bind /dev/null "
                           "/proc/sys/kernel/random/boot_id"], capture_output=True, text=True)
    return done.stderr.strip() if done.returncode else None


UNSHARE = ["unshare", "-m"] if os.geteuid() == 0 else ["unshare", "-m", "--map-root-user"]
REFUSED = can_play_machines()


def machine(number, folder):
    """What a command begins with to run on that machine."""
    boot = folder / f"boot-{number}"
    boot.write_text(f"0000000{number}-1111-2222-3333-444444444444\n")
    script = ('mount --make-rprivate / && mount --bind "$1" /proc/sys/kernel/random/boot_id && export LD_PRELOAD="$2" '
              '&& shift 2 && exec "$@"')
    return [*UNSHARE, "bash", "-c", script, "machine", str(boot), os.environ["ONE_MACHINE"]]


@unittest.skipIf(REFUSED, f"no namespace for machines: {REFUSED}")
class TwoMachines(DaemonTest):
    def setUp(self):
        super().setUp()
        self.points = self.folder / "inputs"
        self.points.mkdir()
        for name, count, seed in (("large", 400_000, 1), ("old", 2_000, 2), ("new", 2_000, 3)):
            self.tessera("generate", "uniform", "--points", count, "--seed", seed, "-o", self.points / f"{name}.npy")
        self.digests = {}

    def on(self, number, **more):
        """A daemon on that machine; it may have to wait for its turn."""
        return self.start(inputs=self.points, prefix=machine(number, self.folder),
                          env={"TESSERAD_LIMITS_DATA_LEASE": f"{LEASE_S}s"}, **more)

    def submit(self, daemon, name, output, **more):
        """Once no other job works on that output."""
        while True:
            status, _, body = daemon.request("POST", "/v1/processes/triangulate/execution", {
                "inputs": {"inputs": [f"{name}.npy"], "output": output, "overwrite": True, **more}})
            other = re.search(r"job (\S+) works on it", body.get("detail", ""))
            if not other:
                self.assertEqual(status, 201, body)
                return body["jobID"]
            daemon.wait(other[1])

    def digest(self, daemon, output):
        return daemon.request("GET", f"/v1/triangulations/{output}")[2].get("digest")

    def expected(self, name):
        if name not in self.digests:
            out = self.folder / f"expected-{name}"
            self.tessera("triangulate", self.points / f"{name}.npy", "-o", out, "--quiet")
            text = self.tessera("info", out, "--json")
            self.digests[name] = __import__("json").loads(text)["digest"]
        return self.digests[name]

    def assert_lost(self, daemon):
        """It ends by itself, with the status that is to be tried again, and says why in one line."""
        self.assertEqual(daemon.process.wait(), 4, daemon.messages())
        lines = [line for line in daemon.messages().splitlines() if LOST in line]
        self.assertEqual(len(lines), 1, daemon.messages())

    def stand_still(self, daemon):
        daemon.process.send_signal(signal.SIGSTOP)

    def go_on(self, daemon):
        daemon.process.send_signal(signal.SIGCONT)

    def records(self):
        return {path.relative_to(self.folder): path.read_bytes()
                for path in sorted((self.folder / "data" / "jobs").glob("*/job.json"))}

    def test_a_daemon_that_wakes_after_it_was_replaced_ends_and_changes_nothing(self):
        first = self.on(1)
        large, old = self.submit(first, "large", "first"), self.submit(first, "old", "latest")
        self.stand_still(first)
        second = self.on(2)  # waits for the lease
        for job in (large, old):
            self.assertEqual(second.wait(job)["status"], "successful")
        newer = self.submit(second, "new", "latest")
        self.assertEqual(second.wait(newer)["status"], "successful")
        before = self.records()
        self.go_on(first)
        self.assert_lost(first)
        self.assertEqual(self.records(), before)
        self.assertEqual(self.digest(second, "latest"), self.expected("new"))
        self.assertEqual(self.digest(second, "first"), self.expected("large"))
        third = self.submit(second, "old", "third")
        self.assertEqual(second.wait(third)["status"], "successful")
        self.assertEqual(second.end(), 0)
        again = self.on(1)
        self.assertEqual({job["id"]: job["status"] for job in again.request("GET", "/v1/jobs")[2]["jobs"]},
                         {job: "successful" for job in (large, old, newer, third)})
        self.assertEqual(again.end(), 0)
        self.assertEqual([path.name for path in (self.folder / "data" / "results").iterdir() if path.name[0] == "."], [])

    def test_a_daemon_that_wakes_before_anybody_has_taken_its_folder_goes_on(self):
        first = self.on(1)
        job = self.submit(first, "large", "first")
        self.stand_still(first)
        time.sleep(2 * LEASE_S)  # longer than it may be silent; what it does then is the test
        self.go_on(first)
        self.assertEqual(first.wait(job)["status"], "successful")
        self.assertEqual(self.digest(first, "first"), self.expected("large"))
        self.assertEqual(first.end(), 0)

    def test_who_comes_while_another_is_alive_waits_and_gives_up_with_the_status_that_is_tried_again(self):
        first = self.on(1)
        with self.assertRaisesRegex(AssertionError, "another tessera is at work in it: process .*waits until") as refused:
            self.on(2)
        self.assertIn("status 4", str(refused.exception))
        job = self.submit(first, "old", "latest")
        self.assertEqual(first.wait(job)["status"], "successful")
        self.assertEqual(first.end(), 0)

    def test_who_waits_comes_when_the_other_ends_and_can_be_ended(self):
        first = self.on(1)
        waits = subprocess.Popen(self.command(2), stderr=subprocess.PIPE, text=True, env=self.environment(),
                                 stdout=subprocess.DEVNULL)
        self.addCleanup(waits.stderr.close)
        self.assertIn("waits until", waits.stderr.readline())
        waits.send_signal(signal.SIGTERM)
        self.assertEqual(waits.wait(), 0)
        self.assertEqual(first.end(), 0)

    def test_of_three_the_last_is_right_in_whatever_order_the_others_wake(self):
        for order in ((0, 1), (1, 0)):
            daemons = [self.on(1)]
            jobs = [self.submit(daemons[0], "old", "latest")]
            for number in (2, 3):
                self.stand_still(daemons[-1])
                daemons.append(self.on(number))
                jobs.append(self.submit(daemons[-1], "new" if number == 3 else "old", "latest"))
            last = daemons[-1]
            self.assertEqual(last.wait(jobs[-1])["status"], "successful")
            for each in order:
                self.go_on(daemons[each])
                self.assert_lost(daemons[each])
            self.assertEqual(self.digest(last, "latest"), self.expected("new"))
            self.assertEqual([last.request("GET", f"/v1/jobs/{job}")[2]["status"] for job in jobs], ["successful"] * 3)
            self.assertEqual(last.end(), 0)

    def command(self, number):
        return [*machine(number, self.folder), os.environ["TESSERAD"], "--data", str(self.folder / "data"), "--listen",
                "127.0.0.1:0", "--metrics", "none", "--memory", "1G"]

    def environment(self):
        clean = {k: v for k, v in os.environ.items() if not k.startswith("TESSERA")}
        return clean | {"TESSERAD_LIMITS_DATA_LEASE": f"{LEASE_S}s"}

    def test_whatever_happens_in_whatever_order_no_job_is_lost_and_nothing_goes_back(self):
        chance = random.Random(SEED)
        asleep, awake, accepted = [], self.on(1), []  # accepted: job and input, in order
        stops = 0
        for _ in range(ROUNDS):
            for _ in range(chance.randrange(1, 4)):
                name = chance.choice(("old", "new"))
                accepted.append((self.submit(awake, name, "latest"), name))
            if chance.random() < 0.3:
                accepted.append((self.submit(awake, "large", "large"), "large"))
            time.sleep(chance.random() * 0.5)  # somewhere in the middle of its jobs
            self.stand_still(awake)
            stops += 1
            if chance.random() < 0.3:
                time.sleep(chance.random() * 2 * LEASE_S)  # nobody comes
                self.go_on(awake)
                continue
            asleep.append(awake)
            awake = self.on(1 + chance.randrange(3) if len(asleep) < 3 else 4)
            while asleep and chance.random() < 0.6:
                wakes = asleep.pop(chance.randrange(len(asleep)))
                self.go_on(wakes)
                self.assert_lost(wakes)
        order = [name for _, name in accepted]
        for job, name in accepted:
            ended = awake.wait(job)
            if ended["status"] == "failed" and "the daemon died 3 times" in ended["problem"]["detail"]:
                # It ran at three replacements, so it might be the reason. Whoever asks for it again gets it.
                self.assertEqual(awake.request("POST", f"/v1/jobs/{job}/resume")[0], 200)
                ended = awake.wait(job)
                order.append(name)
            self.assertEqual(ended["status"], "successful", ended)
        for each in asleep:
            self.go_on(each)
            self.assert_lost(each)
        for job, _ in accepted:
            self.assertEqual(awake.request("GET", f"/v1/jobs/{job}")[2]["status"], "successful")
        latest = [name for name in order if name != "large"][-1]
        self.assertEqual(self.digest(awake, "latest"), self.expected(latest), f"seed {SEED}, {stops} stops")
        self.assertEqual(awake.end(), 0)
        print(f"figures: {stops} stops, {len(accepted)} jobs, {len(order) - len(accepted)} of them given up and resumed, seed {SEED}")


if __name__ == "__main__":
    unittest.main()
