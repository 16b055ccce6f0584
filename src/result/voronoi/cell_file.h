// Files of cells: GeoPackage, FlatGeobuf, GeoJSON, CSV.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "src/base/attribute.h"
#include "src/base/result.h"
#include "src/result/store/stamp.h"
#include "src/result/voronoi/cell_records.h"

namespace tessera::voronoi {

struct CellFileOptions {
  std::string crs;    // as a manifest has it
  ResultStamp stamp;  // of the result
  bool multi = false;
  std::vector<Attribute> schema;  // of the points
};

// A file of polygons. It appears only when it is complete, after finish().
class CellFile {
 public:
  // Error usage when no file has this ending.
  static Status check_ending(const std::filesystem::path& target);
  // Errors, here and below: io; bad_input when GDAL does not know the coordinate system.
  static Result<std::unique_ptr<CellFile>> create(const std::filesystem::path& target, const CellFileOptions& options);
  virtual ~CellFile() = default;
  virtual Status add(const CellRecord& record) = 0;
  virtual Result<std::uint64_t> finish() = 0;  // the size in bytes
};

}  // namespace tessera::voronoi
