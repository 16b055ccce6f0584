// Names a cell or a vertex in a tile file, in error messages and in records that are compared between tiles.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>

#include "src/base/image.h"
#include "src/base/result.h"
#include "src/result/tile_source.h"

namespace tessera {

// The ids of up to 4 vertices, sorted; unused entries are padding_id. In a periodic result these are images
// (src/base/image.h), shifted such that the one with the least id, and of its images the least, has the offset 0.
using IdSet = std::array<PointId, 4>;
inline constexpr PointId padding_id{~std::uint64_t{0}};

struct CellRef {
  TileId tile;
  std::uint32_t cell = 0;  // index in the tile file
};

// "12", or of an image "12[0 -1 0]".
inline std::string text_of(PointId id) {
  if (offset_code(id) == 0 || offset_code(id) >= image::codes) return to_string(id);
  const auto by = offset_of(id).by;
  return to_string(plain(id)) + "[" + std::to_string(by[0]) + " " + std::to_string(by[1]) + " " +
         std::to_string(by[2]) + "]";
}

inline std::string text_of(const IdSet& ids) {
  std::string text;
  for (const auto id : ids)
    if (id != padding_id) text += (text.empty() ? "" : " ") + text_of(id);
  return text;
}

// Makes an error not_delaunay: "out/tiles/000007.vtu: cell 12 (vertices 1 5 8 9) is not positively oriented".
inline Error wrong_cell(const TileSource& source, const CellRef& place, const IdSet& ids, const std::string& reason) {
  return error(Errc::not_delaunay, source.file(place.tile).string() + ": cell " + std::to_string(place.cell) +
                                       " (vertices " + text_of(ids) + ") " + reason);
}

inline Error wrong_tile(const TileSource& source, TileId tile, const std::string& reason) {
  return error(Errc::not_delaunay, source.file(tile).string() + ": " + reason);
}

}  // namespace tessera
