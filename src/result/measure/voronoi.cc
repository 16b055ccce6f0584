#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "src/geometry/mesh/image_order.h"
#include "src/geometry/predicates/exact/predicates.h"
#include "src/result/measure/values.h"
#include "src/result/measure/voronoi_part.h"
#include "src/result/verify/match_facets.h"

namespace tessera {
namespace {

using query::Long;
using query::Quad;
using query::Vec;
using query::Wide;

// What is known of a vertex's Voronoi cell.
struct VoronoiCell {
  double volume = 0, surface = 0;
  std::array<double, 3> centroid{};
  std::uint32_t neighbours = 0;
};

class VoronoiCells {
 public:
  explicit VoronoiCells(const TileMesh& mesh)
      : mesh_(mesh), corners_(static_cast<std::size_t>(mesh.dimension) + 1), stars_(mesh) {}

  VoronoiCell of(std::size_t vertex) {
    VoronoiCell cell;
    const auto star = stars_.of(vertex);
    if (corners_ == 3 && find_ring(vertex, star)) {
      cell.neighbours = static_cast<std::uint32_t>(ring_.size());
      measure(cell, vertex, [&](auto number) { return sum_of_ring<decltype(number)>(vertex); });
      return cell;
    }
    cell.neighbours = count_neighbours(vertex, star);
    const Border border = border_of(vertex, star);
    if (border != Border::none) {
      const double value = border == Border::hull ? std::numeric_limits<double>::infinity() : nan_;
      cell.volume = cell.surface = value;
      cell.centroid = {nan_, nan_, nan_};
      return cell;
    }
    measure(cell, vertex, [&](auto number) { return sum_of<decltype(number)>(vertex, star); });
    return cell;
  }

 private:
  enum class Border : std::uint8_t { none, hull, unknown };
  static constexpr double nan_ = std::numeric_limits<double>::quiet_NaN();

  // Computes with as many bits as the flatness of the cells asks for. `sum` gets a number of the kind to compute with.
  // A few dozen operations stand behind each part.
  template <class Sum>
  void measure(VoronoiCell& cell, std::size_t vertex, const Sum& sum) const {
    const Long accepted = corners_ == 3 ? 1e-15L : 1e-13L;
    const VoronoiPart<Long> quick = sum(Long());
    if (is_within(quick, std::numeric_limits<Long>::epsilon(), accepted)) return fill(cell, vertex, quick);
    if (corners_ == 4) {
      const VoronoiPart<Quad> finer = sum(Quad());
      const auto bits = std::numeric_limits<Quad>::epsilon().convert_to<Long>();
      if (is_within(finer, bits, accepted)) return fill(cell, vertex, finer);
    }
    fill(cell, vertex, sum(Wide()));
  }

  // Whether rounding errors of 32 times `epsilon` in each operation change the volume by less than its share
  // `accepted`.
  template <class Number>
  static bool is_within(const VoronoiPart<Number>& part, Long epsilon, Long accepted) {
    return part.volume > 0 && 32 * epsilon * part.doubt <= accepted * query::rounded(part.volume);
  }

  // In 2D, finds the neighbours counterclockwise, from the least one (image_order.h): so sums over them have the same
  // bits wherever the cells are stored. Returns false when the cells around the vertex are not a ring: it is on
  // the hull, or not all cells are known.
  bool find_ring(std::size_t vertex, std::span<const std::uint32_t> star) {
    ring_.clear();
    if (star.empty()) return false;
    const auto corner_of = [&](std::uint32_t cell) {
      std::size_t k = 0;
      while (k < 2 && static_cast<std::size_t>(vertex_at(cell, k)) != vertex) ++k;
      return k;
    };
    std::uint32_t first = star.front();
    const auto next_to = [&](std::uint32_t cell) {
      return image_order(mesh_, static_cast<std::size_t>(vertex_at(cell, (corner_of(cell) + 1) % 3)));
    };
    for (const std::uint32_t cell : star)
      if (next_to(cell) < next_to(first)) first = cell;
    std::uint32_t cell = first;
    do {
      const std::size_t own = corner_of(cell);
      if (ring_.size() == star.size() || static_cast<std::size_t>(vertex_at(cell, own)) != vertex) return false;
      ring_.push_back(vertex_at(cell, (own + 1) % 3));
      const std::int32_t beyond = mesh_.neighbors[cell * 3 + (own + 1) % 3];
      if (beyond < 0) return false;
      cell = static_cast<std::uint32_t>(beyond);
    } while (cell != first);
    return ring_.size() == star.size();
  }

  template <class Number>
  VoronoiPart<Number> sum_of_ring(std::size_t vertex) const {
    constexpr std::size_t usual = 24;
    std::array<Vec<Number>, usual> few;
    std::vector<Vec<Number>> many;
    if (ring_.size() > usual) many.resize(ring_.size());
    const std::span<Vec<Number>> corners = ring_.size() > usual ? std::span(many) : std::span(few).first(ring_.size());
    const Point& at = mesh_.points[vertex];
    for (std::size_t k = 0; k < ring_.size(); ++k) {
      const Point& p = mesh_.points[static_cast<std::size_t>(ring_[k])];
      corners[k].x = Number(p.x) - Number(at.x);
      corners[k].y = Number(p.y) - Number(at.y);
    }
    return voronoi::cell_2<Number>(corners);
  }

  std::int32_t vertex_at(std::uint32_t cell, std::size_t k) const { return mesh_.cells[cell * corners_ + k]; }

  std::uint32_t count_neighbours(std::size_t vertex, std::span<const std::uint32_t> star) {
    near_.clear();
    for (const std::uint32_t cell : star)
      for (std::size_t k = 0; k < corners_; ++k)
        if (static_cast<std::size_t>(vertex_at(cell, k)) != vertex) near_.push_back(vertex_at(cell, k));
    std::sort(near_.begin(), near_.end());
    return static_cast<std::uint32_t>(std::unique(near_.begin(), near_.end()) - near_.begin());
  }

  // Whether a facet with the vertex is on the hull, or leads to a cell that is not known here.
  Border border_of(std::size_t vertex, std::span<const std::uint32_t> star) const {
    Border border = Border::none;
    for (const std::uint32_t cell : star) {
      for (std::size_t k = 0; k < corners_; ++k) {
        if (static_cast<std::size_t>(vertex_at(cell, k)) == vertex) continue;
        const std::int32_t beyond = mesh_.neighbors[cell * corners_ + k];
        if (beyond < -1) return Border::unknown;
        if (beyond == -1) border = Border::hull;
      }
    }
    return border;
  }

  // The other corners in their order (image_order.h), but for the last two, which give the orientation. So a part has
  // the same bits wherever the cell is stored.
  std::array<std::int32_t, 3> others_of(std::size_t vertex, std::uint32_t cell) const {
    std::array<std::int32_t, 3> others{};
    std::size_t own = 0, count = 0;
    for (std::size_t k = 0; k < corners_; ++k) {
      if (static_cast<std::size_t>(vertex_at(cell, k)) == vertex)
        own = k;
      else
        others[count++] = vertex_at(cell, k);
    }
    bool odd = own % 2 == 1;  // moving the vertex to the front swaps it with each corner before it
    const auto order = [&](std::int32_t v) { return image_order(mesh_, static_cast<std::size_t>(v)); };
    for (std::size_t i = 0; i + 1 < count; ++i) {
      for (std::size_t j = count - 1; j > i; --j) {
        if (!(order(others[j]) < order(others[j - 1]))) continue;
        std::swap(others[j], others[j - 1]);
        odd = !odd;
      }
    }
    if (odd) std::swap(others[count - 1], others[count - 2]);
    return others;
  }

  template <class Number>
  VoronoiPart<Number> sum_of(std::size_t vertex, std::span<const std::uint32_t> star) const {
    std::vector<VoronoiPart<Number>> parts;
    parts.reserve(star.size());
    for (const std::uint32_t cell : star) {
      const auto others = others_of(vertex, cell);
      std::array<Vec<Number>, 3> edges;
      for (std::size_t k = 0; k + 1 < corners_; ++k) {
        edges[k] = query::relative<Number>(mesh_.points[static_cast<std::size_t>(others[k])], mesh_.points[vertex]);
        if (corners_ == 3) edges[k].z = 0;
      }
      parts.push_back(voronoi_part<Number>(std::span<const Vec<Number>>(edges).first(corners_ - 1)));
    }
    // From the least value to the greatest, so that the order of the cells does not matter.
    std::sort(parts.begin(), parts.end(), [](const auto& a, const auto& b) {
      if (a.volume != b.volume) return a.volume < b.volume;
      if (a.surface != b.surface) return a.surface < b.surface;
      if (a.moment.x != b.moment.x) return a.moment.x < b.moment.x;
      if (a.moment.y != b.moment.y) return a.moment.y < b.moment.y;
      return a.moment.z < b.moment.z;
    });
    VoronoiPart<Number> sum;
    for (const auto& part : parts) sum.add(part);
    return sum;
  }

  template <class Number>
  void fill(VoronoiCell& cell, std::size_t vertex, const VoronoiPart<Number>& sum) const {
    const Point& at = mesh_.points[vertex];
    cell.volume = static_cast<double>(query::rounded(sum.volume));
    cell.surface = static_cast<double>(query::rounded(sum.surface));
    const Number place[3] = {sum.moment.x, sum.moment.y, sum.moment.z};
    for (int axis = 0; axis < mesh_.dimension; ++axis)
      cell.centroid[static_cast<std::size_t>(axis)] =
          static_cast<double>(query::rounded(Number(Number(at[axis]) + place[axis] / sum.volume)));
  }

  const TileMesh& mesh_;
  const std::size_t corners_;
  const Stars stars_;
  std::vector<std::int32_t> near_;
  std::vector<std::int32_t> ring_;
};

class Voronoi final : public TileMeasure {
 public:
  Voronoi(const TileSource& source, std::stop_token stop) : source_(source), stop_(std::move(stop)) {}

  std::vector<ResultColumn> columns() const override {
    const Manifest& manifest = source_.manifest();
    const int d = manifest.dimension;
    const auto column = [](const char* name, AttributeType type, std::string unit) {
      return ResultColumn{.name = name,
                          .of_cells = false,
                          .type = type,
                          .unit = std::move(unit),
                          .command = {},
                          .software_version = {}};
    };
    std::vector<ResultColumn> made{
        column(d == 2 ? "voronoi_area" : "voronoi_volume", AttributeType::f64, unit_of(manifest, d)),
        column(d == 2 ? "voronoi_boundary" : "voronoi_surface", AttributeType::f64, unit_of(manifest, d - 1)),
        column("voronoi_neighbours", AttributeType::u32, "")};
    for (const char* axis : {"voronoi_x", "voronoi_y", "voronoi_z"})
      if (made.size() < static_cast<std::size_t>(d) + 3)
        made.push_back(column(axis, AttributeType::f64, unit_of(manifest, 1)));
    return made;
  }

  Result<PassValues> of(std::size_t index, const StoredTile& tile) override {
    if (!tile.mesh.neighbors.empty()) return of_mesh(index, tile.mesh);
    TileMesh matched = tile.mesh;  // a result without stored neighbours
    BOOST_OUTCOME_TRYV(match_facets(matched, source_.file(index)));
    return of_mesh(index, matched);
  }

  void finish(std::vector<ResultColumn>& /*columns*/) const override {}
  std::uint64_t infinite() const override { return 0; }  // cells on the hull are unbounded, and not too large

 private:
  // Without this, a damaged cell would give wrong volumes.
  Status check_cells(std::size_t index, const TileMesh& mesh) const {
    const std::size_t corners = static_cast<std::size_t>(mesh.dimension) + 1;
    for (std::size_t cell = 0; cell < mesh.cell_ghost.size(); ++cell) {
      const auto at = [&](std::size_t k) -> const Point& {
        return mesh.points[static_cast<std::size_t>(mesh.cells[cell * corners + k])];
      };
      const int sign = corners == 3 ? exact::orientation_2_staged(at(0), at(1), at(2)).sign
                                    : exact::orientation_3_staged(at(0), at(1), at(2), at(3)).sign;
      if (sign <= 0) return not_oriented(source_, index, cell);
    }
    return success();
  }

  Result<PassValues> of_mesh(std::size_t index, const TileMesh& mesh) const {
    BOOST_OUTCOME_TRYV(check_cells(index, mesh));
    const std::size_t vertices = mesh.points.size();
    std::vector<double> volumes(vertices), surfaces(vertices);
    std::vector<std::uint32_t> neighbours(vertices);
    std::array<std::vector<double>, 3> centroids;
    for (int axis = 0; axis < mesh.dimension; ++axis) centroids[static_cast<std::size_t>(axis)].resize(vertices);
    VoronoiCells cells(mesh);
    for (std::size_t v = 0; v < vertices; ++v) {
      if (mesh.point_ghost[v] != 0) continue;
      if (v % 256 == 0 && stop_.stop_requested()) return error(Errc::interrupted, "interrupted while measuring");
      const VoronoiCell cell = cells.of(v);
      volumes[v] = cell.volume;
      surfaces[v] = cell.surface;
      neighbours[v] = cell.neighbours;
      for (int axis = 0; axis < mesh.dimension; ++axis)
        centroids[static_cast<std::size_t>(axis)][v] = cell.centroid[static_cast<std::size_t>(axis)];
    }
    PassValues bytes{as_bytes(volumes), as_bytes(surfaces), as_bytes(neighbours)};
    for (int axis = 0; axis < mesh.dimension; ++axis)
      bytes.push_back(as_bytes(centroids[static_cast<std::size_t>(axis)]));
    return bytes;
  }

  const TileSource& source_;
  std::stop_token stop_;
};

}  // namespace

std::unique_ptr<TileMeasure> measure_voronoi(const TileSource& source, std::stop_token stop) {
  return std::make_unique<Voronoi>(source, std::move(stop));
}

}  // namespace tessera
