// The contour lines in squares of a grid between nodes with values, as pieces (marching squares).
//
// A line crosses a side of a square where the linear value between the two nodes equals the level, and goes straight
// from side to side. When two opposite nodes are above the level and two below, the mean of the four decides which two
// are joined. So at each side that a line crosses, one piece ends and one begins, and no two pieces of a square cross:
// a piece cuts off nodes that are all on one side of its level, and so are all values between them. Lines are closed,
// or end at squares with a node without a value.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <stop_token>
#include <utility>
#include <vector>

#include "src/base/ids.h"
#include "src/base/point.h"
#include "src/base/result.h"
#include "src/base/stopped.h"
#include "src/result/terrain/contour_cells.h"

namespace tessera::terrain {

// Nodes of the one lattice that covers the plane: node i is at i * res in x, and likewise in y.
struct Lattice {
  double res = 1;
  std::int64_t column0 = 0, row0 = 0;  // the first column, the lowest row
  std::int64_t width = 0, height = 0;  // in nodes
};

class SquareCells {
 public:
  // `values` are those of the nodes of `part`, row by row, in units of the interval, so that levels are whole numbers;
  // no value is a whole number; NaN: there is no value. `whole` contains all nodes of `part`, and numbers them.
  SquareCells(const Lattice& part, const Lattice& whole, std::vector<double> values);

  // The lowest level of a square, and one above the highest; equal when there is none.
  std::int64_t begin() const { return begin_; }
  std::int64_t end() const { return end_; }
  // True if a value is too far from zero to tell levels apart; then there are no pieces.
  bool too_far() const { return too_far_; }
  // An upper bound of the number of pieces of each level, from begin() on.
  std::vector<std::uint64_t> most_pieces() const;
  // Where the level crosses the side between two nodes: at least a thousandth of the side from the nodes, so that lines
  // of one level do not meet there. The same bits whatever `part` is.
  Point crossing(const TileEdge& side, std::int64_t level) const;
  PointId id_of(std::int32_t node) const;

  // Calls give(piece) for all pieces with levels from `begin` to below `end`. Throws Stopped.
  template <class Give>
  Status for_each_piece(std::int64_t begin, std::int64_t end, const Give& give, const std::stop_token& stop) const {
    StopCheck check(stop, squares_a_look);
    for (std::int64_t row = 0; row + 1 < part_.height; ++row) {
      for (std::int64_t column = 0; column + 1 < part_.width; ++column) {
        check.step();
        const Square square = square_at(column, row);
        for (std::int64_t level = std::max(square.low, begin); level < std::min(square.high, end); ++level)
          give_pieces(square, level, give);
      }
    }
    return success();
  }

 private:
  static constexpr std::uint32_t squares_a_look = 4096;

  struct Square {
    std::array<std::int32_t, 4> nodes;  // counterclockwise
    std::array<double, 4> values;
    std::int64_t low = 0, high = 0;  // its levels, up to below `high`
  };
  Square square_at(std::int64_t column, std::int64_t row) const;

  // The higher side is on the left: a piece begins where the sides, followed counterclockwise, go below the level, and
  // ends where they come above it.
  template <class Give>
  static void give_pieces(const Square& square, std::int64_t level, const Give& give) {
    const auto height = static_cast<double>(level);
    const auto above = [&](std::size_t k) { return square.values[k % 4] > height; };
    const auto side = [&](std::size_t k) {
      const std::int32_t a = square.nodes[k % 4], b = square.nodes[(k + 1) % 4];
      return TileEdge{std::min(a, b), std::max(a, b)};
    };
    const auto& v = square.values;
    const bool joined = (v[0] + v[2]) + (v[1] + v[3]) > 4 * height;  // the areas above the level join across the middle
    for (std::size_t k = 0; k < 4; ++k) {
      if (!above(k) || above(k + 1)) continue;
      std::size_t to = k;
      if (joined) {  // the next side on which they come above
        do ++to;
        while (above(to) || !above(to + 1));
      } else {  // the last such side
        to += 4;
        do --to;
        while (above(to) || !above(to + 1));
      }
      give(Piece{level, side(k), side(to)});
    }
  }

  Lattice part_, whole_;
  std::vector<double> values_;
  std::int64_t begin_ = 0, end_ = 0;
  bool too_far_ = false;
};

}  // namespace tessera::terrain
