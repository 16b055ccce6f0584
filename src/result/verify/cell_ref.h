// Names a cell or a vertex in a tile file, in error messages and in records that are compared between tiles.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>

#include "src/base/result.h"
#include "src/result/tile_source.h"

namespace tessera {

// The ids of up to 4 vertices, sorted; unused entries are padding_id.
using IdSet = std::array<PointId, 4>;
inline constexpr PointId padding_id{~std::uint64_t{0}};

struct CellRef {
  TileId tile;
  std::uint32_t cell = 0;  // index in the tile file
};

inline std::string text_of(const IdSet& ids) {
  std::string text;
  for (const auto id : ids)
    if (id != padding_id) text += (text.empty() ? "" : " ") + to_string(id);
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
