// A cloud that is cut into tiles, in a run folder. Tiles begin from it, and --resume continues it.
//
//   RUN/plan.json             everything below and its own checksum, written last: without it a run folder is not
//   routed RUN/segments.bin          where the tiles' points are: Segments (40 bytes each), one tile after the other
//   RUN/points/, attributes/  the shuffle files (shuffle_file.h)
#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
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
  std::optional<std::uint64_t> points = {};  // that were read; runs of older programs lack it
  friend bool operator==(const InputFile&, const InputFile&) = default;
};

// Whether this process has checked the records of a tile, and found them whole.
struct TileChecked {
  std::atomic<bool> points = false, rows = false;
};

struct RoutedCloud {
  std::filesystem::path folder;
  int dimension = 3;
  DuplicatePolicy keep = DuplicatePolicy::first;  // which of equal points is the vertex
  Partition partition;
  std::vector<std::uint64_t> tile_points;  // by tile, duplicates included
  std::vector<Bounds> tile_bounds;         // by tile: the bounds of its points; empty for an empty tile
  std::vector<ShuffleFile> bundles;
  std::vector<Segment> segments;           // by tile
  std::vector<std::uint64_t> segment_end;  // by tile: where its segments end
  CloudCounts counts;
  Bounds bounds;
  // By tile: what tiles know from the start (seed_finder.h). All tiles know the lexicographically least point, and d+1
  // points that span space, so that no tile is ever flat (docs/design.md). Source indices are those of the vertices
  // that are kept.
  std::vector<Seed> seeds;
  std::vector<Attribute> schema;
  std::vector<InputFile> inputs;
  std::string crs;
  std::string unit;         // of the coordinates; "" when unknown
  std::string options_key;  // equal keys mean the same job; a resume with another key is refused
  // The checksum of the run's plan. It depends on the tile and the bits of every point, so it tells the run from all
  // others. What tiles put on scratch contains it.
  std::uint64_t seal = 0;
  // By tile; copies of this run share it. Without it, load_rows() checks the files at every call.
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

// Streams the cloud into the shuffle files of `folder`. Refuses a cloud without points, and a cloud whose points all
// lie in one hyperplane: error bad_input, with a sentence that says which. Tiles above the limit are split again,
// unless their points are equal. `router`, if given, routes the cloud as input splits if the cloud is large enough;
// then only the shuffle files of the run differ.
Result<RoutedCloud> route(const Cloud& cloud, const std::filesystem::path& folder, const RouteOptions& options,
                          Progress& progress, std::stop_token stop, SplitRouter* router = nullptr);

// Reads plan.json, and checks it and the sizes of the files. What the files contain is checked when it is read. Error
// corrupt names the damaged file.
Result<RoutedCloud> open_run(const std::filesystem::path& folder);

// A tile's points as the kernel needs them: distinct, in Hilbert order within their bounds.
struct LoadedTile {
  std::vector<Point> points;
  std::vector<PointId> ids;                             // beside points; of equal points the id of the kept point
  std::vector<std::pair<PointId, PointId>> duplicates;  // (duplicate, kept), by ascending duplicate
  std::uint64_t other_heights = 0;                      // duplicates whose height is not that of the kept point
};
// Loads a tile's points from the shuffle files. Error corrupt when a file is not the one that was written.
Result<LoadedTile> load_tile(const RoutedCloud& run, TileId tile);
// Makes the same from points in memory (regions, tests, harness). Of equal points the lowest id is kept; heights are
// ignored. REQUIRES: coordinates are finite, and none is -0.
LoadedTile order_points(std::span<const LocalPoint> points, int dimension);

// Maps the shuffle files of a run into memory, each file once. The vertices of one tile belong to a dozen other tiles,
// which share shuffle files. Not thread-safe.
class ShuffleFileMaps {
 public:
  // Refers to `run`, which must outlive this object.
  explicit ShuffleFileMaps(const RoutedCloud& run) : run_(run) {}
  const RoutedCloud& run() const { return run_; }
  struct Maps {
    MappedFile points, rows;
  };
  // Returns the maps of a shuffle file, valid as long as this object. Error io; corrupt when a file is shorter than
  // what was written.
  Result<const Maps*> of(std::uint32_t bundle);

 private:
  const RoutedCloud& run_;
  std::map<std::uint32_t, Maps> maps_;
};

// Returns the rows of `ids` (in any order), which `tile` owns: ids.size() rows of run.schema. Error corrupt if an id is
// missing, or if the tile's files are not those that were written; the first call for a tile checks that. Thread-safe
// if every thread has maps of its own.
Result<std::vector<std::byte>> load_rows(ShuffleFileMaps& maps, TileId tile, const std::vector<PointId>& ids);
inline Result<std::vector<std::byte>> load_rows(const RoutedCloud& run, TileId tile, const std::vector<PointId>& ids) {
  ShuffleFileMaps maps(run);
  return load_rows(maps, tile, ids);
}

}  // namespace tessera
