"""Points from objects behind nginx: what a real server answers, over connections that it closes as it likes."""
import os
import pathlib
import re
import shutil
import subprocess
import unittest

from cli import BAD_INPUT, IO, CliTest

CLOUDS = pathlib.Path(__file__).resolve().parent.parent / "data" / "clouds"
NGINX = shutil.which("nginx", path=os.environ["PATH"] + ":/usr/sbin")

CONFIGURATION = """
pid FOLDER/pid; error_log FOLDER/error.log; worker_processes 1; daemon on; user root;
events { worker_connections 64; }
http {
  access_log FOLDER/access.log; keepalive_requests 5; default_type application/octet-stream;
  client_body_temp_path FOLDER/1; proxy_temp_path FOLDER/2; fastcgi_temp_path FOLDER/3; uwsgi_temp_path FOLDER/4; scgi_temp_path FOLDER/5;
  gzip on; gzip_types *; gzip_min_length 1;
  server {
    listen unix:FOLDER/socket; listen 127.0.0.1:PORT; root CLOUDS;
    location /whole/ { alias CLOUDS/; max_ranges 0; }
    location /slow/ { alias CLOUDS/; limit_rate 400k; }
    location /refused/ { return 403; }
  }
}
"""


@unittest.skipUnless(NGINX, "nginx is not installed")
class Nginx(CliTest):
    def setUp(self):
        super().setUp()
        self.server = self.folder / "nginx"
        self.server.mkdir()
        for port in range(18400 + os.getpid() % 100, 18600):
            text = CONFIGURATION.replace("FOLDER", str(self.server)).replace("CLOUDS", str(CLOUDS)).replace("PORT", str(port))
            configuration = self.write("nginx/nginx.conf", text)
            if subprocess.run([NGINX, "-c", configuration], capture_output=True).returncode == 0:
                break
        else:
            self.fail("nginx finds no port")
        self.addCleanup(subprocess.run, [NGINX, "-c", configuration, "-s", "quit"], capture_output=True)
        self.address = f"http://127.0.0.1:{port}"

    def tiles(self, input, *more):
        self.ok("triangulate", input, "-o", self.out, "--overwrite", "--quiet", "--dim", "2", *more)
        return {path.name: path.read_bytes() for path in (self.out / "tiles").iterdir()}

    def test_the_result_is_that_of_the_file(self):
        for name in ("lone_star_part.copc.laz", "ign_77050_627755_begin.las", "velodyne_400_begin.csv"):
            for place in ("", "slow/"):
                with self.subTest(name=name, place=place):
                    self.assertEqual(self.tiles(f"{self.address}/{place}{name}"), self.tiles(CLOUDS / name))
        said = (self.server / "access.log").read_text()
        self.assertEqual(set(re.findall(r'HTTP/1.1" (\d+) ', said)), {"206"})

    def test_what_is_refused_is_a_sentence(self):
        self.refused(IO, "info", f"{self.address}/refused/a.laz", says="403")
        self.refused(IO, "info", f"{self.address}/missing.laz", says="404")
        self.refused(BAD_INPUT, "info", f"{self.address}/whole/lone_star_part.copc.laz", says="only the whole object")


if __name__ == "__main__":
    unittest.main()
