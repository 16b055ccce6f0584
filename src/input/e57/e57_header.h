// What an E57 file says of itself: its header, and the scans that its XML section lists.
// Source: ASTM E2807-11; Huber, The ASTM E57 File Format for 3D Imaging Data Exchange (2011).
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "src/base/result.h"
#include "src/input/bytes/byte_source.h"
#include "src/input/e57/e57_pages.h"

namespace tessera {

// A number of each record.
struct E57Field {
  enum class Kind : std::uint8_t { single, real, integer, scaled, text };
  std::string name;  // "cartesianX", "intensity", "nor:normalX", ...
  Kind kind = Kind::real;
  std::int64_t minimum = INT64_MIN, maximum = INT64_MAX;  // of integer and scaled, as stored
  double scale = 1, offset = 0;                           // scaled: the value is stored * scale + offset
  unsigned bits() const;                                  // of a stored value; 0: all values are `minimum`
};

// A scan: its records, and the motion into the coordinate system of the file.
struct E57Scan {
  std::size_t number = 0;       // in the file, from 0
  std::uint64_t points_at = 0;  // physical offset of the section with the records
  std::uint64_t records = 0;
  std::vector<E57Field> fields;
  std::array<double, 4> rotation{1, 0, 0, 0};  // a quaternion: w x y z
  std::array<double, 3> translation{};
  bool posed = false;  // the file says where the scanner was
};

struct E57Header {
  std::vector<E57Scan> scans;
  std::string crs;  // WKT, or what else the file says of its coordinate system
};

// The size of a page, from the first 48 bytes of the file. Error bad_input for what is not E57 of version 1, and for a
// file of another length than its header says.
Result<std::size_t> e57_page_bytes(const ByteSource& source);

// Reads the XML section. Error bad_input for what is not well formed, or makes no sense.
Result<E57Header> read_e57_header(E57Pages& pages);

}  // namespace tessera
