"""What others on the machine, and what keeps its logs and volumes, get to see and can do."""
import os
import pty
import resource
import signal
import socket
import subprocess
import unittest

from daemon import TESSERAD, DaemonTest
from local_cluster import free_port

CLEAN = {k: v for k, v in os.environ.items() if not k.startswith("TESSERA")}


class Rights(DaemonTest):
    def begin(self, *options, stdout=subprocess.PIPE):
        process = subprocess.Popen([TESSERAD, "--data", self.folder / "data", "--listen", "127.0.0.1:0", "--metrics", "none",
                                    "--memory", "1G", *options], env=CLEAN, stdout=stdout, stderr=subprocess.PIPE, text=True)
        self.addCleanup(process.stderr.close)
        if process.stdout:
            self.addCleanup(process.stdout.close)
        self.addCleanup(lambda: process.kill() if process.poll() is None else None)
        return process

    def refused(self, *options):
        process = self.begin(*options)
        said = process.stderr.read()
        self.assertEqual(process.wait(), 2, said)
        return said

    def until_it_serves(self, process):
        """What it has logged till then."""
        said = ""
        while "serves at" not in said:
            line = process.stderr.readline()
            self.assertTrue(line, said)
            said += line
        return said

    def token(self):
        return (self.folder / "data/tokens").read_text().split()[-1]

    def test_a_token_goes_into_no_pipe_unless_that_is_asked_for(self):
        # A pipe is what service managers and container engines keep in their logs.
        for options, expected in (((), False), (("--print-token",), True)):
            process = self.begin(*options)
            said = self.until_it_serves(process)
            process.send_signal(signal.SIGTERM)
            printed = process.stdout.read()
            said += process.stderr.read()
            self.assertEqual(process.wait(), 0, said)
            self.assertEqual(printed.endswith(f"/#token={self.token()}\n"), expected, printed)
            self.assertEqual(printed == "", not expected)
            self.assertNotIn(self.token(), said)
            self.assertIn(str(self.folder / "data/tokens"), said, "the log says where they are")

    def test_a_terminal_is_told_the_token(self):
        ours, theirs = pty.openpty()
        self.addCleanup(os.close, ours)
        process = self.begin(stdout=theirs)
        os.close(theirs)
        self.until_it_serves(process)
        printed = os.read(ours, 10_000).decode()
        self.assertIn(f"/#token={self.token()}", printed)
        process.send_signal(signal.SIGTERM)
        self.assertEqual(process.wait(), 0)

    def test_a_volume_that_was_mounted_anew_for_a_group_starts_again(self):
        # What Kubernetes does to every file and folder of a volume (fsGroup).
        daemon = self.start()
        job = daemon.request("POST", "/v1/processes/triangulate/execution", {"inputs": {"inputs": ["*.las"], "output": "block"}})[2]
        self.assertEqual(daemon.wait(job["jobID"])["status"], "successful")
        token, cookie = daemon.token, daemon.request("POST", "/v1/session")[1]["Set-Cookie"]
        self.assertIn("HttpOnly", cookie)
        self.assertEqual(daemon.end(), 0)
        data = self.folder / "data"
        for path in [data, *data.rglob("*")]:
            path.chmod(path.stat().st_mode | (0o2770 if path.is_dir() else 0o660))
        daemon = self.start()
        self.assertEqual(daemon.token, token)
        self.assertEqual((data / "tokens").stat().st_mode & 0o777, 0o600)
        self.assertIn("its rights are 0600 again", daemon.messages())
        self.assertEqual(daemon.request("GET", "/v1/triangulations/block")[0], 200)
        job = daemon.request("POST", "/v1/processes/verify/execution", {"inputs": {"triangulation": "block"}})[2]
        self.assertEqual(daemon.wait(job["jobID"])["status"], "successful")
        self.assertEqual(daemon.end(), 0)
        (data / "tokens").chmod(0o644)
        self.assertIn("tokens: others can read it; its rights must be 0600", self.refused())

    def node(self, scratch):
        return self.refused("--cluster", f"127.0.0.1:{free_port()}", "--certs", self.folder / "certs", "--scratch", scratch)

    def test_a_scratch_folder_of_others_is_not_taken(self):
        self.tessera("certs", "init", "certs")
        self.tessera("certs", "node", "certs", "a")
        victim = self.folder / "victim"
        victim.write_text("precious")
        scratch = self.folder / "scratch"
        scratch.mkdir()
        (scratch / "life").symlink_to(victim)
        scratch.chmod(0o777)
        self.assertIn("others can write to it", self.node(scratch))
        scratch.chmod(0o700)
        process = self.begin("--cluster", f"127.0.0.1:{free_port()}", "--certs", self.folder / "certs", "--scratch", scratch)
        said = process.stderr.read()
        self.assertEqual(process.wait(), 4, said)
        self.assertIn("life", said)
        self.assertEqual(victim.read_text(), "precious")
        (scratch / "life").unlink()
        if os.geteuid() != 0:
            return  # a folder cannot be given to another user
        os.chown(scratch, 65534, 65534)
        self.assertIn("belongs to another user", self.node(scratch))
        link = self.folder / "link"
        link.symlink_to(self.folder / "own")
        (self.folder / "own").mkdir()
        os.chown(link, 65534, 65534, follow_symlinks=False)
        self.assertIn("belongs to another user", self.node(link))
        self.assertEqual(list((self.folder / "own").iterdir()), [])

    def test_inputs_and_data_lie_apart(self):
        (self.folder / "data/below").mkdir(parents=True)
        link = self.folder / "link"
        link.symlink_to(self.folder / "data/below")
        for inputs in (self.folder, self.folder / "data", self.folder / "data/below", link):
            self.assertIn("one of them lies inside the other", self.refused("--inputs", inputs))
        (self.folder / "data-inputs").mkdir()
        process = self.begin("--inputs", self.folder / "data-inputs")
        self.until_it_serves(process)
        process.send_signal(signal.SIGTERM)
        self.assertEqual(process.wait(), 0)

    def test_many_connections_without_a_token_fail_no_job(self):
        soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
        few = 256
        if hard < 4 * few:
            self.skipTest(f"the hard limit of open files is {hard}")
        resource.setrlimit(resource.RLIMIT_NOFILE, (few, hard))  # what a shell may give
        try:
            daemon = self.start()
        finally:
            resource.setrlimit(resource.RLIMIT_NOFILE, (min(hard, 4 * few), hard))
        self.addCleanup(resource.setrlimit, resource.RLIMIT_NOFILE, (soft, hard))
        self.assertEqual(resource.prlimit(daemon.process.pid, resource.RLIMIT_NOFILE), (hard, hard))
        idle = [socket.create_connection(("127.0.0.1", daemon.port)) for _ in range(few + 50)]
        for connection in idle:
            self.addCleanup(connection.close)
        job = daemon.request("POST", "/v1/processes/triangulate/execution",
                             {"inputs": {"inputs": ["*.las"], "output": "block", "tiles": 12}})[2]
        self.assertEqual(daemon.wait(job["jobID"])["status"], "successful")
        self.assertEqual(daemon.end(), 0)


if __name__ == "__main__":
    unittest.main()
