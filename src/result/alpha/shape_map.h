// Writes a 2D alpha shape to a map file.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>

#include "src/base/result.h"
#include "src/result/alpha/outlines.h"
#include "src/result/alpha/shape_simplex.h"
#include "src/result/store/stamp.h"

namespace tessera::alpha {

// A file of polygons, and of singular edges and vertices. It appears only when it is complete, after finish().
class ShapeMap {
 public:
  // Whether the ending of the target is one of a map file.
  static bool is_map(const std::filesystem::path& target);
  // `stamp`: of the result. `general`: whether singular simplices will come. Errors, here and below: io; bad_input when
  // GDAL does not know the coordinate system.
  static Result<std::unique_ptr<ShapeMap>> create(const std::filesystem::path& target, const std::string& crs,
                                                  const ResultStamp& stamp, bool general);
  virtual ~ShapeMap() = default;
  virtual Status polygon(const OutlineRings& rings) = 0;
  // A singular edge or vertex.
  virtual Status singular(const ShapeSimplex& simplex) = 0;
  virtual Result<std::uint64_t> finish() = 0;  // the size in bytes
};

}  // namespace tessera::alpha
