#include "src/surface/surface_tile.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "src/surface/arrays.h"

namespace tessera::surface {

SurfaceTile::SurfaceTile(TileId self, std::string name, StoredTile stored)
    : self_(self), name_(std::move(name)), stored_(std::move(stored)) {}

Error SurfaceTile::corrupt(const std::string& reason) const { return error(Errc::corrupt, name_ + ": " + reason); }

Result<SurfaceTile> SurfaceTile::make(TileId self, std::string name, StoredTile stored) {
  SurfaceTile tile(self, std::move(name), std::move(stored));
  BOOST_OUTCOME_TRYV(tile.index());
  return tile;
}

Status SurfaceTile::index() {
  const TileMesh& mesh = stored_.mesh;
  if (mesh.dimension != 3 || mesh.neighbors.size() != mesh.cells.size())
    return corrupt("is not a tile of a 3D triangulation with neighbours");
  while (static_cast<std::size_t>(own_) < mesh.points.size() && mesh.point_ghost[static_cast<std::size_t>(own_)] == 0)
    ++own_;
  const auto own = static_cast<std::size_t>(own_);
  star_first_.assign(own + 1, 0);
  for (const std::int32_t v : mesh.cells)
    if (v < own_) ++star_first_[static_cast<std::size_t>(v) + 1];
  std::partial_sum(star_first_.begin(), star_first_.end(), star_first_.begin());
  star_cells_.resize(star_first_[own]);
  std::vector<std::uint32_t> next(star_first_.begin(), star_first_.end() - 1);
  for (std::size_t i = 0; i < mesh.cells.size(); ++i)
    if (mesh.cells[i] < own_)
      star_cells_[next[static_cast<std::size_t>(mesh.cells[i])]++] = static_cast<std::uint32_t>(i / 4);
  by_id_.resize(own);
  std::iota(by_id_.begin(), by_id_.end(), 0);
  std::sort(by_id_.begin(), by_id_.end(), [&](std::int32_t a, std::int32_t b) { return id(a) < id(b); });
  return success();
}

CellName SurfaceTile::name(std::int32_t cell) const {
  CellName name;
  for (std::size_t k = 0; k < 4; ++k) name[k] = id(vertex(cell, k));
  std::sort(name.begin(), name.end());
  return name;
}

TileId SurfaceTile::main_tile(std::int32_t cell) const {
  return std::min(std::min(owner(vertex(cell, 0)), owner(vertex(cell, 1))),
                  std::min(owner(vertex(cell, 2)), owner(vertex(cell, 3))));
}

TileId SurfaceTile::main_tile(std::int32_t cell, std::size_t facet) const {
  const auto& corners = facet_corners[facet];
  return std::min(std::min(owner(vertex(cell, corners[0])), owner(vertex(cell, corners[1]))),
                  owner(vertex(cell, corners[2])));
}

std::array<Corner, 3> SurfaceTile::facet(std::int32_t cell, std::size_t opposite) const {
  const auto& corners = facet_corners[opposite];
  return {corner(vertex(cell, corners[0])), corner(vertex(cell, corners[1])), corner(vertex(cell, corners[2]))};
}

Result<std::size_t> SurfaceTile::corner_of(std::int32_t cell, PointId wanted) const {
  for (std::size_t k = 0; k < 4; ++k)
    if (id(vertex(cell, k)) == wanted) return k;
  return corrupt("cell " + std::to_string(cell) + " lacks a vertex that the cell has in another tile");
}

Result<std::size_t> SurfaceTile::corner_towards(std::int32_t cell, std::int32_t from) const {
  for (std::size_t k = 0; k < 4; ++k)
    if (neighbor(cell, k) == from) return k;
  return corrupt("cell " + std::to_string(cell) + " is a neighbour of cell " + std::to_string(from) +
                 ", which does not name it in turn");
}

std::span<const std::uint32_t> SurfaceTile::star(std::int32_t v) const {
  const auto at = static_cast<std::size_t>(v);
  return std::span(star_cells_).subspan(star_first_[at], star_first_[at + 1] - star_first_[at]);
}

double SurfaceTile::scale_of(std::int32_t v) {
  marked_.resize(mesh().points.size(), 0);
  std::vector<double> squares;
  const Point& p = point(v);
  marked_[static_cast<std::size_t>(v)] = v + 1;
  for (const std::uint32_t cell : star(v)) {
    for (std::size_t k = 0; k < 4; ++k) {
      const std::int32_t other = vertex(static_cast<std::int32_t>(cell), k);
      std::int32_t& marked = marked_[static_cast<std::size_t>(other)];
      if (marked == v + 1) continue;
      marked = v + 1;
      const Point& q = point(other);
      squares.push_back((q.x - p.x) * (q.x - p.x) + (q.y - p.y) * (q.y - p.y) + (q.z - p.z) * (q.z - p.z));
    }
  }
  if (squares.empty()) return 0;
  const auto middle = squares.begin() + static_cast<std::ptrdiff_t>((squares.size() - 1) / 2);
  std::nth_element(squares.begin(), middle, squares.end());
  return scale_of_edges * std::sqrt(*middle);
}

Result<std::int32_t> SurfaceTile::find(const CellName& wanted) const {
  std::uint64_t sum = 0;  // most cells differ in it
  for (const PointId corner : wanted) sum += corner.value;
  for (const PointId corner : wanted) {
    const auto found = std::lower_bound(by_id_.begin(), by_id_.end(), corner,
                                        [&](std::int32_t v, PointId other) { return id(v) < other; });
    if (found == by_id_.end() || id(*found) != corner) continue;
    for (const std::uint32_t i : star(*found)) {
      const auto cell = static_cast<std::int32_t>(i);
      std::uint64_t others = sum;
      for (std::size_t k = 0; k < 4; ++k) others -= id(vertex(cell, k)).value;
      if (others == 0 && name(cell) == wanted) return cell;
    }
    break;
  }
  return corrupt("lacks a cell at vertex " + to_string(wanted[0]) + " that another tile has");
}

void SurfaceTile::forget_weights() {
  arcs_ = {};
  excess_ = {};
}

SurfaceTile::Weights SurfaceTile::take_weights() {
  Weights weights{std::move(arcs_), std::move(excess_)};
  forget_weights();
  return weights;
}

Status SurfaceTile::put_weights(Weights weights) {
  if (weights.arcs.size() != mesh().cells.size() || weights.excess.size() != mesh().cell_ghost.size())
    return corrupt("has another number of cells than when rays went through the tile");
  arcs_ = std::move(weights.arcs);
  excess_ = std::move(weights.excess);
  return success();
}

void SurfaceTile::begin_weights() {
  arcs_.assign(mesh().cells.size(), 0);
  excess_.assign(mesh().cell_ghost.size(), 0);
}

std::size_t SurfaceTile::bytes() const {
  return mesh().bytes() + stored_.rows.size() + (star_first_.size() + star_cells_.size() + by_id_.size()) * 4 +
         arcs_.size() * 4 + excess_.size() * 8;
}

namespace {

template <class Stored, class Use>
void cells_of(Stored& stored, const Use& use) {
  auto& mesh = stored.mesh;
  use(mesh.points);
  use(mesh.ids);
  use(mesh.owners);
  use(mesh.point_ghost);
  use(mesh.cells);
  use(mesh.cell_ghost);
  use(mesh.neighbors);
  use(stored.rows);
}

}  // namespace

Status SurfaceTile::save_cells(const std::filesystem::path& path) const {
  return save_arrays(path, [&](const auto& use) { cells_of(stored_, use); });
}

Result<SurfaceTile> SurfaceTile::load_cells(TileId self, std::string name, const std::filesystem::path& path,
                                            const std::vector<Attribute>& schema) {
  SurfaceTile tile(self, std::move(name), {});
  tile.stored_.schema = schema;
  BOOST_OUTCOME_TRYV(load_arrays(path, [&](const auto& use) { cells_of(tile.stored_, use); }));
  BOOST_OUTCOME_TRYV(tile.index());
  return tile;
}

}  // namespace tessera::surface
