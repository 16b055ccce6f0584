// The other way to change a result: all tiles are triangulated as in a first triangulation, from their changed points.
// When most tiles have fresh points, that costs less than the exchange of a change, because final cells need not be
// kept, and seeds make the exchange small.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <stop_token>
#include <vector>

#include "src/base/big_vector.h"
#include "src/base/point.h"
#include "src/base/result.h"
#include "src/delaunay/run/result_stages.h"
#include "src/delaunay/update/update_plan.h"
#include "src/delaunay/update/update_store.h"
#include "src/exchange/tile_program.h"
#include "src/result/tile_source.h"
#include "src/tiling/partition.h"

namespace tessera {

// What a first triangulation must know of all points before it begins. By tile.
struct AnewStart {
  std::vector<std::uint64_t> points;  // distinct ones
  std::vector<Bounds> bounds;
  std::vector<Seed> seeds;
};

// Reads the points of all tiles, on several threads. Error usage when the points do not span space.
Result<AnewStart> find_anew_start(const TileSource& source, const Partition& partition, const UpdatePlan& plan,
                                  unsigned threads, const std::stop_token& stop);
BigVector<std::byte> bytes_of(const AnewStart& start);
std::optional<AnewStart> anew_start_of(std::span<const std::byte> bytes);

// The programs of the tiles. What they have become is kept in `ends`. `stage`: the number of the stage.
Result<std::shared_ptr<const TilePrograms>> anew_programs(const ResultInput& input, std::uint32_t stage,
                                                          std::shared_ptr<const UpdatePlan> plan,
                                                          const Partition& partition, AnewStart start,
                                                          std::shared_ptr<UpdateStore> ends);

}  // namespace tessera
