"""Points from stores that GDAL reads: gs:// and az://."""
import json
import pathlib
import unittest
import urllib.parse

from cli import BAD_INPUT, IO, CliTest
from object_server import Answer, ObjectServer

CLOUDS = pathlib.Path(__file__).resolve().parent.parent / "data" / "clouds"
FILES = sorted(CLOUDS.glob("ign_770*_6277*.laz"))[:2]


class StoreServer(ObjectServer):
    """Objects as Google's and Azure's stores give them, without signatures. Lists a folder by prefix."""

    def __init__(self, objects):
        super().__init__(objects)
        outer = self

        def head(handler):
            name = urllib.parse.unquote(handler.path.split("?")[0].lstrip("/"))
            answer = outer.fault(None, outer.honest(name, None, None, None))
            handler.send_response(answer.status)
            for key, value in answer.headers.items():
                handler.send_header(key, value)
            handler.send_header("Content-Length", str(len(answer.body)))
            handler.end_headers()

        self.server.RequestHandlerClass.do_HEAD = head

    def gate(self, handler, request):
        path, _, query = handler.path.partition("?")
        query = dict(urllib.parse.parse_qsl(query))
        if "prefix" not in query:
            return None
        keys = sorted(name.partition("/")[2] for name in self.objects if name.startswith(path.strip("/") + "/" + query["prefix"]))
        return Answer(200, {"Content-Type": "application/xml"}, (
            "<?xml version='1.0' encoding='UTF-8'?><ListBucketResult xmlns='http://doc.s3.amazonaws.com/2006-03-01'><Name>bucket</Name><Prefix>"
            f"{query['prefix']}</Prefix><IsTruncated>false</IsTruncated>"
            + "".join(f"<Contents><Key>{key}</Key><LastModified>2024-01-01T00:00:00.000Z</LastModified><ETag>\"x\"</ETag><Size>1000</Size></Contents>" for key in keys)
            + "</ListBucketResult>").encode())


class Stores(CliTest):
    def serve(self, folder):
        server = self.enterContext(StoreServer({f"{folder}/{file.name}": file.read_bytes() for file in FILES}))
        account = f"DefaultEndpointsProtocol=http;AccountName=me;AccountKey=a2V5;BlobEndpoint={server.address}/me"
        self.env = {"HOME": str(self.folder), "GS_NO_SIGN_REQUEST": "YES", "CPL_GS_ENDPOINT": server.address + "/", "AZURE_STORAGE_CONNECTION_STRING": account}
        return server

    def digest(self, *inputs):
        self.ok("triangulate", *inputs, "--dim", "2", "--class", "2", "-o", self.out, "--overwrite", "--quiet", env=self.env)
        return json.loads((self.out / "manifest.json").read_text())["digest2"]

    def test_objects_are_the_files(self):
        for name, folder in (("gs://bucket/a b/", "bucket/a b"), ("az://clouds/", "me/clouds")):
            server = self.serve(folder)
            with self.subTest(name=name):
                self.assertEqual(self.digest(*(name + file.name for file in FILES)), self.digest(*FILES))
                self.assertLessEqual(server.most_at_once, 16)
                self.refused(IO, "info", name + "none.las", env=self.env, says=(name + "none.las: there is no such object",))

    def test_a_folder_of_a_bucket(self):
        server = self.serve("bucket/block")
        server.objects["bucket/block/read.me"] = b"?"
        self.assertEqual(self.digest("gs://bucket/block/"), self.digest(*FILES))
        self.refused(IO, "info", "gs://bucket/empty/", env=self.env, says=("gs://bucket/empty/: holds no point files", "--recursive"))

    def test_an_object_that_changes_is_an_error(self):
        server = self.serve("bucket")
        asked = []

        def fault(request, answer):
            asked.append(request)
            if len(asked) > 4:
                answer.headers["Last-Modified"] = "Tue, 14 Nov 2023 23:00:00 GMT"
            return answer

        server.fault = fault
        self.refused(BAD_INPUT, "triangulate", "gs://bucket/" + FILES[0].name, "--dim", "2", "-o", self.out, env=self.env, says="was changed on the server")


if __name__ == "__main__":
    unittest.main()
