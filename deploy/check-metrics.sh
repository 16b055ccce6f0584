#!/usr/bin/env bash
# Has Prometheus's own tool judge the figures of a running daemon:
#   deploy/check-metrics.sh [ADDRESS]      default: 127.0.0.1:7071
# promtool is Debian's, of the package prometheus; where it is not installed, it is taken out of that package, which would
# bring a server and eleven more packages.
set -euo pipefail
address=${1:-127.0.0.1:7071}
tool=$(command -v promtool || true)
if [[ -z $tool ]]; then
  folder=$(mktemp -d)
  trap 'rm -rf "$folder"' EXIT
  (cd "$folder" && apt-get download -qq prometheus 2>/dev/null && dpkg -x prometheus_*.deb .)
  tool=$folder/usr/bin/promtool
fi
curl --silent --show-error --fail "http://$address/metrics" | "$tool" check metrics
echo "check-metrics: passed"
