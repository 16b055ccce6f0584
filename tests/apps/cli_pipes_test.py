"""A named pipe, or a device without an end, in the place of any file of a result: a sentence, and nobody waits."""
import json
import os
import shutil
import unittest

from cli import IO, OK, CliTest

# All that read a result, each with a result of 2 or 3 dimensions.
READERS = (("verify",), ("verify", "--against-cgal"), ("info",), ("export", "-o", "mesh.ply", "--overwrite"), ("export", "-o", "mesh.vtu", "--overwrite"),
           ("query", "locate", "0.5,0.5,0.5"), ("query", "star", "7"), ("query", "interpolate", "where.xyz", "--value", "z"),
           ("dem", "--res", "0.1", "-o", "dem.tif", "--overwrite"), ("contours", "--interval", "0.1", "-o", "lines.gpkg", "--overwrite"),
           ("profile", "--line", "0,0 1,1", "-o", "profile.csv", "--overwrite"), ("tileset", "-o", "tileset", "--overwrite"))


class Pipes(CliTest):
    def test_in_the_place_of_any_file_of_a_result(self):
        cloud = self.xyz(n=600)
        with open(cloud, "a", encoding="ascii") as file:
            file.write(cloud.read_text("ascii").splitlines()[0] + "\n")  # a duplicate
        (self.folder / "where.xyz").write_text("0.5 0.5 0\n0.25 0.75 0\n", "ascii")
        self.ok("triangulate", cloud, "--dim", "2", "--tiles", "3", "-o", self.out)
        files = [f.relative_to(self.out) for f in self.out.rglob("*") if f.is_file() and f.name != "report.html"]
        self.assertEqual({f.name for f in files}, {"manifest.json", "triangulation.pvtu", "duplicates.bin", "duplicate-rows.bin", "000000.vtu", "000001.vtu", "000002.vtu"})
        for what in ("pipe", "device"):
            for file in files:
                damaged = self.folder / "damaged"
                shutil.rmtree(damaged, ignore_errors=True)
                shutil.copytree(self.out, damaged)
                (damaged / file).unlink()
                if what == "pipe":
                    os.mkfifo(damaged / file)
                else:
                    os.symlink("/dev/zero", damaged / file)
                for command, *more in READERS:
                    with self.subTest(file=str(file), what=what, command=command, more=more):
                        done = self.run_tessera(command, damaged, *more)
                        if done.returncode == OK and command != "verify":
                            continue  # it needs no more than the other files
                        self.assertEqual(done.returncode, IO, done.stderr)
                        self.assertIn(f"{damaged / file}: is not a regular file", done.stderr)

    def test_in_the_place_of_files_of_an_unfinished_run(self):
        cloud = self.xyz(n=5000)
        args = ["triangulate", cloud, "--tiles", "6", "-o", self.out, "--threads", "1"]
        self.ok(*args)
        digest = json.loads(self.ok("info", self.out, "--json"))["digest"]
        shutil.rmtree(self.out)
        (self.out / ".run").mkdir(parents=True)
        os.mkfifo(self.out / ".run" / "plan.json")
        self.ok(*args, "--resume")  # without a plan there is nothing to go on with: it begins again
        self.assertEqual(json.loads(self.ok("info", self.out, "--json"))["digest"], digest)


if __name__ == "__main__":
    unittest.main()
