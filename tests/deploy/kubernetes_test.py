"""The manifest: objects and fields that `podman kube play` 4.3 has, names that agree, and what the security page promises."""
import os
import pathlib
import re
import tomllib
import unittest

import yaml

SOURCE = pathlib.Path(os.environ["SOURCE"])
TEXT = (SOURCE / "deploy/kubernetes.yaml").read_text()
DATA = (SOURCE / "deploy/kubernetes-data.yaml").read_text()

# podman-kube-play(1) of 4.3; it has volumes of secrets, too, although its page lacks them. Of PersistentVolumeClaims it makes
# the volume, and fails when it is there: hence the file of its own.
KINDS = {"ConfigMap", "Deployment"}
VOLUMES = {"persistentVolumeClaim", "hostPath", "configMap", "secret", "emptyDir"}
CONTAINER = {"name", "image", "imagePullPolicy", "args", "ports", "resources", "securityContext", "readinessProbe",
             "livenessProbe", "volumeMounts"}
POD = {"automountServiceAccountToken", "enableServiceLinks", "terminationGracePeriodSeconds", "securityContext", "containers",
       "volumes"}


class Manifest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.objects = {document["kind"]: document for document in yaml.safe_load_all(TEXT)}
        cls.claim = yaml.safe_load(DATA)
        cls.deployment = cls.objects["Deployment"]["spec"]
        cls.pod = cls.deployment["template"]["spec"]
        (cls.container,) = cls.pod["containers"]
        cls.settings = tomllib.loads(cls.objects["ConfigMap"]["data"]["tesserad.toml"])

    def test_objects_and_fields_are_those_of_podman(self):
        self.assertEqual(set(self.objects), KINDS)
        self.assertEqual(self.claim["kind"], "PersistentVolumeClaim")
        self.assertEqual(set(self.pod), POD)
        self.assertEqual(set(self.container), CONTAINER)
        kinds = {kind for volume in self.pod["volumes"] for kind in volume if kind != "name"}
        self.assertEqual(kinds, VOLUMES)
        # Podman asks http and tcp probes with curl and nc, which the image lacks, and gives words to a shell unquoted.
        for probe in ("readinessProbe", "livenessProbe"):
            for word in self.container[probe]["exec"]["command"]:
                self.assertRegex(word, r"^[\w/.-]+$")
        # Without it podman 4.3 crashes.
        (secret,) = [volume["secret"] for volume in self.pod["volumes"] if "secret" in volume]
        self.assertIs(secret["optional"], False)

    def test_one_daemon_has_the_data(self):
        self.assertEqual(self.deployment["replicas"], 1)
        self.assertEqual(self.deployment["strategy"], {"type": "Recreate"})
        self.assertEqual(self.deployment["selector"]["matchLabels"], self.deployment["template"]["metadata"]["labels"])

    def test_names_agree(self):
        volumes = {volume["name"]: volume for volume in self.pod["volumes"]}
        mounts = {mount["name"]: mount["mountPath"] for mount in self.container["volumeMounts"]}
        self.assertEqual(set(volumes), set(mounts))
        name = self.claim["metadata"]["name"]
        self.assertEqual(volumes["data"]["persistentVolumeClaim"]["claimName"], name)
        self.assertEqual(volumes["settings"]["configMap"]["name"], self.objects["ConfigMap"]["metadata"]["name"])
        self.assertIn(f"create secret tls {volumes['tls']['secret']['secretName']} ", TEXT)
        self.assertEqual(self.settings["data"], mounts["data"])
        self.assertEqual(self.settings["inputs"], [mounts["inputs"]])
        for key in ("tls-certificate", "tls-key"):
            self.assertEqual(os.path.dirname(self.settings[key]), mounts["tls"])
        self.assertEqual(self.container["livenessProbe"]["exec"]["command"][1], f"{mounts['settings']}/live.sh")
        metrics = self.settings["metrics"].replace(":", "/")
        self.assertIn(f"/dev/tcp/{metrics} ", self.objects["ConfigMap"]["data"]["live.sh"])
        self.assertEqual(self.container["args"], ["--config", f"{mounts['settings']}/tesserad.toml"])
        port = self.container["ports"][0]["containerPort"]
        self.assertEqual(self.settings["listen"], f"0.0.0.0:{port}")

    def test_the_keys_are_those_of_the_sample(self):
        sample = set(re.findall(r"(?m)^# ([a-z-]+) = ", (SOURCE / "config/tesserad.toml").read_text()))
        self.assertEqual(set(self.settings) - sample, set())

    def test_it_runs_without_rights(self):
        user = self.pod["securityContext"]["runAsUser"]
        self.assertTrue(self.pod["securityContext"]["runAsNonRoot"])
        self.assertEqual(self.container["securityContext"],
                         {"allowPrivilegeEscalation": False, "readOnlyRootFilesystem": True, "capabilities": {"drop": ["ALL"]}})
        self.assertIn(f"\nUSER {user}:{user}\n", (SOURCE / "deploy/Containerfile").read_text())
        annotations = self.claim["metadata"]["annotations"]
        self.assertEqual(annotations["volume.podman.io/uid"], str(user))

    def test_it_has_a_bound_on_memory_and_no_way_without_tls(self):
        self.assertIn("memory", self.container["resources"]["limits"])
        self.assertNotIn("insecure", TEXT)


class Cluster(unittest.TestCase):
    """The nodes beside it."""

    @classmethod
    def setUpClass(cls):
        cls.text = (SOURCE / "deploy/kubernetes-cluster.yaml").read_text()
        documents = list(yaml.safe_load_all(cls.text))
        cls.services = {document["metadata"]["name"]: document["spec"] for document in documents if document["kind"] == "Service"}
        (cls.set,) = [document["spec"] for document in documents if document["kind"] == "StatefulSet"]
        cls.pod = cls.set["template"]["spec"]
        (cls.container,) = cls.pod["containers"]
        cls.options = dict(zip(cls.container["args"][::2], cls.container["args"][1::2]))

    def test_the_options_are_the_daemons(self):
        sample = set(re.findall(r"(?m)^# ([a-z-]+) = ", (SOURCE / "config/tesserad.toml").read_text()))
        self.assertEqual({option.removeprefix("--") for option in self.options} - sample, set())
        commented = set(re.findall(r"(?m)^#   ([a-z-]+) = ", self.text))
        self.assertEqual(commented, {"cluster", "advertise", "certs", "roles"})
        self.assertEqual(commented - sample, set())

    def test_names_agree(self):
        labels = self.set["template"]["metadata"]["labels"]
        self.assertEqual(self.set["selector"]["matchLabels"], labels)
        self.assertEqual(self.services[self.set["serviceName"]]["selector"], labels)
        self.assertTrue(self.services[self.set["serviceName"]]["publishNotReadyAddresses"])
        deployment = next(document for document in yaml.safe_load_all(TEXT) if document["kind"] == "Deployment")
        host, port = self.options["--join"].split(":")
        self.assertEqual(self.services[host]["selector"], deployment["spec"]["template"]["metadata"]["labels"])
        self.assertEqual(self.options["--advertise"], f"$(POD).{self.set['serviceName']}:{port}")
        mounts = {mount["name"]: mount["mountPath"] for mount in self.container["volumeMounts"]}
        volumes = {volume["name"]: volume for volume in self.pod["volumes"]}
        self.assertEqual(set(mounts), set(volumes))
        for name in ("data", "scratch", "certs"):
            self.assertEqual(self.options[f"--{name}"], mounts[name])
        self.assertEqual(volumes["data"]["persistentVolumeClaim"]["claimName"], yaml.safe_load(DATA)["metadata"]["name"])
        self.assertIn(f"create secret generic {volumes['certs']['secret']['secretName']} ", self.text)
        self.assertEqual(volumes["certs"]["secret"]["defaultMode"], 0o440)

    def test_a_node_has_the_time_to_hand_its_tiles_over(self):
        drain = re.search(r'(?m)^# drain-timeout = "(\d+)s"$', (SOURCE / "config/tesserad.toml").read_text())
        self.assertGreater(self.pod["terminationGracePeriodSeconds"], int(drain[1]))

    def test_its_health_is_asked_where_it_is_told(self):
        ports = {port["name"]: port["containerPort"] for port in self.container["ports"]}
        self.assertEqual(self.options["--metrics"], f"0.0.0.0:{ports['metrics']}")
        for probe, path in (("readinessProbe", "/readyz"), ("livenessProbe", "/livez")):
            self.assertEqual(self.container[probe]["httpGet"], {"path": path, "port": "metrics"})

    def test_it_runs_without_rights(self):
        self.assertTrue(self.pod["securityContext"]["runAsNonRoot"])
        self.assertEqual(self.container["securityContext"],
                         {"allowPrivilegeEscalation": False, "readOnlyRootFilesystem": True, "capabilities": {"drop": ["ALL"]}})
        self.assertIn("memory", self.container["resources"]["limits"])


if __name__ == "__main__":
    unittest.main()
