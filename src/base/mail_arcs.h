// Mail between tiles, as those who watch a job see it: arcs between parts of the map of its tiles, of which there are
// few however many tiles there are.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <map>
#include <mutex>
#include <utility>
#include <vector>

#include "src/base/tile_map.h"

namespace tessera {

// Of an event, and of a word of a node that is alone; with three numbers each they are less than 4 KiB on any wire.
inline constexpr std::size_t mail_arcs_max = 128;

// From a part of the map to another one. A part >= 0 is a row of TileLayout::cuts with all that is below it, a
// negative one the tile -1-part: as the children of a TileCut.
struct MailArc {
  std::int32_t from = 0, to = 0;
  std::uint64_t bytes = 0;
  friend bool operator==(const MailArc&, const MailArc&) = default;
};

// The `max` with most bytes, those first; of equal ones in the order of their parts.
std::vector<MailArc> heaviest(std::vector<MailArc> arcs, std::size_t max);

// The tiles as at most `max` parts, none of which has many more tiles than others.
struct MapParts {
  static constexpr std::uint16_t nowhere = 0xffff;
  std::vector<std::uint16_t> of_tile;  // a place in `codes`; `nowhere` for one that the layout does not have
  std::vector<std::int32_t> codes;     // of the parts, as in MailArc; without cuts, a tile in the middle of them
};
MapParts parts_of(const TileLayout& layout, std::size_t tiles, std::size_t max);

// What was sent in the last one to two seconds. Safe from any thread.
class RecentMail {
 public:
  using Time = std::chrono::steady_clock::time_point;
  static constexpr std::chrono::seconds half{1};

  void add(const std::vector<MailArc>& arcs, Time now = std::chrono::steady_clock::now());
  std::vector<MailArc> heaviest(Time now = std::chrono::steady_clock::now()) const;

 private:
  using Bytes = std::map<std::pair<std::int32_t, std::int32_t>, std::uint64_t>;
  mutable std::mutex mutex_;
  Bytes now_, before_;
  Time since_{};  // of now_
};

}  // namespace tessera
