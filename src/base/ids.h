// Strong types for the numbers that identify points, tiles, nodes and jobs.
#pragma once

#include <compare>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

namespace tessera {

template <class Tag, class Rep>
struct Id {
  Rep value{};
  friend constexpr auto operator<=>(const Id&, const Id&) = default;
  friend std::string to_string(const Id& id) { return std::to_string(id.value); }
};

// The rank of a point in the input: files in the order given, then the order within a file. It is the vertex's global
// id for ever.
using PointId = Id<struct PointTag, std::uint64_t>;
// The number of a tile, from 0 to the number of tiles less 1.
using TileId = Id<struct TileTag, std::uint32_t>;
// The number that a job's coordinator gives to a process that hosts tiles.
using NodeId = Id<struct NodeTag, std::uint32_t>;
// A file of routed points: the number of the attempt that made it, and its number among the files of that attempt. An
// attempt is one try at routing one input split.
struct ShuffleFileId {
  std::uint32_t attempt = 0, number = 0;
  friend bool operator==(const ShuffleFileId&, const ShuffleFileId&) = default;
};
// A job, unique among all jobs that a process has ever known.
using JobId = Id<struct JobTag, std::uint64_t>;

// Ids go to disk and over the network as the bytes of their numbers.
static_assert(sizeof(PointId) == 8 && std::is_trivially_copyable_v<PointId> && std::is_standard_layout_v<PointId>);
static_assert(sizeof(TileId) == 4 && std::is_trivially_copyable_v<TileId> && std::is_standard_layout_v<TileId>);

// The numbers of ids, without a copy.
template <class Tag, class Rep>
std::span<const Rep> numbers_of(const std::vector<Id<Tag, Rep>>& ids) {
  static_assert(sizeof(Id<Tag, Rep>) == sizeof(Rep));
  return {reinterpret_cast<const Rep*>(ids.data()), ids.size()};
}

}  // namespace tessera

template <class Tag, class Rep>
struct std::hash<tessera::Id<Tag, Rep>> {
  std::size_t operator()(const tessera::Id<Tag, Rep>& id) const noexcept { return std::hash<Rep>{}(id.value); }
};
