// A stored result that is kept in memory and changed by batches: points are added and removed. After each batch the
// tiles are those of a triangulation of all points from scratch, with the same source indices (docs/updates-design.md).
//
//  (1) A batch happens as a whole or not at all, and one after the other.
//  (2) When apply() returns without an error, the batch is in the log OUT/.live/NNNNNN.log: opening the result again
//      brings it back, however this process ended.
//  (3) Versions are numbered. A number is never given twice, also when the result is opened again.
//  (4) Readers take the current version, and see all tiles of that version for as long as they keep it. They never wait
//      for a batch.
//  (5) Which of equal points is the vertex follows the rule of the result, as in update_result().
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <stop_token>
#include <utility>
#include <vector>

#include "src/base/point.h"
#include "src/base/result.h"
#include "src/delaunay/live/live_duplicates.h"
#include "src/delaunay/live/live_exchange.h"
#include "src/delaunay/live/live_log.h"
#include "src/delaunay/live/live_plan.h"
#include "src/delaunay/live/live_rows.h"
#include "src/delaunay/live/live_version.h"
#include "src/delaunay/update/changed_columns.h"
#include "src/delaunay/update/update.h"
#include "src/result/store/duplicate_rows.h"
#include "src/result/tile_source.h"
#include "src/tiling/partition.h"
#include "src/tiling/tile/known_from_start.h"

namespace tessera {

struct LiveOptions {
  unsigned threads = 1;
  std::uint64_t memory_bytes = std::uint64_t{4}
                               << 30;  // for all tiles, of the newest version and of those that readers have
  // A tile with more points is split when it is stored. 0: as an earlier change of the result has said, else by the
  // largest tile (limit_of_tiles()).
  std::uint64_t tile_points = 0;
};

// A change costs as much as its tiles. So tiles in memory are split from this size on, if no earlier change of the
// result has said another.
inline constexpr std::uint64_t grown_live_tile_least = 20'000;

// What becomes of points of the result that are equal to new ones.
enum class EqualToNew : std::uint8_t {
  stay,  // the rule of the result says which is the vertex
  go     // they are removed
};

// What a batch has done.
struct LiveApplied {
  std::uint64_t version = 0;
  std::uint64_t first_new = 0;  // the source index of the first new point; the others follow
  std::uint64_t removed = 0;    // points: vertices and duplicates, those included that new points have replaced
  // The new points that are equal to others, which were there or come before them in the batch; ascending.
  std::vector<PointId> equal = {};
  // Boxes that contain all cells that are new or gone, one for each tile that has such cells.
  std::vector<Bounds> changed = {};
  std::uint64_t begun = 0, awake = 0;  // tiles
};

struct LiveState {
  std::uint64_t version = 0;             // the number of the newest version
  std::uint64_t stored = 0;              // the number of the version that is stored
  std::uint32_t stored_version = 0;      // the version of the stored result, as its manifest counts
  std::uint64_t added = 0, removed = 0;  // points, by the batches that are in the log alone
  std::uint64_t log_bytes = 0;
  std::optional<Error> broken = {};  // why nothing can be applied any more
};

class LiveResult {
 public:
  // Reads all tiles of the newest version into memory, and repeats what the log has. Errors: usage when the result
  // cannot be changed, as when it has densities, or when another process has the log; memory when the tiles need more
  // than the options allow; corrupt; io; interrupted.
  static Result<std::unique_ptr<LiveResult>> open(const std::filesystem::path& out, const LiveOptions& options,
                                                  const std::stop_token& stop = {});

  // Applies a batch. Batches that come at the same time are applied one after the other. Errors, after which nothing
  // has changed: usage when a point to be removed does not exist, when a coordinate is not finite, when the attributes
  // do not fit, when a vertex would go whose duplicate would take its place and has no known attributes, when the
  // points that would be left do not span space; memory when the tiles would need more than the options allow; those of
  // reading attributes; io when the log cannot be written, as on a full disk. When it is then not known whether the
  // batch is in the log, the error says so, state() has it as `broken`, nothing can be applied any more, and opening
  // the result again tells. Thread-safe.
  Result<LiveApplied> apply(const ResultChange& change, EqualToNew equal = EqualToNew::stay);

  // The newest version. Thread-safe, also beside apply().
  std::shared_ptr<const LiveVersion> current() const { return current_.load(); }
  TileSource source() const;  // what is stored, without columns
  std::uint64_t log_bytes() const;
  LiveState state() const;  // thread-safe; never waits for a batch

  // Makes the newest version the next version of the stored result, by new files of the tiles that have changed, and
  // begins a new log. However the process ends, opening the result again brings back all batches. Batches wait
  // meanwhile, readers do not. Tiles that have grown too large are split, if there is memory for that; current() then
  // has the same version in other tiles. Errors: those of NewVersion; usage when another program has changed the result
  // meanwhile; memory. After an error of committing nothing can be applied any more, and opening the result again tells
  // what is stored. Thread-safe.
  Status checkpoint();

  // Writes the newest version as a result of its own, to a folder that must not exist. Files of tiles that have not
  // changed since the stored version are hard links. Batches wait meanwhile, readers do not. Errors: usage when the
  // folder exists; io; corrupt. After an error nothing is left of the folder. Thread-safe.
  Result<Manifest> write_to(const std::filesystem::path& to) const;

 private:
  LiveResult(TileSource source, Partition partition, const LiveOptions& options);
  // The newest version, in the tiles in which it is stored.
  struct Storing {
    std::shared_ptr<const LiveVersion> version;
    std::shared_ptr<const Partition> partition;
    std::set<TileId> tiles;  // whose files are others now, or gone
  };
  Error too_little_memory() const;
  Status load(const std::stop_token& stop);
  Status load_duplicates(std::vector<IdTiles::Entry>& entries);
  Status load_tile(std::size_t index, LiveVersion::Tiles& tiles, std::vector<IdTiles::Entry>& entries) const;
  Status check_points(const ResultChange& change) const;
  LivePlanner planner(const LiveVersion& before);
  Result<LiveApplied> apply_logged(const ResultChange& change, bool log);
  Status append(const ResultChange& change);
  Error no_memory_since(std::uint64_t records);
  Status check_left(const LiveVersion& before, LiveExchange& exchange) const;
  std::size_t memory_with(const LiveVersion& next);
  std::shared_ptr<const LiveVersion> next(const LiveVersion& before, const LivePlan& plan, LiveExchange& exchange,
                                          std::set<TileId>& changed) const;
  void note(const LivePlan& plan, const ResultChange& change);
  IdTiles ids_of(const LiveVersion::Tiles& tiles) const;
  Result<Storing> storing();
  Status store();
  std::uint64_t tile_limit() const;
  void describe(Manifest& manifest, const LiveVersion& version) const;
  Result<FinishedTiles> finish_tiles(const std::filesystem::path& folder, const std::vector<TileEntry>& written,
                                     const std::filesystem::path& columns) const;
  std::optional<Digest> digest_with(const std::vector<TileEntry>& written, const std::set<TileId>& other) const;
  Status begin_again(const Storing& stored);
  Result<std::optional<DuplicateRowSort>> rows_of_duplicates(const std::filesystem::path& scratch) const;
  void publish_state();
  Error refuse(const std::string& why) const;

  static constexpr const char* until_opened_again = "nothing is changed any more until the result is opened again";

  TileSource whole_;   // what is stored
  TileSource source_;  // without columns
  std::shared_ptr<const Partition> partition_;
  KnownFromStart around_;  // all tiles refer to it; only the writer reads it, and sets it when tiles are split
  LiveOptions options_;
  mutable std::mutex writer_;  // all that follows, but for current_
  std::atomic<std::shared_ptr<const LiveVersion>> current_;
  std::vector<std::weak_ptr<const LiveVersion>> older_;  // than current_; readers may have them
  LiveDuplicates duplicates_;
  std::uint64_t next_id_ = 0;
  std::uint64_t filtered_ = 0;  // points that were removed since the stored version
  LiveRows rows_;
  std::optional<StoredRows> stored_rows_;  // of source_
  std::set<TileId> changed_;               // since the stored version
  std::uint64_t stored_number_ = 0;        // of the version that is stored
  std::optional<LiveLog> log_;
  std::optional<Error> broken_;
  mutable std::mutex state_mutex_;
  LiveState state_;
};

}  // namespace tessera
