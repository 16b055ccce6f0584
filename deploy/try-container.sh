#!/usr/bin/env bash
# Builds the image of tesserad and tries it, alone and with the manifest for Kubernetes:
#   deploy/try-container.sh [BASE]
# BASE: the Debian 12 to begin with, default docker.io/library/debian:12-slim. Where no registry can be reached, the word
# `mmdebstrap` makes one of Debian's packages. Needs buildah, podman, catatonit, openssl, curl. Leaves the image
# localhost/tesserad; what else it makes is removed.
set -euo pipefail
cd "$(dirname "$0")/.."
base=${1:-docker.io/library/debian:12-slim}
folder=$(mktemp -d)
manifests=("$PWD/deploy/kubernetes-data.yaml" "$folder/kubernetes.yaml")
sed "s#path: /srv/lidar,#path: $PWD/data/ign,#" deploy/kubernetes.yaml > "${manifests[1]}"

clean() {
  podman rm -f -t 30 tesserad-try || true
  for manifest in "${manifests[@]}"; do podman kube down "$manifest" || true; done
  podman volume rm tesserad tesserad-tls tesserad-data tesserad-try || true
  podman secret rm tesserad-tls || true
  rm -rf "$folder"
} >/dev/null 2>&1
trap clean EXIT
[[ -z $(podman volume ls -q --filter name=tesserad) ]] ||
  { echo "try-container: podman has volumes of tesserad already, which this script would remove; remove or rename them first" >&2; exit 1; }

# Waits until the container's daemon is ready, and fails with its log when it ends instead.
wait_ready() {
  for ((tries = 0; tries < 150; ++tries)); do
    podman exec "$1" tesserad health >/dev/null 2>&1 && return
    [[ $(podman inspect "$1" --format '{{.State.Running}}') == true ]] || break
    sleep 0.2
  done
  podman logs "$1"
  return 1
}

if [[ $base == mmdebstrap ]]; then
  base=localhost/debian:12-slim
  if ! podman image exists $base; then
    # As Debian's images do: the file system of a layer need not outlive a power cut.
    mmdebstrap --variant=minbase --dpkgopt=force-unsafe-io --include=ca-certificates bookworm "$folder/root.tar"
    podman import -q "$folder/root.tar" $base
    rm "$folder/root.tar"
  fi
fi

# What has been compiled and fetched before need not be again.
mounted=()
mount_cache() { if [[ -d $1 ]]; then mounted+=(--volume "$1:/root/$2"); fi; }
mount_cache "${CCACHE_DIR:-$HOME/.cache/ccache}" .cache/ccache
mount_cache "${npm_config_cache:-$HOME/.npm}" .npm
buildah bud --format docker --network host --ignorefile deploy/containerignore "${mounted[@]}" --build-arg BASE="$base" \
  -f deploy/Containerfile -t localhost/tesserad:latest .
podman images localhost/tesserad --format 'try-container: {{.Repository}} {{.Size}}'

# Alone, on a network of its own, where it listens on loopback: nothing can be written but /data and /tmp.
podman run -d --name tesserad-try --network none --read-only --tmpfs /tmp --cap-drop all --security-opt no-new-privileges \
  -v tesserad-try:/data -v "$PWD/data/ign:/inputs:ro" localhost/tesserad >/dev/null
wait_ready tesserad-try
podman healthcheck run tesserad-try
[[ $(podman exec tesserad-try id -u) == 65532 ]]
podman exec tesserad-try tessera triangulate /inputs/ign_77050_627755.las -o /tmp/result --quiet
podman stop -t 90 tesserad-try >/dev/null
[[ $(podman inspect tesserad-try --format '{{.State.ExitCode}}') == 0 ]]
echo "try-container: alone: ready, healthy, works, stops"

# The manifest. podman 4.3 mounts the `data` of secrets undecoded, so that they must be stored as they are to be read.
openssl req -x509 -newkey ec -pkeyopt ec_paramgen_curve:prime256v1 -nodes -days 1 -subj /CN=localhost \
  -addext subjectAltName=DNS:localhost,IP:127.0.0.1 -keyout "$folder/key.pem" -out "$folder/certificate.pem" 2>/dev/null
indent() { sed 's/^/    /' "$1"; }
printf 'apiVersion: v1\nkind: Secret\nmetadata: {name: tesserad-tls}\ndata:\n  tls.crt: |\n%s\n  tls.key: |\n%s\n' \
  "$(indent "$folder/certificate.pem")" "$(indent "$folder/key.pem")" | podman secret create tesserad-tls - >/dev/null
# As Kubernetes makes it: podman 4.3 alone would let everybody read the key, which is refused. What is there keeps its rights.
make_tls_volume() {
  podman volume create tesserad-tls >/dev/null
  podman run --rm --user 0 --network none -v tesserad-tls:/tls -v "$folder:/from:ro" --entrypoint /bin/bash localhost/tesserad \
    -c 'install -m 0440 -g 65532 /from/key.pem /tls/tls.key && install -m 0444 /from/certificate.pem /tls/tls.crt'
}
make_tls_volume
for manifest in "${manifests[@]}"; do podman kube play "$manifest" >/dev/null; done
pod=tesserad-pod-0-tesserad
wait_ready $pod
podman exec $pod bash /etc/tessera/live.sh
curl --silent --show-error --cacert "$folder/certificate.pem" -o /dev/null https://localhost:7070/
before=$(podman exec $pod cat /data/tokens | sha256sum)

# As in an upgrade: down, and up again on the same data.
podman kube down "${manifests[1]}" >/dev/null
podman volume rm tesserad tesserad-tls >/dev/null
make_tls_volume
podman kube play "${manifests[1]}" >/dev/null
wait_ready $pod
[[ $(podman exec $pod cat /data/tokens | sha256sum) == "$before" ]]
echo "try-container: passed"
