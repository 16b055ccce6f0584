// How the points of a LAZ file are compressed: the LASzip record ("laszip encoded", 22204).
// Source: rapidlasso, LAZ Specification 1.4.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "src/base/result.h"

namespace tessera::laz {

enum class Compressor : std::uint16_t { none = 0, pointwise = 1, pointwise_chunked = 2, layered_chunked = 3 };
enum class ItemType : std::uint16_t {
  byte = 0,
  point_10 = 6,
  gps_time_11 = 7,
  rgb_12 = 8,
  wave_packet_13 = 9,
  point_14 = 10,
  rgb_14 = 11,
  rgb_nir_14 = 12,
  wave_packet_14 = 13,
  byte_14 = 14
};

// The most extra bytes of a record. No known file has more, and each byte costs a kilobyte of models while a chunk is
// decoded.
inline constexpr std::uint16_t extra_bytes_max = 2048;

struct LazItem {
  ItemType type;
  std::uint16_t bytes = 0, version = 0;
};

struct LazLayout {
  Compressor compressor = Compressor::none;
  std::uint32_t chunk_points = 0;  // UINT32_MAX: the chunk table has the number of points of each chunk
  std::vector<LazItem> items;
  // Returns the item of this type; null if records have none.
  const LazItem* find(ItemType type) const {
    const auto found = std::find_if(items.begin(), items.end(), [&](const LazItem& item) { return item.type == type; });
    return found == items.end() ? nullptr : &*found;
  }
  bool chunked() const {
    return compressor == Compressor::pointwise_chunked || compressor == Compressor::layered_chunked;
  }
  bool variable_chunks() const { return chunked() && chunk_points == UINT32_MAX; }
};

// Reads the LASzip record; `record` is its payload. Error bad_input, naming `path`, for a record that ends early, an
// unknown coder or version, and items that do not make up records of `record_bytes` bytes in `point_format`.
Result<LazLayout> read_laz_layout(const std::string& path, std::span<const std::byte> record, int point_format,
                                  std::uint16_t record_bytes);

// The layout that writers use for records of `record_bytes` bytes in `point_format`: chunked, items of version 2 or 3.
// REQUIRES: a point format without waveforms; record_bytes is at least that of the format.
LazLayout standard_layout(int point_format, std::uint16_t record_bytes, std::uint32_t chunk_points);

}  // namespace tessera::laz
