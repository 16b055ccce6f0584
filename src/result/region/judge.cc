#include "src/result/region/judge.h"

#include <algorithm>
#include <array>
#include <span>

#include "src/base/stopped.h"
#include "src/result/region/meets.h"
#include "src/result/region/reach.h"

namespace tessera {
namespace {

class Judge {
 public:
  Judge(const GrowingTriangulation& triangulation, const CellList& cells, const Bounds& region,
        const RegionShape& shape, const UnitTree& unread, const std::stop_token& stop)
      : triangulation_(triangulation),
        cells_(cells),
        region_(region),
        shape_(shape),
        unread_(unread),
        check_(stop, cells_a_look),
        corners_(static_cast<std::size_t>(triangulation.dimension()) + 1) {
    judgement_.states.resize(cells.vertices.size() / corners_, CellState::elsewhere);
    sides_.push_back(everywhere);
    for (Vertex v = 1; v <= triangulation.vertices(); ++v) sides_.push_back(sides_of(triangulation.point(v)));
  }

  Judgement judge() {
    const std::size_t n = judgement_.states.size();
    for (std::size_t c = 0; c < n; ++c) {
      check_.step();
      if (infinite(c) == corners_) finite_cell(c);
    }
    for (std::size_t c = 0; c < n; ++c) {
      check_.step();
      if (infinite(c) < corners_) infinite_cell(c);
    }
    auto& units = judgement_.units;
    std::sort(units.begin(), units.end());
    units.erase(std::unique(units.begin(), units.end()), units.end());
    return std::move(judgement_);
  }

 private:
  using Simplex = std::array<Point, 4>;
  static constexpr std::uint8_t everywhere = 0xFF;
  // A shape with many edges takes a millisecond for a cell.
  static constexpr std::uint32_t cells_a_look = 256;

  // The corner of the infinite vertex; corners_ when there is none.
  std::size_t infinite(std::size_t c) const {
    const Vertex* v = &cells_.vertices[c * corners_];
    return static_cast<std::size_t>(std::find(v, v + corners_, infinite_vertex) - v);
  }
  Simplex simplex(std::size_t c) const {
    Simplex simplex{};
    for (std::size_t i = 0; i < corners_; ++i)
      if (const Vertex v = cells_.vertices[c * corners_ + i]; v != infinite_vertex)
        simplex[i] = triangulation_.point(v);
    return simplex;
  }
  std::span<const Point> points(const Simplex& simplex) const { return std::span(simplex).first(corners_); }

  // The sides of the region beyond which a point lies, as bits. Most cells have all vertices beyond one side, and these
  // bits show that.
  std::uint8_t sides_of(const Point& p) const {
    unsigned sides = 0;
    for (int axis = 0; axis + 1 < static_cast<int>(corners_); ++axis) {
      sides |= unsigned{p[axis] < region_.lo[axis]} << (2 * axis);
      sides |= unsigned{p[axis] > region_.hi[axis]} << (2 * axis + 1);
    }
    return static_cast<std::uint8_t>(sides);
  }

  void finite_cell(std::size_t c) {
    std::uint8_t beyond = everywhere;
    for (std::size_t i = 0; i < corners_; ++i) beyond &= sides_[cells_.vertices[c * corners_ + i]];
    if (beyond != 0) return;
    const Simplex cell = simplex(c);
    if (!meets(points(cell), region_) || (shape_ && !shape_(points(cell)))) return;
    ++judgement_.met;
    if (!settle(c, SphereReach(points(cell)))) ++judgement_.open;
  }

  void infinite_cell(std::size_t c) {
    const std::size_t k = infinite(c);
    const std::uint32_t behind = cells_.neighbors[c * corners_ + k];
    const Simplex cell = simplex(c);
    const HullReach reach(points(cell), k);
    const int side = reach.side(region_);
    // If the region only touches the facet, the finite cell behind the facet meets the region.
    if (side < 0 || (side == 0 && judgement_.states[behind] == CellState::elsewhere)) return;
    if (!settle(c, reach)) ++judgement_.hull_open;
  }

  template <class Reach>
  bool settle(std::size_t c, const Reach& reach) {
    const auto unit = unread_.nearest([&](const Bounds& box) { return reach.meets(box); });
    judgement_.states[c] = unit ? CellState::open : CellState::final;
    if (unit) judgement_.units.push_back(*unit);
    return !unit;
  }

  const GrowingTriangulation& triangulation_;
  const CellList& cells_;
  const Bounds& region_;
  const RegionShape& shape_;
  const UnitTree& unread_;
  StopCheck check_;
  std::size_t corners_;
  std::vector<std::uint8_t> sides_;  // by vertex
  Judgement judgement_;
};

}  // namespace

Judgement judge(const GrowingTriangulation& triangulation, const CellList& cells, const Bounds& region,
                const RegionShape& shape, const UnitTree& unread, const std::stop_token& stop) {
  return Judge(triangulation, cells, region, shape, unread, stop).judge();
}

}  // namespace tessera
