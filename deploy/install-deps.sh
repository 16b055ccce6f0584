#!/usr/bin/env bash
# Installs what building, testing and the demo need on Debian 12. Quick and silent when nothing is missing.
set -euo pipefail

packages=(
  build-essential cmake ninja-build ccache mold pkg-config
  libcgal-dev libgmp-dev libmpfr-dev        # exact geometry
  libcaf-dev                                # actors
  libboost-dev                              # Outcome, Asio
  libprotobuf-dev protobuf-compiler
  libhdf5-dev zlib1g-dev libzstd-dev libxxhash-dev  # result files, compressed input
  libgdal-dev                               # GeoPackage, coordinate systems
  libcli11-dev libtomlplusplus-dev libspdlog-dev libfmt-dev nlohmann-json3-dev
  robin-map-dev libssl-dev
  libgtest-dev python3 python3-numpy
  pybind11-dev python3-dev python3-scipy    # the Python package, and what it is compared with
  gdal-bin python3-gdal python3-gmsh        # tests read exports back
  python3-vtk9 xvfb xauth                   # the demo's picture
)
# `./tessera.sh tidy` and the fuzz preset ask for these with --clang.
if [[ "${1:-}" == --clang ]]; then packages+=(clang clang-tidy clang-format libclang-rt-14-dev); fi

missing=()
for package in "${packages[@]}"; do
  status=$(dpkg-query -W -f '${db:Status-Status}' "$package" 2>/dev/null || true)
  [[ $status == installed ]] || missing+=("$package")
done
[[ ${#missing[@]} -eq 0 ]] && exit 0

as_root=()
if [[ $(id -u) -ne 0 ]]; then
  command -v sudo >/dev/null || { echo "install-deps: run as root, or install sudo; missing: ${missing[*]}" >&2; exit 1; }
  as_root=(sudo)
fi
echo "install-deps: installing ${missing[*]}"
"${as_root[@]}" apt-get update -qq
"${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends "${missing[@]}"
