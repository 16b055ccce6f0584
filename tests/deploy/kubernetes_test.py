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


def check_rights(case, pod):
    """That a namespace where Kubernetes enforces "restricted" takes the pod, and that no start opens its files to the group."""
    context = dict(pod["securityContext"])
    case.assertEqual(context.pop("seccompProfile"), {"type": "RuntimeDefault"})
    case.assertEqual(context.pop("fsGroupChangePolicy"), "OnRootMismatch")
    case.assertIs(context.pop("runAsNonRoot"), True)
    case.assertEqual(set(context), {"runAsUser", "runAsGroup", "fsGroup"})
    case.assertEqual(len(set(context.values())), 1)
    case.assertIs(pod["automountServiceAccountToken"], False)
    for container in pod["containers"]:
        case.assertEqual(container["securityContext"],
                         {"allowPrivilegeEscalation": False, "readOnlyRootFilesystem": True, "capabilities": {"drop": ["ALL"]}})
        case.assertIn("memory", container["resources"]["limits"])
    for volume in pod["volumes"]:
        if "hostPath" in volume:
            case.assertEqual(volume["hostPath"]["type"], "Directory")


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
        self.assertEqual(secret["defaultMode"], 0o440)  # a key that others can read is refused

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
        check_rights(self, self.pod)
        user = self.pod["securityContext"]["runAsUser"]
        self.assertIn(f"\nUSER {user}:{user}\n", (SOURCE / "deploy/Containerfile").read_text())
        annotations = self.claim["metadata"]["annotations"]
        self.assertEqual(annotations["volume.podman.io/uid"], str(user))

    def test_it_has_a_bound_on_memory_and_no_way_without_tls(self):
        self.assertIn("memory", self.container["resources"]["limits"])
        self.assertNotIn("insecure", TEXT)


class Cluster(unittest.TestCase):
    """The coordinator and its nodes, in place of the one daemon."""

    @classmethod
    def setUpClass(cls):
        cls.text = (SOURCE / "deploy/kubernetes-cluster.yaml").read_text()
        cls.objects = {(document["kind"], document["metadata"]["name"]): document for document in yaml.safe_load_all(cls.text)}
        cls.coordinator = cls.objects["StatefulSet", "tesserad-coordinator"]["spec"]
        cls.nodes = cls.objects["StatefulSet", "tesserad-node"]["spec"]
        cls.pods = [held["template"]["spec"] for held in (cls.coordinator, cls.nodes)]
        (cls.container,) = cls.pods[1]["containers"]
        cls.options = dict(zip(cls.container["args"][::2], cls.container["args"][1::2]))
        cls.settings = tomllib.loads(cls.objects["ConfigMap", "tesserad-coordinator"]["data"]["tesserad.toml"])

    def service(self, name):
        return self.objects["Service", name]["spec"]

    def test_the_options_are_the_daemons(self):
        sample = set(re.findall(r"(?m)^# ([a-z-]+) = ", (SOURCE / "config/tesserad.toml").read_text()))
        self.assertEqual({option.removeprefix("--") for option in self.options} - sample, set())
        self.assertEqual(set(self.settings) - sample, set())
        self.assertEqual(self.settings["roles"], ["coordinator"])

    def test_there_is_one_coordinator_and_never_a_second_beside_one_that_cannot_be_reached(self):
        self.assertEqual(self.coordinator["replicas"], 1)
        self.assertEqual({kind for kind, _ in self.objects}, {"ConfigMap", "Service", "StatefulSet", "PodDisruptionBudget",
                                                              "NetworkPolicy"})

    def test_names_agree(self):
        for held in (self.coordinator, self.nodes):
            labels = held["template"]["metadata"]["labels"]
            self.assertEqual(held["selector"]["matchLabels"], labels)
            # Found also when it is not ready: a coordinator whose disk is full still has nodes.
            governing = self.service(held["serviceName"])
            self.assertEqual(governing["selector"], labels)
            self.assertEqual(governing["clusterIP"], "None")
            self.assertIs(governing["publishNotReadyAddresses"], True)
            pod = held["template"]["spec"]
            (container,) = pod["containers"]
            mounts = {mount["name"]: mount["mountPath"] for mount in container["volumeMounts"]}
            volumes = {volume["name"]: volume for volume in pod["volumes"]}
            self.assertEqual(set(mounts), set(volumes))
            given = self.settings if held is self.coordinator else {key[2:]: value for key, value in self.options.items()}
            self.assertEqual((given["data"], given["certs"]), (mounts["data"], mounts["certs"]))
            self.assertEqual(volumes["data"]["persistentVolumeClaim"]["claimName"], yaml.safe_load(DATA)["metadata"]["name"])
            self.assertIn(f"create secret generic {volumes['certs']['secret']['secretName']} ", self.text)
            self.assertEqual(volumes["certs"]["secret"]["defaultMode"], 0o440)
        self.assertEqual(self.options["--join"], self.settings["advertise"])
        host, port = self.options["--join"].split(":")
        self.assertEqual(host, self.coordinator["serviceName"])
        self.assertEqual(self.options["--advertise"], f"$(POD).{self.nodes['serviceName']}:{port}")
        # In a folder of its own: what is mounted belongs to root, and everybody may write to it.
        (mount,) = [mount["mountPath"] for mount in container["volumeMounts"] if mount["name"] == "scratch"]
        self.assertEqual(os.path.dirname(self.options["--scratch"]), mount)
        self.assertEqual(self.service("tesserad")["selector"], self.service(host)["selector"])

    def test_a_node_has_the_time_to_hand_its_tiles_over(self):
        drain = re.search(r'(?m)^# drain-timeout = "(\d+)s"$', (SOURCE / "config/tesserad.toml").read_text())
        self.assertGreater(self.pods[1]["terminationGracePeriodSeconds"], int(drain[1]))

    def test_machines_are_emptied_one_node_after_the_other(self):
        budget = self.objects["PodDisruptionBudget", "tesserad-node"]["spec"]
        self.assertEqual(budget["maxUnavailable"], 1)
        self.assertEqual(budget["selector"], self.nodes["selector"])

    def test_only_its_own_pods_may_call_the_cluster(self):
        policy = self.objects["NetworkPolicy", "tesserad"]["spec"]
        ours = {"matchExpressions": [{"key": "app", "operator": "In", "values": ["tesserad-coordinator", "tesserad-node"]}]}
        self.assertEqual(policy["podSelector"], ours)
        self.assertEqual(policy["policyTypes"], ["Ingress"])
        who = {port["port"]: rule.get("from") for rule in policy["ingress"] for port in rule["ports"]}
        self.assertEqual(set(who), {"cluster", "metrics", "https"})
        self.assertEqual(who["cluster"], [{"podSelector": ours}])
        self.assertEqual([list(one) for one in who["metrics"]], [["namespaceSelector"]])
        self.assertIsNone(who["https"])
        for pod in self.pods:
            (container,) = pod["containers"]
            self.assertLessEqual({port["name"] for port in container["ports"]}, set(who))

    def test_its_health_is_asked_where_it_is_told(self):
        for pod, metrics in zip(self.pods, (self.settings["metrics"], self.options["--metrics"])):
            (container,) = pod["containers"]
            ports = {port["name"]: port["containerPort"] for port in container["ports"]}
            self.assertEqual(metrics, f"0.0.0.0:{ports['metrics']}")
            for probe, path in (("readinessProbe", "/readyz"), ("livenessProbe", "/livez")):
                self.assertEqual(container[probe]["httpGet"], {"path": path, "port": "metrics"})

    def test_it_runs_without_rights(self):
        for pod in self.pods:
            check_rights(self, pod)
        self.assertNotIn("insecure", self.text)


if __name__ == "__main__":
    unittest.main()
