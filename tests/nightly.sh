#!/bin/bash
# All that takes too long for every change, one after the other, with figures at the end; status 1 when anything failed.
#
#   tests/nightly.sh [BUILD] [FUZZ_BUILD]       default: build/release, build/fuzz; fuzzing is left out where there is no such build
#
# Some five hours on two processors of 2.5 GHz: two of fuzzing (13 targets), one and a half of the seeds (5 to 10 ms each), three quarters of an
# hour of kills (22 s each); and the models. It prints how long each part took. A part alone: PARTS="kills seeds".
# Shorter, to try it: KILLS=2 COORDINATOR_KILLS=1 SEEDS=1400 FUZZ_SECONDS=5 POINTS_LARGE=200k.
# shellcheck disable=SC2317  # functions are called by part
set -uo pipefail
source=$(cd "$(dirname "$0")/.." && pwd)
build=$(realpath "${1:-$source/build/release}") fuzz=${2:-$source/build/fuzz}
parts=${PARTS:-kills jobs machines pauses hostile network slow seeds models neighbours fuzz large}
seeds=${SEEDS:-300000} fuzz_seconds=${FUZZ_SECONDS:-600} points=${POINTS_LARGE:-10M}
export KILLS=${KILLS:-100} COORDINATOR_KILLS=${COORDINATOR_KILLS:-30} SEED=${SEED:-$(date +%Y%m%d)}
export TESSERA=$build/src/front/apps/tessera TESSERAD=$build/src/front/daemon/tesserad IGN=$source/data/ign PYTHONDONTWRITEBYTECODE=1
scratch=$(mktemp -d "${TMPDIR:-/tmp}/tessera-nightly-XXXXXX")
trap 'rm -rf "$scratch"' EXIT
figures=() failed=0

figures_of() { { grep '^figures:' "$1" || grep -E '^(Ran|[0-9,]+ seeds)' "$1"; } | tail -n 1; }

# NAME COMMAND...: its output is shown when it fails.
part() {
  local name=$1 begin=$SECONDS log=$scratch/$1.log outcome=passed
  shift
  "$@" > "$log" 2>&1 || { outcome=FAILED; failed=1; tail -n 50 "$log"; }
  figures+=("$(printf '%-32s %-7s %6d s  %s' "$name" "$outcome" $((SECONDS - begin)) "$(figures_of "$log")")")
  echo "${figures[-1]}"
}
apps_test() { (cd "$source/tests/apps" && /usr/bin/python3 -m unittest -v "$1"); }
daemon_test() { (cd "$source/tests/daemon" && /usr/bin/python3 -m unittest -v "$1"); }

# Both dimensions, seven kinds of cloud, two partitions, two to four nodes, all that may go wrong.
run_seeds() {
  local faults=$1 share=$((seeds / 28 / $2)) first=$((SEED % 1000000 * 1000)) kind dim partition run=0 before=0
  for kind in lattice planes uniform clusters slab corners jitter; do
    for dim in 2 3; do
      for partition in kdtree random; do
        first=$((first + share)) run=$((run + 1))
        "$TESSERA" harness --quiet --kind "$kind" --dim "$dim" -n 36 --tiles 7 --partition "$partition" --nodes $((2 + run % 3)) \
          --faults "$faults" --seeds "$first..$((first + share - 1))" || return 1
        before=$((before + share))
      done
    done
  done
  echo "figures: $before seeds from $((SEED % 1000000 * 1000)), $faults"
}

fuzz_all() {
  local target name
  for target in "$fuzz"/tests/fuzz/fuzz_*; do
    [ -x "$target" ] || continue
    name=${target##*fuzz_}
    mkdir -p "$scratch/found-$name"
    local corpus=("$scratch/found-$name")
    [ -d "$source/tests/fuzz/corpus/$name" ] && corpus+=("$source/tests/fuzz/corpus/$name")
    "$target" -max_total_time="$fuzz_seconds" -malloc_limit_mb=160 -timeout=60 -max_len=8192 -print_final_stats=1 \
      -artifact_prefix="$scratch/found-$name/" "${corpus[@]}" || return 1
  done
  echo "figures: $fuzz_seconds s a target"
}

large() {
  "$TESSERA" generate uniform -n "$points" -o "$scratch/large.npy" --quiet &&
    "$TESSERA" triangulate "$scratch/large.npy" -o "$scratch/large" --memory 2G --quiet &&
    /usr/bin/time -f 'figures: verified in %e s, %M KiB' "$TESSERA" verify "$scratch/large" --quiet
}

for name in $parts; do
  case $name in
    kills)
      POINTS=$points TILES=64 MEMORY=3G A_JOB=4 part kills-of-nodes daemon_test kills_test.Kills.test_nodes
      POINTS=$points TILES=64 MEMORY=3G A_JOB=3 part kills-of-the-coordinator daemon_test kills_test.Kills.test_the_coordinator
      ;;
    jobs)
      JOBS=200 KILLS=20 part jobs-and-kills-of-the-daemon daemon_test storm_test
      LIVE_KILLS=200 part kills-of-live-results daemon_test live_test.Killed
      ;;
    machines) ROUNDS=50 ONE_MACHINE=$build/tests/daemon/libone_machine.so part machines daemon_test two_machines_test ;;
    pauses) ROLLING_POINTS=$points PAUSES_S=12,15,25 part pauses-of-the-coordinator daemon_test pauses_test ;;
    hostile) HOSTILE_S=${HOSTILE_S:-1800} part hostile-peer daemon_test hostile_test ;;
    network) part network daemon_test network_test ;;
    slow) POINTS=4M MEMORY=1G TILES=64 SLOW_FIGURES=1 part slow-node daemon_test slow_node_test ;;
    seeds)
      part seeds-all-faults run_seeds kill,pause,join,coordinator,leave,last,all 1
      part seeds-coordinator run_seeds coordinator 4
      part seeds-leave run_seeds leave,join 4
      part seeds-leave-coordinator run_seeds leave,join,coordinator 4
      CHANGES_SEED=$((SEED % 1000000 * 1000000)) CHANGES_WORLDS=$seeds part seeds-changes "$build/tests/tile/changes_test" '--gtest_filter=Changes.*'
      SECOND_STAGE_SEEDS=$((seeds / 15)) part seeds-second-stage "$build/tests/exchange/second_stage_test" '--gtest_filter=SecondStage.*'
      SURFACE_STEPS_SEEDS=$((seeds / 15)) part seeds-surface-steps "$build/tests/surface/surface_steps_test" '--gtest_filter=SurfaceSteps.*'
      UPDATE_EXCHANGE_SEEDS=$((seeds / 15)) part seeds-update-exchange "$build/tests/update/update_exchange_test" '--gtest_filter=ChangeOnActors.*'
      ;;
    models) part models /usr/bin/python3 "$source/tests/model/run.py" --full ;;
    neighbours)
      MORE_CLOUDS=${MORE_CLOUDS:-$source/tests/data/clouds} MORE_NEIGHBOURS=1 part neighbours apps_test cli_neighbours_test.Neighbours.test_all_files_of_a_folder_that_adjoin
      ;;
    fuzz) if [ -d "$fuzz/tests/fuzz" ]; then part fuzz fuzz_all; else echo "fuzz: no build in $fuzz"; fi ;;
    large) part large-cloud large ;;
    *) echo "there is no part '$name'" >&2; exit 2 ;;
  esac
done
echo
printf '%s\n' "${figures[@]}"
exit "$failed"
