// Writes lines to a map file.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>

#include "src/base/point.h"
#include "src/base/result.h"
#include "src/result/store/stamp.h"

namespace tessera::terrain {

struct LineFileOptions {
  std::string crs;         // as a manifest has it
  std::string layer;       // its name
  std::string value;       // the name of the lines' attribute beside `index`
  ResultStamp stamp;       // of the result
  bool heights = true;     // whether that attribute is the lines' height
  bool overwrite = false;  // replace an existing file
};

// A file of lines. It appears only when it is complete, after finish().
class LineFile {
 public:
  // Checks the target's ending: .gpkg, .geojson or .json. Error usage for another ending, a folder, or an existing
  // file.
  static Status check_target(const std::filesystem::path& target, bool overwrite);
  // Errors, here and below: io; bad_input when GDAL does not know the coordinate system.
  static Result<std::unique_ptr<LineFile>> create(const std::filesystem::path& target, const LineFileOptions& options);
  virtual ~LineFile() = default;
  virtual Status add(double value, bool index, std::span<const Point> points) = 0;
  virtual Result<std::uint64_t> finish() = 0;  // the size in bytes
};

}  // namespace tessera::terrain
