#!/bin/bash
# Whether two builds of tessera write the same files: tiles, master file and duplicates byte for byte, and all sums and
# digests of the manifest, over runs of every partition, dimension, format, with attributes, little memory, many tiles.
#   scripts/compare_runs.sh BEFORE AFTER
# Prints what differs, and fails then.
set -u
[[ $# -eq 2 ]] || { echo "usage: scripts/compare_runs.sh BEFORE AFTER (two programs tessera)" >&2; exit 2; }
before=$1
after=$2
data=$(cd "$(dirname "$0")/../tests/data/clouds" && pwd)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
runs=0
wrong=0

sums() { grep -oE '"(digest2|xxh3|triangulation.pvtu|duplicates.bin)": *"[0-9a-f]+"' "$1/manifest.json"; }

compare() {
  local name="$*"
  runs=$((runs + 1))
  for build in before after; do
    if ! "${!build}" triangulate "$@" -o "$work/$build" > "$work/$build.log" 2>&1; then
      echo "$build, $name: $(tail -n 1 "$work/$build.log")"
      wrong=$((wrong + 1))
      rm -rf "$work/before" "$work/after"
      return
    fi
  done
  if ! diff -rq -x manifest.json -x report.html "$work/before" "$work/after" ||
    ! diff <(sums "$work/before") <(sums "$work/after"); then
    echo "the files differ: $name"
    wrong=$((wrong + 1))
  fi
  rm -rf "$work/before" "$work/after"
}

ign=("$data/ign_77050_627755.laz" "$data/ign_77050_627760.laz")
for dim in 2 3; do
  for partition in kdtree octree grid random; do
    compare "${ign[0]}" --dim $dim --partition $partition --tiles 9
  done
  compare "$data/autzen_trim.laz" --dim $dim
  compare "$data/autzen_trim.laz" --dim $dim --tiles 13 --threads 1
  compare "${ign[@]}" --dim $dim --tiles 60 --threads 2
  compare "${ign[@]}" --dim $dim --tiles 40 --memory 40M
done
compare "${ign[@]}" --dim 2 --tiles 300 --threads 2
compare "$data/liblas_certainty3d.las" --dim 2 --tiles 5 --attributes all
compare "$data/lone_star_begin.laz" --tiles 7 --no-neighbors
for file in ellipsoid.copc.laz csf_sample_begin.ply pdal_mvk_thin.las velodyne_400_begin.csv pdal_mesh.ply \
  laspy_grid_begin.las lion_takanawa_part.copc.laz; do
  compare "$data/$file" --tiles 4
done
compare "$data/cities_begin.csv" --dim 2 --tiles 3
for keep in lowest highest last; do
  compare "$data/isprs_CSite2_begin.ply" --dim 2 --tiles 6 --keep $keep
done
echo "$runs runs; the files of $wrong differ, or were not made"
[ $wrong = 0 ]
