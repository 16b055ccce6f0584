#include "src/surface/triangles.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <functional>
#include <utility>

namespace tessera::surface {

void give_labels(const SurfaceTile& tile, std::span<const Label> labels,
                 const std::function<void(TileId, const LabelRecord&)>& label) {
  for (std::int32_t cell = 0; cell < tile.cells(); ++cell) {
    if (!tile.is_main(cell)) continue;
    std::array<TileId, 4> owners;
    for (std::size_t k = 0; k < 4; ++k) owners[k] = tile.owner(tile.vertex(cell, k));
    std::sort(owners.begin(), owners.end());
    for (std::size_t k = 0; k < 4; ++k) {
      if (owners[k] == tile.self() || (k > 0 && owners[k] == owners[k - 1])) continue;
      label(owners[k], {tile.name(cell), labels[static_cast<std::size_t>(cell)] == Label::outside ? 1u : 0u});
    }
  }
}

namespace {

class Collector {
 public:
  Collector(const SurfaceTile& tile, std::span<const Label> labels, const CutRule& rule, const Boundary& boundary)
      : tile_(tile), labels_(labels), rule_(rule), boundary_(boundary) {}

  std::vector<SurfaceFacet> collect() {
    for (std::int32_t cell = 0; cell < tile_.cells(); ++cell)
      for (std::uint8_t k = 0; k < 4; ++k) look_at(cell, k);
    return std::move(facets_);
  }

 private:
  bool outside(std::int32_t cell) const { return labels_[static_cast<std::size_t>(cell)] == Label::outside; }

  void look_at(std::int32_t cell, std::uint8_t k) {
    const std::int32_t across = tile_.neighbor(cell, k);
    if (across == SurfaceTile::elsewhere) return;
    if (across == SurfaceTile::outside) {
      const bool beyond = boundary_.below || !is_inside_beyond(tile_, cell, k, rule_);
      if (outside(cell) != beyond) add({cell, k, beyond});
    } else if (!outside(cell) && outside(across)) {
      add({cell, k, true});
    }
  }

  void add(const SurfaceFacet& facet) {
    const auto at = vertices_of(tile_, facet);
    if (std::none_of(at.begin(), at.end(), [&](std::int32_t v) { return v < tile_.own_vertices(); })) return;
    if (boundary_.trim && longest(at) > *boundary_.trim) return;
    facets_.push_back(facet);
  }

  // Returns the longest edge. Lengths are rounded, but the edges are taken in the order of the vertices' ids, so all
  // tiles agree.
  double longest(std::array<std::int32_t, 3> at) const {
    std::sort(at.begin(), at.end(), [&](std::int32_t a, std::int32_t b) { return tile_.id(a) < tile_.id(b); });
    double most = 0;
    for (std::size_t i = 0; i < 3; ++i) {
      const Point &p = tile_.point(at[i]), &q = tile_.point(at[(i + 1) % 3]);
      const double x = p.x - q.x, y = p.y - q.y, z = p.z - q.z;
      most = std::max(most, std::sqrt(x * x + y * y + z * z));
    }
    return most;
  }

  const SurfaceTile& tile_;
  std::span<const Label> labels_;
  const CutRule& rule_;
  const Boundary& boundary_;
  std::vector<SurfaceFacet> facets_;
};

}  // namespace

std::array<std::int32_t, 3> vertices_of(const SurfaceTile& tile, const SurfaceFacet& facet) {
  std::array<std::int32_t, 3> at;
  for (std::size_t i = 0; i < 3; ++i) at[i] = tile.vertex(facet.cell, facet_corners[facet.corner][i]);
  if (!facet.outwards) std::swap(at[1], at[2]);
  return at;
}

TriangleName name_of(const SurfaceTile& tile, const SurfaceFacet& facet) {
  const auto at = vertices_of(tile, facet);
  TriangleName name{tile.id(at[0]), tile.id(at[1]), tile.id(at[2])};
  std::sort(name.begin(), name.end());
  return name;
}

Result<std::vector<SurfaceFacet>> facets_of(const SurfaceTile& tile, std::span<const Label> labels, const CutRule& rule,
                                            const Boundary& boundary) {
  for (std::size_t cell = 0; cell < labels.size(); ++cell)
    if (labels[cell] == Label::unknown)
      return tile.corrupt("it is not known whether cell " + std::to_string(cell) + " is outside");
  return Collector(tile, labels, rule, boundary).collect();
}

StoredTile triangles_of(const SurfaceTile& tile, std::span<const SurfaceFacet> facets) {
  std::vector<std::array<std::int32_t, 3>> triangles;
  for (const SurfaceFacet& facet : facets) triangles.push_back(vertices_of(tile, facet));
  const TileMesh& from = tile.mesh();
  std::vector<std::int32_t> number(from.points.size(), -1);
  for (const auto& triangle : triangles)
    for (const std::int32_t v : triangle) number[static_cast<std::size_t>(v)] = 0;
  StoredTile out;
  out.schema = {{"z", AttributeType::f64}};
  out.schema.insert(out.schema.end(), tile.stored().schema.begin(), tile.stored().schema.end());
  const std::size_t width = row_bytes(tile.stored().schema);
  TileMesh& mesh = out.mesh;
  mesh.dimension = 2;
  for (std::size_t v = 0; v < number.size(); ++v) {
    if (number[v] < 0) continue;
    number[v] = static_cast<std::int32_t>(mesh.points.size());
    const Point& p = from.points[v];
    mesh.points.push_back({p.x, p.y, 0});
    mesh.ids.push_back(from.ids[v]);
    mesh.owners.push_back(from.owners[v]);
    mesh.point_ghost.push_back(from.point_ghost[v]);
    const auto height = std::as_bytes(std::span(&p.z, 1));
    out.rows.insert(out.rows.end(), height.begin(), height.end());
    const auto row = std::span(tile.stored().rows).subspan(v * width, width);
    out.rows.insert(out.rows.end(), row.begin(), row.end());
  }
  for (auto& triangle : triangles)
    for (std::int32_t& v : triangle) v = number[static_cast<std::size_t>(v)];
  put_triangles(std::move(triangles), tile.self(), mesh);
  return out;
}

void put_triangles(std::vector<std::array<std::int32_t, 3>> triangles, TileId self, TileMesh& mesh) {
  for (auto& triangle : triangles)
    std::rotate(triangle.begin(), std::min_element(triangle.begin(), triangle.end()), triangle.end());
  std::sort(triangles.begin(), triangles.end());
  mesh.cells.clear();
  mesh.cell_ghost.clear();
  for (const auto& triangle : triangles) {
    TileId main = self;
    for (const std::int32_t v : triangle) {
      mesh.cells.push_back(v);
      main = std::min(main, mesh.owners[static_cast<std::size_t>(v)]);
    }
    mesh.cell_ghost.push_back(main == self ? 0 : 1);
  }
}

}  // namespace tessera::surface
