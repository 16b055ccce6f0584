// Clips a Voronoi cell of the plane to a region. Exact: all decisions are signs of integers, and corners are rounded
// once at the end. So the corners on an edge that two cells share are the same for both.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "src/base/point.h"
#include "src/result/voronoi/cell_shape.h"
#include "src/result/voronoi/clip_region.h"
#include "src/result/voronoi/exact_number.h"

namespace tessera::voronoi {

// A cell: the points that are nearer to `site` than to all points `around`, which are counterclockwise around it. A
// bounded cell has a corner between each two of them, as their circumcentre with the site. An unbounded cell has none
// between the last and the first.
struct PlanarCell {
  Point site;
  std::span<const Point> around;
  bool bounded = true;
  std::span<const Point> corners;  // rounded; corner i is that of around[i] and the next point
};

// For one thread.
class CellClipper {
 public:
  explicit CellClipper(const ClipRegion& region) : region_(region) {}

  enum class Place : std::uint8_t { inside, outside, across };
  // Whether the closed cell meets no edge of the region and is inside or outside; else `across`, and then shape() may
  // follow.
  Place place_of(const PlanarCell& cell);
  // The part of the cell in the region, with each ring as it is rounded, perhaps not valid any more. REQUIRES:
  // place_of() was called for this cell.
  CellShape shape(const PlanarCell& cell);

 private:
  struct Corner {  // (x / w, y / w) times 2^exponent_, with w > 0
    Whole x, y, w;
    Point rounded;
  };
  struct Line {  // a x + b y - c w is positive on its left
    Whole a, b, c, dx, dy;
  };
  struct Segment {
    Line line;
    bool of_cell = false;
    std::uint32_t edge = 0;            // of the region
    std::size_t from = 0, to = 0;      // corners
    std::vector<std::size_t> on = {};  // corners on it
    bool reversed = false;             // runs from the greater corner to the less
  };
  // A piece of segments between two successive corners, of which `low` is the lesser.
  struct Piece {
    std::size_t low = 0, high = 0, segment = 0;
  };
  struct Arc {  // a piece in the direction that has the shape on its left
    std::size_t tail = 0, head = 0;
    Whole dx, dy;
    bool used = false;
  };

  std::size_t add_corner(Whole x, Whole y, Whole w);
  std::size_t add_point(const Point& p);
  std::array<Whole, 2> whole(const Point& p) const { return {whole_of(p.x, exponent_), whole_of(p.y, exponent_)}; }
  static int side(const Line& line, const Corner& corner);
  static bool less(const Corner& a, const Corner& b);
  void set_exponent(const PlanarCell& cell);
  void make_cell(const PlanarCell& cell);
  std::size_t far_corner(std::size_t from, const Line& along, bool ahead);
  void make_edges();
  void meet(std::size_t first, std::size_t second);
  std::vector<Piece> pieces();
  void keep(std::span<const Piece> same);
  bool in_cell(const Corner& middle) const;
  std::pair<bool, bool> in_region(const Corner& middle, const Piece& piece) const;
  std::vector<std::vector<std::size_t>> trace();
  std::size_t next_arc(std::size_t arc, std::span<const std::size_t> out) const;
  CellShape rounded_shape(const std::vector<std::vector<std::size_t>>& rings) const;

  const ClipRegion& region_;
  std::vector<std::uint32_t> near_;  // edges of the region
  int exponent_ = 0;
  std::vector<Corner> corners_;
  std::vector<Segment> segments_;
  std::size_t cell_segments_ = 0;
  std::vector<Line> bisectors_;
  std::vector<std::size_t> rank_;       // of corners: equal corners have one rank
  std::vector<std::size_t> corner_of_;  // by rank
  std::vector<Arc> arcs_;
};

}  // namespace tessera::voronoi
