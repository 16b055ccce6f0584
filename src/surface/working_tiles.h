// The tiles of a result that are worked on: in memory while they fit, else on disk.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <filesystem>
#include <list>
#include <map>
#include <memory>
#include <mutex>
#include <utility>
#include <vector>

#include "src/base/files/surface_names.h"
#include "src/base/result.h"
#include "src/result/tile_source.h"
#include "src/surface/surface_tile.h"

namespace tessera::surface {

// Thread-safe, but a tile may be used by one thread at a time.
class WorkingTiles {
 public:
  // `folder`: for tiles that do not fit into `memory_bytes`.
  WorkingTiles(TileSource source, std::filesystem::path folder, std::uint64_t memory_bytes)
      : source_(std::move(source)),
        folder_(std::move(folder)),
        memory_bytes_(memory_bytes),
        on_disk_(source_.tiles(), OnDisk::no) {}

  // Returns a tile without weights. Errors: of reading.
  Result<std::unique_ptr<SurfaceTile>> take(std::size_t index);
  Status give_back(std::size_t index, std::unique_ptr<SurfaceTile> tile);
  const TileSource& source() const { return source_; }

 private:
  std::filesystem::path cells_path(std::size_t index) const { return surface_cells_file(folder_, index); }
  using Leaving = std::vector<std::pair<std::size_t, std::unique_ptr<SurfaceTile>>>;
  Leaving too_much();  // Takes tiles out of memory until the others fit. REQUIRES: the lock is held.
  Status put_down(Leaving leaving);
  Status put_down(std::size_t index, const SurfaceTile& tile) const;
  Result<std::unique_ptr<SurfaceTile>> from_result(std::size_t index) const;

  TileSource source_;
  std::filesystem::path folder_;
  std::uint64_t memory_bytes_;
  enum class OnDisk : std::uint8_t { no, soon, yes };
  std::vector<OnDisk> on_disk_;  // by index
  std::mutex mutex_;
  std::condition_variable written_;
  std::map<std::size_t, std::unique_ptr<SurfaceTile>> here_;
  std::list<std::size_t> order_;  // of the tiles in memory, the longest unused first
  std::uint64_t held_ = 0;
};

}  // namespace tessera::surface
