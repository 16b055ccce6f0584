#include "src/result/volume/surface.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "src/geometry/predicates/exact/predicates.h"
#include "src/result/query/stored_triangulation.h"
#include "src/result/terrain/tiles.h"

namespace tessera::volume {

namespace {

Error corrupt(const std::filesystem::path& file, const std::string& what) {
  return error(Errc::corrupt, file.string() + ": " + what);
}

}  // namespace

Result<Surface> Surface::open(const std::filesystem::path& out, const std::string& value,
                              const exports::CellSizes& sizes) {
  BOOST_OUTCOME_TRY(source, TileSource::open(out));
  BOOST_OUTCOME_TRYV(terrain::check_surface(out, source.manifest(), sizes));
  BOOST_OUTCOME_TRY(column, query::find_column(out, source.manifest(), value));
  return Surface(std::move(source), column, sizes);
}

Result<std::vector<std::size_t>> Surface::tiles(const std::optional<FlatBox>& box, std::uint64_t memory_bytes,
                                                const std::stop_token& stop) const {
  std::vector<std::size_t> tiles(source_.tiles());
  std::iota(tiles.begin(), tiles.end(), std::size_t{0});
  const Bounds& all = manifest().bounds;
  if (!box || manifest().region) return tiles;  // a region has one tile
  if (!box->meets({all.lo.x, all.lo.y, all.hi.x, all.hi.y})) return std::vector<std::size_t>{};
  const double width = std::min(box->right, all.hi.x) - std::max(box->left, all.lo.x);
  const double height = std::min(box->high, all.hi.y) - std::max(box->low, all.lo.y);
  // A search would take as long as reading.
  if (width * height >= (all.hi.x - all.lo.x) * (all.hi.y - all.lo.y) / 2) return tiles;
  BOOST_OUTCOME_TRY(result, query::StoredTriangulation::open(source_, {.memory_bytes = memory_bytes}));
  const Bounds area{{box->left, box->low, 0}, {box->right, box->high, 0}};
  BOOST_OUTCOME_TRY(ids, result.tiles({.box = area}, {.stop = stop}));
  std::erase_if(tiles,
                [&](std::size_t i) { return !std::binary_search(ids.begin(), ids.end(), source_.entry(i).tile); });
  return tiles;
}

Result<SurfaceTile> Surface::read(std::size_t index) const {
  BOOST_OUTCOME_TRY(tile, source_.read(index, {.rows = true}));
  const TileMesh& mesh = tile.mesh;
  const Bounds& bounds = manifest().bounds;
  const std::size_t row_bytes = tessera::row_bytes(tile.schema);
  SurfaceTile read;
  read.points_.reserve(mesh.points.size());
  for (std::size_t v = 0; v < mesh.points.size(); ++v) {
    const Point& p = mesh.points[v];
    if (!(p.x >= bounds.lo.x && p.x <= bounds.hi.x && p.y >= bounds.lo.y && p.y <= bounds.hi.y))
      return corrupt(source_.file(index), "has a vertex outside of the manifest's bounds");
    read.points_.push_back({p.x, p.y, column_.value(tile.rows.data() + v * row_bytes)});
  }
  std::vector<FlatBox> boxes;
  for (std::size_t i = 0; i < mesh.cell_ghost.size(); ++i) {
    if (mesh.cell_ghost[i] != 0) continue;
    if (!filter_.keeps(mesh, i)) {
      ++read.long_edges_;
      continue;
    }
    std::array<std::uint32_t, 3> cell{};
    for (std::size_t k = 0; k < 3; ++k) cell[k] = static_cast<std::uint32_t>(mesh.cells[3 * i + k]);
    const auto corner = [&](std::size_t k) { return mesh.points[cell[k]]; };
    if (exact::orientation_2(corner(0), corner(1), corner(2)) <= 0)
      return corrupt(source_.file(index), "cell " + std::to_string(i) + " is not positively oriented");
    if (!std::all_of(cell.begin(), cell.end(), [&](std::uint32_t v) { return std::isfinite(read.points_[v].z); })) {
      ++read.without_height_;
      continue;
    }
    read.cells_.push_back(cell);
    boxes.push_back(box_of({corner(0), corner(1), corner(2)}));
    if (boxes.size() == 1)
      read.box_ = boxes[0];
    else
      read.box_.add(boxes.back());
  }
  read.tree_ = BoxTree(boxes);
  return read;
}

Result<std::shared_ptr<const SurfaceTile>> SurfaceCache::get(std::size_t index) {
  std::unique_lock lock(mutex_);
  Slot& slot = slots_[index];  // stays where it is while other slots come and go
  loaded_.wait(lock, [&] { return !slot.loading; });
  slot.used = ++clock_;
  if (slot.tile) return slot.tile;
  slot.loading = true;
  lock.unlock();
  auto read = surface_.read(index);
  lock.lock();
  slot.loading = false;
  loaded_.notify_all();
  BOOST_OUTCOME_TRY(tile, std::move(read));
  auto shared = std::make_shared<const SurfaceTile>(std::move(tile));
  slot.tile = shared;
  bytes_ += shared->bytes();
  evict();
  return shared;
}

void SurfaceCache::evict() {
  while (bytes_ > bytes_max_) {
    Slot* oldest = nullptr;
    for (auto& [index, slot] : slots_)
      if (slot.tile && slot.tile.use_count() == 1 && (oldest == nullptr || slot.used < oldest->used)) oldest = &slot;
    if (oldest == nullptr) return;  // all are in use
    bytes_ -= oldest->tile->bytes();
    oldest->tile = nullptr;
  }
}

}  // namespace tessera::volume
