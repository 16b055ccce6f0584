// Options of a job: how a routed cloud is worked on.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "src/base/tile_kind.h"
#include "src/exchange/share.h"
#include "src/geometry/kernel/kernel.h"

namespace tessera {

class TileConsumer;  // src/result/store/tile_taker.h

// Whether tiles keep their whole triangulation in memory, or hand out final cells and keep the rest. by_budget: whole
// if all tiles fit.
enum class TileRetention : std::uint8_t { by_budget, whole, reduced };

// What is stored of tiles: cells, or the points that they follow from. by_size: points if the cloud has more than
// most_points_with_cells points.
enum class StoreAs : std::uint8_t { by_size, cells, points };
inline constexpr std::array<std::string_view, 3> store_as_names{"auto", "cells", "points"};
inline std::string_view name_of(StoreAs store) { return store_as_names[static_cast<std::size_t>(store)]; }
inline constexpr std::uint64_t most_points_with_cells = 50'000'000;
constexpr TileKind kind_of_tiles(StoreAs store, std::uint64_t points) {
  return store == StoreAs::points || (store == StoreAs::by_size && points > most_points_with_cells) ? TileKind::points
                                                                                                    : TileKind::cells;
}

struct RunOptions {
  std::uint32_t threads = 1;
  std::uint64_t memory_bytes = std::uint64_t{4} << 30;
  KernelKind kernel = KernelKind::flat;
  TileRetention keep = TileRetention::by_budget;
  StoreAs store = StoreAs::by_size;
  bool neighbors = true;  // whether they are stored
  bool resumable = true;  // this and the next two are as in ShareOptions
  std::uint32_t grace_s = 0;
  std::string lock_file = {};
  TileConsumer* taker = nullptr;  // on one node alone: gets the tiles' cells, which are then not stored

  friend bool operator==(const RunOptions&, const RunOptions&) = default;
};

// What the programs of a job must know besides the points (ShareSpec::programs).
struct DelaunayOptions {
  KernelKind kernel = KernelKind::flat;
  TileRetention keep = TileRetention::by_budget;
  StoreAs store = StoreAs::by_size;
  bool neighbors = true;
  friend bool operator==(const DelaunayOptions&, const DelaunayOptions&) = default;
};
std::string to_bytes(const DelaunayOptions& options);
Result<DelaunayOptions> delaunay_options_from_bytes(const std::string& bytes);

// Returns the specification of a job on one node.
ShareSpec spec_of(const RunOptions& options, std::string run_folder, std::string out_folder);

}  // namespace tessera
