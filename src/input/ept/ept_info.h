// ept.json: what a cloud in EPT is made of.
// Source: Entwine Point Tile, version 1.1.0 (entwine.io, 2020), and 1.0.0 where it differs.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "src/base/attribute.h"
#include "src/base/point.h"
#include "src/base/result.h"
#include "src/input/bytes/byte_source.h"

namespace tessera::ept {

// A number of each record of a binary tile. The value is the stored number times `scale` plus `offset`.
struct Dimension {
  std::string name;  // "X", "Intensity", "GpsTime", ...
  AttributeType type = AttributeType::f64;
  std::size_t at = 0;  // its place in the record, in bytes
  double scale = 1, offset = 0;
  bool plain() const { return scale == 1 && offset == 0; }
};

struct Info {
  enum class Tiles : std::uint8_t { laz, binary, zstd };

  std::filesystem::path path;  // that of ept.json
  Bounds cube;                 // the root of the octree
  Bounds conforming;           // a box of all points, as stated; empty if none is stated
  Tiles tiles = Tiles::laz;
  std::uint64_t points = 0;
  double span = 0;  // the voxels along a side of each node
  std::vector<Dimension> dimensions;
  std::size_t record_bytes = 0;  // of a record of a binary tile
  std::string crs;               // WKT, "EPSG:n" or empty
  std::string crs_note;          // why `crs` is empty although the file has something

  // The distance between points at the root.
  double spacing() const { return (cube.hi.x - cube.lo.x) / span; }
  // How far rounding may put a point outside the cube of its node.
  double slack() const;
};

// Returns nothing for a dimension that the file does not have.
const Dimension* find(const Info& info, std::string_view name);

// Reads ept.json. Errors, bad_input: what is not JSON or not EPT; versions, types and numbers that are not known or
// impossible; a cloud without X, Y or Z.
Result<Info> read_info(const ByteSource& source);

// Reads a file of EPT that is one JSON object and has at most 16 MiB.
Result<std::string> read_text(const ByteSource& source);

}  // namespace tessera::ept
