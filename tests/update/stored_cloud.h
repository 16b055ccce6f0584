// A result that was made from scratch, of any points with any source indices: CGAL's cells, cut into tiles.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <vector>

#include "src/base/duplicate_policy.h"
#include "src/base/point.h"
#include "src/result/store/tile_store.h"
#include "src/tiling/kept_points.h"
#include "src/tiling/partition.h"

namespace tessera::testing {

struct StoredCloud {
  int dimension = 3;
  Partition partition;
  std::vector<LocalPoint> points;
  DuplicatePolicy keep = DuplicatePolicy::first;  // by height: the schema begins with z
  bool duplicate_rows = true;                     // older software wrote none
  std::uint64_t points_read = 0;
  std::vector<Attribute> schema = {};
  // The attributes of a point; nothing: some_rows(), for some_schema().
  std::function<std::vector<std::byte>(PointId)> row_of = {};
  std::function<TileKind(TileId)> kind_of = [](TileId) { return TileKind::cells; };

  std::vector<std::byte> rows_of(const std::vector<PointId>& ids) const;
  HeightsOf heights() const;
  // Writes the result. REQUIRES: the points span space.
  Manifest store(const std::filesystem::path& out) const;
};

// The schema of one attribute, and its value of a point.
std::vector<Attribute> some_schema();
std::uint32_t some_value(PointId id);
std::vector<std::byte> some_rows(const std::vector<PointId>& ids);

// Of a schema of a height (f64) and some_value(): few different heights, and some that are unknown.
std::vector<std::byte> row_with_height(PointId id);

}  // namespace tessera::testing
