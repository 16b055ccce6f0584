// Voronoi cells in 3D. The parts of each Delaunay cell are computed once, for all of its own vertices, and added up in
// sums that do not depend on the order of the cells. Where the error can be too large, the cell or the vertex is
// computed with more bits.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "src/geometry/mesh/image_order.h"
#include "src/result/measure/cell_parts.h"
#include "src/result/measure/level_sum.h"
#include "src/result/measure/twofold.h"
#include "src/result/measure/values.h"
#include "src/result/measure/voronoi_cells.h"
#include "src/result/measure/voronoi_part.h"

namespace tessera::voronoi {
namespace {

using query::Long;
using query::Wide;

constexpr Long accepted = 1e-13L;  // the relative error of a volume
// Up to these flatnesses the parts of a cell are computed with 64 bits, and with 128.
constexpr Long quick_flatness = 0x1p13L, fine_flatness = 0x1p70L;

// The sum of parts; `error` is that of the volumes.
class PartSum {
 public:
  void add(const VoronoiPart<Long>& part, Long error) {
    volume_.add(part.volume);
    surface_.add(part.surface);
    moment_[0].add(part.moment.x);
    moment_[1].add(part.moment.y);
    moment_[2].add(part.moment.z);
    error_.add(error);
    ++parts_;
  }
  std::uint32_t parts() const { return parts_; }
  VoronoiPart<Long> value() const {
    return {.volume = volume_.value(),
            .surface = surface_.value(),
            .moment = {moment_[0].value(), moment_[1].value(), moment_[2].value()},
            .doubt = error_.value() + static_cast<Long>(parts_) * (error_.lowest() + volume_.lowest())};
  }

 private:
  LevelSum<3> volume_, surface_;
  std::array<LevelSum<3>, 3> moment_;
  LevelSum<2> error_;
  std::uint32_t parts_ = 0;
};

class SpaceCells {
 public:
  explicit SpaceCells(const TileMesh& mesh) : mesh_(mesh) {
    std::size_t end = mesh.points.size();
    while (end > 0 && mesh.point_ghost[end - 1] != 0) --end;  // own vertices come first
    sums_.resize(end);
    borders_.resize(end);
  }

  Status run(const std::stop_token& stop, const TakeCell& take) {
    for (std::size_t cell = 0; cell < mesh_.cell_ghost.size(); ++cell) {
      BOOST_OUTCOME_TRYV(go_on(stop, cell));
      add(static_cast<std::uint32_t>(cell));
    }
    std::vector<std::uint8_t> hard(mesh_.points.size(), 0);
    bool any = false;
    for (std::size_t v = 0; v < sums_.size(); ++v) {
      if (!is_own(v)) continue;
      if (const auto cell = quick_cell(v)) {
        take(v, *cell);
      } else {
        hard[v] = 1;
        any = true;
      }
    }
    return any ? run_hard(hard, stop, take) : success();
  }

 private:
  // The facets on the hull, and whether there are others beyond which nothing is known.
  struct Borders {
    std::uint32_t hull : 31 = 0;
    bool unknown : 1 = false;
  };
  using Corners = std::array<std::int32_t, 4>;

  bool is_own(std::size_t vertex) const { return mesh_.point_ghost[vertex] == 0; }

  // The vertices of a cell in their order (image_order.h), but for the last two, which give the orientation. So a cell
  // has the same bits wherever it is stored.
  Corners corners_of(std::uint32_t cell) const {
    Corners corners;
    std::array<ImageOrder, 4> order;
    for (std::size_t k = 0; k < 4; ++k) {
      corners[k] = mesh_.cells[4 * std::size_t{cell} + k];
      order[k] = image_order(mesh_, static_cast<std::size_t>(corners[k]));
    }
    bool odd = false;
    for (std::size_t i = 1; i < 4; ++i) {
      for (std::size_t j = i; j > 0 && order[j] < order[j - 1]; --j) {
        std::swap(order[j], order[j - 1]);
        std::swap(corners[j], corners[j - 1]);
        odd = !odd;
      }
    }
    if (odd) std::swap(corners[2], corners[3]);
    return corners;
  }
  std::array<Point, 4> points_of(const Corners& corners) const {
    std::array<Point, 4> points;
    for (std::size_t k = 0; k < 4; ++k) points[k] = mesh_.points[static_cast<std::size_t>(corners[k])];
    return points;
  }

  void add(std::uint32_t cell) {
    const Corners corners = corners_of(cell);
    const auto points = points_of(corners);
    const CellParts<Long> quick(points);
    if (quick.flatness() > 0 && quick.flatness() <= quick_flatness) {
      add(corners, quick, std::numeric_limits<Long>::epsilon());
    } else {
      const CellParts<Twofold> fine(points);
      if (fine.flatness() > 0 && fine.flatness() <= fine_flatness)
        add(corners, fine, Twofold::epsilon());
      else
        add(corners, CellParts<Wide>(points), std::numeric_limits<Wide>::epsilon().convert_to<Long>());
    }
    add_borders(cell);
  }

  template <class Number>
  void add(const Corners& corners, const CellParts<Number>& parts, Long epsilon) {
    for (std::size_t k = 0; k < 4; ++k) {
      const auto v = static_cast<std::size_t>(corners[k]);
      if (!is_own(v)) continue;
      const auto exact = parts.of(k);
      const VoronoiPart<Long> part{
          .volume = long_of(exact.volume),
          .surface = long_of(exact.surface),
          .moment = {long_of(exact.moment.x), long_of(exact.moment.y), long_of(exact.moment.z)}};
      sums_[v].add(part, epsilon * exact.doubt + std::numeric_limits<Long>::epsilon() * std::abs(part.volume));
    }
  }

  void add_borders(std::uint32_t cell) {
    const auto at = std::span(mesh_.cells).subspan(4 * std::size_t{cell}, 4);
    for (std::size_t facet = 0; facet < 4; ++facet) {
      const std::int32_t beyond = mesh_.neighbors[4 * std::size_t{cell} + facet];
      if (beyond >= 0) continue;
      for (std::size_t k = 0; k < 4; ++k) {
        const auto v = static_cast<std::size_t>(at[k]);
        if (k == facet || !is_own(v)) continue;
        if (beyond == -1)
          ++borders_[v].hull;
        else
          borders_[v].unknown = true;
      }
    }
  }

  // Nothing when this takes more bits, or a look at all cells around the vertex.
  std::optional<VoronoiCell> quick_cell(std::size_t vertex) const {
    const PartSum& sum = sums_[vertex];
    const Borders& border = borders_[vertex];
    if (border.unknown) return std::nullopt;
    // The facets opposite the vertex are triangles that close around it, but for a hole of as many sides as there are
    // facets on the hull. So by Euler's formula the numbers of triangles and sides give that of the corners.
    if (border.hull > 0) return open_cell(Border::hull, 1 + (sum.parts() + border.hull) / 2);
    const VoronoiPart<Long> all = sum.value();
    if (!(all.volume > 0 && all.doubt <= accepted * all.volume && is_finite(all))) return std::nullopt;
    VoronoiCell cell{.neighbours = 2 + sum.parts() / 2};
    fill(cell, mesh_.points[vertex], 3, all);
    return cell;
  }
  static bool is_finite(const VoronoiPart<Long>& part) {
    return std::isfinite(part.volume) && std::isfinite(part.surface) && std::isfinite(part.moment.x) &&
           std::isfinite(part.moment.y) && std::isfinite(part.moment.z);
  }

  Status run_hard(const std::vector<std::uint8_t>& hard, const std::stop_token& stop, const TakeCell& take) {
    const Stars stars(mesh_, [&](std::size_t v) { return hard[v] != 0; });
    for (std::size_t v = 0; v < hard.size(); ++v) {
      if (hard[v] == 0) continue;
      BOOST_OUTCOME_TRYV(go_on(stop, 0));
      const auto star = stars.of(v);
      const std::uint32_t neighbours = count_neighbours(mesh_, v, star);
      take(v, borders_[v].unknown ? open_cell(Border::unknown, neighbours) : fine_cell(v, star, neighbours));
    }
    return success();
  }

  VoronoiCell fine_cell(std::size_t vertex, std::span<const std::uint32_t> star, std::uint32_t neighbours) const {
    VoronoiCell cell{.neighbours = neighbours};
    const Point& at = mesh_.points[vertex];
    const auto fine = sum_of<Twofold>(vertex, star);
    if (fine.volume > 0 && Twofold::epsilon() * fine.doubt <= accepted * long_of(fine.volume))
      fill(cell, at, 3, fine);
    else
      fill(cell, at, 3, sum_of<Wide>(vertex, star));
    return cell;
  }

  template <class Number>
  VoronoiPart<Number> sum_of(std::size_t vertex, std::span<const std::uint32_t> star) const {
    std::vector<VoronoiPart<Number>> parts;
    parts.reserve(star.size());
    for (const std::uint32_t cell : star) {
      const Corners corners = corners_of(cell);
      const auto at = std::find(corners.begin(), corners.end(), static_cast<std::int32_t>(vertex)) - corners.begin();
      parts.push_back(CellParts<Number>(points_of(corners)).of(static_cast<std::size_t>(at)));
    }
    // From the least value to the greatest, so that the order of the cells does not matter.
    std::sort(parts.begin(), parts.end(), [](const auto& a, const auto& b) {
      if (!(a.volume == b.volume)) return a.volume < b.volume;
      if (!(a.surface == b.surface)) return a.surface < b.surface;
      if (!(a.moment.x == b.moment.x)) return a.moment.x < b.moment.x;
      if (!(a.moment.y == b.moment.y)) return a.moment.y < b.moment.y;
      return a.moment.z < b.moment.z;
    });
    VoronoiPart<Number> sum;
    for (const auto& part : parts) sum.add(part);
    return sum;
  }

  const TileMesh& mesh_;
  std::vector<PartSum> sums_;     // by vertex
  std::vector<Borders> borders_;  // likewise
};

}  // namespace

Status space_cells(const TileMesh& mesh, const std::stop_token& stop, const TakeCell& take) {
  return SpaceCells(mesh).run(stop, take);
}

}  // namespace tessera::voronoi
