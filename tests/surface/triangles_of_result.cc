#include "tests/surface/triangles_of_result.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <set>
#include <utility>

#include "src/job/engine_steps.h"
#include "src/surface/build.h"
#include "tests/store/sample_result.h"

namespace tessera::surface {

IdTriangle of_ids(PointId a, PointId b, PointId c) {
  IdTriangle triangle{a, b, c};
  std::rotate(triangle.begin(), std::min_element(triangle.begin(), triangle.end()), triangle.end());
  return triangle;
}

Triangles triangles_of(const std::filesystem::path& result, const SurfaceOptions& options) {
  Triangles found;
  const test::TemporaryFolder scratch;
  Engine engine(options.threads, options.memory_bytes, kinds_of_stages());
  Progress progress;
  EngineSteps steps(engine, {.threads = options.threads, .memory_bytes = options.memory_bytes, .resumable = false},
                    progress);
  const auto built =
      build(TileSource::open(result).value(), options, {.run = scratch.path(), .lock_file = {}}, false, steps, {}, {});
  if (!built && built.error().where.starts_with("there is no surface")) return found;
  EXPECT_TRUE(built) << built.error().where;
  found.added = built.value().split;
  found.handed_over = built.value().rays.handed_over;
  found.undecided = built.value().undecided;
  const auto triangles = TileSource::open(built.value().triangles).value();
  for (std::size_t i = 0; i < triangles.tiles(); ++i) {
    const StoredTile tile = triangles.read(i, {.rows = true}).value();
    const TileMesh& mesh = tile.mesh;
    const std::size_t width = row_bytes(tile.schema);
    for (std::size_t v = 0; v < mesh.points.size(); ++v) {
      Point at = mesh.points[v];
      std::memcpy(&at.z, tile.rows.data() + v * width, sizeof at.z);
      EXPECT_EQ(found.points.try_emplace(mesh.ids[v], at).first->second, at);
    }
    for (std::size_t j = 0; j < mesh.cell_ghost.size(); ++j) {
      const auto id = [&](std::size_t k) { return mesh.ids[static_cast<std::size_t>(mesh.cells[3 * j + k])]; };
      const IdTriangle triangle = of_ids(id(0), id(1), id(2));
      ++found.in_tiles[triangle];
      if (mesh.cell_ghost[j] == 0) found.main.push_back(triangle);
    }
  }
  std::sort(found.main.begin(), found.main.end());
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

std::string not_manifold(const std::vector<IdTriangle>& triangles) {
  std::map<std::pair<PointId, PointId>, int> edges;  // with their directions
  std::map<PointId, std::map<PointId, PointId>> around;
  for (const IdTriangle& triangle : triangles) {
    for (std::size_t i = 0; i < 3; ++i) {
      const PointId a = triangle[i], b = triangle[(i + 1) % 3], c = triangle[(i + 2) % 3];
      if (++edges[{a, b}] > 1) return "edge " + to_string(a) + "-" + to_string(b);
      around[a][b] = c;
    }
  }
  // A fan is one way round: it ends where it began, or it is open and begins where nothing leads to.
  for (const auto& [vertex, next] : around) {
    std::set<PointId> led_to;
    for (const auto& [from, to] : next) led_to.insert(to);
    PointId at = next.begin()->first;
    for (const auto& [from, to] : next)
      if (!led_to.contains(from)) at = from;
    std::set<PointId> seen;
    for (auto found = next.find(at); found != next.end() && seen.insert(found->first).second;)
      found = next.find(found->second);
    if (seen.size() != next.size()) return "vertex " + to_string(vertex);
  }
  return {};
}

}  // namespace tessera::surface
