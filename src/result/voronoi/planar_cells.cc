#include "src/result/voronoi/planar_cells.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "src/base/attribute.h"
#include "src/geometry/predicates/exact/predicates.h"
#include "src/result/measure/values.h"
#include "src/result/voronoi/cell_clipper.h"
#include "src/result/voronoi/star_order.h"

namespace tessera::voronoi {

namespace {

class PlanarCells {
 public:
  PlanarCells(const TileMesh& mesh, const ClipRegion* region, Repairs& repairs)
      : mesh_(mesh), stars_(mesh), repairs_(repairs) {
    if (region != nullptr) clipper_ = std::make_unique<CellClipper>(*region);
  }

  // Computes all circumcentres. Returns the number of a cell that is damaged, if there is one.
  Result<std::optional<std::size_t>> prepare(const std::stop_token& stop) {
    const std::size_t cells = mesh_.cell_ghost.size();
    centres_.resize(cells);
    for (std::size_t cell = 0; cell < cells; ++cell) {
      if (cell % 4096 == 0 && stop.stop_requested()) return error(Errc::interrupted, "interrupted while making cells");
      std::array<Point, 3> at;
      for (std::size_t k = 0; k < 3; ++k) at[k] = flat(mesh_.cells[cell * 3 + k]);
      if (exact::orientation_2(at[0], at[1], at[2]) <= 0) return std::optional(cell);
      centres_[cell] = circumcentre(at);
    }
    return std::optional<std::size_t>();
  }

  enum class Made : std::uint8_t { shape, shapeless, outside, damaged };
  // Sets shape() and the head of the cell of a vertex.
  Made make(std::size_t vertex, CellHead& head) {
    shape_.parts.clear();
    thin_ = false;
    if (!order_.order(mesh_, vertex, stars_.of(vertex), star_)) return Made::damaged;
    head = {.id = mesh_.ids[vertex].value,
            .neighbours = static_cast<std::uint32_t>(star_.around.size()),
            .unbounded = star_.on_hull ? 1U : 0U};
    around_.clear();
    corners_.clear();
    for (const std::int32_t v : star_.around) around_.push_back(flat(v));
    for (const std::uint32_t cell : star_.cells) corners_.push_back(centres_[cell]);
    if (!clip(vertex)) return Made::outside;
    thin_ =
        std::erase_if(shape_.parts, [&](const auto& part) { return !is_valid(part) && !repairs_.repair(part); }) > 0;
    if (shape_.parts.empty()) {
      constexpr double nan = std::numeric_limits<double>::quiet_NaN();
      head.size = star_.on_hull && !clipper_ ? std::numeric_limits<double>::infinity() : 0;
      head.centroid[0] = head.centroid[1] = nan;
      return Made::shapeless;
    }
    // So that the order of parts and the last bits of measures do not depend on the tile.
    std::sort(shape_.parts.begin(), shape_.parts.end(), part_before);
    const ShapeMeasures measures = measure(shape_);
    head.size = measures.area;
    head.centroid[0] = measures.centroid.x;
    head.centroid[1] = measures.centroid.y;
    return Made::shape;
  }
  const CellShape& shape() const { return shape_; }
  bool thin() const { return thin_; }  // whether the shape lost parts

 private:
  Point flat(std::int32_t v) const {
    const Point& p = mesh_.points[static_cast<std::size_t>(v)];
    return {p.x, p.y, 0};
  }

  // Sets the shape before the check of its rings. False when the cell is outside of the region.
  bool clip(std::size_t vertex) {
    const bool bounded = !star_.on_hull;
    if (clipper_) {
      const PlanarCell cell{flat(static_cast<std::int32_t>(vertex)), around_, bounded, corners_};
      const CellClipper::Place place = clipper_->place_of(cell);
      if (place == CellClipper::Place::outside) return false;
      if (place == CellClipper::Place::across) {
        shape_ = clipper_->shape(cell);
        return !shape_.parts.empty();
      }
    } else if (!bounded) {
      return true;
    }
    const auto is_finite = [](const Point& p) { return std::isfinite(p.x) && std::isfinite(p.y); };
    if (!std::all_of(corners_.begin(), corners_.end(), is_finite)) return true;  // beyond what doubles hold
    Ring ring = corners_;
    remove_repeated(ring);
    begin_with_least(ring);
    shape_.parts.push_back({std::move(ring)});
    return true;
  }

  const TileMesh& mesh_;
  const Stars stars_;
  Repairs& repairs_;
  StarOrder order_;
  std::unique_ptr<CellClipper> clipper_;
  std::vector<Point> centres_;  // by cell
  OrderedStar star_;
  std::vector<Point> around_, corners_;
  CellShape shape_;
  bool thin_ = false;
};

}  // namespace

Result<CellCounts> add_planar_cells(const TileSource& source, std::size_t index, const ClipRegion* region, bool multi,
                                    Repairs& repairs, CellRecords::Adder& to, const std::stop_token& stop) {
  BOOST_OUTCOME_TRY(tile, source.read(index, {.rows = true}));
  PlanarCells cells(tile.mesh, region, repairs);
  BOOST_OUTCOME_TRY(damaged, cells.prepare(stop));
  if (damaged) return not_oriented(source, index, *damaged);
  const std::size_t row = row_bytes(tile.schema);
  CellCounts counts;
  CellHead head;
  for (std::size_t v = 0; v < tile.mesh.points.size(); ++v) {
    if (tile.mesh.point_ghost[v] != 0) continue;
    if (v % 256 == 0 && stop.stop_requested()) return error(Errc::interrupted, "interrupted while making cells");
    const PlanarCells::Made made = cells.make(v, head);
    if (made == PlanarCells::Made::damaged)
      return error(Errc::corrupt, source.file(index).string() + ": the triangles around vertex " +
                                      to_string(tile.mesh.ids[v]) + " do not surround the vertex");
    if (made == PlanarCells::Made::outside) {
      ++counts.outside;
      continue;
    }
    counts.shapeless += made == PlanarCells::Made::shapeless ? 1 : 0;
    counts.thin += cells.thin() ? 1 : 0;
    counts.unbounded += head.unbounded;
    BOOST_OUTCOME_TRYV(
        to.add({head, std::span<const std::byte>(tile.rows).subspan(v * row, row), to_wkb(cells.shape(), multi)}));
  }
  return counts;
}

}  // namespace tessera::voronoi
