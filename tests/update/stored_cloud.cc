#include "tests/update/stored_cloud.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <limits>
#include <map>
#include <optional>
#include <set>
#include <utility>

#include "src/geometry/reference/reference.h"
#include "src/result/store/digest.h"
#include "src/result/store/duplicate_rows.h"
#include "src/result/store/points_tile.h"
#include "src/tiling/routed_cloud.h"
#include "src/tiling/tile/rebuild.h"

namespace tessera::testing {
namespace {

using Foreign = std::map<TileId, std::set<PointId>>;

// By tile, the vertices of others in cells with a vertex of its own.
Foreign foreign_of(const std::vector<IdCell>& cells, int dimension, const std::map<PointId, TileId>& owners) {
  Foreign out;
  for (const IdCell& cell : cells) {
    for (int i = 0; i <= dimension; ++i) {
      const TileId tile = owners.at(cell[static_cast<std::size_t>(i)]);
      for (int k = 0; k <= dimension; ++k) {
        const PointId other = cell[static_cast<std::size_t>(k)];
        if (owners.at(other) != tile) out[tile].insert(other);
      }
    }
  }
  return out;
}

Result<TileEntry> write_as_points(const std::filesystem::path& out, TileId tile, const TileMesh& mesh,
                                  const std::vector<std::byte>& rows, const StoreOptions& options) {
  CountedCells counted;
  counted.cells = mesh.cell_ghost.size();
  counted.main_cells = static_cast<std::uint64_t>(std::count(mesh.cell_ghost.begin(), mesh.cell_ghost.end(), 0));
  counted.digest = CellDigest(mesh.dimension, mesh.ids).of(mesh.cells, mesh.cell_ghost.data());
  return write_points_tile(
      out,
      {.dimension = mesh.dimension,
       .tile = tile,
       .own = static_cast<std::uint64_t>(std::count(mesh.point_ghost.begin(), mesh.point_ghost.end(), 0)),
       .points = mesh.points,
       .ids = mesh.ids,
       .owners = mesh.owners,
       .schema = options.schema,
       .rows = rows},
      counted, options);
}

}  // namespace

std::vector<Attribute> some_schema() { return {{"some", AttributeType::u32}}; }

std::uint32_t some_value(PointId id) { return static_cast<std::uint32_t>(id.value * 2654435761u); }

std::vector<std::byte> some_rows(const std::vector<PointId>& ids) {
  std::vector<std::byte> rows(ids.size() * sizeof(std::uint32_t));
  for (std::size_t i = 0; i < ids.size(); ++i) {
    const std::uint32_t value = some_value(ids[i]);
    std::memcpy(&rows[i * sizeof value], &value, sizeof value);
  }
  return rows;
}

std::vector<std::byte> row_with_height(PointId id) {
  const std::uint32_t some = some_value(id);
  const double height = some % 11 == 0 ? std::numeric_limits<double>::quiet_NaN() : some / 7 % 4;
  std::vector<std::byte> row(sizeof height + sizeof some);
  std::memcpy(row.data(), &height, sizeof height);
  std::memcpy(row.data() + sizeof height, &some, sizeof some);
  return row;
}

std::vector<std::byte> StoredCloud::rows_of(const std::vector<PointId>& ids) const {
  if (schema.empty()) return {};
  if (!row_of) return some_rows(ids);
  std::vector<std::byte> rows;
  for (const PointId id : ids) {
    const auto row = row_of(id);
    rows.insert(rows.end(), row.begin(), row.end());
  }
  return rows;
}

HeightsOf StoredCloud::heights() const {
  return [this](std::span<const PointId> ids) -> Result<std::vector<double>> {
    std::vector<double> heights(ids.size());
    for (std::size_t i = 0; i < ids.size(); ++i) std::memcpy(&heights[i], row_of(ids[i]).data(), sizeof(double));
    return heights;
  };
}

Manifest StoredCloud::store(const std::filesystem::path& out) const {
  Manifest manifest;
  manifest.software_version = "test";
  manifest.command = {"test"};
  manifest.dimension = dimension;
  manifest.partition_kind = name_of(partition.kind());
  manifest.boxes = partition.boxes();
  manifest.partition = partition.to_json();
  manifest.schema = schema;
  std::map<TileId, std::vector<LocalPoint>> own;
  for (const LocalPoint& p : points) own[partition.tile_of(p.at)].push_back(p);
  std::map<TileId, LoadedTile> loaded;
  std::map<PointId, TileId> owners;
  std::map<PointId, Point> at;
  std::vector<LocalPoint> vertices;
  std::vector<DuplicatePair> duplicates;
  for (const auto& [tile, list] : own) {
    loaded[tile] = order_points(list, dimension);
    const auto chosen = choose_kept(keep, is_by_height(keep) ? heights() : HeightsOf(), loaded[tile]);
    EXPECT_TRUE(chosen) << chosen.error().where;
    for (std::size_t i = 0; i < loaded[tile].ids.size(); ++i) {
      const PointId id = loaded[tile].ids[i];
      owners[id] = tile;
      at[id] = loaded[tile].points[i];
      vertices.push_back({at[id], id});
      manifest.bounds.add(at[id]);
    }
    for (const auto& [duplicate, kept] : loaded[tile].duplicates) duplicates.push_back({duplicate, kept});
  }
  const auto foreign = foreign_of(global_delaunay(vertices, dimension), dimension, owners);
  for (auto& [tile, mine] : loaded) {
    RebuildInput input{.dimension = dimension,
                       .self = tile,
                       .own = mine.points.size(),
                       .points = mine.points,
                       .ids = mine.ids,
                       .owners = std::vector<TileId>(mine.points.size(), tile)};
    if (const auto found = foreign.find(tile); found != foreign.end()) {
      for (const PointId id : found->second) {
        input.points.push_back(at.at(id));
        input.ids.push_back(id);
        input.owners.push_back(owners.at(id));
      }
    }
    auto mesh = rebuild(std::move(input));
    EXPECT_TRUE(mesh) << (mesh ? "" : mesh.error().where);
    const StoreOptions options{.schema = schema};
    const auto rows = rows_of(mesh.value().ids);
    auto entry = kind_of(tile) == TileKind::points ? write_as_points(out, tile, mesh.value(), rows, options)
                                                   : write_tile(out, tile, mesh.value(), rows, options);
    EXPECT_TRUE(entry) << (entry ? "" : entry.error().where);
    manifest.tiles.push_back(entry.value());
    manifest.vertices += entry.value().own_points;
    manifest.cells += entry.value().main_cells;
  }
  manifest.points_read = points_read;
  manifest.filtered = points_read - points.size();
  std::sort(duplicates.begin(), duplicates.end());
  manifest.keep = keep;
  std::optional<DuplicateRowSort> rows;
  if (duplicate_rows && !schema.empty()) rows.emplace(out, 1 << 20, row_bytes(schema));
  for (const DuplicatePair& pair : duplicates) {
    if (rows) {
      EXPECT_TRUE(rows->push(pair.duplicate, rows_of({pair.duplicate})));
    }
  }
  const Status finished = finish_store(out, manifest, duplicates, rows ? &*rows : nullptr);
  EXPECT_TRUE(finished) << (finished ? "" : finished.error().where);
  return manifest;
}

}  // namespace tessera::testing
