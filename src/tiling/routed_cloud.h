// A cloud cut into tiles under a run folder: what the tile actors start from, and what --resume continues.
//
//   RUN/plan.json             everything below and its own checksum, written last: a run folder without it has not been
//                             routed
//   RUN/segments.bin          where the tiles' points are: Segments (40 bytes), of one tile after the other
//   RUN/points/, attributes/  the bundles (bundle.h)
#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <span>
#include <stop_token>
#include <string>
#include <utility>
#include <vector>

#include "src/base/attribute.h"
#include "src/base/duplicate_policy.h"
#include "src/base/files/mapped_file.h"
#include "src/base/files/names.h"
#include "src/base/point.h"
#include "src/base/progress.h"
#include "src/base/result.h"
#include "src/input/cloud/cloud.h"
#include "src/tiling/partition.h"
#include "src/tiling/shuffle_file.h"
#include "src/tiling/split_router.h"

namespace tessera {

struct InputFile {
  std::string path;
  std::uint64_t bytes = 0;
  std::int64_t modified_ns = 0;
  friend bool operator==(const InputFile&, const InputFile&) = default;
};

// Whether a tile's records have been found whole by this process.
struct TileChecked {
  std::atomic<bool> points = false, rows = false;
};

struct RoutedCloud {
  std::filesystem::path folder;
  int dimension = 3;
  DuplicatePolicy keep = DuplicatePolicy::first;  // of equal points
  Partition partition;
  std::vector<std::uint64_t> tile_points;  // by tile, duplicates included
  std::vector<Bounds> tile_bounds;         // by tile: of its points; empty for an empty tile
  std::vector<ShuffleFile> bundles;
  std::vector<Segment> segments;           // by tile
  std::vector<std::uint64_t> segment_end;  // by tile: of its segments
  CloudCounts counts;
  Bounds bounds;
  // What tiles know from the start (seed_finder.h), by tile. All of them know the lexicographically least point, and
  // d+1 points that span the space, so that no tile is ever flat (docs/design.md). Source indices are those of the
  // vertices that are kept.
  std::vector<Seed> seeds;
  std::vector<Attribute> schema;
  std::vector<InputFile> inputs;
  std::string crs;
  std::string options_key;  // equal keys = the same job; a resume with another key is refused
  // The checksum of its plan: what tells the run from all others, for it depends on where every point went and on its
  // bits. What tiles put on scratch says it.
  std::uint64_t seal = 0;
  // By tile; copies of this run share it. Without it, load_rows() checks the files whenever it is called.
  std::shared_ptr<std::vector<TileChecked>> checked;

  std::span<const Segment> segments_of(TileId tile) const {
    const std::uint64_t begin = tile.value == 0 ? 0 : segment_end[tile.value - 1];
    return std::span(segments).subspan(begin, segment_end[tile.value] - begin);
  }
  ShuffleFiles files() const { return {folder, bundles, row_bytes(schema)}; }
};

struct RouteOptions {
  PartitionKind kind = PartitionKind::kdtree;
  std::uint64_t max_points_per_tile = 0;  // used when `tiles` is 0
  std::uint32_t tiles = 0;
  std::uint64_t memory_bytes = std::uint64_t{1} << 30;  // for buffers and the sample
  std::string options_key = {};
};

// Streams the cloud into tile files. Refuses, with bad_input and one sentence, a cloud without points or whose points
// all lie on one hyperplane (it tells which). Tiles above the limit are split again, except by identical points.
// `router`: routes stretches of what is large enough to be cut; the run is the same without it, but for its bundles.
Result<RoutedCloud> route(const Cloud& cloud, const std::filesystem::path& folder, const RouteOptions& options,
                          Progress& progress, std::stop_token stop, SplitRouter* router = nullptr);

// Reads plan.json, checks it, and the files' sizes. What is in the files is checked when it is read. Error corrupt
// names the damaged file.
Result<RoutedCloud> open_run(const std::filesystem::path& folder);

// A tile's points as the kernel wants them: distinct, in Hilbert order within their bounds.
struct LoadedTile {
  std::vector<Point> points;
  std::vector<PointId> ids;                             // of equal points, that of the one that is kept
  std::vector<std::pair<PointId, PointId>> duplicates;  // (duplicate, kept), by ascending duplicate
  std::uint64_t other_heights = 0;                      // duplicates whose height is not that of the kept point
};
// Error corrupt when the file is not the one that was written.
Result<LoadedTile> load_tile(const RoutedCloud& run, TileId tile);
// The same from memory (regions, tests, harness): of equal points the lowest id, and heights are not looked at.
// REQUIRES: finite coordinates without -0.
LoadedTile order_points(std::span<const LocalPoint> points, int dimension);

// Points and attributes of a run's bundles as bytes in memory, each file opened once: the vertices of one tile are
// those of a dozen others, which share bundles.
class ShuffleFileMaps {
 public:
  // Refers to the run.
  explicit ShuffleFileMaps(const RoutedCloud& run) : run_(run) {}
  const RoutedCloud& run() const { return run_; }
  struct Maps {
    MappedFile points, rows;
  };
  // Error io; corrupt when a file is shorter than what was written. Valid as long as this.
  Result<const Maps*> of(std::uint32_t bundle);

 private:
  const RoutedCloud& run_;
  std::map<std::uint32_t, Maps> maps_;
};

// The rows of `ids` (any order), which `tile` owns: ids.size() rows of run.schema. Error corrupt if one is missing, or
// if the tile's files are not those that were written, which the first call for a tile finds out. Safe to call from
// several threads, with maps of their own.
Result<std::vector<std::byte>> load_rows(ShuffleFileMaps& maps, TileId tile, const std::vector<PointId>& ids);
inline Result<std::vector<std::byte>> load_rows(const RoutedCloud& run, TileId tile, const std::vector<PointId>& ids) {
  ShuffleFileMaps maps(run);
  return load_rows(maps, tile, ids);
}

}  // namespace tessera
