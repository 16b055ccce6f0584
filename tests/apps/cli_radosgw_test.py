"""Results in the object store of Ceph: a real server that speaks S3, with one monitor and one store of objects in memory."""
import hashlib
import json
import os
import pathlib
import shutil
import signal
import socket
import subprocess
import time
import unittest
import urllib.request
import uuid

from cli import IO, USAGE, CliTest

PROGRAMS = ("ceph-mon", "ceph-osd", "radosgw", "radosgw-admin", "ceph", "ceph-authtool", "monmaptool")
KEY, SECRET = "AKIDEXAMPLE", "wJalrXUtnFEMIK7MDENGbPxRfiCYEXAMPLEKEY"
EMPTY = hashlib.sha256(b"").hexdigest()

CONFIGURATION = """
[global]
fsid = FSID
mon host = [v2:127.0.0.1:MONPORT/0]
mon initial members = a
osd pool default size = 1
osd pool default min size = 1
osd pool default pg num = 1
osd pool default pgp num = 1
osd pool default pg autoscale mode = off
osd crush chooseleaf type = 0
mon allow pool size one = true
mon max pg per osd = 1000
osd objectstore = memstore
memstore device bytes = 1073741824
run dir = FOLDER
admin socket = FOLDER/$name.asok
log file = FOLDER/$name.log
mon data = FOLDER/mon
osd data = FOLDER/osd
pid file = FOLDER/$name.pid
keyring = FOLDER/keyring
public network = 127.0.0.0/8
cluster network = 127.0.0.0/8
rgw frontends = beast endpoint=127.0.0.1:RGWPORT
"""


def free_port():
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


@unittest.skipUnless(all(shutil.which(program) for program in PROGRAMS), "radosgw of Ceph is not installed")
class Radosgw(CliTest):
    def setUp(self):
        super().setUp()
        self.ceph = self.folder / "ceph"
        (self.ceph / "mon").mkdir(parents=True)
        (self.ceph / "osd").mkdir()
        fsid, port = str(uuid.uuid4()), free_port()
        self.address = f"http://127.0.0.1:{(gateway := free_port())}"
        text = CONFIGURATION.replace("FSID", fsid).replace("FOLDER", str(self.ceph)).replace("MONPORT", str(port)).replace("RGWPORT", str(gateway))
        (self.ceph / "ceph.conf").write_text(text)
        everything = ("--cap", "mon", "allow *", "--cap", "osd", "allow *", "--cap", "mgr", "allow *")
        self.call("ceph-authtool", "--create-keyring", "keyring", "--gen-key", "-n", "mon.", "--cap", "mon", "allow *")
        self.call("ceph-authtool", "keyring", "--gen-key", "-n", "client.admin", *everything)
        self.call("monmaptool", "--create", "--addv", "a", f"[v2:127.0.0.1:{port}]", "--fsid", fsid, "monmap")
        self.call("ceph-mon", "--mkfs", "-i", "a", "--monmap", "monmap", "--keyring", "keyring", "-c", "ceph.conf")
        self.start("ceph-mon", "-f", "-i", "a", "-c", "ceph.conf")
        store = str(uuid.uuid4())
        self.call("ceph", "-c", "ceph.conf", "osd", "new", store)
        self.call("ceph", "-c", "ceph.conf", "auth", "get-or-create", "osd.0", "mon", "allow profile osd", "osd", "allow *", "-o", "osd/keyring")
        self.call("ceph-osd", "-i", "0", "--mkfs", "--osd-uuid", store, "-c", "ceph.conf", "--keyring", "osd/keyring")
        self.start("ceph-osd", "-f", "-i", "0", "-c", "ceph.conf", "--keyring", "osd/keyring")
        self.call("radosgw-admin", "-c", "ceph.conf", "user", "create", "--uid=t", "--display-name=t", f"--access-key={KEY}", f"--secret={SECRET}")
        self.start("radosgw", "-f", "-n", "client.admin", "-c", "ceph.conf", "--keyring", self.ceph / "keyring")
        self.wait_for_gateway()
        self.asked("PUT", "maps")
        self.environment = {"HOME": str(self.folder), "AWS_ENDPOINT_URL": self.address, "AWS_ACCESS_KEY_ID": KEY, "AWS_SECRET_ACCESS_KEY": SECRET}

    def call(self, *command):
        done = subprocess.run([*map(str, command)], cwd=self.ceph, capture_output=True, text=True, timeout=120)
        self.assertEqual(done.returncode, 0, (command, done.stderr))

    def start(self, *command):
        log = self.enterContext(open(self.ceph / f"{command[0]}.out", "w"))
        process = subprocess.Popen([*map(str, command)], cwd=self.ceph, stdout=log, stderr=log)
        self.addCleanup(process.wait)
        self.addCleanup(process.send_signal, signal.SIGKILL)

    def wait_for_gateway(self):
        end = time.monotonic() + 120
        while True:
            try:
                return urllib.request.urlopen(self.address, timeout=10).close()
            except OSError:
                self.assertLess(time.monotonic(), end, "radosgw does not begin")
                time.sleep(0.2)

    def asked(self, method, path):
        """The answer to a request that the command curl signs."""
        done = subprocess.run(["curl", "-sS", "--fail", "--aws-sigv4", "aws:amz:us-east-1:s3", "--user", f"{KEY}:{SECRET}", "-X", method, "-H",
                               f"x-amz-content-sha256: {EMPTY}", f"{self.address}/{path}"], capture_output=True, timeout=60)
        self.assertEqual(done.returncode, 0, done.stderr)
        return done.stdout

    def test_a_result_goes_there_and_back(self):
        cloud, near = self.xyz(n=200_000), self.folder / "near"
        self.ok("triangulate", cloud, "-o", near, "--dim", 2, "--tiles", 1, "--quiet")
        tile = next((near / "tiles").iterdir())
        self.assertGreater(tile.stat().st_size, 16 << 20, "it is sent in parts")
        self.ok("triangulate", cloud, "-o", "s3://maps/block", "--dim", 2, "--tiles", 1, "--quiet", env=self.environment)
        self.assertEqual(self.asked("GET", f"maps/block/tiles/{tile.name}"), tile.read_bytes())
        self.assertNotIn(b"<Upload>", self.asked("GET", "maps?uploads="))
        told = [json.loads(self.ok("verify", place, "--json", env=self.environment)) for place in (near, "s3://maps/block")]
        self.assertEqual({**told[0], "result": ""}, {**told[1], "result": ""})
        question = ("locate", "0.31,0.62", "--json")
        self.assertEqual(self.ok("query", "s3://maps/block", *question, env=self.environment), self.ok("query", near, *question))
        self.refused(USAGE, "triangulate", cloud, "-o", "s3://maps/block", "--dim", 2, says="--overwrite", env=self.environment)
        self.ok("upload", near, "-o", "s3://maps/block", "--overwrite", "--quiet", env=self.environment)
        self.ok("fetch", "s3://maps/block", "-o", "back", env=self.environment)
        self.assertEqual((self.folder / "back/tiles" / tile.name).read_bytes(), tile.read_bytes())
        points = self.write("a b+c.xyz", cloud.read_bytes())
        self.refused(IO, "triangulate", points, "-o", "s3://nowhere/block", says=("404", "NoSuchBucket"), env=self.environment)
        wrong = self.environment | {"AWS_SECRET_ACCESS_KEY": "wrong"}
        self.refused(IO, "upload", near, "-o", "s3://maps/other", says=("403", "SignatureDoesNotMatch"), env=wrong)


if __name__ == "__main__":
    unittest.main()
