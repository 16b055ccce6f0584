"""Connections whose readiness is told late, when it is not true any more."""

import os
import unittest

import serving
from events_test import Stream


class Late(serving.ServerTest):
    environment = {"LD_PRELOAD": os.environ["LATE_READINESS"]}

    def test_no_watcher_is_taken_for_gone(self):
        streams = [Stream(self, "/v1/events") for _ in range(100)]
        self.assertEqual({stream.status for stream in streams}, {200})
        self.assertTrue(self.server.tell("tell 1"))
        heard = [stream.event() for stream in streams]
        self.assertEqual(heard.count(None), 0)


if __name__ == "__main__":
    unittest.main()
