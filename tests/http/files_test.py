"""Files: ranges, validators, and every byte as it is."""

import unittest

import serving

SIZE = 5_000_011
PATH = "/v1/triangulations/block/files/deep/tile.vtu"


class Files(serving.ServerTest):
    options = {"file_bytes": SIZE}

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.content = (bytes(range(251)) * (SIZE // 251 + 1))[:SIZE]

    def get(self, **headers):
        return self.ask("GET", PATH, headers={name.replace("_", "-"): value for name, value in headers.items()})

    def test_a_file_is_sent_as_it_is(self):
        answer = self.get()
        self.assertEqual((answer.status, answer.body == self.content), (200, True))
        self.assertEqual(answer.headers["ETag"], '"xxh3-0123"')
        self.assertEqual(answer.headers["Accept-Ranges"], "bytes")

    def test_ranges(self):
        for asked, begin, end in (("0-0", 0, 1), ("5-9", 5, 10), ("4000000-", 4_000_000, SIZE), ("-7", SIZE - 7, SIZE),
                                  (f"-{SIZE + 9}", 0, SIZE), (f"3-{SIZE * 2}", 3, SIZE), (f"{SIZE - 1}-", SIZE - 1, SIZE)):
            answer = self.get(Range=f"bytes={asked}")
            self.assertEqual((answer.status, answer.body == self.content[begin:end]), (206, True), asked)
            self.assertEqual(answer.headers["Content-Range"], f"bytes {begin}-{end - 1}/{SIZE}")
        for asked in (f"bytes={SIZE}-", "bytes=-0", f"bytes={SIZE}-{SIZE + 3}"):
            answer = self.get(Range=asked)
            self.assertEqual((answer.status, answer.headers["Content-Range"]), (416, f"bytes */{SIZE}"), asked)
        for asked in ("bytes=9-3", "bytes=1-2,5-6", "lines=1-2", "bytes=x"):
            self.assertEqual((self.get(Range=asked).status), 200, asked)

    def test_validators(self):
        for tags, status in (('"xxh3-0123"', 304), ('W/"xxh3-0123"', 304), ('"a", "xxh3-0123"', 304), ("*", 304), ('"a"', 200)):
            answer = self.get(If_None_Match=tags)
            self.assertEqual((answer.status, answer.headers["ETag"]), (status, '"xxh3-0123"'), tags)
        for tags, status in (('"xxh3-0123"', 200), ('W/"xxh3-0123"', 412), ('"a"', 412), ("*", 200)):
            self.assertEqual(self.get(If_Match=tags).status, status, tags)
        for tag, status in (('"xxh3-0123"', 206), ('"old"', 200), ('W/"xxh3-0123"', 200),
                            ("Sat, 29 Oct 2030 19:43:31 GMT", 200)):
            self.assertEqual(self.get(Range="bytes=2-5", If_Range=tag).status, status, tag)

    def test_a_log_that_grows_has_ranges_and_no_tag(self):
        job = self.submit()
        answer = self.ask("GET", f"/v1/jobs/{job}/log", headers={"Range": "bytes=4-"})
        self.assertEqual((answer.status, answer.body, answer.headers["ETag"]), (206, b"two\n", None))

    def test_no_descriptor_is_left(self):
        self.get()
        before = self.server.descriptors()
        for at in range(50):
            self.get(Range=f"bytes={at}-{at + 3}")
            self.get(If_None_Match="*")
            self.get(If_Match='"a"')
            self.ask("HEAD", PATH)
        self.assertLessEqual(self.server.descriptors(), before + 2)

    def test_the_connection_goes_on_after_a_file(self):
        connection = self.connect()
        for part in ("bytes=0-9", "bytes=1000000-3000000"):
            connection.request("GET", PATH, headers={"Authorization": "Bearer " + self.server.tokens["read"], "Range": part})
            self.assertEqual(connection.getresponse().read()[:1], self.content[0:1] if part == "bytes=0-9" else
                             self.content[1_000_000:1_000_001])


if __name__ == "__main__":
    unittest.main()
