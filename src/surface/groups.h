// Which tiles decide together, before all do: of level 1 each group is some tiles, of level 2 some groups, and level 3
// is all. What a group cannot decide lies at its rim, so that little is left for the last.
//
// By numbers of tiles, in ascending order: those that partition() has cut apart last are next to each other. Which
// tiles are together costs time, never truth.
#pragma once

#include <algorithm>
#include <cstddef>

namespace tessera::surface {

class Groups {
 public:
  static constexpr unsigned levels = 3;

  // `together`: all are one group of level 1.
  Groups(std::size_t tiles, bool together) : tiles_(tiles) {
    if (together) of_ = std::max(tiles, of_);
    while (of_ * of_ * of_ < tiles) of_ *= 2;
  }
  std::size_t first_of(std::size_t tile, unsigned level) const { return tile - tile % size(level); }
  // Of a group: how many it is made of, and where one of them begins.
  std::size_t members(std::size_t first, unsigned level) const {
    const std::size_t end = std::min(first + size(level), tiles_);
    return (end - first + size(level - 1) - 1) / size(level - 1);
  }
  std::size_t member(std::size_t first, unsigned level, std::size_t i) const { return first + i * size(level - 1); }
  // Which member of its group of this level a tile is in.
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
