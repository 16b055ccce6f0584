#!/usr/bin/env bash
# Installs what is missing on Debian 12, and never removes a package:
#   install-deps.sh [build] [test] [nightly] [demo] [clang] [qgis] [site]      default: build and test
# build: the command, the libraries; test: what the tests compare with; nightly: what only the long ones need; demo: its
# picture; clang: `./tessera.sh tidy`; qgis: the tests of the plugin; site: the documents as a site.
# Quick and silent when nothing is missing.
set -euo pipefail

build=(
  build-essential cmake ninja-build ccache mold pkg-config
  libcgal-dev libgmp-dev libmpfr-dev        # exact geometry
  libcaf-dev                                # actors
  libboost-dev                              # Outcome, Asio
  libprotobuf-dev protobuf-compiler
  libcurl4-openssl-dev                      # objects on other machines
  zlib1g-dev libzstd-dev libxxhash-dev libexpat1-dev  # result files, compressed input, E57
  libmeshoptimizer-dev                      # surfaces for viewers
  libhdf5-dev                               # snapshots of simulations
  libgdal-dev libproj-dev                   # GeoPackage, coordinate systems
  libcli11-dev libtomlplusplus-dev libspdlog-dev libfmt-dev nlohmann-json3-dev
  robin-map-dev libssl-dev libsystemd-dev prometheus-cpp-dev
  libgtest-dev python3 python3-numpy
  pybind11-dev python3-dev patchelf         # the Python package, and its wheel
  esbuild                                   # bundles the dashboard
)
test=(
  python3-scipy python3-pip                 # what the Python package is compared with, what installs it
  python3-pandas python3-joblib             # what its users bring along
  mkdocs mkdocs-material                    # make the site of documents
  mypy debootstrap                          # checks its types; makes systems in which the wheel is tried
  gdal-bin python3-gdal python3-gmsh python3-meshio  # read exports back
  python3-h5py python3-astropy              # write snapshots, read grids
  python3-jsonschema openssl wrk curl       # checks what the service answers; its certificates; its load
  nginx-light                               # serves objects
  systemd python3-yaml                      # judge the unit, read the manifest
  iproute2 iptables                         # networks of a test's own, that lose packets
  libfaketime python3-owslib                # sets clocks; a client of OGC API Processes
  strace                                    # shows what is opened
  libmaxflow-dev                            # what minimum cuts are compared with
  spin                                      # searches the models of the cluster
  clang-format                              # judges how sources look
  chromium chromium-driver python3-selenium node-typescript  # look at the dashboard, check its types
)
nightly=(radosgw ceph-mon ceph-osd           # a store of objects
  python3-yt)                               # reads tables of points
demo=(xvfb xauth)
site=(mkdocs mkdocs-material python3-yaml)
qgis=(qgis python3-qgis qgis-providers)
clang=(clang clang-tidy clang-format libclang-rt-14-dev)

installed() { [[ $(dpkg-query -W -f '${db:Status-Status}' "$1" 2>/dev/null || true) == installed ]]; }

# ParaView brings a VTK of its own, and Debian installs one of the two.
installed python3-paraview || { test+=(python3-vtk9); demo+=(python3-vtk9); }

# Fetches the packages of the dashboard's viewer; who has Node.js from elsewhere has it with that.
command -v npm >/dev/null || build+=(npm)

[[ $# -gt 0 ]] || set -- build test
packages=()
for part in "$@"; do
  case "$part" in
    build | test | nightly | demo | clang | qgis | site) declare -n chosen=$part; packages+=("${chosen[@]}") ;;
    *) echo "install-deps: '$part' is not a part; the parts are build, test, nightly, demo, clang, qgis and site" >&2; exit 2 ;;
  esac
done

missing=()
for package in "${packages[@]}"; do
  installed "$package" || missing+=("$package")
done
[[ ${#missing[@]} -eq 0 ]] && exit 0

as_root=()
if [[ $(id -u) -ne 0 ]]; then
  command -v sudo >/dev/null || { echo "install-deps: run as root, or install sudo; missing: ${missing[*]}" >&2; exit 1; }
  as_root=(sudo)
fi
echo "install-deps: installing ${missing[*]}"
"${as_root[@]}" apt-get update -qq
"${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-remove --no-install-recommends "${missing[@]}"
