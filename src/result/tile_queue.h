// Hands out the tiles of a result to threads.
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

// A queue of tiles for several threads. Each tile goes to one thread. next() and done() are safe to call from several
// threads.
class TileQueue {
 public:
  // `progress` is called with the fraction that is done, 0..1, by one thread at a time; it may be null.
  TileQueue(TileSource source, std::vector<std::size_t> tiles, std::stop_token stop,
            std::function<void(double)> progress)
      : source_(source.stopped_by(stop)),
        tiles_(std::move(tiles)),
        stop_(std::move(stop)),
        progress_(std::move(progress)) {}

  const TileSource& source() const { return source_; }

  // The number of threads to use, at least 1 and at most `wanted`: no more than there are tiles, and no more than fit
  // into memory, when each thread needs `tile_factor` times the bytes of a tile's file, and `beside` bytes more.
  unsigned threads(unsigned wanted, std::uint64_t memory_bytes, double tile_factor, std::uint64_t beside) const;
  // The bytes that the largest tile needs.
  std::uint64_t tile_bytes(double tile_factor) const;
  // The next tile; nothing at the end. Error interrupted.
  Result<std::optional<std::size_t>> next();
  void done();  // call this when a tile is done

 private:
  TileSource source_;
  std::vector<std::size_t> tiles_;
  std::stop_token stop_;
  std::function<void(double)> progress_;
  std::atomic<std::size_t> next_{0};
  std::mutex mutex_;
  std::size_t done_ = 0;
};

// How all tiles of a result are worked on.
struct TileLoop {
  unsigned threads = 1;
  std::uint64_t memory_bytes = 0;  // for tiles; one tile may exceed it
  double tile_factor = 1;          // memory that the work needs for a tile, divided by the bytes of the tile's file
  std::stop_token stop = {};
  // Called with the fraction that is done, 0..1, by one thread at a time; may be null.
  std::function<void(double)> progress = {};
};
// Calls `work` once for each tile, by several threads. The source that it gets is stopped by `loop.stop`. Errors: those
// of `work`; interrupted.
Status for_each_tile(const TileSource& source, const TileLoop& loop,
                     const std::function<Status(const TileSource& source, std::size_t index)>& work);

}  // namespace tessera
