// Which tiles of a result are read, and by whom.
#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <mutex>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "src/base/point.h"
#include "src/base/result.h"
#include "src/store/tile_store.h"

namespace tessera::terrain {

// Error usage for a 3D result, whose cells are no surface over a plane, and for a longest edge that is no length.
Status check_surface(const std::filesystem::path& out, const Manifest& manifest, const std::optional<double>& max_edge);

// Error usage, which says where the points are, when the box is outside of all of them.
Status check_meets(const Manifest& manifest, const std::optional<Bounds>& box);

// Memory that tiles may take while they are looked for; and when to end.
struct Looking {
  std::uint64_t memory_bytes = 0;
  std::stop_token stop = {};
};

// Of a 2D result: the tiles that own a vertex of a cell that meets the closed box. Without a box all of them, as when
// it covers half of the result or more: to find those that are not needed would take as long as to read them. Errors:
// usage when there is none; of reading.
Result<std::vector<TileEntry>> tiles_meeting(const std::filesystem::path& out, const Manifest& manifest,
                                             const std::optional<Bounds>& box, const Looking& looking);

// What there is to say of a drawing: that its coordinates have no system, that a region does not know all of its place.
// Else empty.
std::string note_of(const Manifest& manifest, const std::optional<Bounds>& box);

// Tiles for several threads, each to one of them.
class TileQueue {
 public:
  // `progress`: is told the part that is done, 0..1, by one thread at a time; or null.
  TileQueue(std::vector<TileEntry> tiles, std::stop_token stop, std::function<void(double)> progress)
      : tiles_(std::move(tiles)), stop_(std::move(stop)), progress_(std::move(progress)) {}

  // How many threads, of at least 1: no more than tiles, nor than memory for `tile_factor` times a tile's file each.
  unsigned threads(unsigned wanted, std::uint64_t memory_bytes, double tile_factor, std::uint64_t beside) const;
  // What the largest tile takes.
  std::uint64_t tile_bytes(double tile_factor) const;
  // Null at the end. Error interrupted.
  Result<const TileEntry*> next();
  void done();  // with one of them

 private:
  std::vector<TileEntry> tiles_;
  std::stop_token stop_;
  std::function<void(double)> progress_;
  std::atomic<std::size_t> next_{0};
  std::mutex mutex_;
  std::size_t done_ = 0;
};

}  // namespace tessera::terrain
