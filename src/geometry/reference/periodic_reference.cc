#include "src/geometry/reference/periodic_reference.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "src/geometry/reference/differing_cells.h"
#include "src/geometry/reference/reference.h"

namespace tessera {
namespace {

PeriodicCell canonical(PeriodicCell cell, int corners) {
  const auto end = cell.begin() + corners;
  const PeriodOffset first = std::min_element(cell.begin(), end)->second;
  for (auto v = cell.begin(); v != end; ++v) v->second = v->second - first;
  std::sort(cell.begin(), end);
  return cell;
}

std::string text_of(const PeriodicCell& cell) {
  std::string out;
  for (const auto& [id, o] : cell) {
    out += (out.empty() ? "(" : " ") + to_string(id);
    if (o == PeriodOffset{}) continue;
    out += "[" + std::to_string(o.by[0]) + " " + std::to_string(o.by[1]) + " " + std::to_string(o.by[2]) + "]";
  }
  return out + ")";
}

}  // namespace

std::vector<PeriodicCell> periodic_delaunay(const PeriodicCloud& cloud, int copies) {
  // Copies have ids of their own.
  const auto along = [&](std::size_t axis) { return cloud.period.length[axis] > 0 ? copies / 2 : 0; };
  std::vector<LocalPoint> all;
  std::vector<std::pair<PointId, PeriodOffset>> what;
  for (int x = -along(0); x <= along(0); ++x) {
    for (int y = -along(1); y <= along(1); ++y) {
      for (int z = -along(2); z <= along(2); ++z) {
        for (const LocalPoint& p : cloud.points) {
          const PeriodOffset o{{x, y, z}};
          all.push_back({cloud.period.shifted(p.at, o), PointId{all.size()}});
          what.emplace_back(p.id, o);
        }
      }
    }
  }
  const auto corners = static_cast<std::size_t>(cloud.dimension) + 1;
  std::vector<PeriodicCell> out;
  for (const IdCell& cell : global_delaunay(all, cloud.dimension)) {
    PeriodicCell c{};
    bool here = false;
    for (std::size_t i = 0; i < corners; ++i) {
      c[i] = what[cell[i].value];
      here |= c[i].second == PeriodOffset{};
    }
    if (here) out.push_back(canonical(c, cloud.dimension + 1));
  }
  std::sort(out.begin(), out.end());
  out.erase(std::unique(out.begin(), out.end()), out.end());
  return out;
}

std::vector<PeriodicCell> periodic_main_cells(std::span<const TileMesh> meshes) {
  std::vector<PeriodicCell> out;
  for (const TileMesh& mesh : meshes) {
    const auto corners = static_cast<std::size_t>(mesh.dimension) + 1;
    for (std::size_t c = 0; c < mesh.cell_ghost.size(); ++c) {
      if (mesh.cell_ghost[c] != 0) continue;
      PeriodicCell cell{};
      for (std::size_t i = 0; i < corners; ++i) {
        const auto v = static_cast<std::size_t>(mesh.cells[c * corners + i]);
        cell[i] = {mesh.ids[v], image::offset(mesh.offsets.empty() ? 0 : mesh.offsets[v])};
      }
      out.push_back(canonical(cell, mesh.dimension + 1));
    }
  }
  std::sort(out.begin(), out.end());
  return out;
}

std::string difference(const std::vector<PeriodicCell>& expected, const std::vector<PeriodicCell>& got) {
  return differing_cells(expected, got, [](const PeriodicCell& cell) { return text_of(cell); });
}

PeriodicCloud wrapped(int dimension, std::span<const LocalPoint> points, const Period& period) {
  double extent = 1;
  Bounds bounds;
  for (const LocalPoint& p : points) bounds.add(p.at);
  for (int axis = 0; axis < dimension; ++axis) {
    extent = std::max({extent, bounds.hi[axis] - bounds.lo[axis], period.length[static_cast<std::size_t>(axis)]});
  }
  const double step = std::ldexp(1.0, std::ilogb(extent) - 30);
  const auto rounded = [&](double x) { return std::floor(x / step) * step; };
  PeriodicCloud out{dimension, period, {}};
  for (double& length : out.period.length) length = rounded(length);
  for (LocalPoint p : points) {
    for (int axis = 0; axis < dimension; ++axis) {
      const double length = out.period.length[static_cast<std::size_t>(axis)];
      p.at[axis] = rounded(p.at[axis] - bounds.lo[axis]);
      if (length > 0) p.at[axis] = std::fmod(p.at[axis], length);
    }
    out.points.push_back(p);
  }
  std::stable_sort(out.points.begin(), out.points.end(),
                   [](const LocalPoint& a, const LocalPoint& b) { return a.at < b.at; });
  out.points.erase(std::unique(out.points.begin(), out.points.end(),
                               [](const LocalPoint& a, const LocalPoint& b) { return a.at == b.at; }),
                   out.points.end());
  std::sort(out.points.begin(), out.points.end(), [](const LocalPoint& a, const LocalPoint& b) { return a.id < b.id; });
  return out;
}

}  // namespace tessera
