#!/usr/bin/env bash
# Makes a self-contained wheel, and uses it in a fresh system of a version of Debian, in which nothing of Tessera's is:
#   deploy/try-wheel.sh [SUITE PYTHON]      default: bookworm /usr/bin/python3
#   deploy/try-wheel.sh trixie python3.13   another glibc (2.41), another Python: PYTHON is one here, with its C headers
# pip takes the wheel only if its tag suits. Needs debootstrap, and root for chroot.
set -euo pipefail
cd "$(dirname "$0")/.."
suite=${1:-bookworm}
python=${2:-/usr/bin/python3}
build=${TESSERA_BUILD:-build/release}
[[ $(id -u) -eq 0 ]] || { echo "try-wheel: run as root, because debootstrap and chroot need it" >&2; exit 1; }
command -v debootstrap > /dev/null || { echo "try-wheel: debootstrap is missing: apt install debootstrap" >&2; exit 1; }

held=$(mktemp -d)
trap 'rm -rf "$held"' EXIT
root=$held/root
debootstrap --variant=minbase --include=ca-certificates,python3-numpy,python3-pip,pybind11-dev "$suite" "$root" > "$held/log" 2>&1 ||
  { tail -3 "$held/log" >&2; exit 1; }

# The headers of pybind11 alone, without those of the other system's C library.
mkdir -p "$held"/pybind11/{include,share/cmake} "$root/wheel"
cp -r "$root/usr/include/pybind11" "$held/pybind11/include"
cp -r "$root"/usr/*/cmake/pybind11 "$held/pybind11/share/cmake"
export pybind11_ROOT=$held/pybind11
others=("$python")
[[ $python == /usr/bin/python3 ]] && others=()
# The last line names the last wheel; the first is for Debian's Python.
wheel=$(/usr/bin/python3 python/backend/tessera_build.py "$build" "$root/wheel" "${others[@]}" 2> "$held/log" | tail -1) ||
  { tail -20 "$held/log" >&2; exit 1; }

cp deploy/try_wheel.py "$root/wheel"
within() { env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin LANG=C.UTF-8 chroot "$root" "$@"; }
break=()
within pip install --help | grep -q -e --break-system-packages && break=(--break-system-packages)
within pip install --quiet --no-index --no-deps "${break[@]}" --root-user-action=ignore "/wheel/$(basename "$wheel")"
within python3 /wheel/try_wheel.py
gdal=$(within apt-cache pkgnames libgdal | grep -x 'libgdal[0-9]*' | tail -1)
within env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends "$gdal" > "$held/log" 2>&1 ||
  { tail -3 "$held/log" >&2; exit 1; }
within python3 /wheel/try_wheel.py gdal
echo "with $gdal: passed"
