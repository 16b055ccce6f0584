// A tile that is kept as points: cells are counted, hashed and dropped.
#include <algorithm>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "src/base/image.h"
#include "src/delaunay/delaunay_program.h"
#include "src/result/store/digest.h"
#include "src/tiling/hilbert.h"

namespace tessera {
namespace {

class FinishedPoints final : public Finished {
 public:
  FinishedPoints(TileId self, PointsOfTile tile, DelaunayStore& store)
      : self_(self), tile_(std::move(tile)), store_(store) {}
  std::uint64_t bytes() const override { return tile_.bytes(); }
  void store(Stored done) override { store_.store_points(self_, std::move(tile_), std::move(done)); }

 private:
  TileId self_;
  PointsOfTile tile_;
  DelaunayStore& store_;
};

// The words of a digest are made of indices, as tile files have them.
Digest digest_of_cells(const CellDigest& digest, std::span<const Vertex> cells) {
  return digest.of({reinterpret_cast<const std::int32_t*>(cells.data()), cells.size()});
}

// `ids` may be images.
CellDigest cell_digest(const DelaunayStage& stage, std::span<const PointId> ids) {
  if (!stage.around->periodic()) return {stage.dimension, ids};
  std::vector<PointId> points;
  std::vector<std::uint8_t> offsets;
  for (const PointId id : ids) {
    points.push_back(plain(id));
    offsets.push_back(static_cast<std::uint8_t>(offset_code(id)));
  }
  return {stage.dimension, points, offsets};
}

// Puts foreign vertices into Hilbert order, as the tile's own points are. Then differences between successive points
// are small, and a reader that triangulates them inserts each point near the one before. The order depends on the
// points alone.
void put_in_order(std::vector<SharedPoint>& foreign, int dimension) {
  Bounds bounds;
  for (const SharedPoint& p : foreign) bounds.add(p.at);
  const HilbertKey key(bounds, dimension);
  std::vector<std::pair<std::uint64_t, SharedPoint>> keyed;
  keyed.reserve(foreign.size());
  for (const SharedPoint& p : foreign) keyed.emplace_back(key(p.at), p);
  std::sort(keyed.begin(), keyed.end(), [](const auto& a, const auto& b) {
    return a.first != b.first ? a.first < b.first : a.second.id < b.second.id;
  });
  for (std::size_t i = 0; i < keyed.size(); ++i) foreign[i] = keyed[i].second;
}

}  // namespace

std::vector<TileId> PointsOfTile::append_foreign(TileId self) {
  std::vector<TileId> owners(points.size(), self);
  for (const SharedPoint& p : foreign) {
    points.push_back(p.at);
    ids.push_back(p.id);
    owners.push_back(p.tile);
  }
  return owners;
}

void DelaunayProgram::discard(const LoadedTile& loaded, const Box& box) {
  const CellDigest digest = cell_digest(stage_, triangulation_->ids());
  gone_.cells = gone_.main_cells =
      triangulation_->discard(loaded.points, box, !stage_.reduce,
                              [&](std::span<const Vertex> cells) { gone_.digest += digest_of_cells(digest, cells); });
}

Result<std::unique_ptr<Finished>> DelaunayProgram::finish_points() {
  if (!points_) {
    BOOST_OUTCOME_TRYV(load_own_points());
  }
  PointsOfTile tile;
  tile.counted = gone_;
  {
    const CellDigest digest = cell_digest(stage_, triangulation_->ids());
    RestOfTile rest = triangulation_->collect_rest(
        [&](std::span<const Vertex> cells) { tile.counted.digest += digest_of_cells(digest, cells); });
    tile.counted.cells += rest.cells;
    tile.counted.main_cells += rest.main_cells;
    tile.foreign = std::move(rest.foreign);
  }
  counts_ = triangulation_->counts();
  tile.points = std::move(points_->points);
  tile.ids = std::move(points_->ids);
  if (tile.ids.empty()) {  // a triangulation that is whole numbers its own points first, from 1 on
    const auto own = triangulation_->ids().subspan(1, tile.points.size());
    tile.ids.assign(own.begin(), own.end());
  }
  put_in_order(tile.foreign, stage_.dimension);
  return std::unique_ptr<Finished>(std::make_unique<FinishedPoints>(self_, std::move(tile), *stage_.store));
}

}  // namespace tessera
