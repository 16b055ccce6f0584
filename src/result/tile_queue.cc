#include "src/result/tile_queue.h"

#include <algorithm>
#include <atomic>
#include <numeric>

#include "src/base/on_threads.h"

namespace tessera {

std::uint64_t TileQueue::tile_bytes(double tile_factor) const {
  std::uint64_t most = 0;
  for (const std::size_t i : tiles_) most = std::max(most, source_.work_bytes(i));
  return (std::uint64_t{1} << 20) + static_cast<std::uint64_t>(static_cast<double>(most) * tile_factor);
}

unsigned TileQueue::threads(unsigned wanted, std::uint64_t memory_bytes, double tile_factor,
                            std::uint64_t beside) const {
  const std::uint64_t most = std::max<std::uint64_t>(memory_bytes / (tile_bytes(tile_factor) + beside), 1);
  return static_cast<unsigned>(
      std::min<std::uint64_t>({std::max(wanted, 1u), most, std::max<std::size_t>(tiles_.size(), 1)}));
}

Result<std::optional<std::size_t>> TileQueue::next() {
  if (stop_.stop_requested()) return error(Errc::interrupted, "interrupted while reading tiles");
  const std::size_t i = next_++;
  return i < tiles_.size() ? std::optional(tiles_[i]) : std::nullopt;
}

void TileQueue::done() {
  const std::lock_guard lock(mutex_);
  ++done_;
  if (progress_) progress_(static_cast<double>(done_) / static_cast<double>(tiles_.size()));
}

Status for_each_tile(const TileSource& source, const TileLoop& loop,
                     const std::function<Status(const TileSource& source, std::size_t index)>& work) {
  std::vector<std::size_t> all(source.tiles());
  std::iota(all.begin(), all.end(), std::size_t{0});
  TileQueue tiles(source, std::move(all), loop.stop, loop.progress);
  std::atomic<bool> failed{false};
  return on_threads(tiles.threads(loop.threads, loop.memory_bytes, loop.tile_factor, 0), failed, [&]() -> Status {
    while (!failed) {
      BOOST_OUTCOME_TRY(index, tiles.next());
      if (!index) break;
      BOOST_OUTCOME_TRYV(work(tiles.source(), *index));
      tiles.done();
    }
    return success();
  });
}

}  // namespace tessera
