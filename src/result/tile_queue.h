// Which thread reads which tile of a result next.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <mutex>
#include <optional>
#include <stop_token>
#include <utility>
#include <vector>

#include "src/base/result.h"
#include "src/result/tile_source.h"

namespace tessera {

// Tiles for several threads, each to one of them.
class TileQueue {
 public:
  // `progress`: is told the part that is done, 0..1, by one thread at a time; or null.
  TileQueue(TileSource source, std::vector<std::size_t> tiles, std::stop_token stop,
            std::function<void(double)> progress)
      : source_(source.stopped_by(stop)),
        tiles_(std::move(tiles)),
        stop_(std::move(stop)),
        progress_(std::move(progress)) {}

  const TileSource& source() const { return source_; }

  // How many threads, of at least 1: no more than tiles, nor than memory for `tile_factor` times a tile's file each.
  unsigned threads(unsigned wanted, std::uint64_t memory_bytes, double tile_factor, std::uint64_t beside) const;
  // What the largest tile takes.
  std::uint64_t tile_bytes(double tile_factor) const;
  // Nothing at the end. Error interrupted.
  Result<std::optional<std::size_t>> next();
  void done();  // with one of them

 private:
  TileSource source_;
  std::vector<std::size_t> tiles_;
  std::stop_token stop_;
  std::function<void(double)> progress_;
  std::atomic<std::size_t> next_{0};
  std::mutex mutex_;
  std::size_t done_ = 0;
};

}  // namespace tessera
