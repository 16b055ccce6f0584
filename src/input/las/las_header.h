// The header and the variable length records of a LAS 1.0-1.4 file, checked against the file.
// Source: ASPRS, LAS Specification 1.4 - R15 (2019), and versions 1.0 to 1.3 where they differ.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "src/base/attribute.h"
#include "src/base/point.h"
#include "src/base/result.h"
#include "src/input/bytes/byte_source.h"

namespace tessera {

// Where an attribute is in a point record. The value is the bits `mask` of the number at `offset`, shifted right by
// `shift`, then times `scale` plus `add`.
struct LasField {
  Attribute attribute;
  std::size_t offset = 0;
  AttributeType stored = AttributeType::u8;
  unsigned shift = 0;
  std::uint8_t mask = 0xFF;  // used only for stored == u8
  double scale = 1, add = 0;
  bool plain() const { return mask == 0xFF && shift == 0 && scale == 1 && add == 0; }
};

struct LasHeader {
  int minor = 0;                   // the version is 1.minor
  int point_format = 0;            // 0..10
  std::uint16_t record_bytes = 0;  // as declared, including extra bytes
  std::uint64_t points_at = 0;     // the offset of the first record
  std::uint64_t points = 0;
  std::array<double, 3> scale{}, offset{};
  Bounds bounds;         // as declared; empty if the declared bounds are no box
  std::string crs;       // WKT or "EPSG:n", or empty
  std::string crs_note;  // why `crs` is empty although the file has GeoTIFF keys or well-known text
  std::vector<LasField> fields;
  bool compressed = false;        // LAZ
  std::vector<std::byte> laszip;  // the payload of the LASzip record; empty if there is none
  std::vector<std::byte> copc;    // the payload of the COPC info record; empty if there is none
};

// The bytes of a record of a point format from 0 to 10 without extra bytes.
std::uint16_t standard_record_bytes(int point_format);

// Error bad_input for what is not LAS, an unknown version or point format, and sizes and offsets that contradict each
// other or the file. The number of points is not yet compared with the file's size.
Result<LasHeader> read_las_header(const ByteSource& source);

}  // namespace tessera
