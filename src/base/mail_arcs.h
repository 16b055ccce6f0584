// The mail between tiles, as people who watch a job see it: arcs between regions of the tile map. There are few
// regions, however many tiles there are.
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

// The most arcs in an event. A node of a cluster reports a quarter of them at a time. With three numbers each the arcs
// take less than 4 KiB in any encoding.
inline constexpr std::size_t mail_arcs_max = 128;

// Bytes that went from one region of the map to another. A region >= 0 is a row of TileLayout::cuts with everything
// below it. A negative region is the tile -1-region, as in the children of a TileCut.
struct MailArc {
  std::int32_t from = 0, to = 0;
  std::uint64_t bytes = 0;
  friend bool operator==(const MailArc&, const MailArc&) = default;
};

// Returns the `max` arcs with most bytes, in decreasing order. Arcs with equal bytes are ordered by their regions.
std::vector<MailArc> heaviest(std::vector<MailArc> arcs, std::size_t max);

// The tiles of a map, grouped into regions.
struct MapRegions {
  static constexpr std::uint16_t nowhere = 0xffff;
  // by tile: an index into `codes`, or `nowhere` for a tile that the layout lacks
  std::vector<std::uint16_t> of_tile;
  // the regions, coded as in MailArc; without cuts a region is coded as a tile in its middle
  std::vector<std::int32_t> codes;
};
// Groups the tiles into at most `max` regions of similar numbers of tiles.
MapRegions map_regions_of(const TileLayout& layout, std::size_t tiles, std::size_t max);

// The mail of the last one to two seconds. Thread-safe.
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
  Time since_{};  // when now_ began
};

}  // namespace tessera
