// Makes lines from the pieces of contour lines in cells, some levels at a time.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <stop_token>
#include <utility>
#include <vector>

#include "src/base/option.h"
#include "src/base/result.h"
#include "src/base/stopped.h"
#include "src/result/terrain/contour_lines.h"
#include "src/result/terrain/link_pieces.h"

namespace tessera::terrain {

class LineMaker {
 public:
  // The memory of a piece and of the line's point that it makes.
  static constexpr std::uint64_t piece_bytes = sizeof(Piece) + 2 * sizeof(std::size_t) + sizeof(LinePoint);
  static constexpr std::uint64_t pieces_least = 1 << 16;

  // `vertices_max` bounds the vertices of all lines; 0: no bound.
  LineMaker(ContourLines& lines, std::uint64_t vertices_max, std::stop_token stop)
      : lines_(lines), vertices_max_(vertices_max), stop_(std::move(stop)) {}

  // Adds the lines of `cells`, which are ContourCells or SquareCells, with about `memory_bytes` for pieces. Safe to
  // call from several threads. Errors: usage when there are too many levels; memory beyond the bound; those of
  // ContourLines. Throws Stopped.
  template <class Cells>
  Status add(const Cells& cells, std::uint64_t memory_bytes) {
    BOOST_OUTCOME_TRYV(check_levels(cells));
    // Sorting this many takes some tenths of a second, in which a stop is not noticed.
    constexpr std::uint64_t pieces_at_once = 1 << 21;
    const std::uint64_t pieces_max = std::clamp(memory_bytes / piece_bytes, pieces_least, pieces_at_once);
    const std::vector<std::uint64_t> most = cells.most_pieces();
    std::vector<Piece> pieces;
    std::vector<LinePoint> points;
    // As many levels at a time as there is room for.
    for (std::int64_t begin = cells.begin(), end = begin; begin < cells.end(); begin = end) {
      std::uint64_t count = 0;
      do count += most[static_cast<std::size_t>(end++ - cells.begin())];
      while (end < cells.end() && count + most[static_cast<std::size_t>(end - cells.begin())] <= pieces_max);
      pieces.clear();
      BOOST_OUTCOME_TRYV(cells.for_each_piece(
          begin, end, [&](const Piece& piece) { pieces.push_back(piece); }, stop_));
      BOOST_OUTCOME_TRYV(link_pieces(pieces, [&](std::int64_t level, const std::vector<TileEdge>& edges) -> Status {
        throw_if_stopped(stop_);
        points.clear();
        for (const TileEdge& edge : edges) {
          const Point at = cells.crossing(edge, level);
          points.push_back({cells.id_of(edge.a), cells.id_of(edge.b), at.x, at.y});
        }
        BOOST_OUTCOME_TRYV(count_vertices(points.size()));
        return lines_.add(level, points);
      }));
    }
    return success();
  }

  // Error usage for too many levels, which could not be counted in memory: the interval must be wrong.
  template <class Cells>
  static Status check_levels(const Cells& cells) {
    constexpr std::int64_t levels_max = 1 << 22;
    if (cells.too_far() || cells.end() - cells.begin() > levels_max)
      return error(Errc::usage, option("interval") + ": is too small for the values of the vertices");
    return success();
  }

 private:
  Status count_vertices(std::uint64_t more) {
    vertices_ += more;
    if (vertices_max_ > 0 && vertices_ > vertices_max_)
      return error(Errc::memory, "the lines have more than " + std::to_string(vertices_max_) +
                                     " vertices: ask for a smaller " + option("bbox") + " or a larger " +
                                     option("interval"));
    return success();
  }

  ContourLines& lines_;
  std::uint64_t vertices_max_;
  std::stop_token stop_;
  std::atomic<std::uint64_t> vertices_{0};
};

}  // namespace tessera::terrain
