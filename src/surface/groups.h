// Which tiles decide together before all tiles do. A group of level 1 is some tiles, a group of level 2 is some groups
// of level 1, and level 3 is all tiles. What a group cannot decide lies at its border, so little is left for the last
// level.
//
// Groups consist of tiles with successive numbers: tiles that partition() has separated last are next to each other.
// The grouping affects time only, never the result.
#pragma once

#include <algorithm>
#include <cstddef>

namespace tessera::surface {

class Groups {
 public:
  static constexpr unsigned levels = 3;

  // `together`: all tiles are one group of level 1.
  Groups(std::size_t tiles, bool together) : tiles_(tiles) {
    if (together) of_ = std::max(tiles, of_);
    while (of_ * of_ * of_ < tiles) of_ *= 2;
  }
  std::size_t first_of(std::size_t tile, unsigned level) const { return tile - tile % size(level); }
  // A group is named by its first tile. members() returns how many members of the level below it has, member() the
  // first tile of member i.
  std::size_t members(std::size_t first, unsigned level) const {
    const std::size_t end = std::min(first + size(level), tiles_);
    return (end - first + size(level - 1) - 1) / size(level - 1);
  }
  std::size_t member(std::size_t first, unsigned level, std::size_t i) const { return first + i * size(level - 1); }
  // Returns in which member of its group of this level a tile is.
  std::size_t member_of(std::size_t tile, unsigned level) const {
    return (tile - first_of(tile, level)) / size(level - 1);
  }

 private:
  std::size_t size(unsigned level) const {
    std::size_t tiles = 1;
    for (unsigned i = 0; i < level; ++i) tiles *= of_;
    return tiles;
  }

  std::size_t tiles_;
  std::size_t of_ = 4;  // members of a group
};

}  // namespace tessera::surface
