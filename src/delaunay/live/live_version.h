// One version of a live result, as readers see it: all tiles are of this version, and none changes. Any number of
// threads may read it, without waiting for the writer.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "src/base/point.h"
#include "src/delaunay/live/id_tiles.h"
#include "src/delaunay/live/live_tile.h"
#include "src/tiling/partition.h"

namespace tessera {

// The vertices of a cell, in the order of a positive orientation; in 2D the last entry is not used. An infinite cell
// has `infinite` in the place of a vertex.
struct LiveCell {
  static constexpr PointId infinite{~std::uint64_t{0}};
  std::array<PointId, 4> ids{infinite, infinite, infinite, infinite};
  std::array<Point, 4> points{};  // of the infinite vertex: unspecified
  // A place of the cell in memory. Other places may have the same cell, and another version may have another cell here.
  TileId tile;
  std::uint32_t row = 0;
  bool is_finite(int corners) const {
    return std::find(ids.begin(), ids.begin() + corners, infinite) == ids.begin() + corners;
  }
};

class LiveVersion {
 public:
  // By tile; null for a tile without points. REQUIRES: some tile has points, and all together are a triangulation.
  using Tiles = std::vector<std::shared_ptr<const LiveTile>>;
  LiveVersion(std::uint64_t number, std::shared_ptr<const Partition> partition, Tiles tiles, IdTiles ids);

  // 0: what was stored. Each batch adds one.
  std::uint64_t number() const { return number_; }
  const Partition& partition() const { return *partition_; }
  const Tiles& tiles() const { return tiles_; }
  const IdTiles& ids() const { return ids_; }
  std::uint64_t vertices() const { return vertices_; }
  std::size_t memory() const { return memory_; }  // bytes, those that are shared with other versions included

  // A cell that contains p, a point with finite coordinates; nothing if p lies outside the hull.
  std::optional<LiveCell> locate(const Point& p) const;
  // The coordinates of a vertex; nothing if this version has no such vertex.
  std::optional<Point> point(PointId id) const;
  // The cells around a vertex, infinite ones included; nothing if this version has no such vertex.
  std::optional<std::vector<LiveCell>> star(PointId id) const;
  // The cell across the facet opposite a corner. REQUIRES: this version has returned the cell.
  LiveCell across(const LiveCell& cell, int corner) const;

 private:
  struct Place {
    const LiveTile* tile;
    LiveTile::Row row;
  };
  LiveCell cell(const Place& place) const;
  std::optional<std::pair<const LiveTile*, Vertex>> vertex(PointId id) const;
  const LiveTile& tile_near(const Point& p) const;
  Place true_cell_near(const LiveTile& tile, const CellRecord& cell, const Point& p) const;
  Place step(const Place& from, const CellRecord& cell, int facet) const;
  Place in_other_tile(const LiveTile& tile, Vertex v, const std::array<PointId, 4>& ids) const;
  std::array<PointId, 4> ids_of(const LiveTile& tile, const CellRecord& cell) const;

  std::uint64_t number_;
  std::shared_ptr<const Partition> partition_;
  Tiles tiles_;
  IdTiles ids_;
  int corners_;
  std::uint64_t vertices_ = 0;
  std::size_t memory_ = 0;
};

}  // namespace tessera
