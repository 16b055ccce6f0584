// Writes an alpha shape as PLY, binary little endian.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>

#include "src/base/result.h"
#include "src/result/alpha/numbered_shape.h"
#include "src/result/store/stamp.h"

namespace tessera::alpha {

struct ShapePlyHead {
  int dimension = 3;
  bool general = false;
  std::uint64_t ids = 0;  // every id is less than this
  bool periodic = false;  // vertices are images
  std::string comment;    // of one line
  ResultStamp stamp;
};

// Vertices are the element "vertex" with their ids; images have the properties "offset_x", "offset_y" and "offset_z",
// how many periods they lie away from their points. Facets are the element "face" in 3D, and "edge" in 2D. In a general
// shape each has a property "singular", 0 or 1; in 3D singular edges follow as the element "edge". Singular vertices
// are vertices without a face and edge.
class ShapePly : public ShapeTaker {
 public:
  // Error io.
  static Result<std::unique_ptr<ShapePly>> create(const std::filesystem::path& target, const ShapePlyHead& head);
  // Gives the file its name, and returns its size in bytes.
  virtual Result<std::uint64_t> finish() = 0;
};

}  // namespace tessera::alpha
