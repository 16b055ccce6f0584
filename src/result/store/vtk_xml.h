// The XML of tile files and of the master file, as FORMAT.md specifies.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "src/base/attribute.h"
#include "src/base/files/names.h"
#include "src/base/ids.h"
#include "src/result/store/tile_layout.h"
#include "src/result/store/tile_store.h"

namespace tessera::store {

struct TileHeader {
  int format = unchanged_format;
  int dimension = 3;
  TileId tile;
  std::uint64_t points = 0;
  std::uint64_t cells = 0;
  bool final = false;
  bool neighbors = true;
  std::vector<Attribute> schema;
  std::vector<Attribute> cell_schema = {};  // only in changed results
  bool images = false;                      // only if a vertex is an image
  std::vector<std::uint64_t> offsets;       // of the arrays of tile_arrays(), counted from the end of the header

  std::vector<ArrayInfo> arrays() const {
    return tile_arrays(dimension, final, neighbors, schema, cell_schema, images);
  }
  // Bytes of an array of this tile before packing. REQUIRES: points, cells < 2^32.
  std::uint64_t bytes_of(const ArrayInfo& array) const;
};

// The text before the first array, padded with blanks to `size` bytes. REQUIRES: one offset for each array.
std::string header_text(const TileHeader& header, std::size_t size = 0);
// The header from which header_text() made `text`; nothing for any other text.
std::optional<TileHeader> parse_header(std::string_view text);

inline constexpr std::string_view header_end = "<AppendedData encoding=\"raw\">\n_";
inline constexpr std::string_view footer = "\n</AppendedData>\n</VTKFile>\n";

// A PUnstructuredGrid over the tiles. Depends only on the manifest's dimension, schema and tiles.
std::string master_text(const Manifest& manifest);

}  // namespace tessera::store
