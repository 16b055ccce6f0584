#include "tests/engine/checks.h"

#include <algorithm>
#include <array>
#include <stop_token>

#include "src/geometry/predicates/independent/predicates.h"
#include "src/result/tile_source.h"
#include "src/result/verify/verify.h"
#include "src/tiling/partition.h"

namespace tessera::testing {
namespace {

constexpr IdCell no_cell{infinite_id, infinite_id, infinite_id, infinite_id};

// The tile of every vertex, by source index.
using Owners = std::vector<TileId>;

TileId least_owner(const IdCell& cell, int corners, const Owners& owners) {
  TileId least{UINT32_MAX};
  for (int i = 0; i < corners; ++i) least = std::min(least, owners[cell[i].value]);
  return least;
}

// By tile, how many cells have a vertex there.
std::vector<std::uint64_t> cells_by_tile(const std::vector<IdCell>& cells, int corners, const Owners& owners,
                                         std::size_t tiles) {
  std::vector<std::uint64_t> counts(tiles, 0);
  for (const IdCell& cell : cells) {
    std::array<TileId, 4> in{};
    for (int i = 0; i < corners; ++i) in[i] = owners[cell[i].value];
    std::sort(in.begin(), in.begin() + corners);
    const auto end = std::unique(in.begin(), in.begin() + corners);
    for (auto tile = in.begin(); tile != end; ++tile) ++counts[tile->value];
  }
  return counts;
}

class TileFileCheck {
 public:
  TileFileCheck(const TileMesh& mesh, TileId tile, const Expected& expected, const Owners& owners)
      : m_(mesh), tile_(tile), expected_(expected), owners_(owners), corners_(mesh.dimension + 1) {}

  // Appends the main cells.
  std::string run(std::vector<IdCell>& main) const {
    if (auto wrong = vertices(); !wrong.empty()) return wrong;
    for (std::size_t c = 0; c < m_.cell_ghost.size(); ++c) {
      auto wrong = cell(c);
      if (wrong.empty()) wrong = neighbours(c);
      if (!wrong.empty()) return "cell " + std::to_string(c) + ": " + wrong;
      if (!m_.cell_ghost[c]) main.push_back(ids_of(c));
    }
    return "";
  }

 private:
  const std::int32_t* corner(std::size_t c) const { return &m_.cells[c * corners_]; }

  IdCell ids_of(std::size_t c, int without = -1) const {
    IdCell ids = no_cell;
    for (int i = 0; i < corners_; ++i) {
      if (i != without) ids[i] = m_.ids[corner(c)[i]];
    }
    std::sort(ids.begin(), ids.end());
    return ids;
  }

  std::string vertices() const {
    for (std::size_t i = 0; i < m_.points.size(); ++i) {
      const std::string at = "vertex " + std::to_string(i) + ": ";
      if (m_.ids[i].value >= expected_.points.size()) return at + "no such source index";
      if (m_.points[i] != expected_.points[m_.ids[i].value].at) return at + "not the coordinates of its source index";
      if ((owners_[m_.ids[i].value] != tile_) != (m_.point_ghost[i] != 0)) return at + "ghost flag";
      if (owners_[m_.ids[i].value] != m_.owners[i]) return at + "owner";
    }
    return "";
  }

  std::string cell(std::size_t c) const {
    const std::int32_t* v = corner(c);
    const auto& p = m_.points;
    const int sign = m_.dimension == 3 ? independent::orientation_3(p[v[0]], p[v[1]], p[v[2]], p[v[3]])
                                       : independent::orientation_2(p[v[0]], p[v[1]], p[v[2]]);
    if (sign <= 0) return "not positively oriented";
    const IdCell ids = ids_of(c);
    if (!std::binary_search(expected_.cells.begin(), expected_.cells.end(), ids)) return "not in the triangulation";
    if ((least_owner(ids, corners_, owners_) != tile_) != (m_.cell_ghost[c] != 0)) return "ghost flag";
    return "";
  }

  std::string neighbours(std::size_t c) const {
    for (int i = 0; i < corners_; ++i) {
      const std::int32_t n = m_.neighbors[c * corners_ + i];
      const std::string at = "neighbour " + std::to_string(i) + ": ";
      bool own = false;
      for (int k = 0; k < corners_; ++k) own |= k != i && m_.point_ghost[corner(c)[k]] == 0;
      const IdCell facet = ids_of(c, i);
      if (n == -2) {
        if (own) return at + "held by another tile, though the facet has a vertex of this one";
        continue;
      }
      const bool hull = std::binary_search(expected_.hull.begin(), expected_.hull.end(), facet);
      if (hull != (n == -1)) return at + (hull ? "a hull facet" : "not a hull facet");
      if (n == -1) continue;
      if (n < 0 || static_cast<std::size_t>(n) >= m_.cell_ghost.size()) return at + "out of range";
      const auto* back = &m_.neighbors[static_cast<std::size_t>(n) * corners_];
      const auto k = std::find(back, back + corners_, static_cast<std::int32_t>(c)) - back;
      if (k == corners_) return at + "does not know it";
      if (ids_of(static_cast<std::size_t>(n), static_cast<int>(k)) != facet) return at + "the facets differ";
    }
    return "";
  }

  const TileMesh& m_;
  TileId tile_;
  const Expected& expected_;
  const Owners& owners_;
  int corners_;
};

std::string wrong_counts(const EngineRun& run, const Expected& expected) {
  const Manifest& m = run.manifest;
  const auto differ = [](const char* what, std::uint64_t want, std::uint64_t got) {
    return want == got ? std::string() : what + (" " + std::to_string(got)) + " instead of " + std::to_string(want);
  };
  std::string wrong = differ("points read", expected.points.size(), m.points_read);
  if (wrong.empty()) wrong = differ("invalid points", expected.invalid, m.invalid);
  if (wrong.empty()) wrong = differ("vertices", expected.vertices, m.vertices);
  if (wrong.empty()) wrong = differ("cells", expected.cells.size(), m.cells);
  if (wrong.empty())
    wrong = differ("vertices + duplicates + rejects", m.points_read, m.vertices + m.duplicates + m.invalid);
  return wrong;
}

}  // namespace

Expected expected_of(std::vector<LocalPoint> points, int dimension) {
  Expected expected;
  std::vector<LocalPoint> finite;
  for (const LocalPoint& p : points) {
    if (is_finite(p.at)) finite.push_back(p);
  }
  expected.invalid = points.size() - finite.size();
  std::sort(finite.begin(), finite.end(),
            [](const LocalPoint& a, const LocalPoint& b) { return a.at != b.at ? a.at < b.at : a.id < b.id; });
  std::size_t kept = 0;
  for (std::size_t i = 0; i < finite.size(); ++i) {
    if (i > 0 && finite[i].at == finite[kept].at) {
      expected.duplicates.push_back({finite[i].id, finite[kept].id});
    } else {
      kept = i;
      ++expected.vertices;
    }
  }
  std::sort(expected.duplicates.begin(), expected.duplicates.end());
  for (const IdCell& cell : global_delaunay_with_hull(finite, dimension)) {
    (cell[dimension] == infinite_id ? expected.hull : expected.cells).push_back(cell);
  }
  expected.points = std::move(points);
  return expected;
}

std::string wrong_with(const EngineRun& run, const std::filesystem::path& out, const Expected& expected) {
  if (auto wrong = wrong_counts(run, expected); !wrong.empty()) return wrong;
  if (!expected.duplicates.empty()) {
    const auto duplicates = read_duplicates(out, Manifest{});
    if (!duplicates) return duplicates.error().where;
    if (duplicates.value() != expected.duplicates) return "other duplicates are listed";
  } else if (std::filesystem::exists(out / "duplicates.bin")) {
    return "there are no duplicates, but a file of them";
  }

  const int corners = run.routed.dimension + 1;
  Owners owners(expected.points.size(), TileId{UINT32_MAX});
  for (const LocalPoint& p : expected.points) {
    if (is_finite(p.at)) owners[p.id.value] = run.routed.partition.tile_of(p.at);
  }
  const auto source = TileSource::open(out);
  if (!source) return source.error().where;
  const auto partition = Partition::from_json(source.value().manifest().partition);
  if (!partition) return partition.error().where;
  for (const LocalPoint& p : expected.points)
    if (is_finite(p.at) && partition.value().tile_of(p.at) != owners[p.id.value])
      return "the manifest's partition gives point " + to_string(p.id) + " to another tile";
  const auto by_tile = cells_by_tile(expected.cells, corners, owners, run.routed.partition.tiles());
  std::vector<IdCell> main;
  main.reserve(expected.cells.size());
  std::uint64_t own_points = 0;
  for (const TileEntry& entry : run.manifest.tiles) {
    const std::string at = "tile " + to_string(entry.tile) + ": ";
    const auto index = source.value().find(entry.tile);
    if (!index) return at + "is not in the manifest that was written";
    const auto stored = source.value().read(*index, {});
    if (!stored) return stored.error().where;
    const TileMesh& mesh = stored.value().mesh;
    if (auto wrong = TileFileCheck(mesh, entry.tile, expected, owners).run(main); !wrong.empty()) return at + wrong;
    if (mesh.cell_ghost.size() != by_tile[entry.tile.value]) {
      return at + std::to_string(mesh.cell_ghost.size()) + " cells instead of " +
             std::to_string(by_tile[entry.tile.value]);
    }
    own_points += static_cast<std::uint64_t>(std::count(mesh.point_ghost.begin(), mesh.point_ghost.end(), 0));
  }
  if (own_points != expected.vertices) return "the tiles' own vertices are " + std::to_string(own_points);
  std::sort(main.begin(), main.end());
  if (auto wrong = difference(expected.cells, main); !wrong.empty()) return wrong;
  if (main.size() != expected.cells.size()) return "a cell is main twice";

  VerifyOptions options;
  options.scratch = out.parent_path();
  const auto verified = verify(out, options, std::stop_token{});
  if (!verified) return "verify: " + verified.error().where;
  return "";
}

}  // namespace tessera::testing
