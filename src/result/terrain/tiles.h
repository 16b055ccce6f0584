// Chooses which tiles of a result are read.
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
#include "src/result/export/cell_filter.h"
#include "src/result/tile_source.h"

namespace tessera::terrain {

// Error usage for a 3D result, whose cells are no surface over a plane, and for limits that are no lengths.
Status check_surface(const std::filesystem::path& out, const Manifest& manifest, const exports::CellSizes& sizes);

// Error usage when the box is outside of all points; the message says where the points are.
Status check_meets(const Manifest& manifest, const std::optional<Bounds>& box);

// Memory for tiles during the search; and when to stop.
struct Looking {
  std::uint64_t memory_bytes = 0;
  std::stop_token stop = {};
};

// For a 2D result, returns the tiles that own a vertex of a cell that meets the closed box; or all tiles, when there is
// no box or it covers half of the result, because a search would then take as long as reading. Errors: usage when there
// is no such tile; those of reading.
Result<std::vector<std::size_t>> tiles_meeting(const TileSource& source, const std::optional<Bounds>& box,
                                               const Looking& looking);

// Remarks about a drawing: that its coordinates have no coordinate system, that a region does not know the whole box,
// or how many pixels have no value because the region does not know their neighbours. Else empty.
std::string note_of(const Manifest& manifest, const std::optional<Bounds>& box, std::uint64_t unknown_pixels = 0);

}  // namespace tessera::terrain
