// A binary glTF 2.0 file as it grows: one mesh of triangles, compressed (EXT_meshopt_compression).
#pragma once

#include <cstddef>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <span>
#include <vector>

#include "src/base/point.h"

namespace tessera::tileset {

// Strides of vertices are multiples of 4 in glTF, and in what is compressed.
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

  // 65,535 steps over their extent on each axis, in glTF's axes: x, z, -y. REQUIRES: there are some.
  void add_positions(std::span<const Point> positions, const Point& origin);
  // Attributes of the vertices.
  void add_shorts(const char* name, const std::vector<PackedShort>& values);
  void add_bytes(const char* name, const std::vector<PackedByte>& values);
  void add_floats(const char* name, const std::vector<float>& values);
  // A whole number of 32 bits: its lower half and its upper.
  void add_words(const char* name, const std::vector<std::uint32_t>& values);
  void add_triangles(const std::vector<std::uint32_t>& corners, std::size_t vertices);

  // All of it; without vertices a scene with nothing in it. `extras`: of the scene, or null.
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
