"""Processes around the library: forked ones, fresh ones, pools of them."""
import concurrent.futures
import multiprocessing
import threading
import unittest

import joblib
import tessera

import clouds


def digest_of(points):
    return tessera.triangulate(points, max_points_per_tile=300, threads=2).digest


def cells_of(points):
    return clouds.simplex_set(tessera.Delaunay(points).simplices)


def refused_or(work, *arguments):
    """What `work` returns, or "CLASS: SENTENCE" of what the library refuses."""
    try:
        return work(*arguments)
    except tessera.Error as error:
        return f"{type(error).__name__}: {error}"


class Processes(unittest.TestCase):
    def setUp(self):
        self.points = clouds.random(3000, 3)
        self.digest = digest_of(self.points)  # the library has worked before anything is forked

    def test_pools_of_all_kinds_triangulate(self):
        for method in ("fork", "forkserver", "spawn"):
            context = multiprocessing.get_context(method)
            with self.subTest(method), concurrent.futures.ProcessPoolExecutor(2, context) as pool:
                parts = [clouds.random(500, 2, seed) for seed in range(4)]
                self.assertEqual([*pool.map(digest_of, [self.points] * 2, timeout=120)], [self.digest] * 2)
                self.assertEqual([*pool.map(cells_of, parts, timeout=120)], [*map(cells_of, parts)])

    def test_a_pool_of_the_default_kind_triangulates(self):
        with multiprocessing.Pool(2) as pool:
            self.assertEqual(pool.map_async(digest_of, [self.points] * 3).get(120), [self.digest] * 3)

    def test_joblib_triangulates(self):
        for backend in ("loky", "multiprocessing", "threading"):
            with joblib.parallel_backend(backend, n_jobs=2):
                digests = joblib.Parallel()(joblib.delayed(digest_of)(self.points) for _ in range(3))
            self.assertEqual(digests, [self.digest] * 3)

    def test_a_forked_child_shares_what_its_parent_has(self):
        t, whole = tessera.triangulate(self.points, max_points_per_tile=300), tessera.Delaunay(self.points)
        queries = clouds.random(1000, 3, 2)

        def work():
            nonlocal t
            tiles = [tile.id for tile in t]
            t = None  # the child's: its parent's folder stays
            return tiles, whole.find_simplex(queries).tolist()

        with self.forked(work) as answer:
            self.assertEqual(answer, ([tile.id for tile in t], whole.find_simplex(queries).tolist()))
        self.assertTrue(t.folder.is_dir())

    def test_a_child_forked_within_a_call_is_refused_at_once(self):
        whole, t = tessera.Delaunay(self.points), tessera.triangulate(self.points)
        working, forked = threading.Event(), threading.Event()

        def hold(_):
            working.set()
            forked.wait()

        other = threading.Thread(target=lambda: tessera.triangulate(clouds.random(50_000, 3), progress=hold))
        other.start()
        working.wait()
        try:
            with self.forked(lambda: [refused_or(digest_of, self.points), refused_or(cells_of, self.points),
                                      refused_or(whole.find_simplex, self.points), refused_or(t.__getitem__, 0)]) as answers:
                for answer in answers:
                    self.assertRegex(answer, "UsageError: this process was forked while its parent was in a call")
        finally:
            forked.set()
            other.join()

    def forked(self, work):
        """A context manager that gives what `work` returns in a forked child."""
        receiver, sender = multiprocessing.get_context("fork").Pipe(duplex=False)
        child = multiprocessing.get_context("fork").Process(target=lambda: sender.send(work()))

        class Answer:
            def __enter__(self):
                child.start()
                sender.close()
                if not receiver.poll(120):
                    child.kill()
                    raise AssertionError("the child hangs")
                return receiver.recv()

            def __exit__(self, *_):
                child.join()

        return Answer()


if __name__ == "__main__":
    unittest.main()
