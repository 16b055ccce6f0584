// The XML of tile files and of the master file, as FORMAT.md gives it.
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
  std::vector<std::uint64_t> offsets;       // of tile_arrays(), from the end of the header

  std::vector<ArrayInfo> arrays() const { return tile_arrays(dimension, final, neighbors, schema, cell_schema); }
  // How many bytes an array of this tile has before it is packed. REQUIRES: points, cells < 2^32.
  std::uint64_t bytes_of(const ArrayInfo& array) const;
};

// All that stands before the first array, filled up to `size`. REQUIRES: an offset an array.
std::string header_text(const TileHeader& header, std::size_t size = 0);
// What header_text() made `text` of; nothing when it made no such text.
std::optional<TileHeader> parse_header(std::string_view text);

inline constexpr std::string_view header_end = "<AppendedData encoding=\"raw\">\n_";
inline constexpr std::string_view footer = "\n</AppendedData>\n</VTKFile>\n";

// A PUnstructuredGrid over the tiles: a function of dimension, schema and tiles of the manifest.
std::string master_text(const Manifest& manifest);

}  // namespace tessera::store
