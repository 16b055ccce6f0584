#include "src/tiling/tile/changed_points.h"

#include <algorithm>

namespace tessera {

bool ChangedPoints::begins() const {
  return std::any_of(fresh.begin(), fresh.end(), [](std::uint8_t f) { return f != 0; });
}

ChangedPoints change_points(const TileMesh& mesh, TileId self, const PointIds& removed,
                            std::span<const LocalPoint> added, const PointIds& filled) {
  ChangedPoints out;
  const std::size_t vertices = mesh.points.size();
  const auto corners = static_cast<std::size_t>(mesh.dimension) + 1;
  std::vector<std::uint8_t> gone(vertices), affected(vertices);
  bool any = false;
  for (std::size_t v = 0; v < vertices && !removed.empty(); ++v) {
    gone[v] = removed.contains(mesh.ids[v]) ? 1 : 0;
    any |= gone[v] != 0;
  }
  for (std::size_t at = 0; any && at < mesh.cells.size(); at += corners) {
    const std::int32_t* cell = &mesh.cells[at];
    if (std::none_of(cell, cell + corners, [&](std::int32_t v) { return gone[v] != 0; })) continue;
    const bool known = !filled.empty() && std::all_of(cell, cell + corners, [&](std::int32_t v) {
      return gone[v] == 0 || filled.contains(mesh.ids[v]);
    });
    out.reshaped |= known;
    for (std::size_t i = 0; i < corners && !known; ++i) affected[cell[i]] = 1;
  }
  for (std::size_t v = 0; v < vertices; ++v) {
    const bool own = mesh.owners[v] == self;
    out.lost |= own && gone[v] != 0;
    if (gone[v] != 0) continue;
    if (own) {
      out.own.push_back({mesh.points[v], mesh.ids[v]});
      out.fresh.push_back(affected[v]);
    } else {
      out.foreign.push_back({mesh.points[v], mesh.ids[v], mesh.owners[v], 0});
    }
  }
  out.own.insert(out.own.end(), added.begin(), added.end());
  out.fresh.resize(out.own.size(), 1);
  return out;
}

}  // namespace tessera
