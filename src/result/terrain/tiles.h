// Which tiles of a result are read.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "src/base/point.h"
#include "src/base/result.h"
#include "src/result/tile_source.h"

namespace tessera::terrain {

// Error usage for a 3D result, whose cells are no surface over a plane, and for a longest edge that is no length.
Status check_surface(const std::filesystem::path& out, const Manifest& manifest, const std::optional<double>& max_edge);

// Error usage, which says where the points are, when the box is outside of all of them.
Status check_meets(const Manifest& manifest, const std::optional<Bounds>& box);

// Memory that tiles may take while they are looked for; and when to end.
struct Looking {
  std::uint64_t memory_bytes = 0;
  std::stop_token stop = {};
};

// Of a 2D result: the tiles that own a vertex of a cell that meets the closed box. Without a box all of them, as when
// it covers half of the result or more: to find those that are not needed would take as long as to read them. Errors:
// usage when there is none; of reading.
Result<std::vector<std::size_t>> tiles_meeting(const TileSource& source, const std::optional<Bounds>& box,
                                               const Looking& looking);

// What there is to say of a drawing: that its coordinates have no system, that a region does not know all of its place.
// Else empty.
std::string note_of(const Manifest& manifest, const std::optional<Bounds>& box);

}  // namespace tessera::terrain
