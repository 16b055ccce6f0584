"""Runs the real command as a user does, and makes small inputs for it."""
import ctypes
import json
import os
import pathlib
import random
import shutil
import struct
import subprocess
import tempfile
import unittest

TESSERA = os.environ["TESSERA"]
IGN = pathlib.Path(os.environ["IGN"])

OK, USAGE, BAD_INPUT, IO, CORRUPT, NOT_DELAUNAY, MEMORY, INTERRUPTED, INTERNAL = 0, 2, 3, 4, 5, 6, 7, 8, 9


def heed_permissions():
    """For a child process: root, too, may not read or write what the mode bits forbid (two capabilities less)."""
    PR_CAPBSET_DROP, CAP_DAC_OVERRIDE, CAP_DAC_READ_SEARCH = 24, 1, 2
    if os.geteuid() == 0:
        libc = ctypes.CDLL(None, use_errno=True)
        for capability in (CAP_DAC_OVERRIDE, CAP_DAC_READ_SEARCH):
            if libc.prctl(PR_CAPBSET_DROP, capability, 0, 0, 0) != 0:
                raise OSError(ctypes.get_errno(), "prctl")


class CliTest(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="tessera-cli-"))
        self.addCleanup(shutil.rmtree, self.folder, True)
        self.out = self.folder / "out"

    def run_tessera(self, *args, env=None, preexec_fn=None):
        clean = {k: v for k, v in os.environ.items() if not k.startswith("TESSERA")}
        done = subprocess.run([TESSERA, *map(str, args)], cwd=self.folder, env=clean | (env or {}), text=True,
                              stdout=subprocess.PIPE, stderr=subprocess.PIPE, timeout=300, preexec_fn=preexec_fn)
        # The marks of options in sentences are control characters; JSON would write them as escapes.
        for said in (done.stdout, done.stderr):
            self.assertNotRegex(said, r"[\x00-\x08]|\\u000[0-8]")
        return done

    def ok(self, *args, **more):
        done = self.run_tessera(*args, **more)
        self.assertEqual(done.returncode, OK, done.stderr)
        return done.stdout

    def refused(self, status, *args, says=(), **more):
        """The command fails with this status and one line on stderr that holds all of `says`."""
        done = self.run_tessera(*args, **more)
        lines = done.stderr.splitlines()
        self.assertEqual(done.returncode, status, done.stderr)
        sentences = [line for line in lines if line.startswith("tessera: ")]
        self.assertEqual(len(sentences), 1, done.stderr)
        self.assertEqual(lines[-1], sentences[0], "the sentence is the last line")
        for part in (says,) if isinstance(says, str) else says:
            self.assertIn(str(part), sentences[0])
        return done

    def write(self, name, content):
        path = self.folder / name
        path.write_bytes(content if isinstance(content, bytes) else content.encode())
        return path

    def xyz(self, name="cloud.xyz", n=2000, seed=1, columns=3):
        rng = random.Random(seed)
        return self.write(name, "".join(" ".join(repr(rng.random()) for _ in range(columns)) + "\n" for _ in range(n)))

    def las(self, name="cloud.las", n=500, version=(1, 2), **header):
        """A LAS file of point format 0; keywords replace header fields, to make it wrong."""
        rng = random.Random(7)
        fields = dict(magic=b"LASF", header_bytes=227, offset=227, records=0, point_format=0, record_bytes=20, count=n,
                      scale=(0.01,) * 3, shift=(0.0,) * 3)
        fields.update(header)
        head = bytearray(227)
        head[0:4] = fields["magic"]
        head[24:26] = bytes(version)
        struct.pack_into("<HII", head, 94, fields["header_bytes"], fields["offset"], fields["records"])
        struct.pack_into("<BHI", head, 104, fields["point_format"], fields["record_bytes"], fields["count"])
        struct.pack_into("<6d", head, 131, *fields["scale"], *fields["shift"])
        struct.pack_into("<6d", head, 179, 10, 0, 10, 0, 10, 0)
        body = b"".join(struct.pack("<3iH6x", *(rng.randrange(1000) for _ in range(3)), 0) for _ in range(n))
        return self.write(name, bytes(head) + body)

    def json_lines(self, text):
        return [json.loads(line) for line in text.splitlines()]

    def files(self, folder=None):
        folder = folder or self.folder
        return sorted(str(p.relative_to(folder)) for p in folder.rglob("*"))
