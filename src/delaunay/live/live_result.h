// A stored result that is kept in memory and changed by batches: points are added and removed. After each batch the
// tiles are those of a triangulation of all points from scratch, with the same source indices (docs/updates-design.md).
//
//  (1) A batch happens as a whole or not at all, and one after the other.
//  (2) When apply() returns without an error, the batch is in the log OUT/.live/NNNNNN.log: opening the result again
//      brings it back, however this process ended.
//  (3) Versions are numbered. A number is never given twice, also when the result is opened again.
//  (4) Readers take the current version, and see all tiles of that version for as long as they keep it. They never wait
//      for a batch.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
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
#include "src/delaunay/live/live_version.h"
#include "src/delaunay/update/changed_columns.h"
#include "src/delaunay/update/update.h"
#include "src/result/store/duplicate_rows.h"
#include "src/result/tile_source.h"

namespace tessera {

struct LiveOptions {
  unsigned threads = 1;
  std::uint64_t memory_bytes = std::uint64_t{4}
                               << 30;  // for all tiles, of the newest version and of those that readers have
};

// What a batch has done.
struct LiveApplied {
  std::uint64_t version = 0;
  std::uint64_t first_new = 0;                 // the source index of the first new point; the others follow
  std::uint64_t removed = 0;                   // points: vertices and duplicates
  std::vector<DuplicatePair> duplicates = {};  // new points that are equal to others
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
  // cannot be changed, has densities or keeps another point than the first of equal ones, or when another
  // process has the log; memory when the tiles need more than the options allow; corrupt; io; interrupted.
  static Result<std::unique_ptr<LiveResult>> open(const std::filesystem::path& out, const LiveOptions& options,
                                                  const std::stop_token& stop = {});

  // Applies a batch. Batches that come at the same time are applied one after the other. Errors, after which nothing
  // has changed: usage when a point to be removed does not exist, when a coordinate is not finite, when the attributes
  // do not fit, when a vertex would go whose duplicate would take its place and has no known attributes, when the
  // points that would be left do not span space; memory when the tiles would need more than the options allow. Error io
  // when the log cannot be written: whether the batch is in the log is then not known, nothing can be applied any more,
  // and opening the result again tells. Thread-safe.
  Result<LiveApplied> apply(const ResultChange& change);

  // The newest version. Thread-safe, also beside apply().
  std::shared_ptr<const LiveVersion> current() const { return current_.load(); }
  TileSource source() const;  // what is stored, without columns
  std::uint64_t log_bytes() const;
  LiveState state() const;  // thread-safe; never waits for a batch

  // Makes the newest version the next version of the stored result, by new files of the tiles that have changed, and
  // begins a new log. However the process ends, opening the result again brings back all batches. Batches wait
  // meanwhile, readers do not. Errors: those of NewVersion; usage when another program has changed the result
  // meanwhile. After an error of committing nothing can be applied any more, and opening the result again tells what is
  // stored. Thread-safe.
  Status checkpoint();

  // Writes the newest version as a result of its own, to a folder that must not exist. Files of tiles that have not
  // changed since the stored version are hard links. Batches wait meanwhile, readers do not. Errors: usage when the
  // folder exists; io; corrupt. After an error nothing is left of the folder. Thread-safe.
  Result<Manifest> write_to(const std::filesystem::path& to) const;

 private:
  LiveResult(TileSource source, Partition partition, const LiveOptions& options);
  struct Planned {
    LiveBatch batch;
    std::vector<PointId> duplicates_removed;
    std::map<PointId, PointId> heirs;  // by the vertex that goes
    std::map<TileId, Bounds> removed_of;
    std::vector<IdTiles::Entry> entries;
  };
  Status load(const std::stop_token& stop);
  Status load_duplicates(std::vector<IdTiles::Entry>& entries);
  Status load_tile(std::size_t index, LiveVersion::Tiles& tiles, std::vector<IdTiles::Entry>& entries) const;
  Status check_points(const ResultChange& change) const;
  Result<Planned> plan(const LiveVersion& before, const ResultChange& change) const;
  Status plan_removal(const LiveVersion& before, const std::vector<PointId>& ids, Planned& planned) const;
  Result<LiveApplied> apply_logged(const ResultChange& change, bool log);
  Status check_left(const LiveVersion& before, LiveExchange& exchange) const;
  std::size_t memory_with(const LiveVersion& next);
  std::shared_ptr<const LiveVersion> next(const LiveVersion& before, const Planned& planned, LiveExchange& exchange,
                                          std::set<TileId>& changed) const;
  void note(const Planned& planned, const ResultChange& change, const LiveApplied& applied);
  void describe(Manifest& manifest, const LiveVersion& version) const;
  Result<FinishedTiles> finish_tiles(const std::filesystem::path& folder, const std::vector<TileEntry>& written,
                                     const std::filesystem::path& columns) const;
  std::optional<Digest> digest_with(const std::vector<TileEntry>& written) const;
  Status begin_again();
  Result<std::optional<DuplicateRowSort>> rows_of_duplicates(const std::filesystem::path& scratch) const;
  const std::vector<std::byte>* row_of_duplicate(PointId id) const;
  void publish_state();
  Error refuse(const std::string& why) const;

  static constexpr const char* until_opened_again = "nothing is changed any more until the result is opened again";

  TileSource whole_;   // what is stored
  TileSource source_;  // without columns
  std::shared_ptr<const Partition> partition_;
  KnownFromStart around_;
  LiveOptions options_;
  mutable std::mutex writer_;  // all that follows, but for current_
  std::atomic<std::shared_ptr<const LiveVersion>> current_;
  std::vector<std::weak_ptr<const LiveVersion>> older_;  // than current_; readers may have them
  LiveDuplicates duplicates_;
  std::uint64_t next_id_ = 0;
  std::uint64_t filtered_ = 0;                      // points that were removed since the stored version
  std::map<PointId, std::vector<std::byte>> rows_;  // of the points that were added since the stored version
  // The stored attributes of duplicates. Those of points that were added since are in rows_.
  std::map<PointId, std::vector<std::byte>> duplicate_rows_;
  bool duplicates_have_rows_ = false;  // the attributes of all duplicates are known
  std::set<TileId> changed_;           // since the stored version
  std::uint64_t stored_number_ = 0;    // of the version that is stored
  std::optional<LiveLog> log_;
  std::optional<Error> broken_;
  mutable std::mutex state_mutex_;
  LiveState state_;
};

}  // namespace tessera
