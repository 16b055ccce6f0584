// A tile of one version of a live result. Nobody changes the tile any more: to change it, a writer makes a copy. So any
// number of threads may read it without a lock.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "src/base/point.h"
#include "src/base/result.h"
#include "src/tiling/tile/known_from_start.h"
#include "src/tiling/tile/tile_triangulation.h"

namespace tessera {

class LiveTile {
 public:
  // `triangulation`: settled, and not flat.
  explicit LiveTile(std::unique_ptr<const TileTriangulation> triangulation);

  const TileTriangulation& triangulation() const { return *triangulation_; }
  std::size_t memory() const { return memory_; }

  // A cell by its row in the kernel.
  using Row = std::uint32_t;
  CellRecord row(Row r) const { return triangulation_->kernel().row(r); }
  bool has_own(const CellRecord& cell) const;
  bool infinite(const CellRecord& cell) const;
  // A finite cell with an own vertex, near p if p is among the own points.
  Row near(const Point& p) const;
  // Walks to the cell of the tile's triangulation that contains p, or to an infinite cell that sees p. Cells without an
  // own vertex may be no cells of the whole triangulation.
  Row find(const Point& p) const;
  // The facet of a cell, by its opposite corner, that has p strictly behind it; nothing if there is none. `first`: the
  // corner that is asked first. REQUIRES: the cell is finite.
  std::optional<int> facet_before(const CellRecord& cell, const Point& p, std::uint32_t first) const;
  // The own point with these coordinates, if there is one.
  std::optional<PointId> own_at(const Point& p) const;
  // The cells around an own vertex. Some cells may be infinite.
  std::vector<Row> star(Vertex v) const;

 private:
  int corners() const { return dimension_ + 1; }
  void sample();
  std::size_t place_of(const Point& p) const;

  std::unique_ptr<const TileTriangulation> triangulation_;
  int dimension_;
  std::size_t memory_ = 0;
  // A grid over the own points: a finite cell near each of its places.
  Bounds bounds_;
  std::uint32_t side_ = 1;
  std::vector<Row> grid_;
};

// What a live tile begins from, when no point is new.
struct LiveTilePoints {
  TileId self;
  int dimension = 3;
  std::vector<Point> points;         // the tile's own, in Hilbert order
  std::vector<PointId> ids;          // beside points
  std::vector<SharedPoint> foreign;  // the foreign vertices of its cells
};

// `around` outlives the tile. Errors, with the end of a sentence: corrupt when no tile can have these points; memory
// when a kernel cannot number them.
Result<std::shared_ptr<const LiveTile>> build_live_tile(LiveTilePoints tile, const KnownFromStart& around);

}  // namespace tessera
