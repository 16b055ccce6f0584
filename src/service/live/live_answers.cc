#include "src/service/live/live_answers.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <utility>

#include "src/geometry/predicates/exact/predicates.h"
#include "src/result/query/dual.h"

namespace tessera::service {
namespace {

std::size_t corners_of(const LiveVersion& version) {
  return static_cast<std::size_t>(version.partition().dimension()) + 1;
}

std::array<PointId, 4> sorted_ids(const LiveCell& cell) {
  auto ids = cell.ids;
  std::sort(ids.begin(), ids.end());
  return ids;
}

query::Cell cell_of(const LiveCell& cell) {
  return {.tile = cell.tile, .cell = first_in_memory + static_cast<std::int32_t>(cell.row), .vertices = cell.ids};
}

query::Vertex vertex_of(const LiveVersion& version, PointId id, const Point& at) {
  return {id, version.ids().find(id).value_or(TileId{}), at};
}

// How many corners of the cell see p on the plane of their opposite facet; nothing if p is outside.
std::optional<int> touched_facets(const LiveCell& cell, const Point& p, std::size_t corners) {
  int touched = 0;
  for (std::size_t i = 0; i < corners; ++i) {
    auto at = cell.points;
    at[i] = p;
    const int sign =
        corners == 4 ? exact::orientation_3(at[0], at[1], at[2], at[3]) : exact::orientation_2(at[0], at[1], at[2]);
    if (sign < 0) return std::nullopt;
    touched += sign == 0 ? 1 : 0;
  }
  return touched;
}

// All cells that contain p are around each vertex of the face of `found` that has p in its inside.
LiveCell first_of_equal_right(const LiveVersion& version, const LiveCell& found, const Point& p) {
  const std::size_t corners = corners_of(version);
  if (touched_facets(found, p, corners).value_or(0) == 0) return found;
  LiveCell best = found;
  for (std::size_t i = 0; i < corners; ++i) {
    const auto star = version.star(found.ids[i]);
    if (!star) continue;
    for (const LiveCell& cell : *star) {
      if (!cell.is_finite(static_cast<int>(corners)) || !touched_facets(cell, p, corners)) continue;
      if (sorted_ids(cell) < sorted_ids(best)) best = cell;
    }
  }
  return best;
}

// As for a stored star: for each facet with the vertex, the Voronoi edge across it, seen from both sides.
double voronoi_volume_of(const std::vector<LiveCell>& star, PointId id, const Point& origin, std::size_t corners) {
  using query::Vec;
  using query::Wide;
  std::map<std::array<PointId, 4>, std::vector<std::size_t>> beside;  // cells by facet
  std::vector<std::vector<Vec<Wide>>> at(star.size());
  std::vector<Vec<Wide>> centre;
  const auto facet_of = [&](const LiveCell& cell, std::size_t corner) {
    auto ids = cell.ids;
    ids[corner] = LiveCell::infinite;
    std::sort(ids.begin(), ids.end());
    return ids;
  };
  for (std::size_t c = 0; c < star.size(); ++c) {
    for (std::size_t k = 0; k < corners; ++k) {
      at[c].push_back(query::relative<Wide>(star[c].points[k], origin));
      if (star[c].ids[k] != id) beside[facet_of(star[c], k)].push_back(c);
    }
    const auto found = query::circumcentre<Wide>(at[c]);
    if (!found) return std::numeric_limits<double>::quiet_NaN();
    centre.push_back(*found);
  }
  Wide volume = 0;
  for (std::size_t c = 0; c < star.size(); ++c) {
    for (std::size_t k = 0; k < corners; ++k) {
      if (star[c].ids[k] == id) continue;
      const auto& pair = beside[facet_of(star[c], k)];
      if (pair.size() != 2) return std::numeric_limits<double>::infinity();
      std::array<Vec<Wide>, 3> facet;
      std::size_t here = 0;
      for (std::size_t i = 0; i + 1 < corners; ++i) {
        const std::size_t corner = query::facet_corner(corners, k, i);
        facet[i] = at[c][corner];
        if (star[c].ids[corner] == id) here = i;
      }
      const std::size_t beyond = pair[0] == c ? pair[1] : pair[0];
      volume += query::edge_shares<Wide>({facet.data(), corners - 1}, centre[c], centre[beyond])[here] / 2;
    }
  }
  return std::abs(static_cast<double>(query::rounded(volume)));
}

Error no_such_vertex(const LiveVersion& version, PointId id) {
  return error(Errc::usage, "version " + std::to_string(version.number()) + " has no vertex " + to_string(id) +
                                "; a point that is equal to another one is no vertex");
}

}  // namespace

Result<std::vector<query::Cell>> live_locate(const LiveVersion& version, std::span<const Point> points,
                                             const query::AskOptions& options) {
  std::vector<query::Cell> out;
  out.reserve(points.size());
  for (const Point& p : points) {
    if (options.stop.stop_requested()) return error(Errc::interrupted, "interrupted while points were located");
    const auto found = version.locate(p);
    out.push_back(found ? cell_of(first_of_equal_right(version, *found, p)) : query::Cell{});
  }
  return out;
}

Result<query::CellDetails> live_details(const LiveVersion& version, const query::Cell& cell) {
  const std::size_t corners = corners_of(version);
  LiveCell here;
  here.ids = cell.vertices;
  here.tile = cell.tile;
  here.row = static_cast<std::uint32_t>(cell.cell - first_in_memory);
  query::CellDetails details;
  details.cell = cell;
  for (std::size_t i = 0; i < corners; ++i) {
    const auto at = version.point(here.ids[i]);
    if (!at) return no_such_vertex(version, here.ids[i]);
    details.vertices.push_back(vertex_of(version, here.ids[i], *at));
    const LiveCell next = version.across(here, static_cast<int>(i));
    details.neighbors.push_back(next.is_finite(static_cast<int>(corners)) ? cell_of(next) : query::Cell{});
  }
  return details;
}

Result<query::Star> live_star(const LiveVersion& version, PointId id) {
  const std::size_t corners = corners_of(version);
  const auto cells = version.star(id);
  const auto at = version.point(id);
  if (!cells || !at) return no_such_vertex(version, id);
  std::vector<LiveCell> finite;
  for (const LiveCell& cell : *cells)
    if (cell.is_finite(static_cast<int>(corners))) finite.push_back(cell);
  std::sort(finite.begin(), finite.end(),
            [](const LiveCell& a, const LiveCell& b) { return sorted_ids(a) < sorted_ids(b); });
  query::Star star;
  star.vertex = vertex_of(version, id, *at);
  std::map<PointId, Point> around;
  for (const LiveCell& cell : finite) {
    star.cells.push_back(cell_of(cell));
    for (std::size_t k = 0; k < corners; ++k)
      if (cell.ids[k] != id) around[cell.ids[k]] = cell.points[k];
  }
  for (const auto& [neighbour, where] : around) star.neighbors.push_back(vertex_of(version, neighbour, where));
  star.voronoi_volume = finite.size() == cells->size() ? voronoi_volume_of(finite, id, *at, corners)
                                                       : std::numeric_limits<double>::infinity();
  return star;
}

Result<query::Neighbours> live_neighbours(const LiveVersion& version, PointId id) {
  const std::size_t corners = corners_of(version);
  const auto cells = version.star(id);
  if (!cells) return no_such_vertex(version, id);
  query::Neighbours told{.asked = id, .vertex = id, .ids = {}};
  for (const LiveCell& cell : *cells) {
    for (std::size_t k = 0; k < corners; ++k) {
      if (cell.ids[k] == LiveCell::infinite) told.on_hull = true;
      if (cell.ids[k] != LiveCell::infinite && cell.ids[k] != id) told.ids.push_back(cell.ids[k]);
    }
  }
  std::sort(told.ids.begin(), told.ids.end());
  told.ids.erase(std::unique(told.ids.begin(), told.ids.end()), told.ids.end());
  return told;
}

}  // namespace tessera::service
