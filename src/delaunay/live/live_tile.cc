#include "src/delaunay/live/live_tile.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "src/base/check.h"
#include "src/base/too_large.h"
#include "src/delaunay/update/changed_tile.h"
#include "src/geometry/predicates/exact/predicates.h"

namespace tessera {

LiveTile::LiveTile(std::unique_ptr<const TileTriangulation> triangulation)
    : triangulation_(std::move(triangulation)), dimension_(triangulation_->kernel().max_dimension()) {
  check(triangulation_->kernel_dimension() == dimension_, "a live tile is not flat");
  sample();
  memory_ = triangulation_->memory() + grid_.capacity() * sizeof(Row) + sizeof *this;
}

bool LiveTile::has_own(const CellRecord& cell) const {
  return std::any_of(cell.vertices, cell.vertices + corners(), [&](Vertex v) { return triangulation_->is_own(v); });
}

bool LiveTile::infinite(const CellRecord& cell) const {
  return std::find(cell.vertices, cell.vertices + corners(), infinite_vertex) != cell.vertices + corners();
}

// One place for some 32 cells. A place that no sampled cell is in takes the cell of the place before.
void LiveTile::sample() {
  constexpr Row step = 8;
  const Kernel& kernel = triangulation_->kernel();
  const Row rows = kernel.rows();
  check(rows > 0, "the kernel of a live tile has rows");
  const auto places = static_cast<double>(rows) / 32 + 1;
  side_ = static_cast<std::uint32_t>(std::max(1.0, std::floor(std::pow(places, 1.0 / dimension_))));
  std::vector<std::pair<Point, Row>> samples;
  for (Row r = 0; r < rows; ++r) {
    if (r % step != 0 && !samples.empty()) continue;
    const CellRecord cell = kernel.row(r);
    if (cell.vertices[0] == CellRecord::gap || infinite(cell)) continue;
    const auto own =
        std::find_if(cell.vertices, cell.vertices + corners(), [&](Vertex v) { return triangulation_->is_own(v); });
    if (own == cell.vertices + corners()) continue;
    samples.emplace_back(kernel.point(*own), r);
    bounds_.add(samples.back().first);
  }
  check(!samples.empty(), "a live tile has a finite cell");
  constexpr Row none = ~Row{0};
  std::size_t all = 1;
  for (int i = 0; i < dimension_; ++i) all *= side_;
  grid_.assign(all, none);
  for (const auto& [at, r] : samples) grid_[place_of(at)] = r;
  Row last = samples.front().second;
  for (Row& r : grid_) last = r == none ? r = last : r;
}

// Where differences overflow, the share may be no number. Any place will do then.
std::size_t LiveTile::place_of(const Point& p) const {
  std::size_t place = 0;
  for (int i = 0; i < dimension_; ++i) {
    const double width = bounds_.hi[i] - bounds_.lo[i], share = (p[i] - bounds_.lo[i]) / width;
    const auto along = share > 0 ? static_cast<std::uint32_t>(std::min(share, 1.0) * side_) : 0u;
    place = place * side_ + std::min(side_ - 1, along);
  }
  return place;
}

LiveTile::Row LiveTile::near(const Point& p) const { return grid_[place_of(p)]; }

// Behind facet i lies p when p in place of corner i turns the orientation of the cell round.
std::optional<int> LiveTile::facet_before(const CellRecord& cell, const Point& p, std::uint32_t first) const {
  const Kernel& kernel = triangulation_->kernel();
  std::array<Point, 4> at;
  for (int i = 0; i < corners(); ++i) at[i] = kernel.point(cell.vertices[i]);
  for (int k = 0; k < corners(); ++k) {
    const int i = static_cast<int>((first + static_cast<std::uint32_t>(k)) % static_cast<std::uint32_t>(corners()));
    const Point corner = std::exchange(at[i], p);
    const int sign =
        dimension_ == 3 ? exact::orientation_3(at[0], at[1], at[2], at[3]) : exact::orientation_2(at[0], at[1], at[2]);
    at[i] = corner;
    if (sign < 0) return i;
  }
  return std::nullopt;
}

// Among cospherical points a walk could go in circles if it asked the corners in the same order each time.
LiveTile::Row LiveTile::find(const Point& p) const {
  Row r = near(p);
  std::uint32_t random = 0x9e3779b9;
  for (;;) {
    const CellRecord cell = row(r);
    if (infinite(cell)) return r;
    const auto facet = facet_before(cell, p, random >> 16);
    if (!facet) return r;
    random = random * 1664525u + 1013904223u;
    r = cell.neighbors[*facet] >> 2;
  }
}

// A cell that contains a vertex has it as a corner.
std::optional<PointId> LiveTile::own_at(const Point& p) const {
  const CellRecord cell = row(find(p));
  for (int i = 0; i < corners(); ++i) {
    const Vertex v = cell.vertices[i];
    if (v != infinite_vertex && triangulation_->is_own(v) && triangulation_->kernel().point(v) == p)
      return triangulation_->ids()[v];
  }
  return std::nullopt;
}

std::vector<LiveTile::Row> LiveTile::star(Vertex v) const {
  std::vector<Row> out{find(triangulation_->kernel().point(v))};
  for (std::size_t next = 0; next < out.size(); ++next) {
    const CellRecord cell = row(out[next]);
    for (int i = 0; i < corners(); ++i) {
      if (cell.vertices[i] == v) continue;
      const Row across = cell.neighbors[i] >> 2;
      if (std::find(out.begin(), out.end(), across) == out.end()) out.push_back(across);
    }
  }
  return out;
}

// No point is fresh, so the tile has nothing to say.
Result<std::shared_ptr<const LiveTile>> build_live_tile(LiveTilePoints tile, const KnownFromStart& around) {
  put_in_hilbert_order(tile.foreign, tile.dimension);
  const std::vector<std::uint8_t> fresh(tile.points.size());
  try {
    auto made = std::make_unique<TileTriangulation>(
        TileOptions{.self = tile.self, .dimension = tile.dimension, .around = &around});
    const Status built = made->triangulate_changed({tile.points, tile.ids, fresh, tile.foreign});
    if (!built) return error(Errc::corrupt, "two of its vertices are equal");
    if (made->kernel_dimension() < tile.dimension) return error(Errc::corrupt, "its vertices do not span space");
    made->settle();
    return std::make_shared<const LiveTile>(std::move(made));
  } catch (const Unsound&) {
    return error(Errc::corrupt, "two of its vertices are equal");
  } catch (const TileTooLarge& e) {
    return error(Errc::memory, std::string("the tile ") + e.what());
  }
}

}  // namespace tessera
