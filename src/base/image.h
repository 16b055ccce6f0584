// Images. In a periodic cloud a point stands for all points that lie whole periods away from it, and so does a tile.
// Each of these is an image: the point or the tile itself, and an offset (docs/periodic-design.md).
//
// An image of a point is a PointId, and an image of a tile a TileId, with the offset in the upper bits. The offset 0 is
// the number 0 there: so a number without an offset is the image that is the point, or the tile, itself.
#pragma once

#include <algorithm>
#include <array>
#include <compare>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "src/base/ids.h"
#include "src/base/point.h"

namespace tessera {

// How many periods an image lies away, by axis.
struct PeriodOffset {
  std::array<int, 3> by{};
  // Lexicographic, so the order of two images stays the same when both are shifted.
  friend auto operator<=>(const PeriodOffset&, const PeriodOffset&) = default;
  friend PeriodOffset operator+(const PeriodOffset& a, const PeriodOffset& b) {
    return {{a.by[0] + b.by[0], a.by[1] + b.by[1], a.by[2] + b.by[2]}};
  }
  friend PeriodOffset operator-(const PeriodOffset& a, const PeriodOffset& b) {
    return {{a.by[0] - b.by[0], a.by[1] - b.by[1], a.by[2] - b.by[2]}};
  }
  // Whether all numbers are -1, 0 or 1: tiles know no other images.
  bool near() const { return -1 <= by[0] && by[0] <= 1 && -1 <= by[1] && by[1] <= 1 && -1 <= by[2] && by[2] <= 1; }
};

// The period along each axis. 0: the cloud is not periodic along this axis. Coordinates and periods are such that a
// coordinate plus or minus a period is a double without rounding.
struct Period {
  std::array<double, 3> length{};

  friend bool operator==(const Period&, const Period&) = default;

  bool any() const { return length[0] > 0 || length[1] > 0 || length[2] > 0; }
  bool along(int axis) const { return length[static_cast<std::size_t>(axis)] > 0; }
  // How many of the axes have no period.
  int open_axes(int dimension) const {
    int axes = 0;
    for (int axis = 0; axis < dimension; ++axis) axes += along(axis) ? 0 : 1;
    return axes;
  }
  // Whether an image can have this offset.
  bool allows(const PeriodOffset& o) const {
    const auto fits = [&](int axis) { return o.by[axis] == 0 || length[axis] > 0; };
    return o.near() && fits(0) && fits(1) && fits(2);
  }
  Point shifted(const Point& p, const PeriodOffset& o) const {
    return {p.x + o.by[0] * length[0], p.y + o.by[1] * length[1], p.z + o.by[2] * length[2]};
  }
  // All that near images can have; 0 is among them.
  std::vector<PeriodOffset> offsets() const {
    std::vector<PeriodOffset> out;
    for (int x = -1; x <= 1; ++x) {
      for (int y = -1; y <= 1; ++y) {
        for (int z = -1; z <= 1; ++z) {
          if (const PeriodOffset o{{x, y, z}}; allows(o)) out.push_back(o);
        }
      }
    }
    return out;
  }
};

namespace image {
inline constexpr std::uint32_t codes = 27, code_of_none = 13;
inline constexpr int point_bits = 59, tile_bits = 26;  // below the code: more than points and tiles can have

// The rank of a near offset in the order of offsets, from 0 to 26.
constexpr std::uint32_t rank(const PeriodOffset& o) {
  return static_cast<std::uint32_t>((o.by[0] + 1) * 9 + (o.by[1] + 1) * 3 + o.by[2] + 1);
}
constexpr std::uint32_t code(const PeriodOffset& o) { return (rank(o) + codes - code_of_none) % codes; }
constexpr PeriodOffset offset(std::uint32_t code) {
  const auto rank = static_cast<int>((code + code_of_none) % codes);
  return {{rank / 9 - 1, rank / 3 % 3 - 1, rank % 3 - 1}};
}
}  // namespace image

inline PointId plain(PointId id) { return {id.value & ((std::uint64_t{1} << image::point_bits) - 1)}; }
inline TileId plain(TileId id) { return {id.value & ((std::uint32_t{1} << image::tile_bits) - 1)}; }
inline std::uint32_t offset_code(PointId id) { return static_cast<std::uint32_t>(id.value >> image::point_bits); }
inline std::uint32_t offset_code(TileId id) { return id.value >> image::tile_bits; }
template <class AnyId>
PeriodOffset offset_of(AnyId id) {
  return image::offset(offset_code(id));
}
// Whether two images are near each other.
template <class One, class Other>
bool near(One a, Other b) {
  return offset_code(a) == offset_code(b) || (offset_of(a) - offset_of(b)).near();
}
// REQUIRES: the offset is near.
inline PointId image_of(PointId id, const PeriodOffset& o) {
  return {plain(id).value | std::uint64_t{image::code(o)} << image::point_bits};
}
inline TileId image_of(TileId id, const PeriodOffset& o) {
  return {plain(id).value | image::code(o) << image::tile_bits};
}
// Orders images of tiles: by tile, and images of one tile by offset. In this order a tile itself comes after its images
// with smaller offsets.
inline TileId rank_of(TileId id) { return {plain(id).value * image::codes + image::rank(offset_of(id))}; }

// Sorts the images of a simplex, and shifts them so that the first has no offset: then all simplices that are the same
// up to a shift are equal. The order is that of the source indices, and of images of one point that of their offsets,
// which a shift does not change. REQUIRES: each two images are near each other.
inline void sort_up_to_shifts(std::span<PointId> images) {
  const auto order = [](PointId id) { return std::pair(plain(id).value, image::rank(offset_of(id))); };
  std::sort(images.begin(), images.end(), [&](PointId a, PointId b) { return order(a) < order(b); });
  const PeriodOffset first = offset_of(images.front());
  for (PointId& id : images) id = image_of(id, offset_of(id) - first);
}

}  // namespace tessera
