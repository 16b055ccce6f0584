"""Where points come from: compressed files, standard input, folders, lists; several files at once."""
import gzip
import hashlib
import os
import pathlib
import pty
import random
import resource
import signal
import struct
import subprocess
import time
import unittest

from cli import BAD_INPUT, IGN, INTERRUPTED, IO, TESSERA, USAGE, CliTest


class InputTest(CliTest):
    def tiles(self, folder):
        return {p.name: hashlib.sha256(p.read_bytes()).hexdigest() for p in (self.folder / folder / "tiles").iterdir()}

    def triangulate(self, out, *inputs, **more):
        self.ok("triangulate", *inputs, "-o", out, "--tiles", "3", "--quiet", **more)
        return self.tiles(out)

    def piped(self, data, *args, pieces=1):
        """Runs the command with `data` on standard input, through a pipe, in so many pieces."""
        process = subprocess.Popen([TESSERA, *map(str, args)], cwd=self.folder, stdin=subprocess.PIPE,
                                   stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        for i in range(pieces):
            process.stdin.write(data[i * len(data) // pieces:(i + 1) * len(data) // pieces])
            process.stdin.flush()
            time.sleep(0.02 if pieces > 1 else 0)
        out, errors = process.communicate(timeout=120)
        return process.returncode, out.decode(), errors.decode()

    def infos(self, *args):
        return self.json_lines(self.ok("info", *args, "--json"))[0]


class Compressed(InputTest):
    def test_the_result_is_that_of_the_plain_file(self):
        plain = self.xyz(n=3000)
        expected = self.triangulate("plain", plain)
        packed = self.write("packed.xyz.gz", gzip.compress(plain.read_bytes()))
        self.assertEqual(self.triangulate("packed", packed), expected)
        told = self.infos(packed)["files"][0]
        self.assertEqual((told["packing"], told["format"], told["bytes"]), ("gzip", "xyz", packed.stat().st_size))
        self.assertIn("(gzip, ", self.ok("info", packed))
        las = self.las(n=2000)
        packed = self.write("packed.las.gz", gzip.compress(las.read_bytes()))
        self.assertEqual(self.triangulate("packed las", packed), self.triangulate("las", las))

    def test_a_run_can_be_resumed(self):
        cloud = self.write("cloud.xyz.gz", gzip.compress(self.xyz(n=60_000).read_bytes()))
        args = ["triangulate", cloud, "-o", self.out, "--tiles", "12", "--threads", "1", "--quiet"]
        process = subprocess.Popen([TESSERA, *map(str, args)], stderr=subprocess.PIPE)
        while not (self.out / ".run" / "plan.json").exists():
            self.assertIsNone(process.poll())
            time.sleep(0.005)
        process.send_signal(signal.SIGINT)
        process.communicate(timeout=120)
        self.assertEqual(process.returncode, INTERRUPTED)
        self.ok(*args, "--resume")
        self.ok("verify", self.out, "--quiet")

    def test_damage_is_a_sentence_and_leaves_nothing(self):
        whole = gzip.compress(self.xyz().read_bytes())
        cut = self.write("cut.xyz.gz", whole[:-100])
        bad = self.write("bad.xyz.gz", whole[:2000] + bytes(10) + whole[2010:])
        for path, says in [(cut, "is cut off"), (bad, "is damaged"), (self.write("no.xyz.gz", b"1 2 3\n"), "unknown format")]:
            before = self.files()
            self.refused(BAD_INPUT, "triangulate", path, "-o", self.out, says=[path.name, says])
            self.assertEqual(self.files(), before)

    @unittest.skipIf(os.geteuid() != 0, "only root may mount")
    def test_a_full_disk_says_how_much_was_unpacked_and_where(self):
        cloud = self.write("cloud.xyz.gz", gzip.compress(self.xyz(n=60_000).read_bytes()))
        disk = self.folder / "disk"
        disk.mkdir()
        if subprocess.run(["mount", "-t", "tmpfs", "-o", "size=2m", "tmpfs", disk]).returncode != 0:
            self.skipTest("tmpfs cannot be mounted here")
        try:
            self.refused(IO, "triangulate", cloud, "-o", disk / "out", "--quiet",
                         says=["cloud.xyz.gz", f"could not be kept in {disk} beyond its first 2.0 MB", "No space left"])
            self.assertEqual(list(disk.iterdir()), [])
            self.refused(IO, "info", cloud, env={"TMPDIR": str(disk)}, says=["TMPDIR", "No space left"])
        finally:
            subprocess.run(["umount", disk], check=True)

    def test_a_bomb_costs_disk_but_no_memory(self):
        part = gzip.compress(bytes(16 << 20))
        bomb = self.write("bomb.xyz.gz", part * 64)
        self.assertLess(bomb.stat().st_size, 2 << 20)
        limit = lambda: resource.setrlimit(resource.RLIMIT_DATA, (256 << 20, 256 << 20))
        self.refused(BAD_INPUT, "info", bomb, "--threads", "1", says="is not text: it holds zero bytes", preexec_fn=limit)


class Meshes(InputTest):
    def test_what_is_exported_is_read_back_with_the_same_points(self):
        self.ok("triangulate", self.xyz(n=500), "-o", self.out, "--tiles", "3", "--dim", "2", "--quiet")
        points = []
        for ending in ["off", "obj", "ply"]:
            self.ok("export", self.out, "-o", f"mesh.{ending}", "--quiet")
            self.assertEqual(self.infos(f"mesh.{ending}")["files"][0]["format"], ending)
            self.ok("triangulate", f"mesh.{ending}", "-o", ending, "--quiet")
            self.ok("export", ending, "-o", f"{ending}.again.off", "--quiet")
            lines = [line for line in (self.folder / f"{ending}.again.off").read_text().splitlines() if not line.startswith("#")]
            points.append(sorted(lines[2:2 + int(lines[1].split()[0])]))
        self.assertEqual(len(points[0]), 500)
        self.assertEqual(points, 3 * points[2:])

    def test_the_corners_of_triangles_are_duplicates(self):
        corners = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]
        facets = "".join("facet normal 0 0 0\nouter loop\n" + "".join("vertex %d %d %d\n" % corners[v] for v in range(4) if v != left)
                         + "endloop\nendfacet\n" for left in range(4))
        stl = self.write("a.stl", f"solid\n{facets}endsolid\n")
        self.ok("triangulate", stl, "-o", self.out, "--quiet")
        self.assertIn(" 12, 8 duplicates", self.ok("info", self.out))


class StandardInput(InputTest):
    def binary_stl(self, triangles):
        rng = random.Random(3)
        return self.write("a.stl", bytes(80) + struct.pack("<I", triangles) + b"".join(
            struct.pack("<12fH", *(rng.random() for _ in range(12)), 0) for _ in range(triangles)))

    def test_gives_what_the_file_gives_in_every_format(self):
        corpus = IGN.parents[1] / "tests/fuzz/corpus"
        for path in [self.xyz(n=2000), self.las(n=2000), corpus / "ply/isprs_CSite2.ply", corpus / "off/all.off",
                     corpus / "obj/colours.obj", corpus / "stl/text.stl", self.binary_stl(2000)]:
            told = self.infos(path)
            for data in [path.read_bytes(), gzip.compress(path.read_bytes())]:
                status, out, errors = self.piped(data, "info", "-", "--json")
                self.assertEqual(status, 0, errors)
                got = self.json_lines(out)[0]
                for key in ["format", "points", "dimension", "detail"]:
                    self.assertEqual(got["files"][0][key], told["files"][0][key])
                self.assertEqual(got["sampled_bounds"], told["sampled_bounds"])
                self.assertEqual(got["files"][0]["path"], "standard input")
                self.assertEqual(got["files"][0]["bytes"], len(data))

    def test_is_triangulated_from_a_pipe_a_slow_pipe_and_a_file(self):
        cloud = self.xyz(n=3000)
        expected = self.triangulate("expected", cloud)
        args = ["triangulate", "-", "--tiles", "3", "--quiet", "-o"]
        for out, pieces in [("pipe", 1), ("slow", 37)]:
            status, _, errors = self.piped(cloud.read_bytes(), *args, out, pieces=pieces)
            self.assertEqual((status, errors), (0, ""))
            self.assertEqual(self.tiles(out), expected)
        with open(cloud) as file:
            done = subprocess.run([TESSERA, *args, "file"], cwd=self.folder, stdin=file, stderr=subprocess.PIPE)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(self.tiles("file"), expected)
        with open(cloud) as file:  # of which somebody has read a line
            os.lseek(file.fileno(), len(cloud.read_text().splitlines(True)[0]), os.SEEK_SET)
            done = subprocess.run([TESSERA, "info", "-", "--json"], stdin=file, stdout=subprocess.PIPE, text=True)
        self.assertLess(self.json_lines(done.stdout)[0]["files"][0]["bytes"], cloud.stat().st_size)
        self.ok("verify", "pipe", "--quiet")

    def test_that_holds_nothing_readable_is_a_sentence(self):
        for data, says in [(b"", "is empty"), (bytes(range(256)), "unknown format"), (b"some words\nmore\n", "line 2"),
                           (gzip.compress(b"1 2 3\n" * 99)[:-9], "is cut off"), (self.las().read_bytes()[:300], "record")]:
            status, _, errors = self.piped(data, "triangulate", "-", "-o", "out")
            self.assertEqual(status, BAD_INPUT, errors)
            self.assertIn("tessera: standard input", errors)
            self.assertIn(says, errors)
        self.assertFalse(self.out.exists())

    def test_that_is_closed_or_a_terminal_is_a_sentence(self):
        done = subprocess.run(f"'{TESSERA}' info - <&-", shell=True, stderr=subprocess.PIPE, text=True)
        self.assertEqual((done.returncode, done.stderr), (BAD_INPUT, "tessera: standard input: is empty\n"))
        ours, theirs = pty.openpty()
        done = subprocess.run([TESSERA, "info", "-"], stdin=theirs, stderr=subprocess.PIPE, text=True, timeout=60)
        os.close(ours), os.close(theirs)
        self.assertEqual(done.returncode, USAGE)
        self.assertIn("is a terminal", done.stderr)
        done = subprocess.run([TESSERA, "info", "-"], stdin=os.open(self.folder, os.O_RDONLY), stderr=subprocess.PIPE, text=True)
        self.assertIn("standard input: is a folder", done.stderr)

    def test_is_read_once(self):
        self.refused(USAGE, "triangulate", "-", "-", "-o", self.out, says="once")
        self.refused(USAGE, "info", "-", "--input-list", "-", says="once")
        self.refused(USAGE, "triangulate", "-", "-o", self.out, "--resume", says=["--resume", "standard input"])
        self.assertFalse(self.out.exists())

    def test_does_not_keep_other_errors_waiting(self):
        process = subprocess.Popen([TESSERA, "triangulate", "missing.las", "-", "-o", self.out, "--threads", "4"],
                                   stdin=subprocess.PIPE, stderr=subprocess.PIPE)
        self.assertEqual(process.wait(timeout=60), IO)
        self.assertIn(b"missing.las", process.communicate()[1])

    def test_that_never_ends_can_be_interrupted(self):
        process = subprocess.Popen([TESSERA, "triangulate", "-", "-o", self.out], stdin=subprocess.PIPE, stderr=subprocess.PIPE)
        process.stdin.write(b"1 2 3\n")
        process.stdin.flush()
        time.sleep(0.5)
        process.send_signal(signal.SIGINT)
        began = time.monotonic()
        self.assertEqual(process.wait(timeout=60), INTERRUPTED)
        self.assertLess(time.monotonic() - began, 30)
        self.assertIn(b"tessera: interrupted", process.communicate()[1])
        self.assertEqual(self.files(), [])

    def test_that_was_routed_and_interrupted_leaves_nothing(self):
        process = subprocess.Popen([TESSERA, "triangulate", "-", "-o", self.out, "--tiles", "12", "--threads", "1"],
                                   stdin=subprocess.PIPE, stderr=subprocess.PIPE)
        process.stdin.write(self.xyz(n=100_000).read_bytes())
        process.stdin.close()
        while not (self.out / ".run" / "plan.json").exists():
            self.assertIsNone(process.poll())
            time.sleep(0.005)
        process.send_signal(signal.SIGINT)
        self.assertEqual(process.wait(timeout=120), INTERRUPTED)
        self.assertIn(b"cannot be read again", process.stderr.read())
        process.stderr.close()
        self.assertFalse(self.out.exists())


class Folders(InputTest):
    def setUp(self):
        super().setUp()
        (self.folder / "block" / "sub").mkdir(parents=True)
        self.a = self.las("block/a.las", n=800)
        self.b = self.xyz("block/b.xyz", n=900)
        self.c = self.xyz("block/sub/c.xyz", n=700, seed=3)
        (self.folder / "block" / "preview.png").write_bytes(b"not points")

    def test_stand_for_the_point_files_in_them(self):
        self.assertEqual(self.triangulate("one", "block"), self.triangulate("two", self.a, self.b))
        self.assertEqual(self.triangulate("three", "block", "--recursive"), self.triangulate("four", self.a, self.b, self.c))
        self.assertEqual([f["path"] for f in self.infos("block")["files"]], ["block/a.las", "block/b.xyz"])
        config = self.write("my.toml", "[info]\nrecursive = true\n")
        self.assertEqual(len(self.infos("block", "--config", config)["files"]), 3)

    def test_without_points_or_with_a_result_are_sentences(self):
        (self.folder / "empty").mkdir()
        self.refused(IO, "triangulate", "empty", "-o", self.out, says="empty: holds no point files")
        self.refused(IO, "info", "empty", says="empty: holds no point files")
        self.triangulate("result", self.b)
        self.refused(USAGE, "triangulate", "result", "-o", self.out, says="result: is a result folder")
        self.refused(USAGE, "info", "result", self.b, says="not both")
        self.assertIn("tetrahedra", self.ok("info", "result"))
        # A manifest of somebody else's is none of ours.
        self.write("block/manifest.json", "{}")
        self.assertEqual(len(self.infos("block")["files"]), 2)

    def test_with_a_file_that_is_no_points_say_where_it_was_found(self):
        self.write("block/read_me.txt", "This block was flown in 2020.\nIt is nice.\n")
        self.refused(BAD_INPUT, "triangulate", "block", "-o", self.out,
                     says=["read_me.txt: ", "found in the folder block", "'block/*.las'"])


class Lists(InputTest):
    def test_name_files_that_follow_those_given(self):
        a, b = self.xyz("a.xyz", n=500), self.xyz("b.xyz", n=600, seed=2)
        (self.folder / "lists").mkdir()
        c = self.las("lists/c.las", n=400)
        self.write("lists/list.txt", f"# the block\n\nc.las\n../b.xyz\n{a}\n")
        told = self.infos("--input-list", "lists/list.txt")
        self.assertEqual([f["path"] for f in told["files"]], ["lists/c.las", "lists/../b.xyz", str(a)])
        expected = self.triangulate("one", b, c, b, a)
        self.assertEqual(self.triangulate("two", b, "--input-list", "lists/list.txt"), expected)
        status, out, errors = self.piped(b"c.las\n", "info", "--input-list", "-")
        self.assertIn("standard input, line 1: c.las: cannot be opened", errors)
        status, out, errors = self.piped(b"lists/c.las\na.xyz\n", "info", "--input-list", "-")
        self.assertEqual((status, errors), (0, ""))

    def test_that_are_wrong_are_named_with_their_line(self):
        self.refused(IO, "info", "--input-list", self.write("l.txt", "\nmissing.las\n"), says=["l.txt, line 2: ", "missing.las"])
        self.refused(BAD_INPUT, "info", "--input-list", self.write("l.txt", "# nothing\n"), says="l.txt: names no input file")
        self.refused(IO, "info", "--input-list", "none.txt", says="none.txt")
        config = self.write("my.toml", "[info]\ninput-list = \"l.txt\"\n")
        self.refused(USAGE, "info", "--config", config, says="command line only")


class SeveralAtOnce(InputTest):
    def test_threads_change_no_byte_of_the_result(self):
        rng = random.Random(4)
        for i in range(30):
            lines = "".join(f"{rng.randrange(60)} {rng.randrange(60)} {rng.randrange(60)}\n" for _ in range(rng.randrange(1, 400)))
            if i % 7 == 0:
                lines += "nan 0 0\n"
            if i % 3 == 0:
                self.write(f"{i:02}.xyz.gz", gzip.compress(lines.encode()))
            else:
                self.write(f"{i:02}.xyz", lines)
        self.las("05.las", n=3000)
        self.xyz("15.xyz", n=30_000)
        args = ["*.*", "--skip-invalid", "--crop", "0,0,50,60", "--attributes", "all"]
        expected = self.triangulate("out1", *args, "--threads", "1")
        for threads in ["2", "5"]:
            self.assertEqual(self.triangulate(f"out{threads}", *args, "--threads", threads), expected)
            self.assertEqual((self.folder / f"out{threads}" / "duplicates.bin").read_bytes(),
                             (self.folder / "out1" / "duplicates.bin").read_bytes())
        self.ok("verify", "out5", "--quiet")


if __name__ == "__main__":
    unittest.main()
