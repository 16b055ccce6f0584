// Strong types for the numbers everything is keyed by.
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

// A point's rank in the input: files in the order given, then file order. The vertex's global id, for ever.
using PointId = Id<struct PointTag, std::uint64_t>;
// A tile's number, 0..tiles-1: never a PointId, nor an index into anything but lists of tiles.
using TileId = Id<struct TileTag, std::uint32_t>;
// A process that hosts tiles, as its coordinator numbers it.
using NodeId = Id<struct NodeTag, std::uint32_t>;
// A file of routed points: of those that one attempt at routing a stretch of the input has made, the number.
struct ShuffleFileId {
  std::uint32_t attempt = 0, number = 0;
  friend bool operator==(const ShuffleFileId&, const ShuffleFileId&) = default;
};
// A job, unique among those that a process has ever known.
using JobId = Id<struct JobTag, std::uint64_t>;

// Ids go to disk and over wires as their numbers' bytes.
static_assert(sizeof(PointId) == 8 && std::is_trivially_copyable_v<PointId> && std::is_standard_layout_v<PointId>);
static_assert(sizeof(TileId) == 4 && std::is_trivially_copyable_v<TileId> && std::is_standard_layout_v<TileId>);

// The numbers of ids, in place: for arrays that leave the program.
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
