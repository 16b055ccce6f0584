// A tile that takes part in the change of a result: from its stored file to its new cells.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <stop_token>
#include <utility>
#include <vector>

#include <tsl/robin_map.h>

#include "src/base/mix_hash.h"
#include "src/base/point.h"
#include "src/base/result.h"
#include "src/delaunay/update/update_plan.h"
#include "src/geometry/mesh/tile_mesh.h"
#include "src/result/tile_source.h"
#include "src/tiling/tile/tile_triangulation.h"

namespace tessera {

// What all tiles of a change have in common. Read-only.
struct UpdateSetting {
  const TileSource& source;
  const UpdatePlan& plan;
  const KnownFromStart& around;
  std::span<const std::byte> rows;  // of the new points
  std::stop_token stop;
};

// Not thread-safe.
class WokenTile {
 public:
  WokenTile(TileId self, const UpdateSetting& setting) : self_(self), setting_(setting) {}

  // Reads what is stored, and finds what is fresh. Errors: those of TileSource::read().
  Status read();
  TileId self() const { return self_; }
  // Whether the tile has fresh points.
  bool begins() const { return begins_; }
  // Whether the tile is to be written even if no message wakes it.
  bool lost() const { return lost_; }
  bool empty() const { return points_.empty(); }
  // The owners of the vertices of stored cells with a removed vertex.
  const std::set<TileId>& beside_removed() const { return beside_removed_; }
  // An own point that stays, or nothing.
  const std::optional<SharedPoint>& old_point() const { return old_point_; }
  // An own point, when all are new. REQUIRES: not empty().
  SharedPoint new_point() const { return {points_[0], ids_[0], self_, fresh_bit}; }
  // The bounds of the own vertices that are removed.
  const Bounds& removed_bounds() const { return removed_bounds_; }
  // New points that are equal to others of the tile, and that the plan has not found.
  const std::vector<DuplicatePair>& duplicates() const { return duplicates_; }

  // Returns at most `most` of the own points that stay and are fresh, spread evenly. They lie around removed points.
  std::vector<SharedPoint> affected(std::size_t most) const;
  // Points of other tiles, all of which stay, that the tile is to know from the start. Call before begin().
  void know(const std::vector<SharedPoint>& points);
  // Triangulates. `common`: for a tile that begins.
  Status begin(const std::optional<SharedPoint>& common);
  // One splay.
  using Mail = std::vector<std::pair<TileId, std::vector<SharedPoint>>>;
  Status step(const Mail& mail);
  std::map<TileId, std::vector<SharedPoint>> take_updates() { return triangulation_->take_updates(); }
  bool awake() const { return triangulation_ != nullptr; }
  bool flat() const { return triangulation_->kernel_dimension() < setting_.source.manifest().dimension; }
  // Whether the tile's cells may differ from the stored ones.
  bool changed() const { return begins_ || lost_ || (awake() && triangulation_->counts().inserted > 0); }
  ExchangeCounts counts() const { return counts_; }

  // The cells, once all is quiet. The triangulation is gone afterwards. REQUIRES: awake(), not flat().
  TileMesh collect();
  // The attributes of a vertex that the stored tile has, that is new, or that has been a duplicate. Nothing for another
  // one.
  std::optional<std::span<const std::byte>> row(PointId id) const;

 private:
  TileId self_;
  const UpdateSetting& setting_;
  // Of the new tile.
  std::vector<Point> points_;
  std::vector<PointId> ids_;
  std::vector<std::uint8_t> fresh_;
  std::vector<SharedPoint> foreign_;
  tsl::robin_map<PointId, std::uint8_t, MixHash> old_;  // own points that stay: 1 for a fresh one
  bool begins_ = false, lost_ = false;
  std::set<TileId> beside_removed_;
  std::optional<SharedPoint> old_point_;
  Bounds removed_bounds_;
  std::vector<DuplicatePair> duplicates_;
  std::unique_ptr<TileTriangulation> triangulation_;
  ExchangeCounts counts_;
  // As stored.
  std::vector<std::byte> rows_;
  tsl::robin_map<PointId, std::size_t, MixHash> row_of_;
};

}  // namespace tessera
