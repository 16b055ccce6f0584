#!/usr/bin/env bash
# Everything a developer does, each with all its set-up and nothing twice: ./tessera.sh help
set -euo pipefail
cd "$(dirname "$0")"

build_folder=build/release
jobs=$(nproc)

usage() {
  cat <<'TEXT'
./tessera.sh build            the programs, some 8 minutes on two cores: build/release/src/front/apps/tessera, .../src/front/daemon/tesserad
./tessera.sh all              everything, some 20 minutes: also the libraries, the Python package, tests and benchmarks
./tessera.sh demo             triangulate the bundled IGN block, verify it, make its surface, draw both: demo-out/surface.png
./tessera.sh serve [ARGS]     a daemon with the bundled block, on the loopback; its data: serve-data/ (ARGS go to tesserad)
./tessera.sh site             the documents as a site, with search: build/site/index.html; nothing comes from the network
./tessera.sh test [ARGS]      build and run the tests but for the long ones of tests/nightly_tests.txt; with ARGS for ctest,
                              those that ARGS choose (-R splay); the last line says what was skipped, and why
./tessera.sh nightly          the long tests; and the engine against CGAL: every set x partition x tiles x threads (many hours)
./tessera.sh wheel [PYTHON...] a self-contained wheel in build/release, for Debian's Python and for those that you name
./tessera.sh tidy [REVISION]  clang-tidy over the sources; with a revision, over those that have changed since
./tessera.sh format           clang-format over the sources
./tessera.sh deps [PARTS]     install what is missing (Debian 12): build, test, nightly, demo, clang, qgis, site
TEXT
}

# Builds these targets.
build() {
  deploy/install-deps.sh build
  local launcher=()
  command -v ccache >/dev/null && launcher=(-DCMAKE_CXX_COMPILER_LAUNCHER=ccache -DCMAKE_C_COMPILER_LAUNCHER=ccache)
  [[ -f $build_folder/build.ninja ]] || cmake --preset release "${launcher[@]}"
  cmake --build $build_folder -j "$jobs" --target "$@"
}

demo() {
  deploy/install-deps.sh build demo
  build tessera_command
  local out=demo-out
  mkdir -p $out
  local tessera=$build_folder/src/front/apps/tessera
  $tessera triangulate 'tests/data/clouds/ign_770*.laz' -o $out/result --tiles 12 --attributes all --overwrite
  $tessera verify $out/result
  xvfb-run -a /usr/bin/python3 scripts/draw_tiles.py $out/result $out/tiles.png
  $tessera surface $out/result -o $out/surface/ --format vtu --overwrite
  xvfb-run -a /usr/bin/python3 scripts/draw_surface.py $out/surface $out/surface.png
  echo "pictures: $out/surface.png, $out/tiles.png    report: $out/result/report.html"
}

serve() {
  deploy/install-deps.sh build
  build tesserad tessera_command
  exec $build_folder/src/front/daemon/tesserad --data serve-data --inputs data/ign --print-token "$@"
}

site() {
  deploy/install-deps.sh build site
  build tesserad manual
  scripts/site/make_site.py $build_folder build/site
}

# One wheel for each Python. Python 3.12 and later need pybind11 2.12, which the environment variable pybind11_ROOT names.
wheel() {
  build tessera_python tessera_viewer
  /usr/bin/python3 python/backend/tessera_build.py $build_folder $build_folder "$@"
}

sources() { git ls-files 'src/*.cc' 'actors/*.cc' 'python/*.cc' 'tests/*.cc' 'bench/*.cc'; }

# CAF's and Asio's templates alone give thousands of findings: what includes them is left out.
tidy() {
  local files
  [[ -z ${1:-} ]] || git rev-parse --quiet --verify "$1^{commit}" > /dev/null || { echo "tidy: there is no revision $1" >&2; return 2; }
  # grep says with status 1 that it has found nothing.
  files=$(sources | grep -v -E '^(tests|bench)/' | changed_since "${1:-}" | xargs -r grep -L -E 'caf/|boost/asio|actors/') || (($? == 1 || $? == 123))
  [[ -n $files ]] || { echo "clang-tidy: no source has changed"; return; }
  deploy/install-deps.sh build test clang
  build all
  # Each source by itself, and without precompiled headers, which Clang does not read. What is generated is in the build.
  cmake --preset release -B build/tidy -DTESSERA_UNITY=OFF -DTESSERA_PRECOMPILED=OFF > /dev/null
  sed -i "s#/build/tidy/#/$build_folder/#g" build/tidy/compile_commands.json
  xargs -P "$jobs" -n 4 clang-tidy -p build/tidy --quiet --warnings-as-errors='*' --extra-arg=-Wno-unknown-warning-option <<< "$files"
}

# Of the files in its input, those that have changed since a revision; all without one.
changed_since() {
  [[ -n $1 ]] || { cat; return; }
  local changed
  changed=$(git diff --name-only --diff-filter=d "$1")
  grep -F -x -f <(printf '%s\n' "$changed") || (($? == 1))
}

# A regular expression for the names of the tests that take too long for every change.
nightly_tests() { grep -v '^#' tests/nightly_tests.txt | paste -sd '|'; }

# Its last line tells what was skipped.
run_tests() {
  deploy/install-deps.sh
  build all
  (($# > 0)) || set -- -E "$(nightly_tests)"
  local status=0
  ctest --test-dir $build_folder --output-on-failure -j $((jobs + 1)) "$@" || status=$?
  scripts/skipped_tests.py $build_folder/Testing/Temporary/LastTest.log
  return $status
}

nightly() {
  deploy/install-deps.sh build test nightly qgis
  run_tests -R "$(nightly_tests)"
  build engine_product
  cmake --build $build_folder --target nightly
  # Each source includes what it uses, also where no header is precompiled.
  cmake --preset release -B build/plain -DTESSERA_PRECOMPILED=OFF -DTESSERA_UNITY=OFF
  cmake --build build/plain -j "$jobs"
}

case "${1:-help}" in
  build) build tessera_command tesserad ;;
  all) build all ;;
  demo) demo ;;
  serve) shift; serve "$@" ;;
  site) site ;;
  test) shift; run_tests "$@" ;;
  nightly) nightly ;;
  wheel) shift; wheel "$@" ;;
  tidy) shift; tidy "$@" ;;
  format) deploy/install-deps.sh clang; git ls-files '*.cc' '*.h' | xargs clang-format -i ;;
  deps) shift; deploy/install-deps.sh "$@" ;;
  help|-h|--help) usage ;;
  *) usage >&2; exit 2 ;;
esac
