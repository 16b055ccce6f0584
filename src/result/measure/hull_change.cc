#include "src/result/measure/hull_change.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "src/result/verify/match_facets.h"

namespace tessera {

Result<bool> HullChange::any_on_hull(const TileMesh& mesh, TileId tile, const Which& which) const {
  if (mesh.neighbors.empty() && !mesh.cells.empty()) {  // a result without stored neighbours
    TileMesh matched = mesh;
    BOOST_OUTCOME_TRYV(match_facets(matched, old_.file(tile), stop_));
    return any_on_hull(matched, tile, which);
  }
  const std::size_t corners = static_cast<std::size_t>(mesh.dimension) + 1;
  for (std::size_t at = 0; at < mesh.cells.size(); at += corners) {
    for (std::size_t facet = 0; facet < corners; ++facet) {
      if (mesh.neighbors[at + facet] >= 0) continue;
      for (std::size_t k = 0; k < corners; ++k) {
        const auto v = static_cast<std::size_t>(mesh.cells[at + k]);
        if (k != facet && mesh.point_ghost[v] == 0 && which(mesh.ids[v])) return true;
      }
    }
  }
  return false;
}

Status HullChange::look_at_old(std::size_t index, const Which& gone) {
  BOOST_OUTCOME_TRY(stored, old_.stopped_by(stop_).read(index, {}));
  BOOST_OUTCOME_TRY(found, any_on_hull(stored.mesh, old_.entry(index).tile, gone));
  if (found) possible_ = true;
  return success();
}

Status HullChange::look_at(TileId tile, const TileMesh& now) {
  if (possible_) return success();
  std::vector<PointId> before, own;
  const auto index = old_.find(tile);
  if (index) {
    BOOST_OUTCOME_TRY(ids, old_.read_own_ids(*index));
    before = std::move(ids);
  }
  for (std::size_t v = 0; v < now.ids.size(); ++v) {
    if (now.point_ghost[v] == 0) own.push_back(now.ids[v]);
  }
  std::sort(before.begin(), before.end());
  std::sort(own.begin(), own.end());
  const auto outside = [](const std::vector<PointId>& ids) {
    return [&ids](PointId id) { return !std::binary_search(ids.begin(), ids.end(), id); };
  };
  BOOST_OUTCOME_TRY(come, any_on_hull(now, tile, outside(before)));
  if (come) possible_ = true;
  if (come || std::includes(own.begin(), own.end(), before.begin(), before.end())) return success();
  return look_at_old(*index, outside(own));
}

Status HullChange::look_at_gone(TileId tile) {
  const auto index = old_.find(tile);
  if (possible_ || !index) return success();
  return look_at_old(*index, [](PointId) { return true; });
}

}  // namespace tessera
