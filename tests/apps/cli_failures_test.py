"""Bad input, bad folders, full disks, damaged results: one sentence, the right status, and nothing half-written."""
import json
import os
import resource
import subprocess
import unittest

from cli import BAD_INPUT, CORRUPT, IO, MEMORY, USAGE, CliTest, heed_permissions


class BadInput(CliTest):
    def refuse(self, status, path, *args, says=()):
        before = self.files()
        says = [says] if isinstance(says, str) else list(says)
        self.refused(status, "triangulate", path, "-o", self.out, *args, says=says)
        self.assertEqual(self.files(), before, "nothing is left")

    def test_files_that_are_not_there_or_not_files(self):
        self.refuse(IO, "missing.las", says="missing.las")
        self.refuse(IO, "none/*.las", says="none/*.las")
        (self.folder / "folder.las").mkdir()
        done = self.run_tessera("triangulate", "folder.las", "-o", self.out)
        self.assertIn(done.returncode, (BAD_INPUT, IO))
        self.assertIn("folder.las", done.stderr)
        self.assertFalse(self.out.exists())

    def test_unreadable_files(self):
        path = self.xyz()
        path.chmod(0)
        before = self.files()
        self.refused(IO, "triangulate", path, "-o", self.out, says="cloud.xyz", preexec_fn=heed_permissions)
        self.assertEqual(self.files(), before, "nothing is left")

    def test_empty_and_unknown_files(self):
        self.refuse(BAD_INPUT, self.write("empty.las", b""), says="empty.las")
        self.refuse(BAD_INPUT, self.write("noise.dat", bytes(range(256)) * 10), says="noise.dat")
        self.refuse(BAD_INPUT, self.write("words.xyz", "this is\nno cloud\n"), says="words.xyz")

    def test_las_files_that_lie(self):
        whole = self.las().read_bytes()
        for name, content in [("header", whole[:100]), ("record", whole[:-7]), ("half", whole[:len(whole) // 2])]:
            self.refuse(BAD_INPUT, self.write(f"{name}.las", content), says=f"{name}.las")
        for name, lie in [("count", dict(count=10**9)), ("length", dict(record_bytes=3)), ("format", dict(point_format=99)),
                          ("offset", dict(offset=0xFFFFFFF0)), ("scale", dict(scale=(float("nan"),) * 3)),
                          ("version", dict(version=(9, 9))), ("magic", dict(magic=b"LASX")),
                          ("records", dict(records=0xFFFFFFFF))]:
            content = self.las(**lie).read_bytes()
            self.refuse(BAD_INPUT, self.write(f"{name}.las", content), says=f"{name}.las")

    def test_coordinates_that_are_not_finite_are_named_by_place(self):
        text = self.xyz(n=50).read_text()
        self.refuse(BAD_INPUT, self.write("nan.xyz", text + "nan 0 0\n"), says=["nan.xyz", "line 51"])
        self.refuse(BAD_INPUT, self.write("inf.xyz", text + "0 inf 0\n"), says=["inf.xyz", "line 51"])

    def test_points_that_span_no_volume(self):
        grid = [(x, y) for x in range(5) for y in range(5)]
        for name, lines in [("one", ["1 2 3"]), ("three", ["0 0 0", "1 0 0", "0 1 0"]), ("same", ["1 1 1"] * 50),
                            ("line", [f"{i} {i} {i}" for i in range(50)]), ("plane", [f"{x} {y} 7" for x, y in grid])]:
            self.refuse(BAD_INPUT, self.write(f"{name}.xyz", "\n".join(lines) + "\n"))
        self.refuse(BAD_INPUT, self.write("row.xyz", "\n".join(f"{i} 0 0" for i in range(9)) + "\n"), "--dim", "2")

    def test_filters_that_leave_nothing(self):
        self.refuse(BAD_INPUT, self.xyz(), "--crop", "5,5,6,6")
        self.refuse(USAGE, self.xyz(), "--class", "2", says="classification")
        self.refuse(USAGE, self.xyz(), "--attributes", "colour", says="colour")

    def test_too_little_memory(self):
        self.refuse(MEMORY, self.xyz(n=20_000), "--memory", "1M", says="--memory")


class ResultFolders(CliTest):
    def setUp(self):
        super().setUp()
        self.cloud = self.xyz()

    def triangulate(self, *args, **more):
        return self.ok("triangulate", self.cloud, "-o", self.out, "--tiles", "2", "--quiet", *args, **more)

    def refuse(self, status, *args, says=()):
        self.refused(status, "triangulate", self.cloud, "-o", self.out, *args, says=says)

    def test_a_result_is_replaced_only_when_asked_for(self):
        self.triangulate()
        before = (self.out / "manifest.json").read_bytes()
        self.refuse(USAGE, says="--overwrite")
        self.assertEqual((self.out / "manifest.json").read_bytes(), before)
        self.ok("triangulate", self.cloud, "-o", self.out, "--tiles", "5", "--overwrite", "--quiet")
        self.assertEqual(len(list((self.out / "tiles").iterdir())), 5)
        self.ok("verify", self.out, "--quiet")

    def test_resuming_what_is_finished_says_so_and_changes_nothing(self):
        self.triangulate()
        before = {name: (self.out / name).stat().st_mtime_ns for name in self.files(self.out)}
        args = "triangulate", self.cloud, "-o", self.out, "--resume"
        self.assertIn("is finished already", self.ok(*args))
        self.assertEqual(json.loads(self.ok(*args, "--json").splitlines()[-1])["event"], "finished")
        self.assertEqual(self.ok(*args, "--quiet"), "")
        self.assertEqual({name: (self.out / name).stat().st_mtime_ns for name in self.files(self.out)}, before)
        self.refused(USAGE, "triangulate", self.xyz("other.xyz"), "-o", self.out, "--resume",
                     says=["other input files", "--overwrite"])

    def test_a_bad_new_input_leaves_the_old_result(self):
        self.triangulate()
        before = {name: (self.out / name).stat().st_mtime_ns for name in self.files(self.out)}
        bad = self.write("bad.xyz", self.cloud.read_text() + "nan 0 0\n")
        self.refused(BAD_INPUT, "triangulate", bad, "-o", self.out, "--overwrite", says="nan")
        self.assertEqual({name: (self.out / name).stat().st_mtime_ns for name in self.files(self.out)}, before)
        self.ok("verify", self.out, "--quiet")

    def test_other_peoples_files_are_never_touched(self):
        self.out.mkdir()
        (self.out / "thesis.tex").write_text("important")
        for option in [(), ("--overwrite",), ("--resume",)]:
            self.refuse(USAGE, *option, says="not empty")
        (self.out / "thesis.tex").unlink()
        self.triangulate()
        (self.out / "thesis.tex").write_text("important")
        (self.out / "tiles" / "notes.txt").write_text("important")
        self.triangulate("--overwrite")
        self.assertEqual((self.out / "thesis.tex").read_text(), "important")
        self.assertEqual((self.out / "tiles" / "notes.txt").read_text(), "important")

    def test_folders_that_cannot_be(self):
        self.refused(IO, "triangulate", self.cloud, "-o", self.folder / "no" / "such" / "out", says="does not exist")
        self.refused(IO, "triangulate", self.cloud, "-o", self.cloud, says="is not a folder")
        self.refused(IO, "triangulate", self.cloud, "-o", "/proc/out", says="/proc/out")

    def test_a_folder_without_write_permission(self):
        self.out.mkdir(mode=0o555)
        self.refused(IO, "triangulate", self.cloud, "-o", self.out, says="cannot be written",
                     preexec_fn=heed_permissions)

    def test_an_empty_folder_and_a_trailing_slash_will_do(self):
        self.out.mkdir()
        self.ok("triangulate", self.cloud, "-o", f"{self.out}/", "--quiet")
        self.ok("triangulate", self.cloud, "-o", "other/", "--quiet")

    def test_a_manifest_from_the_future_is_refused(self):
        self.triangulate()
        path = self.out / "manifest.json"
        manifest = json.loads(path.read_text())
        versions = [key for key in manifest if "version" in key and isinstance(manifest[key], int)]
        manifest[versions[0]] = 99
        path.write_text(json.dumps(manifest))
        for command in [("verify", self.out), ("info", self.out), ("export", self.out, "-o", "m.ply"),
                        ("triangulate", self.cloud, "-o", self.out, "--overwrite")]:
            self.refused(CORRUPT, *command, says="manifest.json")


class FullDisk(CliTest):
    def test_a_limit_on_file_sizes_is_an_error_and_leaves_nothing(self):
        cloud = self.xyz(n=20_000)
        before = self.files()

        def limit():
            resource.setrlimit(resource.RLIMIT_FSIZE, (100_000, 100_000))

        self.refused(IO, "triangulate", cloud, "-o", self.out, preexec_fn=limit)
        self.assertEqual(self.files(), before)

    @unittest.skipIf(os.geteuid() != 0, "only root may mount")
    def test_a_full_disk_is_an_error_and_leaves_nothing_at_whatever_point_it_is_full(self):
        cloud = self.xyz(n=20_000)
        disk = self.folder / "disk"
        disk.mkdir()
        for size in ["300k", "700k", "2m", "5m"]:
            if subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={size}", "tmpfs", disk]).returncode != 0:
                self.skipTest("tmpfs cannot be mounted here")
            try:
                self.refused(IO, "triangulate", cloud, "-o", disk / "out", "--tiles", "4", "--quiet")
                self.assertEqual(list(disk.iterdir()), [], size)
            finally:
                subprocess.run(["umount", disk], check=True)


    @unittest.skipIf(os.geteuid() != 0, "only root may mount")
    def test_a_change_asks_for_room_before_it_begins(self):
        cloud = self.xyz(n=20_000)
        disk = self.folder / "disk"
        disk.mkdir()
        self.ok("triangulate", cloud, "-o", "made", "--tiles", "4", "--quiet")
        size = sum(p.stat().st_size for p in (self.folder / "made").rglob("*"))
        if subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={size * 3 // 2}", "tmpfs", disk]).returncode != 0:
            self.skipTest("tmpfs cannot be mounted here")
        try:
            subprocess.run(["cp", "-r", self.folder / "made", disk / "out"], check=True)
            before = self.files(disk)
            self.refused(IO, "update", disk / "out", "--add", cloud, "--quiet",
                         says=("out: the changed tiles need at least about", "beside the old ones, and the disk has"))
            self.assertEqual(self.files(disk), before)
            self.ok("verify", disk / "out", "--quiet")
        finally:
            subprocess.run(["umount", disk], check=True)


class Damage(CliTest):
    def setUp(self):
        super().setUp()
        self.ok("triangulate", self.xyz(), "-o", self.out, "--tiles", "3", "--quiet")
        self.tile = self.out / "tiles" / "000001.vtu"

    def test_a_changed_byte_of_a_tile_is_found(self):
        content = bytearray(self.tile.read_bytes())
        for at in [0, 100, len(content) // 2, len(content) - 1]:
            damaged = content.copy()
            damaged[at] ^= 0x40
            self.tile.write_bytes(damaged)
            self.refused(CORRUPT, "verify", self.out, says="000001")

    def test_a_truncated_or_missing_tile_is_found(self):
        content = self.tile.read_bytes()
        for length in [0, 10, len(content) // 2, len(content) - 1]:
            self.tile.write_bytes(content[:length])
            self.refused(CORRUPT, "verify", self.out, says="000001")
            self.refused(CORRUPT, "export", self.out, "-o", "m.ply", says="000001")
        self.tile.unlink()
        done = self.run_tessera("verify", self.out)
        self.assertIn(done.returncode, (IO, CORRUPT))
        self.assertIn("000001", done.stderr)

    def test_a_damaged_manifest_is_found(self):
        path = self.out / "manifest.json"
        for content in ["", "{", "[]", "null", path.read_text()[:-20]]:
            path.write_text(content)
            self.refused(CORRUPT, "verify", self.out, says="manifest.json")
            self.refused(CORRUPT, "info", self.out, says="manifest.json")

    def test_what_is_no_result_is_an_error(self):
        self.refused(IO, "verify", self.folder / "nothing", says="nothing")
        (self.folder / "empty").mkdir()
        self.refused(IO, "verify", self.folder / "empty", says="empty")


if __name__ == "__main__":
    unittest.main()
