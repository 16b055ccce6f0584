// Builds a binary glTF 2.0 file piece by piece: one mesh of triangles, compressed (EXT_meshopt_compression).
#pragma once

#include <cstddef>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <span>
#include <vector>

#include "src/base/point.h"

namespace tessera::tileset {

// glTF and the compression need strides of vertices that are multiples of 4.
struct PackedPosition {
  std::uint16_t at[3], unused = 0;
};
struct PackedShort {
  std::uint16_t value, unused = 0;
};
struct PackedByte {
  std::uint8_t value, unused[3] = {0, 0, 0};
};

class GlbFile {
 public:
  using Json = nlohmann::ordered_json;

  // Adds positions in 65,535 steps over their extent on each axis, in glTF's axes x, z, -y. REQUIRES: there are
  // positions.
  void add_positions(std::span<const Point> positions, const Point& origin);
  // Add attributes of the vertices.
  void add_shorts(const char* name, const std::vector<PackedShort>& values);
  void add_bytes(const char* name, const std::vector<PackedByte>& values);
  void add_floats(const char* name, const std::vector<float>& values);
  // Adds 32-bit numbers as two halves, the lower one first.
  void add_words(const char* name, const std::vector<std::uint32_t>& values);
  void add_triangles(const std::vector<std::uint32_t>& corners, std::size_t vertices);

  // Returns the whole file; without vertices, an empty scene. `extras` belongs to the scene; may be null.
  std::vector<std::byte> finish(const Json& extras) const;

 private:
  template <class T>
  void add_vertices(const char* name, const std::vector<T>& values, Json accessor);
  void add(const std::vector<unsigned char>& packed, std::size_t count, std::size_t stride, const char* mode,
           int target, bool has_stride, Json accessor);

  Json attributes_ = Json::object(), accessors_ = Json::array(), views_ = Json::array(), node_;
  std::vector<std::byte> bytes_;
  std::size_t unpacked_ = 0;
};

}  // namespace tessera::tileset
