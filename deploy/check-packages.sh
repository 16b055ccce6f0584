#!/usr/bin/env bash
# Run by try-packages.sh in the clean system: installs /packages/*.deb, uses them, removes them. /input holds points.
set -euo pipefail
export DEBIAN_FRONTEND=noninteractive LC_ALL=C.UTF-8
say() { echo "check-packages: $*"; }
contains() { grep -q -- "$1" || { say "expected: $1"; exit 1; }; }

apt-get update -qq
apt-get install -y -qq --no-install-recommends /packages/*.deb libgdal32 libcurl4 man-db bash-completion g++ pkg-config >/dev/null
say "installed: $(dpkg-query -W -f '${db:Status-Abbrev} ${Package}\n' '*tessera*' | awk '$1 == "ii" { print $2 }' | xargs)"

tessera --version
cd "$(mktemp -d)"
tessera triangulate /input/*.las -o result --tiles 4 --quiet
tessera verify result | contains "is the Delaunay triangulation"
say "a result is made and proved"

MANPAGER=cat man tessera | contains "triangulate"
MANPAGER=cat man tessera-triangulate | contains "--memory"
say "man pages are there"
bash -c '. /usr/share/bash-completion/bash_completion; _completion_loader tessera; complete -p tessera' | contains "tessera"
say "the shell completes"

python3 - <<'PYTHON'
import numpy
import tessera
cube = numpy.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], dtype=float)
assert len(tessera.Delaunay(cube).simplices) in (5, 6)
assert tessera.__file__.startswith("/usr/lib/python3/dist-packages/"), tessera.__file__
PYTHON
say "Python imports it"

cat > program.cc <<'CPLUSPLUS'
#include <tessera/tessera.h>

#include <cstdio>
int main() { std::puts(tessera::library_version()); }
CPLUSPLUS
read -r -a flags < <(pkg-config --cflags --libs tessera)
g++ program.cc "${flags[@]}" -o program
./program
say "C++ finds headers and library"

if command -v tesserad >/dev/null; then
  tesserad --version
  MANPAGER=cat man tesserad | contains "SIGHUP"
  bash -c '. /usr/share/bash-completion/completions/tesserad; COMP_WORDS=(tesserad --me) COMP_CWORD=1; _tesserad
    echo "${COMPREPLY[@]}"' | contains "--metrics --memory"
  [[ -f /lib/systemd/system/tesserad.service && -f /etc/tessera/tesserad.toml ]]
  # With the installed configuration, and ports of its own: a chroot shares the network. Asked until it is ready or gone.
  metrics=127.0.0.1:17071
  tesserad --data "$PWD/data" --config /etc/tessera/tesserad.toml --listen 127.0.0.1:17070 --metrics $metrics \
    > daemon.log 2>&1 &
  daemon=$!
  for ((tries = 0; tries < 100; ++tries)); do
    kill -0 "$daemon" || { cat daemon.log; exit 1; }
    tesserad health --metrics $metrics && break
    sleep 0.2
  done
  tesserad health --metrics $metrics
  kill -TERM "$daemon"
  wait "$daemon"
  say "the daemon starts, is ready and stops"
fi

# shellcheck disable=SC2046
apt-get purge -y -qq $(dpkg-query -W -f '${Package} ' '*tessera*') >/dev/null
left=$(find /usr /etc /lib -xdev -name '*tessera*')
[[ -z "$left" ]] || { say "left after removal: $left"; exit 1; }
say "nothing is left after removal"
