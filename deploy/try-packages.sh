#!/usr/bin/env bash
# Builds the Debian packages, checks them with lintian, installs them in a clean Debian 12 and uses them there:
#   deploy/try-packages.sh [MIRROR]      default: http://deb.debian.org/debian
# Needs mmdebstrap and lintian, and rights to make a chroot. Leaves the packages in build/package/, and nothing else.
set -euo pipefail
cd "$(dirname "$0")/.."
mirror=${1:-http://deb.debian.org/debian}
build=build/package

launcher=()
command -v ccache >/dev/null && launcher=(-DCMAKE_CXX_COMPILER_LAUNCHER=ccache -DCMAKE_C_COMPILER_LAUNCHER=ccache)
cmake --preset package "${launcher[@]}"
cmake --build "$build" -j "$(nproc)"
rm -f "$build"/*.deb
(cd "$build" && cpack)

# CPack gives the library maintainer scripts that call ldconfig, beside the trigger.
lintian --allow-root --fail-on error,warning --suppress-tags maintscript-calls-ldconfig "$build"/*.deb

# --format=null: the tree is gone at the end. The hooks run where the new system is $1.
export PACKAGES=$PWD/$build SOURCE=$PWD
mmdebstrap --variant=apt --format=null --include=ca-certificates \
  --customize-hook='mkdir "$1/packages" "$1/input" && cp "$PACKAGES"/*.deb "$1/packages"' \
  --customize-hook='cp "$SOURCE"/deploy/check-packages.sh "$SOURCE"/data/ign/ign_77050_627755.las "$1/input"' \
  --customize-hook='chroot "$1" bash /input/check-packages.sh' \
  bookworm /dev/null "deb $mirror bookworm main"
echo "try-packages: passed"
