// A tile of a result that is changed: what it begins from, what it tells of its holes, and what it has become
// (docs/updates-design.md).
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "src/base/big_vector.h"
#include "src/base/figures.h"
#include "src/base/point.h"
#include "src/delaunay/update/update_plan.h"
#include "src/geometry/mesh/tile_mesh.h"
#include "src/result/store/tile_store.h"

namespace tessera {

// What the owners of removed points have told a tile, and a tile itself.
struct ToldOfHoles {
  bool beside = false;              // a vertex of the tile is in a cell with a removed point of another tile
  std::vector<SharedPoint> around;  // points around the holes, by id
  std::vector<PointId> filled;      // removed points: the tile knows all points around their holes; ascending
  bool empty() const { return !beside && around.empty() && filled.empty(); }
};
BigVector<std::byte> bytes_of(const ToldOfHoles& told);
// Nothing when the bytes are not those of such a list.
std::optional<ToldOfHoles> told_of(std::span<const std::byte> bytes);

// What TileTriangulation::triangulate_changed() begins from.
struct StartOfTile {
  std::vector<Point> points;              // the tile's own, distinct, in Hilbert order
  std::vector<PointId> ids;               // beside points
  std::vector<std::uint8_t> fresh;        // beside points
  std::vector<SharedPoint> foreign;       // that the tile knows from the start, in Hilbert order
  std::vector<DuplicatePair> duplicates;  // new points that are equal to others of the tile
  Bounds removed_bounds;                  // of the tile's own vertices that are removed
  bool begins = false;                    // the tile has fresh points
  bool lost = false;                      // an own vertex is removed
  bool reshaped = false;                  // cells with a vertex of the tile are gone whose points are not fresh
};
// `stored`: the tile `self`; without its cells, no point that stays counts as fresh, and the tile not as reshaped.
StartOfTile start_of(TileId self, TileMesh stored, const UpdatePlan& plan, const ToldOfHoles& told);

// So that each is inserted near the one before.
void put_in_hilbert_order(std::vector<SharedPoint>& points, int dimension);

// What a tile has become. Tiles that were not concerned have no such record.
struct TileEnd {
  bool begun = false;                   // it had fresh points
  bool awake = false;                   // it was triangulated
  bool lost = false;                    // an own vertex was removed
  bool changed = false;                 // its cells are others now, or it has none any more
  std::optional<TileEntry> entry = {};  // of its new file; nothing when it has no new one
  Bounds bounds = {};                   // of its own vertices, when it has changed
  Bounds removed_bounds = {};
  std::vector<DuplicatePair> duplicates = {};
  ExchangeCounts counts = {};
};
BigVector<std::byte> bytes_of(const TileEnd& end);
std::optional<TileEnd> tile_end_of(std::span<const std::byte> bytes);

}  // namespace tessera
