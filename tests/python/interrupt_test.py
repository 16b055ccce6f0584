"""The GIL, threads, progress, Ctrl-C."""
import os
import pathlib
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import time
import unittest

import numpy as np
import tessera

import clouds


class Progress(unittest.TestCase):
    def test_it_is_told_in_the_callers_thread_and_ends_with_all_done(self):
        seen, threads = [], set()

        def progress(figures):
            seen.append(figures)
            threads.add(threading.get_ident())

        t = tessera.triangulate(clouds.random(400_000, 3), max_points_per_tile=50_000, progress=progress)
        self.assertEqual(threads, {threading.get_ident()})
        self.assertGreater(len(seen), 2)
        self.assertIsInstance(seen[-1], tessera.Progress)
        self.assertEqual(seen[-1].phase, "done")
        self.assertEqual((seen[-1].points_total, seen[-1].points_triangulated), (400_000, 400_000))
        self.assertEqual(seen[-1].tiles_stored, seen[-1].tiles_total)
        self.assertEqual([f.seconds for f in seen], sorted(f.seconds for f in seen))
        self.assertEqual(t.n_points, 400_000)

    def test_what_it_raises_comes_out_and_leaves_nothing(self):
        class Mine(Exception):
            pass

        raised = Mine("enough")

        def progress(figures):
            raise raised

        with tempfile.TemporaryDirectory() as folder:
            with self.assertRaises(Mine) as caught:
                tessera.triangulate(clouds.random(300_000, 3), folder=pathlib.Path(folder, "out"), progress=progress)
            self.assertIs(caught.exception, raised)
            self.assertEqual(os.listdir(folder), [])

    def test_other_python_threads_go_on_meanwhile(self):
        points = clouds.random(300_000, 3)
        queries = clouds.random(1_000_000, 3, 2)
        tri = tessera.Delaunay(points[:1000])
        for name, work in {"triangulate": lambda: tessera.triangulate(points), "Delaunay": lambda: tessera.Delaunay(points),
                           "find_simplex": lambda: tri.find_simplex(queries)}.items():
            counts, stop = [0], threading.Event()

            def count():
                while not stop.is_set():
                    counts[0] += 1
                    time.sleep(0.001)

            other = threading.Thread(target=count)
            other.start()
            begin, start = counts[0], time.monotonic()
            work()
            counted, seconds = counts[0] - begin, time.monotonic() - start
            stop.set()
            other.join()
            with self.subTest(name):
                # Held, the GIL would give it one turn or two. Generous: the machine may be busy.
                self.assertGreater(counted, 20 * seconds)

    def test_it_works_in_any_thread_and_in_several_at_once(self):
        results = {}

        def work(seed):
            points = clouds.random(20_000, 3, seed)
            seen = []
            t = tessera.triangulate(points, max_points_per_tile=5000, threads=1, progress=seen.append)
            results[seed] = t.n_cells == tessera.Delaunay(points).nsimplex and seen[-1].phase == "done"

        threads = [threading.Thread(target=work, args=(seed,)) for seed in range(4)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        self.assertEqual(results, {seed: True for seed in range(4)})


SCRIPT = """
import sys, time, numpy as np, tessera
points = np.random.default_rng(1).random((4_000_000, 3))
progress = (lambda figures: None) if "progress" in sys.argv else None
work = {"array": lambda: tessera.triangulate(points, progress=progress),
        "folder": lambda: tessera.triangulate(points, folder=sys.argv[2], progress=progress),
        "Delaunay": lambda: tessera.Delaunay(points),
        "find_simplex": tessera.Delaunay(points[:100_000]).find_simplex}[sys.argv[1]]
args = [np.tile(points, (5, 1))] if sys.argv[1] == "find_simplex" else []
print("working", flush=True)
try:
    work(*args)
except KeyboardInterrupt:
    print("interrupted", flush=True)
    raise SystemExit(0)
print("finished", flush=True)
"""


class CtrlC(unittest.TestCase):
    def interrupted_after(self, seconds, *args):
        """The processor time that the script took after the signal, in seconds, and what it left in the temporary folder."""
        with tempfile.TemporaryDirectory() as folder:
            out = str(pathlib.Path(folder, "out"))
            args = [out if arg == "OUT" else arg for arg in args]
            process = subprocess.Popen([sys.executable, "-c", SCRIPT, *args], stdout=subprocess.PIPE, text=True,
                                       env=os.environ | {"TMPDIR": folder})
            self.assertEqual(process.stdout.readline(), "working\n")
            time.sleep(seconds)
            process.send_signal(signal.SIGINT)
            until_then = sum(map(int, pathlib.Path(f"/proc/{process.pid}/stat").read_text().split()[13:15]))
            rest = process.stdout.read()
            process.stdout.close()
            _, process.returncode, used = os.wait4(process.pid, 0)
            self.assertEqual(rest, "interrupted\n")
            return used.ru_utime + used.ru_stime - until_then / os.sysconf("SC_CLK_TCK"), os.listdir(folder)

    def test_it_ends_everything_at_once_and_leaves_nothing(self):
        for seconds in (0.1, 1.2):
            for args in (["array"], ["array", "progress"], ["folder", "OUT"], ["folder", "OUT", "progress"], ["Delaunay"],
                         ["find_simplex"]):
                with self.subTest(seconds=seconds, args=args):
                    took, left = self.interrupted_after(seconds, *args)
                    self.assertEqual(left, [])
                    # Processor time of two threads, for the machine may be busy. Undisturbed they would take 8 to 40 s.
                    self.assertLess(took, 3)

    def test_a_handler_that_does_not_raise_does_not_end_it(self):
        points = clouds.random(400_000, 3)
        seen = []
        old = signal.signal(signal.SIGALRM, lambda *_: seen.append(1))
        self.addCleanup(signal.signal, signal.SIGALRM, old)
        for work in (tessera.triangulate, tessera.Delaunay):
            signal.setitimer(signal.ITIMER_REAL, 0.1)
            work(points)
        self.assertEqual(len(seen), 2)


if __name__ == "__main__":
    unittest.main()
