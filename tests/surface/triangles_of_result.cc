#include "tests/surface/triangles_of_result.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <mutex>
#include <utility>

#include "tests/store/sample_result.h"

namespace tessera::surface {

IdTriangle of_ids(PointId a, PointId b, PointId c) {
  IdTriangle triangle{a, b, c};
  std::rotate(triangle.begin(), std::min_element(triangle.begin(), triangle.end()), triangle.end());
  return triangle;
}

Triangles triangles_of(const std::filesystem::path& result, const SensorOptions& where, PassesOptions options) {
  Triangles found;
  const test::TemporaryFolder scratch;
  const auto source = TileSource::open(result).value();
  const auto sensors = Sensors::make(where, source.manifest().schema, source.manifest().bounds).value();
  const auto passes = Passes::begin(source, sensors, scratch.path(), std::move(options)).value();
  std::mutex mutex;
  const Status status = passes->run([&](std::size_t, const StoredTile& tile) -> Status {
    const std::lock_guard lock(mutex);
    const TileMesh& mesh = tile.mesh;
    const std::size_t width = row_bytes(tile.schema);
    for (std::size_t v = 0; v < mesh.points.size(); ++v) {
      Point at = mesh.points[v];
      std::memcpy(&at.z, tile.rows.data() + v * width, sizeof at.z);
      EXPECT_EQ(found.points.try_emplace(mesh.ids[v], at).first->second, at);
    }
    for (std::size_t i = 0; i < mesh.cell_ghost.size(); ++i) {
      const auto id = [&](std::size_t k) { return mesh.ids[static_cast<std::size_t>(mesh.cells[3 * i + k])]; };
      const IdTriangle triangle = of_ids(id(0), id(1), id(2));
      ++found.in_tiles[triangle];
      if (mesh.cell_ghost[i] == 0) found.main.push_back(triangle);
    }
    return success();
  });
  EXPECT_TRUE(status) << status.error().where;
  std::sort(found.main.begin(), found.main.end());
  found.handed_over = passes->counts().handed_over;
  found.undecided = passes->counts().undecided;
  return found;
}

std::vector<PointId> open_edge(const std::vector<IdTriangle>& triangles) {
  std::map<std::pair<PointId, PointId>, int> balance;
  for (const IdTriangle& triangle : triangles)
    for (std::size_t i = 0; i < 3; ++i) {
      const PointId a = triangle[i], b = triangle[(i + 1) % 3];
      balance[std::minmax(a, b)] += a < b ? 1 : -1;
    }
  for (const auto& [edge, sum] : balance)
    if (sum != 0) return {edge.first, edge.second};
  return {};
}

}  // namespace tessera::surface
