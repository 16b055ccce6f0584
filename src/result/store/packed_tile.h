// A tile file as packed arrays: their places and their bytes. The values in the arrays are not checked here.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "src/base/result.h"
#include "src/result/store/data_file.h"
#include "src/result/store/tile_layout.h"
#include "src/result/store/vtk_xml.h"

namespace tessera::store {

class PackedTile {
 public:
  // An array of the file.
  struct Packed {
    ArrayInfo info;
    std::uint64_t bytes = 0;           // unpacked
    std::uint64_t table = 0;           // offset of the table
    std::uint64_t begin = 0;           // offset of the first block
    std::uint64_t end = 0;             // end of the last block
    std::vector<std::uint64_t> sizes;  // of the blocks
  };

  // Reads header and tables. Error corrupt when no tile can have them.
  static Result<PackedTile> open(DataFile file, TileId tile);

  const TileHeader& header() const { return header_; }
  const std::vector<Packed>& arrays() const { return arrays_; }  // in the header's order

  // Makes the error "out/tiles/000042.vtu, PointData/id: reason".
  Error corrupt(const std::string& place, const std::string& reason) const;

  // Reads an array. REQUIRES: every tile has the array.
  template <class List>
  Status read_array(Section section, std::string_view name, List& values) const {
    return read_array(find(section, name), values);
  }

  template <class List>
  Status read_array(const Packed& array, List& values) const {
    values.resize(array.bytes / sizeof(typename List::value_type));
    return read_blocks(array, std::as_writable_bytes(std::span(values)));
  }

  // Reads a part of the array as it stands in the file, table and blocks. Nothing in it is checked.
  Status read_raw(const Packed& array, std::uint64_t offset, std::span<std::byte> buffer) const;

 private:
  explicit PackedTile(DataFile file) : file_(std::move(file)) {}
  Result<bool> read_at(std::uint64_t offset, std::span<std::byte> buffer) const;
  Status read_header(TileId tile);
  Status read_tables();
  const Packed& find(Section section, std::string_view name) const;
  Status read_blocks(const Packed& array, std::span<std::byte> values) const;

  DataFile file_;
  TileHeader header_;
  std::uint64_t data_begin_ = 0;
  std::vector<Packed> arrays_;
};

}  // namespace tessera::store
