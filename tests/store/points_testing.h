// Tiles as points, for tests of their files.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <random>
#include <span>
#include <vector>

#include "src/result/store/points_tile.h"
#include "src/result/store/tile_columns.h"

namespace tessera::test {

// Points without attributes: ids are random, every foreign point is of one of tiles 0 to 6 that is not `tile`.
inline PointsTile points_tile(int dimension, std::vector<Point> points, std::size_t foreign, unsigned seed = 1) {
  PointsTile tile;
  tile.dimension = dimension;
  tile.tile = TileId{42};
  tile.own = points.size() - foreign;
  tile.points = std::move(points);
  std::mt19937_64 random(seed);
  for (std::size_t i = 0; i < tile.points.size(); ++i) {
    if (dimension == 2) tile.points[i].z = 0;
    tile.ids.push_back({random() % 1'000'000});
    tile.owners.push_back(i < tile.own ? tile.tile : TileId{static_cast<std::uint32_t>(random() % 7)});
  }
  return tile;
}

// Uniform in the unit cube, along x: `foreign` of them are behind the others.
inline PointsTile uniform_tile(int dimension, std::size_t n, std::size_t foreign, unsigned seed = 1) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> unit(0, 1);
  std::vector<Point> points(n);
  for (std::size_t i = 0; i < n; ++i)
    points[i] = {(static_cast<double>(i) + unit(random)) / static_cast<double>(n), unit(random), unit(random)};
  return points_tile(dimension, std::move(points), foreign, seed);
}

// Adds an attribute behind the others: one value a point, over and over again when there are fewer.
template <class T>
void add_attribute(PointsTile& tile, const Attribute& attribute, const std::vector<T>& values) {
  const std::size_t before = row_bytes(tile.schema), size = size_of(attribute.type);
  std::vector<std::byte> rows(tile.points.size() * (before + size));
  for (std::size_t i = 0; i < tile.points.size(); ++i) {
    std::byte* row = rows.data() + i * (before + size);
    if (before > 0) std::memcpy(row, tile.rows.data() + i * before, before);
    std::memcpy(row + before, &values[i % values.size()], size);
  }
  tile.schema.push_back(attribute);
  tile.rows = std::move(rows);
}

// The file of a tile that these columns were added to.
std::vector<std::byte> file_with_columns(const PointsTile& tile, std::span<const store::ColumnValues> columns);

}  // namespace tessera::test
