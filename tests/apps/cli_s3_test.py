"""Points from objects in S3: signed as Amazon says, with the credentials that other programs find, and whole folders."""
import json
import pathlib
import unittest

from cli import IO, USAGE, CliTest
from s3_server import S3Server

CLOUDS = pathlib.Path(__file__).resolve().parent.parent / "data" / "clouds"
FILES = sorted(CLOUDS.glob("ign_770*_6277*.laz"))
KEYS = {"AKIDEXAMPLE": "wJalrXUtnFEMI/K7MDENG+bPxRfiCYEXAMPLEKEY"}
ME = {"AWS_ACCESS_KEY_ID": "AKIDEXAMPLE", "AWS_SECRET_ACCESS_KEY": KEYS["AKIDEXAMPLE"]}


class S3(CliTest):
    def serve(self, objects=None, **more):
        objects = {"clouds/" + key: path.read_bytes() for key, path in (objects or {"a/b.laz": FILES[0]}).items()}
        return self.enterContext(S3Server(objects, KEYS, **more))

    def environment(self, server, **variables):
        return {"HOME": str(self.folder), "AWS_ENDPOINT_URL": server.address, "AWS_EC2_METADATA_DISABLED": "true"} | variables

    def points(self, server, *names, more=(), **variables):
        return json.loads(self.ok("info", *names, "--json", *more, env=self.environment(server, **variables)))["points"]

    def expected(self, *files):
        return json.loads(self.ok("info", *files, "--json"))["points"]

    def test_requests_are_signed(self):
        for key in ("a/b.laz", "a b/+(ü)'=&~.laz"):
            server = self.serve({key: FILES[0]})
            with self.subTest(key=key):
                self.assertEqual(self.points(server, f"s3://clouds/{key}", **ME), self.expected(FILES[0]))

    def test_a_wrong_key_and_a_wrong_secret_are_sentences(self):
        server = self.serve()
        for variables, says in ((ME | {"AWS_SECRET_ACCESS_KEY": "other"}, "SignatureDoesNotMatch"),
                                (ME | {"AWS_ACCESS_KEY_ID": "NOBODY"}, "InvalidAccessKeyId")):
            done = self.refused(IO, "info", "s3://clouds/a/b.laz", env=self.environment(server, **variables), says=("s3://clouds/a/b.laz", "403", says))
            self.assertNotIn(KEYS["AKIDEXAMPLE"], done.stderr)

    def test_a_token_goes_along_and_is_signed(self):
        server = self.serve(token="TOKEN/123==")
        self.assertEqual(self.points(server, "s3://clouds/a/b.laz", **ME, AWS_SESSION_TOKEN="TOKEN/123=="), self.expected(FILES[0]))
        self.refused(IO, "info", "s3://clouds/a/b.laz", env=self.environment(server, **ME), says="InvalidToken")

    def test_credentials_come_from_the_usual_files(self):
        (self.folder / ".aws").mkdir()
        server = self.serve(region="eu-west-3")
        self.write(".aws/credentials", f"# mine\n[default]\naws_access_key_id = NOBODY\naws_secret_access_key = x\n\n[work]\naws_access_key_id={ME['AWS_ACCESS_KEY_ID']}\n"
                                       f"aws_secret_access_key = {ME['AWS_SECRET_ACCESS_KEY']}\n")
        self.write(".aws/config", "[default]\nregion = eu-west-3\n[profile work]\nregion = eu-west-3\ns3 =\n    region = no-where-1\n")
        self.assertEqual(self.points(server, "s3://clouds/a/b.laz", AWS_PROFILE="work"), self.expected(FILES[0]))
        self.refused(IO, "info", "s3://clouds/a/b.laz", env=self.environment(server), says="InvalidAccessKeyId")
        self.assertEqual(self.points(server, "s3://clouds/a/b.laz", more=("--profile", "work")), self.expected(FILES[0]))
        self.refused(USAGE, "info", "s3://clouds/a/b.laz", "--profile", "nobody", env=self.environment(server), says=("--profile", "nobody"))

    def test_the_region_that_the_server_names_is_used(self):
        server = self.serve(region="ap-south-1")
        self.assertEqual(self.points(server, "s3://clouds/a/b.laz", **ME), self.expected(FILES[0]))

    def test_without_credentials(self):
        server = self.serve(public={"clouds"})
        self.refused(USAGE, "info", "s3://clouds/a/b.laz", env=self.environment(server), says=("no credentials", "--anonymous"))
        self.assertEqual(self.points(server, "s3://clouds/a/b.laz", more=("--anonymous",)), self.expected(FILES[0]))
        self.refused(IO, "info", "s3://others/a/b.laz", "--anonymous", env=self.environment(server), says=("403", "AccessDenied"))

    def test_who_asks_pays_only_when_told_so(self):
        server = self.serve()
        self.points(server, "s3://clouds/a/b.laz", **ME)
        self.assertEqual(set(server.payers), {None})
        server.payers.clear()
        self.points(server, "s3://clouds/a/b.laz", more=("--requester-pays",), **ME)
        self.assertEqual(set(server.payers), {"requester"})

    def test_the_option_is_stronger_than_the_variable(self):
        server = self.serve()
        env = self.environment(server, **ME) | {"AWS_ENDPOINT_URL": "http://127.0.0.1:1"}
        self.ok("info", "s3://clouds/a/b.laz", "--endpoint", server.address, env=env)

    def test_a_folder_stands_for_its_point_files(self):
        objects = {f"block/{path.name}": path for path in FILES} | {"block/readme.md": FILES[0], "block/deep/z.laz": FILES[0]}
        server = self.serve(objects, page=2)
        self.assertEqual(self.points(server, "s3://clouds/block/", **ME), self.expected(*FILES))
        self.assertEqual(self.points(server, "s3://clouds", more=("--recursive",), **ME), self.expected(*FILES) + self.expected(FILES[0]))
        self.refused(IO, "info", "s3://clouds/", env=self.environment(server, **ME), says=("s3://clouds/", "no point files", "--recursive"))
        for name, says in (("s3://", "no bucket"), ("s3://UPPER/a.laz", "no bucket")):
            self.refused(USAGE, "info", name, env=self.environment(server, **ME), says=says)

    def test_a_redirect_does_not_get_the_signature(self):
        server, other = self.serve(), self.serve()
        server.fault = lambda request, answer: type(answer)(307, {"Location": other.url("clouds/a/b.laz")}, b"")
        self.refused(IO, "info", "s3://clouds/a/b.laz", env=self.environment(server, **ME), says="must not get")
        self.assertEqual(other.requests, [])


if __name__ == "__main__":
    unittest.main()
