#include "src/delaunay/live/live_tile.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "src/base/check.h"
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
  for (const auto& [at, r] : samples) {
    std::size_t place = 0;
    for (int i = 0; i < dimension_; ++i) {
      const double width = bounds_.hi[i] - bounds_.lo[i];
      const double share = width > 0 ? (at[i] - bounds_.lo[i]) / width : 0;
      place = place * side_ + std::min(side_ - 1, static_cast<std::uint32_t>(share * side_));
    }
    grid_[place] = r;
  }
  Row last = samples.front().second;
  for (Row& r : grid_) last = r == none ? r = last : r;
}

LiveTile::Row LiveTile::near(const Point& p) const {
  std::size_t place = 0;
  for (int i = 0; i < dimension_; ++i) {
    const double width = bounds_.hi[i] - bounds_.lo[i];
    const double share = width > 0 ? std::clamp((p[i] - bounds_.lo[i]) / width, 0.0, 1.0) : 0;
    place = place * side_ + std::min(side_ - 1, static_cast<std::uint32_t>(share * side_));
  }
  return grid_[place];
}

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

}  // namespace tessera
